"""Angles of a URDF that are right angles but for their few digits: loops that are closed by exact ones stay open by them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING
from xml.etree import ElementTree

if TYPE_CHECKING:
    from .robot import Robot

#: So many digits behind the point show that a multiple of pi/4 is meant, and still leave loops open.
FEWEST, MOST = 2, 9

#: Of more angles only the number is told.
MOST_TOLD = 3


def rounded_to(text: str) -> int | None:
    """The n with n pi/4 = this number but for the rounding of its digits, or None.

    >>> rounded_to("1.57"), rounded_to("-3.1416"), rounded_to("0.79"), rounded_to("1.5"), rounded_to("1.5707963267948966")
    (2, -4, 1, None, None)
    """
    digits = len(text.strip().partition(".")[2])
    n = round(float(text) / (math.pi / 4))
    meant = n and FEWEST <= digits <= MOST and abs(float(text) - n * math.pi / 4) < 10.0**-digits
    return n if meant else None


def rounded_advice(robot: Robot) -> str:
    """Which angles of the robot are rounded and what to do, or an empty string.

    Looked at are the places of joints in the URDF and the directions of the frames of loops.
    """
    found = [*_of_joints(robot.description), *_of_loops(robot)]
    if not found:
        return ""
    more = f" and {len(found) - MOST_TOLD} more" if len(found) > MOST_TOLD else ""
    one = len(found) == 1
    told = f"{', '.join(found[:MOST_TOLD])}{more} {'is' if one else 'are'} rounded"
    return f"{told}, which tilts axes that may be meant to be parallel: write {'it' if one else 'them'} with all digits (pi/2 is {math.pi / 2!r})"


def _of_joints(description: ElementTree.Element) -> Iterator[str]:
    for joint in description.findall("joint"):
        origin = joint.find("origin")
        texts = [] if origin is None else origin.get("rpy", "").split()
        if worst := next(filter(rounded_to, texts), None):
            yield f'the rpy {worst} of joint "{joint.get("name")}"'


def _of_loops(robot: Robot) -> Iterator[str]:
    for loop in robot.loops:
        for key in ("rotation1", "rotation2"):
            if worst := next(filter(rounded_to, map(repr, getattr(loop, key))), None):
                yield f"the {key} {worst} of {loop.label}"
