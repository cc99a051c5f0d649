"""Connections of two bodies of a robot besides its joints: loop closures, springs, bushings, tendons; motions of points.

A connection is a function of the pose of a frame on the second body relative to a frame on the first,

    phi = [R1^T (p2 - p1); log(R1^T R2)]        (m; rad, a rotation vector)

A loop constrains rows of phi to zero; springs and bushings have an energy of phi.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, Literal, get_args

import numpy as np

from ..ground.by_name import Public
from ..ground.checks import nearest, real_array, real_number
from ..ground.errors import InputError
from ..ground.units import GROUND
from ..linalg.arrays import block_diag
from .description.urdf import HIDDEN
from .kinematics import Anchor, Kinematics, RelativePose, directions_across, turned_product
from .tangent import Tangent, joint_displacements

LoopKind = Literal["point", "rigid", "hinge", "prismatic", "cylindrical", "universal", "rod"]
Vector = Sequence[float]

AXES = ("x", "y", "z", "rx", "ry", "rz")

#: Place and directions of the own frame of a body, and constants of no spring.
ZEROS = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Connection(Public):
    """The base of all connections: two frames, each fixed in a body.

    Attributes:
        body1, body2: names of links, or "ground".
        point1, point2: origins of the frames in their links (m). One that is None lies where the other is at the guess from which
            the equilibrium is sought, before loops are closed, and the second frame then has the directions of the first.
        rotation1, rotation2: directions of the frames in their links: roll, pitch, yaw (rad) as in a URDF.
        name: for messages and results; made from the bodies when not given.
    """

    body1: str
    point1: Vector | None
    body2: str
    point2: Vector | None = None
    rotation1: Vector = field(default=ZEROS, kw_only=True)
    rotation2: Vector = field(default=ZEROS, kw_only=True)
    name: str | None = field(default=None, kw_only=True)

    word = "connection"
    turning: ClassVar[Any] = True  # whether it depends on the rotation of its frames
    between_points: ClassVar[Any] = ""  # its name where it is along the line between two points

    def __post_init__(self):
        for key in ("body1", "body2"):
            if not isinstance(getattr(self, key), str):
                raise InputError(f'{self.word}: {key}: found {getattr(self, key)!r}; expected the name of a link, or "ground"')
        self._set("name", str(self.name) if self.name is not None else f"{self.body1}-{self.body2}")
        missing = [key for key in ("point1", "point2") if getattr(self, key) is None]
        for key in ("point1", "rotation1", "point2", "rotation2"):
            if key not in missing:
                self._set_vector(key)
        if len(missing) == 2 or (missing and self.between_points):
            body = self.body1 if missing[0] == "point1" else self.body2
            reason = (
                f"a {self.between_points} needs the point on {body} that it ends at"
                if self.between_points
                else "give one of both points"
            )
            raise InputError(f"{self.label}: {missing[0]} is missing; {reason}")
        if missing and any(self.rotation2):
            raise InputError(f"{self.label}: found rotation2 without {missing[0]}; give both, or neither")
        if self.body1 == self.body2:
            raise InputError(f'{self.label}: both ends are on "{self.body1}"; name two bodies')

    @property
    def label(self) -> str:
        """Label of the connection in messages."""
        return f'{self.word} "{self.name}"'

    def _set(self, key: str, value) -> None:
        object.__setattr__(self, key, value)  # a frozen dataclass

    def _set_vector(self, key: str, **limits) -> None:
        vector = real_array(getattr(self, key), f"{self.label}: {key}", shape=(3,))
        for entry in vector:
            real_number(entry, f"{self.label}: {key.replace('_', ' ')}", **limits)
        self._set(key, tuple(vector.tolist()))


@dataclass(frozen=True)
class Support(Connection):
    """A connection that may be a foot in contact with the ground.

    Attributes:
        friction: coefficient of friction of a foot on the ground, in which case its force at rest is checked: a note reports one
            outside of the cone about ``normal``, or one that pulls.
        normal: of the contact, on the foot, in the directions of the ground.
        patch: of a foot that cannot turn freely, the extents of its sole along x and y of the frame on body1 about the point (m): a
            note reports a centre of pressure outside of it, where the foot tips over.
    """

    friction: float | None = field(default=None, kw_only=True)
    normal: Vector = field(default=(0.0, 0.0, 1.0), kw_only=True)
    patch: Sequence[float] | None = field(default=None, kw_only=True)

    has_sole: ClassVar[Any] = False  # whether it has torques about all axes

    def __post_init__(self):
        super().__post_init__()
        self._set_vector("normal")
        if self.friction is not None:
            self._set("friction", real_number(self.friction, f"{self.label}: friction", minimum=0.0))
            if GROUND not in (self.body1, self.body2) or not any(self.normal):
                raise InputError(f'{self.label}: friction is checked of a foot on the "{GROUND}", with a normal other than 0, 0, 0')
        if self.patch is not None:
            extents = real_array(self.patch, f"{self.label}: patch", shape=(2,)).tolist()
            if not self.has_sole or self.friction is None or min(extents) <= 0:
                wanted = "two lengths of the sole of a foot with friction that is rigid or has springs about all axes"
                raise InputError(f"{self.label}: patch: found {self.patch}; expected {wanted}")
            self._set("patch", tuple(extents))

    @property
    def unit_normal(self) -> np.ndarray:
        """The normal on the foot, of length 1, shape (3,)."""
        return np.array(self.normal) / np.linalg.norm(self.normal)

    def on_foot(self, wrench: np.ndarray) -> np.ndarray:
        """A force or wrench on the foot, from that on body2."""
        return wrench if self.body1 == GROUND else -wrench

    def parts(self, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The pressure along the normal and the magnitude of the tangential force, both (T,), of a force (3, T) on the foot."""
        along = self.unit_normal @ force
        return along, np.linalg.norm(force - np.outer(self.unit_normal, along), axis=0)


@dataclass(frozen=True)
class Loop(Support):
    """A joint that closes a loop: rows of phi (see the module) constrained to 0.

    Attributes:
        kind: "point": the points coincide (3 rows); "rigid": the frames coincide (6 rows); "hinge": they coincide but for
            a turn about the axis (5 rows); "prismatic": but for a displacement along it (5 rows); "cylindrical": but for both
            (4 rows); "universal": the points coincide and two axes, one in each body, stay at right angles, as of a Cardan joint
            (4 rows); "rod": the points keep a distance (1 row).
        axis: of a hinge, prismatic or cylindrical loop, in the frame on body1 and the same in that on body2; of any length but zero.
            Of a universal loop that in the frame on body1.
        axis2: of a universal loop that in the frame on body2.
        length: length of a rod (m); that at the guess when not given.

    The multiplier of a row is the force (N) or torque (N m) on body2, against that on body1, in the frame on body1; torques
    of a hinge that turns are in the frame half-way between the two. That of a rod is its compression (N).

    >>> Loop("coupler", (0.5, 0, 0), "rocker", (0.4, 0, 0)).name
    'coupler-rocker'
    """

    kind: LoopKind = "point"
    axis: Vector = (0.0, 0.0, 1.0)
    axis2: Vector = (1.0, 0.0, 0.0)
    length: float | None = None

    word = "loop"

    def __post_init__(self):
        super().__post_init__()
        if self.kind not in (kinds := get_args(LoopKind)):
            raise InputError(f"{self.label}: found the kind {self.kind!r}{nearest(self.kind, kinds)}; expected {', '.join(kinds)}")
        self._set_direction("axis")
        self._set_direction("axis2")
        if self.length is not None:
            self._set("length", real_number(self.length, f"{self.label}: length", positive=True))
            if self.kind != "rod":
                raise InputError(f"{self.label}: length belongs to a rod; leave it out")

    def _set_direction(self, key: str) -> None:
        self._set_vector(key)
        if not (largest := max(map(abs, getattr(self, key)))):
            raise InputError(f"{self.label}: {key}: found 0, 0, 0; expected a direction")
        direction = np.array(getattr(self, key)) / largest
        self._set(key, tuple((direction / np.linalg.norm(direction)).tolist()))

    @property
    def turning(self) -> bool:
        """Whether the connection depends on the rotation of its frames."""
        return self.kind not in ("point", "rod")

    @property
    def between_points(self) -> str:
        """Name of the connection, "rod" for rods."""
        return "rod" if self.kind == "rod" else ""

    @property
    def has_sole(self) -> bool:
        """Whether the loop is rigid."""
        return self.kind == "rigid"

    @cached_property
    def _parts(self) -> tuple[np.ndarray, np.ndarray]:
        """The directions of phi that are constrained: displacements (k, 3), then rotations (l, 3)."""
        across, none, every = directions_across(self.axis), np.zeros((0, 3)), np.eye(3)
        moves = {"prismatic": across, "cylindrical": across, "rod": every[:1]}.get(self.kind, every)
        turns = {"point": none, "rod": none, "hinge": across, "cylindrical": across, "universal": every[:1]}.get(self.kind, every)
        return moves, turns

    @cached_property
    def rows(self) -> np.ndarray:
        """The combinations of phi that are constrained to 0, shape (k, 6); of a rod and of the axes of a universal loop, the place of
        the row."""
        return block_diag(*self._parts)

    def gaps(self, phi: np.ndarray, length: float) -> np.ndarray:
        """The left sides of the rows (m, rad): rows @ phi, |p| - length of a rod, a1 . R a2 of universal axes, shape (k,).

        Args:
            phi: shape (6,).
            length: length of a rod (m).

        Returns:
            Zero where the loop is closed.
        """
        if self.kind == "rod":
            return np.array([np.linalg.norm(phi[:3]) - length])
        gaps = self.rows @ phi
        if self.kind == "universal":
            gaps[3] = turned_product(self.axis, self.axis2, phi[3:])[0]
        return gaps

    def gradient(self, phi: np.ndarray) -> np.ndarray:
        """Return the derivatives of the rows with respect to phi, shape (k, 6)."""
        if self.kind == "universal":
            gradient = self.rows.copy()
            gradient[3, 3:] = turned_product(self.axis, self.axis2, phi[3:])[1]
            return gradient
        if self.kind != "rod":
            return self.rows
        if not (distance := np.linalg.norm(phi[:3])):
            raise InputError(f"{self.label}: both its ends are at the same place, so that it has no direction; move one of them")
        return np.append(phi[:3] / distance, np.zeros(3))[None]

    def curvature(self, phi: np.ndarray, multipliers: np.ndarray) -> np.ndarray:
        """The second derivative of multipliers @ gaps by phi.

        Args:
            phi: shape (6,).
            multipliers: shape (k,).

        Returns:
            Shape (6, 6).
        """
        result = np.zeros((6, 6))
        if self.kind == "rod":
            along = self.gradient(phi)[0, :3]
            result[:3, :3] = multipliers[0] * (np.eye(3) - np.outer(along, along)) / np.linalg.norm(phi[:3])
        if self.kind == "universal":
            result[3:, 3:] = multipliers[3] * turned_product(self.axis, self.axis2, phi[3:])[2]
        return result

    @property
    def row_names(self) -> tuple[str, ...]:
        """Return the names of the rows."""
        names = []
        for part, axes, word in zip(self._parts, (AXES[:3], AXES[3:]), ("shift", "turn")):
            places = [np.flatnonzero(row) for row in part]
            single = all(len(place) == 1 for place in places)
            names += [axes[place[0]] if single else f"{word} {number}" for number, place in enumerate(places, 1)]
        if self.kind == "universal":
            names[3] = "right angle"
        return tuple(f"{self.name} {axis}" for axis in (("length",) if self.kind == "rod" else names))

    @property
    def row_units(self) -> tuple[str, ...]:
        """The unit of each row."""
        moves, turns = self._parts
        return ("m",) * len(moves) + ("rad",) * len(turns)


@dataclass(frozen=True)
class BodySpring(Connection):
    """A spring with a parallel damper along the line between two points: tension k (l - l0) + c l'.

    Attributes:
        stiffness: k (N/m).
        rest_length: l0 (m).
        preload: instead of it, the tension at the guess (N), negative for a spring under pressure. Without either there is
            no force at the guess.
        damping: c (N s/m).

    >>> BodySpring("slider", (0, 0, 0), "ground", (1, 0, 0), stiffness=300.0, rest_length=0.4).stiffness
    300.0
    """

    stiffness: float = 0.0
    rest_length: float | None = None
    preload: float | None = None
    damping: float = 0.0

    word = between_points = "spring"
    turning = False

    def __post_init__(self):
        super().__post_init__()
        self._set("stiffness", real_number(self.stiffness, f"{self.label}: stiffness", minimum=0.0))
        self._set("damping", real_number(self.damping, f"{self.label}: damping", minimum=0.0))
        if self.rest_length is not None:
            self._set("rest_length", real_number(self.rest_length, f"{self.label}: rest length", minimum=0.0))
        if self.preload is not None:
            self._set("preload", real_number(self.preload, f"{self.label}: preload"))
        if self.rest_length is not None and self.preload is not None:
            raise InputError(f"{self.label}: found both rest_length and preload; give one of them")
        if self.preload and not self.stiffness:
            raise InputError(f"{self.label}: found a preload but no stiffness; give a stiffness greater than zero")


@dataclass(frozen=True)
class Bushing(Support):
    """Springs and dampers in all directions between two frames: forces and torques K phi + D phi' (see the module).

    A foot on compliant ground is a bushing whose body1 is "ground" and whose point1 is left out: its springs have the directions of
    the ground, turned by rotation1, and are without force where the guess has the foot, from where its load presses them.

    Attributes:
        stiffness, turning_stiffness: along and about the axes of the frame on body1 (N/m, N m/rad).
        damping, turning_damping: damping coefficients (N s/m, N m s/rad).

    >>> Bushing("ground", None, "foot", (0, 0, -0.02), stiffness=(1e4, 1e4, 1e5), friction=0.7).stiffness
    (10000.0, 10000.0, 100000.0)
    """

    stiffness: Vector = ZEROS
    turning_stiffness: Vector = ZEROS
    damping: Vector = ZEROS
    turning_damping: Vector = ZEROS

    word = "bushing"

    def __post_init__(self):
        super().__post_init__()
        for key in ("stiffness", "turning_stiffness", "damping", "turning_damping"):
            self._set_vector(key, minimum=0.0)

    @property
    def turning(self) -> bool:
        """Whether it has torques."""
        return any(self.turning_stiffness) or any(self.turning_damping)

    @property
    def has_sole(self) -> bool:
        """Whether there are springs about all axes."""
        return all(self.turning_stiffness)


@dataclass(frozen=True)
class PointMotion(Public):
    """The displacement of a point of a body along a direction that is fixed in space, or its rotation about it.

    As an output it is that displacement (m) or small rotation (rad), as an input the force (N) or torque (N m) that works
    along it, which keeps its direction while the body turns.

    Attributes:
        body: a link.
        point: in the link's frame (m).
        along: the direction, in the directions of the ground; of any length but zero.
        turn: whether rotation and torque are meant.

    >>> PointMotion("tip", along=(0, 0, 2)).along
    (0.0, 0.0, 1.0)
    """

    body: str
    point: Sequence[float] = (0.0, 0.0, 0.0)
    along: Sequence[float] = (1.0, 0.0, 0.0)
    turn: bool = False

    def __post_init__(self):
        if not isinstance(self.body, str):
            raise InputError(f"point: found the body {self.body!r}; expected the name of a link")
        if not isinstance(self.turn, bool):
            raise InputError(f'point of "{self.body}": turn: found {self.turn!r}; expected True or False')
        where = f'point of "{self.body}"'
        point = real_array(self.point, f"{where}: point", shape=(3,))
        along = real_array(self.along, f"{where}: along", shape=(3,))
        length = np.linalg.norm(along)
        if not 0 < length < np.inf:
            raise InputError(f"{where}: along: found {self.along}; expected a direction")
        object.__setattr__(self, "point", tuple(point.tolist()))
        object.__setattr__(self, "along", tuple((along / length).tolist()))


@dataclass(frozen=True)
class Attached:
    """A connection with resolved frames."""

    connection: Any  # a Loop, BodySpring or Bushing
    # its frames
    first: Anchor
    second: Anchor
    rest_length: float = 0.0  # of a BodySpring or a rod (m), otherwise 0

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
        return self.anchor(body, "body")

    def anchor(self, body: str, what: str, point: Vector = ZEROS, rotation: Vector = ZEROS) -> Anchor:
        """A frame given in a link, in the joint that carries the link."""
        import pinocchio

        turn = pinocchio.rpy.rpyToMatrix(*rotation)
        if body == GROUND:
            return Anchor(0, turn, np.array(point))
        self.check(body, what)
        frame = self._frames[body]
        link = np.array(frame.placement.rotation)
        return Anchor(int(frame.parentJoint), link @ turn, frame.placement.translation + link @ np.array(point))

    def point(self, motion: PointMotion, what: str) -> Anchor:
        """The point of an input or output."""
        self.check(motion.body, what)
        return self.anchor(motion.body, what, motion.point)

    def check(self, body: str, what: str) -> None:
        """Raise an InputError where no link has this name."""
        if body == GROUND:
            raise InputError(f'{what}: found "{GROUND}", which does not move; name a link')
        if body not in self._frames:
            raise InputError(f'{what}: there is no body "{body}"{nearest(body, (GROUND, *self.names))}')

    def attached(self, connection: Connection, guess: Kinematics) -> Attached:
        """A connection with its frames; an omitted point coincides with the other one at the guess."""
        first = self.anchor(connection.body1, connection.label, connection.point1 or ZEROS, connection.rotation1)
        second = self.anchor(connection.body2, connection.label, connection.point2 or ZEROS, connection.rotation2)
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


@dataclass(frozen=True)
class Segment:
    """A straight line between points of two bodies (m), whose length counts ``factor`` times."""

    body1: str
    point1: tuple[float, ...]
    body2: str
    point2: tuple[float, ...]
    factor: float = 1.0


@dataclass(frozen=True)
class Tendon:
    """A spring with damper and inertia along L = sum(c q) + sum(factor |p2 - p1|), with the force a x + b x^2 + c x^3."""

    name: str  # name of the tendon
    joints: Mapping[str, float] = field(default_factory=dict)  # the coefficient c by joint
    segments: tuple[Segment, ...] = ()  # its straight lines
    stiffness: tuple[float, ...] = ()  # a, b, c
    # the lengths between which there is no force, x being the distance from them; None for the length at the guess
    rest: tuple[float, float] | None = (0.0, 0.0)
    # along the tendon
    damping: float = 0.0
    inertia: float = 0.0

    def attached(self, tangent: Tangent, frames: LinkFrames, locked: Mapping[str, float], guess: Kinematics) -> AttachedTendon:
        """The tendon of a robot; locked joints and lines within a body have a constant part of the length."""
        row, offset = np.zeros(guess.tree.model.nv), 0.0
        lines: list[tuple[Anchor, Anchor, float]] = []
        for name, coefficient in self.joints.items():
            if name in locked:
                offset += coefficient * locked[name]
            else:
                row[tangent.place(name, f'tendon "{self.name}"')] = coefficient
        for item in self.segments:
            ends = [
                frames.anchor(body, f'tendon "{self.name}"', point)
                for body, point in ((item.body1, item.point1), (item.body2, item.point2))
            ]
            if ends[0].joint == ends[1].joint:
                offset += item.factor * float(np.linalg.norm(ends[0].point - ends[1].point))
            else:
                lines.append((ends[0], ends[1], item.factor))
        attached = AttachedTendon(self, row, offset, tuple(lines), self.rest or (0.0, 0.0))
        if self.rest is None:
            length = StretchedTendon(attached, guess).length
            return AttachedTendon(self, row, offset, tuple(lines), (length, length))
        return attached


@dataclass(frozen=True, eq=False)
class AttachedTendon:
    """A tendon by the coordinates, shape (nv,), with lines between anchors and the lengths at rest."""

    tendon: Tendon
    row: np.ndarray
    offset: float
    lines: tuple[tuple[Anchor, Anchor, float], ...]
    rest: tuple[float, float]


class StretchedTendon:
    """The contributions of a tendon to the equations in one configuration."""

    def __init__(self, attached: AttachedTendon, kinematics: Kinematics):
        self.attached, self._kinematics = attached, kinematics
        self._poses = [(RelativePose(kinematics, first, second, False), factor) for first, second, factor in attached.lines]
        if any(not np.any(pose.value[:3]) for pose, _ in self._poses):
            raise InputError(
                f'tendon "{attached.tendon.name}": two of its points are at the same place, so that it has no direction'
            )

    @cached_property
    def length(self) -> float:
        """L (m, rad)."""
        row, kinematics = self.attached.row, self._kinematics
        turned = row @ joint_displacements(kinematics.tree.model, kinematics.configuration, np.zeros(len(row)))
        return float(self.attached.offset + turned + sum(factor * np.linalg.norm(pose.value[:3]) for pose, factor in self._poses))

    @cached_property
    def _directions(self) -> list[np.ndarray]:
        return [np.append(pose.value[:3], np.zeros(3)) / np.linalg.norm(pose.value[:3]) for pose, _ in self._poses]

    @cached_property
    def gradient(self) -> np.ndarray:
        """dL/dq, shape (nv,)."""
        return self.attached.row + sum(
            (factor * u @ pose.jacobian for u, (pose, factor) in zip(self._directions, self._poses)),
            np.zeros(len(self.attached.row)),
        )

    @cached_property
    def _tension(self) -> tuple[float, float]:
        """The force along the tendon and its derivative by the length."""
        low, high = self.attached.rest
        stretch = max(self.length - high, 0.0) + min(self.length - low, 0.0)
        if low < self.length < high:
            return 0.0, 0.0
        force = np.polynomial.Polynomial([0.0, *self.attached.tendon.stiffness])
        return float(force(stretch)), float(force.deriv()(stretch))

    @property
    def force(self) -> np.ndarray:
        """The generalized force on the left of the equations, shape (nv,)."""
        return self._tension[0] * self.gradient

    @cached_property
    def stiffness(self) -> np.ndarray:
        """Derivative of the generalized force, shape (nv, nv)."""
        force, slope = self._tension
        K = slope * np.outer(self.gradient, self.gradient)
        for u, (pose, factor) in zip(self._directions, self._poses):
            across = (np.eye(3) - np.outer(u[:3], u[:3])) / np.linalg.norm(pose.value[:3])
            K = K + force * factor * (pose.hessian(u) + pose.jacobian[:3].T @ across @ pose.jacobian[:3])
        return K

    @property
    def damping(self) -> np.ndarray:
        """Damping matrix of the tendon, shape (nv, nv)."""
        return self.attached.tendon.damping * np.outer(self.gradient, self.gradient)

    @property
    def inertia(self) -> np.ndarray:
        """Inertia matrix of the tendon, shape (nv, nv)."""
        return self.attached.tendon.inertia * np.outer(self.gradient, self.gradient)
