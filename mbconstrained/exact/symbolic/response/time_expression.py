"""The inverse Laplace transform of b(s) / (a(s) s^gamma) as an expression in t.

a(s) s^gamma is factored over the field of its coefficients: the rational numbers, or the rational functions of symbols.
"""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Sequence
from fractions import Fraction

import sympy

from ....ground.errors import InputError
from ..field.fields import as_positive, check_one_each, checked_time, element, exact_expression, expression_of, field_of, symbols_of
from ..symbolic_matrix import S
from ..symbolic_ring import factors_of
from .inverse_transform import Quotient, regular_parts
from .transform import delta


def time_expression(
    numerator: Sequence[Fraction | sympy.Expr],
    denominator: Sequence[Fraction | sympy.Expr],
    gamma: int,
    t: sympy.Symbol | None = None,
) -> sympy.Expr:
    """y(t), t >= 0, whose transform is b(s) / (a(s) s^gamma), its polynomial part as derivatives of Dirac's delta.

    Symbols in the coefficients are positive and generic: the result holds where no two roots of different
    factors meet and no root of a factor is double, and everywhere else as a limit. Where the sign of w^2 in a factor
    (s + d)^2 + w^2 depends on the values of the symbols, the result is written with cos(w t) and sin(w t) and holds for
    w^2 < 0 as well; w^2 = 0 is a limit. Roots of degree 1 and 2 and quartics over one square root are in radicals.

    >>> time_expression([Fraction(2)], [Fraction(2), Fraction(2), Fraction(1)], 0)
    2*exp(-t)*sin(t)
    >>> k, m = sympy.symbols("k m", positive=True)
    >>> time_expression([Fraction(1)], [k, Fraction(0), m], 0)
    sin(sqrt(k)*t/sqrt(m))/(sqrt(k)*sqrt(m))
    """
    if isinstance(gamma, bool) or not isinstance(gamma, numbers.Integral):
        raise InputError(f"gamma: found {gamma!r}; expected a whole number")
    given = [_exact(numerator, "numerator"), _exact(denominator, "denominator")]
    symbols = symbols_of(given[0] + given[1])
    t = checked_time(t, symbols, "the coefficients'", "t")
    check_one_each([*symbols, t])
    names = as_positive(symbols)
    expression = _inverse(*_polynomials([[c.xreplace(names) for c in p] for p in given]), int(gamma), t)
    return expression.xreplace({positive: symbol for symbol, positive in names.items()})


def _inverse(b: sympy.Poly, a: sympy.Poly, gamma: int, t: sympy.Symbol) -> sympy.Expr:
    """The inverse transform of b(s) / (a(s) s^gamma)."""
    if a.is_zero:
        raise InputError("denominator: found a(s) = 0; expected a polynomial that is not zero")
    power = sympy.Poly(S ** abs(gamma), S, domain=a.domain)
    b, a = (b, a * power) if gamma > 0 else (b * power, a)
    factors, b = _cancelled(b, factors_of(a) if not b.is_zero else [], a.rep.to_list()[0])
    product = sympy.prod((q**k for q, k in factors), sympy.Poly(1, S, domain=a.domain))
    impulses, rest = b.div(product)
    coefficients = reversed(impulses.rep.to_list())
    total = [expression_of(a.domain, c) * delta(t, k) for k, c in enumerate(coefficients) if c]
    return sympy.Add(*total, *regular_parts(1, [Quotient({sympy.S.One: [rest]}, factors)], t))


def _exact(coefficients, what: str) -> list[sympy.Expr]:
    if isinstance(coefficients, str) or not isinstance(coefficients, Iterable):
        raise InputError(f"{what}: found {coefficients!r}; expected a list of coefficients, the lowest power first")
    return [exact_expression(c, what) for c in coefficients]


def _polynomials(given: list[list[sympy.Expr]]) -> list[sympy.Poly]:
    """b and a over the smallest field with their coefficients."""
    field = field_of(given[0] + given[1])
    elements = [[element(field, c, "coefficients") for c in reversed(p)] for p in given]
    return [sympy.Poly(p or [field.zero], S, domain=field) for p in elements]


def _cancelled(b, factors, leading):
    """The factors and b / leading without common factors."""
    left = []
    b = b * sympy.Poly([b.domain.one / leading], S, domain=b.domain)
    for q, k in factors:
        while k:
            quotient, rest = b.div(q)
            if not rest.is_zero:
                break
            b, k = quotient, k - 1
        left += [(q, k)] if k else []
    return left, b
