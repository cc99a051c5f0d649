"""Numbers of robots as parameters, against differences of whole robots: built, balanced and linearized again."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.scene.build.robot_file import robot_arguments
from tests.robot.linkages import GROUND, joint, link, urdf

ROBOTS = Path(__file__).parents[2] / "robots"

#: Central differences of order 8 (Fornberg 1988).
WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)

ROD = link("rod", 2.0, (0, 0, -0.5), (0.1, 0.1, 0.01)), joint("hinge", "frame", "rod", "continuous", axis=(0, 1, 0))

#: Two links, a tool that is fixed to the first.
ARM = urdf(
    GROUND,
    *ROD,
    link("tool", 0.5, (0.05, 0, 0), (0.01, 0.02, 0.015, 0.001, 0, 0), (0.3, 0, 0.2)),
    link("second", 1.0, (0, 0, -0.3), (0.05, 0.05, 0.01)),
    joint("mounting", "rod", "tool", "fixed", at=(0, 0, -0.8), turned=(0, 0.4, 0)),
    joint("knee", "rod", "second", "continuous", at=(0, 0, -1), axis=(0, 1, 0)),
)

NUMBERS = {
    "hinge.stiffness": 12.0,
    "knee.stiffness": 9.0,
    "hinge.damping": 0.4,
    "stay.stiffness": 15.0,
    "stay.damping": 0.3,
    "pad.stiffness x": 20.0,
    "pad.stiffness z": 30.0,
    "pad.turning_stiffness y": 5.0,
    "pad.damping z": 0.7,
    "rod.mass": 2.0,
    "tool.mass": 0.5,
    "second.mass": 1.0,
    "payload on second.mass": 0.6,
}


def arm(**changed):
    """The arm with a load on its second link and springs; every number of it by name."""
    p = NUMBERS | changed
    robot = mb.Robot(
        ARM,
        joint_stiffness={"hinge": p["hinge.stiffness"], "knee": p["knee.stiffness"]},
        joint_rest={"hinge": 0.6, "knee": -0.8},
        joint_damping={"hinge": p["hinge.damping"]},
        springs=[
            mb.BodySpring(
                "second", (0.1, 0, -0.5), "ground", (0.5, 0, 0.2), p["stay.stiffness"], 0.9, damping=p["stay.damping"], name="stay"
            ),
            mb.Bushing(
                "rod",
                (0, 0, -0.4),
                "ground",
                (0.3, 0, -0.4),
                stiffness=(p["pad.stiffness x"], 0, p["pad.stiffness z"]),
                turning_stiffness=(0, p["pad.turning_stiffness y"], 0),
                damping=(0, 0, p["pad.damping z"]),
                name="pad",
            ),
        ],
        payloads=[mb.Payload("second", p["payload on second.mass"], (0, 0, -0.6), (0.02, 0.02, 0.01))],
        masses={name: p[f"{name}.mass"] for name in ("rod", "tool", "second")},
    )
    return robot.linearize(robot.equilibrium({"hinge": 0.2, "knee": -0.3}))


def difference(function, value, step=0.01):
    """The derivative at a value."""
    h = step * value
    return sum(w * (function(value + i * h) - function(value - i * h)) / h for i, w in enumerate(WEIGHTS, 1))


def agree(d, name, expected):
    """To the larger of the estimate and the rounding errors of the differences."""
    place = d.names.index(name)
    size = np.abs(d.modes.eigenvalues).max() / d.parameters[place].value
    error = np.abs(d.eigenvalues[place] - expected)
    assert (error <= 10 * d.errors[place] + 2e-11 * size).all()
    assert error.max() <= 1e-9 * size


@pytest.fixture(scope="module")
def sensitivities():
    return arm().sensitivities()


@pytest.mark.long
def test_all_numbers_are_parameters(sensitivities):
    assert set(sensitivities.names) == set(NUMBERS)
    assert {one.name: pytest.approx(one.value) for one in sensitivities.parameters} == NUMBERS


@pytest.mark.parametrize("name", NUMBERS)
def test_each_number_of_an_arm(sensitivities, name):
    agree(sensitivities, name, difference(lambda value: arm(**{name: value}).modes().eigenvalues, NUMBERS[name]))


def test_a_pendulum_on_a_spring_in_closed_form():
    """m g l sin q + k (q - r) = 0 and w^2 = (m g l cos q + k) / J: the derivative by k has a part of the angle q, which k changes."""
    k, r, pull, inertia = 6.0, 1.2, 2 * 9.81 * 0.5, 0.1 + 2 * 0.5**2
    robot = mb.Robot(urdf(GROUND, *ROD), joint_stiffness={"hinge": k}, joint_rest={"hinge": r})
    posture = robot.equilibrium({"hinge": 0.5})
    q, d = posture["hinge"], robot.linearize(posture).sensitivities()
    moved = -(q - r) / (pull * np.cos(q) + k)
    w = np.sqrt((pull * np.cos(q) + k) / inertia)
    expected = (1 - pull * np.sin(q) * moved) / inertia / (2 * w)
    found = d.natural_frequencies[d.names.index("hinge.stiffness"), 0]
    assert abs(found - expected) <= 1e-11 * abs(expected)
    assert abs(found - 1 / inertia / (2 * w)) > 0.1 * abs(expected)  # without the moving equilibrium


def scene(folder, **changed):
    """A robot of the collection with changed numbers in its posture."""
    data = mb.read_robot(ROBOTS / folder)[1]
    arguments = robot_arguments(data.table, data.names, data.place) | changed
    robot = mb.Robot(data.names.path, **arguments)
    return robot.linearize(robot.equilibrium(**data.posture)), arguments


@pytest.mark.long
def test_a_loop():
    """The crank's spring carries the four-bar; the loads in its loop change with every mass."""
    d = scene("four_bar")[0].sensitivities(["crank pivot.stiffness", "coupler.mass", "rocker.mass"])
    spring = difference(lambda k: scene("four_bar", joint_stiffness={"crank pivot": k})[0].modes().eigenvalues, 20.0)
    agree(d, "crank pivot.stiffness", spring)
    for name in ("coupler", "rocker"):
        mass = d.parameter(f"{name}.mass").value
        agree(d, f"{name}.mass", difference(lambda m, n=name: scene("four_bar", masses={n: m})[0].modes().eigenvalues, mass))


@pytest.mark.long
def test_flexible_joints():
    """Gears of an arm with seven motors."""
    system, arguments = scene("seven_joint_arm")
    name, gear = next(iter(arguments["flexible_joints"].items()))
    d = system.sensitivities([f"{name}.stiffness"])

    def eigenvalues(k):
        changed = {**arguments["flexible_joints"], name: replace(gear, stiffness=k)}
        return scene("seven_joint_arm", flexible_joints=changed)[0].modes().eigenvalues

    agree(d, f"{name}.stiffness", difference(eigenvalues, gear.stiffness))


@pytest.mark.long
def test_a_free_base():
    """The block of an engine on its mounts: the posture of a free body moves with its mass."""
    d = scene("engine")[0].sensitivities(["block.mass"])
    agree(d, "block.mass", difference(lambda m: scene("engine", masses={"block": m})[0].modes().eigenvalues, d.parameters[0].value))


@pytest.mark.long
def test_rayleigh_damping_and_wrong_names():
    system = arm().with_rayleigh_damping(0.1, 0.02)
    expected = difference(lambda k: arm(**{"hinge.stiffness": k}).with_rayleigh_damping(0.1, 0.02).modes().eigenvalues, 12.0)
    agree(system.sensitivities(["hinge.stiffness"]), "hinge.stiffness", expected)
    with pytest.raises(mb.InputError, match='there is no parameter "hinge.stifness"; did you mean "hinge.stiffness"'):
        system.sensitivities(["hinge.stifness"])
