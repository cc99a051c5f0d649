"""Joints of SDF files and of simulators' tags as joints of a URDF, or as loops and springs where they close a loop."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...ground.checks import nearest
from ...ground.coordinate_units import GROUND
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import RIGHT_ANGLE
from ..connections import Bushing, Loop, LoopKind
from ..flexible_joint import Motor
from ..tangent import JointGear
from .models import ModelFile
from .urdf import HIDDEN, number, numbers, short

#: The body of an SDF that does not move.
WORLD = "world"

#: Number of unread parts named in a notice; the others are counted.
MOST_NAMED_PARTS = 12

#: The loop that closes with a joint of a kind.
LOOPS: dict[str, LoopKind] = {
    "revolute": "hinge",
    "prismatic": "prismatic",
    "fixed": "rigid",
    "ball": "point",
    "universal": "universal",
}

#: Other names of these kinds, and the number of axes of each kind.
_OTHER_NAMES = {"continuous": "revolute", "hinge": "revolute", "spherical": "ball", "slider": "prismatic", "revolute2": "universal"}
_AXES = {"revolute": 1, "prismatic": 1, "screw": 1, "universal": 2, "fixed": 0, "ball": 0, "floating": 0, "gearbox": 2}

#: Limits of this size (rad, m) and more are none.
UNLIMITED = 1e16


@dataclass
class Content:
    """Loops, springs, gears and motors of a description during reading, and the parts that are omitted.

    Attributes:
        word: the format, for messages.
        doubted: parts that are not read and may act on the motion.
        noted: parts that are not read and do not act on it.
        usual: links that give no mass or no inertia.
        stopped: joints both limits of which are the same.
        notices: others.
    """

    word: str
    loops: list[Loop] = field(default_factory=list)
    springs: list[Bushing] = field(default_factory=list)
    gears: list[JointGear] = field(default_factory=list)
    joint_stiffness: dict[str, float] = field(default_factory=dict)
    joint_rest: dict[str, float] = field(default_factory=dict)
    motors: dict[str, Motor] = field(default_factory=dict)
    doubted: list[str] = field(default_factory=list)
    noted: list[str] = field(default_factory=list)
    usual: list[str] = field(default_factory=list)
    stopped: list[str] = field(default_factory=list)
    notices: list[Notice] = field(default_factory=list)

    def leave_out(self, part: str, acts: bool) -> None:
        """Note an omitted part, and whether it may affect the motion."""
        (self.doubted if acts else self.noted).append(part)

    def add_spring(self, joint: str, stiffness: float, rest: float) -> None:
        """Add a spring of a joint, unless its stiffness is zero."""
        if stiffness:
            self.joint_stiffness[joint], self.joint_rest[joint] = stiffness, rest

    def model_file(self, **values) -> ModelFile:
        """The description with all parts that were read."""
        notices = list(self.notices)
        if self.usual:
            text = "links that give no mass or no inertia have those of the format, 1 kg and 1 kg m^2"
            notices.append(Notice(NoticeKind.ACCURACY, f"{self.word}: {text}: {_listed(self.usual)}"))
        if self.stopped:
            notices.append(
                Notice(NoticeKind.OVERRIDE, f"{self.word}: joints whose limits are equal are fixed: {_listed(self.stopped)}")
            )
        if self.doubted:
            text = "not read, though it may act on the motion; give loops, springs, gears, motors or payloads instead"
            notices.append(Notice(NoticeKind.OMITTED, f"{self.word}: {text}: {_listed(self.doubted)}", doubtful=True))
        if self.noted:
            notices.append(
                Notice(NoticeKind.OMITTED, f"{self.word}: not read, without effect on the motion: {_listed(self.noted)}")
            )
        lists: dict[str, Any] = {key: tuple(getattr(self, key)) for key in ("loops", "springs", "gears")}
        by_joint: dict[str, Any] = {key: getattr(self, key) for key in ("joint_stiffness", "joint_rest", "motors")}
        return ModelFile(None, notices=tuple(notices), **lists, **by_joint, **values)


def _listed(parts: list[str]) -> str:
    parts = list(dict.fromkeys(parts))
    more = f" and {len(parts) - MOST_NAMED_PARTS} more" if len(parts) > MOST_NAMED_PARTS else ""
    return ", ".join(parts[:MOST_NAMED_PARTS]) + more


def placement(xyz: Sequence[float], rpy: Sequence[float] = (0.0, 0.0, 0.0)):
    """The SE3 of a translation (m) and roll, pitch, yaw (rad)."""
    import pinocchio

    return pinocchio.SE3(pinocchio.rpy.rpyToMatrix(*rpy), np.array(xyz, dtype=float))


def origin_of(parent: Element, where: str):
    """The SE3 of the element <origin> of a URDF, if there is one."""
    origin = parent.find("origin")
    keys = ("xyz", "rpy")
    return placement(*(numbers("0 0 0" if origin is None else origin.get(key, "0 0 0"), 3, f"{where}, {key}") for key in keys))


def add_origin(parent: Element, place) -> None:
    """Add an SE3 as the element <origin> of a URDF."""
    xyz, rpy = place.translation.tolist(), angles_of(place)
    SubElement(parent, "origin", xyz=" ".join(map(repr, xyz)), rpy=" ".join(map(repr, rpy)))


def angles_of(place) -> list[float]:
    """Roll, pitch, yaw of an SE3."""
    import pinocchio

    return pinocchio.rpy.matrixToRpy(place.rotation).tolist()


@dataclass
class JointAxis:
    """One axis of a joint.

    Attributes:
        direction: direction in the frame of the joint.
        limits: lower and upper limit (rad, m).
        damping, friction, stiffness, rest: constants of the joint (SI).
        mimic: leader, multiplier and offset of a joint that follows.
        leader_axis: axis of a leader that has two.
    """

    direction: np.ndarray
    limits: tuple[float, float] = (-UNLIMITED, UNLIMITED)
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    mimic: tuple[str, float, float] | None = None
    leader_axis: str = "axis"


@dataclass
class Joint:
    """A joint between two bodies.

    Attributes:
        name, kind: its name and kind.
        parent, child: names of bodies; WORLD does not move.
        place: its frame, an SE3, where all joints are at 0.
        axes: in its frame.
        pitch: of a screw, displacement by angle (m/rad).
        ratio, reference: of a gearbox.
    """

    name: str
    kind: str
    parent: str
    child: str
    place: Any
    axes: list[JointAxis] = field(default_factory=list)
    pitch: float = 0.0
    ratio: float = 1.0
    reference: str = ""

    @property
    def has_springs(self) -> bool:
        """Whether there is a spring, a damper or friction."""
        return any(axis.stiffness or axis.damping or axis.friction for axis in self.axes)

    @property
    def closes(self) -> bool:
        """Whether the joint closes a loop."""
        if self.kind == "universal":
            first, second = (axis.direction for axis in self.axes)
            return bool(abs(first @ second) < RIGHT_ANGLE)
        return self.kind in LOOPS

    def reversed(self) -> Joint:
        """The joint from child to parent, with the same values of its coordinates."""
        turned = [JointAxis(**{**vars(axis), "direction": -axis.direction}) for axis in reversed(self.axes)]
        return Joint(**{**vars(self), "parent": self.child, "child": self.parent, "axes": turned})


class Frames(Protocol):
    """Frames of a description by name."""

    def place(self, name: str, where: str) -> Any:
        """The SE3 of a frame where all joints are at 0."""

    def body(self, name: str, where: str) -> str:
        """The body to which a frame is fixed, or WORLD."""


def text_of(element: Element | None, tag: str, usual: str = "") -> str:
    """The text of a child, or the default."""
    child = None if element is None else element.find(tag)
    return usual if child is None or child.text is None else child.text.strip()


def is_true(text: str) -> bool:
    """Whether a text means true in an SDF."""
    return text.strip().lower() in ("1", "true")


#: Attributes of <pose>.
_POSE_ATTRIBUTES = ("relative_to", "rotation_format", "degrees", "frame")


def pose_of(element: Element, where: str) -> tuple[Any, str]:
    """The SE3 of the element <pose> of an SDF, and the name of the frame that it is relative to; empty for the usual one."""
    import pinocchio

    pose = element.find("pose")
    if pose is None:
        return pinocchio.SE3.Identity(), ""
    base = pose.get("relative_to", pose.get("frame", ""))
    where, text, form = f"{where}, pose", (pose.text or "").strip(), pose.get("rotation_format", "euler_rpy")
    if not text:
        return pinocchio.SE3.Identity(), base
    if unknown := [key for key in pose.attrib if key not in _POSE_ATTRIBUTES and "}" not in key and ":" not in key]:
        raise InputError(f'{where}: found the attribute "{short(unknown[0])}"; expected {", ".join(_POSE_ATTRIBUTES)}')
    if form not in ("euler_rpy", "quat_xyzw"):
        raise InputError(f'{where}: found the rotation_format "{short(form)}"; expected euler_rpy or quat_xyzw')
    if form == "euler_rpy":
        *xyz, roll, pitch, yaw = numbers(text, 6, where)
        angles = np.array([roll, pitch, yaw])
        return placement(xyz, (np.deg2rad(angles) if is_true(pose.get("degrees", "")) else angles).tolist()), base
    values = np.array(numbers(text, 7, where))
    if not values[3:].any():
        raise InputError(f"{where}: found a quaternion of zeros; expected x, y, z, w of length 1")
    quaternion = values[3:] / np.linalg.norm(values[3:])
    return pinocchio.SE3(pinocchio.Quaternion(quaternion).matrix(), values[:3]), base


def _limit(text: str, usual: float, where: str) -> float:
    try:
        value = float(text) if text else usual
    except ValueError:
        value = np.nan
    return float(np.clip(value, -UNLIMITED, UNLIMITED)) if abs(value) >= UNLIMITED or not text else number(text, where)


def read_joint(element: Element, frames: Frames, content: Content, version: tuple[int, int] = (1, 7), prefix: str = "") -> Joint:
    """The element <joint> of an SDF."""
    own = element.get("name", "")
    name, where = f"{prefix}{own}", f'{content.word.lower()}, joint "{short(prefix + own)}"'
    kind = element.get("type", "")
    kind = _OTHER_NAMES.get(kind, kind)
    if kind not in _AXES:
        raise InputError(f'{where}: found the type "{short(kind)}"{nearest(kind, _AXES)}; expected {", ".join(_AXES)}')
    ends = [text_of(element, tag) for tag in ("parent", "child")]
    if not all(ends):
        raise InputError(f"{where}: found no <{'parent' if not ends[0] else 'child'}>; expected the name of a link or frame")
    parent, child = (frames.body(end, f"{where}, {tag}") for end, tag in zip(ends, ("parent", "child")))
    pose, base = pose_of(element, where)
    place = frames.place(base or ends[1], where) * pose
    axes = []
    for tag in ("axis", "axis2")[: _AXES[kind]]:
        axes.append(_axis(element.find(tag), place, frames, version, f"{where}, {tag}"))
        if (mimic := axes[-1].mimic) is not None:
            axes[-1].mimic = f"{prefix}{mimic[0]}", *mimic[1:]
    joint = Joint(name, kind, parent, child, place, axes)
    if kind == "screw":
        pitch, given = text_of(element, "screw_thread_pitch"), text_of(element, "thread_pitch")
        thread = number(given, f"{where}, thread_pitch") if given else 1.0
        if not pitch and not thread:
            raise InputError(f"{where}, thread_pitch: found 0; expected the turn of the screw for one metre (rad/m)")
        joint.pitch = number(pitch, f"{where}, screw_thread_pitch") / (2 * np.pi) if pitch else -1.0 / thread
    if kind == "gearbox":
        joint.ratio = number(text_of(element, "gearbox_ratio", "1"), f"{where}, gearbox_ratio")
        joint.reference = frames.body(text_of(element, "gearbox_reference_body"), f"{where}, gearbox_reference_body")
    _leave_out_of_joint(element, name, kind, content)
    return joint


#: Children of <joint> and of <axis> in an SDF that are read or have no effect on the motion.
_KNOWN = set(
    "parent child pose axis axis2 sensor thread_pitch screw_thread_pitch gearbox_ratio gearbox_reference_body rotor_inertia "
    "gear_ratio effort_limit acceleration provideFeedback must_be_loop_joint mimic".split()
)


#: Elements of which the first counts.
_SINGLE = "pose inertial mass inertia ixx ixy ixz iyy iyz izz parent child axis axis2 xyz limit dynamics damping mimic".split()


def leave_out_repeated(element: Element, place: str, content: Content) -> None:
    """Note repeated elements, of which the first is read, and units, which an SDF does not have."""
    for part in (element, *(below for child in element if child.tag in _SINGLE for below in child.iter())):
        tags = Counter(child.tag for child in part)
        for tag in _SINGLE:
            if tags[tag] > 1:
                content.leave_out(f"second <{tag}> of {place}", True)
        for key in part.attrib.keys() & {"unit", "units"}:
            content.leave_out(f'{key} = "{short(part.get(key))}" of <{short(part.tag)}> of {place}', True)


def _leave_out_of_joint(element: Element, name: str, kind: str, content: Content) -> None:
    leave_out_repeated(element, f'the joint "{short(name)}"', content)
    for child in element:
        tag = child.tag.rpartition("}")[2]
        if tag not in ("physics", "controller_gains", *_KNOWN):
            content.leave_out(f'<{short(tag)}> of the joint "{short(name)}"', True)
    for suspension in element.iterfind("physics/ode/suspension"):
        if kind == "universal" and element.get("type") == "revolute2" and amount(text_of(suspension, "cfm")):
            content.leave_out(f'<suspension> of the joint "{short(name)}"', True)
    if amount(text_of(element.find("physics/ode"), "cfm")):
        content.leave_out(f'<physics> cfm of the joint "{short(name)}"', True)
    beyond = [part for tag in ("axis", "axis2")[_AXES[kind] :] for part in element.findall(tag)]
    if kind != "fixed" and any(amount(value.text or "") for axis in beyond for value in axis.iterfind("dynamics/*")):
        content.leave_out(f'spring and damper of the {kind} joint "{short(name)}" about <{beyond[0].tag}>, which it has not', True)
    for axis in (*element.findall("axis"), *element.findall("axis2")):
        if amount(text_of(axis, "initial_position")):
            content.leave_out(f'<initial_position> of "{short(name)}"', False)
        known = ("damping", "friction", "spring_stiffness", "spring_reference")
        for part in axis.iterfind("dynamics/*"):
            if part.tag not in known and amount(part.text or ""):
                content.leave_out(f'<{short(part.tag)}> of the joint "{short(name)}"', True)
        for part in axis:
            if part.tag not in ("xyz", "dynamics", "limit", "use_parent_model_frame", "mimic", "initial_position"):
                content.leave_out(f'<{short(part.tag)}> of the joint "{short(name)}"', True)


def amount(text: str) -> float:
    """The size of the largest of the numbers of a text; true is 1, and text without a number is 0."""
    sizes = [abs(float(part)) for part in re.findall(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])", text[:200])]
    return max(sizes, default=float(text.strip().lower() == "true"))


def _axis(element: Element | None, place, frames: Frames, version: tuple[int, int], where: str) -> JointAxis:
    direction = np.array(numbers(text_of(element, "xyz", "0 0 1"), 3, where))
    if not direction.any():
        raise InputError(f"{where}: found 0 0 0; expected a direction")
    direction = direction / np.abs(direction).max()
    direction /= np.linalg.norm(direction)
    if element is None:
        return JointAxis(direction)
    xyz = element.find("xyz")
    base = "" if xyz is None else xyz.get("expressed_in", "")
    if not base and is_true(text_of(element, "use_parent_model_frame", "1" if version < (1, 5) else "0")):
        base = "__model__"
    if base:
        direction = place.rotation.T @ frames.place(base, f"{where}, expressed_in").rotation @ direction
    axis, dynamics, limit = JointAxis(direction), element.find("dynamics"), element.find("limit")
    for key, tag in (
        ("damping", "damping"),
        ("friction", "friction"),
        ("stiffness", "spring_stiffness"),
        ("rest", "spring_reference"),
    ):
        minimum = None if key == "rest" else 0.0
        setattr(axis, key, number(text_of(dynamics, tag, "0") or "0", f"{where}, {tag}", minimum=minimum))
    low, high = (
        _limit(text_of(limit, tag), usual, f"{where}, {tag}") for tag, usual in (("lower", -UNLIMITED), ("upper", UNLIMITED))
    )
    if low > high:
        raise InputError(f"{where}, limit: found lower {low:g} and upper {high:g}; expected lower below upper")
    axis.limits = low, high
    if (mimic := element.find("mimic")) is not None:
        values = {
            key: number(text_of(mimic, key, usual), f"{where}, mimic, {key}")
            for key, usual in (("multiplier", "1"), ("offset", "0"), ("reference", "0"))
        }
        offset = values["offset"] - values["multiplier"] * values["reference"]
        axis.mimic, axis.leader_axis = (mimic.get("joint", ""), values["multiplier"], offset), mimic.get("axis", "axis")
        if axis.leader_axis not in ("axis", "axis2"):
            raise InputError(f'{where}, mimic: found the axis "{short(axis.leader_axis)}"; expected axis or axis2')
    return axis


def add_loop(joint: Joint, places: Mapping[str, Any], content: Content) -> None:
    """Add the loop that a joint closes, and its spring and damper."""
    where = f'{content.word.lower()}, joint "{short(joint.name)}"'
    if not joint.closes:
        kinds = f"{', '.join(LOOPS)}, the axes of a universal one at right angles"
        raise InputError(f"{where}: a {joint.kind} joint closes a loop; expected {kinds}")
    bodies = [GROUND if body == WORLD else body for body in (joint.parent, joint.child)]
    first, second = ((places[body].inverse() * joint.place) for body in (joint.parent, joint.child))
    if bodies[0] == bodies[1]:
        raise InputError(f'{where}: both its ends are on "{short(bodies[0])}"; expected two bodies')
    keys = ("axis", "axis2") if joint.kind == "universal" else ("axis",)
    directions = {key: tuple(axis.direction.tolist()) for key, axis in zip(keys, joint.axes)}
    content.loops.append(connection(Loop, bodies, first, second, name=joint.name, kind=LOOPS[joint.kind], **directions))
    if any(axis.mimic for axis in joint.axes):
        content.leave_out(f'<mimic> of the joint "{short(joint.name)}", which closes a loop', True)
    if not joint.has_springs:
        return
    if joint.kind not in ("revolute", "prismatic"):
        content.leave_out(f'spring and damper of the joint "{short(joint.name)}", which closes a loop', True)
        return
    (axis,), slides = joint.axes, joint.kind == "prismatic"
    if axis.friction:
        content.leave_out(f'friction of the joint "{short(joint.name)}", which closes a loop', False)
    turn = placement((0, 0, 0))
    turn.rotation = _turned_to(axis.direction)
    at_rest = placement((0.0, 0.0, axis.rest if slides else 0.0), (0.0, 0.0, 0.0 if slides else axis.rest))
    prefix = "" if slides else "turning_"
    values = {f"{prefix}stiffness": (0.0, 0.0, axis.stiffness), f"{prefix}damping": (0.0, 0.0, axis.damping)}
    content.springs.append(
        connection(Bushing, bodies, first * turn * at_rest, second * turn, name=f"{joint.name} spring", **values)
    )


def _turned_to(direction: np.ndarray) -> np.ndarray:
    """A rotation that turns z to a direction."""
    across = np.linalg.svd(direction[None])[2][1:]
    rotation = np.column_stack([*across, direction])
    rotation[:, 0] *= np.sign(np.linalg.det(rotation))
    return rotation


def connection(make: type, bodies: Sequence[str], first, second, **values) -> Any:
    """A loop or bushing of frames on two bodies."""
    (body1, body2), points = bodies, (first.translation.tolist(), second.translation.tolist())
    return make(body1, points[0], body2, points[1], rotation1=angles_of(first), rotation2=angles_of(second), **values)


def add_joint(robot: Element, joint: Joint, places: Mapping[str, Any], content: Content) -> None:
    """Add a joint of the tree to the element <robot> of a URDF, with its springs and couplings.

    The frame of a link of a URDF is at its joint; one that is elsewhere is fixed to a link without mass at the joint. A universal
    joint is two joints, and a screw is two with a gear.
    """
    pieces = [(joint.name, "revolute" if joint.kind not in ("prismatic", "fixed", "ball", "floating") else joint.kind, 0)]
    if joint.kind == "universal":
        pieces = [(f"{joint.name} {tag}", "revolute", place) for place, tag in enumerate(("axis", "axis2"))]
    if joint.kind == "screw":
        pieces.append((f"{joint.name} slide", "prismatic", 0))
        content.gears.append(JointGear(f"{joint.name} slide", joint.name, joint.pitch))
    origin, tail = places[joint.parent].inverse() * joint.place, joint.place.inverse() * places[joint.child]
    parent = joint.parent
    for name, kind, place in pieces:
        is_last = name == pieces[-1][0]
        child = joint.child if is_last and tail.isIdentity(0.0) else f"{HIDDEN}{name}"
        if child != joint.child:
            SubElement(robot, "link", name=child)
        axis = joint.axes[place] if joint.axes and kind in ("revolute", "prismatic") else None
        if axis is not None and axis.limits[0] == axis.limits[1]:
            origin = origin * _displaced(kind, axis)
            content.stopped.append(f'"{short(name)}" at {axis.limits[0]:g}')
            axis, kind = None, "fixed"
        element = SubElement(robot, "joint", name=name, type=kind)
        SubElement(element, "parent", link=parent)
        SubElement(element, "child", link=child)
        add_origin(element, origin)
        origin, parent = placement((0, 0, 0)), child
        if axis is not None:
            _add_axis(element, axis, content, own=kind == "revolute" or joint.kind == "prismatic")
    if parent != joint.child:
        element = SubElement(robot, "joint", name=parent, type="fixed")
        SubElement(element, "parent", link=parent)
        SubElement(element, "child", link=joint.child)
        add_origin(element, tail)


def _displaced(kind: str, axis: JointAxis):
    """The SE3 of a joint at its lower limit."""
    import pinocchio

    shift = axis.limits[0] * axis.direction
    return placement(shift.tolist()) if kind == "prismatic" else pinocchio.SE3(pinocchio.exp3(shift), np.zeros(3))


def _add_axis(element: Element, axis: JointAxis, content: Content, own: bool) -> None:
    """Axis, limits, damping and spring of a joint; of a sliding part of a screw, which has none of its ``own``, the axis."""
    SubElement(element, "axis", xyz=" ".join(map(repr, axis.direction.tolist())))
    if not own:
        return
    name, (low, high) = element.get("name", ""), axis.limits
    if low > -UNLIMITED or high < UNLIMITED:
        SubElement(element, "limit", lower=repr(low), upper=repr(high), effort="0", velocity="0")
    SubElement(element, "dynamics", damping=repr(axis.damping), friction=repr(axis.friction))
    content.add_spring(name, axis.stiffness, axis.rest)
    if axis.mimic is not None:
        leader, multiplier, offset = axis.mimic
        content.gears.append(JointGear(name, leader, multiplier, offset))
