"""Meshes of Wavefront files (.obj) with the colours and names of textures of their material files (.mtl)."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import numpy as np

from .mesh_parts import Color, Mesh, ReadFile, Surfaces, UnreadableMesh, visible


def wavefront_mesh(text: str, read: ReadFile, scale=(1.0, 1.0, 1.0)) -> Mesh:
    """The mesh of a Wavefront file: its polygons, without lines, points and curves."""
    vertices: list[list[str]] = []
    spots: list[list[str]] = []
    polygons: dict[str, list[list[tuple[int, int]]]] = {}  # by the name of the material
    materials: dict[str, tuple[Color | None, str]] = {}
    libraries: set[str] = set()
    own = polygons.setdefault("", [])
    for key, rest in _lines(text):
        if key == "v":
            vertices.append(rest.split()[:3])
        elif key == "vt":
            spots.append(rest.split()[:2])
        elif key == "f":
            own.append([_corner(corner, len(vertices), len(spots)) for corner in rest.split()])
        elif key == "usemtl":
            own = polygons.setdefault(rest, [])
        elif key == "mtllib" and rest not in libraries:
            libraries.add(rest)
            materials |= _materials(read(rest))
    surfaces, places = Surfaces(), _table(spots, 2)
    surfaces.add_vertices(_table(vertices, 3))
    for name, rows in polygons.items():
        table = np.array(list(chain.from_iterable(rows)), int).reshape(-1, 2)
        color, image = materials.get(name, (None, ""))
        numbers = table[:, 1]
        shown = bool(image) and bool(table.size) and 0 <= numbers.min() and numbers.max() < len(places)
        surfaces.add_polygons([len(row) for row in rows], table[:, 0], color, image, places[numbers] if shown else None)
    return surfaces.mesh(scale)


def _lines(text: str) -> Iterator[tuple[str, str]]:
    """First word and rest of each line; one that ends in a backslash goes on in the next."""
    for line in text.replace("\\\r\n", " ").replace("\\\n", " ").splitlines():
        key, _, rest = line.strip().replace("\t", " ").partition(" ")
        yield key, rest.strip()


def _corner(text: str, vertices: int, spots: int) -> tuple[int, int]:
    """Numbers, counted from 0, of the vertex and of the place in the texture, -1 without one; negative ones count from the last."""
    vertex, _, others = text.partition("/")
    spot = others.partition("/")[0]
    return _number(vertex, vertices), _number(spot, spots) if spot else -1


def _number(text: str, count: int) -> int:
    try:
        number = int(text)
    except ValueError:
        raise UnreadableMesh(f"found {text[:40]!a} instead of a whole number") from None
    if not 0 < abs(number) <= count:
        raise UnreadableMesh("corners that do not exist")
    return number - 1 if number > 0 else count + number


def _table(rows: list[list[str]], width: int) -> np.ndarray:
    try:
        table = np.array(rows, float) if rows else np.zeros((0, width))
    except ValueError:
        table = np.zeros(0)
    if table.shape[1:] != (width,):
        raise UnreadableMesh(f"found a line without {width} numbers")
    return table


def _materials(text: str) -> dict[str, tuple[Color | None, str]]:
    """Colour and name of the texture of each material of a material file; lines that make no sense are left out."""
    values: dict[str, dict[str, str]] = {}
    own: dict[str, str] = {}
    for key, rest in _lines(text):
        if key == "newmtl":
            own = values.setdefault(rest, {})
        else:
            own[key] = rest
    return {name: (_color(entries), _image(entries.get("map_Kd", ""))) for name, entries in values.items()}


def _color(entries: dict[str, str]) -> Color | None:
    try:
        red, green, blue = map(float, entries["Kd"].split()[:3])
        return visible((red, green, blue, float(entries["d"] if "d" in entries else 1 - float(entries.get("Tr", "0")))))
    except (KeyError, ValueError):
        return None


def _image(rest: str) -> str:
    """The file of a texture, behind its options, whose values have no blanks."""
    return rest.split()[-1] if rest.startswith("-") else rest
