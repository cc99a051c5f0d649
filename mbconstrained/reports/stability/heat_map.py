"""Digits right as a map: what is turned from top to bottom, how far it is turned from left to right."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...page.look import INK, MUTED, RED
from ..figures import WIDTH, Picture, nothing_to_show, power_of_ten, powers, shown, width_of
from .pictures import MOST, digits_in_words, digits_of, has_digits

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .point import Point
    from .sweeps import Sweep

#: Even steps of brightness from dark to light, told apart by colour-blind eyes too; no grey in it, which means refused.
COLORS = "viridis"

#: Where there is no answer: refused, and not judged.
REFUSED, UNJUDGED = "#d5dbe0", "#ffffff"

#: Height of a row and of all that is not rows, and width of what is not columns beside the names, in inches.
ROW_HIGH, AROUND_HIGH, BAR_WIDE = 0.3, 1.15, 1.0

#: Letters of the longest name.
NAME = 34

#: Narrower cells have no numbers, in inches; wider rows of cells leave the rest of the picture empty.
ROOM_FOR_NUMBER = 0.2

#: Colours darker than this, of 1, have white numbers on them.
DARK = 0.45


def heat_map(title: str, sweeps: Sequence[Sweep]) -> Picture:
    """A row for each sweep, a column for each value of what is turned; every cell has its whole digits right as its colour.

    Cells with a warning are framed, what was refused is grey, and what is wrong without a warning has a red cross.
    """
    sweeps = [sweep for sweep in sweeps if sweep.points]
    if not sweeps:
        return nothing_to_show(title, "Digits right")
    values = sorted({point.parameter for sweep in sweeps for point in sweep.points})

    def draw(figure: Figure) -> None:
        axes, bar = figure.subplots(1, 2, width_ratios=(60, 1))
        for row, sweep in enumerate(sweeps):
            for point in sweep.points:
                _cell(axes, values.index(point.parameter), row, point, _has_room(sweeps, values))
        _axes(axes, sweeps, values)
        _bar(bar)
        _legend(figure, sweeps)

    return Picture(title, digits_in_words(sweeps), AROUND_HIGH + ROW_HIGH * max(len(sweeps), 3), draw)


def _cell(axes: Axes, column: int, row: int, point: Point, has_room: bool) -> None:
    from matplotlib.patches import Rectangle

    color = _color(point)
    text_color = "white" if _brightness(color) < DARK else INK
    axes.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, facecolor=color, edgecolor="white", linewidth=1.0))
    if point.verdict == "told":
        axes.add_patch(Rectangle((column - 0.41, row - 0.36), 0.82, 0.72, fill=False, edgecolor=text_color, linewidth=1.3))
    if point.verdict == "wrong":
        axes.plot([column], [row], **_cross())
    elif has_room:
        axes.text(column, row, _number(point), ha="center", va="center_baseline", color=text_color, fontsize=7.5)


def _number(point: Point) -> str:
    """Whole digits: those that are right."""
    if not has_digits(point):
        return "–" if point.verdict == "refused" else "?"
    return str(math.floor(digits_of(point.right)))


def _color(point: Point) -> str:
    if not has_digits(point):
        return REFUSED if point.verdict == "refused" else UNJUDGED
    return _palette()[math.floor(digits_of(point.right))]


def _palette() -> list[str]:
    """One colour for each number of digits."""
    import matplotlib
    from matplotlib.colors import to_hex

    return [to_hex(color) for color in matplotlib.colormaps[COLORS].resampled(int(MOST) + 1)(range(int(MOST) + 1))]


def _brightness(color: str) -> float:
    """Relative luminance to the power of 1/2.2, about as bright as it looks."""
    from matplotlib.colors import to_rgb

    red, green, blue = (part**2.2 for part in to_rgb(color))
    return (0.2126 * red + 0.7152 * green + 0.0722 * blue) ** (1 / 2.2)


def _cross() -> dict:
    edge = {"markeredgecolor": "white", "markeredgewidth": 1.2}
    return {"marker": "X", "markersize": 10.5, "color": RED, "linestyle": "none", **edge}


def _has_room(sweeps: Sequence[Sweep], values: Sequence[float]) -> bool:
    names = max(width_of(shown(sweep.title, NAME)) for sweep in sweeps)
    return (WIDTH - BAR_WIDE - names) / len(values) >= ROOM_FOR_NUMBER


def _axes(axes: Axes, sweeps: Sequence[Sweep], values: Sequence[float]) -> None:
    """Names beside the rows, factors below the columns."""
    axes.set_xlim(-0.5, len(values) - 0.5)
    axes.set_ylim(len(sweeps) - 0.5, -0.5)
    step = math.ceil(len(values) / 20)
    axes.set_xticks(range(0, len(values), step), [_value(value) for value in values[::step]])
    axes.set_yticks(range(len(sweeps)), [shown(sweep.title, NAME) for sweep in sweeps], color=INK)
    axes.set_xlabel(_across(sweeps))
    axes.grid(False)
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _across(sweeps: Sequence[Sweep]) -> str:
    """What all sweeps turn, or that it is a factor on each."""
    parameters = {sweep.parameter for sweep in sweeps}
    return shown(parameters.pop(), 80) if len(parameters) == 1 else "times what it is"


def _value(value: float) -> str:
    return power_of_ten(value) if f"{value:.2e}".startswith("1.00e") else powers(f"{value:.3g}")


def _bar(axes: Axes) -> None:
    """The colours of 0 to 16 digits, as shapes: a page shows no images."""
    from matplotlib.patches import Rectangle

    for digits, color in enumerate(_palette()):
        axes.add_patch(Rectangle((0, digits - 0.5), 1, 1, facecolor=color, edgecolor=color, linewidth=0.3))
    axes.set(xlim=(0, 1), ylim=(-0.5, MOST + 0.5), xticks=(), yticks=range(0, int(MOST) + 1, 4), ylabel="digits right")
    axes.yaxis.set_label_position("right")
    axes.yaxis.tick_right()
    axes.grid(False)
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _legend(figure: Figure, sweeps: Sequence[Sweep]) -> None:
    """What cells other than plain ones mean, of those that occur."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    found = {point.verdict for sweep in sweeps for point in sweep.points}
    handles = {
        "told": Patch(facecolor="white", edgecolor=INK, linewidth=1.3, label="with a warning"),
        "refused": Patch(facecolor=REFUSED, edgecolor=REFUSED, label="refused"),
        "not judged": Patch(facecolor=UNJUDGED, edgecolor=MUTED, linewidth=0.6, linestyle=":", label="? not judged"),
        "wrong": Line2D([], [], label="wrong without a warning", **_cross()),
    }
    shown_handles = [handle for verdict, handle in handles.items() if verdict in found]
    if shown_handles:
        figure.legend(handles=shown_handles, loc="outside lower center", ncols=4, handlelength=1.6, fontsize=8)
