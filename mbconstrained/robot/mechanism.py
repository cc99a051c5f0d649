"""Links, loops and springs of a robot attached to the joints of its model: names are resolved to indices."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..ground.checks import nearest
from ..ground.coordinate_units import GROUND
from ..ground.errors import InputError
from .connections import BodySpring, Connection, Loop, PointMotion
from .description.urdf import HIDDEN
from .kinematics import Anchor, Kinematics, RelativePose


@dataclass(frozen=True)
class Attached:
    """A connection with resolved frames.

    Attributes:
        connection: a Loop, BodySpring or Bushing.
        first, second: its frames.
        rest_length: of a BodySpring or a rod (m), otherwise 0.
    """

    connection: Any
    first: Anchor
    second: Anchor
    rest_length: float = 0.0

    def pose(self, kinematics: Kinematics) -> RelativePose:
        """phi in a configuration."""
        return RelativePose(kinematics, self.first, self.second, self.connection.turning)


class LinkFrames:
    """The links of a pinocchio model, each fixed in one of its joints; masses by link (kg)."""

    def __init__(self, model, masses: Mapping[str, float]):
        import pinocchio

        self._masses, self._supports = masses, [list(support) for support in model.supports]
        frames = [(number, frame) for number, frame in enumerate(model.frames) if frame.type == pinocchio.FrameType.BODY]
        frames = [(number, frame) for number, frame in frames if not str(frame.name).startswith(HIDDEN)]
        self._frames = {str(frame.name): frame for _, frame in frames}
        self._numbers = {str(frame.name): number for number, frame in frames}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the links."""
        return tuple(self._frames)

    def number(self, body: str) -> int:
        """Index of the frame of a link."""
        return self._numbers[body]

    def heaviest_links(self) -> dict[int, str]:
        """The heaviest link that moves with each joint, the first of several, by the index of the joint."""
        heaviest: dict[int, str] = {}
        for body in self.names:
            joint = self.link(body).joint
            if joint not in heaviest or self._masses.get(body, 0.0) > self._masses.get(heaviest[joint], 0.0):
                heaviest[joint] = body
        return heaviest

    def link_behind(self, joint: int) -> str:
        """The heaviest link that moves with a joint, or else the first one behind it, as between axes of a universal joint."""
        heaviest = self.heaviest_links()
        return heaviest.get(joint) or next(body for number, body in heaviest.items() if joint in self._supports[number])

    def link(self, body: str) -> Anchor:
        """The frame of a link, or of the ground, in the joint that carries it."""
        return self.anchor(body, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), "body")

    def anchor(self, body: str, point, rotation, what: str) -> Anchor:
        """A frame given in a link, in the joint that carries the link."""
        import pinocchio

        rotation = pinocchio.rpy.rpyToMatrix(*rotation)
        if body == GROUND:
            return Anchor(0, rotation, np.array(point))
        self.check(body, what)
        frame = self._frames[body]
        link = np.array(frame.placement.rotation)
        return Anchor(int(frame.parentJoint), link @ rotation, frame.placement.translation + link @ np.array(point))

    def point(self, motion: PointMotion, what: str) -> Anchor:
        """The point of an input or output."""
        self.check(motion.body, what)
        return self.anchor(motion.body, motion.point, (0.0, 0.0, 0.0), what)

    def check(self, body: str, what: str) -> None:
        """Raise an InputError where no link has this name."""
        if body == GROUND:
            raise InputError(f'{what}: found "{GROUND}", which does not move; name a link')
        if body not in self._frames:
            raise InputError(f'{what}: there is no body "{body}"{nearest(body, (GROUND, *self.names))}')

    def attached(self, connection: Connection, guess: Kinematics) -> Attached:
        """A connection with its frames; an omitted point coincides with the other one at the guess."""
        nowhere, label = (0.0, 0.0, 0.0), connection.label
        first = self.anchor(connection.body1, connection.point1 or nowhere, connection.rotation1, label)
        second = self.anchor(connection.body2, connection.point2 or nowhere, connection.rotation2, label)
        if connection.point1 is not None and connection.point2 is not None:
            return Attached(connection, first, second)
        (rotation, place), (own, end) = guess.frame(first), guess.frame(second)
        if connection.point2 is None:
            second = replace(second, point=second.point + second.rotation @ own.T @ (place - end))
        else:
            first = replace(first, point=first.point + first.rotation @ rotation.T @ (end - place))
        return Attached(connection, first, replace(second, rotation=second.rotation @ own.T @ rotation))


#: Loops that turn about their axis.
TURNING = ("hinge", "cylindrical")


def untwisted(attached: Attached, at: Kinematics) -> Attached:
    """The connection with the second frame of a hinge turned about its axis, so that the hinge is at angle 0 in a configuration.

    The multipliers of its rows are then torques, and its rotation vector is far from its jump at pi.
    """
    import pinocchio

    loop = attached.connection
    if not isinstance(loop, Loop) or loop.kind not in TURNING:
        return attached
    axis = np.array(loop.axis)
    R1, R2 = at.frame(attached.first)[0], at.frame(attached.second)[0]
    *v, w = pinocchio.Quaternion(R1.T @ R2).coeffs()
    back = pinocchio.exp3(-2 * np.arctan2(axis @ np.array(v), w) * axis)
    return replace(attached, second=replace(attached.second, rotation=attached.second.rotation @ back))


def with_rest_length(attached: Attached, guess: Kinematics) -> Attached:
    """The connection with the length of a rod, or with the rest length of a spring given by its preload, at the guess."""
    spring = attached.connection
    if isinstance(spring, Loop) and spring.kind == "rod":
        distance = float(np.linalg.norm(attached.pose(guess).value[:3]))
        return replace(attached, rest_length=distance if spring.length is None else spring.length)
    if not isinstance(spring, BodySpring):
        return attached
    if spring.rest_length is not None:
        return replace(attached, rest_length=spring.rest_length)
    length = float(np.linalg.norm(attached.pose(guess).value[:3]))
    slack = (spring.preload or 0.0) / spring.stiffness if spring.stiffness else 0.0
    if slack > length:
        raise InputError(
            f"{spring.label}: with a preload of {spring.preload:g} N and {length:.6g} m length at the guess its rest length "
            "would be negative; give a smaller preload or a greater stiffness"
        )
    return replace(attached, rest_length=length - slack)


def checked_connections(
    connections, kinds: tuple[type[Connection], ...], word: str, frames: LinkFrames, others: Sequence[Connection] = ()
) -> tuple[Connection, ...]:
    """Loops or springs, checked, each with a distinct name."""
    wanted = " or ".join(f"mb.{kind.__name__}" for kind in kinds)
    if isinstance(connections, Connection) or not isinstance(connections, Iterable):
        raise InputError(f"{word}: found {type(connections).__name__}; expected a list of {wanted}(...)")
    given: tuple[Connection, ...] = tuple(connections)
    for connection in given:
        if not isinstance(connection, kinds):
            raise InputError(f"{word}: found {type(connection).__name__}; make each with {wanted}(...)")
        for body in (connection.body1, connection.body2):
            if body != GROUND:
                frames.check(body, connection.label)
    return _with_distinct_names(given, [connection.name for connection in others])


def _with_distinct_names(connections, others) -> tuple[Connection, ...]:
    """The connections with distinct names: equal names get numbers."""
    names = [*others, *(connection.name for connection in connections)]
    distinct, used = [], set(names)
    for connection in connections:
        if names.count(connection.name) > 1:
            numbered = (f"{connection.name} {number}" for number in range(1, 2 * len(names) + 1))
            connection = replace(connection, name=next(name for name in numbered if name not in used))
            used.add(connection.name)
        distinct.append(connection)
    return tuple(distinct)
