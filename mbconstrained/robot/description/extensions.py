"""Contents of URDF files beyond tree, masses and shapes, and their joints and those of SDF files as joints, loops and springs.

Each is read, or named in a notice: a doubtful one where it may carry mass, stiffness, damping or coupling.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...ground.checks import nearest
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import RIGHT_ANGLE
from ...ground.units import GROUND
from ..connections import Bushing, Loop, LoopKind
from ..flexible_joint import Motor
from ..kinematics import directions_across
from ..tangent import JointGear
from .urdf import (
    HIDDEN,
    MOMENTS,
    RENAMED_GROUND,
    ModelFile,
    angles_of,
    axis_of,
    checked_tree,
    joint_element,
    number,
    numbers,
    parsed_xml,
    place_of,
    placement,
    read_urdf,
    resolve_quaternions,
    rotation_of,
    short,
)

#: The body of an SDF that does not move.
WORLD = "world"

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
class JointAxis:
    """One axis of a joint."""

    direction: np.ndarray  # direction in the frame of the joint
    limits: tuple[float, float] = (-UNLIMITED, UNLIMITED)  # lower and upper limit (rad, m)
    # constants of the joint (SI)
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    mimic: tuple[str, float, float] | None = None  # leader, multiplier and offset of a joint that follows
    leader_axis: str = "axis"  # axis of a leader that has two


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
    values = numbers(text, 7, where)
    return pinocchio.SE3(rotation_of(values[3:], where), np.array(values[:3])), base


def _limit(text: str, usual: float, where: str) -> float:
    try:
        value = float(text) if text else usual
    except ValueError:
        value = np.nan
    return float(np.clip(value, -UNLIMITED, UNLIMITED)) if abs(value) >= UNLIMITED or not text else number(text, where)


def read_joint(element: Element, frames: Frames, content: ModelFile, version: tuple[int, int] = (1, 7), prefix: str = "") -> Joint:
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
    if axes and (follows := next((part for part in element if local_name(part) == "mimic"), None)) is not None:  # as in Drake
        ratio, offset = (
            number(follows.get(key, own), f"{where}, mimic, {key}") for key, own in (("multiplier", "1"), ("offset", "0"))
        )
        axes[0].mimic = f"{prefix}{follows.get('joint', '')}", ratio, offset
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


#: Children of <joint>, <axis> and <dynamics> in an SDF that are read or have no effect on the motion.
_JOINT = (
    "parent child pose axis axis2 sensor thread_pitch screw_thread_pitch gearbox_ratio gearbox_reference_body rotor_inertia "
    "gear_ratio effort_limit acceleration provideFeedback must_be_loop_joint mimic physics controller_gains"
)
_OF_AXIS, _OF_DYNAMICS = (
    "xyz dynamics limit use_parent_model_frame mimic initial_position",
    "damping friction spring_stiffness spring_reference",
)


#: Elements of which the first counts.
_SINGLE = (
    "pose origin inertial mass inertia ixx ixy ixz iyy iyz izz parent child axis axis2 xyz limit dynamics damping mimic".split()
)


def leave_out_repeated(element: Element, place: str, content: ModelFile) -> None:
    """Note repeated elements, of which the first is read, and units, which an SDF does not have."""
    for part in (element, *(below for child in element if child.tag in _SINGLE for below in child.iter())):
        tags = Counter(child.tag for child in part)
        for tag in _SINGLE:
            if tags[tag] > 1:
                content.leave_out(f"second <{tag}> of {place}", True)
        for key in part.attrib.keys() & {"unit", "units"}:
            content.leave_out(f'{key} = "{short(part.get(key))}" of <{short(part.tag)}> of {place}', True)


def _leave_out_of_joint(element: Element, name: str, kind: str, content: ModelFile) -> None:
    leave_out_repeated(element, f'the joint "{short(name)}"', content)
    of = f' of the joint "{short(name)}"'
    leave_out_unknown(element, _JOINT, of, content)
    for suspension in element.iterfind("physics/ode/suspension"):
        if kind == "universal" and element.get("type") == "revolute2" and amount(text_of(suspension, "cfm")):
            content.leave_out(f"<suspension>{of}", True)
    if amount(text_of(element.find("physics/ode"), "cfm")):
        content.leave_out(f"<physics> cfm{of}", True)
    beyond = [part for tag in ("axis", "axis2")[_AXES[kind] :] for part in element.findall(tag)]
    if kind != "fixed" and any(amount(value.text or "") for axis in beyond for value in axis.iterfind("dynamics/*")):
        content.leave_out(f'spring and damper of the {kind} joint "{short(name)}" about <{beyond[0].tag}>, which it has not', True)
    for axis in (*element.findall("axis"), *element.findall("axis2")):
        if amount(text_of(axis, "initial_position")):
            content.leave_out(f'<initial_position> of "{short(name)}"', False)
        leave_out_unknown((part for part in axis.iterfind("dynamics/*") if amount(part.text or "")), _OF_DYNAMICS, of, content)
        leave_out_unknown(axis, _OF_AXIS, of, content)


def leave_out_unknown(
    children: Iterable[Element], known: str, of: str, content: ModelFile, acts: Callable[[Element], Any] = lambda child: True
) -> None:
    """Note the children whose tags are not known, and whether they may act on the motion."""
    for child in children:
        if (tag := local_name(child)) not in known.split():
            content.leave_out(f"<{short(tag)}>{of}", bool(acts(child)))


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


def add_loop(joint: Joint, places: Mapping[str, Any], content: ModelFile) -> None:
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
    rotation = np.column_stack([*directions_across(direction), direction])
    rotation[:, 0] *= np.sign(np.linalg.det(rotation))
    return rotation


def connection(make: type, bodies: Sequence[str], first, second, **values) -> Any:
    """A loop or bushing of frames on two bodies."""
    (body1, body2), points = bodies, (first.translation.tolist(), second.translation.tolist())
    turns = {"rotation1": angles_of(first.rotation), "rotation2": angles_of(second.rotation)}
    return make(body1, points[0], body2, points[1], **turns, **values)


def add_joint(robot: Element, joint: Joint, places: Mapping[str, Any], content: ModelFile) -> None:
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
        element = joint_element(robot, name, kind, parent, child, origin)
        origin, parent = placement((0, 0, 0)), child
        if axis is not None:
            _add_axis(element, axis, content, own=kind == "revolute" or joint.kind == "prismatic")
    if parent != joint.child:
        joint_element(robot, parent, "fixed", parent, joint.child, tail)


def _displaced(kind: str, axis: JointAxis):
    """The SE3 of a joint at its lower limit."""
    import pinocchio

    shift = axis.limits[0] * axis.direction
    return placement(shift.tolist()) if kind == "prismatic" else pinocchio.SE3(pinocchio.exp3(shift), np.zeros(3))


def _add_axis(element: Element, axis: JointAxis, content: ModelFile, own: bool) -> None:
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


#: A frame by its name: the body it is fixed in, and its placement there, an SE3 of pinocchio.
Anchor = Callable[[str, str], tuple[str, Any]]

#: Words in names of tags, and of plugins and their tags, for something that may act on the motion.
_ACTS = re.compile(
    r"spring|stiff|damp|mass|inertia|gear|joint|constraint|coupl|mimic|bushing|hinge|slider|tendon|weld|attach|armature|reduction|"
    r"rotor|gravity|buoyan|hydro|lift_?drag|magnet|force|link|model",
    re.IGNORECASE,
)
_PLUGIN_ACTS = re.compile(r"mimic|spring|stiffness|damping|buoyan|hydrodynamic|lift_?drag|added_?mass|coupl", re.IGNORECASE)


def local_name(element: Element) -> str:
    """The tag without its namespace."""
    return element.tag.rpartition("}")[2].rpartition(":")[2]


def _is_drake(element: Element) -> bool:
    return "drake" in element.tag.removesuffix(local_name(element))


def acts(element: Element) -> str | None:
    """The first word in an element for something that may affect the motion."""
    if element.tag == "plugin":
        words = [element.get("filename", ""), element.get("name", ""), *(local_name(part) for part in element.iter())]
        return next((word for word in words if _PLUGIN_ACTS.search(word)), None)
    return next((local_name(part) for part in element.iter() if _ACTS.search(local_name(part))), None)


def _value(element: Element | None, usual: str = "") -> str:
    """The content of an element: an attribute as in a URDF, or its text as in an SDF."""
    if element is None:
        return usual
    return element.get("value") or element.get("name") or (element.text or "").strip() or usual


def read_drake(element: Element, anchor: Anchor, content: ModelFile) -> None:
    """Bushings and ball constraints of Drake among the children of an element; other tags of Drake are named."""
    for child in filter(_is_drake, element):
        tag, parts = local_name(child), {local_name(part): part for part in child}
        if tag == "joint":
            name, kind = short(child.get("name")), short(child.get("type"))
            raise InputError(f'{content.word.lower()}, joint "{name}": found the type "{kind}" of a drake:joint, which is not read')
        where = f"{content.word.lower()}, {tag}"
        if tag == "linear_bushing_rpy":
            ends = [anchor(_value(parts.get(f"bushing_frame{end}")), where) for end in "AC"]
            keys = {"turning_stiffness": "torque_stiffness", "turning_damping": "torque_damping"}
            keys |= {"stiffness": "force_stiffness", "damping": "force_damping"}
            values = {key: numbers(_value(parts.get(f"bushing_{tag}"), "0 0 0"), 3, f"{where}, {tag}") for key, tag in keys.items()}
            (bodies, places), name = zip(*ends), f"bushing {len(content.springs) + 1}"
            content.springs.append(connection(Bushing, bodies, *places, name=name, **values))
            text = "has torques about its rotation vector instead of roll, pitch and yaw, equal to first order where its frames coincide"
            content.remarks.append(Notice(NoticeKind.ACCURACY, f"{content.word}: {name} {text}"))
        elif tag == "ball_constraint":
            ends = []
            for end, key in ("A", "AP"), ("B", "BQ"):
                body, place = anchor(_value(parts.get(f"ball_constraint_body_{end}")), where)
                point = numbers(_value(parts.get(f"ball_constraint_p_{key}"), "0 0 0"), 3, f"{where}, p_{key}")
                ends.append((body, place * placement(point)))
            bodies, places = zip(*ends)
            content.loops.append(connection(Loop, bodies, *places, name=f"ball constraint {len(content.loops) + 1}"))
        elif tag != "collision_filter_group":
            content.leave_out(f"<drake:{short(tag)}>", True)


def read_motor(joint: str, elements: list[Element], content: ModelFile) -> None:
    """The motor of a joint from tags of Drake (rotor_inertia, gear_ratio) or ROS (motorInertia, mechanicalReduction)."""
    armature = 0.0
    for element in elements:
        parts = {local_name(part): part for part in element.iter()}
        where = f'{content.word.lower()}, motor of "{short(joint)}"'
        inertia = parts.get("rotor_inertia", parts.get("motorInertia"))
        ratio = next((parts[key] for key in ("gear_ratio", "mechanicalReduction", "mechanical_reduction") if key in parts), None)
        if inertia is not None:
            turns = number(_value(ratio, "1"), f"{where}, gear ratio")
            armature += number(_value(inertia), f"{where}, rotor inertia", minimum=0.0) * turns**2
        elif ratio is not None and amount(_value(ratio)) not in (0.0, 1.0):
            content.leave_out(f'reduction {short(_value(ratio))} of "{short(joint)}", which has no inertia of a rotor', False)
        if "controller_gains" in parts:
            content.leave_out(f'<drake:controller_gains> of "{short(joint)}"', True)
    if armature:
        content.motors[joint] = Motor(armature=armature + content.motors.get(joint, Motor()).armature)


def read_urdf_file(source) -> ModelFile:
    """A URDF with its extensions."""
    text, folder = read_urdf(source)
    root = parsed_xml(text, "urdf")
    content = ModelFile("URDF", root, folder)
    _read_version(root, content)
    checked_tree(root, _add_drake_joints(root, content))
    urdf = _UrdfFrames(root)
    read_drake(root, urdf.anchor, content)
    for loop in root.findall("loop_joint"):
        _read_loop_joint(loop, urdf, content)
    for transmission in root.iter("transmission"):
        _read_transmission(transmission, urdf, content)
    for gazebo in root.findall("gazebo"):
        _read_gazebo(gazebo, urdf, content)
    _leave_out_others(root, content)
    return content


#: Versions of URDF that are known, and the first one whose origins may have quaternions.
_VERSIONS, _QUATERNIONS = ("1.0", "1.1", "1.2"), "1.1"


def _read_version(root: Element, content: ModelFile) -> None:
    """Note an unknown version, and resolve what later ones write in another way."""
    if (version := root.get("version", _VERSIONS[0])) not in _VERSIONS:
        known = f"{_VERSIONS[0]} to {_VERSIONS[-1]} are known, and it is read as the last of them"
        content.remarks.append(Notice(NoticeKind.OMITTED, f"URDF: its version is {short(version)!a}; {known}", doubtful=True))
        version = _VERSIONS[-1]
    if version >= _QUATERNIONS:
        resolve_quaternions(root)


class _UrdfFrames:
    """The frames of a URDF by name: its links, and Drake's elements <frame>."""

    def __init__(self, root: Element):
        self.links = {str(link.get("name")) for link in root.findall("link")}  # names
        self.joints = {str(joint.get("name")): joint for joint in root.findall("joint")}  # elements by name
        self._frames = {str(frame.get("name")): frame for frame in root.findall("frame")}
        self.places: dict[str, Any] = {WORLD: placement((0, 0, 0))}  # SE3 of the links where all joints are at 0
        parents = {joint.find("child").get("link"): joint for joint in self.joints.values()}
        for link in self.links:
            path = [link]
            while path[-1] not in self.places and path[-1] in parents:
                path.append(parents[path[-1]].find("parent").get("link"))
            place = self.places.get(path[-1], placement((0, 0, 0)))
            self.places.setdefault(path[-1], place)
            for name in reversed(path[:-1]):
                place = self.places[name] = place * place_of(
                    parents[name].find("origin"), f'urdf, joint "{short(parents[name].get("name"))}"'
                )

    def anchor(self, name: str, where: str) -> tuple[str, Any]:
        """The body of a frame, and the SE3 in it."""
        name = RENAMED_GROUND if name == GROUND and RENAMED_GROUND in self.links else name
        if name in self.links:
            return name, placement((0, 0, 0))
        if (frame := self._frames.get(name)) is not None and frame.get("link") in self.links:
            return str(frame.get("link")), place_of(frame, f'urdf, frame "{short(name)}"')
        if name in (WORLD, GROUND):
            return GROUND, placement((0, 0, 0))
        raise InputError(f'{where}: there is no link or frame "{short(name)}"')

    def body(self, name: str, where: str) -> str:
        body, _ = self.anchor(name, where)
        return WORLD if body == GROUND else body

    def place(self, name: str, where: str):
        """The SE3 of a frame, as in ``Frames``."""
        return self.places[self.body(name, where)] * self.anchor(name, where)[1] if name != "__model__" else placement((0, 0, 0))


def _add_drake_joints(root: Element, content: ModelFile) -> set[str]:
    """Replace the joints of kinds that only Drake has, universal, ball and screw ones, by those of a description; names of balls."""
    balls = set()
    for element in [child for child in root if _is_drake(child) and local_name(child) == "joint"]:
        name, kind = element.get("name", ""), element.get("type", "")
        where = f'urdf, joint "{short(name)}"'
        if kind not in ("universal", "ball", "screw", "planar"):
            raise InputError(f'{where}: found the type "{short(kind)}" of a drake:joint; expected universal, ball, screw, planar')
        ends = [element.find(tag) for tag in ("parent", "child")]
        parent, child = ("" if end is None else end.get("link", "") for end in ends)
        root.remove(element)
        dynamics = element.find("dynamics")
        if kind == "planar":
            element.tag = "joint"
            for axis in element.findall("axis"):
                element.remove(axis)
            SubElement(element, "axis", xyz="0 0 1")  # where Drake has its normal
            root.append(element)
            if dynamics is not None and amount(dynamics.get("damping", "")):
                dynamics.attrib.pop("damping")
                content.leave_out(f'damping of "{short(name)}"', True)
            continue
        damping = 0.0 if dynamics is None else number(dynamics.get("damping", "0"), f"{where}, damping", minimum=0.0)
        if kind == "ball":
            balls.add(name)
        if kind == "ball" and damping:
            content.leave_out(f'damping of "{short(name)}"', True)
        directions = {"universal": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "screw": [axis_of(element, where)], "ball": []}[kind]
        axes = [JointAxis(np.array(direction) / np.linalg.norm(direction), damping=damping) for direction in directions]
        pitch = next((_value(part) for part in element if local_name(part) == "screw_thread_pitch"), "0")
        joint = Joint(
            name, kind, parent, child, place_of(element.find("origin"), where), axes, number(pitch, f"{where}, pitch") / (2 * np.pi)
        )
        add_joint(root, joint, {parent: placement((0, 0, 0)), child: joint.place}, content)
    return balls


def _read_loop_joint(element: Element, urdf: _UrdfFrames, content: ModelFile) -> None:
    """A loop of Isaac, RBDL or older Drake: two frames, each on a link."""
    name = element.get("name", "")
    where = f'urdf, loop_joint "{short(name)}"'
    ends = []
    for tag in ("link1", "link2"):
        end = element.find(tag)
        body, _ = urdf.anchor("" if end is None else end.get("link", ""), where)
        ends.append((body, place_of(end, f"{where}, {tag}")))
    kind = element.get("type", "fixed")
    kinds = {"continuous": "hinge", "revolute": "hinge", "prismatic": "prismatic", "fixed": "rigid", "ball": "point"}
    kinds |= {"spherical": "point"}
    if kind not in kinds:
        raise InputError(f'{where}: found the type "{short(kind)}"; expected {", ".join(kinds)}')
    bodies, places = zip(*ends)
    axis = {"axis": axis_of(element, where)} if kinds[kind] in ("hinge", "prismatic") else {}
    content.loops.append(connection(Loop, bodies, *places, name=name or None, kind=kinds[kind], **axis))


def _read_transmission(element: Element, urdf: _UrdfFrames, content: ModelFile) -> None:
    """The motors of a transmission; couplings of several joints are named."""
    names = [joint.get("name", "") for tag in ("joint", "rollJoint", "flexJoint") for joint in element.findall(tag)]
    moving = [name for name in dict.fromkeys(names) if name in urdf.joints]
    actuators = [part for part in element if "ctuator" in part.tag]
    passive = [part.get("name", "") for tag in ("passive_joint", "gap_joint") for part in element.findall(tag)]
    free = [name for name in passive if name in urdf.joints and urdf.joints[name].find("mimic") is None]
    where = f'<transmission> "{short(element.get("name"))}"'
    if [name for name in free if urdf.joints[name].get("type") != "fixed"]:
        content.leave_out(f"{where} of the passive joints {', '.join(map(short, free))}", True)
    if len(moving) == 1:
        own = [part for part in element if part.tag not in ("type", "hardwareInterface")]
        whole = Element("transmission")
        whole.extend(own)
        read_motor(moving[0], actuators if len(actuators) > 1 else [whole], content)
    elif any(amount(_value(part)) for part in element.iter() if local_name(part) in ("rotor_inertia", "motorInertia")):
        content.leave_out(f"{where}, inertias of rotors of {len(moving)} joints", True)


#: Children of <gazebo> that have no effect on the motion of the bodies, or only where they touch others.
_CONTACTS = (
    "material mu1 mu2 mu kp kd maxVel minDepth fdir1 selfCollide self_collide sensor laserRetro maxContacts visual implicitSpringDamper "
    "provideFeedback stopCfm stopErp stopKp stopKd fudgeFactor disableFixedJointLumping preserveFixedJoint cfmDamping erp cfm "
    "initial_joint_position collision canonicalBody allow_auto_disable pose static enable_wind physics ode limit light "
    "joint plugin springStiffness springReference gravity turnGravityOff kinematic dampingFactor velocity_decay"
)


def _read_gazebo(element: Element, urdf: _UrdfFrames, content: ModelFile) -> None:
    """Joints and springs of an element <gazebo>; the other parts that may act on the motion are named."""
    reference = element.get("reference")
    place = "<gazebo>" if reference is None else f'<gazebo> of "{short(reference)}"'
    joint = None if reference is None else urdf.joints.get(reference)
    stiffness = text_of(element, "springStiffness")
    if joint is not None and joint.get("type") != "fixed" and amount(stiffness):
        rest = number(text_of(element, "springReference", "0"), f"urdf, {place}, springReference")
        content.add_spring(str(reference), number(stiffness, f"urdf, {place}, springStiffness", minimum=0.0), rest)
    for child in element:
        tag, text = local_name(child), (child.text or "").strip()
        if child.tag == "joint" and reference is None:
            add_loop(read_joint(child, urdf, content), urdf.places, content)
        elif child.tag == "plugin":
            _read_plugin(child, urdf, content)
        elif child.tag in ("springStiffness", "springReference"):
            if joint is None and amount(text):
                content.leave_out(f"<{tag}> in {place}, which is no joint", True)
        elif child.tag in ("gravity", "turnGravityOff", "kinematic"):
            if is_true(text) != (child.tag == "gravity"):
                content.leave_out(f"<{tag}> {text} in {place}", True)
        elif child.tag in ("dampingFactor", "velocity_decay"):
            if amount(text) or any(amount(part.text or "") for part in child):
                content.leave_out(f"<{tag}> in {place}", True)
        elif not ("#controller" in child.tag or "#sensor" in child.tag or _is_drake(child)):
            leave_out_unknown([child], _CONTACTS, f" in {place}", content, acts)


def _read_plugin(element: Element, urdf: _UrdfFrames, content: ModelFile) -> None:
    """Note a plugin; one that couples joints which a <mimic> couples has no further effect."""
    word = acts(element)
    followers = [part.text.strip() for part in element.iter("mimicJoint") if part.text]
    coupled = followers and all(name in urdf.joints and urdf.joints[name].find("mimic") is not None for name in followers)
    if word and not coupled:
        content.leave_out(f"plugin {short(element.get('filename') or element.get('name') or '')} ({short(word)})", True)


#: Children of <robot>, <link>, <inertial>, <joint> and <dynamics> that are read, checked elsewhere or have no effect on the motion.
_READ_BY_URDF = {
    "robot": "link joint material transmission gazebo frame loop_joint sensor group collision_checking self_collision ros2_control mujoco",
    "link": "inertial visual collision contact sensor collision_checking self_collision_checking self_filter surface material origin "
    "audio light",
    "inertial": "origin mass inertia",
    "joint": "origin parent child axis limit dynamics mimic safety_controller calibration hardwareInterface sensor",
}


#: Attributes of the elements of links and joints; others are noted where they have a size.
_ATTRIBUTES = {
    "origin": "xyz rpy",
    "mass": "value",
    "inertia": " ".join(MOMENTS),
    "axis": "xyz",
    "mimic": "joint multiplier offset",
    "dynamics": "damping friction",
}


def _known(child: Element, parent: str) -> str:
    """Known tags among the children of an element; none with the name space of Drake."""
    return "" if _is_drake(child) else _READ_BY_URDF[parent]


def _has_size(element: Element) -> bool:
    return bool(acts(element) or any(map(amount, element.attrib.values())))


def _leave_out_attributes(element: Element, of: str, content: ModelFile) -> None:
    """Note unknown attributes of masses, inertias, origins, axes, mimics and dynamics; of the last those that may be forces are doubtful."""
    for tag, known in _ATTRIBUTES.items():
        for part in element.iterfind(f"inertial/{tag}" if element.tag == "link" else tag):
            for key, value in part.attrib.items():
                if key not in known.split() and amount(value):
                    may_act = tag != "dynamics" or _ACTS.search(key) is not None
                    content.leave_out(f"{short(key)} = {short(value)} in the <{tag}> of {of}", may_act)


def _leave_out_others(root: Element, content: ModelFile) -> None:
    """Note the unread parts of the other elements, and whether they may affect the motion."""
    leave_out_unknown((child for child in root if not _is_drake(child)), _READ_BY_URDF["robot"], "", content, acts)
    for mujoco in root.findall("mujoco"):
        for part, may_act in _of_mujoco(mujoco):
            content.leave_out(part, may_act)
    for link in root.findall("link"):
        name = short(link.get("name"))
        for child in link:
            text = (child.text or child.get("value") or "").strip()
            if child.tag in ("gravity", "kinematic"):
                if is_true(text) != (child.tag == "gravity"):
                    content.leave_out(f'<{child.tag}> {text} of "{name}"', True)
            else:
                leave_out_unknown([child], _known(child, "link"), f' of "{name}"', content, acts)
        leave_out_repeated(link, f'the link "{name}"', content)
        _leave_out_attributes(link, f'"{name}"', content)
        leave_out_unknown(link.iterfind("inertial/*"), _READ_BY_URDF["inertial"], f' in the <inertial> of "{name}"', content)
        if any(amount(_value(child)) != 1 for child in link.iterfind("contact/inertia_scaling")):
            content.leave_out(f'<inertia_scaling> of "{name}"', True)
    for joint in root.findall("joint"):
        name = short(joint.get("name"))
        for child in joint:
            leave_out_unknown([child], _known(child, "joint"), f' of the joint "{name}"', content, _has_size)
        leave_out_repeated(joint, f'the joint "{name}"', content)
        _leave_out_attributes(joint, f'"{name}"', content)


#: Settings of MuJoCo for a URDF that change masses, by their neutral values.
_MASSES = {"boundmass": "0", "boundinertia": "0", "settotalmass": "-1", "inertiafromgeom": "auto", "balanceinertia": "false"}


def _of_mujoco(element: Element) -> Iterator[tuple[str, bool]]:
    """Settings of an element <mujoco> that change the motion, and elements that a URDF does not have."""
    for child in element.iter():
        if child.tag == "compiler":
            for key, usual in _MASSES.items():
                if (value := child.get(key, usual)) not in (usual, "false"):
                    yield f'{key} = "{short(value)}" of <mujoco>', key != "balanceinertia"
        elif child.tag == "option":
            for key in ("gravity", "density", "viscosity", "wind"):
                if amount(child.get(key, "")) and child.get(key, "").split() not in (["0", "0", "-9.81"],):
                    yield f'{key} = "{short(child.get(key))}" of <mujoco>', True
        elif child.tag in ("default", "equality", "tendon", "actuator", "worldbody", "body", "joint") and len(child):
            yield f"<{child.tag}> of <mujoco>", True
