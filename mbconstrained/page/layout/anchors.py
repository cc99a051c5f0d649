"""How a turning body is tied to the ground: a wall behind its shaft, or blocks around it."""

from __future__ import annotations

import numpy as np

from ..drawing import Body, Link
from .joints import Joint
from .piece import Piece
from .toothing import THICKNESS

WALL_DISTANCE = 1.3


def wall_behind(body: Body, joints: list[Joint]) -> Piece:
    """Springs and dampers around the shaft, from a wall behind the body."""
    wall = Body(f"ground behind {body.name}", "ground", _beside(body, y=WALL_DISTANCE), size=(1.3, 0.16, 1.3))
    return Piece((wall,), tuple(Link(joint.name, joint.kind, wall.name, body.name) for joint in joints))


def blocks_around(body: Body, joints: list[Joint], up: int) -> Piece:
    """Springs as spirals in front of the body, held by studs from below (up = -1) or above; dampers as brakes on its rim."""
    bodies, links = [], []
    brakes = [joint for joint in joints if joint.kind == "torsion damper"]
    springs = [joint for joint in joints if joint not in brakes]
    radius = body.size[0] / 2
    if springs:
        bodies.append(Body(f"ground at {body.name}", "ground", _beside(body, z=up * (radius + 0.45)), size=(0.7, 0.9, 0.2)))
    for i, joint in enumerate(springs):
        front = -THICKNESS / 2 - 0.13 * (i + 1)
        stud = (0.0, front, -up * (0.28 * radius + 0.45))
        links.append(Link(joint.name, joint.kind, bodies[0].name, body.name, stud, (0.0, front, 0.0)))
    for side, joint in zip((-1, 1, -1, 1), brakes):
        block = f"ground of {joint.name}"
        bodies.append(Body(block, "ground", _beside(body, x=side * (radius + 0.7)), size=(0.18, 0.5, 0.6)))
        links.append(Link(joint.name, joint.kind, block, body.name, end_offset=(side * radius, 0.0, 0.0)))
    return Piece(tuple(bodies), tuple(links))


def _beside(body: Body, *, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> tuple:
    return tuple(np.array(body.rest) + (x, y, z))
