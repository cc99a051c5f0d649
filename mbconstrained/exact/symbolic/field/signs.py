"""The sign of a rational function of positive symbols, where it has one; and square roots taken as far as they go."""

from __future__ import annotations

import sympy
from sympy.polys.domains.domain import Domain

from .fields import expression_of


def sign(field: Domain, value) -> int | None:
    """1, -1 or 0 where the element of the field has this sign for all positive values of the symbols, None where it is not seen.

    Coefficients of one sign decide, factor by factor; so does a negative discriminant in one of the symbols.

    >>> a, b = sympy.symbols("a b")
    >>> K = sympy.ZZ.frac_field(a, b)
    >>> [sign(K, K.from_sympy(e)) for e in (a / b, a**2 - a * b + b**2, a - b, -((a - b) ** 2) * a)]
    [1, 1, None, -1]
    """
    if not value:
        return 0
    if not field.is_FractionField:
        return _sign_of_number(field, value)
    return _times(_sign_of_polynomial(field.numer(value)), _sign_of_polynomial(field.denom(value)))


def definite(field: Domain, value) -> bool:
    """True where the element cannot vanish, whatever positive values the symbols take."""
    return sign(field, value) in (1, -1)


def sign_with_root(field: Domain, rational, factor, radicand) -> int | None:
    """The sign of rational + factor sqrt(radicand), the radicand positive and no square in the field; None where it is not seen."""
    one, two = sign(field, rational), sign(field, factor)
    if one is None or two is None:
        return None
    if one * two >= 0:
        return one or two
    return _times(one, sign(field, rational**2 - factor**2 * radicand))


def square_root(field: Domain, value) -> tuple:
    """f and g, elements of the field, with value = f^2 g, g free of squares.

    >>> K = sympy.QQ
    >>> square_root(K, K(5, 4))
    (1/2, 5)
    """
    if not value or not field.is_FractionField:
        return _square_root_of_number(field, value)
    ring, outside, inside = field.get_ring(), field.one, field.one
    for part, way in ((field.numer(value), 1), (field.denom(value), -1)):
        constant, factors = part.factor_list()
        for factor, power in factors:
            outside *= field.convert(factor, ring) ** (way * (power // 2))
            inside *= field.convert(factor, ring) ** (way * (power % 2))
        number, rest = (field.convert_from(c, ring.domain) for c in _square_root_of_number(ring.domain, constant))
        outside, inside = outside * number**way, inside * rest**way
    return outside, inside


def root_expression(field: Domain, value) -> sympy.Expr:
    """The square root of an element as an expression, squares taken out: sqrt(5) sqrt(k/m), not sqrt(5 k m)/m.

    >>> k, m = sympy.symbols("k m")
    >>> K = sympy.ZZ.frac_field(k, m)
    >>> root_expression(K, K.from_sympy(12 * k**3 / m))
    2*sqrt(3)*k*sqrt(k/m)
    """
    f, g = square_root(field, value)
    if not field.is_FractionField:
        return field.to_sympy(f) * sympy.sqrt(field.to_sympy(g))
    content, rest = _content(field, g)
    return expression_of(field, f) * sympy.sqrt(content) * sympy.sqrt(expression_of(field, rest))


def _content(field: Domain, value) -> tuple:
    """A positive number and the rest of an element of the field."""
    ring = field.get_ring()
    if not ring.domain.is_ZZ:
        return sympy.S.One, value
    above, below = abs(field.numer(value).content()), abs(field.denom(value).content())
    return sympy.Rational(int(above), int(below)), value * field.convert(below) / field.convert(above)


def _sign_of_number(domain: Domain, number) -> int:
    value = domain.to_sympy(number)
    return 1 if value.is_positive else -1


def _sign_of_polynomial(p) -> int | None:
    constant, factors = p.factor_list()
    signs = [1 if power % 2 == 0 else _sign_of_factor(factor) for factor, power in factors]
    found = _sign_of_number(p.ring.domain, constant)
    for each in signs:
        found = _times(found, each)
    return found


def _sign_of_factor(p) -> int | None:
    signs = {_sign_of_number(p.ring.domain, c) for c in p.coeffs()}
    if len(signs) == 1:
        return signs.pop()
    if (number := p.as_expr()).is_number:  # pi is one of the symbols of the ring
        return 1 if number.is_positive else -1
    for symbol in p.ring.gens:
        if p.degree(symbol) == 2:
            zeroth, first, second = (_coefficient(p, symbol, power) for power in range(3))
            discriminant = first**2 - 4 * zeroth * second
            if zeroth and discriminant and _sign_of_polynomial(discriminant) == -1:
                return _sign_of_polynomial(second)
    return None


def _coefficient(p, symbol, power: int):
    """Of symbol^power in p, a polynomial in the other symbols."""
    place = p.ring.index(symbol)
    terms = {tuple(0 if i == place else e for i, e in enumerate(m)): c for m, c in p.terms() if m[place] == power}
    return p.ring.from_dict(terms)


def _square_root_of_number(domain: Domain, number) -> tuple:
    if not (domain.is_ZZ or domain.is_QQ) or not number:
        return domain.one, number
    value = domain.to_sympy(number)
    root = sympy.sqrt(abs(value.p * value.q))
    outside, inside = root.as_coeff_Mul()
    squarefree = sympy.sign(value) * inside**2
    if domain.is_ZZ:
        return domain.from_sympy(outside), domain.from_sympy(squarefree)
    return domain.from_sympy(outside / value.q), domain.from_sympy(squarefree)


def _times(one: int | None, two: int | None) -> int | None:
    return None if one is None or two is None else one * two
