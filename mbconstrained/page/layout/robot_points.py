"""Where the points of a robot are: origins of its links and corners of boxes around what they are drawn with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..parts import Part
from ..rotation import rotated


def link_points(parts: Mapping[str, Sequence[Part]], poses: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The origin of each link, then the corners of its parts, shape (3, k, T), by link name.

    Args:
        parts: of the links that have any, by name.
        poses: by name, positions (3, T) and quaternions (4, T).
    """
    return {name: _placed(parts.get(name, ()), pose) for name, pose in poses.items()}


def robot_size(points: Mapping[str, np.ndarray]) -> float:
    """Diagonal of a box around all points at the first time; 1 for what is a single point.

    >>> robot_size({"arm": np.array([[0.0, 3.0], [0.0, 0.0], [0.0, 4.0]])[:, :, None]})
    5.0
    """
    first = np.hstack([block[:, :, 0] for block in points.values()] or [np.zeros((3, 1))])
    return float(np.linalg.norm(np.ptp(first, axis=1))) or 1.0


def _placed(parts: Sequence[Part], pose) -> np.ndarray:
    corners = np.hstack([np.zeros((3, 1)), *(part.corners for part in parts)])
    return pose.positions[:, None] + rotated(pose.quaternions, corners)
