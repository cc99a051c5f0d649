"""The figures of the stability study: digits right, claimed and expected over a parameter, as curves and as a heat map."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import counted
from ...page.animation.figure import PALETTE
from ...page.plots.images import GREY, INK, MUTED, RED, WARN
from ...page.typeset import shortened
from ..figures import Picture, nothing_to_show, power_of_ten, powers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .point import Point
    from .scaling_factors import ScalingSweep

#: Least ratio of parameters on a logarithmic axis.
DECADES = 100.0

#: Digits of a double.
MOST = 16

RIGHT, CLAIMED, EXPECTED = PALETTE[0], PALETTE[4], "#8795a1"

#: Shades where more digits are claimed than right, and where more are right than claimed.
OVER, RESERVE = "#f6c77d", "#dbe9f4"

#: Columns of the small pictures, and heights of a row of them and of the legend, inches.
COLUMNS, ROW_HIGH, LEGEND_HIGH = 5, 1.62, 0.55

#: Letters in a line of a small title, and lines; ticks below it.
TITLE_WIDTH, TITLE_LINES, TICKS = 27, 2, 3

#: A colour map with even steps of brightness, suitable for colour-blind readers, and without grey, which means refused.
COLORS, REFUSED = "viridis", "#d5dbe0"

#: Height of a row of the map and of all else, inches; letters of the longest name; most columns of cells with numbers in them.
MAP_ROW_HIGH, AROUND_HIGH, NAME, MOST_NUMBERED = 0.3, 1.15, 34, 30

#: Number of digits from which the colours of the map are bright, with dark numbers on them.
BRIGHT = 8

#: Verdicts other than "right" in legends, each with a marker of its own, so that they are distinct without colours.
VERDICTS = {
    "warned": ("with a warning", {"marker": "^", "color": WARN, "markeredgecolor": INK, "zorder": 6}),
    "refused": ("refused", {"marker": "s", "color": GREY, "markeredgecolor": MUTED, "zorder": 5}),
    "not judged": ("not judged", {"marker": "D", "color": "white", "markeredgecolor": MUTED, "zorder": 5}),
    "wrong": ("wrong without a warning", {"marker": "X", "color": RED, "markeredgecolor": "white", "markersize": 8, "zorder": 7}),
}


def digit_curves(title: str, sweeps: Sequence[ScalingSweep]) -> Picture:
    """A small figure of each sweep, with a common axis of digits; red frames where an answer is wrong without a warning."""
    sweeps = [sweep for sweep in sweeps if sweep.points]
    if not sweeps:
        return nothing_to_show(title, "Digits right")
    columns = min(COLUMNS, len(sweeps))
    rows = math.ceil(len(sweeps) / columns)

    def draw(figure: Figure) -> None:
        panels = figure.subplots(rows, columns, sharey=True, squeeze=False)
        for axes, sweep in zip(panels.flat, sweeps):
            _panel(axes, sweep)
        for axes in panels.flat[len(sweeps) :]:
            axes.set_axis_off()
        for axes in panels[:, 0]:
            axes.set_ylabel("digits")
        _legend(figure, sweeps)

    return Picture(title, _in_words(sweeps), max(ROW_HIGH * rows, 2.2) + LEGEND_HIGH, draw)


def _panel(axes: Axes, sweep: ScalingSweep) -> None:
    """Shades between correct and claimed digits, curves, and a mark at each point."""
    points = sorted(sweep.points, key=lambda point: point.parameter)
    right, claimed, expected = (
        np.array([math.nan if digits is None else digits for digits in (getattr(point, key) for point in points)])
        for key in ("right", "claimed", "expected")
    )
    x = _axis_of_parameters(axes, np.array([point.parameter for point in points]))
    axes.set_ylim(-0.8, MOST + 0.6)
    axes.set_yticks(range(0, MOST + 1, 4))
    for color, below, above in ((RESERVE, claimed, right), (OVER, right, claimed)):
        axes.fill_between(x, below, above, where=above > below, interpolate=True, color=color, linewidth=0)
    axes.plot(x, expected, color=EXPECTED, linewidth=1.0, zorder=2)
    axes.plot(x, claimed, color=CLAIMED, linewidth=1.4, linestyle=(0, (4, 2)), zorder=3)
    axes.plot(x, right, color=RIGHT, linewidth=1.7, zorder=4)
    for place, point in zip(x, points):
        axes.plot(place, point.right or 0.0, clip_on=False, linestyle="none", **_mark(point.verdict))
    lines = textwrap.wrap(shortened(sweep.title, 200), TITLE_WIDTH, max_lines=TITLE_LINES, placeholder="…")
    axes.set_title("\n".join(lines), fontsize=7.8)
    axes.set_xlabel(shortened(sweep.parameter, TITLE_WIDTH + 3), fontsize=7.2, labelpad=1)
    axes.tick_params(labelsize=7)
    if sweep.count("wrong"):
        for spine in axes.spines.values():
            spine.set(visible=True, color=RED, linewidth=1.6)


def _axis_of_parameters(axes: Axes, x: np.ndarray) -> np.ndarray:
    """Ticks, and the places of the parameters: their logarithms where they span two decades or more, with 0 a step below."""
    from matplotlib.ticker import MaxNLocator

    positive = x[x > 0]
    if (x < 0).any() or not len(positive) or positive.max() < DECADES * positive.min():
        axes.xaxis.set_major_locator(MaxNLocator(TICKS, integer=bool((x == np.round(x)).all())))
        return x
    low, high = math.floor(math.log10(positive.min())), math.ceil(math.log10(positive.max()))
    step = max(1, math.ceil((high - low) / (TICKS - 1)))
    ticks = {low - step: "0"} if (x == 0).any() else {}
    ticks |= {power: power_of_ten(10.0**power) for power in range(low, high + 1, step)}
    axes.set_xticks(list(ticks), list(ticks.values()))
    return np.where(x > 0, np.log10(np.where(x > 0, x, 1.0)), low - step)


def _mark(verdict: str) -> dict:
    right = {"marker": "o", "color": RIGHT, "markeredgewidth": 0, "markersize": 3.2, "zorder": 5}
    return {"markersize": 5.5, "markeredgewidth": 0.8, **VERDICTS[verdict][1]} if verdict in VERDICTS else right


def _legend(figure: Figure, sweeps: Sequence[ScalingSweep]) -> None:
    """The curves, the shades, and the marks that occur."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    points = [point for sweep in sweeps for point in sweep.points]
    handles = [
        Line2D([], [], linewidth=1.7, label="digits right", **_mark("right")),
        Line2D([], [], color=CLAIMED, linestyle=(0, (4, 2)), label="claimed by the estimate"),
        Line2D([], [], color=EXPECTED, linewidth=1.0, label="expected from the condition of the data"),
        Patch(color=RESERVE, label="more right than claimed"),
    ]
    if any(point.right is not None and point.claimed > point.right for point in points):
        handles.append(Patch(color=OVER, label="fewer right than claimed"))
    verdicts = {point.verdict for point in points}
    handles += [Line2D([], [], linestyle="none", label=VERDICTS[key][0], **_mark(key)) for key in VERDICTS if key in verdicts]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, columnspacing=1.4, handlelength=2.2, fontsize=8)


def _in_words(sweeps: Sequence[ScalingSweep]) -> str:
    """A text alternative."""
    return " ".join(["Digits right, claimed and expected over the parameter.", *map(_sentence, sweeps)])


def _sentence(sweep: ScalingSweep) -> str:
    least = [f"at least {min(point.right for point in sweep.answers):.1f} digits right"] if sweep.answers else []
    counts = [(sweep.count(key), VERDICTS[key][0]) for key in ("warned", "refused", "wrong")]
    parts = [counted(len(sweep.points), "point"), *least, *(f"{count} {text}" for count, text in counts if count)]
    return f"{shortened(sweep.title, 60)}: {', '.join(parts)}."


def heat_map(title: str, sweeps: Sequence[ScalingSweep]) -> Picture:
    """A row for each sweep, a column for each value of the parameter; the colour of a cell shows its correct digits.

    Cells with a warning are framed, refused ones are grey, and wrong ones without a warning have a red cross.
    """
    sweeps = [sweep for sweep in sweeps if sweep.points]
    if not sweeps:
        return nothing_to_show(title, "Digits right")
    values = sorted({point.parameter for sweep in sweeps for point in sweep.points})

    def draw(figure: Figure) -> None:
        import matplotlib

        axes = figure.subplots()
        digits = np.full((len(sweeps), len(values)), math.nan)
        for row, sweep in enumerate(sweeps):
            for point in sweep.points:
                column = values.index(point.parameter)
                digits[row, column] = math.nan if point.right is None else math.floor(point.right)
                _cell(axes, column, row, point, len(values) <= MOST_NUMBERED)
        colors = matplotlib.colormaps[COLORS].resampled(MOST + 1)
        mesh = axes.pcolormesh(digits, cmap=colors, vmin=-0.5, vmax=MOST + 0.5, edgecolors="white", linewidth=1.0, zorder=1)
        figure.colorbar(mesh, ax=axes, ticks=range(0, MOST + 1, 4), label="digits right", aspect=30, pad=0.01)
        _names(axes, sweeps, values)
        _map_legend(figure, sweeps)

    return Picture(title, _in_words(sweeps), AROUND_HIGH + MAP_ROW_HIGH * max(len(sweeps), 3), draw)


def _cell(axes: Axes, column: int, row: int, point: Point, has_number: bool) -> None:
    """Frame, cross, number, and grey where refused."""
    from matplotlib.patches import Rectangle

    color = "white" if point.right is not None and point.right < BRIGHT else INK
    if point.verdict == "refused":
        axes.add_patch(Rectangle((column, row), 1, 1, facecolor=REFUSED, edgecolor="white", zorder=2))
    if point.verdict == "warned":
        axes.add_patch(Rectangle((column + 0.09, row + 0.14), 0.82, 0.72, fill=False, edgecolor=color, linewidth=1.3, zorder=2))
    if point.verdict == "wrong":
        axes.plot(column + 0.5, row + 0.5, linestyle="none", **_cross())
    elif has_number:
        missing = "–" if point.verdict == "refused" else "?"
        number = missing if point.right is None else str(math.floor(point.right))
        axes.text(column + 0.5, row + 0.5, number, ha="center", va="center_baseline", color=color, fontsize=7.5)


def _cross() -> dict:
    return {**_mark("wrong"), "markersize": 10.5}


def _names(axes: Axes, sweeps: Sequence[ScalingSweep], values: Sequence[float]) -> None:
    """Names of the rows, factors below the columns."""
    axes.invert_yaxis()
    step = math.ceil(len(values) / 20)
    axes.set_xticks(np.arange(0, len(values), step) + 0.5, [_value(value) for value in values[::step]])
    axes.set_yticks(np.arange(len(sweeps)) + 0.5, [shortened(sweep.title, NAME) for sweep in sweeps], color=INK)
    parameters = {sweep.parameter for sweep in sweeps}
    axes.set_xlabel(shortened(parameters.pop(), 80) if len(parameters) == 1 else "scaling factor")
    axes.grid(False)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)


def _value(value: float) -> str:
    return power_of_ten(value) if f"{value:.2e}".startswith("1.00e") else powers(f"{value:.3g}")


def _map_legend(figure: Figure, sweeps: Sequence[ScalingSweep]) -> None:
    """The legend of verdicts other than "right"."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = {
        "warned": Patch(facecolor="white", edgecolor=INK, linewidth=1.3, label="with a warning"),
        "refused": Patch(facecolor=REFUSED, edgecolor=REFUSED, label="refused"),
        "not judged": Patch(facecolor="white", edgecolor=MUTED, linewidth=0.6, linestyle=":", label="? not judged"),
        "wrong": Line2D([], [], linestyle="none", label="wrong without a warning", **_cross()),
    }
    shown = [handle for verdict, handle in handles.items() if any(sweep.count(verdict) for sweep in sweeps)]
    if shown:
        figure.legend(handles=shown, loc="outside lower center", ncols=4, handlelength=1.6, fontsize=8)
