"""Groups of states that are coupled weakly, against exponentials in ball arithmetic: relative to each group's own motion."""

import numpy as np
import pytest
from flint import arb, arb_mat, ctx, fmpq
from hypothesis import given, settings
from hypothesis import strategies as st

from mbconstrained.linalg.blocks import decoupled
from mbconstrained.linalg.exponential import block_states


def balls(matrix: np.ndarray) -> arb_mat:
    return arb_mat(*matrix.shape, [arb(fmpq(*float(value).as_integer_ratio())) for value in matrix.ravel()])


def exponential(S: np.ndarray, start: np.ndarray, time: float) -> np.ndarray:
    """e^{S t} v in 400 bits."""
    bits, ctx.prec = ctx.prec, 400
    try:
        states = (balls(S) * arb(fmpq(*float(time).as_integer_ratio()))).exp() * balls(start[:, None])
        return np.array([float(states[i, 0].mid()) for i in range(len(start))])
    finally:
        ctx.prec = bits


def generator(K: np.ndarray, C: np.ndarray) -> np.ndarray:
    n = len(K)
    return np.block([[np.zeros((n, n)), np.eye(n)], [-K, -C]])


def spring_chain(n: int) -> np.ndarray:
    return 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)


def errors(S: np.ndarray, start: np.ndarray, times, groups) -> float:
    """The largest error of each group's displacements relative to their own size at each time."""
    parts, worst = decoupled(S), 0.0
    for time in times:
        values = parts.basis @ block_states(parts.blocks, parts.coordinates(start), np.array([time]))[:, 0]
        expected = exponential(S, start, time)
        for at in groups:
            worst = max(worst, np.abs(values - expected)[at].max() / np.abs(expected)[at].max())
    return worst


@pytest.mark.parametrize("coupling", [1e-6, 1e-9, 1e-12, 1e-15, 1e-40])
def test_one_part_decays_and_the_other_was_hardly_excited_by_it(coupling):
    K = np.array([[1 + coupling, -coupling], [-coupling, 1 + coupling]])
    S = generator(K, np.diag([1.0, 0.0]))
    assert errors(S, np.array([1.0, 0.0, 0.0, 0.0]), [1.0, 10.0, 100.0], [[0], [1], [0, 1]]) <= 1e-13


@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("coupling", [1e-14, 1e-17])
def test_a_part_that_grows_is_excited_through_a_tiny_entry(coupling, back):
    """Some modes of both parts have nearly one rate: these stay together."""
    n = 20
    K = np.kron(np.eye(2), spring_chain(n)) - np.diag(np.repeat([0.0, 2.0], n))
    K[n, n - 1], K[n - 1, n] = coupling, back * coupling
    start = np.zeros(4 * n)
    start[:n] = np.random.default_rng(0).normal(size=n)
    assert errors(generator(K, 0 * K), start, [1.0, 60.0], [range(n), range(n, 2 * n), range(2 * n)][1:]) <= 1e-12


@settings(max_examples=10)
@given(st.integers(0, 10**6), st.floats(-18.0, -4.0))
def test_dense_parts(seed, exponent):
    random, n = np.random.default_rng(seed), 8
    first, second = (part @ part.T + np.eye(n) for part in random.normal(size=(2, n, n)))
    between = 10.0**exponent * random.normal(size=(n, n))
    K = np.block([[first, random.integers(0, 2) * between], [between.T, second]])
    C = np.diag(np.repeat(random.uniform(0.1, 0.5, 2) * [1.0, 0.0], n))
    start = np.concatenate([random.normal(size=n), np.zeros(3 * n)])
    assert errors(generator(K, C), start, [1.0, 100.0], [range(n, 2 * n), range(2 * n)]) <= 1e-11


def test_like_parts_coupled_backward_by_a_tiny_entry_stay_together():
    K = np.array([[4.0, 4e-12], [0.1, 4.0]])
    S = generator(K, 0.1 * np.eye(2))
    assert [len(block) for block in decoupled(S).blocks] == [4]
    assert errors(S, np.array([-0.2, 0.05, 0.3, -0.1]), [0.1, 1.0, 10.0], [[0], [1]]) <= 1e-13
