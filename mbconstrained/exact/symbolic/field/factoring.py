"""Irreducible factors over the field of the entries, and inverses modulo a polynomial."""

from __future__ import annotations

from functools import reduce

import sympy
from sympy.polys.domains.domain import Domain
from sympy.polys.matrices import DomainMatrix

from .compact import in_one_form

#: (q, k): an irreducible monic factor and its multiplicity.
Factors = list[tuple[sympy.Poly, int]]

#: Characters of a polynomial in a representation.
LONGEST = 60


def integers(field: Domain) -> Domain:
    """The ring that the field consists of fractions of; the field itself where it has none."""
    return field.get_ring() if field.has_assoc_Ring else field


def factors_of(p: sympy.Poly) -> Factors:
    """The monic irreducible factors of p over its field with their powers, those of low degree first.

    Over rational functions of symbols, p times its denominators is factored as a polynomial in s and the symbols (Gauss).

    >>> s, k, m = sympy.symbols("s k m")
    >>> factors_of(sympy.Poly(m * s**3 + k * s, s, domain=sympy.ZZ.frac_field(k, m)))
    [(Poly(s, s, domain='ZZ(k,m)'), 1), (Poly(s**2 + k/m, s, domain='ZZ(k,m)'), 1)]
    """
    order = min((power for (power,), _ in p.terms()), default=0)
    rest = sympy.Poly(p.rep.to_list()[: p.degree() - order + 1], p.gen, domain=p.domain) if order else p  # factoring is slow
    found = [(sympy.Poly([p.domain.one, p.domain.zero], p.gen, domain=p.domain), order)] if order else []
    if p.domain.is_FractionField:
        rest = rest.clear_denoms(convert=True)[1]
    found += [(_monic(factor, p.domain), power) for factor, power in rest.factor_list()[1] if factor.degree() > 0]
    return sorted(found, key=lambda pair: (pair[0].degree(), len(pair[0].terms()), pair[1], str(pair[0])))


def _monic(factor: sympy.Poly, field: Domain) -> sympy.Poly:
    """With equal coefficients where polynomials are equal."""
    monic = factor.set_domain(field).monic()
    return sympy.Poly([in_one_form(field, c) for c in monic.rep.to_list()], monic.gen, domain=field)


def inverse_modulo(unit: sympy.Poly, modulus: sympy.Poly) -> sympy.Poly:
    """1 / unit modulo a polynomial: the first column of the inverse of the matrix of v -> unit v.

    By elimination without fractions: those of Euclid's algorithm grow. Modulo s^k it is a power series.

    >>> s = sympy.Symbol("s")
    >>> inverse_modulo(sympy.Poly(s**2 - 1, s, domain="QQ"), sympy.Poly(s**3, s, domain="QQ"))
    Poly(-s**2 - 1, s, domain='QQ')
    """
    field, degree, ring = unit.domain, modulus.degree(), integers(unit.domain)
    if len(modulus.terms()) == 1:
        return _inverse_series(unit, degree)
    columns = [coefficients((unit * sympy.Poly(unit.gen**i, unit.gen, domain=field)).rem(modulus), degree) for i in range(degree)]
    scale = field.one
    if field.has_assoc_Ring:
        scale = field.convert_from(reduce(ring.lcm, (field.denom(c) for column in columns for c in column)), ring)
    rows = [[ring.convert_from(column[i] * scale, field) for column in columns] for i in range(degree)]
    one = DomainMatrix([[ring.one if i == 0 else ring.zero] for i in range(degree)], (degree, 1), ring)
    numerators, denominator = DomainMatrix(rows, (degree, degree), ring).solve_den(one, method="rref")
    factor = scale / field.convert_from(denominator, ring)
    first = [field.convert_from(row[0], ring) * factor for row in numerators.to_list()]
    return sympy.Poly(first[::-1], unit.gen, domain=field)


def _inverse_series(unit: sympy.Poly, count: int) -> sympy.Poly:
    """1 / unit modulo s^count."""
    first, *others = coefficients(unit, count)
    found = [unit.domain.one / first]
    for j in range(1, count):
        known = sum((c * found[j - i] for i, c in enumerate(others[:j], 1)), unit.domain.zero)
        found.append(-known * found[0])
    return sympy.Poly(found[::-1], unit.gen, domain=unit.domain)


def coefficients(p: sympy.Poly, count: int) -> list:
    """The first of p, lowest power first, elements of the field."""
    found = p.rep.to_list()[::-1][:count]
    return found + [p.domain.zero] * (count - len(found))


def described(p: sympy.Poly) -> str:
    """p in short, for representations: its degree where it is long."""
    text = str(p.as_expr())
    return text if len(text) <= LONGEST else f"of degree {p.degree()} in {p.gen}"


def constant(p: sympy.Poly, value) -> sympy.Poly:
    """An element of the field of p as a Poly."""
    return sympy.Poly.from_list([value], p.gen, domain=p.domain)


def resultant(p: sympy.Poly, other: sympy.Poly):
    """Of two Polys over the field, an element of it: zero where they have a zero in common."""
    return p.domain.from_sympy(p.resultant(other))
