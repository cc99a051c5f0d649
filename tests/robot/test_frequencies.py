"""Linearized robots against minimal-coordinate models in 80 digits (tests/oracles/linkages.py) and against closed forms."""

import numpy as np
import pytest

import mbconstrained as mb
from tests.robot import linkages
from tests.robot.linkages import GROUND, PLANE, TABLE, allowed, given, joint, known, known_frequencies, linearized, link, urdf

G = 9.81


def frequencies(system) -> np.ndarray:
    return system.modes().natural_frequencies


def upper_zeros(system) -> np.ndarray:
    """The zeros of the engine, one of each pair, as often as they occur."""
    zeros = [mode.eigenvalue for mode in system.modes() for _ in range(mode.multiplicity)]
    return np.array(sorted(zeros, key=lambda s: (abs(s), s.real)))


def near(frequencies, expected, digits: float = 1e-9) -> bool:
    frequencies, expected = np.asarray(frequencies), np.asarray(expected)
    assert frequencies.shape == expected.shape
    return bool(np.all(np.abs(frequencies - expected) <= digits * np.abs(expected).max()))


@pytest.mark.parametrize("name", TABLE)
def test_equilibrium_is_that_of_minimal_coordinates(name):
    _, posture, _ = linearized(name)
    for joint_name, value in known(name)["posture"].items():
        if joint_name in posture.joints:
            assert posture.joints[joint_name] == pytest.approx(float(value), rel=1e-9, abs=1e-10)
    assert posture.residual < 1e-9 and posture.loop_error < 1e-11


@pytest.mark.parametrize("name", [name for name in TABLE if "zeros" not in known(name)])
def test_frequencies_are_those_of_minimal_coordinates(name):
    _, _, system = linearized(name)
    expected = known_frequencies(name)
    assert near(frequencies(system), expected[expected > 0])


@pytest.mark.parametrize("name", [name for name in TABLE if "zeros" in known(name)])
def test_zeros_with_dampers_are_those_of_minimal_coordinates(name):
    _, _, system = linearized(name)
    zeros = [complex(float(re), float(im)) for re, im in known(name)["zeros"] if float(im) >= 0]
    expected = np.array(sorted(zeros, key=lambda s: (abs(s), s.real)))
    assert near(upper_zeros(system), expected)


@pytest.mark.parametrize("name", TABLE)
@pytest.mark.parametrize("level", ["position", "velocity", "acceleration"])
def test_projected_matrices_are_symmetric_and_give_the_frequencies_at_any_level(name, level):
    robot, posture, _ = linearized(name)
    system = robot.linearize(posture, level=level)
    N = allowed(system)
    K, M = N.T @ system.stiffness @ N, N.T @ system.mass @ N
    assert np.abs(K - K.T).max() <= 1e-10 * np.abs(K).max()
    assert np.abs(M - M.T).max() <= 1e-14 * np.abs(M).max()
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)
    # eigenvalues near zero (rigid modes) carry the rounding errors of the largest one
    assert near(squares, known_frequencies(name) ** 2, 2e-9 if known_frequencies(name).min() > 0 else 1e-12)


@pytest.mark.parametrize("name", TABLE)
def test_energies_of_the_parts_add_up(name):
    _, _, system = linearized(name)
    for parts, whole in ((system.energy_parts.kinetic, system.mass), (system.energy_parts.strain, system.stiffness)):
        total = sum(np.asarray(getattr(part, "matrix", part)) for part in parts.values())
        assert np.abs(total - whole).max() <= 1e-12 * np.abs(whole).max()


@pytest.mark.parametrize("name", ["four-bar", "four-bar with a pin", "slider-crank"])
def test_reactions_are_the_gradients_of_the_potential(name):
    # lambda of grad V = J^T lambda, frequencies in 80 digits, is the force on body 1 in the ground's directions
    _, posture, _ = linearized(name)
    force = -np.array([float(x) for x in known(name)["loop_forces"]])
    (reaction,) = posture.reactions.values()
    angle = posture.joints["j1"] + posture.joints["j2"] + posture.joints.get("j4", 0.0)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    if (
        name == "four-bar with a pin"
    ):  # there the pin's weight is carried by body 1: what the loop carries differs, the sum does not
        p = given(name)
        pinned = np.linalg.norm(turn @ reaction[:2] - force)
        assert 0 < pinned <= p["pin_mass"] * G + 25.0 and abs(reaction[2]) < 1e-9
    else:
        assert near(turn @ reaction[:2], force) and np.abs(reaction[2:]).max() < 1e-9


@pytest.mark.parametrize("angle", [0.3, np.pi / 2, -2.0])
def test_a_spring_without_a_rest_carries_the_weight_in_the_posture(angle):
    # k acts from the posture on: w^2 = (m g l cos + k) / (I + m l^2), and the load is that of gravity alone
    m, l, I, k = 1.7, 0.6, 0.05, 5e4
    model = urdf(GROUND, link("bob", m, (0, 0, -l), (I / 3, I, I / 2)), joint("swing", "frame", "bob", axis=(0, 1, 0)))
    robot = mb.Robot(model, joint_stiffness={"swing": k})
    for hold in ((), "all"):
        posture = robot.equilibrium({"swing": angle}, hold=hold)
        assert posture.joints == {"swing": angle}
        assert posture.torques["swing"] == pytest.approx(m * G * l * np.sin(angle), rel=1e-13)
        assert near(robot.linearize(posture).stiffness, [[m * G * l * np.cos(angle) + k]], 1e-12)


def parallelogram_square(crank, mass, length):
    """w^2 = g (m + mc) / (L (m + 2/3 mc)): a coupler m that stays level, two uniform cranks mc."""
    return G * (mass + crank) / (length * (mass + 2 * crank / 3))


@pytest.mark.parametrize("crank", [0.4, 1e-9, 0.0])
def test_parallelogram_whose_coupler_is_a_free_body(crank):
    # links without inertia are links: the coupler alone moves, as a point on a string does
    robot, guess = linkages.free_parallelogram(crank, 1.5, 0.5, 1.0)
    system = robot.linearize(robot.equilibrium(guess))
    assert near(frequencies(system) ** 2, [parallelogram_square(crank, 1.5, 0.5)])


@pytest.mark.parametrize("crank", [0.4, 0.0])
def test_parallelogram_in_joint_angles(crank):
    p = {"masses": [crank, 1.5, crank], "lengths": [0.5, 1.0, 0.5], "end": [1.0, 0.0], "guess": [-1.5, 1.5, 1.5]}
    p["guess"][2] = -np.pi / 2 + 1.6 - 0.03  # third bar points up from the coupler's end to the ceiling
    robot, _ = linkages.hanging_four_bar(p)
    posture = robot.equilibrium({"j1": -1.5, "j2": 1.5, "j3": 1.5})
    assert near(frequencies(robot.linearize(posture)) ** 2, [parallelogram_square(crank, 1.5, 0.5)])


@pytest.mark.parametrize("turned", [0.0, 0.8, np.pi])
def test_a_pin_that_is_fastened_to_the_rocker(turned):
    # the frames of the loop may look anywhere
    robot, guess = linkages.four_bar_with_pin(given("four-bar with a pin"), turned)
    system = robot.linearize(robot.equilibrium(guess))
    assert near(frequencies(system), known_frequencies("four-bar with a pin"))


@pytest.mark.parametrize(
    "kind, options",
    [
        ("hinge", {}),
        ("hinge", {"rotation2": (0, 0, 2.5)}),
        ("hinge", {"axis": (0, 0, -2.0)}),
        ("point", {"rotation1": (0.3, 1.0, -0.4)}),
    ],
)
def test_four_bar_closed_by_a_point_or_a_hinge(kind, options):
    p = given("four-bar")
    robot, guess = linkages.four_bar(p, loops=[linkages.four_bar_loop(p, kind=kind, **options)])
    system = robot.linearize(robot.equilibrium(guess))
    assert near(frequencies(system), known_frequencies("four-bar"))


@pytest.mark.parametrize("beyond", [0.0, 1e-9, -1e-9, 1e-4])
def test_hinge_whose_frames_are_turned_by_half_a_turn(beyond):
    # the logarithm of the rotation jumps there; the hinge does not
    p = given("four-bar")
    angles = {key: float(x) for key, x in known("four-bar")["posture"].items()}
    turned = angles["j3"] - angles["j1"] - angles["j2"]  # of the rocker against the coupler, where it rests
    loop = linkages.four_bar_loop(p, kind="hinge", rotation2=(0, 0, np.pi - turned + beyond))
    robot, _ = linkages.four_bar(p, loops=[loop])
    posture = robot.equilibrium(angles)
    assert posture.joints == pytest.approx(angles, abs=1e-9)
    assert near(frequencies(robot.linearize(posture)), known_frequencies("four-bar"))


def test_spherical_four_bar_with_frames_turned_by_half_a_turn():
    robot, guess = linkages.spherical(given("spherical four-bar"), half_turn=True)
    system = robot.linearize(robot.equilibrium(guess))
    assert near(frequencies(system), known_frequencies("spherical four-bar"))


@pytest.mark.parametrize("force", [4.0, -11.0])
def test_pendulum_pushed_by_a_force_that_keeps_its_direction(force):
    # it hangs along the sum of weight and force: w^2 = sqrt(g^2 + (F/m)^2) / L for a point at the end of a string
    mass, length = 1.3, 0.7
    model = urdf(GROUND, link("bob", mass, (length, 0, 0)), joint("swing", "frame", "bob", "continuous"))
    robot = mb.Robot(model, gravity=PLANE)
    posture = robot.equilibrium({"swing": -1.4}, forces={mb.PointMotion("bob", (length, 0, 0), along=(3, 0, 0)): force})
    assert np.tan(posture.joints["swing"]) == pytest.approx(-mass * G / force, rel=1e-10)
    assert near(frequencies(robot.linearize(posture)) ** 2, [np.hypot(G, force / mass) / length])


def test_force_at_a_joint():
    model = urdf(GROUND, link("bob", 1.0, (0.5, 0, 0)), joint("swing", "frame", "bob", "continuous"))
    robot = mb.Robot(model, gravity=PLANE)
    posture = robot.equilibrium({"swing": -1.4}, forces={"swing": 2.0})
    assert np.cos(posture.joints["swing"]) == pytest.approx(2.0 / (0.5 * G), rel=1e-12)  # m g l cos(q) = torque


def test_inputs_and_outputs():
    # the tip of the second bar, (x, y) and turn, by hand; an input is the same row as an output
    p = given("double pendulum")
    robot, posture, _ = linearized("double pendulum")
    tip = (p["lengths"][1], 0, 0)
    watched = {
        "x": mb.PointMotion("lower", tip),
        "y": mb.PointMotion("lower", tip, along=(0, 2, 0)),
        "turn": mb.PointMotion("lower", along=(0, 0, 1), turn=True),
        "elbow": "j2",
    }
    system = robot.linearize(posture, inputs=watched, outputs=watched)
    a, b = posture.joints["j1"], posture.joints["j1"] + posture.joints["j2"]
    first, second = p["lengths"]
    rows = {
        "x": [-first * np.sin(a) - second * np.sin(b), -second * np.sin(b)],
        "y": [first * np.cos(a) + second * np.cos(b), second * np.cos(b)],
        "turn": [1, 1],
        "elbow": [0, 1],
    }
    for name, row in rows.items():
        assert near(system.inputs[name], row, 1e-13) and near(system.outputs[name], row, 1e-13)
    force = system.input_force({"x": mb.step([3.0]), "elbow": mb.step([-1.0])})
    assert near(force(0.5), 3 * np.array(rows["x"]) - np.array(rows["elbow"]), 1e-13)


def test_motors_may_be_eliminated():
    # det of the degree-4 matrix vanishes at the zeros of the doubled system, and nowhere else
    for name in ("flexible arm", "flexible arm with PD"):
        _, _, system = linearized(name)
        assert tuple(system.names) == ("j1", "j2", "j1 motor", "j2 motor")
        A = system.without_motors().polynomial_matrix
        assert (A.degree, A.size) == (4, 2)
        values = [complex(float(re), float(im)) for re, im in known(name)["zeros"]]
        scale = np.abs(values).max()
        for s in values:
            others = np.prod([s - z for z in values if z is not s])
            lead = np.linalg.det(A(scale * 1e3) / (scale * 1e3) ** 4)
            slope = abs(lead * others)
            assert abs(np.linalg.det(A(s))) <= 1e-8 * slope * abs(s)
