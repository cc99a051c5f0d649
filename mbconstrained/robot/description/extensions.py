"""Contents of URDF files beyond tree, masses and shapes: tags of Drake, Gazebo, ROS, MuJoCo, Isaac and PyBullet.

Each is read, or named in a notice: a doubtful one where it may carry mass, stiffness, damping or coupling.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...ground.coordinate_units import GROUND
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ..connections import Bushing, Loop
from ..flexible_joint import Motor
from .joints import (
    WORLD,
    Content,
    Joint,
    JointAxis,
    add_joint,
    add_loop,
    amount,
    connection,
    is_true,
    origin_of,
    placement,
    read_joint,
    text_of,
)
from .models import DOWNWARDS, ModelFile
from .urdf import RENAMED_GROUND, axis_of, checked_tree, number, numbers, parsed_xml, read_urdf, short

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


def read_drake(element: Element, anchor: Anchor, content: Content) -> None:
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
            content.notices.append(Notice(NoticeKind.ACCURACY, f"{content.word}: {name} {text}"))
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


def read_motor(joint: str, elements: list[Element], content: Content) -> None:
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
    root, content = parsed_xml(text, "urdf"), Content("URDF")
    checked_tree(root, _add_drake_joints(root, content))
    urdf = _UrdfFrames(root)
    read_drake(root, urdf.anchor, content)
    for loop in root.findall("loop_joint"):
        _read_loop_joint(loop, urdf, content)
    for transmission in root.iter("transmission"):
        _read_transmission(transmission, urdf, content)
    for gazebo in root.findall("gazebo"):
        _read_gazebo(gazebo, urdf, content)
    for part, may_act in _others(root):
        content.leave_out(part, may_act)
    return content.model_file(gravity=DOWNWARDS, description=root, folder=folder)


class _UrdfFrames:
    """The frames of a URDF by name: its links, and Drake's elements <frame>.

    Attributes:
        links: names.
        joints: elements by name.
        places: SE3 of the links where all joints are at 0.
    """

    def __init__(self, root: Element):
        self.links = {str(link.get("name")) for link in root.findall("link")}
        self.joints = {str(joint.get("name")): joint for joint in root.findall("joint")}
        self._frames = {str(frame.get("name")): frame for frame in root.findall("frame")}
        self.places: dict[str, Any] = {WORLD: placement((0, 0, 0))}
        parents = {joint.find("child").get("link"): joint for joint in self.joints.values()}
        for link in self.links:
            path = [link]
            while path[-1] not in self.places and path[-1] in parents:
                path.append(parents[path[-1]].find("parent").get("link"))
            place = self.places.get(path[-1], placement((0, 0, 0)))
            self.places.setdefault(path[-1], place)
            for name in reversed(path[:-1]):
                place = self.places[name] = place * origin_of(parents[name], f'urdf, joint "{short(parents[name].get("name"))}"')

    def anchor(self, name: str, where: str) -> tuple[str, Any]:
        """The body of a frame, and the SE3 in it."""
        name = RENAMED_GROUND if name == GROUND and RENAMED_GROUND in self.links else name
        if name in self.links:
            return name, placement((0, 0, 0))
        if (frame := self._frames.get(name)) is not None and frame.get("link") in self.links:
            keys = ("xyz", "rpy")
            values = (numbers(frame.get(key, "0 0 0"), 3, f'urdf, frame "{short(name)}", {key}') for key in keys)
            return str(frame.get("link")), placement(*values)
        if name in (WORLD, GROUND):
            return GROUND, placement((0, 0, 0))
        raise InputError(f'{where}: there is no link or frame "{short(name)}"')

    def body(self, name: str, where: str) -> str:
        """The body of a frame, as in ``Frames``."""
        body, _ = self.anchor(name, where)
        return WORLD if body == GROUND else body

    def place(self, name: str, where: str):
        """The SE3 of a frame, as in ``Frames``."""
        return self.places[self.body(name, where)] * self.anchor(name, where)[1] if name != "__model__" else placement((0, 0, 0))


def _add_drake_joints(root: Element, content: Content) -> set[str]:
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
        joint = Joint(name, kind, parent, child, origin_of(element, where), axes, number(pitch, f"{where}, pitch") / (2 * np.pi))
        add_joint(root, joint, {parent: placement((0, 0, 0)), child: joint.place}, content)
    return balls


def _read_loop_joint(element: Element, urdf: _UrdfFrames, content: Content) -> None:
    """A loop of Isaac, RBDL or older Drake: two frames, each on a link."""
    name = element.get("name", "")
    where = f'urdf, loop_joint "{short(name)}"'
    ends = []
    for tag in ("link1", "link2"):
        end = element.find(tag)
        body, _ = urdf.anchor("" if end is None else end.get("link", ""), where)
        values = ("0 0 0" if end is None else end.get(key, "0 0 0") for key in ("xyz", "rpy"))
        ends.append((body, placement(*(numbers(value, 3, f"{where}, {tag}") for value in values))))
    kind = element.get("type", "fixed")
    kinds = {"continuous": "hinge", "revolute": "hinge", "prismatic": "prismatic", "fixed": "rigid", "ball": "point"}
    kinds |= {"spherical": "point"}
    if kind not in kinds:
        raise InputError(f'{where}: found the type "{short(kind)}"; expected {", ".join(kinds)}')
    bodies, places = zip(*ends)
    axis = {"axis": axis_of(element, where)} if kinds[kind] in ("hinge", "prismatic") else {}
    content.loops.append(connection(Loop, bodies, *places, name=name or None, kind=kinds[kind], **axis))


def _read_transmission(element: Element, urdf: _UrdfFrames, content: Content) -> None:
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
_CONTACTS = set(
    "material mu1 mu2 mu kp kd maxVel minDepth fdir1 selfCollide self_collide sensor laserRetro maxContacts visual implicitSpringDamper "
    "provideFeedback stopCfm stopErp stopKp stopKd fudgeFactor disableFixedJointLumping preserveFixedJoint cfmDamping erp cfm "
    "initial_joint_position collision canonicalBody allow_auto_disable pose static enable_wind physics ode limit light".split()
)


def _read_gazebo(element: Element, urdf: _UrdfFrames, content: Content) -> None:
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
        elif child.tag not in _CONTACTS and "#controller" not in child.tag and "#sensor" not in child.tag and not _is_drake(child):
            content.leave_out(f"<{short(tag)}> in {place}", acts(child) is not None)


def _read_plugin(element: Element, urdf: _UrdfFrames, content: Content) -> None:
    """Note a plugin; one that couples joints which a <mimic> couples has no further effect."""
    word = acts(element)
    followers = [part.text.strip() for part in element.iter("mimicJoint") if part.text]
    coupled = followers and all(name in urdf.joints and urdf.joints[name].find("mimic") is not None for name in followers)
    if word and not coupled:
        content.leave_out(f"plugin {short(element.get('filename') or element.get('name') or '')} ({short(word)})", True)


#: Children of <robot>, <link>, <inertial>, <joint> and <dynamics> that are read, checked elsewhere or have no effect on the motion.
_KNOWN = {
    "robot": "link joint material transmission gazebo frame loop_joint sensor group collision_checking self_collision ros2_control mujoco",
    "link": "inertial visual collision contact sensor collision_checking self_collision_checking self_filter surface material origin "
    "audio light",
    "inertial": "origin mass inertia",
    "joint": "origin parent child axis limit dynamics mimic safety_controller calibration hardwareInterface sensor",
}


def _others(root: Element) -> Iterator[tuple[str, bool]]:
    """Unread parts of the other elements, and whether they may affect the motion."""
    for child in root:
        if child.tag not in _KNOWN["robot"].split() and not _is_drake(child):
            yield f"<{short(local_name(child))}>", acts(child) is not None
    for mujoco in root.findall("mujoco"):
        yield from _of_mujoco(mujoco)
    for link in root.findall("link"):
        name = short(link.get("name"))
        for child in link:
            text = (child.text or child.get("value") or "").strip()
            if child.tag in ("gravity", "kinematic"):
                if is_true(text) != (child.tag == "gravity"):
                    yield f'<{child.tag}> {text} of "{name}"', True
            elif child.tag not in _KNOWN["link"].split():
                yield f'<{short(local_name(child))}> of "{name}"', acts(child) is not None
        for child in link.iterfind("inertial/*"):
            if child.tag not in _KNOWN["inertial"].split():
                yield f'<{short(local_name(child))}> in the <inertial> of "{name}"', True
        for child in link.iterfind("contact/inertia_scaling"):
            if amount(_value(child)) != 1:
                yield f'<inertia_scaling> of "{name}"', True
    for joint in root.findall("joint"):
        name = short(joint.get("name"))
        for child in joint:
            if child.tag not in _KNOWN["joint"].split():
                yield (
                    f'<{short(local_name(child))}> of the joint "{name}"',
                    acts(child) is not None or any(map(amount, child.attrib.values())),
                )
        dynamics = joint.find("dynamics")
        for key, value in {} if dynamics is None else dynamics.attrib.items():
            if key not in ("damping", "friction") and amount(value):
                yield f'{short(key)} = {short(value)} in the <dynamics> of "{name}"', _ACTS.search(key) is not None


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
