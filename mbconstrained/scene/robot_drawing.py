"""The drawing of a robot: its links where their motion puts them, drawn large enough to be seen."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..page.content import Animation
from ..page.drawing import Drawing
from ..page.marks import Moment
from ..page.path import Path
from .drawing import view_of
from .frames import ROUNDING, frames_of
from .marks import marks_of
from .robot_picture import RobotPicture

if TYPE_CHECKING:
    from .result import Result

NOTE = "small motions about the equilibrium"

#: Poses that are computed: loops are closed for each, and the page interpolates between them by cubic polynomials.
MOST_POSES = 1_000


def robot_animation(result: Result) -> Animation:
    """The robot with the motion of its coordinates, at no more than ``MOST_POSES`` times."""
    times, values, rates = frames_of(result, MOST_POSES)
    kept = np.unique(np.linspace(0, len(times) - 1, min(len(times), MOST_POSES)).round().astype(int))
    scene, picture = result.scene, RobotPicture(result.scene.equations.robot_scene)
    drawing = drawing_of_robot(picture, values[:, kept], scene.table.drawing)
    marks = marks_of(result, drawing, times[kept])
    marks = replace(marks, moments=tuple(_with_paths(moment, picture, drawing.scale) for moment in marks.moments))
    return Animation(drawing, scene.equations.coordinates.names, times[kept], values[:, kept], rates[:, kept], marks)


def _with_paths(moment: Moment, picture: RobotPicture, scale: float) -> Moment:
    """The moment with the poses of the links just before and just after it, where they are not the same."""
    values = np.column_stack([moment.before, moment.after])
    if np.ptp(values, axis=1).max(initial=0.0) <= ROUNDING * np.abs(values).max(initial=0.0):
        return moment
    poses = picture.poses(values, scale)
    return replace(moment, paths={name: Path(pose.positions, pose.quaternions) for name, pose in poses.items()})


def drawing_of_robot(picture: RobotPicture, values: np.ndarray, table=None) -> Drawing:
    """A drawing of the robot with the paths of its links.

    Args:
        picture: the robot in its posture.
        values: deviations from it, shape (n, T).
        table: the [drawing] table with a scale, a view and a note of its own, or None.
    """
    scale = table.scale if table and "scale" in table.model_fields_set else visible_scale(picture, values)
    drawing = picture.drawing(picture.poses(values, scale), scale, (table.note if table else "") or NOTE)
    return replace(drawing, view=view_of(table))


def visible_scale(picture: RobotPicture, values: np.ndarray) -> float:
    """How much larger than true motion is drawn, at least 1: so that the point that moves furthest is seen to move.

    Args:
        picture: the robot in its posture.
        values: deviations from the posture, shape (n, T).
    """
    extremes = values[:, np.unique(np.abs(values).argmax(axis=1))]
    return max(1.0, picture.room(extremes))
