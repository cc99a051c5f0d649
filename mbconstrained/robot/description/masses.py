"""Masses of links: payloads, masses and inertias in place of those of the URDF, and notices on physically impossible ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from ...ground.checks import nearest, real_array, real_number
from ...ground.coordinate_units import GROUND
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import noise_of
from .urdf import MOMENTS, RENAMED_GROUND, ROUNDED, moments, number, short


@dataclass(frozen=True)
class Payload:
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
    tensor = np.diag(values) if len(values) == 3 else np.zeros((3, 3))
    if len(values) == 6:
        tensor[np.triu_indices(3)] = values
        tensor = tensor + np.triu(tensor, 1).T
    if (least := np.linalg.eigvalsh(tensor)[0]) < -noise_of(np.abs(tensor).max(), 3):
        raise InputError(f"{where}: the moment of inertia about some axis is {least:.3g} kg m^2; expected 0 or more")
    return tensor


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

#: Number of links named in a notice; the others are counted.
MOST_NAMED_LINKS = 3


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
            Notice(NoticeKind.OMITTED, f"mimic joints of which the leader does not exist move by themselves: {_first(lost)}")
        )
    return (*notices, *_inertia_notices(robot))


def _inertia_notices(robot: Element) -> list[Notice]:
    """Notices on impossible inertias: rounded zeros and violated triangle inequalities are noted, negative moments doubted."""
    principal = {}
    for link in robot.findall("link"):
        if (inertia := link.find("inertial/inertia")) is not None:
            tensor = np.zeros((3, 3))
            tensor[np.triu_indices(3)] = list(moments(inertia, "").values())
            principal[link.get("name")] = np.linalg.eigvalsh(tensor + np.triu(tensor, 1).T)
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
    return [Notice(NoticeKind.ACCURACY, f"{text}: {_first(links)}", doubtful) for text, links, doubtful in texts if links]


def _first(names: list[str]) -> str:
    more = f" and {len(names) - MOST_NAMED_LINKS} more" if len(names) > MOST_NAMED_LINKS else ""
    return ", ".join(names[:MOST_NAMED_LINKS]) + more
