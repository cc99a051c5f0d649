"""Rigid bars that translate and rotate: each is horizontal, with the elements of its points below it.

A bar is a ``RigidBar``, or an inertia and a mass of which constraint rows x_point - x - d q = 0 make one. A rotor is a bar in each of
two planes and is drawn as one shaft, with what its points are attached to in the plane z below it, in the plane y behind it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...ground.coordinate_units import GROUND
from ...models.elements import Body as ModelBody
from ...models.elements import Element, Relation, RigidBar
from ...models.rotor import PLANES, Rotor, in_planes
from .bodies import DrawnBody, DrawnLink, Shape, Solid, Vector
from .chains import BALL, Chain
from .layout import DrawnJoint, Piece, groups, turned_piece, walk

#: Length between the outermost points of the longest bar, least distance of points, and longest bar, drawing units.
LENGTH, CLOSEST, LONGEST = 5.0, 1.5, 14.0

#: Height and depth of a bar, its overhang at its ends, and the distance to the bar above, drawing units.
HEIGHT, DEPTH, OVERHANG, STOREY = 0.4, 0.6, 0.45, 2.4

#: Radius and width of the disc at the centre of mass of a rotor, and the distance between rotors on one axis, drawing units.
DISC, WIDTH, BETWEEN = 0.7, 0.3, 1.6

#: Directions of the displacements of rotors by the names of their planes; bars move upwards.
DIRECTIONS: dict[str, Vector] = {"y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

#: The placement of a cylinder whose axis is along x.
_LYING = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Bar:
    """A rigid bar of the model: names of its displacement, angle and rows, and its points with their distances in m."""

    name: str
    angle: str | None
    points: Mapping[str, float]
    rows: frozenset[str]
    rotor: str | None = None  # the name of the rotor whose bar in one plane it is
    plane: str = "z"  # "y" or "z", that of its displacements

    @property
    def places(self) -> dict[str, float]:
        """Distances of all attachment points, including the centre of mass."""
        return {self.name: 0.0, **self.points}


def bars_of(elements: Sequence[Element]) -> list[Bar]:
    """The bars of a model."""
    rotating = [bar for element in elements if isinstance(element, Rotor) for bar in _planes(element)]
    known = {bar.angle for bar in rotating}
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
    bars = (
        _bar(angle, [row for _, row in rows], own.get(angle), masses, units)
        for angle, rows in rows_of.items()
        if angle not in known
    )
    return [*(bar for bar in bars if bar is not None), *rotating]


def _planes(rotor: Rotor) -> Iterable[Bar]:
    rows = frozenset(element.name for element in rotor.parts if isinstance(element, Relation))
    angles = rotor.tilts if rotor.diametral_inertia is not None else (None, None)
    for name, plane, angle in zip(in_planes(rotor.name), PLANES, angles):
        points = {in_planes(point)[PLANES.index(plane)]: distance for point, distance in rotor.points.items()}
        yield Bar(name, angle, points, rows, rotor.name, plane)


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
    bars: Sequence[Bar], sliding: Sequence[str], joints: list[DrawnJoint], massless: frozenset[str], unit: float, turn: float = 1.0
) -> list[Piece]:
    """The pieces of the bars with the elements attached to their points."""
    rigid = {name: bar for bar in bars for name in bar.places}
    attached = groups(sliding, (joint.ends for joint in joints))
    pairs = [(one, bar.name) for bar in bars for one in bar.points]
    pairs += [in_planes(bar.rotor) for bar in bars if bar.rotor is not None]
    pieces = []
    for whole in groups(sliding, [*(joint.ends for joint in joints), *pairs]):
        own = [bar for bar in bars if bar.name in whole]
        if own:
            parts = [part for part in attached if set(part) <= set(whole)]
            pieces.append(_Layout(own, parts, joints, massless, rigid, unit, turn).piece())
    return pieces


class _Layout:
    """The positions of joined bars, one above the other, of rotors on one axis, and the chains at their points."""

    def __init__(
        self, bars: list[Bar], parts, joints: list[DrawnJoint], massless: frozenset[str], rigid: Mapping[str, Bar], unit, turn
    ):
        self.turn = turn
        self.bars, self.parts, self.joints, self.massless, self.rigid, self.unit = bars, parts, joints, massless, rigid, unit
        self.places: dict[str, np.ndarray] = {}  # of the points, and of the bars' centres of mass

    def piece(self) -> Piece:
        """The bars, their points, and chains upwards from the ground to them."""
        self._stack()
        wholes: dict[str, list[Bar]] = {}
        for bar in self.bars:
            wholes.setdefault(bar.rotor or bar.name, []).append(bar)
        bodies, links = [self._shaft(own) if own[0].rotor else self._drawn(own[0]) for own in wholes.values()], []
        for part in self.parts:
            points = [name for name in part if name in self.rigid]
            chain = self._chain(part, points[0]) if len(points) == 1 else self._between(part)
            bodies += chain.bodies
            links += chain.links
        joined = {end for link in links for end in (link.start, link.end)}
        centres = {bar.name for bar in self.bars if bar.rotor is None or (bar.points and bar.name not in joined)}
        kept = [self._in_both_planes(body) for body in bodies if body.shape == "solids" or body.name not in centres]
        return Piece(tuple(kept), tuple(links))

    def _in_both_planes(self, body: DrawnBody) -> DrawnBody:
        """A point of a rotor, displaced in both planes; the point in the plane z has its name."""
        bar = self.rigid.get(body.name)
        if bar is None or bar.rotor is None:
            return body
        name = body.name.removesuffix(f" {bar.plane}")
        moves = {one: DIRECTIONS[plane] for one, plane in zip(in_planes(name), PLANES)}
        label = name if bar.plane == "z" and name != bar.rotor else ""
        return replace(body, moves={body.name: moves[body.name]} | moves, label=label)

    def _stack(self) -> None:
        """The bars in a stack, preferably with one on the ground at the bottom; each further one above a connected one.

        The first rotor is on the right of all bars that are not above one, each further rotor on the right of the one before.
        """
        grounded = {joint.other(GROUND) for joint in self.joints if GROUND in joint.ends}
        rotors: dict[str, np.ndarray] = {}
        right: float | None = None
        for bar in self.bars:
            if bar.rotor is None:
                continue
            if bar.rotor not in rotors:
                left, end = self._ends(bar)
                rotors[bar.rotor] = np.array([0.0 if right is None else right + BETWEEN - left, 0.0, 0.0])
                right = rotors[bar.rotor][0] + end
            self._put(bar, rotors[bar.rotor])
        waiting = [bar for bar in self.bars if bar.rotor is None]
        waiting.sort(key=lambda bar: not any(set(part) & grounded & set(bar.places) for part in self.parts))
        corner = np.zeros(3)
        while waiting:
            bar, corner = next(((bar, at) for bar in waiting if (at := self._above(bar)) is not None), (waiting[0], corner))
            waiting.remove(bar)
            self._put(bar, corner)

    def _put(self, bar: Bar, centre: np.ndarray) -> None:
        for name, distance in bar.places.items():
            self.places[name] = centre + (self.unit * distance, 0.0, 0.0)

    def _ends(self, bar: Bar) -> tuple[float, float]:
        """The left and the right end of a bar from its centre of mass, drawing units."""
        places = [self.unit * distance for distance in bar.places.values()]
        return min(places) - OVERHANG, max(places) + OVERHANG

    def _above(self, bar: Bar) -> np.ndarray | None:
        """The position of a bar above a placed one that is connected to it; None without one."""
        for part in self.parts:
            below = next((name for name in part if name in self.places), None)
            own = next((name for name in part if name in bar.places), None)
            if below and own:
                return self.places[below] + (-self.unit * bar.places[own], 0.0, STOREY)
        return None

    def _drawn(self, bar: Bar) -> DrawnBody:
        """A box over all its points, and a small ball at its centre of mass."""
        left, right = self._ends(bar)
        placement = np.eye(4)
        placement[0, 3] = (left + right) / 2
        box = Solid("box", (right - left, DEPTH, HEIGHT), placement)
        return DrawnBody(
            bar.name,
            "solids",
            _place(self.places[bar.name]),
            moves={bar.name: (0.0, 0.0, 1.0)},
            turns={bar.angle: (0.0, -self.turn, 0.0)} if bar.angle else {},
            size=(2 * max(-left, right), DEPTH, HEIGHT),
            solids=(box,),
        )

    def _shaft(self, bars: Sequence[Bar]) -> DrawnBody:
        """A shaft over all points of a rotor with a disc at its centre of mass, for its bars in both planes."""
        left, right = self._ends(bars[0])
        placement = _LYING.copy()
        placement[0, 3] = (left + right) / 2
        tilts = {bar.angle: np.cross((self.turn, 0.0, 0.0), DIRECTIONS[bar.plane]) for bar in bars if bar.angle}
        return DrawnBody(
            str(bars[0].rotor),
            "solids",
            _place(self.places[bars[0].name]),
            moves={bar.name: DIRECTIONS[bar.plane] for bar in bars},
            turns={angle: _place(tilt) for angle, tilt in tilts.items()},
            size=(2 * max(-left, right), 2 * DISC, 2 * DISC),
            solids=(Solid("cylinder", (HEIGHT / 2, right - left), placement), Solid("cylinder", (DISC, WIDTH), _LYING)),
        )

    def _surface(self, point: str) -> np.ndarray:
        """The position of a point at the side of its bar that faces its attachment: the lower one, in the plane y the far one."""
        bar = self.rigid[point]
        in_disc = bar.rotor and abs(self.unit * bar.places[point]) < (WIDTH + BALL) / 2
        return self.places[point] + self._outwards(point) * ((DISC if in_disc else HEIGHT / 2) + BALL / 2)

    def _outwards(self, point: str) -> np.ndarray:
        """The direction from a point to its attachment."""
        plane = self.rigid[point].plane
        return np.multiply(DIRECTIONS[plane], 1.0 if plane == "y" else -1.0)

    def _chain(self, part: list[str], point: str) -> Piece:
        """The bodies between the ground and a point, or suspended from it, upwards; in the plane y those behind a point."""
        behind = self.rigid[point].plane == "y"
        joints = [self._from_left(joint, GROUND in joint.ends, behind) for joint in self.joints]
        order = walk(part, joints, point)
        chain = Chain(order if behind else order[::-1], self.massless | {point}, joints, wall=not behind).piece()
        chain = turned_piece(chain, dict.fromkeys(part, DIRECTIONS[self.rigid[point].plane]))
        return chain.shifted(self._surface(point) - chain.body(point).rest)

    @staticmethod
    def _from_left(joint: DrawnJoint, grounded: bool, behind: bool) -> DrawnJoint:
        """A joint with the ground at its left end, or at its right one."""
        if not grounded or (joint.start if not behind else joint.end) == GROUND:
            return joint
        return replace(joint, start=joint.end, end=joint.start)

    def _between(self, part: list[str]) -> Piece:
        """Bodies between two bars, or two points of one: in the middle of their attachments; those of a shaft next to it."""
        bodies, places = [], {}
        planes = [self.rigid[name].plane for name in part if name in self.rigid and self.rigid[name].rotor]
        plane = planes[0] if planes else "z"
        outwards = np.multiply(DIRECTIONS[plane], 1.0 if plane == "y" else -1.0)
        for name in part:
            if name in self.rigid:
                places[name] = self._surface(name) if self.rigid[name].rotor else self.places[name]
            else:
                near = [end for joint in self.joints if name in joint.ends for end in joint.ends & self.places.keys()]
                near = near or [one for one in part if one in self.places]
                places[name] = np.mean([self.places[end] for end in near], axis=0)
                if all(self.rigid[end].rotor for end in near):
                    places[name] += STOREY * outwards
            size = (BALL,) * 3 if name in self.massless or name in self.rigid else (0.8, 0.8, 0.8)
            shape: Shape = "sphere" if size[0] == BALL else "box"
            bodies.append(DrawnBody(name, shape, _place(places[name]), {name: DIRECTIONS[plane]}, size=size))
        grounds = []
        links = []
        for joint in self.joints:
            if not joint.ends & set(part):
                continue
            start, end = joint.start, joint.end
            if GROUND in joint.ends:
                body = joint.other(GROUND)
                size = (1.2, 0.2, 1.2) if plane == "y" else (1.2, 1.2, 0.2)
                grounds.append(DrawnBody(f"ground of {joint.name}", "ground", _place(places[body] + 2.0 * outwards), size=size))
                start, end = grounds[-1].name, body
            links.append(DrawnLink(joint.name, joint.kind, start, end))
        return Piece((*grounds, *bodies), tuple(links))


def _place(vector: np.ndarray) -> Vector:
    x, y, z = (np.asarray(vector, dtype=float) + 0.0).tolist()
    return x, y, z
