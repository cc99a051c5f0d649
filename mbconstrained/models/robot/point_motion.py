"""A direction of motion of a point of a robot: an output to be seen, or an input to be pushed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...checks import real_array
from ...errors import InputError


@dataclass(frozen=True)
class PointMotion:
    """The displacement of a point of a body along a direction that is fixed in space, or its rotation about it.

    As an output it is that displacement (m) or small rotation (rad), as an input the force (N) or torque (N m) that works
    along it, which keeps its direction while the body turns.

    Attributes:
        body: a link.
        point: in the link's frame (m).
        along: the direction, in the directions of the ground; of any length but zero.
        turn: whether rotation and torque are meant.

    >>> PointMotion("tip", along=(0, 0, 2)).along
    (0.0, 0.0, 1.0)
    """

    body: str
    point: Sequence[float] = (0.0, 0.0, 0.0)
    along: Sequence[float] = (1.0, 0.0, 0.0)
    turn: bool = False

    def __post_init__(self):
        if not isinstance(self.body, str):
            raise InputError(f"point: found the body {self.body!r}; expected the name of a link")
        if not isinstance(self.turn, bool):
            raise InputError(f'point of "{self.body}": turn: found {self.turn!r}; expected True or False')
        where = f'point of "{self.body}"'
        point = real_array(self.point, f"{where}: point", shape=(3,))
        along = real_array(self.along, f"{where}: along", shape=(3,))
        length = np.linalg.norm(along)
        if not 0 < length < np.inf:
            raise InputError(f"{where}: along: found {self.along}; expected a direction")
        object.__setattr__(self, "point", tuple(point.tolist()))
        object.__setattr__(self, "along", tuple((along / length).tolist()))
