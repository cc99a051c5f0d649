"""What is drawn over the model: arrows of forces that last, and what happens at single times: jumps and impulses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from .drawing import Drawing, Vector
from .path import Path


@dataclass(frozen=True)
class Arrow:
    """A force, a moment or an impulse of one at a body; a moment is an arrow around an axis.

    Attributes:
        body: name of the body.
        direction: of a positive force, or the axis about which a positive moment turns counter-clockwise; any length but zero.
        turns: whether it is a moment.
        unit: such as "N" or "N m s".
    """

    body: str
    direction: Vector
    unit: str
    turns: bool = False

    def as_data(self, number: int) -> dict:
        """For the page, where bodies have numbers."""
        length = float(np.linalg.norm(self.direction))
        return {"body": number, "direction": [part / length for part in self.direction], "turns": self.turns, "unit": self.unit}


@dataclass(frozen=True)
class LastingForce:
    """Arrows of one force over time.

    Attributes:
        values, rates: at the times of the animation, shape (T,).
        arrows: each with its factor: a force that two bodies exert on each other is 1 on one and -1 on the other.
    """

    name: str
    values: np.ndarray
    rates: np.ndarray
    arrows: tuple[tuple[Arrow, float], ...]


@dataclass(frozen=True)
class Moment:
    """What happens at one time.

    Attributes:
        time: in s.
        told: sentences, each without a full stop.
        before, after: the coordinates just before and just after, each (r,).
        strikes: impulses, as arrows with their sizes and what they are called.
        paths: of bodies that have paths, their poses just before and just after.
    """

    time: float
    told: tuple[str, ...]
    before: np.ndarray
    after: np.ndarray
    strikes: tuple[tuple[Arrow, float, str], ...] = ()
    paths: Mapping[str, Path] = field(default_factory=dict)


@dataclass(frozen=True)
class Marks:
    """Everything that is drawn over a model.

    Attributes:
        moments: by time.
        forces: that are drawn all the time.
    """

    moments: tuple[Moment, ...] = ()
    forces: tuple[LastingForce, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.moments or self.forces)


def arrow_at(drawing: Drawing, coordinate: str, unit: str) -> Arrow | None:
    """The arrow of a force along a coordinate: at the body that this moves alone, or first; None where none is moved.

    >>> from mbconstrained.page import Body
    >>> arrow_at(Drawing((Body("cart", moves={"x": (1, 0, 0)}),)), "x", "N")
    Arrow(body='cart', direction=(1.0, 0.0, 0.0), unit='N', turns=False)
    """
    moved = [body for body in drawing.bodies if any(map(any, (body.moves.get(coordinate, ()), body.turns.get(coordinate, ()))))]
    moved.sort(key=lambda body: len({*body.moves, *body.turns}))
    for body in moved:
        turns = not any(body.moves.get(coordinate, ()))
        return Arrow(body.name, (body.turns if turns else body.moves)[coordinate], unit, turns)
    return None
