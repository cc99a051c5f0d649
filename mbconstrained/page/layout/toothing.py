"""Toothed wheels: radii in proportion, numbers of teeth, and where the teeth point so that two wheels mesh."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..drawing import Body, Vector

THICKNESS = 0.26  # of every wheel and disc, in drawing units
LARGEST, SMALLEST, LIMIT = 1.0, 0.3, 3.0  # drawn radii: usual of the larger wheel, least of the smaller, most of any


@dataclass(frozen=True)
class Wheel:
    """A toothed wheel on a body: ``nominal`` is its radius in the model, ``phase`` where its first tooth points."""

    body: str
    nominal: float
    radius: float
    teeth: int
    middle: Vector
    phase: float = 0.0
    ring: bool = False

    def drawn(self, name: str, label: str) -> Body:
        """The wheel as a body, turning with the coordinate of its body."""
        return Body(
            name,
            "ring" if self.ring else "gear",
            self.middle,
            turns={self.body: (0.0, -1.0, 0.0)},
            size=(2 * self.radius, THICKNESS, 2 * self.radius),
            label=label,
            rest_turn=(0.0, -self.phase, 0.0),
            teeth=self.teeth,
        )


def first_wheel(body: str, nominal: float, partner: float, middle, ring: bool) -> Wheel:
    """A wheel that is drawn in a size at which its partner is drawn well too."""
    small, large = sorted((nominal, partner))
    scale = min(max(LARGEST / large, SMALLEST / small), LIMIT / large)
    return Wheel(body, nominal, scale * nominal, _teeth(nominal, partner), tuple(middle), ring=ring)


def meshing_wheel(first: Wheel, body: str, nominal: float, direction: float, internal: bool) -> Wheel:
    """The partner of a wheel in a direction (rad from the right, counter-clockwise), one running inside the other or not."""
    ratio = nominal / first.nominal
    teeth = max(3, round(first.teeth * ratio))
    distance = first.radius * (1 - ratio if internal else 1 + ratio)
    middle = np.array(first.middle) + distance * np.array([math.cos(direction), 0.0, math.sin(direction)])
    phase = _meshing_phase(first, teeth, direction, internal)
    return Wheel(body, nominal, ratio * first.radius, teeth, tuple(middle), phase, ring=internal and ratio > 1)


def _teeth(one: float, other: float) -> int:
    """Number of teeth of the first of two radii: these themselves where they can be numbers of teeth, else a good fit."""
    if all(radius == round(radius) and 8 <= radius <= 120 for radius in (one, other)):
        return round(one)
    ratio = max(one, other) / min(one, other)
    small = min(range(12, 25), key=lambda count: (round(abs(count * ratio - round(count * ratio)), 9), -count))
    return small if one <= other else round(small * ratio)


def _meshing_phase(first: Wheel, teeth: int, direction: float, internal: bool) -> float:
    """A tooth meets a gap on the other side; inside a ring, whose outline is a hole, a tooth meets a tooth of the hole."""
    share = (direction - first.phase) * first.teeth / (2 * math.pi)  # in teeth of the first wheel, up to the contact
    pitch = 2 * math.pi / teeth
    return direction - share * pitch if internal else direction + math.pi - (0.5 - share) * pitch
