"""The study of a scene over many samples: checked at the start, computed in chunks by a backend, and stored."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...ground.checks import counted, nearest, real_number, whole_number
from ...ground.display import Displayed
from ...ground.errors import InputError, MbconstrainedError, SceneError, shown
from ...scene.file.includes import read_tables
from ...scene.quantities.variations import Values, Variation
from ...scene.schema.analyses.vary_table import VaryTable
from ...scene.schema.validation import validated
from ..timing import version_of
from .evaluation import Job
from .execution import by_dask, by_processes, hashes, in_process
from .kept_quantities import Variable, figures_of, limits_of, variables_of
from .sampling import ParameterSamples
from .store import Chunks, Memory, Store, variable_data
from .sweep_report import SweepResult
from .sweep_result import ONLY_RANDOM

if TYPE_CHECKING:
    from ...scene.run.scene import Scene

#: Samples of a chunk: as many as chunks, within these limits, so that a worker has some, and an interruption costs little.
LEAST_CHUNK, MOST_CHUNK, USUAL_CHUNKS = 8, 256, 64

MOST_WORKERS = 1024

#: The size of a study of so many samples is reported before it begins.
LARGE = 100_000

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

    @property
    def chunk(self) -> int:
        """Number of samples computed and stored together, which depends on the number of samples alone."""
        return self.table.chunk or min(max(len(self.samples) // USUAL_CHUNKS, LEAST_CHUNK), MOST_CHUNK)

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
            "parameters": {name: one.as_data() for name, one in self.samples.variations.items()},
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
    own = scene.table.vary
    given = {} if own is None else {name: getattr(own, name) for name in own.model_fields_set}
    table = validated({**given, **options, "parameters": {**given.get("parameters", {}), **(parameters or {})}}, "vary", VaryTable)
    samples = ParameterSamples(table.parameters, table)
    data, name = read_tables(scene.path)
    data.pop("vary", None)
    settings = {setting.name: setting.value for setting in scene.settings}
    job = Job(str(scene.path), data, dict(name.origins), settings, ())
    middle = _middle(job, scene, samples)
    job = replace(job, variables=variables_of(table.keep, middle))
    return Sweep(scene, samples, job.variables, job, table), middle


def _middle(job: Job, scene: Scene, samples: ParameterSamples) -> Scene:
    """The scene of the middle sample, by which units and uses of the parameters are checked."""
    for name, variation in samples.variations.items():
        if name in job.settings:
            raise InputError(f'"{name}" is set and varied; do one of them')
        _check_unit(job, name, variation)
    middle = job.scene(samples.nominal)
    middle.equations.polynomial_matrix.jordan_pairs()  # a motion is determined
    for name in samples.variations:
        if name in middle.parameters.unused:
            used = [other for other in scene.parameters.values if other not in middle.parameters.unused]
            raise InputError(
                f'nothing in the scene uses the parameter "{name}"; vary one that is used{nearest(name, used)}: {", ".join(used)}'
            )
    return middle


def _check_unit(job: Job, name: str, variation: Variation) -> None:
    """Check that the scene accepts a value with the unit of the variation."""
    value, unit = variation.nominal, variation.unit
    if isinstance(variation, Values) and variation.is_text:
        return
    try:
        job.scene({name: f"{value!r} {unit}" if unit and unit != "1" else value})
    except SceneError as problem:
        raise SceneError(f"{shown(name)} cannot be varied: {str(problem).replace('--set: ', '')}") from None
