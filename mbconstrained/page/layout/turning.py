"""How a drawing, or a part of it, is turned, so that its displacements go, and its angles turn, the way that is asked for."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..drawing import Body, Link, Vector
from ..rotation import matrix_of, vector_of
from .joints import groups
from .piece import Piece

#: The way of positive displacements in a layout, and the axis about which positive angles turn counter-clockwise.
ALONG, ABOUT = np.array([1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])

UP = np.array([0.0, 0.0, 1.0])

#: What rises by more than this for each unit of its way stands more than it lies.
STEEP = 0.8


def turn_to(along: Sequence[float] | None, about: Sequence[float] | None) -> Vector:
    """The rotation vector (rad) that turns a layout to these two directions, which are at right angles.

    Args:
        along: of positive displacements; None: as it is, as far as that is at right angles to the other.
        about: of the axis about which positive angles turn counter-clockwise; None likewise.

    >>> turn_to([0, 0, 2], None)
    (0.0, -1.5707963267948966, 0.0)
    >>> turn_to(None, None)
    (0.0, 0.0, 0.0)
    """
    return _plain(vector_of(_frame(along, about)))


def turned_pieces(pieces: Iterable[Piece], directions: Mapping[str, Sequence[float]], gears=()) -> list[Piece]:
    """Pieces in which bodies move along, or turn about, directions of their own.

    What holds a body to the ground is turned with it. Bodies of one direction that are linked, or are wheels in mesh, are
    turned together about the first of them, so that they keep their places to each other.

    Args:
        directions: by the name of a coordinate, of positive displacements, or of the axis about which positive angles turn
            counter-clockwise.
        gears: pairs of names of wheels in mesh.
    """
    return [_turned(piece, directions, gears) for piece in pieces] if directions else list(pieces)


def _turned(piece: Piece, directions: Mapping[str, Sequence[float]], gears) -> Piece:
    own = {body.name: tuple(directions[name]) for body in piece.bodies for name in _coordinates(body) if name in directions}
    held = {other: own[one] for link in piece.links for one, other in _both_ways(link) if one in own and other not in own}
    own |= {body.name: held[body.name] for body in piece.bodies if body.name in held and not _coordinates(body)}
    pairs = [(link.start, link.end) for link in piece.links] + list(gears)
    pairs += [(body.name, name) for body in piece.bodies for name in body.turns]  # the further wheels of a body
    joined = groups(own, [frozenset(pair) for pair in pairs if len({own.get(name) for name in pair}) == 1])
    for names in joined:
        moved = [body for body in piece.bodies if body.name in names and _coordinates(body)]
        if moved:
            piece = _turned_together(piece, names, moved[0], own[moved[0].name])
    return piece


def _turned_together(piece: Piece, names: Collection[str], first: Body, direction: Sequence[float]) -> Piece:
    name = _coordinates(first)[0]
    now, angle = (first.moves[name], False) if name in first.moves else (first.turns[name], True)
    wanted, usual = ((None, direction), (None, now)) if angle else ((direction, None), (now, None))
    rotation = _frame(*wanted) @ _frame(*usual).T
    middle = np.array(first.rest)
    bodies = [turned_body(body, rotation, middle) if body.name in names else body for body in piece.bodies]
    links = [_turned_link(link, rotation) if {link.start, link.end} <= {*names} else link for link in piece.links]
    return Piece(tuple(bodies), tuple(links))


def direction_of(body: Body) -> np.ndarray:
    """The unit vector along which a body is displaced by its first coordinate, or about which that turns it."""
    return _unit(next(iter((*body.moves.values(), *body.turns.values()))))


def turned_body(body: Body, rotation: np.ndarray, middle: np.ndarray) -> Body:
    """The body with its motion turned about a point."""
    rest_turn = vector_of(rotation @ matrix_of(body.rest_turn))
    rest = middle + rotation @ (np.array(body.rest) - middle)
    moves, turns = ({key: _plain(rotation @ vector) for key, vector in way.items()} for way in (body.moves, body.turns))
    return replace(body, rest=_plain(rest), rest_turn=_plain(rest_turn), moves=moves, turns=turns)


def _turned_link(link: Link, rotation: np.ndarray) -> Link:
    offset, end_offset = (_plain(rotation @ each) for each in (link.offset, link.end_offset))
    return replace(link, offset=offset, end_offset=end_offset, turn=_plain(vector_of(rotation @ matrix_of(link.turn))))


def _coordinates(body: Body) -> tuple[str, ...]:
    return (*body.moves, *body.turns)


def _both_ways(link: Link) -> tuple[tuple[str, str], tuple[str, str]]:
    return (link.start, link.end), (link.end, link.start)


def _frame(along: Sequence[float] | None, about: Sequence[float] | None) -> np.ndarray:
    """The rotation (3, 3) of a layout to these two directions; where both are left out, none."""
    if along is None and about is None:
        return np.eye(3)
    first = _unit(along) if along is not None else _across(ALONG, _unit(about))
    if about is not None:
        second = _unit(about)
    else:  # what is below stays below, unless it goes steeply
        second = _across(ABOUT, first) if abs(first[2]) > STEEP else np.cross(first, _across(UP, first))
    return np.column_stack([first, -second, np.cross(first, -second)])


def _plain(vector: np.ndarray) -> Vector:
    return tuple((np.asarray(vector) + 0.0).tolist())


def _unit(vector) -> np.ndarray:
    vector = np.array(vector, dtype=float)
    return vector / np.linalg.norm(vector)


def _across(usual: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """The direction at right angles to an axis that is nearest to the usual one; where that is the axis, another one."""
    for wanted in (usual, UP):
        part = wanted - (wanted @ axis) * axis
        if np.linalg.norm(part) > 1e-6:
            return _unit(part)
    raise AssertionError("two directions are never along one axis")
