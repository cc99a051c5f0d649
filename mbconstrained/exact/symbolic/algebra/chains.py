"""Jordan chains, right and left: the Taylor coefficients of root polynomials at a zero.

At a zero x of p the columns v_0 ... v_(k-1) and rows b_0 ... b_(k-1) of a chain satisfy

    A(s) (v_0 + v_1 (s - x) + ...) = O((s - x)^k),    A(s)^-1 = sum over i <= j of v_i b_j^T / (s - x)^(j - i + 1) + ...,

so that they are the columns of C and the rows of B at a Jordan block of size k. They are the same polynomials in x at all zeros
of p, with coefficients in the field of the entries.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from ..field.factoring import described
from ..field.power_series import inverse, power, product, taylor
from .decomposition import RootPolynomials

#: A vector of polynomials in the zero, modulo p.
Vector = tuple[sympy.Poly, ...]


@dataclass(frozen=True, repr=False)
class Chain:
    """A Jordan chain of A(s) for each of the zeros of an irreducible polynomial.

    Attributes:
        polynomial: p, monic.
        length: k.
        right: v_0 ... v_(k-1), each r Polys in the zero, of lower degree than p.
        left: b_0 ... b_(k-1).
    """

    polynomial: sympy.Poly
    length: int
    right: tuple[Vector, ...]
    left: tuple[Vector, ...]

    def __repr__(self) -> str:
        return f"Chain({described(self.polynomial)}, length={self.length})"


def chain_of(term: RootPolynomials) -> Chain:
    """The chain of one term phi psi^T / p^k: v_i from phi(x + h), b_(k-1-i) from psi(x + h) h^k / p(x + h)^k."""
    p, k = term.divisor, term.length
    right = [taylor(entry, p, k) for entry in term.right]
    weight = inverse(power(taylor(p, p, k + 1)[1:], k, p), p)
    left = [product(taylor(entry, p, k), weight, p) for entry in term.left]
    return Chain(p, k, tuple(zip(*right)), tuple(zip(*left))[::-1])
