"""Zeros of irreducible polynomials in radicals, and numbers u + v sqrt(g) over the field of the entries."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial, reduce
from typing import Any

import sympy
from sympy.polys.domains.domain import Domain

from ...ground.errors import InputError
from .fields import coefficients, expression_of, in_one_form, root_expression, sign, sign_with_root, square_root


@dataclass(frozen=True)
class Surd:
    """u + v sqrt(g), elements of the field, g no square in it."""

    field: Domain
    u: Any
    v: Any
    g: Any

    def __add__(self, other: Surd) -> Surd:
        return Surd(self.field, self.u + other.u, self.v + other.v, self.g)

    def __sub__(self, other: Surd) -> Surd:
        return self + -other

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


def compact_expression(number: Surd) -> sympy.Expr:
    """u + v sqrt(g) with the common factor of u and v in front, sqrt(g) too where g divides u."""
    field = number.field
    if not number.v:
        return expression_of(field, number.u)
    shared, u, v = _parted(number)
    if field.is_FractionField and not number.g.numer.is_ground and not u.numer.rem(number.g.numer):
        root = root_expression(field, number.g)
        return expression_of(field, shared * number.g) / root * _sum(number, v, u / number.g)  # u + v r = g/r (v + u/g r), r^2 = g
    return expression_of(field, shared) * _sum(number, u, v)


def compact_root(number: Surd) -> sympy.Expr:
    """A square root of u + v sqrt(g), the positive one where the number is positive."""
    field = number.field
    if not number.v:
        root = root_expression(field, in_one_form(field, number.u))
        nested = [power for power in root.atoms(sympy.Pow) if power.is_number and not power.exp.is_Integer]
        return root.xreplace({power: sympy.expand(sympy.sqrtdenest(power)) for power in nested})
    shared, u, v = _parted(number)
    inner = _sum(number, u, v)
    if not inner.is_number or not field.is_FractionField:
        return root_expression(field, shared) * sympy.sqrtdenest(sympy.sqrt(inner))
    front = sympy.S.One
    if field.domain.is_ZZ:
        front = sympy.Rational(*(field.domain.to_sympy(part.content()) for part in (shared.numer, shared.denom)))
    denested = sympy.sqrtdenest(sympy.sqrt(sympy.expand(front * inner)))  # (3 + sqrt(5))/2 is a square, 3 + sqrt(5) is none
    return root_expression(field, shared / field.from_sympy(front)) * sympy.expand(denested)


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


# Zeros of irreducible polynomials, and values of polynomials there, in the form of responses and Jordan forms.
#
# In radicals over the field K of the entries: degrees 1 and 2, s^4 + b s^2 + c (undamped systems of two degrees of freedom) and
# other products of two quadratics over K(sqrt(g)). Values are computed in K(sqrt(g)) exactly and written down once: nothing is
# simplified afterwards. Other polynomials with numbers have zeros of 30 digits, others with symbols none.

#: Real and imaginary part of the value of a polynomial.
Parts = tuple[sympy.Expr, sympy.Expr]


@dataclass(frozen=True)
class Root:
    """A zero of an irreducible polynomial; of a complex pair the one with the positive imaginary part, where its sign is seen."""

    # Where it depends on the symbols whether two zeros are real, a square root may be one of a negative number (Moysis et al., Eq. 95).
    real: sympy.Expr
    imaginary: sympy.Expr  # 0 of a real zero
    at: Callable[[sympy.Poly], Parts]  # the parts of e(root) for a Poly e over the field

    @property
    def value(self) -> sympy.Expr:
        return self.real + sympy.I * self.imaginary

    @property
    def is_pair(self) -> bool:
        return self.imaginary != 0

    def weights(self, c: sympy.Poly) -> Parts:
        """The factors of cos(w t) and sin(w t) in the sum of c(x) e^{(x - rate) t} over the zero or the pair, w the imaginary part."""
        real, imaginary = self.at(c)
        return (2 * real, -2 * imaginary) if self.is_pair else (real, sympy.S.Zero)


def roots(p: sympy.Poly, split: bool = True) -> tuple[Root, ...] | None:
    """The zeros of an irreducible monic p over the field, one of each complex pair; None for symbols without a short closed form."""
    field = p.domain
    if p.degree() == 1:
        return (_root(p, lambda e: (expression_of(field, coefficients(e, 1)[0]), sympy.S.Zero)),)
    if p.degree() == 2:
        b, a = (Surd(field, c, field.zero, field.one) for c in coefficients(p, 2))
        return _of_quadratic(p, Quadratic(a, b), split)
    factors = quadratic_factors(p) if p.degree() == 4 else None
    if factors is not None:
        one = Quadratic(*factors)
        if sign(field, one.b.g) == -1:
            return tuple(_of_complex_quadratic(p, one, branch) for branch in (1, -1))
        return (*_of_quadratic(p, one, split), *_of_quadratic(p, one.conjugate, split))
    if p.free_symbols_in_domain:  # pi is none
        return None
    numerical = p if p.domain.is_QQ else sympy.Poly([c.evalf(3 * DIGITS) for c in p.all_coeffs()], p.gen)
    parts = [root.as_real_imag() for root in numerical.nroots(n=2 * DIGITS, maxsteps=500)]
    above = [(real, imaginary) for real, imaginary in parts if imaginary >= 0]
    return tuple(Root(*map(_rounded, root), lambda e, root=root: _value_at(root, e.rem(p))) for root in above)


def modes(q: sympy.Poly) -> tuple[Root, ...]:
    """The zeros of an irreducible polynomial as exponents of functions of time: e^{a t} cos(w t) and e^{a t} sin(w t).

    Where the sign of w^2 depends on the values of the symbols, as that of 4 k m - c^2 does, the pair a +- i w is given: cos(w t) and
    w sin(w t) are even in w, so that they hold for w^2 < 0 as well, with the root of a negative number, and for w^2 = 0 as a limit.
    """
    zeros = roots(q.monic(), split=False)
    if zeros is None:
        raise InputError(
            f"the factor {q.as_expr()} of the determinant has no roots in closed form; give some of its symbols "
            f"({', '.join(map(str, q.domain.symbols))}) as numbers, or use numbers throughout (mb.solve)"
        )
    return zeros


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

    def part(branch: int, e) -> Parts:
        even, odd, turned = quadratic.value(e.rem(p))
        return compact_expression(even) + branch * _multiple(odd, -turned, distance), sympy.S.Zero

    return tuple(Root(middle + branch * distance, sympy.S.Zero, partial(part, branch)) for branch in (-1, 1))


def _root_of_difference(quadratic: Quadratic, branch: int) -> sympy.Expr:
    """The root of b - middle^2 (branch 1) or of middle^2 - b (branch -1), with a difference of factors under it where that is shorter."""
    b, middle, field = quadratic.b, quadratic.middle, quadratic.b.field
    direct = _number_in_front(compact_root(quadratic.square if branch == 1 else -quadratic.square))
    if b.v or middle.v or not field.is_FractionField:
        return direct
    below = field.convert(field.denom(middle.u), field.get_ring())
    inside = branch * (expression_of(field, b.u * below**2) - expression_of(field, (middle.u * below) ** 2))
    return min(direct, sympy.sqrt(inside) / expression_of(field, below), key=sympy.count_ops)


def _multiple(number: Surd, turned: Surd, root: sympy.Expr) -> sympy.Expr:
    """number times the root, or turned / root where that is shorter: turned is number times the square of the root."""
    if not number.u and not number.v:
        return sympy.S.Zero
    forms = compact_expression(number) * root, compact_expression(turned) / root
    return min(map(_number_in_front, forms), key=sympy.count_ops)


def _number_in_front(product: sympy.Expr) -> sympy.Expr:
    """The product without roots in the denominator of its leading number."""
    number, rest = product.as_independent(*product.free_symbols, as_Add=False) if product.free_symbols else (product, sympy.S.One)
    return sympy.expand(sympy.radsimp(number)) * rest


def _of_complex_quadratic(p, quadratic: Quadratic, branch: int) -> Root:
    """x = middle + branch (alpha + i beta), with sqrt(g) = i r and (alpha + i beta)^2 = -square; the conjugates are the other zeros."""
    field, middle, square = p.domain, quadratic.middle, -quadratic.square
    norm, r = square.u**2 - square.v**2 * square.g, root_expression(field, -square.g)
    twice = 2 * root_expression(field, norm)
    alpha = branch * sympy.sqrt(twice + expression_of(field, square.u + square.u)) / 2
    side = sign(field, square.v)
    beta = expression_of(field, square.v) * r / (2 * alpha)
    if side:
        beta = branch * side * sympy.sqrt(twice - expression_of(field, square.u + square.u)) / 2
    longer = sign_with_root(field, 2 * middle.v**2 * middle.g - square.u, field.one, norm)  # of beta^2 - (middle.v r)^2
    up = {1: branch * side if side else 1, -1: sign(field, middle.v)}.get(longer) or 1

    def parts(e) -> Parts:
        even, odd, _ = quadratic.value(e)
        (e0, e1), (o0, o1) = ((expression_of(field, part.u), expression_of(field, part.v) * r) for part in (even, odd))
        return e0 + o0 * alpha - o1 * beta, up * (e1 + o1 * alpha + o0 * beta)

    return _root(p, parts)


#: Digits of zeros that have no closed form, and of values of polynomials there.
DIGITS = 30


def _value_at(root: tuple[sympy.Expr, sympy.Expr], e: sympy.Poly) -> Parts:
    """Real and imaginary part of e(root), rounded to ``DIGITS`` digits."""
    real, imaginary = root
    above, below = sympy.S.Zero, sympy.S.Zero
    for c in e.all_coeffs():
        number = sympy.N(c, 2 * DIGITS)
        above, below = above * real - below * imaginary + number, above * imaginary + below * real
    return _rounded(above), _rounded(below)


def _rounded(number: sympy.Expr) -> sympy.Expr:
    """A number rounded to ``DIGITS`` digits; zero stays exact."""
    return sympy.N(number, DIGITS) if number != 0 else sympy.S.Zero


#: The order of preference of square roots: a real one, one that is imaginary for certain, one that depends on the symbols.
ORDER = {1: 0, -1: 1, None: 2}


def quadratic_factors(q: sympy.Poly) -> tuple[Surd, Surd] | None:
    """(a, b) with the quartic q = (s^2 + a s + b) times its conjugate (Ferrari), real where it can be; None where there is none."""
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


class Quadratic:
    """s^2 + a s + b over K(sqrt(g)), and values of polynomials at its zeros x = middle + y, y^2 = -square = a^2/4 - b: linear in y."""

    def __init__(self, a: Surd, b: Surd):
        one = a.field.one
        self.b, self.middle = b, a * a.of(-one / (one + one))
        self.square = b - self.middle * self.middle
        self._powers = [(a.of(one), a.of(a.field.zero), a.of(a.field.zero))]
        self._values: dict[sympy.Poly, tuple[Surd, Surd, Surd]] = {}

    @cached_property
    def conjugate(self) -> Quadratic:
        """The conjugate with -sqrt(g) for sqrt(g); both share the known values."""
        other = Quadratic(-(self.middle + self.middle).conjugate, self.b.conjugate)
        other.value = lambda c: tuple(part.conjugate for part in self.value(c))
        return other

    def value(self, c: sympy.Poly) -> tuple[Surd, Surd, Surd]:
        """e, o and o square with c(x) = e + o y, by the powers of x, each computed once; c is linear in them."""
        if c not in self._values:
            field, factors = self.middle.field, coefficients(c, max(1, len(c.rep.to_list())))
            while len(self._powers) < len(factors):
                even, odd, turned = self._powers[-1]
                following = even + odd * self.middle
                self._powers.append((even * self.middle - turned, following, following * self.square))
            self._values[c] = tuple(
                Surd(field, *(combination(field, factors, [getattr(part, name) for part in parts]) for name in "uv"), self.middle.g)
                for parts in zip(*self._powers[: len(factors)])
            )
        return self._values[c]


def combination(field: Domain, ones: Sequence, others: Sequence):
    """The sum of the products of elements; fractions are brought over one denominator and cancelled once, at the end."""
    pairs = [(one, other) for one, other in zip(ones, others, strict=True) if one and other]
    if not field.is_FractionField:
        return sum((one * other for one, other in pairs), field.zero)
    ring = field.get_ring()
    first, second = (reduce(ring.lcm, {pair[which].denom for pair in pairs}, ring.one) for which in (0, 1))
    above = ((one.numer * first.exquo(one.denom)) * (other.numer * second.exquo(other.denom)) for one, other in pairs)
    return field.field.new(sum(above, ring.zero), first * second)
