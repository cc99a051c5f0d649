"""Motions of long damped chains, trees, rings and ladders by their modes, against exponentials of the generator."""

import numpy as np
import pytest
import scipy.linalg
from scipy.sparse.linalg import expm_multiply

import mbconstrained as mb
from mbconstrained.linalg.tree_modes import ResidueModes
from mbconstrained.response.solve import solve
from tests.linalg.few_couplings import ladder, ring

from .plain_models import plain_system

UNEVEN = np.array([0.0, 0.2, 1.0, 7.0, 30.0])


def systems():
    for kind, sizes in (("chain", {"damped": 8, "static": 5}), ("chain", {}), ("tree", {"damped": 5})):
        yield plain_system(kind, seed=3, size=130, damping="some", **sizes).polynomial_matrix(), kind == "chain"
    for M, C, K in (ring(250), ladder(250)):
        yield mb.PolynomialMatrix([K, C, M]), True


@pytest.mark.parametrize(("A", "whole"), list(systems()), ids=["a chain with joints", "a chain", "trees", "ring", "ladder"])
def test_the_motion_is_that_of_the_exponential(A, whole):
    """Several trees, each on the ground, are decoupled one by one."""
    reduction = A.reduction
    assert reduction.topology is not None and isinstance(reduction.decoupled, ResidueModes) == whole
    start = np.random.default_rng(0).normal(size=reduction.state_count)
    S = reduction.generator.toarray() if hasattr(reduction.generator, "toarray") else reduction.generator
    output = reduction.output.toarray() if hasattr(reduction.output, "toarray") else reduction.output
    m = len(reduction.second)
    free = np.concatenate([start[:m], start[2 * m :]])
    initial = np.stack([reduction.V @ free, reduction.V @ np.concatenate([start[m : 2 * m], np.zeros(len(free) - m)])])
    x = solve(A, initial)
    states = np.array([expm_multiply(S * t, start) for t in UNEVEN]).T
    expected, speed = output @ states, output @ (S @ states)
    assert np.abs(x(UNEVEN) - expected).max() <= 2e-12 * np.abs(expected).max()
    assert np.abs(x.derivative()(UNEVEN) - speed).max() <= 2e-12 * np.abs(speed).max()


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
