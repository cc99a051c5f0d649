"""A drawing: bodies and links in space, and how the coordinates move and turn them. Pure data, no viewer.

Axes: x to the right, y away from the viewer, z up. A body is at

    rest + scale * sum_i moves[i] q_i          turned by the rotation vector  turn_scale * sum_i turns[i] q_i  after rest_turn

so a drawing says nothing about time: the values of the coordinates do. Where that is not how a body moves, as with the
links of a robot, it has a path instead: its poses at the times of the animation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from ..checks import nearest, real_array, real_number, whole_number
from ..errors import InputError
from .parts import Part, checked_color
from .path import Path
from .rotation import matrix_of

Shape = Literal["box", "sphere", "disc", "gear", "ring", "mark", "rail", "ground", "base", "parts"]
LinkKind = Literal["spring", "damper", "strut", "rod", "bushing", "loop", "torsion spring", "torsion damper", "belt"]
Vector = tuple[float, float, float]

SHAPES: tuple[str, ...] = get_args(Shape)
LINK_KINDS: tuple[str, ...] = get_args(LinkKind)

_USUAL_SIZE = {
    "box": (0.8, 0.8, 0.8),
    "sphere": (0.24, 0.24, 0.24),
    "mark": (0.12, 0.12, 0.12),
    "rail": (4.0, 0.12, 0.05),
    "ground": (0.2, 1.2, 1.4),
    "base": (1.2, 1.2, 0.1),
    "parts": (1.0, 1.0, 1.0),
}
_UNNAMED = ("mark", "rail", "ground", "base")


@dataclass(frozen=True)
class Body:
    """Something that is drawn at a place that the coordinates move.

    Attributes:
        name: differs from the other bodies' names.
        shape: "box" (a mass), "sphere" (a massless joint), "disc", "gear" or "ring" (an inertia, a toothed wheel, a wheel
            with teeth inside; its axis is y), "mark" (a point such as a pivot), "rail" (along which a body moves),
            "ground" (a hatched wall), "base" (a hatched plate that lies flat), "parts" (what its parts are).
        rest: place where all coordinates are zero, in drawing units.
        moves: coordinate name -> displacement in drawing units per unit of the coordinate.
        turns: coordinate name -> rotation vector in rad per unit of the coordinate; (0, -1, 0) is counter-clockwise.
        size: extent along x, y and z in drawing units, None for the usual one; along x it is the diameter of a wheel.
        color: "#rrggbb", or None for the usual colour.
        label: text beside the body; None for its name, or nothing beside a mark, a rail or the ground.
        rest_turn: rotation vector in rad where all coordinates are zero.
        teeth: number of teeth of a gear or ring.
        parts: solids of a body of the shape "parts"; its size is of no account then.
        path: its poses at the times of the animation; rest, moves and turns are of no account then.

    >>> Body("cart", rest=(1, 0, 0), moves={"x1": (1, 0, 0)}).shape
    'box'
    """

    name: str
    shape: Shape = "box"
    rest: Vector = (0.0, 0.0, 0.0)
    moves: Mapping[str, Vector] = field(default_factory=dict)
    turns: Mapping[str, Vector] = field(default_factory=dict)
    size: Vector | None = None
    color: str | None = None
    label: str | None = None
    rest_turn: Vector = (0.0, 0.0, 0.0)
    teeth: int = 24
    parts: tuple[Part, ...] = ()
    path: Path | None = None

    def __post_init__(self):
        where = f'body "{_short(self.name)}"'
        _one_of(self.shape, SHAPES, f"{where}, shape")
        usual = {"size": self.size or _USUAL_SIZE.get(self.shape, (1.2, 0.3, 1.2))}
        usual["label"] = self.label if self.label is not None else "" if self.shape in _UNNAMED else self.name
        for attribute, value in usual.items():
            object.__setattr__(self, attribute, value)
        for attribute in ("rest", "rest_turn", "size"):
            object.__setattr__(self, attribute, _vector(getattr(self, attribute), f"{where}, {attribute}"))
        for attribute in ("moves", "turns"):
            object.__setattr__(self, attribute, _vectors(getattr(self, attribute), f"{where}, {attribute}"))
        if min(self.size) <= 0:
            raise InputError(f"{where}, size: found {min(self.size):g}; expected numbers greater than zero")
        checked_color(self.color, f"{where}, color")
        object.__setattr__(self, "parts", tuple(self.parts))
        whole_number(self.teeth, f"{where}, teeth", minimum=3)

    @property
    def half_extent(self) -> np.ndarray:
        """Half of a box around it along x, y, z, shape (3,), as it is turned at rest; its parts are of no account."""
        half = np.array(self.size) / 2
        if not any(self.rest_turn):
            return half
        rotation = matrix_of(self.rest_turn)
        if self.shape not in ("disc", "gear", "ring"):
            return np.abs(rotation) @ half
        axis = rotation[:, 1]
        return half[0] * np.sqrt(np.maximum(0.0, 1 - axis**2)) + half[1] * np.abs(axis)


@dataclass(frozen=True)
class Link:
    """Something that connects two bodies and follows them.

    Attributes:
        name: for messages.
        kind: "spring", "damper", "strut" (a spring around a damper), "rod", "bushing" (a soft block), "loop" (a ball on
            the end's body in a socket on the start's, so that a gap is seen), "torsion spring", "torsion damper" or "belt".
        start, end: names of the bodies. Between wheels on one axis a torsion spring is a helix, otherwise a spiral from
            its start to the hub at its end.
        offset: shift of both ends across the link, so that links side by side do not overlap; an end that is shifted
            out of its body is joined to it by a post.
        end_offset: shift of the end where it differs from that of the start.
        over: for a belt, the name of the wheel that it runs over.
        start_point, end_point: where it is fixed in the frames of the bodies, with which these points turn; None for the
            side of the body that faces the other end, shifted by the offset, which does not turn.
        turn: rotation vector (rad) of the frame in which it is drawn: wheels that it joins have their axes along the y axis
            of this frame.
    """

    name: str
    kind: LinkKind
    start: str
    end: str
    offset: Vector = (0.0, 0.0, 0.0)
    end_offset: Vector | None = None
    over: str | None = None
    start_point: Vector | None = None
    end_point: Vector | None = None
    turn: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self):
        where = f'link "{_short(self.name)}"'
        _one_of(self.kind, LINK_KINDS, f"{where}, kind")
        object.__setattr__(self, "offset", _vector(self.offset, f"{where}, offset"))
        object.__setattr__(self, "turn", _vector(self.turn, f"{where}, turn"))
        end_offset = self.offset if self.end_offset is None else _vector(self.end_offset, f"{where}, end_offset")
        object.__setattr__(self, "end_offset", end_offset)
        for attribute in ("start_point", "end_point"):
            if getattr(self, attribute) is not None:
                object.__setattr__(self, attribute, _vector(getattr(self, attribute), f"{where}, {attribute}"))


@dataclass(frozen=True)
class View:
    """A direction from which a drawing is looked at.

    Attributes:
        yaw: how far round to the right one stands, in rad; 0 is in front.
        pitch: how far up, in rad; 0 is level.
        zoom: how much closer than where all of the motion is seen.
    """

    yaw: float = 0.0
    pitch: float = 0.0
    zoom: float = 1.0


@dataclass(frozen=True)
class Drawing:
    """Bodies and links, and how much larger than true their motion is drawn.

    Attributes:
        scale, turn_scale: magnification of the displacements and of the angles; both are told on the page.
        note: a sentence shown with the picture, or an empty string.
        view: from where it is looked at, or None for where most is seen.
        turn: rotation vector (rad) by which all of it is turned, after everything else.

    Raises:
        InputError: two bodies of one name, a link to an unknown body, or a magnification that is not a number.
    """

    bodies: tuple[Body, ...]
    links: tuple[Link, ...] = ()
    scale: float = 1.0
    turn_scale: float = 1.0
    note: str = ""
    view: View | None = None
    turn: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self):
        object.__setattr__(self, "bodies", tuple(self.bodies))
        object.__setattr__(self, "links", tuple(self.links))
        object.__setattr__(self, "scale", real_number(self.scale, "drawing, scale"))
        object.__setattr__(self, "turn_scale", real_number(self.turn_scale, "drawing, turn_scale"))
        object.__setattr__(self, "turn", _vector(self.turn, "drawing, turn"))
        names = Counter(body.name for body in self.bodies)
        for name, count in names.items():
            if count > 1:
                raise InputError(f'drawing: two bodies are named "{_short(name)}"; names must differ')
        for link in self.links:
            for name in filter(None, (link.start, link.end, link.over)):
                if name not in names:
                    raise InputError(
                        f'drawing: link "{_short(link.name)}" is tied to "{_short(name)}", which is no body{nearest(name, names)}'
                    )

    @property
    def coordinates(self) -> frozenset[str]:
        """Names of the coordinates that move something."""
        return frozenset(name for body in self.bodies for name in (*body.moves, *body.turns))

    def positions(self, body: Body, names: Iterable[str], values: np.ndarray) -> np.ndarray:
        """Where a body is drawn, shape (3, T), when the coordinates have the values (r, T)."""
        place = np.array(body.rest)[:, None] + np.zeros((3, values.shape[1]))
        for name, row in zip(names, values):
            if name in body.moves:
                place += self.scale * np.outer(body.moves[name], row)
        return place


def _vector(value, what: str) -> Vector:
    return tuple(real_array(value, what, shape=(3,)).tolist())


def _vectors(value, what: str) -> dict[str, Vector]:
    return {str(name): _vector(vector, f'{what}, "{_short(name)}"') for name, vector in dict(value).items()}


def _one_of(word: str, known: tuple[str, ...], what: str) -> None:
    if word not in known:
        raise InputError(f"{what}: found {_short(word)}; expected one of {', '.join(known)}{nearest(word, known)}")


def _short(text: object) -> str:
    text = str(text)
    return text if len(text) <= 60 else text[:57] + "..."
