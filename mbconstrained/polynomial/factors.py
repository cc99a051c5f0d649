"""A coefficient of A(s) as the sum of its elements, from which it is known to more digits than float64 can hold.

A stiffness matrix assembled from springs of very different stiffness has lost the soft ones: 1e16 + 1 is 1e16. Its factors
L diag(v) R, such as those of B^T diag(k) B, have not.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class Factors:
    """The matrix left @ diag(values) @ right, all entries meant as the exact numbers that they are.

    Attributes:
        left: L, shape (r, m).
        values: v, shape (m,): stiffnesses, dampings, masses; what is uncertain about the matrix.
        right: R, shape (m, r).

    >>> stiff = Factors(np.array([[1.0, -1.0], [0.0, 1.0]]), np.array([1.0, 1e16]), np.array([[1.0, 0.0], [-1.0, 1.0]]))
    >>> float(stiff.matrix[0, 0]), stiff.exact[0, 0]
    (1e+16, Fraction(10000000000000001, 1))
    """

    left: np.ndarray
    values: np.ndarray
    right: np.ndarray

    @cached_property
    def exact(self) -> np.ndarray:
        """The matrix as Fractions, shape (r, r)."""
        total = np.full((len(self.left), self.right.shape[1]), Fraction(0), dtype=object)
        for column, value, row in zip(self.left.T, self.values, self.right):
            i, j = np.flatnonzero(column), np.flatnonzero(row)
            total[np.ix_(i, j)] += np.multiply.outer(_fractions(column[i]) * Fraction(float(value)), _fractions(row[j]))
        return total

    @cached_property
    def matrix(self) -> np.ndarray:
        """The nearest float64 matrix, shape (r, r)."""
        return self.exact.astype(float)


def _fractions(array: np.ndarray) -> np.ndarray:
    return np.array([Fraction(float(value)) for value in array], dtype=object)
