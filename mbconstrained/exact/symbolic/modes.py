"""The roots of an irreducible polynomial as real functions of time: e^{a t} cos(w t) and e^{a t} sin(w t), in radicals where they can be.

A pair of roots a +- i w with w^2 > 0 oscillates, one with w^2 < 0 is a pair of real exponents. Where the sign of w^2 depends on
the values of the symbols, as that of 4 k m - c^2 does, the oscillating form is given: cos(w t) and w sin(w t) are even in w, so that it
holds for w^2 < 0 as well, with the root of a negative number, and for w^2 = 0 as a limit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy
from sympy.polys.domains import Domain

from ...errors import InputError
from .compact import compact_expression, compact_root, factored
from .quadratic_factors import quadratic_factors, reduced
from .surds import Surd

#: Of roots that have no closed form.
DIGITS = 30


@dataclass(frozen=True)
class Mode:
    """One real root, or a pair of roots rate +- i frequency.

    Attributes:
        rate, frequency: in 1/s and rad/s; frequency 0 for a real root.
        weights: of a polynomial c(x) over the field: the factors of cos(frequency t) and of sin(frequency t) in the
            sum of c(x) e^{x t} over the roots, without e^{rate t}.
    """

    rate: sympy.Expr
    frequency: sympy.Expr
    weights: Callable[[sympy.Poly], tuple[sympy.Expr, sympy.Expr]]


def modes(q: sympy.Poly) -> list[Mode]:
    """The roots of an irreducible polynomial over a field, symbols taken as positive.

    Degree 1 and 2, and quartics that are products of two quadratics over the field and one square root: s^4 + b s^2 + c, and
    with damping in proportion to mass and stiffness. Others with ``DIGITS`` digits where there are no symbols.

    Raises:
        InputError: no closed form, and symbols.
    """
    q, field = q.monic(), q.domain
    if q.degree() == 1:
        return [_real(field, -q.rep.to_list()[1])]
    if q.degree() == 2:
        a, b = q.rep.to_list()[1:]
        return _of_quadratic(*(Surd(field, part, field.zero, field.one) for part in (a, b)))
    split = quadratic_factors(q) if q.degree() == 4 else None
    if split is not None:
        return [
            mode for parts in (split, [Surd(field, part.u, -part.v, part.g) for part in split]) for mode in _of_quadratic(*parts)
        ]
    if field.is_FractionField:
        raise InputError(
            f"the factor {q.as_expr()} of the determinant has no roots in closed form; give some of its symbols "
            f"({', '.join(map(str, field.symbols))}) as numbers or as multiples of each other, or use numbers throughout (mb.solve)"
        )
    return [_numerical(root) for root in _numerical_roots(q)]


def _real(field: Domain, root) -> Mode:
    def weights(c):
        value = field.zero
        for factor in c.rep.to_list():
            value = value * root + factor
        return factored(field, value), sympy.S.Zero

    return Mode(factored(field, root), sympy.S.Zero, weights)


def _of_quadratic(a: Surd, b: Surd) -> list[Mode]:
    """The roots of s^2 + a s + b."""
    one = a.field.one
    middle = a * a.of(-one / (one + one))
    square = b - middle * middle
    if square.sign() == -1:
        distance = compact_root(-square)
        return [_real_of_pair(a, b, middle, end * distance) for end in (-1, 1)]
    frequency = compact_root(square)

    def weights(c):
        even, odd = reduced(c, a, b)
        cosine, sine = even + odd * middle, -odd * square  # odd often has w^2 in its denominator
        return compact_expression(cosine + cosine), _tidy(compact_expression(sine + sine) / frequency)

    return [Mode(compact_expression(middle), frequency, weights)]


def _tidy(product: sympy.Expr) -> sympy.Expr:
    """Without roots in the denominator of the number in front, where there are symbols."""
    number, rest = product.as_independent(*product.free_symbols, as_Add=False)
    return sympy.expand(sympy.radsimp(number)) * rest if product.free_symbols else product


def _real_of_pair(a: Surd, b: Surd, middle: Surd, distance: sympy.Expr) -> Mode:
    def weights(c):
        even, odd = reduced(c, a, b)
        return compact_expression(even + odd * middle) + compact_expression(odd) * distance, sympy.S.Zero

    return Mode(compact_expression(middle) + distance, sympy.S.Zero, weights)


def _numerical_roots(q: sympy.Poly) -> list[tuple[sympy.Expr, sympy.Expr]]:
    """Real and imaginary parts, of each complex pair of the root above the real axis."""
    if not q.domain.is_QQ:
        q = sympy.Poly([c.evalf(3 * DIGITS) for c in q.all_coeffs()], q.gen)
    roots = [root.as_real_imag() for root in q.nroots(n=DIGITS, maxsteps=500)]
    return [(real, imaginary) for real, imaginary in roots if imaginary >= 0]


def _numerical(root) -> Mode:
    real, imaginary = root

    def weights(c):
        above, beside = sympy.S.Zero, sympy.S.Zero
        for factor in c.all_coeffs():
            above, beside = above * real - beside * imaginary + factor, above * imaginary + beside * real
        return (sympy.expand(above), sympy.S.Zero) if imaginary == 0 else (sympy.expand(2 * above), sympy.expand(-2 * beside))

    return Mode(real, imaginary, weights)
