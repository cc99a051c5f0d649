"""Root polynomials of A(s) at the zeros of an irreducible polynomial p, the Jordan chains that are their Taylor coefficients, and the
blocks (C, J, B) of both pairs that they add.

At the zeros of p the principal part of A(s)^-1 is a sum of columns times rows phi psi^T / p^k, one for each elementary divisor p^k:
p^k divides A phi and psi^T A (Gohberg, Lancaster and Rodman, Matrix Polynomials, section 1.5).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from .ring import Element, Matrix, Polynomial, PolynomialRing, slopes, taylor


@dataclass(frozen=True, repr=False)
class RootPolynomials:
    """Root polynomials: one term phi psi^T / p^k of the principal part of A(s)^-1 at the zeros of p.

    Attributes:
        ring: K[s].
        divisor: p, irreducible and monic.
        length: k.
        right: phi, r polynomials modulo p^k.
        compute_left: returns psi; over the rationals its coefficients have many more digits than those of phi.
        pivot: the divisor of the elimination, where there is one: a polynomial not divisible by p.
    """

    ring: PolynomialRing
    divisor: Polynomial
    length: int
    right: tuple[Polynomial, ...]
    compute_left: Callable[[], tuple[Polynomial, ...]] = field(compare=False)
    pivot: Polynomial | None = None

    def __repr__(self) -> str:
        return f"RootPolynomials({self.ring.text(self.divisor)}, length={self.length})"

    @cached_property
    def left(self) -> tuple[Polynomial, ...]:
        """psi, r polynomials modulo p^k."""
        return self.compute_left()


class JordanChain:
    """A Jordan chain of A(s) for every zero z of an irreducible polynomial p at once.

    A(s) (v_0 + v_1 (s - z) + ... + v_(k-1) (s - z)^(k-1)) = O((s - z)^k), v_0 not zero (Moysis et al., Eqs. 19-20), and with the
    left chain A(s)^-1 = sum over i <= j of v_i b_j^T / (s - z)^(j - i + 1) + ...: the v_i are the columns of C and the b_j the rows
    of B at a Jordan block of size k. They are the same polynomials in z at all zeros of p.

    Attributes:
        polynomial: p, monic.
        length: k.
    """

    def __init__(self, term: RootPolynomials):
        self.term, self.length = term, term.length
        self.polynomial = term.ring.exported(term.divisor)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.term.ring.text(self.term.divisor)}, length={self.length})"

    @cached_property
    def right(self) -> tuple[tuple[Polynomial, ...], ...]:
        """v_0 ... v_(k-1), each r polynomials in the zero, of lower degree than p."""
        ring, p, k = self.term.ring, self.term.divisor, self.length
        return tuple(zip(*(taylor(ring, entry, p, k).coefficients for entry in self.term.right)))

    @cached_property
    def left(self) -> tuple[tuple[Polynomial, ...], ...]:
        """b_0 ... b_(k-1): b_(k-1-i) from psi(z + h) h^k / p(z + h)^k."""
        ring, p, k = self.term.ring, self.term.divisor, self.length
        weight = (slopes(ring, p, k) ** k).inverse
        return tuple(zip(*((taylor(ring, entry, p, k) * weight).coefficients for entry in self.term.left)))[::-1]

    @property
    def vectors(self) -> tuple[Matrix, ...]:
        """v_0 ... v_(k-1) as matrices of shape (r, deg p): column j multiplies z^j."""
        ring, d = self.term.ring, self.term.divisor.degree()
        return tuple(ring.matrix([ring.coefficients(entry, d) for entry in vector]) for vector in self.right)


class HypercompanionBlock:
    """The part C (s I - J)^-1 B of A(s)^-1 that belongs to one elementary divisor p^k.

    J is the hypercompanion matrix of p^k (Jacobson): multiplication by s on K[s]/p^k with the basis p^i s^j. Where p = s - z it is
    the Jordan block, and the columns of C are the Jordan chain.

    Attributes:
        term: phi and psi with the part phi psi^T / p^k.
    """

    kind = "hypercompanion"
    zero = None

    def __init__(self, term: RootPolynomials):
        self.term, self.length = term, term.length
        self.polynomial = term.ring.exported(term.divisor)

    def __repr__(self) -> str:
        return f"HypercompanionBlock({self.term.ring.text(self.term.divisor)}, length={self.length})"

    @property
    def degree(self) -> int:
        """The degree of p."""
        return self.term.divisor.degree()

    @cached_property
    def C(self) -> Matrix:
        """Shape (r, k deg p): the digits of phi to the base p, each by its coefficients."""
        ring, p = self.term.ring, self.term.divisor
        return ring.matrix([digits(ring, entry, p, self.length) for entry in self.term.right])

    @cached_property
    def J(self) -> Matrix:
        """Shape (k deg p, k deg p)."""
        return hypercompanion(self.term.ring, self.term.divisor, self.length)

    @cached_property
    def B(self) -> Matrix:
        """Shape (k deg p, r): the coefficient of s^(-1-j) in psi / p^(k-i) at the basis element p^i s^j."""
        ring, p, d = self.term.ring, self.term.divisor, self.degree
        shift = ring.polynomial([ring.zero] * d + [ring.one])
        rows = []
        for i in range(self.length):
            modulus = p ** (self.length - i)
            columns = [ring.coefficients(entry % modulus * shift // modulus, d) for entry in self.term.left]
            rows += [[column[j] for column in columns] for j in reversed(range(d))]
        return ring.matrix(rows)


class NilpotentBlock:
    """The part C (I - s J)^-1 B of A(s)^-1 that an infinite elementary divisor adds (Moysis et al., Eqs. 23-24).

    Args:
        term: root polynomials at w = 1/s = 0.
        length: the size n: the part is phi psi^T / w^(n-1) up to w^0.
    """

    kind = "nilpotent"

    def __init__(self, term: RootPolynomials, length: int):
        self.length, ring = length, term.ring
        zero, one = ring.zero, ring.one
        self.C = ring.matrix([ring.coefficients(entry, length) for entry in term.right])
        self.J = ring.matrix([[one if j == i + 1 else zero for j in range(length)] for i in range(length)])
        columns = [ring.coefficients(entry, length)[::-1] for entry in term.left]
        self.B = ring.matrix([[column[i] for column in columns] for i in range(length)])

    def __repr__(self) -> str:
        return f"NilpotentBlock(length={self.length})"


def digits(ring: PolynomialRing, entry: Polynomial, p: Polynomial, count: int) -> list[Element]:
    """The coefficients of the first digits of a polynomial to the base p, the lowest digit first."""
    row: list[Element] = []
    for _ in range(count):
        entry, digit = divmod(entry, p)
        row += ring.coefficients(digit, p.degree())
    return row


def hypercompanion(ring: PolynomialRing, p: Polynomial, exponent: int) -> Matrix:
    """Hypercompanion matrix of monic p, d = deg p: ones above the diagonal, coefficients of s^d - p(s) in every d-th row."""
    d = p.degree()
    lower = ring.coefficients(p, d)
    rows = [[ring.one if j == i + 1 else ring.zero for j in range(exponent * d)] for i in range(exponent * d)]
    for last in range(d - 1, exponent * d, d):
        for j in range(d):
            rows[last][last - d + 1 + j] = rows[last][last - d + 1 + j] - lower[j]
    return ring.matrix(rows)


class ExactPair:
    """C, J and B of several blocks: C side by side, J on the diagonal, B below each other, computed on demand.

    Attributes:
        blocks: each with C, J, B and the length of its chain.
    """

    def __init__(self, ring: PolynomialRing, size: int, blocks: Sequence):
        self.ring, self.size, self.blocks = ring, size, tuple(blocks)

    def __repr__(self) -> str:
        names = sorted({block.kind for block in self.blocks})
        return f"ExactPair(size={self.size}, {len(self.blocks)} blocks{': ' if names else ''}{', '.join(names)})"

    @property
    def lengths(self) -> tuple[int, ...]:
        """The lengths of the chains."""
        return tuple(block.length for block in self.blocks)

    @cached_property
    def C(self) -> Matrix:
        """Shape (r, n)."""
        return self.ring.side_by_side([self.ring.matrix([[]] * self.size), *(block.C for block in self.blocks)])

    @cached_property
    def J(self) -> Matrix:
        """Shape (n, n)."""
        return self.ring.diagonal([self.ring.matrix([]), *(block.J for block in self.blocks)])

    @cached_property
    def B(self) -> Matrix:
        """Shape (n, r)."""
        return self.ring.below([self.ring.matrix([[]] * self.size).T, *(block.B for block in self.blocks)])
