"""A robot as it is drawn: its parts, read once, and how much of a motion there is room for."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..page.drawing import Drawing
from ..page.layout.magnification import two_digits
from ..page.layout.robot import parts_of, robot_drawing
from ..page.layout.robot_points import link_points, robot_size
from .robot_urdf import in_urdf

if TYPE_CHECKING:
    from ..models.robot.poses import Poses
    from .robot import RobotScene

#: Largest drawn displacement of a point of the robot, as a share of the robot's size.
VISIBLE = 0.15

#: Largest drawn angle of a joint, rad: seen well, and loops can still be closed.
TURN = 0.25

#: Largest entry of a motion so small that it is straight.
SMALL = 1e-4


class RobotPicture:
    """A robot in its posture, to be drawn.

    Attributes:
        scene: the robot with its posture and system.
        parts: what its links are drawn with, by name.

    Raises:
        SceneError: a shape or a mesh file that cannot be drawn; names the URDF.
    """

    def __init__(self, scene: RobotScene):
        self.scene = scene
        with in_urdf(scene.data.urdf_place):
            self.parts = parts_of(scene.robot.visuals())

    def poses(self, values: np.ndarray, scale: float = 1.0) -> dict[str, Poses]:
        """Of all links, for deviations (n, T) from the posture, so much larger than true."""
        return self.scene.robot.poses(self.scene.posture, values, scale)

    def drawing(self, poses: dict[str, Poses], scale: float = 1.0, note: str = "") -> Drawing:
        """The robot with these poses as its paths, which are so much larger than true."""
        points = self.scene.robot.connection_points(self.scene.posture)
        fixed = self.scene.data.table.base == "fixed"
        return robot_drawing(self.parts, poses, points, scale=scale, fixed=fixed, note=note)

    @cached_property
    def at_rest(self) -> dict[str, Poses]:
        """The poses of the posture."""
        return self.poses(np.zeros((len(self.scene.robot.coordinates), 1)))

    @cached_property
    def _points(self) -> np.ndarray:
        """All points at rest, shape (3, k, 1)."""
        return self._of(self.at_rest)

    @property
    def size(self) -> float:
        """Diagonal of a box around all links (m)."""
        return robot_size({"all": self._points})

    def room(self, values: np.ndarray) -> float:
        """How much larger than true a motion may be drawn: no joint turns, and no point moves, too far to look right.

        The number has two digits; it is 1 where nothing moves. Motors are not drawn and do not count.

        Args:
            values: deviations, shape (n, T); how far points move is looked at in a straight motion of their directions.
        """
        links = values[: len(self.scene.robot.coordinates)]
        turning = np.array([unit == "rad" for unit in self.scene.robot.units], dtype=bool)
        angle = float(np.abs(links[turning]).max(initial=0.0))
        limits = ((VISIBLE * self.size, self._reach(links)), (TURN, angle))
        return two_digits(min((limit / found for limit, found in limits if found), default=1.0))

    def _reach(self, links: np.ndarray) -> float:
        """How far the point that moves furthest goes (m)."""
        largest = np.abs(links).max(initial=0.0)
        if not largest:
            return 0.0
        steps = self._of(self.poses(links / largest, SMALL)) - self._points
        return float(np.linalg.norm(steps, axis=0).max() / SMALL * largest)

    def _of(self, poses: dict[str, Poses]) -> np.ndarray:
        return np.hstack(list(link_points(self.parts, poses).values()))
