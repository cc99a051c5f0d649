"""Optimisation of a scalar quantity of a scene over parameters between bounds.

A population of samples, which are solved together, finds the region (differential evolution, Storn and Price, Journal of Global
Optimization 11, 1997); the simplex of Nelder and Mead (The Computer Journal 7, 1965) refines its best sample. Neither needs derivatives:
a peak of a response that is least often has a kink there, where two peaks are equal. Both are SciPy's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...ground.checks import nearest
from ...ground.display import Displayed, TextTable, finite_or_none, number_text, with_unit
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import SIMPLEX_SIZE
from ...page.animation.figure import PALETTE
from ...page.plots.images import MUTED
from ...scene.quantities.variations import Distribution
from ...scene.run.report.summary import notices_json
from ..figures import Picture
from ..study_report import StudyReport
from ..timing import machine
from .evaluation import Job, evaluate
from .kept_quantities import SampleFigure, figures_of, variables_of
from .sweep import study_of
from .sweep_pictures import titled

if TYPE_CHECKING:
    from ...scene.run.scene import Scene

#: Members of the population for each parameter, generations, and the spread of values relative to their mean at which they end.
MEMBERS, GENERATIONS, SPREAD = 12, 60, 1e-3

#: Evaluations of the simplex for each parameter.
SIMPLEX_STEPS = 400

#: Samples along each parameter through the optimum, for the picture.
SLICE = 41

#: A value nearer to a bound than this share of the range is at it.
AT_BOUND = 1e-6


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
) -> Optimum:
    """Minimise or maximise a scalar quantity over values between bounds."""
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
    search = _Search(job, figure, -1 if maximise else 1, list(bounds))
    before = search.values([{}])[0] * search.sign
    best, value, history = search.run([one.ends for one in bounds.values()], study.table.seed, progress)
    values = dict(zip(bounds, map(float, best)))
    return Optimum(scene, figure, search.sign, bounds, values, search.sign * value, before, search.count, history, job)


def _figure(name: str, middle: Scene, usual) -> SampleFigure:
    """The quantity of this name, among the default ones or separately."""
    figures = figures_of(usual)
    if name not in figures:
        try:
            figures |= figures_of(variables_of([name], middle))
        except InputError:
            if isinstance(name, str) and any(sign in name for sign in "^*+("):
                raise InputError(
                    f'found "{name}"; expected the name of one figure, no formula. To fit measured values, sweep the parameters with '
                    "keep = frequencies, or minimise your own sum with scipy.optimize.least_squares over scenes of read_scene(path, settings)"
                ) from None
            hint = nearest(name, figures)
            raise InputError(
                f'there is no figure "{name}"{hint}; there are {", ".join(list(figures)[:20])}, or "largest x", "x at 2 s" …'
            ) from None
    if name not in figures:
        raise InputError(f'"{name}" is several numbers; name one of {", ".join(list(figures)[:20])}')
    return figures[name]


class _Search:
    """The quantity as a function of the parameters."""

    def __init__(self, job: Job, figure: SampleFigure, sign: int, names: list[str]):
        self.job, self.figure, self.sign, self.names = job, figure, sign, names
        self.count = 0
        self.reason = ""

    def values(self, rows: list[dict]) -> np.ndarray:
        """The objective for some samples, to be minimised; infinite without an answer."""
        self.count += len(rows)
        answer = evaluate(self.job, rows)
        self.reason = next((str(reason) for reason in answer["reason"] if reason), self.reason)
        values = self.sign * self.figure.of(answer)
        return np.where(np.isnan(values), np.inf, values)

    def at(self, points: np.ndarray) -> np.ndarray:
        """The objective at points of the unit cube, shape (d, S) or (d,)."""
        rows = (self.low + self.width * np.clip(np.atleast_2d(points.T), 0.0, 1.0)).tolist()
        values = self.values([dict(zip(self.names, row)) for row in rows])
        return values if points.ndim > 1 else values[0]

    def run(self, bounds, seed: int, progress) -> tuple[np.ndarray, float, tuple[float, ...]]:
        """The best parameters, their value, and the best value after each generation."""
        from scipy.optimize import differential_evolution, minimize

        ends = np.array(bounds)
        self.low, self.width = ends[:, 0], np.ptp(ends, axis=1)
        unit, history = [(0.0, 1.0)] * len(ends), []

        def generation(intermediate_result) -> None:
            history.append(self.sign * float(intermediate_result.fun))
            if progress:
                progress(len(history), GENERATIONS)

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
            **_random_state(seed),
        )
        if not np.isfinite(population.fun):
            raise InputError(f"no sample between the bounds has an answer: {self.reason or 'the figure is not finite'}")
        options = {"xatol": SIMPLEX_SIZE, "fatol": SIMPLEX_SIZE * abs(population.fun), "maxfev": SIMPLEX_STEPS * len(unit)}
        refined = minimize(self.at, population.x, method="Nelder-Mead", bounds=unit, options=options)
        best = refined if refined.fun <= population.fun else population
        return self.low + self.width * best.x, float(best.fun), tuple(history)


def _random_state(seed: int) -> dict[str, Any]:
    """The argument of SciPy for random numbers, whose name has changed."""
    from inspect import signature

    from scipy.optimize import differential_evolution

    name = "rng" if "rng" in signature(differential_evolution).parameters else "seed"
    return {name: np.random.default_rng(seed)}


class OptimumReport(StudyReport):
    """The report of an optimum.

    Attributes:
        optimum: the best sample.
    """

    def __init__(self, optimum: Optimum):
        self.optimum = optimum
        self.machine = machine()

    @property
    def heading(self) -> str:
        """Title of the scene and the quantity."""
        verb = "minimised" if self.optimum.sign > 0 else "maximised"
        return f"{self.optimum.scene.title}: {self.optimum.figure.name} {verb}"

    @cached_property
    def unit(self) -> tuple[str, float]:
        """Unit of the quantity, as [output] requests, with its factor."""
        unit = self.optimum.figure.unit
        return self.optimum.scene.equations.coordinates.shown.of(unit) if " or " not in unit else (unit, 1.0)

    @property
    def sentences(self) -> tuple[str, ...]:
        """The optimum as sentences."""
        unit, factor = self.unit
        before, value = (with_unit(factor * each, unit) for each in (self.optimum.before, self.optimum.value))
        return (f"{self.optimum.figure.name}: {value}, instead of {before} in the file, by {self.optimum.evaluations} samples.",)

    @property
    def tables(self) -> tuple[TextTable, ...]:
        """The best values between their bounds."""
        shown, rows = self.optimum.scene.equations.coordinates.shown, []
        for name, one in self.optimum.bounds.items():
            unit, factor = shown.of(one.unit)
            values = (self.optimum.parameters[name], *one.ends)
            rows.append((name, *(with_unit(factor * value, unit) for value in values)))
        return (TextTable("Best values", ("parameter", "best", "from", "to"), tuple(rows)),)

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on values at bounds, and on the optimum as the best of samples."""
        optimum = self.optimum
        texts = [f"{name} is at its bound: a wider range may have a better value" for name in optimum.at_bounds]
        texts.append("the optimum is the best of all samples; that there is no better one far from them is not proved")
        return (*optimum.scene.notices, *(Notice(NoticeKind.ACCURACY, text) for text in texts))

    @property
    def is_trusted(self) -> bool:
        """True: unproved results are reported as such."""
        return True

    def pictures(self) -> list[Picture]:
        """The quantity over each parameter through the optimum, and the best value of each generation."""
        optimum, (unit, factor) = self.optimum, self.unit
        slices = {name: optimum.along(name) for name in list(optimum.bounds)[:4]}
        title = titled(optimum.figure.name, unit)

        def draw(figure) -> None:
            row = figure.subplots(1, len(slices), squeeze=False, sharey=True)[0]
            for axes, (name, (values, own)) in zip(row, slices.items()):
                shown, scale = optimum.scene.equations.coordinates.shown.of(optimum.bounds[name].unit)
                axes.plot(scale * values, factor * own, color=PALETTE[0])
                axes.axvline(scale * optimum.parameters[name], color=MUTED, linewidth=0.9, linestyle="--")
                axes.set_xlabel(titled(name, shown))
            row[0].set_ylabel(title)

        def draw_history(figure) -> None:
            axes = figure.add_subplot()
            axes.plot(
                np.arange(1, len(optimum.history) + 1),
                factor * np.array(optimum.history),
                color=PALETTE[0],
                marker="o",
                markersize=3,
            )
            axes.set(xlabel="generation", ylabel=title)

        note = "Each over one parameter, the others at their best values; dashed: the best value."
        pictures = [Picture("Around the optimum", f"{optimum.figure.name} over {', '.join(slices)}", 2.6, draw, note)]
        if optimum.history:
            pictures.append(Picture("Best value of each generation", f"{optimum.figure.name} over generations", 2.2, draw_history))
        return pictures

    def as_json(self) -> dict:
        optimum = self.optimum
        return {
            "title": optimum.scene.title,
            "figure": optimum.figure.name,
            "unit": optimum.figure.unit,
            "sense": "minimum" if optimum.sign > 0 else "maximum",
            "value": optimum.value,
            "before": finite_or_none(optimum.before),
            "parameters": dict(optimum.parameters),
            "bounds": {name: list(one.ends) for name, one in optimum.bounds.items()},
            "at_bounds": optimum.at_bounds,
            "evaluations": optimum.evaluations,
            "history": list(optimum.history),
            "notices": notices_json(self.notices),
        }
