"""Newton's method for a zero and its vector of a symmetric quadratic pencil, sparse or small and dense.

Two-sided, as the matrices are symmetric (Lancaster 1961): x <- P(s)^-1 P'(s) x and s <- s - (v^T x) / (v^T P(s)^-1 P'(s) x) with
v = P'(s) x, one factorization of P(s) = s^2 M + s C + K a step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import IllConditioned
from ...tolerances import EPS, NOISE_SAFETY
from .lanczos import CONVERGED

#: After so many steps a pair that has not converged is told.
MOST_STEPS = 8

#: A value that moved by no more than this part of the gap has a vector that is right to this times its square root.
CLOSE = EPS**0.5


@dataclass(frozen=True)
class Residual:
    """P(s) x without what the long rows carry.

    Attributes:
        forces: it, shape (r,), and its
        norm, besides those of
        terms: of the sum of the sizes of its terms,
        inertia: of s^2 M x, and
        damping: of s C x.
    """

    forces: np.ndarray
    norm: float
    terms: float
    inertia: float
    damping: float

    @property
    def relative(self) -> float:
        """The residual as a part of its terms, whatever the length of the vector."""
        return self.norm / (self.terms or 1.0)

    @property
    def is_rounding(self) -> bool:
        """Whether no correction makes it smaller."""
        return self.norm <= 2 * EPS * self.terms + CONVERGED * self.inertia

    @property
    def evidence(self) -> tuple[float, float]:
        """The residual, and what rounding and the stopping rule explain of it, relative to the inertia."""
        whole = self.inertia or self.terms or 1.0
        return self.norm / whole, (NOISE_SAFETY * EPS * self.terms + CONVERGED * (self.inertia + self.damping)) / whole


@dataclass
class Pair:
    """P(value) vector = 0 with Im value >= 0, on its way.

    Attributes:
        resting: whether it is a rigid body without damping (two states).
        converged: whether Newton's method ended at its own zero.
        residual: of P(value) vector, once it is known.
    """

    value: complex
    vector: np.ndarray
    resting: bool = False
    converged: bool = True
    residual: Residual | None = None


def gap(values: np.ndarray, place: int) -> float:
    """How far the nearest other one of some zeros lies, conjugates included."""
    others = np.delete(values, place)
    distances = np.abs(np.concatenate([others, np.conj(values)]) - values[place])
    return float(distances[distances > 0].min(initial=abs(values[place])))


def newton(quadratic, estimate: Pair, room: float) -> Pair:
    """The pair that Newton's method makes of an estimate.

    With a value wrong by a part p of the gap the vector was wrong by p^(1/2), and is by p^(3/2) after a step.

    Args:
        quadratic: has ``slope(s, x)`` for P'(s) x, and ``factors(s).solve``.
        room: the gap to the next zero.
    """
    value, x, moved, converged = estimate.value, estimate.vector.astype(complex), np.inf, True
    real = value.imag == 0
    for _ in range(MOST_STEPS):
        slope = quadratic.slope(value, x)
        try:
            image = quadratic.factors(value).solve(slope)
        except IllConditioned:  # the value is a zero to the last digit
            break
        if not np.isfinite(image).all():
            break
        step = (slope @ x) / (slope @ image)
        x = image / np.abs(image).max()
        value = complex((value - step).real) if real else value - step
        moved, last = abs(step), moved
        if moved <= CLOSE * room or moved <= EPS**0.5 * abs(value) and moved >= last / 2:
            break
    else:
        converged = False
    return Pair(value, x.real if real else x, converged=bool(converged and (real or value.imag > 0)))
