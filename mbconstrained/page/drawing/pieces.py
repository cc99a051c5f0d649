"""Pieces of a drawing, bodies and links with fixed relative positions, and their connections by levers, racks and ropes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...ground.coordinate_units import GROUND
from ...models.elements import Element, Lever, Pulley, Rack
from .bodies import DrawnBody, DrawnLink, Vector

#: Radius of a pulley, and distance from it down to the load on its rope, drawing units.
PULLEY, DROP = 0.75, 1.6

#: Space between unconnected pieces, drawing units.
SPACE = 0.7

#: Farthest pivot of a drawn lever, in distances of its ends.
FARTHEST_PIVOT = 4.0


@dataclass(frozen=True)
class Piece:
    """Bodies and links around a local origin."""

    bodies: tuple[DrawnBody, ...]
    links: tuple[DrawnLink, ...] = ()

    @property
    def names(self) -> frozenset[str]:
        """Names of the bodies."""
        return frozenset(body.name for body in self.bodies)

    def body(self, name: str) -> DrawnBody:
        """The body of this name."""
        return next(body for body in self.bodies if body.name == name)

    @property
    def corners(self) -> np.ndarray:
        """The corners with the smallest and the largest coordinates of a box around it, shape (2, 3)."""
        places = np.array([body.rest for body in self.bodies])
        halves = np.array([body.half_extent for body in self.bodies])
        own = {body.name: np.array(body.rest) for body in self.bodies}
        ends = [own[link.end] + link.end_offset for link in self.links] + [own[link.start] + link.offset for link in self.links]
        points = np.vstack([places - halves, places + halves, *ends])
        return np.array([points.min(axis=0), points.max(axis=0)])

    def shifted(self, shift) -> Piece:
        """The piece at another position."""
        return replace(self, bodies=tuple(replace(body, rest=tuple(np.add(body.rest, shift))) for body in self.bodies))

    def hanging(self) -> Piece:
        """The piece turned from the right downwards; its coordinates are then positive upwards."""

        def downwards(vector) -> Vector:
            x, y, z = vector
            return z, y, -x

        turned = []
        for body in self.bodies:
            moves = {name: downwards(np.negative(vector)) for name, vector in body.moves.items()}
            size = tuple(map(abs, downwards(body.size)))
            turned.append(replace(body, rest=downwards(body.rest), moves=moves, size=size))
        links = (replace(link, offset=downwards(link.offset), end_offset=downwards(link.end_offset)) for link in self.links)
        return Piece(tuple(turned), tuple(links))


class Mate(NamedTuple):
    """The position of body ``other`` relative to body ``one`` of another piece."""

    one: str
    other: str
    shift: Vector


def _assembled(pieces: Iterable[Piece], mates: Sequence[Mate]) -> list[Piece]:
    """The pieces that mates connect as one piece each; a mate of bodies of one piece changes nothing."""
    waiting, done = list(pieces), []
    while waiting:
        whole = waiting.pop(0)
        while match := _next(whole, waiting, mates):
            piece, shift = match
            waiting.remove(piece)
            moved = piece.shifted(shift)
            whole = Piece((*whole.bodies, *moved.bodies), (*whole.links, *moved.links))
        done.append(whole)
    return done


def _next(whole: Piece, waiting: list[Piece], mates: Sequence[Mate]) -> tuple[Piece, np.ndarray] | None:
    """A waiting piece that a mate joins to the whole, and its shift."""
    for mate in mates:
        for one, other, shift in (mate, (mate.other, mate.one, np.negative(mate.shift))):
            for piece in waiting:
                if one in whole.names and other in piece.names:
                    return piece, np.add(whole.body(one).rest, shift) - piece.body(other).rest
    return None


def stacked(pieces: Iterable[Piece], mates: Sequence[Mate]) -> Piece:
    """All pieces as one: those that move sideways one below another, in several columns when there are many; others side by side."""
    hanging, lying = [], []
    for piece in _assembled(pieces, mates):
        upwards = any(move[2] for body in piece.bodies for move in body.moves.values())
        (hanging if upwards else lying).append(piece)
    rows = max(6, math.ceil(1.3 * math.sqrt(len(hanging) + len(lying))))
    columns = [lying[begin : begin + rows] for begin in range(0, len(lying), rows)] + [[piece] for piece in hanging]
    bodies, links, left = [], [], 0.0
    for column in columns:
        top, right = 0.0, left
        for piece in column:
            low, high = piece.corners
            shift = (left - low[0], 0.0, top - high[2])
            moved = piece.shifted(shift)
            top, right = low[2] + shift[2] - SPACE, max(right, high[0] + shift[0])
            bodies += moved.bodies
            links += moved.links
        left = right + 2 * SPACE
    return Piece(tuple(bodies), tuple(links))


class DrawnTie(NamedTuple):
    """The drawing of a lever, rack or pulley: its own piece, the mates that join it to others, and the links to them."""

    piece: Piece | None
    mates: tuple[Mate, ...]
    links: tuple[DrawnLink, ...] = ()


def tie_of(element: Element, home: Mapping[str, Piece], turns_per_metre: float) -> DrawnTie | None:
    """The drawing of a lever, rack or pulley."""
    if isinstance(element, Pulley):
        return _pulley_tie(element, turns_per_metre)
    if isinstance(element, Rack):  # runs along the pinion's rim: below it where a positive angle moves it forwards, else above it
        pinion, rack = home[element.gear].body(element.gear), home[element.rack].body(element.rack)
        height = (pinion.size[2] + rack.size[2]) / 2 + 0.04
        return DrawnTie(None, (Mate(element.gear, element.rack, (0.0, 0.0, -height if element.radius > 0 else height)),))
    if isinstance(element, Lever) and home[element.start] is not home[element.end]:
        return _lever_tie(element, home[element.start], home[element.end])
    return None


def _lever_tie(lever: Lever, start: Piece, end: Piece) -> DrawnTie | None:
    """An upright bar through a pivot: its ends move to the sides in the ratio of the arms."""
    span = lever.start_arm + lever.end_arm
    if max(abs(lever.start_arm), abs(lever.end_arm)) > FARTHEST_PIVOT * abs(span):
        return None
    below, above = start.body(lever.start).rest[2] - start.corners[0, 2], end.corners[1, 2] - end.body(lever.end).rest[2]
    room = below + above + 0.7
    up, down = room * lever.start_arm / span, room * lever.end_arm / span
    pivot = DrawnBody(f"pivot of {lever.name}", "ground", size=(0.3, 0.5, 0.16))
    mates = (Mate(pivot.name, lever.start, (0.0, 0.0, up)), Mate(pivot.name, lever.end, (0.0, 0.0, -down)))
    links = tuple(DrawnLink(lever.name, "rod", pivot.name, name) for name in (lever.start, lever.end))
    return DrawnTie(Piece((pivot,)), mates, links)


def _pulley_tie(pulley: Pulley, turns_per_metre: float) -> DrawnTie:
    """A wheel with a rope over it, on the ceiling or on a body; the loads on its ends move up and down."""
    name, carrier = f"wheel of {pulley.name}", pulley.over
    turns = {pulley.start: (0.0, turns_per_metre, 0.0)}
    mates = [Mate(name, pulley.start, (-PULLEY, 0.0, -DROP)), Mate(name, pulley.end, (PULLEY, 0.0, -DROP))]
    moves, ceiling = {}, []
    if carrier == GROUND:
        carrier = f"ceiling of {pulley.name}"
        ceiling = [DrawnBody(carrier, "ground", (0.0, 0.0, PULLEY + 0.6), size=(1.6, 0.9, 0.2))]
    else:
        moves = {carrier: (0.0, 0.0, 1.0)}
        turns[carrier] = (0.0, -turns_per_metre, 0.0)
        mates.append(Mate(name, carrier, (0.0, 0.0, PULLEY + 0.8)))
    wheel = DrawnBody(name, "disc", moves=moves, turns=turns, size=(2 * PULLEY, 0.2, 2 * PULLEY), color="#d9dfe5", label="")
    links = (
        DrawnLink(f"{pulley.name}, hanger", "rod", carrier, name, offset=(0.0, 0.14, 0.0)),
        DrawnLink(pulley.name, "belt", pulley.start, pulley.end, over=name),
    )
    return DrawnTie(Piece((wheel, *ceiling)), tuple(mates), links)
