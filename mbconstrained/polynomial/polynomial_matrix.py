"""The polynomial matrix A(s) of a system A(d/dt) x = f."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from numbers import Number

import numpy as np

from ..ground.checks import constant_zeros, names_of, real_array, real_number
from ..ground.errors import IllConditioned, InputError
from ..linalg.staircase import SingularPencil
from .companion import scaled_companion
from .direct_reduction import reduction_of
from .jordan_pairs import JordanPairs, jordan_pairs
from .reduced_equations import NotReducible, Reduction
from .structure import Structure


class PolynomialMatrix:
    """A(s) = A_0 + A_1 s + ... + A_q s^q, real and square, of any declared degree q >= 0 (Moysis et al., Eq. 4).

    Args:
        coefficients: A_0 ... A_q in ascending powers, each of shape (r, r), as an array, as ``Factors`` or by its
            elements (``mb.ElementMatrix``). A_q may be singular or zero.
        coordinates: names of the r entries of x (x1, x2, ... when not given).
        equations: names of the r rows (equation 1, ... when not given).
        uncertainty: by how much entries may be wrong, in their own units, shape (q + 1, r, r); where it is less than a unit in
            the last place, or not given, entries are taken to be rounded. Rank decisions are made against it.

    Raises:
        InputError: not square, of different shapes, not finite or not real.

    >>> A = PolynomialMatrix([[[1.0]], [[2.0]], [[1.0]]])
    >>> A.degree, A.size, A(-1).tolist()
    (2, 1, [[0.0]])
    """

    def __init__(
        self,
        coefficients: Iterable,
        coordinates: Sequence[str] | None = None,
        equations: Sequence[str] | None = None,
        uncertainty=None,
    ):
        if not isinstance(coefficients, Iterable):
            raise InputError(f"coefficients: found {coefficients!r}; expected a list of square matrices [A_0, A_1, ...]")
        given = [_factors_of(matrix) for matrix in coefficients]
        self.factors = tuple(matrix if isinstance(matrix, Factors) else None for matrix in given)
        matrices = [_assembled(matrix, f"A_{power}") for power, matrix in enumerate(given)]
        if not matrices:
            raise InputError("a polynomial matrix needs at least one coefficient, A_0; none was given")
        for power, matrix in enumerate(matrices):
            if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
                raise InputError(f"A_{power}: expected a square matrix, found shape {matrix.shape}")
            if matrix.shape != matrices[0].shape:
                raise InputError(f"A_{power} has shape {matrix.shape}, but A_0 has {matrices[0].shape}; all must agree")
        self.coefficients = np.array(matrices)
        self.coefficients.flags.writeable = False
        shape = self.coefficients.shape
        self.uncertainty = (
            constant_zeros(shape) if uncertainty is None else np.abs(real_array(uncertainty, "uncertainty", shape=shape))
        )
        self._pairs: dict[float | None, JordanPairs] = {}
        self._like: PolynomialMatrix | None = None
        self._order: np.ndarray | None = None
        self.coordinates = names_of(coordinates, self.size, "coordinates", "x")
        self.equations = names_of(equations, self.size, "equations", "equation ")

    @property
    def exact_coefficients(self) -> np.ndarray:
        """The coefficients, shape (q + 1, r, r), exact Fractions of those that are given by their factors."""
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
    def size(self) -> int:
        """The number of rows and columns r."""
        return self.coefficients.shape[1]

    def __call__(self, s: complex) -> np.ndarray:
        """A(s) at a finite number s, real or complex, shape (r, r), by Horner's rule."""
        if not isinstance(s, Number) or not np.isfinite(s):
            raise InputError(f"s: found {s!r}; expected a finite number, real or complex")
        value = np.zeros((self.size, self.size))
        for matrix in self.coefficients[::-1]:
            value = value * s + matrix
        return value

    def __repr__(self) -> str:
        return f"PolynomialMatrix(degree={self.degree}, size={self.size})"

    @property
    def dual(self) -> PolynomialMatrix:
        """s^q A(1/s), the coefficients in reverse (Moysis et al., Eq. 11): its zeros at 0 are those of A at infinity."""
        given = [self.coefficients[power] if factors is None else factors for power, factors in enumerate(self.factors)]
        return PolynomialMatrix(given[::-1], self.coordinates, self.equations, self.uncertainty[::-1])

    @cached_property
    def reduction(self) -> Reduction | NotReducible:
        """Its reduction to first-order equations, or the condition that it does not meet (``polynomial.direct_reduction``)."""
        like = None if self._like is None else self._like.reduction
        result = reduction_of(self, like if isinstance(like, Reduction) else None)
        if self._like is not None and isinstance(result, Reduction) and isinstance(like, Reduction) and like.wide_modes is not None:
            return replace(result, order=self._order)
        return result

    def moved(self, random: np.random.Generator, move: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> PolynomialMatrix:
        """The same with entries moved by rounding errors, or values of a coefficient that is given by its factors; what is free
        stays free.

        Where the method is so accurate that moved data would show the condition of the data alone, these stay, and its coordinates
        are taken in another order: all its rounding errors are others.

        Args:
            random: the source of the order.
            move: returns the moved entries from given ones and their uncertainty.

        Returns:
            Another A(s).
        """
        result = PolynomialMatrix(self._moved_coefficients(move), self.coordinates, self.equations, self.uncertainty)
        like = self.reduction
        if isinstance(like, Reduction) and like.wide_modes is not None:
            result = PolynomialMatrix(self.coefficients, self.coordinates, self.equations, self.uncertainty)
            result._order = random.permutation(len(like.second))
        result._like = self
        return result

    def _moved_coefficients(self, move) -> list:
        return [
            move(matrix, uncertainty) if factors is None else replace(factors, values=move(factors.values, np.zeros(())))
            for matrix, factors, uncertainty in zip(self.coefficients, self.factors, self.uncertainty)
        ]

    @property
    def is_regular(self) -> bool:
        """False where det A(s) = 0 for every s; True also where float64 cannot tell the structure of a regular A(s)."""
        try:
            scaled_companion(self).split
        except SingularPencil:
            return False
        except IllConditioned:  # said of regular matrices only
            return True
        return True

    def structure(self, rank_tolerance: float | None = None) -> Structure:
        """Finite zeros with multiplicities, pole and zero orders q_i at infinity, infinite elementary divisors (Moysis et al., Eqs.
        5-15).

        Args:
            rank_tolerance: as of ``jordan_pairs``.

        Returns:
            A ``Structure``; ``mb.exact.structure(A)`` gives that of the exact numbers, with the Smith form.

        Raises:
            SingularPolynomialMatrix, IllConditioned: as ``jordan_pairs``.

        >>> A = PolynomialMatrix([[[1.0, 0.0], [0.0, 1.0]], [[2.0, 1.0], [0.0, 0.0]], [[1.0, 0.0], [0.0, 0.0]]])
        >>> A.structure().infinite_divisors, A.structure().finite_zeros[0].partial_multiplicities
        ((0, 2), (2,))
        """
        return self.jordan_pairs(rank_tolerance).structure

    def jordan_pairs(self, rank_tolerance: float | None = None) -> JordanPairs:
        """The finite pair (C, J, B) and the infinite pair (C_inf, J_inf, B_inf), computed once for each tolerance.

        A(s)^-1 = C (s I - J)^-1 B + C_inf (I - s J_inf)^-1 B_inf (Moysis et al., Theorem 2.8), from the scaled companion pencil by
        a staircase (Van Dooren 1979) and the QZ algorithm.

        Args:
            rank_tolerance: a difference of entries counts as zero if it is no larger than this fraction of them; None for the
                rounding error of float64 (zero for what is known exactly, by its elements).

        Returns:
            ``JordanPairs`` with ``finite`` (C, J, B), shapes (r, n), (n, n), (n, r), ``infinite``, ``structure``, ``evidence`` and
            ``laurent(i)`` = H_i, shape (r, r). ``mb.exact.jordan_pairs(A)`` gives true Jordan chains in Fractions.

        Raises:
            SingularPolynomialMatrix: det A(s) = 0 for every s.
            IllConditioned: float64 cannot tell the structure of A(s).
            InputError: the tolerance is no number >= 0.

        >>> pairs = PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]]).jordan_pairs()
        >>> pairs.finite.J.tolist()
        [[0.0, 2.0], [-2.0, 0.0]]
        """
        if rank_tolerance is not None:
            rank_tolerance = real_number(rank_tolerance, "rank_tolerance", minimum=0.0)
        if rank_tolerance not in self._pairs:
            self._pairs[rank_tolerance] = jordan_pairs(self, rank_tolerance)
        return self._pairs[rank_tolerance]


def _factors_of(matrix):
    """B^T diag(k) B where a coefficient is given by its elements, directions B and constants k; itself otherwise."""
    if hasattr(matrix, "directions") and hasattr(matrix, "constants"):
        return Factors(matrix.directions.T, matrix.constants, matrix.directions)
    return matrix


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


@dataclass(frozen=True, eq=False)
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
    def _entries(self) -> dict[tuple[int, int], Fraction]:
        """The entries to which an element contributes, by row and column."""
        entries: dict[tuple[int, int], Fraction] = {}
        for column, value, row in zip(self.left.T, self.values, self.right):
            right = [(j, Fraction(float(row[j]))) for j in np.flatnonzero(row).tolist()]
            for i in np.flatnonzero(column).tolist():
                left = Fraction(float(column[i])) * Fraction(float(value))
                for j, factor in right:
                    entries[i, j] = entries.get((i, j), 0) + left * factor
        return entries

    @property
    def _shape(self) -> tuple[int, int]:
        return len(self.left), self.right.shape[1]

    @cached_property
    def exact(self) -> np.ndarray:
        """The matrix as Fractions, shape (r, r)."""
        total = np.full(self._shape, Fraction(0), dtype=object)
        for place, entry in self._entries.items():
            total[place] = entry
        return total

    @cached_property
    def matrix(self) -> np.ndarray:
        """The nearest float64 matrix, shape (r, r)."""
        total = np.zeros(self._shape)
        for place, entry in self._entries.items():
            total[place] = float(entry)
        return total
