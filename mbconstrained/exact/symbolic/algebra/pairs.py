"""The finite pair (C, J, B) and the minimal infinite pair of A(s), with symbols."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import sympy

from ..field.factoring import resultant
from .assumptions import must_not_vanish
from .blocks import Block, companion_block, jordan_block, nilpotent_block, rational_block
from .chains import Chain, chain_of
from .decomposition import RootPolynomials
from .laurent import Laurent, jump_projector
from .structure import Local, SymbolicStructure, divided_by, structure_of

if TYPE_CHECKING:
    from .matrix import SymbolicPolynomialMatrix


@dataclass(frozen=True)
class SymbolicPair:
    """The strictly proper part of A(s)^-1 as C (s I - J)^-1 B (Moysis et al., Theorem 2.8), n states.

    Attributes:
        C, J, B: shapes (r, n), (n, n), (n, r), J block diagonal.
        blocks: one for each elementary divisor and zero, or for each elementary divisor; each says of which kind it is.
    """

    C: sympy.ImmutableMatrix = field(repr=False)
    J: sympy.ImmutableMatrix = field(repr=False)
    B: sympy.ImmutableMatrix = field(repr=False)
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class SymbolicInfinitePair:
    """The polynomial part of A(s)^-1 as C (I - s J)^-1 B, minimal (Theorem 2.8, sizes corrected).

    Attributes:
        C, J, B: shapes (r, mu), (mu, mu), (mu, r); J has a nilpotent Jordan block of size |q_i| + 1 for every q_i <= 0, the
            largest first (Eqs. 23-24, corrected: also for q_i = 0).
        lengths: the sizes of the blocks.
    """

    C: sympy.ImmutableMatrix = field(repr=False)
    J: sympy.ImmutableMatrix = field(repr=False)
    B: sympy.ImmutableMatrix = field(repr=False)
    lengths: tuple[int, ...]


class SymbolicJordanPairs:
    """Both pairs of a regular A(s) for generic positive symbols; what is not asked for is not computed.

    A(s)^-1 is adj A(s) / det A(s). At the zeros of an irreducible factor p of det A its principal part is a sum of columns times
    rows phi psi^T / p^k (elimination modulo a power of p), which are root polynomials: their Taylor coefficients are the Jordan
    chains, right and left, and nothing has to be solved for B. At infinity the same with A(1/w) at w = 0.

    >>> m, k = sympy.symbols("m k", positive=True)
    >>> from mbconstrained.exact.symbolic import SymbolicPolynomialMatrix
    >>> pairs = SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]]).jordan_pairs()
    >>> pairs.finite.J, pairs.finite.C, pairs.finite.B
    (Matrix([
    [               0, sqrt(k)/sqrt(m)],
    [-sqrt(k)/sqrt(m),                0]]), Matrix([[1, 0]]), Matrix([
    [                  0],
    [1/(sqrt(k)*sqrt(m))]]))
    """

    def __init__(self, A: SymbolicPolynomialMatrix):
        self.polynomial_matrix = A
        self.local = Local(A)

    def __repr__(self) -> str:
        return f"SymbolicJordanPairs({self.polynomial_matrix!r})"

    @cached_property
    def structure(self) -> SymbolicStructure:
        """Smith forms, elementary divisors and zeros."""
        return structure_of(self.local)

    @cached_property
    def chains(self) -> tuple[Chain, ...]:
        """The Jordan chains, one for each elementary divisor, as polynomials in the zeros of its p."""
        return tuple(chain_of(term) for term in self._terms)

    @cached_property
    def finite(self) -> SymbolicPair:
        """(C, J, B) with J in Jordan form where the zeros have a closed form (degrees 1, 2, and s^4 + b s^2 + c), or are numbers.

        Complex pairs have real blocks (Eq. 38). Where it depends on the symbols whether two zeros are real, they have one
        column each, and their square root may be one of a negative number (Eq. 95). Elsewhere blocks are rational: a block
        companion matrix where all zeros belong to one factor of multiplicity one, hypercompanion blocks otherwise.
        """
        A, blocks = self.polynomial_matrix, []
        if self._is_one_companion:
            return _pair(A.size, [companion_block(A, self.local.divisors[0][0])])
        for p, multiplicity in self.local.divisors:
            terms = self.local.terms(p, multiplicity)
            found = self.local.roots(p)
            if found is None:
                blocks += [rational_block(term) for term in terms]
            else:
                blocks += [jordan_block(chain_of(term), root) for root in found for term in terms]
        return _pair(A.size, blocks)

    @cached_property
    def rational(self) -> SymbolicPair:
        """(C, J, B) with entries in the field of A: the hypercompanion block of each elementary divisor p^k.

        They can be long: for a factor of degree 6 with eleven symbols this takes minutes.
        """
        return _pair(self.polynomial_matrix.size, [rational_block(term) for term in self._terms])

    @cached_property
    def infinite(self) -> SymbolicInfinitePair:
        """(C, J, B) of the zeros at infinity, of the minimal size mu."""
        local = self.local.infinity
        lengths = tuple(1 - order for order in local.orders if order <= 0)
        C, J, B = _joined(self.polynomial_matrix.size, [nilpotent_block(t, n) for t, n in zip(local.terms, lengths)])
        return SymbolicInfinitePair(C, J, B, lengths)

    @cached_property
    def laurent(self) -> Laurent:
        """laurent(i) is H_i of A(s)^-1 = sum over i of H_i s^i near infinity (Eqs. 18, 27), for every whole i."""
        return Laurent(self.polynomial_matrix)

    @cached_property
    def jump_projector(self) -> sympy.ImmutableMatrix:
        """P = col(C, CJ, ..., CJ^(q-1)) [J^(q-1)B ... B] M1, shape (q r, q r): the values of a free motion at 0+ from those at 0-."""
        return jump_projector(self.polynomial_matrix, self.laurent)

    @cached_property
    def assumptions(self) -> tuple[sympy.Expr, ...]:
        """Expressions in the symbols that must not vanish for both pairs: those of the structure, and every pivot."""
        terms = () if self._is_one_companion else self._terms
        pivots = (resultant(term.divisor, term.pivot) for term in terms)
        return must_not_vanish(self.polynomial_matrix.field, itertools.chain(divided_by(self.local), pivots))

    @property
    def _is_one_companion(self) -> bool:
        """True where A_q is invertible and det A is irreducible, with zeros that have no closed form."""
        if len(self.local.divisors) != 1:
            return False
        A, (p, multiplicity) = self.polynomial_matrix, self.local.divisors[0]
        return multiplicity == 1 and p.degree() == A.size * A.degree and self.local.roots(p) is None

    @property
    def _terms(self) -> list[RootPolynomials]:
        return [term for p, multiplicity in self.local.divisors for term in self.local.terms(p, multiplicity)]


def _pair(size: int, blocks: list[Block]) -> SymbolicPair:
    return SymbolicPair(*_joined(size, [(block.C, block.J, block.B) for block in blocks]), tuple(blocks))


def _joined(size: int, parts: list) -> tuple[sympy.ImmutableMatrix, ...]:
    """C side by side, J on the diagonal, B below each other."""
    C = sympy.Matrix.hstack(sympy.zeros(size, 0), *(C for C, _, _ in parts))
    B = sympy.Matrix.vstack(sympy.zeros(0, size), *(B for _, _, B in parts))
    return C.as_immutable(), sympy.diag(*(J for _, J, _ in parts)).as_immutable(), B.as_immutable()
