"""Optimisation of a scalar quantity of a scene over parameters between bounds.

A population of samples, which are solved together, finds the region (differential evolution, Storn and Price, Journal of Global
Optimization 11, 1997); the simplex of Nelder and Mead (The Computer Journal 7, 1965) refines its best sample. Neither needs derivatives:
a peak of a response that is least often has a kink there, where two peaks are equal. Both are SciPy's.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from ...ground.display import Displayed, TextTable, number_text, with_unit
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import SIMPLEX_SIZE
from ...page.content import Curve, Plot
from ...scene.schema.analysis_tables import VaryTable
from ...scene.schema.entry_types import Text
from ...scene.variations import Distribution
from ..base import Analysis, Answer
from ..timing import machine
from .evaluation import Job, evaluate
from .kept_quantities import SampleFigure, figure_of, figures_of
from .sweep import study_of

if TYPE_CHECKING:
    from ...scene.run.scene import Scene

#: Members of the population for each parameter, generations, and the spread of values relative to their mean at which they end.
MEMBERS, GENERATIONS, SPREAD = 12, 60, 1e-3

#: Evaluations of the simplex for each parameter.
SIMPLEX_STEPS = 400

#: Samples along each parameter through the optimum, and parameters that are plotted.
SLICE, MOST_SLICES = 41, 4

#: A value nearer to a bound than this share of the range is at it.
AT_BOUND = 1e-6

INTERRUPTED = "interrupted after {} samples: these are the best values until then, not those of a finished search"


@dataclass(frozen=True, repr=False, eq=False)
class Optimum(Displayed):
    """Optimum: the best sample.

    Attributes:
        scene: of the file.
        figure: the objective.
        sign: 1 for a minimum, -1 for a maximum.
        bounds: bounds of the parameters.
        parameters: the best values in SI.
        value: value of the figure there, in SI.
        before: of the figure in the file.
        evaluations: number of samples.
        history: the best value after each generation.
        interrupted: whether the search was interrupted, so that these are the best values until then.
        job: makes the scene of a sample.
    """

    scene: Scene
    figure: SampleFigure
    sign: int
    bounds: Mapping[str, Distribution]
    parameters: Mapping[str, float]
    value: float
    before: float
    evaluations: int
    history: tuple[float, ...]
    job: Job = field(repr=False)
    interrupted: bool = False

    def _summary(self) -> str:
        values = ", ".join(f"{name} = {number_text(value)}" for name, value in self.parameters.items())
        return f"{self.figure.name} {number_text(self.value)} at {values}"

    @property
    def at_bounds(self) -> dict[str, float]:
        """Parameters at an end of their range, with that end."""
        result = {}
        for name, one in self.bounds.items():
            low, high = one.ends
            for end in (low, high):
                if abs(self.parameters[name] - end) <= AT_BOUND * (high - low):
                    result[name] = end
        return result

    def answer(self) -> Answer:
        """The best values between their bounds, with the quantity around them."""
        scene, name = self.scene, self.figure.name
        shown = scene.equations.coordinates.shown
        unit, factor = self.figure.shown(shown)
        before, value = (with_unit(factor * each, unit) for each in (self.before, self.value))
        rows = []
        for parameter, one in self.bounds.items():
            own, scale = shown.of(one.unit)
            rows.append((parameter, *(with_unit(scale * each, own) for each in (self.parameters[parameter], *one.ends))))
        notices = (Notice(NoticeKind.ACCURACY, INTERRUPTED.format(self.evaluations), doubtful=True),) if self.interrupted else ()
        texts = [f"{parameter} is at its bound: a wider range may have a better value" for parameter in self.at_bounds]
        texts.append("the optimum is the best of all samples; that there is no better one far from them is not proved")
        data = {
            "title": scene.title,
            "figure": name,
            "unit": self.figure.unit,
            "sense": "minimum" if self.sign > 0 else "maximum",
            "value": self.value,
            "before": self.before,
            "parameters": dict(self.parameters),
            "bounds": {parameter: one.ends for parameter, one in self.bounds.items()},
            "at_bounds": self.at_bounds,
            "evaluations": self.evaluations,
            "history": self.history,
            "interrupted": self.interrupted,
        }
        return Optimisation.of(
            scene,
            title=f"{scene.title}: {name} {'minimised' if self.sign > 0 else 'maximised'}",
            facts=((name, f"{value}, instead of {before} in the file, by {self.evaluations} samples"),),
            machine=machine(),
            tables=(TextTable("Best values", ("parameter", "best", "from", "to"), tuple(rows)),),
            notices=(*scene.notices, *notices, *(Notice(NoticeKind.ACCURACY, text) for text in texts)),
            data=data,
            plots=lambda: _plots(self, unit, factor),
        )

    def along(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """The objective over one parameter, the others at their best values, shape (samples,) each."""
        values = np.linspace(*self.bounds[name].ends, SLICE)
        rows = [{**self.parameters, name: float(value)} for value in values]
        return values, self.figure.of(evaluate(self.job, rows))


def optimise(
    scene: Scene,
    parameters: Mapping[str, Any] | None = None,
    minimise: str | None = None,
    maximise: str | None = None,
    seed: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    message: Callable[[str], None] | None = None,
) -> Optimum:
    """Minimise or maximise a scalar quantity over values between bounds.

    Args:
        scene: the scene.
        parameters: ranges by name, in addition to those of [vary].
        minimise, maximise: name of the figure, one of both.
        seed: of the random numbers.
        progress: called with the number of generations that are done, and of all.
        message: called with the best values so far.

    Returns:
        The ``Optimum``; where the user interrupts the search, the best values so far.

    Raises:
        InputError: no range, no such figure, no sample with an answer.
    """
    given = {} if seed is None else {"seed": seed}
    table = scene.table.vary
    if minimise is None and maximise is None and table is not None:
        minimise, maximise = table.minimise, table.maximise
    if (minimise is None) == (maximise is None):
        raise InputError('give a figure to minimise, or one to maximise, e.g. --minimise "response peak"')
    study, middle = study_of(scene, parameters, {**given, "keep": None})
    bounds = {}
    for name, one in study.samples.variations.items():
        if not (isinstance(one, Distribution) and one.kind == "uniform"):
            raise InputError(f'"{name}": an optimum needs a range without a number of values, e.g. "1..3 N/mm"')
        bounds[name] = one
    figure = _figure(minimise or maximise, middle, study.variables)
    job = replace(study.job, variables=(figure.variable,))
    search = _Search(scene, job, figure, -1 if maximise else 1, bounds)
    before = search.values([{}])[0] * search.sign
    is_interrupted = search.run(study.table.seed, progress, message)
    value, count, history = search.sign * search.value, search.count, tuple(search.history)
    return Optimum(scene, figure, search.sign, bounds, search.best, value, before, count, history, job, is_interrupted)


def _figure(name: str, middle: Scene, usual) -> SampleFigure:
    """The quantity of this name, among the default ones or separately."""
    if isinstance(name, str) and any(sign in name for sign in "^*+("):
        with suppress(InputError):
            return figure_of(name, figures_of(usual), middle)
        raise InputError(
            f'found "{name}"; expected the name of one figure, no formula. To fit measured values, sweep the parameters with '
            "keep = frequencies, or minimise your own sum with scipy.optimize.least_squares over scenes of read_scene(path, settings)"
        )
    return figure_of(name, figures_of(usual), middle)


class _Search:
    """The quantity as a function of the parameters."""

    def __init__(self, scene: Scene, job: Job, figure: SampleFigure, sign: int, bounds: Mapping[str, Distribution]):
        self.scene, self.job, self.figure, self.sign, self.bounds = scene, job, figure, sign, bounds
        self.count, self.value, self.reason = 0, np.inf, ""
        self.best: dict[str, float] = {}  # the parameters with the least value so far
        self.history: list[float] = []

    def values(self, rows: list[dict]) -> np.ndarray:
        """The objective for some samples, to be minimised; infinite without an answer."""
        answer = evaluate(self.job, rows)
        self.count += len(rows)
        self.reason = next((str(reason) for reason in answer["reason"] if reason), self.reason)
        values = self.sign * self.figure.of(answer)
        return np.where(np.isnan(values), np.inf, values)

    def text(self) -> str:
        """The best values so far."""
        shown = self.scene.equations.coordinates.shown
        of = [(name, *shown.of(self.bounds[name].unit, name)) for name in self.best]
        unit, factor = self.figure.shown(shown)
        at = ", ".join(f"{name} = {with_unit(scale * self.best[name], own)}" for name, own, scale in of)
        return f"{self.figure.name} {with_unit(factor * self.sign * self.value, unit)} at {at}"

    def at(self, points: np.ndarray) -> np.ndarray:
        """The objective at points of the unit cube, shape (d, S) or (d,)."""
        rows = (self.low + self.width * np.clip(np.atleast_2d(points.T), 0.0, 1.0)).tolist()
        samples = [dict(zip(self.bounds, row)) for row in rows]
        values = self.values(samples)
        if values[least := int(np.argmin(values))] < self.value:
            self.value, self.best = float(values[least]), samples[least]
        return values if points.ndim > 1 else values[0]

    def run(self, seed: int, progress, message) -> bool:
        """Search for the best parameters; whether the user interrupted it."""
        from scipy.optimize import differential_evolution, minimize

        ends = np.array([one.ends for one in self.bounds.values()])
        self.low, self.width = ends[:, 0], np.ptp(ends, axis=1)
        unit = [(0.0, 1.0)] * len(ends)

        def report(stage: str, number: int) -> None:
            if message and number & (number - 1) == 0:  # 1, 2, 4, …
                message(f"{stage} {number}: {self.text()}")

        def generation(intermediate_result) -> None:
            self.history.append(self.sign * float(intermediate_result.fun))
            report(f"generation (of at most {GENERATIONS})", len(self.history))
            if progress:
                progress(len(self.history), GENERATIONS)

        def step(x) -> None:
            steps.append(len(steps) + 1)
            report("step of the refinement", len(steps))

        steps: list[int] = []
        try:
            population = differential_evolution(
                self.at,
                unit,
                vectorized=True,
                updating="deferred",
                popsize=MEMBERS,
                maxiter=GENERATIONS,
                tol=SPREAD,
                init="sobol",
                polish=False,
                callback=generation,
                rng=np.random.default_rng(seed),
            )
            if not np.isfinite(population.fun):
                raise InputError(f"no sample between the bounds has an answer: {self.reason or 'the figure is not finite'}")
            options = {"xatol": SIMPLEX_SIZE, "fatol": SIMPLEX_SIZE * abs(population.fun), "maxfev": SIMPLEX_STEPS * len(unit)}
            minimize(self.at, population.x, method="Nelder-Mead", bounds=unit, options=options, callback=step)
        except KeyboardInterrupt:
            if not self.best:
                raise
            return True
        return False


class Ranges(VaryTable):
    """Ranges of parameters, and the figure that shall be least or largest."""

    parameters: dict[str, Any] = Field(
        {}, description='A range, by the name of a parameter or by place as for --set: "k=1..3 N/mm".'
    )
    minimise: Text | None = Field(None, description='The figure to make least, such as "response peak" or "largest x", as in keep.')
    maximise: Text | None = Field(None, description="The figure to make largest instead.")


class Optimisation(Analysis):
    """Find the values of parameters within ranges, those of the table [vary] and of --vary, that make a figure least or largest.

    A population of samples finds the region, a simplex refines the best of them. Ctrl-C ends the search with the best values so far.
    Writes NAME.optimise.html, .png and .json."""

    name = "optimise"
    handles_choices = True
    switches = "all"
    settings = Ranges
    options: ClassVar = {
        "parameters": "--vary", "method": None, "samples": None, "chunk": None
    }  # fmt: skip
    formats = ("page", "images", "json")
    progress = "generations"
    optimum = staticmethod(optimise)

    @classmethod
    def answer(cls, scene: Scene, progress: Callable | None = None, **given) -> Answer:
        """The answer of a scene with some settings in the place of those in [vary], and parameters in addition to them."""
        message = None if sys.stderr.isatty() else lambda text: print(text, file=sys.stderr, flush=True)
        return optimise(scene, given.pop("parameters", None), **given, progress=progress, message=message).answer()


def _plots(optimum: Optimum, unit: str, factor: float) -> Iterator[Plot]:
    """The quantity over each parameter, the others at their best values, and the best value of each generation."""
    name = optimum.figure.name
    for parameter in [] if optimum.interrupted else list(optimum.bounds)[:MOST_SLICES]:  # they take a while
        shown, scale = optimum.scene.equations.coordinates.shown.of(optimum.bounds[parameter].unit)
        values, own = optimum.along(parameter)
        if np.isfinite(own).all():
            curve = Curve(name, factor * own)
            yield Plot(
                f"{name} over {parameter}", unit, scale * values, (curve,), across_unit=shown, quantity=name, variable=parameter
            )
    if optimum.history:
        curve = Curve(name, factor * np.array(optimum.history))
        numbers = np.arange(1.0, len(optimum.history) + 1)
        yield Plot("best value of each generation", unit, numbers, (curve,), across_unit="", quantity=name, variable="generation")
