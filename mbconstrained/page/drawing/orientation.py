"""Orientation and magnification of a drawing.

A drawing, or a piece of it, is rotated so that its displacements and axes of rotation have requested directions. Its motion
is magnified enough to be visible, but not so much that bodies overlap.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...ground.tolerances import noise_of
from .bodies import DrawnBody, Vector
from .joints import groups
from .paths import matrix_of, vector_of
from .pieces import Piece

#: Direction of positive displacements in a layout, and the axis about which positive angles turn counter-clockwise.
ALONG, ABOUT = np.array([1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])

UP = np.array([0.0, 0.0, 1.0])

#: A direction with a larger vertical component is steep.
STEEP = 0.8

#: Shorter components of a unit vector perpendicular to another: the two are parallel.
PARALLEL = 1e-6

#: Largest drawn change of distance between neighbours, about half of the gap between them, drawing units.
NEIGHBOURS = 0.8

#: Largest drawn displacement of a body: a whole chain may move further than its bodies relative to each other, drawing units.
ABSOLUTE = 2.4

#: Smaller angles are magnified, rad.
VISIBLE_ANGLE = 0.35

#: Largest magnified angle, rad: at larger ones the oscillation of a wheel is hard to see.
WIDEST_ANGLE = 2 * VISIBLE_ANGLE

#: Smaller motion counts as none.
SMALLEST_MOTION = 1e-290


def turn_to(along: Sequence[float] | None, about: Sequence[float] | None, own: Sequence[float] = (1.0, 0.0, 0.0)) -> Vector:
    """The orientation of a layout with these two perpendicular directions.

    >>> turn_to([0, 0, 2], None)
    (0.0, -1.5707963267948966, 0.0)
    >>> turn_to(None, None)
    (0.0, 0.0, 0.0)
    >>> turn_to([0, 0, 1], None, own=[0, 0, 1])  # a car, which moves upwards as it is drawn
    (0.0, 0.0, 0.0)
    """
    frame = _frame(along, about)
    return _tuple(vector_of(frame @ _frame(own, None).T if along is not None else frame))


def turned_piece(piece: Piece, directions: Mapping[str, Sequence[float]], gears=()) -> Piece:
    """A piece in which bodies move along, or turn about, directions of their own.

    The ground of a body is turned with it. Bodies of one direction that are linked, or are wheels in mesh, are turned
    together about the first of them, so that they keep their relative positions.
    """
    coordinates = {body.name: (*body.moves, *body.turns) for body in piece.bodies}
    own = {body: tuple(directions[name]) for body, names in coordinates.items() for name in names if name in directions}
    for link in piece.links:
        for one, other in ((link.start, link.end), (link.end, link.start)):
            if coordinates[one] and one in own and not coordinates[other]:
                own[other] = own[one]
    pairs = [(link.start, link.end) for link in piece.links] + list(gears)
    pairs += [(body.name, name) for body in piece.bodies for name in body.turns]  # the further wheels of a body
    in_order = [body.name for body in piece.bodies if body.name in own]
    for names in groups(in_order, [pair for pair in pairs if len({own.get(name) for name in pair}) == 1]):
        moved = [body for body in piece.bodies if body.name in names and coordinates[body.name]]
        if moved:
            piece = _turned_together(piece, names, moved[0], own[moved[0].name])
    return piece


def _turned_together(piece: Piece, names: Collection[str], first: DrawnBody, direction: Sequence[float]) -> Piece:
    if first.moves:
        rotation = _frame(direction, None) @ _frame(next(iter(first.moves.values())), None).T
    else:
        rotation = _frame(None, direction) @ _frame(None, next(iter(first.turns.values()))).T
    middle = np.array(first.rest)
    bodies, links = list(piece.bodies), list(piece.links)
    for i, body in enumerate(bodies):
        if body.name in names:
            moves, turns = ({key: _tuple(rotation @ vector) for key, vector in own.items()} for own in (body.moves, body.turns))
            rest, rest_turn = middle + rotation @ (body.rest - middle), vector_of(rotation @ matrix_of(body.rest_turn))
            bodies[i] = replace(body, rest=_tuple(rest), rest_turn=_tuple(rest_turn), moves=moves, turns=turns)
    for i, link in enumerate(links):
        if link.start in names and link.end in names:
            offset, end_offset = (_tuple(rotation @ each) for each in (link.offset, link.end_offset))
            turn = _tuple(vector_of(rotation @ matrix_of(link.turn)))
            links[i] = replace(link, offset=offset, end_offset=end_offset, turn=turn)
    return Piece(tuple(bodies), tuple(links))


def direction_of(body: DrawnBody) -> np.ndarray:
    """The unit vector along which a body is displaced by its first coordinate, or about which that turns it."""
    return _unit(next(iter((*body.moves.values(), *body.turns.values()))))


def _frame(along: Sequence[float] | None, about: Sequence[float] | None) -> np.ndarray:
    """The rotation (3, 3) of a layout with these two directions; the identity without both."""
    if along is None and about is None:
        return np.eye(3)
    first = _unit(along) if along is not None else _across(ALONG, _unit(about))
    if about is not None:
        second = _unit(about)
    else:  # down stays down, unless the direction is steep
        second = _across(ABOUT, first) if abs(first[2]) > STEEP else np.cross(first, _across(UP, first))
    return np.column_stack([first, -second, np.cross(first, -second)])


def _tuple(vector: np.ndarray) -> Vector:
    return tuple((np.asarray(vector) + 0.0).tolist())


def _unit(vector) -> np.ndarray:
    vector = np.array(vector, dtype=float)
    return vector / np.linalg.norm(vector)


def _across(usual: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """The direction perpendicular to an axis that is nearest to the usual one, or to the vertical."""
    parts = (wanted - (wanted @ axis) * axis for wanted in (usual, UP))
    return _unit(next(part for part in parts if np.linalg.norm(part) > PARALLEL))


def displacement_scale(moves: dict[str, np.ndarray], pairs: Iterable[tuple[str, str]]) -> float:
    """Magnification of displacements."""
    zero = np.zeros(1)
    furthest = max((_peak(move) for move in moves.values()), default=0.0)
    both = ((moves.get(a, zero), moves.get(b, zero)) for a, b in pairs)  # of amplitudes the sum counts
    closest = max((_peak(a - b) if max(len(a), len(b)) > 1 else _peak(a) + _peak(b) for a, b in both), default=0.0)
    scales = [limit / size for limit, size in ((ABSOLUTE, furthest), (NEIGHBOURS, closest)) if size > SMALLEST_MOTION]
    return _rounded_down(min(scales, default=1.0))


def angle_scale(angles: Iterable[np.ndarray]) -> float:
    """Magnification of angles (T,): 1 unless all of them are too small to be visible."""
    largest = max(map(_peak, angles), default=0.0)
    return 1.0 if largest < SMALLEST_MOTION or largest >= VISIBLE_ANGLE else _rounded_down(WIDEST_ANGLE / largest)


def _peak(values: np.ndarray) -> float:
    return float(np.abs(values).max(initial=0.0))


def two_digits(number: float) -> float:
    """The next smaller number of two digits.

    >>> two_digits(0.7), two_digits(1.2345e-7), two_digits(99.9)
    (0.7, 1.2e-07, 99.0)
    """
    return _rounded_down(number, range(10, 100))


def _rounded_down(number: float, steps: Iterable[int] = (10, 15, 20, 30, 50, 70)) -> float:
    """The next smaller number of a step of two digits times a power of ten."""
    power = math.floor(math.log10(number)) - 1
    return float(f"{max(step for step in steps if step <= number / 10.0**power * (1 + noise_of(1.0)))}e{power}")
