"""Figures of a sweep: values over a parameter, maps over two, scatter, distributions, bands around curves, tornado plots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from textwrap import fill

import numpy as np

from ...page.content import LEAST_SHARE, Plot, Scale, curve_with_gaps, raised, shortened
from ...page.figure import PALETTE
from ...page.plots import GREY, LINE, MUTED, RED
from ..figures import Picture
from .samples import QUANTILES, Estimate, rank_correlations

#: Panels next to each other, and their height in inches.
ACROSS, PANEL = 3, 2.3

#: Figures and parameters of which there are panels; of more they would be too small.
MOST_FIGURES, MOST_PARAMETERS = 6, 4

#: Samples that a scatter plot shows, and times or frequencies of a band.
MOST_DOTS, MOST_PLACES = 2000, 400

#: Numbers along an axis of a scatter plot, about: more would overlap.
MOST_TICKS = 4

#: Cells of a map in each direction.
MOST_CELLS = 60

#: Shares of all samples below the curves of a band.
SHARES = (0.5, 0.05, 0.95, 0.25, 0.75)

Axis = tuple[str, np.ndarray]


class SweepPictures:
    """The figures of a result.

    Attributes:
        result: of a sweep.
        figures: names of the numbers that are shown.
    """

    def __init__(self, result, figures: Sequence[str], units: dict[str, tuple[str, float]]):
        self.result, self.units = result, units
        self.kept = np.flatnonzero(result.answered)
        self.figures = [name for name in figures if _varies(result.values(name))][:MOST_FIGURES]

    def all(self) -> list[Picture]:
        """The figures that suit the samples."""
        samples, pictures = self.result.samples, []
        numeric = [name for name, one in samples.grid.items() if not one.is_text]
        rows = [self.figures[first : first + ACROSS] for first in range(0, len(self.figures), ACROSS)]
        if samples.table.method == "one at a time":
            pictures += [self._tornado(row) for row in rows]
        elif len(numeric) == 2 == len(samples.variations):
            pictures += [self._maps(numeric, row) for row in rows]
        else:
            numbers = [name for name in samples.variations if self.result.samples.column(name, slice(0, 1)).dtype.kind == "f"]
            pictures += [self._distributions(row) for row in rows if samples.random]
            pictures += [self._scatter(self._leading(numbers, figure), figure) for figure in self.figures if numbers]
        return pictures

    def values(self, name: str) -> Axis:
        """The title of an axis and the values of a quantity in its unit."""
        unit, factor = self.units[name]
        return titled(name, unit), factor * self.result.values(name)

    def column(self, name: str) -> Axis:
        """The title of an axis and the values of a parameter in its unit."""
        unit, factor = self.result.scene.equations.coordinates.shown.of(getattr(self.result.samples.variations[name], "unit", ""))
        return titled(name, unit), factor * self.result.parameter(name)

    def _leading(self, names: list[str], figure: str) -> list[str]:
        """The parameters with the largest rank correlations, as many as fit, in the order of the scene."""
        correlations = rank_correlations([self.result.parameter(name) for name in names], self.result.values(figure))
        order = np.argsort(-np.nan_to_num(np.abs(correlations)), kind="stable")[:MOST_PARAMETERS]
        return [names[i] for i in sorted(order)]

    def _maps(self, names: list[str], figures: list[str]) -> Picture:
        (across, x), (up, y) = (self.column(name) for name in names)
        shape = self.result.samples.shape[:2]
        steps = [max(1, count // MOST_CELLS) for count in shape]
        kept = slice(None, None, steps[0]), slice(None, None, steps[1])
        x, y = x.reshape(shape)[kept[0], 0], y.reshape(shape)[0, kept[1]]
        maps = [(title, values.reshape(shape)[kept]) for title, values in map(self.values, figures)]

        def draw(figure) -> None:
            for axes, (title, values) in zip(_panels(figure, len(maps), ACROSS), maps):
                finite = np.ma.masked_invalid(values.T)
                mesh = axes.pcolormesh(x, y, finite, shading="nearest", cmap="viridis", edgecolors="face", linewidth=0.2)
                axes.set(xlabel=across, ylabel=up, facecolor=LINE)
                axes.set_title(fill(title, 30), loc="left")
                axes.grid(False)
                figure.colorbar(mesh, ax=axes).solids.set_rasterized(False)  # pages show no images

        missing = int((~self.result.answered).sum())
        note = f"Grey: the {missing} samples without an answer." if missing else ""
        return Picture(f"{_listed(figures)} over {names[0]} and {names[1]}", f"Maps of {', '.join(figures)}", 2.8, draw, note)

    def _scatter(self, names: list[str], of: str) -> Picture:
        step = max(1, len(self.kept) // MOST_DOTS)
        places = self.kept[::step]
        columns, (title, values) = [self.column(name) for name in names], self.values(of)
        is_line = len(self.result.samples.variations) == 1 and not self.result.samples.random
        color = PALETTE[self.figures.index(of) % len(PALETTE)]

        def draw(figure) -> None:
            row = figure.subplots(1, len(columns), squeeze=False, sharey=True)[0]
            for axes, (name, column) in zip(row, columns):
                marks = {"marker": "o", "markersize": 2.6, "linestyle": "-" if is_line else "none", "linewidth": 1.0}
                axes.plot(column[places], values[places], color=color, **marks)
                axes.set_xlabel(name)
                axes.locator_params(axis="x", nbins=MOST_TICKS)
            row[0].set_ylabel(title)

        note = f"One in {step} of the samples is shown." if step > 1 else ""
        return Picture(f"{of} over {_listed(names)}", f"{of} over {', '.join(names)}", PANEL, draw, note)

    def _distributions(self, figures: list[str]) -> Picture:
        data = [(title, np.sort(values[np.isfinite(values)])) for title, values in map(self.values, figures)]
        limits = {name: self.units[name][1] * limit for name, limit in self.result.limits.items()}

        def draw(figure) -> None:
            for axes, name, (title, values) in zip(_panels(figure, len(data)), figures, data):
                axes.hist(values, bins="auto", color=PALETTE[0], alpha=0.8)
                for probability in QUANTILES:
                    axes.axvline(np.quantile(values, probability), color=MUTED, linewidth=0.9, linestyle="--")
                if name in limits:
                    axes.axvline(limits[name], color=RED, linewidth=1.2)
                axes.set(xlabel=title, ylabel="samples")

        note = "Dashed: the quantiles of 5, 50 and 95 %." + (" Red: the limit." if set(limits) & set(figures) else "")
        return Picture(f"Distribution of {_listed(figures)}", f"Histograms of {', '.join(figures)}", PANEL, draw, note)

    def _tornado(self, figures: list[str]) -> Picture:
        names, panels = list(self.result.samples.variations), []
        for name in figures:
            title, values = self.values(name)
            low, high = values[1::2], values[2::2]
            order = np.argsort(np.nan_to_num(np.abs(high - low)))
            panels.append((title, values[0], [(names[i], low[i], high[i]) for i in order]))

        def draw(figure) -> None:
            for axes, (title, middle, rows) in zip(_panels(figure, len(panels)), panels):
                for place, (_, low, high) in enumerate(rows):
                    axes.barh(place, low - middle, left=middle, color=GREY, height=0.6)
                    axes.barh(place, high - middle, left=middle, color=PALETTE[0], height=0.6)
                axes.axvline(middle, color=MUTED, linewidth=0.9)
                axes.set_yticks(range(len(rows)), [_tail(name, 20) for name, _, _ in rows])
                axes.set(xlabel=title)

        note = "Blue: the high value of the parameter, grey: the low one, the others in the middle."
        height = min(1.0 + 0.3 * len(names), 5.0)
        return Picture(
            f"Tornado plot of {_listed(figures)}", f"How far each parameter moves {', '.join(figures)}", height, draw, note
        )

    def bands(self) -> Iterator[Plot]:
        """Percentiles of all samples at each place of the kept curves."""
        for variable in self.result.variables if len(self.kept) else ():
            if not variable.is_curve:
                continue
            unit, factor = variable.unit, 1.0
            if " or " not in unit:
                unit, factor = self.result.scene.equations.coordinates.shown.of(unit)
            across = np.array(variable.labels, dtype=float)
            parts = []
            for begin in range(0, len(across), MOST_PLACES):  # all places, as fewer may show a slower motion, but not all at once
                values = factor * self.result.chunks.read(variable.name, (slice(begin, begin + MOST_PLACES),))[self.kept]
                parts.append(np.quantile(values, SHARES, axis=0))
            levels = np.hstack(parts)
            is_response = variable.source == "response curves" and bool((levels > 0).all())
            scales: tuple[Scale, Scale] = ("log" if is_response and across[0] > 0 else "linear", "log" if is_response else "linear")
            names = ("median" if share == 0.5 else f"{100 * share:g} %" for share in SHARES)
            curves = tuple(curve_with_gaps(name, row) for name, row in zip(names, levels))
            axis, _, end = variable.axis.partition(" (")
            name = variable.name.removeprefix("curve ")
            yield Plot(
                f"band of {name}", unit, across, curves, across_unit=end[:-1], quantity=name, variable=axis, scales=scales,
                note="Percentiles of all samples at each place.",
            )  # fmt: skip


def bars(title: str, names: Sequence[str], groups: dict[str, Sequence[Estimate]], what: str) -> Picture:
    """Horizontal bars with intervals, one for each parameter and group."""

    def draw(figure) -> None:
        axes = figure.add_subplot()
        width = 0.8 / len(groups)
        for number, (label, estimates) in enumerate(groups.items()):
            places = np.arange(len(names)) + width * (number - (len(groups) - 1) / 2)
            values = np.array([one.value for one in estimates])
            ends = np.nan_to_num(np.abs([[one.value - one.low, one.high - one.value] for one in estimates])).T
            axes.barh(places, values, height=0.9 * width, color=PALETTE[number], label=label, xerr=ends, ecolor=MUTED)
        axes.axvline(0, color=MUTED, linewidth=0.9)
        axes.set_yticks(range(len(names)), [_tail(name, 30) for name in names])
        axes.set(xlabel=what)
        axes.invert_yaxis()
        if len(groups) > 1:
            figure.legend(loc="outside lower left", ncols=len(groups))

    return Picture(title, f"{what} of {', '.join(names)}", 0.9 + 0.28 * len(names) * max(1, len(groups) / 1.5), draw)


def _varies(values: np.ndarray) -> bool:
    """Whether values vary by more than rounding errors."""
    finite = values[np.isfinite(values)]
    return bool(len(finite) and np.ptp(finite) > LEAST_SHARE * np.abs(finite).max())


def _panels(figure, count: int, columns: int = 0):
    """Axes next to each other, with space for as many as there are columns."""
    row = figure.subplots(1, columns or count, squeeze=False)[0]
    for axes in row[count:]:
        axes.set_axis_off()
    return row[:count]


def titled(name: str, unit: str) -> str:
    """The title of an axis."""
    return fill(" ".join(filter(None, (_tail(name, 50), f"({raised(unit)})" if unit not in ("", "1") else ""))), 26)


def _tail(name: str, longest: int) -> str:
    """A long name shortened at its start, since locations differ at their ends."""
    return name if len(name) <= longest else f"…{name[1 - longest :]}"


def _listed(names: Sequence[str]) -> str:
    return shortened(", ".join(names), 70)
