"""Jordan chains, right and left: the Taylor coefficients of root polynomials at a zero.

At a zero x of p the columns v_0 ... v_(k-1) and rows b_0 ... b_(k-1) of a chain satisfy

    A(s) (v_0 + v_1 (s - x) + ...) = O((s - x)^k),    A(s)^-1 = sum over i <= j of v_i b_j^T / (s - x)^(j - i + 1) + ...,

so that they are the columns of C and the rows of B at a Jordan block of size k. They are the same polynomials in x at all zeros
of p, with coefficients in the field of the entries.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from .decomposition import RootPolynomials
from .factoring import constant, inverse_modulo

#: A vector of polynomials in the zero, modulo p.
Vector = tuple[sympy.Poly, ...]


@dataclass(frozen=True)
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


def chain_of(term: RootPolynomials) -> Chain:
    """The chain of one term phi psi^T / p^k: v_i from phi(x + h), b_(k-1-i) from psi(x + h) h^k / p(x + h)^k."""
    p, k = term.divisor, term.length
    right = [_taylor(entry, p, k) for entry in term.right]
    weight = _inverse(_power(_taylor(p, p, k + 1)[1:], k, p), p)
    left = [_product(_taylor(entry, p, k), weight, p) for entry in term.left]
    return Chain(p, k, tuple(zip(*right)), tuple(zip(*left))[::-1])


def _taylor(e: sympy.Poly, p: sympy.Poly, count: int) -> list[sympy.Poly]:
    """The coefficients of 1, h, h^2, ... in e(x + h), modulo p."""
    found = []
    for order in range(count):
        found.append(e.rem(p))
        e = e.diff() * constant(p, p.domain.one / p.domain.convert(order + 1))
    return found


def _product(one: list[sympy.Poly], two: list[sympy.Poly], p: sympy.Poly) -> list[sympy.Poly]:
    """Of two power series in h, modulo p."""
    return [sum((one[i] * two[j - i] for i in range(j + 1)), 0 * p).rem(p) for j in range(len(one))]


def _power(series: list[sympy.Poly], exponent: int, p: sympy.Poly) -> list[sympy.Poly]:
    found = [constant(p, p.domain.one), *[0 * p] * (len(series) - 1)]
    for _ in range(exponent):
        found = _product(found, series, p)
    return found


def _inverse(series: list[sympy.Poly], p: sympy.Poly) -> list[sympy.Poly]:
    """One over a power series whose first coefficient has no zero in common with p."""
    first, found = inverse_modulo(series[0], p), []
    for j in range(len(series)):
        known = sum((series[i] * found[j - i] for i in range(1, j + 1)), 0 * p)
        rest = (constant(p, p.domain.one) if j == 0 else 0 * p) - known
        found.append((rest * first).rem(p))
    return found
