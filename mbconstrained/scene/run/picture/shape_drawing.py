"""Drawings on which shapes swing: of lumped models and matrices, of robots along their modes, and of robots that move linearly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ....ground.tolerances import noise_of
from ....page.animation.shapes import cycle
from ....page.drawing.bodies import DrawnBody, Vector
from ....page.drawing.orientation import ABSOLUTE, NEIGHBOURS, WIDEST_ANGLE, two_digits
from ....page.drawing.paths import Path
from ..scene_data import SceneData
from .robot_drawing import NOTE, TURN, VISIBLE, RobotPicture
from .scene_drawing import automatic_drawing, own_drawing, view_of

if TYPE_CHECKING:
    from ....models.elements import Element
    from ...build.robot_model import RobotScene
    from ...schema.drawing_tables import DrawingTable

LENGTHS = ("rest_length", "rest_angle", "distance", "value")

#: Parts of a cycle at which it is looked how far points move; between them they go 8 % further at most.
PARTS = 8


class ShapeDrawing:
    """The drawing of a scene, given or automatic, as on the page of a run, or its robot at rest.

    Modes are motions about the state in which every spring has its length: rest lengths only shift them and are left out.

    Attributes:
        drawing: at rest.
        robot: the robot, if the scene has one.
    """

    def __init__(self, scene: SceneData, shapes: Sequence[np.ndarray]):
        equations, table = scene.equations, scene.table.drawing
        self.names = equations.coordinates.names
        self.robot = RobotPicture(equations.robot_scene, table) if equations.robot_scene else None
        if self.robot is not None:
            rest = self.robot.drawing(self.robot.at_rest, note=table.note if table else "")
            self.drawing = replace(rest, view=view_of(table), posing=self.robot.posing())
            return
        elements = None if equations.model is None else [_at_rest(element) for element in equations.model.elements]
        values = _typical_values(shapes, equations.coordinates.units)
        self.drawing = own_drawing(scene) or automatic_drawing(scene, elements, values)

    def amplitude(self, shape: np.ndarray) -> float:
        """The factor of two digits at which a shape, whose amplitude is free, is drawn, besides the magnification of the drawing.

        Bodies and the distances between linked ones move, and wheels turn, as far as there is room for; 1 where nothing is drawn.
        """
        if self.robot is not None:
            return self.robot.room(cycle(_clean(shape), PARTS + 1))
        drawing, entries = self.drawing, dict(zip(self.names, _clean(shape)))
        moves = {body.name: drawing.scale * _sum(body.moves, entries) for body in drawing.bodies}
        turns = [drawing.turn_scale * _sum(body.turns, entries) for body in drawing.bodies]
        between = [moves[link.end] - moves[link.start] for link in drawing.links]
        limits = ((ABSOLUTE, moves.values()), (NEIGHBOURS, between), (WIDEST_ANGLE, turns))
        furthest = [(limit, float(max(map(np.linalg.norm, vectors), default=0.0))) for limit, vectors in limits]
        return two_digits(min((limit / size for limit, size in furthest if size), default=1.0))

    def paths(self, shape: np.ndarray, factor: float) -> dict[str, Path]:
        """The poses of all links of a robot over one cycle; none of other models."""
        links = self.robot.poses(cycle(_clean(shape)), factor) if self.robot is not None else {}
        return {name: Path(poses.positions, poses.quaternions) for name, poses in links.items()}


def _at_rest(element: Element) -> Element:
    lengths: dict[str, Any] = {key: 0.0 for key in LENGTHS if getattr(element, key, None)}
    return replace(element, **lengths)


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


def _sum(vectors: Mapping[str, Vector], entries: dict[str, complex]) -> np.ndarray:
    return sum((np.array(vector) * entries.get(name, 0.0) for name, vector in vectors.items()), np.zeros(3))


def _clean(shape: np.ndarray) -> np.ndarray:
    """The shape without rounding errors, which would be visible where motors move and links hardly do."""
    return np.where(np.abs(shape) > noise_of(1.0, len(shape)), shape, 0.0)


#: Small motion by which the links are moved to see where each coordinate takes them, in rad and as a share of the robot's size.
STEP = 0.02


class LinearRobot:
    """A robot whose links move along straight lines and turn about fixed axes, as small motion does.

    Attributes:
        drawing: bodies that move with the coordinates, at rest.
    """

    def __init__(self, scene: RobotScene, table: DrawingTable | None = None):
        from scipy.spatial.transform import Rotation

        picture = RobotPicture(scene, table)
        count, names = len(scene.robot.coordinates), scene.coordinates.names
        turning = np.array([unit == "rad" for unit in scene.robot.units], dtype=bool)
        steps = np.where(turning, STEP, STEP * picture.size)
        self.size, moved = picture.size, np.diag(steps)
        forwards, backwards = picture.poses(_padded(moved, len(names))), picture.poses(_padded(-moved, len(names)))
        moves = {name: (forwards[name].positions - backwards[name].positions) / (2 * steps) for name in forwards}
        turns = {}
        for name, ahead in forwards.items():
            rotation = Rotation.from_quat(ahead.quaternions.T) * Rotation.from_quat(backwards[name].quaternions.T).inv()
            turns[name] = rotation.as_rotvec().T / (2 * steps)
        self.turns = np.vstack(list(turns.values()))
        corners = picture.points_of_links
        self.moves = np.vstack([_of_points(corners[name], moves[name], turns[name]) for name in moves])
        rest = picture.drawing(picture.at_rest, note=(table.note if table else "") or NOTE)
        still = np.zeros((3, count))

        def by_coordinate(columns: np.ndarray) -> dict[str, Vector]:
            """The columns that are more than rounding errors, by the names of the coordinates."""
            largest = np.abs(columns).max(axis=0)
            moving = np.flatnonzero(largest > noise_of(largest.max(initial=0.0), count))
            return {names[i]: (float(columns[0, i]), float(columns[1, i]), float(columns[2, i])) for i in moving}

        def linear(body: DrawnBody) -> DrawnBody:
            """The body without its path."""
            if body.path is None:
                return body
            (x, y, z), turn = (
                body.path.positions[:, 0].tolist(),
                Rotation.from_quat(body.path.quaternions[:, 0]).as_rotvec().tolist(),
            )
            own = by_coordinate(moves.get(body.name, still)), by_coordinate(turns.get(body.name, still))
            return replace(body, path=None, rest=(x, y, z), rest_turn=(turn[0], turn[1], turn[2]), moves=own[0], turns=own[1])

        bodies = tuple(map(linear, rest.bodies))
        self.drawing = replace(rest, bodies=bodies, scale=1.0, turn_scale=1.0, view=view_of(table))

    def factors(self, shapes: np.ndarray) -> np.ndarray:
        """Magnification of each shape, at which no link moves or turns too far for the drawing."""
        links = shapes[:, :, : self.moves.shape[1]]
        vectors = ((links @ rows.T).reshape(*links.shape[:2], -1, 3) for rows in (self.moves, self.turns))
        reach, angle = (np.linalg.norm(np.abs(each), axis=3).max(axis=2, initial=0.0) for each in vectors)
        with np.errstate(divide="ignore"):
            room = np.minimum(VISIBLE * self.size / reach, TURN / angle)
        return np.vectorize(lambda factor: two_digits(factor) if np.isfinite(factor) else 1.0)(room)


def _of_points(points: np.ndarray, moves: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Motion of points of a link by the coordinates, three rows for each: v + omega x r."""
    moved = moves.T[:, None, :] + np.cross(turns.T[:, None, :], points.T[None, :, :])
    return moved.reshape(len(moved), -1).T


def _padded(values: np.ndarray, count: int) -> np.ndarray:
    """Values with rows of zeros for motors."""
    return np.vstack([values, np.zeros((count - len(values), values.shape[1]))])
