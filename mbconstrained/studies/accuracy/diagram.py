"""The work-precision diagram: error against run time, one curve for each method."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from ...ground.tolerances import EPS
from ...page.animation.figure import PALETTE
from ...page.plots.images import INK, MUTED
from ...page.typeset import shortened
from ..figures import Picture, nothing_to_show, power_of_ten, powers
from ..timing import duration
from .measure import Measurement

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Height of the panels, and of one line of the legend, in inches; names in such a line, and letters of each.
PANELS_HIGH, LINE_HIGH, COLUMNS, NAME = 4.1, 0.2, 3, 40

#: Smaller errors, such as 0, are drawn here with an open marker.
LOWEST = 1e-17

#: Stars in these colours for our own methods.
OURS = (INK, "#0b5cad", "#7a3b8f")

#: One marker for each of the first 14 other methods; colours repeat after some of them, then with other dashes.
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "p", "h", "d", "8", "H")
DASHES = ("-", (0, (6, 2)), (0, (2, 1.5)), (0, (6, 1.5, 1.5, 1.5)), (0, (1, 1)))

#: Number of decades below which the axis of times has ticks between the powers of ten too.
FEW_DECADES = 2.0

#: The axis of times spans at least this factor, and leaves this one free at its ends.
LEAST_SPAN, ROOM = 20.0, 1.7

#: The axis of errors reaches so many times below the smallest and above the largest error, and at least so many rounding
#: errors of a double up.
BELOW, ABOVE, LEAST_ERRORS = 5.0, 12.0, 1e4

#: Width of the bars that show the spread of the times, in points.
BAR = 2.4

PANELS = (("one run, set-up and evaluation", "one_run"), ("each further evaluation", "further"))


def work_precision(title: str, runs: Sequence[Measurement], floor: float = 0.0, failed: Sequence[str] = ()) -> Picture:
    """The diagram of some methods: relative error over run time, both logarithmic.

    The left panel has the time of one run, the right one that of each further evaluation.
    """
    missing = f"Not in the picture: {'; '.join(map(shortened, failed))}." if failed else ""
    if not runs:
        return nothing_to_show(title, "Relative error against run time", missing)
    curves = [tuple(mine) for _, mine in groupby(runs, key=lambda run: run.method)]
    notes = ["Thin bars: the middle half of the repeated runs."]
    if any(run.error < LOWEST for run in runs):
        notes.append(f"Open markers at the bottom: the error is 0 or below {LOWEST:g}.")
    text = " ".join(["Relative error against run time.", *map(_sentence, curves)])
    height = PANELS_HIGH + LINE_HIGH * math.ceil(len(curves) / COLUMNS)
    note = " ".join([*notes, missing]).strip()
    return Picture(title, text, height, lambda figure: _draw(figure, curves, floor), note)


def _sentence(runs: tuple[Measurement, ...]) -> str:
    """Text alternative of a method: its coarsest and its finest setting."""
    ends = dict.fromkeys((runs[0], runs[-1]))
    results = [
        f"{run.error:.1g} in {duration(run.one_run.median)}{f' ({run.setting.label})' * bool(run.setting.label)}" for run in ends
    ]
    return f"{shortened(runs[0].method.name)}: {', '.join(results)}."


def _draw(figure: Figure, curves: list[tuple[Measurement, ...]], floor: float) -> None:
    """Two panels with the same errors, and one legend below them."""
    looks = _looks(curves)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, (text, kind) in zip(panels, PANELS):
        axes.set_title(text)
        for runs, look in zip(curves, looks):
            _curve(axes, runs, look, kind)
        _axis_of_times(axes)
        for value, name in ((EPS, "rounding error of a double"), (floor, "accuracy of the reference solution")):
            if value > 0:
                axes.axhline(value, color="#8795a1", linewidth=1.0, zorder=1.5)
                place = {"xycoords": ("axes fraction", "data"), "xytext": (-2, 2), "textcoords": "offset points"}
                axes.annotate(name, (1, value), **place, ha="right", va="bottom", color=MUTED, fontsize=7.5)
    _axis_of_errors(panels[0], [_height(run) for runs in curves for run in runs], floor)
    handles = [panels[0].plot([], [], label=_name(runs), **look)[0] for runs, look in zip(curves, looks)]
    figure.legend(handles=handles, loc="outside lower center", ncols=COLUMNS, columnspacing=1.6, fontsize=8)


def _name(runs: tuple[Measurement, ...]) -> str:
    """The method with its coarsest and its finest setting."""
    first, last = runs[0].setting.label, runs[-1].setting.label
    settings = first if first == last else f"{first} … {last.rpartition(' ')[2]}" if first else f"to {last}"
    return powers(shortened(", ".join(filter(None, (runs[0].method.name, settings))), NAME))


def _looks(curves: list[tuple[Measurement, ...]]) -> list[dict]:
    """Markers: stars for the methods of this package, on top; other markers and colours for the others."""
    looks, ours, others = [], 0, 0
    for runs in curves:
        if runs[0].method.is_ours:
            color, marker, dashes = OURS[ours % len(OURS)], "*", DASHES[ours // len(OURS) % len(DASHES)]
            looks.append({"color": color, "marker": marker, "linestyle": dashes, "markersize": 13.0, "linewidth": 2.0, "zorder": 5})
            ours += 1
        else:
            turn, place = divmod(others, len(PALETTE))
            color, marker, dashes = PALETTE[place], MARKERS[others % len(MARKERS)], DASHES[turn % len(DASHES)]
            looks.append({"color": color, "marker": marker, "linestyle": dashes, "markersize": 6.0, "linewidth": 1.3, "zorder": 3})
            others += 1
    return [{**look, "markeredgecolor": "white", "markeredgewidth": 0.6} for look in looks]


def _height(run: Measurement) -> float:
    return max(run.error, LOWEST)


def _curve(axes: Axes, runs: tuple[Measurement, ...], look: dict, kind: str) -> None:
    """A line through the markers, open ones for errors below the floor; thin bars for the spread of the times."""
    times = [getattr(run, kind) for run in runs]
    axes.plot([time.median for time in times], [_height(run) for run in runs], clip_on=False, **look)
    for run, time in zip(runs, times):
        line = {"color": look["color"], "zorder": look["zorder"]}
        if kind == "one_run":
            axes.plot(time.quartiles, [_height(run)] * 2, linewidth=BAR, alpha=0.4, solid_capstyle="butt", **line)
        if run.error < LOWEST:
            is_open = {"markerfacecolor": "white", "markeredgecolor": look["color"], "markeredgewidth": 1.3}
            axes.plot([time.median], [LOWEST], clip_on=False, **{**look, **is_open})


def _axis_of_times(axes: Axes) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axes.set_xscale("log")
    times = np.concatenate([np.asarray(line.get_xdata(), dtype=float) for line in axes.lines])
    room = max(ROOM, (times.max() / times.min()) ** 0.07)
    low, high = times.min() / room, times.max() * room
    spare = max(1.0, math.sqrt(LEAST_SPAN / (high / low)))
    axes.set_xlim(low / spare, high * spare)
    axes.set_xlabel("run time")
    between = (1, 2, 5) if math.log10(high / low) < FEW_DECADES else (1,)
    axes.xaxis.set_major_locator(LogLocator(subs=between, numticks=8))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda seconds, _: duration(seconds)))
    axes.xaxis.set_minor_locator(NullLocator())


def _axis_of_errors(axes: Axes, errors: list[float], floor: float) -> None:
    """Axis of errors of both panels."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axes.set_yscale("log")
    axes.set_ylim(min(*errors, EPS) / BELOW, max(*errors, floor, LEAST_ERRORS * EPS) * ABOVE)
    axes.set_ylabel("relative error (further down is better)")
    axes.yaxis.set_major_locator(LogLocator(numticks=10))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda error, _: power_of_ten(error)))
    axes.yaxis.set_minor_locator(NullLocator())
