"""The animation of a result: a drawing, the key frames of the motion, and the overlay of jumps, impulses and reactions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ....page.animation.animation import Animation
from ....page.animation.keyframes import MOST_FRAMES
from ..curves import visible
from .arrows import overlay_of
from .scene_drawing import drawing_of

if TYPE_CHECKING:
    from ..answer import SceneAnswer

#: Most poses of a robot: each closes its loops, and the page interpolates between poses by cubic polynomials.
MOST_POSES = 1_000

#: Key frames in a period of the fastest visible motion.
FRAMES = 20

#: Relative error of cubic interpolation of a cosine between so many key frames, which is invisible.
ERROR = (2 * np.pi / FRAMES) ** 4 / 384

#: Intervals between key frames that are checked, and the share of them that may be wrong: those next to a jump or a kink always are.
CHECKED, KINKS = 128, 0.05

#: Most numbers in the key frames of a page.
MOST_NUMBERS = 400_000


def animation_of(result: SceneAnswer) -> Animation:
    """The drawing with the motion of the coordinates; a robot moves through at most ``MOST_POSES`` poses."""
    equations, table = result.scene.equations, result.scene.table.drawing
    if equations.robot_scene is not None:
        from .robot_drawing import RobotPicture, drawing_of_robot, event_with_poses

        times, values, rates = frames_of(result, MOST_POSES)
        kept = np.unique(np.linspace(0, len(times) - 1, min(len(times), MOST_POSES)).round().astype(int))
        frames = times[kept], values[:, kept], rates[:, kept]
        picture = RobotPicture(equations.robot_scene, table)
        drawing = drawing_of_robot(picture, frames[1], table)
        overlay = overlay_of(result, drawing, frames[0])
        overlay = replace(overlay, events=tuple(event_with_poses(event, picture, drawing.scale) for event in overlay.events))
        return Animation(drawing, equations.coordinates.names, *frames, overlay)
    scales = {key: getattr(table, key) for key in ("scale", "turn_scale") if table and key in table.model_fields_set}
    drawing, frames = drawing_of(result.scene, result.values, **scales), frames_of(result, MOST_FRAMES)
    return Animation(drawing, equations.coordinates.names, *frames, overlay_of(result, drawing, frames[0]))


def frames_of(result: SceneAnswer, most: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Key frames: those of the scene, or more where cubic polynomials between these deviate from the motion."""
    times, values = result.times, result.values
    rates = result.curves("velocity").values
    most = min(most, MOST_NUMBERS // max(1, len(values)))
    scale = visible(values, result.scene.equations.coordinates.units)
    at, rate = result.motion, result.motion.derivative(1)
    while len(times) < most and _misses(times, values, rates, at, scale):
        times = np.linspace(times[0], times[-1], min(2 * len(times) - 1, most))
        values, rates = at(times), rate(times)
    return times, values, rates


def _misses(times, values, rates, at: Callable[[np.ndarray], np.ndarray], scale: np.ndarray) -> bool:
    """Whether cubic polynomials between the key frames deviate from the motion halfway between them."""
    left = np.unique(np.linspace(0, len(times) - 2, CHECKED).round().astype(int))
    right, length = left + 1, np.diff(times)[left]
    middle = (values[:, left] + values[:, right]) / 2 + length * (rates[:, left] - rates[:, right]) / 8
    wrong = np.abs(at(times[left] + length / 2) - middle) > ERROR * scale
    return np.mean(wrong.any(axis=0)) > KINKS
