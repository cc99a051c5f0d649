"""The polynomial matrix A(s) of a system A(d/dt) x = f."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from numbers import Number
from typing import TYPE_CHECKING

import numpy as np

from ..checks import constant_zeros, names_of, real_array, real_number
from ..errors import IllConditioned, InputError
from .factors import Factors

if TYPE_CHECKING:
    from ..exact.rational import ExactJordanPairs
    from ..jordan.pairs import JordanPairs
    from .reduction import Reduction
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
        self.uncertainty = constant_zeros(shape) if uncertainty is None else np.abs(real_array(uncertainty, "uncertainty", shape=shape))
        self._pairs: dict[float | str | None, JordanPairs | ExactJordanPairs] = {}
        self.coordinates = names_of(coordinates, self.size, "coordinates", "x")
        self.equations = names_of(equations, self.size, "equations", "equation ")

    @property
    def exact_coefficients(self) -> np.ndarray:
        """The coefficients, shape (q + 1, r, r), exact Fractions of those that are given by their factors."""
        found = self.coefficients.astype(object)
        for power, factors in enumerate(self.factors):
            if factors is not None:
                found[power] = factors.exact
        return found

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
    def reduction(self) -> Reduction | None:
        """Its reduction to first-order equations, None where its structure is not so plain (``polynomial.plain``)."""
        from .plain import reduction_of

        return reduction_of(self)

    @property
    def is_regular(self) -> bool:
        """False where det A(s) = 0 for every s; True also where float64 cannot tell the structure of a regular A(s)."""
        from ..linalg.staircase import SingularPencil
        from .companion import scaled_companion

        try:
            scaled_companion(self).split
        except SingularPencil:
            return False
        except IllConditioned:  # said of regular matrices only
            return True
        return True

    def structure(self, rank_tolerance: float | None = None, *, exact: bool = False) -> Structure:
        """Finite zeros with multiplicities, pole and zero orders q_i at infinity, infinite elementary divisors.

        Args:
            rank_tolerance, exact: see ``jordan_pairs``. Of exact=True an ``ExactStructure``: also the determinant, the
                elementary divisors over the rationals and the Smith form.

        >>> A = PolynomialMatrix([[[1.0, 0.0], [0.0, 1.0]], [[2.0, 1.0], [0.0, 0.0]], [[1.0, 0.0], [0.0, 0.0]]])
        >>> A.structure().infinite_divisors, A.structure(exact=True).finite_zeros[0].partial_multiplicities
        ((0, 2), (2,))
        """
        return self.jordan_pairs(rank_tolerance, exact=exact).structure

    def jordan_pairs(self, rank_tolerance: float | None = None, *, exact: bool = False) -> JordanPairs | ExactJordanPairs:
        """The finite pair (C, J, B) and the infinite pair (C, J, B), see ``mbconstrained.jordan``.

        Args:
            rank_tolerance: a difference of entries counts as zero if it is no larger than this part of them; None for the
                rounding noise of float64 (of what is known exactly, by its elements, nothing is lost).
            exact: True for true Jordan chains and pairs in Fractions, every entry of A(s) taken as the exact number that it is,
                see ``mbconstrained.exact.rational``.

        Raises:
            SingularPolynomialMatrix: det A(s) = 0 for every s.
            IllConditioned: float64 cannot tell the structure of A(s).
            InputError: exact arithmetic and a tolerance are asked for together.
        """
        if exact:
            return self._exact_pairs(rank_tolerance)
        if rank_tolerance is not None:
            rank_tolerance = real_number(rank_tolerance, "rank_tolerance", minimum=0.0)
        if rank_tolerance not in self._pairs:
            from ..jordan.pairs import jordan_pairs

            self._pairs[rank_tolerance] = jordan_pairs(self, rank_tolerance)
        return self._pairs[rank_tolerance]

    def _exact_pairs(self, rank_tolerance) -> ExactJordanPairs:
        if rank_tolerance is not None:
            raise InputError(
                f"rank_tolerance: found {rank_tolerance!r} with exact=True, where nothing is rounded; give one or the other"
            )
        if "exact" not in self._pairs:
            from ..exact.rational import exact_jordan_pairs

            self._pairs["exact"] = exact_jordan_pairs(self)
        return self._pairs["exact"]


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
