"""Bodies along one axis: a chain from left to right, springs and dampers between them, walls where it is tied.

A long chain is folded into rows. Each row ends with a mark that moves as the first body of the next one, so that what is
between them is seen as it is.
"""

from __future__ import annotations

import math
from itertools import pairwise

from ...models.elements import GROUND
from ..drawing import Body, Link
from .joints import Joint
from .piece import Piece

GAP = 1.5  # between bodies that can move to each other, in drawing units; a mass is 0.8 wide
CLOSE = 0.8  # between bodies that a rod joins
LANE = 0.36  # between links side by side
BOX, BALL, WALL = 0.8, 0.24, 0.2
LONGEST = 40.0  # a row
ROOM = 1.3  # between the rows
SHAPE = 2.1  # how much wider than high the rows together are, about as the picture


class Chain:
    """The layout of bodies in a given order.

    Links between neighbours lie side by side. Others run above the bodies between, on posts. Ties to the ground go to
    a wall at either end of the chain; those of bodies in between, to blocks under the chain.
    """

    def __init__(self, order: list[str], massless: frozenset[str], joints: list[Joint], *, wall: bool = True):
        self.order = order
        self.massless = massless
        self.number = {name: i for i, name in enumerate(order)}
        self.joints = [joint for joint in joints if joint.ends <= {GROUND, *order}]
        self.joints_by_ends: dict[frozenset[str], list[Joint]] = {}
        for joint in self.joints:
            self.joints_by_ends.setdefault(joint.ends, []).append(joint)
        self.wall = wall  # whether the first body may be tied to a wall on its left
        self.links: list[Link] = []
        self.grounds: list[Body] = []

    def piece(self) -> Piece:
        """Bodies with their left end, or wall, at x = 0 and their middles at z = 0."""
        self.top = max(self._height(name) for name in self.order) / 2
        self.places = self._places()
        self.levels = dict.fromkeys(self.order, 0.0)
        self.marks: dict[str, Body] = {}
        self._fold()
        for one, other in pairwise(self.order):
            self._side_by_side(self._between(one, other), instead=other)
        self._above()
        for name in self.order:
            self._walls(name)
            self._block(name)
        bodies = [self._body(name) for name in self.order]
        return Piece((*self.grounds, *bodies, *self.marks.values()), tuple(self.links))

    def _fold(self) -> None:
        """Put what is too long for one row into several, unless a link would have to cross from row to row."""
        length = self.places[self.order[-1]]
        low, high = zip(*map(self._span, self.joints)) if self.joints else ((0,), (0,))
        inner = [joint for i in range(1, len(self.order) - 1) for joint in self._between(self.order[i], GROUND)]
        if length <= LONGEST or max(b - a for a, b in zip(low, high)) > 1 or inner:
            return
        pitch = 2 * self.top + ROOM
        wide = length / math.ceil(math.sqrt(length / (SHAPE * pitch)))
        shift, row = 0.0, 0
        for one, other in pairwise(self.order):
            if self.places[other] - shift > wide:
                row += 1
                self.marks[other] = self._mark(other, (self.places[other] - shift, 0.0, self.levels[one]))
                shift = self.places[other] - self._width(other) / 2
            self.places[other] -= shift
            self.levels[other] = -pitch * row

    def _mark(self, name: str, place) -> Body:
        size = (BALL, BALL, BALL)
        return Body(f"{name}, also below", "mark", place, {name: (1.0, 0.0, 0.0)}, size=size, label=name)

    def _between(self, one: str, other: str) -> list[Joint]:
        return self.joints_by_ends.get(frozenset((one, other)), [])

    def _tied(self, name: str, side: str) -> list[Joint]:
        """The ties of a body to the ground on one side: "left" or "right" of it, or "below"."""
        return [joint for joint in self._between(name, GROUND) if self._side(name, joint) == side]

    def _side(self, name: str, joint: Joint) -> str:
        first, last = name == self.order[0], name == self.order[-1]
        if last and (not first or joint.start == name or not self.wall):
            return "right"
        return "left" if first and self.wall else "below"

    def _height(self, name: str) -> float:
        """High enough for the links on its busier side."""
        if name in self.massless:
            return BALL
        i = self.number[name]
        sides = [self._between(name, other) for other in self.order[max(i - 1, 0) : i + 2] if other != name]
        count = max(map(len, [*sides, self._tied(name, "left"), self._tied(name, "right")]), default=0)
        return max(BOX, LANE * count + 0.12)

    def _width(self, name: str) -> float:
        return BALL if name in self.massless else BOX

    def _places(self) -> dict[str, float]:
        places, edge = {}, 0.0
        if self._tied(self.order[0], "left"):
            edge = WALL + GAP
        for name, following in zip(self.order, [*self.order[1:], None]):
            places[name] = edge + self._width(name) / 2
            kinds = {joint.kind for joint in self._between(name, following)} if following else set()
            edge += self._width(name) + (CLOSE if kinds == {"rod"} else GAP)
        return places

    def _body(self, name: str) -> Body:
        shape, width = ("sphere", BALL) if name in self.massless else ("box", BOX)
        size = (width, width, self._height(name))
        return Body(name, shape, (self.places[name], 0.0, self.levels[name]), {name: (1.0, 0.0, 0.0)}, size=size)

    def _side_by_side(self, joints: list[Joint], ground: str = GROUND, instead: str = "") -> None:
        for i, joint in enumerate(joints):
            self._link(joint, ground, z=LANE * ((len(joints) - 1) / 2 - i), instead=instead)

    def _link(self, joint: Joint, ground: str = GROUND, *, z: float, ground_z: float | None = None, instead: str = "") -> None:
        """A link; to a wall for the ground, and to the mark that stands for a body in the row before its own."""
        others = {GROUND: ground, **({instead: self.marks[instead].name} if instead in self.marks else {})}
        ends = [others.get(name, name) for name in (joint.start, joint.end)]
        heights = [z if name != ground or ground_z is None else ground_z for name in ends]
        self.links.append(Link(joint.name, joint.kind, *ends, *((0.0, 0.0, height) for height in heights)))

    def _above(self) -> None:
        """Links past other bodies, each in the lowest lane that is free along its way."""
        lanes: list[list[tuple[int, int]]] = []
        for joint in self.joints:
            low, high = self._span(joint)
            if high - low < 2:
                continue
            free = (i for i, lane in enumerate(lanes) if all(high <= begin or end <= low for begin, end in lane))
            number = next(free, len(lanes))
            lanes += [[]] if number == len(lanes) else []
            lanes[number].append((low, high))
            self._link(joint, z=self.top + LANE * (number + 1))

    def _span(self, joint: Joint) -> tuple[int, int]:
        """Places in the order of its first and last body; of a tie to the ground both are the same."""
        places = [self.number[name] for name in joint.ends if name != GROUND]
        return min(places), max(places)

    def _walls(self, name: str) -> None:
        """Walls beside a body, as far as it is tied to them."""
        for side, sign in (("left", -1), ("right", 1)):
            joints = self._tied(name, side)
            if joints:
                x = self.places[name] + sign * ((self._width(name) + WALL) / 2 + GAP)
                height = max(2 * self.top + 0.6, LANE * len(joints) + 0.7)
                wall = self._ground(f"ground {side} of {name}", (x, 0.0, self.levels[name]), (WALL, 1.2, height))
                self._side_by_side(joints, wall)

    def _block(self, name: str) -> None:
        """A block to the left under a body, as far as it is tied to one."""
        joints = self._tied(name, "below")
        if not joints:
            return
        depths = [-self.top - LANE * (i + 1) for i in range(len(joints))]
        middle = (depths[0] + depths[-1]) / 2
        place = (self.places[name] - self._width(name) / 2 - 1.0, 0.0, middle)
        block = self._ground(f"ground below {name}", place, (0.16, 0.5, depths[0] - depths[-1] + 0.44))
        for joint, depth in zip(joints, depths):
            self._link(joint, block, z=depth, ground_z=depth - middle)

    def _ground(self, name: str, rest, size) -> str:
        self.grounds.append(Body(name, "ground", rest, size=size))
        return name
