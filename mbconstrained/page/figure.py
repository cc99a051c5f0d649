"""A drawing with its motion, as the plain data that the page's script draws."""

from __future__ import annotations

import math

import numpy as np

from ..errors import InputError
from .drawing import Body, Drawing, Link, Vector
from .keyframes import KeyFrames
from .viewer import SCENE_COMMANDS

#: Blue, vermilion, green, orange, purple and sky blue of Okabe and Ito: told apart with any kind of colour vision.
PALETTE = ("#0072b2", "#d55e00", "#009e73", "#e69f00", "#cc79a7", "#56b4e9")

#: A picture wider than this many drawing units shows nothing of its bodies, and its arithmetic would overflow.
WIDEST = 1e12

_COLORS = {"sphere": "#ffffff", "mark": "#3d4852", "rail": "#b8c2cc", "ground": "#d5dce2"}
_UPWARDS = np.array([0.0, 0.0, 1.0])  # the way a rope leaves what hangs on it


def figure_data(drawing: Drawing, frames: KeyFrames) -> dict:
    """Bodies, links, bounds of the whole motion, point of view and magnification, as lists and dicts.

    Raises:
        InputError: the motion is so large that no body could be seen.
    """
    places = {body.name: _places(drawing, body, frames) for body in drawing.bodies}
    posts = {body.name: [] for body in drawing.bodies}
    links = [_link_data(link, drawing, places, posts) for link in drawing.links]
    bounds = _bounds(drawing, places)
    return {
        "bodies": [_body_data(body, drawing, frames.names, posts[body.name]) for body in drawing.bodies],
        "links": links,
        "bounds": bounds,
        "view": _view(drawing, bounds),
        "magnification": {"scale": drawing.scale, "turn_scale": drawing.turn_scale},
        "commands": SCENE_COMMANDS,
    }


def _places(drawing: Drawing, body: Body, frames: KeyFrames) -> np.ndarray:
    places = drawing.positions(body, frames.names, frames.values)
    furthest = np.abs(places).max()
    if furthest > WIDEST:
        raise InputError(
            f'drawing: body "{body.name[:60]}" is drawn up to {furthest:.3g} units away, where nothing of it can be seen; '
            "give the drawing a smaller scale, or ask for earlier times"
        )
    return places


def _body_data(body: Body, drawing: Drawing, names: tuple[str, ...], posts: list) -> dict:
    return {
        "name": body.name,
        "label": body.label,
        "shape": body.shape,
        "rest": list(body.rest),
        "rest_turn": list(body.rest_turn),
        "size": list(body.size),
        "color": body.color or _COLORS.get(body.shape) or _usual_color(body, names),
        "teeth": body.teeth,
        "moves": _terms(body.moves, names, drawing.scale),
        "turns": _terms(body.turns, names, drawing.turn_scale),
        "posts": posts,
    }


def _usual_color(body: Body, names: tuple[str, ...]) -> str:
    """The colour of the curve of the last coordinate that moves the body, a little lighter."""
    own = [i for i, name in enumerate(names) if name in body.moves or name in body.turns]
    return _lighter(PALETTE[own[-1] % len(PALETTE)]) if own else "#9aa7b3"


def _lighter(color: str) -> str:
    """A quarter of the way to white."""
    return "#" + "".join(f"{round(0.75 * int(color[i : i + 2], 16) + 0.25 * 255):02x}" for i in (1, 3, 5))


def _terms(per_unit: dict, names: tuple[str, ...], scale: float) -> list[list[float]]:
    return [[names.index(name), *(scale * value for value in vector)] for name, vector in per_unit.items()]


def _link_data(link: Link, drawing: Drawing, places: dict, posts: dict) -> dict:
    index = {body.name: i for i, body in enumerate(drawing.bodies)}
    start, end, over = (None if name is None else drawing.bodies[index[name]] for name in (link.start, link.end, link.over))
    way = places[link.end] - places[link.start]
    leaving, arriving = (way.mean(axis=1), -way.mean(axis=1)) if over is None else (_UPWARDS, _UPWARDS)
    start_point = _attachment(start, link.offset, leaving, posts)
    end_point = _attachment(end, link.end_offset, arriving, posts)
    gap = way + np.subtract(end_point, start_point)[:, None]
    lengths = np.linalg.norm(gap, axis=0)
    return {
        "kind": link.kind,
        "start": index[link.start],
        "end": index[link.end],
        "over": None if over is None else index[link.over],
        "start_point": start_point,
        "end_point": end_point,
        "mean": float(lengths.mean()),
        "shortest": float(lengths.min()),
        "longest": float(lengths.max()),
        "coaxial": bool(np.argmax(np.abs(gap[:, 0])) == 1),
        "radius": over.size[0] / 2 if over else 0.5,
    }


def _attachment(body: Body, offset: Vector, towards: np.ndarray, posts: dict) -> list[float]:
    """Where the link meets the body, relative to its middle: on the side that faces the other end, or on a post."""
    point = np.array(offset)
    if (np.abs(point) > np.array(body.size) / 2).any():
        posts[body.name].append(point.tolist())
        return point.tolist()
    axis = int(np.argmax(np.abs(towards)))
    if body.shape in ("box", "ground") or (body.shape in ("disc", "gear") and axis == 1):
        point[axis] += math.copysign(body.size[axis] / 2, towards[axis])
    return point.tolist()


def _bounds(drawing: Drawing, places: dict) -> dict:
    """The corners of a box around everything at all key frames."""
    halves = {body.name: np.array(body.size)[:, None] / 2 for body in drawing.bodies}
    points = [places[name] + sign * half for name, half in halves.items() for sign in (-1, 1)]
    points += [places[link.start] + np.array(link.offset)[:, None] for link in drawing.links]
    points += [places[link.end] + np.array(link.end_offset)[:, None] for link in drawing.links]
    points = np.hstack(points) if points else np.array([[-0.5, 0.5]] * 3)
    return {"low": points.min(axis=1).tolist(), "high": points.max(axis=1).tolist()}


def _view(drawing: Drawing, bounds: dict) -> dict:
    """From the side and a little above: less from the side in front of a long chain, and where wheels stand behind each
    other so far round, to the left or right, that those behind come out from behind those in front."""
    places = np.array([body.rest for body in drawing.bodies] or [(0.0, 0.0, 0.0)])
    across, away = (places - places.mean(axis=0))[:, :2].T
    if np.ptp(away) > 0:
        return {"yaw": 0.72 if across @ away >= 0 else -0.72, "pitch": 0.38}
    return {"yaw": min(0.26, 1.8 / (bounds["high"][0] - bounds["low"][0])), "pitch": 0.24}
