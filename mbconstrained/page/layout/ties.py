"""Levers, racks and ropes over pulleys: how they put pieces of a drawing together, and what they look like."""

from __future__ import annotations

from dataclasses import dataclass

from ...models.elements import GROUND, Lever, Pulley, Rack
from ..drawing import Body, Link
from .mates import Mate
from .piece import Piece

PULLEY = 0.75  # radius of a pulley in drawing units
DROP = 1.6  # from a pulley down to what hangs on its rope

#: A pivot further away than this many times the distance of a lever's ends is not drawn, nor is the lever.
FARTHEST_PIVOT = 4.0


@dataclass(frozen=True)
class Tie:
    """A piece of its own, the mates that put it to others, and the links from it to them."""

    piece: Piece | None
    mates: tuple[Mate, ...]
    links: tuple[Link, ...] = ()


def lever_tie(lever: Lever, start: Piece, end: Piece) -> Tie | None:
    """An upright bar through a pivot: its ends move to the sides in the ratio of the arms. None where it has no room."""
    room = start.place(lever.start)[2] - start.low[2] + end.high[2] - end.place(lever.end)[2] + 0.7
    span = lever.start_arm + lever.end_arm
    if max(abs(lever.start_arm), abs(lever.end_arm)) > FARTHEST_PIVOT * abs(span):
        return None
    up, down = room * lever.start_arm / span, room * lever.end_arm / span
    pivot = Body(f"pivot of {lever.name}", "ground", size=(0.3, 0.5, 0.16))
    mates = (Mate(pivot.name, lever.start, (0.0, 0.0, up)), Mate(pivot.name, lever.end, (0.0, 0.0, -down)))
    links = tuple(Link(lever.name, "rod", pivot.name, name) for name in (lever.start, lever.end))
    return Tie(Piece((pivot,)), mates, links)


def rack_tie(rack: Rack, pinion: Body, body: Body) -> Tie:
    """The rack runs along the pinion's rim: below it where a positive angle moves it forwards, else above it."""
    height = (pinion.size[2] + body.size[2]) / 2 + 0.04
    return Tie(None, (Mate(rack.gear, rack.rack, (0.0, 0.0, -height if rack.radius > 0 else height)),))


def pulley_tie(pulley: Pulley, turns_per_metre: float) -> Tie:
    """A wheel with a rope over it, carried by the ceiling or by a body; what hangs on its ends moves up and down.

    Args:
        turns_per_metre: angle in rad by which the wheel turns, as drawn, for a metre of rope.
    """
    over = {} if pulley.over == GROUND else {pulley.over: (0.0, 0.0, 1.0)}
    turns = {pulley.start: (0.0, turns_per_metre, 0.0)}
    if over:
        turns[pulley.over] = (0.0, -turns_per_metre, 0.0)
    name = f"wheel of {pulley.name}"
    wheel = Body(name, "disc", moves=over, turns=turns, size=(2 * PULLEY, 0.2, 2 * PULLEY), color="#d9dfe5", label="")
    bodies, carrier = [wheel], pulley.over
    mates = [Mate(name, pulley.start, (-PULLEY, 0.0, -DROP)), Mate(name, pulley.end, (PULLEY, 0.0, -DROP))]
    if over:
        mates.append(Mate(name, pulley.over, (0.0, 0.0, PULLEY + 0.8)))
    else:
        carrier = f"ceiling of {pulley.name}"
        bodies.append(Body(carrier, "ground", (0.0, 0.0, PULLEY + 0.6), size=(1.6, 0.9, 0.2)))
    links = (
        Link(f"{pulley.name}, hanger", "rod", carrier, name, offset=(0.0, 0.14, 0.0)),
        Link(pulley.name, "belt", pulley.start, pulley.end, over=name),
    )
    return Tie(Piece(tuple(bodies)), tuple(mates), links)
