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
            None for one that is told by its components along the axes of the body's frame, with which it then turns.
        turns: whether it is a moment.
        unit: such as "N" or "N m s".
        point: where it begins, in the frame of the body.
    """

    body: str
    direction: Vector | None
    unit: str
    turns: bool = False
    point: Vector = (0.0, 0.0, 0.0)

    def as_data(self, number: int) -> dict:
        """For the page, where bodies have numbers."""
        direction = None if self.direction is None else (np.array(self.direction) / np.linalg.norm(self.direction)).tolist()
        return {"body": number, "direction": direction, "turns": self.turns, "unit": self.unit, "point": list(self.point)}


@dataclass(frozen=True)
class LastingForce:
    """Arrows of one force over time.

    Attributes:
        values, rates: at the times of the animation, shape (T,), or (3, T) where its arrows have no direction of their own.
        arrows: each with its factor: a force that two bodies exert on each other is 1 on one and -1 on the other.
    """

    name: str
    values: np.ndarray
    rates: np.ndarray
    arrows: tuple[tuple[Arrow, float], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """One for each row of the values."""
        name = f"force: {self.name}"
        return (name,) if self.values.ndim == 1 else tuple(f"{name} {axis}" for axis in "xyz")

    @property
    def largest(self) -> float:
        """At all these times."""
        return float(np.linalg.norm(np.atleast_2d(self.values), axis=0).max())


Strike = tuple[Arrow, float | np.ndarray, str]


@dataclass(frozen=True)
class Moment:
    """What happens at one time.

    Attributes:
        time: in s.
        told: sentences, each without a full stop.
        before, after: the coordinates just before and just after, each (r,).
        strikes: impulses, as arrows with their sizes and what they are called; of an arrow without a direction the size is the
            three components.
        paths: of bodies that have paths, their poses just before and just after.
    """

    time: float
    told: tuple[str, ...]
    before: np.ndarray
    after: np.ndarray
    strikes: tuple[Strike, ...] = ()
    paths: Mapping[str, Path] = field(default_factory=dict)


@dataclass(frozen=True)
class Marks:
    """Everything that is drawn over a model.

    Attributes:
        moments: by time.
        forces: that are drawn all the time.
        told: what these are, for the line over the picture.
    """

    moments: tuple[Moment, ...] = ()
    forces: tuple[LastingForce, ...] = ()
    told: str = "reactions"

    def __bool__(self) -> bool:
        return bool(self.moments or self.forces)


def arrow_at(drawing: Drawing, coordinate: str, unit: str) -> Arrow | None:
    """The arrow of a force along a coordinate: at the body that this moves alone, or first; None where none is moved.

    >>> from mbconstrained.page import Body
    >>> arrow_at(Drawing((Body("cart", moves={"x": (1, 0, 0)}),)), "x", "N")
    Arrow(body='cart', direction=(1.0, 0.0, 0.0), unit='N', turns=False, point=(0.0, 0.0, 0.0))
    """
    moved = [body for body in drawing.bodies if any(map(any, (body.moves.get(coordinate, ()), body.turns.get(coordinate, ()))))]
    moved.sort(key=lambda body: len({*body.moves, *body.turns}))
    for body in moved:
        turns = not any(body.moves.get(coordinate, ()))
        return Arrow(body.name, (body.turns if turns else body.moves)[coordinate], unit, turns)
    return None
