"""URDF texts: looked through before pinocchio sees them, so that what is wrong is told in plain words.

A URDF is data: nothing in it is run or fetched. Mesh files are not opened here (``visuals``).
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from ...checks import nearest
from ...errors import InputError
from ..element import GROUND
from .urdf_numbers import number, short

LARGEST_URDF = 5_000_000  # bytes; the URDF of a humanoid has a few hundred thousand
MOST_LINKS = 2_000

_JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")


def read_urdf(source: str | Path) -> tuple[str, Path | None]:
    """The XML text, and the folder of the file if it was one.

    Raises:
        InputError: no such file, too large, not text.
    """
    if isinstance(source, str) and "<" in source:
        return source, None
    if not isinstance(source, (str, Path)):
        raise InputError(f"urdf: found {type(source).__name__}; expected the path of a .urdf file, or its text")
    path = Path(source)
    try:
        if path.stat().st_size > LARGEST_URDF:
            raise InputError(f"{path.name}: the file has {path.stat().st_size:,} bytes; at most {LARGEST_URDF:,} are read")
        return path.read_text("utf-8-sig"), path.parent
    except FileNotFoundError:
        others = [other.name for other in path.parent.glob("*.urdf")] if path.parent.is_dir() else []
        raise InputError(f"{path}: there is no such URDF file{nearest(path.name, others)}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path.name}: not a text file in UTF-8") from None
    except InputError:
        raise
    except (OSError, ValueError) as problem:
        raise InputError(f"urdf: the file cannot be read ({getattr(problem, 'strerror', None) or problem})") from None


def checked_tree(text: str) -> ElementTree.Element:
    """The element <robot>, once names and kinds of joints are found to make sense; of numbers see ``skeleton``.

    Raises:
        InputError: not XML, entities, no robot, names used twice, unknown links, loops, kinds of joints that do not exist.
    """
    if re.search(r"<!(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise InputError("urdf: found a document type or an entity; a URDF has none, take it out")
    try:
        root = ElementTree.fromstring(text.encode(), ElementTree.XMLParser(encoding="utf-8"))  # whatever it declares
    except (ElementTree.ParseError, ValueError) as problem:
        raise InputError(f"urdf: not XML ({problem})") from None
    if root.tag != "robot":
        raise InputError(f"urdf: found <{short(root.tag)}>; expected <robot>")
    if not root.findall("link"):
        raise InputError("urdf: found no <link>; a robot needs at least one")
    if (count := len(root.findall("link"))) > MOST_LINKS:
        raise InputError(f"urdf: found {count:,} links; at most {MOST_LINKS:,} are read")
    links = _names(root, "link")
    if GROUND in links:
        raise InputError(f'urdf: a link is named "{GROUND}", which here is what does not move; choose another name')
    _names(root, "joint")
    children = [_check_joint(joint, set(links)) for joint in root.findall("joint")]
    _check_tree(children, links)
    return root


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: q_follower = multiplier q_leader + offset; a leader that is fixed stays at 0."""

    follower: str
    leader: str
    multiplier: float
    offset: float
    leader_is_fixed: bool = False


def mimics_of(root: ElementTree.Element) -> tuple[Mimic, ...]:
    """The joints that follow others.

    Raises:
        InputError: an unknown leader, or one that follows itself; numbers that are none.
    """
    joints, found = {joint.get("name"): joint for joint in root.findall("joint")}, []
    for name, joint in joints.items():
        if (mimic := joint.find("mimic")) is None or joint.get("type") == "fixed":
            continue
        where, leader = f'urdf, joint "{short(name)}", mimic', mimic.get("joint", "")
        if leader not in joints or joints[leader].find("mimic") is not None:
            raise InputError(f'{where}: found "{short(leader)}"{nearest(leader, joints)}; expected a joint that follows no other')
        kinds = joint.get("type"), joints[leader].get("type")
        if several := [kind for kind in kinds if kind in ("planar", "floating")]:
            raise InputError(f"{where}: found a {several[0]} joint; only joints with one degree of freedom can follow or lead")
        numbers = [number(mimic.get(key, usual), f"{where}, {key}") for key, usual in (("multiplier", "1"), ("offset", "0"))]
        found.append(Mimic(str(name), leader, *numbers, leader_is_fixed=kinds[1] == "fixed"))
    return tuple(found)


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


def _check_joint(joint, links: set[str]) -> tuple[str, str]:
    """Parent and child of a joint."""
    where = f'urdf, joint "{short(joint.get("name"))}"'
    if joint.get("type") not in _JOINT_TYPES:
        found = short(joint.get("type"))
        raise InputError(f'{where}: found the type "{found}"{nearest(found, _JOINT_TYPES)}; expected {", ".join(_JOINT_TYPES)}')
    ends = []
    for tag in ("parent", "child"):
        element = joint.find(tag)
        name = "" if element is None else element.get("link", "")
        if name not in links:
            raise InputError(f'{where}: its {tag} is "{short(name)}", which is no link{nearest(name, links)}')
        ends.append(name)
    return ends[0], ends[1]


def _check_tree(ends: list[tuple[str, str]], links: list[str]) -> None:
    """From one link, the base, all others are reached, each by one way."""
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
