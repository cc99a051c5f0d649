"""Power series in h whose coefficients are polynomials in a zero x of an irreducible q: what e(x + h) is, modulo q."""

from __future__ import annotations

import sympy

from .factoring import constant, inverse_modulo

#: The coefficients of 1, h, h^2, ...
Series = list[sympy.Poly]


def taylor(e: sympy.Poly, q: sympy.Poly, count: int) -> Series:
    """Of e(x + h)."""
    found = [e.rem(q)]
    for j in range(1, count):
        e = e.diff() * constant(q, q.domain.one / q.domain.convert(j))
        found.append(e.rem(q))
    return found


def product(one: Series, two: Series, q: sympy.Poly) -> Series:
    """To the order of the first."""
    return [sum((one[i] * two[j - i] for i in range(j + 1)), q.zero).rem(q) for j in range(len(one))]


def power(series: Series, exponent: int, q: sympy.Poly) -> Series:
    """To the same order."""
    found = [q.one, *[q.zero] * (len(series) - 1)]
    for _ in range(exponent):
        found = product(found, series, q)
    return found


def inverse(series: Series, q: sympy.Poly) -> Series:
    """1 / series, to the same order; the first coefficient is not zero."""
    first = inverse_modulo(series[0], q)
    found = [first]
    for j in range(1, len(series)):
        known = sum((series[i] * found[j - i] for i in range(1, j + 1)), q.zero)
        found.append((-known * first).rem(q))
    return found
