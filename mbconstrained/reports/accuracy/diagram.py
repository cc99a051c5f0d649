"""How a work-precision diagram is drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...page.figure import PALETTE
from ...page.look import INK, MUTED
from ...tolerances import EPS
from ..figures import WIDTH, power_of_ten, powers, shown, width_of
from ..labels import Label, place_labels
from ..timing import duration
from .series import MeasuredPoint, Series

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Stars in these colours for our own methods.
OURS = (INK, "#0b5cad", "#7a3b8f")

#: One marker for each of the first 14 other methods; colours repeat after six of them, then with other dashes.
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "p", "h", "d", "8", "H")
DASHES = ("-", (0, (6, 2)), (0, (2, 1.5)), (0, (6, 1.5, 1.5, 1.5)), (0, (1, 1)))

#: Where the axis of times has fewer decades than this, it has ticks between the powers of ten too.
FEW_DECADES = 2.0

#: The axis of times spans at least this factor, and leaves this one free at its ends.
LEAST_SPAN, ROOM = 20.0, 1.7

#: The axis of errors reaches so many times below the smallest and above the largest error, where texts have room, and at
#: least so many roundings of a double up.
BELOW, ABOVE, LEAST_ERRORS = 5.0, 12.0, 1e4

#: Part of the text's colour beside a point that is ink, so that light colours can be read.
DARKER = 0.35

#: Width of the bars that show the spread of the times, in points.
BAR = 2.4

#: Longest name in the legend and longest setting beside a point, in letters.
NAME, SETTING = 34, 16

#: The legend: most names side by side, and the width of what stands before a name and behind it, in inches.
MOST_COLUMNS, HANDLE = 5, 0.75

PANELS = (("one run, set-up and evaluation", False), ("each further evaluation", True))


@dataclass(frozen=True)
class Look:
    """How one method is drawn."""

    color: str
    marker: str
    dashes: str | tuple
    size: float
    width: float
    order: float


def draw_diagram(figure: Figure, series: tuple[Series, ...], floor: float) -> None:
    """Two panels with the same errors, and one legend below them."""
    looks = looks_of(series)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, (text, further) in zip(panels, PANELS):
        _axis_of_times(axes, series, further)
        axes.set_title(text)
        for one, look in zip(series, looks):
            _curve(axes, one, look, further)
    _axis_of_errors(panels[0], series, floor)
    for axes in panels:
        _floors(axes, floor)
    handles = [_handle(one, look) for one, look in zip(series, looks)]
    figure.legend(handles=handles, loc="outside lower center", ncols=columns(series), columnspacing=1.6)
    place_labels(figure, [(axes, _labels(series, looks, further)) for axes, (_, further) in zip(panels, PANELS)])


def columns(series: tuple[Series, ...]) -> int:
    """How many names of the legend stand side by side: as many as there is room for."""
    widths = [HANDLE + width_of(shown(one.name, NAME)) for one in series]
    return next((count for count in range(min(len(series), MOST_COLUMNS), 1, -1) if _width(widths, count) < WIDTH), 1)


def _width(widths: list[float], count: int) -> float:
    """Of a legend that is filled column by column."""
    rows = math.ceil(len(widths) / count)
    return sum(max(widths[start : start + rows]) for start in range(0, len(widths), rows))


def looks_of(series: tuple[Series, ...]) -> list[Look]:
    """Stars for our own methods; another marker and colour for each of the others."""
    ours = (Look(color, "*", dashes, 13.0, 2.0, 5.0) for dashes in DASHES for color in OURS)
    others = (
        Look(color, MARKERS[(turn * len(PALETTE) + place) % len(MARKERS)], DASHES[turn % len(DASHES)], 6.0, 1.3, 3.0)
        for turn in range(len(series))
        for place, color in enumerate(PALETTE)
    )
    return [next(ours) if one.is_ours else next(others) for one in series]


def _curve(axes: Axes, one: Series, look: Look, further: bool) -> None:
    """A line through the markers; thin bars for the spread of the times."""
    line = {"color": look.color, "zorder": look.order}
    x, y = zip(*((point.time(further), point.height) for point in one.points))
    axes.plot(x, y, linewidth=look.width, linestyle=look.dashes, **line)
    for point in one.points:
        if not further:
            axes.plot(point.quartiles, (point.height,) * 2, linewidth=BAR, alpha=0.4, solid_capstyle="butt", **line)
        axes.plot([point.time(further)], [point.height], clip_on=False, linestyle="none", **_marker(look, point))


def _marker(look: Look, point: MeasuredPoint | None = None) -> dict:
    """Filled; open where the error is too small to be drawn, an arrow upwards where it is too large."""
    is_open = point is not None and (point.is_beyond or point.is_below)
    return {
        "marker": "^" if point is not None and point.is_beyond else look.marker,
        "markersize": look.size,
        "color": look.color,
        "markerfacecolor": "white" if is_open else look.color,
        "markeredgecolor": look.color if is_open else "white",
        "markeredgewidth": 1.3 if is_open else 0.6,
        "zorder": look.order + 0.5,
    }


def _handle(one: Series, look: Look):
    from matplotlib.lines import Line2D

    return Line2D([], [], label=shown(one.name, NAME), linewidth=look.width, linestyle=look.dashes, **_marker(look))


def _axis_of_times(axes: Axes, series: tuple[Series, ...], further: bool) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    points = [point for one in series for point in one.points]
    times = [point.time(further) for point in points] + [time for point in points for time in point.quartiles if not further]
    room = max(ROOM, (max(times) / min(times)) ** 0.07)
    low, high = min(times) / room, max(times) * room
    spare = max(1.0, math.sqrt(LEAST_SPAN / (high / low)))
    low, high = low / spare, high * spare
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    axes.set_xlabel("run time")
    between = (1, 2, 5) if math.log10(high / low) < FEW_DECADES else (1,)
    axes.xaxis.set_major_locator(LogLocator(subs=between, numticks=8))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda seconds, _: duration(seconds)))
    axes.xaxis.set_minor_locator(NullLocator())


def _axis_of_errors(axes: Axes, series: tuple[Series, ...], floor: float) -> None:
    """For both panels, which share it."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    heights = [point.height for one in series for point in one.points]
    axes.set_yscale("log")
    axes.set_ylim(min(*heights, EPS) / BELOW, max(*heights, floor, LEAST_ERRORS * EPS) * ABOVE)
    axes.set_ylabel("relative error (further down is better)")
    axes.yaxis.set_major_locator(LogLocator(numticks=10))
    axes.yaxis.set_major_formatter(FuncFormatter(power_of_ten))
    axes.yaxis.set_minor_locator(NullLocator())


def _floors(axes: Axes, floor: float) -> None:
    """Grey lines at what a double can hold and at what the truth is good for."""
    for value, text in ((EPS, "rounding of a double"), (floor, "the truth is not known better")):
        if value > 0:
            axes.axhline(value, color="#8795a1", linewidth=1.0, zorder=1.5)
            place = {"xy": (1, value), "xycoords": ("axes fraction", "data"), "xytext": (-2, 2), "textcoords": "offset points"}
            axes.annotate(text, **place, ha="right", va="bottom", color=MUTED, fontsize=7.5, zorder=1.6)


def _labels(series: tuple[Series, ...], looks: list[Look], further: bool) -> list[Label]:
    """The coarsest and the finest setting of each method, and our names, which come first. All points keep their places free."""
    labels = []
    for one, look in sorted(zip(series, looks), key=lambda pair: not pair[0].is_ours):
        texts = [""] * len(one.points)
        texts[0], texts[-1] = _setting(one.points[0]), shown(one.name, NAME) if one.is_ours else _setting(one.points[-1])
        color = _darker(look.color)
        labels += [Label(p.time(further), p.height, text, color, one.is_ours) for p, text in zip(one.points, texts)]
    return labels


def _setting(point: MeasuredPoint) -> str:
    return powers(shown(point.label, SETTING))


def _darker(color: str) -> str:
    from matplotlib.colors import to_hex, to_rgb

    return to_hex([(1 - DARKER) * part + DARKER * ink for part, ink in zip(to_rgb(color), to_rgb(INK))])
