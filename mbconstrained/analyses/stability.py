"""Numerical stability: correct, expected and claimed digits for the systems of the gallery, or for a scene scaled over decades.

The condition of the data is measured with exact arithmetic, condition = max |change of x| / (h max |x|) for data that are perturbed by h.
Float64 data, exact to half a unit in the last place, determine no more than -log10(condition eps) digits for any method.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import Field

from ..exact.enclosure.exact_response import ExactResponse
from ..exact.enclosure.exact_sources import ExactSource, S, Shape
from ..exact.rational import RationalMatrix, rational
from ..ground.checks import counted
from ..ground.display import TextTable
from ..ground.errors import MbconstrainedError, Overflow, SingularPolynomialMatrix
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import EPS, TRUST_LIMIT
from ..mechanics.constraints import with_multipliers
from ..mechanics.element_matrix import ElementMatrix
from ..page.content import Marks, Plot, Scale, curve_with_gaps
from ..polynomial.coefficients import Factors
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..response.estimate import LEAST
from ..scene.build.equations import equations_of
from ..scene.run.scene import Scene
from ..scene.schema.entry_types import Table, Text
from .base import Analysis, Answer
from .study_problem import StudyProblem, again, chosen_places, fractions_of, given_of, mechanical_problem, problem_of, values_of
from .timing import Progress, machine, no_progress

if TYPE_CHECKING:
    from ..response.response import Response
    from .gallery import System

#: A scene is scaled by factors from 10^-DECADES to 10^DECADES, in steps of so many decades.
DECADES, STEP = 8, 2

#: An answer with so many digits fewer than the data determine is reported.
SHORT = 0.5

#: Below the table of digits.
NOTE = (
    "right: correct digits by exact arithmetic, 16 at most; expected: digits that the condition of the data allows; claimed: by the "
    "error estimate. warned: the answer came with a warning; wrong: more than one digit fewer than claimed, without a warning. "
    "Redundant constraint rows that were left out of the answer are left out of the exact solution too."
)

#: Verdicts but "right", as they stand in sentences.
VERDICTS = {"warned": "came with a warning", "refused": "refused with a reason", "not judged": "not judged by exact arithmetic"}


class StabilitySettings(Table):
    """Systems of the gallery, or decades over which a scene is scaled."""

    systems: Text | None = Field(None, description="Only these systems of the gallery, as A,B.")
    decades: int = Field(DECADES, ge=1, le=16, description="Scale a scene by 10^-N to 10^N.")
    step: int = Field(STEP, ge=1, le=16, description="Decades from point to point.")


class Stability(Analysis):
    """Count the digits that are right, that the condition of the data allows, and that the error estimate claims.

    Without a scene this is done for the gallery of stiff and extreme systems; with one its masses, dampers, springs and its
    horizon are scaled over decades. Writes NAME.stability.html, .png and .json. The exit code is 3 if any answer was wrong without
    a warning."""

    name = "stability"
    handles_choices = True
    switches = "none"
    settings = StabilitySettings
    formats = ("page", "images", "json")
    progress = "steps"
    without_scene = ("systems",)

    @classmethod
    def solve(cls, scene: Scene, settings: StabilitySettings | None, progress: Progress = no_progress) -> Answer:
        table = settings or StabilitySettings()
        return scene_report(scene, table.decades, table.step, progress).answer(scene.name)

    @classmethod
    def answer_without_scene(cls, progress: Progress | None = None, systems: str = "", **_) -> Answer:
        from .gallery import GALLERY, system

        names = [name.strip() for name in systems.split(",") if name.strip()]
        return gallery_report([system(name) for name in names] or GALLERY, progress or no_progress).answer("gallery")


@dataclass(frozen=True)
class ScalingSweep:
    """Points over one parameter."""

    name: str  # name of the scaling factor, or of the system of the gallery
    title: str  # for headings
    theme: str  # chapter of the gallery
    difficulty: str  # of a system of the gallery, in a sentence
    source: str  # source of a system of the gallery
    parameter: str  # with its unit if it has one
    points: tuple[Point, ...]  # in the order of the parameter
    broken: tuple[str, ...] = ()  # declared properties of a system of the gallery that exact arithmetic does not confirm

    def count(self, verdict: str) -> int:
        """Number of points with a verdict: right, warned, refused, not judged or wrong."""
        return sum(point.verdict == verdict for point in self.points)

    @property
    def answers(self) -> tuple[Point, ...]:
        """The points whose answer was compared with exact arithmetic."""
        return tuple(point for point in self.points if point.right is not None)

    def to_dict(self) -> dict:
        texts = {name: value for name, value in asdict(replace(self, points=())).items() if isinstance(value, str)}
        return {**texts, "broken": list(self.broken), "points": [point.to_dict() for point in self.points]}


@dataclass(frozen=True)
class StabilityReport:
    """Correct digits over sweeps."""

    title: str  # title of the scene, or of the gallery
    sweeps: tuple[ScalingSweep, ...]  # one for each system of the gallery, or for each scaling factor of a scene
    machine: dict[str, str]  # processor, system and packages
    of_scene: bool  # whether a scene was scaled

    def count(self, verdict: str) -> int:
        """Number of points with a verdict: right, warned, refused, not judged or wrong."""
        return sum(sweep.count(verdict) for sweep in self.sweeps)

    @property
    def is_trusted(self) -> bool:
        """Whether no answer was wrong without a warning."""
        return not self.count("wrong")

    @property
    def sentences(self) -> tuple[str, ...]:
        """The result as sentences: trust, counts, the fewest digits, the answer furthest below what the data determine, properties."""
        return tuple(self._sentences())

    def _sentences(self) -> Iterator[str]:
        judged, wrong = sum(len(sweep.answers) for sweep in self.sweeps), self.count("wrong")
        answers = f"{wrong or 'None'} of {counted(judged, 'answer')} compared with exact arithmetic {'are' if wrong > 1 else 'is'}"
        yield f"{answers} wrong without a warning." if judged else "No answer was compared with exact arithmetic."
        counts = [f"{counted(self.count('right'), 'answer')} had the digits that the estimate claims"]
        counts += [f"{self.count(verdict)} {text}" for verdict, text in VERDICTS.items() if self.count(verdict)]
        yield f"{', '.join(counts)}."
        if silent := [(sweep, point) for sweep in self.sweeps for point in sweep.answers if point.verdict == "right"]:
            sweep, least = min(silent, key=lambda pair: pair[1].right)
            yield f"Fewest digits without a warning: {_digit_text(sweep, least)}."
            known = [(sweep, point) for sweep, point in silent if not math.isnan(point.expected)]
            sweep, short = max(known, key=lambda pair: pair[1].expected - pair[1].right, default=(sweep, least))
            if short.expected - short.right > SHORT:
                yield f"Furthest below what the data determine: {_digit_text(sweep, short)}."
        if broken := [promise for sweep in self.sweeps for promise in sweep.broken]:
            yield f"Not as declared: {'; '.join(broken)}."
        elif not self.of_scene:
            yield "The declared properties of the systems hold, by exact arithmetic."

    def answer(self, name: str) -> Answer:
        """Digits, the reasons of all verdicts but "right", and curves; of a scene those of all its factors together, too."""
        counts = {verdict: self.count(verdict) for verdict in ("right", "warned", "refused", "not judged", "wrong")}
        data = {
            "title": self.title,
            "verdict": self.sentences,
            "counts": counts,
            "machine": self.machine,
            "sweeps": [sweep.to_dict() for sweep in self.sweeps],
        }
        notice = Notice(NoticeKind.ACCURACY, " ".join(self.sentences), doubtful=not self.is_trusted)
        tables = (digit_table(self), *reason_tables(self), *(() if self.of_scene else (gallery_table(self),)))
        return Answer(
            kind="stability",
            name=name,
            title=f"Numerical stability: {self.title}",
            source="",
            facts=(),
            machine=self.machine,
            tables=tables,
            notices=(notice,),
            data=data,
            plots=lambda: (*(overview_plot(self.sweeps) if self.of_scene else ()), *digit_plots(self.sweeps)),
            most_rows=None,
        )


def gallery_report(systems: Sequence[System], progress: Progress = no_progress) -> StabilityReport:
    sweeps = [_of_system(system, progress) for system in systems]
    return StabilityReport("Gallery of stiff and extreme systems", tuple(sweeps), machine(), of_scene=False)


def _of_system(system: System, progress: Progress) -> ScalingSweep:
    from .gallery import broken_promises

    points = points_of(system.build, system.values, lambda text: progress(f"{system.title}: {text}"))
    broken = [sentence for value in system.values for sentence in broken_promises(system, value)]
    texts = (system.name, system.title, system.theme, system.difficulty, system.source, system.parameter)
    return ScalingSweep(*texts, points, tuple(broken))


def scene_report(scene: Scene, decades: int = DECADES, step: int = STEP, progress: Progress = no_progress) -> StabilityReport:
    """Scale the parameters of a scene, and its horizon, over decades."""
    up = [*range(step, decades, step), decades]
    factors = [float(f"1e{exponent}") for exponent in (*(-power for power in reversed(up)), 0, *up)]
    sweeps = []
    for name, scaled in scaling_factors(scene).items():
        points = points_of(scaled, factors, lambda text, name=name: progress(f"{name} times {text}"))
        sweeps.append(ScalingSweep(name, name, "", "", "", f"factor on {name}", points))
    return StabilityReport(scene.heading, tuple(sweeps), machine(), of_scene=True)


def _digit_text(sweep: ScalingSweep, point: Point) -> str:
    """The digits of a point and its parameter."""
    expected = "" if math.isnan(point.expected) else f", {point.expected:.1f} determined by the data"
    place = f"{sweep.title}, {sweep.parameter} = {point.parameter:.3g}"
    return f"{point.right:.1f} right, {point.claimed:.1f} claimed{expected} ({place})"


def digit_table(report: StabilityReport) -> TextTable:
    """A row for each sweep, in the gallery by theme."""
    columns = ("from … to", "points", "right", "warned", "refused", "wrong", "fewest digits", "expected", "claimed")
    rows, theme = [], ""
    for sweep in report.sweeps:
        named = (sweep.title,) if report.of_scene else (sweep.theme if sweep.theme != theme else "", sweep.name)
        theme = sweep.theme
        counts = [str(sweep.count(verdict) or "–") for verdict in ("right", "warned", "refused", "wrong")]
        least = min(sweep.answers, key=lambda point: point.right, default=None)
        digits = (math.nan,) * 3 if least is None else (least.right, least.expected, least.claimed)
        texts = ("–" if math.isnan(value) else f"{value:.1f}" for value in digits)
        span = f"{sweep.points[0].parameter:.3g} … {sweep.points[-1].parameter:.3g}"
        rows.append((*named, span, str(len(sweep.points)), *counts, *texts))
    head = ("parameter",) if report.of_scene else ("theme", "system")
    return TextTable("Digits", (*head, *columns), tuple(rows), NOTE)


def reason_tables(report: StabilityReport) -> list[TextTable]:
    """Wrong answers, warnings and refusals with their reasons; equal reasons share a row."""
    titles = {"wrong": "Wrong without a warning", "warned": "Warnings", "refused": "Refused", "not judged": "Not judged"}
    rows_of = [(title, _reason_rows(report, verdict)) for verdict, title in titles.items()]
    return [TextTable(title, ("parameter", "at", "reason"), rows) for title, rows in rows_of if rows]


def _reason_rows(report: StabilityReport, verdict: str) -> tuple[tuple[str, str, str], ...]:
    rows: dict[tuple[str, str], list[str]] = {}
    for sweep in report.sweeps:
        for point in sweep.points:
            if point.verdict == verdict:
                rows.setdefault((sweep.name, _short(point)), []).append(f"{point.parameter:.3g}")
    return tuple((name, ", ".join(parameters), reason) for (name, reason), parameters in rows.items())


def _short(point: Point) -> str:
    """Short reason; for several warnings the first, without its numbers, which are in the data."""
    return point.warnings[0].partition(":")[0] if point.verdict == "warned" else point.reason


def gallery_table(report: StabilityReport) -> TextTable:
    rows = tuple((sweep.name, sweep.title, sweep.parameter, sweep.difficulty, sweep.source) for sweep in report.sweeps)
    return TextTable("The systems", ("system", "title", "parameter", "difficulty", "source"), rows, folded=True)


# --- one problem: digits, condition and warnings

Verdict = Literal["right", "warned", "wrong", "refused", "not judged"]

#: Largest ratio of the error to the claimed error of an answer that is right.
LARGEST_RATIO = 10.0

#: Time limit of exact arithmetic for the solution, and again for the condition, s.
SECONDS = 30.0

#: Digits of the exact solution: twice those of float64.
DIGITS = 32

#: Most digits of float64: of an answer that is right to the last bit, and of an answer from rounded data.
MOST_DIGITS, MOST_EXPECTED = 16.0, -math.log10(EPS / 2)

#: Errors are relative to at least the smallest normal number, below which float64 has no relative precision.
SMALLEST = Fraction(float(np.finfo(float).tiny))


@dataclass(frozen=True)
class Point:
    """Point of a sweep."""

    parameter: float  # parameter of the sweep
    #: max |error| / max |x| at the times of the problem by exact arithmetic; None where refused or not known
    error: float | None = None
    estimate: float | None = None  # the error estimate; None where refused
    condition: float | None = None  # condition number of the data; None where not known
    warnings: tuple[str, ...] = ()  # the reasons for exit code 3 of ``mbconstrained run``
    refused: str = ""  # the text of the error in place of an answer
    notices: tuple[str, ...] = ()  # other notices of the answer
    unknown: str = ""  # the reason where error or condition are not known

    @property
    def right(self) -> float | None:
        """Correct digits, between 0 and 16."""
        return _digits(self.error)

    @property
    def claimed(self) -> float | None:
        """Digits according to the error estimate, between 0 and 16."""
        return _digits(self.estimate)

    @property
    def expected(self) -> float:
        """Digits that float64 data determine, -log10(condition eps), between 0 and 15.95; NaN where not known."""
        return math.nan if self.condition is None else min(_digits(self.condition * EPS), MOST_EXPECTED)

    @property
    def verdict(self) -> Verdict:
        """Refused, warned, or wrong without a warning where the error exceeds ten times the estimate.

        Both are at least eight rounding errors. Not judged where the exact solution is not known.
        """
        if self.refused or self.warnings:
            return "refused" if self.refused else "warned"
        if self.error is None:
            return "not judged"
        return "right" if max(self.error, LEAST) <= LARGEST_RATIO * max(self.estimate, LEAST) else "wrong"

    @property
    def reason(self) -> str:
        """The reason of the verdict; empty for "right"."""
        if self.verdict == "wrong":
            return f"only {self.right:.1f} digits are right, the estimate claims {self.claimed:.1f}, without a warning"
        return {"refused": self.refused, "warned": "; ".join(self.warnings), "not judged": self.unknown}.get(self.verdict, "")

    def to_dict(self) -> dict:
        derived = {name: getattr(self, name) for name in ("right", "expected", "claimed", "verdict")}
        data = {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()} | derived
        return {name: None if isinstance(value, float) and not math.isfinite(value) else value for name, value in data.items()}


def points_of(
    build: Callable[[float], StudyProblem],
    parameters: Sequence[float],
    progress: Progress = no_progress,
    variations: int | None = None,
) -> tuple[Point, ...]:
    """A point for each parameter; refused where no problem exists."""
    points = []
    for parameter in parameters:
        progress(f"{parameter:.3g}")
        try:
            points.append(point_of(build(parameter), parameter, variations))
        except MbconstrainedError as reason:
            points.append(Point(parameter, refused=str(reason)))
    return tuple(points)


def point_of(problem: StudyProblem, parameter: float = 0.0, variations: int | None = None, seconds: float = SECONDS) -> Point:
    """Solve a problem and compare the answer with exact arithmetic.

    >>> from mbconstrained.analyses.study_problem import mechanical_problem
    >>> from mbconstrained import MechanicalSystem
    >>> point = point_of(mechanical_problem("spring", MechanicalSystem([[1.0]], stiffness=[[4.0]]), [1.0, 2.0], [1.0]))
    >>> point.verdict, point.right > 15, point.expected > 14, point.warnings
    ('right', True, True, ())
    """
    from ..scene.run.stages import too_large_to_certify

    try:
        response = problem.solve()
        values, estimate = response(problem.times), response.error_estimate(problem.times)
    except MbconstrainedError as reason:
        return Point(parameter, refused=str(reason))
    error, why = _within(seconds, lambda: _error(problem, response, values), too_large_to_certify(problem))
    draws = DRAWS if variations is None else variations
    condition, why_not = _within(seconds, lambda: (condition_of(problem, response.exact, draws) if draws else None, ""), why)
    warnings = [notice.text for notice in response.notices if notice.doubtful]
    if not estimate <= TRUST_LIMIT:
        warnings.append(f"the estimated relative error is {estimate:.2g}: the data do not determine the answer well enough")
    notices = tuple(notice.text for notice in response.notices if not notice.doubtful)
    return Point(parameter, error, estimate, condition, tuple(warnings), notices=notices, unknown=why or why_not)


def _error(problem: StudyProblem, response: Response, answer: np.ndarray) -> tuple[float | None, str]:
    """max |error| / max |x|: infinite where values are not finite, or where the exact data determine no motion.

    Not known where the answer treats as rounding errors what the exact data contain: they describe another motion.
    """
    from ..exact.enclosure.exact_response import structure_notices

    if not np.isfinite(answer).all():
        return math.inf, ""
    try:
        exact = response.exact
    except SingularPolynomialMatrix:
        return math.inf, ""
    if other := structure_notices(response.solution.finite_count, exact):
        return None, other[0].text
    solution = values_of(exact.enclose(problem.times, DIGITS))
    values = fractions_of(answer)
    largest = np.abs(solution).max(initial=SMALLEST)
    return float(np.abs(values - solution).max(initial=Fraction(0)) / largest), ""


def _within(seconds: float, work, reason: str = "") -> tuple[float | None, str]:
    """The result of the work within a time limit; else None and the reason."""
    from ..scene.run.plan import OutOfTime, time_limit

    if reason:
        return None, reason
    try:
        with time_limit(seconds):
            return work()
    except OutOfTime:
        return None, f"exact arithmetic took more than {seconds:g} s"
    except (Overflow, SingularPolynomialMatrix) as problem:  # beyond 1e100000; singular
        return None, f"exact arithmetic: {problem}"


def _digits(error: float | None) -> float | None:
    """-log10 of an error, between 0 and 16; None without an error."""
    if error is None:
        return None
    if not error < 1:
        return 0.0
    return MOST_DIGITS if error == 0 else min(-math.log10(error), MOST_DIGITS)


# --- the condition of the data

#: Number of random perturbations.
DRAWS = 8

#: Perturbations in units of h: different ones, so that ratios of data change (as in ``response.estimate``).
MOVES = (-1.0, -0.5, 0.5, 1.0)

#: h, far above the accuracy of the exact answers, and so small that only the first order matters. Larger conditions than its inverse are not resolved; those of meaningful float64 data are below 1e40.
PERTURBATION = Fraction(1, 2**160)

#: Digits of the exact answers: those of h (48) and of the change where values cancel.
CONDITION_DIGITS = 75


def condition_of(problem: StudyProblem, exact: ExactResponse, draws: int = DRAWS) -> float:
    """max |dx| / (h max |x|) over the times, dx the largest change of x over some relative perturbations of the data by h.

    The data are the constants of the elements where a matrix is given by its elements, else its entries that are not zero
    (both of a symmetric pair alike), the entries of the constraint rows, the values at 0-, and the force: its size in each row,
    its frequencies and rates. Zeros stay; so do the values of constraint rows, and matrices whose perturbation changes the number
    of finite zeros.

    >>> from mbconstrained import PolynomialMatrix
    >>> from mbconstrained import zero
    >>> decay = StudyProblem("decay", PolynomialMatrix([[[1.0]], [[1.0]]]), np.ones((1, 1)), zero(1), np.array([8.0]))
    >>> 4 <= condition_of(decay, decay.solve().exact) <= 17  # of e^(-a t) x0: 1 + 2 a t for two entries and a start
    True
    """
    truth = values_of(exact.enclose(problem.times, CONDITION_DIGITS))
    largest = np.abs(truth).max(initial=Fraction(0))
    changes = [_largest_change(problem, exact, truth, seed) for seed in range(draws)]
    change = max(changes, default=Fraction(0))
    if largest == 0:
        return 0.0 if change == 0 else math.inf
    try:
        return float(change / (PERTURBATION * largest))
    except OverflowError:  # a force that grows and is cut off, which its perturbed copy is not
        return math.inf


def _largest_change(problem, exact, truth, seed) -> Fraction:
    perturbed = _moved(problem, exact, np.random.default_rng(seed)).enclose(problem.times, CONDITION_DIGITS)
    return np.abs(values_of(perturbed) - truth).max(initial=Fraction(0))


def _moved(problem: StudyProblem, exact: ExactResponse, random) -> ExactResponse:
    initial = [[entry * _factor(random) for entry in row] for row in exact.initial]
    sources = _moved_sources(exact.sources, len(exact.rows), random)
    return ExactResponse(_moved_matrix(exact.matrix, _directions(problem, random)), initial, sources, exact.rows)


def _moved_matrix(matrix: RationalMatrix, directions: Sequence[np.ndarray]) -> RationalMatrix:
    """A(s) + h dA(s); coefficients that would change the number of finite zeros stay."""
    zeros = matrix.determinant.degree()
    given = [coefficient.tolist() for coefficient in matrix.coefficients]
    changed = [_sum(coefficient, direction) for coefficient, direction in zip(given, directions)]
    whole = RationalMatrix(changed)
    if whole.determinant.degree() == zeros:
        return whole
    kept = list(given)
    for power, coefficient in enumerate(changed):
        trial = [*kept[:power], coefficient, *kept[power + 1 :]]
        if RationalMatrix(trial).determinant.degree() == zeros:
            kept = trial
    return RationalMatrix(kept)


def _sum(coefficient: list[list], direction: np.ndarray) -> list[list]:
    """The perturbed coefficient."""
    entries = [list(row) for row in coefficient]
    for i, j in zip(*np.nonzero(direction)):
        entries[i][j] = entries[i][j] + rational(PERTURBATION * Fraction(direction[i, j]))
    return entries


def _directions(problem: StudyProblem, random) -> list[np.ndarray]:
    """dA_0 ... dA_q as Fractions: the coefficients with each of their data perturbed."""
    if problem.system is None:
        return [_direction(matrix, random) for matrix in given_of(problem.polynomial_matrix)]
    directions = [_direction(matrix, random) for matrix in problem.system.given]
    A = problem.system.constraint_matrix
    if not len(A):
        return directions
    moved = fractions_of(A * _moves(random, A.shape))  # rows and their forces, which are in their directions, alike
    return with_multipliers(directions, moved, [row.order for row in problem.system.rows])


def _direction(matrix, random) -> np.ndarray:
    if isinstance(matrix, ElementMatrix):
        matrix = Factors(matrix.directions.T, matrix.constants, matrix.directions)
    if isinstance(matrix, Factors):
        return replace(matrix, values=matrix.values * _moves(random, matrix.values.shape)).exact
    moves = _moves(random, matrix.shape)
    if np.array_equal(matrix, matrix.T):
        moves = np.triu(moves) + np.triu(moves, 1).T
    return fractions_of(matrix * moves)


def _moved_sources(sources: Sequence[ExactSource], rows: int, random) -> list[ExactSource]:
    """Sources with each row scaled and each function accelerated by a factor; values of constraint rows stay."""
    factors, clocks, moved = {}, {}, []
    for source in sources:
        clock = clocks.setdefault(source.shape.key[1], _factor(random))
        sizes = factors.setdefault(source.shape.key, [_factor(random) for _ in range(rows)])
        vector = (*(entry * size for entry, size in zip(source.vector, sizes)), *source.vector[rows:])
        moved.append(replace(source, vector=vector, shape=_faster(source.shape, clock)))
    return moved


def _faster(shape: Shape, clock) -> Shape:
    """g(c t), whose transform is G(s / c) / c, with scaled frequencies and rates."""
    return Shape(shape.numerator(S / clock) / clock, shape.denominator(S / clock))


def _factor(random):
    return rational(1 + PERTURBATION * Fraction(float(random.choice(MOVES))))


def _moves(random, shape) -> np.ndarray:
    return random.choice(MOVES, size=shape)


# --- scaling factors of a scene

#: Most elements of a lumped model that are scaled one by one; those of larger models only all together.
MOST_ELEMENTS = 12

#: Number of times of the scene at which a problem is solved.
TIMES = 25

#: The tables of a lumped model and the scaled parameter of their entries.
ELEMENTS = {
    "mass": "mass",
    "inertia": "inertia",
    "damper": "damping",
    "torsion_damper": "damping",
    "spring": "stiffness",
    "torsion_spring": "stiffness",
}

#: Names of all elements of a kind.
ALL = {"mass": "all masses", "inertia": "all inertias", "damping": "all dampers", "stiffness": "all springs"}


Scaled = Callable[[float], StudyProblem]


def scaling_factors(scene: Scene) -> dict[str, Scaled]:
    """The problem as a function of a factor, for each parameter of the model that can be scaled and for the horizon.

    >>> from mbconstrained import read_scene
    >>> list(scaling_factors(read_scene("examples/stiff_stack.toml")))[-1]
    'horizon'
    """
    whole = problem_of(scene)
    problem = whole.at(whole.times[chosen_places(len(whole.times), TIMES)])
    if scene.equations.model is not None:
        factors = _lumped_factors(scene, problem)
    elif problem.system is not None:
        factors = _system_factors(problem)
    elif problem.respond is not None:
        factors = _transfer_factors(scene, problem)
    else:
        factors = _coefficient_factors(problem)
    return {**dict(factors), "horizon": lambda factor: problem.at(problem.times * factor)}


def _lumped_factors(scene: Scene, problem: StudyProblem) -> Iterator[tuple[str, Scaled]]:
    """All masses, all dampers, all springs; and each separately where there are several, but not too many."""
    entries = [(table, place) for table in ELEMENTS for place in range(len(getattr(scene.table.model, table)))]
    for kind, all_of_them in ALL.items():
        mine = [entry for entry in entries if ELEMENTS[entry[0]] == kind]
        if mine:
            name = all_of_them if len(mine) > 1 else _title(scene, mine[0])
            yield name, partial(_with_elements, scene, problem, mine)
        if 1 < len(mine) and len(entries) <= MOST_ELEMENTS:
            yield from ((_title(scene, entry), partial(_with_elements, scene, problem, [entry])) for entry in mine)


def _title(scene: Scene, entry: tuple[str, int]) -> str:
    """Title of an entry: its name or its two ends, with a number for several without a name between the same ends."""
    table, place = entry
    names = [entry.name or f"{entry.start} to {entry.end}" for entry in getattr(scene.table.model, table)]
    name = names[place]
    number = f" ({names[: place + 1].count(name)})" if names.count(name) > 1 else ""
    return f"{ELEMENTS[table]} of {name}{number}"


def _with_elements(scene: Scene, problem: StudyProblem, entries: list[tuple[str, int]], factor: float) -> StudyProblem:
    model = scene.table.model
    for table, place in entries:
        rows, key = list(getattr(model, table)), ELEMENTS[table]
        rows[place] = rows[place].model_copy(update={key: float(getattr(rows[place], key)) * factor})
        model = model.model_copy(update={table: rows})
    return _with_model(scene, problem, model)


def _with_model(scene: Scene, problem: StudyProblem, model) -> StudyProblem:
    table = scene.table.model_copy(update={"model": model})
    equations = equations_of(table, scene.folder, scene.file_name)
    return problem_of(replace(scene, table=table, equations=equations)).at(problem.times)


def _transfer_factors(scene: Scene, problem: StudyProblem) -> Iterator[tuple[str, Scaled]]:
    """The denominator, with the method of ``run``: from rest."""
    model = scene.table.model
    given = [float(coefficient) for coefficient in model.denominator]

    def scaled(place: int, factor: float) -> StudyProblem:
        denominator = [*given[:place], given[place] * factor, *given[place + 1 :]]
        return _with_model(scene, problem, model.model_copy(update={"denominator": denominator}))

    for place, coefficient in reversed(list(enumerate(given))):
        if coefficient:
            yield f"denominator's coefficient of s^{len(given) - 1 - place}", partial(scaled, place)


def _system_factors(problem: StudyProblem) -> Iterator[tuple[str, Scaled]]:
    for place, name in ((2, "mass"), (1, "damping"), (0, "stiffness")):
        given = problem.system.given[place]
        if np.any(given.matrix if isinstance(given, ElementMatrix) else given):
            yield name, partial(_with_matrix, problem, place)


def _with_matrix(problem: StudyProblem, place: int, factor: float) -> StudyProblem:
    """The problem with K, C or M (place 0, 1, 2) multiplied."""
    given, doubt = list(problem.system.given), list(problem.system.uncertainty)
    matrix = given[place]
    scaled = ElementMatrix(matrix.directions, matrix.constants * factor) if isinstance(matrix, ElementMatrix) else matrix * factor
    given[place], doubt[place] = scaled, doubt[place] * factor
    system = again(problem.system, given, doubt)
    return mechanical_problem(problem.title, system, problem.times, *problem.initial, force=problem.applied)


def _coefficient_factors(problem: StudyProblem) -> Iterator[tuple[str, Scaled]]:
    for power, matrix in enumerate(problem.polynomial_matrix.coefficients):
        if np.any(matrix):
            yield f"coefficient of s^{power}", partial(_with_coefficient, problem, power)


def _with_coefficient(problem: StudyProblem, power: int, factor: float) -> StudyProblem:
    A = problem.polynomial_matrix
    given = given_of(A)
    matrix = given[power]
    given[power] = replace(matrix, values=matrix.values * factor) if isinstance(matrix, Factors) else matrix * factor
    return replace(problem, polynomial_matrix=PolynomialMatrix(given, A.coordinates, A.equations), respond=None)


# --- plots

#: Least ratio of parameters on a logarithmic axis.
LOGARITHMIC = 100.0

#: Verdicts other than "right" in legends, and the shapes of their marks.
SHAPES = {
    "warned": ("with a warning", "circle"),
    "refused": ("refused", "diamond"),
    "not judged": ("not judged", "diamond"),
    "wrong": ("wrong without a warning", "cross"),
}


def overview_plot(sweeps: Sequence[ScalingSweep]) -> Iterator[Plot]:
    """Digits right over the common factor, a curve for each sweep; none where nothing was judged."""
    sweeps = [sweep for sweep in sweeps if sweep.points]
    x = np.array(sorted({point.parameter for sweep in sweeps for point in sweep.points}))
    curves, marks = [], []
    for number, sweep in enumerate(sweeps):
        right = {point.parameter: point.right for point in sweep.points}
        curves.append(curve_with_gaps(sweep.title, np.array([right.get(value) for value in x], dtype=float)))
        marks += _verdict_marks(sweep.points, number)
    if any(sweep.answers for sweep in sweeps):
        yield Plot(
            "digits right",
            "",
            x,
            tuple(curves),
            across_unit="",
            quantity="digits right",
            variable="factor",
            scales=("log", "linear"),
            marks=tuple(marks),
            includes=(0.0, MOST_DIGITS),
            shown=len(curves),
            is_large=True,
        )


def _verdict_marks(points: Sequence[Point], curve: int | None = None) -> Iterator[Marks]:
    """A mark where an answer is not right."""
    for verdict, (text, shape) in SHAPES.items():
        if own := [point for point in points if point.verdict == verdict]:
            places = np.array([[point.parameter, point.right or 0.0] for point in own])
            yield Marks(text, places, tuple(point.reason for point in own), shape, curve)


def digit_plots(sweeps: Sequence[ScalingSweep]) -> Iterator[Plot]:
    """Digits right, claimed and expected over the parameter of each sweep, with a mark where an answer is not right."""
    for sweep in sweeps:
        points = sorted(sweep.points, key=lambda point: point.parameter)
        x = np.array([point.parameter for point in points])
        keys = ("right", "claimed", "expected") if sweep.answers else ()
        digits = {key: np.array([getattr(point, key) for point in points], dtype=float) for key in keys}
        marks = _verdict_marks(points)
        is_wide = bool((x >= 0).all() and x.max() >= LOGARITHMIC * x[x > 0].min(initial=x.max()))
        curves = tuple(curve_with_gaps(f"digits {key}", values) for key, values in digits.items() if np.isfinite(values).any())
        if curves:
            scales: tuple[Scale, Scale] = ("log" if is_wide else "linear", "linear")
            yield Plot(
                sweep.title,
                "",
                x,
                curves,
                None,
                "",
                "digits",
                sweep.parameter,
                scales,
                marks=tuple(marks),
                includes=(0.0, MOST_DIGITS),
            )
