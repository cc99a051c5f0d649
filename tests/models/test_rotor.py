"""Rotors of lumped models: matrices by hand, closed forms of a rigid rotor, bearings with cross coupling and speed tables."""

import numpy as np
import pytest

import mbconstrained as mb

MASS, DIAMETRAL, POLAR, LEFT, RIGHT = 20.0, 0.5, 0.3, -0.2, 0.3
SKEW = np.array([[0.0, 1.0], [-1.0, 0.0]])


def rigid_rotor(stiffness=2e6, **more) -> mb.LumpedModel:
    """On two equal bearings."""
    model = mb.LumpedModel()
    model.rotor("disc", MASS, diametral_inertia=DIAMETRAL, polar_inertia=POLAR, points={"left": LEFT, "right": RIGHT})
    for point in ("left", "right"):
        model.bearing("ground", point, stiffness, **more)
    return model


def planar(stiffness, damping):
    """The matrices over (y, z, a, b), displacements and tilts, of bearing matrices k and c at both points."""
    B = [np.kron([[1.0, distance]], np.eye(2)) for distance in (LEFT, RIGHT)]
    return tuple(sum(one.T @ matrix @ one for one in B) for matrix in (stiffness, damping))


def by_hand(W, K, C):
    """Eigenvalues of M s^2 + (C + W G) s + K over (y, z, a, b)."""
    M = np.diag([MASS, MASS, DIAMETRAL, DIAMETRAL])
    D = C + W * np.pad(POLAR * SKEW, (2, 0))
    S = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    return np.sort_complex(np.linalg.eigvals(S))


@pytest.mark.parametrize("speed", [0.0, 300.0, 2000.0])
@pytest.mark.parametrize(
    "stiffness, damping",
    [
        (2e6, 0.0),
        ([2e6, 3e6], [100.0, 200.0]),
        ([[2e6, 4e5], [-4e5, 2e6]], [[300.0, 50.0], [50.0, 300.0]]),
        ([[-1e5, 1e6], [-1e6, 2e6]], 50.0),
    ],
)
def test_a_rigid_rotor_has_the_equations_by_hand(stiffness, damping, speed):
    """J_d a'' + W J_p b' + ..., J_d b'' - W J_p a' + ... in displacements and tilts (Genta 2005, section 4.3)."""
    K, C = planar(*(np.diag(np.broadcast_to(one, 2)) if np.ndim(one) < 2 else np.array(one) for one in (stiffness, damping)))
    rotor = rigid_rotor(stiffness, damping=damping).assemble()
    found = np.sort_complex(rotor.at_speed(speed).modes().eigenvalues)
    expected = by_hand(speed, K, C)
    size = np.abs(expected).max()
    found, expected = (values[values.imag >= -1e-12 * size] for values in (found, expected))
    np.testing.assert_allclose(found[np.argsort(found.imag)], expected[np.argsort(expected.imag)], atol=1e-10 * size)


def test_the_tilts_of_a_symmetric_rotor_are_those_of_a_gyroscope():
    """w = (+-G + sqrt(G^2 + 4 k J)) / (2 J) with G = W J_p and k = 2 k_b d^2; displacements sqrt(2 k_b / m)."""
    model, k, d = mb.LumpedModel(), 1e5, 0.4
    model.rotor("disc", 8.0, diametral_inertia=0.5, polar_inertia=0.9, points={"a": -d, "b": d})
    for point in "ab":
        model.bearing(point, "ground", k)
    rotor = model.assemble()
    for W in (0.0, 100.0, 700.0):
        G, K, J = W * 0.9, 2 * k * d * d, 0.5
        expected = [np.sqrt(2 * k / 8.0)] * 2 + [(sign * G + np.sqrt(G * G + 4 * K * J)) / (2 * J) for sign in (1, -1)]
        np.testing.assert_allclose(np.sort(rotor.at_speed(W).modes().natural_frequencies), np.sort(expected), rtol=1e-12)
    assert sorted(rotor.campbell([0.0, 700.0]).directions)[0] == "backward"


def test_the_parts_of_a_bearing_are_springs_that_the_energy_knows():
    system = rigid_rotor([2e6, 3e6]).assemble()
    assert "bearing ground-left stiffness y" in system.energy_parts.strain
    np.testing.assert_array_equal(system.gyroscopic, -system.gyroscopic.T)
    assert system.gyroscopic[system.names.index("disc y angle"), system.names.index("disc z angle")] == POLAR


TABLE = {"speeds": [0.0, 100.0, 400.0], "stiffness": [1e6, [2e6, 3e6], [[2e6, 5e5], [-5e5, 2e6]]], "damping": [10.0, 20.0, 50.0]}


def test_a_speed_table_is_linear_between_its_speeds():
    rotor = mb.LumpedModel()
    rotor.rotor("disc", MASS)
    rotor.bearing("ground", "disc", **TABLE)
    system = rotor.assemble()
    np.testing.assert_allclose(system.at_speed(50.0).stiffness, np.diag([1.5e6, 2e6]), rtol=1e-15)
    np.testing.assert_allclose(system.at_speed(250.0).stiffness, [[2e6, 2.5e5], [-2.5e5, 2.5e6]], rtol=1e-15)
    np.testing.assert_allclose(system.at_speed(250.0).damping, 35.0 * np.eye(2), rtol=1e-15)
    with pytest.raises(mb.InputError, match=r"found 500 rad/s; the table of the bearing .* is from 0 to 400"):
        system.at_speed(500.0)
    with pytest.raises(mb.InputError, match="500 rad/s"):
        system.campbell([0.0, 500.0])


def test_critical_speeds_with_a_speed_table_are_where_the_branches_meet_the_line():
    """Undamped, k(W) = m W^2 in each plane: the roots of a quadratic polynomial in each interval; one at a knot is found once."""
    model = mb.LumpedModel()
    model.rotor("disc", 1.0)
    model.bearing("ground", "disc", speeds=[0.0, 100.0, 200.0], stiffness=[[1e4, 4e3], [1e4, 8e3], [5e4, 3e4]])
    critical = model.assemble().critical_speeds()
    # y: W^2 = 1e4 (W = 100, a knot), and W^2 = 1e4 + 400 (W - 100) at W = 100 and 300, beyond; z: W^2 = 4e3 + 40 W
    np.testing.assert_allclose(critical, [20 + np.sqrt(400 + 4e3), 100.0], rtol=1e-12)


def test_a_table_with_equal_ends_is_not_constant():
    model = mb.LumpedModel()
    model.rotor("disc", 1.0)
    model.bearing("ground", "disc", speeds=[0.0, 10.0, 20.0], stiffness=[100.0, 400.0, 100.0])
    diagram = model.assemble().campbell([0.0, 5.0, 10.0, 20.0])
    np.testing.assert_allclose(diagram.damped_frequencies[:, 0], np.sqrt([100.0, 250.0, 400.0, 100.0]), rtol=1e-12)


def test_unbalance_turns_from_y_to_z():
    model = rigid_rotor()
    model.unbalance("disc", 2e-5, angle=0.3)
    model.unbalance("left", 1e-5)
    u, names = model.assemble().unbalance, model.assemble().names
    for t in np.linspace(0.0, 6.0, 5):
        y, z = ((u[names.index(f"disc {plane}")] * np.exp(1j * t)).real for plane in "yz")
        np.testing.assert_allclose([y, z], [2e-5 * np.cos(t + 0.3), 2e-5 * np.sin(t + 0.3)], atol=1e-20)
    assert u[names.index("left y")] == 1e-5 and np.count_nonzero(u) == 4


@pytest.mark.parametrize(
    "add, message",
    [
        (lambda m: m.rotor("r", -1.0), r'rotor "r": mass: found -1'),
        (lambda m: m.rotor("r", 1.0, diametral_inertia=-0.1), "diametral inertia: found -0.1"),
        (lambda m: m.rotor("r", 1.0, diametral_inertia=0.1, polar_inertia=-0.1), "polar inertia: found -0.1"),
        (lambda m: m.rotor("r", 1.0, diametral_inertia=0.1, polar_inertia=0.3), "swapped"),
        (lambda m: m.rotor("r", 1.0, polar_inertia=0.3), "without a diametral inertia"),
        (lambda m: m.rotor("r", 1.0, points={"a": 0.1}), "points without"),
        (lambda m: m.rotor("r", 1.0, diametral_inertia=1.0, points=[1.0]), "by name"),
        (lambda m: m.rotor("disc", 1.0), "already in use"),
        (lambda m: m.bearing("ground", "lift", 1.0), 'no body "lift y"; did you mean "left y"'),
        (lambda m: m.bearing("left", "left", 1.0), "two of its ends"),
        (lambda m: m.bearing("ground", "left"), "neither stiffness nor damping"),
        (lambda m: m.bearing("ground", "left", [1.0, 2.0, 3.0]), "two of the planes"),
        (lambda m: m.bearing("ground", "left", "stiff"), 'stiffness: found "stiff"; expected a stiffness'),
        (
            lambda m: m.bearing("ground", "left", [1.0, 2.0], speeds=[2.0, 1.0]),
            "speeds: found 2, 1; expected two or more, ascending",
        ),
        (lambda m: m.bearing("ground", "left", [1.0], speeds=[1.0, 2.0]), "found 1 entry; expected 2"),
        (lambda m: m.unbalance("ground", 1.0), "does not turn"),
        (lambda m: m.unbalance("left", -1.0), "moment: found -1"),
    ],
)
def test_what_is_wrong_is_named(add, message):
    with pytest.raises(mb.InputError, match=message):
        add(rigid_rotor())


@pytest.mark.parametrize("points", [{}, {"left": -0.4, "right": 0.4}])
def test_a_rotor_hangs_in_its_bearings_by_its_weight(points):
    """Along z alone: m g / k."""
    model = mb.LumpedModel()
    model.gravity(-9.81)
    inertias = {"diametral_inertia": 1.0, "polar_inertia": 0.5, "points": points} if points else {}
    model.rotor("disc", 20.0, **inertias)
    for point in points or ("disc",):
        model.bearing("ground", point, stiffness=4e6 / len(points or "1"), damping=1e4)
    system = model.assemble()
    sag = dict(zip(system.names, system.solve()(100.0)))
    assert sag["disc z"] == pytest.approx(-20.0 * 9.81 / 4e6, rel=1e-9) and sag["disc y"] == 0.0
