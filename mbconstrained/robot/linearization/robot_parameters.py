"""The constants of a robot as parameters: stiffness and damping of joints and connections, masses of links and payloads.

Those of joints stand in the matrices as they are, but for the stiffness of a spring with a rest: like masses and connections between
bodies it moves the equilibrium. Then the equilibrium is searched again, from the posture, and the robot is linearized there
(``Parameter.of_function``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy, deepcopy
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ...mechanics.parameter import Parameter
from ..connections import BodySpring
from ..description.masses import replace_masses
from ..description.urdf import link_masses, skeleton
from ..kinematics import Tree, built_model
from ..robot_model import RobotModel
from ..statics.equilibrium import Search, equilibrium

if TYPE_CHECKING:
    from ...mechanics.system import MechanicalSystem
    from ..posture import Posture
    from ..statics.balance import Load

#: Constants along and about an axis, with their units.
BUSHING_UNITS = {"stiffness": "N/m", "turning_stiffness": "N m/rad", "damping": "N s/m", "turning_damping": "N m s/rad"}

Linearize = Callable[["Posture"], "MechanicalSystem"]


def robot_parameters(posture: Posture, linearize: Linearize) -> Iterator[Parameter]:
    """One parameter for each nonzero constant."""
    yield from _joints(posture, linearize)
    yield from _flexible_joints(posture.robot)
    yield from _connections(posture, linearize)
    yield from _masses(posture, linearize)


def _joints(posture: Posture, linearize: Linearize) -> Iterator[Parameter]:
    robot, size = posture.robot, len(posture.robot.coordinates) + len(posture.robot.flexible_joints)
    for place, (name, unit) in enumerate(zip(robot.coordinates, robot.units)):
        of_force = "N m" if unit == "rad" else "N"
        value, only = float(robot.joint_stiffness[place]), np.eye(len(robot.coordinates))[place]
        if value:
            build = partial(_with_joint_stiffness, posture, linearize, only, value)
            yield Parameter.of_function(f"{name}.stiffness", value, build, f"{of_force}/{unit}")
        if value := float(robot.joint_damping[place]):
            corner = np.diag(np.eye(size)[place])
            yield Parameter(f"{name}.damping", value, damping=corner, unit=f"{of_force} s/{unit}")


def _flexible_joints(robot: RobotModel) -> Iterator[Parameter]:
    """Stiffness and damping of gears: [1, -1; -1, 1] between link and motor, without effect on the statics of the links."""
    count = len(robot.coordinates)
    for number, (name, joint) in enumerate(robot.flexible_joints.items()):
        stretch = np.zeros(count + len(robot.flexible_joints))
        stretch[[robot.coordinates.index(name), count + number]] = -1.0, 1.0
        unit = robot.units[robot.coordinates.index(name)]
        of_force = "N m" if unit == "rad" else "N"
        for key, over in (("stiffness", unit), ("damping", f"s/{unit}")):
            if value := getattr(joint, key):
                slopes: dict[str, Any] = {key: np.outer(stretch, stretch)}
                yield Parameter(f"{name}.{key}", value, **slopes, unit=f"{of_force}/{over}".replace("/s/", " s/"))


def _connections(posture: Posture, linearize: Linearize) -> Iterator[Parameter]:
    """Constants of springs and bushings between bodies; a spring keeps its rest length."""
    for number, item in enumerate(posture.balance.load.springs):
        spring = item.connection
        for key, unit in BUSHING_UNITS.items():
            given = getattr(spring, key, 0.0)
            for axis, value in zip([""] if isinstance(spring, BodySpring) else [" x", " y", " z"], np.atleast_1d(given).tolist()):
                if value:
                    build = partial(_with_connection, posture, linearize, number, key, axis.strip())
                    yield Parameter.of_function(f"{spring.name}.{key}{axis}", value, build, unit)


def _masses(posture: Posture, linearize: Linearize) -> Iterator[Parameter]:
    """Masses of links; the inertia of a body is linear in each of them: by joint the ten inertial parameters of pinocchio for 1 kg."""
    robot = posture.robot
    for name, mass, slopes in (*_links(robot), *_payloads(robot)):
        if slopes:
            yield Parameter.of_function(f"{name}.mass", mass, partial(_with_masses, posture, linearize, mass, slopes), "kg")


def _links(robot: RobotModel) -> Iterator[tuple[str, float, dict[int, np.ndarray]]]:
    """Masses of the links of a URDF, by the description with another mass."""
    if robot.source.model is not None:
        return
    own = _inertias(robot, {})
    for name, mass in link_masses(robot.description).items():
        if mass > 0.0:
            changes = _inertias(robot, {name: 2 * mass}) - own
            yield name, mass, {joint: change / mass for joint, change in enumerate(changes, 1) if change.any()}


def _inertias(robot: RobotModel, masses: dict[str, float]) -> np.ndarray:
    description = deepcopy(robot.description)
    replace_masses(description, masses, {})
    model = built_model(skeleton(description), robot.base != "fixed", robot.locked, robot.model.gravity.linear)
    return np.array([np.array(one.toDynamicParameters()) for one in list(model.inertias)[1:]]).reshape(-1, 10)


def _payloads(robot: RobotModel) -> Iterator[tuple[str, float, dict[int, np.ndarray]]]:
    import pinocchio

    for payload in robot.payloads:
        anchor = robot.link_frames.anchor(payload.body, payload.centre, (0.0, 0.0, 0.0), "payloads")
        slope = np.array(pinocchio.Inertia(1.0, anchor.point, np.zeros((3, 3))).toDynamicParameters())
        if payload.mass and anchor.joint:
            yield f"payload on {payload.body}", payload.mass, {anchor.joint: slope}


def _with_joint_stiffness(posture: Posture, linearize: Linearize, only: np.ndarray, old: float, value: float) -> MechanicalSystem:
    twin = copy(posture.robot)
    twin.joint_stiffness = twin.joint_stiffness + (value - old) * only
    return linearize(_again(posture, twin, replace(posture.balance.load, joint_stiffness=twin.joint_stiffness)))


def _with_connection(posture: Posture, linearize: Linearize, number: int, key: str, axis: str, value: float) -> MechanicalSystem:
    springs = list(posture.balance.load.springs)
    spring: Any = springs[number].connection
    numbers = value if not axis else tuple(value if one == axis else old for one, old in zip("xyz", getattr(spring, key)))
    springs[number] = replace(springs[number], connection=replace(spring, **{key: numbers}))
    return linearize(_again(posture, posture.robot, replace(posture.balance.load, springs=tuple(springs))))


def _with_masses(
    posture: Posture, linearize: Linearize, old: float, slopes: dict[int, np.ndarray], value: float
) -> MechanicalSystem:
    import pinocchio

    twin = copy(posture.robot)
    model = twin.model.copy()
    for joint, slope in slopes.items():
        numbers = model.inertias[joint].toDynamicParameters() + (value - old) * slope
        model.inertias[joint] = pinocchio.Inertia.FromDynamicParameters(numbers)
    twin.tree = Tree(model)
    return linearize(_again(posture, twin, posture.balance.load))


def _again(posture: Posture, robot: RobotModel, load: Load) -> Posture:
    """The equilibrium of a slightly changed robot, near the posture; the constrained coordinates keep their values."""
    free = ~np.isin(robot.coordinates, list(posture.torques))
    state = equilibrium(Search(robot.tree, load, free, names=robot.coordinates), posture.configuration)
    balance = state.balance
    return replace(posture, robot=robot, configuration=balance.configuration, multipliers=state.multipliers, balance=balance)
