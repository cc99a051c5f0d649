"""A piece of a drawing: bodies and links that keep their places to each other, to be put somewhere as a whole."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..drawing import Body, Link, Vector


@dataclass(frozen=True)
class Piece:
    """Bodies and links around an origin of their own."""

    bodies: tuple[Body, ...]
    links: tuple[Link, ...] = ()

    def place(self, name: str) -> np.ndarray:
        """Where a body rests, shape (3,)."""
        return np.array(self.body(name).rest)

    def body(self, name: str) -> Body:
        """The body of this name."""
        return next(body for body in self.bodies if body.name == name)

    @property
    def names(self) -> frozenset[str]:
        """Names of the bodies."""
        return frozenset(body.name for body in self.bodies)

    @property
    def low(self) -> np.ndarray:
        """The corner with the smallest coordinates of a box around it, shape (3,)."""
        return self._corners()[0]

    @property
    def high(self) -> np.ndarray:
        """The corner with the largest coordinates of a box around it, shape (3,)."""
        return self._corners()[1]

    def _corners(self) -> tuple[np.ndarray, np.ndarray]:
        places = np.array([body.rest for body in self.bodies])
        halves = np.array([body.half_extent for body in self.bodies])
        own = {body.name: np.array(body.rest) for body in self.bodies}
        ends = [own[link.end] + link.end_offset for link in self.links] + [own[link.start] + link.offset for link in self.links]
        points = np.vstack([places - halves, places + halves, *ends])
        return points.min(axis=0), points.max(axis=0)

    def shifted(self, shift) -> Piece:
        """The piece somewhere else."""
        return replace(self, bodies=tuple(replace(body, rest=tuple(body.rest + np.array(shift))) for body in self.bodies))

    def hanging(self) -> Piece:
        """The piece turned so that what went to the right hangs down; coordinates are positive upwards then."""
        turned = []
        for body in self.bodies:
            moves = {name: _downwards(np.negative(vector)) for name, vector in body.moves.items()}
            size = tuple(abs(value) for value in _downwards(body.size))
            turned.append(replace(body, rest=_downwards(body.rest), moves=moves, size=size))
        links = (
            replace(link, offset=_downwards(link.offset), end_offset=_downwards(link.end_offset)) for link in self.links
        )
        return Piece(tuple(turned), tuple(links))


def _downwards(vector) -> Vector:
    x, y, z = vector
    return (z, y, -x)
