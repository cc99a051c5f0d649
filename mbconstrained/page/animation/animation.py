"""An animation: a drawing, the motion of its coordinates, and the forces, jumps and impulses shown with it. Pure data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ...ground.checks import real_array
from ...ground.errors import InputError
from ..drawing.bodies import Drawing, Vector
from ..drawing.paths import Path

#: Larger numbers cannot be drawn: the arithmetic of axes and of interpolation would overflow.
LARGEST = 1e290


@dataclass(frozen=True)
class Arrow:
    """A force, a moment or an impulse of either on a body; a moment is an arrow around an axis.

    Attributes:
        body: name of the body.
        direction: of a positive force, or the axis about which a positive moment turns counter-clockwise; any length but zero.
            None for a vector given by its components along the axes of the body's frame, with which it turns.
        unit: such as "N" or "N m s".
        turns: whether it is a moment.
        point: start of the arrow in the frame of the body.
    """

    body: str
    direction: Vector | None
    unit: str
    turns: bool = False
    point: Vector = (0.0, 0.0, 0.0)

    @property
    def unit_direction(self) -> np.ndarray | None:
        """The direction with length 1, shape (3,)."""
        return None if self.direction is None else np.array(self.direction) / np.linalg.norm(self.direction)


@dataclass(frozen=True, eq=False)
class ForceArrows:
    """Arrows of one force over time.

    Attributes:
        name: name of the force.
        values, rates: at the times of the animation, shape (T,), or (3, T) where its arrows have no direction of their own.
        arrows: each with its factor: a force that two bodies exert on each other is 1 on one and -1 on the other.
    """

    name: str
    values: np.ndarray
    rates: np.ndarray
    arrows: tuple[tuple[Arrow, float], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """One name for each row of the values."""
        name = f"force: {self.name}"
        return (name,) if self.values.ndim == 1 else tuple(f"{name} {axis}" for axis in "xyz")


class ImpulseArrow(NamedTuple):
    """An impulsive load: its arrow, its size (three components where the arrow has no direction) and its label."""

    arrow: Arrow
    size: float | np.ndarray
    label: str


@dataclass(frozen=True, eq=False)
class DrawnEvent:
    """Jumps and impulses at one time.

    Attributes:
        time: in s.
        lines: sentences without a full stop, shown with the picture.
        before, after: the coordinates just before and just after, each (r,).
        impulses: the impulsive loads.
        paths: by body name, of bodies that have paths, the poses just before and just after.
    """

    time: float
    lines: tuple[str, ...]
    before: np.ndarray
    after: np.ndarray
    impulses: tuple[ImpulseArrow, ...] = ()
    paths: Mapping[str, Path] = field(default_factory=dict)


@dataclass(frozen=True)
class Overlay:
    """Overlay of an animation.

    Attributes:
        events: jumps and impulses, in the order of time.
        forces: forces shown at all times.
        description: description of the forces, for the line over the picture.
    """

    events: tuple[DrawnEvent, ...] = ()
    forces: tuple[ForceArrows, ...] = ()
    description: str = "reactions"

    def __bool__(self) -> bool:
        return bool(self.events or self.forces)


@dataclass(frozen=True, eq=False)
class Animation:
    """A drawing and the motion of its coordinates.

    Attributes:
        drawing: bodies and links.
        names: r coordinate names; the page also lists those that the drawing does not use.
        times: shape (T,), ascending, in s.
        values: shape (r, T), in the units of the coordinates.
        rates: their time derivatives, shape (r, T); estimated from the values when None. With them the motion between
            the times is exact to fourth order in their spacing.
        overlay: forces, jumps and impulses that are drawn over the model.

    Raises:
        InputError: shapes that do not match, NaN, infinity or numbers beyond 1e290, times that do not ascend.
    """

    drawing: Drawing
    names: tuple[str, ...]
    times: np.ndarray
    values: np.ndarray
    rates: np.ndarray | None = None
    overlay: Overlay = Overlay()

    def __post_init__(self):
        times = ascending_times(self.times, "animation, times")
        values = drawable(self.values, "animation, values", (len(self.names), len(times)))
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)
        if self.rates is not None:
            object.__setattr__(self, "rates", drawable(self.rates, "animation, rates", values.shape))


def arrow_at(drawing: Drawing, coordinate: str, unit: str) -> Arrow | None:
    """The arrow of a force along a coordinate.

    >>> from mbconstrained.page.drawing.bodies import DrawnBody
    >>> arrow_at(Drawing((DrawnBody("cart", moves={"x": (1, 0, 0)}),)), "x", "N")
    Arrow(body='cart', direction=(1.0, 0.0, 0.0), unit='N', turns=False, point=(0.0, 0.0, 0.0))
    """
    moved = [body for body in drawing.bodies if any(map(any, (body.moves.get(coordinate, ()), body.turns.get(coordinate, ()))))]
    if not moved:
        return None
    body = min(moved, key=lambda body: len({*body.moves, *body.turns}))
    turns = not any(body.moves.get(coordinate, ()))
    return Arrow(body.name, (body.turns if turns else body.moves)[coordinate], unit, turns)


def drawable(value, what: str, shape: tuple[int | None, ...]) -> np.ndarray:
    """An array of numbers small enough that their differences are finite."""
    array = real_array(value, what, shape=shape)
    if np.abs(array).max(initial=0.0) > LARGEST:
        raise InputError(f"{what}: found {np.abs(array).max():.3g}, which is too large to draw; give an earlier end")
    return array


def ascending_times(value, what: str) -> np.ndarray:
    """Times, each after the one before."""
    times = drawable(value, what, (None,))
    if len(times) == 0:
        raise InputError(f"{what}: no times found; give at least one")
    if (np.diff(times) <= 0).any():
        place = int(np.argmax(np.diff(times) <= 0))
        raise InputError(f"{what}: {times[place]:g} s is followed by {times[place + 1]:g} s; times must ascend")
    return times
