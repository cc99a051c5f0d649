"""A(s) as a first-order pencil s E - F with states x, x', ..., x^(q-1), in scaled units.

E = diag(I, ..., I, A_q), F = [[0, I, ..., 0], ..., [-A_0, ..., -A_(q-1)]] is a strong linearization: it has the
finite and the infinite elementary divisors of A(s), and its solutions from values at 0- are those of
A(d/dt) x = f exactly, impulses included, because every row but the last only states that the next state is
the derivative of the one before.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..ground.tolerances import EPS, NOISE_SAFETY
from ..linalg.precise import is_precise, magnitude, of_kind, precise, zero_multiplicity
from ..linalg.rounding import Noisy
from ..linalg.scaling import Scaling, joint_scaling
from ..linalg.staircase import SplitPencil, split_regular
from .coefficients import PolynomialCoefficients


@dataclass(frozen=True, eq=False)
class ScaledCompanion:
    """The companion pencil of the scaled coefficients.

    Attributes:
        known: scaled A_0 ... A_g with g = max(q, 1), shape (g + 1, r, r), in float64 or precise, and how well they are known.
        scaling: the powers of two used.
    """

    known: Noisy
    scaling: Scaling

    @property
    def is_precise(self) -> bool:
        """True where the coefficients have more digits than float64."""
        return is_precise(self.known.data)

    @cached_property
    def coefficients(self) -> np.ndarray:
        """The coefficients in float64."""
        return self.known.data.astype(float)

    @property
    def size(self) -> int:
        """r."""
        return self.known.data.shape[1]

    @property
    def grade(self) -> int:
        """g, the number of stacked derivatives."""
        return len(self.known.data) - 1

    @property
    def state_count(self) -> int:
        """g r, the size of the pencil."""
        return self.grade * self.size

    @property
    def E(self) -> np.ndarray:
        """Shape (g r, g r), in float64."""
        return self.pencil[0].data.astype(float)

    @cached_property
    def pencil(self) -> tuple[Noisy, Noisy]:
        """E and F with their uncertainty."""
        r, g = self.size, self.grade
        E, F = (Noisy.exact(of_kind(np.eye(g * r, k=shift), self.known.data)) for shift in (0, r))
        last = slice((g - 1) * r, None)
        E[last, last] = self.known[g]
        for power in range(g):
            F[last, power * r : (power + 1) * r] = -self.known[power]
        return E, F

    @cached_property
    def split(self) -> SplitPencil:
        """The finite and the infinite part.

        Raises:
            SingularPencil: det A(s) = 0 for every s.
        """
        return split_regular(*self.pencil)

    def scaled_stack(self, initial: np.ndarray) -> np.ndarray:
        """Values (q, r) at 0- as the pencil's state (g r,), in its units; S of them, (q, r, S), as (g r, S)."""
        stack = np.zeros((self.grade, *initial.shape[1:]))
        powers = self.scaling.time ** -np.arange(len(initial), dtype=float)
        stack[: len(initial)] = (initial.T * powers / self.scaling.columns[:, None]).T
        return stack.reshape(-1, *initial.shape[2:])


def scaled_companion(A: PolynomialCoefficients, rank_tolerance: float | None = None, in_float64: bool = True) -> ScaledCompanion:
    """The companion pencil of A(s) in units chosen from its entries, in float64 or precise.

    Entries given in float64 are known to a unit in the last place, a coefficient given by its factors is known exactly; where
    a rank tolerance is given, a difference of entries counts as zero if it is no larger than that part of them.
    """
    exact = _with_first_power(A.coefficients if in_float64 else precise(A.exact_coefficients))
    scaling = joint_scaling(_with_first_power(_telling(A)))
    scaled = scaling.apply(exact)
    if rank_tolerance is not None:
        known = np.full(len(exact), rank_tolerance / NOISE_SAFETY)
    else:
        by_factors = [factors is not None and not in_float64 for factors in A.factors]
        known = np.where([*by_factors, True][: len(exact)], 0.0, EPS)
    noise = known[:, None, None] * magnitude(scaled)
    if rank_tolerance is None:
        noise = np.maximum(noise, scaling.apply(_with_first_power(A.uncertainty)))
    return ScaledCompanion(Noisy(scaled, noise), scaling)


def multiplicity_at_zero(A: PolynomialCoefficients) -> int:
    """The multiplicity of s = 0 as a zero of a regular det A(s) with exact entries."""
    *lower, highest = _with_first_power(A.exact_coefficients)
    states, last = len(lower) * A.size, slice((len(lower) - 1) * A.size, None)
    E, F = np.eye(states, dtype=object), np.eye(states, k=A.size, dtype=object)
    E[last, last], F[last] = highest, -np.hstack(lower)
    return zero_multiplicity(E, F)


def _telling(A: PolynomialCoefficients) -> np.ndarray:
    """The coefficients without entries that may be zero, which have no size for scaling.

    Those are within their uncertainty, or rounding errors of the largest of their row and of the largest of their column, in one
    coefficient: what computed matrices have in place of zeros.
    """
    size = np.abs(A.coefficients)
    rounding = EPS * np.minimum(size.max(axis=1, keepdims=True, initial=0.0), size.max(axis=2, keepdims=True, initial=0.0))
    return np.where(size > np.maximum(NOISE_SAFETY * A.uncertainty, rounding), A.coefficients, 0.0)


def _with_first_power(coefficients: np.ndarray) -> np.ndarray:
    """The coefficients with a first power, which a pencil needs, added where there is none."""
    return coefficients if len(coefficients) > 1 else np.concatenate([coefficients, 0 * coefficients])


def known_coefficient(A: PolynomialCoefficients, power: int) -> Noisy:
    """A_power with its uncertainty: precise and exact where it is given by its factors."""
    factors = A.factors[power]
    known = Noisy.rounded(A.coefficients[power]) if factors is None else Noisy.exact(precise(factors.exact))
    return Noisy(known.data, np.maximum(known.noise, A.uncertainty[power]))
