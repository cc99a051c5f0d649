"""Rotors in closed form: one disc, a gyroscope, coupled planes; critical speeds against precise arithmetic; limits of stability."""

from pathlib import Path

import mpmath
import numpy as np
import pytest

import mbconstrained as mb

SKEW = np.array([[0.0, 1.0], [-1.0, 0.0]])


def disc(ratio, stiffness=(4.0, 4.0), **more):
    """Tilts of a disc of diametral inertia 1 and polar inertia ``ratio`` on springs."""
    return mb.MechanicalSystem(np.eye(2), stiffness=np.diag(stiffness), gyroscopic=ratio * SKEW, **more)


def random_rotor(size, seed, damping=0.0, anisotropy=0.3):
    """Discs on a shaft with different stiffness in both planes: M, C, K, G."""
    random = np.random.default_rng(seed)
    chain = 2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)
    K = np.kron(chain * random.uniform(1, 3), np.diag([1.0, 1.0 + anisotropy]))
    M = np.diag(np.repeat(random.uniform(0.5, 2.0, size), 2))
    return M, damping * K, K, np.kron(np.diag(random.uniform(0.1, 0.45, size)), SKEW)


def test_frequencies_of_a_disc_on_equal_springs():
    """w = +-p W / 2 + sqrt(k + (p W / 2)^2) for inertias 1 and p (Genta 2005, section 2.6)."""
    speeds = np.linspace(0.0, 6.0, 25)
    diagram = disc(1.6).campbell(speeds)
    assert diagram.directions == ("backward", "forward")
    half = 0.8 * speeds
    expected = np.sqrt(4 + half**2)[:, None] + np.array([-1.0, 1.0]) * half[:, None]
    np.testing.assert_allclose(diagram.damped_frequencies, expected, rtol=1e-12)
    np.testing.assert_allclose(diagram.whirl, np.tile([-1.0, 1.0], (25, 1)), atol=1e-7)
    assert (diagram.slopes[:, 1].imag > 0).all() and (diagram.slopes[:, 0].imag < 0).all()
    assert not diagram.stability_margins.any()


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("ratio", [0.4, 1.6])
def test_critical_speeds_of_a_disc(ratio, order):
    """k = n^2 W^2 (1 -+ p / n): no forward critical speed of the order n where p > n."""
    expected = sorted(2 / order / np.sqrt(1 + sign * ratio / order) for sign in (1, -1) if 1 + sign * ratio / order > 0)
    np.testing.assert_allclose(disc(ratio).critical_speeds(order), expected, rtol=1e-14)


def test_a_free_gyroscope_precesses():
    """Without springs the tilts have w = p W and 0; with one free translation at the same time."""
    free = mb.MechanicalSystem(np.eye(3), gyroscopic=np.pad(1.5 * SKEW, (0, 1)))
    diagram = free.campbell([0.0, 1.0, 2.0])
    np.testing.assert_allclose(diagram.damped_frequencies, [[0.0], [1.5], [3.0]], atol=1e-12)
    assert len(free.critical_speeds()) == 0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_critical_speeds_against_precise_arithmetic(seed):
    """K x = w^2 (M - i G / n) x with 40 digits."""
    M, C, K, G = random_rotor(4, seed)
    system = mb.MechanicalSystem(M, C, K, gyroscopic=G)
    with mpmath.workdps(40):
        values = mpmath.eig((mpmath.matrix(M) - 1j * mpmath.matrix(G)) ** -1 * mpmath.matrix(K), right=False)
        expected = sorted(float(mpmath.sqrt(value.real)) for value in values if value.real > 0)
    np.testing.assert_allclose(system.critical_speeds(), expected, rtol=1e-13)


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.2])
def test_critical_speeds_are_where_branches_meet_the_line(damping):
    """Each critical speed is on a branch of the diagram, and each branch that changes sides of the line has one."""
    M, C, K, G = random_rotor(3, 5, damping)
    system = mb.MechanicalSystem(M, C, K, gyroscopic=G)
    critical = system.critical_speeds()
    for speed in critical:
        assert np.abs(system.at_speed(speed).modes().eigenvalues.imag - speed).min() < 1e-9
    diagram = system.campbell(np.linspace(0.0, 8.0, 81))
    above = diagram.damped_frequencies > diagram.speeds[:, None]
    assert np.abs(np.diff(above.astype(int), axis=0)).sum() == (critical < 8.0).sum()
    assert {point.order for point in diagram.critical_speeds()} == {1.0}
    ratios = [point.damping_ratio for point in diagram.critical_speeds()]
    assert all(ratio > 0 for ratio in ratios) if damping else not any(ratios)


def test_rows_and_massless_coordinates_leave_critical_speeds():
    """A disc whose tilts are given twice by constraint rows, and one whose springs act through massless joints, in series with others."""
    twice = mb.MechanicalSystem(
        np.diag([1.0, 1.0, 0.0, 0.0]),
        stiffness=np.diag([0.0, 0.0, 4.0, 4.0]),
        gyroscopic=np.pad(0.4 * SKEW, (0, 2)),
        constraints=[mb.Constraint([1, 0, -1, 0], level="acceleration"), mb.Constraint([0, 1, 0, -1], level="position")],
    )
    np.testing.assert_allclose(twice.critical_speeds(), disc(0.4).critical_speeds(), rtol=1e-12)
    joint = np.array([[8.0, 0, -8, 0], [0, 8, 0, -8], [-8, 0, 16, 0], [0, -8, 0, 16]])
    series = mb.MechanicalSystem(np.diag([1.0, 1.0, 0.0, 0.0]), stiffness=joint, gyroscopic=np.pad(0.4 * SKEW, (0, 2)))
    np.testing.assert_allclose(series.critical_speeds(), disc(0.4).critical_speeds(), rtol=1e-10)
    frequencies = series.campbell([0.0, 1.0, 2.0]).damped_frequencies
    np.testing.assert_allclose(frequencies, disc(0.4).campbell([0.0, 1.0, 2.0]).damped_frequencies, rtol=1e-10)


@pytest.mark.parametrize("internal", [0.1, 0.5])
def test_rotating_damping_makes_a_shaft_unstable(internal):
    """m z'' + (c + c_i) z' + (k - i W c_i) z = 0, z = y + i x: stable below W = sqrt(k / m) (1 + c / c_i) (Genta 2005, section 3.5)."""
    external, C = 0.2, np.eye(2)
    shaft = mb.MechanicalSystem(np.eye(2), (external + internal) * C, 9 * np.eye(2), circulatory=-internal * SKEW)
    limit = 3.0 * (1 + external / internal)
    diagram = shaft.campbell(np.linspace(0.0, 2 * limit, 7))
    np.testing.assert_allclose(diagram.stability_limits, [limit], rtol=1e-12)
    assert (np.sign(diagram.stability_margins) == np.sign(limit - diagram.speeds))[diagram.speeds != limit].all()


def test_at_speed_is_the_system_with_the_matrices_of_that_speed():
    M, C, K, G = random_rotor(2, 8, 0.05)
    rotor = mb.MechanicalSystem(M, C, K, gyroscopic=G)
    np.testing.assert_array_equal(rotor.at_speed(3.0).damping, C + 3.0 * G)
    np.testing.assert_allclose(
        np.sort(rotor.campbell([1.0, 3.0]).natural_frequencies[1]), rotor.at_speed(3.0).modes().natural_frequencies, rtol=1e-10
    )
    np.testing.assert_array_equal(rotor.damping, C)


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda: mb.MechanicalSystem(np.eye(2), stiffness=np.eye(2)).critical_speeds(), "does not depend on a speed"),
        (lambda: disc(0.4).campbell([1.0]), "two or more"),
        (lambda: disc(0.4).campbell([2.0, 1.0]), "ascending"),
        (lambda: disc(0.4).critical_speeds(0), "positive"),
        (lambda: mb.MechanicalSystem(np.eye(2), gyroscopic=np.eye(3)), "gyroscopic"),
    ],
)
def test_what_is_wrong_is_named(call, message):
    with pytest.raises(mb.InputError, match=message):
        call()


@pytest.fixture(scope="module")
def large_rotor():
    """A rotor of 42 coordinates; its critical speeds by mpmath, 40 digits, K x = w^2 (M - i G) x."""
    with np.load(Path(__file__).parents[1] / "oracles" / "rotor_example.npz") as data:
        return {name: data[name] for name in data.files}


def test_the_critical_speeds_of_a_large_rotor(large_rotor):
    M, K, G, expected = (large_rotor[name] for name in ("M", "K", "G", "critical_speeds"))
    np.testing.assert_allclose(mb.MechanicalSystem(M, stiffness=K, gyroscopic=G).critical_speeds(), expected, rtol=1e-12)


def test_no_mode_of_a_large_rotor_is_swapped(large_rotor):
    """Coarse and fine speeds have the same branches; every branch that passes the line W has a critical speed; all eigenvalues are there."""
    M, K, G, critical = (large_rotor[name] for name in ("M", "K", "G", "critical_speeds"))
    rotor = mb.MechanicalSystem(M, stiffness=K, gyroscopic=G)
    speeds = np.linspace(0.0, 1.1 * critical[7], 101)
    fine, coarse = rotor.campbell(speeds), rotor.campbell(speeds[::20])
    np.testing.assert_allclose(fine.damped_frequencies[::20], coarse.damped_frequencies, rtol=1e-9)
    above = fine.damped_frequencies > speeds[:, None]
    assert np.abs(np.diff(above[1:].astype(int), axis=0)).sum() == (critical < speeds[-1]).sum()
    n, W = len(M), speeds[50]
    first_order = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -W * np.linalg.solve(M, G)]])
    values = np.linalg.eigvals(first_order)
    expected = np.sort(values.imag[values.imag > 1.0])  # free motions of eigenvalue 0 are none of the branches
    np.testing.assert_allclose(np.sort(fine.damped_frequencies[50]), expected, rtol=1e-6)
