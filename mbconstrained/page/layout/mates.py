"""Pieces put together: where one body of a piece stands decides where another piece goes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from .piece import Piece


@dataclass(frozen=True)
class Mate:
    """Body ``other`` stands at this shift from body ``one``; both are of different pieces."""

    one: str
    other: str
    shift: tuple[float, float, float]


def assembled(pieces: Iterable[Piece], mates: Iterable[Mate]) -> list[Piece]:
    """The pieces that mates connect as one piece each; a mate of bodies that already have their places changes nothing."""
    waiting, mates = list(pieces), list(mates)
    done = []
    while waiting:
        whole = waiting.pop(0)
        while found := _next(whole, waiting, mates):
            part, shift = found
            waiting.remove(part)
            moved = part.shifted(shift)
            whole = Piece((*whole.bodies, *moved.bodies), (*whole.links, *moved.links))
        done.append(whole)
    return done


def _next(whole: Piece, waiting: list[Piece], mates: list[Mate]) -> tuple[Piece, np.ndarray] | None:
    """A waiting piece that a mate ties to the whole, and the shift that puts it there."""
    for mate in mates:
        for one, other, sign in ((mate.one, mate.other, 1), (mate.other, mate.one, -1)):
            for part in waiting:
                if one in whole.names and other in part.names:
                    return part, whole.place(one) + sign * np.array(mate.shift) - part.place(other)
    return None


def stacked(pieces: list[Piece], gap: float = 0.7) -> Piece:
    """Pieces that move sideways below each other, in several columns when there are many; others beside each other."""
    rows = max(6, math.ceil(1.3 * math.sqrt(len(pieces))))
    hanging = [piece for piece in pieces if _moves_upwards(piece)]
    lying = [piece for piece in pieces if not _moves_upwards(piece)]
    columns = [lying[begin : begin + rows] for begin in range(0, len(lying), rows)] + [[piece] for piece in hanging]
    bodies, links, left = [], [], 0.0
    for column in columns:
        top, right = 0.0, left
        for piece in column:
            moved = piece.shifted((left - piece.low[0], 0.0, top - piece.high[2]))
            top, right = moved.low[2] - gap, max(right, moved.high[0])
            bodies += moved.bodies
            links += moved.links
        left = right + 2 * gap
    return Piece(tuple(bodies), tuple(links))


def _moves_upwards(piece: Piece) -> bool:
    return any(move[2] for body in piece.bodies for move in body.moves.values())
