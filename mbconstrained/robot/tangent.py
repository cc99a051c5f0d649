"""The coordinates of a robot: names, units, and configurations given by name.

A configuration (nq numbers, with unit quaternions and cosines) is not a vector; small motions about it are. The nv
tangent coordinates are the angle or displacement of each joint with one degree of freedom, and for a free body the translation
along and the rotation about its own axes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..ground.by_name import Public
from ..ground.checks import counted, nearest, real_array, real_number
from ..ground.errors import InputError
from ..ground.tolerances import SAME_JOINT_VALUE
from .description.urdf import Mimic, of_first_leader

BASE = "base"

#: Number of joints beyond their limits that are named; the others are counted.
MOST_OUTSIDE = 3

#: Suffixes of the names of the coordinates of joints with several degrees of freedom, and the numbers that give a configuration.
_SEVERAL = {
    "JointModelPlanar": ((" x", " y", " rz"), "x, y and an angle"),
    "JointModelTranslation": ((" x", " y", " z"), "x, y, z"),
    "JointModelSpherical": ((" rx", " ry", " rz"), "roll, pitch, yaw, or a quaternion x, y, z, w"),
    "JointModelFreeFlyer": (
        (" x", " y", " z", " rx", " ry", " rz"),
        "x, y, z, roll, pitch, yaw, or x, y, z and a quaternion x, y, z, w",
    ),
}


class Tangent:
    """Names of the joints of a pinocchio model and of their tangent coordinates."""

    def __init__(self, model, free_base: bool, locked: tuple[str, ...] = ()):
        self.model = model
        self.locked = locked
        names = [str(name) for name in model.names]
        if free_base:
            names[1] = BASE
        self.joints = tuple(names[1:])
        for name in self.joints:
            if self.joints.count(name) > 1 or (name in self.coordinates and self.coordinates.count(name) > 1):
                raise InputError(f'urdf: the joint "{name}" has the name of the free base or of one of its motions; choose another')

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the nv tangent coordinates."""
        return tuple(f"{name}{suffix}" for name, joint in self._each() for suffix in _suffixes(joint))

    @cached_property
    def units(self) -> tuple[str, ...]:
        """ "m" or "rad" for each of them."""
        return tuple(unit for _, joint in self._each() for unit in _units(joint))

    def place(self, name: str, what: str) -> int:
        """The place of a joint with one degree of freedom among the coordinates."""
        if name in self.coordinates:
            return self.coordinates.index(name)
        if name in self.joints:
            several = ", ".join(self.coordinates_of(name))
            raise InputError(f'{what}: "{name}" has several degrees of freedom; name one of {several}')
        if name in self.locked:
            raise InputError(f'{what}: the joint "{name}" is locked; leave it out, or do not lock it')
        raise InputError(f'{what}: there is no joint "{name}"{nearest(name, (*self.joints, *self.coordinates))}')

    def vector(self, values: Mapping[str, float], what: str, **limits) -> np.ndarray:
        """Numbers by coordinate as a vector, zero for the others."""
        vector = np.zeros(self.model.nv)
        for name, value in _mapping(values, what).items():
            vector[self.place(name, what)] = real_number(value, f"{what} of {name}", **limits)
        return vector

    def configuration(self, values, what: str = "guess") -> np.ndarray:
        """q from a mapping of joint names to values, zero for the others; or all nq numbers of it.

        A free body takes x, y, z, roll, pitch, yaw or x, y, z and a quaternion x, y, z, w; one that slides in a plane
        x, y and its angle.
        """
        import pinocchio

        q = pinocchio.neutral(self.model)
        if not isinstance(values, Mapping):
            return pinocchio.normalize(self.model, self._whole(values, what))
        for name, value in self._by_joint(values, what).items():
            if name not in self.joints:
                locked = "; it is locked" if name in self.locked else nearest(name, self.joints)
                raise InputError(f'{what}: there is no joint "{name}" that moves{locked}')
            joint = self.model.joints[self.joints.index(name) + 1]
            q[joint.idx_q : joint.idx_q + joint.nq] = _joint_configuration(joint, value, f"{what} of {name}")
        return q

    def _by_joint(self, values: Mapping, what: str) -> Mapping:
        """The values by joint, with those of the coordinates of a joint with several degrees of freedom collected, 0 where omitted."""
        collected: dict = {}
        for name, value in values.items():
            joint = next((joint for joint in self.joints if name != joint and name in self.coordinates_of(joint)), None)
            if joint in values:
                raise InputError(f'{what}: found "{name}" and "{joint}"; give one of them')
            if joint is None:
                collected[name] = value
            else:
                own = self.coordinates_of(joint)
                collected.setdefault(joint, [0.0] * len(own))[own.index(name)] = real_number(value, f"{what} of {name}")
        return collected

    def coordinates_of(self, joint: str) -> tuple[str, ...]:
        """The names of the coordinates of a joint; rx, ry and rz are roll, pitch and yaw where values are given."""
        model = self.model.joints[self.joints.index(joint) + 1]
        return self.coordinates[model.idx_v : model.idx_v + model.nv]

    def values(self, q: np.ndarray) -> dict[str, float | tuple[float, ...]]:
        """Values by joint, the inverse of ``configuration``: a number, or the numbers of a joint with several degrees of freedom."""
        return {name: _joint_value(joint, q[joint.idx_q : joint.idx_q + joint.nq]) for name, joint in self._each()}

    def angles(self, q: np.ndarray) -> np.ndarray:
        """Value of the joint of each coordinate (rad, m), 0 for joints with several degrees of freedom, shape (nv,)."""
        return joint_displacements(self.model, q, np.zeros(self.model.nv))

    @cached_property
    def limits(self) -> dict[str, tuple[float, float]]:
        """Lower and upper limit of each joint that has any; the largest float64 number means none in pinocchio."""
        ends = np.array([self.model.lowerPositionLimit, self.model.upperPositionLimit])
        low, high = np.where(np.abs(ends) < np.finfo(float).max, ends, np.copysign(np.inf, ends))
        return {
            name: (float(low[joint.idx_q]), float(high[joint.idx_q]))
            for name, joint in self._each()
            if joint.nq == 1 and low[joint.idx_q] < high[joint.idx_q] and np.isfinite([low[joint.idx_q], high[joint.idx_q]]).any()
        }

    def outside_limits(self, values: Mapping[str, Any], tolerance: float, share: float = 0.0) -> str:
        """Text about the joints beyond their limits, with the first of them; empty without any."""
        outside = []
        for name, (low, high) in self.limits.items():
            allowed = tolerance + (share * (high - low) if np.isfinite(high - low) else 0.0)
            if not low - allowed <= values[name] <= high + allowed:
                unit = self.units[self.coordinates.index(name)]
                outside.append(f'"{name}" at {values[name]:.6g} {unit} (limits {low:.6g} ... {high:.6g})')
        one = len(outside) == 1
        first = f"{counted(len(outside), 'joint')} {'is' if one else 'are'} beyond {'its' if one else 'their'} limits: "
        return f"{first}{', '.join(outside[:MOST_OUTSIDE])}{' ...' if len(outside) > MOST_OUTSIDE else ''}" if outside else ""

    def _each(self):
        return zip(self.joints, list(self.model.joints)[1:])

    def _whole(self, values, what: str) -> np.ndarray:
        q = real_array(values, what, shape=(self.model.nq,))
        for name, joint in self._each():
            turn = q[joint.idx_q + _units(joint).count("m") : joint.idx_q + joint.nq]
            if joint.nq != joint.nv and not np.any(turn):
                raise InputError(f"{what}: the numbers of {name} that stand for its rotation are all 0")
        return q


def _mapping(values, what: str) -> Mapping:
    if values is None:
        return {}
    if not isinstance(values, Mapping):
        raise InputError(f'{what}: found {type(values).__name__}; expected numbers by joint, such as {{"j1": 1.2}}')
    return values


def _units(joint) -> tuple[str, ...]:
    if joint.nv == 1:
        return ("m",) if joint.shortname().startswith("JointModelP") else ("rad",)
    return tuple("rad" if suffix.startswith(" r") else "m" for suffix in _suffixes(joint))


def _suffixes(joint) -> tuple[str, ...]:
    """Suffixes of the names of a joint's coordinates."""
    return ("",) if joint.nv == 1 else _SEVERAL[joint.shortname()][0]


def _joint_configuration(joint, value, what: str) -> np.ndarray:
    import pinocchio

    if joint.nv == 1:
        value = real_number(value, what)
        return np.array([value] if joint.nq == 1 else [np.cos(value), np.sin(value)])
    numbers = real_array(value, what, shape=(None,))
    shifts = _units(joint).count("m")
    turn, turns = numbers[shifts:], joint.nv - shifts
    if turns == 3 and len(turn) == 4 and turn.any():
        turn = turn / np.linalg.norm(turn)
    elif len(numbers) != joint.nv:
        raise InputError(f"{what}: found {len(numbers)} numbers; expected {_SEVERAL[joint.shortname()][1]}")
    elif turns == 3:
        turn = pinocchio.Quaternion(pinocchio.rpy.rpyToMatrix(*turn)).coeffs()
    elif turns == 1:
        turn = np.array([np.cos(turn[0]), np.sin(turn[0])])
    return np.concatenate([numbers[:shifts], turn])


def _joint_value(joint, q: np.ndarray):
    if joint.nq == joint.nv == 1:
        return float(q[0])
    if joint.nq == 2:
        return float(np.arctan2(q[1], q[0]))
    is_planar = joint.shortname() == "JointModelPlanar"
    return (*q[:2].tolist(), float(np.arctan2(q[3], q[2]))) if is_planar else tuple(q.tolist())


@dataclass(frozen=True)
class MimicRow:
    """A mimic joint as a constraint row: q_follower - multiplier q_leader - offset = 0.

    Attributes:
        name: name of the row.
        unit: unit of the follower, "m" or "rad".
        follower, leader: numbers of joints in the model.
        multiplier, offset: of the leader's value, and added to it.
    """

    name: str
    unit: str
    follower: int
    leader: int
    multiplier: float
    offset: float

    def gap(self, model, configuration: np.ndarray) -> float:
        """The left side (rad, m); for continuous joints the smallest angle modulo a full turn."""
        leader = joint_displacement(model.joints[self.leader], configuration, 0.0)
        return joint_displacement(model.joints[self.follower], configuration, self.multiplier * leader + self.offset)

    def row(self, model) -> np.ndarray:
        """The derivative of the row, shape (nv,)."""
        row = np.zeros(model.nv)
        row[model.joints[self.follower].idx_v] = 1.0
        row[model.joints[self.leader].idx_v] -= self.multiplier
        return row


@dataclass(frozen=True)
class JointGear(Public):
    """A gear or rack between two joints: q_joint = ratio q_leader + offset.

    Attributes:
        joint: the joint that follows.
        leader: the joint that it follows, which may follow another one.
        ratio: -2 for a gear that turns twice as fast in the other direction; the radius of the pinion (m) for a rack.
        offset: the value of the joint where that of the leader is 0 (rad, m).

    >>> JointGear("rack", "pinion", ratio=0.05).ratio
    0.05
    """

    joint: str
    leader: str
    ratio: float
    offset: float = 0.0

    def __post_init__(self):
        for key in ("ratio", "offset"):
            object.__setattr__(self, key, real_number(getattr(self, key), f'gear of "{self.joint}": {key}'))


def geared(gears, mimics: tuple[Mimic, ...], joints: Mapping[str, bool]) -> tuple[Mimic, ...]:
    """The mimic joints of the URDF, followed by the gears."""
    if isinstance(gears, JointGear) or not all(isinstance(one, JointGear) for one in gears):
        raise InputError("gears: expected a list of mb.JointGear(joint, leader, ratio)")
    added = tuple(Mimic(one.joint, one.leader, one.ratio, one.offset) for one in gears)
    followers = [mimic.follower for mimic in (*mimics, *added)]
    for one in added:
        for name in (one.follower, one.leader):
            if not joints.get(name):
                what = "has not one degree of freedom" if name in joints else "is no joint"
                raise InputError(f'gears: "{name}" {what}{nearest(name, [key for key, single in joints.items() if single])}')
        if followers.count(one.follower) > 1:
            raise InputError(f'gears: "{one.follower}" follows "{one.leader}" and another joint; expected one leader')
    by_follower = {mimic.follower: mimic for mimic in (*mimics, *added)}
    return (*mimics, *(of_first_leader(one, by_follower) for one in added))


def locked_values(locked, mimics: tuple[Mimic, ...]) -> dict[str, float]:
    """Values of the locked joints and of the joints that follow them."""
    if locked is not None and not isinstance(locked, Mapping):
        raise InputError(f'locked: found {type(locked).__name__}; expected values by joint, such as {{"j4": 0.3}}')
    values = {name: real_number(value, f"locked: {name}") for name, value in (locked or {}).items()}
    for mimic in mimics:
        if mimic.leader in values or mimic.leader_is_fixed:
            follows = mimic.multiplier * values.get(mimic.leader, 0.0) + mimic.offset
            if abs(values.setdefault(mimic.follower, follows) - follows) > SAME_JOINT_VALUE * max(1.0, abs(follows)):
                raise InputError(
                    f'locked: "{mimic.follower}" follows "{mimic.leader}" and is then at {follows:.6g}; found '
                    f"{values[mimic.follower]:.6g}: leave it out"
                )
        elif mimic.follower in values:
            raise InputError(f'locked: "{mimic.follower}" follows "{mimic.leader}", which moves; lock that joint instead')
    return values


def mimic_rows(mimics: tuple[Mimic, ...], tangent: Tangent) -> tuple[MimicRow, ...]:
    """The mimic rows between moving joints, without those of a locked joint."""
    rows = []
    for mimic in mimics:
        if mimic.follower in tangent.coordinates and mimic.leader in tangent.coordinates:
            numbers = [tangent.joints.index(name) + 1 for name in (mimic.follower, mimic.leader)]
            unit = tangent.units[tangent.coordinates.index(mimic.follower)]
            rows.append(MimicRow(f"{mimic.follower} follows {mimic.leader}", unit, *numbers, mimic.multiplier, mimic.offset))
    return tuple(rows)


def joint_displacement(joint, configuration: np.ndarray, rest: float) -> float:
    """The displacement of a joint with one degree of freedom from a value (rad, m)."""
    value = configuration[joint.idx_q : joint.idx_q + joint.nq]
    if joint.nq == 1:
        return float(value[0] - rest)
    c, s = np.cos(rest), np.sin(rest)
    return float(np.arctan2(c * value[1] - s * value[0], c * value[0] + s * value[1]))


def joint_displacements(model, configuration: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """The displacement of each joint with one degree of freedom from its value in ``rest``, shape (nv,), 0 for others."""
    displacements = np.zeros(model.nv)
    for joint in list(model.joints)[1:]:
        if joint.nv == 1:
            displacements[joint.idx_v] = joint_displacement(joint, configuration, rest[joint.idx_v])
    return displacements
