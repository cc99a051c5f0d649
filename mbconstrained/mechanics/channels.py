"""Inputs and outputs of a mechanical system by name: a coordinate, a constraint row, or a direction that has a name of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from ..ground.checks import nearest
from ..ground.coordinate_units import GROUND
from ..ground.errors import InputError
from .equations import ElementForce, EquationsOfMotion, Side

#: Number of names listed in a message.
LISTED = 8


class Channel(NamedTuple):
    """A linear combination of coordinates, as input or output; or a constraint row."""

    name: str  # its name
    direction: np.ndarray  # the combination a of a x, shape (n,); of a constraint row its coefficients
    unit: str  # unit of a x, "m", "rad" or "1"
    row: int | None = None  # the place of the constraint row; None of other channels
    element: ElementForce | None = None  # the spring or damper whose force is meant; None of other channels

    def unknowns(self, system: EquationsOfMotion) -> np.ndarray:
        """Position among the coordinates and the multipliers of all rows, as a unit vector or direction, shape (n + k,)."""
        if self.row is None:
            return np.concatenate([self.direction, np.zeros(len(system.rows))])
        return np.eye(1, system.size + len(system.rows), system.size + self.row)[0]


Known = TypeVar("Known")


def reference(system: EquationsOfMotion, name: str) -> Channel:
    """The motion relative to which others are given."""
    known = {GROUND: Channel(GROUND, np.zeros(system.size), "m")} | channels(system, "outputs")
    return chosen_by_name("relative_to", name, known, ())[0]


def channels(system: EquationsOfMotion, side: Side) -> dict[str, Channel | None]:
    """All channels by name: coordinates, constraint rows, and the named inputs or outputs of the system."""
    own = system.named_directions(side)
    known: dict[str, Channel | None] = {channel.name: channel for channel in coordinate_channels(system)}
    known |= {name: Channel(name, direction, unit) for name, (direction, unit) in own.items()}
    for channel in row_channels(system):
        known[channel.name] = None if channel.name in known else channel
    return known


def coordinate_channels(system: EquationsOfMotion) -> list[Channel]:
    return [Channel(name, row, unit) for (name, unit), row in zip(system.units.items(), np.eye(system.size))]


def row_channels(system: EquationsOfMotion) -> list[Channel]:
    return [Channel(row.name, row.coefficients, row.unit, place) for place, row in enumerate(system.rows)]


def chosen_by_name(what: str, chosen, known: Mapping[str, Known | None], default: Sequence[Known]) -> list[Known]:
    """Entries that a user selects by name."""
    if chosen is None:
        return list(default)
    names = [chosen] if isinstance(chosen, str) else list(chosen) if isinstance(chosen, (Sequence, np.ndarray)) else None
    listed = ", ".join(f'"{name}"' for name in list(known)[-LISTED:])
    if names is None:
        raise InputError(f"{what}: found {chosen!r}; expected a list of names, such as {listed}")
    if not names:
        raise InputError(f"{what}: none was named; known are, among others, {listed}")
    result = []
    for name in names:
        if not isinstance(name, str) or name not in known:
            raise InputError(f'{what}: there is no "{name}"{nearest(str(name), known)}; known are, among others, {listed}')
        one = known[name]
        if one is None:
            raise InputError(f'{what}: the name "{name}" is that of a coordinate and of a constraint row; rename one of them')
        result.append(one)
    if len(set(names)) < len(names):
        raise InputError(f'{what}: the name "{next(name for name in names if names.count(name) > 1)}" is used twice')
    return result
