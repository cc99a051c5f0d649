"""What values are compared with: exact arithmetic, or where that takes too long a stated cross-check."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ..errors import Overflow
from ..response import Response
from ..scene.time_limit import OutOfTime, time_limit
from .problem import Problem

#: At most so many of the times are compared, evenly chosen, the first and the last among them.
MOST_TIMES = 101

#: Digits of the exact values: what float64 cannot hold is kept beside it.
DIGITS = 25

#: Exact arithmetic with more states takes minutes; after so many seconds it is broken off.
MOST_STATES, SECONDS = 240, 60.0


@dataclass(frozen=True)
class Truth:
    """True values at some of the times of a problem.

    Attributes:
        places: which of the times are compared, shape (K,).
        values, rest: the true values as the sum of two float64 numbers, shape (r, K).
        floor: errors below it cannot be told; 0 where the values are exact.
        how: where they are from, in a sentence.
    """

    places: np.ndarray
    values: np.ndarray
    rest: np.ndarray
    floor: float
    how: str

    @property
    def scale(self) -> float:
        """max |x| at the compared times."""
        return float(np.abs(self.values).max(initial=0.0))

    def error(self, values: np.ndarray) -> float:
        """max |error| / max |x| of values (r, T) at the times of the problem; the error itself where x is zero throughout."""
        found = np.asarray(values)[:, self.places]
        if not np.isfinite(found).all():
            return np.inf
        error = float(np.abs((found - self.values) - self.rest).max(initial=0.0))
        return max(error / (self.scale or 1.0), self.floor)


def states_of(problem: Problem) -> int:
    """Coordinates times the degree of A(s), one each at least: it has no more states than these."""
    return problem.polynomial_matrix.size * max(problem.polynomial_matrix.degree, 1)


def truth_of(problem: Problem, seconds: float = SECONDS) -> Truth:
    """The truth by exact arithmetic, the data taken as the numbers that they are; by a cross-check where that takes too long.

    Args:
        seconds: after so long exact arithmetic is broken off.
    """
    places = chosen_places(len(problem.times))
    states = states_of(problem)
    if states > MOST_STATES:
        return _cross_checked(problem, places, f"exact arithmetic with {states} states takes too long")
    try:
        with time_limit(seconds):
            return exact_truth(problem.solve(), problem.times, places)
    except OutOfTime:
        return _cross_checked(problem, places, f"exact arithmetic took more than {seconds:g} s")
    except Overflow as problem_found:
        return _cross_checked(problem, places, f"exact arithmetic gave up: {problem_found}")


def exact_truth(response: Response, times: np.ndarray, places: np.ndarray) -> Truth:
    """The truth at some of the times by exact rational and ball arithmetic."""
    box = response.enclose(times[places], digits=DIGITS)
    exact = np.vectorize(_middle, otypes=[object])(box.lower, box.upper)
    values = exact.astype(float)
    rest = (exact - np.vectorize(Fraction, otypes=[object])(values)).astype(float)
    count = f"{len(places)} of {len(times)} times" if len(places) < len(times) else f"all {len(times)} times"
    return Truth(
        places, values, rest, 0.0, f"exact rational and ball arithmetic at {count}, the data taken as the numbers that they are"
    )


def chosen_places(count: int, most: int = MOST_TIMES) -> np.ndarray:
    """At most so many of the places 0 ... count - 1, evenly chosen, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(int))


def _middle(low: str, high: str) -> Fraction:
    return (Fraction(low) + Fraction(high)) / 2


def _cross_checked(problem: Problem, places: np.ndarray, why: str) -> Truth:
    """The closed form, known as well as another method agrees with it: e^(S dt) on the reduced equations."""
    from .accuracy.expm_steps import METHOD

    values, other = problem.solve()(problem.times), METHOD.prepare(problem, None)()
    scale = np.abs(values).max(initial=0.0) or 1.0
    floor = float(np.abs(values - other).max(initial=0.0) / scale)
    how = f"{why}: the closed form itself, with which {METHOD.name} agrees to {floor:.1e}; errors below that cannot be told"
    values = values[:, places]
    return Truth(places, values, np.zeros_like(values), floor, how)
