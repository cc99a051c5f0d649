"""One problem: correct digits, digits expected from the condition and claimed by the estimate, and warnings."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Literal

import numpy as np

from ...ground.errors import MbconstrainedError, Overflow, SingularPolynomialMatrix
from ...ground.tolerances import EPS, TRUST_LIMIT
from ...response.estimate import LEAST
from ..reference_solution import fractions_of, values_of
from ..study_problem import StudyProblem
from ..study_report import Progress, no_progress

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
    """Point of a sweep.

    Attributes:
        parameter: parameter of the sweep.
        error: max |error| / max |x| at the times of the problem by exact arithmetic; None where refused or not known.
        estimate: the error estimate; None where refused.
        condition: condition number of the data; None where not known.
        warnings: the reasons for exit code 3 of ``mbconstrained run``.
        refused: the text of the error in place of an answer.
        notices: other notices of the answer.
        unknown: the reason where error or condition are not known.
    """

    parameter: float
    error: float | None = None
    estimate: float | None = None
    condition: float | None = None
    warnings: tuple[str, ...] = ()
    refused: str = ""
    notices: tuple[str, ...] = ()
    unknown: str = ""

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

    def as_json(self) -> dict:

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

    >>> from mbconstrained.studies.study_problem import mechanical_problem
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
    from .condition import DRAWS, condition_of

    draws = DRAWS if variations is None else variations
    return (condition_of(problem, response.exact, draws) if draws else None), ""


def _within(seconds: float, work, reason: str = "") -> tuple[float | None, str]:
    """The result of the work within a time limit; else None and the reason."""
    from ...scene.run.stage_costs import OutOfTime, time_limit

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
