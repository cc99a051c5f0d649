"""Inverse transforms with symbols in the coefficients: right for every sign of what positivity leaves open."""

import mpmath
import pytest
import sympy

import mbconstrained as mb
from mbconstrained.exact.symbolic.symbolic_response import time_expression

t, s = sympy.Symbol("t", real=True), sympy.Symbol("s")
m, k, c, w, k1, k2, m1, m2, alpha, beta = sympy.symbols("m k c w k1 k2 m1 m2 alpha beta", positive=True)
DIGITS = 60


def ascending(p):
    return sympy.Poly(p, s).all_coeffs()[::-1]


def inverted(numerator, denominator, values, time):
    """By mpmath from the transform alone."""
    with mpmath.workdps(DIGITS):
        above, below = ([mpmath.mpmathify(sympy.N(sympy.S(e).subs(values), DIGITS)) for e in p] for p in (numerator, denominator))
        return mpmath.invertlaplace(
            lambda p: mpmath.polyval(above[::-1], p) / mpmath.polyval(below[::-1], p), time, method="talbot"
        )


def agrees(form, numerator, denominator, values, times=(0.3, 1.7)):
    for time in times:
        found = complex(sympy.N(form.subs(values).subs(t, sympy.Rational(str(time))), 40))
        assert found == pytest.approx(
            complex(inverted(numerator, denominator, values, mpmath.mpf(str(time)))), rel=1e-14, abs=1e-14
        )


CHAIN = sympy.Matrix([[m1 * s**2 + k1 + k2, -k2], [-k2, m2 * s**2 + k2]])
RAYLEIGH = sympy.Matrix([[m * s**2 + 2 * k, -k], [-k, m * s**2 + k]]) + s * (
    alpha * m * sympy.eye(2) + beta * k * sympy.Matrix([[2, -1], [-1, 1]])
)
GYROSCOPE = sympy.Matrix([[m * s**2 + k, -c * s], [c * s, m * s**2 + k]])


@pytest.mark.parametrize("damping", [1, 2, 4, 7, 40], ids=lambda value: f"c={value}")
@pytest.mark.parametrize("numerator", [[1], [2, 3]])
def test_a_damped_oscillator_under_and_over_the_critical_damping(damping, numerator):
    """4 k m = 16 * 3: c = 7 and 40 are overdamped, where the root is imaginary."""
    agrees(time_expression(numerator, [k, c, m], 0, t), numerator, [k, c, m], {m: 3, k: 4, c: damping})


def test_the_critical_damping_is_a_limit():
    form = time_expression([1, 2], [k, c, m], 0, t).subs({m: 1, k: 4})
    assert form.subs(c, 4).has(sympy.nan, sympy.zoo)
    critical = sympy.limit(form, c, 4)
    assert sympy.simplify(critical - time_expression([1, 2], [4, 4, 1], 0, t)) == 0


@pytest.mark.parametrize(
    ("denominator", "values"),
    [
        (ascending(CHAIN.det()), {k1: 2, k2: 3, m1: 5, m2: 7}),
        (ascending(RAYLEIGH.det()), {k: 2, m: 3, alpha: sympy.Rational(1, 5), beta: sympy.Rational(1, 7)}),
        (ascending(RAYLEIGH.det()), {k: 2, m: 3, alpha: 3, beta: 2}),
        (ascending(GYROSCOPE.det()), {k: 2, m: 3, c: 5}),
        ([k, 0, 0, 0, 1], {k: 3}),
        ([k**2, 0, 2 * k, 0, 1], {k: 3}),
        ([-k, 0, m], {k: 3, m: 2}),
        ([k, -c, 0, 0, m1], {k: 1, c: 0, m1: 1}),
        ([k**3, 3 * k**2, 3 * k, 1], {k: 2}),
        ([sympy.sqrt(2), 3, sympy.sqrt(2)], {}),
        ([2, 0, 4, 0, 1], {}),
        ([-2, 0, 1, 0, 1], {}),
        ([2, 0, -4, 0, 1], {}),
        ([2, 0, 0, 0, 1], {}),
        ([1, 0, 0, 0, 1], {}),
    ],
)
def test_values_are_those_of_the_transform(denominator, values):
    numerator = [1, 2]
    denominator = [0 if sympy.S(e).has(c) and values.get(c) == 0 else e for e in denominator]
    agrees(time_expression(numerator, denominator, 1, t), numerator, [0, *denominator], values)


def test_two_equal_masses_have_frequencies_of_the_golden_ratio():
    form = time_expression([1], [k**2, 0, 3 * k * m, 0, m**2], 0, t)
    golden = (1 + sympy.sqrt(5)) / 2
    frequencies = {sympy.simplify(f.args[0] / t / sympy.sqrt(k / m)) for f in form.atoms(sympy.sin)}
    assert {sympy.nsimplify(f - golden) for f in frequencies} & {0} and {sympy.simplify(f - golden + 1) for f in frequencies} & {0}


def test_the_discriminant_is_positive_after_a_square_is_seen():
    """c^2 + (k - m)^2 > 0, although its coefficients have both signs."""
    form = time_expression([1], [-(k**2) + 2 * k * m - m**2 - c**2, 0, 1], 0, t)
    assert form.has(sympy.exp) and not form.has(sympy.sin)


def test_impulses_have_symbols_too():
    assert (
        time_expression([0, 0, 1], [k, m], 0, t) - k**2 / m**3 * sympy.exp(-k * t / m) * 1 + k * sympy.DiracDelta(t) / m**2
        == sympy.DiracDelta(t, 1) / m
    )


def test_a_common_factor_cancels():
    assert time_expression(ascending((m * s + k) * 3), ascending((m * s + k) * (s + c)), 0, t) == 3 * sympy.exp(-c * t)


@pytest.mark.parametrize(
    ("ask", "text"),
    [
        (lambda: time_expression([1], [k, c, m1, m2], 0, t), "no roots in closed form; give some of its symbols"),
        (lambda: time_expression([1], [sympy.sqrt(k), 1], 0, t), "expected a rational function of symbols"),
        (lambda: time_expression([1], [t, 1], 0, t), "t: the symbol t is also one of the coefficients'"),
        (lambda: time_expression([1], [sympy.Symbol("t"), 1], 0), "t: the symbol t is also one of the coefficients'"),
        (lambda: time_expression(["k"], [1], 0, t), "numerator: found 'k'"),
        (lambda: time_expression(1, [1], 0, t), "numerator: found 1; expected a list"),
        (lambda: time_expression([1], [0], 0, t), r"denominator: found a\(s\) = 0"),
        (lambda: time_expression([1], [], 0, t), r"denominator: found a\(s\) = 0"),
        (lambda: time_expression([1], [1, 1], 0.5, t), "gamma: found 0.5; expected a whole number"),
        (lambda: time_expression([1], [s, 1], 0, t), 'the symbol "s" is the variable'),
        (lambda: time_expression([1], [k + sympy.Symbol("k"), 1], 0, t), 'two symbols "k"'),
    ],
)
def test_what_cannot_be_done_is_said(ask, text):
    with pytest.raises(mb.InputError, match=text):
        ask()
