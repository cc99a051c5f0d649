"""Signs and square roots of rational functions of positive symbols, and numbers u + v sqrt(g) over their field, written in few terms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sympy
from sympy.polys.domains.domain import Domain

from .fields import expression_of, in_one_form


def sign(field: Domain, value) -> int | None:
    """Sign (1, -1 or 0) of the element for all positive values of the symbols; None where it is undecided.

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


def sign_with_root(field: Domain, rational, factor, radicand) -> int | None:
    """The sign of rational + factor sqrt(radicand)."""
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
    for part, exponent in ((field.numer(value), 1), (field.denom(value), -1)):
        constant, factors = part.factor_list()
        for factor, power in factors:
            outside *= field.convert(factor, ring) ** (exponent * (power // 2))
            inside *= field.convert(factor, ring) ** (exponent * (power % 2))
        number, rest = (field.convert_from(c, ring.domain) for c in _square_root_of_number(ring.domain, constant))
        outside, inside = outside * number**exponent, inside * rest**exponent
    return outside, inside


def root_expression(field: Domain, value) -> sympy.Expr:
    """The square root of an element as an expression, squares in front: sqrt(5) sqrt(k/m), not sqrt(5 k m)/m.

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
    total = _sign_of_number(p.ring.domain, constant)
    for each in signs:
        total = _times(total, each)
    return total


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
    """Coefficient of symbol^power in p, a polynomial in the other symbols."""
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


@dataclass(frozen=True)
class Surd:
    """u + v sqrt(g), elements of the field, g no square in it.

    >>> golden = Surd(sympy.QQ, sympy.QQ(1, 2), sympy.QQ(1, 2), sympy.QQ(5))
    >>> compact_expression(golden * golden - golden), golden.sign()
    (1, 1)
    """

    field: Domain
    u: Any
    v: Any
    g: Any

    def __add__(self, other: Surd) -> Surd:
        return Surd(self.field, self.u + other.u, self.v + other.v, self.g)

    def __sub__(self, other: Surd) -> Surd:
        return Surd(self.field, self.u - other.u, self.v - other.v, self.g)

    def __mul__(self, other: Surd) -> Surd:
        return Surd(self.field, self.u * other.u + self.v * other.v * self.g, self.u * other.v + self.v * other.u, self.g)

    def __neg__(self) -> Surd:
        return Surd(self.field, -self.u, -self.v, self.g)

    @property
    def conjugate(self) -> Surd:
        """u - v sqrt(g)."""
        return Surd(self.field, self.u, -self.v, self.g)

    def of(self, u) -> Surd:
        """An element of the field as a surd."""
        return Surd(self.field, u, self.field.zero, self.g)

    def sign(self) -> int | None:
        """Sign for all positive values of the symbols; None where it is undecided, or where the number may be complex."""
        if not self.v:
            return sign(self.field, self.u)
        return sign_with_root(self.field, self.u, self.v, self.g) if sign(self.field, self.g) == 1 else None


# Quartics as products of two quadratics over the field and one square root (Ferrari).

#: The order of preference of square roots: a real one, one that is imaginary for certain, one that depends on the symbols.
ORDER = {1: 0, -1: 1, None: 2}


def quadratic_factors(q: sympy.Poly) -> tuple[Surd, Surd] | None:
    """(a, b) with q = (s^2 + a s + b) times its conjugate, real where it can be; None where there is none.

    They are there for s^4 + b s^2 + c, and with Rayleigh damping.

    >>> s = sympy.Symbol("s")
    >>> a, b = quadratic_factors(sympy.Poly(s**4 + 3 * s**2 + 1, s, domain="QQ"))
    >>> compact_expression(a), compact_expression(b)
    (0, sqrt(5)/2 + 3/2)
    """
    field = q.domain
    h = q.rep.to_list()[1] / field.convert(4)
    moved = q.compose(sympy.Poly([field.one, -h], q.gen, domain=field)).rep.to_list()
    p, linear, last = moved[2:]
    resolvent = sympy.Poly([field.one, 2 * p, p * p - 4 * last, -linear * linear], q.gen, domain=field)
    lines = [factor.rep.to_list() for factor, _ in resolvent.factor_list()[1] if factor.degree() == 1]
    candidates = [_quadratic(field, h, p, linear, last, -zeroth / first) for first, zeroth in lines]
    return min(candidates, key=lambda parts: (ORDER[sign(field, parts[1].g)], bool(parts[0].v)), default=None)


def _quadratic(field, h, p, linear, last, z) -> tuple[Surd, Surd]:
    """s^2 + a s + b of the root z of the resolvent: its root is that of z, or of p^2 - 4 last where z = 0."""
    half = field.one / field.convert(2)
    outside, g = square_root(field, z if z else p * p - 4 * last)
    root = Surd(field, field.zero, outside, g)
    if not z:
        return root.of(2 * h), root.of(h * h + p * half) + root * root.of(half)
    return root.of(2 * h) + root, root.of(h * h + (p + z) * half) + root * root.of(h - linear * half / z)


# Expressions of few terms, what both parts share in front.


def compact_expression(number: Surd) -> sympy.Expr:
    """u + v sqrt(g) with the common factor of u and v in front, sqrt(g) too where g divides u.

    >>> k, m = sympy.symbols("k m")
    >>> K = sympy.ZZ.frac_field(k, m)
    >>> compact_expression(Surd(K, K.from_sympy(3 * k / m), K.from_sympy(k / m), K(5)))
    k*(sqrt(5) + 3)/m
    """
    field = number.field
    if not number.v:
        return expression_of(field, number.u)
    shared, u, v = _parted(number)
    if field.is_FractionField and not number.g.numer.is_ground and not u.numer.rem(number.g.numer):
        root = root_expression(field, number.g)
        return expression_of(field, shared * number.g) / root * _sum(number, v, u / number.g)  # u + v r = g/r (v + u/g r), r^2 = g
    return expression_of(field, shared) * _sum(number, u, v)


def compact_root(number: Surd) -> sympy.Expr:
    """A square root of u + v sqrt(g), the positive one where the number is positive.

    >>> k, m = sympy.symbols("k m")
    >>> K = sympy.ZZ.frac_field(k, m)
    >>> compact_root(Surd(K, K.from_sympy(3 * k / m / 2), K.from_sympy(k / m / 2), K(5)))
    sqrt(k/m)*(1/2 + sqrt(5)/2)
    """
    field = number.field
    if not number.v:
        return _denested(root_expression(field, in_one_form(field, number.u)))
    shared, u, v = _parted(number)
    inner = _sum(number, u, v)
    if not inner.is_number or not field.is_FractionField:
        return root_expression(field, shared) * sympy.sqrtdenest(sympy.sqrt(inner))
    front = (
        sympy.Rational(*(field.domain.to_sympy(part.content()) for part in (shared.numer, shared.denom)))
        if field.domain.is_ZZ
        else 1
    )
    denested = sympy.expand(
        sympy.sqrtdenest(sympy.sqrt(sympy.expand(front * inner)))
    )  # (3 + sqrt(5))/2 is a square, 3 + sqrt(5) is none
    return root_expression(field, shared / field.from_sympy(sympy.S(front))) * denested


def _denested(root: sympy.Expr) -> sympy.Expr:
    nested = [power for power in root.atoms(sympy.Pow) if power.is_number and not power.exp.is_Integer]
    return root.xreplace({power: sympy.expand(sympy.sqrtdenest(power)) for power in nested})


def _parted(number: Surd) -> tuple:
    """A common factor of u and v, and both without it."""
    field, u, v = number.field, number.u, number.v
    if not field.is_FractionField:
        return field.one, u, v
    shared = field((u.numer * v.denom).gcd(v.numer * u.denom)) / field(u.denom * v.denom)
    return shared, u / shared, v / shared


def _sum(number: Surd, u, v) -> sympy.Expr:
    field = number.field
    return field.to_sympy(u) + field.to_sympy(v) * root_expression(field, number.g)
