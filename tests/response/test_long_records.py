"""Records of many samples against steps with the matrix exponential of the motion and its force together."""

import numpy as np
import pytest
import scipy.linalg

import mbconstrained as mb
from mbconstrained.response.response import Response
from mbconstrained.signals.bohl import FreeRestarts
from tests.response.chains import COUNT, chain, first_order, masses

PUSHED = 11
RANDOM = np.random.default_rng(3)


def record(times, rows=(PUSHED,), size=COUNT):
    """Random samples on some coordinates, and the force."""
    samples = RANDOM.normal(size=(len(rows), len(times)))
    values = np.zeros((size, len(times)))
    values[list(rows)] = samples
    return samples[0], mb.sampled(times, values)


def by_steps(A, times, samples) -> np.ndarray:
    """x at the samples from rest: (z, f, f') by e^{...h}."""
    n, S = A.size, first_order(A)
    joint = np.zeros((2 * n + 2, 2 * n + 2))
    joint[: 2 * n, : 2 * n], joint[n + PUSHED, 2 * n], joint[2 * n, 2 * n + 1] = S, 1 / masses()[PUSHED], 1.0
    steps = {gap: scipy.linalg.expm(joint * gap) for gap in set(np.diff(times))}
    z, found = np.zeros(2 * n), [np.zeros(n)]
    for gap, slope, value in zip(np.diff(times), np.diff(samples) / np.diff(times), samples):
        z = (steps[gap] @ np.concatenate([z, [value, slope]]))[: 2 * n]
        found.append(z[:n])
    return np.array(found).T


@pytest.mark.parametrize(
    "gaps", [np.full(700, 0.5), np.tile([0.25, 0.5, 1.0], 200), np.full(900, 2.0**-7)], ids=["even", "three", "short"]
)
def test_a_record_is_followed_as_steps_follow_it(gaps):
    A, times = chain(), np.append(0.0, np.cumsum(gaps))
    samples, force = record(times)
    x = mb.solve(A, force=force)
    known = by_steps(A, times, samples)
    assert np.abs(x(times) - known).max() <= 1e-11 * np.abs(known).max()


@pytest.mark.parametrize("count", [5, 400])
def test_the_two_ways_to_solve_agree_between_the_samples_too(count):
    """The first sample after t = 0 comes long before anything has moved."""
    A, times = chain(), np.append(0.0, np.cumsum(RANDOM.uniform(0.01, 0.05, count)))
    _, force = record(times, (PUSHED, 0))
    start = np.zeros((2, COUNT))
    start[0] = np.sin(np.arange(COUNT))
    asked = np.union1d(np.append(times, times[:-1] + 0.4 * np.diff(times)), [1e-5, times[-1] + 3.0])
    reduced, general = mb.solve(A, start, force), Response._by_pairs(A.jordan_pairs(), start, force)
    for one, other in ((reduced, general), (reduced.derivative(1), general.derivative(1))):
        assert np.abs(one(asked) - other(asked)).max() <= 1e-12 * np.abs(other(asked)).max()


def test_at_samples_in_any_order_the_values_are_those_of_each_alone():
    A, times = chain(), np.linspace(0.0, 20.0, 301)
    x = mb.solve(A, force=record(times)[1])
    chosen = times[RANDOM.permutation(301)[:40]]
    assert np.allclose(x(chosen), np.array([x(time) for time in chosen]).T, rtol=0, atol=1e-14)
    beside = np.nextafter(times[1:], 0)
    assert np.allclose(x(beside), x(times[1:]), rtol=0, atol=1e-13)


def test_rows_of_a_record_that_stay_zero_have_no_states():
    force = record(np.linspace(0, 1, 20), (3, 7))[1]
    assert force.smooth.coefficients.shape == (COUNT, 4)
    nothing = mb.sampled([0.0, 1.0], np.zeros((2, 2)))
    assert nothing.is_zero and nothing([0.0, 0.5]).tolist() == [[0.0, 0.0], [0.0, 0.0]]


def test_jumps_of_the_states_are_what_the_pieces_leave():
    A = chain()
    x = mb.solve(A, force=record(np.linspace(0.0, 3.0, 7))[1])
    start = x.function.start
    assert isinstance(start, FreeRestarts)
    J = x.function.generator
    for k in range(1, len(start.knots)):
        before = scipy.linalg.expm(J * (start.knots[k] - start.knots[k - 1])) @ start.states[:, k - 1]
        assert np.allclose(start.jumps[:, k], start.states[:, k] - before, rtol=0, atol=1e-12 * np.abs(start.states).max())
    assert np.array_equal(start.jumps[:, 0], start.states[:, 0])
    late = x.function.delayed(2.0)
    assert not late(1.0).any() and np.allclose(late([2.0, 3.3]), x([0.0, 1.3]), rtol=0, atol=1e-13)


def test_jumps_of_the_force_make_accelerations_jump_and_nothing_else_of_a_mass():
    A = chain()
    x = mb.solve(A, force=mb.pulse(np.eye(COUNT)[PUSHED], start=1.0, duration=1.0))
    assert x.events == ()
    jump = x.derivative(2)(1.0) - x.derivative(2)(np.nextafter(1.0, 0))
    assert np.allclose(jump, np.eye(COUNT)[PUSHED] / masses(), rtol=0, atol=1e-12)


def test_a_damper_alone_that_is_pushed_by_a_jump_changes_its_velocity():
    """K x + C x' + M x'' = f, the last coordinate without mass: x' jumps there by the jump of f over the damping."""
    K, C, M = chain().coefficients.copy()
    M[-1, -1], C[-1, -1] = 0.0, 0.5
    A = mb.PolynomialMatrix([K, C, M])
    x = mb.solve(A, force=mb.step(3.0 * np.eye(COUNT)[-1]).delayed(2.0))
    assert [event.time for event in x.events] == [2.0]
    assert np.allclose(x.events[0].jump[1], 6.0 * np.eye(COUNT)[-1], rtol=0, atol=1e-12) and not x.events[0].jump[0].any()
