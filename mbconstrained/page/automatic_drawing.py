"""Automatic drawings of lumped models: chains of masses, storeys, rigid bars and trains of wheels; boxes and discs for coordinates.

A long chain is folded into rows. Each row ends with a mark that moves with the first body of the next one, so that the link
between them is drawn to scale.

A bar is a ``RigidBar``, or an inertia and a mass of which constraint rows x_point - x - d q = 0 make one. A rotor is a bar in each of
two planes and is drawn as one shaft, with what its points are attached to in the plane z below it, in the plane y behind it.

A train is a set of shafts whose wheels mesh. Wheels on one shaft are behind each other; meshing wheels touch, with radii to
scale and the teeth of one in the gaps of the other. Shafts end at a wall, single wheels at blocks around them.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from ..ground.checks import listed
from ..ground.units import GROUND
from ..models.elements import Body as ModelBody
from ..models.elements import Element, Gear, GearMesh, Mass, Node, Pulley, Rack, Relation, RigidBar, with_parts
from ..models.rotor import PLANES, Rotor, in_planes
from .drawing import Drawing, DrawnBody, DrawnLink, LinkKind, Shape, Solid, Vector
from .layout import (
    CLOSING,
    PULLEY,
    DrawnJoint,
    Mate,
    Piece,
    angle_scale,
    as_tuple,
    direction_of,
    displacement_scale,
    groups,
    joints_of,
    natural_positions,
    settled_joints,
    stacked,
    tie_of,
    turned_piece,
    two_digits,
    walk,
)

#: Gaps between bodies with relative motion, between bodies joined by a rod, and between those that touch, drawing units.
GAP, CLOSE, TOUCHING = 1.5, 0.8, 0.25

#: Distance between parallel links, drawing units.
LANE = 0.36

#: Widths of a mass, a massless joint and a wall, drawing units.
BOX, BALL, WALL = 0.8, 0.24, 0.2

#: Longest row, and gap between rows, drawing units.
LONGEST, ROW_GAP = 40.0, 1.3

#: Width of all rows relative to their height, about as of the picture.
ASPECT = 2.1


class Chain:
    """The layout of bodies in a given order.

    Links between neighbours are parallel. Others run above the bodies between, on posts. Links to the ground end at a wall
    at either end of the chain; those of bodies in between, at blocks under the chain.
    """

    def __init__(self, order: list[str], massless: frozenset[str], joints: list[DrawnJoint], *, wall: bool = True):
        self.order = order
        self.massless = massless
        self.number = {name: i for i, name in enumerate(order)}
        self.joints = [joint for joint in joints if joint.ends <= {GROUND, *order}]
        self.joints_by_ends: dict[frozenset[str], list[DrawnJoint]] = {}
        for joint in self.joints:
            self.joints_by_ends.setdefault(joint.ends, []).append(joint)
        self.wall = wall  # whether the first body may have a wall on its left
        self.width = {name: BALL if name in massless else BOX for name in order}
        self.links: list[DrawnLink] = []
        self.grounds: list[DrawnBody] = []

    def piece(self) -> Piece:
        """Bodies with their left end, or wall, at x = 0 and their middles at z = 0."""
        self.top = max(self._height(name) for name in self.order) / 2
        self.places = self._places()
        self.levels = dict.fromkeys(self.order, 0.0)
        self.marks: dict[str, DrawnBody] = {}  # by the name of a body, which stands for it in the row before its own
        self._fold()
        for one, other in pairwise(self.order):
            self._side_by_side(self._between(one, other), {other: self.marks[other].name} if other in self.marks else {})
        self._above()
        bodies = []
        for name in self.order:
            self._walls(name)
            self._block(name)
            shape: Shape = "sphere" if name in self.massless else "box"
            size = (self.width[name], self.width[name], self._height(name))
            place = (self.places[name], 0.0, self.levels[name])
            bodies.append(DrawnBody(name, shape, place, {name: (1.0, 0.0, 0.0)}, size=size))
        return Piece((*self.grounds, *bodies, *self.marks.values()), tuple(self.links))

    def _fold(self) -> None:
        """Fold a long chain into rows, unless a link would cross from row to row."""
        length = self.places[self.order[-1]]
        low, high = zip(*map(self._span, self.joints)) if self.joints else ((0,), (0,))
        inner = [joint for i in range(1, len(self.order) - 1) for joint in self._between(self.order[i], GROUND)]
        if length <= LONGEST or max(b - a for a, b in zip(low, high)) > 1 or inner:
            return
        pitch = 2 * self.top + ROW_GAP
        wide = length / math.ceil(math.sqrt(length / (ASPECT * pitch)))
        shift, row = 0.0, 0
        for one, other in pairwise(self.order):
            if self.places[other] - shift > wide:
                row += 1
                place, moves = (self.places[other] - shift, 0.0, self.levels[one]), {other: (1.0, 0.0, 0.0)}
                self.marks[other] = DrawnBody(f"{other}, also below", "mark", place, moves, size=(BALL, BALL, BALL), label=other)
                shift = self.places[other] - self.width[other] / 2
            self.places[other] -= shift
            self.levels[other] = -pitch * row

    def _between(self, one: str, other: str) -> list[DrawnJoint]:
        return self.joints_by_ends.get(frozenset((one, other)), [])

    def _tied(self, name: str, side: str) -> list[DrawnJoint]:
        """The links of a body to the ground on one side: "left" or "right" of it, or "below"."""
        return [joint for joint in self._between(name, GROUND) if self._side(name, joint) == side]

    def _side(self, name: str, joint: DrawnJoint) -> str:
        first, last = name == self.order[0], name == self.order[-1]
        if last and (not first or joint.start == name or not self.wall):
            return "right"
        return "left" if first and self.wall else "below"

    def _height(self, name: str) -> float:
        """Height sufficient for the links on the side with most of them."""
        if name in self.massless:
            return BALL
        i = self.number[name]
        sides = [self._between(name, other) for other in self.order[max(i - 1, 0) : i + 2] if other != name]
        count = max(map(len, [*sides, self._tied(name, "left"), self._tied(name, "right")]), default=0)
        return max(BOX, LANE * count + 0.12)

    def _places(self) -> dict[str, float]:
        places, edge = {}, 0.0
        if self._tied(self.order[0], "left"):
            edge = WALL + _gap(self._tied(self.order[0], "left"))
        for name, following in zip(self.order, [*self.order[1:], None]):
            places[name] = edge + self.width[name] / 2
            edge += self.width[name] + _gap(self._between(name, following) if following else [])
        return places

    def _side_by_side(self, joints: list[DrawnJoint], others: Mapping[str, str]) -> None:
        for i, joint in enumerate(joints):
            z = LANE * ((len(joints) - 1) / 2 - i)
            self._link(joint, others, z, z)

    def _link(self, joint: DrawnJoint, others: Mapping[str, str], z: float, ground_z: float) -> None:
        """A link at a height; its ends are at other bodies where these stand for the ground or for a body of another row."""
        ends = [others.get(name, name) for name in (joint.start, joint.end)]
        offsets = [(0.0, 0.0, ground_z if name == GROUND else z) for name in (joint.start, joint.end)]
        self.links.append(DrawnLink(joint.name, joint.kind, *ends, *offsets))

    def _above(self) -> None:
        """Links past other bodies, each in the lowest lane that is free along its length."""
        lanes: list[list[tuple[int, int]]] = []
        for joint in self.joints:
            low, high = self._span(joint)
            if high - low < 2:
                continue
            free = (i for i, lane in enumerate(lanes) if all(high <= begin or end <= low for begin, end in lane))
            number = next(free, len(lanes))
            lanes += [[]] if number == len(lanes) else []
            lanes[number].append((low, high))
            self._link(joint, {}, self.top + LANE * (number + 1), 0.0)

    def _span(self, joint: DrawnJoint) -> tuple[int, int]:
        """Numbers of its first and last body; equal for a link to the ground."""
        places = [self.number[name] for name in joint.ends if name != GROUND]
        return min(places), max(places)

    def _walls(self, name: str) -> None:
        """Walls at the sides of a body with links to the ground."""
        for side, sign in (("left", -1), ("right", 1)):
            joints = self._tied(name, side)
            if joints:
                x = self.places[name] + sign * ((self.width[name] + WALL) / 2 + _gap(joints))
                height = max(2 * self.top + 0.6, LANE * len(joints) + 0.7)
                place = (x, 0.0, self.levels[name])
                self.grounds.append(DrawnBody(f"ground {side} of {name}", "ground", place, size=(WALL, 1.2, height)))
                self._side_by_side(joints, {GROUND: self.grounds[-1].name})

    def _block(self, name: str) -> None:
        """A block to the left under a body with links to the ground below."""
        joints = self._tied(name, "below")
        if not joints:
            return
        depths = [-self.top - LANE * (i + 1) for i in range(len(joints))]
        middle = (depths[0] + depths[-1]) / 2
        place = (self.places[name] - self.width[name] / 2 - 1.0, 0.0, middle)
        size = (0.16, 0.5, depths[0] - depths[-1] + 0.44)
        self.grounds.append(DrawnBody(f"ground below {name}", "ground", place, size=size))
        for joint, depth in zip(joints, depths):
            self._link(joint, {GROUND: self.grounds[-1].name}, depth, depth - middle)


def _gap(joints: Sequence[DrawnJoint]) -> float:
    """The distance of neighbours with these connections."""
    kinds = {joint.kind for joint in joints}
    return CLOSE if kinds == {"rod"} else TOUCHING if kinds == {"stop"} and len(joints) == 1 else GAP


# A building: storeys one above the other that move sideways, with columns and braces between them.


#: Extent of a slab, distance from slab to slab, and distance of the columns from the middle, drawing units.
SLAB, STOREY, COLUMN = (3.6, 1.8, 0.24), 1.3, 1.5

#: Distance of a further connection from the one in front of it, drawing units.
BEHIND = 0.4

_ORDINAL = r"\d+(st|nd|rd|th)|first|second|third|fourth|fifth|sixth|seventh|eighth|ninth|tenth"
_NAME = re.compile(rf"((ground|top|roof|{_ORDINAL}) )?(floor|storey|story|roof|slab)[ _-]?\d*", re.IGNORECASE)
_SOIL = re.compile("soil|base|basement|foundation", re.IGNORECASE)


def are_storeys(names: Sequence[str]) -> bool:
    """Whether these are names of storeys, at least two, and at most one of what they stand on.

    >>> are_storeys(["soil", "first floor", "roof"]), are_storeys(["floor 1", "floor_2", "cart"])
    (True, False)
    """
    others = [name for name in names if not _NAME.fullmatch(name)]
    return len(names) - len(others) > 1 and len(others) < 2 and all(map(_SOIL.fullmatch, others))


def storeys(order: Sequence[str], joints: Sequence[DrawnJoint]) -> Piece:
    """The piece of a building.

    A spring or rod is two columns, which lean as it is stretched, a damper is a brace. Where nothing connects the storeys to the
    ground the first one is the moving ground.
    """
    footing = (SLAB[0] + 1.0, SLAB[1] + 0.6, 0.1)
    fixed = [GROUND] * any(joint.ends <= {GROUND, *order} and GROUND in joint.ends for joint in joints)
    levels = {name: STOREY * number for number, name in enumerate([*fixed, *order])}
    slabs = [DrawnBody("ground", "base", (0.0, 0.0, -SLAB[2] / 2), size=footing) for _ in fixed]
    for name in order:
        size = SLAB if levels[name] else footing
        slabs.append(DrawnBody(name, "box", (0.0, 0.0, levels[name] or -SLAB[2] / 2), {name: (1.0, 0.0, 0.0)}, size=size))
    links: list[DrawnLink] = []
    drawn: Counter[tuple[str, str]] = Counter()
    for joint in joints:
        if joint.ends <= levels.keys():
            low, high = sorted((joint.start, joint.end), key=lambda name: levels[name])
            far, back = levels[high] - levels[low] > 1.5 * STOREY, BEHIND * drawn[low, high]
            drawn[low, high] += 1
            bottom, top = SLAB[2] / 2 if levels[low] else footing[2] / 2, -SLAB[2] / 2
            kind: LinkKind = "rod" if joint.kind in ("spring", "rod") and not far else joint.kind
            lines = [(-COLUMN, -COLUMN), (COLUMN, COLUMN)] if kind == "rod" else [(-0.7 * COLUMN, 0.7 * COLUMN)]
            for name, (left, right) in zip((joint.name, f"{joint.name}, right"), lines):
                ends = {"start_point": (left, back, bottom), "end_point": (right, back, top)}
                links.append(DrawnLink(name, kind, low, high, **ends))
    return Piece(tuple(slabs), tuple(links))


def columns(order: Sequence[str]) -> list[DrawnJoint]:
    """Connections from each storey to the next one, where only the coordinates of the storeys are known."""
    return [DrawnJoint(f"columns of {high}", "rod", low, high, None) for low, high in pairwise((GROUND, *order))]


#: Length between the outermost points of the longest bar, least distance of points, and longest bar, drawing units.
BAR_LENGTH, CLOSEST, LONGEST_BAR = 5.0, 1.5, 14.0

#: Height and depth of a bar, its overhang at its ends, and the distance to the bar above, drawing units.
HEIGHT, DEPTH, OVERHANG, BAR_STOREY = 0.4, 0.6, 0.45, 2.4

#: Radius and width of the disc of a rotor without moments of inertia, and the distance between rotors on one axis, drawing units.
DISC, WIDTH, BETWEEN = 0.7, 0.3, 1.6

#: Limits of the radius of a disc, drawing units.
DISCS = (0.5, 1.1)

#: Radius and width of the race of a bearing and of the ring in it, drawing units.
RACE, RING = (0.36, 0.18), (0.29, 0.26)

#: Directions of the displacements of rotors by the names of their planes, bars moving upwards, and from a point to its attachment.
DIRECTIONS: dict[str, Vector] = {"y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
OUTWARDS = {"y": np.array([0.0, 1.0, 0.0]), "z": np.array([0.0, 0.0, -1.0])}

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
    cylinder: tuple[float, float] | None = None  # radius and length in m of the cylinder with its mass and moments of inertia

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
        yield Bar(name, angle, points, rows, rotor.name, plane, _cylinder(rotor))


def _cylinder(rotor: Rotor) -> tuple[float, float] | None:
    """Radius and length of the uniform cylinder J_p = m r^2 / 2, J_d = m (3 r^2 + l^2) / 12; None without moments of inertia."""
    if not rotor.polar_inertia or rotor.diametral_inertia is None:
        return None
    square = 2 * rotor.polar_inertia / rotor.mass
    return math.sqrt(square), math.sqrt(max(0.0, 12 * rotor.diametral_inertia / rotor.mass - 3 * square))


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
    return float(min(max(BAR_LENGTH, CLOSEST * span / gap if gap else BAR_LENGTH), LONGEST_BAR) / span) if span else 1.0


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
        bodies = [self._rotor(own) if own[0].rotor else self._drawn(own[0]) for own in wholes.values()]
        links = self._shafts()
        flexible = {name for link in links for name in (link.name, *link.shown)}
        self.joints = [joint for joint in self.joints if joint.name not in flexible]
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
                return self.places[below] + (-self.unit * bar.places[own], 0.0, BAR_STOREY)
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
            as_tuple(self.places[bar.name]),
            moves={bar.name: (0.0, 0.0, 1.0)},
            turns={bar.angle: (0.0, -self.turn, 0.0)} if bar.angle else {},
            size=(2 * max(-left, right), DEPTH, HEIGHT),
            solids=(box,),
        )

    def _disc(self, bar: Bar) -> tuple[float, float]:
        """Radius and width of the disc of a rotor: of its cylinder, between the points next to its centre of mass."""
        if bar.cylinder is None:
            return DISC, WIDTH
        gap = min((abs(self.unit * distance) for distance in bar.points.values() if distance), default=BAR_LENGTH)
        radius, width = (self.unit * one for one in bar.cylinder)
        return min(max(radius, DISCS[0]), DISCS[1]), min(max(width, WIDTH), max(WIDTH, 2 * gap - 2.2))

    def _rotor(self, bars: Sequence[Bar]) -> DrawnBody:
        """The disc of a rotor at its centre of mass and its bearings, for its bars in both planes."""
        left, right = self._ends(bars[0])
        radius, width = self._disc(bars[0])
        solids = [Solid("cylinder", (radius, width), _LYING)]
        borne = [self.unit * bars[0].places[point] for point in self._borne(bars)]
        for place in borne:
            placement = _LYING.copy()
            placement[0, 3] = place
            solids += [Solid("cylinder", size, placement, tone) for size, tone in ((RACE, "#56646f"), (RING, "#cdd5dc"))]
        tilts = {bar.angle: np.cross((self.turn, 0.0, 0.0), DIRECTIONS[bar.plane]) for bar in bars if bar.angle}
        return DrawnBody(
            str(bars[0].rotor),
            "solids",
            as_tuple(self.places[bars[0].name]),
            moves={bar.name: DIRECTIONS[bar.plane] for bar in bars},
            turns={angle: as_tuple(tilt) for angle, tilt in tilts.items()},
            size=(2 * max(-left, right), 2 * radius, 2 * radius),
            solids=tuple(solids),
            traced=tuple((place, 0.0, 0.0) for place in dict.fromkeys((0.0, *borne))),
        )

    def _borne(self, bars: Sequence[Bar]) -> list[str]:
        """The points of a rotor, in the first of its planes, that something but a shaft is attached to."""
        attached = {end for joint in self.joints if not self._is_flexible(joint) for end in joint.ends}
        pairs = zip(*(bar.points for bar in bars))
        return [first for first, second in pairs if attached & {first, second}]

    def _is_flexible(self, joint: DrawnJoint) -> bool:
        """Whether it is a part of a shaft: between two rotors."""
        ends = [self.rigid[end] for end in joint.ends if end in self.rigid]
        return len({bar.rotor for bar in ends if bar.rotor}) == 2

    def _shafts(self) -> list[DrawnLink]:
        """The shafts, each through all points of rotors that are joined by flexible parts."""
        flexible = [joint for joint in self.joints if self._is_flexible(joint)]
        own: dict[str, Bar] = {}
        for bar in self.bars:
            if bar.rotor and bar.plane == PLANES[0]:
                own[bar.rotor] = bar
        pairs = [tuple({self.rigid[end].rotor for end in joint.ends}) for joint in flexible]
        shafts = []
        for names in groups([*own], pairs):
            stations = [
                (self.places[own[name].name][0] + self.unit * distance, name, self.unit * distance)
                for name in names
                for distance in {*own[name].places.values()}
            ]
            stations.sort()
            first, last = (self._ends(own[name]) for _, name, _ in (stations[0], stations[-1]))
            stations = [(0.0, stations[0][1], first[0]), *stations, (0.0, stations[-1][1], last[1])]
            points = tuple((name, (distance, 0.0, 0.0), own[name].angle is not None) for _, name, distance in stations)
            parts = [joint.name for joint in flexible if {self.rigid[end].rotor for end in joint.ends} <= {*names}]
            name, *others = parts or [f"shaft of {names[0]}"]
            ends = {"start_point": points[0][1], "end_point": points[-1][1]}
            shafts.append(DrawnLink(name, "shaft", points[0][0], points[-1][0], **ends, stations=points, shown=tuple(others)))
        return shafts

    def _surface(self, point: str) -> np.ndarray:
        """The position of a point at the side of its bar that faces its attachment: the lower one, in the plane y the far one."""
        bar = self.rigid[point]
        radius, width = self._disc(bar)
        in_disc = bar.rotor and abs(self.unit * bar.places[point]) < (width + BALL) / 2
        edge = radius if in_disc else RACE[0] if bar.rotor else HEIGHT / 2
        return self.places[point] + OUTWARDS[bar.plane] * (edge + BALL / 2)

    def _chain(self, part: list[str], point: str) -> Piece:
        """The bodies between the ground and a point, or suspended from it, upwards; in the plane y those behind a point."""
        behind = self.rigid[point].plane == "y"
        joints = [  # the ground at the left end, or behind a point at the right one
            replace(joint, start=joint.end, end=joint.start) if (joint.start if behind else joint.end) == GROUND else joint
            for joint in self.joints
        ]
        order = walk(part, joints, point)
        chain = Chain(order if behind else order[::-1], self.massless | {point}, joints, wall=not behind).piece()
        chain = turned_piece(chain, dict.fromkeys(part, DIRECTIONS[self.rigid[point].plane]))
        return chain.shifted(self._surface(point) - chain.body(point).rest)

    def _between(self, part: list[str]) -> Piece:
        """Bodies between two bars, or two points of one: in the middle of their attachments; those of a shaft next to it."""
        bodies, places, grounds, links = [], {}, [], []
        plane = next((self.rigid[name].plane for name in part if name in self.rigid and self.rigid[name].rotor), "z")
        for name in part:
            if name in self.rigid:
                places[name] = self._surface(name) if self.rigid[name].rotor else self.places[name]
            else:
                near = [end for joint in self.joints if name in joint.ends for end in joint.ends & self.places.keys()]
                near = near or [one for one in part if one in self.places]
                places[name] = np.mean([self.places[end] for end in near], axis=0)
                if all(self.rigid[end].rotor for end in near):
                    places[name] += BAR_STOREY * OUTWARDS[plane]
            size = (BALL,) * 3 if name in self.massless or name in self.rigid else (0.8, 0.8, 0.8)
            shape: Shape = "sphere" if size[0] == BALL else "box"
            bodies.append(DrawnBody(name, shape, as_tuple(places[name]), {name: DIRECTIONS[plane]}, size=size))
        for joint in self.joints:
            if joint.ends & set(part):
                start, end = joint.start, joint.end
                if GROUND in joint.ends:
                    start, end = f"ground of {joint.name}", joint.other(GROUND)
                    size = (1.2, 0.2, 1.2) if plane == "y" else (1.2, 1.2, 0.2)
                    grounds.append(DrawnBody(start, "ground", as_tuple(places[end] + 2.0 * OUTWARDS[plane]), size=size))
                links.append(DrawnLink(joint.name, joint.kind, start, end))
        return Piece((*grounds, *bodies), tuple(links))


#: Distances from body to body along a shaft, from a shaft to its wall, and between unconnected shafts, drawing units.
SHAFT_PITCH, WALL_DISTANCE, SHAFT_GAP = 1.3, 1.3, 3.0

#: Radii of an inertia and of a joint without one, drawing units.
WHEEL, SMALL_WHEEL = 0.6, 0.3

#: Thickness of every wheel and disc, drawing units.
THICKNESS = 0.26

#: Drawn radii of toothed wheels: usual of the larger, least of the smaller, most of any, drawing units.
LARGEST, SMALLEST, LIMIT = 1.0, 0.3, 3.0

#: Directions of the wheels around a wheel: right, left, up, down, rad.
_AROUND = (0.0, math.pi, math.pi / 2, -math.pi / 2)


class Train:
    """The layout of turning bodies that shafts and toothed wheels connect, some with a rack below them."""

    def __init__(
        self, names: list[str], massless: frozenset[str], joints: list[DrawnJoint], gears: list[Gear | GearMesh], racked=frozenset()
    ):
        self.massless = massless
        self.racked = racked
        self.joints = [joint for joint in joints if joint.ends <= {GROUND, *names}]
        self.gears = [gear for gear in gears if gear.start in names and gear.end in names]
        shafts = groups(names, [joint.ends for joint in self.joints])
        self.shafts = [tuple(walk(shaft, self.joints)) for shaft in shafts]
        self.shaft_of = {name: shaft for shaft in self.shafts for name in shaft}
        self.wheels: list[Wheel] = []
        self.axes: dict[tuple, np.ndarray] = {}  # position of the first body of each shaft
        self.directions: dict[tuple, list[float]] = {shaft: [] for shaft in self.shafts}  # directions of meshing wheels

    def piece(self) -> Piece:
        """Bodies with the first shaft at x = z = 0 and its first body at y = 0."""
        edge = 0.0
        while len(self.axes) < len(self.shafts):  # those connected by gears next to each other
            shaft = next(shaft for shaft in self.shafts if shaft not in self.axes)
            self.axes[shaft] = np.array([edge, 0.0, 0.0])
            while gear := next(
                (g for g in self.gears if (self.shaft_of[g.start] in self.axes) != (self.shaft_of[g.end] in self.axes)), None
            ):
                self._mesh(gear)
            edge = max(axis[0] for axis in self.axes.values()) + SHAFT_GAP
        drawn = {name: self._bodies(name) for shaft in self.shafts for name in shaft}
        anchors = [self._anchor(name, own[0]) for name, own in drawn.items()]
        inner = (DrawnLink(joint.name, joint.kind, joint.start, joint.end) for joint in self.joints if GROUND not in joint.ends)
        bodies = (body for own in (*drawn.values(), *(anchor.bodies for anchor in anchors)) for body in own)
        return Piece(tuple(bodies), (*inner, *(link for anchor in anchors for link in anchor.links)))

    def _mesh(self, gear: Gear | GearMesh) -> None:
        """Places the other shaft of a gear so that its wheels touch, in the first direction in which no wheel meshes yet."""
        ends = [*zip((gear.start, gear.end), gear.sizes)]
        if self.shaft_of[gear.start] not in self.axes:
            ends.reverse()
        (one, radius), (other, other_radius) = ends
        first = self._wheel(one, radius, other_radius, gear.internal and radius > other_radius)
        occupied = self.directions[self.shaft_of[one]]
        free = (angle for angle in _AROUND if all(math.cos(angle - other) < 0.9 for other in occupied))
        direction = next(free, 0.0)
        second = _meshing(first, other, other_radius, direction, gear.internal)
        self.wheels.append(second)
        shaft = self.shaft_of[other]
        self.axes[shaft] = np.array(second.middle) - self._along(other)
        occupied.append(direction)
        self.directions[shaft].append(direction if gear.internal else direction + math.pi)

    def _wheel(self, name: str, radius: float, partner: float, ring: bool) -> Wheel:
        """The wheel of this radius on a body with a position; a further one, of another size, is behind the first.

        A new one has a size that suits its partner too.
        """
        own = [wheel for wheel in self.wheels if wheel.body == name]
        known = next((wheel for wheel in own if math.isclose(wheel.nominal, radius) and wheel.ring == ring), None)
        if known:
            return known
        small, large = sorted((radius, partner))
        scale = min(max(LARGEST / large, SMALLEST / small), LIMIT / large)
        middle = self._middle(name) + (0.0, 1.4 * THICKNESS * len(own), 0.0)
        self.wheels.append(Wheel(name, radius, scale * radius, _teeth(radius, partner), tuple(middle), ring=ring))
        return self.wheels[-1]

    def _along(self, name: str) -> np.ndarray:
        """Offset from the first body of its shaft, which is next to the ground and furthest from the viewer."""
        return np.array([0.0, -SHAFT_PITCH * self.shaft_of[name].index(name), 0.0])

    def _middle(self, name: str) -> np.ndarray:
        return self.axes[self.shaft_of[name]] + self._along(name)

    def _bodies(self, name: str) -> list[DrawnBody]:
        """The wheels of a body, of which only the first has its name, or a disc."""
        own = [wheel for wheel in self.wheels if wheel.body == name]
        if own:
            further = [replace(wheel.drawn, name=f"{name}, wheel {i}", label="") for i, wheel in enumerate(own[1:], start=2)]
            return [own[0].drawn, *further]
        radius, color = (SMALL_WHEEL, "#ffffff") if name in self.massless else (WHEEL, None)
        size = (2 * radius, THICKNESS, 2 * radius)
        return [DrawnBody(name, "disc", tuple(self._middle(name)), turns={name: (0.0, -1.0, 0.0)}, size=size, color=color)]

    def _anchor(self, name: str, body: DrawnBody) -> Piece:
        """The links of a body to the ground: to a wall behind the first of several on a shaft, else to blocks around it."""
        grounded = [joint for joint in self.joints if joint.ends == {name, GROUND}]
        shaft = self.shaft_of[name]
        if name != shaft[0] or len(shaft) == 1:
            return _blocks_around(body, grounded, up=1 if name in self.racked else -1)
        wall = DrawnBody(f"ground behind {body.name}", "ground", _relative(body, y=WALL_DISTANCE), size=(1.3, 0.16, 1.3))
        links = tuple(DrawnLink(joint.name, joint.kind, wall.name, body.name) for joint in grounded)
        return Piece((wall,), links) if links else Piece(())


def _blocks_around(body: DrawnBody, joints: list[DrawnJoint], up: int) -> Piece:
    """Springs as spirals in front of the body, on studs from below (up = -1) or above; dampers as brakes on its rim."""
    bodies, links = [], []
    brakes = [joint for joint in joints if joint.kind in ("torsion damper", "brake")]
    springs = [joint for joint in joints if joint not in brakes]
    radius = body.size[0] / 2
    if springs:
        bodies.append(DrawnBody(f"ground at {body.name}", "ground", _relative(body, z=up * (radius + 0.45)), size=(0.7, 0.9, 0.2)))
    for i, joint in enumerate(springs):
        front = -THICKNESS / 2 - 0.13 * (i + 1)
        stud = (0.0, front, -up * (0.28 * radius + 0.45))
        links.append(DrawnLink(joint.name, joint.kind, bodies[0].name, body.name, stud, (0.0, front, 0.0)))
    for side, joint in zip((-1, 1, -1, 1), brakes):
        block = f"ground of {joint.name}"
        bodies.append(DrawnBody(block, "ground", _relative(body, x=side * (radius + 0.7)), size=(0.18, 0.5, 0.6)))
        links.append(DrawnLink(joint.name, joint.kind, block, body.name, end_offset=(side * radius, 0.0, 0.0)))
    return Piece(tuple(bodies), tuple(links))


def _relative(body: DrawnBody, *, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> tuple:
    return tuple(np.array(body.rest) + (x, y, z))


@dataclass(frozen=True)
class Wheel:
    """A toothed wheel on a body: ``nominal`` is its radius in the model, ``phase`` the direction of its first tooth."""

    body: str
    nominal: float
    radius: float
    teeth: int
    middle: Vector
    phase: float = 0.0
    ring: bool = False

    @property
    def drawn(self) -> DrawnBody:
        """The wheel as a body, turning with the coordinate of its body."""
        size, rest_turn = (2 * self.radius, THICKNESS, 2 * self.radius), (0.0, -self.phase, 0.0)
        turns = {self.body: (0.0, -1.0, 0.0)}
        shape: Shape = "ring" if self.ring else "gear"
        return DrawnBody(self.body, shape, self.middle, turns=turns, size=size, rest_turn=rest_turn, teeth=self.teeth)


def _meshing(first: Wheel, body: str, nominal: float, direction: float, internal: bool) -> Wheel:
    """The partner of a wheel in a direction (rad from the right, counter-clockwise), one running inside the other or not.

    A tooth meets a gap on the other side; inside a ring, whose outline is a hole, a tooth meets a tooth of the hole.
    """
    ratio = nominal / first.nominal
    teeth = max(3, round(first.teeth * ratio))
    distance = first.radius * (1 - ratio if internal else 1 + ratio)
    middle = np.array(first.middle) + distance * np.array([math.cos(direction), 0.0, math.sin(direction)])
    share = (direction - first.phase) * first.teeth / (2 * math.pi)  # in teeth of the first wheel, up to the contact
    pitch = 2 * math.pi / teeth
    phase = direction - share * pitch if internal else direction + math.pi - (0.5 - share) * pitch
    return Wheel(body, nominal, ratio * first.radius, teeth, tuple(middle), phase, ring=internal and ratio > 1)


def _teeth(one: float, other: float) -> int:
    """Number of teeth of the first of two radii: the radius itself where both can be numbers of teeth, else a good fit."""
    if all(radius == round(radius) and 8 <= radius <= 120 for radius in (one, other)):
        return round(one)
    ratio = max(one, other) / min(one, other)
    small = min(range(12, 25), key=lambda count: (round(abs(count * ratio - round(count * ratio)), 9), -count))
    return small if one <= other else round(small * ratio)


#: Two directions (unit vectors) that differ by less are equal within rounding error.
ALIKE = 1e-9

#: Distances from one coordinate to the next, downwards and across, and to the right of all, drawing units.
ROW_PITCH, COLUMN_WIDTH, PIECE_GAP = 0.95, 5.6, 0.8


def lumped_drawing(
    elements: Iterable[Element], names, values=None, scale=None, turn_scale=None, directions=None, stack=None
) -> Drawing:
    """A drawing of a lumped model and its connections; distances are schematic, motion is to scale.

    A body stands at its place in the layout plus its displacement from the state in which all springs and rods have
    their lengths, so that a spring is drawn longer by as much as it is stretched.

    >>> from mbconstrained.models.elements import Mass, Spring
    >>> drawing = lumped_drawing([Mass("cart", 10.0), Spring("ground", "cart", 2.0, name="k")], ["cart"], [0.01])
    >>> [body.name for body in drawing.bodies]
    ['ground left of cart', 'cart']
    >>> drawing.scale
    70.0
    """
    elements, motion = with_parts(elements), {} if values is None else _motion(names, values)
    bodies = [element for element in elements if isinstance(element, ModelBody)]
    gears: list[Any] = [element for element in elements if element.symbol == "gear"]
    pulleys = [element for element in elements if isinstance(element, Pulley)]
    turning = [body.name for body in bodies if body.unit == "rad"]
    sliding = [body.name for body in bodies if body.unit != "rad"]
    joints = joints_of(elements, turning)
    slides = settled_joints(sliding, [joint for joint in joints if joint.ends <= {GROUND, *sliding}])
    rubbing = _rubbing(sliding, slides)
    slides = [joint for joint in slides if joint not in rubbing]
    twists = [joint for joint in joints if joint.ends <= {GROUND, *turning}]
    bars = bars_of(elements)
    natural, length = natural_positions(sliding, slides), bar_length(bars) if bars else 1.0
    for bar in bars:  # level where none of its springs is stretched on the average
        natural |= dict.fromkeys(bar.places, float(np.mean([natural[point] for point in bar.points or bar.places])))
    if scale is None:
        pairs = [(joint.start, joint.end) for joint in slides]
        pairs += [(end, pulley.over) for pulley in pulleys for end in (pulley.start, pulley.end)]
        moved = [name for name in natural if name in motion and name in sliding]
        scale = displacement_scale({name: motion[name] - natural[name] for name in moved}, pairs)
    lying = {bar.angle for bar in bars if not any(bar.angle in joint.ends for joint in twists)}
    wheels = [name for name in turning if name not in lying]
    if turn_scale is None:
        turn_scale = angle_scale([motion[name] for name in wheels if name in motion]) if wheels or not bars else scale / length

    plays = {
        joint.name: _play_magnification(turn_scale * (joint.limits[1] - joint.limits[0]))
        for joint in twists
        if joint.kind == "play" and None not in joint.limits
    }
    massless = frozenset(body.name for body in bodies if isinstance(body, Node))
    spots = {body.name: body.position for body in bodies if isinstance(body, Mass) and body.position is not None}
    meshing = [(gear.start, gear.end) for gear in gears]
    racked = frozenset(rack.gear for rack in elements if isinstance(rack, Rack) and rack.radius > 0)
    pieces = bar_pieces(bars, sliding, slides, massless, length, scale / (length * (turn_scale or 1.0)))
    barred = {name for piece in pieces for body in piece.bodies for name in (body.name, *body.moves)}
    rows = groups([name for name in sliding if name not in barred], (joint.ends for joint in slides))
    upright = {tuple(group) for group in rows if stack == "vertical" or (stack is None and are_storeys(group))}
    chains = [
        storeys(walk(group, slides, next(filter(_SOIL.fullmatch, group), None)), slides)
        if tuple(group) in upright
        else _chain(group, slides, massless, pulleys, spots)
        for group in rows
    ]
    trains = groups(wheels, [*(joint.ends for joint in twists), *meshing])
    chains += [Train(group, massless, twists, gears, racked).piece() for group in trains]
    if directions:
        chains = [turned_piece(piece, directions, meshing) for piece in chains]
    pieces += chains
    pieces, mates, pads = _on_supports(pieces, rubbing, scale, motion)
    home = {name: piece for piece in pieces for name in piece.names}
    ties = [tie_of(element, home, scale / (PULLEY * (turn_scale or 1.0))) for element in elements]
    ties = [tie for tie in ties if tie is not None]
    pieces += [tie.piece for tie in ties if tie.piece]
    whole = stacked(pieces, [*mates, *(mate for tie in ties for mate in tie.mates)])
    limits = {joint.name: joint.limits for joint in joints}
    links = tuple(
        replace(link, limits=limits.get(link.name, link.limits), magnification=plays.get(link.name, 1.0))
        for link in (*whole.links, *pads, *(link for tie in ties for link in tie.links))
    )

    drawn = [_at_zero(body, natural, scale) for body in whole.bodies]
    magnified = (f"relative angle of {name} drawn {factor:g} × as large" for name, factor in plays.items() if factor != 1)
    notes = (
        *magnified,
        _not_drawn(elements, {name for link in links for name in (link.name, *link.shown)}.union(*(bar.rows for bar in bars))),
        _askew(drawn, slides + twists),
    )
    return Drawing(tuple(drawn), links, scale, turn_scale, " · ".join(filter(None, notes)))


def _rubbing(names: Sequence[str], joints: Sequence[DrawnJoint]) -> list[DrawnJoint]:
    """Friction with the ground, or between bodies that nothing else connects: one is drawn on the other."""
    others = [joint.ends for joint in joints if joint.kind != "friction" and GROUND not in joint.ends]
    parts = groups(names, others)
    part = {name: number for number, own in enumerate(parts) for name in own}
    rubbing = []
    for joint in joints:
        if joint.kind == "friction" and (GROUND in joint.ends or part[joint.start] != part[joint.end]):
            rubbing.append(joint)
            part = {
                name: part.get(joint.end, number) if number == part.get(joint.start) and GROUND not in joint.ends else number
                for name, number in part.items()
            }
    return rubbing


#: Height of a plate under a body, and of the pad between both, drawing units.
PLATE, PAD = 0.16, 0.1


def _on_supports(
    pieces: Sequence[Piece], rubbing: Sequence[DrawnJoint], scale: float, motion: Mapping[str, np.ndarray]
) -> tuple[list[Piece], list[Mate], list[DrawnLink]]:
    """Pieces with plates of the ground under bodies that rub on it, mates of bodies on others, and the pads between them.

    A body that is nothing but a support is a plate as long as the relative motion.
    """
    pieces, mates, pads, zero = list(pieces), [], [], np.zeros(1)
    for joint in rubbing:
        upper = joint.end if joint.end != GROUND else joint.start
        lower = joint.other(upper)
        place = next(i for i, piece in enumerate(pieces) if upper in piece.names)
        body = pieces[place].body(upper)
        down, along = body.half_extent[2], np.abs(direction_of(body))
        stroke = scale * float(np.abs(motion.get(upper, zero) - motion.get(lower, zero)).max())
        size = as_tuple(np.array([0.8, 0.8, PLATE]) + 2 * (stroke + 0.3) * along * (along[2] < ALIKE))
        if lower == GROUND:
            plate = DrawnBody(f"ground under {joint.name}", "base", _relative(body, z=-down - PAD - PLATE / 2), size=size)
            pieces[place] = replace(pieces[place], bodies=(*pieces[place].bodies, plate))
        else:
            place = next(i for i, piece in enumerate(pieces) if lower in piece.names)
            plate = pieces[place].body(lower)
            if len(pieces[place].bodies) == 1:
                plate = replace(plate, shape="box", size=size)
                pieces[place] = Piece((plate,))
            mates.append(Mate(upper, lower, (0.0, 0.0, -down - PAD - plate.half_extent[2])))
        ends = {"start_point": (0.0, 0.0, plate.half_extent[2]), "end_point": (0.0, 0.0, -down)}
        pads.append(DrawnLink(joint.name, "pad", plate.name, upper, **ends))
    return pieces, mates, pads


#: The drawn angle of a play is at least this, rad.
PLAY = 0.7


def _play_magnification(angle: float) -> float:
    return two_digits(PLAY / angle) if 0 < angle < PLAY else 1.0


def _at_zero(body: DrawnBody, natural: dict, scale: float) -> DrawnBody:
    """The body at the position for all coordinates zero, from its position in the layout."""
    shift = sum((natural[name] * np.array(move) for name, move in body.moves.items()), np.zeros(3))
    return replace(body, rest=tuple(body.rest - scale * shift))


def _not_drawn(elements: Iterable[Element], known: set[str]) -> str:
    """A note of the elements without a link; gears and racks are drawn as wheels in contact."""
    others = (element for element in elements if element.symbol not in (None, "gear", "rack") or isinstance(element, Relation))
    missing = ", ".join(element.name for element in others if element.name not in known)
    return f"not drawn: {missing}" * bool(missing)


def _motion(names, values) -> dict[str, np.ndarray]:
    values = np.asarray(values, dtype=float)
    return dict(zip(names, values[:, None] if values.ndim == 1 else values))


def _chain(group: list[str], joints: list[DrawnJoint], massless: frozenset[str], pulleys: list[Pulley], spots) -> Piece:
    """Chain from left to right; on a rope, from the rope downwards; carrying a pulley, down to it."""
    roped = next((name for name in group if any(name in (pulley.start, pulley.end) for pulley in pulleys)), None)
    if roped:
        return Chain(walk(group, joints, roped), massless, joints, wall=False).piece().hanging()
    carrier = next((name for name in group if any(name == pulley.over for pulley in pulleys)), None)
    if carrier:
        return Chain(walk(group, joints, carrier)[::-1], massless, joints).piece().hanging()
    placed = all(name in spots for name in group)
    return Chain(sorted(group, key=spots.get) if placed else _ordered(group, joints), massless, joints).piece()


def _ordered(group: list[str], joints: list[DrawnJoint]) -> list[str]:
    """The walk through a group, or backwards where so more of its stops and cables lead forwards."""
    order = walk(group, joints)
    own = [
        (order.index(joint.start), order.index(joint.end)) for joint in joints if joint.kind in CLOSING and joint.ends <= {*order}
    ]
    return order[::-1] if sum(one < other for one, other in own) < len(own) / 2 else order


def _askew(bodies: list[DrawnBody], joints: list[DrawnJoint]) -> str:
    """A note on elements whose drawn length does not show their elongation: their ends have different directions."""
    directions = {body.name: direction_of(body) for body in bodies if body.moves or body.turns}
    between = [joint for joint in joints if GROUND not in joint.ends]
    names = [joint.name for joint in between if np.abs(directions[joint.start] - directions[joint.end]).max() > ALIKE]
    if not names:
        return ""
    join = "joins" if len(names) == 1 else "join"
    return f"{listed(names)} {join} bodies of different directions: not drawn to scale"


def coordinate_drawing(names, values=None, units=None, scale=None, turn_scale=None, directions=None, stack=None) -> Drawing:
    """A box on a rail for each displacement, a disc for each angle, one below the other, in several columns when there are many.

    >>> [body.shape for body in coordinate_drawing(["x1", "q"], [0.01, 1.0], ["m", "rad"]).bodies]
    ['rail', 'box', 'disc']
    """
    unit_of = dict(zip(names, ["m"] * len(names) if units is None else units))
    motion, directions = _motion(names, np.zeros(len(names)) if values is None else values), directions or {}
    drawn = [name for name in names if unit_of[name] in ("m", "rad")]
    floors = [name for name in drawn if unit_of[name] == "m" and name not in directions]
    floors = floors if stack == "vertical" or (stack is None and are_storeys(floors)) else []
    building = storeys(floors, columns(floors)) if floors else Piece(())
    usual = [name for name in drawn if name not in directions and name not in floors]
    rows = max(6, math.ceil(1.3 * math.sqrt(len(usual))))
    bodies = []
    for i, name in enumerate(usual):
        bodies += _of_coordinate(name, unit_of[name], (COLUMN_WIDTH * (i // rows), 0.0, -ROW_PITCH * (i % rows)))
    left, others = Piece(tuple(bodies)).corners[1, 0] + PIECE_GAP if bodies else 0.0, [building] * bool(floors)
    for name in drawn:
        if name in directions:
            own = _of_coordinate(name, unit_of[name], (0.0, 0.0, 0.0))
            links = tuple(DrawnLink("", "rod", own[0].name, body.name) for body in own[1:])  # so that they are turned together
            others.append(Piece(turned_piece(Piece(tuple(own), links), {name: directions[name]}).bodies))
    for piece in others:
        low, high = piece.corners
        bodies += piece.shifted((left - low[0], 0.0, 0.0)).bodies
        left += high[0] - low[0] + PIECE_GAP
    if scale is None:
        moves = {name: motion[name] for name in names if unit_of[name] == "m"}
        scale = displacement_scale(moves, pairwise((GROUND, *floors)))
    if turn_scale is None:
        turn_scale = angle_scale([motion[name] for name in names if unit_of[name] == "rad"])
    missing = [name for name in names if name not in drawn]
    note = f"not drawn, neither displacement nor angle: {', '.join(missing)}" if missing else ""
    return Drawing(tuple(bodies), building.links, scale, turn_scale, note)


def _of_coordinate(name: str, unit: str, place: tuple[float, float, float]) -> list[DrawnBody]:
    if unit == "rad":
        return [DrawnBody(name, "disc", place, turns={name: (0.0, -1.0, 0.0)}, size=(0.6, 0.2, 0.6))]
    rail = DrawnBody(f"rail of {name}", "rail", (place[0], 0.0, place[2] - 0.24), size=(5.0, 0.3, 0.05))
    return [rail, DrawnBody(name, "box", place, {name: (1.0, 0.0, 0.0)}, size=(0.42, 0.42, 0.42))]
