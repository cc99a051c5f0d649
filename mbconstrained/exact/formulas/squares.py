"""Sums of products written with a square in them where their terms cancel: near resonance they keep their digits so."""

from __future__ import annotations

from itertools import combinations

import sympy

Monomials = dict[tuple[int, ...], sympy.Rational]


def with_square(total: sympy.Expr) -> sympy.Expr:
    """u^2 - 2 u v + v^2 + rest as (u - v)^2 + rest, where nothing is subtracted in the rest; else as it is.

    What a divisor near resonance is, |k - m w^2 + i c w|^2, is small there, and its terms are not.

    >>> k, m, c, w = sympy.symbols("k m c w", positive=True)
    >>> with_square(k**2 - 2 * k * m * w**2 + m**2 * w**4 + c**2 * w**2)
    c**2*w**2 + (-k + m*w**2)**2
    >>> with_square(k - m)
    k - m
    """
    polynomial = total.as_poly()
    if polynomial is None or not (polynomial.domain.is_QQ or polynomial.domain.is_ZZ):
        return total
    terms: Monomials = dict(polynomial.terms())
    for one, other in combinations(_square_roots(terms), 2):
        rest = _without_square(terms, one, other)
        if rest is not None:
            u, v = (sympy.Poly({powers: factor}, *polynomial.gens).as_expr() for powers, factor in (one, other))
            return (u - v) ** 2 + sympy.Poly(rest or {(0,) * len(polynomial.gens): 0}, *polynomial.gens).as_expr()
    return total


def _square_roots(terms: Monomials) -> list[tuple[tuple[int, ...], sympy.Expr]]:
    """Powers and factors of the roots of the terms that are squares."""
    even = [(powers, factor) for powers, factor in terms.items() if factor > 0 and not any(power % 2 for power in powers)]
    roots = [(tuple(power // 2 for power in powers), sympy.sqrt(factor)) for powers, factor in even]
    return [(powers, factor) for powers, factor in roots if factor.is_Rational]


def _without_square(terms: Monomials, one, other) -> Monomials | None:
    """What is left without the square of the difference, if nothing is subtracted in it."""
    between = tuple(p + q for p, q in zip(one[0], other[0]))
    rest = dict(terms)
    for powers, factor in (_squared(one), _squared(other), (between, -2 * one[1] * other[1])):
        rest[powers] = rest.get(powers, 0) - factor
    return {powers: factor for powers, factor in rest.items() if factor} if min(rest.values()) >= 0 else None


def _squared(root) -> tuple[tuple[int, ...], sympy.Expr]:
    return tuple(2 * power for power in root[0]), root[1] ** 2
