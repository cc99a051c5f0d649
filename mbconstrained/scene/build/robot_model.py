"""Equations of a scene of kind "robot": the robot's file, an equilibrium, small motions about it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ...ground.errors import InputError, shown
from ..file.includes import robot_name, robot_path
from ..file.messages import SceneName, at
from ..quantities.coordinates import Coordinates
from .robot_file import RobotData, robot_data, robot_of
from .robot_values import PLACE, joint_values, point_motion, posing

if TYPE_CHECKING:
    from ...robot.connections import PointMotion
    from ...robot.linearization.linearized import LinearizedRobot
    from ...robot.posture import Posture
    from ...robot.robot import Robot


@dataclass(frozen=True)
class RobotScene:
    """A robot in its posture, as a system in small deviations from it.

    Attributes:
        data: content of its file.
        robot, posture, system: of the models' floor; the system knows inputs and outputs by name.
        inputs: the joint or PointMotion of each input, by its name.
        forces: constant forces, as in ``Robot.equilibrium``.
    """

    data: RobotData
    robot: Robot
    posture: Posture
    system: LinearizedRobot
    inputs: Mapping[str, str | PointMotion]
    forces: Mapping[str | PointMotion, float] = field(default_factory=dict)

    @property
    def coordinates(self) -> Coordinates:
        """Names and units of the deviations."""
        names = tuple(self.system.names)
        return Coordinates(names, tuple(self.system.units[name] for name in names))

    @property
    def outputs(self) -> Coordinates:
        """Names and units of the outputs."""
        return Coordinates(tuple(self.system.outputs), tuple(self.system.output_units.values()))


def robot_scene(model, changed: dict, folder: Path, file_name: SceneName, lap: Callable[[str], object]) -> RobotScene:
    """Read the robot, find its equilibrium and linearize it there."""
    path = robot_path(model.robot, folder)
    data = robot_data(path, changed, robot_name(file_name, f"{path.absolute().parent.name}/{path.name}"))
    with at(file_name, "model"):
        data = data.with_locked(joint_values(model.locked, data.names, PLACE))
        arguments = _posture_arguments(data, posing(model, data.names, data.table.base, data.semantics))
    robot = robot_of(data)
    lap("robot model (pinocchio)")
    with at(file_name, "model"):
        posture = robot.equilibrium(**arguments)
    lap("equilibrium")
    inputs, outputs = (_motions(getattr(model, key), data, f"model.{key}", file_name) for key in ("input", "output"))
    with at(file_name, "model"):
        system = robot.linearize(posture, level=model.level, inputs=inputs, outputs=outputs)
    return RobotScene(data, robot, posture, system, inputs, arguments["forces"])


def _posture_arguments(data: RobotData, own: dict) -> dict:
    """The posture of the robot's file, with the changes of the scene."""
    posture = data.posture
    merged = {key: {**posture[key], **own[key]} for key in ("guess", "forces")}
    return data.unlocked({**merged, "hold": own.get("hold", posture["hold"])})


def _motions(entries, data: RobotData, key: str, file_name: str) -> dict:
    """Joint names and PointMotions by name."""
    motions = {}
    for number, entry in enumerate(entries, 1):
        with at(file_name, f"{key}[{number}] (of {shown(entry.name)})"):
            if entry.name in motions:
                raise InputError("this name is used twice; names must differ")
            if entry.joint is not None:
                data.names.joint_unit(entry.joint)
            motions[entry.name] = point_motion(entry, data.names) if entry.joint is None else entry.joint
    return motions
