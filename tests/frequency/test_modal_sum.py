"""Sums over modes of large symmetric matrices against solutions of the equations themselves."""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.frequency.frequency_response import MODAL_SIZE, SUM_LINES
from mbconstrained.frequency.pole_residue_form import ModalSum


def matrices(n, free=False, structural=0.0):
    """Full symmetric matrices with frequencies over two decades and light damping that modes do not separate; the first free."""
    random = np.random.default_rng(n)
    Q = np.linalg.qr(random.standard_normal((n, n)))[0]
    squares = np.geomspace(1.0, 1e4, n)
    squares[0] *= not free
    K = Q * squares @ Q.T
    G = random.standard_normal((n, n))
    M = np.eye(n) + 0.1 * G @ G.T / n
    K = (K + K.T) / 2
    return K * (1 + 1j * structural) if structural else K, 0.02 * Q * np.sqrt(squares) @ Q.T + 1e-3 * (G + G.T), (M + M.T) / 2


@pytest.mark.parametrize(("free", "structural"), [(False, 0.0), (True, 0.0), (False, 0.03)])
def test_values_of_the_sum_are_solutions(free, structural):
    K, C, M = matrices(30, free, structural)
    B = np.eye(30)[:, :2]
    total = ModalSum.of(np.array([K, C, M]), B, B[:, ::-1].T)
    w = np.geomspace(0.05, 300.0, 9)
    values, sizes = total.values(1j * w)
    for line, omega in enumerate(w):
        X = np.linalg.solve(K + 1j * omega * C - omega**2 * M, B)  # A is symmetric: the left solutions are X, too
        terms = np.abs(X.T) @ (np.abs(K) + omega * np.abs(C) + omega**2 * np.abs(M)) @ np.abs(X)
        difference = np.abs(values[..., line] - X[[1, 0]])
        assert (difference <= 1e-11 * sizes[..., line] + 4 * len(K) * np.finfo(float).eps * terms[[1, 0]]).all()


def test_other_matrices_have_no_such_sum():
    K, C, M = matrices(5)
    B = np.eye(5)[:, :1]
    assert ModalSum.of(np.array([K + np.triu(K), C, M]), B, B.T) is None
    assert ModalSum.of(np.array([K, C, np.diag([1.0, 1.0, 1.0, 1.0, 0.0])]), B, B.T) is None
    assert ModalSum.of(np.array([K, M]), B, B.T) is None


def test_errors_of_full_models_are_covered_by_their_estimates():
    n = MODAL_SIZE + 10
    K, C, M = matrices(n)
    f = np.geomspace(0.01, 60.0, SUM_LINES + 10)
    H = mb.MechanicalSystem(M, C, K).frequency_response(f, ["x1", "x2"], ["x3", "x1"])
    at = np.arange(0, len(f), 7)
    few = mb.MechanicalSystem(M, C, K).frequency_response(f[at], ["x1", "x2"], ["x3", "x1"])  # refined solutions
    assert few.error_estimate.max() <= 1e-10 and H.error_estimate.max() <= 1e-9
    difference = np.abs(H.values[..., at] - few.values)
    assert (difference <= (H.error_estimate[..., at] + few.error_estimate) * np.abs(few.values)).all()
