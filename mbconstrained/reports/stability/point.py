"""One problem: how many digits are right, how many the data allow, how many were claimed, and whether a warning came."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Literal

import numpy as np

from ...errors import MbconstrainedError, Overflow, SingularPolynomialMatrix
from ...response.estimate import LEAST
from ...tolerances import EPS, TRUST_LIMIT
from ..problem import Problem

if TYPE_CHECKING:
    from ...response import Response

Verdict = Literal["right", "told", "wrong", "refused", "not judged"]

#: A claim is wrong when the error is more than so many times what was claimed.
WRONG = 10.0

#: Seconds that exact arithmetic may take for the truth, and again for the condition.
SECONDS = 30.0

#: Digits of the exact answer that errors are measured against: twice those of float64.
DIGITS = 32

#: Float64 has no more: what is right to the last bit has so many digits, and data that are rounded determine so many.
MOST_DIGITS, MOST_EXPECTED = 16.0, -math.log10(EPS / 2)

#: Below the smallest normal number float64 has no relative precision: errors are relative to no less than this.
SMALLEST = Fraction(float(np.finfo(float).tiny))


@dataclass(frozen=True)
class Point:
    """One place in a sweep.

    Errors are those of x at the times of the problem, max |error| / max |x|.

    Attributes:
        parameter: of the sweep.
        right: digits right against exact arithmetic, between 0 and 16; None where refused, or where that is not known.
        expected: digits that float64 data let anybody expect, -log10(condition eps), between 0 and 15.95; NaN where not known.
        claimed: digits that the error estimate claims; None where refused.
        warnings: what makes ``mbconstrained run`` leave with exit code 3.
        refused: the text of the error, where there is no answer.
        verdict: "refused"; "told" where a warning came; "wrong" where none came and the error is more than ten times the estimate
            (both at least eight roundings); "right" where it is not; "not judged" where no warning came and the truth is not known.
        notices: what else was said of the answer.
        unknown: why digits are not known, in words.
        error, estimate, condition: the numbers behind the digits.
    """

    parameter: float
    right: float | None
    expected: float
    claimed: float | None
    warnings: tuple[str, ...] = ()
    refused: str = ""
    verdict: Verdict = "right"
    notices: tuple[str, ...] = ()
    unknown: str = ""
    error: float | None = None
    estimate: float | None = None
    condition: float | None = None

    @property
    def reason(self) -> str:
        """Why the verdict is what it is, in words; empty where all is right."""
        if self.verdict == "wrong":
            return f"only {self.right:.1f} digits are right, the estimate claims {self.claimed:.1f}, and no warning came"
        return {"refused": self.refused, "told": "; ".join(self.warnings), "not judged": self.unknown}.get(self.verdict, "")

    def as_json(self) -> dict:
        """As plain data: what is no finite number is null."""
        found = {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()}
        return {name: None if isinstance(value, float) and not math.isfinite(value) else value for name, value in found.items()}


@dataclass(frozen=True)
class Answer:
    """What the numeric engine says of a problem: values (r, T) at its times, its own estimate of their error, its notices."""

    response: Response
    values: np.ndarray
    estimate: float
    warnings: tuple[str, ...]
    notices: tuple[str, ...]


def point_of(problem: Problem, parameter: float = 0.0, variations: int | None = None, seconds: float = SECONDS) -> Point:
    """Solve a problem and hold the answer against exact arithmetic.

    Args:
        problem: with its times.
        parameter: of the sweep, kept with the result.
        variations: how often the data are moved to find the condition; None for the usual number, 0 for no condition.
        seconds: for the truth, and again for the condition; what takes longer is not known, and says so.

    Only errors of this package, in plain words, count as refused; any other is let through.

    >>> from ..problem import mechanical_problem
    >>> from ...mechanics import MechanicalSystem
    >>> point = point_of(mechanical_problem("spring", MechanicalSystem([[1.0]], stiffness=[[4.0]]), [1.0, 2.0], [1.0]))
    >>> point.verdict, point.right > 15, point.expected > 14, point.warnings
    ('right', True, True, ())
    """
    try:
        answer = answer_of(problem)
    except MbconstrainedError as reason:
        return refused_point(parameter, str(reason))
    error, why = _within(seconds, lambda: _held(problem, answer), too_large_for(problem))
    condition, why_not = _within(seconds, lambda: _condition(problem, answer, variations), why)
    return Point(
        parameter,
        right=_digits(error),
        expected=math.nan if condition is None else min(_digits(condition * EPS), MOST_EXPECTED),
        claimed=_digits(answer.estimate),
        warnings=answer.warnings,
        verdict=verdict_of(error, answer.estimate, answer.warnings),
        notices=answer.notices,
        unknown=why or why_not,
        error=error,
        estimate=answer.estimate,
        condition=condition,
    )


def refused_point(parameter: float, reason: str) -> Point:
    """Where there is no answer, or not even a problem."""
    return Point(parameter, None, math.nan, None, refused=reason, verdict="refused")


def answer_of(problem: Problem) -> Answer:
    """The numeric answer with all that it says of itself, as ``mbconstrained run`` says it of displacements.

    Raises:
        MbconstrainedError: any, in plain words: there is no answer.
    """
    response = problem.solve()
    values, estimate = response(problem.times), response.error_estimate(problem.times)
    doubtful = tuple(notice.text for notice in response.notices if notice.doubtful)
    if not estimate <= TRUST_LIMIT:
        doubtful += (f"the estimated relative error is {estimate:.2g}: the data do not determine the answer well enough",)
    others = tuple(notice.text for notice in response.notices if not notice.doubtful)
    return Answer(response, values, estimate, doubtful, others)


def verdict_of(error: float | None, estimate: float, warnings: tuple[str, ...]) -> Verdict:
    """What error, claim and warnings amount to.

    >>> verdict_of(1e-9, 1e-12, ()), verdict_of(1e-9, 1e-12, ("a rank decision",)), verdict_of(1e-16, 0.0, ())
    ('wrong', 'told', 'right')
    """
    if warnings:
        return "told"
    if error is None:
        return "not judged"
    return "right" if max(error, LEAST) <= WRONG * max(estimate, LEAST) else "wrong"


def too_large_for(problem: Problem) -> str:
    """Why exact arithmetic is not even tried; an empty text where it is."""
    from ...scene.certificate import too_large

    return too_large(problem)


def _held(problem: Problem, answer: Answer) -> tuple[float | None, str]:
    """max |error| / max |x|: infinite where values are no numbers, or where the data, taken exactly, determine no motion.

    Where the answer took for rounding what the data, taken exactly, are, the truth is of another motion, and none is told.
    """
    from ...exact.enclosure import structure_notices
    from .condition import values_of

    if not np.isfinite(answer.values).all():
        return math.inf, ""
    try:
        exact = answer.response.exact
    except SingularPolynomialMatrix:
        return math.inf, ""
    if other := structure_notices(answer.response, exact):
        return None, other[0].text
    truth, found = values_of(exact.enclose(problem.times, DIGITS)), np.vectorize(Fraction, otypes=[object])(answer.values)
    largest = np.abs(truth).max(initial=SMALLEST)
    return float(np.abs(found - truth).max(initial=Fraction(0)) / largest), ""


def _condition(problem: Problem, answer: Answer, variations: int | None) -> tuple[float | None, str]:
    from .condition import DRAWS, condition_of

    draws = DRAWS if variations is None else variations
    return (condition_of(problem, answer.response.exact, draws) if draws else None), ""


def _within(seconds: float, work, reason: str = "") -> tuple[float | None, str]:
    """The number that the work finds; else None, and why."""
    from ...scene.time_limit import OutOfTime, time_limit

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
    """-log10, between 0 and 16; none where the error is no number."""
    if error is None:
        return None
    if not error < 1:
        return 0.0
    return MOST_DIGITS if error == 0 else min(-math.log10(error), MOST_DIGITS)
