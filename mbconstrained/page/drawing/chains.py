"""Bodies along one axis: a chain from left to right with springs and dampers between them and walls at its ends; or storeys of a building.

A long chain is folded into rows. Each row ends with a mark that moves with the first body of the next one, so that the link
between them is drawn to scale.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from itertools import pairwise

from ...ground.coordinate_units import GROUND
from .bodies import DrawnBody, DrawnLink, Shape
from .layout import DrawnJoint, Piece

#: Gaps between bodies with relative motion, and between bodies joined by a rod, drawing units.
GAP, CLOSE = 1.5, 0.8

#: Distance between parallel links, drawing units.
LANE = 0.36

#: Widths of a mass, a massless joint and a wall, drawing units.
BOX, BALL, WALL = 0.8, 0.24, 0.2

#: Longest row, and gap between rows, drawing units.
LONGEST, ROW_GAP = 40.0, 1.3

#: Width of all rows relative to their height, about as of the picture.
ASPECT = 2.1


class Chain:
    """The layout of bodies in a given order.

    Links between neighbours are parallel. Others run above the bodies between, on posts. Links to the ground end at a wall
    at either end of the chain; those of bodies in between, at blocks under the chain.
    """

    def __init__(self, order: list[str], massless: frozenset[str], joints: list[DrawnJoint], *, wall: bool = True):
        self.order = order
        self.massless = massless
        self.number = {name: i for i, name in enumerate(order)}
        self.joints = [joint for joint in joints if joint.ends <= {GROUND, *order}]
        self.joints_by_ends: dict[frozenset[str], list[DrawnJoint]] = {}
        for joint in self.joints:
            self.joints_by_ends.setdefault(joint.ends, []).append(joint)
        self.wall = wall  # whether the first body may have a wall on its left
        self.width = {name: BALL if name in massless else BOX for name in order}
        self.links: list[DrawnLink] = []
        self.grounds: list[DrawnBody] = []

    def piece(self) -> Piece:
        """Bodies with their left end, or wall, at x = 0 and their middles at z = 0."""
        self.top = max(self._height(name) for name in self.order) / 2
        self.places = self._places()
        self.levels = dict.fromkeys(self.order, 0.0)
        self.marks: dict[str, DrawnBody] = {}  # by the name of a body, which stands for it in the row before its own
        self._fold()
        for one, other in pairwise(self.order):
            self._side_by_side(self._between(one, other), {other: self.marks[other].name} if other in self.marks else {})
        self._above()
        bodies = []
        for name in self.order:
            self._walls(name)
            self._block(name)
            shape: Shape = "sphere" if name in self.massless else "box"
            size = (self.width[name], self.width[name], self._height(name))
            place = (self.places[name], 0.0, self.levels[name])
            bodies.append(DrawnBody(name, shape, place, {name: (1.0, 0.0, 0.0)}, size=size))
        return Piece((*self.grounds, *bodies, *self.marks.values()), tuple(self.links))

    def _fold(self) -> None:
        """Fold a long chain into rows, unless a link would cross from row to row."""
        length = self.places[self.order[-1]]
        low, high = zip(*map(self._span, self.joints)) if self.joints else ((0,), (0,))
        inner = [joint for i in range(1, len(self.order) - 1) for joint in self._between(self.order[i], GROUND)]
        if length <= LONGEST or max(b - a for a, b in zip(low, high)) > 1 or inner:
            return
        pitch = 2 * self.top + ROW_GAP
        wide = length / math.ceil(math.sqrt(length / (ASPECT * pitch)))
        shift, row = 0.0, 0
        for one, other in pairwise(self.order):
            if self.places[other] - shift > wide:
                row += 1
                place, moves = (self.places[other] - shift, 0.0, self.levels[one]), {other: (1.0, 0.0, 0.0)}
                self.marks[other] = DrawnBody(f"{other}, also below", "mark", place, moves, size=(BALL, BALL, BALL), label=other)
                shift = self.places[other] - self.width[other] / 2
            self.places[other] -= shift
            self.levels[other] = -pitch * row

    def _between(self, one: str, other: str) -> list[DrawnJoint]:
        return self.joints_by_ends.get(frozenset((one, other)), [])

    def _tied(self, name: str, side: str) -> list[DrawnJoint]:
        """The links of a body to the ground on one side: "left" or "right" of it, or "below"."""
        return [joint for joint in self._between(name, GROUND) if self._side(name, joint) == side]

    def _side(self, name: str, joint: DrawnJoint) -> str:
        first, last = name == self.order[0], name == self.order[-1]
        if last and (not first or joint.start == name or not self.wall):
            return "right"
        return "left" if first and self.wall else "below"

    def _height(self, name: str) -> float:
        """Height sufficient for the links on the side with most of them."""
        if name in self.massless:
            return BALL
        i = self.number[name]
        sides = [self._between(name, other) for other in self.order[max(i - 1, 0) : i + 2] if other != name]
        count = max(map(len, [*sides, self._tied(name, "left"), self._tied(name, "right")]), default=0)
        return max(BOX, LANE * count + 0.12)

    def _places(self) -> dict[str, float]:
        places, edge = {}, 0.0
        if self._tied(self.order[0], "left"):
            edge = WALL + GAP
        for name, following in zip(self.order, [*self.order[1:], None]):
            places[name] = edge + self.width[name] / 2
            kinds = {joint.kind for joint in self._between(name, following)} if following else set()
            edge += self.width[name] + (CLOSE if kinds == {"rod"} else GAP)
        return places

    def _side_by_side(self, joints: list[DrawnJoint], others: Mapping[str, str]) -> None:
        for i, joint in enumerate(joints):
            z = LANE * ((len(joints) - 1) / 2 - i)
            self._link(joint, others, z, z)

    def _link(self, joint: DrawnJoint, others: Mapping[str, str], z: float, ground_z: float) -> None:
        """A link at a height; its ends are at other bodies where these stand for the ground or for a body of another row."""
        ends = [others.get(name, name) for name in (joint.start, joint.end)]
        offsets = [(0.0, 0.0, ground_z if name == GROUND else z) for name in (joint.start, joint.end)]
        self.links.append(DrawnLink(joint.name, joint.kind, *ends, *offsets))

    def _above(self) -> None:
        """Links past other bodies, each in the lowest lane that is free along its length."""
        lanes: list[list[tuple[int, int]]] = []
        for joint in self.joints:
            low, high = self._span(joint)
            if high - low < 2:
                continue
            free = (i for i, lane in enumerate(lanes) if all(high <= begin or end <= low for begin, end in lane))
            number = next(free, len(lanes))
            lanes += [[]] if number == len(lanes) else []
            lanes[number].append((low, high))
            self._link(joint, {}, self.top + LANE * (number + 1), 0.0)

    def _span(self, joint: DrawnJoint) -> tuple[int, int]:
        """Numbers of its first and last body; equal for a link to the ground."""
        places = [self.number[name] for name in joint.ends if name != GROUND]
        return min(places), max(places)

    def _walls(self, name: str) -> None:
        """Walls at the sides of a body with links to the ground."""
        for side, sign in (("left", -1), ("right", 1)):
            joints = self._tied(name, side)
            if joints:
                x = self.places[name] + sign * ((self.width[name] + WALL) / 2 + GAP)
                height = max(2 * self.top + 0.6, LANE * len(joints) + 0.7)
                place = (x, 0.0, self.levels[name])
                self.grounds.append(DrawnBody(f"ground {side} of {name}", "ground", place, size=(WALL, 1.2, height)))
                self._side_by_side(joints, {GROUND: self.grounds[-1].name})

    def _block(self, name: str) -> None:
        """A block to the left under a body with links to the ground below."""
        joints = self._tied(name, "below")
        if not joints:
            return
        depths = [-self.top - LANE * (i + 1) for i in range(len(joints))]
        middle = (depths[0] + depths[-1]) / 2
        place = (self.places[name] - self.width[name] / 2 - 1.0, 0.0, middle)
        size = (0.16, 0.5, depths[0] - depths[-1] + 0.44)
        self.grounds.append(DrawnBody(f"ground below {name}", "ground", place, size=size))
        for joint, depth in zip(joints, depths):
            self._link(joint, {GROUND: self.grounds[-1].name}, depth, depth - middle)


# A building: storeys one above the other that move sideways, with columns and braces between them.


#: Extent of a slab, distance from slab to slab, and distance of the columns from the middle, drawing units.
SLAB, STOREY, COLUMN = (3.6, 1.8, 0.24), 1.3, 1.5

#: Distance of a further connection from the one in front of it, drawing units.
BEHIND = 0.4

_NAME = re.compile(r"(ground |top |roof |\d+(st|nd|rd|th) )?(floor|storey|story|roof|slab)[ _-]?\d*", re.IGNORECASE)


def are_storeys(names: Sequence[str]) -> bool:
    """Whether these are names of storeys, at least two.

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
    """A connection of two storeys, displaced backwards."""
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
