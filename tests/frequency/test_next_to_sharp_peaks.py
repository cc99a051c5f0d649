"""Lines next to sharp peaks, where a solution of A(i w) x = b has few digits: against 60 digits, data and frequency taken exactly."""

import mpmath
import numpy as np
import pytest
import scipy.linalg

import mbconstrained as mb
from mbconstrained.frequency.frequency_response import MODAL_SIZE, SUM_LINES, ModalSum


def cantilever(count, length=1.0, E=2.1e11, rho=7850.0, width=0.02, height=0.01):
    """M and K of Euler-Bernoulli elements, clamped at the first node."""
    h = length / count
    bending, line = E * width * height**3 / 12 / h**3, rho * width * height * h / 420
    ke = bending * np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h * h, -6 * h, 2 * h * h],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h * h, -6 * h, 4 * h * h],
        ]
    )
    me = line * np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h * h, 13 * h, -3 * h * h],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
        ]
    )
    M, K = np.zeros((2, 2 * count + 2, 2 * count + 2))
    for i in range(count):
        at = slice(2 * i, 2 * i + 4)
        M[at, at] += me
        K[at, at] += ke
    return M[2:, 2:], K[2:, 2:]


def receptance(M, C, K, f, place):
    with mpmath.workdps(60):
        w, n = 2 * mpmath.pi * mpmath.mpf(f), len(M)
        A = mpmath.matrix(n, n)
        for i in range(n):
            for j in range(n):
                A[i, j] = mpmath.mpf(K[i, j]) - w * w * mpmath.mpf(M[i, j]) + 1j * w * mpmath.mpf(C[i, j])
        b = mpmath.matrix(n, 1)
        b[place] = 1
        return complex(mpmath.lu_solve(A, b)[place])


@pytest.mark.parametrize("damping", [0.0, 1e-12, 3e-9, 1e-5, 0.02])
@pytest.mark.parametrize("digits", [4, 9, 16])
def test_values_next_to_a_resonance_of_a_beam(damping, digits):
    M, K = cantilever(12)
    w = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[0])
    C, f = K * (2 * damping / w), float(np.round(w / 2 / np.pi, digits))
    system = mb.MechanicalSystem(M, C, K)
    tip = len(M) - 2
    H = system.frequency_response([f], [system.names[tip]], [system.names[tip]])
    exact = receptance(M, C, K, f, tip)
    assert abs(H.values.item() - exact) <= H.error_estimate.item() * abs(exact)
    assert H.error_estimate.item() <= 1e-9


@pytest.mark.parametrize(("ratio", "zeta"), [(1e6, 1e-9), (1e8, 1e-8), (1e10, 1e-6), (1e13, 1e-3)])
def test_stiff_links_in_turned_coordinates(ratio, zeta):
    c, s = np.cos(0.7), np.sin(0.7)
    R = np.array([[c, -s], [s, c]])
    K = R @ np.diag([1.0, ratio]) @ R.T
    K = (K + K.T) / 2
    C = K * 2 * zeta
    H = mb.MechanicalSystem(np.eye(2), C, K).frequency_response([1 / (2 * np.pi)], ["x1"], ["x1"])
    exact = receptance(np.eye(2), C, K, 1 / (2 * np.pi), 0)
    assert abs(H.values.item() - exact) <= max(H.error_estimate.item(), 1e-15) * abs(exact)


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
