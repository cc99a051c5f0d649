"""Responses of transfer functions: published values, exact rational and multiprecision oracles, and the theorems."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from examples.simulators import example_47
from tests.oracles.transfer import descending, factors, impulses, multiplied, residues, taylor

REFERENCE = json.loads((Path(__file__).parents[1] / "oracles" / "hauksdottir.json").read_text())
NUMERATOR, DENOMINATOR = example_47()

small = st.fractions(min_value=-2, max_value=1, max_denominator=4)
poles = st.lists(small | st.tuples(small, st.fractions(min_value=Fraction(1, 4), max_value=3, max_denominator=4)), max_size=4)
numerators = st.lists(st.integers(-5, 5), min_size=1, max_size=6).filter(lambda b: b[-1] != 0)
orders = st.integers(-4, 4)
TIMES = (0.01, 0.3, 1.0, 4.0, 12.0)


def respond(numerator, denominator, gamma):
    """With coefficients in ascending powers."""
    return mb.transfer_function_response(numerator[::-1], denominator[::-1], gamma)


@pytest.mark.parametrize("name", REFERENCE)
def test_values_of_example_47(name):
    gamma, time = int(name[1]), float(name[3:-1])
    y = mb.transfer_function_response(NUMERATOR, DENOMINATOR, gamma)
    assert abs(Fraction(float(y(time)[0])) / Fraction(REFERENCE[name]) - 1) < Fraction(1, 10**13)


@pytest.mark.parametrize("name", [name for name in REFERENCE if name[1] != "0"])
def test_values_of_example_47_from_floats(name):
    numerator, denominator = ([float(c) for c in p] for p in (NUMERATOR, DENOMINATOR))
    y = mb.transfer_function_response(numerator, denominator, int(name[1]))
    assert y(float(name[3:-1]))[0] == pytest.approx(float(REFERENCE[name]), rel=1e-13)


@pytest.mark.parametrize("gamma", [-3, 0, 1, 2, 5])
def test_small_values_of_example_47_keep_all_digits(gamma):
    """y ~ t^(gamma + 3) at first; the sum of modes has an error of 2600 times I_3 at t = 0.01."""
    y = mb.transfer_function_response(NUMERATOR, DENOMINATOR, gamma)
    for order in range(3):
        function = y.derivative(order)
        for time in (1e-6, 1e-3, 0.01, 0.1, 0.5, 1.0, 2.0, 5.0):
            exact = taylor(NUMERATOR[::-1], DENOMINATOR[::-1], gamma, time, order)
            assert function(time)[0] == pytest.approx(exact, rel=1e-13)


@pytest.mark.parametrize("poles", [[Fraction(-1)] * 20, [(Fraction(-1, 2), Fraction(1))] * 6, [Fraction(-k) for k in range(1, 13)]])
def test_high_orders_are_small_for_long_and_right_all_along(poles):
    denominator = multiplied(*factors(poles))
    y = respond([1], denominator, 3)
    times = np.array([0.05, 0.5, 2.0, 5.0, 10.0, 30.0])
    exact = [residues([1], poles, 3, t, digits=120) for t in times]
    assert y(times)[0] == pytest.approx(exact, rel=1e-13)
    assert [y(t)[0] for t in times] == pytest.approx(y(times)[0], rel=1e-15)


@given(poles, numerators, orders)
def test_all_poles_numerators_and_inputs_against_residues(poles, b, gamma):
    """Repeated, complex, zero and unstable poles, common factors, m < n, m = n and m > n."""
    a = multiplied(*factors(poles))
    y = respond(b, a, gamma)
    exact = np.array([residues(b, poles, gamma, t) for t in TIMES])
    assert np.abs(y(TIMES)[0] - exact).max() <= 1e-12 * max(np.abs(exact).max(), abs(float(b[-1])) * 1e-6)
    assert [float(c[0]) for c in y.impulses] == pytest.approx([float(c) for c in impulses(b, a, gamma)], rel=1e-12, abs=1e-12)
    assert len(y.impulses) == len(impulses(b, a, gamma))


@pytest.mark.long
@given(poles, numerators, orders)
def test_the_derivative_of_a_response_is_the_response_to_the_derivative(poles, b, gamma):
    """Eq. (8) in the sense of distributions: the value at 0+ becomes an impulse."""
    a = multiplied(*factors(poles))
    y, integral = respond(b, a, gamma), respond(b, a, gamma + 1)
    size = np.abs(y(TIMES)).max() + np.abs(integral(TIMES)).max()
    assert np.abs(integral.derivative()(TIMES) - y(TIMES)).max() <= 1e-11 * size
    shifted = [integral(0.0)[0], *(c[0] for c in integral.impulses)]
    found = [c[0] for c in y.impulses] + [0.0] * (len(shifted) - len(y.impulses))
    assert found == pytest.approx(shifted, rel=1e-12, abs=1e-12 * max(map(abs, b)))


@given(poles, numerators, orders)
def test_the_value_at_zero_is_the_limit_of_s_times_the_transform(poles, b, gamma):
    a = multiplied(*factors(poles))
    limit = float(descending(b, a, gamma, 40).get(-1, 0))
    assert respond(b, a, gamma)(0.0)[0] == pytest.approx(limit, rel=1e-12, abs=1e-12 * max(map(abs, b)))


@given(poles, numerators, orders, poles)
def test_common_factors_leave_the_response(poles, b, gamma, common):
    a, factor = multiplied(*factors(poles)), multiplied(*factors(common))
    y, other = respond(b, a, gamma), respond(multiplied(b, factor), multiplied(a, factor), gamma)
    assert np.array_equal(y(TIMES), other(TIMES))
    assert len(other.common_factor) >= len(factor)


def test_an_unstable_common_factor_leaves_the_response_at_all_times():
    y = mb.transfer_function_response([1, -3], [1, -2, -3])  # (s - 3) / ((s - 3)(s + 1))
    assert y([10.0, 1e6]).tolist() == [[pytest.approx(1 - np.exp(-10), rel=1e-15), 1.0]]


@pytest.mark.parametrize("order", [1, 2, 5])
@pytest.mark.parametrize("gamma", [-6, -1, 0, 1, 3])
def test_zero_poles_shift_the_input(order, gamma):
    """Eq. (34): y_gamma of s^n0 a(s) is y_(gamma + n0) of a(s)."""
    y = mb.transfer_function_response([3, 1, 2], [1, 2, 2, 1] + [0] * order, gamma)
    other = mb.transfer_function_response([3, 1, 2], [1, 2, 2, 1], gamma + order)
    assert y(TIMES)[0] == pytest.approx(other(TIMES)[0], rel=1e-13)
    assert np.array(y.impulses).ravel() == pytest.approx(np.array(other.impulses).ravel(), rel=1e-13)
    assert y.residue_form.zero_poles == order


@pytest.mark.parametrize(
    "b, a, gamma", [([1, 3], [1, 3, 2, 0, 0], -2), ([1, 3], [1, 3, 2, 0, 0], -5), ([1, 0, 0], [1, 3, 3, 1], 2)]
)
def test_what_cancels_at_zero_leaves_nothing_behind(b, a, gamma):
    """The input's zeros and the poles at s = 0, or the other way round: y decays like e^-t, to 1e-17 at t = 40 and on."""
    y = mb.transfer_function_response(b, a, gamma)
    places = [Fraction(-1), Fraction(-2), Fraction(0), Fraction(0)] if len(a) == 5 else [Fraction(-1)] * 3
    for time in (5.0, 40.0, 200.0):
        assert y(time)[0] == pytest.approx(residues(b[::-1], places, gamma, time, digits=300), rel=1e-12, abs=0)


@pytest.mark.parametrize("exponent", [-30, -15, 0, 15, 30])
@pytest.mark.parametrize("gamma", [-3, 0, 1, 3])
def test_the_unit_of_time_does_not_matter(exponent, gamma):
    """The response of b(T s) / a(T s) at t is T^(gamma - 1) times that of b(s) / a(s) at t / T."""
    T = Fraction(10) ** exponent
    b, a = [Fraction(2), Fraction(3)], [Fraction(1), Fraction(3), Fraction(3), Fraction(1)]
    y = mb.transfer_function_response(b, a, gamma)
    slow = mb.transfer_function_response(*([c * T ** (len(p) - 1 - k) for k, c in enumerate(p)] for p in (b, a)), gamma)
    for time in (1e-3, 1.0, 7.0):
        assert slow(time * float(T))[0] == pytest.approx(float(T) ** (gamma - 1) * y(time)[0], rel=1e-12)
    assert len(slow.impulses) == len(y.impulses)


@pytest.mark.parametrize("gamma", range(-3, 4))
def test_a_constant_denominator_and_integrators(gamma):
    """Eq. (35): y is the sum of b_i I_(g - i)."""
    for order in (0, 2):
        y = mb.transfer_function_response([3, 0, 5], [2] + [0] * order, gamma)
        g = gamma + order
        expected = 2.5 * mb.power([1.0], g) + 1.5 * mb.power([1.0], g - 2)
        assert y(TIMES)[0] == pytest.approx(expected(TIMES)[0], rel=1e-14)
        assert np.array(y.impulses).ravel() == pytest.approx(np.array(expected.impulses).ravel(), rel=1e-14)


def test_sums_of_inputs():
    """Eqs. (9), (10), an input that starts later, and one that is no power."""
    b, a = [1, 2], [1, 2, 5]
    u = 2.0 * mb.power([1.0], 2) - mb.power([1.0], 0)
    y = mb.transfer_function_response(b, a, u)
    ramp, impulse = (mb.transfer_function_response(b, a, gamma) for gamma in (2, 0))
    assert y(TIMES) == pytest.approx(2 * ramp(TIMES) - impulse(TIMES), rel=1e-12)
    late = mb.transfer_function_response(b, a, u.delayed(2.0))
    assert late([1.0, 3.0, 6.0])[0] == pytest.approx([0.0, *y([1.0, 4.0])[0]], rel=1e-12)
    turning = mb.transfer_function_response([1, 0], [1, 1], mb.harmonic([1.0], angular_frequency=1.0))
    t = np.array([0.1, 1.0, 5.0])  # s^2 / ((s + 1)(s^2 + 1))
    assert turning(t)[0] == pytest.approx((np.exp(-t) + np.cos(t) - np.sin(t)) / 2, rel=1e-13)


def test_the_same_system_with_another_input_and_its_basic_responses():
    """Eq. (32): y is the sum of b_l y_b,(gamma - l), a_n taken out."""
    y = mb.transfer_function_response([4, 2, 6], [2, 4, 10], 2)
    assert y.with_input(1)(TIMES) == pytest.approx(y.derivative()(TIMES), rel=1e-12)
    total = sum(b / 2 * basic(TIMES) for b, basic in zip((6, 2, 4), y.basic_responses))
    assert y(TIMES) == pytest.approx(total, rel=1e-12)
    assert [basic.gamma for basic in y.basic_responses] == [2, 1, 0]


def test_the_fundamental_solution_starts_from_its_last_derivative():
    """Eqs. (12), (13), (43): zeros, then one; poles at s = 0 belong to the input."""
    y = mb.transfer_function_response([1], [3, 9, 15, 9, 0, 0])
    f = y.fundamental_solution
    assert [f.derivative(k)(0.0)[0] for k in range(3)] == pytest.approx([0.0, 0.0, 1.0])
    impulse = mb.transfer_function_response([1], [1, 3, 5, 3], 0)
    assert f(TIMES)[0] == pytest.approx(impulse(TIMES)[0], rel=1e-12)
    with pytest.raises(mb.InputError, match="no poles but s = 0"):
        _ = mb.transfer_function_response([1], [2, 0]).fundamental_solution


def test_objects_of_the_paper_need_a_whole_gamma():
    y = mb.transfer_function_response([1], [1, 1], mb.ramp([1.0]))
    for ask in (lambda: y.basic_responses, lambda: y.expression()):
        with pytest.raises(mb.InputError, match="inputs I_gamma"):
            ask()


@pytest.mark.parametrize("gamma", [0, 1, 3])
def test_the_estimate_bounds_the_error_also_where_the_response_is_small(gamma):
    """And does not cry wolf there: the answer comes from exact series."""
    numerator, denominator = ([float(c) for c in p] for p in (NUMERATOR, DENOMINATOR))
    y = mb.transfer_function_response(numerator, denominator, gamma)
    exact = [Fraction(c) for c in numerator[::-1]], [Fraction(c) for c in denominator[::-1]]
    for time in (0.01, 1.0, 4.0):
        error = abs(y(time)[0] / taylor(*exact, gamma, time) - 1)
        assert error <= y.error_estimate(time) < 1e-12


@pytest.mark.parametrize("times", [-1.0, np.nan, [[1.0]]])
def test_times_that_are_none(times):
    with pytest.raises(mb.InputError, match="time"):
        mb.transfer_function_response([1], [1, 1])(times)


def test_a_high_order_with_a_numerator_as_high():
    """Order 31: the impulses of b(d/dt) u are taken as values at 0+, known exactly."""
    poles = [(Fraction(-1, 8) * (k + 1), Fraction(k, 4)) if k else Fraction(-1) for k in range(16)]
    a = multiplied(*factors(poles))
    b = [Fraction((-1) ** k * (k + 1)) for k in range(len(a))]
    y = respond(b, a, 1)
    for time in (0.1, 1.0):
        assert y(time)[0] == pytest.approx(residues(b, poles, 1, time, digits=120), rel=1e-12)
    assert y(0.0)[0] == float(b[-1])


def test_values_at_zero_beyond_the_range_are_refused():
    with pytest.raises(mb.Overflow, match="beyond the range"):
        mb.transfer_function_response([1.0], [1.0, 1e60], -6)


CASES = [  # poles, zeros at 0, gamma, t
    ([Fraction(-(10**7)), Fraction(1, 2)], 2, 0, 40.0),
    ([Fraction(-1000), Fraction(-1, 4)], 3, -2, 5.0),
    ([Fraction(-(10**4)), Fraction(1, 2)], 3, -1, 20.0),
    ([Fraction(-(10**4)), Fraction(-1, 4)], 3, -2, 10.0),
    ([Fraction(-(10**6)), Fraction(-1)], 0, -5, 1.0),
    ([Fraction(-(10**5)), Fraction(-1)], 0, -6, 1.0),
    ([Fraction(-(10**8)), Fraction(-1, 2**30)], 1, 0, 1000.0),
]


@pytest.mark.parametrize("poles, zeros, gamma, time", CASES)
def test_what_is_left_of_slow_modes_has_all_digits(poles, zeros, gamma, time):
    a = multiplied(*factors(poles))
    y = mb.transfer_function_response([1, *[0] * zeros], a[::-1], gamma)
    known = residues([Fraction(0)] * zeros + [Fraction(1)], poles, gamma, time, digits=120)
    assert y(time)[0] == pytest.approx(known, rel=1e-12)
    assert y.error_estimate([time]) < 1e-9
