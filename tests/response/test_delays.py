"""Equations with delays: the method of steps against rational series, Lambert's function, an independent integrator and exact arithmetic."""

from fractions import Fraction
from itertools import pairwise
from math import factorial

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import lambertw

import mbconstrained as mb
from mbconstrained.response.methods.method_of_steps import residual_of

MASS, STIFFNESS, DAMPING = np.diag([1.0, 2.0]), np.array([[5.0, -2.0], [-2.0, 3.0]]), 0.1 * np.eye(2)
BACK, RATE = np.array([[0.0, 0.4], [0.0, 0.0]]), np.array([[0.3, 0.0], [0.1, -0.2]])
OSCILLATORS = mb.PolynomialMatrix([STIFFNESS, DAMPING, MASS])
START = np.array([[0.3, -0.2], [0.1, 0.4]])


def series(t) -> float:
    """x' = -x(t - 1) from x(0) = 1, zero before: the sum of (-1)^k (t - k)^k / k!, in rational numbers."""
    t = Fraction(t)
    return float(sum((-1) ** k * (t - k) ** k / Fraction(factorial(k)) for k in range(int(t) + 1)))


def integrated(terms, force, start, end, history=None):
    """x and x' of the oscillators by DOP853 from break point to break point, each delayed value from the interval it lies in."""
    n, inverse, pieces = 2, np.linalg.inv(MASS), []

    def past(t, middle):
        if middle < 0:
            return np.zeros(2 * n) if history is None else history(t)
        return next(one(t) for a, b, one in pieces if a <= middle <= b)

    sums, shortest = {0.0}, min(terms)
    for _ in range(int(end / shortest) + 1):
        sums |= {round(one + delay, 12) for one in sums for delay in terms if one + delay < end}
    breaks, y = sorted(sums | {end}), np.concatenate(start)
    for a, b in pairwise(breaks):

        def rates(t, y, a=a, b=b):
            load = force(t).copy()
            for delay, (K, C) in terms.items():
                z = past(t - delay, (a + b) / 2 - delay)
                load -= K @ z[:n] + C @ z[n:]
            return np.concatenate([y[n:], inverse @ (load - DAMPING @ y[n:] - STIFFNESS @ y[:n])])

        solution = solve_ivp(rates, (a, b), y, method="DOP853", rtol=3e-14, atol=1e-15, dense_output=True)
        pieces.append((a, b, solution.sol))
        y = solution.y[:, -1]
    return lambda times: np.array([past(t, t) for t in times]).T


def test_scalar_delay_is_the_rational_series_however_many_delays_have_passed():
    x = mb.solve(mb.PolynomialMatrix([[[0.0]], [[1.0]]]), [[1.0]], delayed={1.0: [[1.0]]})
    times = [0.0, 0.3, 1.0, 1.5, 3.7, 10.0, 25.25, 80.5]
    values, exact = x(times)[0], np.array([series(t) for t in times])
    assert (abs(values - exact) <= 1e-12 * abs(exact) + 1e-15 * abs(exact).max() * (abs(exact) > 1e-3)).all()
    assert x(2.0).shape == (1,) and x.method.name == "method of steps" and not x.events


def test_a_motion_that_began_as_a_mode_remains_this_mode():
    s = lambertw(-0.8 + 0j, k=1)  # a root of s + 0.8 e^-s = 0
    x = mb.solve(mb.PolynomialMatrix([[[0.0]], [[1.0]]]), delayed={1.0: [[0.8]]}, history=lambda t: np.exp(s * t).real)
    times = np.linspace(0, 12, 61)
    np.testing.assert_allclose(x(times)[0], np.exp(s * times).real, atol=1e-12)


@pytest.mark.parametrize("terms", [{0.7: (BACK, RATE)}, {0.7: (BACK, RATE), 0.31: (0.2 * BACK.T, 0.5 * DAMPING)}])
def test_oscillators_with_delays_against_an_integrator(terms):
    force = mb.harmonic([1.0, 0.5], angular_frequency=1.7)
    x = mb.solve(OSCILLATORS, START, force, delayed={delay: list(pair) for delay, pair in terms.items()})
    times = np.array([0.2, 0.5, 0.71, 1.3, 2.2, 4.1])
    expected = integrated(terms, force, START, 4.2)(times)
    np.testing.assert_allclose(np.vstack([x(times), x.derivative()(times)]), expected, atol=1e-12)


def test_the_motion_before_the_start_enters():
    def past(t):
        return np.array([np.sin(t), 1 + t * t])

    x = mb.solve(OSCILLATORS, delayed={0.7: [BACK, RATE]}, history=past)
    np.testing.assert_allclose(x.initial, [[0, 1], [1, 0]], atol=1e-10)
    assert not x.events  # the motion continues without a jump
    rates = lambda t: np.concatenate([past(t), [np.cos(t), 2 * t]])  # noqa: E731
    expected = integrated({0.7: (BACK, RATE)}, mb.zero(2), x.initial, 4.2, rates)(times := np.array([0.2, 0.71, 1.4, 4.1]))
    np.testing.assert_allclose(x(times), expected[:2], atol=1e-11)


@pytest.mark.parametrize("history", [None, [1.0, 2.0]])
def test_values_lie_in_the_intervals_of_exact_arithmetic(history):
    force = mb.harmonic([1.0, 0.5], angular_frequency=1.7) + mb.step([1.0, 0.0]).delayed(0.45)
    x = mb.solve(OSCILLATORS, START, force, delayed={0.7: [BACK, RATE], 0.35: BACK.T}, history=history)
    times = [0.0, 0.2, 0.35, 0.45, 0.7, 1.4, 1.63]
    for order in (0, 1):
        box = x.enclose(times, 20, order=order)
        assert box.error_bounds(x.derivative(order)(times)).max() <= max(x.error_estimate(times, order=order), 1e-15) * 4


def node_with_delay(force):
    K = np.array([[3.0, 0.0, -1.0], [0.0, 4.0, -2.0], [-1.0, -2.0, 3.5]])
    A = mb.PolynomialMatrix([K, np.diag([0.1, 0.2, 0.0]), np.diag([1.0, 2.0, 0.0])])
    back, rate = np.zeros((3, 3)), np.zeros((3, 3))
    back[2, 0], rate[1, 1] = 0.7, 0.5
    return mb.solve(A, [[0.1, 0.2, 0.0], np.zeros(3)], force, delayed={0.3: [back, rate]})


def test_jumps_travel_with_the_delay_and_end():
    force = mb.pulse([1.0, 0.0, 2.0], start=0.25, duration=0.4) + mb.impulse([0.5, 0.0, 0.0]).delayed(0.6)
    x = node_with_delay(force)
    assert [event.time for event in x.events] == pytest.approx([0.25, 0.3, 0.6, 0.65, 0.9])
    for event in x.events:
        for order in (0, 1):
            sides = [x.derivative(order)(event.time + side) for side in (-1e-9, 1e-9)]
            np.testing.assert_allclose(sides[1] - sides[0], event.jump[order], atol=1e-7)
    times = np.linspace(0, 20, 997)
    residual = residual_of(x.function, x.polynomial_matrix, x.problem.delayed)
    np.testing.assert_allclose(residual(times), force(times), atol=1e-13)


def test_a_delayed_rate_of_a_coordinate_that_jumps_is_an_impulse():
    K = np.array([[2.0, -1.0], [-1.0, 1.0]])
    A = mb.PolynomialMatrix([K, np.zeros((2, 2)), np.diag([1.0, 0.0])], coordinates=["mass", "node"])
    rate = np.array([[0.0, 0.25], [0.0, 0.0]])
    x = mb.solve(A, force=mb.step([0.0, 2.0]).delayed(0.5), delayed={0.2: [0 * rate, rate]})
    first, second = x.events[:2]
    assert first.time == 0.5 and first.jump[0].tolist() == [0.0, 2.0]
    assert second.time == 0.7 and second.jump[1, 0] == pytest.approx(-0.25 * 2.0)
    box = x.enclose([0.71, 0.75, 0.95], 18)
    assert box.error_bounds(x([0.71, 0.75, 0.95])).max() < 1e-14


def test_the_error_estimate_is_at_least_the_error():
    x = mb.solve(mb.PolynomialMatrix([[[0.0]], [[1.0]]]), [[1.0]], delayed={1.0: [[1.55]]})  # close to the limit of stability
    times = [30.0, 40.0, 50.0]
    error = x.enclose(times, 20).error_bounds(x(times)).max() / abs(x(times)).max()
    assert error <= x.error_estimate(times) < 1e-11


@pytest.mark.parametrize(
    "delayed, text",
    [
        ({0.3: [np.zeros((2, 2)), np.zeros((2, 2)), MASS]}, "neutral"),
        ({0.3: [np.zeros((2, 2))] * 3 + [MASS]}, "advanced"),
        ({0.1: [[1.0]]}, "expected 2 x 2"),
        ({0.0: np.eye(2)}, "acts at once"),
        ({-1.0: np.eye(2)}, "at least 0"),
        ({np.nan: np.eye(2)}, "delay"),
        ({0.1: [[np.nan, 0.0], [0.0, 0.0]]}, "nan"),
        ([1.0], "mapping from delays"),
    ],
)
def test_refusals_name_what_is_wrong(delayed, text):
    with pytest.raises(mb.InputError, match=text):
        mb.solve(OSCILLATORS, delayed=delayed)


def test_histories_that_do_not_fit_are_refused():
    with pytest.raises(mb.InputError, match="no delays"):
        mb.solve(OSCILLATORS, history=[0.0, 1.0])
    for history in ([1.0], mb.step([1.0]), mb.impulse([1.0, 0.0])):
        with pytest.raises(mb.InputError, match="history"):
            mb.solve(OSCILLATORS, delayed={0.3: BACK}, history=history)
    with pytest.raises(mb.InputError, match="several"):
        mb.solve(OSCILLATORS, np.zeros((3, 2, 2)), delayed={0.3: BACK})


def test_times_beyond_memory_are_refused_at_once():
    x = mb.solve(mb.PolynomialMatrix([[[0.0]], [[1.0]]]), [[1.0]], delayed={1.0: [[1.0]]})
    with pytest.raises(mb.InputError, match="ask for earlier times"):
        x(1e9)
    assert x(1.0) == 0.0 + x.enclose(1.0).middle  # and earlier ones are still answered


def test_terms_that_are_zero_are_no_delay():
    assert mb.solve(OSCILLATORS, START, delayed={0.3: np.zeros((2, 2))}).method.name != "method of steps"


@pytest.mark.parametrize("seed", [1, 11, 21, 30, 39, *(pytest.param(seed, marks=pytest.mark.long) for seed in (12, 13, 15, 19))])
def test_random_systems_lie_in_exact_intervals_within_their_estimates(seed):
    random = np.random.default_rng(seed)
    n, degree = int(random.integers(1, 4)), int(random.integers(1, 3))
    A = [random.normal(size=(n, n)).round(2) for _ in range(degree + 1)]
    if random.random() < 0.4:
        A[degree][-1] = 0.0
    patterns = random.random((n, n)) < 0.6
    delays = random.uniform(0.3, 0.9, 2).round(2)[: int(random.integers(1, 3))]
    delayed = {float(delay): [random.normal(size=(n, n)).round(2) * patterns for _ in range(degree)] for delay in delays}
    force = mb.step(random.normal(size=n).round(1)).delayed(0.25) + mb.harmonic(
        random.normal(size=n).round(1), angular_frequency=2.5
    )
    try:
        x = mb.solve(mb.PolynomialMatrix(A), random.normal(size=(degree, n)).round(1), force, delayed=delayed)
    except mb.InputError as refused:
        assert "type" in str(refused)  # of a singular leading matrix: neutral or advanced
        return
    times = np.sort(random.uniform(0, 1.2, 3))
    error = x.enclose(times, 16).error_bounds(x(times)).max() / abs(x(times)).max()
    assert error <= x.error_estimate(times) and error < 1e-11
