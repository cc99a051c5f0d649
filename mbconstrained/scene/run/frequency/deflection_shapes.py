"""The operating deflection shapes of a scene: its drawing, and how all coordinates move at each frequency under a unit of an input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ....frequency.features import frequencies_by_poles
from ....frequency.frequency_response import FrequencyResponse
from ....ground.coordinate_units import force_unit, rate_unit
from ....ground.tolerances import noise_of
from ....mechanics.channels import channels
from ....page.drawing.bodies import Drawing, DrawnBody, Vector
from ....page.drawing.layout import two_digits
from ....page.frequency_page import Deflections
from ..modes.mode_pages import amplitude, mode_drawing
from ..picture.robot_drawing import NOTE, TURN, VISIBLE, RobotPicture
from ..picture.scene_drawing import view_of

if TYPE_CHECKING:
    from ....mechanics.system import MechanicalSystem
    from ...build.robot_model import RobotScene
    from ...schema.drawing_tables import DrawingTable
    from .frequency_data import FrequencyData

#: Numbers of all shapes; of larger models or more inputs fewer lines have one.
MOST_NUMBERS = 150_000

#: Lines with a shape: neighbours look the same; peaks are among them in any case.
MOST_SHAPES = 600

#: A force on each input, by the unit along which it works; a prescribed motion has the unit of its row.
UNIT = "1 "


def deflections_of(frequency: FrequencyData) -> Deflections | None:
    """The shapes of all inputs at the lines of the response; None where the model has no places, or nothing to draw."""
    system, scene = frequency.system, frequency.scene
    if system is None or not scene.table.output.animation:
        return None
    response = frequency.coordinate_response()
    lines = _lines(frequency, response)
    if len(lines) < 2:
        return None
    H = np.moveaxis(response(lines).values, 0, 2)  # inputs, lines, coordinates
    robot_scene, table = scene.equations.robot_scene, scene.table.drawing
    names = scene.equations.coordinates.names
    if robot_scene:
        robot = LinearRobot(robot_scene, table)
        drawing, factors = robot.drawing, robot.factors(H)
    else:
        largest = [H[i, line] for i in range(len(H)) for line in range(len(lines))]
        drawing = mode_drawing(scene, [_normed(shape) for shape in largest])
        factors = np.array([[_amplitude(drawing, names, shape) for shape in block] for block in H])
    axis = frequency.axis_factor
    texts = tuple(_unit_text(system, name, frequency.table.quantity) for name in response.inputs)
    return Deflections(drawing, names, texts, axis * lines, 1 / lines, H * factors[:, :, None], factors)


def _normed(shape: np.ndarray) -> np.ndarray:
    return shape / (np.abs(shape).max() or 1.0)


def _amplitude(drawing: Drawing, names: Sequence[str], shape: np.ndarray) -> float:
    """Amplitude of a shape, as of a mode, whose largest entry is 1."""
    size = float(np.abs(shape).max())
    return amplitude(drawing, names, shape / size) / size if size else 1.0


def _lines(frequency: FrequencyData, response: FrequencyResponse) -> np.ndarray:
    """Frequencies in Hz, those of the response and all peaks, no more than can be stored, none at a pole."""
    given = frequency.response.frequencies_hz
    low, high = given[given > 0][[0, -1]] if (given > 0).any() else (1.0, 1.0)
    placed = frequencies_by_poles(response.harmonic, with_peaks=False)
    lines = np.union1d(given[given > 0], placed[(placed > low) & (placed < high)])
    most = max(2, min(MOST_SHAPES, MOST_NUMBERS // (len(response.inputs) * len(response.outputs))))
    lines = lines[np.unique(np.linspace(0, len(lines) - 1, min(most, len(lines))).astype(int))] if len(lines) else lines
    peaks = [peak.frequency_hz for peak in frequency.peaks if np.isfinite(peak.amplitude) and peak.frequency_hz > 0]
    lines = np.union1d(lines, peaks)
    return np.setdiff1d(lines, [one.frequency_hz for one in response(lines).poles_on_lines])


def _unit_text(system: MechanicalSystem, name: str, quantity: str) -> str:
    """Text of a unit input, such as "1 N on cart" or "1 m of motion of road"."""
    channel = channels(system, "inputs")[name]
    if channel is None or channel.row is None:
        return f"{UNIT}{force_unit(channel.unit) if channel else ''} on {name}"
    order = 0 if quantity == "transmissibility" else system.rows[channel.row].order
    return f"{UNIT}{rate_unit(channel.unit, order)} of {name}"


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
