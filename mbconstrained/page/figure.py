"""A drawing with its motion, as the plain data that the page's script draws."""

from __future__ import annotations

import itertools

import numpy as np

from ..errors import InputError
from .drawing import Body, Drawing
from .figure_links import link_data, outermost_ends
from .keyframes import KeyFrames
from .meshes import Meshes, parts_data
from .poses import KeyPoses, body_poses
from .rotation import matrix_of, quaternions_of, rotated
from .viewer import SCENE_COMMANDS

#: Blue, vermilion, green, orange, purple and sky blue of Okabe and Ito: told apart with any kind of colour vision.
PALETTE = ("#0072b2", "#d55e00", "#009e73", "#e69f00", "#cc79a7", "#56b4e9")

#: A picture wider than this many drawing units shows nothing of its bodies, and its arithmetic would overflow.
WIDEST = 1e12

#: Bodies whose middles are further behind each other than this, in drawing units, are seen from a corner.
AWAY = 1e-6

#: A picture is flat where one extent is less than this share of the others.
_FLAT = 0.3

_COLORS = {"sphere": "#ffffff", "mark": "#3d4852", "rail": "#b8c2cc", "ground": "#d5dce2", "base": "#d5dce2"}


#: A tenth of a pixel where the picture is 4000 pixels wide.
UNSEEN = 1 / 40_000

#: How long a drawing unit is in a drawing of parts: this share of its diagonal at the first key frame.
UNIT = 1 / 8


def figure_data(drawing: Drawing, *takes: KeyFrames) -> dict:
    """Bodies, links, bounds of the whole motion, point of view and magnification, as lists and dicts.

    Bodies are in the lengths of the drawing, everything else in units that fit it: the thickness of a spring or the
    room for a name is the same in the picture of a finger and of a crane. Without parts that unit is 1.

    Args:
        drawing: bodies and links.
        takes: key frames of one motion, or of several that the page shows in turn in the same picture.

    Raises:
        InputError: the motion is so large that no body could be seen.
    """
    poses = {body.name: body_poses(drawing, takes, i) for i, body in enumerate(drawing.bodies)}
    unit = _unit(drawing, poses)
    _seen(poses, unit)
    posts = {body.name: [] for body in drawing.bodies}
    links = [link_data(link, drawing, poses, posts, unit) for link in drawing.links]
    bounds = _bounds(drawing, poses, unit)
    meshes = Meshes()
    names = takes[0].names if takes else ()
    return {
        "bodies": [_body_data(body, i, drawing, names, posts, meshes) for i, body in enumerate(drawing.bodies)],
        "meshes": meshes.data,
        "links": links,
        "unit": unit,
        "bounds": bounds,
        "view": _view(drawing, bounds),
        "turn": quaternions_of(np.array(drawing.turn)[:, None])[:, 0].tolist(),
        "magnification": {"scale": drawing.scale, "turn_scale": drawing.turn_scale},
        "commands": SCENE_COMMANDS,
    }


def unseen_errors(drawing: Drawing, names: tuple[str, ...], figure: dict) -> tuple[np.ndarray, tuple[float, float]]:
    """By how much coordinates (r,), and places and orientations on paths, may be off without it being seen in a figure.

    A coordinate that moves no body is told, or is the length of an arrow: it may not be off at all. What a path turns is
    taken to reach as far as the picture.
    """
    extent = figure["unit"] * max(np.subtract(figure["bounds"]["high"], figure["bounds"]["low"]))
    swings = dict.fromkeys(names, 0.0)
    for body in drawing.bodies:
        own = {*body.moves, *body.turns}
        for name in own:
            moved = drawing.scale * np.linalg.norm(body.moves.get(name, 0.0))
            turned = drawing.turn_scale * np.linalg.norm(body.turns.get(name, 0.0)) * np.linalg.norm(body.half_extent)
            swings[name] = max(swings[name], len(own) * (moved + turned))
    errors = np.array([UNSEEN * extent / swing if swing else 0.0 for swing in swings.values()])
    return errors, (0.6 * UNSEEN * extent, 0.4 * UNSEEN)


def _unit(drawing: Drawing, poses: dict[str, KeyPoses]) -> float:
    if not any(body.shape == "parts" for body in drawing.bodies):
        return 1.0
    points = np.hstack([_corners(body, poses[body.name].first)[:, :, 0] for body in drawing.bodies])
    reach = float(np.linalg.norm(np.ptp(points, axis=1))) if points.size else 0.0
    return UNIT * reach or 1.0


def _seen(poses: dict[str, KeyPoses], unit: float) -> None:
    for name, pose in poses.items():
        furthest = np.abs(pose.positions).max(initial=0.0) / unit
        if furthest > WIDEST:
            raise InputError(
                f'drawing: body "{name[:60]}" is drawn up to {furthest:.3g} units away, where nothing of it can be seen; '
                "give the drawing a smaller scale, or ask for earlier times"
            )


def _body_data(body: Body, number: int, drawing: Drawing, names: tuple[str, ...], posts: dict, meshes: Meshes) -> dict:
    color = body.color or _COLORS.get(body.shape) or _usual_color(body, number, names)
    return {
        "name": body.name,
        "label": body.label,
        "shape": body.shape,
        "rest": list(body.rest),
        "rest_turn": list(body.rest_turn),
        "size": list(body.size),
        "color": color,
        "teeth": body.teeth,
        "moves": _terms(body.moves, names, drawing.scale),
        "turns": _terms(body.turns, names, drawing.turn_scale),
        "posts": posts[body.name],
        "parts": parts_data(body.parts, color, meshes),
    }


def _usual_color(body: Body, number: int, names: tuple[str, ...]) -> str:
    """The colour of the curve of the last coordinate that moves the body, a little lighter; for parts, one in turn."""
    if body.shape == "parts":
        return _lighter(PALETTE[number % len(PALETTE)])
    own = [i for i, name in enumerate(names) if name in body.moves or name in body.turns]
    return _lighter(PALETTE[own[-1] % len(PALETTE)]) if own else "#9aa7b3"


def _lighter(color: str) -> str:
    """A quarter of the way to white."""
    return "#" + "".join(f"{round(0.75 * int(color[i : i + 2], 16) + 0.25 * 255):02x}" for i in (1, 3, 5))


def _terms(per_unit: dict, names: tuple[str, ...], scale: float) -> list[list[float]]:
    return [[names.index(name), *(scale * value for value in vector)] for name, vector in per_unit.items()]


def _corners(body: Body, poses: KeyPoses) -> np.ndarray:
    """Corners of a box around the body, shape (3, k, T): turned with it where it consists of parts."""
    if body.shape == "parts":
        return poses.of_points(np.hstack([np.zeros((3, 1)), *(part.corners for part in body.parts)]))
    half = body.half_extent[:, None, None]
    return poses.positions[:, None] + half * np.array([-1.0, 1.0])[:, None]


def _bounds(drawing: Drawing, poses: dict[str, KeyPoses], unit: float) -> dict:
    """The corners of a box around everything at all key frames, in drawing units."""
    points = [_corners(body, poses[body.name]) for body in drawing.bodies]
    for link in drawing.links:
        points += [end[:, None] for end in outermost_ends(link, poses)]
    points = [np.stack([ends.min(axis=(1, 2)), ends.max(axis=(1, 2))], axis=1) / unit for ends in points]
    if any(drawing.turn):
        turn = quaternions_of(np.array(drawing.turn)[:, None])
        points = [rotated(turn, np.array(list(itertools.product(*ends))).T)[:, :, 0] for ends in points]
    points = np.hstack(points or [np.zeros((3, 1))])
    low, high = points.min(axis=1), points.max(axis=1)
    room = 0.0 if (low < high).any() else 0.5  # around what is a point
    return {"low": (low - room).tolist(), "high": (high + room).tolist()}


def _view(drawing: Drawing, bounds: dict) -> dict:
    """The view of the drawing itself, or one in which most is seen."""
    if drawing.view is not None:
        return {"yaw": drawing.view.yaw, "pitch": drawing.view.pitch, "zoom": drawing.view.zoom}
    if any(body.shape == "parts" for body in drawing.bodies):
        return _view_of_parts(bounds)
    return _view_of_shapes(drawing, bounds)


def _view_of_parts(bounds: dict) -> dict:
    """Across the plane in which it lies where it is flat, from a corner otherwise."""
    width, depth, height = np.subtract(bounds["high"], bounds["low"])
    if height < _FLAT * max(width, depth):
        return {"yaw": 0.3, "pitch": 1.0}
    if depth < _FLAT * width:
        return {"yaw": 0.3, "pitch": 0.25}
    return {"yaw": 1.25, "pitch": 0.25} if width < _FLAT * depth else {"yaw": 0.6, "pitch": 0.36}


def _view_of_shapes(drawing: Drawing, bounds: dict) -> dict:
    """From the side and a little above: less from the side in front of a long chain, more where something moves away from the
    viewer; and where wheels stand behind each other so far round, to the left or right, that those behind come out from
    behind those in front."""
    turn = matrix_of(drawing.turn)
    places = np.array([body.rest for body in drawing.bodies] or [(0.0, 0.0, 0.0)]) @ turn.T
    across, away = (places - places.mean(axis=0))[:, :2].T
    if np.ptp(away) > AWAY:
        return {"yaw": 0.72 if across @ away >= 0 else -0.72, "pitch": 0.38}
    ways = [turn @ move for body in drawing.bodies for move in body.moves.values()]
    if any(abs(way[1]) > AWAY * np.linalg.norm(way) for way in ways):
        return {"yaw": 0.6, "pitch": 0.3}
    return {"yaw": min(0.26, 1.8 / max(1.0, bounds["high"][0] - bounds["low"][0])), "pitch": 0.24}
