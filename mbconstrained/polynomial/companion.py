"""A(s) as a first-order pencil s E - F with states x, x', ..., x^(q-1), in units of its own.

E = diag(I, ..., I, A_q), F = [[0, I, ..., 0], ..., [-A_0, ..., -A_(q-1)]] is a strong linearization: it has the
finite and the infinite elementary divisors of A(s), and its solutions from values at 0- are those of
A(d/dt) x = f exactly, impulses included, because every row but the last only says that the next state is
the derivative of the one before.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..linalg.scaling import Scaling, joint_scaling
from ..linalg.staircase import SplitPencil, split_regular
from .matrix import PolynomialMatrix


@dataclass(frozen=True)
class ScaledCompanion:
    """The companion pencil of the scaled coefficients.

    Attributes:
        coefficients: scaled A_0 ... A_g with g = max(q, 1), shape (g + 1, r, r).
        scaling: the powers of two used.
    """

    coefficients: np.ndarray
    scaling: Scaling

    @property
    def size(self) -> int:
        """r."""
        return self.coefficients.shape[1]

    @property
    def grade(self) -> int:
        """g, the number of stacked derivatives."""
        return len(self.coefficients) - 1

    @cached_property
    def E(self) -> np.ndarray:
        """Shape (g r, g r)."""
        r, g = self.size, self.grade
        E = np.eye(g * r)
        E[(g - 1) * r :, (g - 1) * r :] = self.coefficients[g]
        return E

    @cached_property
    def F(self) -> np.ndarray:
        """Shape (g r, g r)."""
        r, g = self.size, self.grade
        F = np.eye(g * r, k=r)
        F[(g - 1) * r :] = -np.hstack(self.coefficients[:g])
        return F

    @cached_property
    def split(self) -> SplitPencil:
        """The finite and the infinite part.

        Raises:
            SingularPencil: det A(s) = 0 for every s.
        """
        return split_regular(self.E, self.F)

    def scaled_stack(self, initial: np.ndarray) -> np.ndarray:
        """Values (q, r) at 0- as the pencil's state (g r,), in its units."""
        stack = np.zeros((self.grade, self.size))
        powers = self.scaling.time ** -np.arange(len(initial), dtype=float)
        stack[: len(initial)] = initial * powers[:, None] / self.scaling.columns
        return stack.reshape(-1)


def scaled_companion(A: PolynomialMatrix) -> ScaledCompanion:
    """The companion pencil of A(s) in units chosen from its entries."""
    coefficients = A.coefficients
    if A.degree == 0:  # a pencil needs a first power: declare one
        coefficients = np.concatenate([coefficients, np.zeros_like(coefficients)])
    scaling = joint_scaling(coefficients)
    return ScaledCompanion(scaling.apply(coefficients), scaling)
