"""The posture of a robot as tables, facts and plain data, and notices on joints beyond their limits."""

from __future__ import annotations

from collections.abc import Sequence
from math import asin, atan2, degrees
from typing import TYPE_CHECKING

import numpy as np

from ....ground.coordinate_units import force_unit
from ....ground.display import TextTable, number_text, with_unit
from ....ground.notices import Notice, NoticeKind
from ....ground.tolerances import JOINT_LIMIT

if TYPE_CHECKING:
    from ....robot.connections import Connection
    from ....robot.linearization.linear_range import LinearRange
    from ...build.robot_model import RobotScene

#: Loop forces below this share of the largest, and places and torques below this share of 1 in SI, are rounding and printed as 0.
ROUNDING = 1e-12


def posture_tables(robot_scene: RobotScene) -> list[TextTable]:
    """Joints, and forces of loops and springs at rest."""
    return [_joint_table(robot_scene), _force_table(robot_scene)]


def robot_evidence(robot_scene: RobotScene, motion: LinearRange) -> list[tuple[str, str, str]]:
    """The residual of the equilibrium, the gap of its loops, and how well the nonlinear equations follow the motion."""
    posture = robot_scene.posture
    rows = [("equilibrium: residual", f"{posture.residual:.2g}", "largest unbalanced force relative to the largest force")]
    if posture.balance.load.has_rows:
        rows.append(("equilibrium: loops", f"{posture.loop_error:.2g}", "largest gap of a loop, in m or rad"))
    meaning = "force that the linear motion leaves in the nonlinear equations, relative to its own forces"
    reached = f"; {motion.limit_text}" if motion.limit_text else ""
    return [*rows, ("linear motion: residual", f"{motion.deviation:.2g}", f"{meaning}{reached}")]


def robot_fact(robot_scene: RobotScene) -> tuple[str, str]:
    """Title, source and licence of the robot."""
    data = robot_scene.data
    return "robot", "; ".join(filter(None, [data.title or data.name, data.source, data.licence and f"licence {data.licence}"]))


def posture_json(robot_scene: RobotScene) -> dict:
    """The robot and its posture as plain data."""
    data, posture = robot_scene.data, robot_scene.posture
    return {
        "robot": {"name": data.name, "title": data.title, "source": data.source, "licence": data.licence},
        "posture": {
            "joints": {name: list(value) if isinstance(value, tuple) else value for name, value in posture.joints.items()},
            "torques": dict(posture.torques),
            "reactions": {name: value.tolist() for name, value in posture.reactions.items()},
            "ground_reactions": {name: value.tolist() for name, value in posture.ground_reactions.items()},
            "residual": posture.residual,
            "loop_error": posture.loop_error,
        },
    }


def _joint_table(robot_scene: RobotScene) -> TextTable:
    torques = dict(zip(robot_scene.posture.torques, _cleaned(robot_scene.posture.torques.values())))
    robot = robot_scene.robot
    units, tangent = dict(zip(robot.coordinates, robot.units)), robot.tangent
    columns = ("joint", "rests at", "with load") if torques else ("joint", "rests at")
    rows = []
    for name, value in robot_scene.posture.joints.items():
        own = [one for one in tangent.coordinates_of(name) if one in torques]
        acting = [one for one in own if torques[one]] or own[:1]
        loads = [f"{one[len(name) :]} {with_unit(torques[one], force_unit(units[one]))}".strip() for one in acting]
        rows.append((name, _place(value, [units[one] for one in tangent.coordinates_of(name)]), ", ".join(loads))[: len(columns)])
    return TextTable("Posture", columns, tuple(rows))


def _place(value, units: Sequence[str]) -> str:
    """The position of a joint: displacements, then an angle, several, or a quaternion as roll, pitch and yaw."""
    values, moving = np.atleast_1d(value).tolist(), units.count("m")
    if len(values) == 1:
        return _single(values[0], units[0] if units else "")
    moved, turned = _cleaned(values[:moving]), values[moving:]
    texts = [f"{_vector(moved)} m"] if moving else []
    if len(turned) == 1:
        texts.append(_single(turned[0], "rad"))
    elif len(turned) == 4:
        texts.append(f"roll, pitch, yaw {_vector(_cleaned(_angles(turned)))} rad")
    elif turned:
        texts.append(f"{_vector(_cleaned(turned))} rad")
    return ", ".join(texts)


def _single(value: float, unit: str) -> str:
    (value,) = _cleaned([value])
    return f"{with_unit(value, unit)} ({degrees(value):.4g}°)" if unit == "rad" else with_unit(value, unit)


def _angles(quaternion) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a unit quaternion x, y, z, w, as a URDF writes rotations."""
    x, y, z, w = quaternion
    pitch = asin(max(-1.0, min(1.0, 2 * (w * y - x * z))))
    return atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), pitch, atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _cleaned(values) -> list[float]:
    """Positions or torques, with rounding errors set to 0."""
    largest = max([1.0, *map(abs, values)])
    return [value if abs(value) > ROUNDING * largest else 0.0 for value in values]


def _force_table(robot_scene: RobotScene) -> TextTable:
    """Forces of loops, springs and bushings in the frames on their first bodies, and along the axes of the ground where these differ."""
    posture, robot = robot_scene.posture, robot_scene.robot
    items = (*robot.loops, *robot.springs)
    forces = np.array([[values[item.name] for item in items] for values in (posture.reactions, posture.ground_reactions)])
    forces = forces.reshape(2, -1, 6)
    rounding = ROUNDING * np.abs(forces).max(initial=0.0)
    own, ground = np.where(np.abs(forces) > rounding, forces, 0.0)
    rows = [(item.name, item.body2, *_wrench(item, own[i]), *_wrench(item, ground[i])) for i, item in enumerate(items)]
    columns = ("loop or spring", "on", "force", "torque", "force, axes of the ground", "torque, axes of the ground")
    same = np.abs(own - ground).max(initial=0.0) <= rounding
    left_out = {3, 5} if not any(item.turning for item in items) else set()
    shown = sorted({0, 1, 2, 3, *(() if same else (4, 5))} - left_out)
    axes = "x, y, z of the ground" if same else "x, y, z of its frame on the first body, then of the ground"
    note = f"{axes}; forces during the motion come on top."
    return TextTable(
        "Forces of loops and springs at rest",
        tuple(columns[i] for i in shown),
        tuple(tuple(row[i] for i in shown) for row in rows),
        note,
    )


def _wrench(connection: Connection, value: np.ndarray) -> tuple[str, str]:
    return f"{_vector(value[:3])} N", f"{_vector(value[3:])} N m" if connection.turning else ""


def _vector(values) -> str:
    return f"({', '.join(number_text(value) for value in values)})"


#: A motion passes a limit by this share of the range of its joint: a joint that rests at its limit may tremble.
LIMIT_SHARE = 1e-3


def limit_notices(robot_scene: RobotScene, ends: np.ndarray) -> list[Notice]:
    """A notice on joints that exceed their limits during the motion."""
    lowest, highest = ends[: len(robot_scene.robot.coordinates)].T
    robot, furthest = robot_scene.robot, {}
    rests = robot.tangent.angles(robot_scene.posture.configuration)
    for name, (low, high) in robot.limits.items():
        place = robot.coordinates.index(name)
        rest = float(rests[place])
        reached = float(rest + lowest[place]), float(rest + highest[place])
        beyond = not low - JOINT_LIMIT <= rest <= high + JOINT_LIMIT  # which the posture reports
        furthest[name] = low if beyond else max(reached, key=lambda value: max(low - value, value - high))
    outside = robot.tangent.outside_limits(furthest, JOINT_LIMIT, LIMIT_SHARE)
    text = f"during the motion {outside}; the equations have no limits"
    return [Notice(NoticeKind.LARGE_MOTION, text)] if outside else []
