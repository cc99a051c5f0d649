"""Polynomials through Chebyshev points on many intervals at once, each in its own time from 0 to 1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev, polynomial

from ..ground.tolerances import COEFFICIENT_NOISE, EPS, JOINT_SAFETY

#: Polynomials of this degree take four pieces for a period of a harmonic at a tolerance of 1e-12, and their
#: coefficients of powers from the left end on are larger than the values by no more than the tolerance allows.
DEGREE = 10

#: Chebyshev points of the first kind on [0, 1]: none at the ends, where the function may jump.
NODES = (1 - np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))) / 2

#: Places between the nodes at which the polynomial is compared with the function, close to both ends and within.
CHECKS = np.array([0.001, 0.17, 0.46, 0.79, 0.999])


def _maps() -> tuple[np.ndarray, np.ndarray]:
    """The maps from values at the nodes to coefficients of T_j(2 t - 1), and from these to coefficients of t^k."""
    basis = chebyshev.chebvander(2 * NODES - 1, DEGREE)
    shifted = np.zeros((DEGREE + 1, DEGREE + 1))
    for j in range(DEGREE + 1):
        inner = chebyshev.cheb2poly(np.eye(1, j + 1, j)[0])
        total = np.zeros(1)
        for coefficient in inner[::-1]:
            total = polynomial.polyadd(polynomial.polymul(total, [-1.0, 2.0]), [coefficient])
        shifted[: j + 1, j] = total[: j + 1]
    weights = np.full(DEGREE + 1, 2.0 / (DEGREE + 1))
    weights[0] /= 2
    return weights[:, None] * basis.T, shifted


TO_CHEBYSHEV, TO_POWERS = _maps()

#: The matrix about the right end: T_j is even or odd about the middle.
TO_POWERS_AT_END = TO_POWERS * (-1.0) ** np.add.outer(np.arange(DEGREE + 1), np.arange(DEGREE + 1))

#: Bound on the change of the coefficients of t^k per error of the polynomial.
SENSITIVITY = np.abs(TO_POWERS).sum(axis=1)


@dataclass(frozen=True, eq=False)
class Fit:
    """Polynomials of m intervals with r rows.

    Attributes:
        powers: coefficients of t^k from the left end on, t = 1 at the right end, shape (r, m, DEGREE + 1).
        powers_at_end: coefficients about the right end.
        error: estimated largest error, shape (m,).
        follows: whether it is within the tolerance, shape (m,).
    """

    powers: np.ndarray
    powers_at_end: np.ndarray
    error: np.ndarray
    follows: np.ndarray

    @property
    def size(self) -> int:
        """The number r of rows."""
        return len(self.powers)

    def at(self, k: int) -> Fit:
        """The fit of one interval."""
        one = slice(k, k + 1)
        return Fit(self.powers[:, one], self.powers_at_end[:, one], self.error[one], self.follows[one])

    def begins_from_zero(self, error: float) -> np.ndarray:
        """The left coefficients, with those within the error set to zero."""
        return np.where(np.abs(self.powers) > JOINT_SAFETY * error * SENSITIVITY, self.powers, 0.0)

    def ends_at_zero(self, error: float) -> np.ndarray:
        """The right coefficients, with those within the error set to zero."""
        return np.where(np.abs(self.powers_at_end) > JOINT_SAFETY * error * SENSITIVITY, self.powers_at_end, 0.0)

    def jumps(self, error: float, ratio: np.ndarray) -> np.ndarray:
        """Changes of the coefficients from one interval to the next, in the unit of the next, shape (r, m - 1, DEGREE + 1)."""
        scale = (ratio[:-1] / ratio[1:])[:, None] ** np.arange(DEGREE + 1.0)
        change = self.powers[:, 1:] - self.powers_at_end[:, :-1] * scale
        return np.where(np.abs(change) > JOINT_SAFETY * error * SENSITIVITY * (1 + scale), change, 0.0)

    def breaks(self, other: Fit, ratio: float, error: float) -> bool:
        """Whether value, slope or curvature jump to the next interval, which is shorter by the ratio."""
        own, others = (max(1.0, side) ** -np.arange(3.0) for side in (ratio, 1 / ratio))  # in units of the shorter one
        change = np.abs(other.powers[:, 0, :3] * others - self.powers_at_end[:, 0, :3] * own)
        return bool((change > JOINT_SAFETY * error * SENSITIVITY[:3] * (own + others)).any())

    def bend(self, other: Fit, own_ratio: float, other_ratio: float) -> float:
        """Change of slope and curvature to the next interval, with a unit of length over the lengths of both."""
        own, others = (ratio ** np.arange(1.0, 3.0) for ratio in (own_ratio, other_ratio))
        return float(np.abs(other.powers[:, 0, 1:3] * others - self.powers_at_end[:, 0, 1:3] * own).max())

    def meetings(self, other: Fit, length: float, other_length: float, gap: float) -> list[float]:
        """Times after the end of this interval at which its parabola meets that of an interval that begins a gap later.

        Where the parabolas only touch, or nearly so, it is the time of their least distance. This locates a kink close to
        an end of an interval, where the interpolation points missed it.
        """
        own = self.powers_at_end[:, 0, :3] / length ** np.arange(3.0)
        zero, one, two = (other.powers[:, 0, :3] / other_length ** np.arange(3.0)).T
        moved = np.stack([zero - gap * one + gap**2 * two, one - 2 * gap * two, two], axis=1)
        difference = moved - own
        row = int((np.abs(difference) * length ** np.arange(3.0))[:, 1:].max(axis=1).argmax())
        return [float(root.real) for root in np.roots(difference[row, ::-1])]


def fitted(values: np.ndarray, largest: float, tolerance: float) -> Fit:
    """Polynomials through the values at NODES, compared with those at CHECKS; values of shape (r, m, nodes and checks)."""
    at_nodes, at_checks = values[..., : DEGREE + 1], values[..., DEGREE + 1 :]
    coefficients = at_nodes @ TO_CHEBYSHEV.T
    coefficients = np.where(np.abs(coefficients) <= COEFFICIENT_NOISE * EPS * largest, 0.0, coefficients)
    missed = np.abs(coefficients @ chebyshev.chebvander(2 * CHECKS - 1, DEGREE).T - at_checks).max(axis=(0, 2))
    tail = np.abs(coefficients[..., -2:]).sum(axis=2).max(axis=0)
    rounding = EPS * (np.abs(coefficients) @ np.abs(TO_POWERS).T).sum(axis=2).max(axis=0)
    error = np.maximum(missed, tail)
    powers, powers_at_end = coefficients @ TO_POWERS.T, coefficients @ TO_POWERS_AT_END.T
    return Fit(powers, powers_at_end, error, np.maximum(error, rounding) <= tolerance * largest)
