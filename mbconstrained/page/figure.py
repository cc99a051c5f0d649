"""The figure of an animation: bodies, links, bounds, view, and the overlay of forces and impulses, as data for the page's script."""

from __future__ import annotations

import base64
import itertools
import json
import math
import re
from collections.abc import Iterable, Sequence

import numpy as np

from ..ground.errors import InputError
from .animation import Arrow, BodyPoses, DrawnEvent, ForceArrows, KeyFrames, Overlay, body_poses, packed, track
from .content import raised
from .drawing import SWITCHING, Drawing, DrawnBody, DrawnLink, Path, SliderPosing, Solid, Vector, matrix_of, quaternions_of, rotated

#: Length of the longest arrow, in drawing units; a mass is 0.8 wide.
LONGEST = 1.5

#: Radius of the arrow around an axis that stands for a moment, with its head, in drawing units.
MOMENT_RADIUS = 0.75

#: A body that moves or turns less than this in the picture (drawing units, rad) has no visible jump.
VISIBLE_JUMP = 1e-3


def overlay_data(
    overlay: Overlay, frames: KeyFrames, poses: BodyPoses, event_poses: Sequence[BodyPoses], unit: float
) -> tuple[dict, list[np.ndarray]]:
    """Forces, jumps and impulses for the page's script, with the extent of their arrows."""
    numbers = {name: i for i, name in enumerate(poses)}
    forces, events, points = [], [], []
    lengths = _lengths(_largest_forces(overlay.forces))
    for force in overlay.forces:
        arrows, first = [], frames.names.index(force.names[0])
        values = frames.values[first : first + len(force.names)]
        for arrow, factor in force.arrows:
            arrows.append({**_arrow_data(arrow, numbers, lengths), "factor": factor})
            points.append(_reached(arrow, poses[arrow.body], factor * lengths[arrow.unit] * values, unit))
        forces.append({"name": force.name, "rows": len(force.names), "arrows": arrows})
    lengths = _lengths(_largest((arrow, size) for event in overlay.events for arrow, size, _ in event.impulses))
    for event, pairs in zip(overlay.events, event_poses):
        ghosts, impulses = [], []
        for name, pair in pairs.items():
            distance = np.linalg.norm(np.ptp(pair.positions, axis=1)) / unit
            if max(distance, 2 * np.linalg.norm(np.ptp(pair.quaternions, axis=1))) > VISIBLE_JUMP:
                ghosts.append([numbers[name], *pair.positions[:, 0].tolist(), *pair.quaternions[:, 0].tolist()])
        for arrow, size, label in event.impulses:
            data = _arrow_data(arrow, numbers, lengths)
            impulses.append({**data, "size": np.asarray(size).tolist(), "label": _typeset(label)})
            values = lengths[arrow.unit] * np.repeat(np.reshape(size, (-1, 1)), 2, axis=1)
            points.append(_reached(arrow, pairs[arrow.body], values, unit))
        lines = [_typeset(line) for line in event.lines]
        events.append({"time": float(event.time), "lines": lines, "ghosts": ghosts, "impulses": impulses})
    return {"events": events, "forces": forces}, points


def _arrow_data(arrow: Arrow, numbers: dict[str, int], lengths: dict[str, float]) -> dict:
    return {
        "body": numbers[arrow.body],
        "direction": None if arrow.direction is None else arrow.unit_direction.tolist(),
        "turns": arrow.turns,
        "unit": arrow.unit,
        "point": list(arrow.point),
        "length": lengths[arrow.unit],
    }


def force_scale(forces: Sequence[ForceArrows]) -> str:
    """The size of the longest arrow of each unit, such as "longest arrow 12.5 N"; an empty string without forces."""
    sizes = [f"{size:.3g} {unit}" for unit, size in _largest_forces(forces).items() if size]
    return f"longest arrow {' or '.join(sizes)}" if sizes else ""


def _largest_forces(forces: Sequence[ForceArrows]) -> dict[str, float]:
    """The largest magnitude of all forces over all times, by unit."""
    sizes = ((force, np.linalg.norm(np.atleast_2d(force.values), axis=0).max()) for force in forces)
    return _largest((arrow, factor * size) for force, size in sizes for arrow, factor in force.arrows)


def _largest(sizes) -> dict[str, float]:
    largest: dict[str, float] = {}
    for arrow, size in sizes:
        largest[arrow.unit] = max(largest.get(arrow.unit, 0.0), float(np.linalg.norm(size)))
    return largest


def _lengths(largest: dict[str, float]) -> dict[str, float]:
    """Drawing units per unit of a force or impulse."""
    return {unit: LONGEST / (size or 1.0) for unit, size in largest.items()}


def _typeset(text: str) -> str:
    """A text with raised powers of units and true minus signs."""
    return re.sub(r"(?<![\w.])-(?=\d)", "−", raised(text))


def _reached(arrow: Arrow, poses: Path, values: np.ndarray, unit: float) -> np.ndarray:
    """The tips of a force with values (1, T) or (3, T) in drawing units; the corners of a box around a moment."""
    points = poses.of_points(np.array(arrow.point)[:, None])[:, 0] / unit
    if arrow.turns:
        return (points[:, :, None] + MOMENT_RADIUS * np.array([-1.0, 1.0])).reshape(3, -1)
    if arrow.direction is not None:
        return points + arrow.unit_direction[:, None] * values
    return points + np.einsum("ikt,kt->it", rotated(poses.quaternions, np.eye(3)), values)


#: Blue, vermilion, green, orange, purple and sky blue of Okabe and Ito: distinct with any kind of colour vision.
PALETTE = ("#0072b2", "#d55e00", "#009e73", "#e69f00", "#cc79a7", "#56b4e9")

#: A picture wider than this many drawing units shows nothing of its bodies, and its arithmetic would overflow.
WIDEST = 1e12

#: Bodies whose middles are further behind each other than this, in drawing units, are viewed from a corner.
DEPTH = 1e-6

#: A picture is flat where one extent is less than this share of the others.
FLAT = 0.3

#: An error below a tenth of a pixel is invisible where the picture is 4000 pixels wide.
INVISIBLE = 1 / 40_000

#: Length of a drawing unit in a drawing of solids, as a share of its diagonal at the first key frame.
UNIT = 1 / 8

#: An end on the surface of its body may be outside it by the rounding error of a rotation, relative to the size.
ROUNDING = 1e-9

_COLORS = {
    "sphere": "#ffffff",
    "mark": "#3d4852",
    "rail": "#b8c2cc",
    "ground": "#d5dce2",
    "base": "#d5dce2",
    "collision": "#cc79a7",
}

_UPWARDS = np.array([0.0, 0.0, 1.0])  # the direction in which a rope leaves what hangs on it


def figure_data(drawing: Drawing, takes: Sequence[KeyFrames], overlay: Overlay = Overlay()) -> dict:
    """Bodies, links, bounds of the whole motion, point of view and magnification, as lists and dicts.

    Bodies are in the lengths of the drawing, everything else in units that fit it: the thickness of a spring or the
    space for a name is the same in the picture of a finger and of a crane. Without solids that unit is 1.
    """
    poses_of_takes = [body_poses(drawing, frames) for frames in takes]
    event_poses = [body_poses(drawing, _event_frames(drawing, takes[0], event)) for event in overlay.events]
    everything = [*poses_of_takes, *event_poses]
    poses = {
        name: Path(
            np.hstack([take[name].positions for take in everything]), np.hstack([take[name].quaternions for take in everything])
        )
        for name in everything[0]
    }
    corners = [_corners(body, poses[body.name]) for body in drawing.bodies]
    unit = _unit(drawing, corners)
    for name, pose in poses.items():
        furthest = np.abs(pose.positions).max(initial=0.0) / unit
        if not furthest <= WIDEST:
            raise InputError(
                f'drawing: body "{name[:60]}" is drawn up to {furthest:.3g} units away, where nothing of it can be seen; '
                "give the drawing a smaller scale, or ask for earlier times"
            )
    posts = {body.name: [] for body in drawing.bodies}
    index = {body.name: i for i, body in enumerate(drawing.bodies)}
    links = [_link_data(link, drawing, index, poses, posts, unit) for link in drawing.links]
    overlay_entries, arrows = overlay_data(overlay, takes[0], poses_of_takes[0], event_poses, unit)
    low, high = _bounds(drawing, poses, corners, unit)
    turn = quaternions_of(np.array(drawing.turn)[:, None])
    reached = np.column_stack([low, high, *(rotated(turn, block)[:, :, 0] for block in arrows)])
    meshes, images = Stored(), Stored()
    data = {
        "bodies": [_body_data(body, i, drawing, takes[0].names, posts, meshes, images) for i, body in enumerate(drawing.bodies)],
        "meshes": meshes.items,
        "images": images.items,
        "links": links,
        "unit": unit,
        "bounds": {"low": reached.min(axis=1).tolist(), "high": reached.max(axis=1).tolist()},
        "view": _view(drawing, high - low),
        "turn": turn.ravel().tolist(),
        "magnification": {"scale": drawing.scale, "turn_scale": drawing.turn_scale},
    }
    if overlay:
        data["overlay"] = overlay_entries
    if any(link.kind == "shaft" for link in drawing.links):
        traced = [[i, list(point)] for i, body in enumerate(drawing.bodies) for point in body.traced]
        data["rotors"] = {"points": traced, "window": drawing.revolution}
    if any(link.states or link.kind in SWITCHING for link in drawing.links):
        data["switching"] = True
    if drawing.posing and drawing.posing.names:
        data["posing"] = _posing_data(drawing.posing, drawing)
    return data


def _posing_data(posing: SliderPosing, drawing: Drawing) -> dict:
    """Sliders, and for each body the coordinates that move it and its pose at rest, or None."""
    rest = {name: [*path.positions[:, 0], *path.quaternions[:, 0]] for name, path in posing.rest.items()}
    return {
        "sliders": [list(slider) for slider in zip(posing.names, posing.units, posing.limits)],
        "columns": [_rounded(row) for row in posing.columns],
        "twists": [_rounded(twist) for twist in posing.twists.T],
        "bodies": [
            {"moving": list(posing.moving[body.name]), "rest": _rounded(rest[body.name])} if body.name in rest else None
            for body in drawing.bodies
        ],
    }


def _event_frames(drawing: Drawing, frames: KeyFrames, event: DrawnEvent) -> KeyFrames:
    """Two key frames: just before the event and just after it."""
    values = np.zeros((len(frames.names), 2))
    values[: len(event.before)] = np.column_stack([event.before, event.after])
    near = int(np.argmin(np.abs(frames.times - event.time)))
    around = (path and (path if path.count == 1 else path.thinned([near, near])) for path in frames.paths)
    paths = tuple(event.paths.get(body.name, path) for body, path in zip(drawing.bodies, around))
    return KeyFrames(frames.names, np.array([event.time, event.time]), values, np.zeros_like(values), paths=paths)


def invisible_errors(drawing: Drawing, names: tuple[str, ...], figure: dict) -> tuple[np.ndarray, tuple[float, float]]:
    """The largest errors that are invisible in a figure.

    A coordinate that moves no body is listed with its value, or is the length of an arrow: its error must be 0. What a path
    turns is assumed to reach as far as the picture.
    """
    extent = figure["unit"] * max(np.subtract(figure["bounds"]["high"], figure["bounds"]["low"]))
    swings = dict.fromkeys(names, 0.0)
    for body in drawing.bodies:
        own = {*body.moves, *body.turns}
        for name in own:
            moved = drawing.scale * np.linalg.norm(body.moves.get(name, 0.0))
            turned = drawing.turn_scale * np.linalg.norm(body.turns.get(name, 0.0)) * np.linalg.norm(body.half_extent)
            swings[name] = max(swings[name], len(own) * (moved + turned))
    errors = np.array([INVISIBLE * extent / swing if swing else 0.0 for swing in swings.values()])
    return errors, (0.6 * INVISIBLE * extent, 0.4 * INVISIBLE)


def _unit(drawing: Drawing, corners: list[np.ndarray]) -> float:
    if not any(body.shape == "solids" for body in drawing.bodies):
        return 1.0
    points = np.hstack([block[:, :, 0] for block in corners])
    reach = float(np.linalg.norm(np.ptp(points, axis=1))) if points.size else 0.0
    return UNIT * reach or 1.0


def _body_data(
    body: DrawnBody, number: int, drawing: Drawing, names: tuple[str, ...], posts: dict, meshes: Stored, images: Stored
) -> dict:
    color = body.color or _COLORS.get(body.shape) or _usual_color(body, number, names)
    return {
        **{field: getattr(body, field) for field in ("name", "label", "shape", "rest", "rest_turn", "size", "teeth")},
        "color": color,
        "moves": [[names.index(name), *np.multiply(drawing.scale, move).tolist()] for name, move in body.moves.items()],
        "turns": [[names.index(name), *np.multiply(drawing.turn_scale, turn).tolist()] for name, turn in body.turns.items()],
        "posts": posts[body.name],
        "frame": body.path is not None and body.shape == "solids",
        "ellipsoid": None if body.ellipsoid is None else _rounded(body.ellipsoid),
        "solids": [_solid_data(solid, color, meshes, images) for solid in body.solids if solid.opacity > 0 and solid.corners.size],
        "collision": [_solid_data(solid, _COLORS["collision"], meshes, images) for solid in body.collision if solid.corners.size],
    }


def _usual_color(body: DrawnBody, number: int, names: tuple[str, ...]) -> str:
    """The colour of the curve of the last coordinate that moves the body, a quarter lighter; for solids, one in turn."""
    last = max((names.index(name) for name in (*body.moves, *body.turns) if name in names), default=None)
    if body.shape != "solids" and last is None:
        return "#9aa7b3"
    color = PALETTE[(number if body.shape == "solids" else last) % len(PALETTE)]
    return "#" + "".join(f"{round(0.75 * int(color[i : i + 2], 16) + 0.25 * 255):02x}" for i in (1, 3, 5))


def _corners(body: DrawnBody, poses: Path) -> np.ndarray:
    """Corners of a box around the body, shape (3, k, T): turned with it where it consists of solids."""
    if body.shape == "solids":
        return poses.of_points(np.hstack([np.zeros((3, 1)), *(solid.corners for solid in body.solids)]))
    half = body.half_extent[:, None, None]
    return poses.positions[:, None] + half * np.array([-1.0, 1.0])[:, None]


def _bounds(drawing: Drawing, poses: BodyPoses, corners: list[np.ndarray], unit: float) -> tuple[np.ndarray, np.ndarray]:
    """The corners of a box around everything at all key frames, in drawing units."""
    points = list(corners)
    for link in drawing.links:
        points += [
            end[:, None] for end in _link_ends(link, poses, link.start_point or link.offset, link.end_point or link.end_offset)
        ]
    points = [np.stack([block.min(axis=(1, 2)), block.max(axis=(1, 2))], axis=1) / unit for block in points]
    if any(drawing.turn):
        turn = quaternions_of(np.array(drawing.turn)[:, None])
        points = [rotated(turn, np.array(list(itertools.product(*block))).T)[:, :, 0] for block in points]
    ends = np.hstack(points or [np.zeros((3, 1))])
    low, high = ends.min(axis=1), ends.max(axis=1)
    margin = 0.0 if (low < high).any() else 0.5  # around a single point
    return low - margin, high + margin


def _view(drawing: Drawing, extent: np.ndarray) -> dict:
    """The view of the drawing, or an automatic one in which most is visible.

    Solids are viewed across the plane in which they lie where they are flat, from a corner otherwise.
    """
    if drawing.view is not None:
        return {"yaw": drawing.view.yaw, "pitch": drawing.view.pitch, "zoom": drawing.view.zoom}
    width, depth, height = extent
    if not any(body.shape == "solids" for body in drawing.bodies):
        return _view_of_shapes(drawing, width)
    if height < FLAT * max(width, depth):
        return {"yaw": 0.3, "pitch": 1.0}
    if depth < FLAT * width:
        return {"yaw": 0.3, "pitch": 0.25}
    return {"yaw": 1.25, "pitch": 0.25} if width < FLAT * depth else {"yaw": 0.6, "pitch": 0.36}


def _view_of_shapes(drawing: Drawing, width: float) -> dict:
    """View from the side and slightly above, adapted to long chains, motion towards the viewer and wheels behind each other."""
    turn = matrix_of(drawing.turn)
    places = np.array([body.rest for body in drawing.bodies] or [(0.0, 0.0, 0.0)]) @ turn.T
    across, depth = (places - places.mean(axis=0))[:, :2].T
    if np.ptp(depth) > DEPTH:
        return {"yaw": 0.72 if across @ depth >= 0 else -0.72, "pitch": 0.38}
    directions = [turn @ move for body in drawing.bodies for move in body.moves.values()]
    if any(abs(direction[1]) > DEPTH * np.linalg.norm(direction) for direction in directions):
        return {"yaw": 0.6, "pitch": 0.3}
    return {"yaw": min(0.26, 1.8 / max(1.0, width)), "pitch": 0.24}


def _link_data(link: DrawnLink, drawing: Drawing, index: dict[str, int], poses: BodyPoses, posts: dict, unit: float) -> dict:
    """A link for the page; an end outside its body adds a post to those of the body."""
    start, end, over = (None if name is None else drawing.bodies[index[name]] for name in (link.start, link.end, link.over))
    direction = (poses[link.end].positions - poses[link.start].positions).mean(axis=1)
    leaving, arriving = (direction, -direction) if over is None else (_UPWARDS, _UPWARDS)
    start_point = link.start_point or _attachment(start, link.offset, leaving, posts)
    end_point = link.end_point or _attachment(end, link.end_offset, arriving, posts)
    from_start, from_end = _link_ends(link, poses, start_point, end_point)
    gap = matrix_of(link.turn).T @ (from_end - from_start) / unit
    turning = link.kind in ("play", "clutch", "brake")
    limits = [-drawing.turn_scale * one if turning and one is not None else one for one in link.limits]
    if not turning and any(one is not None for one in limits):
        at_zero = np.array(end.rest) + end_point - start.rest - start_point
        limits = _limits(drawing, start, end, at_zero, (from_end - from_start).mean(axis=1), link.limits, unit)
    begins, levels = zip(*link.states) if link.states else ((), ())
    lengths = np.linalg.norm(gap, axis=0)
    return {
        "kind": link.kind,
        "start": index[link.start],
        "end": index[link.end],
        "over": None if over is None else index[link.over],
        "start_point": list(start_point),
        "end_point": list(end_point),
        "start_turns": link.start_point is not None,
        "end_turns": link.end_point is not None,
        "mean": float(lengths.mean()),
        "shortest": float(lengths.min()),
        "longest": float(lengths.max()),
        "coaxial": bool(np.argmax(np.abs(gap[:, 0])) == 1),
        "radius": over.size[0] / 2 if over else 0.5,
        "turn": quaternions_of(np.array(link.turn)[:, None]).ravel().tolist() if any(link.turn) else None,
        **({"stations": [[index[name], *rest] for name, *rest in link.stations]} if link.stations else {}),
        **({"limits": limits, "magnification": link.magnification} if link.kind in SWITCHING else {}),
        **({"states": {"begins": packed(np.array(begins), "<f8"), "levels": list(levels)}} if link.states else {}),
    }


def _limits(
    drawing: Drawing, start: DrawnBody, end: DrawnBody, at_zero: np.ndarray, direction: np.ndarray, limits, unit: float
) -> list[float | None]:
    """The lengths of a link at which it closes when it becomes shorter and longer, from its vector at zero and its mean direction."""
    moves, along = (*end.moves.values(), *start.moves.values()), direction / (np.linalg.norm(direction) or 1.0)
    away = float(np.dot(moves[0], along)) if moves else 1.0
    lengths = [None if one is None else max(float(at_zero @ along) + drawing.scale * one * away, 0.0) / unit for one in limits]
    return lengths[::-1] if away < 0 else lengths


def _link_ends(link: DrawnLink, poses: BodyPoses, start_point, end_point) -> list[np.ndarray]:
    """Positions of both ends, each (3, T): turned with the body where they are fixed in its frame."""
    ends = []
    for name, point, fixed in ((link.start, start_point, link.start_point), (link.end, end_point, link.end_point)):
        column = np.array(point, dtype=float)[:, None]
        ends.append(poses[name].positions + column if fixed is None else poses[name].of_points(column)[:, 0])
    return ends


def _attachment(body: DrawnBody, offset: Vector, towards: np.ndarray, posts: dict) -> list[float]:
    """Attachment of a link to a body, relative to its middle: on the side that faces the other end, or on a post."""
    if body.shape == "solids":
        return list(offset)
    frame = matrix_of(body.rest_turn)  # in which the body has its size and its posts
    point, towards = frame.T @ np.array(offset), frame.T @ towards
    if (np.abs(point) > np.array(body.size) / 2 * (1 + ROUNDING)).any():
        posts[body.name].append(point.tolist())
        return list(offset)
    axis = int(np.argmax(np.abs(towards)))
    if body.shape in ("box", "ground") or (body.shape in ("disc", "gear") and axis == 1):
        point[axis] += math.copysign(body.size[axis] / 2, towards[axis])
    return (frame @ point).tolist()


class Stored:
    """Data stored once in a page, with multiple uses."""

    def __init__(self) -> None:
        self.items: list = []
        self._numbers: dict[str, int] = {}

    def number(self, data) -> int:
        """Index of the data among the stored items."""
        key = json.dumps(data)
        if key not in self._numbers:
            self._numbers[key] = len(self.items)
            self.items.append(data)
        return self._numbers[key]


def _mesh_data(solid: Solid, images: Stored) -> dict:
    """A mesh; its vertices have 16 bits across its extent, at most that of the picture, and its faces the necessary number of bits."""
    vertices, faces = solid.vertices, solid.faces
    size = 2 if len(vertices) <= np.iinfo(np.uint16).max + 1 else 4
    corners = track(vertices.T, INVISIBLE * np.ptp(vertices, axis=0))
    data = {"vertices": corners, "faces": packed(faces, f"<u{size}"), "bytes": size}
    if solid.image is None or solid.places is None:
        return data
    places = track(solid.places.reshape(-1, 2).T, np.full(2, np.inf))
    return data | {"places": places, "image": images.number(base64.b64encode(solid.image).decode("ascii"))}


def _rounded(entries: Iterable[float]) -> list[float]:
    """Numbers with nine digits."""
    return [float(f"{entry:.9g}") for entry in entries]


def _solid_data(solid: Solid, color: str, meshes: Stored, images: Stored) -> dict:
    """A visible solid, with the colour of its body unless it has its own."""
    return {
        "kind": solid.kind,
        "size": list(solid.size),
        "matrix": _rounded(solid.placement.T.ravel()),
        "color": solid.color or color,
        "opacity": solid.opacity,
        "mesh": meshes.number(_mesh_data(solid, images)) if solid.kind == "mesh" else None,
    }
