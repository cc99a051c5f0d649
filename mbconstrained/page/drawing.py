"""A drawing: bodies and links in space, moved and turned by the coordinates, or along paths. Pure data, no viewer.

A rotation is a rotation vector (axis times angle, rad), a unit quaternion x y z w, or a matrix. The few formulas are written
here because importing ``scipy.spatial.transform`` takes 0.4 s, many times as long as a whole page.

Axes: x to the right, y away from the viewer, z up. A body is at

    rest + scale * sum_i moves[i] q_i          turned by the rotation vector  turn_scale * sum_i turns[i] q_i  after rest_turn

so a drawing does not depend on time: the values of the coordinates do. A body that moves otherwise, such as a link of a
robot, has a path instead: its poses at the times of the animation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Literal, get_args

import numpy as np

from ..ground.errors import InputError


@dataclass(frozen=True, eq=False)
class Path:
    """Positions and orientations of a body's frame, in the axes of the drawing.

    The page interpolates both by cubic polynomials between the times, and brings the quaternions back to unit length.

    >>> Path([[0, 1], [0, 0], [0, 0]], [[0, 0], [0, 0], [0, 0], [1, -1]]).quaternions[3]
    array([1., 1.])
    """

    positions: np.ndarray  # shape (3, T) in drawing units (m for a robot), or (3, 1) for a body that rests
    # shape (4, T), x y z w, of unit length; their signs are chosen so that neighbours are near each other (q and -q are the same
    # orientation)
    quaternions: np.ndarray

    def __post_init__(self):
        quaternions = np.asarray(self.quaternions, dtype=float)
        flipped = (quaternions[:, 1:] * quaternions[:, :-1]).sum(axis=0) < 0
        signs = np.cumprod([1.0, *np.where(flipped, -1.0, 1.0)])
        object.__setattr__(self, "positions", np.asarray(self.positions, dtype=float))
        object.__setattr__(self, "quaternions", quaternions * signs)

    @property
    def count(self) -> int:
        """Number of poses."""
        return self.positions.shape[1]

    @property
    def moves(self) -> bool:
        """Whether any pose differs from the first."""
        both = np.vstack([self.positions, self.quaternions])
        return bool((both != both[:, :1]).any())

    def thinned(self, kept) -> Path:
        """The poses with these indices; one pose where it does not move."""
        chosen = np.asarray(kept) if self.moves else [0]
        return Path(self.positions[:, chosen], self.quaternions[:, chosen])

    def of_points(self, points) -> np.ndarray:
        """Positions of points (3, k) that are fixed in the body's frame, shape (3, k, T)."""
        return self.positions[:, None] + rotated(self.quaternions, np.asarray(points, dtype=float))


def quaternions_of(turns: np.ndarray) -> np.ndarray:
    """Quaternions (4, T) of rotation vectors (3, T) in rad.

    >>> quaternions_of(np.array([[0.0], [0.0], [np.pi]])).round(12).T
    array([[0., 0., 1., 0.]])
    """
    angles = np.linalg.norm(turns, axis=0)
    return np.vstack([turns * (np.sinc(angles / (2 * np.pi)) / 2), np.cos(angles / 2)])


def rotated(quaternions: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Rotated points R p, with R = (w² - u·u) I + 2 u uᵀ + 2 w [u]×."""
    u, w = quaternions[:3], quaternions[3]
    x, y, z = u
    cross = np.array([[0 * w, -z, y], [z, 0 * w, -x], [-y, x, 0 * w]])
    matrices = np.eye(3)[:, :, None] * (w**2 - (u**2).sum(axis=0)) + 2 * u[:, None] * u + 2 * w * cross
    return np.einsum("ijt,jk->ikt", matrices, points)


def after(second: np.ndarray, first: np.ndarray) -> np.ndarray:
    """The product of quaternions: of one rotation after another."""
    (u, w), (v, s) = (second[:3], second[3]), (first[:3], first[3])
    return np.vstack([w * v + s * u + np.cross(u, v, axis=0), w * s - (u * v).sum(axis=0)])


def matrix_of(turn) -> np.ndarray:
    """The matrix (3, 3) of a rotation vector (3,)."""
    if not np.any(turn):
        return np.eye(3)
    return rotated(quaternions_of(np.array(turn, dtype=float)[:, None]), np.eye(3))[:, :, 0]


def vector_of(matrix: np.ndarray) -> np.ndarray:
    """The rotation vector (3,) of a matrix; half a turn included.

    >>> vector_of(np.diag([-1.0, -1.0, 1.0])).round(12)
    array([0.        , 0.        , 3.14159265])
    """
    sine = np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]]) / 2
    cosine = (np.trace(matrix) - 1) / 2
    angle = np.arctan2(np.linalg.norm(sine), cosine)
    if cosine < -0.9:
        outer = (matrix + matrix.T) / 2 - cosine * np.eye(3)  # axis times axis, up to a factor
        column = outer[:, int(np.argmax(np.diag(outer)))]
        axis = column / np.linalg.norm(column) * (-1.0 if column @ sine < 0 else 1.0)
        return angle * axis
    return sine * (angle / np.linalg.norm(sine)) if angle else sine


Shape = Literal["box", "sphere", "disc", "gear", "ring", "mark", "rail", "ground", "base", "solids"]
SwitchingKind = Literal["stop", "slot", "cable", "friction", "pad", "latch", "play", "clutch", "brake"]
SteadyKind = Literal["spring", "damper", "strut", "rod", "bushing", "loop", "torsion spring", "torsion damper", "belt", "shaft"]
LinkKind = Literal[SteadyKind, SwitchingKind]
SWITCHING: tuple[str, ...] = get_args(SwitchingKind)
Vector = tuple[float, float, float]

_USUAL_SIZE = {
    "box": (0.8, 0.8, 0.8),
    "sphere": (0.24, 0.24, 0.24),
    "mark": (0.12, 0.12, 0.12),
    "rail": (4.0, 0.12, 0.05),
    "ground": (0.2, 1.2, 1.4),
    "base": (1.2, 1.2, 0.1),
    "solids": (1.0, 1.0, 1.0),
}
_UNNAMED = ("mark", "rail", "ground", "base")


@dataclass(frozen=True, eq=False)
class Solid:
    """A box, cylinder, sphere or mesh, fixed in the frame of a body.

    >>> Solid("cylinder", (0.1, 2)).corners.max(axis=1)
    array([0.1, 0.1, 1. ])
    """

    kind: str  # "box", "cylinder" (axis z), "sphere" or "mesh"
    # size of a box its extents along x, y, z; of a cylinder its radius and length; of a sphere its radius
    size: tuple[float, ...] = ()
    # shape (4, 4), from the solid's frame to the body's, a rotation and a translation
    placement: np.ndarray = field(default_factory=lambda: np.eye(4))
    color: str | None = None  # "#rrggbb", or None for that of the body
    opacity: float = 1.0  # from 0 to 1
    # of a mesh, shapes (k, 3) and (f, 3); a face has the numbers of its three corners. Equal vertices are merged, and those without
    # a face and faces without area removed, so that the same mesh is the same numbers.
    vertices: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    faces: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), dtype=int))
    image: bytes | None = None  # a JPEG file that a mesh shows instead of the colour, or None
    # of the corners of each face in the image, shape (f, 3, 2), from (0, 0) at its lower left to (1, 1)
    places: np.ndarray | None = None

    def __post_init__(self):
        if self.kind == "mesh":
            used, numbers = np.unique(self.faces, return_inverse=True)
            vertices, merged = np.unique(self.vertices[used].astype(np.float32), axis=0, return_inverse=True)
            faces = merged.reshape(-1)[numbers.reshape(-1, 3)]
            a, b, c = faces.T
            kept = (a != b) & (b != c) & (c != a)
            object.__setattr__(self, "vertices", vertices.astype(float))
            object.__setattr__(self, "faces", faces[kept])
            object.__setattr__(self, "places", None if self.places is None else self.places[kept])

    @property
    def corners(self) -> np.ndarray:
        """Corners of a box around it in the frame of the body, shape (3, 8); (3, 0) for a mesh without faces."""
        if self.kind == "mesh" and not len(self.faces):
            return np.zeros((3, 0))
        if self.kind == "mesh":
            ends = np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])
        else:
            radius, *length = self.size
            extents = self.size if self.kind == "box" else (2 * radius, 2 * radius, *(length or [2 * radius]))
            ends = np.outer((-0.5, 0.5), extents)
        return self.placement[:3, :3] @ np.array(list(product(*ends.T))).T + self.placement[:3, 3:]


@dataclass(frozen=True)
class DrawnBody:
    """A drawn object that the coordinates move.

    >>> DrawnBody("cart", rest=(1, 0, 0), moves={"x1": (1, 0, 0)}).shape
    'box'
    """

    name: str  # differs from the other bodies' names
    # "box" (a mass), "sphere" (a massless joint), "disc", "gear" or "ring" (an inertia, a toothed wheel, a wheel with teeth inside;
    # its axis is y), "mark" (a point such as a pivot), "rail" (along which a body moves), "ground" (a hatched wall), "base" (a
    # hatched plate that lies flat), "solids" (its solids)
    shape: Shape = "box"
    rest: Vector = (0.0, 0.0, 0.0)  # position where all coordinates are zero, in drawing units
    # coordinate name -> displacement in drawing units per unit of the coordinate
    moves: Mapping[str, Vector] = field(default_factory=dict)
    # coordinate name -> rotation vector in rad per unit of the coordinate; (0, -1, 0) is counter-clockwise
    turns: Mapping[str, Vector] = field(default_factory=dict)
    # extent along x, y and z in drawing units, None for the usual one; along x it is the diameter of a wheel
    size: Vector | None = None
    color: str | None = None  # "#rrggbb", or None for the usual colour
    label: str | None = None  # text next to the body; None for its name, except for a mark, a rail or the ground
    rest_turn: Vector = (0.0, 0.0, 0.0)  # rotation vector in rad where all coordinates are zero
    teeth: int = 24  # number of teeth of a gear or ring
    solids: tuple[Solid, ...] = ()  # of a body of the shape "solids", whose size is ignored
    collision: tuple[Solid, ...] = ()  # further solids that the page shows on request
    path: Path | None = None  # its poses at the times of the animation; rest, moves and turns are then ignored
    # placement (4, 4) of a unit sphere, column by column, that makes it a uniform ellipsoid with centre of mass and inertia of the
    # body; None where there is no mass
    ellipsoid: tuple[float, ...] | None = None
    traced: tuple[Vector, ...] = ()  # points in its frame whose paths the page draws: over one revolution, or one cycle of a mode

    def __post_init__(self):
        label = "" if self.shape in _UNNAMED else self.name
        values = {
            "rest": _vector(self.rest),
            "rest_turn": _vector(self.rest_turn),
            "moves": {name: _vector(vector) for name, vector in self.moves.items()},
            "turns": {name: _vector(vector) for name, vector in self.turns.items()},
            "size": _vector(self.size or _USUAL_SIZE.get(self.shape, (1.2, 0.3, 1.2))),
            "label": label if self.label is None else self.label,
        }
        for attribute, value in values.items():
            object.__setattr__(self, attribute, value)
        if min(self.size) <= 0:
            raise InputError(f"size: found {min(self.size):g}; expected numbers greater than zero")

    @property
    def half_extent(self) -> np.ndarray:
        """Half of a box around it along x, y, z, shape (3,), as it is turned at rest; without its solids."""
        half = np.array(self.size) / 2
        if not any(self.rest_turn):
            return half
        rotation = matrix_of(self.rest_turn)
        if self.shape not in ("disc", "gear", "ring"):
            return np.abs(rotation) @ half
        axis = rotation[:, 1]
        return half[0] * np.sqrt(np.maximum(0.0, 1 - axis**2)) + half[1] * np.abs(axis)


@dataclass(frozen=True)
class DrawnLink:
    """A drawn connection of two bodies."""

    name: str  # for messages
    # "spring", "damper", "strut" (a spring around a damper), "rod", "bushing" (a soft block), "loop" (a ball on the end's body in a
    # socket on the start's, so that a gap is visible), "torsion spring", "torsion damper" or "belt"; with several states "stop" (a plate
    # on a rod that the end's body meets), "slot" (a tongue between two plates), "cable", "friction" (a pad on a strip), "pad" (below a body), "latch",
    # and between bodies that turn "play" (a tongue between two fingers), "clutch" (two discs) or "brake" (a shoe on the rim); "shaft"
    # (a bar that bends, through its stations)
    kind: LinkKind
    # names of the bodies. Between wheels on one axis a torsion spring is a helix, otherwise a spiral from its start to the hub at
    # its end.
    start: str
    end: str
    # shift of both ends across the link, so that parallel links do not overlap; an end that is shifted out of its body is joined to
    # it by a post
    offset: Vector = (0.0, 0.0, 0.0)
    end_offset: Vector | None = None  # shift of the end where it differs from that of the start
    over: str | None = None  # for a belt, the name of the wheel that it runs over
    # its ends in the frames of the bodies, with which these points turn; None for the side of the body that faces the other end,
    # shifted by the offset, which does not turn
    start_point: Vector | None = None
    end_point: Vector | None = None
    # rotation vector (rad) of the frame in which it is drawn: wheels that it joins have their axes along the y axis of this frame
    turn: Vector = (0.0, 0.0, 0.0)

    # elongations, in units of the coordinates, at which it closes when it becomes shorter and when it becomes longer; None for none
    limits: tuple[float | None, float | None] = (None, None)
    magnification: float = 1.0  # of the relative angle of a play, in addition to that of the drawing
    # times in s at which its engagement changes: 0 without force, 1 slipping, 2 closed, stuck or taut; empty where it has no states
    states: tuple[tuple[float, int], ...] = ()
    # of a shaft: in their order along it, a body, a point in its frame, and whether the shaft has the direction of the body's x axis there
    stations: tuple[tuple[str, Vector, bool], ...] = ()
    shown: tuple[str, ...] = ()  # names of further elements that it stands for

    def __post_init__(self):
        end_offset = self.offset if self.end_offset is None else self.end_offset
        object.__setattr__(self, "offset", _vector(self.offset))
        object.__setattr__(self, "end_offset", _vector(end_offset))


@dataclass(frozen=True)
class View:
    """A point of view."""

    yaw: float = 0.0  # angle to the right of the front, in rad
    pitch: float = 0.0  # angle above the horizontal, in rad
    zoom: float = 1.0  # magnification; at 1 the whole motion fills the picture


@dataclass(frozen=True, eq=False)
class SliderPosing:
    """Sliders for the posture of a robot: q = columns s, each link by the product exp(S_1 q_1) ... exp(S_n q_n)."""

    names: tuple[str, ...]  # names, units and symmetric limits of the r sliders s
    units: tuple[str, ...]
    limits: tuple[float, ...]
    columns: np.ndarray  # shape (n, r)
    twists: np.ndarray  # S_i, velocity at the origin and rate of rotation, shape (6, n)
    moving: Mapping[str, tuple[int, ...]]  # by link, the indices of its own coordinates
    rest: Mapping[str, Path]  # by link, the pose in the posture


@dataclass(frozen=True)
class Drawing:
    """Bodies and links, and the magnification of their motion."""

    bodies: tuple[DrawnBody, ...]
    links: tuple[DrawnLink, ...] = ()
    scale: float = 1.0  # magnification of the displacements and of the angles; the page states both
    turn_scale: float = 1.0
    note: str = ""  # a sentence shown with the picture, or an empty string
    view: View | None = None  # the point of view, or None for one that shows most
    turn: Vector = (0.0, 0.0, 0.0)  # rotation vector (rad) of the whole drawing, applied last
    posing: SliderPosing | None = None  # by sliders, of a robot, or None
    revolution: float | None = None  # duration of the orbits, a revolution of the rotors, in s; None for the whole motion

    def __post_init__(self):
        for name, count in Counter(body.name for body in self.bodies).items():
            if count > 1:
                raise InputError(f'drawing: two bodies are named "{name[:60]}"; names must differ')


def _vector(value) -> Vector:
    x, y, z = map(float, value)
    return x, y, z
