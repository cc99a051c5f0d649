"""Responses as expressions in t: exact where they can be, equal to the numbers everywhere, with their transforms."""

from fractions import Fraction

import numpy as np
import pytest
import sympy

import mbconstrained as mb
from mbconstrained.exact.symbolic.symbolic_response import time_expression

t, s = sympy.Symbol("t", real=True), sympy.Symbol("s")

SYSTEMS = [
    ([1], [1, 1]),
    ([2, 1], [1, 3, 3, 1]),
    ([1, 0, 3], [1, 2, 5]),
    ([1], [1, 2, 6, 5, 0, 0]),
    ([1, 2, 3, 4], [1, 0, 2, 0, 1]),  # (s^2 + 1)^2
    ([3, 1], [1, 2, -1, -2]),
    ([1, 0, 0, 0, 2], [1, 1]),
    ([1, 4], [1, -2, -1]),  # 1 +- sqrt(2)
    ([5], [2]),
    ([0], [1, 1]),
    ([1, -1], [1, 0, -1]),
    ([1, 2], [1, 1, 0, 1, 1, 3]),  # no closed form of its poles
    ([0.1, 0.3], [0.7, 0.2, 0.9]),
]


def without_impulses(expression):
    return expression.replace(sympy.DiracDelta, lambda *_: sympy.S.Zero)


@pytest.mark.parametrize("numerator, denominator", SYSTEMS)
@pytest.mark.parametrize("gamma", [-2, 0, 1, 3])
def test_an_expression_has_the_values_and_the_impulses_of_the_response(numerator, denominator, gamma):
    y = mb.transfer_function_response(numerator, denominator, gamma)
    expression = y.expression(t)
    regular = without_impulses(expression)
    for time in (0.5, 2.0, 6.0):
        assert y(time)[0] == pytest.approx(float(regular.subs(t, sympy.Rational(time)).evalf(30)), rel=1e-12, abs=1e-14)
    impulses = sympy.expand(expression - regular)
    deltas = [sympy.DiracDelta(t), *(sympy.DiracDelta(t, k) for k in range(1, 8))]
    found = [float(impulses.coeff(delta)) for delta in deltas]
    assert found == pytest.approx([c[0] for c in y.impulses] + [0.0] * (8 - len(y.impulses)), rel=1e-13, abs=1e-15)


def test_exact_forms():
    form = mb.transfer_function_response([1], [1, 2, 1]).expression(t)
    assert sympy.expand(form - (1 - sympy.exp(-t) - t * sympy.exp(-t))) == 0
    turning = mb.transfer_function_response([2], [1, 2, 2], 0).expression(t)
    assert turning == 2 * sympy.exp(-t) * sympy.sin(t)
    irrational = mb.transfer_function_response([1], [1, 0, -2], 0).expression(t)
    assert sympy.simplify(irrational - sympy.sinh(sympy.sqrt(2) * t) / sympy.sqrt(2)) == 0
    assert mb.transfer_function_response([1, 1], [1], -1).expression(t) == sympy.DiracDelta(t, 1) + sympy.DiracDelta(t, 2)
    assert mb.transfer_function_response([0], [1, 1]).expression(t) == 0


@pytest.mark.parametrize("gamma", [0, 1, 2])
def test_the_transform_of_an_expression_is_the_transfer_function(gamma):
    """Back by sympy: nothing of it is used to get there."""
    form = mb.transfer_function_response([1, 5], [1, 4, 6, 4], gamma).expression(t)
    positive = sympy.Symbol("t", positive=True)
    back = sympy.laplace_transform(form.subs(t, positive), positive, s, noconds=True)
    assert sympy.simplify(back - (s + 5) / (s**3 + 4 * s**2 + 6 * s + 4) / s**gamma) == 0


def test_floats_are_taken_as_they_are_written():
    form = mb.transfer_function_response([0.1], [1, 0.2]).expression(t)
    assert sympy.expand(form - (1 - sympy.exp(-t / 5)) / 2) == 0
    exact = mb.transfer_function_response([Fraction(1, 3)], [1, Fraction(1, 3)]).expression(t)
    assert sympy.expand(exact - (1 - sympy.exp(-t / 3))) == 0


def test_numerical_roots_have_thirty_digits():
    form = mb.transfer_function_response([1], [1, 1, 0, 1, 1, 3], 0).expression(t)
    assert all(number._prec >= 100 for number in form.atoms(sympy.Float))


def test_a_common_factor_is_not_in_it():
    form = mb.transfer_function_response([1, -3], [1, -2, -3], 0).expression(t)
    assert form == sympy.exp(-t)


def test_the_symbol():
    assert mb.transfer_function_response([1], [1, 1]).expression().free_symbols == {t}
    own = sympy.Symbol("tau")
    assert time_expression([Fraction(1)], [Fraction(1), Fraction(1)], 0, own) == sympy.exp(-own)
    with pytest.raises(mb.InputError, match="t: found 't'; expected a sympy.Symbol"):
        mb.transfer_function_response([1], [1, 1]).expression("t")


def test_a_long_sum_evaluates_to_the_response():
    """Order 8 of example (47): exact poles, rational coefficients."""
    from examples.simulators import example_47

    y = mb.transfer_function_response(*example_47(), 3)
    form = y.expression(t)
    assert not form.atoms(sympy.Float)
    assert float(form.subs(t, sympy.Rational(1, 100)).evalf(40)) == pytest.approx(y(0.01)[0], rel=1e-14)
    assert np.isfinite(y(0.01)[0]) and y(0.01)[0] > 0
