"""The page of a sweep: each variant of a scene moves in the shape of its lowest oscillating mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ....page.mode_page import ModePicture, ModesContent, cycle
from .mode_pages import amplitude, mode_drawing, robot_modes
from .scene_modes import SceneModes

if TYPE_CHECKING:
    from ....page.content import PageContent
    from ..scene import Scene
    from .scene_modes import ModeLine

Facts = tuple[tuple[str, str], ...]


def variants_content(scenes: Sequence[tuple[str, Facts, Scene]], content: PageContent) -> ModesContent | None:
    """A page on which each variant of a scene moves in the shape of its lowest oscillating mode."""
    lines = [(name, facts, scene, _lowest(scene)) for name, facts, scene in scenes]
    moving = [(name, facts, scene, line) for name, facts, scene, line in lines if line is not None]
    names = moving[0][2].equations.coordinates.names if moving else ()
    if len(moving) < 2 or any(scene.equations.coordinates.names != names for _, _, scene, _ in moving):
        return None
    middle = len(moving) // 2
    robots = [robot_modes(scene) for _, _, scene, _ in moving]
    own = robots[middle]
    drawing = replace(own.drawing, posing=None) if own else mode_drawing(moving[middle][2], [line.shape for *_, line in moving])
    pictures = []
    for (name, facts, _, line), robot in zip(moving, robots):
        factor = robot.amplitude(line.shape) if robot else amplitude(drawing, names, line.shape)
        paths = robot.paths(line.shape, factor) if robot else {}
        pictures.append(ModePicture(name, facts, (), cycle(line.shape), paths, 2 * np.pi / line.value.imag, factor))
    return ModesContent(
        content.title,
        content.source,
        drawing,
        names,
        tuple(pictures),
        content.notices,
        content.facts,
        content.tables,
        content.figures,
        "variant",
    )


def _lowest(scene: Scene) -> ModeLine | None:
    """The oscillating mode of the lowest frequency."""
    lines = [line for line in SceneModes(scene).lines if line.shape is not None and line.value.imag > 0]
    return min(lines, key=lambda line: abs(line.value), default=None)
