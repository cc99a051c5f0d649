"""A drawing for a system of which only equations are known: every place is a box on a rail of its own, every angle a disc."""

from __future__ import annotations

import math

import numpy as np

from ...checks import names_of, real_array
from ...errors import InputError
from ..drawing import Body, Drawing, Link
from .magnification import angle_scale, displacement_scale
from .piece import Piece
from .turning import turned_pieces

PITCH, WIDTH = 0.95, 5.6  # from one to the next, downwards and across
GAP = 0.8  # beside what goes another way


def coordinate_drawing(names, values=None, units=None, scale=None, turn_scale=None, directions=None) -> Drawing:
    """Boxes on rails and discs, one below the other, in several columns when there are many.

    Args:
        names: r coordinate names.
        values: typical values, shape (r,) or (r, T), by which the magnifications are chosen; None for 1.
        units: r units; "m" slides, "rad" turns, and what is neither place nor angle is not drawn. None for "m".
        scale, turn_scale: the magnifications, where they shall not be chosen.
        directions: vectors by name, of coordinates that move along, or turn about, another axis than usual: these stand on the
            right.

    Raises:
        InputError: repeated names, values or units of another shape, NaN or infinity.

    >>> [body.shape for body in coordinate_drawing(["x1", "q"], [0.01, 1.0], ["m", "rad"]).bodies]
    ['rail', 'box', 'disc']
    """
    names = names_of(names, len(names), "drawing, names", "x")
    motion = dict(zip(names, rows_of(values, len(names))))
    unit_of = dict(zip(names, _units(units, len(names))))
    drawn = [name for name in names if unit_of[name] in _SHOWN]
    own = {name: directions[name] for name in drawn if name in (directions or {})}
    usual = [name for name in drawn if name not in own]
    bodies = [body for name, place in zip(usual, _places(len(usual))) for body in _SHOWN[unit_of[name]](name, place)]
    bodies += _beside(bodies, [_askew(_SHOWN[unit_of[name]](name, (0.0, 0.0, 0.0)), own[name]) for name in own])
    if scale is None:
        scale = displacement_scale({name: motion[name] for name in drawn if unit_of[name] == "m"}, ())
    if turn_scale is None:
        turn_scale = angle_scale([motion[name] for name in drawn if unit_of[name] == "rad"])
    return Drawing(tuple(bodies), (), scale, turn_scale, _note([name for name in names if name not in drawn]))


def rows_of(values, count: int) -> np.ndarray:
    """Typical values as an array (count, T)."""
    if values is None:
        return np.zeros((count, 1))
    values = real_array(values, "drawing, typical values")
    return real_array(values[:, None] if values.ndim == 1 else values, "drawing, typical values", shape=(count, None))


def _units(units, count: int) -> tuple[str, ...]:
    units = ("m",) * count if units is None else tuple(units)
    if len(units) != count:
        raise InputError(f"drawing, units: {len(units)} given for {count} coordinates; give one each")
    return units


def _places(count: int) -> list[tuple[float, float, float]]:
    rows = max(6, math.ceil(1.3 * math.sqrt(count)))
    return [(WIDTH * (i // rows), 0.0, -PITCH * (i % rows)) for i in range(count)]


def _askew(bodies: list[Body], direction) -> Piece:
    """A box with its rail, or a disc, that goes another way."""
    links = tuple(Link("", "rod", bodies[0].name, body.name) for body in bodies[1:])  # so that they are turned together
    (found,) = turned_pieces([Piece(tuple(bodies), links)], {bodies[-1].name: direction})
    return Piece(found.bodies)


def _beside(bodies: list[Body], pieces: list[Piece]) -> list[Body]:
    """The bodies of the pieces, each beside the one before, the first to the right of what is there."""
    left = Piece(tuple(bodies)).high[0] + GAP if bodies else 0.0
    found = []
    for piece in pieces:
        moved = piece.shifted((left - piece.low[0], 0.0, 0.0))
        found += moved.bodies
        left = moved.high[0] + GAP
    return found


def _on_rail(name: str, place: tuple[float, float, float]) -> list[Body]:
    rail = Body(f"rail of {name}", "rail", (place[0], 0.0, place[2] - 0.24), size=(5.0, 0.3, 0.05))
    return [rail, Body(name, "box", place, {name: (1.0, 0.0, 0.0)}, size=(0.42, 0.42, 0.42))]


def _disc(name: str, place: tuple[float, float, float]) -> list[Body]:
    return [Body(name, "disc", place, turns={name: (0.0, -1.0, 0.0)}, size=(0.6, 0.2, 0.6))]


_SHOWN = {"m": _on_rail, "rad": _disc}


def _note(missing: list[str]) -> str:
    return f"not drawn, neither place nor angle: {', '.join(missing)}" if missing else ""
