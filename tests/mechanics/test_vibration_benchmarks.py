"""Published benchmarks: the harmonic and the random test 5H and 5R of NAFEMS on finite elements of our own, stop bands of long chains."""

import mpmath as mp
import numpy as np
import pytest

import mbconstrained as mb
from tests.frequency.references import relative_error

E, POISSON, DENSITY, LENGTH, SIDE, LOAD = 200e9, 0.3, 8000.0, 10.0, 2.0, 1e6


def deep_beam(count):
    """NAFEMS test 5: a simply supported beam of 10 m, 2 m x 2 m; exact static Timoshenko elements with consistent masses.

    The shape functions are those of Friedman and Kosmatka (1993), the shear factor that of Cowper (1966) for a square; Rayleigh
    damping 5.36 M + 7.46e-5 K (test 5H), 2 % in the first mode.
    """
    A, inertia, length = SIDE**2, SIDE**4 / 12, LENGTH / count
    factor = 10 * (1 + POISSON) / (12 + 11 * POISSON)
    shear = 12 * E * inertia / (factor * E / (2 * (1 + POISSON)) * A * length**2)
    polynomials = [
        np.array(
            [
                [1 + shear, -shear, -3, 2],
                np.array([0, 1 + shear / 2, -2 - shear / 2, 1]) * length,
                [0, shear, 3, -2],
                np.array([0, -shear / 2, shear / 2 - 1, 1]) * length,
            ]
        )
        / (1 + shear),
        np.array([[0, -6 / length, 6 / length], [1 + shear, -4 - shear, 3], [0, 6 / length, -6 / length], [0, shear - 2, 3]])
        / (1 + shear),
    ]
    points, weights = np.polynomial.legendre.leggauss(5)
    points, weights = (points + 1) / 2, weights * length / 2
    w, turn = (np.polynomial.polynomial.polyval(points, part.T) for part in polynomials)
    curvature = (
        np.polynomial.polynomial.polyval(points, np.array([np.polynomial.polynomial.polyder(row) for row in polynomials[1]]).T)
        / length
    )
    slope = (
        np.polynomial.polynomial.polyval(points, np.array([np.polynomial.polynomial.polyder(row) for row in polynomials[0]]).T)
        / length
    )
    strain = slope - turn
    k = E * inertia * (curvature * weights) @ curvature.T + 12 * E * inertia / (shear * length**2) * (strain * weights) @ strain.T
    m = DENSITY * (A * (w * weights) @ w.T + inertia * (turn * weights) @ turn.T)
    n = 2 * (count + 1)
    K, M, force = np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
    for at in range(0, n - 2, 2):
        K[at : at + 4, at : at + 4] += k
        M[at : at + 4, at : at + 4] += m
        force[at : at + 4] += LOAD * w @ weights
    names = [f"{kind}{i}" for i in range(count + 1) for kind in ("w", "turn")]
    supports = [mb.Constraint(np.eye(n)[[0, n - 2]], names=["left", "right"])]
    system = mb.MechanicalSystem(M, None, (K + K.T) / 2, supports, names).with_rayleigh_damping(5.36, 7.46e-5)
    return system, force, curvature_at_ends(polynomials[1]) / length


def curvature_at_ends(polynomial):
    """d turn / d xi at both ends by the four coordinates of an element."""
    derivatives = np.array([np.polynomial.polynomial.polyder(row) for row in polynomial])
    return np.array([derivatives.sum(axis=1), derivatives[:, 0]])


@pytest.mark.long
def test_nafems_5h_deep_simply_supported_beam_under_a_harmonic_load():
    """NAFEMS R0016: 13.45 mm and 241.9 MPa at 42.65 Hz. Programs agree with these to 0.5 %, with the frequency to 0.1 %."""
    count = 24
    system, force, curvature = deep_beam(count)
    middle = count // 2
    frequencies = np.linspace(42.5, 42.8, 16)
    steady = [system.steady_state(mb.harmonic(force, frequency_hz=f)).deflection_shape(f) for f in frequencies]
    peak = np.argmax([abs(shape[2 * middle]) for shape in steady])
    shape = steady[peak][2 * middle - 2 : 2 * middle + 4]
    bending = (curvature[1] @ shape[:4] + curvature[0] @ shape[2:]) / 2
    assert abs(frequencies[peak] / 42.65 - 1) <= 1e-3
    assert abs(abs(shape[2]) * 1e3 / 13.45 - 1) <= 5e-3
    assert abs(E * abs(bending) * SIDE / 2 / 1e6 / 241.9 - 1) <= 5e-3
    reaction = np.einsum("ijf,j->if", system.frequency_response([0.0], list(system.names), quantity="reaction").values, force)
    np.testing.assert_allclose(reaction[:, 0], -LOAD * LENGTH / 2, rtol=1e-8)  # at rest each support has half of the load


def test_nafems_5r_deep_simply_supported_beam_under_a_random_load():
    """NAFEMS R0016, also ANSYS VM19: 180.90 mm^2/Hz and 58516 (N/mm^2)^2/Hz at 42.65 Hz under 1e6 N/m with a unit white spectrum, fully correlated.

    Programs differ from these by 1 % (Ansys, PTC, Abaqus) and by up to 2.7 % in the stress; here 0.5 % and 0.2 %, with loads at the nodes.
    """
    count, f = 36, np.linspace(42.5, 42.8, 16)
    system, force, curvature = deep_beam(count)
    loads = {f"w{i}": mb.psd([1, 1000], [force[2 * i] ** 2] * 2) for i in range(1, count)}
    middle = [f"{kind}{i}" for i in range(count // 2 - 1, count // 2 + 2) for kind in ("w", "turn")]
    spectra = system.random_response(loads, middle, coherence=1.0).cross_psd(f)
    bending = (np.pad(curvature[1], (0, 2)) + np.pad(curvature[0], (2, 0))) / 2 * E * SIDE / 2
    deflection, stress = spectra[2, 2].real, np.einsum("i,ijf,j->f", bending, spectra, bending).real
    assert abs(f[deflection.argmax()] / 42.65 - 1) <= 1e-3
    assert abs(deflection.max() * 1e6 / 180.90 - 1) <= 1e-2
    assert abs(stress.max() / 1e12 / 58516 - 1) <= 1e-2


@pytest.mark.parametrize("count", [10, 30, 60])
def test_stop_band_of_chains_of_masses(count):
    """From the first to the last mass of a chain that is fixed at its first spring: 1 / prod (s^2 + 4 sin^2((2 k - 1) pi / (4 n + 2))).

    The cofactor of the corner of a tridiagonal matrix is the product of its couplings, here 1, and the determinant is that of the modes.
    """
    K = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    K[-1, -1] = 1.0
    system = mb.MechanicalSystem(np.eye(count), None, K)
    frequencies = np.array([0.01, 0.5, 1.0, 3.0])
    H = system.frequency_response(frequencies, ["x1"], [f"x{count}"])
    for f, value, estimate in zip(frequencies, H.values[0, 0], H.error_estimate[0, 0]):
        with mp.workdps(60):
            w = 2 * mp.pi * mp.mpf(float(f))
            squares = [4 * mp.sin((k - mp.mpf(1) / 2) * mp.pi / (2 * count + 1)) ** 2 for k in range(1, count + 1)]
            exact = 1 / mp.fprod(square - w**2 for square in squares)
        assert relative_error(value, exact) <= max(estimate, 2e-16) <= 1e-10
