"""A drawing of a robot: its links where their paths put them, and loops, springs and bushings between them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..drawing import Body, Drawing, Link
from ..parts import Part
from ..path import Path
from .robot_points import link_points, robot_size

#: Shares of the robot's size: thickness of plates, least width of that at the root, width of those under fixed points, and
#: radius of the ball that stands for a link without a shape.
_PLATE, _WIDTH, _PAD, _BALL = 0.012, 0.15, 0.06, 0.014

#: How much wider than the root a plate under it is, and how much narrower one over it, which would hide it.
_MARGIN, _COVER = 1.2, 0.6

#: What is drawn besides the links begins with a blank, which no link's name does.
BASE_PLATE, PAD = " base plate", " plate"


def robot_drawing(
    parts: Mapping[str, Sequence[Part]],
    poses: Mapping[str, Any],
    connections: Iterable[Any] = (),
    *,
    scale=1.0,
    fixed=True,
    note="",
) -> Drawing:
    """Every link of a robot as a body with a path.

    Args:
        parts: of the links that are drawn, by name, as ``parts_of`` makes them.
        poses: by link name, the root first, positions (3, T) and quaternions (4, T), as ``Robot.poses()`` gives them.
        connections: each with name, kind ("loop", "spring", "damper" or "bushing"), body1, point1, body2 and point2, as
            ``Robot.connection_points()`` gives them; a spring and a damper between the same points become a strut.
        scale: how much larger than true the paths already are; the page tells it.
        fixed: whether the root stands on the ground; then a hatched plate is drawn under it.
        note: a sentence shown with the picture.
    """
    connections = tuple(connections)
    paths = {name: Path(pose.positions, pose.quaternions) for name, pose in poses.items()}
    points = link_points(parts, paths)
    size = robot_size(points)
    shown = _filled(parts, paths, {end for row in connections for end in (row.body1, row.body2)}, size)
    bodies = [_body(name, shown[name], path) for name, path in paths.items()]
    bodies += [_plate(points, paths, size)] if fixed else []
    bodies += _pads(connections, size)
    if "ground" not in paths:
        bodies.append(Body("ground", "parts", label=""))
    return Drawing(bodies, tuple(_links(connections)), scale, note=note)


def parts_of(visuals: Iterable[Any]) -> dict[str, list[Part]]:
    """What links are drawn with, by name.

    Args:
        visuals: each with link, kind, size, placement, color (r, g, b, a from 0 to 1, or None), vertices and faces, as
            ``Robot.visuals()`` gives them.
    """
    parts = {}
    for visual in visuals:
        parts.setdefault(visual.link, []).append(_part(visual))
    return parts


def _part(visual) -> Part:
    red, green, blue, opacity = (None, None, None, 1.0) if visual.color is None else visual.color
    color = None if red is None else "#" + "".join(f"{round(255 * min(1.0, max(0.0, c))):02x}" for c in (red, green, blue))
    size = () if visual.kind == "mesh" else visual.size
    return Part(visual.kind, size, visual.placement, color, opacity, visual.vertices, visual.faces)


def _body(name: str, parts: Sequence[Part], path: Path) -> Body:
    return Body(name, "parts", parts=parts, path=path, label=None if parts else "")


def _filled(parts: Mapping[str, Sequence[Part]], names: Iterable[str], connected: set[str], size: float) -> dict:
    """The parts of all links: a ball for one without a shape, where something is tied to it or no link has a shape."""
    shapeless = not any(parts.values())
    ball = [Part("sphere", (_BALL * size,))]
    return {name: parts.get(name) or (ball if shapeless or name in connected else []) for name in names}


def _plate(points: Mapping[str, np.ndarray], paths: Mapping[str, Path], size: float) -> Body:
    """A plate under the first link, which is the root, or over it where the others hang from it."""
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
    return Body(BASE_PLATE, "base", (middle[0], middle[1], level), size=(width, depth, thickness))


def _pads(connections: tuple[Any, ...], size: float) -> list[Body]:
    """A small plate under each point that is fixed to the ground."""
    tied = [(row.body1, row.point1) for row in connections] + [(row.body2, row.point2) for row in connections]
    points = dict.fromkeys(_vector(point) for name, point in tied if name == "ground")
    width, thickness = _PAD * size, _PLATE * size
    places = [(x, y, z - thickness / 2) for x, y, z in points]
    return [Body(f"{PAD} {i}", "base", place, size=(width, width, thickness)) for i, place in enumerate(places, start=1)]


def _links(connections: tuple[Any, ...]) -> Iterable[Link]:
    between: dict[tuple, list[Any]] = {}
    for row in connections:
        kind = "strut" if row.kind in ("spring", "damper") else row.kind
        between.setdefault((kind, row.body1, row.body2, _vector(row.point1), _vector(row.point2)), []).append(row)
    for (_, start, end, start_point, end_point), rows in between.items():
        kinds = {row.kind for row in rows}
        kind = "strut" if kinds == {"spring", "damper"} else rows[0].kind
        yield Link(rows[0].name, kind, start, end, start_point=start_point, end_point=end_point)


def _vector(point) -> tuple[float, float, float]:
    return tuple(float(value) for value in point)
