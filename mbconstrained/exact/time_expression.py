"""The inverse Laplace transform of b(s) / (a(s) s^gamma) as an expression in t.

a(s) s^gamma is factored over the rationals. At a root x of an irreducible factor q, of multiplicity k, the coefficients of
the principal part are the same polynomials in x for all roots of q, with rational coefficients: they are found in the field
Q[x]/q exactly, and only then a root is put in, exact where q is linear or quadratic, with ``DIGITS`` digits otherwise.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import sympy

from ..errors import InputError

#: Of roots that have no closed form.
DIGITS = 30

X = sympy.Symbol("x")


def time_expression(
    numerator: Sequence[Fraction], denominator: Sequence[Fraction], gamma: int, t: sympy.Symbol | None = None
) -> sympy.Expr:
    """y(t), t >= 0, whose transform is b(s) / (a(s) s^gamma), its polynomial part as derivatives of Dirac's delta.

    Args:
        numerator, denominator: b and a, exact, lowest power first.
        gamma: any whole number.
        t: the symbol; None for a real one called t.

    Raises:
        InputError: t is not a symbol.

    >>> time_expression([Fraction(2)], [Fraction(2), Fraction(2), Fraction(1)], 0)
    2*exp(-t)*sin(t)
    """
    t = sympy.Symbol("t", real=True) if t is None else t
    if not isinstance(t, sympy.Symbol):
        raise InputError(f"t: found {t!r}; expected a sympy.Symbol, e.g. sympy.Symbol('t', real=True)")
    b, a = (_polynomial(p) for p in (numerator, denominator))
    power = sympy.Poly(X ** abs(gamma), X, domain="QQ")
    b, a = (b, a * power) if gamma > 0 else (b * power, a)
    b, a = b.cancel(a, include=True) if not b.is_zero else (b, sympy.Poly(1, X, domain="QQ"))
    impulses, rest = b.div(a)
    total = [c * _delta(t, k) for k, c in enumerate(reversed(impulses.all_coeffs()))]
    for factor, multiplicity in a.factor_list()[1]:
        if not rest.is_zero:
            others = a.quo(factor**multiplicity)
            total += _terms(factor, _principal_part(rest, factor, multiplicity, others), t)
    return sympy.Add(*total)


def _polynomial(coefficients) -> sympy.Poly:
    rationals = [sympy.Rational(c.numerator, c.denominator) for c in reversed(coefficients)]
    return sympy.Poly(rationals or [0], X, domain="QQ")


def _delta(t, order) -> sympy.Expr:
    return sympy.DiracDelta(t, order) if order else sympy.DiracDelta(t)


def _principal_part(b, q, k, others) -> list[sympy.Poly]:
    """c_1 ... c_k of b / (q^k others) = sum of c_j / (s - x)^j + ... at a root x of q, polynomials in x modulo q."""
    slopes = _taylor(q, q, k + 1)[1:]  # q(x + h) = h (q'(x) + q''(x) h / 2 + ...)
    below = _taylor(others, q, k)
    for _ in range(k):
        below = _times(below, slopes, q)
    inverse, above = below[0].invert(q), _taylor(b, q, k)
    found: list[sympy.Poly] = []
    for j in range(k):
        known = sum((below[i] * found[j - i] for i in range(1, j + 1)), 0 * q)
        found.append(((above[j] - known) * inverse).rem(q))
    return found[::-1]


def _taylor(p, q, count) -> list[sympy.Poly]:
    """The coefficients of 1, h, h^2, ... of p(x + h) modulo q."""
    found = []
    for j in range(count):
        found.append((p * sympy.Rational(1, sympy.factorial(j))).rem(q))
        p = p.diff()
    return found


def _times(one, two, q) -> list[sympy.Poly]:
    return [sum((one[i] * two[j - i] for i in range(j + 1)), 0 * q).rem(q) for j in range(len(one))]


def _terms(q, coefficients, t) -> list[sympy.Expr]:
    """The sum over the roots x of q of c_j(x) t^(j-1)/(j-1)! e^(x t), pairs of complex roots together."""
    found = []
    for real, imaginary in _roots(q):
        for j, c in enumerate(coefficients):
            power = t**j / sympy.factorial(j)
            if imaginary == 0:
                found.append(_at(c, real, 0)[0] * power * sympy.exp(real * t))
            else:
                cosine, sine = _at(c, real, imaginary)
                turning = 2 * cosine * sympy.cos(imaginary * t) - 2 * sine * sympy.sin(imaginary * t)
                found.append(turning * power * sympy.exp(real * t))
    return found


def _roots(q) -> list[tuple[sympy.Expr, sympy.Expr]]:
    """Real and imaginary parts of the roots, of each complex pair the one above the real axis."""
    if q.degree() == 1:
        first, zeroth = q.all_coeffs()
        return [(-zeroth / first, sympy.S.Zero)]
    if q.degree() == 2:
        a, b, c = q.all_coeffs()
        middle, square = -b / (2 * a), (b**2 - 4 * a * c) / (4 * a**2)
        if square < 0:
            return [(middle, sympy.sqrt(-square))]
        return [(middle - sympy.sqrt(square), sympy.S.Zero), (middle + sympy.sqrt(square), sympy.S.Zero)]
    roots = [root.as_real_imag() for root in q.nroots(n=DIGITS, maxsteps=500)]
    return [(real, imaginary) for real, imaginary in roots if imaginary >= 0]


def _at(c, real, imaginary) -> tuple[sympy.Expr, sympy.Expr]:
    """Real and imaginary part of c(x), by Horner's rule."""
    above, beside = sympy.S.Zero, sympy.S.Zero
    for factor in c.all_coeffs():
        above, beside = above * real - beside * imaginary + factor, above * imaginary + beside * real
    return sympy.expand(above), sympy.expand(beside)
