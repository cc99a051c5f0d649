"""MJCF files, which pinocchio reads: its equality constraints as loops and gears, its springs, gravity and key frames.

Pinocchio reads bodies, joints, masses and ``connect`` and ``weld``; joint springs, couplings of joints and gravity come from the XML.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from ...ground.coordinate_units import GROUND
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ..connections import Loop, LoopKind
from ..tangent import JointGear
from .models import ModelFile
from .urdf import numbers, read_urdf, short, xml_element

#: Files that include others, at most so deep.
DEEPEST_INCLUDE = 5

_POLYNOMIAL = 5  # coefficients of the coupling of two joints


def is_mjcf(source) -> bool:
    """Whether this is the path of an MJCF file."""
    if not isinstance(source, (str, Path)) or Path(str(source)[:4096]).suffix.lower() not in (".xml", ".mjcf"):
        return False
    return re.search(r"<mujoco\b", read_urdf(source, "MJCF")[0]) is not None


def read_mjcf(path: str | Path, free_base: bool) -> ModelFile:
    """The content of an MJCF file.

    Args:
        path: of the file.
        free_base: whether a base without a free joint gets one.

    Returns:
        Model, loops, gears, springs of joints, gravity and key frames.

    Raises:
        InputError: pinocchio cannot read it, or reads only a part; files outside of its folder.
    """
    import pinocchio

    path = Path(path)
    root = _expanded(path, path.parent.resolve(), 0)
    if len(bodies := root.findall("worldbody/body")) > 1:
        names = ", ".join(f'"{short(body.get("name"))}"' for body in bodies)
        raise InputError(f"mjcf: <worldbody> has {len(bodies)} bodies ({names}), of which one is read: put them into one <body>")
    floating = bool(bodies) and (bodies[0].find("freejoint") is not None or bodies[0].find("joint[@type='free']") is not None)
    joint = (pinocchio.JointModelFreeFlyer(),) if free_base and not floating else ()
    try:
        model, points, frames = pinocchio.buildModelAndConstraintsFromMJCF(str(path), *joint)
    except (ValueError, RuntimeError, IndexError) as problem:
        reason = (str(problem).splitlines() or ["unknown"])[0][:200]
        advice = (
            "; key frames do not fit a base with a joint that the file does not have"
            if joint and root.find("keyframe") is not None
            else ""
        )
        raise InputError(f"mjcf: pinocchio cannot read {path.name} as a robot ({reason}){advice}") from None
    loops = [*(_loop(model, item, "point") for item in points), *(_loop(model, item, "rigid") for item in frames)]
    springs = dict(_springs(root, {str(name) for name in model.names}))
    gravity = root.find("option[@gravity]")
    return ModelFile(
        model=model,
        path=path,
        gravity=numbers("0 0 -9.81" if gravity is None else gravity.get("gravity"), 3, "mjcf, option, gravity"),
        loops=tuple(loops),
        gears=tuple(_gears(root)),
        joint_stiffness={name: stiffness for name, (stiffness, _) in springs.items()},
        joint_rest={name: rest for name, (_, rest) in springs.items()},
        states={entry.key(): np.array(entry.data()) for entry in model.referenceConfigurations},
        notices=tuple(_left_out(root)),
    )


def _expanded(path: Path, folder: Path, depth: int) -> Element:
    """The root element with the content of included files, all names of files checked to lie in the folder."""
    text, _ = read_urdf(path, "MJCF")
    root = xml_element(text, "mjcf")
    compiler = root.find("compiler")
    directories = ["", *([] if compiler is None else [compiler.get(key, "") for key in ("meshdir", "assetdir", "texturedir")])]
    for element in root.iterfind(".//*[@file]"):
        places = [(folder / directory / element.get("file", "")).resolve() for directory in directories]
        if not all(place.is_relative_to(folder) for place in places):
            raise InputError(
                f"mjcf: the file {short(element.get('file'))!a} of <{element.tag}> lies outside of the folder of the MJCF"
            )
    for parent in list(root.iter()):
        for child in parent.findall("include"):
            if depth >= DEEPEST_INCLUDE:
                raise InputError(f"mjcf: files include each other more than {DEEPEST_INCLUDE} deep")
            parent.extend(_expanded(folder / child.get("file", ""), folder, depth + 1))
            parent.remove(child)
    return root


def _loop(model, constraint, kind: LoopKind) -> Loop:
    """A loop of the frames of a constraint, each in a link of its joint."""
    ends = []
    for joint, placement in (
        (constraint.joint1_id, constraint.joint1_placement),
        (constraint.joint2_id, constraint.joint2_placement),
    ):
        frame = next((frame for frame in model.frames if "BODY" in str(frame.type) and frame.parentJoint == joint), None)
        own = placement if frame is None or not joint else frame.placement.inverse() * placement
        ends.append((GROUND if frame is None or not joint else str(frame.name), own))
    (body1, first), (body2, second) = ends
    return Loop(
        body1,
        first.translation.tolist(),
        body2,
        second.translation.tolist(),
        kind=kind,
        rotation1=_angles(first),
        rotation2=_angles(second),
        name=str(constraint.name) or None,
    )


def _angles(placement) -> list[float]:
    import pinocchio

    return pinocchio.rpy.matrixToRpy(placement.rotation).tolist()


def _gears(root: Element) -> Iterator[JointGear]:
    """Joints that follow others linearly."""
    for element in _joint_equalities(root):
        offset, ratio, *higher = _polynomial(element)
        if element.get("joint2") and not any(higher):
            yield JointGear(element.get("joint1", ""), element.get("joint2", ""), ratio, offset)


def _joint_equalities(root: Element) -> Iterator[Element]:
    return (element for element in root.iterfind("equality/joint") if element.get("active", "true") != "false")


def _polynomial(element: Element) -> list[float]:
    text = element.get("polycoef", "0 1")
    given = numbers(text, len(text.split()), "mjcf, equality, polycoef")
    return [*given, *np.zeros(_POLYNOMIAL - len(given)).tolist()] if len(given) < _POLYNOMIAL else given


def _springs(root: Element, joints: set[str]) -> Iterator[tuple[str, tuple[float, float]]]:
    """Stiffness and rest (rad, m) by joint, of those that have a stiffness, the classes of defaults looked up."""
    defaults: dict[str, Mapping[str, str]] = {}
    for default in root.findall("default"):
        _collect(default, {}, defaults)
    compiler = root.find("compiler")
    unit = 1.0 if compiler is not None and compiler.get("angle") == "radian" else math.pi / 180
    for joint, child_class in _joints(root.findall("worldbody"), "main"):
        values = {**defaults.get(joint.get("class", child_class), {}), **joint.attrib}
        where = f'mjcf, joint "{short(joint.get("name"))}"'
        (stiffness,) = numbers(values.get("stiffness", "0"), 1, f"{where}, stiffness")
        if stiffness and joint.get("name") in joints:
            (rest,) = numbers(values.get("springref", "0"), 1, f"{where}, springref")
            yield str(joint.get("name")), (stiffness, rest * (1.0 if values.get("type") == "slide" else unit))


def _collect(default: Element, inherited: Mapping[str, str], into: dict[str, Mapping[str, str]]) -> None:
    """The attributes of joints by class of defaults."""
    own = default.find("joint")
    values = {**inherited, **({} if own is None else own.attrib)}
    into[default.get("class", "main")] = values
    for nested in default.findall("default"):
        _collect(nested, values, into)


def _joints(bodies: list[Element], child_class: str) -> Iterator[tuple[Element, str]]:
    """All joints with the class of their bodies."""
    for body in bodies:
        own = body.get("childclass", child_class)
        yield from ((joint, own) for joint in body.findall("joint"))
        yield from _joints(body.findall("body"), own)


def _left_out(root: Element) -> Iterator[Notice]:
    """Notices on what acts on the motion in MuJoCo and is not read."""
    nonlinear = [
        element.get("joint1", "")
        for element in _joint_equalities(root)
        if any(_polynomial(element)[2:]) or not element.get("joint2")
    ]
    kinds = [child.tag for child in root.iterfind("equality/*") if child.tag not in ("connect", "weld", "joint")]
    parts = [f"the coupling of joint {short(name)}" for name in nonlinear]
    parts += [f"<equality> {kind}" for kind in dict.fromkeys(kinds)]
    parts += [f"<{tag}>" for tag in ("tendon", "actuator") if root.find(f"{tag}/*") is not None]
    if parts:
        text = f"{', '.join(parts)} of the MJCF: not read; where it acts on the motion, give loops, springs, gears or motors"
        yield Notice(NoticeKind.OMITTED, text, doubtful=bool(nonlinear or kinds))
