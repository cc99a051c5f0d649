"""Digits over what is turned: how many are right, how many were claimed, how many one may expect."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ...checks import counted
from ...page.figure import PALETTE
from ...page.look import GREY, INK, MUTED, RED, WARN
from ..figures import Picture, nothing_to_show, power_of_ten, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .point import Point
    from .sweeps import Sweep

#: Parameters that span so much stand by their decades.
DECADES = 100.0

#: A double holds no more digits.
MOST = 16.0

RIGHT, CLAIMED, EXPECTED = PALETTE[0], PALETTE[4], "#8795a1"

#: Where more was claimed than is right, and where there is that much in reserve.
OVER, RESERVE = "#f6c77d", "#dbe9f4"

#: Curves that differ by less, in digits, touch.
TOUCH = 1e-6

#: Columns of the small pictures, and heights in inches: of one picture alone, of a row of small ones, and of the legend.
COLUMNS, ALONE_HIGH, ROW_HIGH, LEGEND_HIGH = 5, 3.3, 1.62, 0.55

#: Letters in a line of a small title, and lines.
TITLE_WIDTH, TITLE_LINES = 27, 2


def digit_curves(sweep: Sweep) -> Picture:
    """One sweep: digits that are right, claimed and expected over what is turned."""
    if not sweep.points:
        return nothing_to_show(sweep.title, "Digits right")

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        _panel(axes, sweep.points, size=5.5)
        _ticks(axes, sweep.points, most=9)
        axes.set_xlabel(shown(sweep.parameter, 80))
        axes.set_ylabel("digits")
        _legend(figure, [sweep])

    return Picture(sweep.title, digits_in_words([sweep]), ALONE_HIGH + LEGEND_HIGH, draw)


def gallery(title: str, sweeps: Sequence[Sweep]) -> Picture:
    """A small picture of each sweep, all with the same axis of digits; red frames where an answer is wrong without a warning."""
    sweeps = [sweep for sweep in sweeps if sweep.points]
    if not sweeps:
        return nothing_to_show(title, "Digits right")
    columns = min(COLUMNS, len(sweeps))
    rows = math.ceil(len(sweeps) / columns)

    def draw(figure: Figure) -> None:
        panels = figure.subplots(rows, columns, sharey=True, squeeze=False)
        for axes, sweep in zip(panels.flat, sweeps):
            _small(axes, sweep)
        for axes in panels.flat[len(sweeps) :]:
            axes.set_axis_off()
        for axes in panels[:, 0]:
            axes.set_ylabel("digits")
        _legend(figure, sweeps)

    return Picture(title, digits_in_words(sweeps), max(ROW_HIGH * rows, 2.2) + LEGEND_HIGH, draw)


def _small(axes: Axes, sweep: Sweep) -> None:
    _panel(axes, sweep.points, size=3.8)
    _ticks(axes, sweep.points, most=3)
    lines = textwrap.wrap(shown(sweep.title, 200), TITLE_WIDTH, max_lines=TITLE_LINES, placeholder="…")
    axes.set_title("\n".join(lines), fontsize=7.8)
    axes.set_xlabel(shown(sweep.parameter, TITLE_WIDTH + 3), fontsize=7.2, labelpad=1)
    axes.tick_params(labelsize=7)
    if any(point.verdict == "wrong" for point in sweep.points):
        for spine in axes.spines.values():
            spine.set(visible=True, color=RED, linewidth=1.6)


def _panel(axes: Axes, points: Sequence[Point], size: float) -> None:
    """Shaded between right and claimed, curves on it, and a mark at each point."""
    points = sorted(points, key=lambda point: point.parameter)
    x = places_of([point.parameter for point in points])
    right, claimed, expected = (
        np.array([digits_of(getattr(point, key)) for point in points]) for key in ("right", "claimed", "expected")
    )
    axes.set_ylim(-0.8, MOST + 0.6)
    axes.set_yticks(range(0, int(MOST) + 1, 4))
    at, more, less = _with_crossings(x, right, claimed)
    axes.fill_between(at, less, more, where=more >= less - TOUCH, color=RESERVE, linewidth=0)
    axes.fill_between(at, more, less, where=less >= more - TOUCH, color=OVER, linewidth=0)
    axes.plot(x, expected, color=EXPECTED, linewidth=1.0, zorder=2)
    axes.plot(x, claimed, color=CLAIMED, linewidth=1.4, linestyle=(0, (4, 2)), zorder=3)
    axes.plot(x, right, color=RIGHT, linewidth=1.7, zorder=4)
    for verdict in dict.fromkeys(point.verdict for point in points):
        marked = [(place, digits_of(point.right, 0.0)) for place, point in zip(x, points) if point.verdict == verdict]
        axes.plot(*zip(*marked), clip_on=False, linestyle="none", **_mark(verdict, size))


def _with_crossings(x: np.ndarray, right: np.ndarray, claimed: np.ndarray) -> tuple[np.ndarray, ...]:
    """Both curves with the points between in which they cross, so that the shades end there."""
    gap = right - claimed
    share = [a / (a - b) if a * b < 0 else 0.0 for a, b in pairwise(gap)]
    at = np.unique(np.concatenate([x, x[:-1] + np.array(share) * np.diff(x)]))
    return at, np.interp(at, x, right), np.interp(at, x, claimed)


def _mark(verdict: str, size: float) -> dict:
    """A shape of its own for each verdict, so that colours are not needed to tell them apart."""
    wrong = {"marker": "X", "markersize": 1.9 * size, "color": RED, "markeredgecolor": "white", "markeredgewidth": 0.8, "zorder": 7}
    told = {"marker": "^", "markersize": 1.45 * size, "color": WARN, "markeredgecolor": INK, "markeredgewidth": 0.8, "zorder": 6}
    refused = {
        "marker": "s",
        "markersize": 1.15 * size,
        "color": GREY,
        "markeredgecolor": MUTED,
        "markeredgewidth": 0.8,
        "zorder": 5,
    }
    unjudged = {**refused, "marker": "D", "color": "white"}
    fine = {"marker": "o", "markersize": 0.85 * size, "color": RIGHT, "markeredgewidth": 0, "zorder": 5}
    return {"wrong": wrong, "told": told, "refused": refused, "not judged": unjudged}.get(verdict, fine)


def _is_over(point: Point) -> bool:
    """Whether more was claimed than is right."""
    return digits_of(point.claimed) > digits_of(point.right)


def has_digits(point: Point) -> bool:
    """Whether there is an answer that could be judged."""
    return point.right is not None and not math.isnan(point.right)


def digits_of(value: float | None, otherwise: float = math.nan) -> float:
    """Digits kept between 0 and 16; something else where there are none."""
    return otherwise if value is None or math.isnan(value) else min(max(value, 0.0), MOST)


def places_of(parameters: Sequence[float]) -> np.ndarray:
    """Where parameters stand: by their decades where they span two or more, and 0, the limit of such, a step below the least.

    >>> places_of([0.0, 1e-4, 1e-2, 1.0]), places_of([1, 2, 40])
    (array([-6., -4., -2.,  0.]), array([ 1.,  2., 40.]))
    """
    x = np.array(parameters, dtype=float)
    if not is_logarithmic(x):
        return x
    powers_found = np.log10(x[x > 0])
    step = np.diff(np.unique(powers_found)).max(initial=0.0) or 1.0
    return np.where(x > 0, np.log10(np.where(x > 0, x, 1.0)), powers_found.min() - step)


def is_logarithmic(x: np.ndarray) -> bool:
    """Whether they span two decades or more, 0 aside, and none is negative."""
    positive = x[x > 0]
    return bool((x >= 0).all() and len(positive) and positive.max() >= DECADES * positive.min())


def _ticks(axes: Axes, points: Sequence[Point], most: int) -> None:
    """So many at most: whole powers of ten, and 0 where it occurs."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator

    x = np.unique([point.parameter for point in points])
    if not is_logarithmic(x):
        axes.xaxis.set_major_locator(MaxNLocator(most, integer=bool((x == np.round(x)).all())))
        return
    places = places_of(x)
    low, high = math.floor(places[x > 0].min() + 1e-9), math.ceil(places.max() - 1e-9)
    step = max(1, math.ceil((high - low) / (most - 1)))
    ticks = [float(power) for power in range(low, high + 1, step)]
    zero = [float(places[0])] if x[0] == 0 else []
    margin = 0.03 * (high - min([low, *zero]))
    axes.set_xlim(min([low, *zero]) - margin, high + margin)
    axes.xaxis.set_major_locator(FixedLocator(zero + [tick for tick in ticks if not zero or tick - zero[0] >= 0.6 * step]))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda place, _: "0" if zero and place == zero[0] else power_of_ten(10.0**place)))


def _legend(figure: Figure, sweeps: Sequence[Sweep]) -> None:
    """The curves, the shades, and those marks that occur."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    found = {point.verdict for sweep in sweeps for point in sweep.points}
    marks = {"told": "with a warning", "refused": "refused", "not judged": "not judged", "wrong": "wrong without a warning"}
    handles = [
        Line2D([], [], linewidth=1.7, label="digits right", **_mark("right", 5.0)),
        Line2D([], [], color=CLAIMED, linestyle=(0, (4, 2)), label="claimed by the estimate"),
        Line2D([], [], color=EXPECTED, linewidth=1.0, label="expected from the data's condition"),
        Patch(color=RESERVE, label="more right than claimed"),
    ]
    handles += [Patch(color=OVER, label="fewer right than claimed")] * any(
        _is_over(point) for sweep in sweeps for point in sweep.points
    )
    handles += [Line2D([], [], linestyle="none", label=text, **_mark(key, 5.0)) for key, text in marks.items() if key in found]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, columnspacing=1.4, handlelength=2.2, fontsize=8)


def digits_in_words(sweeps: Sequence[Sweep]) -> str:
    """In words, for those who cannot see it."""
    return " ".join(["Digits right, claimed and expected over what is turned.", *map(_sentence, sweeps)])


def _sentence(sweep: Sweep) -> str:
    answers = [digits_of(point.right) for point in sweep.points if has_digits(point)]
    kinds = {"told": "with a warning", "refused": "refused", "wrong": "wrong without a warning"}
    counts = {text: sum(point.verdict == key for point in sweep.points) for key, text in kinds.items()}
    least = [f"at least {min(answers):.1f} digits right"] if answers else []
    parts = [counted(len(sweep.points), "point"), *least, *(f"{count} {text}" for text, count in counts.items() if count)]
    return f"{shown(sweep.title, 60)}: {', '.join(parts)}."
