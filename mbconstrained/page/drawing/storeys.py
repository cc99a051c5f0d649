"""A building: storeys one above the other that move sideways, with columns and braces between them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

from ...ground.coordinate_units import GROUND
from .bodies import DrawnBody, DrawnLink
from .joints import DrawnJoint
from .pieces import Piece

#: Extent of a slab, distance from slab to slab, and distance of the columns from the middle, drawing units.
SLAB, STOREY, COLUMN = (3.6, 1.8, 0.24), 1.3, 1.5

#: Distance of a further connection from the one in front of it, drawing units.
BEHIND = 0.4

_NAME = re.compile(r"(ground |top |roof |\d+(st|nd|rd|th) )?(floor|storey|story|roof|slab)[ _-]?\d*", re.IGNORECASE)


def are_storeys(names: Sequence[str]) -> bool:
    """Whether these are names of storeys, two at least.

    >>> are_storeys(["floor 1", "floor_2", "roof"]), are_storeys(["floor 1", "cart"])
    (True, False)
    """
    return len(names) > 1 and all(_NAME.fullmatch(name) for name in names)


def storeys(order: Sequence[str], joints: Sequence[DrawnJoint]) -> Piece:
    """The piece of a building.

    A spring or rod is two columns, which lean as it is stretched, a damper is a brace.
    """
    levels = {GROUND: 0.0} | {name: STOREY * (number + 1) for number, name in enumerate(order)}
    base = DrawnBody("ground", "base", (0.0, 0.0, -SLAB[2] / 2), size=(SLAB[0] + 1.0, SLAB[1] + 0.6, 0.1))
    slabs = [DrawnBody(name, "box", (0.0, 0.0, levels[name]), {name: (1.0, 0.0, 0.0)}, size=SLAB) for name in order]
    links: list[DrawnLink] = []
    drawn: dict[tuple[str, str], int] = {}
    for joint in joints:
        if joint.ends <= levels.keys():
            low, high = sorted((joint.start, joint.end), key=lambda name: levels[name])
            number = drawn.get((low, high), 0)
            drawn[low, high] = number + 1
            links += _joined(joint, low, high, BEHIND * number, far=levels[high] - levels[low] > 1.5 * STOREY)
    return Piece((base, *slabs), tuple(links))


def columns(order: Sequence[str]) -> list[DrawnJoint]:
    """Connections from each storey to the next one, where only the coordinates of the storeys are known."""
    return [DrawnJoint(f"columns of {high}", "rod", low, high, None) for low, high in pairwise((GROUND, *order))]


def _joined(joint: DrawnJoint, low: str, high: str, back: float, *, far: bool) -> list[DrawnLink]:
    """A connection of two storeys, so much further back."""
    bottom, top = (0.05 if low == GROUND else SLAB[2] / 2), -SLAB[2] / 2
    kind = "rod" if joint.kind in ("spring", "rod") and not far else joint.kind
    lines = [(-COLUMN, -COLUMN), (COLUMN, COLUMN)] if kind == "rod" else [(-0.7 * COLUMN, 0.7 * COLUMN)]
    return [
        DrawnLink(
            joint.name if side == 0 else f"{joint.name}, right",
            kind,
            "ground" if low == GROUND else low,
            high,
            start_point=(left, back, bottom),
            end_point=(right, back, top),
        )
        for side, (left, right) in enumerate(lines)
    ]
