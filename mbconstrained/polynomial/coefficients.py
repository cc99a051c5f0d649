"""The coefficients of A(s) = A_0 + A_1 s + ... + A_q s^q, as they were given."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from ..ground.by_name import Public, answering
from ..ground.checks import constant_zeros, counted, names_of, real_array
from ..ground.errors import InputError, SingularPolynomialMatrix


@answering
class PolynomialCoefficients(Public):
    """Data of a ``PolynomialMatrix``, without the answers to questions about it."""

    def __init__(
        self,
        coefficients: Iterable,
        coordinates: Sequence[str] | None = None,
        equations: Sequence[str] | None = None,
        uncertainty=None,
    ):
        if not isinstance(coefficients, Iterable):
            raise InputError(f"coefficients: found {coefficients!r}; expected a list of matrices [A_0, A_1, ...]")
        given = [  # the element matrix B^T diag(k) B of a coefficient given by its elements, directions B and constants k
            matrix.factors if hasattr(matrix, "directions") else matrix for matrix in coefficients
        ]
        self.factors = tuple(matrix if isinstance(matrix, Factors) else None for matrix in given)
        matrices = [
            matrix if type(matrix) is np.ndarray and matrix.dtype == float else _assembled(matrix, f"A_{power}")
            for power, matrix in enumerate(given)
        ]
        if not matrices:
            raise InputError("a polynomial matrix needs at least one coefficient, A_0; none was given")
        for power, matrix in enumerate(matrices):
            if matrix.ndim != 2:
                raise InputError(f"A_{power}: expected a matrix, found shape {matrix.shape}")
            if matrix.shape != matrices[0].shape:
                raise InputError(f"A_{power} has shape {matrix.shape}, but A_0 has {matrices[0].shape}; all must agree")
        self.coefficients = np.array(matrices)
        if not np.isfinite(self.coefficients).all():
            for power, matrix in enumerate(matrices):
                real_array(matrix, f"A_{power}")
        self.coefficients.flags.writeable = False
        shape = self.coefficients.shape
        self.uncertainty = (
            constant_zeros(shape) if uncertainty is None else np.abs(real_array(uncertainty, "uncertainty", shape=shape))
        )
        self.is_uncertain = uncertainty is not None and bool(self.uncertainty.any())
        self._pairs: dict = {}
        self.coordinates = names_of(coordinates, shape[2], "coordinates", "x")
        self.equations = names_of(equations, shape[1], "equations", "equation ")

    @property
    def exact_coefficients(self) -> np.ndarray:
        """The coefficients, shape (q + 1, m, n), exact Fractions of those that are given by their factors."""
        result = self.coefficients.astype(object)
        for power, factors in enumerate(self.factors):
            if factors is not None:
                result[power] = factors.exact
        return result

    @property
    def degree(self) -> int:
        """The declared degree q (the number of coefficients less one)."""
        return len(self.coefficients) - 1

    @property
    def shape(self) -> tuple[int, int]:
        """The numbers of equations and of coordinates, (m, n)."""
        return self.coefficients.shape[1:]

    @property
    def is_square(self) -> bool:
        """True with as many equations as coordinates."""
        return self.shape[0] == self.shape[1]

    @property
    def size(self) -> int:
        """The number r of equations, and of coordinates, where these are as many.

        Raises:
            SingularPolynomialMatrix: other numbers of equations and coordinates, which determine no motion.
        """
        _, rows, columns = self.coefficients.shape
        if rows != columns:
            self.check_square()
        return rows

    def check_square(self) -> None:
        """Check that there are as many equations as coordinates.

        Raises:
            SingularPolynomialMatrix: other numbers of them, which determine no motion.
        """
        if not self.is_square:
            raise SingularPolynomialMatrix(_not_square(*self.shape))

    def __repr__(self) -> str:
        size = f"size={self.size}" if self.is_square else f"shape={self.shape}"
        return f"{type(self).__name__}(degree={self.degree}, {size})"


def _not_square(equations: int, coordinates: int) -> str:
    """Text on numbers of equations and coordinates that differ, with a remedy."""
    text = (
        f"A(s) has {counted(equations, 'equation')} for {counted(coordinates, 'coordinate')}, but a motion is determined by as many"
    )
    if equations < coordinates:
        remedy = (
            "some coordinates can move without any force. Attach them (by a mass, spring, damper, constraint or prescribed motion)"
        )
    else:
        remedy = "some equations are redundant or contradict others. Leave those out"
    return f"{text}: {remedy}; A.structure() shows which they are."


def _assembled(matrix, what: str) -> np.ndarray:
    if not isinstance(matrix, Factors):
        return real_array(matrix, what)
    try:
        return matrix.matrix
    except OverflowError:
        raise InputError(f"{what}: its elements add up to an entry beyond the range of float64; choose other units") from None


# A coefficient of A(s) as the sum of its elements, from which it is known to more digits than float64 can hold.
#
# A stiffness matrix assembled from springs of very different stiffness has lost the soft ones: 1e16 + 1 is 1e16. Its factors
# L diag(v) R, such as those of B^T diag(k) B, have not.


#: Sums of elements of so many rows at most are products of matrices, those of more go term by term.
DENSE_SIZE = 64


@dataclass(frozen=True, eq=False)
class Factors:
    """The matrix left @ diag(values) @ right with exact entries.

    Attributes:
        left: L, shape (r, m).
        values: v, shape (m,): stiffnesses, dampings, masses; what is uncertain about the matrix.
        right: R, shape (m, r).
    """

    left: np.ndarray
    values: np.ndarray
    right: np.ndarray

    @cached_property
    def _terms(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The terms left * value * right by entry: their factors, shape (3, t), and of each entry its row, column and first term."""
        element, row = self.left.T.nonzero()
        owner, column = self.right.nonzero()
        counts = np.bincount(owner, minlength=len(self.values))
        begin = (np.cumsum(counts) - counts)[element]
        counts = counts[element]
        first = np.repeat(np.arange(len(element)), counts)
        second = np.arange(len(first)) + np.repeat(begin - np.cumsum(counts) + counts, counts)
        element, row, column = element[first], row[first], column[second]
        places = row * self._shape[1] + column
        order = np.argsort(places, kind="stable")
        element, row, column, places = element[order], row[order], column[order], places[order]
        begin = np.flatnonzero(np.diff(places, prepend=-1))
        factors = np.array([self.left[row, element], self.values[element], self.right[element, column]])
        return factors, row[begin], column[begin], begin

    @property
    def _shape(self) -> tuple[int, int]:
        return len(self.left), self.right.shape[1]

    @cached_property
    def exact(self) -> np.ndarray:
        """The matrix as Fractions, shape (r, r)."""
        total = np.full(self._shape, Fraction(0), dtype=object)
        factors, row, column, begin = self._terms
        for i, j, own in zip(row, column, np.split(factors, begin[1:], axis=1)):
            total[i, j] = _exact_sum(own)
        return total

    @cached_property
    def matrix(self) -> np.ndarray:
        """The nearest float64 matrix, shape (r, r): every entry is the exact sum of its terms, rounded once."""
        signs = np.abs(self.left), np.abs(self.right)
        if (
            len(self.left) <= DENSE_SIZE
            and all(((part == 0) | (part == 1)).all() for part in signs)
            and (signs[0] @ signs[1]).max(initial=0.0) <= 2
        ):
            with np.errstate(over="ignore", invalid="ignore"):
                total = (self.left * self.values) @ self.right + 0.0  # no negative zeros; two terms are rounded once
            if np.isfinite(total).all():
                return total
        factors, row, column, begin = self._terms
        total = np.zeros(self._shape)
        if not len(begin):
            return total
        (left, values, right), counts = factors, np.diff(begin, append=factors.shape[1])
        with np.errstate(over="ignore", invalid="ignore"):
            sums = np.add.reduceat(left * values * right, begin) + 0.0  # no negative zeros
        unit = np.logical_and.reduceat((np.abs(left) == 1) & (np.abs(right) == 1), begin)
        rounded_once = unit & (counts <= 2) & np.isfinite(sums)
        for place in np.flatnonzero(~rounded_once).tolist():
            sums[place] = float(_exact_sum(factors[:, begin[place] : begin[place] + counts[place]]))
        total[row, column] = sums
        return total


def _exact_sum(factors: np.ndarray) -> Fraction:
    """The sum of products, from their factors, shape (3, t)."""
    return sum((Fraction(a) * Fraction(b) * Fraction(c) for a, b, c in factors.T.tolist()), Fraction(0))
