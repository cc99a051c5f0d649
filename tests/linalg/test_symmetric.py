"""M x'' + C x' + K x = 0 decoupled by a symmetric eigenproblem: identities, closed forms, exponentials, mpmath, exact arithmetic."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
import scipy.linalg
from mpmath import mp, mpf
from scipy.sparse import csr_array

from mbconstrained.ground.tolerances import EPS
from mbconstrained.linalg.blocks import block_matrix
from mbconstrained.linalg.division import congruence
from mbconstrained.linalg.exponential import block_states
from mbconstrained.linalg.symmetric import refined_modes, symmetric_modes


def generator(M, C, K) -> np.ndarray:
    size = len(M)
    return np.block([[np.zeros((size, size)), np.eye(size)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])


def modes(M, C, K):
    return symmetric_modes(csr_array(M), csr_array(C), csr_array(K))


def check(M, C, K) -> None:
    """The identities, and e^{S t} of a start against SciPy."""
    M, C, K = (np.asarray(matrix, dtype=float) for matrix in (M, C, K))
    found, S = modes(M, C, K), generator(M, C, K)
    assert np.allclose(found.inverse @ found.basis, np.eye(len(S)), rtol=0, atol=1e-12)
    size = np.abs(found.basis).max() * np.abs(S).max()
    assert np.abs(S @ found.basis - found.basis @ block_matrix(found.blocks)).max() <= 1e-13 * size * len(S)
    start, times = np.random.default_rng(0).normal(size=len(S)), np.array([0.0, 0.1, 1.0, 7.0])
    states = found.basis @ block_states(found.blocks, found.inverse @ start, times)
    expected = np.array([scipy.linalg.expm(S * t) @ start for t in times]).T
    assert np.abs(states - expected).max() <= 1e-12 * np.abs(expected).max()


def chain(size: int) -> np.ndarray:
    return 2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)


def ring(size: int) -> np.ndarray:
    return 2 * np.eye(size) - np.roll(np.eye(size), 1, 0) - np.roll(np.eye(size), -1, 0)


def dense(size: int, seed: int = 0) -> np.ndarray:
    root = np.random.default_rng(seed).normal(size=(size, size))
    return root @ root.T + np.eye(size)


ZERO = np.zeros((6, 6))
CASES = {
    "one mass": ([[2.0]], [[0.0]], [[3.0]]),
    "one mass, negative stiffness": ([[2.0]], [[0.0]], [[-3.0]]),
    "one free mass": ([[2.0]], [[0.0]], [[0.0]]),
    "two": (np.diag([1.0, 3.0]), np.zeros((2, 2)), chain(2)),
    "a chain": (np.eye(6), ZERO, chain(6)),
    "a chain in another order": (np.eye(6), ZERO, chain(6)[np.ix_([3, 0, 5, 1, 4, 2], [3, 0, 5, 1, 4, 2])]),
    "a ring, with repeated zeros": (np.eye(6), ZERO, ring(6) + np.eye(6)),
    "not coupled": (np.diag(np.arange(1.0, 7.0)), ZERO, np.diag(np.arange(1.0, 7.0))),
    "a full stiffness": (np.eye(6), ZERO, dense(6)),
    "a full mass": (dense(6, 1), ZERO, dense(6)),
    "negative stiffness": (np.eye(6), ZERO, chain(6) - 1.5 * np.eye(6)),
    "a stiffness of zero": (np.diag([1.0, 2.0, 3.0]), np.zeros((3, 3)), np.diag([0.0, 4.0, 1.0])),
    "a stiffness of zero, damped": (np.diag([1.0, 2.0, 3.0]), np.diag([1.0, 2.0, 3.0]), np.diag([0.0, 4.0, 1.0])),
    "damped in proportion": (np.eye(6), 0.1 * chain(6) + 0.2 * np.eye(6), chain(6)),
    "critically damped": (np.eye(3), np.diag([2.0, 4.0, 0.0]), np.diag([1.0, 4.0, 9.0])),
    "overdamped": (np.eye(6), 30.0 * np.eye(6), chain(6)),
    "negative damping": (np.eye(6), -0.1 * chain(6), chain(6)),
}


@pytest.mark.parametrize("name", CASES)
def test_modes_make_the_motion(name):
    check(*CASES[name])


def test_weak_damping_of_a_heavy_part_is_seen_beside_a_light_and_stiff_one():
    """Each coupling by dampers counts beside the modes that it couples: here 1e-3 beside 1e9."""
    M, K = np.diag([1.0, 1.0, 1e-6]), np.diag([2.0, 2.0, 1e6])
    K[0, 1] = K[1, 0] = -1.0
    assert modes(M, np.diag([2e-3, 0.0, 1e3]), K) is None


@pytest.mark.parametrize("ratio", [1e4, 1e10])
def test_slow_modes_beside_stiff_ones_keep_their_digits(ratio):
    """Pairs of masses on stiff springs, joined by soft ones: eigenvalues of the matrix as it is, in fifty digits.

    The eigenvectors are off by about EPS times the ratio of the eigenvalues, the quotients by the square of that.
    """
    springs = np.where(np.arange(9) % 2, ratio, 1.0)
    K = np.diag(springs[:-1] + springs[1:]) - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1)
    with mpmath.workdps(50):
        exact = np.array([float(value) for value in mpmath.eigsy(mpmath.matrix(K.tolist()), eigvals_only=True)])
    found = modes(np.eye(8), np.zeros((8, 8)), K)
    rates = np.sort([block[0, 1] for block in found.blocks])
    assert np.abs(rates**2 / np.sort(exact) - 1).max() <= 1e-13 + (4 * EPS * ratio) ** 2


def test_a_slow_decay_of_an_overdamped_mode_keeps_its_digits():
    """x'' + 1e6 x' + x = 0 from (1, 0): the slow zero is -1e-6 (1 + 1e-12 + 2e-24 ...)."""
    found = modes([[1.0]], [[1e6]], [[1.0]])
    times = np.array([1.0, 1e6, 3e6])
    x = (found.basis @ block_states(found.blocks, found.inverse @ np.array([1.0, 0.0]), times))[0]
    with mpmath.workdps(40):
        root = mpmath.sqrt(mpmath.mpf(1e12) - 4)
        slow, fast = (-mpmath.mpf(1e6) + root) / 2, (-mpmath.mpf(1e6) - root) / 2
        exact = [float((slow * mpmath.exp(fast * t) - fast * mpmath.exp(slow * t)) / (slow - fast)) for t in times]
    assert np.abs(x / exact - 1).max() <= 20 * EPS


def test_congruence_is_rounded_once():
    random = np.random.default_rng(0)
    X, A = random.standard_normal((6, 6)), random.standard_normal((6, 6)) * np.geomspace(1, 1e8, 6)
    exact = np.array(list(map(Fraction, X.ravel().tolist()))).reshape(6, 6)
    expected = (exact.T @ np.array(list(map(Fraction, A.ravel().tolist()))).reshape(6, 6) @ exact).astype(float)
    assert np.abs(congruence(X, A) - expected).max() <= 1e-15 * np.abs(expected).max()
    close = X - X[:, ::-1] * 2.0**-30  # what cancels is right, too
    assert np.abs(congruence(close, A - A.T)).diagonal().max() <= 1e-25 * np.abs(A).max()


def test_the_slowest_modes_of_a_beam_have_all_digits():
    """K of a chain to the fourth power has the spread of a fine beam, 1e10; its least eigenvalues by mpmath to 40 digits."""
    n = 14
    chain = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    K = np.rint(np.linalg.matrix_power(chain, 5))
    mp.dps = 40
    values = sorted(mp.eigsy(mp.matrix(K.tolist()), eigvals_only=True))
    shapes, stiffness, _ = refined_modes(np.eye(n), np.zeros((n, n)), K, scipy.linalg.eigh(K)[1])
    assert values[-1] / values[0] > 1e8
    errors = [abs(mpf(float(k)) / value - 1) for k, value in zip(np.sort(stiffness), values)]
    assert max(errors) <= 1e-14
    assert np.abs(shapes.T @ shapes - np.eye(n)).max() <= 1e-14


def test_modes_of_equal_rates_are_refined_together():
    """Two like beams, coupled by nothing: rates are double."""
    n = 10
    chain = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    K = np.kron(np.eye(2), np.rint(np.linalg.matrix_power(chain, 4)))
    shapes, stiffness, _ = refined_modes(np.eye(2 * n), np.zeros((2 * n, 2 * n)), K, scipy.linalg.eigh(K)[1])
    once = np.sort(stiffness)[0::2]
    assert np.allclose(np.sort(stiffness)[1::2], once, rtol=1e-13, atol=0)
    assert np.allclose(once, np.sort((2 - 2 * np.cos(np.arange(1, n + 1) * np.pi / (n + 1))) ** 4), rtol=1e-13, atol=0)
    assert np.abs(shapes.T @ shapes - np.eye(2 * n)).max() <= 1e-14
