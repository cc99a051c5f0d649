"""A mesh in parts, each of one colour or texture, as the readers of mesh files give it."""

from __future__ import annotations

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
    """Triangles, collected by how they look; ``mesh`` gives the parts."""

    def __init__(self) -> None:
        self._vertices: list[np.ndarray] = [np.zeros((0, 3))]
        self._count = 0
        self._faces: dict[tuple[Color | None, str], tuple[list[np.ndarray], list[np.ndarray]]] = {}

    def add_vertices(self, vertices: np.ndarray) -> int:
        """The number of the first one of further corners (k, 3)."""
        self._vertices.append(vertices)
        self._count += len(vertices)
        return self._count - len(vertices)

    def add_faces(self, start: int, faces: np.ndarray, color: Color | None = None, image: str = "", places=None) -> None:
        """Triangles of corners counted from ``start``; an image is shown where the places of the corners in it are given."""
        if faces.size and not 0 <= faces.min() <= faces.max() < self._count - start:
            raise UnreadableMesh("triangles with corners that do not exist")
        shown = bool(image) and places is not None
        corners, spots = self._faces.setdefault((None, image) if shown else (color, ""), ([], []))
        corners.append(faces.reshape(-1, 3) + start)
        spots += [places.reshape(-1, 3, 2)] if shown else []

    def mesh(self, scale=(1.0, 1.0, 1.0)) -> Mesh:
        """The mesh, its corners times the scale."""
        vertices, parts = np.vstack(self._vertices) * scale, []
        for (color, image), (faces, places) in self._faces.items():
            if sum(map(len, faces)):
                parts.append(MeshPart(np.vstack(faces), color, Texture(image, np.vstack(places)) if image else None))
        if not parts:
            raise UnreadableMesh("no triangles")
        if not all(np.isfinite(array).all() for array in (vertices, *(part.texture.places for part in parts if part.texture))):
            raise UnreadableMesh("corners that are no finite numbers")
        return Mesh(vertices, tuple(parts))


def visible(color: Color) -> Color:
    """A colour within its range; an opacity of 0 is 1, since exporters write it where they mean opaque."""
    red, green, blue, opacity = (min(1.0, max(0.0, part)) for part in color)
    return red, green, blue, opacity or 1.0
