"""Parts that are coupled weakly, in any units, seen at any time: the answer is as accurate as its estimate, or warns."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb

sizes = st.integers(2, 5)
couplings = st.floats(-19.0, -1.0).map(lambda power: 10.0**power)
units = st.integers(-12, 12)
TINY = 1e-280
rates = st.sampled_from([0.0, 0.1, 1.0, 3.0])


@st.composite
def chains(draw):
    """A chain of oscillators on springs of their own, joined by weak springs or dampers, a start at one of them, and a time."""
    n = draw(sizes)
    own = [draw(st.sampled_from([0.5, 1.0, 1.0, 4.0])) for _ in range(n)]
    K, C, M = np.diag(own), np.diag([draw(rates) for _ in range(n)]), np.eye(n)
    for i in range(n - 1):
        weak = draw(couplings)
        place = draw(st.sampled_from("KKKC"))
        matrix = K if place == "K" else C
        matrix[i, i] += weak
        matrix[i + 1, i + 1] += weak
        matrix[i, i + 1] -= weak
        matrix[i + 1, i] -= weak * draw(st.sampled_from([1.0, 1.0, 0.0]))
    scale = 2.0 ** np.array([draw(units) for _ in range(n)])
    A = mb.PolynomialMatrix([matrix * scale / scale[:, None] for matrix in (K, C, M)])
    start, force = np.zeros((2, n)), None
    at = draw(st.integers(0, n - 1))
    if draw(st.booleans()):
        start[draw(st.integers(0, 1)), at] = 1.0
    else:
        force = mb.step(np.eye(n)[at]) + mb.step(np.eye(n)[(at + 1) % n] * draw(couplings))
    return A, start / scale, None if force is None else force.mapped(np.diag(1 / scale)), 10.0 ** draw(st.floats(-2, 3))


@given(chains())
def test_the_answer_at_any_time_is_as_accurate_as_its_estimate_or_warns(problem):
    A, start, force, time = problem
    x = mb.solve(A, start, force)
    box = x.enclose(time, digits=16)
    expected = np.array(box.lower, dtype=float)
    error, size = np.abs(x(time) - expected).max(), np.abs(expected).max()
    assert error <= 10 * x.error_estimate(time) * size or any(notice.doubtful for notice in x.notices)


@st.composite
def scattered(draw, largest: int = 4):
    """Parts of any size joined at any places of K, C and M, in units of their own, in any unit of time, seen from early to very late.

    Every exact part of the data is small next to others somewhere: couplings, supports, loads, values at 0-, light and zero masses.
    """
    n = draw(st.integers(2, largest))
    small = st.floats(-22.0, 0.0).map(lambda power: 10.0**power)
    K = np.diag(
        [draw(st.sampled_from([0.0, 0.5, 1.0, 1.0, 4.0, -0.1])) + draw(st.sampled_from([0.0, 1.0])) * draw(small) for _ in range(n)]
    )
    C = np.diag([draw(rates) for _ in range(n)])
    M = np.diag([draw(st.sampled_from([1.0, 1.0, 1.0, 2.0, 1e-3])) for _ in range(n)])
    for _ in range(draw(st.integers(1, 2 * n))):
        i, j = draw(st.permutations(range(n)))[:2]
        weak = draw(small) * draw(st.sampled_from([1.0, -1.0]))
        back = draw(st.sampled_from([1.0, 1.0, -1.0, 0.0]))  # symmetric, gyroscopic or circulatory, one-way
        matrix = draw(st.sampled_from([K, K, C, M]))
        if matrix is M:
            weak, back = 0.1 * weak, 1.0
        matrix[i, j] += weak
        matrix[j, i] += back * weak
    columns, rows = (2.0 ** np.array([draw(units) for _ in range(n)]) for _ in range(2))
    clock = 2.0 ** draw(st.integers(-20, 20))  # seconds in the unit of time
    A = mb.PolynomialMatrix([matrix * clock**k * columns / rows[:, None] for k, matrix in enumerate((K, C, M))])
    start = np.array([[draw(st.sampled_from([0.0, 0.0, 1.0])) * draw(small) for _ in range(n)] for _ in range(2)])
    load = np.array([draw(st.sampled_from([0.0, 0.0, 1.0])) * draw(small) for _ in range(n)]) / rows
    kind = draw(st.sampled_from(["none", "step", "harmonic", "pulse"]))
    force = {
        "none": lambda: None,
        "step": lambda: mb.step(load),
        "harmonic": lambda: mb.harmonic(load, angular_frequency=draw(st.sampled_from([0.7, 1.0])) / clock),
        "pulse": lambda: mb.pulse(
            load, start=draw(st.sampled_from([0.0, 3.0])) * clock, duration=10.0 ** draw(st.floats(-9, 0)) * clock
        ),
    }[kind]()
    times = [10.0 ** draw(st.floats(-3, 5)) * clock for _ in range(2)]
    return A, start / columns / clock ** np.arange(2)[:, None], force, np.array(times)


@given(scattered())
def test_scattered_couplings(problem):
    check_at_each_time(*problem)


@pytest.mark.long
@given(scattered(largest=12))
def test_scattered_couplings_of_larger_models(problem):
    check_at_each_time(*problem)


def check_at_each_time(A, start, force, times) -> None:
    """Small models are proved, and their estimate is no less than a tenth of the error at each single time, or there is a warning."""
    try:
        x = mb.solve(A, start, force)
        values = [x(time) for time in times]
    except mb.Overflow:
        return
    box = x.enclose(times, digits=16)
    for k, time in enumerate(times):
        expected = np.array(box.lower[:, k], dtype=float)
        size = np.abs(expected).max()
        if not TINY < size < 1 / TINY:  # float64 has no relative precision there
            continue
        error, estimate = np.abs(values[k] - expected).max() / size, x.error_estimate(time)
        warned = any(notice.doubtful for notice in x.notices)
        assert error <= 10 * estimate or warned, (time, error, estimate)
        assert not x.is_proved or error <= 2e-12, (time, error)
