"""Partial fractions over a field K: exact, the roots of irreducible factors never computed.

At a root x of an irreducible factor q of the denominator, of multiplicity k, the coefficients of the principal part are the
same polynomials in x for all roots of q, with coefficients in K: they are found in K[x]/q.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import sympy
from sympy.polys.matrices import DomainMatrix

from .compact import in_one_form
from .factoring import integers

#: The variable of all transforms.
S = sympy.Symbol("s")

#: (q, k): an irreducible monic factor and its multiplicity.
Factors = list[tuple[sympy.Poly, int]]


def factors_of(denominator: sympy.Poly) -> Factors:
    """The irreducible factors over the field of the polynomial, monic; a power of s is taken out first."""
    coefficients = denominator.rep.to_list()
    field, gen = denominator.domain, denominator.gen
    order = next(i for i, c in enumerate(reversed(coefficients)) if c)
    found = [(sympy.Poly(gen, gen, domain=field), order)] if order else []
    rest = sympy.Poly(coefficients[: len(coefficients) - order], gen, domain=field)
    return found + [(_in_one_form(q.monic()), k) for q, k in rest.factor_list()[1]]


def _in_one_form(q: sympy.Poly) -> sympy.Poly:
    """Equal polynomials with equal coefficients."""
    return sympy.Poly([in_one_form(q.domain, c) for c in q.rep.to_list()], q.gen, domain=q.domain)


def principal_parts(numerators: Sequence[sympy.Poly], factors: Factors) -> list[list[list[sympy.Poly]]]:
    """For each factor q, for each numerator: c_1 ... c_k of b / product = sum of c_j / (s - x)^j + ... at a root x of q."""
    return [_at_factor(numerators, factors, index) for index in range(len(factors))]


def _at_factor(numerators, factors, index) -> list[list[sympy.Poly]]:
    q, k = factors[index]
    slopes = taylor(q, q, k + 1)[1:]  # q(x + h) = h (q'(x) + q''(x) h / 2 + ...)
    below = [q.one] + [q.zero] * (k - 1)
    for other, multiplicity in factors:
        series = slopes if other == q else taylor(other, q, k)
        for _ in range(multiplicity):
            below = _times(below, series, q)
    inverse = _inverted(below, q)
    return [_times(taylor(b, q, k), inverse, q)[::-1] for b in numerators]


def taylor(p: sympy.Poly, q: sympy.Poly, count: int) -> list[sympy.Poly]:
    """The coefficients of 1, h, h^2, ... of p(x + h) modulo q."""
    found, field = [p.rem(q)], q.domain
    for j in range(1, count):
        p = p.diff() * sympy.Poly([field.one / field.convert(j)], q.gen, domain=field)
        found.append(p.rem(q))
    return found


def _times(one, two, q) -> list[sympy.Poly]:
    return [sum((one[i] * two[j - i] for i in range(j + 1)), q.zero).rem(q) for j in range(len(one))]


def _inverted(series, q) -> list[sympy.Poly]:
    """1 / series, to the same order."""
    first = _inverse(series[0], q)
    found = [first]
    for j in range(1, len(series)):
        known = sum((series[i] * found[j - i] for i in range(1, j + 1)), q.zero)
        found.append((-known * first).rem(q))
    return found


def _inverse(u: sympy.Poly, q: sympy.Poly) -> sympy.Poly:
    """1 / u modulo q: the first column of the inverse of the matrix of v -> u v, by elimination without fractions (Euclid's grow)."""
    field, degree, ring = q.domain, q.degree(), integers(q.domain)
    columns = [_coefficients((u * sympy.Poly(q.gen**i, q.gen, domain=field)).rem(q), degree) for i in range(degree)]
    scale = field.one
    if field.has_assoc_Ring:
        scale = field.convert_from(reduce(ring.lcm, (field.denom(c) for column in columns for c in column)), ring)
    rows = [[ring.convert_from(column[i] * scale, field) for column in columns] for i in range(degree)]
    one = DomainMatrix([[ring.one if i == 0 else ring.zero] for i in range(degree)], (degree, 1), ring)
    numerators, denominator = DomainMatrix(rows, (degree, degree), ring).solve_den(one, method="rref")
    factor = scale / field.convert_from(denominator, ring)
    first = [field.convert_from(row[0], ring) * factor for row in numerators.to_list()]
    return sympy.Poly(first[::-1], q.gen, domain=field)


def _coefficients(p: sympy.Poly, count: int) -> list:
    """Those of p, lowest power first."""
    found = p.rep.to_list()[::-1][:count]
    return found + [p.domain.zero] * (count - len(found))


def series_at_infinity(numerator: sympy.Poly, denominator: sympy.Poly, lowest: int) -> dict[int, object]:
    """{i: c_i} with numerator / denominator = sum of c_i s^i near infinity, i >= lowest, by long division, elements of the field."""
    above, below = numerator.rep.to_list(), denominator.rep.to_list()
    highest = len(above) - len(below)
    rest = list(above) + [numerator.domain.zero] * max(0, -lowest + len(below) - 1)
    found = {}
    for place, power in enumerate(range(highest, lowest - 1, -1)):
        factor = rest[place] / below[0]
        found[power] = factor
        if factor:
            for k, c in enumerate(below):
                rest[place + k] -= factor * c
    return found


def delta(t: sympy.Expr, order: int) -> sympy.Expr:
    """The derivative of Dirac's delta at t."""
    return sympy.DiracDelta(t, order) if order else sympy.DiracDelta(t)
