"""The reference solution of a problem: exact arithmetic, or a stated cross-check where that takes too long."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ..exact.enclosure.intervals import Enclosure
from ..ground.errors import Overflow
from ..response.response import Response
from ..scene.run.stage_costs import OutOfTime, time_limit
from .study_problem import StudyProblem

#: Most times that are compared, evenly chosen with the first and the last.
MOST_TIMES = 101

#: Digits of the exact values, kept as sums of two float64 numbers.
DIGITS = 25

#: Most states for exact arithmetic, which takes minutes with more, and its time limit, s.
MOST_STATES, SECONDS = 240, 60.0


@dataclass(frozen=True, eq=False)
class ReferenceSolution:
    """The solution at some of the times of a problem.

    Attributes:
        places: indices of the compared times, shape (K,).
        values, rest: the solution as the sum of two float64 numbers, shape (r, K).
        error_bound: smaller errors are not resolved; 0 for an exact solution.
        source: method of computation, as a phrase.
    """

    places: np.ndarray
    values: np.ndarray
    rest: np.ndarray
    error_bound: float
    source: str

    @property
    def scale(self) -> float:
        """max |x| at the compared times."""
        return float(np.abs(self.values).max(initial=0.0))

    def error(self, values: np.ndarray) -> float:
        """max |error| / max |x| of values (r, T) at the times of the problem; the absolute error where x is zero."""
        compared = np.asarray(values)[:, self.places]
        if not np.isfinite(compared).all():
            return np.inf
        error = float(np.abs((compared - self.values) - self.rest).max(initial=0.0))
        return max(error / (self.scale or 1.0), self.error_bound)


def states_of(problem: StudyProblem) -> int:
    """Upper bound of the number of states: coordinates times the degree of A(s), at least 1."""
    return problem.polynomial_matrix.size * max(problem.polynomial_matrix.degree, 1)


def reference_solution(problem: StudyProblem, seconds: float = SECONDS) -> ReferenceSolution:
    """The reference solution by exact arithmetic for the given numbers; by a cross-check where that takes too long."""
    places = chosen_places(len(problem.times))
    states = states_of(problem)
    if states > MOST_STATES:
        return _cross_checked(problem, places, f"exact arithmetic with {states} states takes too long")
    try:
        with time_limit(seconds):
            return exact_solution(problem.solve(), problem.times, places)
    except OutOfTime:
        return _cross_checked(problem, places, f"exact arithmetic took more than {seconds:g} s")
    except Overflow as reason:
        return _cross_checked(problem, places, f"exact arithmetic failed: {reason}")


def exact_solution(response: Response, times: np.ndarray, places: np.ndarray) -> ReferenceSolution:
    """The solution at some of the times by exact rational and ball arithmetic."""
    box = response.enclose(times[places], digits=DIGITS)
    exact = values_of(box)
    values = exact.astype(float)
    rest = (exact - fractions_of(values)).astype(float)
    count = f"{len(places)} of {len(times)} times" if len(places) < len(times) else f"all {len(times)} times"
    return ReferenceSolution(places, values, rest, 0.0, f"exact rational and ball arithmetic at {count} for the given numbers")


def chosen_places(count: int, most: int = MOST_TIMES) -> np.ndarray:
    """Some of the indices 0 ... count - 1, evenly spaced, including the first and the last."""
    return np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(int))


def values_of(box: Enclosure) -> np.ndarray:
    """The middles of the intervals as Fractions, of the shape of x."""
    return (fractions_of(box.lower) + fractions_of(box.upper)) / 2


#: Floats, or decimal strings, as the exact numbers that they are.
fractions_of = np.vectorize(Fraction, otypes=[object])


def _cross_checked(problem: StudyProblem, places: np.ndarray, why: str) -> ReferenceSolution:
    """The closed form, verified to the accuracy with which steps by e^(S dt) on the reduced equations agree."""
    from .accuracy.matrix_exponential import STEPS

    values, other = problem.solve()(problem.times), STEPS.prepare(problem, None)()
    scale = np.abs(values).max(initial=0.0) or 1.0
    error_bound = float(np.abs(values - other).max(initial=0.0) / scale)
    source = f"{why}: the closed form itself, with which {STEPS.name} agrees to {error_bound:.1e}; smaller errors are not resolved"
    values = values[:, places]
    return ReferenceSolution(places, values, np.zeros_like(values), error_bound, source)
