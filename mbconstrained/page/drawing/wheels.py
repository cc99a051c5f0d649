"""Rotating bodies: shafts along the line of sight, with discs and toothed wheels that face the viewer.

A train is a set of shafts whose wheels mesh. Wheels on one shaft are behind each other; meshing wheels touch, with radii to
scale and the teeth of one in the gaps of the other. Shafts end at a wall, single wheels at blocks around them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ...ground.coordinate_units import GROUND
from ...models.elements import Gear, GearMesh
from .bodies import DrawnBody, DrawnLink, Shape, Vector
from .layout import DrawnJoint, Piece, groups, walk

#: Distances from body to body along a shaft, from a shaft to its wall, and between unconnected shafts, drawing units.
PITCH, WALL_DISTANCE, SHAFT_GAP = 1.3, 1.3, 3.0

#: Radii of an inertia and of a joint without one, drawing units.
DISC, SMALL = 0.6, 0.3

#: Thickness of every wheel and disc, drawing units.
THICKNESS = 0.26

#: Drawn radii of toothed wheels: usual of the larger, least of the smaller, most of any, drawing units.
LARGEST, SMALLEST, LIMIT = 1.0, 0.3, 3.0

#: Directions of the wheels around a wheel: right, left, up, down, rad.
_AROUND = (0.0, math.pi, math.pi / 2, -math.pi / 2)


class Train:
    """The layout of turning bodies that shafts and toothed wheels connect.

    Args:
        names: the bodies.
        massless: names of joints without inertia.
        joints, gears: of the model; those of other bodies are ignored.
        racked: the bodies with a rack below them.
    """

    def __init__(
        self, names: list[str], massless: frozenset[str], joints: list[DrawnJoint], gears: list[Gear | GearMesh], racked=frozenset()
    ):
        self.massless = massless
        self.racked = racked
        self.joints = [joint for joint in joints if joint.ends <= {GROUND, *names}]
        self.gears = [gear for gear in gears if gear.start in names and gear.end in names]
        shafts = groups(names, [joint.ends for joint in self.joints])
        self.shafts = [tuple(walk(shaft, self.joints)) for shaft in shafts]
        self.shaft_of = {name: shaft for shaft in self.shafts for name in shaft}
        self.wheels: list[Wheel] = []
        self.axes: dict[tuple, np.ndarray] = {}  # position of the first body of each shaft
        self.directions: dict[tuple, list[float]] = {shaft: [] for shaft in self.shafts}  # directions of meshing wheels

    def piece(self) -> Piece:
        """Bodies with the first shaft at x = z = 0 and its first body at y = 0."""
        edge = 0.0
        while len(self.axes) < len(self.shafts):  # those connected by gears next to each other
            shaft = next(shaft for shaft in self.shafts if shaft not in self.axes)
            self.axes[shaft] = np.array([edge, 0.0, 0.0])
            while gear := next(filter(self._is_next, self.gears), None):
                self._mesh(gear)
            edge = max(axis[0] for axis in self.axes.values()) + SHAFT_GAP
        drawn = {name: self._bodies(name) for shaft in self.shafts for name in shaft}
        anchors = [self._anchor(name, own[0]) for name, own in drawn.items()]
        inner = (DrawnLink(joint.name, joint.kind, joint.start, joint.end) for joint in self.joints if GROUND not in joint.ends)
        bodies = (body for own in (*drawn.values(), *(anchor.bodies for anchor in anchors)) for body in own)
        return Piece(tuple(bodies), (*inner, *(link for anchor in anchors for link in anchor.links)))

    def _is_next(self, gear: Gear | GearMesh) -> bool:
        """Whether one of its shafts has a position and the other does not."""
        return (self.shaft_of[gear.start] in self.axes) != (self.shaft_of[gear.end] in self.axes)

    def _mesh(self, gear: Gear | GearMesh) -> None:
        """Places the other shaft of a gear so that its wheels touch, in the first direction in which no wheel meshes yet."""
        ends = [*zip((gear.start, gear.end), gear.sizes)]
        if self.shaft_of[gear.start] not in self.axes:
            ends.reverse()
        (one, radius), (other, other_radius) = ends
        first = self._wheel(one, radius, other_radius, gear.internal and radius > other_radius)
        occupied = self.directions[self.shaft_of[one]]
        free = (angle for angle in _AROUND if all(math.cos(angle - other) < 0.9 for other in occupied))
        direction = next(free, 0.0)
        second = _meshing(first, other, other_radius, direction, gear.internal)
        self.wheels.append(second)
        shaft = self.shaft_of[other]
        self.axes[shaft] = np.array(second.middle) - self._along(other)
        occupied.append(direction)
        self.directions[shaft].append(direction if gear.internal else direction + math.pi)

    def _wheel(self, name: str, radius: float, partner: float, ring: bool) -> Wheel:
        """The wheel of this radius on a body with a position; a further one, of another size, is behind the first.

        A new one has a size that suits its partner too.
        """
        own = [wheel for wheel in self.wheels if wheel.body == name]
        known = next((wheel for wheel in own if math.isclose(wheel.nominal, radius) and wheel.ring == ring), None)
        if known:
            return known
        small, large = sorted((radius, partner))
        scale = min(max(LARGEST / large, SMALLEST / small), LIMIT / large)
        middle = self._middle(name) + (0.0, 1.4 * THICKNESS * len(own), 0.0)
        self.wheels.append(Wheel(name, radius, scale * radius, _teeth(radius, partner), tuple(middle), ring=ring))
        return self.wheels[-1]

    def _along(self, name: str) -> np.ndarray:
        """Offset from the first body of its shaft, which is next to the ground and furthest from the viewer."""
        return np.array([0.0, -PITCH * self.shaft_of[name].index(name), 0.0])

    def _middle(self, name: str) -> np.ndarray:
        return self.axes[self.shaft_of[name]] + self._along(name)

    def _bodies(self, name: str) -> list[DrawnBody]:
        """The wheels of a body, of which only the first has its name, or a disc."""
        own = [wheel for wheel in self.wheels if wheel.body == name]
        if own:
            further = [replace(wheel.drawn, name=f"{name}, wheel {i}", label="") for i, wheel in enumerate(own[1:], start=2)]
            return [own[0].drawn, *further]
        radius, color = (SMALL, "#ffffff") if name in self.massless else (DISC, None)
        size = (2 * radius, THICKNESS, 2 * radius)
        return [DrawnBody(name, "disc", tuple(self._middle(name)), turns={name: (0.0, -1.0, 0.0)}, size=size, color=color)]

    def _anchor(self, name: str, body: DrawnBody) -> Piece:
        """The links of a body to the ground: to a wall behind the first of several on a shaft, else to blocks around it."""
        grounded = [joint for joint in self.joints if joint.ends == {name, GROUND}]
        shaft = self.shaft_of[name]
        if name != shaft[0] or len(shaft) == 1:
            return _blocks_around(body, grounded, up=1 if name in self.racked else -1)
        wall = DrawnBody(f"ground behind {body.name}", "ground", _relative(body, y=WALL_DISTANCE), size=(1.3, 0.16, 1.3))
        links = tuple(DrawnLink(joint.name, joint.kind, wall.name, body.name) for joint in grounded)
        return Piece((wall,), links) if links else Piece(())


def _blocks_around(body: DrawnBody, joints: list[DrawnJoint], up: int) -> Piece:
    """Springs as spirals in front of the body, on studs from below (up = -1) or above; dampers as brakes on its rim."""
    bodies, links = [], []
    brakes = [joint for joint in joints if joint.kind == "torsion damper"]
    springs = [joint for joint in joints if joint not in brakes]
    radius = body.size[0] / 2
    if springs:
        bodies.append(DrawnBody(f"ground at {body.name}", "ground", _relative(body, z=up * (radius + 0.45)), size=(0.7, 0.9, 0.2)))
    for i, joint in enumerate(springs):
        front = -THICKNESS / 2 - 0.13 * (i + 1)
        stud = (0.0, front, -up * (0.28 * radius + 0.45))
        links.append(DrawnLink(joint.name, joint.kind, bodies[0].name, body.name, stud, (0.0, front, 0.0)))
    for side, joint in zip((-1, 1, -1, 1), brakes):
        block = f"ground of {joint.name}"
        bodies.append(DrawnBody(block, "ground", _relative(body, x=side * (radius + 0.7)), size=(0.18, 0.5, 0.6)))
        links.append(DrawnLink(joint.name, joint.kind, block, body.name, end_offset=(side * radius, 0.0, 0.0)))
    return Piece(tuple(bodies), tuple(links))


def _relative(body: DrawnBody, *, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> tuple:
    return tuple(np.array(body.rest) + (x, y, z))


@dataclass(frozen=True)
class Wheel:
    """A toothed wheel on a body: ``nominal`` is its radius in the model, ``phase`` the direction of its first tooth."""

    body: str
    nominal: float
    radius: float
    teeth: int
    middle: Vector
    phase: float = 0.0
    ring: bool = False

    @property
    def drawn(self) -> DrawnBody:
        """The wheel as a body, turning with the coordinate of its body."""
        size, rest_turn = (2 * self.radius, THICKNESS, 2 * self.radius), (0.0, -self.phase, 0.0)
        turns = {self.body: (0.0, -1.0, 0.0)}
        shape: Shape = "ring" if self.ring else "gear"
        return DrawnBody(self.body, shape, self.middle, turns=turns, size=size, rest_turn=rest_turn, teeth=self.teeth)


def _meshing(first: Wheel, body: str, nominal: float, direction: float, internal: bool) -> Wheel:
    """The partner of a wheel in a direction (rad from the right, counter-clockwise), one running inside the other or not.

    A tooth meets a gap on the other side; inside a ring, whose outline is a hole, a tooth meets a tooth of the hole.
    """
    ratio = nominal / first.nominal
    teeth = max(3, round(first.teeth * ratio))
    distance = first.radius * (1 - ratio if internal else 1 + ratio)
    middle = np.array(first.middle) + distance * np.array([math.cos(direction), 0.0, math.sin(direction)])
    share = (direction - first.phase) * first.teeth / (2 * math.pi)  # in teeth of the first wheel, up to the contact
    pitch = 2 * math.pi / teeth
    phase = direction - share * pitch if internal else direction + math.pi - (0.5 - share) * pitch
    return Wheel(body, nominal, ratio * first.radius, teeth, tuple(middle), phase, ring=internal and ratio > 1)


def _teeth(one: float, other: float) -> int:
    """Number of teeth of the first of two radii: the radius itself where both can be numbers of teeth, else a good fit."""
    if all(radius == round(radius) and 8 <= radius <= 120 for radius in (one, other)):
        return round(one)
    ratio = max(one, other) / min(one, other)
    small = min(range(12, 25), key=lambda count: (round(abs(count * ratio - round(count * ratio)), 9), -count))
    return small if one <= other else round(small * ratio)
