"""A mesh in parts, each of one colour or texture, as the readers of mesh files give it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

#: Red, green, blue and opacity from 0 to 1.
Color = tuple[float, float, float, float]


class UnreadableMesh(ValueError):
    """A file that is broken, or uses what the reader does not know."""


@dataclass(frozen=True, eq=False)
class Texture:
    """An image over triangles.

    Attributes:
        image: a JPEG file, or, from a reader, the name of an image file.
        places: of the corners of each triangle in the image, shape (f, 3, 2), from (0, 0) at its lower left to (1, 1).
    """

    image: bytes | str
    places: np.ndarray


@dataclass(frozen=True, eq=False)
class MeshPart:
    """Triangles of a mesh that look alike.

    Attributes:
        faces: numbers of the corners, shape (f, 3).
        color: None where the file gives none.
        texture: takes the place of the colour, or None.
    """

    faces: np.ndarray
    color: Color | None = None
    texture: Texture | None = None


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh.

    Attributes:
        vertices: corners (k, 3) in m.
        parts: with their triangles.
        notes: on textures that are not drawn.
    """

    vertices: np.ndarray
    parts: tuple[MeshPart, ...]
    notes: tuple[str, ...] = ()

    @cached_property
    def whole(self) -> MeshPart:
        """All triangles, without their colours."""
        return MeshPart(np.vstack([part.faces for part in self.parts]))


class Surfaces:
    """Triangles, collected by how they look.

    ``add`` takes polygons in the order of the file; ``mesh`` gives the parts.
    """

    def __init__(self) -> None:
        self._vertices: list[np.ndarray] = []
        self._count = 0
        self._faces: dict[tuple[Color | None, str], tuple[list[np.ndarray], list[np.ndarray]]] = {}

    def add_vertices(self, vertices: np.ndarray) -> int:
        """Further corners (k, 3)."""
        self._vertices.append(vertices)
        self._count += len(vertices)
        return self._count - len(vertices)

    def add_polygons(
        self, sides, corners: np.ndarray, color: Color | None, image: str = "", places: np.ndarray | None = None
    ) -> None:
        """Polygons, cut into triangles from their first corners."""
        chosen = triangles(np.asarray(sides, int), len(corners))
        textured = bool(image) and places is not None
        faces, spots = self._faces.setdefault((None, image) if textured else (color, ""), ([], []))
        faces.append(corners[chosen])
        if textured and places is not None:
            spots.append(places[chosen])

    def mesh(self, scale=(1.0, 1.0, 1.0)) -> Mesh:
        """The mesh, its corners times the scale."""
        vertices = np.vstack([np.zeros((0, 3)), *self._vertices]) * scale
        parts = []
        for (color, image), (faces, spots) in self._faces.items():
            texture = Texture(image, np.vstack(spots)) if image else None
            parts.append(MeshPart(np.vstack(faces), color, texture))
        numbers = [part.faces for part in parts if part.faces.size]
        if not numbers or min(map(np.min, numbers)) < 0 or max(map(np.max, numbers)) >= len(vertices):
            raise UnreadableMesh("triangles with corners that do not exist")
        places = [part.texture.places for part in parts if part.texture]
        if not all(np.isfinite(array).all() for array in (vertices, *places)):
            raise UnreadableMesh("corners that are no finite numbers")
        return Mesh(vertices, tuple(part for part in parts if part.faces.size))


def triangles(sides: np.ndarray, count: int) -> np.ndarray:
    """The places of the corners of triangles in a row of polygons, each cut from its first corner.

    >>> triangles(np.array([3, 4]), 7)
    array([[0, 1, 2],
           [3, 4, 5],
           [3, 5, 6]])
    """
    if (sides < 0).any() or sides.sum() != count:
        raise UnreadableMesh("polygons with another number of corners than given")
    own = np.maximum(sides - 2, 0)
    first = np.repeat(np.cumsum(sides) - sides, own)
    step = np.arange(own.sum()) - np.repeat(np.cumsum(own) - own, own)
    return np.stack([first, first + step + 1, first + step + 2], axis=1)


def visible(color: Color) -> Color:
    """A colour within its range; an opacity of 0 is 1, since exporters write it where they mean opaque."""
    red, green, blue, opacity = (min(1.0, max(0.0, part)) for part in color)
    return red, green, blue, opacity or 1.0


#: Reads another text file that a mesh file names.
ReadFile = Callable[[str], str]
