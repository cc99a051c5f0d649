"""The polynomial matrix A(s) of a system A(d/dt) x = f."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from numbers import Number

import numpy as np

from ..ground.by_name import answering
from ..ground.checks import real_number
from ..ground.errors import IllConditioned, InputError, SingularPolynomialMatrix, within_float64
from ..linalg.staircase import SingularPencil
from .coefficients import PolynomialCoefficients
from .decoupling import scaled_companion
from .direct_reduction import reduction_of
from .jordan_pairs import JordanPairs, jordan_pairs
from .kronecker_form import kronecker_structure
from .reduced_equations import NotReducible, Reduction
from .structure import Structure

#: With more states, degree times size, the QZ algorithm of the Jordan pairs takes longer than all else.
MOST_PAIR_STATES = 150


@answering
class PolynomialMatrix(PolynomialCoefficients):
    """A(s) = A_0 + A_1 s + ... + A_q s^q, real, of any declared degree q >= 0 (Moysis et al., Eq. 4).

    Motions, eigenvalues and responses need a regular A(s): square, and det A(s) not zero for every s. Of every other one, with any
    numbers of equations and coordinates, ``structure`` shows which coordinates are free and which equations are redundant.

    Args:
        coefficients: A_0 ... A_q in ascending powers, each of shape (m, n), as an array, as ``Factors`` or by its
            elements (``mb.ElementMatrix``). A_q may be singular or zero.
        coordinates: names of the n entries of x, the columns (x1, x2, ... when not given).
        equations: names of the m rows (equation 1, ... when not given).
        uncertainty: by how much entries may be wrong, in their own units, shape (q + 1, m, n); where it is less than a unit in
            the last place, or not given, entries are taken to be rounded. Rank decisions are made against it.

    Raises:
        InputError: no matrices, of different shapes, not finite or not real.

    >>> A = PolynomialMatrix([[[1.0]], [[2.0]], [[1.0]]])
    >>> A.degree, A.size, A(-1).tolist()
    (2, 1, [[0.0]])
    >>> PolynomialMatrix([[[1.0, -1.0]], [[0.0, 2.0]]]).shape
    (1, 2)
    """

    _pairs: dict[float | None, JordanPairs]
    _like: PolynomialMatrix | None = None
    _order: np.ndarray | None = None

    def __call__(self, s: complex) -> np.ndarray:
        """A(s) at a finite number s, real or complex, shape (m, n), by Horner's rule."""
        if not isinstance(s, Number) or not np.isfinite(s):
            raise InputError(f"s: found {s!r}; expected a finite number, real or complex")
        value = np.zeros(self.shape)
        for matrix in self.coefficients[::-1]:
            value = value * s + matrix
        return value

    @property
    def dual(self) -> PolynomialMatrix:
        """s^q A(1/s), the coefficients in reverse (Moysis et al., Eq. 11): its zeros at 0 are those of A at infinity."""
        given = [self.coefficients[power] if factors is None else factors for power, factors in enumerate(self.factors)]
        return PolynomialMatrix(given[::-1], self.coordinates, self.equations, self.uncertainty[::-1])

    @cached_property
    def reduction(self) -> Reduction | NotReducible:
        """Return the reduction to first-order equations, or the violated condition (``polynomial.direct_reduction``)."""
        like = None if self._like is None else self._like.reduction
        result = reduction_of(self, like if isinstance(like, Reduction) else None)
        if self._like is not None and isinstance(result, Reduction) and isinstance(like, Reduction) and like.wide_modes is not None:
            return replace(result, order=self._order)
        return result

    def moved(self, random: np.random.Generator, move: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> PolynomialMatrix:
        """Return A(s) with entries, or constants of elements, perturbed by rounding errors; free motions stay free.

        Where the method is so accurate that perturbed data would only show their condition, the data stay and the coordinates are
        permuted, which changes all rounding errors.

        Args:
            random: the source of the order.
            move: returns perturbed entries from given ones and their uncertainty.

        Returns:
            Another A(s).
        """
        moved = [
            move(matrix, uncertainty) if factors is None else replace(factors, values=move(factors.values, np.zeros(())))
            for matrix, factors, uncertainty in zip(self.coefficients, self.factors, self.uncertainty)
        ]
        result = PolynomialMatrix(moved, self.coordinates, self.equations, self.uncertainty)
        like = self.reduction
        if isinstance(like, Reduction) and like.wide_modes is not None:
            result = PolynomialMatrix(self.coefficients, self.coordinates, self.equations, self.uncertainty)
            result._order = random.permutation(len(like.second))
        result._like = self
        return result

    @property
    def is_regular(self) -> bool:
        """False where A(s) is not square or det A(s) = 0 for every s; True also where float64 cannot determine the structure of a regular A(s)."""
        if not self.is_square:
            return False
        try:
            scaled_companion(self).split
        except SingularPencil:
            return False
        except IllConditioned:  # said of regular matrices only
            return True
        return True

    @property
    def large_reduction(self) -> Reduction | None:
        """The reduction of a large A(s), which has its eigenvalues without Jordan pairs; None of a small one, or where there is none."""
        large = self.degree * self.size > MOST_PAIR_STATES
        return self.reduction if large and isinstance(self.reduction, Reduction) else None

    @property
    def eigenvalues(self) -> np.ndarray:
        """The finite zeros in 1/s, each once, of complex pairs the one above the real axis; of large A(s) by the reduced equations."""
        if self.large_reduction is not None:
            return self.large_reduction.eigenvalues
        return np.array([zero.value for zero in self.jordan_pairs().finite.zeros])

    @property
    def eigenvalue_count(self) -> int:
        """Number of finite zeros, the degree of det A(s)."""
        if self.large_reduction is not None:
            return self.large_reduction.state_count
        return sum(zero.count for zero in self.jordan_pairs().finite.zeros)

    def check_regular(self) -> None:
        """Check that A(s) is regular: where it reduces directly, the divisors make up the leading coefficient of det A(s).

        Raises:
            SingularPolynomialMatrix, IllConditioned: as ``jordan_pairs``.
        """
        if not isinstance(self.reduction, Reduction):
            self.jordan_pairs()

    def structure(self, rank_tolerance: float | None = None) -> Structure:
        """Finite zeros with multiplicities, pole and zero orders q_i at infinity, infinite elementary divisors (Moysis et al., Eqs.
        5-15), and of an A(s) that is not regular the right and left kernel with their minimal indices.

        The Kronecker form of the scaled companion pencil, by a staircase of rank decisions (Van Dooren 1979; De Teran, Dopico and
        Mackey 2009).

        Args:
            rank_tolerance: as in ``jordan_pairs``.

        Returns:
            A ``Structure``; ``mb.exact.structure(A)`` gives that of the exact numbers, with the Smith form.

        Raises:
            IllConditioned: float64 cannot tell the structure of A(s).
            InputError: the tolerance is no number >= 0.

        >>> A = PolynomialMatrix([[[1.0, 0.0], [0.0, 1.0]], [[2.0, 1.0], [0.0, 0.0]], [[1.0, 0.0], [0.0, 0.0]]])
        >>> A.structure().infinite_divisors, A.structure().finite_zeros[0].partial_multiplicities
        ((0, 2), (2,))
        >>> PolynomialMatrix([[[0.0, -1.0]], [[1.0, 0.0]]], coordinates=["position", "input"]).structure().right_kernel
        (PolynomialVector(position: 1, input: s),)
        """
        if self.is_square:
            with suppress(SingularPolynomialMatrix), within_float64():
                return self.jordan_pairs(rank_tolerance).structure
        return kronecker_structure(self, _checked(rank_tolerance))

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
        rank_tolerance = _checked(rank_tolerance)
        if rank_tolerance not in self._pairs:
            self._pairs[rank_tolerance] = jordan_pairs(self, rank_tolerance)
        return self._pairs[rank_tolerance]


def _checked(rank_tolerance: float | None) -> float | None:
    return None if rank_tolerance is None else real_number(rank_tolerance, "rank_tolerance", minimum=0.0)
