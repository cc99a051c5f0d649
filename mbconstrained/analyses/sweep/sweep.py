"""The analysis sweep: a study of many samples of a scene's parameters, and its result.

A study is checked at the start, computed in chunks by a backend, and stored.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from ...exchange.trajectories import csv_of
from ...ground.checks import counted, nearest, optional_package, real_number, whole_number
from ...ground.display import Displayed, TextTable, number_text, with_unit
from ...ground.errors import InputError, MbconstrainedError, SceneError, named
from ...ground.notices import Notice, NoticeKind
from ...page.content import PageContent, Plot
from ...scene.file import read_tables, shown
from ...scene.schema.analysis_tables import VaryTable
from ...scene.schema.entry_types import Text, validated
from ...scene.variations import Distribution, Values, Variation
from ..base import Analysis, Answer
from ..modes import variants_content
from ..timing import machine, version_of
from .evaluation import ANSWERED, Job, is_stacked
from .execution import by_dask, by_processes, hashes, in_process
from .kept_quantities import SampleFigure, Variable, figure_of, figures_of, limits_of, variables_of
from .plots import SweepPlots, row_plot
from .samples import (
    QUANTILES,
    Estimate,
    ParameterSamples,
    SobolIndices,
    Summary,
    exceedance,
    rank_correlations,
    sobol_indices,
    summary,
)
from .store import REASON, STATUS, Chunks, Memory, Store, column_name, variable_data

if TYPE_CHECKING:
    from ...scene.run.scene import Scene

#: Samples of a chunk: as many as chunks, within these limits, so that a worker has some, and an interruption costs little; the most where
#: stacks serve, to which a sample costs next to nothing.
LEAST_CHUNK, MOST_CHUNK, USUAL_CHUNKS = 8, 256, 64

MOST_WORKERS = 1024

#: The size of a study of so many samples is reported before it begins.
LARGE = 100_000

ONLY_RANDOM = "limits: probabilities need distributions of all parameters, and some have given values"

#: Samples without an answer that are listed; the data has all.
MOST_FAILURES = 20

#: Variants that the page animates, and coordinates of the largest system that it animates.
MOST_VARIANTS, MOST_COORDINATES = 25, 200

#: Figures of which the parameters that matter are shown.
MOST_MATTERING = 3


#: Number of damaged chunks that are named.
MOST_DAMAGED = 6

Progress = Callable[[int, int], None]


@dataclass(frozen=True, repr=False, eq=False)
class Sweep(Displayed):
    """A study of many samples of a scene's parameters; ``run`` computes it.

    Attributes:
        scene: the scene as it is in the file.
        samples: samples of the parameters.
        variables: kept quantities of each sample.
        job: data for workers.
        table: [vary] with what was given in addition.
    """

    scene: Scene
    samples: ParameterSamples
    variables: tuple[Variable, ...]
    job: Job
    table: VaryTable

    def _summary(self) -> str:
        return f"{self.scene.name}, {counted(len(self.samples), 'sample')} of {', '.join(self.samples.variations)}"

    @cached_property
    def chunk(self) -> int:
        """Number of samples computed and stored together, which depends on the study alone."""
        least = MOST_CHUNK if is_stacked(self.job, self.samples.nominal) else LEAST_CHUNK
        return self.table.chunk or min(max(len(self.samples) // USUAL_CHUNKS, least), MOST_CHUNK)

    def run(
        self,
        store: str | Path | None = None,
        workers: int | None = None,
        dask: str | None = None,
        progress: Progress | None = None,
        sample_timeout: float | None = None,
        message: Callable[[str], None] = print,
    ) -> SweepResult:
        """Compute the missing samples.

        Args:
            store: a folder, such as "k.zarr", that keeps them, so that an interrupted run goes on from there; None for memory.
            workers: processes of this machine, one chunk at a time each; None for this process.
            dask: instead, the address of the scheduler of a Dask cluster.
            progress: called with the number of chunks that are done, and of all.
            sample_timeout: seconds that a sample may take; one over it has no answer, and the status 3 in the store. A chunk that is
                not done in this time is computed again, each sample alone.
            message: called with what is worth knowing while it runs, such as a worker that does not answer.

        Returns:
            The ``SweepResult``. It has the same bits whoever computed it.

        Raises:
            InputError: the store is of another study, the cluster does not answer.
            OSError: the disk is full.
        """
        if workers is not None and whole_number(workers, "workers", minimum=1) > MOST_WORKERS:
            raise InputError(f"workers: found {workers}; expected at most {MOST_WORKERS}")
        if workers is not None and dask is not None:
            raise InputError("workers and dask cannot both be given; leave out one of them")
        seconds = None if sample_timeout is None else real_number(sample_timeout, "sample_timeout", positive=True)
        texts = [text for values in self.samples.grid.values() if values.is_text for text in values.values]
        files = hashes(self.job, texts)
        chunks = self._chunks(store, files)
        missing = list(chunks.missing())
        work = ((number, self.samples.rows(chunks.at(number))) for number in missing)
        done = chunks.count - len(missing)
        report = progress or (lambda done, count: None)
        report(done, chunks.count)
        start, is_large = time.monotonic(), len(self.samples) >= LARGE
        if is_large:
            message(
                f"{len(self.samples):,} samples in {chunks.count:,} chunks, {done:,} of them done; "
                f"{chunks.bytes_per_sample * len(self.samples) / 1e9:.2g} GB of numbers"
            )
        if dask is not None and missing:
            answers = by_dask(self.job, work, dask, files, seconds, message)
        elif workers is not None and missing:
            answers = by_processes(self.job, work, min(workers, len(missing)), seconds)
        else:
            answers = in_process(self.job, work, seconds)
        try:
            for number, arrays in answers:
                chunks.write(number, arrays)
                done += 1
                if is_large and done == chunks.count - len(missing) + 1:
                    elapsed = time.monotonic() - start
                    hours = elapsed * len(missing) / 3600
                    message(f"the first chunk took {elapsed:.2g} s; all that are missing take about {hours:.2g} h of one process")
                report(done, chunks.count)
        except InputError:
            raise
        except (MbconstrainedError, KeyboardInterrupt) as problem:
            raise _with_advice(problem, done, chunks) from None
        finally:
            answers.close()
        return SweepResult(self.scene, self.samples, self.variables, self.table, self.job, chunks)

    def _chunks(self, store: str | Path | None, files: Mapping[str, str]) -> Chunks:
        arguments = (self.samples, self.variables, self.chunk)
        if store is None:
            return Memory(*arguments)
        vary = {
            "parameters": {name: one.to_dict() for name, one in self.samples.variations.items()},
            "chunk": self.chunk,
            **self.table.model_dump(include={"method", "samples", "seed", "correlation"}),
        }
        description = {
            "scene": {key: value for key, value in self.job.data.items() if key not in ("title", "source", "drawing")},
            "set": dict(self.job.settings),
            "files": dict(files),
            "vary": vary,
            "keep": variable_data(self.variables),
            "versions": {name: version_of(name) for name in ("mbconstrained", "numpy", "scipy")},
        }
        return Store(Path(store), description, *arguments)


@dataclass(frozen=True, repr=False, eq=False)
class SweepResult(Displayed):
    """The samples of a study with what was kept of each.

    Attributes:
        scene: of the study.
        samples: samples of its parameters.
        variables: kept quantities.
        table: [vary].
        job: makes the scene of a sample.
        chunks: storage of the arrays.
    """

    scene: Scene
    samples: ParameterSamples
    variables: tuple[Variable, ...]
    table: VaryTable
    job: Job
    chunks: Chunks

    def _summary(self) -> str:
        failed = len(self.samples) - int(self.answered.sum())
        return f"{self.scene.name}, {counted(len(self.samples), 'sample')}{f', {failed} without an answer' if failed else ''}"

    def __len__(self) -> int:
        return len(self.samples)

    @cached_property
    def answered(self) -> np.ndarray:
        """Whether each sample has an answer, shape (S,)."""
        return self.chunks.read(STATUS) == ANSWERED

    @property
    def failures(self) -> dict[int, str]:
        """Reasons of the samples without an answer, by index from 0."""
        places = np.flatnonzero(~self.answered).tolist()
        reasons = self.chunks.read(REASON) if places else []
        return {place: str(reasons[place]) for place in places}

    def parameter(self, name: str) -> np.ndarray:
        """The values of a varied parameter, numbers in SI or texts, shape (S,)."""
        if name not in self.samples.variations:
            raise InputError(
                f'"{name}" is not varied{nearest(name, self.samples.variations)}; there are {", ".join(self.samples.variations)}'
            )
        return self.samples.column(name)

    def values(self, name: str) -> np.ndarray:
        """Return a kept variable or scalar quantity over the samples, NaN for those without an answer.

        Args:
            name: such as "frequency" or "frequency 1".

        Returns:
            Numbers in SI, shape (S,), of a variable with an axis (S, n).

        Raises:
            InputError: nothing of this name was kept.
        """
        if name in (one.name for one in self.variables):
            return self.chunks.read(name)
        figure = self.figures.get(name)
        if figure is None:
            known = list(dict.fromkeys([*(one.name for one in self.variables), *self.figures]))
            raise InputError(f"{shown(name)} was not kept{nearest(name, known)}; there are {', '.join(known[:20])}")
        return self.chunks.read(figure.variable.name, figure.place)

    @cached_property
    def figures(self) -> dict[str, SampleFigure]:
        """Scalar quantities of each sample, by name."""
        return figures_of(self.variables)

    def statistics(self, name: str) -> Summary:
        """Return moments and quantiles of a scalar quantity."""
        return summary(self.independent(name))

    def independent(self, name: str) -> np.ndarray:
        """Return the values of a scalar quantity in the samples drawn from the distributions."""
        return self.values(name)[: self.samples.independent] if self.samples.is_random else self.values(name)

    @property
    def limits(self) -> dict[str, float]:
        """Limits of scalar quantities in SI."""
        return limits_of(self.table.limits, self.figures)

    def exceedance(self, name: str, limit: float) -> Estimate:
        """Return the probability that a scalar quantity exceeds a limit.

        Args:
            name: name of the figure.
            limit: in SI.

        Returns:
            The estimate with its interval.

        Raises:
            InputError: the samples are no random ones.
        """
        if not self.samples.is_random:
            raise InputError(ONLY_RANDOM)
        return exceedance(self.independent(name), limit)

    def sobol_indices(self, name: str) -> SobolIndices:
        """Return Sobol indices: the shares of the variance of a scalar quantity caused by each parameter.

        Raises:
            InputError: another method than saltelli, a sample without an answer.
        """
        if self.table.method != "saltelli":
            raise InputError('Sobol indices need method = "saltelli"')
        return sobol_indices(self.values(name), self.table.samples)

    def sample_scene(self, number: int) -> Scene:
        """Return the scene of a sample.

        Args:
            number: from 0.

        Returns:
            The scene, ready to be run.
        """
        return self.job.scene(self.samples.rows(slice(number, number + 1))[0])

    def to_xarray(self):
        """Return all variables as an ``xarray.Dataset`` over the samples, with units as attributes.

        Raises:
            MissingPackage: xarray is not installed.
        """
        xarray = optional_package("xarray", "to_xarray")
        variables: dict[str, Any] = {}
        for name, one in self.samples.variations.items():
            variables[column_name(name)] = ("sample", self.samples.column(name), {"units": one.unit} if one.unit else {})
        coordinates: dict[str, Any] = {}
        for variable in self.variables:
            axes = ["sample", *([variable.axis] if variable.axis else [])]
            variables[variable.name] = (axes, self.chunks.read(variable.name), {"units": variable.unit})
            coordinates |= {variable.axis: list(variable.labels)} if variable.axis else {}
        variables |= {name: ("sample", self.chunks.read(name)) for name in (STATUS, REASON)}
        return xarray.Dataset(variables, coordinates, {"source": "mbconstrained"})

    def csv(self) -> str:
        """Return parameters and scalar quantities of each sample as CSV, numbers in SI."""
        return csv_of(self._columns())

    def _columns(self) -> dict[str, np.ndarray]:
        """Return parameters and scalar quantities of each sample by their heads, numbers in SI."""
        units = {name: one.unit for name, one in self.samples.variations.items()}
        columns = {f"{name} ({unit})" if unit else name: self.samples.column(name) for name, unit in units.items()}
        columns |= {
            f"{one.name} ({one.unit})" if one.unit not in ("", "1") else one.name: self.values(one.name)
            for one in self.figures.values()
        }
        return {"sample": np.arange(len(self)), **columns, REASON: self.chunks.read(REASON)}

    # The report.

    @cached_property
    def _units(self) -> dict[str, tuple[str, float]]:
        """Unit and factor of each quantity, as [output] requests."""
        shown = self.scene.equations.coordinates.shown
        return {name: one.shown(shown) for name, one in self.figures.items()}

    def _text(self, name: str, value: float) -> str:
        unit, factor = self._units[name]
        return with_unit(factor * value, unit)

    @cached_property
    def _figures(self) -> list[str]:
        """Names of the quantities with a value; without damping ratios of undamped systems."""
        values = {name: self.values(name) for name in self.figures}
        undamped = {
            name
            for name, one in self.figures.items()
            if one.variable.name == "damping ratio" and not np.nan_to_num(values[name]).any()
        }
        return [name for name, own in values.items() if not np.isnan(own).all() and name not in undamped]

    @cached_property
    def _facts(self) -> tuple[tuple[str, str], ...]:
        """The sampling and the scene."""
        return ("samples", self._sampling()), ("scene", self.scene.path.name)

    def _sampling(self) -> str:
        """The number of samples, their sampling, and the number without an answer."""
        samples, table = self.samples, self.table
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
        failed = len(self.failures)
        answers = "all have an answer" if not failed else f"{failed} have no answer, each with its reason"
        return f"{counted(len(self), 'sample')}: {' by '.join(filter(None, parts))}; {answers}"

    def _tables(self) -> tuple[TextTable, ...]:
        """Parameters, statistics, limits, sensitivities, samples without an answer."""
        tables = [self._parameters(), self._statistics()]
        tables += [self._limits()] if self.table.limits else []
        tables += [self._sobol_table()] if self._sobol else []
        return (*tables, *([self._failures()] if self.failures else []))

    def _plots(self) -> Iterator[Plot]:
        """Maps, distributions, scatter plots, sensitivities, bands."""
        plots = SweepPlots(self, self._figures, self._units)
        yield from plots.all()
        names = list(self.samples.variations)
        for figure, indices in self._sobol.items():
            groups = {"alone": indices.first, "with the others": indices.total}
            values = {label: [one.value for one in group] for label, group in groups.items()}
            intervals = tuple(groups.values())
            yield row_plot(f"Sobol indices of {figure}", names, values, "share of the variance", intervals=intervals)
        for figure, ranks in self._correlations.items():
            order = np.argsort(-np.abs(np.nan_to_num(ranks)))
            of, own = [names[i] for i in order], {"rank correlation": np.nan_to_num(ranks)[order]}
            yield row_plot(f"tornado plot of {figure}: rank correlations", of, own, "rank correlation")
        yield from plots.bands()

    def _animated(self) -> dict[str, Any]:
        """Parts of the page: an animation of variants at quantiles of the first quantity, in their lowest mode."""
        system = self.scene.equations.system
        if not self._figures or system is None or system.size > MOST_COORDINATES:
            return {}
        name, variants = self._figures[0], []
        values = self.values(name)
        places = np.argsort(values, kind="stable")[: int(np.isfinite(values).sum())]
        for number in np.unique(np.linspace(0, len(places) - 1, MOST_VARIANTS).round().astype(int)).tolist():
            place = int(places[number])
            with suppress(MbconstrainedError):
                facts = (*self._values(place), (name, self._text(name, values[place])))
                variants.append((f"sample {place + 1}", facts, self.sample_scene(place)))
        shown = ("animation", f"{len(variants)} samples at quantiles of {name}, each in the shape of its lowest mode")
        content = variants_content(variants, PageContent("", facts=(shown, *self._facts)))
        return {} if content is None else {"animation": content.animation, "facts": content.facts}

    @cached_property
    def _sobol(self) -> dict[str, SobolIndices]:
        """The Sobol indices of each quantity; none without Saltelli's design, or where a sample has no value."""
        if self.table.method != "saltelli":
            return {}
        whole = [name for name in self._figures if np.isfinite(self.values(name)).all()]
        return {name: self.sobol_indices(name) for name in whole}

    @cached_property
    def _correlations(self) -> dict[str, list[float]]:
        """Rank correlations of the first quantities with several random parameters."""
        samples = self.samples
        if len(samples.variations) < 2 or not samples.is_random or self._sobol:
            return {}
        columns = [self.parameter(name) for name in samples.variations]
        return {name: rank_correlations(columns, self.values(name)) for name in self._figures[:MOST_MATTERING]}

    def _notices(self, strict: bool) -> tuple[Notice, ...]:
        """Notices on samples without an answer, and on invalid intervals."""
        notices = []
        if self.samples.is_random and self.table.method in ("sobol", "latin hypercube"):
            text = (
                f"the intervals are those of independent samples; those of a {self.table.method} design are narrower in most cases"
            )
            notices.append(Notice(NoticeKind.ACCURACY, text))
        if damaged := self.chunks.damaged:
            numbers = ", ".join(map(str, damaged[:MOST_DAMAGED])) + (" ..." if len(damaged) > MOST_DAMAGED else "")
            text = f"{counted(len(damaged), 'chunk')} of the store ({numbers}) {'was' if len(damaged) == 1 else 'were'} damaged, and computed again"
            notices.append(Notice(NoticeKind.OMITTED, text))
        if failed := len(self.failures):
            text = f"{failed} of {counted(len(self), 'sample')} have no answer; statistics are those of the others"
            notices.append(Notice(NoticeKind.OMITTED, text, doubtful=strict))
        return (*self.scene.notices, *notices)

    def answer(self, strict: bool = False) -> Answer:
        """Return statistics, sensitivities and reasons as an ``Answer``, whose CSV file has the samples.

        Args:
            strict: whether it is not to be trusted where a sample has no answer.

        Returns:
            The answer, to be printed or written.
        """
        samples, scene = self.samples, self.scene
        data = {
            "title": scene.title,
            "samples": len(self),
            "answered": int(self.answered.sum()),
            "method": self.table.method if samples.random else "given values",
            "seed": self.table.seed,
            "parameters": {name: one.to_dict() for name, one in samples.variations.items()},
            "figures": {
                name: {"unit": self.figures[name].unit, **_summary_data(self.statistics(name), samples.is_random)}
                for name in self._figures
            },
            "limits": {
                name: {"limit": limit, **_estimate_data(self.exceedance(name, limit))} for name, limit in self.limits.items()
            },
            "sobol_indices": {
                name: {
                    parameter: {"first": _estimate_data(a), "total": _estimate_data(b)}
                    for parameter, a, b in zip(samples.variations, one.first, one.total)
                }
                for name, one in self._sobol.items()
            },
            "rank_correlations": {name: dict(zip(samples.variations, ranks)) for name, ranks in self._correlations.items()},
            "failures": [
                {"sample": place, "reason": reason, "values": samples.rows(slice(place, place + 1))[0]}
                for place, reason in self.failures.items()
            ],
        }
        return ParameterSweep.of(
            scene,
            title=f"{scene.title}: {counted(len(self), 'sample')}",
            facts=self._facts,
            machine=machine(),
            tables=self._tables(),
            notices=self._notices(strict),
            data=data,
            plots=self._plots,
            columns=lambda: {"": self._columns()},
            on_page=self._animated,
            most_rows=None,
        )

    def _parameters(self) -> TextTable:
        shown = self.scene.equations.coordinates.shown
        rows = tuple((name, _described(one, shown, name)) for name, one in self.samples.variations.items())
        return TextTable("Parameters", ("parameter", "varied"), rows)

    def _statistics(self) -> TextTable:
        if not self.samples.is_random:
            return self._extremes()
        rows = []
        for name in self._figures:
            unit, factor = self._units[name]
            of = self.statistics(name)
            quantiles = [estimate_text(of.quantiles[p], factor) if of.quantiles else "–" for p in QUANTILES]
            title = f"{name} ({unit})" if unit not in ("", "1") else name
            rows.append((title, number_text(factor * of.mean), number_text(factor * of.deviation), *quantiles))
        note = "In parentheses: intervals that contain the quantile with a probability of 95 %."
        columns = ("figure", "mean", "standard deviation", "5 %", "median", "95 %")
        return TextTable("Statistics", columns, tuple(rows), note)

    def _extremes(self) -> TextTable:
        rows = []
        for name in self._figures:
            values = self.values(name)
            ends = int(np.nanargmin(values)), int(np.nanargmax(values))
            rows.append((name, *(f"{self._text(name, values[at])} at {self._place(at)}" for at in ends)))
        return TextTable("Least and largest values", ("figure", "least", "largest"), tuple(rows))

    def _values(self, sample: int) -> tuple[tuple[str, str], ...]:
        """The parameters of a sample as texts."""
        shown = self.scene.equations.coordinates.shown
        row, texts = self.samples.rows(slice(sample, sample + 1))[0], []
        for name, value in row.items():
            unit, factor = shown.of(getattr(self.samples.variations[name], "unit", ""), name)
            texts.append((name, value if isinstance(value, str) else with_unit(factor * value, unit)))
        return tuple(texts)

    def _place(self, sample: int) -> str:
        return ", ".join(f"{name} = {text}" for name, text in self._values(sample))

    def _limits(self) -> TextTable:
        rows = []
        for name, limit in self.limits.items():
            estimate = self.exceedance(name, limit)
            text = f"{100 * estimate.value:.4g} % ({100 * estimate.low:.3g} to {100 * estimate.high:.3g} %)"
            rows.append((name, self._text(name, limit), text))
        return TextTable("Probabilities of exceeding limits", ("figure", "limit", "probability"), tuple(rows))

    def _sobol_table(self) -> TextTable:
        rows = [
            (figure, name, estimate_text(first), estimate_text(total))
            for figure, indices in self._sobol.items()
            for name, first, total in zip(self.samples.variations, indices.first, indices.total)
        ]
        return TextTable("Sobol indices", ("figure", "parameter", "alone", "with the others"), tuple(rows))

    def _failures(self) -> TextTable:
        failures = list(self.failures.items())
        rows = tuple((self._place(place), reason) for place, reason in failures[:MOST_FAILURES])
        note = f"and {len(failures) - MOST_FAILURES} more, which the CSV file has" if len(failures) > MOST_FAILURES else ""
        return TextTable("Samples without an answer", ("sample", "reason"), rows, note)


class StudyInterrupted(KeyboardInterrupt):
    """A study that the user interrupted; the text explains how to resume it."""


def _with_advice(problem: BaseException, done: int, chunks: Chunks) -> BaseException:
    """The problem, with the stored part and how to resume."""
    stored = f"{done} of {chunks.count} chunks are stored; the same command goes on from there"
    text = stored if isinstance(chunks, Store) else "nothing is stored; give a store to be able to go on"
    if isinstance(problem, KeyboardInterrupt):
        return StudyInterrupted(f"interrupted: {text}")
    return type(problem)(f"{problem}; {text}")


def sweep(scene: Scene, parameters: Mapping[str, Any] | None = None, **options) -> Sweep:
    """The study of a scene (``Scene.sweep``)."""
    study, _ = study_of(scene, parameters, options)
    if limits_of(study.table.limits, figures_of(study.variables)) and not study.samples.is_random:
        raise InputError(ONLY_RANDOM)
    return study


def study_of(scene: Scene, parameters: Mapping[str, Any] | None, options: Mapping[str, Any]) -> tuple[Sweep, Scene]:
    """The study of a scene, and the scene of its middle sample."""
    if not isinstance(parameters or {}, Mapping):
        raise InputError(f'parameters: found {parameters!r}; expected ranges by name, such as {{"k": "1..3 N/mm:50"}}')
    own = scene.table.vary
    given = {} if own is None else {name: getattr(own, name) for name in own.model_fields_set}
    table = validated({**given, **options, "parameters": {**given.get("parameters", {}), **(parameters or {})}}, "vary", VaryTable)
    samples = ParameterSamples(table.parameters, table)
    data, name = read_tables(scene.path)
    data.pop("vary", None)
    settings = {setting.name: setting.value for setting in scene.settings}
    job = Job(str(scene.path), data, dict(name.origins), settings, (), scene.data_folders)
    middle = _middle(job, scene, samples)
    variables = variables_of(table.keep, middle)
    limits: dict[str, Any] = {}
    for name, limit in table.limits.items():
        with named("limits"):
            figure = figure_of(name, figures_of(variables), middle)
        limits[figure.name] = limit
        variables = tuple(dict.fromkeys((*variables, figure.variable)))
    table = table.model_copy(update={"limits": limits})
    job = replace(job, variables=variables)
    return Sweep(scene, samples, job.variables, job, table), middle


def _middle(job: Job, scene: Scene, samples: ParameterSamples) -> Scene:
    """The scene of the middle sample, by which units and uses of the parameters are checked."""
    for name in samples.variations:
        if name in job.settings:
            raise InputError(f'"{name}" is set and varied; do one of them')
    try:
        middle = job.scene({name: _with_unit(one) for name, one in samples.variations.items()})
    except SceneError:
        for name, variation in samples.variations.items():
            _check_unit(job, name, variation)
        middle = job.scene(samples.nominal)
    if middle.equations.system is not None:
        middle.equations.system._refuse_delays("sweep")
    middle.equations.polynomial_matrix.jordan_pairs()  # a motion is determined
    for name in samples.variations:
        if name in middle.parameters.unused:
            used = [other for other in scene.parameters.values if other not in middle.parameters.unused]
            raise InputError(
                f'nothing in the scene uses the parameter "{name}"; vary one that is used{nearest(name, used)}: {", ".join(used)}'
            )
    return middle


def _with_unit(variation: Variation) -> Any:
    """The middle value, with its unit where it has one."""
    value, unit = variation.nominal, variation.unit
    is_text = isinstance(variation, Values) and variation.is_text
    return f"{value!r} {unit}" if not is_text and unit and unit != "1" else value


def _check_unit(job: Job, name: str, variation: Variation) -> None:
    """Check that the scene accepts a value with the unit of the variation."""
    if isinstance(variation, Values) and variation.is_text:
        return
    try:
        job.scene({name: _with_unit(variation)})
    except SceneError as problem:
        raise SceneError(f"{shown(name)} cannot be varied: {str(problem).replace('--set: ', '')}") from None


class SweepSettings(VaryTable):
    """Varied parameters and kept quantities of the samples, and who computes them."""

    store: Text | None = Field(None, description="Keep the samples in this Zarr store, and go on from there.")
    workers: int | None = Field(None, ge=1, description="Compute in so many processes.")
    dask: Text | None = Field(None, description="Compute on the Dask cluster with this address of its scheduler.")
    sample_timeout: float | None = Field(None, ge=0, description="Give up a sample that takes longer, in s; it has no answer then.")
    strict: bool = Field(False, description="Leave with 3 if a sample has no answer.")


class ParameterSweep(Analysis):
    """Compute many samples of the parameters of a scene, those of its table [vary] and of --vary.

    Ranges with a number of values and lists are combined in a grid; distributions (normal, lognormal, uniform, or a range without a number)
    are sampled at each point of it. With --store an interrupted study goes on where it was, and with --workers or --dask others compute:
    the results have the same bits. Writes NAME.sweep.html, .png, .json and .csv."""

    name = "sweep"
    handles_choices = True
    switches = "all"
    settings = SweepSettings
    options: ClassVar = {
        "parameters": "--vary", "keep": "--keep", "limits": "--limit", "correlation": "--correlation", "minimise": None, "maximise": None,
        "chunk": None,
    }  # fmt: skip
    formats = ("page", "images", "json", "csv")
    progress = "chunks of samples"
    study = staticmethod(sweep)

    @classmethod
    def answer(cls, scene: Scene, progress: Progress | None = None, **given) -> Answer:
        """The answer of a scene with some settings in the place of those in [vary], and parameters in addition to them."""
        running: dict[str, Any] = {key: str(given.pop(key)) for key in ("store", "dask") if key in given}
        running |= {key: given.pop(key) for key in ("workers", "sample_timeout") if given.get(key)}
        strict = given.pop("strict", False)
        study = sweep(scene, given.pop("parameters", None), **given)
        result = study.run(**running, progress=progress, message=lambda text: print(text, file=sys.stderr, flush=True))
        return result.answer(strict)


def estimate_text(estimate: Estimate, factor: float = 1.0) -> str:
    """A number with its interval.

    >>> estimate_text(Estimate(1.0, 0.5, 2.0))
    '1 (0.5 to 2)'
    """
    value = number_text(factor * estimate.value)
    if np.isnan(estimate.low) or np.isnan(estimate.high) or estimate.low == estimate.high:
        return value
    return f"{value} ({factor * estimate.low:.4g} to {factor * estimate.high:.4g})"


def _described(one: Variation, shown, name: str) -> str:
    unit, factor = shown.of(one.unit, name)
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
    data = {"count": of.count, "infinite": of.infinite, "least": of.least, "largest": of.largest}
    if not random:
        return data
    quantiles = {f"{probability:g}": _estimate_data(one) for probability, one in of.quantiles.items()}
    return {**data, "mean": of.mean, "standard_deviation": of.deviation, "quantiles": quantiles}


def _estimate_data(one: Estimate) -> dict:
    return {"value": one.value, "interval": [one.low, one.high]}
