"""The report of a sweep: parameters, statistics, sensitivities, samples without an answer; as text, page and data."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property

import numpy as np

from ...analyses.modes import variants_content
from ...ground.checks import counted
from ...ground.display import TextTable, finite_or_none, number_text, with_unit
from ...ground.errors import MbconstrainedError
from ...ground.notices import Notice, NoticeKind
from ...page.content import PageContent
from ...scene.quantities.variations import Distribution, Variation
from ...scene.run.report.summary import notices_json
from ..figures import Picture
from ..study_report import StudyReport
from ..timing import machine
from .sample_statistics import QUANTILES, Estimate, SobolIndices, rank_correlations
from .sweep_pictures import SweepPictures, bars
from .sweep_result import SampleAnswers

#: Samples without an answer that are listed; the data has all.
MOST_FAILURES = 20

#: Variants that the page animates, and coordinates of the largest system that it animates.
MOST_VARIANTS, MOST_COORDINATES = 25, 200

#: Figures of which the parameters that matter are shown.
MOST_MATTERING = 3


#: Number of damaged chunks that are named.
MOST_DAMAGED = 6


class SweepReport(StudyReport):
    """The report of a sweep.

    Attributes:
        result: of the sweep.
        strict: whether samples without an answer make the exit code 3.
    """

    def __init__(self, result: SampleAnswers, strict: bool = False):
        self.result, self.strict = result, strict
        self.machine = machine()

    @property
    def heading(self) -> str:
        """Title of the scene, and the varied parameters."""
        return f"{self.result.scene.title}: {counted(len(self.result), 'sample')}"

    @cached_property
    def units(self) -> dict[str, tuple[str, float]]:
        """Unit and factor of each quantity, as [output] requests."""
        shown = self.result.scene.equations.coordinates.shown
        return {
            name: shown.of(one.unit) if " or " not in one.unit else (one.unit, 1.0) for name, one in self.result.figures.items()
        }

    @cached_property
    def figures(self) -> list[str]:
        """Names of the quantities with a value; without damping ratios of undamped systems."""
        values = {name: self.result.values(name) for name in self.result.figures}
        undamped = {
            name
            for name, one in self.result.figures.items()
            if one.variable.name == "damping ratio" and not np.nan_to_num(values[name]).any()
        }
        return [name for name, own in values.items() if not np.isnan(own).all() and name not in undamped]

    @property
    def sentences(self) -> tuple[str, ...]:
        """The number of samples, their sampling, and the number without an answer."""
        samples, table = self.result.samples, self.result.table
        drawn = {
            "random": f"{table.samples} random points, seed {table.seed}",
            "latin hypercube": f"a Latin hypercube of {table.samples} points, seed {table.seed}",
            "sobol": f"{table.samples} Sobol points, seed {table.seed}",
            "saltelli": f"Saltelli's design of blocks of {table.samples} points, seed {table.seed}",
            "one at a time": "one parameter at a time, the others in the middle",
        }[table.method]
        given = [str(len(one.values)) for one in samples.grid.values()]
        grid = f"a grid of {' × '.join(given)} values" if given and table.method != "one at a time" else ""
        parts = [grid, drawn if samples.random or table.method == "one at a time" else ""]
        failed = len(self.result.failures)
        answers = "all have an answer" if not failed else f"{failed} have no answer, each with its reason"
        return (f"{counted(len(self.result), 'sample')}: {' by '.join(filter(None, parts))}; {answers}.",)

    @property
    def tables(self) -> tuple[TextTable, ...]:
        """Parameters, statistics, limits, sensitivities, samples without an answer."""
        tables = [self._parameters(), self._statistics()]
        tables += [self._limits()] if self.result.table.limits else []
        tables += [self._sobol_table()] if self.sobol else []
        return (*tables, *([self._failures()] if self.result.failures else []))

    def pictures(self) -> list[Picture]:
        """Maps, distributions, scatter plots, bands, sensitivities."""
        pictures = SweepPictures(self.result, self.figures, self.units).all()
        names = list(self.result.samples.variations)
        for figure, indices in self.sobol.items():
            groups: dict[str, Sequence[Estimate]] = {"alone": indices.first, "with the others": indices.total}
            pictures.append(bars(f"Sobol indices of {figure}", names, groups, "share of the variance"))
        for figure, ranks in self.correlations.items():
            order = np.argsort(-np.abs(np.nan_to_num(ranks)))
            values = [Estimate(0.0 if np.isnan(ranks[i]) else ranks[i], np.nan, np.nan) for i in order]
            title = f"Tornado plot of {figure}: rank correlations"
            pictures.append(bars(title, [names[i] for i in order], {"": values}, "rank correlation"))
        return pictures

    def page_content(self, pictures: Sequence[Picture] | None = None) -> PageContent:
        """The report as a page, which animates variants at quantiles of the first quantity in their lowest mode."""
        content, result = super().page_content(pictures), self.result
        system = result.scene.equations.system
        if not self.figures or system is None or system.size > MOST_COORDINATES:
            return content
        name, variants = self.figures[0], []
        unit, factor = self.units[name]
        values = result.values(name)
        places = np.argsort(values, kind="stable")[: int(np.isfinite(values).sum())]
        for number in np.unique(np.linspace(0, len(places) - 1, MOST_VARIANTS).round().astype(int)).tolist():
            place = int(places[number])
            text = with_unit(factor * values[place], unit)
            with suppress(MbconstrainedError):
                variants.append((f"sample {place + 1}", (*self._values(place), (name, text)), result.sample_scene(place)))
        shown = ("animation", f"{len(variants)} samples at quantiles of {name}, each in the shape of its lowest mode")
        return variants_content(variants, replace(content, facts=(shown, *content.facts))) or content

    @cached_property
    def sobol(self) -> dict[str, SobolIndices]:
        """The Sobol indices of each quantity; none without Saltelli's design, or where a sample has no value."""
        if self.result.table.method != "saltelli":
            return {}
        whole = [name for name in self.figures if np.isfinite(self.result.values(name)).all()]
        return {name: self.result.sobol_indices(name) for name in whole}

    @cached_property
    def correlations(self) -> dict[str, list[float]]:
        """Rank correlations of the first quantities with several random parameters."""
        samples = self.result.samples
        if len(samples.variations) < 2 or not samples.is_random or self.sobol:
            return {}
        columns = [self.result.parameter(name) for name in samples.variations]
        return {name: rank_correlations(columns, self.result.values(name)) for name in self.figures[:MOST_MATTERING]}

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on samples without an answer, and on invalid intervals."""
        result, texts = self.result, []
        if result.samples.is_random and result.table.method in ("sobol", "latin hypercube"):
            texts.append(
                f"the intervals are those of independent samples; those of a {result.table.method} design are narrower in most cases"
            )
        notices = [Notice(NoticeKind.ACCURACY, text) for text in texts]
        if damaged := result.chunks.damaged:
            numbers = ", ".join(map(str, damaged[:MOST_DAMAGED])) + (" ..." if len(damaged) > MOST_DAMAGED else "")
            text = f"{counted(len(damaged), 'chunk')} of the store ({numbers}) {'was' if len(damaged) == 1 else 'were'} damaged, and computed again"
            notices.append(Notice(NoticeKind.OMITTED, text))
        if failed := len(result.failures):
            text = f"{failed} of {counted(len(result), 'sample')} have no answer; statistics are those of the others"
            notices.append(Notice(NoticeKind.OMITTED, text, doubtful=self.strict))
        return (*result.scene.notices, *notices)

    @property
    def is_trusted(self) -> bool:
        """False where samples without an answer count as an error, and there are some."""
        return not (self.strict and self.result.failures)

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:
        """The scene, then the machine."""
        return (("scene", self.result.scene.path.name), *super().facts)

    def as_json(self) -> dict:
        """Statistics and reasons as plain data, numbers in SI; samples are in the store and the CSV file."""
        result, samples = self.result, self.result.samples
        random = samples.is_random
        return {
            "title": result.scene.title,
            "samples": len(result),
            "answered": int(result.answered.sum()),
            "method": result.table.method if samples.random else "given values",
            "seed": result.table.seed,
            "parameters": {name: one.as_data() for name, one in samples.variations.items()},
            "figures": {
                name: {"unit": result.figures[name].unit, **_summary_data(result.statistics(name), random)} for name in self.figures
            },
            "limits": {
                name: {"limit": limit, **_estimate_data(result.exceedance(name, limit))} for name, limit in result.limits.items()
            },
            "sobol_indices": {
                name: {
                    parameter: {"first": _estimate_data(a), "total": _estimate_data(b)}
                    for parameter, a, b in zip(samples.variations, one.first, one.total)
                }
                for name, one in self.sobol.items()
            },
            "rank_correlations": {
                name: dict(zip(samples.variations, map(finite_or_none, ranks))) for name, ranks in self.correlations.items()
            },
            "failures": [
                {"sample": place, "reason": reason, "values": samples.rows(slice(place, place + 1))[0]}
                for place, reason in result.failures.items()
            ],
            "notices": notices_json(self.notices),
            "trusted": self.is_trusted,
        }

    def _parameters(self) -> TextTable:
        shown = self.result.scene.equations.coordinates.shown
        rows = tuple((name, _described(one, shown)) for name, one in self.result.samples.variations.items())
        return TextTable("Parameters", ("parameter", "varied"), rows)

    def _statistics(self) -> TextTable:
        if not self.result.samples.is_random:
            return self._extremes()
        rows = []
        for name in self.figures:
            unit, factor = self.units[name]
            of = self.result.statistics(name)
            quantiles = [estimate_text(of.quantiles[p], factor) if of.quantiles else "–" for p in QUANTILES]
            title = f"{name} ({unit})" if unit not in ("", "1") else name
            rows.append((title, number_text(factor * of.mean), number_text(factor * of.deviation), *quantiles))
        note = "In parentheses: intervals that contain the quantile with a probability of 95 %."
        columns = ("figure", "mean", "standard deviation", "5 %", "median", "95 %")
        return TextTable("Statistics", columns, tuple(rows), note)

    def _extremes(self) -> TextTable:
        rows = []
        for name in self.figures:
            unit, factor = self.units[name]
            values = self.result.values(name)
            ends = [int(np.nanargmin(values)), int(np.nanargmax(values))]
            texts = [f"{with_unit(factor * values[at], unit)} at {self._place(at)}" for at in ends]
            rows.append((name, *texts))
        return TextTable("Least and largest values", ("figure", "least", "largest"), tuple(rows))

    def _values(self, sample: int) -> tuple[tuple[str, str], ...]:
        """The parameters of a sample as texts."""
        shown = self.result.scene.equations.coordinates.shown
        row, texts = self.result.samples.rows(slice(sample, sample + 1))[0], []
        for name, value in row.items():
            unit, factor = shown.of(getattr(self.result.samples.variations[name], "unit", ""))
            texts.append((name, value if isinstance(value, str) else with_unit(factor * value, unit)))
        return tuple(texts)

    def _place(self, sample: int) -> str:
        return ", ".join(f"{name} = {text}" for name, text in self._values(sample))

    def _limits(self) -> TextTable:
        rows = []
        for name, limit in self.result.limits.items():
            unit, factor = self.units[name]
            estimate = self.result.exceedance(name, limit)
            text = f"{100 * estimate.value:.4g} % ({100 * estimate.low:.3g} to {100 * estimate.high:.3g} %)"
            rows.append((name, with_unit(factor * limit, unit), text))
        return TextTable("Probabilities of exceeding limits", ("figure", "limit", "probability"), tuple(rows))

    def _sobol_table(self) -> TextTable:
        rows = [
            (figure, name, estimate_text(first), estimate_text(total))
            for figure, indices in self.sobol.items()
            for name, first, total in zip(self.result.samples.variations, indices.first, indices.total)
        ]
        return TextTable("Sobol indices", ("figure", "parameter", "alone", "with the others"), tuple(rows))

    def _failures(self) -> TextTable:
        failures = list(self.result.failures.items())
        rows = tuple((self._place(place), reason) for place, reason in failures[:MOST_FAILURES])
        note = f"and {len(failures) - MOST_FAILURES} more, which the CSV file has" if len(failures) > MOST_FAILURES else ""
        return TextTable("Samples without an answer", ("sample", "reason"), rows, note)


def estimate_text(estimate: Estimate, factor: float = 1.0) -> str:
    """A number with its interval.

    >>> estimate_text(Estimate(1.0, 0.5, 2.0))
    '1 (0.5 to 2)'
    """
    value = number_text(factor * estimate.value)
    if np.isnan(estimate.low) or np.isnan(estimate.high) or estimate.low == estimate.high:
        return value
    return f"{value} ({factor * estimate.low:.4g} to {factor * estimate.high:.4g})"


def _described(one: Variation, shown) -> str:
    unit, factor = shown.of(one.unit)
    if isinstance(one, Distribution):
        ends = f", between {factor * one.low:g} and {factor * one.high:g}" if np.isfinite([one.low, one.high]).all() else ""
        words = {"uniform": "uniform from {} to {}", "normal": "normal, mean {}, standard deviation {}"}
        words["lognormal"] = "lognormal, mean {}, standard deviation {}"
        texts = (with_unit(factor * value, unit) for value in (one.first, one.second))
        return words[one.kind].format(*texts) + ends
    if one.is_text or len(one.values) <= 4:
        return ", ".join(str(value) if one.is_text else with_unit(factor * value, unit) for value in one.values[:8])
    low, high = (with_unit(factor * end, unit) for end in one.ends)
    return f"{len(one.values)} values from {low} to {high}"


def _summary_data(of, random: bool) -> dict:
    data = {"count": of.count, "infinite": of.infinite, "least": finite_or_none(of.least), "largest": finite_or_none(of.largest)}
    if not random:
        return data
    quantiles = {f"{probability:g}": _estimate_data(one) for probability, one in of.quantiles.items()}
    return {**data, "mean": finite_or_none(of.mean), "standard_deviation": finite_or_none(of.deviation), "quantiles": quantiles}


def _estimate_data(one: Estimate) -> dict:
    return {"value": finite_or_none(one.value), "interval": [finite_or_none(one.low), finite_or_none(one.high)]}


class SweepResult(SampleAnswers):
    """The samples of a study with what was kept of each."""

    def _tables(self) -> tuple[TextTable, ...]:
        return SweepReport(self).tables
