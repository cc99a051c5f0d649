"""The Jordan pairs of A(s) with symbols: Jordan blocks in radicals, the assumptions, and the projector onto consistent values."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import sympy
from sympy.polys.domains.domain import Domain
from sympy.polys.matrices import DomainMatrix

from ..core.exact_pairs import ExactJordanPairs, ExactMatrix
from ..core.jordan_blocks import ExactPair, HypercompanionBlock, JordanChain
from .field.radicals import Root
from .field.surds import sign
from .symbolic_ring import SymbolicRing


class SymbolicMatrix(ExactMatrix, Protocol):
    """A(s) with its field, and A_0 ... A_q as rows of elements of it."""

    field: Domain
    elements: list[Any]


class SymbolicJordanPairs(ExactJordanPairs):
    """Finite and infinite Jordan pair of a regular A(s) for generic positive symbols, computed on demand.

    >>> m, k = sympy.symbols("m k", positive=True)
    >>> from mbconstrained import SymbolicPolynomialMatrix
    >>> pairs = SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]]).jordan_pairs()
    >>> pairs.finite.J, pairs.finite.C, pairs.finite.B
    (Matrix([
    [               0, sqrt(k)/sqrt(m)],
    [-sqrt(k)/sqrt(m),                0]]), Matrix([[1, 0]]), Matrix([
    [                  0],
    [1/(sqrt(k)*sqrt(m))]]))
    """

    matrix: SymbolicMatrix
    ring: SymbolicRing

    @cached_property
    def finite(self) -> ExactPair:
        """(C, J, B) with J in Jordan form where the zeros have a closed form (degrees 1, 2, and s^4 + b s^2 + c), or are numbers.

        Complex pairs have real blocks (Moysis et al., Eq. 38). Where it depends on the symbols whether two zeros are real, they
        have one column each, and their square root may be one of a negative number (Eq. 95). Elsewhere blocks have entries in the
        field: a block companion matrix where all zeros belong to one factor of multiplicity one, hypercompanion blocks otherwise.
        """
        if self._is_one_companion:
            return ExactPair(self.ring, self.matrix.size, [_companion_block(self.matrix, self.factors[0][0])])
        blocks: list = []
        for place, (p, _) in enumerate(self.factors):
            terms, roots = self.root_polynomials(place), self.ring.roots(p)
            if roots is None:
                blocks += [HypercompanionBlock(term) for term in terms]
            else:
                blocks += [_jordan_block(JordanChain(term), root) for root in roots for term in terms]
        return ExactPair(self.ring, self.matrix.size, blocks)

    @cached_property
    def jump_projector(self) -> sympy.ImmutableMatrix:
        """P = col(C, CJ, ..., CJ^(q-1)) [J^(q-1)B ... B] M1, shape (q r, q r) (Moysis et al., Eq. 98).

        The values of a free motion at 0+ are P times those at 0-. For every pair the first two factors have the blocks
        H_(c-a-q), and M1 has A_(q-c+b) at (c, b), c >= b.
        """
        A, shape = self.matrix, (self.matrix.size, self.matrix.size)
        q, r = A.degree, A.size
        coefficients = [DomainMatrix(rows, shape, A.field) for rows in A.elements]
        total = sympy.zeros(q * r, q * r)
        for a, b in itertools.product(range(q), repeat=2):
            block = DomainMatrix.zeros(shape, A.field).to_dense()
            for c in range(b, q):
                block += DomainMatrix(self.laurent.elements(c - a - q), shape, A.field) * coefficients[q - c + b]
            total[a * r : (a + 1) * r, b * r : (b + 1) * r] = self.ring.matrix(block.to_list())
        return total.as_immutable()

    @cached_property
    def assumptions(self) -> tuple[sympy.Expr, ...]:
        """Expressions in the symbols that must not vanish for both pairs: those of the structure, and every pivot."""
        terms = () if self._is_one_companion else self.terms
        pivots = (_resultant(term.divisor, term.pivot) for term in terms)
        return must_not_vanish(self.matrix.field, itertools.chain(self._divided_by(), pivots))

    def structure_assumptions(self) -> tuple[sympy.Expr, ...]:
        """The degree of det A, distinct zeros, and the pivots of multiple and infinite ones; zeros without closed form left out."""
        return must_not_vanish(self.matrix.field, self._divided_by())

    def _divided_by(self) -> Iterable:
        A, field = self.matrix, self.matrix.field
        yield from (field.convert(field.denom(c), field.get_ring()) for matrix in A.elements for row in matrix for c in row)
        yield A.determinant.rep.LC()
        for place, (p, multiplicity) in enumerate(self.factors):
            yield from (_resultant(p, other) for other, _ in self.factors[:place])
            if p.degree() > 1 and self.ring.roots(p) is not None:
                yield _resultant(p, p.diff())
            if multiplicity > 1:
                yield from (_resultant(p, term.pivot) for term in self.root_polynomials(place))
        yield from (term.pivot.rep.LC() for term in self.infinity)

    @property
    def _is_one_companion(self) -> bool:
        """True where A_q is invertible and det A is irreducible, with zeros that have no closed form."""
        if len(self.factors) != 1:
            return False
        A, (p, multiplicity) = self.matrix, self.factors[0]
        return multiplicity == 1 and p.degree() == A.size * A.degree and self.ring.roots(p) is None


@dataclass(frozen=True, repr=False, eq=False)
class Block:
    """The part of the finite pair that belongs to one elementary divisor p^k and one of its zeros.

    Attributes:
        kind: "jordan"; "real jordan", of a complex pair a +- i b, with [[a, b], [-b, a]] on the diagonal (Moysis et al., Eq. 38);
            "companion", the block companion matrix of all of A(s).
        polynomial, length: p and k.
        zero: in radicals, or with 30 digits where there are no symbols, of a pair the one above the real axis; None of a
            companion matrix.
        C, J, B: its columns, square and rows.
    """

    kind: str
    polynomial: sympy.Poly
    length: int
    zero: sympy.Expr | None
    C: sympy.ImmutableMatrix
    J: sympy.ImmutableMatrix
    B: sympy.ImmutableMatrix

    def __repr__(self) -> str:
        return f"Block({self.kind}, length={self.length}, degree {self.polynomial.degree()})"


def _jordan_block(chain: JordanChain, root: Root) -> Block:
    """The Jordan block of a chain at a zero, real for a complex pair."""
    right = [[root.at(entry) for entry in vector] for vector in chain.right]
    if root.is_pair:
        columns = [[parts[which] for parts in vector] for vector in right for which in (0, 1)]
        rows = [[root.at(sign * entry)[which] for entry in vector] for vector in chain.left for which, sign in ((0, 2), (1, -2))]
        diagonal = sympy.Matrix([[root.real, root.imaginary], [-root.imaginary, root.real]])
    else:
        columns = [[real for real, _ in vector] for vector in right]
        rows = [[root.at(entry)[0] for entry in vector] for vector in chain.left]
        diagonal = sympy.Matrix([[root.real]])
    J = sympy.diag(*[diagonal] * chain.length) + _shift(len(columns), diagonal.rows)
    kind = "real jordan" if root.is_pair else "jordan"
    C, B = sympy.Matrix(columns).T, sympy.Matrix(rows)
    return Block(kind, chain.polynomial, chain.length, root.value, *(matrix.as_immutable() for matrix in (C, J, B)))


def _companion_block(A: SymbolicMatrix, p: sympy.Poly) -> Block:
    """C = [I 0 ... 0], J = [0 I; -A_q^-1 A_0 ... -A_q^-1 A_(q-1)] and B = [0; A_q^-1], where A_q is invertible and det A ~ p.

    C (s I - J)^-1 B = A(s)^-1. No entry is longer than A_q^-1 makes it, while the chains of such a p are long.
    """
    q, r, shape = A.degree, A.size, (A.size, A.size)
    *lower, leading = (DomainMatrix(rows, shape, A.field) for rows in A.elements)
    inverse = leading.inv()
    J = _shift(q * r, r)
    J[(q - 1) * r :, :] = sympy.Matrix.hstack(*(A.ring.matrix((-(inverse * matrix)).to_list()) for matrix in lower))
    C, B = sympy.eye(r, q * r), sympy.Matrix.vstack(sympy.zeros((q - 1) * r, r), A.ring.matrix(inverse.to_list()))
    return Block("companion", p, 1, None, *(matrix.as_immutable() for matrix in (C, J, B)))


def _shift(size: int, by: int) -> sympy.Matrix:
    """Ones next to the diagonal blocks."""
    return sympy.Matrix(size, size, lambda i, j: int(j == i + by))


def must_not_vanish(field: Domain, values: Iterable) -> tuple[sympy.Expr, ...]:
    """The irreducible factors of all numerators and denominators that vanish for some positive symbols, in order of length.

    >>> a, b = sympy.symbols("a b")
    >>> K = sympy.ZZ.frac_field(a, b)
    >>> must_not_vanish(K, [K.from_sympy(a**2 * (a - b) / (a + b)), K.from_sympy(2 * b - 2 * a)])
    (a - b,)
    """
    if not field.is_FractionField:
        return ()
    ring, is_definite = field.get_ring(), {}
    for value in values:
        for part in (field.numer(value), field.denom(value)):
            for factor, _ in part.factor_list()[1]:
                if factor not in is_definite:
                    is_definite[factor] = sign(field, field.convert(factor, ring)) in (1, -1)
    doubtful = [ring.to_sympy(factor) for factor, definite_sign in is_definite.items() if not definite_sign]
    return tuple(sorted(doubtful, key=lambda e: (sympy.count_ops(e), str(e))))


def _resultant(p: sympy.Poly, other: sympy.Poly):
    """Resultant of two Polys over the field, an element of it: zero where they have a common zero."""
    return p.domain.from_sympy(p.resultant(other))
