"""The drawing of a robot: its links on their paths, and loops, springs and bushings between them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from .bodies import Drawing, DrawnBody, DrawnLink, Solid
from .paths import Path

#: Shares of the robot's size: thickness of plates, least width of the base plate, width of the plates under fixed points, height of a
#: mount on the ground, and radius of the ball for a link without a shape.
_PLATE, _WIDTH, _PAD, _MOUNT, _BALL = 0.012, 0.15, 0.06, 0.08, 0.014

#: Width relative to the root of a base plate under it, and of one over it, which must not hide it.
_MARGIN, _COVER = 1.2, 0.6

#: Triangles of a mesh; one with more is drawn with fewer unless all are asked for.
MOST_TRIANGLES = 20_000

#: Cells along the longest side of a mesh that is simplified, at most, and by what their number shrinks until few triangles are left.
_CELLS, _FEWER = 256, 0.8

#: Names of further bodies begin with a blank, which no link's name does.
BASE_PLATE, PAD = " base plate", " plate"


def robot_drawing(
    solids: Mapping[str, Sequence[Solid]],
    poses: Mapping[str, Any],
    connections: Iterable[Any] = (),
    *,
    scale=1.0,
    fixed=True,
    note="",
    ellipsoids: Mapping[str, np.ndarray] | None = None,
    collision: Mapping[str, Sequence[Solid]] | None = None,
) -> Drawing:
    """Every link of a robot as a body with a path."""
    placements = {name: tuple(matrix.T.ravel().tolist()) for name, matrix in (ellipsoids or {}).items()}
    connections = tuple(connections)
    paths = {name: Path(pose.positions, pose.quaternions) for name, pose in poses.items()}
    points = link_points(solids, paths)
    size = robot_size(points)
    shapeless = not any(solids.values())  # then, and for a connection at a link without a shape, a ball
    ball = Solid("sphere", (_BALL * size,))
    connected = {end for row in connections for end in (row.body1, row.body2)}
    bodies = []
    for name, path in paths.items():
        own = solids.get(name) or [ball] * (shapeless or name in connected)
        further = {"collision": tuple((collision or {}).get(name, ())), "ellipsoid": placements.get(name)}
        bodies.append(DrawnBody(name, "solids", solids=tuple(own), path=path, label=None if own else "", **further))
    bodies += [_plate(points, paths, size)] if fixed else []
    ends = [_ends(row, points, _MOUNT * size) for row in connections]
    bodies += _pads(connections, ends, size)
    if "ground" not in paths:
        bodies.append(DrawnBody("ground", "solids", label=""))
    return Drawing(tuple(bodies), tuple(_links(connections, ends)), scale, note=note)


def simplified(vertices: np.ndarray, faces: np.ndarray, most: int = MOST_TRIANGLES) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A mesh of few triangles: the vertices in each cell of a grid become one at their mean (Rossignac and Borrel 1993)."""
    low, side, cells = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max()) or 1.0, _CELLS
    while True:
        i, j, k = np.round((vertices - low) * (cells / side)).astype(int).T
        _, number, count = np.unique((i * (cells + 1) + j) * (cells + 1) + k, return_inverse=True, return_counts=True)
        a, b, c = number[faces].T
        kept = (a != b) & (b != c) & (c != a)
        if np.count_nonzero(kept) <= most:
            return np.stack([np.bincount(number, column) / count for column in vertices.T], axis=1), number[faces][kept], kept
        cells = int(_FEWER * cells)


def solids_of(visuals: Iterable[Any], *, full: bool = True) -> dict[str, list[Solid]]:
    """The solids of links, by name."""
    solids: dict[str, list[Solid]] = {}
    shared: dict[int, Solid] = {}  # by the identity of the faces, which links may share
    for visual in visuals:
        color, opacity = None, 1.0
        if visual.color is not None:
            *parts, opacity = visual.color
            color = "#" + "".join(f"{round(255 * part):02x}" for part in parts)
        own = {"placement": visual.placement, "color": color, "opacity": opacity}
        if visual.faces is None:
            solid = Solid(visual.kind, visual.size, **own)
        elif id(visual.faces) in shared:
            solid = replace(shared[id(visual.faces)], **own)
        else:
            solid = shared[id(visual.faces)] = Solid(visual.kind, **own, **_mesh_of(visual, full))
        solids.setdefault(visual.link, []).append(solid)
    return solids


def _mesh_of(visual: Any, full: bool) -> dict[str, Any]:
    """Vertices, faces and texture of a mesh or of a part of one, which has its share of the triangles that the mesh may have."""
    vertices, faces = visual.vertices, visual.faces
    image, places = (None, None) if visual.texture is None else (visual.texture.image, visual.texture.places)
    if not full and visual.triangles > MOST_TRIANGLES:
        vertices, faces, kept = simplified(vertices, faces, MOST_TRIANGLES * len(faces) // visual.triangles)
        places = None if places is None else places[kept]
    return {"vertices": vertices, "faces": faces, "image": image, "places": places}


def _plate(points: Mapping[str, np.ndarray], paths: Mapping[str, Path], size: float) -> DrawnBody:
    """A plate under the first link, which is the root, or over it where the other links hang from it."""
    names = list(points)
    rests = bool(names) and not paths[names[0]].moves
    root = points[names[0]][:, :, 0] if rests else np.zeros((3, 1))
    low, high = root.min(axis=1), root.max(axis=1)
    heights = np.concatenate([block[2, :, 0] for block in points.values()] or [root[2]])
    hangs = low[2] - heights.min() > max(heights.max() - high[2], _WIDTH * size)
    width, depth = np.maximum((_COVER if hangs else _MARGIN) * (high - low)[:2], _WIDTH * size)
    thickness = _PLATE * size
    level = high[2] + thickness / 2 if hangs else low[2] - thickness / 2
    middle = (low + high) / 2
    return DrawnBody(BASE_PLATE, "base", (middle[0], middle[1], level), size=(width, depth, thickness))


_Point = tuple[float, ...]


def _ends(row: Any, points: Mapping[str, np.ndarray], height: float) -> tuple[_Point, _Point]:
    """The points that a connection is drawn between: those of a mount on the ground coincide, and its foot is moved out of the body."""
    ends, bodies = [list(map(float, point)) for point in (row.point1, row.point2)], (row.body1, row.body2)
    if row.kind == "bushing" and bodies.count("ground") == 1:
        foot, body = bodies.index("ground"), points.get(bodies[1 - bodies.index("ground")])
        is_above = body is None or body[2, :, 0].mean() >= ends[foot][2]
        ends[foot][2] -= height if is_above else -height
    return tuple(ends[0]), tuple(ends[1])


def _pads(connections: tuple[Any, ...], ends: Sequence[tuple[_Point, _Point]], size: float) -> list[DrawnBody]:
    """A small plate under each point that is fixed to the ground."""
    attached = [(name, point) for row, two in zip(connections, ends) for name, point in zip((row.body1, row.body2), two)]
    points = dict.fromkeys(point for name, point in attached if name == "ground")
    width, thickness = _PAD * size, _PLATE * size
    places = [(x, y, z - thickness / 2) for x, y, z in points]
    return [DrawnBody(f"{PAD} {i}", "base", place, size=(width, width, thickness)) for i, place in enumerate(places, start=1)]


def _links(connections: tuple[Any, ...], ends: Sequence[tuple[_Point, _Point]]) -> Iterable[DrawnLink]:
    between: dict[tuple, list[Any]] = {}
    for row, points in zip(connections, ends):
        kind = "strut" if row.kind in ("spring", "damper") else row.kind
        between.setdefault((kind, row.body1, row.body2, *points), []).append(row)
    for (_, start, end, start_point, end_point), rows in between.items():
        kinds = {row.kind for row in rows}
        kind = "strut" if kinds == {"spring", "damper"} else rows[0].kind
        yield DrawnLink(rows[0].name, kind, start, end, start_point=start_point, end_point=end_point)


def link_points(solids: Mapping[str, Sequence[Solid]], poses: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The origin of each link, then the corners of its solids."""
    points = {}
    for name, pose in poses.items():
        corners = np.hstack([np.zeros((3, 1)), *(solid.corners for solid in solids.get(name, ()))])
        points[name] = Path(pose.positions, pose.quaternions).of_points(corners)
    return points


def robot_size(points: Mapping[str, np.ndarray]) -> float:
    """Diagonal of a box around all points at the first time; 1 for a single point.

    >>> robot_size({"arm": np.array([[0.0, 3.0], [0.0, 0.0], [0.0, 4.0]])[:, :, None]})
    5.0
    """
    first = np.hstack([block[:, :, 0] for block in points.values()] or [np.zeros((3, 1))])
    return float(np.linalg.norm(np.ptp(first, axis=1))) or 1.0
