"""Motions of damped rings and ladders by their modes, against exponentials of the generator."""

import numpy as np
import pytest
import scipy.linalg

import mbconstrained as mb
from mbconstrained.linalg.tree_modes import ResidueModes
from mbconstrained.response.solve import solve

COUNT, UNEVEN = 250, np.array([0.0, 0.2, 1.0, 7.0, 30.0])


def coupled(pairs):
    """M, C and K of masses with a spring and a damper between each of these pairs, the first mass on the ground."""
    random = np.random.default_rng(0)
    C, K = np.zeros((2, COUNT, COUNT))
    for pair in pairs:
        pull = np.zeros(COUNT)
        pull[list(pair)] = 1.0, -1.0
        K += random.uniform(0.5, 2.0) * np.outer(pull, pull)
        C += random.uniform(0.0, 0.05) * np.outer(pull, pull)
    K[0, 0] += 1.0
    return np.diag(random.uniform(0.5, 2.0, COUNT)), C, K


RING = [(at, (at + 1) % COUNT) for at in range(COUNT)]
LADDER = [(at, at + 2) for at in range(COUNT - 2)] + [(at, at + 1) for at in range(0, COUNT, 2)]


@pytest.mark.parametrize("pairs", [RING, LADDER], ids=["ring", "ladder"])
def test_the_motion_is_that_of_the_exponential(pairs):
    M, C, K = coupled(pairs)
    A = mb.PolynomialMatrix([K, C, M])
    assert A.reduction.topology is not None and isinstance(A.reduction.decoupled, ResidueModes)
    start = np.random.default_rng(1).normal(size=(2, COUNT))
    generator = np.block([[np.zeros_like(K), np.eye(COUNT)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    expected = np.array([(scipy.linalg.expm(generator * t) @ start.ravel())[:COUNT] for t in UNEVEN]).T
    assert np.abs(solve(A, start)(UNEVEN) - expected).max() <= 2e-12 * np.abs(expected).max()


def test_where_modes_are_refused_even_times_take_powers_nevertheless():
    """Four dampers at equal distances leave half of the zeros of a uniform ring double."""
    count, even = 4 * 63, np.linspace(0.0, 20.0, 60)
    shift = np.roll(np.eye(count), 1, axis=0)
    K, C = 2.1 * np.eye(count) - shift - shift.T, np.diag((np.arange(count) % 63 == 0).astype(float))
    A = mb.PolynomialMatrix([K, C, np.eye(count)])
    start = np.random.default_rng(1).normal(size=(2, count))
    x = solve(A, start)
    values = x(even)
    assert A.reduction.topology is not None and A.reduction.topology_failed and "decoupled" not in A.reduction.__dict__
    generator = np.block([[np.zeros_like(K), np.eye(count)], [-K, -C]])
    expected = (scipy.linalg.expm(generator * even[-1]) @ start.ravel())[:count]
    assert np.abs(values[:, -1] - expected).max() <= 2e-12 * np.abs(expected).max()
