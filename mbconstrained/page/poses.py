"""Where bodies are and how they are turned at key frames: by their paths, or by the coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .drawing import Body, Drawing
from .keyframes import KeyFrames
from .rotation import after, quaternions_of, rotated


@dataclass(frozen=True, eq=False)
class KeyPoses:
    """Positions (3, T) and unit quaternions (4, T), x y z w, at all key frames."""

    positions: np.ndarray
    quaternions: np.ndarray

    @property
    def first(self) -> KeyPoses:
        """The first of them alone."""
        return KeyPoses(self.positions[:, :1], self.quaternions[:, :1])

    def of_points(self, points: np.ndarray) -> np.ndarray:
        """Where points (3, k) that are fixed in the body's frame are, shape (3, k, T)."""
        return self.positions[:, None] + rotated(self.quaternions, np.asarray(points, dtype=float))


def body_poses(drawing: Drawing, takes: tuple[KeyFrames, ...], number: int) -> KeyPoses:
    """All poses of the body of this number, one take after the other."""
    each = [_poses(drawing, drawing.bodies[number], frames, number) for frames in takes]
    return KeyPoses(*(np.hstack(rows) for rows in zip(*each)))


def _poses(drawing: Drawing, body: Body, frames: KeyFrames, number: int) -> tuple[np.ndarray, np.ndarray]:
    path, count = frames.paths[number], len(frames.times)
    if path is not None:
        still = np.zeros(count, dtype=int) if path.count == 1 else slice(None)
        return path.positions[:, still], path.quaternions[:, still]
    turns = np.zeros((3, count))
    for name, row in zip(frames.names, frames.values):
        if name in body.turns:
            turns += drawing.turn_scale * np.outer(body.turns[name], row)
    at_rest = quaternions_of(np.array(body.rest_turn)[:, None])
    return drawing.positions(body, frames.names, frames.values), after(quaternions_of(turns), at_rest + np.zeros((4, count)))
