"""Parts of a linearized robot with several states: joint stops, contacts of points, feet that lift off, loops that close and open.

Their rows are those of the Jacobians at the posture. A loop that carries load there is replaced by its force in all phases,

    M d'' + D d' + K d = f - J^T lambda_0 + J^T lambda,

with lambda the whole force of the loop while it is closed, and K that of the closed loop: the gap is a coordinate, and the second
derivative of its force belongs to K whether it is open or closed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..ground.by_name import Public
from ..ground.checks import nearest, real_array, real_number
from ..ground.errors import InputError, named
from ..ground.notices import Notice, NoticeKind
from ..ground.quantities import quantity
from ..ground.units import GROUND
from ..mechanics.constraints import Constraint
from ..mechanics.switched.phase import STILL
from ..mechanics.switched.switches import Guard, Switch, SwitchState, TimedChange, rigid_contact
from ..models.switching import Contact
from .connections import Attached, Loop, PointMotion, untwisted, with_rest_length
from .kinematics import directions_across
from .statics import cleaned_rows

if TYPE_CHECKING:
    from ..mechanics.switched.switched_motion import SwitchedMotion
    from .statics import Posture

#: Times at which forces of feet are compared with their cones.
CONE_TIMES = 400


@dataclass(frozen=True, eq=False)
class Grip:
    """The rows of a contact that does not slide.

    Attributes:
        name: of the contact and of the row along its normal.
        across: names of the rows across it.
        friction: coefficient of friction; None where it is not checked.
    """

    name: str
    across: tuple[str, ...]
    friction: float | None


class StickingContact(Switch):
    """A contact that does not slide, closed at the start where it touches at rest.

    Where it can neither stick nor separate, as with more friction than there can be, it slides until it separates.

    Args:
        row, gap: of its normal.
        across: rows that vanish while it is closed.
    """

    def __init__(self, name: str, row: np.ndarray, gap: float, across: Sequence[Constraint]):
        frictionless = rigid_contact(name, row, gap, 0.0)
        sliding = frictionless.states["closed"]
        closed = replace(sliding, rows=(*sliding.rows, *across))
        contact = replace(frictionless.contact, sliding="sliding")
        super().__init__(name, frictionless.states | {"closed": closed, "sliding": sliding}, contact=contact)
        self.sticking = np.vstack([row, *(one.rows for one in across)])

    def start(self, x: np.ndarray, v: np.ndarray) -> str:
        touches = np.isclose(self.contact.row @ x, -self.contact.gap, rtol=STILL, atol=0.0)
        slides = np.abs(self.sticking @ v) > STILL * (np.abs(self.sticking) @ np.abs(v))
        return "closed" if touches and not slides.any() else "open"


class RobotSwitch(Public):
    """The base of parts of a robot with several states."""

    @property
    def opened(self) -> str | None:
        """The loop of the robot that it replaces; None without."""
        return None

    def _switches(self, posture: Posture, size: int) -> tuple[tuple[Switch, ...], Grip | None]:
        """Return its switches over a number of coordinates, and the rows of a contact that does not slide."""
        raise NotImplementedError


@dataclass(frozen=True)
class JointStop(RobotSwitch):
    """Stops of a joint at its limits, rigid with impacts by Newton's law of restitution, or elastic with a stiffness.

    Args:
        joint: a joint with one degree of freedom.
        lower, upper: values of the joint at the stops (rad, m, or texts with a unit); those of the URDF when both are left out.
        restitution: velocity after an impact by that before it, 0 to 1.
        stiffness, damping: of elastic stops (N m/rad, N/m); rigid when left out.
        name: "<joint> stop" when left out; with two stops, " lower" and " upper" are added.

    Raises:
        InputError: a joint without limits, or a posture beyond them.

    A pendulum of length l meets a stop where it hangs after a quarter of its period:

    >>> from mbconstrained import Robot
    >>> urdf = '''<robot name="pendulum"><link name="base"/><link name="rod"><inertial><mass value="2"/>
    ...   <origin xyz="0 0 -0.5"/><inertia ixx="0.1" iyy="0.1" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
    ...   <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>'''
    >>> robot = Robot(urdf)
    >>> pendulum = robot.linearize(robot.equilibrium()).with_switches(JointStop("hinge", lower=0.0, restitution=0.5))
    >>> x = pendulum.solve({"hinge": 0.1}, end=1.0)
    >>> w = np.sqrt(2 * 9.81 * 0.5 / (0.1 + 2 * 0.5**2))
    >>> impulse = (1 + 0.5) * (0.1 + 2 * 0.5**2) * w * 0.1
    >>> bool(np.isclose(x.events[0].time, np.pi / 2 / w)), bool(np.isclose(x.events[0].impulses["hinge stop"], impulse))
    (True, True)
    """

    joint: str
    lower: float | str | None = None
    upper: float | str | None = None
    restitution: float = 0.0
    stiffness: float | str | None = None
    damping: float | str = 0.0
    name: str | None = None

    def _switches(self, posture: Posture, size: int) -> tuple[tuple[Switch, ...], Grip | None]:
        model, name = posture.robot, self.name or f"{self.joint} stop"
        single = [one for one in model.joints if one in model.coordinates]
        if self.joint not in single:
            raise InputError(
                f'joint stop: there is no joint "{self.joint}" with one degree of freedom{nearest(self.joint, single)}'
            )
        place = model.coordinates.index(self.joint)
        unit, at, row = model.units[place], float(np.ravel(posture.joints[self.joint])[0]), np.eye(size)[place]
        given = {"lower": self.lower, "upper": self.upper}
        if self.lower is None and self.upper is None:
            if self.joint not in model.limits:
                raise InputError(f'joint stop "{name}": {self.joint} has no limits; give lower, upper or both')
            given = {side: value for side, value in zip(given, model.limits[self.joint]) if np.isfinite(value)}
        ends = {}
        for side, value in given.items():
            if value is not None:
                with named(f'joint stop "{name}": {side}'):
                    ends[side] = quantity(value, unit)
        switches: list[Switch] = []
        for side, limit in ends.items():
            sign = 1.0 if side == "lower" else -1.0
            gap = sign * (at - limit)
            if gap < 0:
                raise InputError(
                    f'joint stop "{name}": {self.joint} is at {at:.6g} {unit} in the posture, beyond the {side} stop at {limit:.6g} {unit}'
                )
            own = name if len(ends) == 1 else f"{name} {side}"
            switches += _contact(own, sign * row, gap, self.restitution, self.stiffness, self.damping, unit)
        return tuple(switches), None


@dataclass(frozen=True)
class PointContact(RobotSwitch):
    """A point of a body that meets a plane, fixed in the ground or in another body, which it cannot pass.

    Rigid with impacts by Newton's law of restitution, or elastic with a stiffness. It slides without friction, or sticks: then it does
    not slide at all while it touches without rebound, and notices report forces and impulses outside the cone of friction.

    Args:
        body: a link.
        point: in the link's frame (m).
        normal: of the plane, towards the point, in the directions of the ground at the posture.
        gap: distance of the point from the plane at the posture (m, or a text with a unit).
        restitution: velocity after an impact by that before it, 0 to 1; 0 of one that sticks.
        stiffness, damping: of an elastic contact (N/m, N s/m); rigid when left out.
        sticks: whether it does not slide.
        friction: coefficient by which forces of one that sticks are checked.
        other: the body with the plane.
        name: "<body> contact" when left out.

    Raises:
        InputError: unknown bodies, a negative gap, an elastic contact, or one with rebound, that sticks.

    A foot of 2 kg on a spring meets the ground 1 cm below:

    >>> from mbconstrained import Robot
    >>> urdf = '''<robot name="foot"><link name="base"/><link name="foot"><inertial><mass value="2"/>
    ...   <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    ...   <joint name="leg" type="prismatic"><parent link="base"/><child link="foot"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"
    ...   effort="1" velocity="1"/></joint></robot>'''
    >>> robot = Robot(urdf, joint_stiffness={"leg": 2000.0})
    >>> foot = robot.linearize(robot.equilibrium()).with_switches(PointContact("foot", gap=0.01, restitution=0.5))
    >>> x = foot.solve(velocity={"leg": -1.0}, end=0.1)
    >>> [(event.text, round(event.impulses["foot contact"], 9)) for event in x.events[:1]]  # v = sqrt(1 - (0.01 w)^2)
    [('foot contact impact', 2.846049894)]
    """

    body: str
    point: Sequence[float] = (0.0, 0.0, 0.0)
    normal: Sequence[float] = (0.0, 0.0, 1.0)
    gap: float | str = 0.0
    restitution: float = 0.0
    stiffness: float | str | None = None
    damping: float | str = 0.0
    sticks: bool = False
    friction: float | None = None
    other: str = GROUND
    name: str | None = None

    def _switches(self, posture: Posture, size: int) -> tuple[tuple[Switch, ...], Grip | None]:
        name = self.name or f"{self.body} contact"
        label, frames = f'contact "{name}"', posture.robot.link_frames
        if self.sticks and (self.stiffness is not None or self.restitution):
            other = "restitution" if self.stiffness is None else "stiffness"
            raise InputError(f"{label}: found {other} and sticks; a contact that sticks is rigid and comes to rest without rebound")
        friction = None if self.friction is None else real_number(self.friction, f"{label}: friction", minimum=0.0)
        if friction is not None and not self.sticks:
            raise InputError(f"{label}: friction is checked of a contact that sticks; add sticks=True, or leave friction out")
        normal = _direction(self.normal, f"{label}: normal")
        kinematics = posture.balance.kinematics
        anchor, plane = frames.point(PointMotion(self.body, self.point), label), frames.link(GROUND)
        if self.other != GROUND:
            frames.check(self.other, label)
            plane = frames.link(self.other)
        if anchor.joint == plane.joint:
            raise InputError(f'{label}: "{self.body}" does not move relative to "{self.other}"')
        place = kinematics.frame(anchor)[1]
        moved = kinematics.of_point(anchor.joint, place) - kinematics.of_point(plane.joint, place)
        row, across, names = _split(posture, size, moved, normal, name)
        if not row.any():
            raise InputError(f"{label}: the point does not move along the normal; give another normal, or another point")
        if not self.sticks:
            return _contact(name, row, self.gap, self.restitution, self.stiffness, self.damping, "m"), None
        (frictionless,) = _contact(name, row, self.gap, 0.0, None, 0.0, "m")
        return (StickingContact(name, row, frictionless.contact.gap, across),), Grip(name, names, friction)


@dataclass(frozen=True)
class LiftingFoot(RobotSwitch):
    """A foot of the robot, a loop on the ground, that lifts off where it would have to pull, and lands again.

    It lands without rebound, and while it stands it sticks, wherever it has landed. Notices report forces and impulses outside its cone of friction.

    Args:
        loop: the name of a loop of kind "point" or "rigid" between a link and the ground, closed at the posture, with its ``normal``.

    Raises:
        InputError: an unknown loop, or one that is no foot.

    A block that stands on the ground is thrown up and lands after 2 v / g:

    >>> from mbconstrained import Loop, Robot
    >>> urdf = '''<robot name="block"><link name="block"><inertial><mass value="2"/>
    ...   <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'''
    >>> foot = Loop("ground", (0, 0, 0), "block", (0, 0, 0), kind="rigid", name="sole")
    >>> robot = Robot(urdf, loops=[foot], base="free")
    >>> x = robot.linearize(robot.equilibrium()).with_switches(LiftingFoot("sole")).solve(velocity={"base z": 0.1}, end=0.1)
    >>> round(x.events[-1].time, 9), round(x.events[-1].impulses["sole"], 9)
    (0.02038736, 0.2)
    """

    loop: str

    @property
    def opened(self) -> str:
        """The foot."""
        return self.loop

    def _switches(self, posture: Posture, size: int) -> tuple[tuple[Switch, ...], Grip | None]:
        item, rows = _loop_rows(posture, size, self.loop, "lifting foot")
        loop, label = item.connection, f'lifting foot "{self.loop}"'
        if loop.kind not in ("point", "rigid") or GROUND not in (loop.body1, loop.body2):
            raise InputError(f'{label}: found a {loop.kind} loop; expected one of kind "point" or "rigid" on the ground')
        name = self.loop
        row, across, names = _split(posture, size, _shifts(posture, item), loop.unit_normal, name)
        turns = [
            Constraint(turn, level="velocity", names=f"{name} {axis}", unit="rad")
            for turn, axis in zip(rows[3:], ("rx", "ry", "rz"))
            if turn.any()
        ]
        return (StickingContact(name, row, 0.0, (*across, *turns)),), Grip(name, names, loop.friction)


@dataclass(frozen=True)
class ClosingLoop(RobotSwitch):
    """A loop that closes, as a gripper that grasps, or opens, as one that lets go.

    A new ``Loop`` closes at a time, or where its second point has come nearer to the first along the normal by a gap; the frames
    keep the relative pose that they have then. It closes without rebound and holds until it is released. The name of a loop of the robot,
    closed at the posture, is one that is released.

    Args:
        loop: an ``mb.Loop``, or the name of a loop of the robot.
        at: the time at which it closes (s).
        gap: the distance by which the second point must come nearer to the first against ``loop.normal`` (m, or a text with a unit).
        released: the time at which it opens (s).

    Raises:
        InputError: neither or both of at and gap; a loop of the robot without released.

    >>> from mbconstrained import Loop, Robot
    >>> urdf = '''<robot name="pair"><link name="base"/><link name="a"><inertial><mass value="2"/>
    ...   <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="b"><inertial><mass value="2"/>
    ...   <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    ...   <joint name="to a" type="prismatic"><parent link="base"/><child link="a"/><axis xyz="1 0 0"/></joint>
    ...   <joint name="to b" type="prismatic"><parent link="base"/><child link="b"/><axis xyz="1 0 0"/></joint></robot>'''
    >>> robot = Robot(urdf, gravity=0.0)
    >>> hand = robot.linearize(robot.equilibrium()).with_switches(ClosingLoop(Loop("a", (0, 0, 0), "b", name="grip"), at=0.5))
    >>> x = hand.solve(velocity={"to a": 1.0}, end=1.0)
    >>> x.velocity(0.6).round(12).tolist(), x.events[0].time  # the momentum is shared
    ([0.5, 0.5], 0.5)
    """

    loop: Loop | str
    at: float | None = None
    gap: float | str | None = None
    released: float | None = None

    def __post_init__(self):
        label = f'closing loop "{self.loop if isinstance(self.loop, str) else getattr(self.loop, "name", "")}"'
        if not isinstance(self.loop, (str, Loop)):
            raise InputError(
                f"closing loop: found {type(self.loop).__name__}; expected an mb.Loop, or the name of one of the robot's"
            )
        for key in ("at", "released"):
            if getattr(self, key) is not None:
                object.__setattr__(self, key, real_number(getattr(self, key), f"{label}: {key}", positive=True))
        if isinstance(self.loop, str):
            if self.released is None or self.at is not None or self.gap is not None:
                raise InputError(f"{label}: a loop of the robot is closed at the posture; give the time at which it is released")
        elif (self.at is None) == (self.gap is None):
            raise InputError(f"{label}: expected a time at, or a gap; found {'both' if self.at is not None else 'neither'}")
        if self.at is not None and self.released is not None and self.released <= self.at:
            raise InputError(
                f"{label}: it is released at {self.released:g} s and closes at {self.at:g} s; expected a later release"
            )

    @property
    def opened(self) -> str | None:
        """The loop of the robot."""
        return self.loop if isinstance(self.loop, str) else None

    def _switches(self, posture: Posture, size: int) -> tuple[tuple[Switch, ...], Grip | None]:
        name = self.loop if isinstance(self.loop, str) else str(self.loop.name)
        release = [] if self.released is None else [TimedChange(self.released, "released", ("closed",), "is released")]
        if isinstance(self.loop, str):
            item, rows = _loop_rows(posture, size, self.loop, "closing loop")
            names, units = item.connection.row_names, item.connection.row_units
            together = [Constraint(row, names=own, unit=unit) for row, own, unit in zip(rows, names, units) if row.any()]
            return (Switch(name, {"closed": SwitchState(tuple(together)), "released": SwitchState()}, release),), None
        item = _attached(posture, self.loop, name)
        rows, names, units = _rows_of(posture, size, item), self.loop.row_names, self.loop.row_units
        kept = [Constraint(row, level="velocity", names=own, unit=unit) for row, own, unit in zip(rows, names, units) if row.any()]
        if not kept:
            raise InputError(f'closing loop "{name}": its bodies do not move relative to each other')
        if self.at is not None:
            states = {"open": SwitchState(), "closed": SwitchState(tuple(kept)), "released": SwitchState()}
            return (Switch(name, states, [TimedChange(self.at, "closed", ("open",), "closes"), *release]),), None
        with named(f'closing loop "{name}": gap'):
            gap = real_number(quantity(self.gap, "m"), "gap", minimum=0.0)
        row = _split(posture, size, _shifts(posture, item), self.loop.unit_normal, name)[0]
        states = {
            "open": SwitchState(guards=(Guard("closed", row, np.zeros(size), -gap, text="closes"),)),
            "closed": SwitchState(tuple(kept)),
            "released": SwitchState(),
        }
        return (Switch(name, states, release),), None


def robot_switches(posture: Posture, size: int, parts: Sequence[RobotSwitch]) -> tuple[tuple[Switch, ...], tuple[Grip, ...]]:
    """The switches of parts at a posture, over a number of coordinates, and the contacts that do not slide."""
    wanted = "mb.JointStop, mb.PointContact, mb.LiftingFoot or mb.ClosingLoop"
    for part in parts or (None,):
        if not isinstance(part, RobotSwitch):
            raise InputError(f"with_switches: found {'nothing' if part is None else type(part).__name__}; expected {wanted}")
    own = [part._switches(posture, size) for part in parts]
    switches = tuple(switch for several, _ in own for switch in several)
    names = [switch.name for switch in switches]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f'with_switches: "{name}" is given twice; give one of them another name')
    return switches, tuple(grip for _, grip in own if grip is not None)


def _contact(name, row, gap, restitution, stiffness, damping, unit: str) -> tuple[Switch, ...]:
    """The switch of a rigid or elastic contact."""
    return Contact("body", "other", gap, restitution, stiffness, damping, name=name).settled({"body": unit}).switches(row, unit)


def _direction(value, label: str) -> np.ndarray:
    vector = real_array(value, label, shape=(3,))
    length = float(np.linalg.norm(vector))
    if not length:
        raise InputError(f"{label}: found 0, 0, 0; expected a direction")
    return vector / length


def _split(
    posture: Posture, size: int, rows: np.ndarray, normal: np.ndarray, name: str
) -> tuple[np.ndarray, tuple[Constraint, ...], tuple[str, ...]]:
    """The row along a normal, those across it at velocity level, and the names of these, from displacements along x, y, z of the ground."""
    nonzero = np.abs(normal) > 0
    aligned = nonzero.sum() == 1
    words = [axis for axis, own in zip("xyz", nonzero) if not own] if aligned else ["shift 1", "shift 2"]
    clean = _clean(posture, size, np.vstack([normal, directions_across(normal)]) @ rows, ["m"] * 3)
    kept = [(f"{name} {word}", row) for word, row in zip(words, clean[1:]) if row.any()]
    constraints = tuple(Constraint(row, level="velocity", names=own, unit="m") for own, row in kept)
    return clean[0], constraints, tuple(own for own, _ in kept)


def _clean(posture: Posture, size: int, rows: np.ndarray, units: Sequence[str]) -> np.ndarray:
    """Rows over all coordinates without rounding errors."""
    count = len(posture.robot.coordinates)
    clean = cleaned_rows(rows[:, :count], posture.balance.sizes, units)[0]
    return np.pad(clean, ((0, 0), (0, size - count)))


def _rows_of(posture: Posture, size: int, item: Attached) -> np.ndarray:
    pose = item.pose(posture.balance.kinematics)
    return _clean(posture, size, item.connection.gradient(pose.value) @ pose.jacobian, item.connection.row_units)


def _loop_rows(posture: Posture, size: int, name: str, what: str) -> tuple[Attached, np.ndarray]:
    """A loop of the robot by name, with its rows."""
    moving = posture.robot.moving_base
    loops = {item.connection.name: item for item in posture.loops if moving is None or item.connection.name != moving.name}
    if name not in loops:
        raise InputError(f'{what}: there is no loop "{name}"{nearest(str(name), loops)}; there are {", ".join(loops) or "none"}')
    return loops[name], _rows_of(posture, size, loops[name])


def _attached(posture: Posture, loop: Loop, name: str) -> Attached:
    """A new loop at the posture."""
    frames, kinematics = posture.robot.link_frames, posture.balance.kinematics
    for body in (loop.body1, loop.body2):
        if body != GROUND:
            frames.check(body, f'closing loop "{name}"')
    return with_rest_length(untwisted(frames.attached(loop, kinematics), kinematics), kinematics)


def _shifts(posture: Posture, item: Attached) -> np.ndarray:
    """The displacement of the second point, or of the point that is not on the ground, relative to the other in the directions of the ground."""
    kinematics = posture.balance.kinematics
    moved = kinematics.frame(item.first)[0] @ item.pose(kinematics).jacobian[:3]
    return -moved if item.connection.body2 == GROUND else moved


def load_of(posture: Posture, size: int, loops: Sequence[str]) -> np.ndarray:
    """J^T lambda of some loops at the posture, shape (n,)."""
    own = [
        pose.jacobian.T @ (gradient.T @ posture.multipliers[places])
        for item, pose, gradient, places in posture.balance.loops
        if item.connection.name in loops
    ]
    force = sum(own, np.zeros(len(posture.robot.coordinates)))
    return np.pad(force, (0, size - len(force)))


def grip_notices(grips: Sequence[Grip], motion: SwitchedMotion) -> Iterator[Notice]:
    """Notices on contacts that do not slide although their forces or impulses leave the cone of friction, or pull in an impact."""
    times = np.linspace(0.0, motion.solution.sequence.end, CONE_TIMES)
    places = {row.name: place for place, row in enumerate(motion._reaction_rows)}
    forces = motion.reaction(times) if grips else np.zeros((0, len(times)))
    for grip in grips:
        if grip.name not in places:
            continue
        along = forces[places[grip.name]]
        across = np.linalg.norm([forces[places[name]] for name in grip.across if name in places] or [0.0 * along], axis=0)
        if grip.friction is not None:
            excess = across - grip.friction * along
            worst = int(excess.argmax())
            if excess[worst] > np.finfo(float).eps ** 0.5 * np.abs(along).max(initial=0.0):
                need = f"{across[worst]:.4g} N across and {along[worst]:.4g} N along the normal"
                yield Notice(
                    NoticeKind.LARGE_MOTION, f"{grip.name} would slip at t = {times[worst]:.3g} s: {need}; it is kept in place"
                )
        alone = len(motion.solution.sequence.machine.switches) == 1
        slides = [time for time, phase in motion.phases if ("sliding" if alone else f"{grip.name} sliding") in phase]
        if slides:
            text = f"{grip.name} slides without friction from t = {slides[0]:.6g} s on, where it could neither stick nor lift off"
            yield Notice(NoticeKind.LARGE_MOTION, text)
        yield from _impulse_notices(grip, motion)


def _impulse_notices(grip: Grip, motion: SwitchedMotion) -> Iterator[Notice]:
    for event in motion.events:
        along = event.impulses.get(grip.name, 0.0)
        across = float(np.linalg.norm([event.impulses.get(name, 0.0) for name in grip.across]))
        if along < 0:
            yield Notice(
                NoticeKind.LARGE_MOTION,
                f"{grip.name}: at t = {event.time:.6g} s it would have to pull by {-along:.4g} N s to come to rest; a real one lifts off",
            )
            return
        if grip.friction is not None and across > grip.friction * along * (1 + np.finfo(float).eps ** 0.5):
            text = f"at t = {event.time:.6g} s its impulse of {across:.4g} N s across and {along:.4g} N s along the normal"
            yield Notice(NoticeKind.LARGE_MOTION, f"{grip.name}: {text} is outside its cone of friction; a real one slips")
            return
