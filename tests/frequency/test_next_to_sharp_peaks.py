"""Lines next to sharp peaks, where a solution of A(i w) x = b has few digits: against 60 digits, data and frequency taken exactly."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import scipy.linalg

import mbconstrained as mb


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


@pytest.mark.parametrize("damping", [1e-9, 1e-3])
def test_springs_of_a_model_keep_their_digits_on_a_peak(damping):
    """Soft springs to the ground next to a stiff one: what rounding takes of 1000.3 + 0.1 moves the peak by more than its width."""
    model = mb.LumpedModel()
    model.mass("a", 2.3)
    model.mass("b", 0.7)
    model.spring("ground", "a", 0.1)
    model.spring("a", "b", 1000.3)
    model.spring("ground", "b", 0.2)
    model.damper("a", "b", damping)
    system = model.assemble()
    line = float(system.modes().frequencies_hz[0])
    H = system.frequency_response([line], ["a"], ["a"])
    with mpmath.workdps(50):
        w = 2 * mpmath.pi * mpmath.mpf(line)
        k = mpmath.mpf(1000.3) + 1j * w * mpmath.mpf(damping)
        rows = [[mpmath.mpf(0.1) + k - w**2 * mpmath.mpf(2.3), -k], [-k, mpmath.mpf(0.2) + k - w**2 * mpmath.mpf(0.7)]]
        true = complex((mpmath.matrix(rows) ** -1)[0, 0])
    assert abs(H.values.item() - true) <= H.error_estimate.item() * abs(true) and H.error_estimate.item() < 1e-14


def test_a_response_that_vanishes_does_not_hide_the_others():
    """x1 stays where the row 2 x1 = 0 holds, whatever acts on it; x2 alone is 1 / (k - m w^2)."""
    system = mb.MechanicalSystem(np.diag([0.0, 2.0]), stiffness=np.diag([1100187.3, 5.0]), constraints=[mb.Constraint([2.0, 0.0])])
    box = system.frequency_response([1.0]).enclose(1.0)
    assert abs(box.middle[0, 0]) < 1e-300 and abs(box.middle[0, 3] * (5 - 8 * np.pi**2) - 1) < 1e-14
