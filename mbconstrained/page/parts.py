"""Parts of a body: the boxes, cylinders, spheres and meshes that a robot's link is drawn with."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import product
from typing import Literal, get_args

import numpy as np

from ..checks import nearest, real_array, real_number
from ..errors import InputError

PartKind = Literal["box", "cylinder", "sphere", "mesh"]
PART_KINDS: tuple[str, ...] = get_args(PartKind)

#: How many sizes each kind has: extents along x, y, z; radius and length along z; radius.
_SIZES = {"box": 3, "cylinder": 2, "sphere": 1, "mesh": 0}

#: Placements further than this from a rotation are refused; texts of six digits are nearer.
_NO_ROTATION = 1e-4


@dataclass(frozen=True, eq=False)
class Part:
    """One solid, fixed in the frame of its body.

    Attributes:
        kind: "box", "cylinder" (axis z), "sphere" or "mesh".
        size: of a box its extents along x, y, z; of a cylinder its radius and length; of a sphere its radius.
        placement: shape (4, 4), from the part's frame to the body's, a rotation and a shift; None where they agree.
        color: "#rrggbb", or None for that of the body.
        opacity: from 0 to 1.
        vertices, faces: of a mesh, shapes (k, 3) and (f, 3); a face has the numbers of its three corners. Vertices at one
            place become one and faces without area go, so that the same mesh is the same numbers.

    Raises:
        InputError: sizes that are negative or of another number, shapes that do not match, NaN, a face with a corner that
            does not exist, a placement that is no rotation and shift.

    >>> Part("cylinder", (0.1, 2)).corners.max(axis=1)
    array([0.1, 0.1, 1. ])
    """

    kind: PartKind
    size: tuple[float, ...] = ()
    placement: np.ndarray | None = None
    color: str | None = None
    opacity: float = 1.0
    vertices: np.ndarray | None = None
    faces: np.ndarray | None = None

    def __post_init__(self):
        if self.kind not in PART_KINDS:
            hint = nearest(self.kind, PART_KINDS)
            raise InputError(f"part, kind: found {str(self.kind)[:60]}; expected one of {', '.join(PART_KINDS)}{hint}")
        object.__setattr__(self, "size", _size(self.size, self.kind))
        object.__setattr__(self, "placement", _placement(self.placement, f"part, {self.kind}, placement"))
        object.__setattr__(self, "color", checked_color(self.color, f"part, {self.kind}, color"))
        opacity = real_number(self.opacity, f"part, {self.kind}, opacity", minimum=0)
        object.__setattr__(self, "opacity", min(1.0, opacity))
        vertices, faces = _mesh(self.vertices, self.faces) if self.kind == "mesh" else (None, None)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces)

    @property
    def corners(self) -> np.ndarray:
        """Corners of a box around it in the frame of the body, shape (3, 8); (3, 0) for a mesh without faces."""
        if self.kind == "mesh" and not len(self.faces):
            return np.zeros((3, 0))
        low, high = self._box()
        corners = np.array(list(product(*zip(low, high)))).T
        return self.placement[:3, :3] @ corners + self.placement[:3, 3:]

    def _box(self) -> tuple[np.ndarray, np.ndarray]:
        if self.kind == "mesh":
            return self.vertices.min(axis=0), self.vertices.max(axis=0)
        if self.kind == "box":
            half = np.array(self.size) / 2
        else:
            radius = self.size[0]
            half = np.array([radius, radius, self.size[1] / 2 if self.kind == "cylinder" else radius])
        return -half, half


def checked_color(color: str | None, what: str) -> str | None:
    """The colour, if it is None or "#rrggbb"."""
    if color is not None and not re.fullmatch("#[0-9a-fA-F]{6}", str(color)):
        raise InputError(f'{what}: found {str(color)[:60]}; expected six hexadecimal digits such as "#4682b4"')
    return color


def _size(value, kind: str) -> tuple[float, ...]:
    value = () if kind == "mesh" else (value,) if np.ndim(value) == 0 else value
    size = real_array(value, f"part, {kind}, size", shape=(_SIZES[kind],))
    if size.min(initial=0.0) < 0:
        raise InputError(f"part, {kind}, size: found {size.min():g}; expected no negative number")
    return tuple(size.tolist())


def _placement(value, what: str) -> np.ndarray:
    placement = real_array(np.eye(4) if value is None else value, what, shape=(4, 4))
    rotation = placement[:3, :3]
    off = max(np.abs(rotation @ rotation.T - np.eye(3)).max(), np.abs(placement[3] - [0, 0, 0, 1]).max())
    if off > _NO_ROTATION or np.linalg.det(rotation) < 0:
        raise InputError(f"{what}: found a matrix that is no rotation and shift; give [[R, p], [0, 1]] with R orthonormal")
    return placement


def _mesh(vertices, faces) -> tuple[np.ndarray, np.ndarray]:
    vertices = _rows_of_three(vertices, "part, mesh, vertices")
    faces = _rows_of_three(faces, "part, mesh, faces")
    wrong = (faces != np.floor(faces)) | (faces < 0) | (faces >= len(vertices))
    if wrong.any():
        raise InputError(
            f"part, mesh, faces: found {faces[wrong][0]:g}; expected numbers of vertices, whole and from 0 to {len(vertices) - 1}"
        )
    places, numbers = np.unique(vertices.astype(np.float32), axis=0, return_inverse=True)
    faces = numbers.reshape(-1)[faces.astype(int)]
    a, b, c = faces.T
    return places.astype(float), faces[(a != b) & (b != c) & (c != a)]


def _rows_of_three(value, what: str) -> np.ndarray:
    empty = value is None or np.size(value) == 0
    return real_array(np.zeros((0, 3)) if empty else value, what, shape=(None, 3))
