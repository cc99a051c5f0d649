"""Partial fractions over a field K: exact, the roots of irreducible factors never computed.

At a root x of an irreducible factor q of the denominator, of multiplicity k, the coefficients of the principal part are the
same polynomials in x for all roots of q, with coefficients in K: they are found in K[x]/q.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy

from ..field.factoring import Factors
from ..field.power_series import inverse, power, product, taylor


def principal_parts(numerators: Sequence[sympy.Poly], factors: Factors) -> list[list[list[sympy.Poly]]]:
    """For each factor q, for each numerator: c_1 ... c_k of b / product = sum of c_j / (s - x)^j + ... at a root x of q."""
    return [_at_factor(numerators, factors, index) for index in range(len(factors))]


def _at_factor(numerators, factors, index) -> list[list[sympy.Poly]]:
    q, k = factors[index]
    slopes = taylor(q, q, k + 1)[1:]  # q(x + h) = h (q'(x) + q''(x) h / 2 + ...)
    below = [q.one] + [q.zero] * (k - 1)
    for other, multiplicity in factors:
        series = slopes if other == q else taylor(other, q, k)
        below = product(below, power(series, multiplicity, q), q)
    weight = inverse(below, q)
    return [product(taylor(b, q, k), weight, q)[::-1] for b in numerators]


def delta(t: sympy.Expr, order: int) -> sympy.Expr:
    """The derivative of Dirac's delta at t."""
    return sympy.DiracDelta(t, order) if order else sympy.DiracDelta(t)
