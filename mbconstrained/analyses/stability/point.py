"""One problem: correct digits, digits expected from the condition and claimed by the estimate, and warnings.

The condition is measured with exact arithmetic, condition = max |change of x| / (h max |x|) for data that are perturbed by h. Float64 data, exact
to half a unit in the last place, determine no more than -log10(condition eps) digits for any method.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Literal

import numpy as np

from ...exact.enclosure.exact_response import ExactResponse
from ...exact.enclosure.exact_sources import ExactSource, S, Shape
from ...exact.rational import RationalMatrix, rational
from ...ground.errors import MbconstrainedError, Overflow, SingularPolynomialMatrix
from ...ground.tolerances import EPS, TRUST_LIMIT
from ...mechanics.constraints import with_multipliers
from ...mechanics.element_matrix import ElementMatrix
from ...polynomial.coefficients import Factors
from ...response.estimate import LEAST
from ..study_problem import StudyProblem, fractions_of, given_of, values_of
from ..timing import Progress, no_progress

if TYPE_CHECKING:
    from ...response.response import Response

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
    from ...scene.run.stages import too_large_to_certify

    try:
        response = problem.solve()
        values, estimate = response(problem.times), response.error_estimate(problem.times)
    except MbconstrainedError as reason:
        return Point(parameter, refused=str(reason))
    error, why = _within(seconds, lambda: _error(problem, response, values), too_large_to_certify(problem))
    condition, why_not = _within(seconds, lambda: _condition(problem, response, variations), why)
    warnings = [notice.text for notice in response.notices if notice.doubtful]
    if not estimate <= TRUST_LIMIT:
        warnings.append(f"the estimated relative error is {estimate:.2g}: the data do not determine the answer well enough")
    notices = tuple(notice.text for notice in response.notices if not notice.doubtful)
    return Point(parameter, error, estimate, condition, tuple(warnings), notices=notices, unknown=why or why_not)


def _error(problem: StudyProblem, response: Response, answer: np.ndarray) -> tuple[float | None, str]:
    """max |error| / max |x|: infinite where values are not finite, or where the exact data determine no motion.

    Not known where the answer treats as rounding errors what the exact data contain: they describe another motion.
    """
    from ...exact.enclosure.exact_response import structure_notices

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


def _condition(problem: StudyProblem, response: Response, variations: int | None) -> tuple[float | None, str]:
    draws = DRAWS if variations is None else variations
    return (condition_of(problem, response.exact, draws) if draws else None), ""


def _within(seconds: float, work, reason: str = "") -> tuple[float | None, str]:
    """The result of the work within a time limit; else None and the reason."""
    from ...scene.run.plan import OutOfTime, time_limit

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
STEP = Fraction(1, 2**160)

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
        return float(change / (STEP * largest))
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
        entries[i][j] = entries[i][j] + rational(STEP * Fraction(direction[i, j]))
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
    return rational(1 + STEP * Fraction(float(random.choice(MOVES))))


def _moves(random, shape) -> np.ndarray:
    return random.choice(MOVES, size=shape)
