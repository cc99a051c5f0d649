"""What moves on a page of modes: a drawing for all of them, and for each an amplitude at which it is seen and looks right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..page.drawing import Drawing
from ..page.layout.magnification import ABSOLUTE, NEIGHBOURS, WIDEST_ANGLE, two_digits
from ..page.mode_content import cycle
from ..page.path import Path
from ..tolerances import noise_of
from .drawing import automatic_drawing, own_drawing

if TYPE_CHECKING:
    from ..models.elements import Element
    from .scene import Scene

LENGTHS = ("rest_length", "rest_angle", "distance", "value")


class DrawnModes:
    """A drawing that the coordinates move, for pictures of modes.

    Attributes:
        drawing: at rest.
    """

    def __init__(self, scene: Scene, shapes: Sequence[np.ndarray]):
        self.names = scene.equations.coordinates.names
        self.drawing = mode_drawing(scene, shapes)

    def amplitude(self, shape: np.ndarray) -> float:
        """The factor at which a shape is drawn, besides the magnification of the drawing."""
        return amplitude(self.drawing, self.names, shape)

    def paths(self, shape: np.ndarray, factor: float) -> dict[str, Path]:
        """None: all bodies are moved by coordinates."""
        return {}


def mode_drawing(scene: Scene, shapes: Sequence[np.ndarray]) -> Drawing:
    """The drawing of the scene, its own or one made from its elements or coordinates, as on the page of a run.

    Modes are motions about the state in which every spring has its length: rest lengths only shift them and are left out.
    """
    equations = scene.equations
    values = _typical_values(shapes, equations.coordinates.units)
    elements = None if equations.model is None else [_at_rest(element) for element in equations.model.elements]
    return own_drawing(scene) or automatic_drawing(scene, elements, values)


def _at_rest(element: Element) -> Element:
    return replace(element, **{key: 0.0 for key in LENGTHS if getattr(element, key, None)})


def _typical_values(shapes: Sequence[np.ndarray], units: Sequence[str]) -> np.ndarray:
    """Cycles by which displacements and angles are magnified: of all shapes, or of the typical one that has both."""
    turning = np.array([unit == "rad" for unit in units], dtype=bool)
    both = [shape for shape in shapes if min(_largest(shape[turning]), _largest(shape[~turning])) > noise_of(1.0, len(shape))]
    if both:
        turned = [WIDEST_ANGLE / _largest(shape[turning]) * shape for shape in both]
        turned.sort(key=lambda shape: _largest(shape[~turning]))
        return cycle(turned[(len(turned) - 1) // 2])  # at the largest angle drawn it moves neither far nor hardly
    return np.hstack([cycle(shape) for shape in shapes] or [np.zeros((len(units), 1))])


def _largest(entries: np.ndarray) -> float:
    return float(np.abs(entries).max(initial=0.0))


def amplitude(drawing: Drawing, names: Sequence[str], shape: np.ndarray) -> float:
    """The factor of two digits at which the shape is drawn, besides the magnification of the drawing.

    Bodies and the distances between linked ones move, and wheels turn, as far as there is room for; 1 where nothing is drawn.
    """
    entries = dict(zip(names, np.where(np.abs(shape) > noise_of(1.0, len(shape)), shape, 0.0)))  # rounding is not to be seen
    moves = {body.name: drawing.scale * _sum(body.moves, entries) for body in drawing.bodies}
    turns = [drawing.turn_scale * _sum(body.turns, entries) for body in drawing.bodies]
    between = [moves[link.end] - moves[link.start] for link in drawing.links]
    limits = ((ABSOLUTE, moves.values()), (NEIGHBOURS, between), (WIDEST_ANGLE, turns))
    furthest = [(limit, max(map(np.linalg.norm, vectors), default=0.0)) for limit, vectors in limits]
    return two_digits(min((limit / size for limit, size in furthest if size), default=1.0))


def _sum(vectors, entries: dict[str, complex]) -> np.ndarray:
    return sum((np.array(vector) * entries.get(name, 0.0) for name, vector in vectors.items()), np.zeros(3))
