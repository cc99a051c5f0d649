"""What a robot's posture tells, as tables and as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from math import asin, atan2, degrees
from typing import TYPE_CHECKING

from .happenings import number, sized
from .robot_values import FORCE
from .text_table import TextTable

if TYPE_CHECKING:
    from .robot import RobotScene

#: Loop forces below this share of the largest, and places and torques below this share of 1 in SI, are rounding and printed as 0.
ROUNDING = 1e-12


def posture_tables(found: RobotScene | None) -> list[TextTable]:
    """Joints and loop forces at rest; nothing without a robot."""
    return [_joint_table(found), _loop_table(found)] if found else []


def posture_evidence(found: RobotScene | None) -> list[tuple[str, str, str]]:
    """How well the equilibrium is one; nothing without a robot."""
    if found is None:
        return []
    rows = [("equilibrium: residual", f"{found.posture.residual:.2g}", "largest force not balanced, over the largest that acts")]
    if found.posture.balance.load.is_held:
        rows.append(("equilibrium: loops", f"{found.posture.loop_error:.2g}", "largest gap of a loop, in m or rad"))
    return rows


def robot_facts(found: RobotScene | None) -> tuple[tuple[str, str], ...]:
    """Where the robot is from; nothing without one."""
    return (("robot", f"{found.data.title}; {found.data.source}; licence {found.data.licence}"),) if found else ()


def posture_json(found: RobotScene | None) -> dict:
    """The robot and its posture as plain data; nothing without a robot."""
    if found is None:
        return {}
    data, posture = found.data, found.posture
    return {
        "robot": {"name": data.name, "title": data.title, "source": data.source, "licence": data.licence},
        "posture": {
            "joints": {name: list(value) if isinstance(value, tuple) else value for name, value in posture.joints.items()},
            "torques": dict(posture.torques),
            "reactions": {name: [float(entry) for entry in value] for name, value in posture.reactions.items()},
            "residual": posture.residual,
            "loop_error": posture.loop_error,
        },
    }


def _joint_table(found: RobotScene) -> TextTable:
    torques = dict(zip(found.posture.torques, _cleaned(found.posture.torques.values())))
    columns = ("joint", "rests at", "held with") if torques else ("joint", "rests at")
    rows = []
    for name, value in found.posture.joints.items():
        unit = found.data.names.units.get(name, "")
        held = sized(torques[name], FORCE[unit].replace("*", " ")) if name in torques else ""
        rows.append((name, _place(value, unit), held)[: len(columns)])
    return TextTable("Posture", columns, tuple(rows))


def _place(value, unit: str) -> str:
    if not isinstance(value, Sequence):
        return _single(value, unit)
    if len(value) == 3:  # of a planar joint
        return f"{_vector(_cleaned(value[:2]))} m, {_single(value[2], 'rad')}"
    return f"{_vector(_cleaned(value[:3]))} m, roll, pitch, yaw {_vector(_cleaned(_angles(value[3:])))} rad"


def _single(value: float, unit: str) -> str:
    (value,) = _cleaned([value])
    return f"{sized(value, unit)} ({degrees(value):.4g}°)" if unit == "rad" else sized(value, unit)


def _angles(quaternion) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a unit quaternion x, y, z, w, as a URDF writes rotations."""
    x, y, z, w = quaternion
    pitch = asin(max(-1.0, min(1.0, 2 * (w * y - x * z))))
    return atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), pitch, atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _cleaned(values) -> list[float]:
    """Places or torques, those that are rounding as 0."""
    largest = max([1.0, *map(abs, values)])
    return [value if abs(value) > ROUNDING * largest else 0.0 for value in values]


def _loop_table(found: RobotScene) -> TextTable:
    reactions = found.posture.reactions
    largest = max((abs(entry) for value in reactions.values() for entry in value), default=0.0)
    loops = {loop.name: loop for loop in found.robot.loops}
    rows = []
    for name, value in reactions.items():
        clean = [entry if abs(entry) > ROUNDING * largest else 0.0 for entry in value]
        torque = "" if loops[name].kind == "point" else f"{_vector(clean[3:])} N m"
        rows.append((name, loops[name].body2, f"{_vector(clean[:3])} N", torque))
    note = "x, y, z of the loop's frame on its first body; reactions during the motion come on top."
    if not any(row[3] for row in rows):
        return TextTable("Loop forces at rest", ("loop", "on", "force"), tuple(row[:3] for row in rows), note)
    return TextTable("Loop forces at rest", ("loop", "on", "force", "torque"), tuple(rows), note)


def _vector(values) -> str:
    return f"({', '.join(number(value) for value in values)})"
