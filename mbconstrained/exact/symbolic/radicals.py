"""Zeros of irreducible polynomials in radicals, and the values of polynomials there.

Over the field K of the entries: degrees 1 and 2, s^4 + b s^2 + c (undamped systems of two degrees of freedom) and other products
of two quadratics over K(sqrt(g)). Values are found in K(sqrt(g)) exactly and written down once: nothing is simplified afterwards.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy

from .compact import compact_expression, compact_root, factored
from .quadratic_factors import quadratic_factors, reduced
from .signs import root_expression, sign
from .surds import Surd

#: Real and imaginary part of the value of a polynomial.
Parts = tuple[sympy.Expr, sympy.Expr]


@dataclass(frozen=True)
class Root:
    """A zero of an irreducible polynomial p in radicals.

    Attributes:
        real, imaginary: its parts; the imaginary one is 0 for a real zero, and of a complex pair this is the zero with the
            positive one. Where it depends on the symbols whether zeros are real (under- or overdamped), ``imaginary`` is 0 and
            a square root in ``real`` may be one of a negative number, as in Moysis et al., Eq. 95.
        at: the parts of e(root) for a Poly e over the field.
    """

    real: sympy.Expr
    imaginary: sympy.Expr
    at: Callable[[sympy.Poly], Parts]

    @property
    def value(self) -> sympy.Expr:
        """The zero as one expression."""
        return self.real + sympy.I * self.imaginary

    @property
    def is_pair(self) -> bool:
        """True where it stands for a pair of complex zeros."""
        return self.imaginary != 0


def roots(p: sympy.Poly) -> tuple[Root, ...] | None:
    """The zeros of an irreducible monic p over the field, of each complex pair one; None where there is no short closed form.

    >>> s, k, m = sympy.symbols("s k m")
    >>> p = sympy.Poly(s**4 + 3 * k / m * s**2 + k**2 / m**2, s, domain=sympy.ZZ.frac_field(k, m))
    >>> [root.imaginary for root in roots(p)]
    [sqrt(k/m)*(1/2 + sqrt(5)/2), sqrt(k/m)*(-1/2 + sqrt(5)/2)]
    """
    field = p.domain
    if p.degree() == 1:
        return (_root(p, lambda e: (factored(field, _coefficients(e, 1)[0]), sympy.S.Zero)),)
    if p.degree() == 2:
        b, a = (Surd(field, c, field.zero, field.one) for c in _coefficients(p, 2))
        return _of_quadratic(p, a, b)
    return _of_quartic(p) if p.degree() == 4 else None


def _coefficients(p: sympy.Poly, count: int) -> list:
    """Those of p, lowest power first, elements of the field."""
    found = p.rep.to_list()[::-1][:count]
    return found + [p.domain.zero] * (count - len(found))


def _root(p: sympy.Poly, parts: Callable[[sympy.Poly], Parts]) -> Root:
    """The root at which polynomials modulo p have these parts."""
    x = sympy.Poly([p.domain.one, p.domain.zero], p.gen, domain=p.domain)
    return Root(*parts(x.rem(p)), lambda e: parts(e.rem(p)))


def _of_quadratic(p, a: Surd, b: Surd) -> tuple[Root, ...]:
    """Of s^2 + a s + b: a complex pair where b - a^2/4 is positive, -a/2 +- sqrt(a^2/4 - b) elsewhere."""
    middle = a * a.of(-a.field.one / a.field.convert(2))
    square = b - middle * middle
    if square.sign() == 1:
        frequency = _root_of_difference(b, middle, 1)

        def parts(e) -> Parts:
            even, odd = reduced(e, a, b)
            return compact_expression(even + odd * middle), _multiple(odd, frequency, square)

        return (_root(p, parts),)
    distance = _root_of_difference(b, middle, -1)

    def part(way: int, e) -> Parts:
        even, odd = reduced(e, a, b)
        return compact_expression(even + odd * middle) + way * _multiple(odd, distance, -square), sympy.S.Zero

    return tuple(_root(p, lambda e, way=way: part(way, e)) for way in (-1, 1))


def _root_of_difference(b: Surd, middle: Surd, way: int) -> sympy.Expr:
    """The root of b - middle^2 (way 1) or of middle^2 - b (way -1), with a difference of factors under it where that is shorter."""
    field = b.field
    plain = compact_root((b - middle * middle) * b.of(field.convert(way)))
    if b.v or middle.v or not field.is_FractionField:
        return plain
    below = field.convert(field.denom(middle.u), field.get_ring())
    inside = way * (factored(field, b.u * below**2) - factored(field, (middle.u * below) ** 2))
    return min(plain, sympy.sqrt(inside) / factored(field, below), key=sympy.count_ops)


def _multiple(number: Surd, root: sympy.Expr, square: Surd) -> sympy.Expr:
    """number times the root of the square, or number square / root where that is shorter."""
    if not number.u and not number.v:
        return sympy.S.Zero
    return min(
        _number_in_front(compact_expression(number) * root),
        _number_in_front(compact_expression(number * square) / root),
        key=sympy.count_ops,
    )


def _number_in_front(product: sympy.Expr) -> sympy.Expr:
    """Without roots in the denominator of the number in front."""
    number, rest = product.as_independent(*product.free_symbols, as_Add=False) if product.free_symbols else (product, sympy.S.One)
    return sympy.expand(sympy.radsimp(number)) * rest


def _of_quartic(p) -> tuple[Root, ...] | None:
    """Of both quadratics over K(sqrt(g)), or of s^4 + b s^2 + c with two complex pairs a root of c apart."""
    field = p.domain
    c, odd, b, cubic = _coefficients(p, 4)
    found = quadratic_factors(p)
    if found is not None:
        other = [Surd(field, part.u, -part.v, part.g) for part in found]
        return (*_of_quadratic(p, *found), *_of_quadratic(p, *other))
    if odd or cubic or sign(field, b * b / field.convert(4) - c) != -1:
        return None
    return tuple(_of_complex_square(p, way, b, c) for way in (-1, 1))


def _of_complex_square(p, way: int, b, c) -> Root:
    """s = way alpha + i beta, alpha^2 = (2 sqrt(c) - b)/4, beta^2 = (2 sqrt(c) + b)/4, where s^2 = -b/2 +- i sqrt(c - b^2/4)."""
    field = p.domain
    middle = -b / field.convert(2)
    side = way * root_expression(field, c - middle * middle)
    twice = 2 * root_expression(field, c)
    alpha, beta = way * sympy.sqrt(twice - factored(field, b)) / 2, sympy.sqrt(twice + factored(field, b)) / 2

    def parts(e) -> Parts:
        e0, e1, e2, e3 = _coefficients(e, 4)
        even, odd = (factored(field, low + high * middle) for low, high in ((e0, e2), (e1, e3)))
        up_even, up_odd = (factored(field, high) * side for high in (e2, e3))
        return even + alpha * odd - beta * up_odd, up_even + beta * odd + alpha * up_odd

    return _root(p, parts)
