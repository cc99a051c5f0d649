"""Rigid bars that are displaced and turn: each lies across, with what its points are attached to below it.

A bar is a ``RigidBar``, or an inertia and a mass of which constraint rows x_point - x - d q = 0 make one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...ground.coordinate_units import GROUND
from ...models.elements import Body as ModelBody
from ...models.elements import Element, Relation
from ...models.rigid_bar import RigidBar
from .bodies import Body, Link, Shape, Solid, Vector
from .chains import BALL, Chain
from .joints import Joint, groups, walk
from .orientation import turned_piece
from .pieces import Piece

#: Length between the outermost points of the longest bar, least distance of points, and longest bar, drawing units.
LENGTH, CLOSEST, LONGEST = 5.0, 1.5, 14.0

#: Height and depth of a bar, its overhang at its ends, and the distance to the bar above, drawing units.
HEIGHT, DEPTH, OVERHANG, STOREY = 0.4, 0.6, 0.45, 2.4


@dataclass(frozen=True)
class Bar:
    """A rigid bar of the model: names of its displacement, angle and rows, and its points with their distances in m."""

    name: str
    angle: str
    points: Mapping[str, float]
    rows: frozenset[str]

    @property
    def places(self) -> dict[str, float]:
        """The distances of all that elements may be attached to, the centre of mass too."""
        return {self.name: 0.0, **self.points}


def bars_of(elements: Sequence[Element]) -> list[Bar]:
    """The bars of a model.

    Args:
        elements: with their parts.

    Returns:
        Those that are elements and those that rows make of a displacement, an angle and points.
    """
    units = {element.name: element.unit for element in elements if isinstance(element, ModelBody)}
    masses = {element.name for element in elements if isinstance(element, ModelBody) and element.constant}
    rows_of: dict[str, list[tuple[str, Relation]]] = {}
    for element in elements:
        if isinstance(element, Relation) and element.level == "position" and not element.value:
            turning = [name for name in element.coefficients if units.get(name) == "rad"]
            sliding = [name for name in element.coefficients if units.get(name) == "m"]
            if len(turning) == 1 and len(sliding) == 2 and sum(element.coefficients[name] for name in sliding) == 0:
                rows_of.setdefault(turning[0], []).append((sliding[0], element))
    own = {element.angle: element.name for element in elements if isinstance(element, RigidBar)}
    bars = [_bar(angle, [row for _, row in rows], own.get(angle), masses, units) for angle, rows in rows_of.items()]
    return [bar for bar in bars if bar is not None]


def _bar(angle: str, rows: list[Relation], name: str | None, masses, units) -> Bar | None:
    """The bar whose angle is in these rows; None where they have no displacement in common."""
    common = set.intersection(*({one for one in row.coefficients if units[one] == "m"} for row in rows))
    name = name or min(common, key=lambda one: (one not in masses, list(units).index(one)), default=None)
    if name is None:
        return None
    points = {}
    for row in rows:
        point = next(one for one in row.coefficients if one not in (name, angle))
        points[point] = -row.coefficients[angle] / row.coefficients[point]
    return Bar(name, angle, points, frozenset(row.name for row in rows))


def bar_length(bars: Iterable[Bar]) -> float:
    """Drawing units for a metre along all bars."""
    places = [np.unique([*bar.places.values()]) for bar in bars]
    span = max(np.ptp(own) for own in places)
    gap = min((np.diff(own).min() for own in places if len(own) > 1), default=span)
    return float(min(max(LENGTH, CLOSEST * span / gap if gap else LENGTH), LONGEST) / span) if span else 1.0


def bar_pieces(
    bars: Sequence[Bar], sliding: Sequence[str], joints: list[Joint], massless: frozenset[str], unit: float, turn: float = 1.0
) -> list[Piece]:
    """The pieces of the bars with all that is attached to their points.

    Args:
        bars: of the model.
        sliding: names of the bodies that are displaced.
        joints: between them.
        massless: those without mass.
        unit: drawing units for a metre along a bar.
        turn: angle by which a bar is turned for the drawn rad, at which it stays on its points.

    Returns:
        A piece for each group of bars that are joined.
    """
    rigid = {name: bar for bar in bars for name in bar.places}
    attached = groups(sliding, (joint.ends for joint in joints))
    pairs = [(one, other) for bar in bars for one in bar.points for other in [bar.name]]
    pieces = []
    for whole in groups(sliding, [*(joint.ends for joint in joints), *pairs]):
        own = [bar for bar in bars if bar.name in whole]
        if own:
            parts = [part for part in attached if set(part) <= set(whole)]
            pieces.append(_Layout(own, parts, joints, massless, rigid, unit, turn).piece())
    return pieces


class _Layout:
    """The positions of joined bars, one above the other, and the chains below their points."""

    def __init__(self, bars: list[Bar], parts, joints: list[Joint], massless: frozenset[str], rigid: Mapping[str, Bar], unit, turn):
        self.turn = turn
        self.bars, self.parts, self.joints, self.massless, self.rigid, self.unit = bars, parts, joints, massless, rigid, unit
        self.places: dict[str, np.ndarray] = {}  # of the points, and of the bars' centres of mass

    def piece(self) -> Piece:
        """The bars, their points, and chains upwards from the ground to them."""
        self._stack()
        bodies, links = [self._drawn(bar) for bar in self.bars], []
        for part in self.parts:
            points = [name for name in part if name in self.rigid]
            chain = self._chain(part, points[0]) if len(points) == 1 else self._between(part)
            bodies += chain.bodies
            links += chain.links
        centres = {bar.name for bar in self.bars}
        kept = [body for body in bodies if body.shape == "solids" or body.name not in centres]
        return Piece(tuple(kept), tuple(links))

    def _stack(self) -> None:
        """The first bar at the bottom, preferably one on the ground; each further one above one that it is joined to."""
        grounded = {joint.other(GROUND) for joint in self.joints if GROUND in joint.ends}
        waiting = sorted(self.bars, key=lambda bar: not any(set(part) & grounded & set(bar.places) for part in self.parts))
        corner = np.zeros(3)
        while waiting:
            bar, corner = next(((bar, at) for bar in waiting if (at := self._above(bar)) is not None), (waiting[0], corner))
            waiting.remove(bar)
            for name, distance in bar.places.items():
                self.places[name] = corner + (self.unit * distance, 0.0, 0.0)

    def _above(self, bar: Bar) -> np.ndarray | None:
        """The place of a bar above one that has a place and is joined to it; None where there is none."""
        for part in self.parts:
            below = next((name for name in part if name in self.places), None)
            own = next((name for name in part if name in bar.places), None)
            if below and own:
                return self.places[below] + (-self.unit * bar.places[own], 0.0, STOREY)
        return None

    def _drawn(self, bar: Bar) -> Body:
        """A box over all its points, and a small ball at its centre of mass."""
        left, right = (self.unit * end(bar.places.values()) for end in (min, max))
        placement = np.eye(4)
        placement[0, 3] = (left + right) / 2
        box = Solid("box", (right - left + 2 * OVERHANG, DEPTH, HEIGHT), placement)
        half = max(-left, right) + OVERHANG
        return Body(
            bar.name,
            "solids",
            _place(self.places[bar.name]),
            moves={bar.name: (0.0, 0.0, 1.0)},
            turns={bar.angle: (0.0, -self.turn, 0.0)},
            size=(2 * half, DEPTH, HEIGHT),
            solids=(box,),
        )

    def _chain(self, part: list[str], point: str) -> Piece:
        """The bodies that stand between the ground and a point, or hang from it, upwards."""
        joints = [joint if joint.end != GROUND else replace(joint, start=GROUND, end=joint.start) for joint in self.joints]
        order = walk(part, joints, point)[::-1]
        chain = turned_piece(Chain(order, self.massless | {point}, joints).piece(), dict.fromkeys(part, (0.0, 0.0, 1.0)))
        under = self.places[point] - (0.0, 0.0, (HEIGHT + BALL) / 2)
        return chain.shifted(under - chain.body(point).rest)

    def _between(self, part: list[str]) -> Piece:
        """Bodies between two bars, or two points of one: at the middle of what they are joined to."""
        bodies, places = [], {}
        for name in part:
            if name in self.rigid:
                places[name] = self.places[name]
            else:
                near = [self.places[end] for joint in self.joints if name in joint.ends for end in joint.ends & self.places.keys()]
                places[name] = (
                    np.mean(near, axis=0) if near else np.mean([self.places[one] for one in part if one in self.places], axis=0)
                )
            size = (BALL,) * 3 if name in self.massless or name in self.rigid else (0.8, 0.8, 0.8)
            shape: Shape = "sphere" if size[0] == BALL else "box"
            bodies.append(Body(name, shape, _place(places[name]), {name: (0.0, 0.0, 1.0)}, size=size))
        grounds = []
        links = []
        for joint in self.joints:
            if not joint.ends & set(part):
                continue
            start, end = joint.start, joint.end
            if GROUND in joint.ends:
                body = joint.other(GROUND)
                grounds.append(
                    Body(f"ground of {joint.name}", "ground", _place(places[body] - (0.0, 0.0, 2.0)), size=(1.2, 1.2, 0.2))
                )
                start, end = grounds[-1].name, body
            links.append(Link(joint.name, joint.kind, start, end))
        return Piece((*grounds, *bodies), tuple(links))


def _place(vector: np.ndarray) -> Vector:
    x, y, z = (np.asarray(vector, dtype=float) + 0.0).tolist()
    return x, y, z
