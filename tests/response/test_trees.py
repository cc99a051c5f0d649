"""Motions of long damped chains and trees by their modes, against exponentials of the generator and against powers of them."""

import numpy as np
import pytest
import scipy.linalg

from mbconstrained.linalg.tree_modes import ResidueModes
from mbconstrained.response.solve import solve

from .plain_models import plain_system

UNEVEN = np.array([0.0, 0.2, 1.0, 7.0, 30.0])


def systems():
    for kind, sizes in (("chain", {"damped": 8, "static": 5}), ("chain", {}), ("tree", {"damped": 5})):
        yield plain_system(kind, seed=3, size=130, damping="some", **sizes).polynomial_matrix(), kind == "chain"


@pytest.mark.parametrize(("A", "whole"), list(systems()), ids=["a chain with joints", "a chain", "trees"])
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
    expected = np.array([output @ scipy.linalg.expm(S * t) @ start for t in UNEVEN]).T
    assert np.abs(x(UNEVEN) - expected).max() <= 2e-12 * np.abs(expected).max()
    speed = np.array([output @ S @ scipy.linalg.expm(S * t) @ start for t in UNEVEN]).T
    assert np.abs(x.derivative()(UNEVEN) - speed).max() <= 2e-12 * np.abs(speed).max()
