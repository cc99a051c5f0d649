"""Delayed inputs: values, derivatives, algebra, and how few states they need."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb

TIMES = np.array([0.0, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.25])
SIGNALS = {
    "step": (mb.step([1.0, -2.0]), lambda t: 1 + 0 * t),
    "ramp": (mb.ramp([1.0, -2.0]), lambda t: t),
    "cubic": (mb.term([1.0, -2.0], power=3), lambda t: t**3),
    "harmonic": (mb.harmonic([1.0, -2.0], angular_frequency=7.0, phase=0.3), lambda t: np.cos(7 * t + 0.3)),
    "term": (mb.term([1.0, -2.0], power=2, rate=-0.5, angular_frequency=2.0), lambda t: t**2 * np.exp(-t / 2) * np.cos(2 * t)),
}
names, delays = st.sampled_from(sorted(SIGNALS)), st.sampled_from([0.0, 0.25, 0.5, 1.0, 1.5])


def known(name, delay, times=TIMES):
    shape = np.where(times >= delay, SIGNALS[name][1](np.maximum(times - delay, 0)), 0.0)
    return np.outer([1.0, -2.0], shape)


@given(names, delays)
def test_a_delayed_input_is_zero_before_and_the_same_later(name, delay):
    assert np.allclose(SIGNALS[name][0].delayed(delay)(TIMES), known(name, delay), rtol=1e-13, atol=1e-13)


@given(names, delays, st.integers(0, 3))
def test_derivatives_are_delayed(name, delay, order):
    signal = SIGNALS[name][0]
    late, early = TIMES[TIMES >= delay], TIMES[TIMES < delay]
    derivative = signal.delayed(delay).derivative(order)
    assert np.allclose(derivative(late), signal.derivative(order)(late - delay), rtol=1e-13, atol=1e-13)
    assert not derivative(early).any()


def test_impulses_are_delayed_and_added_at_equal_times():
    load = mb.impulse([1.0, 0.0]) + mb.impulse([0.0, 2.0], order=1)
    total = load.delayed(1.0) + mb.impulse([3.0, 0.0]).delayed(1.0) + mb.impulse([5.0, 5.0]) - load.delayed(0.5)
    assert [g.tolist() for g in total.impulses] == [[5.0, 5.0]]
    assert [(b.time, [g.tolist() for g in b.impulses]) for b in total.later] == [
        (0.5, [[-1.0, 0.0], [0.0, -2.0]]),
        (1.0, [[4.0, 0.0], [0.0, 2.0]]),
    ]
    again = total.mapped([[1.0, 1.0]]).delayed(2.0)
    assert again.impulses == () and [b.time for b in again.later] == [2.0, 2.5, 3.0]
    assert again.later[2].impulses[0].tolist() == [4.0] and again.knots.tolist() == [0.0, 2.0, 2.5, 3.0]


@pytest.mark.parametrize("delay", [-1.0, np.nan, np.inf, "2", None, [1.0]])
def test_a_delay_is_a_time(delay):
    with pytest.raises(mb.InputError, match="delay: "):
        mb.step([1.0]).delayed(delay)


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        ({"start": -1.0, "duration": 1.0}, "start: found -1"),
        ({"duration": 0.0}, "duration: found 0"),
        ({"start": 1e20, "duration": 1.0}, "vanishes next to the start"),
        ({"start": 1e308, "duration": 1e308}, "^duration: 1e\\+308 s after the start at 1e\\+308 s is beyond the range"),
    ],
)
def test_a_pulse_lasts(keys, text):
    with pytest.raises(mb.InputError, match=text):
        mb.pulse([1.0], **keys)


def test_parts_with_one_vector_share_one_channel():
    pulses = sum(k * mb.pulse([0.1, 0.7], start=k, duration=0.5) for k in range(1, 30))
    assert [len(block) for block in pulses.smooth.blocks] == [1]
    record = mb.sampled([1.0, 2.0, 3.0], [[1.0, 2.0, 0.0]])
    assert [
        len(block) for block in (record + mb.sampled([0.0, 5.0], [[1.0, 1.0]]) + mb.pulse([2.0], duration=1.0)).smooth.blocks
    ] == [2]


def test_what_cancels_leaves_exactly_nothing():
    f = mb.step([3.0, 0.1]).delayed(1.0) + mb.ramp([1.0, 1.0]) - mb.step([3.0, 0.1]).delayed(1.0)
    assert not (f.smooth.coefficients @ f.smooth.restarts.jumps)[:, 1].any()
    assert (mb.pulse([1.0], duration=1.0) - mb.pulse([1.0], duration=1.0)).is_zero


@pytest.mark.parametrize(
    ("signal", "delay"),
    [
        (mb.pulse([1e20], duration=1e-20), 5.0),
        (mb.pulse([1.0], start=1.0, duration=1e-9), 1e13),
        (mb.sampled([0.0, 1e-12, 2e-12], [[0.0, 2e12, 0.0]]), 1e9),
        (mb.impulse([1.0]) - mb.impulse([1.0]).delayed(1e-20), 1.0),
    ],
)
def test_a_delay_never_swallows_what_acts_between_two_changes(signal, delay):
    with pytest.raises(mb.InputError, match="^delay: .* to one and the same float64 time, .*; give a shorter delay"):
        signal.delayed(delay)


@pytest.mark.parametrize("signal", [mb.step([1.0]), mb.impulse([1.0]), mb.sampled([0.0, 1e308], [[0.0, 1.0]])])
def test_a_delay_ends_within_the_range_of_float64(signal):
    with pytest.raises(mb.InputError, match="^delay: 1e\\+308 s after 1e\\+308 s is beyond the range"):
        signal.delayed(1e308).delayed(1e308)


def test_a_jump_of_a_record_is_delayed():
    record = mb.sampled([0.0, 1.0, 1.0, 2.0], [[1.0, 2.0, 5.0, 5.0]]).delayed(1e9)
    assert record.knots.tolist() == [0.0, 1e9, 1e9 + 1, 1e9 + 2]
    assert record([1e9, 1e9 + 0.5, 1e9 + 1]).tolist() == [[1.0, 1.5, 5.0]]


def test_inputs_are_shown_in_one_line():
    late = (mb.pulse([1.0, 2.0], duration=1.0) + mb.impulse([1.0, 0.0])).delayed(2.0)
    assert repr(late) == "ImpulsiveSmooth(2 rows, smooth part of 1 state, impulses at 1 time)"
    assert repr(late.smooth) == "BohlFunction(2 rows, 1 state)"
    assert repr(late.smooth.start) == "Restarts(1 state, set at 3 times)"
    assert repr(mb.approximated(lambda t: 0 * t, 1.0)).startswith("Approximation(1 row, ")


def test_a_sine_written_as_a_cosine_begins_at_zero():
    assert mb.harmonic([1.0], angular_frequency=2.0, phase=-np.pi / 2)(0.0)[0] == 0.0
    assert mb.harmonic([1.0], angular_frequency=2.0, phase=1e-20)(0.0)[0] == 1.0
    assert mb.harmonic([1.0], angular_frequency=2.0, phase=np.pi / 2 + 1e-12)(0.0)[0] == pytest.approx(-1e-12, rel=1e-3)


@given(st.floats(0.0, 1e6), st.floats(1e-9, 1.0))
def test_a_pulse_keeps_its_duration_at_late_times(start, duration):
    """The velocity of a free mass after it is the impulse: force times duration."""
    free = mb.PolynomialMatrix([[[0.0]], [[0.0]], [[2.0]]])
    velocity = mb.solve(free, force=mb.pulse([4.0], start=start, duration=duration)).derivative()
    assert np.allclose(velocity(start + duration + 1.0), 2.0 * duration, rtol=1e-14, atol=0.0)
    again = mb.solve(free, force=mb.pulse([4.0], duration=duration).delayed(start / 2).delayed(start / 2)).derivative()
    assert np.allclose(again(start + duration + 1.0), 2.0 * duration, rtol=1e-14, atol=0.0)


@given(
    st.lists(
        st.tuples(st.sampled_from(sorted(SIGNALS)), st.integers(0, 12), st.floats(-9, 9), st.floats(-9, 9)), min_size=3, max_size=40
    )
)
def test_many_delayed_inputs_need_few_states(terms):
    """With as many vectors as terms: no more chains of states for each function of time than there are rows."""
    matrices = [np.diag([a, b]) for _, _, a, b in terms]
    inputs = [SIGNALS[name][0].mapped(A).delayed(delay / 4) for (name, delay, *_), A in zip(terms, matrices)]
    total = sum(inputs)
    expected = sum(one(TIMES) for one in inputs)
    assert np.allclose(total(TIMES), expected, rtol=1e-12, atol=1e-12 * (1 + np.abs([one(TIMES) for one in inputs]).max()))
    largest = max(len(one.smooth.blocks[0]) for one in inputs)
    assert total.smooth.state_count <= 2 * len({name for name, *_ in terms}) * largest


def test_times_that_rounding_brings_together_stay_apart():
    """0.1 + 0.2 and 0.3 are neighbours of which a delay makes one number."""
    pulse = mb.step([1.0]).delayed(0.1).delayed(0.2) - mb.step([1.0]).delayed(0.3)
    free = mb.PolynomialMatrix([[[0.0]], [[0.0]], [[1.0]]])
    velocity = mb.solve(free, force=1e20 * pulse.delayed(0.7)).derivative()(2.0)
    assert np.isclose(velocity[0], 1e20 * float(Fraction(0.3) - Fraction(0.1) - Fraction(0.2)), rtol=1e-13, atol=0.0)
    later = mb.sampled([0.0, 1e-12, 2e-12], [[0.0, 2e12, 0.0]]).delayed(1e3)
    assert np.isclose(mb.solve(free, force=later).derivative()(1e3 + 1.0)[0], 2.0, rtol=1e-13, atol=0.0)


SHAPES = {
    "rectangle": lambda u: np.ones_like(u),
    "half-sine": lambda u: np.sin(np.pi * u),
    "versed-sine": lambda u: (1 - np.cos(2 * np.pi * u)) / 2,
    "triangle": lambda u: 1 - np.abs(2 * u - 1),
    "sawtooth": lambda u: u,
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("start", "duration"), [(0.0, 2.0), (3.0, 11e-3), (1e3, 1e-3)])
def test_a_pulse_has_its_shape(shape, start, duration):
    f = mb.pulse([2.0, -1.0], start=start, duration=duration, shape=shape)
    u = np.linspace(0.02, 0.98, 25)
    values = f(start + duration * u)
    precision = 8 * np.spacing(start) / duration + 1e-14  # of the times themselves
    np.testing.assert_allclose(values, np.outer([2.0, -1.0], SHAPES[shape](u)), atol=8 * precision)
    assert np.abs(f(np.array([start + 1.5 * duration, start + 20 * duration]))).max() <= 1e-13
    assert not start or not f(0.5 * start).any()


@pytest.mark.parametrize("shape", SHAPES)
def test_the_impulse_of_a_pulse_is_the_momentum_of_a_free_mass(shape):
    x = mb.solve(mb.PolynomialMatrix([[[0.0]], [[0.0]], [[1.0]]]), force=mb.pulse([1.0], start=1.0, duration=0.5, shape=shape))
    mean = {"rectangle": 1.0, "half-sine": 2 / np.pi}.get(shape, 0.5)
    assert x.derivative()(4.0).item() == pytest.approx(0.5 * mean, rel=1e-13)


def test_an_unknown_shape_is_named():
    with pytest.raises(mb.InputError, match="half-sine"):
        mb.pulse([1.0], duration=1.0, shape="halfsine")
