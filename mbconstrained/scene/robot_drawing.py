"""The drawing of a robot: its links where its motion puts them, drawn large enough to be seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..page.content import Animation
from ..page.drawing import Drawing
from ..page.layout.magnification import VISIBLE_ANGLE
from ..page.layout.robot import robot_drawing
from ..page.parts import Part
from ..page.poses import rotated

if TYPE_CHECKING:
    from ..models.robot import Visual
    from .result import Result
    from .robot import RobotScene

#: The largest movement of a point of the robot that is drawn, as a share of the robot's size.
VISIBLE = 0.15

#: Largest angle that a drawing is made to show, in rad; what turns further is drawn as it is.
WIDEST_ANGLE = 2 * VISIBLE_ANGLE

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
    visuals = found.robot.visuals()
    scale = table.scale if table and "scale" in table.model_fields_set else visible_scale(found, visuals, values)
    return robot_drawing(
        visuals,
        found.robot.poses(found.posture, values, scale),
        found.robot.connection_points(found.posture),
        scale=scale,
        fixed=found.data.table.base == "fixed",
        note=(table.note if table else "") or NOTE,
    )


def visible_scale(found: RobotScene, visuals: Sequence[Visual], values: np.ndarray) -> float:
    """How much larger than true motion is drawn, at least 1: so that the point that moves furthest is seen to move.

    Args:
        found: the robot in its posture.
        visuals: of its links.
        values: deviations from the posture, shape (n, T).
    """
    turning = np.array([unit == "rad" for unit in found.coordinates.units])
    angle = np.abs(values[turning]).max(initial=0.0)
    extremes = values[:, np.unique(np.abs(values).argmax(axis=1))]
    moved = _points(found, visuals, np.hstack([np.zeros((len(values), 1)), extremes]))
    size = float(np.linalg.norm(np.ptp(moved[:, :, 0], axis=1)))
    furthest = float(np.linalg.norm(moved - moved[:, :, :1], axis=0).max(initial=0.0))
    limits = [limit / found for limit, found in ((VISIBLE * size, furthest), (WIDEST_ANGLE, angle)) if limit and found]
    return max(1.0, float(f"{min(limits, default=1.0):.2g}"))


def _points(found: RobotScene, visuals: Sequence[Visual], values: np.ndarray) -> np.ndarray:
    """Corners of boxes around the visuals and origins of the links, shape (3, k, T)."""
    corners = {name: [np.zeros((3, 1))] for name in found.robot.bodies}
    for visual in visuals:
        size = () if visual.kind == "mesh" else visual.size
        part = Part(visual.kind, size, visual.placement, vertices=visual.vertices, faces=visual.faces)
        corners[visual.link].append(part.corners)
    poses = found.robot.poses(found.posture, values)
    placed = [pose.positions[:, None] + rotated(pose.quaternions, np.hstack(corners[name])) for name, pose in poses.items()]
    return np.hstack(placed)
