"""What pinocchio is given of a URDF: masses and joints, every number looked at before.

The parser behind pinocchio drops an inertia that it cannot read and goes on with a massless link; here that is an error.
Shapes are left out: collision geometry is never read, and visuals only where they are drawn.
"""

from __future__ import annotations

from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...errors import InputError
from .urdf_numbers import number, numbers, short

_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")

#: A moment of inertia about some axis may be negative by so much of the largest: rounding of the data.
ROUNDED = 1e-6

_UNLIMITED = ("continuous", "fixed", "floating", "planar")


def skeleton(robot: Element) -> str:
    """The XML text of a robot with masses and joints alone.

    Raises:
        InputError: numbers that are none, masses or inertias without sense, axes without a direction.
    """
    found = Element("robot", name=str(robot.get("name") or "robot"))
    for link in robot.findall("link"):
        copy = SubElement(found, "link", name=link.get("name"))
        if (inertial := link.find("inertial")) is not None:
            _copy_inertial(copy, inertial, f'urdf, link "{short(link.get("name"))}"')
    for joint in robot.findall("joint"):
        _copy_joint(found, joint, f'urdf, joint "{short(joint.get("name"))}"')
    return ElementTree.tostring(found, encoding="unicode")


def link_masses(robot: Element) -> dict[str, float]:
    """Masses by link (kg), of those that have one."""
    found = {link.get("name"): link.find("inertial/mass") for link in robot.findall("link")}
    return {name: number(mass.get("value"), "mass") for name, mass in found.items() if mass is not None}


def _copy_inertial(link: Element, inertial: Element, where: str) -> None:
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        missing = "mass" if mass is None else "inertia"
        raise InputError(f"{where}, inertial: found no <{missing}>; give it, with zeros where there is none")
    copy = SubElement(link, "inertial")
    _copy_origin(copy, inertial, where)
    SubElement(copy, "mass", value=_text([number(mass.get("value"), f"{where}, mass", minimum=0.0)]))
    moments = {key: number(inertia.get(key), f"{where}, inertia, {key}") for key in _MOMENTS}
    _check_moments(moments, where)
    SubElement(copy, "inertia", {key: _text([value]) for key, value in moments.items()})


def _check_moments(moments: dict[str, float], where: str) -> None:
    tensor = np.zeros((3, 3))
    tensor[np.triu_indices(3)] = list(moments.values())
    least, *_, largest = np.linalg.eigvalsh(tensor + np.triu(tensor, 1).T)
    if least < -ROUNDED * abs(largest):
        raise InputError(f"{where}, inertia: the moment of inertia about some axis is {least:.3g} kg m^2; expected 0 or more")


def _copy_joint(robot: Element, joint: Element, where: str) -> None:
    kind = joint.get("type")
    copy = SubElement(robot, "joint", name=joint.get("name"), type=kind)
    for tag in ("parent", "child"):
        SubElement(copy, tag, link=joint.find(tag).get("link"))
    _copy_origin(copy, joint, where)
    if kind not in ("fixed", "floating"):
        SubElement(copy, "axis", xyz=_text(_axis(joint, where)))
    if kind not in _UNLIMITED:
        SubElement(copy, "limit", {key: _text([value]) for key, value in _limits(joint, where).items()})
    if (dynamics := joint.find("dynamics")) is not None:
        values = {key: number(dynamics.get(key, "0"), f"{where}, {key}", minimum=0.0) for key in ("damping", "friction")}
        SubElement(copy, "dynamics", {key: _text([value]) for key, value in values.items()})


def _copy_origin(parent: Element, element: Element, where: str) -> None:
    if (origin := element.find("origin")) is not None:
        SubElement(
            parent, "origin", {key: _text(numbers(origin.get(key, "0 0 0"), 3, f"{where}, {key}")) for key in ("xyz", "rpy")}
        )


def _axis(joint: Element, where: str) -> list[float]:
    """The axis, x where none is given."""
    axis = joint.find("axis")
    found = numbers("1 0 0" if axis is None else axis.get("xyz", ""), 3, f"{where}, axis")
    if not any(found):
        raise InputError(f"{where}, axis: found 0 0 0; expected a direction")
    if joint.get("type") == "planar" and (any(found[:2]) or found[2] < 0):  # pinocchio does not look at it
        raise InputError(f'{where}, axis: found {_text(found)}; expected "0 0 1" of a planar joint: turn its origin instead')
    return found


def _limits(joint: Element, where: str) -> dict[str, float]:
    """Limits; those that are left out are 0, and a joint whose limits both are 0 has none."""
    limit = joint.find("limit")
    keys = ("lower", "upper", "effort", "velocity")
    found = {key: number("0" if limit is None else limit.get(key, "0"), f"{where}, limit, {key}") for key in keys}
    low, high = found["lower"], found["upper"]
    if low > high or low == high != 0:
        raise InputError(f"{where}, limit: found lower {low:g} and upper {high:g}; expected lower below upper, or lock the joint")
    return found


def _text(values: list[float]) -> str:
    return " ".join(map(repr, values))
