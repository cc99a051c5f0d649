"""Plots of a sweep: values over a parameter, maps over two, scatter, distributions, bands around curves, tornado plots."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...page.content import LEAST_SHARE, Cells, Curve, Guide, Marks, Plot, Scale, curve_with_gaps, measured, shortened
from .samples import QUANTILES, Estimate, rank_correlations

#: Panels of an image.
ACROSS = 3

#: Quantities and parameters of which there are plots.
MOST_FIGURES, MOST_PARAMETERS = 6, 4

#: Samples that a scatter plot shows, and times or frequencies of a band that are read together.
MOST_DOTS, MOST_PLACES = 500, 400

#: Cells of a map in each direction.
MOST_CELLS = 60

#: Rows of names that a plot of the usual height has room for.
MOST_ROWS = 8

#: Shares of all samples below the curves of a band.
SHARES = (0.5, 0.05, 0.95, 0.25, 0.75)


class SweepPlots:
    """The plots of a result.

    Attributes:
        result: of a sweep.
        units: unit and factor of each quantity, as [output] requests.
        figures: names of the quantities that are shown.
    """

    def __init__(self, result, figures: Sequence[str], units: Mapping[str, tuple[str, float]]):
        self.result, self.units = result, units
        self.kept = np.flatnonzero(result.answered)
        self.figures = [name for name in figures if _varies(result.values(name))][:MOST_FIGURES]

    def all(self) -> Iterator[Plot]:
        """The plots that suit the samples, those of a row of quantities in one image."""
        samples = self.result.samples
        numeric = [name for name, one in samples.grid.items() if not one.is_text]
        for place, figure in enumerate(self.figures):
            row = f"row {place // ACROSS}"
            if samples.table.method == "one at a time":
                yield replace(self._tornado(figure), image=row)
            elif len(numeric) == 2 == len(samples.variations):
                yield replace(self._map(numeric, figure), image=row)
            elif samples.random:
                yield replace(self._distribution(figure), image=row)
        if samples.table.method == "one at a time" or len(numeric) == 2 == len(samples.variations):
            return
        numbers = [name for name in samples.variations if self.result.samples.column(name, slice(0, 1)).dtype.kind == "f"]
        for figure in self.figures if numbers else ():
            correlations = rank_correlations([self.result.parameter(name) for name in numbers], self.result.values(figure))
            order = np.argsort(-np.nan_to_num(np.abs(correlations)), kind="stable")[:MOST_PARAMETERS]
            for i in sorted(order):
                yield replace(self._scatter(numbers[i], figure), image=f"scatter of {figure}")

    def values(self, name: str) -> tuple[str, np.ndarray]:
        """The unit shown of a quantity and its values in it."""
        unit, factor = self.units[name]
        return "" if unit == "1" else unit, factor * self.result.values(name)

    def column(self, name: str) -> tuple[str, np.ndarray]:
        """The unit shown of a parameter and its values in it."""
        unit, factor = self.result.scene.equations.coordinates.shown.of(
            getattr(self.result.samples.variations[name], "unit", ""), name
        )
        return unit, factor * self.result.parameter(name)

    def _map(self, names: Sequence[str], figure: str) -> Plot:
        (across, x), (up, y), (unit, values) = *map(self.column, names), self.values(figure)
        shape = self.result.samples.shape[:2]
        places = [np.arange(0, count, -(-count // MOST_CELLS)) for count in shape]
        x, y = x.reshape(shape)[places[0], 0], y.reshape(shape)[0, places[1]]
        orders = np.argsort(x), np.argsort(y)
        x, y, grid = x[orders[0]], y[orders[1]], values.reshape(shape)[np.ix_(*places)][np.ix_(*orders)].T
        texts = [
            [f"{measured(a, across)}, {measured(b, up)}: {measured(value, unit) if np.isfinite(value) else 'no answer'}"]
            for b, row in zip(y, grid)
            for a, value in zip(x, row)
        ]
        cells = Cells(_edges(x), _edges(y), grid, np.reshape(texts, grid.shape).tolist(), unit, (x, y))
        missing = int((~self.result.answered).sum())
        return Plot(
            f"{figure} over {names[0]} and {names[1]}",
            up,
            cells.across,
            (),
            across_unit=across,
            quantity=names[1],
            variable=names[0],
            cells=cells,
            note=f"Grey: the {missing} samples without an answer." if missing else "",
        )

    def _scatter(self, name: str, figure: str) -> Plot:
        step = max(1, len(self.kept) // MOST_DOTS)
        (across, x), (unit, values) = self.column(name), self.values(figure)
        places = [i for i in self.kept[::step][np.argsort(x[self.kept[::step]], kind="stable")] if np.isfinite(values[i])]
        x, y, color = x[places], values[places], self.figures.index(figure)
        texts = (f"sample {i + 1}: {name} = {measured(a, across)}, {figure} {measured(b, unit)}" for i, a, b in zip(places, x, y))
        is_line = len(self.result.samples.variations) == 1 and not self.result.samples.random and len(np.unique(x)) == len(x)
        ends = x if is_line else x[[0, -1]] if x[0] < x[-1] else x[:1]
        curve = Curve(
            figure, y if is_line else np.full(len(ends), y[0]), color, drawn=None if is_line else np.zeros(len(ends), bool)
        )
        return Plot(
            f"{figure} over {name}",
            unit,
            ends,
            (curve,),
            across_unit=across,
            quantity=figure,
            variable=name,
            marks=(Marks("", np.array([x, y]).T, tuple(texts), "dot", 0),),
            note=f"One in {step} of the samples is shown." if step > 1 else "",
        )

    def _distribution(self, figure: str) -> Plot:
        unit, values = self.values(figure)
        values = values[np.isfinite(values)]
        counts, edges = np.histogram(values, bins="auto")
        ends = np.array([edges[:-1], np.nextafter(edges[1:], -np.inf)]).T.ravel()  # a step for each bin, next to the following one
        high = 1.05 * float(counts.max())
        guides = [
            Guide(f"{100 * p:g} %" if p != 0.5 else "median", (at, 0.0), (at, high), "line")
            for p, at in zip(QUANTILES, np.quantile(values, QUANTILES).tolist())
        ]
        if figure in self.result.limits:
            limit = self.units[figure][1] * self.result.limits[figure]
            guides.append(Guide("limit", (limit, high), (limit, 0.0), "limit"))
        curve = Curve("samples", np.repeat(counts, 2).astype(float))
        return Plot(
            f"distribution of {figure}",
            "",
            ends,
            (curve,),
            across_unit=unit,
            quantity="samples",
            variable=figure,
            guides=tuple(guides),
            includes=(0.0,),
        )

    def _tornado(self, figure: str) -> Plot:
        unit, values = self.values(figure)
        names, ends = list(self.result.samples.variations), np.array([values[1::2], values[2::2]])
        order = np.argsort(-np.nan_to_num(np.abs(ends[1] - ends[0])), kind="stable")
        groups = {f"{name} value of the parameter": ends[i][order] for i, name in enumerate(("low", "high"))}
        return row_plot(f"tornado plot of {figure}", [names[i] for i in order], groups, figure, unit, float(values[0]))

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


def row_plot(
    title: str, names: Sequence[str], groups: Mapping[str, Sequence[float] | np.ndarray], quantity: str, unit: str = "", base: float = 0.0,
    intervals: Sequence[Sequence[Estimate]] = (),
) -> Plot:  # fmt: skip
    """Values of several groups, a row for each name, the first on top: lines from a base, or along intervals, with marks."""
    rows = np.arange(len(names), 0.0, -1.0)
    values = np.array([*groups.values()], dtype=float)
    known = np.where(np.isfinite(values), values, base)
    low, high = np.minimum(known.min(axis=0), base), np.maximum(known.max(axis=0), base)
    guides = [Guide("", (a, y), (b, y), "line") for a, b, y in zip(low, high, rows)]
    guides += [
        Guide("", (one.low, y), (one.high, y), "limit") for group in intervals for one, y in zip(group, rows) if one.low < one.high
    ]
    ends = np.array([low.min(), high.max(), *(end for group in intervals for one in group for end in (one.low, one.high))])
    left, right = float(np.nanmin(ends)), float(np.nanmax(ends))
    width = (right - left) or abs(base) or 1.0
    guides.append(Guide("", (base, 0.0), (base, len(names) + 1.0), "grid"))
    marks = [
        Marks("", np.array([own, rows]).T[np.isfinite(own)], _texts(names, own, label, unit), curve=number)
        for number, (label, own) in enumerate(zip(groups, values))
    ]
    labels = Marks(
        "", np.array([np.full(len(rows), left - 0.03 * width), rows]).T, tuple(shortened(name, 60) for name in names), "text"
    )
    span = np.array([left - 0.03 * width, right + 0.03 * width])
    hidden = np.zeros(2, dtype=bool)
    return Plot(
        title,
        "",
        span,
        tuple(Curve(label, np.full(2, rows[0]), drawn=hidden) for label in groups),
        across_unit=unit,
        quantity="parameter",
        variable=quantity,
        scales=("linear", "rows"),
        guides=tuple(guides),
        marks=(*marks, labels),
        includes=(1.0, float(len(names))),
        is_large=len(names) > MOST_ROWS,
        note="Red: intervals of 95 %." if intervals else "",
    )


def _texts(names: Sequence[str], values: np.ndarray, label: str, unit: str) -> tuple[str, ...]:
    return tuple(f"{name}, {label}: {measured(value, unit)}" for name, value in zip(names, values) if np.isfinite(value))


def _edges(values: np.ndarray) -> np.ndarray:
    """Edges of cells around ascending values."""
    middles = (values[1:] + values[:-1]) / 2
    if not len(middles):
        return values[0] + np.array([-0.5, 0.5])
    return np.concatenate([[2 * values[0] - middles[0]], middles, [2 * values[-1] - middles[-1]]])


def _varies(values: np.ndarray) -> bool:
    """Whether values vary by more than rounding errors."""
    finite = values[np.isfinite(values)]
    return bool(len(finite) and np.ptp(finite) > LEAST_SHARE * np.abs(finite).max())
