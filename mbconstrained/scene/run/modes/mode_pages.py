"""The page of the modes of a scene: one drawing for all modes, and for each mode an amplitude and, of a robot, paths of the links."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ....ground.tolerances import noise_of
from ....page.drawing.bodies import Drawing
from ....page.drawing.orientation import ABSOLUTE, NEIGHBOURS, WIDEST_ANGLE, two_digits
from ....page.drawing.paths import Path
from ....page.mode_page import ModePicture, ModesContent, Share, cycle
from ...build.robot_model import robot_fact
from ..picture.robot_drawing import RobotPicture
from ..picture.scene_drawing import automatic_drawing, own_drawing, view_of
from ..scene_data import SceneData
from .mode_summary import BY_COORDINATE, ListedModes, ModeLine, descending, mass_tables, shape_cells
from .scene_sensitivities import influence_tables

if TYPE_CHECKING:
    from ....models.elements import Element
    from ...build.robot_model import RobotScene
    from ...schema.drawing_tables import DrawingTable


def modes_content(modes: ListedModes) -> ModesContent:
    """A picture for each line of the list, all with the same drawing."""
    scene = modes.scene
    coordinates, robot = scene.equations.coordinates, robot_modes(scene)
    shapes = [line.shape for line in modes.lines if line.shape is not None]
    drawing = robot.drawing if robot else mode_drawing(scene, shapes)

    def picture(line: ModeLine) -> ModePicture:
        facts = tuple((label, text) for label, text in line.cells.items() if label not in ("kind", "meaning"))
        if line.shape is None:
            return ModePicture(line.name, facts, note=line.cells["meaning"])
        factor = robot.amplitude(line.shape) if robot else amplitude(drawing, coordinates.names, line.shape)
        return ModePicture(
            line.name,
            facts,
            shares=_shares_by_part(line),
            shape=tuple(shape_cells(line.shape, coordinates)),
            values=cycle(line.shape),
            paths=robot.paths(line.shape, factor) if robot else {},
            period=2 * np.pi / line.value.imag if line.value.imag else None,
            scale=factor,
            note=_note(line),
        )

    return ModesContent(
        title=scene.title,
        source=scene.table.source,
        drawing=drawing,
        names=coordinates.names,
        modes=tuple(map(picture, modes.lines)),
        notices=modes.notices,
        facts=_facts(modes),
        tables=(*mass_tables(modes), *influence_tables(scene)),
    )


def robot_modes(scene: SceneData) -> RobotModes | None:
    """The robot of a scene, if it has one."""
    robot_scene, table = scene.equations.robot_scene, scene.table.drawing
    return RobotModes(robot_scene, table) if robot_scene else None


def _note(line: ModeLine) -> str:
    meaning = line.cells["meaning"]
    if not line.value.imag:
        return f"{meaning}; drawn as if its shape swung"
    return f"{meaning}; drawn without {'growth' if line.value.real > 0 else 'decay'}" if line.value.real else meaning


def _shares_by_part(line: ModeLine) -> tuple[Share, ...]:
    """(part, kinetic share, strain share) of every part with either, in descending order; None for a missing one."""
    kinetic, strain = line.shares.kinetic or {}, line.shares.strain or {}
    rows = ((name, kinetic.get(name), strain.get(name)) for name in dict.fromkeys((*kinetic, *strain)))
    return tuple(sorted(rows, key=lambda row: descending(max(abs(row[1] or 0.0), abs(row[2] or 0.0)))))


def _facts(modes: ListedModes) -> tuple[tuple[str, str], ...]:
    coordinates = modes.scene.equations.coordinates
    listed = ", ".join(f"{name} ({unit})" for name, unit in zip(coordinates.names, coordinates.units))
    shares = [("shares of energy", BY_COORDINATE)] if modes.system.energy_parts.is_by_coordinate else []
    robot_scene = modes.scene.equations.robot_scene
    robot = [robot_fact(robot_scene)] if robot_scene else []
    return (("coordinates", listed), ("shapes", "their amplitude is free"), *robot, *shares)


LENGTHS = ("rest_length", "rest_angle", "distance", "value")


def mode_drawing(scene: SceneData, shapes: Sequence[np.ndarray]) -> Drawing:
    """The drawing of the scene, given or automatic, as on the page of a run.

    Modes are motions about the state in which every spring has its length: rest lengths only shift them and are left out.
    """
    equations = scene.equations
    values = _typical_values(shapes, equations.coordinates.units)
    elements = None if equations.model is None else [_at_rest(element) for element in equations.model.elements]
    return own_drawing(scene) or automatic_drawing(scene, elements, values)


def _at_rest(element: Element) -> Element:
    return replace(element, **{key: 0.0 for key in LENGTHS if getattr(element, key, None)})


def _typical_values(shapes: Sequence[np.ndarray], units: Sequence[str]) -> np.ndarray:
    """Typical cycles that set the magnification of displacements and angles: of all shapes, or of the one that has both."""
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
    entries = dict(zip(names, np.where(np.abs(shape) > noise_of(1.0, len(shape)), shape, 0.0)))  # without rounding error
    moves = {body.name: drawing.scale * _sum(body.moves, entries) for body in drawing.bodies}
    turns = [drawing.turn_scale * _sum(body.turns, entries) for body in drawing.bodies]
    between = [moves[link.end] - moves[link.start] for link in drawing.links]
    limits = ((ABSOLUTE, moves.values()), (NEIGHBOURS, between), (WIDEST_ANGLE, turns))
    furthest = [(limit, max(map(np.linalg.norm, vectors), default=0.0)) for limit, vectors in limits]
    return two_digits(min((limit / size for limit, size in furthest if size), default=1.0))


def _sum(vectors, entries: dict[str, complex]) -> np.ndarray:
    return sum((np.array(vector) * entries.get(name, 0.0) for name, vector in vectors.items()), np.zeros(3))


#: Parts of a cycle at which it is looked how far points move; between them they go 8 % further at most.
PARTS = 8


class RobotModes:
    """A robot in its posture, for pictures of its modes.

    Attributes:
        drawing: the robot at rest.
    """

    def __init__(self, scene: RobotScene, table: DrawingTable | None = None):
        self.picture = RobotPicture(scene, table)
        rest = self.picture.drawing(self.picture.at_rest, note=table.note if table else "")
        self.drawing = replace(rest, view=view_of(table), posing=self.picture.posing())

    def amplitude(self, shape: np.ndarray) -> float:
        """The factor at which a shape, whose amplitude is free, is drawn."""
        return self.picture.room(cycle(_clean(shape), PARTS + 1))

    def paths(self, shape: np.ndarray, factor: float) -> dict[str, Path]:
        """The poses of all links over one cycle."""
        links = self.picture.poses(cycle(_clean(shape)), factor)
        return {name: Path(poses.positions, poses.quaternions) for name, poses in links.items()}


def _clean(shape: np.ndarray) -> np.ndarray:
    """The shape without rounding errors, which would be visible where motors move and links hardly do."""
    return np.where(np.abs(shape) > noise_of(1.0, len(shape)), shape, 0.0)
