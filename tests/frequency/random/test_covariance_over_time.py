"""Covariances after noise is switched on, entry by entry against the exponential of Van Loan (1978) in ball arithmetic of the exact data."""

from fractions import Fraction

import flint
import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.frequency.random import nonstationary

RATIOS = (0.0, 1e-6, 1e-2, 1.0, 10.0)


def chain(n: int, stiffness: float = 1.0) -> np.ndarray:
    return stiffness * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))


def graded(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Damping from 0 to 10, couplings down to 1e-16, stiffness ratios up to 1e12."""
    rng = np.random.default_rng(seed)
    n, coupling = int(rng.integers(2, 4)), 10.0 ** -rng.uniform(0, 16)
    K = np.diag(rng.uniform(1, 5, n)) + coupling * chain(n)
    if seed % 3 == 1:
        D = np.diag(10.0 ** rng.uniform(-3, 3, n))
        K = D @ K @ D
    damping = RATIOS[seed % 5]
    return np.diag(rng.uniform(0.5, 2, n)), damping * (np.eye(n) if seed % 2 else K / np.abs(K).max()), K


def exact_covariance(M, C, K, time: float) -> np.ndarray:
    """Of the displacements under white noise of intensity 1 on the first coordinate; M regular."""
    n, before = len(M), flint.ctx.prec

    def rational(matrix) -> flint.fmpq_mat:
        return flint.fmpq_mat([[flint.fmpq(*Fraction(float(entry)).as_integer_ratio()) for entry in row] for row in matrix])

    inverse = rational(M).inv()
    right, zero, unit = (inverse * rational(part) for part in (C, np.zeros((n, n)), M))
    left = inverse * rational(K)
    A = [[*zero.table()[i], *unit.table()[i]] for i in range(n)]
    A += [[*(-entry for entry in left.table()[i]), *(-entry for entry in right.table()[i])] for i in range(n)]
    b = [flint.fmpq(0)] * n + [inverse[i, 0] for i in range(n)]
    N, t, bits = 2 * n, flint.fmpq(*float(time).as_integer_ratio()), 400
    rows = [[-entry for entry in A[i]] + [b[i] * b[j] / 2 for j in range(N)] for i in range(N)]
    rows += [[flint.fmpq(0)] * N + [A[j][i] for j in range(N)] for i in range(N)]
    try:
        while True:
            flint.ctx.prec = bits
            E = (flint.arb_mat(flint.fmpq_mat(rows) * t)).exp()
            P = [[sum((E[N + k, N + i] * E[k, N + j] for k in range(N)), flint.arb(0)) for j in range(n)] for i in range(n)]
            if all(P[i][i].rel_accuracy_bits() > 200 for i in range(n)):  # 60 digits
                return np.array([[float(entry) for entry in row] for row in P])
            bits *= 2
    finally:
        flint.ctx.prec = before


def relative_errors(R, models, times) -> np.ndarray:
    exact = np.array([exact_covariance(*models, time) for time in times])
    sizes = np.sqrt(exact.diagonal(axis1=1, axis2=2))
    return np.abs(R.covariance_over_time(times) - exact) / (sizes[:, :, None] * sizes[:, None, :])


@pytest.mark.parametrize(
    ("model", "times"),
    [
        ((np.eye(2), 0.02 * np.eye(2), np.eye(2) + 1e-3 * np.array([[1.0, -1.0], [-1.0, 1.0]])), [0.1, 1.0, 10.0]),
        ((np.eye(3), chain(3), chain(3, 100.0)), [1e-3, 1e-2, 0.1, 1.0]),
        ((np.eye(4), chain(4, 100.0), chain(4, 1e6)), [1e-5, 1e-4, 1e-3, 1e-2]),
    ],
    ids=["weak coupling", "three masses", "stiff chain"],
)
def test_variances_of_masses_far_from_the_noise(model, times):
    """Shortly after the start they are smaller by any number of orders of magnitude; float64 alone has negative ones."""
    R = mb.MechanicalSystem(*model).random_response({"x1": mb.white_noise(1.0)})
    assert relative_errors(R, model, times).max() <= 1e-12
    assert R.covariance_over_time_error_estimate(times).max() <= 1e-12


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("work", [None, 0], ids=["exact engine", "float64"])
def test_estimates_contain_the_errors(seed, work, monkeypatch):
    """Every entry, with the exact engine and as in larger models without it; no variance is negative."""
    if work is not None:
        monkeypatch.setattr(nonstationary, "MOST_PROVED_WORK", work)
    for own in range(seed, 30, 6):
        model, times = graded(own), 10.0 ** np.random.default_rng(own).uniform(-6, 3, 3)
        R = mb.MechanicalSystem(*model).random_response({"x1": mb.white_noise(1.0)})
        errors, estimates = relative_errors(R, model, times), R.covariance_over_time_error_estimate(times)
        assert (errors <= 3 * np.maximum(estimates, 1e-15)).all()  # estimates, no bounds
        assert (R.covariance_over_time(times).diagonal(axis1=1, axis2=2) >= 0).all()
        if work is None:
            assert estimates.max() <= 1e-12


def test_exact_covariances_are_those_of_modes(monkeypatch):
    """Two algorithms: with a singular mass matrix and a constraint, filters, coherence, initial values and a modulation."""
    K, L = np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 4.0]]), np.random.default_rng(1).standard_normal((6, 6))
    times, modulation = [0.1, 2.0, 30.0], [(1.0, 0.5), (-0.7, 3.0)]
    constraint = mb.Constraint([1.0, -1.0, 0.0])
    noise, filtered = mb.white_noise(1.0), mb.rational_spectrum(1.3, [1.0, 2.0], [1.0, 0.5, 4.0])
    responses = [
        mb.MechanicalSystem(np.diag([1.0, 0.0, 0.5]), 0.1 * K, K, [constraint]).random_response({"x1": noise}),
        mb.MechanicalSystem(np.diag([1.0, 0.0, 0.5]), 0.1 * K, K).random_response({"x1": noise}),
        mb.MechanicalSystem(np.eye(3), 0.1 * K, K).random_response({"x1": filtered, "x2": noise}),
        mb.MechanicalSystem(np.eye(3), 0.1 * K, K).random_response({"x1": noise, "x3": noise}, coherence=0.25),
    ]
    arguments = [(None, None), (None, modulation), (None, modulation), (L @ L.T, modulation)]
    rough = [R.covariance_over_time(times, *own) for R, own in zip(responses, arguments)]
    monkeypatch.setattr(nonstationary, "PROVED_ACCURACY", 0.0)
    for R, own, values in zip(responses, arguments, rough):
        exact = R.covariance_over_time(times, *own)
        assert np.abs(values - exact).max() <= 1e-12 * np.abs(exact).max()
        assert R.covariance_over_time_error_estimate(times, *own).max() <= 1e-15
