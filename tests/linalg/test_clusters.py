"""Clusters of one size taken together: each as alone, whatever the others beside it are, from whichever times it starts at."""

import mpmath
import numpy as np
import pytest

from mbconstrained.ground.errors import IllConditioned
from mbconstrained.linalg.exponential import block_states

TIMES = np.array([0.0, 1e-7, 0.03, 0.4, 1.7, 6.0, 25.0])


def chain(rate, coupling, size) -> np.ndarray:
    """Defective: one zero, of which each state drives the one before."""
    return rate * np.eye(size) + coupling * np.eye(size, k=1)


def pairs(rate, frequency, apart, coupling) -> np.ndarray:
    """Two complex pairs, the second of which drives the first."""
    block = np.zeros((4, 4))
    for at, w in ((0, frequency), (2, frequency * (1 + apart))):
        block[at : at + 2, at : at + 2] = [[rate, w], [-w, rate]]
    block[1, 2] = coupling
    return block


STACKS = {
    3: [
        *(
            chain(rate, coupling, 3)
            for rate, coupling in ((0.0, 1.0), (0.0, 1e3), (-0.5, 0.5), (-40.0, 1.0), (0.2, 30.0), (-1e-6, 1e-6))
        ),
        np.array([[-1.0, 2.0, 0.3], [-2.0, -1.0, 0.1], [0.0, 0.0, 0.0]]),
        np.array([[-1e-3, 20.0, 1e5], [-20.0, -1e-3, 0.0], [0.0, 0.0, 0.0]]),
        np.diag([-3.0, -3.0, -3.0]),
    ],
    4: [
        *(chain(rate, coupling, 4) for rate, coupling in ((0.0, 1.0), (-2.0, 0.3), (0.1, 5.0))),
        *(pairs(-0.1, w, apart, w) for w in (1e-3, 0.2, 1.0, 1.9, 30.0) for apart in (0.0, 1e-9, 0.01)),
        pairs(-5.0, 0.1, 0.0, 1.0),
        np.diag([0.0, -1.0, -2.0, -3.0]) + np.triu(np.ones((4, 4)), 1),
    ],
}


def starts(size, count) -> np.ndarray:
    return np.random.default_rng(size).uniform(-1.0, 1.0, size * count)


@pytest.mark.parametrize("size", STACKS)
def test_each_agrees_with_eighty_digits_whatever_stands_beside_it(size):
    blocks = STACKS[size]
    start = starts(size, len(blocks))
    found = block_states(blocks, start, TIMES).reshape(-1, size, len(TIMES))
    for block, own, states in zip(blocks, start.reshape(-1, size), found):
        rate = np.abs(block).sum(axis=1).max()
        for time, state in zip(TIMES, states.T):
            with mpmath.workdps(80 + int(rate * time) if rate * time < 300 else 400):
                exact = mpmath.expm(mpmath.matrix(block.tolist()) * mpmath.mpf(time)) * mpmath.matrix(own.tolist())
                known = np.array([float(value) for value in exact])
            assert np.abs(state - known).max() <= 2e-15 * (4 + rate * time) * np.abs(known).max()


def test_one_too_fast_beside_the_others_is_told():
    blocks = [chain(-1.0, 1.0, 3), chain(-1.0, 1e200, 3)]
    with pytest.raises(IllConditioned, match="by more than 150 powers of ten"):
        block_states(blocks, np.ones(6), np.array([1.0]))
