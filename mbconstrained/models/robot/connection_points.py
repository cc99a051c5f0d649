"""Where loops and springs are fixed, in the frames of the links: for pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from .connections import BodySpring, Connection, Loop
from .kinematics import Anchor

if TYPE_CHECKING:
    from .posture import Posture


@dataclass(frozen=True)
class ConnectionPoints:
    """The two ends of a loop or spring.

    Attributes:
        name: of the loop or spring.
        kind: what it is; a spring with a damper beside it is listed as each of the two.
        body1, point1, body2, point2: links, or "ground", with points in their frames (m), shape (3,).
    """

    name: str
    kind: Literal["loop", "spring", "damper", "bushing"]
    body1: str
    point1: np.ndarray
    body2: str
    point2: np.ndarray


def connection_points(posture: Posture) -> tuple[ConnectionPoints, ...]:
    """The ends of all loops, then of all springs."""
    load, found = posture.balance.load, []
    for item in (*load.loops, *load.springs):
        connection = item.connection
        ends = [
            _in_link(posture, body, anchor) for body, anchor in ((connection.body1, item.first), (connection.body2, item.second))
        ]
        found += [
            ConnectionPoints(connection.name, kind, connection.body1, ends[0], connection.body2, ends[1])
            for kind in _kinds(connection)
        ]
    return tuple(found)


def _in_link(posture: Posture, body: str, anchor: Anchor) -> np.ndarray:
    """The anchor's point in the frame of the link instead of that of its joint."""
    link = posture.robot.link_frames.link(body)
    return link.rotation.T @ (anchor.point - link.point)


def _kinds(connection: Connection) -> tuple[str, ...]:
    if isinstance(connection, Loop):
        return ("loop",)
    if isinstance(connection, BodySpring):
        return ("spring",) * bool(connection.stiffness or not connection.damping) + ("damper",) * bool(connection.damping)
    return ("bushing",)
