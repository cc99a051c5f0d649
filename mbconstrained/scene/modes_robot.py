"""A robot on a page of modes: its drawing at rest, and the paths of its links in a mode."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..page.drawing import View
from ..page.mode_content import cycle
from ..page.path import Path
from ..tolerances import noise_of
from .robot_picture import RobotPicture

if TYPE_CHECKING:
    from .robot import RobotScene

#: Parts of a cycle at which it is looked how far points move; between them they go 8 % further at most.
PARTS = 8


class RobotModes:
    """A robot in its posture, for pictures of its modes.

    Attributes:
        drawing: the robot at rest.
    """

    def __init__(self, scene: RobotScene, note: str = "", view: View | None = None):
        self.picture = RobotPicture(scene)
        self.drawing = replace(self.picture.drawing(self.picture.at_rest, note=note), view=view)

    def amplitude(self, shape: np.ndarray) -> float:
        """The factor at which a shape, whose amplitude is free, is drawn."""
        return self.picture.room(cycle(_clean(shape), PARTS + 1))

    def paths(self, shape: np.ndarray, factor: float) -> dict[str, Path]:
        """The poses of all links over one cycle."""
        found = self.picture.poses(cycle(_clean(shape)), factor)
        return {name: Path(poses.positions, poses.quaternions) for name, poses in found.items()}


def _clean(shape: np.ndarray) -> np.ndarray:
    """Without entries that are rounding, which would be seen where motors move and links hardly do."""
    return np.where(np.abs(shape) > noise_of(1.0, len(shape)), shape, 0.0)
