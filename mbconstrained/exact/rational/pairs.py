"""The finite and the infinite Jordan pair of A(s) over the rationals: true chains, nothing rounded."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import flint
import numpy as np

from ...errors import InputError
from ...jordan.pairs import InfinitePair
from ...polynomial.matrix import PolynomialMatrix
from .arithmetic import fraction
from .blocks import Chain, ExactBlock, finite_block, infinite_block, joined
from .cramer import WholeMatrix
from .local_smith import LocalBlock, local_smith
from .matrix import RationalMatrix
from .singular import regular_matrix
from .structure import ExactStructure, exact_structure, irreducible_factors

#: The zero at s = 0.
ORIGIN = flint.fmpz_poly([0, 1])


@dataclass(frozen=True)
class ExactFinitePair:
    """The strictly proper part of A(s)^-1 as C (s I - J)^-1 B, exactly (Moysis et al., Theorem 2.8).

    Arrays hold Fractions. B is computed when it is asked for: with C and J of few digits, its entries have 2 deg(p^k) times as many
    as the coefficients of det A(s). That is nothing where zeros are rational or factors short; of one irreducible factor of degree 40
    of float64 data it takes seconds, of degree 80 minutes. C, J and the chains take seconds at degree 160.

    Attributes:
        size: r.
        blocks: one for each elementary divisor p^k, by p and then by k.
    """

    size: int
    blocks: tuple[ExactBlock, ...]

    @cached_property
    def C(self) -> np.ndarray:
        """Shape (r, n): for rational zeros the columns are the vectors of the Jordan chains."""
        return np.hstack([np.zeros((self.size, 0), dtype=object), *(block.C for block in self.blocks)])

    @cached_property
    def J(self) -> np.ndarray:
        """Shape (n, n), in 1/s: the hypercompanion matrices of all p^k on the diagonal, Jordan blocks where zeros are rational."""
        return joined([block.J for block in self.blocks])

    @cached_property
    def B(self) -> np.ndarray:
        """Shape (n, r)."""
        return np.vstack([np.zeros((0, self.size), dtype=object), *(block.B for block in self.blocks)])

    @property
    def chains(self) -> tuple[Chain, ...]:
        """One for each elementary divisor."""
        return tuple(block.chain for block in self.blocks)


@dataclass(frozen=True)
class ExactJordanPairs:
    """Both pairs of a regular A(s) as exact Fractions; what is not asked for is not computed.

    Entries of A(s) are taken as the exact numbers that they are, or that their elements are.

    Attributes:
        polynomial_matrix: A(s).

    >>> import mbconstrained as mb
    >>> pairs = mb.PolynomialMatrix([[[1, 0], [0, 1]], [[2, 1], [0, 0]], [[1, 0], [0, 0]]]).jordan_pairs(exact=True)
    >>> print(pairs.finite.J.astype(int).tolist(), pairs.finite.C.astype(int).tolist(), pairs.finite.B.astype(int).tolist())
    [[-1, 1], [0, -1]] [[1, 0], [0, 0]] [[0, -1], [1, 1]]
    >>> pairs.laurent(0).astype(int).tolist(), pairs.laurent(-1).astype(int).tolist()
    ([[0, 0], [0, 1]], [[0, -1], [0, 0]])
    """

    polynomial_matrix: PolynomialMatrix
    _rational: RationalMatrix = field(repr=False)

    @cached_property
    def structure(self) -> ExactStructure:
        """Zeros and their multiplicities, finite and infinite, with the elementary divisors over the rationals."""
        local = [self._local(place) if multiplicity > 1 else None for place, (_, multiplicity) in enumerate(self._factors)]
        return exact_structure(self._rational, self._factors, local, self._at_infinity)

    @cached_property
    def finite(self) -> ExactFinitePair:
        """(C, J, B) and the chains of the finite zeros."""
        blocks = [
            finite_block(block, index, self._whole.factors)
            for place in range(len(self._factors))
            for block in self._local(place)
            if block.exponent
            for index in range(block.count)
        ]
        return ExactFinitePair(self._rational.size, tuple(blocks))

    @cached_property
    def infinite(self) -> InfinitePair:
        """(C, J, B) of the zeros at infinity, of the minimal size mu: J is made of Jordan blocks, the columns of C are chains."""
        r, q = self._rational.size, self._rational.degree
        parts = [
            infinite_block(block, index, q, self._whole.factors)
            for block in self._at_infinity
            if block.exponent >= q
            for index in range(block.count)
        ]
        C = np.hstack([np.zeros((r, 0), dtype=object), *(part.C for part in parts)])
        B = np.vstack([np.zeros((0, r), dtype=object), *(part.B for part in parts)])
        return InfinitePair(C, joined([part.J for part in parts]), B)

    def laurent(self, index: int) -> np.ndarray:
        """H_i of A(s)^-1 = sum over i of H_i s^i near infinity, shape (r, r), by dividing the adjugate by the determinant."""
        if isinstance(index, bool) or not isinstance(index, (int, np.integer)):
            raise InputError(f"index: found {index!r}; expected a whole number")
        everything, shift = range(self._rational.size), max(0, -int(index))
        whole = self._whole.part(everything, everything)
        rows = [
            [(p.left_shift(shift) // whole.determinant)[int(index) + shift] * factor for p, factor in zip(row, self._whole.factors)]
            for row in whole.left(everything)
        ]
        return np.array([[fraction(entry) for entry in row] for row in rows], dtype=object)

    @cached_property
    def _whole(self) -> WholeMatrix:
        return WholeMatrix.of(self._rational)

    @cached_property
    def _factors(self) -> list[tuple[flint.fmpz_poly, int]]:
        return irreducible_factors(self._rational.determinant)

    @cached_property
    def _found(self) -> dict[int, tuple[LocalBlock, ...]]:
        return {}

    def _local(self, place: int) -> tuple[LocalBlock, ...]:
        """The local Smith form at the irreducible factor in that place, found once."""
        if place not in self._found:
            self._found[place] = local_smith(self._whole, *self._factors[place])
        return self._found[place]

    @cached_property
    def _at_infinity(self) -> tuple[LocalBlock, ...]:
        """The local Smith form of the dual at s = 0."""
        missing = self._rational.size * self._rational.degree - self._rational.determinant.degree()
        return local_smith(self._whole.dual, ORIGIN, missing)


def exact_jordan_pairs(A: PolynomialMatrix) -> ExactJordanPairs:
    """The pairs of A(s); see ``PolynomialMatrix.jordan_pairs``.

    Raises:
        SingularPolynomialMatrix: det A(s) is exactly zero for every s; names the dependent equations and free coordinates.
    """
    return ExactJordanPairs(A, regular_matrix(A))
