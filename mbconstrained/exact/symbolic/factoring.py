"""Irreducible factors over the field of the entries, and inverses modulo a polynomial."""

from __future__ import annotations

import sympy
from sympy.polys.domains.domain import Domain


def integers(field: Domain) -> Domain:
    """The ring that the field consists of fractions of; the field itself where it has none."""
    return field.get_ring() if field.has_assoc_Ring else field


def factors(p: sympy.Poly) -> list[tuple[sympy.Poly, int]]:
    """The monic irreducible factors of p over its field with their powers, those of low degree first.

    Over rational functions of symbols, p times its denominators is factored as a polynomial in s and the symbols (Gauss).

    >>> s, k, m = sympy.symbols("s k m")
    >>> factors(sympy.Poly(m * s**3 + k * s, s, domain=sympy.ZZ.frac_field(k, m)))
    [(Poly(s, s, domain='ZZ(k,m)'), 1), (Poly(s**2 + k/m, s, domain='ZZ(k,m)'), 1)]
    """
    field = p.domain
    if not field.is_FractionField:
        found = [(factor.monic(), power) for factor, power in p.factor_list()[1]]
    else:
        whole = p.clear_denoms(convert=True)[1]
        found = [(factor.set_domain(field).monic(), power) for factor, power in whole.factor_list()[1] if factor.degree() > 0]
    return sorted(found, key=lambda pair: (pair[0].degree(), len(pair[0].terms()), pair[1], str(pair[0])))


def inverse_modulo(unit: sympy.Poly, modulus: sympy.Poly) -> sympy.Poly:
    """The inverse modulo a polynomial, factor by factor: that of s - a is (m(a) - m(s)) / (s - a) / m(a), without Euclid.

    >>> s = sympy.Symbol("s")
    >>> inverse_modulo(sympy.Poly(s**2 - 1, s, domain="QQ"), sympy.Poly(s**3, s, domain="QQ"))
    Poly(-s**2 - 1, s, domain='QQ')
    """
    found = constant(unit, unit.domain.one / unit.rep.LC())
    for factor, power in factors(unit):
        if factor.degree() == 1:
            rest = modulus.rem(factor)
            inverse = (rest - modulus).quo(factor) * constant(unit, unit.domain.one / rest.rep.LC())
        else:
            inverse = factor.invert(modulus)
        for _ in range(power):
            found = (found * inverse).rem(modulus)
    return found


def constant(p: sympy.Poly, value) -> sympy.Poly:
    """An element of the field of p as a Poly."""
    return sympy.Poly.from_list([value], p.gen, domain=p.domain)


def resultant(p: sympy.Poly, other: sympy.Poly):
    """Of two Polys over the field, an element of it: zero where they have a zero in common."""
    return p.domain.from_sympy(p.resultant(other))
