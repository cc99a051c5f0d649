"""Modes: labels, frequencies, damping, shapes, drift."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.mechanics.constraints import Constraint
from mbconstrained.mechanics.modes import Conservation, cleaned
from mbconstrained.mechanics.system import MechanicalSystem
from tests.mechanics.systems import massless_joints, two_masses


def kinds(system):
    return [(mode.kind, mode.multiplicity) for mode in system.modes()]


def chain(count, m=2.0, k=3.0):
    """Equal masses between two walls, joined by equal springs."""
    return MechanicalSystem(m * np.eye(count), stiffness=k * (2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)))


@pytest.mark.parametrize("level, drift", [("position", 0), ("velocity", 1), ("acceleration", 2)])
def test_two_masses(level, drift):
    modes = two_masses(level).modes()
    assert modes.drift == drift
    # w = (5 -+ sqrt 5)/10, from the Smith form s^2 (s^4 + 3/5 s^2 + 1/25) (Moysis et al., Eq. 85 with m = 10, k = 2)
    assert np.allclose(modes.natural_frequencies, [(5 - 5**0.5) / 10, (5 + 5**0.5) / 10], rtol=1e-13)
    assert (modes.damping_ratios == 0).all()
    assert [mode.kind for mode in modes] == ["drift"] * (drift > 0) + ["oscillation"] * 2
    # shapes: both kinds of the first mass's coordinate agree, the distance from m w^2 (x1 + q2) = k q2
    for omega, shape in zip(modes.natural_frequencies, modes.shapes.T):
        assert np.isclose(np.abs(shape).max(), 1.0)
        assert np.allclose([shape[0] - shape[1], 10 * omega**2 * (shape[0] + shape[2]) - 2 * shape[2]], 0, atol=1e-13)


def test_massless_joints_have_an_offset():
    modes = massless_joints().modes()
    assert kinds(massless_joints()) == [("offset", 1), ("oscillation", 1)]
    # s^2 + 4/15 s + 1/5, from the Smith form (Moysis et al., Eq. 93)
    assert np.isclose(modes[1].eigenvalue, -2 / 15 + 1j * 41**0.5 / 15, rtol=1e-13)
    assert np.isclose(modes.natural_frequencies[0], 0.2**0.5)
    assert np.isclose(modes.damping_ratios[0], 2 / 15 / 0.2**0.5)
    assert np.allclose(modes[0].shapes, [[0], [1], [0]])  # the joint between the dampers stays where it is left
    assert np.allclose(modes.shapes[:, 0], [1 / 3, 1 / 3, 1])


@given(st.lists(st.sampled_from(["position", "velocity", "acceleration"]), min_size=0, max_size=3))
def test_drift_counts_the_levels(levels):
    system = chain(4)
    rows = [Constraint(np.eye(4)[i] - np.eye(4)[i + 1], level=level) for i, level in enumerate(levels)]
    tied = MechanicalSystem(system.mass, stiffness=system.stiffness, constraints=rows)
    orders = {"position": 0, "velocity": 1, "acceleration": 2}
    assert tied.modes().drift == sum(orders[level] for level in levels)
    # every zero of the polynomial matrix with its levels is among the labelled ones
    zeros = tied.polynomial_matrix().jordan_pairs().finite.zeros
    assert sum(mode.multiplicity * (2 if mode.eigenvalue.imag else 1) for mode in tied.modes()) == sum(z.count for z in zeros)
    assert len(tied.modes().natural_frequencies) == 4 - len(levels)


@pytest.mark.parametrize("count", [1, 2, 5, 12])
def test_chain_between_walls(count):
    # w_j = 2 sqrt(k/m) sin(j pi / (2 (n + 1))), shape sin(i j pi / (n + 1)) (any textbook on vibrations)
    modes = chain(count).modes()
    j = np.arange(1, count + 1)
    assert np.allclose(modes.natural_frequencies, 2 * 1.5**0.5 * np.sin(j * np.pi / (2 * (count + 1))), rtol=1e-12)
    sines = np.sin(np.outer(j, j) * np.pi / (count + 1))
    along = np.abs((modes.shapes * sines).sum(axis=0)) / np.linalg.norm(modes.shapes, axis=0) / np.linalg.norm(sines, axis=0)
    assert np.allclose(along, 1.0)
    assert modes.shapes.dtype == float


def test_free_bodies():
    free = MechanicalSystem(np.diag([1.0, 2.0]), stiffness=[[3, -3], [-3, 3]])
    assert kinds(free) == [("rigid body", 2), ("oscillation", 1)]
    rigid = free.modes()[0]
    assert np.allclose(rigid.shapes, [[1], [1]])
    assert "unconstrained" in rigid.text
    assert kinds(MechanicalSystem(np.eye(3))) == [("rigid body", 6)]


def test_a_damped_free_body_has_an_offset_and_a_decay():
    body = MechanicalSystem([[2.0]], damping=[[6.0]])
    assert kinds(body) == [("offset", 1), ("decay", 1)]
    assert np.isclose(body.modes()[1].eigenvalue, -3.0)
    assert body.modes()[1].text == "decay, time constant 0.333333 s"


def test_rigid_bodies_and_offsets_are_told_apart():
    both = MechanicalSystem(np.eye(2), damping=np.diag([0.0, 1.0]))
    rigid, offset = both.modes()[:2]
    assert (rigid.kind, rigid.multiplicity, offset.kind, offset.multiplicity) == ("rigid body", 2, "offset", 1)
    assert np.allclose(rigid.shapes, [[1], [0]])
    assert np.allclose(offset.shapes, [[0], [1]])


def test_critical_damping_is_one_double_zero():
    critical = MechanicalSystem([[1.0]], [[2.0]], [[1.0]])
    (mode,) = critical.modes()
    assert (mode.kind, mode.multiplicity) == ("decay", 2)
    assert np.isclose(mode.eigenvalue, -1.0)
    assert mode.shapes.shape == (1, 1)
    assert critical.modes().natural_frequencies.size == 0
    assert critical.modes().shapes.shape == (1, 0)


def test_a_defective_zero_has_fewer_shapes_than_its_multiplicity():
    pair = MechanicalSystem(np.eye(2), np.diag([2.0, 1.0]), np.diag([1.0, 9.0])).modes()
    double = [mode for mode in pair if mode.multiplicity == 2]
    assert len(double) == 1 and double[0].shapes.shape == (2, 1)
    assert np.allclose(double[0].shapes, [[1], [0]])


@pytest.mark.parametrize("seed", range(3))
def test_what_symmetry_rules_out_does_not_appear(seed):
    random = np.random.default_rng(seed)
    n = 12
    M, Q, G = (random.normal(size=(n, n)) for _ in range(3))
    M, Q, G = M @ M.T + np.eye(n), np.linalg.qr(Q)[0], G - G.T
    stiff = 10.0 ** random.uniform(-3, 6, n)  # soft and stiff springs: rounding leaves real parts of 1e-10 and more
    K, S = Q @ np.diag(stiff) @ Q.T, Q @ np.diag(stiff * np.resize([1, 1, -1], n)) @ Q.T
    free, spinning, unstable = (MechanicalSystem(M, C, stiffness).modes() for C, stiffness in ((None, K), (G, K), (None, S)))
    for modes in (free, spinning):  # lossless and stable: no real part at all
        assert {mode.kind for mode in modes} == {"oscillation"}
        assert (modes.damping_ratios == 0).all()
    assert all(mode.eigenvalue.real == 0 or mode.eigenvalue.imag == 0 for mode in unstable)  # s^2 is real
    assert {mode.kind for mode in unstable} == {"oscillation", "growth", "decay"}
    # omega^2 from the symmetric eigenproblem, an algorithm of its own
    assert np.allclose(free.natural_frequencies**2, scipy.linalg.eigh(K, M, eigvals_only=True), rtol=1e-6)


def test_computed_zeros_are_freed_of_what_cannot_be():
    anything, passive, reversible, both = (
        Conservation(p, q) for p, q in ((False, False), (True, False), (False, True), (True, True))
    )
    assert cleaned(1e-3 + 1j, 2, anything) == 1e-3 + 1j
    assert cleaned(1e-9 + 1j, 2, anything) == 1j  # less growth than the rounding of a double zero
    assert cleaned(1e-9 + 1j, 1, anything) == 1e-9 + 1j  # a simple zero is known better: this one grows
    assert cleaned(-1e-9 + 1j, 2, anything) == -1e-9 + 1j
    assert cleaned(-1e-17 + 1j, 1, anything) == 1j
    assert cleaned(1e-3 + 1j, 1, passive) == 1j
    assert cleaned(-1e-9 + 1j, 1, passive) == -1e-9 + 1j
    assert cleaned(1e-3 + 1j, 1, reversible) == 1j
    assert cleaned(1 + 1e-3j, 1, reversible) == 1
    assert cleaned(1e-9 + 0j, 1, both) == 0


def test_an_upside_down_pendulum_grows():
    modes = MechanicalSystem([[1.0]], stiffness=[[-4.0]]).modes()
    assert sorted((mode.kind, mode.eigenvalue.real) for mode in modes) == [
        ("decay", pytest.approx(-2.0)),
        ("growth", pytest.approx(2.0)),
    ]


def test_flutter_grows_and_oscillates():
    # unsymmetric stiffness (a follower force): s^2 = -2 +- i
    modes = MechanicalSystem(np.eye(2), stiffness=[[2, 1], [-1, 2]]).modes()
    growing = [mode for mode in modes if mode.kind == "growth"]
    assert len(growing) == 1
    assert np.isclose(growing[0].eigenvalue ** 2, -2 + 1j) or np.isclose(growing[0].eigenvalue ** 2, -2 - 1j)
    assert growing[0].text.startswith("growing oscillation at")
    assert growing[0].damping_ratio < 0


def test_gyroscopic_systems_are_undamped():
    # s^4 + (g^2 + 3) s^2 + 2 with g = 3
    modes = MechanicalSystem(np.eye(2), [[0, 3], [-3, 0]], np.diag([1.0, 2.0])).modes()
    squares = np.sort(-np.roots([1, 12, 2]).real)
    assert np.allclose(modes.natural_frequencies**2, squares)
    assert all(mode.eigenvalue.real == 0 for mode in modes)
    assert modes.shapes.dtype == complex


def test_a_stiff_lightly_damped_system_never_grows():
    stiff = MechanicalSystem(np.diag([1e-6, 1.0]), 1e-9 * np.array([[1, -1], [-1, 1]]), [[1e9, -1e9], [-1e9, 1e9 + 1]])
    assert {mode.kind for mode in stiff.modes()} == {"oscillation"}


@pytest.mark.parametrize("stiffness", [1e-12, 1e-16, 1e-19])
def test_a_very_soft_support_never_makes_growth(stiffness):
    # the square of its frequency is near or below the rounding of the other one
    system = MechanicalSystem(np.eye(3), stiffness=[[1 + stiffness, -1, 0], [-1, 2, -1], [0, -1, 1]])
    assert {mode.kind for mode in system.modes()} <= {"oscillation", "rigid body", "offset"}


def test_the_table_is_text():
    rows = two_masses().modes().table()
    assert rows[0] == {
        "kind": "drift",
        "eigenvalue (1/s)": "0",
        "frequency (Hz)": "",
        "natural frequency (rad/s)": "",
        "damping ratio": "",
        "multiplicity": "2",
        "meaning": "drift of constraint rows at velocity or acceleration level, no motion of the bodies",
    }
    assert rows[1]["frequency (Hz)"] == "0.0439893"  # (5 - sqrt 5)/(20 pi)
    assert rows[1]["natural frequency (rad/s)"] == "0.276393"
    assert rows[1]["damping ratio"] == "0"
    assert rows[1]["eigenvalue (1/s)"] == "± 0.276393 i"
    damped = massless_joints().modes().table()[1]
    assert damped["eigenvalue (1/s)"] == "-0.133333 ± 0.426875 i"
    assert damped["meaning"] == "oscillation at 0.0711763 Hz, damping ratio 0.2981"


def test_undetermined_motion_is_refused():
    with pytest.raises(mb.SingularPolynomialMatrix, match="x2"):
        MechanicalSystem(np.diag([1.0, 0.0])).modes()


def test_slow_growth_is_called_growth():
    # x'' - 2e-9 x' + x = 0: zeros 1e-9 +- i
    system = MechanicalSystem([[1.0]], [[-2e-9]], [[1.0]])
    assert [mode.kind for mode in system.modes()] == ["growth"]
    assert any(notice.kind == "unstable" for notice in system.solve([1.0]).notices)


@pytest.mark.parametrize("count, damped", [(1, True), (30, True), (30, False), (60, True)])
def test_residuals_are_rounding_errors_and_frequencies_those_of_lapack(count, damped):
    random = np.random.default_rng(count)
    A, B = (random.normal(size=(count, count)) for _ in range(2))
    M, K = A @ A.T + count * np.eye(count), B @ B.T + count * np.eye(count)
    C = np.diag(random.uniform(0.0, 1.0, count)) if damped else np.zeros((count, count))
    modes = MechanicalSystem(M, C, K).modes()
    first_order = np.block([[np.zeros_like(K), np.eye(count)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    values = np.linalg.eigvals(first_order)
    assert np.allclose(np.sort(np.abs(values[values.imag > 0])), modes.natural_frequencies, rtol=1e-10)
    assert modes.residuals.shape == (len(modes),) and modes.residuals.max() < 1e-13
    assert modes.shapes.dtype == (complex if damped and count > 1 else float)


def test_modes_and_motions_share_the_decoupled_equations():
    system = chain(30)
    modes, motion = system.modes(), system.solve(np.ones(30))
    assert modes.polynomial_matrix is motion.polynomial_matrix


@pytest.mark.parametrize("n", [4, 30])
def test_tiny_ground_springs_of_a_free_chain_are_data(n):
    """K 1 = g 1 exactly: all masses move together, and the motion of the others is reported as a decision without a clear gap."""
    K = np.diff(np.eye(n), axis=0).T @ np.diff(np.eye(n), axis=0) + 2.0**-47 * np.eye(n)
    system = MechanicalSystem(np.eye(n), stiffness=K)
    rate = 2.0**-23.5
    assert np.isclose(system.modes().natural_frequencies[0], rate, rtol=1e-9)
    assert np.allclose(system.solve(np.ones(n))(1e7), np.cos(rate * 1e7), rtol=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_a_free_grid_of_assembled_springs_is_free(seed):
    random, n = np.random.default_rng(seed), 6
    nodes = np.arange(n * n).reshape(n, n)
    pairs = [*zip(nodes[:-1].ravel(), nodes[1:].ravel()), *zip(nodes[:, :-1].ravel(), nodes[:, 1:].ravel())]
    K = np.zeros((n * n, n * n))
    for (i, j), k in zip(pairs, random.uniform(0.1, 3.0, len(pairs))):
        K[[i, j], [i, j]] += k
        K[[i, j], [j, i]] -= k
    assert kinds(MechanicalSystem(np.eye(n * n), stiffness=K))[0] == ("rigid body", 2)
