"""Links as data for the page: where they meet their bodies, and how long they are over the whole motion."""

from __future__ import annotations

import math

import numpy as np

from .drawing import Body, Drawing, Link, Vector
from .poses import KeyPoses
from .rotation import matrix_of, quaternions_of

#: An end on the surface of its body is not out of it for the rounding of a turn, relative to the size.
ROUNDING = 1e-9

_UPWARDS = np.array([0.0, 0.0, 1.0])  # the way a rope leaves what hangs on it


def link_data(link: Link, drawing: Drawing, poses: dict[str, KeyPoses], posts: dict, unit: float) -> dict:
    """A link for the page; an end out of its body adds a post to those of the body."""
    index = {body.name: i for i, body in enumerate(drawing.bodies)}
    start, end, over = (None if name is None else drawing.bodies[index[name]] for name in (link.start, link.end, link.over))
    way = (poses[link.end].positions - poses[link.start].positions).mean(axis=1)
    leaving, arriving = (way, -way) if over is None else (_UPWARDS, _UPWARDS)
    start_point = link.start_point or _attachment(start, link.offset, leaving, posts)
    end_point = link.end_point or _attachment(end, link.end_offset, arriving, posts)
    from_start, from_end = _link_ends(link, poses, start_point, end_point)
    gap = matrix_of(link.turn).T @ (from_end - from_start) / unit
    lengths = np.linalg.norm(gap, axis=0)
    return {
        "kind": link.kind,
        "start": index[link.start],
        "end": index[link.end],
        "over": None if over is None else index[link.over],
        "start_point": list(start_point),
        "end_point": list(end_point),
        "start_turns": link.start_point is not None,
        "end_turns": link.end_point is not None,
        "mean": float(lengths.mean()),
        "shortest": float(lengths.min()),
        "longest": float(lengths.max()),
        "coaxial": bool(np.argmax(np.abs(gap[:, 0])) == 1),
        "radius": over.size[0] / 2 if over else 0.5,
        "turn": quaternions_of(np.array(link.turn)[:, None])[:, 0].tolist() if any(link.turn) else None,
    }


def outermost_ends(link: Link, poses: dict[str, KeyPoses]) -> tuple[np.ndarray, np.ndarray]:
    """Where both ends are, each (3, T), as far as they shift the bounds: not brought to the sides of the bodies."""
    return _link_ends(link, poses, link.start_point or link.offset, link.end_point or link.end_offset)


def _link_ends(link: Link, poses: dict[str, KeyPoses], start_point, end_point) -> tuple[np.ndarray, np.ndarray]:
    """Where both ends are, each (3, T): turned with the body where they are fixed in its frame."""
    return (
        _end(poses[link.start], start_point, link.start_point is not None),
        _end(poses[link.end], end_point, link.end_point is not None),
    )


def _end(poses: KeyPoses, point: Vector, turns: bool) -> np.ndarray:
    column = np.array(point, dtype=float)[:, None]
    return poses.of_points(column)[:, 0] if turns else poses.positions + column


def _attachment(body: Body, offset: Vector, towards: np.ndarray, posts: dict) -> list[float]:
    """Where the link meets the body, relative to its middle: on the side that faces the other end, or on a post."""
    if body.shape == "parts":
        return list(offset)
    frame = matrix_of(body.rest_turn)  # in which the body has its size and its posts
    point, towards = frame.T @ np.array(offset), frame.T @ towards
    if (np.abs(point) > np.array(body.size) / 2 * (1 + ROUNDING)).any():
        posts[body.name].append(point.tolist())
        return list(offset)
    axis = int(np.argmax(np.abs(towards)))
    if body.shape in ("box", "ground") or (body.shape in ("disc", "gear") and axis == 1):
        point[axis] += math.copysign(body.size[axis] / 2, towards[axis])
    return (frame @ point).tolist()
