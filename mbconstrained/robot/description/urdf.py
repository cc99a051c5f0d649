"""URDF and SRDF texts, validated before pinocchio reads them, so that errors name the element and the remedy; masses of links.

A URDF is data: nothing in it is executed or fetched. Mesh files are not opened here (``meshes``).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...ground.by_name import Public
from ...ground.checks import listed, nearest, real_array, real_number
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import noise_of
from ...ground.units import GROUND

#: Kinds of joints with several degrees of freedom that have tangent coordinates here.
SEVERAL = ("JointModelPlanar", "JointModelFreeFlyer", "JointModelSpherical", "JointModelTranslation")


#: Number of unread parts, and of links, named in a notice; the others are counted.
MOST_PARTS = 12

#: The acceleration of free fall where a file gives none (m/s^2).
DOWNWARDS = (0.0, 0.0, -9.81)


@dataclass(eq=False)
class ModelFile:
    """The content of a file of a robot, which its reader fills in: the tree, and what joins its links besides joints."""

    word: str = ""  # the format, for messages; empty for a pinocchio model alone
    # the element <robot> of a URDF, for other formats made of their tree, and the folder of the file
    description: Element = None
    folder: Path | None = None
    model: Any = None  # of pinocchio, of an MJCF file or a given one; of others it is built from the description
    gravity: Sequence[float] = DOWNWARDS  # shape (3,) (m/s^2)
    # ``Loop``, ``Bushing``, ``Tendon`` and ``JointGear``
    loops: list[Any] = field(default_factory=list)
    springs: list[Any] = field(default_factory=list)
    tendons: list[Any] = field(default_factory=list)
    gears: list[Any] = field(default_factory=list)
    # by joint
    joint_stiffness: dict[str, float] = field(default_factory=dict)
    joint_rest: dict[str, float] = field(default_factory=dict)
    motors: dict[str, Any] = field(default_factory=dict)
    states: dict[str, np.ndarray] = field(default_factory=dict)  # configurations q by name
    # by body a point (m) at which a force compensates the weight of a mass (kg)
    lift: dict[str, tuple[Sequence[float], float]] = field(default_factory=dict)
    # parts that are not read and may act on the motion, and those that do not
    doubted: list[str] = field(default_factory=list)
    noted: list[str] = field(default_factory=list)
    usual: list[str] = field(default_factory=list)  # links that give no mass or no inertia
    stopped: list[str] = field(default_factory=list)  # joints both limits of which are the same
    remarks: list[Notice] = field(default_factory=list)  # other notices
    path: Path | None = None  # of an MJCF file
    compiled: Any = None  # the ``MjModel`` of an MJCF file, to compare with; None where it has elastic parts that are not read
    drawn: Any = None  # the model with shapes
    links: Sequence[str] = ()  # links of its bodies, by number
    undrawn: frozenset[int] = frozenset()  # geoms whose mesh is missing

    def __post_init__(self):
        if self.model is not None:
            self.description = described(self.model)

    def leave_out(self, part: str, acts: bool) -> None:
        """Note an omitted part, and whether it may affect the motion."""
        (self.doubted if acts else self.noted).append(part)

    def add_spring(self, joint: str, stiffness: float, rest: float) -> None:
        """Add a spring of a joint, unless its stiffness is zero."""
        if stiffness:
            self.joint_stiffness[joint], self.joint_rest[joint] = stiffness, rest

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on what was left out or changed, one for all parts of a kind."""
        rows = (
            (NoticeKind.ACCURACY, "links that give no mass or no inertia have those of the format, 1 kg and 1 kg m^2", self.usual),
            (NoticeKind.OVERRIDE, "joints whose limits are equal are fixed", self.stopped),
            (
                NoticeKind.OMITTED,
                "not read, though it may act on the motion; give loops, springs, gears, motors or payloads instead",
                self.doubted,
            ),
            (NoticeKind.OMITTED, "not read, without effect on the motion", self.noted),
        )
        notices = (
            Notice(kind, f"{self.word}: {text}: {listed(list(dict.fromkeys(parts)), MOST_PARTS)}", doubtful=parts is self.doubted)
            for kind, text, parts in rows
            if parts
        )
        return (*self.remarks, *notices)

    def named_states(self, tangent) -> dict[str, dict]:
        """The states as guesses: values (rad, m) by joint, of the joints of a ``Tangent``; none where joints of the file are locked."""
        return {name: tangent.values(q) for name, q in self.states.items() if len(q) == tangent.model.nq}


def is_model(given) -> bool:
    """Whether an object is a pinocchio model; pinocchio is imported only where it may be one."""
    if isinstance(given, str) or not type(given).__module__.startswith("pinocchio"):
        return False
    import pinocchio

    return isinstance(given, pinocchio.Model)


def has_free_base(model) -> bool:
    """Whether the first joint of a model is a free one of its base."""
    return model.njoints > 1 and model.joints[1].shortname() == "JointModelFreeFlyer"


def described(model) -> Element:
    """The names, masses and joints of a pinocchio model as the element <robot> of a URDF, without shapes."""
    import pinocchio

    robot, first = Element("robot", name=str(model.name) or "robot"), {}
    for frame in model.frames:
        if frame.type == pinocchio.FrameType.BODY:
            link = SubElement(robot, "link", name=str(frame.name))
            first.setdefault(int(frame.parentJoint), link)
    if not first:
        raise InputError('model: found no body; name the bodies, model.addBodyFrame("link", joint, pinocchio.SE3.Identity(), 0)')
    for number in range(1, model.njoints):
        joint, name = model.joints[number], str(model.names[number])
        kind = joint.shortname()
        if (joint.nv != 1 and kind not in SEVERAL) or "Mimic" in kind:
            raise InputError(
                f'model: the joint "{name}" is a {kind.removeprefix("JointModel")}, which has no coordinates here; write it as joints with one '
                "degree of freedom each"
            )
        if number in first:
            inertial, own = SubElement(first[number], "inertial"), model.inertias[number]
            SubElement(inertial, "mass", value=repr(float(own.mass)))
            values = np.array(own.inertia)[np.triu_indices(3)].tolist()
            SubElement(inertial, "inertia", {key: repr(value) for key, value in zip(MOMENTS, values)})
            word = "floating" if joint.nv > 1 else "prismatic" if kind.startswith("JointModelP") else "revolute"
            if number > 1 or not has_free_base(model):
                parent = first.get(int(model.parents[number]), first[min(first)])
                joint_element(robot, name, word, parent.get("name", ""), first[number].get("name", ""))
    return robot


def joint_element(robot: Element, name: str, kind: str, parent: str, child: str, place=None) -> Element:
    """A new joint of a URDF, at an SE3."""
    joint = SubElement(robot, "joint", name=name, type=kind)
    for tag, link in (("parent", parent), ("child", child)):
        SubElement(joint, tag, link=link)
    if place is not None:
        add_origin(joint, place)
    return joint


def placement(xyz: Sequence[float], rpy: Sequence[float] = (0.0, 0.0, 0.0)):
    """The SE3 of a translation (m) and roll, pitch, yaw (rad)."""
    import pinocchio

    return pinocchio.SE3(pinocchio.rpy.rpyToMatrix(*rpy), np.array(xyz, dtype=float))


def place_of(element: Element | None, where: str):
    """The SE3 of the attributes xyz and rpy of an element; none are zeros."""
    texts = ((key, "0 0 0" if element is None else element.get(key, "0 0 0")) for key in ("xyz", "rpy"))
    return placement(*(numbers(text, 3, f"{where}, {key}") for key, text in texts))


def rotation_of(quaternion: Sequence[float], where: str) -> np.ndarray:
    """The rotation of a quaternion x, y, z, w of any length but 0."""
    import pinocchio

    if not (size := np.linalg.norm(quaternion)):
        raise InputError(f"{where}: found a quaternion of zeros; expected x, y, z, w of length 1")
    return pinocchio.Quaternion(np.array(quaternion) / size).matrix()


def resolve_quaternions(root: Element) -> None:
    """Write the quaternions of origins, which a URDF may have since version 1.1, as roll, pitch, yaw."""
    for element in root:
        where = f'urdf, {short(element.tag)} "{short(element.get("name"))}", origin'
        for origin in element.iter("origin"):
            text = origin.attrib.pop("quat_xyzw", None)
            if text is not None and "rpy" in origin.attrib:
                raise InputError(f"{where}: found rpy and quat_xyzw; expected one of them")
            if text is not None:
                quaternion = numbers(text, 4, f"{where}, quat_xyzw")
                origin.set("rpy", _text(angles_of(rotation_of(quaternion, f"{where}, quat_xyzw"))))


def add_origin(parent: Element, place) -> None:
    """Add an SE3 as the element <origin> of a URDF."""
    SubElement(parent, "origin", xyz=_text(place.translation.tolist()), rpy=_text(angles_of(place.rotation)))


def angles_of(rotation: np.ndarray) -> list[float]:
    """Roll, pitch, yaw of a rotation (3, 3)."""
    import pinocchio

    return pinocchio.rpy.matrixToRpy(rotation).tolist()


LARGEST_URDF = 5_000_000  # bytes; the URDF of a humanoid has a few hundred thousand
MOST_LINKS = 2_000

_JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")


def read_urdf(source: str | Path, kind: str = "URDF") -> tuple[str, Path | None]:
    """The XML text, and the folder of the file if it was one."""
    if isinstance(source, str) and "<" in source:
        return source, None
    if not isinstance(source, (str, Path)):
        raise InputError(f"{kind.lower()}: found {type(source).__name__}; expected the path of a .{kind.lower()} file, or its text")
    path = Path(source)
    try:
        if path.stat().st_size > LARGEST_URDF:
            raise InputError(f"{path.name}: the file has {path.stat().st_size:,} bytes; at most {LARGEST_URDF:,} are read")
        return path.read_text("utf-8-sig"), path.parent
    except FileNotFoundError:
        others = [other.name for other in path.parent.glob(f"*.{kind.lower()}")] if path.parent.is_dir() else []
        raise InputError(f"{path}: there is no such {kind} file{nearest(path.name, others)}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path.name}: not a text file in UTF-8") from None
    except InputError:
        raise
    except (OSError, ValueError) as problem:
        raise InputError(f"{kind.lower()}: the file cannot be read ({getattr(problem, 'strerror', None) or problem})") from None


def checked_tree(root: ElementTree.Element, balls: Collection[str] = ()) -> ElementTree.Element:
    """The element <robot> with checked names, joint types and tree; ``skeleton`` checks the numbers."""
    if any(element.tag.startswith("{") and "xacro" in element.tag for element in root.iter()):
        raise InputError("urdf: found xacro macros; expand them first: xacro robot.xacro > robot.urdf")
    if not root.findall("link"):
        raise InputError("urdf: found no <link>; a robot needs at least one")
    if (count := len(root.findall("link"))) > MOST_LINKS:
        raise InputError(f"urdf: found {count:,} links; at most {MOST_LINKS:,} are read")
    _rename_ground(root)
    links = _names(root, "link")
    _names(root, "joint")
    children = [_check_joint(joint, set(links), balls) for joint in root.findall("joint")]
    _check_tree(children, links)
    return root


def parsed_xml(text: str, what: str) -> ElementTree.Element:
    """The element <robot> of a text."""
    root = xml_element(text, what)
    if root.tag != "robot":
        raise InputError(f"{what}: found <{short(root.tag)}>; expected <robot>{_OTHER_FORMATS.get(root.tag, '')}")
    return root


def xml_element(text: str, what: str) -> ElementTree.Element:
    """The root element of a text, which is UTF-8 whatever it declares."""
    if re.search(r"<!(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise InputError(f"{what}: found a document type or an entity, which are not read; take it out")
    try:
        return ElementTree.fromstring(text.encode(), ElementTree.XMLParser(encoding="utf-8"))
    except (ElementTree.ParseError, ValueError) as problem:
        raise InputError(f"{what}: not XML ({problem})") from None


def root_link(root: ElementTree.Element) -> str:
    """The name of the link without a parent, the base, of a checked tree."""
    children = {child.get("link") for joint in root.findall("joint") for child in joint.findall("child")}
    return next(str(link.get("name")) for link in root.findall("link") if link.get("name") not in children)


#: Advice where another format than URDF is found, by the name of the root element.
_OTHER_FORMATS = {
    "mujoco": ": this is MJCF; give the path of the file, which ends in .xml",
    "sdf": ": this is SDF; give the path of the file, which ends in .sdf or .world",
}

#: The beginning of the names of links without mass that carry a joint whose frame is not that of its link; they are not shown.
HIDDEN = "frame of joint "

#: The name of a link "ground", which here names the body that does not move.
RENAMED_GROUND = f"{GROUND} link"


def _rename_ground(root: Element) -> None:
    """Rename a link "ground", in its element and in the joints."""
    for element, key in [(e, "name") for e in root.findall("link")] + [
        (e, "link") for joint in root.findall("joint") for tag in ("parent", "child") for e in joint.findall(tag)
    ]:
        if element.get(key) == GROUND:
            element.set(key, RENAMED_GROUND)


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: q_follower = multiplier q_leader + offset; a leader that is fixed stays at 0."""

    follower: str
    leader: str
    multiplier: float
    offset: float
    leader_is_fixed: bool = False


def mimics_of(root: ElementTree.Element) -> tuple[Mimic, ...]:
    """The joints that follow others; one whose leader the URDF does not have moves by itself (``masses.description_notices``)."""
    joints, mimics = {joint.get("name"): joint for joint in root.findall("joint")}, []
    for name, joint in joints.items():
        if (mimic := joint.find("mimic")) is None or joint.get("type") == "fixed":
            continue
        where, leader = f'urdf, joint "{short(name)}", mimic', mimic.get("joint", "")
        if leader not in joints:
            continue
        kinds = joint.get("type"), joints[leader].get("type")
        if several := [kind for kind in kinds if kind in ("planar", "floating")]:
            raise InputError(f"{where}: found a {several[0]} joint; only joints with one degree of freedom can follow or lead")
        numbers = [number(mimic.get(key, usual), f"{where}, {key}") for key, usual in (("multiplier", "1"), ("offset", "0"))]
        mimics.append(Mimic(str(name), leader, *numbers, leader_is_fixed=kinds[1] == "fixed"))
    by_follower = {mimic.follower: mimic for mimic in mimics}
    return tuple(of_first_leader(mimic, by_follower) for mimic in mimics)


def of_first_leader(mimic: Mimic, by_follower: Mapping[str, Mimic]) -> Mimic:
    """The mimic joint as a gear to the first joint of a chain of mimic joints, q = r (r' q' + o') + o."""
    passed = [mimic.follower]
    while (before := by_follower.get(mimic.leader)) is not None:
        if before.follower in passed:
            circle = " -> ".join(f'"{short(name)}"' for name in (*passed[passed.index(before.follower) :], before.follower))
            raise InputError(f'"{short(mimic.follower)}" follows itself by mimic joints or gears ({circle}); one of them must lead')
        passed.append(before.follower)
        ratio, offset = mimic.multiplier * before.multiplier, mimic.multiplier * before.offset + mimic.offset
        mimic = Mimic(mimic.follower, before.leader, ratio, offset, before.leader_is_fixed)
    return mimic


def _names(root, tag: str) -> list[str]:
    names = [str(element.get("name", "")) for element in root.findall(tag)]
    for name, count in Counter(names).items():
        if not name or name != name.strip():
            raise InputError(
                f'urdf: found a <{tag}> with the name "{short(name)}"; expected one that begins and ends with a letter'
            )
        if count > 1:
            raise InputError(f'urdf: two elements <{tag}> are named "{short(name)}"; names must differ')
    return names


def _check_joint(joint, links: set[str], balls: Collection[str]) -> tuple[str, str]:
    """Parent and child of a joint."""
    where = f'urdf, joint "{short(joint.get("name"))}"'
    if joint.get("type") not in _JOINT_TYPES and joint.get("name") not in balls:
        kind = short(joint.get("type"))
        raise InputError(f'{where}: found the type "{kind}"{nearest(kind, _JOINT_TYPES)}; expected {", ".join(_JOINT_TYPES)}')
    ends = []
    for tag in ("parent", "child"):
        element = joint.find(tag)
        name = "" if element is None else element.get("link", "")
        if name not in links:
            raise InputError(f'{where}: its {tag} is "{short(name)}", which is no link{nearest(name, links)}')
        ends.append(name)
    return ends[0], ends[1]


def _check_tree(ends: list[tuple[str, str]], links: list[str]) -> None:
    """Check that exactly one path leads from one link, the base, to each other link."""
    twice = [child for child, count in Counter(child for _, child in ends).items() if count > 1]
    if twice:
        raise InputError(
            f'urdf: the link "{short(twice[0])}" is the child of two joints; a URDF is a tree: keep one, and close the loop with '
            "mb.Loop"
        )
    children = {child for _, child in ends}
    roots = [name for name in links if name not in children]
    if len(roots) > 1:
        names = ", ".join(f'"{short(name)}"' for name in roots[:3])
        raise InputError(f"urdf: {len(roots)} links have no parent ({names}); expected one, the base")
    reached = set(roots)
    while more := {child for parent, child in ends if parent in reached} - reached:
        reached |= more
    if rest := [name for name in links if name not in reached]:
        names = ", ".join(f'"{short(name)}"' for name in rest[:3])
        raise InputError(f"urdf: the joints of {names} go round in a circle; a URDF is a tree: close loops with mb.Loop")


#: Range of the numbers of a URDF in SI units, of which the squares stay within that of float64; smaller ones are 0, the noise of the
#: programs that write them.
LEAST, LARGEST = 1e-100, 1e100


def number(text, where: str, minimum: float | None = None) -> float:
    """A number whose magnitude is at most LARGEST; magnitudes below LEAST become 0.

    >>> number(" 2.5 ", "mass")
    2.5
    """
    return numbers(text, 1, where, minimum)[0]


def numbers(text, count: int, where: str, minimum: float | None = None) -> list[float]:
    """A given count of numbers between blanks.

    >>> numbers("0 0 -9.81", 3, "xyz")
    [0.0, 0.0, -9.81]
    """
    try:
        values = [float(part) for part in str(text).split()]
    except ValueError:
        values = []
    if len(values) != count:
        raise InputError(f"{where}: found {short(text)!a}; expected {f'{count} numbers' if count > 1 else 'a number'}")
    values = [0.0 if abs(value) < LEAST else value for value in values]
    for value in values:
        if not abs(value) <= LARGEST:  # false for what is not finite, too
            raise InputError(f"{where}: found {value:g}; expected a size of at most {LARGEST:g}")
        if minimum is not None and value < minimum:
            raise InputError(f"{where}: found {value:g}; expected at least {minimum:g}")
    return values


def short(text) -> str:
    """A text as quoted in messages: printable and short."""
    text = "".join(c if c.isprintable() else "?" for c in str(text))
    return text if len(text) <= 60 else text[:57] + "..."


# The parser of pinocchio replaces an inertia that it cannot read by none; the skeleton that it gets here contains checked
# masses and joints alone, without shapes.

MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")

#: A negative moment of inertia below this share of the largest of its link, or a thousandth of it of the largest of all, is a
#: rounded zero; below this share of the largest of all it is noted, and no reason for doubt.
ROUNDED = 1e-6

_UNLIMITED = ("continuous", "fixed", "floating", "planar", "ball")


def skeleton(robot: Element) -> str:
    """The XML text of a robot with masses and joints alone, every number validated."""
    tree = Element("robot", name=str(robot.get("name") or "robot"))
    for link in robot.findall("link"):
        copy = SubElement(tree, "link", name=link.get("name"))
        if (inertial := link.find("inertial")) is not None:
            _copy_inertial(copy, inertial, f'urdf, link "{short(link.get("name"))}"')
    for joint in robot.findall("joint"):
        _copy_joint(tree, joint, f'urdf, joint "{short(joint.get("name"))}"')
    return ElementTree.tostring(tree, encoding="unicode")


def _copy(parent: Element, element: Element, tag: str, keys: Sequence[str], where: str, count=1, usual=None, **limits) -> None:
    """Copy the numbers of a child, if there is one."""
    if (child := element.find(tag)) is not None:
        texts = {key: _text(numbers(child.get(key, usual), count, f"{where}, {key}", **limits)) for key in keys}
        SubElement(parent, tag, texts)


def link_masses(robot: Element) -> dict[str, float]:
    """Masses by link (kg), of those that have one."""
    elements = {link.get("name"): link.find("inertial/mass") for link in robot.findall("link")}
    return {name: number(mass.get("value"), "mass") for name, mass in elements.items() if mass is not None}


def _copy_inertial(link: Element, inertial: Element, where: str) -> None:
    for tag in ("mass", "inertia"):
        if inertial.find(tag) is None:
            raise InputError(f"{where}, inertial: found no <{tag}>; give it, with zeros where there is none")
    copy = SubElement(link, "inertial")
    _copy(copy, inertial, "origin", ("xyz", "rpy"), where, 3, "0 0 0")
    SubElement(copy, "mass", value=repr(number(inertial.find("mass").get("value"), f"{where}, mass", minimum=0.0)))
    _copy(copy, inertial, "inertia", MOMENTS, f"{where}, inertia")


def _copy_joint(robot: Element, joint: Element, where: str) -> None:
    kind, ends = joint.get("type"), (joint.find(tag).get("link") for tag in ("parent", "child"))
    copy = joint_element(robot, joint.get("name"), kind, *ends)
    _copy(copy, joint, "origin", ("xyz", "rpy"), where, 3, "0 0 0")
    if kind not in ("fixed", "floating", "ball"):
        SubElement(copy, "axis", xyz=_text(axis_of(joint, where)))
    if kind not in _UNLIMITED:
        SubElement(copy, "limit", {key: _text([value]) for key, value in _limits(joint, where).items()})
    _copy(copy, joint, "dynamics", ("damping", "friction"), where, usual="0", minimum=0.0)


def axis_of(joint: Element, where: str) -> list[float]:
    """The axis of a joint, x where none is given."""
    axis = joint.find("axis")
    direction = numbers("1 0 0" if axis is None else axis.get("xyz", ""), 3, f"{where}, axis")
    if not any(direction):
        raise InputError(f"{where}, axis: found 0 0 0; expected a direction")
    if joint.get("type") == "planar" and (any(direction[:2]) or direction[2] < 0):  # pinocchio does not look at it
        raise InputError(f'{where}, axis: found {_text(direction)}; expected "0 0 1" of a planar joint: turn its origin instead')
    return direction


def _limits(joint: Element, where: str) -> dict[str, float]:
    """Limits of a joint; omitted ones are 0, and a joint with both at 0 has none."""
    limit = joint.find("limit")
    keys = ("lower", "upper", "effort", "velocity")
    values = {key: number("0" if limit is None else limit.get(key, "0"), f"{where}, limit, {key}") for key in keys}
    low, high = values["lower"], values["upper"]
    if low > high or low == high != 0:
        raise InputError(f"{where}, limit: found lower {low:g} and upper {high:g}; expected lower below upper, or lock the joint")
    return values


def _text(values: list[float]) -> str:
    return " ".join(map(repr, values))


#: Numbers of a pose of the base: x, y, z and a quaternion x, y, z, w.
POSE = 7


@dataclass(frozen=True)
class SemanticDescription:
    """The content of an SRDF file.

    Attributes:
        states: values (rad, m) by joint, by name of the state; equal names of several groups are one state.
        rotors: inertia of the rotor (kg m^2, kg) and gear ratio by joint, of those that have both.
    """

    states: dict[str, dict[str, float | tuple[float, ...]]] = field(default_factory=dict)
    rotors: dict[str, tuple[float, float]] = field(default_factory=dict)

    def state(self, name: str, joints: Collection[str], base: str | None) -> dict[str, float | tuple[float, ...]]:
        """The values of the moving joints in a state; a free base, if one is named, takes the pose of a joint that is not among them."""
        if name not in self.states:
            there = f"; there are {', '.join(self.states)}" if self.states else ": no SRDF file with one is given (srdf)"
            raise InputError(f'state: there is no "{short(name)}"{nearest(name, self.states)}{there}')
        guess = {}
        for joint, value in self.states[name].items():
            if joint in joints:
                guess[joint] = value
            elif base is not None and isinstance(value, tuple) and len(value) == POSE:
                guess[base] = value
        return guess


def read_srdf(path: str | Path) -> SemanticDescription:
    """States and rotors of an SRDF file."""
    root = parsed_xml(read_urdf(path, "SRDF")[0], "srdf")
    content = SemanticDescription()
    for state in root.iter("group_state"):
        name = state.get("name", "")
        values = content.states.setdefault(name, {})
        for joint in state.findall("joint"):
            text, where = joint.get("value", ""), f'srdf, state "{short(name)}", joint "{short(joint.get("name"))}"'
            entries = numbers(text, max(1, len(text.split())), where)
            values[joint.get("name", "")] = entries[0] if len(entries) == 1 else tuple(entries)
    for joint in root.iterfind(".//rotor_params/joint"):
        where = f'srdf, rotor of "{short(joint.get("name"))}"'
        (inertia,), (ratio,) = (numbers(joint.get(key, "0"), 1, f"{where}, {key}") for key in ("mass", "gear_ratio"))
        if inertia < 0:
            raise InputError(f"{where}, mass: found {inertia:g}; expected at least 0")
        if inertia and ratio:
            content.rotors[joint.get("name", "")] = inertia, ratio
    return content


@dataclass(frozen=True)
class Payload(Public):
    """A body fixed to a link, such as the load of a gripper.

    Attributes:
        body: the link.
        mass: in kg.
        centre: of mass, in the link's frame (m).
        inertia: about it, in the directions of the link: the three principal moments, or ixx, ixy, ixz, iyy, iyz, izz (kg m^2).

    >>> Payload("tool", mass=2.0, centre=(0, 0, 0.1)).inertia
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """

    body: str
    mass: float
    centre: Sequence[float] = (0.0, 0.0, 0.0)
    inertia: Sequence[float] = (0.0, 0.0, 0.0)

    def __post_init__(self):
        where = f'payload of "{self.body}"'
        object.__setattr__(self, "mass", real_number(self.mass, f"{where}: mass", minimum=0.0))
        object.__setattr__(self, "centre", tuple(real_array(self.centre, f"{where}: centre", shape=(3,)).tolist()))
        object.__setattr__(self, "inertia", tuple(_tensor(self.inertia, f"{where}: inertia")[np.triu_indices(3)].tolist()))

    @property
    def tensor(self) -> np.ndarray:
        """The inertia as a matrix, shape (3, 3)."""
        return _tensor(self.inertia, "inertia")


def _tensor(moments, where: str) -> np.ndarray:
    """The symmetric matrix of three principal moments or of six moments; no moment about any axis may be negative."""
    values = real_array(moments, where, shape=(None,))
    if len(values) not in (3, 6):
        raise InputError(f"{where}: found {len(values)} numbers; expected 3 principal moments, or ixx, ixy, ixz, iyy, iyz, izz")
    tensor = np.diag(values) if len(values) == 3 else _symmetric(values)
    if (least := np.linalg.eigvalsh(tensor)[0]) < -noise_of(np.abs(tensor).max(), 3):
        raise InputError(f"{where}: the moment of inertia about some axis is {least:.3g} kg m^2; expected 0 or more")
    return tensor


def _symmetric(moments: Sequence[float]) -> np.ndarray:
    """The matrix of ixx, ixy, ixz, iyy, iyz, izz."""
    tensor = np.zeros((3, 3))
    tensor[np.triu_indices(3)] = moments
    return tensor + np.triu(tensor, 1).T


def replace_masses(robot: Element, masses: Mapping[str, float], inertias: Mapping[str, Sequence[float]]) -> None:
    """Replace masses and inertias of links in a description; with a mass alone the inertia changes in the same ratio."""
    links = {link.get("name", ""): link for link in robot.findall("link")}
    for key, values in (("masses", masses), ("inertias", inertias)):
        if not isinstance(values, Mapping):
            raise InputError(f"{key}: found {type(values).__name__}; expected values by link")
        for name in values:
            if name not in links:
                raise InputError(f'{key}: there is no link "{name}"{nearest(str(name), links)}')
            if links[name].find("inertial/mass") is None or links[name].find("inertial/inertia") is None:
                raise InputError(f'{key}: the link "{name}" has no <inertial>; add an mb.Payload to it instead')
    for name, mass in masses.items():
        element, inertia = links[name].find("inertial/mass"), links[name].find("inertial/inertia")
        new = real_number(mass, f"masses: {name}", minimum=0.0)
        old = number(element.get("value"), f'urdf, link "{name}", mass')
        if old <= 0 and new and name not in inertias:
            raise InputError(
                f'masses: the link "{name}" has no mass in the URDF, so that its inertia has no ratio to it; give inertias, too'
            )
        element.set("value", repr(new))
        for key in MOMENTS:
            moment = number(inertia.get(key), f'urdf, link "{name}", inertia, {key}')
            inertia.set(key, repr(moment * (new / old if old else 0.0)))
    for name, given in inertias.items():
        for key, value in zip(MOMENTS, _tensor(given, f"inertias: {name}")[np.triu_indices(3)].tolist()):
            links[name].find("inertial/inertia").set(key, repr(value))


#: The triangle inequality of principal moments holds to this share, the digits that descriptions are rounded to.
ROUNDED_TRIANGLE = 1e-2


def description_notices(robot: Element) -> tuple[Notice, ...]:
    """Notices on physically impossible or unused contents of a description; one for all links or joints of a kind."""
    notices = []
    if any(link.get("name") == RENAMED_GROUND for link in robot.findall("link")):
        text = f'the link "{GROUND}" is called "{RENAMED_GROUND}" here, since "{GROUND}" is what does not move'
        notices.append(Notice(NoticeKind.OVERRIDE, text))
    if robot.find("link/inertial") is None:
        text = "no link has an <inertial>: the robot has no mass, and no motion can be computed without springs or masses"
        notices.append(Notice(NoticeKind.OMITTED, text))
    joints = {joint.get("name"): joint for joint in robot.findall("joint")}
    lost = [
        f'"{short(name)}" (of "{short(joint.find("mimic").get("joint", ""))}")'
        for name, joint in joints.items()
        if joint.find("mimic") is not None and joint.find("mimic").get("joint", "") not in joints
    ]
    if lost:
        notices.append(
            Notice(NoticeKind.OMITTED, f"mimic joints of which the leader does not exist move by themselves: {listed(lost)}")
        )
    return (*notices, *_inertia_notices(robot))


def _inertia_notices(robot: Element) -> list[Notice]:
    """Notices on impossible inertias: rounded zeros and violated triangle inequalities are noted, negative moments doubted."""
    principal = {}
    for link in robot.findall("link"):
        if (inertia := link.find("inertial/inertia")) is not None:
            principal[link.get("name")] = np.linalg.eigvalsh(_symmetric([number(inertia.get(key), key) for key in MOMENTS]))
    largest = max((values[-1] for values in principal.values()), default=0.0)
    smallest = 1e-3 * ROUNDED * largest
    rounded, slight, negative, broken = [], [], [], []
    for name, values in principal.items():
        shown = f'"{short(name)}" ({", ".join(f"{value:.3g}" for value in values)} kg m^2)'
        if values[0] < 0:
            is_rounded = values[0] >= -max(ROUNDED * abs(values[-1]), smallest)
            (rounded if is_rounded else slight if values[0] >= -ROUNDED * largest else negative).append(shown)
        elif values[2] > max((1 + ROUNDED_TRIANGLE) * (values[0] + values[1]), smallest):
            broken.append(shown)
    texts = [
        ("moments of inertia that are rounded zeros below zero", rounded, False),
        ("principal moments of inertia of which one is negative, which no body has, too small to matter here", slight, False),
        ("principal moments of inertia of which one is negative, which no body has", negative, True),
        ("principal moments of inertia of which one exceeds the sum of the others, which no body has", broken, False),
    ]
    return [Notice(NoticeKind.ACCURACY, f"{text}: {listed(links)}", doubtful) for text, links, doubtful in texts if links]
