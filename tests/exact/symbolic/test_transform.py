"""Forces as sums of terms: their values, and their transforms."""

from __future__ import annotations

import mpmath
import pytest
import sympy

import mbconstrained as mb
from mbconstrained.exact.symbolic.symbolic_response import terms_of, transform_of

t, s = sympy.symbols("t s")
F, w, p, a, k, m, t0 = sympy.symbols("F w p a k m t0", positive=True)
DIGITS = 40

SMOOTH = [
    sympy.S(3),
    F,
    t**3,
    F * t * sympy.exp(-2 * t) * sympy.cos(3 * t + p),
    (t + 1) ** 2 * (sympy.sin(w * t) - 2),
    sympy.cos(2 * t) ** 3,
    sympy.sin(w * t) * sympy.cos(a * t + p) * sympy.exp(-a * t),
    sympy.cosh(a * t) * sympy.sin(t),
    sympy.exp(-t + p) * sympy.exp(3 * t),
    2 ** (-t),
    sympy.sin(sympy.sqrt(k / m) * t),
    t * sympy.exp(-sympy.sqrt(k / m) * t + 2 * t),
    sympy.cos(p - 2 * t),
    sympy.cos(w * t + p) * sympy.cos(p - w * t),
]
VALUES = {F: 2, w: 3, p: sympy.Rational(1, 3), a: sympy.Rational(5, 4), k: 2, m: 5, t0: sympy.Rational(3, 2)}


def value_of(terms, time):
    """The sum of terms that start at 0 or earlier, at a time."""
    total = sympy.S.Zero
    for term in terms:
        wave = sympy.cos(term.frequency * time + term.phase)
        total += term.coefficient * time**term.power * sympy.exp(term.rate * time) * wave if time > term.start.subs(VALUES) else 0
    return sympy.N(total.subs(VALUES), DIGITS)


@pytest.mark.parametrize("expression", SMOOTH, ids=str)
def test_the_terms_add_up_to_the_expression(expression):
    for time in (sympy.Rational(1, 3), sympy.Rational(7, 5)):
        assert abs(value_of(terms_of(expression, t), time) - sympy.N(expression.subs(t, time).subs(VALUES), DIGITS)) < 1e-30


@pytest.mark.parametrize("expression", SMOOTH, ids=str)
def test_the_transforms_add_up_to_the_integral(expression):
    """Against quadrature of e^{-st} f(t)."""
    point = sympy.Integer(7)
    found = sum(
        amplitude * numerator / denominator**power
        for parts, denominator, power in (transform_of(term, s) for term in terms_of(expression, t))
        for amplitude, numerator in parts
    )
    with mpmath.workdps(DIGITS):
        integrand = sympy.lambdify(t, (expression.subs(VALUES) * sympy.exp(-point * t)), "mpmath")
        known = mpmath.quad(integrand, [0, 1, 2, 4, 8, 16, 32])
        assert abs(mpmath.mpmathify(sympy.N(sympy.S(found).subs(s, point).subs(VALUES), DIGITS)) - known) < 1e-25


@pytest.mark.parametrize(
    "expression",
    [
        sympy.Heaviside(t - t0) * t**2 * sympy.cos(w * t),
        sympy.Heaviside(t - t0) * sympy.Heaviside(t - 2 * t0) * sympy.exp(-t),
        (sympy.Heaviside(t) - sympy.Heaviside(t - 1)) * t,
        sympy.Heaviside(2 - t) * sympy.sin(t),
        sympy.Heaviside(t + 1) * t,
        sympy.Heaviside(-t - 1) + sympy.Heaviside(2 * t - 3),
    ],
    ids=str,
)
def test_what_starts_later_is_moved_to_its_start(expression):
    for time in (sympy.Rational(1, 3), sympy.Rational(7, 5), sympy.Rational(17, 5)):
        found = sum(
            value_of([moved.__class__(**{**vars(moved), "start": sympy.S.Zero})], time - term.start.subs(VALUES))
            for term in terms_of(expression, t)
            for moved in term.from_its_start()
            if time > term.start.subs(VALUES)
        )
        assert abs(found - sympy.N(expression.subs(t, time).subs(VALUES), DIGITS)) < 1e-30


def test_impulses():
    (one,) = terms_of(F * sympy.DiracDelta(t), t)
    assert (one.coefficient, one.impulse, one.start) == (F, 0, 0)
    (later,) = terms_of(sympy.DiracDelta(3 - 2 * t, 1), t)
    assert (later.coefficient, later.impulse, later.start) == (sympy.Rational(-1, 4), 1, sympy.Rational(3, 2))
    assert terms_of(sympy.DiracDelta(t + 1), t) == []
    assert transform_of(one, s)[0] == [(F, 1)]


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (sympy.tan(t), r"found tan\(t\); expected sums and products of constants, t, exp"),
        (sympy.Function("g")(t), r"found g\(t\)"),
        (1 / t, "found 1/t"),
        (sympy.sqrt(t), r"found sqrt\(t\)"),
        (sympy.exp(-(t**2)), r"found exp\(-t\*\*2\); expected its argument to be a t \+ b"),
        (sympy.exp(sympy.I * t), "with real a and b"),
        (t * sympy.DiracDelta(t), "DiracDelta times a function of time"),
        (sympy.Heaviside(t - a + w), "expected its argument to be t - t0 with t0 >= 0"),
        (sympy.Heaviside(t - a) * sympy.Heaviside(t - w), "known which one is later"),
        (sympy.Abs(sympy.sin(t)), "found Abs"),
    ],
    ids=str,
)
def test_other_functions_are_refused(expression, text):
    with pytest.raises(mb.InputError, match=text):
        terms_of(expression, t)


def test_a_rate_with_a_root_beside_a_frequency_is_refused():
    (term,) = terms_of(sympy.exp(-sympy.sqrt(k) * t) * sympy.cos(w * t), t)
    with pytest.raises(mb.InputError, match="expected one without square roots"):
        transform_of(term, s)
