"""The drawing of a robot: its links where their motion puts them, drawn large enough to be seen."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..page.content import Animation
from ..page.drawing import Drawing
from .robot_picture import RobotPicture

if TYPE_CHECKING:
    from .result import Result
    from .robot import RobotScene

NOTE = "small motions about the equilibrium"

#: Poses that are computed: loops are closed for each, and the page interpolates between them by cubic polynomials.
MOST_POSES = 1_000


def robot_animation(result: Result) -> Animation:
    """The robot with the motion of its coordinates, at no more than ``MOST_POSES`` times."""
    count = len(result.times)
    kept = np.unique(np.linspace(0, count - 1, min(count, MOST_POSES)).round().astype(int))
    scene, values, rates = result.scene, result.values[:, kept], result.curves("velocity").values[:, kept]
    drawing = drawing_of_robot(scene.equations.robot_scene, values, scene.table.drawing)
    return Animation(drawing, scene.equations.coordinates.names, result.times[kept], values, rates)


def drawing_of_robot(found: RobotScene, values: np.ndarray, table=None) -> Drawing:
    """A drawing of the robot with the paths of its links.

    Args:
        found: the robot in its posture.
        values: deviations from it, shape (n, T).
        table: the [drawing] table with a scale and a note of its own, or None.
    """
    picture = RobotPicture(found)
    scale = table.scale if table and "scale" in table.model_fields_set else visible_scale(picture, values)
    return picture.drawing(picture.poses(values, scale), scale, (table.note if table else "") or NOTE)


def visible_scale(picture: RobotPicture, values: np.ndarray) -> float:
    """How much larger than true motion is drawn, at least 1: so that the point that moves furthest is seen to move.

    Args:
        picture: the robot in its posture.
        values: deviations from the posture, shape (n, T).
    """
    extremes = values[:, np.unique(np.abs(values).argmax(axis=1))]
    return max(1.0, picture.room(extremes))
