"""Bodies that turn: shafts that run away from the viewer, with discs and toothed wheels facing the viewer.

A train is a set of shafts whose wheels mesh. Wheels on one shaft stand behind each other; a wheel that meshes with
another stands beside it, touching, their radii in proportion and their teeth in the gaps of each other.
"""

from __future__ import annotations

import math

import numpy as np

from ...models.elements import GROUND, Gear
from ..drawing import Body, Link
from .anchors import blocks_around, wall_behind
from .joints import Joint, groups, walk
from .piece import Piece
from .toothing import THICKNESS, Wheel, first_wheel, meshing_wheel

PITCH = 1.3  # from body to body along a shaft
DISC, SMALL = 0.6, 0.3  # radii of an inertia and of a joint without one
APART = 3.0  # between shafts that nothing connects

#: Where the next wheels around a wheel go: right, left, up, down.
_AROUND = (0.0, math.pi, math.pi / 2, -math.pi / 2)


class Train:
    """The layout of turning bodies that shafts and toothed wheels connect.

    Args:
        names: the bodies.
        massless: those that are joints without inertia.
        joints, gears: what connects them; others are left aside.
        racked: the bodies with a rack below them.
    """

    def __init__(self, names: list[str], massless: frozenset[str], joints: list[Joint], gears: list[Gear], racked=frozenset()):
        self.massless = massless
        self.racked = racked
        self.joints = [joint for joint in joints if joint.ends <= {GROUND, *names}]
        self.gears = [gear for gear in gears if gear.start in names and gear.end in names]
        shafts = groups(names, [joint.ends for joint in self.joints])
        self.shafts = [tuple(walk(shaft, self.joints)) for shaft in shafts]
        self.shaft_of = {name: shaft for shaft in self.shafts for name in shaft}
        self.wheels: list[Wheel] = []
        self.axes: dict[tuple, np.ndarray] = {}  # where the first body of each shaft is, once it has its place
        self.taken: dict[tuple, list[float]] = {shaft: [] for shaft in self.shafts}  # directions of meshing wheels

    def piece(self) -> Piece:
        """Bodies with the first shaft at x = z = 0 and its first body at y = 0."""
        self._place_shafts()
        bodies = {name: self._bodies(name) for shaft in self.shafts for name in shaft}
        parts = [Piece(tuple(own)) for own in bodies.values()]
        inner = [joint for joint in self.joints if GROUND not in joint.ends]
        parts.append(Piece((), tuple(Link(joint.name, joint.kind, joint.start, joint.end) for joint in inner)))
        parts += [self._anchor(name, own[0]) for name, own in bodies.items()]
        return Piece(tuple(b for part in parts for b in part.bodies), tuple(link for part in parts for link in part.links))

    def _place_shafts(self) -> None:
        """One shaft after the other, each next to one that has its place if a gear connects them."""
        edge = 0.0
        while len(self.axes) < len(self.shafts):
            shaft = next(shaft for shaft in self.shafts if shaft not in self.axes)
            self.axes[shaft] = np.array([edge, 0.0, 0.0])
            while gear := next(filter(self._is_next, self.gears), None):
                self._mesh(gear)
            edge = max(axis[0] for axis in self.axes.values()) + APART

    def _is_next(self, gear: Gear) -> bool:
        """One of its shafts has its place, the other not."""
        return (self.shaft_of[gear.start] in self.axes) != (self.shaft_of[gear.end] in self.axes)

    def _mesh(self, gear: Gear) -> None:
        """Places the other shaft of a gear so that its wheels touch."""
        ends = [(gear.start, gear.start_radius), (gear.end, gear.end_radius)]
        if self.shaft_of[gear.start] not in self.axes:
            ends.reverse()
        (one, radius), (other, other_radius) = ends
        first = self._wheel(one, radius, other_radius, gear.internal and radius > other_radius)
        direction = self._direction(self.shaft_of[one])
        second = meshing_wheel(first, other, other_radius, direction, gear.internal)
        self.wheels.append(second)
        shaft = self.shaft_of[other]
        self.axes[shaft] = np.array(second.middle) - self._along(other)
        self.taken[shaft].append(direction if gear.internal else direction + math.pi)

    def _direction(self, shaft: tuple) -> float:
        """The first direction in which no wheel meshes yet."""
        taken = self.taken[shaft]
        free = (angle for angle in _AROUND if all(math.cos(angle - other) < 0.9 for other in taken))
        taken.append(next(free, 0.0))
        return taken[-1]

    def _wheel(self, name: str, radius: float, partner: float, ring: bool) -> Wheel:
        """The wheel of this radius on a body that has its place; a further one, of another size, stands behind the first."""
        own = [wheel for wheel in self.wheels if wheel.body == name]
        known = next((wheel for wheel in own if math.isclose(wheel.nominal, radius) and wheel.ring == ring), None)
        if known:
            return known
        behind = (0.0, 1.4 * THICKNESS * len(own), 0.0)
        self.wheels.append(first_wheel(name, radius, partner, self._middle(name) + behind, ring))
        return self.wheels[-1]

    def _along(self, name: str) -> np.ndarray:
        """From the first body of its shaft, which is next to the ground and furthest from the viewer."""
        return np.array([0.0, -PITCH * self.shaft_of[name].index(name), 0.0])

    def _middle(self, name: str) -> np.ndarray:
        return self.axes[self.shaft_of[name]] + self._along(name)

    def _bodies(self, name: str) -> list[Body]:
        """The wheels of a body, of which only the first has its name, or a disc."""
        own = [wheel for wheel in self.wheels if wheel.body == name]
        if own:
            further = [wheel.drawn(f"{name}, wheel {i}", "") for i, wheel in enumerate(own[1:], start=2)]
            return [own[0].drawn(name, name), *further]
        radius, color = (SMALL, "#ffffff") if name in self.massless else (DISC, None)
        size = (2 * radius, THICKNESS, 2 * radius)
        return [Body(name, "disc", tuple(self._middle(name)), turns={name: (0.0, -1.0, 0.0)}, size=size, color=color)]

    def _anchor(self, name: str, body: Body) -> Piece:
        """The ties of a body to the ground."""
        tied = [joint for joint in self.joints if joint.ends == {name, GROUND}]
        shaft = self.shaft_of[name]
        if name == shaft[0] and len(shaft) > 1:
            return wall_behind(body, tied) if tied else Piece(())
        return blocks_around(body, tied, up=1 if name in self.racked else -1)
