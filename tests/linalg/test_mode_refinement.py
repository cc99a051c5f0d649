"""Undamped modes of wide spread against exact arithmetic."""

from fractions import Fraction

import numpy as np
import scipy.linalg
from mpmath import mp, mpf

from mbconstrained.linalg.division import congruence
from mbconstrained.linalg.symmetric import refined_modes


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
