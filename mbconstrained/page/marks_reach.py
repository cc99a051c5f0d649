"""How far arrows reach, so that the picture has room for them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from .drawing import Drawing
from .keyframes import KeyFrames
from .marks import Arrow, Marks
from .marks_data import LONGEST, largest_forces, largest_strikes, moment_frames
from .poses import KeyPoses, body_poses
from .rotation import quaternions_of, rotated

#: Radius of the arrow around an axis that stands for a moment, with its head, in drawing units.
AROUND = 0.75


def with_arrows(bounds: Mapping, marks: Marks, drawing: Drawing, frames: KeyFrames, unit: float) -> dict:
    """The bounds of a picture with all that its arrows reach at key frames, in drawing units.

    Args:
        bounds: "low" and "high", three numbers each.
        unit: length of a drawing unit in the drawing.
    """
    turn = quaternions_of(np.array(drawing.turn)[:, None])
    blocks = [rotated(turn, points)[:, :, 0] for points in _points(marks, drawing, frames, unit)]
    points = np.column_stack([bounds["low"], bounds["high"], *blocks])
    return {**bounds, "low": points.min(axis=1).tolist(), "high": points.max(axis=1).tolist()}


def _points(marks: Marks, drawing: Drawing, frames: KeyFrames, unit: float) -> Iterator[np.ndarray]:
    """What each arrow reaches, shape (3, k)."""
    numbers = {body.name: i for i, body in enumerate(drawing.bodies)}
    largest = largest_forces(marks.forces)
    for force in marks.forces:
        first = frames.names.index(force.names[0])
        values = frames.values[first : first + len(force.names)]
        for arrow, factor in force.arrows:
            poses = body_poses(drawing, (frames,), numbers[arrow.body])
            yield _reached(arrow, poses, factor * values * LONGEST / (largest[arrow.unit] or 1.0), unit)
    struck = largest_strikes(marks.moments)
    for moment in marks.moments:
        pair = moment_frames(drawing, frames, moment)
        for arrow, size, _ in moment.strikes:
            poses = body_poses(drawing, (pair,), numbers[arrow.body])
            values = np.repeat(np.reshape(size, (-1, 1)), 2, axis=1) * LONGEST / (struck[arrow.unit] or 1.0)
            yield _reached(arrow, poses, values, unit)


def _reached(arrow: Arrow, poses: KeyPoses, values: np.ndarray, unit: float) -> np.ndarray:
    """The tips of a force with values (1, T) or (3, T) in drawing units; the corners of a box around a moment."""
    places = poses.of_points(np.array(arrow.point)[:, None])[:, 0] / unit
    if arrow.turns:
        return (places[:, :, None] + AROUND * np.array([-1.0, 1.0])).reshape(3, -1)
    if arrow.direction is not None:
        return places + np.array(arrow.direction)[:, None] / np.linalg.norm(arrow.direction) * values
    return places + np.einsum("ikt,kt->it", rotated(poses.quaternions, np.eye(3)), values)
