"""Bohl functions: evaluation, algebra and derivatives against their closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb

TIMES = np.array([0.0, 0.1, 1.0, 2.5])
NOTHING = mb.zero(2).smooth


def term(power=0, rate=0.0, frequency=0.0, phase=0.0) -> mb.BohlFunction:
    return mb.term([1.0, -2.0], power=power, rate=rate, angular_frequency=frequency, phase=phase).smooth


def known(power=0, rate=0.0, frequency=0.0, phase=0.0, times=TIMES):
    return np.outer([1.0, -2.0], times**power * np.exp(rate * times) * np.cos(frequency * times + phase))


parameters = st.fixed_dictionaries(
    {
        "power": st.integers(0, 4),
        "rate": st.sampled_from([-3.0, -0.5, 0.0, 0.25]),
        "frequency": st.sampled_from([0.0, 0.5, 7.0]),
        "phase": st.sampled_from([0.0, -np.pi / 2, 0.3]),
    }
)


@given(parameters)
def test_a_term_is_its_closed_form(p):
    assert np.allclose(term(**p)(TIMES), known(**p), rtol=1e-13, atol=1e-13)


@given(parameters)
def test_derivatives_agree_with_the_complex_step(p):
    """f'(t) = Re of the difference quotient along the complex axis, exact to rounding for analytic f."""
    step, times = 1e-20, TIMES[1:]
    moved = times + 1j * step
    value = moved ** p["power"] * np.exp(p["rate"] * moved) * np.cos(p["frequency"] * moved + p["phase"])
    assert np.allclose(term(**p).derivative()(times), np.outer([1.0, -2.0], value.imag / step), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("unit", [1e-12, 1e-7, 1e-4, 1e-2, 1.0, 1e3, 1e9])
@pytest.mark.parametrize("power", [0, 1, 2, 3, 6])
def test_a_term_is_the_same_in_any_unit_of_time(unit, power):
    """(w t)^k e^{-w t} cos w t of w t, from a slow tide to a fast resonator."""
    term = mb.term([unit**power], power=power, rate=-unit, angular_frequency=unit)
    u = np.array([0.0, 0.3, 1.0, 4.0])
    assert np.allclose(term(u / unit)[0], u**power * np.exp(-u) * np.cos(u), rtol=0, atol=1e-12 * 4.0**power)


def test_terms_with_a_common_tail_share_their_states():
    """step + ramp + t^2 needs three states, not six."""
    total = mb.step([1.0]) + mb.ramp([1.0]) + mb.term([1.0], power=2)
    assert total.smooth.generator.shape == (3, 3)
    assert total(2.0)[0] == pytest.approx(7.0, rel=1e-15)


def test_a_matrix_must_fit():
    with pytest.raises(mb.InputError, match="matrix: expected shape any x 2, found 1 x 3"):
        NOTHING.mapped([[1.0, 2.0, 3.0]])


@pytest.mark.parametrize("order", [-1, 1.5, True])
def test_derivatives_have_a_whole_order(order):
    with pytest.raises(mb.InputError, match="order: found .*; expected a whole number of at least 0"):
        term().derivative(order)


def test_functions_of_different_sizes_cannot_be_added():
    with pytest.raises(mb.InputError, match="functions of different sizes cannot be added: 2 and 1 rows"):
        NOTHING + mb.zero(1).smooth


def test_only_functions_can_be_added():
    with pytest.raises(TypeError):
        NOTHING + 1.0


@pytest.mark.parametrize(
    "times, text",
    [
        (-1e-9, "time: found -1e-09 s; the function is defined for t >= 0"),
        ([1.0, -2.0], "time: found -2 s"),
        (np.nan, "time: found nan; expected a finite number"),
        ([0.0, np.inf], "time: the entry at .* is inf"),
        ([[1.0]], r"time: expected a number or a list of numbers, found an array of shape \(1, 1\)"),
        ("soon", "time: found .*'soon'.*; expected numbers"),
        (1j, "time: complex numbers found"),
    ],
)
def test_times_are_checked(times, text):
    with pytest.raises(mb.InputError, match=text):
        term()(times)


def test_a_late_time_in_the_same_call_costs_an_early_one_no_accuracy():
    late = term(power=2, rate=-1.0, frequency=3.0)([0.01, 1.0, 1e9])[:, :2]
    assert np.allclose(late, known(2, -1.0, 3.0, times=np.array([0.01, 1.0])), rtol=1e-13, atol=0)


def test_growth_beyond_float64_is_an_overflow_in_words():
    growth = mb.term([1.0], rate=1.0).smooth
    assert growth(709.0)[0] == pytest.approx(np.exp(709.0), rel=1e-12)
    with pytest.raises(mb.Overflow, match="beyond the range of float64"):
        growth([1.0, 710.0, 720.0])


def test_a_small_amplitude_grows_until_the_value_itself_overflows():
    """1e-100 e^800 = 2.7e247, though e^800 alone is out of range."""
    assert np.log(mb.term([1e-100], rate=1.0)(800.0)[0]) == pytest.approx(800 - 100 * np.log(10), rel=1e-14)


def test_decay_ends_in_zero():
    assert mb.term([1.0], power=3, rate=-1.0)(1e4)[0] == 0.0
