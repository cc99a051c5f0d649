"""Made-up robots that several tests look at, with places known in closed form."""

from dataclasses import dataclass, field

import numpy as np

from mbconstrained.page.animation import Animation
from mbconstrained.page.drawing import Path
from mbconstrained.scene.run.drawing import robot_drawing, solids_of


@dataclass(frozen=True)
class Seen:
    """A visual as a robot gives it."""

    link: str
    kind: str
    size: object
    placement: np.ndarray = field(default_factory=lambda: np.eye(4))
    color: tuple | None = None
    vertices: np.ndarray | None = None
    faces: np.ndarray | None = None
    texture: object = None
    note: str = ""

    @property
    def triangles(self) -> int:
        return 0 if self.faces is None else len(self.faces)


@dataclass(frozen=True)
class Tie:
    """A connection as a robot gives it."""

    name: str
    kind: str
    body1: str
    point1: tuple
    body2: str
    point2: tuple


def turned(axis, angle) -> np.ndarray:
    """Quaternions (4, T) of turns by angles (T,) about an axis."""
    angle = np.atleast_1d(np.asarray(angle, dtype=float))
    return np.vstack([np.outer(axis, np.sin(angle / 2)), np.cos(angle / 2)])


CRANK, COUPLER, ROCKER, GROUND_LENGTH = 0.25, 0.6, 0.45, 0.55


def four_bar_angles(times) -> np.ndarray:
    """Angles of crank, coupler and rocker in the x-z plane, shape (3, T), the loop closed exactly."""
    crank = 1.0 + 0.6 * np.sin(1.3 * np.asarray(times))
    x, z = GROUND_LENGTH - CRANK * np.cos(crank), -CRANK * np.sin(crank)
    span = np.hypot(x, z)
    coupler = np.arctan2(z, x) + np.arccos((COUPLER**2 + span**2 - ROCKER**2) / (2 * COUPLER * span))
    tip = np.array([COUPLER * np.cos(coupler) - x, COUPLER * np.sin(coupler) - z])
    return np.array([crank, coupler, np.arctan2(tip[1], tip[0])])


def four_bar(times, size: float = 1.0, **options) -> Animation:
    """A four-bar in the x-z plane with a loop, a spring to the ground and a bushing, times size."""
    times = np.asarray(times, dtype=float)
    angles, zero = four_bar_angles(times), np.zeros(len(times))
    pin = CRANK * size * np.array([np.cos(angles[0]), zero, np.sin(angles[0])])
    far = np.array([GROUND_LENGTH * size + zero, zero, zero])
    places = {"crank": np.zeros((3, len(times))), "coupler": pin, "rocker": far}
    poses = {name: Path(place, turned((0, -1, 0), angle)) for (name, place), angle in zip(places.items(), angles)}
    seen = [
        Seen(name, "box", (length * size, 0.03 * size, 0.05 * size), shifted((length * size / 2, 0, 0)))
        for name, length in zip(poses, (CRANK, COUPLER, ROCKER))
    ]
    ties = [
        Tie("loop", "loop", "coupler", (COUPLER * size, 0, 0), "rocker", (ROCKER * size, 0, 0)),
        Tie("spring", "spring", "ground", (0.28 * size, 0, 0), "coupler", (COUPLER / 2 * size, 0, 0)),
        Tie("bush", "bushing", "crank", (CRANK * size, 0, 0), "coupler", (0, 0, 0)),
    ]
    return Animation(robot_drawing(solids_of(seen), poses, ties, **options), ("crank",), times, angles[:1])


def shifted(shift) -> np.ndarray:
    """A placement that only shifts."""
    matrix = np.eye(4)
    matrix[:3, 3] = shift
    return matrix


def octahedron(radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces."""
    vertices = radius * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1.0]])
    faces = [(a, b, c) if (a == 0) ^ (b == 2) ^ (c == 4) else (b, a, c) for a in (0, 1) for b in (2, 3) for c in (4, 5)]
    return vertices, np.array(faces)
