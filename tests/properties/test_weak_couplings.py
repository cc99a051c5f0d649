"""Parts that are coupled weakly, in any units, seen at any time: the answer is as accurate as its estimate, or warns."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb

sizes = st.integers(2, 5)
couplings = st.floats(-19.0, -1.0).map(lambda power: 10.0**power)
units = st.integers(-12, 12)
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
