"""The picture of the ratios: a bar for one run and one for each further evaluation of every workload."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbconstrained.analyses.accuracy.accuracy import ratio as shown_ratio
from mbconstrained.analyses.figures import Picture, nothing_to_show, power_of_ten
from mbconstrained.page.plots import GREY, INK, MUTED, RED
from tests.benchmarks.speed.report import PARTS, Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TITLE = "Our time over that of the fastest peer of equal or smaller error"

COLORS = {"one_run": INK, "further": "#0b5cad"}
LABELS = {"one_run": "one run", "further": "each further evaluation"}

#: Height of a workload and of what stands around all of them, inches; of a bar, in workloads.
ROW, AROUND, BAR = 0.42, 0.95, 0.36


def picture_of(rows: list[Row]) -> Picture:
    """Bars to the left of 1 are ours, to the right the peer's; red lines are what is wanted."""
    shown = [row for row in rows if row.ratio("one_run") is not None]
    if not shown:
        return nothing_to_show(TITLE, "Ratios of run times")
    height = ROW * len(shown) + AROUND
    return Picture(TITLE, described(shown), height, lambda figure: draw(figure, shown))


def described(rows: list[Row]) -> str:
    """What is to be seen, in words."""
    told = [f"{row.workload.name} {shown_ratio(row.ratio('one_run'))} and {shown_ratio(row.ratio('further'))}" for row in rows]
    return f"{TITLE}, one run and each further evaluation: {'; '.join(told)}."


def draw(figure: Figure, rows: list[Row]) -> None:
    """One panel, the first workload on top."""
    axes, bars = figure.subplots(), []
    for part, offset in zip(PARTS, (-0.5 * BAR, 0.5 * BAR)):
        places = [place + offset for place in range(len(rows))]
        ratios = [row.ratio(part) for row in rows]
        bars.append(axes.barh(places, [ratio - 1.0 for ratio in ratios], BAR, left=1.0, color=COLORS[part], label=LABELS[part]))
        for place, ratio, row in zip(places, ratios, rows):
            beyond = ratio > 1.0
            axes.annotate(
                shown_ratio(ratio), (ratio, place), (4 if beyond else -4, 0), textcoords="offset points",
                ha="left" if beyond else "right", va="center", color=MUTED, fontsize=7.5,
            )  # fmt: skip
            wanted = getattr(row.workload.target, part)
            if wanted is not None:
                axes.plot([wanted, wanted], [place - BAR / 2, place + BAR / 2], color=RED, linewidth=1.6)
    (line,) = axes.plot([], [], color=RED, linewidth=1.6, label="wanted at most")
    _axes(axes, rows)
    figure.legend(handles=[*bars, line], loc="outside lower center", ncols=3)


def _axes(axes, rows: list[Row]) -> None:
    from matplotlib.ticker import FuncFormatter, NullLocator

    ratios = [row.ratio(part) for row in rows for part in PARTS]
    wanted = [value for row in rows for part in PARTS if (value := getattr(row.workload.target, part))]
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda ratio, _: power_of_ten(ratio)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlim(min(*ratios, *wanted, 0.5) / 3, max(*ratios, *wanted, 2.0) * 3)
    axes.axvline(1.0, color=GREY, linewidth=1.0)
    axes.set_yticks(range(len(rows)), [row.workload.name for row in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("less than 1: the package is faster")
