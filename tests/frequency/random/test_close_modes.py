"""Variances and spectral moments of close, weakly coupled and lightly damped modes: against the Lyapunov equation in rational arithmetic."""

import flint
import mpmath as mp
import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.frequency.random import random_response
from mbconstrained.linalg.precise import relative_degrees


def exact_covariance(M, C, K, intensity):
    """E[w w^T] of w = (x, x') by (S (x) I + I (x) S) vec P = -vec W, all floats taken as the rationals they are; M diagonal, white forces on all."""
    n = len(M)

    def rational(value):
        return flint.fmpq(*map(int, float(value).as_integer_ratio()))

    N = 2 * n
    S = [[flint.fmpq(int(j == i + n)) for j in range(N)] for i in range(n)]
    S += [
        [-rational(K[i, j]) / rational(M[i, i]) for j in range(n)] + [-rational(C[i, j]) / rational(M[i, i]) for j in range(n)]
        for i in range(n)
    ]
    A, b = flint.fmpq_mat(N * N, N * N), flint.fmpq_mat(N * N, 1)
    for i in range(N):
        for j in range(N):
            for k in range(N):
                A[N * i + j, N * k + j] += S[i][k]
                A[N * i + j, N * i + k] += S[j][k]
            if i == j >= n:
                b[N * i + j, 0] = -rational(intensity) / 2 / rational(M[i - n, i - n]) ** 2
    solution = A.solve(b)
    value = np.array([float(flint.arb(solution[N * i + i, 0]).mid()) for i in range(N)])
    return value[:n], value[n:]


def pair(coupling, damping):
    K = np.diag([3.0, 3.0])
    K[0, 1] = K[1, 0] = -0.37 * coupling
    return np.eye(2), np.diag([2.8, 2.3]) * damping, K


@pytest.mark.parametrize("coupling", [1e-1, 1e-4, 1e-8, 1e-16])
@pytest.mark.parametrize("damping", [3.0, 1e-3, 1e-7, 1e-13])
def test_variances_and_second_moments_of_close_modes(coupling, damping):
    M, C, K = pair(coupling, damping)
    system = mb.MechanicalSystem(M, C, K)
    R = system.random_response({name: mb.white_noise(1.0) for name in system.names})
    positions, velocities = exact_covariance(M, C, K, 1.0)
    for own, exact, error in (
        (R.moment(0), positions, R.moment_error_estimate(0)),
        (R.moment(2), velocities / (2 * np.pi) ** 2, R.moment_error_estimate(2)),
    ):
        assert (np.abs(own - exact) <= (error + 1e-15) * exact).all()
        assert error.max() <= 1e-12


@pytest.mark.parametrize("coupling", [1e-2, 1e-5, 1e-8])
@pytest.mark.parametrize("damping", [1e-3, 1e-6, 1e-9])
def test_estimates_without_the_exact_engine_contain_the_errors_of_close_modes(monkeypatch, coupling, damping):
    monkeypatch.setattr(random_response, "ALWAYS_PROVED", 0)
    monkeypatch.setattr(random_response, "MOST_PROVED", 0)
    M, C, K = pair(coupling, damping)
    system = mb.MechanicalSystem(M, C, K)
    R = system.random_response({name: mb.white_noise(1.0) for name in system.names})
    exact, _ = exact_covariance(M, C, K, 1.0)
    assert (np.abs(R.moment(0) - exact) <= 10 * R.error_estimate * exact).all()


def test_degrees_of_transfer_functions_are_those_of_the_data():
    """A chain: the k-th mass follows a force on the first with s^-(k + 1), however light the damping; without damping s^-2k."""
    n = 5
    K = 1e6 * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    for damping, degrees in ((1e-9, [2, 3, 4, 5, 6]), (0.0, [2, 4, 6, 8, 10])):
        own = relative_degrees(np.array([K, damping * K, np.eye(n)]), np.eye(n)[:, :1], np.eye(n))
        assert own[:, 0].tolist() == degrees
    massless = np.array([K, 1e-3 * K, np.diag([1.0, 0, 1, 1, 1])])
    assert relative_degrees(massless, np.eye(n)[:, 1:2], np.eye(n)[1:2]).item() == 1
    assert relative_degrees(np.array([np.eye(2), np.eye(2)]), np.eye(2)[:, :1], np.eye(2)[1:]).item() == np.inf


@pytest.mark.parametrize("coupling", [1e-8, 1e-12, 1e-14, 1e-16, 0.0])
def test_estimates_of_larger_models_contain_the_error_of_weak_couplings(coupling):
    """Two chains of six masses, against exact variances: noise on the one reaches the other by one soft spring, or not at all."""
    springs = np.array([1.0] * 5 + [coupling] + [1.0] * 5)
    links = np.diff(np.eye(12), axis=0)
    K = links.T @ np.diag(springs) @ links + np.diag(np.linspace(0.5, 1.0, 12))
    system = mb.MechanicalSystem(np.eye(12), 1e-3 * np.eye(12), K)
    R = system.random_response({f"x{i}": mb.white_noise(1.0) for i in (2, 3, 4, 5)}, ["x1", "x8"])
    if not coupling:
        assert R.rms[1] == R.error_estimate[1] == 0
        return
    exact = R.enclose().lower.astype(float)
    assert (np.abs(R.covariance.diagonal() - exact) <= R.error_estimate * exact).all()
    assert any("no digit" in notice.text for notice in R.notices) == (R.error_estimate[1] == np.inf)


def test_variances_are_those_of_the_springs_and_dampers_of_a_model():
    """135.31 + 0.46 N/m is rounded in the matrix, 0.46 N/m and its damper are not; variances by the Lyapunov equation in 50 digits."""
    model = mb.LumpedModel()
    model.mass("a", 1.0)
    model.mass("b", 2.5)
    model.spring("ground", "a", 0.46)
    model.spring("a", "b", 135.31)
    model.damper("ground", "a", 0.00085371)
    model.damper("a", "b", 0.25111944)
    response = model.assemble().random_response({"a": mb.white_noise(1.0), "b": mb.white_noise(2.0)})
    with mp.workdps(50):
        k, c = ([mp.mpf(value) for value in pair] for pair in ((0.46, 135.31), (0.00085371, 0.25111944)))
        rows = [[mp.mpf(0)] * 2 + [mp.mpf(i == j) for j in range(2)] for i in range(2)]
        for i, mass in enumerate((mp.mpf(1), mp.mpf(2.5))):
            rows.append(
                [-entry / mass for one in (k, c) for entry in ([one[0] + one[1], -one[1]] if i == 0 else [-one[1], one[1]])]
            )
        S, noise = mp.matrix(rows), mp.diag([0, 0, mp.mpf(1) / 2, mp.mpf(1) / mp.mpf(2.5) ** 2])
        equations, right = mp.zeros(16), mp.matrix(16, 1)
        for i in range(4):
            for j in range(4):
                right[4 * i + j] = -noise[i, j]
                for m in range(4):
                    equations[4 * i + j, 4 * m + j] += S[i, m]
                    equations[4 * i + j, 4 * i + m] += S[j, m]
        P = mp.lu_solve(equations, right)
        true = np.array([float(P[0]), float(P[5])])
    assert (np.abs(response.covariance.diagonal() / true - 1) <= response.error_estimate).all()
