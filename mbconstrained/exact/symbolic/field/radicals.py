"""Zeros of irreducible polynomials, and the values of polynomials there: all that responses and Jordan forms know of zeros.

In radicals over the field K of the entries: degrees 1 and 2, s^4 + b s^2 + c (undamped systems of two degrees of freedom) and
other products of two quadratics over K(sqrt(g)). Values are found in K(sqrt(g)) exactly and written down once: nothing is
simplified afterwards. Other polynomials with numbers have zeros of 30 digits, others with symbols none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import sympy

from .compact import compact_expression, compact_root, factored
from .factoring import coefficients
from .numerical_roots import numerical_roots, rounded, value_at
from .quadratic_factors import quadratic_factors
from .quadratics import Quadratic
from .signs import root_expression, sign, sign_with_root
from .surds import Surd

#: Real and imaginary part of the value of a polynomial.
Parts = tuple[sympy.Expr, sympy.Expr]


@dataclass(frozen=True)
class Root:
    """A zero of an irreducible polynomial p.

    Attributes:
        real, imaginary: its parts; the imaginary one is 0 for a real zero, and of a complex pair this is the zero with the
            positive one, where the sign is seen. Where it depends on the symbols whether two zeros are real (under- or
            overdamped), a square root in them may be one of a negative number, as in Moysis et al., Eq. 95.
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


def roots(p: sympy.Poly, split: bool = True) -> tuple[Root, ...] | None:
    """The zeros of an irreducible monic p over the field, of each complex pair one; None where there are symbols and no short closed form.

    Args:
        split: two zeros of which it depends on the symbols whether they are real: True: as two, with imaginary part 0; False: as
            a pair. Either may have the square root of a negative number.

    >>> s, k, m = sympy.symbols("s k m")
    >>> p = sympy.Poly(s**4 + 3 * k / m * s**2 + k**2 / m**2, s, domain=sympy.ZZ.frac_field(k, m))
    >>> [root.imaginary for root in roots(p)]
    [sqrt(k/m)*(1/2 + sqrt(5)/2), sqrt(k/m)*(-1/2 + sqrt(5)/2)]
    """
    field = p.domain
    if p.degree() == 1:
        return (_root(p, lambda e: (factored(field, coefficients(e, 1)[0]), sympy.S.Zero)),)
    if p.degree() == 2:
        b, a = (Surd(field, c, field.zero, field.one) for c in coefficients(p, 2))
        return _of_quadratic(p, Quadratic(a, b), split)
    found = quadratic_factors(p) if p.degree() == 4 else None
    if found is not None:
        one = Quadratic(*found)
        if sign(field, one.b.g) == -1:
            return tuple(_of_complex_quadratic(p, one, way) for way in (1, -1))
        return (*_of_quadratic(p, one, split), *_of_quadratic(p, one.conjugate, split))
    if p.free_symbols_in_domain:  # pi is none
        return None
    return tuple(Root(*map(rounded, root), lambda e, root=root: value_at(root, e.rem(p))) for root in numerical_roots(p))


def _root(p: sympy.Poly, parts: Callable[[sympy.Poly], Parts]) -> Root:
    """The root at which polynomials modulo p have these parts."""
    x = sympy.Poly([p.domain.one, p.domain.zero], p.gen, domain=p.domain)
    return Root(*parts(x.rem(p)), lambda e: parts(e.rem(p)))


def _of_quadratic(p, quadratic: Quadratic, split: bool) -> tuple[Root, ...]:
    """A complex pair where b - a^2/4 is positive, -a/2 +- sqrt(a^2/4 - b) elsewhere."""
    known = quadratic.square.sign()
    if known == 1 or (known is None and not split):
        frequency = _root_of_difference(quadratic, 1)

        def parts(e) -> Parts:
            even, *odd = quadratic.value(e)
            return compact_expression(even), _multiple(*odd, frequency)

        return (Root(compact_expression(quadratic.middle), frequency, lambda e: parts(e.rem(p))),)
    middle, distance = compact_expression(quadratic.middle), _root_of_difference(quadratic, -1)

    def part(way: int, e) -> Parts:
        even, odd, turned = quadratic.value(e.rem(p))
        return compact_expression(even) + way * _multiple(odd, -turned, distance), sympy.S.Zero

    return tuple(Root(middle + way * distance, sympy.S.Zero, partial(part, way)) for way in (-1, 1))


def _root_of_difference(quadratic: Quadratic, way: int) -> sympy.Expr:
    """The root of b - middle^2 (way 1) or of middle^2 - b (way -1), with a difference of factors under it where that is shorter."""
    b, middle, field = quadratic.b, quadratic.middle, quadratic.b.field
    plain = _number_in_front(compact_root(quadratic.square.times(field.convert(way))))
    if b.v or middle.v or not field.is_FractionField:
        return plain
    below = field.convert(field.denom(middle.u), field.get_ring())
    inside = way * (factored(field, b.u * below**2) - factored(field, (middle.u * below) ** 2))
    return min(plain, sympy.sqrt(inside) / factored(field, below), key=sympy.count_ops)


def _multiple(number: Surd, turned: Surd, root: sympy.Expr) -> sympy.Expr:
    """number times the root, or turned / root where that is shorter: turned is number times the square of the root."""
    if not number.u and not number.v:
        return sympy.S.Zero
    forms = compact_expression(number) * root, compact_expression(turned) / root
    return min(map(_number_in_front, forms), key=sympy.count_ops)


def _number_in_front(product: sympy.Expr) -> sympy.Expr:
    """Without roots in the denominator of the number in front."""
    number, rest = product.as_independent(*product.free_symbols, as_Add=False) if product.free_symbols else (product, sympy.S.One)
    return sympy.expand(sympy.radsimp(number)) * rest


def _of_complex_quadratic(p, quadratic: Quadratic, way: int) -> Root:
    """x = middle + way (alpha + i beta), with sqrt(g) = i r and (alpha + i beta)^2 = -square; the conjugates are the other zeros."""
    field, middle, square = p.domain, quadratic.middle, -quadratic.square
    norm, r = square.u**2 - square.v**2 * square.g, root_expression(field, -square.g)
    twice = 2 * root_expression(field, norm)
    alpha = way * sympy.sqrt(twice + factored(field, square.u + square.u)) / 2
    side = sign(field, square.v)
    beta = factored(field, square.v) * r / (2 * alpha)
    if side:
        beta = way * side * sympy.sqrt(twice - factored(field, square.u + square.u)) / 2
    longer = sign_with_root(field, 2 * middle.v**2 * middle.g - square.u, field.one, norm)  # of beta^2 - (middle.v r)^2
    up = {1: way * side if side else 1, -1: sign(field, middle.v)}.get(longer) or 1

    def parts(e) -> Parts:
        even, odd, _ = quadratic.value(e)
        (e0, e1), (o0, o1) = ((factored(field, part.u), factored(field, part.v) * r) for part in (even, odd))
        return e0 + o0 * alpha - o1 * beta, up * (e1 + o1 * alpha + o0 * beta)

    return _root(p, parts)
