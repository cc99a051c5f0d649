"""Values of a robot.toml whose units depend on the joint they belong to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ..errors import InputError
from ..models.element import GROUND
from .units import quantity, shown

if TYPE_CHECKING:
    from .robot_urdf import UrdfNames

STIFFNESS = {"rad": "N*m/rad", "m": "N/m"}
DAMPING = {"rad": "N*m*s/rad", "m": "N*s/m"}
FORCE = {"rad": "N*m", "m": "N"}
PLACE = {"rad": "rad", "m": "m"}
BASE = "base"
POSE_UNITS = ("m", "m", "m", "rad", "rad", "rad")


@contextmanager
def of(name: str) -> Iterator[None]:
    """Put a name in front of what is said about its value."""
    try:
        yield
    except InputError as problem:
        raise InputError(f"{name}: {problem}") from None


def joint_values(values: Mapping, names: UrdfNames, units: Mapping[str, str]) -> dict[str, float]:
    """The values of joints in SI, by name."""
    found = {}
    for name, value in values.items():
        unit = names.joint_unit(name)
        with of(name):
            found[name] = quantity(value, units[unit])
    return found


def guess_values(values: Mapping, names: UrdfNames, free_base: bool) -> dict:
    """The values of joints, and the pose of a free base under "base"."""
    joints = {name: value for name, value in values.items() if not (free_base and name == BASE)}
    found = joint_values(joints, names, PLACE)
    if len(joints) < len(values):
        with of(BASE):
            found[BASE] = _pose(values[BASE])
    return found


def _pose(value) -> tuple[float, ...]:
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) not in (6, 7):
        raise InputError(f"found {shown(value)}; expected [x, y, z, roll, pitch, yaw], or x, y, z and a quaternion x, y, z, w")
    units = POSE_UNITS if len(value) == 6 else ("m", "m", "m", "1", "1", "1", "1")
    return tuple(quantity(entry, unit) for entry, unit in zip(value, units))


def held(value, names: UrdfNames):
    """Names of joints, or "all"."""
    if value == "all":
        return value
    for name in value:
        names.joint_unit(name)
    return tuple(value)


def given(entry, *left_out: str) -> dict:
    """What stands in a table, ready for a function of the same names."""
    values = {key: getattr(entry, key) for key in type(entry).model_fields if key in entry.model_fields_set and key not in left_out}
    return {key: tuple(value) if isinstance(value, list) else value for key, value in values.items() if value is not None}


def connection(kind: type, entry, names: UrdfNames):
    """A Loop, BodySpring or Bushing."""
    for key in ("body1", "body2"):
        with of(key):
            names.check_body(getattr(entry, key), GROUND)
    return kind(**{"point2": None, **given(entry)})


def flexible_joint(name: str, entry, names: UrdfNames):
    """A FlexibleJoint; its units are those of its joint."""
    from ..models.robot import FlexibleJoint

    unit = names.joint_unit(name)
    values = given(entry)
    for keys, units in ((("stiffness", "proportional_gain"), STIFFNESS), (("damping", "derivative_gain"), DAMPING)):
        for key in values.keys() & set(keys):
            with of(key):
                values[key] = quantity(values[key], units[unit])
    return FlexibleJoint(**values)


def point_motion(entry, names: UrdfNames):
    """A PointMotion."""
    from ..models.robot import PointMotion

    names.check_body(entry.body)
    return PointMotion(entry.body, tuple(entry.point), tuple(entry.along), entry.turn)


def body_forces(entries, names: UrdfNames) -> dict:
    """Forces on bodies in SI, by PointMotion."""
    found = {}
    for number, entry in enumerate(entries, 1):
        with of(f"body_force[{number}]"):
            motion = point_motion(entry, names)
            found[motion] = found.get(motion, 0.0) + quantity(entry.value, "N*m" if entry.turn else "N")
    return found
