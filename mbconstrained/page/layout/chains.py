"""Bodies along one axis: a chain from left to right, springs and dampers between them, walls where it is tied."""

from __future__ import annotations

from itertools import pairwise

from ...models.elements import GROUND
from ..drawing import Body, Link
from .joints import Joint
from .piece import Piece

GAP = 1.5  # between bodies that can move to each other, in drawing units; a mass is 0.8 wide
CLOSE = 0.8  # between bodies that a rod joins
LANE = 0.36  # between links side by side
BOX, BALL, WALL = 0.8, 0.24, 0.2


class Chain:
    """The layout of bodies in a given order.

    Links between neighbours lie side by side. Others run above the bodies between, on posts. Ties to the ground go to
    a wall at either end of the chain; those of bodies in between, to blocks under the chain.
    """

    def __init__(self, order: list[str], massless: frozenset[str], joints: list[Joint], *, wall: bool = True):
        self.order = order
        self.massless = massless
        self.joints = [joint for joint in joints if joint.ends <= {GROUND, *order}]
        self.wall = wall  # whether the first body may be tied to a wall on its left
        self.links: list[Link] = []
        self.grounds: list[Body] = []

    def piece(self) -> Piece:
        """Bodies with their left end, or wall, at x = 0 and their middles at z = 0."""
        self.top = max(self._height(name) for name in self.order) / 2
        self.places = self._places()
        for pair in pairwise(self.order):
            self._side_by_side(self._between(*pair))
        self._above()
        for name in self.order:
            self._walls(name)
            self._block(name)
        bodies = [self._body(name) for name in self.order]
        return Piece((*self.grounds, *bodies), tuple(self.links))

    def _between(self, one: str, other: str) -> list[Joint]:
        return [joint for joint in self.joints if joint.ends == {one, other}]

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
        i = self.order.index(name)
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
        return Body(name, shape, (self.places[name], 0.0, 0.0), {name: (1.0, 0.0, 0.0)}, size=size)

    def _side_by_side(self, joints: list[Joint], ground: str = GROUND) -> None:
        for i, joint in enumerate(joints):
            self._link(joint, ground, z=LANE * ((len(joints) - 1) / 2 - i))

    def _link(self, joint: Joint, ground: str = GROUND, *, z: float, ground_z: float | None = None) -> None:
        ends = [ground if name == GROUND else name for name in (joint.start, joint.end)]
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
        places = [self.order.index(name) for name in joint.ends if name != GROUND]
        return min(places), max(places)

    def _walls(self, name: str) -> None:
        """Walls beside a body, as far as it is tied to them."""
        for side, sign in (("left", -1), ("right", 1)):
            joints = self._tied(name, side)
            if joints:
                x = self.places[name] + sign * ((self._width(name) + WALL) / 2 + GAP)
                height = max(2 * self.top + 0.6, LANE * len(joints) + 0.7)
                wall = self._ground(f"ground {side} of {name}", (x, 0.0, 0.0), (WALL, 1.2, height))
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
