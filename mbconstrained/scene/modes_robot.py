"""A robot on a page of modes: its drawing at rest, and the paths of its links in a mode."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..page.drawing import Drawing
from ..page.layout.robot import robot_drawing
from ..page.mode_content import cycle
from ..page.path import Path
from .modes_drawing import two_digits

if TYPE_CHECKING:
    from ..models.robot import Posture

#: Largest drawn angle of a joint, rad: seen well, and loops can still be closed.
TURN = 0.25

#: Largest drawn displacement of a link, as a share of the robot's extent.
REACH = 0.12

#: Of a motion so small, relative to its largest entry, that it is straight.
SMALL = 1e-4


class RobotPictures:
    """A robot in its posture, for pictures of its modes.

    Attributes:
        drawing: the robot at rest.
    """

    def __init__(self, posture: Posture, units: tuple[str, ...], note: str = ""):
        self.posture = posture
        self.robot = posture.robot
        self.turning = np.array([unit == "rad" for unit in units])
        self._rest = self.robot.poses(posture, np.zeros((len(units), 1)))
        self.drawing: Drawing = robot_drawing(
            self.robot.visuals(),
            self._rest,
            self.robot.connection_points(posture),
            fixed="base" not in self.robot.joints,
            note=note,
        )

    def amplitude(self, shape: np.ndarray) -> float:
        """The factor at which a shape is drawn: no joint turns, and no link moves, too far to look right."""
        turn = np.abs(shape[self.turning]).max(initial=0.0)
        limits = ((TURN, turn), (REACH * self._extent, self._reach(shape)))
        return two_digits(min((limit / size for limit, size in limits if size and limit), default=1.0))

    def paths(self, shape: np.ndarray, factor: float) -> dict[str, Path]:
        """The poses of all links over one cycle."""
        found = self.robot.poses(self.posture, cycle(shape), factor)
        return {name: Path(poses.positions, poses.quaternions) for name, poses in found.items()}

    @property
    def _extent(self) -> float:
        """Of the box in which the origins of the links lie (m)."""
        return float(np.linalg.norm(np.ptp([poses.positions[:, 0] for poses in self._rest.values()], axis=0)))

    def _reach(self, shape: np.ndarray) -> float:
        """How far the origin of a link moves in the shape (m)."""
        moved = self.robot.poses(self.posture, cycle(shape, 5), SMALL)
        steps = [moved[name].positions - self._rest[name].positions for name in moved]
        return max(float(np.linalg.norm(step, axis=0).max()) for step in steps) / SMALL
