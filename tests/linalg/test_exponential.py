"""e^{J t} v against the same in sixty digits (mpmath) and against closed forms."""

import mpmath
import numpy as np
import pytest

from mbconstrained.ground.errors import IllConditioned
from mbconstrained.linalg.exponential import block_states

NILPOTENT = np.eye(6, k=1)
START = np.array([1.0, -2.0, 3.0, 0.5, -1.0, 2.0])


def triangle(diagonal, above=1.0) -> np.ndarray:
    """Upper triangular with this diagonal and everything above it equal."""
    size = len(diagonal)
    return np.diag(np.asarray(diagonal, float)) + above * np.triu(np.ones((size, size)), 1)


def rotation_chain(rate, frequency, spread=0.0, pairs=2) -> np.ndarray:
    """Blocks [[a, w], [-w, a]] on the diagonal, joined by identities: a defective complex pair when spread = 0."""
    J = np.kron(np.eye(pairs, k=1), np.eye(2))
    for i in range(pairs):
        a, w = rate, frequency * (1 + i * spread)
        J[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[a, w], [-w, a]]
    return J


def reference(block, start, time) -> np.ndarray:
    """The states in sixty digits more than the growth of the exponent needs."""
    digits = 60 + int(abs(block).sum() * time)
    with mpmath.workdps(min(digits, 400)):
        return np.array([float(x) for x in mpmath.expm(mpmath.matrix(block) * mpmath.mpf(time)) * mpmath.matrix(start)])


CLUSTERS = {
    "one": (np.array([[-0.7]]), 1e-14),
    "growing": (np.array([[0.9]]), 1e-14),
    "a pair": (np.array([[-0.1, 2.0], [-3.0, -0.1]]), 1e-14),
    "a nearly defective real pair": (triangle([-1.0, -1.0 - 1e-9]), 1e-14),
    "a real pair with strong coupling": (triangle([-1.0, -2.0], 1e4), 1e-12),
    "an exactly defective pair": (triangle([-1.0, -1.0]), 1e-14),
    "nilpotent": (NILPOTENT, 1e-15),
    "defective": (triangle([-1.0] * 5), 1e-13),
    "nearly defective": (triangle(-1.0 - 1e-10 * np.arange(5)), 1e-13),
    "spread": (triangle([-1.0, -1.1, -1.3, -1.2]), 1e-12),
    "one far from the others": (triangle([-0.1, -0.2, -5.0]), 1e-11),
    "growth and decay": (triangle([0.5, -0.5, 0.0]), 1e-12),
    "a defective complex pair": (rotation_chain(-0.1, 3.0), 1e-13),
    "a triple complex pair": (rotation_chain(-0.1, 3.0, pairs=3), 1e-12),
    "nearly equal complex pairs": (rotation_chain(-0.1, 3.0, spread=1e-9), 1e-13),
    "complex pairs apart": (rotation_chain(-0.1, 3.0, spread=0.5), 1e-11),
    "a complex pair and a real zero": (np.array([[-0.1, 1.0, 1.0], [-1.0, -0.1, 1.0], [0.0, 0.0, -0.2]]), 1e-12),
}


@pytest.mark.parametrize("name", CLUSTERS)
def test_states_agree_with_sixty_digits(name):
    block, accuracy = CLUSTERS[name]
    start = START[: len(block)]
    times = np.array([0.0, 1e-8, 0.03, 1.0, 4.0, 20.0])
    states = block_states([block], start, times)
    for time, found in zip(times, states.T):
        known = reference(block, start, time)
        assert np.abs(found - known).max() <= accuracy * np.abs(known).max()


def test_a_chain_keeps_relative_accuracy_entry_by_entry():
    """e^{N t}: the entry (i, j) is t^(j-i)/(j-i)!, tiny or not."""
    size = 30
    for time in (1e-3, 0.5, 1.0, 2.0, 50.0):
        column = block_states([np.eye(size, k=1)], np.eye(size)[-1], np.array([time]))[::-1, 0]
        known = np.cumprod([1.0, *(time / k for k in range(1, size))])
        assert np.allclose(column, known, rtol=1e-12, atol=0)


@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-6, 1e-3, 0.1])
@pytest.mark.parametrize("rates", [(-0.1, 0.0), (0.0, 0.0), (-0.02, 0.3)], ids=["damped", "undamped", "growing"])
def test_a_motion_near_the_frequency_of_its_force(apart, rates):
    """From rest; both rotations are far from the real axis, which is where they are told from their conjugates."""
    block = np.zeros((4, 4))
    for place, (rate, frequency) in enumerate(zip(rates, (2.0, 2.0 + apart))):
        block[2 * place : 2 * place + 2, 2 * place : 2 * place + 2] = [[rate, frequency], [-frequency, rate]]
    block[1, 2], start = 0.7, np.array([0.0, 0.0, 1.0, -0.5])
    times = np.array([0.0, 1e-6, 0.01, 0.3, 2.0, 30.0, 100.0])
    for time, found in zip(times, block_states([block], start, times).T):
        known = reference(block, start, time)
        assert np.abs(found - known)[:2].max() <= 1e-13 * np.abs(known)[2:].max() * max(time, 1.0)
        assert np.abs(found - known).max() <= 1e-13 * (1 + time) * np.abs(known).max()


@pytest.mark.parametrize("time", [1e3, 1e6, 1e12])
def test_stiff_decay_ends_in_zero_without_a_warning(time):
    for block in (np.array([[-1e6]]), triangle([-1e6, -2e6]), triangle([-1e6, -1.1e6, -1.2e6]), rotation_chain(-1e6, 1e6)):
        assert not block_states([block], START[: len(block)], np.array([time])).any()


def test_growth_beyond_float64_is_not_finite_and_the_rest_is_untouched():
    with np.errstate(over="ignore"):
        states = block_states([np.array([[1.0]]), np.array([[-1.0]])], np.ones(2), np.array([800.0, 1.0]))
    assert not np.isfinite(states[0, 0])
    assert np.allclose(states[1], np.exp([-800.0, -1.0]))
    assert states[0, 1] == pytest.approx(np.e)


@pytest.mark.parametrize("w", [3e-9, 1e-6, 1e-3, 0.3])
def test_pairs_in_a_chain_that_hardly_turn_about_their_middle(w):
    """e^{J t} of [[R, I], [0, R]] is e^{a t} [[Q, t Q], [0, Q]], Q = [[cos w t, c sin(w t)/w], [-w sin(w t)/c, cos w t]]."""
    a, c, start = -3.0, 6.25, np.array([0.3, -0.7, 0.5, 0.2])
    R = np.array([[a, c], [-(w**2) / c, a]])
    block, times = np.block([[R, np.eye(2)], [np.zeros((2, 2)), R]]), np.linspace(0.0, 12.0, 7)
    expected = []
    for t in times:
        Q = np.exp(a * t) * np.array([[np.cos(w * t), c * np.sinc(w * t / np.pi) * t], [-w * np.sin(w * t) / c, np.cos(w * t)]])
        expected.append(np.block([[Q, t * Q], [np.zeros((2, 2)), Q]]) @ start)
    found, expected = block_states([block], start, times), np.array(expected).T
    assert np.allclose(found, expected, rtol=1e-12, atol=1e-14 * np.abs(expected).max(axis=0))


# Clusters of one size taken together: each as alone, whatever the others beside it are.

STACK_TIMES = np.array([0.0, 1e-7, 0.03, 0.4, 1.7, 6.0, 25.0])


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
    found = block_states(blocks, start, STACK_TIMES).reshape(-1, size, len(STACK_TIMES))
    for block, own, states in zip(blocks, start.reshape(-1, size), found):
        rate = np.abs(block).sum(axis=1).max()
        for time, state in zip(STACK_TIMES, states.T):
            known = reference(block, own, time)
            assert np.abs(state - known).max() <= 2e-15 * (4 + rate * time) * np.abs(known).max()


def test_one_too_fast_beside_the_others_is_told():
    blocks = [chain(-1.0, 1.0, 3), chain(-1.0, 1e200, 3)]
    with pytest.raises(IllConditioned, match="by more than 150 powers of ten"):
        block_states(blocks, np.ones(6), np.array([1.0]))
