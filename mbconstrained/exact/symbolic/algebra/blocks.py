"""The blocks of the finite pair: Jordan blocks, real Jordan blocks of complex pairs, rational blocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy
from sympy.polys.matrices import DomainMatrix

from ..field.factoring import described
from ..field.fields import expression_of
from ..field.radicals import Root
from .chains import Chain
from .decomposition import RootPolynomials

if TYPE_CHECKING:
    from .matrix import SymbolicPolynomialMatrix


@dataclass(frozen=True, repr=False)
class Block:
    """The part of the finite pair that belongs to one elementary divisor p^k, or to one of its zeros.

    Attributes:
        kind: "jordan", of a zero that is known; "real jordan", of a complex pair a +- i b, with [[a, b], [-b, a]] on the diagonal
            (Moysis et al., Eq. 38). Where symbols leave zeros no short closed form, "rational", the hypercompanion block of p^k, or
            "companion", the block companion matrix of all of A(s).
        polynomial, length: p and k.
        zero: in radicals, or with 30 digits where there are no symbols, of a pair the one above the real axis; None of the last two kinds.
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
        return f"Block({self.kind}, {described(self.polynomial)}, length={self.length})"


def jordan_block(chain: Chain, root: Root) -> Block:
    """The Jordan block of a chain at a zero, real for a complex pair."""
    right = [[root.at(entry) for entry in vector] for vector in chain.right]
    if root.is_pair:
        columns = [[parts[which] for parts in vector] for vector in right for which in (0, 1)]
        rows = [[root.at(way * entry)[which] for entry in vector] for vector in chain.left for which, way in ((0, 2), (1, -2))]
        diagonal = sympy.Matrix([[root.real, root.imaginary], [-root.imaginary, root.real]])
    else:
        columns = [[real for real, _ in vector] for vector in right]
        rows = [[root.at(entry)[0] for entry in vector] for vector in chain.left]
        diagonal = sympy.Matrix([[root.real]])
    J = sympy.diag(*[diagonal] * chain.length) + _shift(len(columns), diagonal.rows)
    kind = "real jordan" if root.is_pair else "jordan"
    C, B = sympy.Matrix(columns).T, sympy.Matrix(rows)
    return Block(kind, chain.polynomial, chain.length, root.value, *(matrix.as_immutable() for matrix in (C, J, B)))


def rational_block(term: RootPolynomials) -> Block:
    """The block of p^k on K[s]/p^k with the basis p^(k-1), s p^(k-1), ..., p^(k-2), ..., s^(d-1).

    J is multiplication by s, B the coordinates of psi, and C takes k to the coefficient of s^(d k - 1) of phi k mod p^k: the
    Laurent coefficients of phi psi^T / p^k at infinity are C J^i B. For d = 1 this is the Jordan block.
    """
    p, k, d = term.divisor, term.length, term.divisor.degree()
    modulus, x = p**k, sympy.Poly(term.divisor.gen, term.divisor.gen, domain=term.divisor.domain)
    basis = [x**i * p**j for j in reversed(range(k)) for i in range(d)]
    C = [[_coefficient((entry * b).rem(modulus), d * k - 1) for b in basis] for entry in term.right]
    J = list(zip(*[_coordinates((x * b).rem(modulus), p, k) for b in basis]))
    B = list(zip(*[_coordinates(entry, p, k) for entry in term.left]))
    return Block("rational", p, k, None, *(_matrix(p.domain, rows) for rows in (C, J, B)))


def companion_block(A: SymbolicPolynomialMatrix, p: sympy.Poly) -> Block:
    """C = [I 0 ... 0], J = [0 I; -A_q^-1 A_0 ... -A_q^-1 A_(q-1)] and B = [0; A_q^-1], where A_q is invertible and det A ~ p.

    C (s I - J)^-1 B = A(s)^-1. No entry is longer than A_q^-1 makes it, while the chains of such a p are long.
    """
    q, r, shape = A.degree, A.size, (A.size, A.size)
    *lower, leading = (DomainMatrix(rows, shape, A.field) for rows in A.elements)
    inverse = leading.inv()
    below = [_matrix(A.field, (-(inverse * matrix)).to_list()) for matrix in lower]
    J = _shift(q * r, r)
    J[(q - 1) * r :, :] = sympy.Matrix.hstack(*below)
    C, B = sympy.eye(r, q * r), sympy.Matrix.vstack(sympy.zeros((q - 1) * r, r), _matrix(A.field, inverse.to_list()))
    return Block("companion", p, 1, None, *(matrix.as_immutable() for matrix in (C, J, B)))


def nilpotent_block(term: RootPolynomials, length: int) -> tuple[sympy.ImmutableMatrix, ...]:
    """C, J and B of phi psi^T / w^(length - 1) at w = 1/s = 0, what it has in w^0 and below (Moysis et al., Eq. 24)."""
    C = [[_coefficient(entry, i) for i in range(length)] for entry in term.right]
    B = [[_coefficient(entry, length - 1 - j) for entry in term.left] for j in range(length)]
    domain = term.divisor.domain
    return _matrix(domain, C), _shift(length, 1).as_immutable(), _matrix(domain, B)


def _shift(size: int, by: int) -> sympy.Matrix:
    """Ones next to the diagonal blocks."""
    return sympy.Matrix(size, size, lambda i, j: int(j == i + by))


def _matrix(domain, rows) -> sympy.ImmutableMatrix:
    return sympy.ImmutableMatrix([[expression_of(domain, entry) for entry in row] for row in rows])


def _coordinates(e: sympy.Poly, p: sympy.Poly, k: int) -> list:
    """Of e in the basis, from its digits to the base p."""
    digits = []
    for _ in range(k):
        e, digit = e.div(p)
        digits.append([_coefficient(digit, i) for i in range(p.degree())])
    return [c for digit in reversed(digits) for c in digit]


def _coefficient(e: sympy.Poly, power: int):
    """Of s^power in e, an element of the field."""
    return e.rep.to_dict().get((power,), e.domain.zero)
