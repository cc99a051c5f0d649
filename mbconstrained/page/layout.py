"""Tools of automatic layouts: connections of a model as a graph, pieces of a drawing with their directions, magnifications, and ties
between pieces.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple, cast, get_args

import numpy as np

from ..ground.tolerances import noise_of
from ..ground.units import GROUND
from ..models.elements import DelayedFeedback, Element, Lever, Link, Pulley, Rack, Relation, RigidTie
from .drawing import DrawnBody, DrawnLink, LinkKind, Vector, matrix_of, vector_of

if TYPE_CHECKING:
    from ..models.switching import SwitchingElement

# The connections of a model as a graph.


@dataclass(frozen=True)
class DrawnJoint:
    """A connection that is drawn as one link."""

    name: str
    kind: LinkKind
    start: str
    end: str
    length: float | None  # natural x_end - x_start, or None
    limits: tuple[float | None, float | None] = (None, None)  # of x_end - x_start at which it closes, see ``DrawnLink``

    @property
    def ends(self) -> frozenset[str]:
        """The two bodies, or a body and the ground."""
        return frozenset((self.start, self.end))

    def other(self, body: str) -> str:
        """The body at the other end."""
        return self.end if body == self.start else self.start


#: Kinds of links between bodies that turn, by those between bodies that move.
_TURNING: dict[str, LinkKind] = {
    "stop": "play",
    "slot": "play",
    "cable": "play",
    "latch": "clutch",
    "friction": "clutch",
    "spring": "torsion spring",
}


def joints_of(model: Iterable[Any], turning: Collection[str] = ()) -> list[DrawnJoint]:
    """The elements that connect two bodies along or about one axis, some turning; a relation x_b - x_a = value counts as a rod."""
    from ..models.switching import SwitchingElement  # with guards and transitions, which other drawings need not have

    joints = []
    for element in model:
        if isinstance(element, SwitchingElement):
            joints += _switching_joints(element, turning)
            continue
        lengths = (getattr(element, name, None) for name in ("rest_length", "distance", "rest_angle", "value"))
        length = next((length for length in lengths if length is not None), None)
        if isinstance(element, (Link, RigidTie, DelayedFeedback)) and element.symbol in get_args(LinkKind):
            joints.append(DrawnJoint(element.name, cast(LinkKind, element.symbol), element.start, element.end, length))
        elif isinstance(element, Relation) and element.level == "position":
            ends = {factor: name for name, factor in element.coefficients.items()}
            if ends.keys() == {-1.0, 1.0} and len(element.coefficients) == 2:
                joints.append(DrawnJoint(element.name, "rod", ends[-1.0], ends[1.0], length))
    return joints


def _switching_joints(element: SwitchingElement, turning: Collection[str]) -> list[DrawnJoint]:
    """An element with several states as one link, or two where it is a stop on both sides."""
    kind, ends = element.symbol, (element.start, element.end)
    low, high = element.limits
    if kind == "cable" and low is not None:  # its end is behind its start
        ends, high, low = ends[::-1], -low, None
    if any(name in turning for name in ends):
        kind = "brake" if kind in ("friction", "latch") and GROUND in ends else _TURNING[kind]
    if kind != "stop" or low is None or high is None:
        return [DrawnJoint(element.name, kind, *ends, None, (low, high))]
    far = DrawnJoint(f"{element.name} far side", kind, *ends[::-1], None, (-high, None))
    return [DrawnJoint(element.name, kind, *ends, None, (low, None)), far]


def settled_joints(names: Iterable[str], joints: Sequence[DrawnJoint]) -> list[DrawnJoint]:
    """The joints; a stop or cable that alone connects its bodies has its length where it closes as its natural one.

    >>> stop = DrawnJoint("floor", "stop", "ground", "ball", None, (-0.5, None))
    >>> [joint.length for joint in settled_joints(["ball"], [stop, replace(stop, name="other")])]
    [-0.5, None]
    """
    part = {name: i for i, name in enumerate((GROUND, *names))}
    settled = []
    for joint in sorted(joints, key=lambda joint: joint.kind in CLOSING):
        one, other = part[joint.start], part[joint.end]
        closes = next((limit for limit in joint.limits if limit is not None), None)
        if joint.kind in CLOSING and one != other and closes is not None:
            joint = replace(joint, length=0.0 if joint.kind == "slot" else closes)
        if joint.length is not None:
            part = {name: one if number == other else number for name, number in part.items()}
        settled.append(joint)
    order = [joint.name for joint in joints]
    return sorted(settled, key=lambda joint: order.index(joint.name))


#: Kinds of links with a length at which they close.
CLOSING = ("stop", "slot", "cable", "latch")


def groups(names: Iterable[str], pairs: Iterable[Iterable[str]]) -> list[list[str]]:
    """The connected components of a graph.

    >>> groups("abcd", ["ca", ("b", "ground")])
    [['a', 'c'], ['b'], ['d']]
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    numbers = {name: i for i, name in enumerate(names)}
    edges = [[numbers[name] for name in pair] for pair in map(set, pairs) if len(pair) == 2 and pair <= numbers.keys()]
    ends = np.array(edges, dtype=int).reshape(-1, 2).T
    labels = connected_components(coo_array((np.ones(len(edges)), ends), (len(numbers),) * 2), directed=False)[1]
    return [[name for name, i in numbers.items() if labels[i] == label] for label in dict.fromkeys(labels.tolist())]


def walk(names: list[str], joints: list[DrawnJoint], first: str | None = None) -> list[str]:
    """The names of a group in an order in which neighbours are adjacent where that is possible.

    Depth-first from an end, preferably one with a connection that starts at the ground; neighbours connected to the ground
    come last.
    """
    grounded = {joint.other(GROUND) for joint in joints if GROUND in joint.ends}
    begun = {joint.end for joint in joints if joint.start == GROUND}
    number = {name: i for i, name in enumerate(names)}
    near: dict[str, dict[str, None]] = {name: {} for name in names}
    for joint in joints:
        for name in joint.ends & near.keys():
            near[name].update(dict.fromkeys({joint.other(name)} - {name, GROUND}))
    order: dict[str, None] = {}
    waiting = [first or min(names, key=lambda name: (len(near[name]) > 1, name not in begun, number[name]))]
    while waiting:
        name = waiting.pop()
        if name not in order:
            order[name] = None
            waiting += sorted(near[name], key=lambda other: (other in grounded, number[other]), reverse=True)
    return list(order)


def natural_positions(names: Iterable[str], joints: list[DrawnJoint]) -> dict[str, float]:
    """Coordinates at which the connections have their natural lengths."""
    places: dict[str, float] = {}
    tied: dict[str, list[DrawnJoint]] = {name: [] for name in (GROUND, *names)}
    for joint in joints:
        if joint.length is not None:
            for end in joint.ends:
                tied[end].append(joint)
    for start in tied:
        if start in places:
            continue
        places[start] = 0.0
        reached = [start]
        for body in reached:
            for joint in tied[body]:
                if joint.other(body) not in places:
                    places[joint.other(body)] = places[body] + (joint.length if body == joint.start else -joint.length)
                    reached.append(joint.other(body))
    del places[GROUND]
    return places


# Pieces: bodies and links with fixed relative positions.

#: Radius of a pulley, and distance from it down to the load on its rope, drawing units.
PULLEY, DROP = 0.75, 1.6

#: Space between unconnected pieces, drawing units.
SPACE = 0.7

#: Farthest pivot of a drawn lever, in distances of its ends.
FARTHEST_PIVOT = 4.0


@dataclass(frozen=True)
class Piece:
    """Bodies and links around a local origin."""

    bodies: tuple[DrawnBody, ...]
    links: tuple[DrawnLink, ...] = ()

    @property
    def names(self) -> frozenset[str]:
        """Names of the bodies."""
        return frozenset(body.name for body in self.bodies)

    def body(self, name: str) -> DrawnBody:
        return next(body for body in self.bodies if body.name == name)

    @property
    def corners(self) -> np.ndarray:
        """The corners with the smallest and the largest coordinates of a box around it, shape (2, 3)."""
        places = np.array([body.rest for body in self.bodies])
        halves = np.array([body.half_extent for body in self.bodies])
        own = {body.name: np.array(body.rest) for body in self.bodies}
        ends = [own[link.end] + link.end_offset for link in self.links] + [own[link.start] + link.offset for link in self.links]
        points = np.vstack([places - halves, places + halves, *ends])
        return np.array([points.min(axis=0), points.max(axis=0)])

    def shifted(self, shift) -> Piece:
        """The piece at another position."""
        return replace(self, bodies=tuple(replace(body, rest=tuple(np.add(body.rest, shift))) for body in self.bodies))

    def hanging(self) -> Piece:
        """The piece turned from the right downwards; its coordinates are then positive upwards."""

        def downwards(vector) -> Vector:
            x, y, z = vector
            return z, y, -x

        turned = []
        for body in self.bodies:
            moves = {name: downwards(np.negative(vector)) for name, vector in body.moves.items()}
            x, y, z = map(abs, downwards(body.size))
            turned.append(replace(body, rest=downwards(body.rest), moves=moves, size=(x, y, z)))
        links = (replace(link, offset=downwards(link.offset), end_offset=downwards(link.end_offset)) for link in self.links)
        return Piece(tuple(turned), tuple(links))


class Mate(NamedTuple):
    """The position of body ``other`` relative to body ``one`` of another piece."""

    one: str
    other: str
    shift: Vector


def _assembled(pieces: Iterable[Piece], mates: Sequence[Mate]) -> list[Piece]:
    """The pieces that mates connect as one piece each; a mate of bodies of one piece changes nothing."""
    waiting, done = list(pieces), []
    while waiting:
        whole = waiting.pop(0)
        while match := _next(whole, waiting, mates):
            piece, shift = match
            waiting.remove(piece)
            moved = piece.shifted(shift)
            whole = Piece((*whole.bodies, *moved.bodies), (*whole.links, *moved.links))
        done.append(whole)
    return done


def _next(whole: Piece, waiting: list[Piece], mates: Sequence[Mate]) -> tuple[Piece, np.ndarray] | None:
    """A waiting piece that a mate joins to the whole, and its shift."""
    for mate in mates:
        for one, other, shift in (mate, (mate.other, mate.one, np.negative(mate.shift))):
            for piece in waiting:
                if one in whole.names and other in piece.names:
                    return piece, np.add(whole.body(one).rest, shift) - piece.body(other).rest
    return None


def stacked(pieces: Iterable[Piece], mates: Sequence[Mate]) -> Piece:
    """All pieces as one: those that move sideways one below another, in several columns when there are many; others side by side."""
    hanging, lying = [], []
    for piece in _assembled(pieces, mates):
        upwards = any(move[2] for body in piece.bodies for move in body.moves.values())
        (hanging if upwards else lying).append(piece)
    rows = max(6, math.ceil(1.3 * math.sqrt(len(hanging) + len(lying))))
    columns = [lying[begin : begin + rows] for begin in range(0, len(lying), rows)] + [[piece] for piece in hanging]
    bodies, links, left = [], [], 0.0
    for column in columns:
        top, right = 0.0, left
        for piece in column:
            low, high = piece.corners
            shift = (left - low[0], 0.0, top - high[2])
            moved = piece.shifted(shift)
            top, right = low[2] + shift[2] - SPACE, max(right, high[0] + shift[0])
            bodies += moved.bodies
            links += moved.links
        left = right + 2 * SPACE
    return Piece(tuple(bodies), tuple(links))


class DrawnTie(NamedTuple):
    """The drawing of a lever, rack or pulley: its own piece, the mates that join it to others, and the links to them."""

    piece: Piece | None
    mates: tuple[Mate, ...]
    links: tuple[DrawnLink, ...] = ()


def tie_of(element: Element, home: Mapping[str, Piece], turns_per_metre: float) -> DrawnTie | None:
    """The drawing of a lever, rack or pulley."""
    if isinstance(element, Pulley):
        return _pulley_tie(element, turns_per_metre)
    if isinstance(element, Rack):  # runs along the pinion's rim: below it where a positive angle moves it forwards, else above it
        pinion, rack = home[element.gear].body(element.gear), home[element.rack].body(element.rack)
        height = (pinion.size[2] + rack.size[2]) / 2 + 0.04
        return DrawnTie(None, (Mate(element.gear, element.rack, (0.0, 0.0, -height if element.radius > 0 else height)),))
    if isinstance(element, Lever) and home[element.start] is not home[element.end]:
        return _lever_tie(element, home[element.start], home[element.end])
    return None


def _lever_tie(lever: Lever, start: Piece, end: Piece) -> DrawnTie | None:
    """An upright bar through a pivot: its ends move to the sides in the ratio of the arms."""
    span = lever.start_arm + lever.end_arm
    if max(abs(lever.start_arm), abs(lever.end_arm)) > FARTHEST_PIVOT * abs(span):
        return None
    below, above = start.body(lever.start).rest[2] - start.corners[0, 2], end.corners[1, 2] - end.body(lever.end).rest[2]
    room = below + above + 0.7
    up, down = room * lever.start_arm / span, room * lever.end_arm / span
    pivot = DrawnBody(f"pivot of {lever.name}", "ground", size=(0.3, 0.5, 0.16))
    mates = (Mate(pivot.name, lever.start, (0.0, 0.0, up)), Mate(pivot.name, lever.end, (0.0, 0.0, -down)))
    links = tuple(DrawnLink(lever.name, "rod", pivot.name, name) for name in (lever.start, lever.end))
    return DrawnTie(Piece((pivot,)), mates, links)


def _pulley_tie(pulley: Pulley, turns_per_metre: float) -> DrawnTie:
    """A wheel with a rope over it, on the ceiling or on a body; the loads on its ends move up and down."""
    name, carrier = f"wheel of {pulley.name}", pulley.over
    turns = {pulley.start: (0.0, turns_per_metre, 0.0)}
    mates = [Mate(name, pulley.start, (-PULLEY, 0.0, -DROP)), Mate(name, pulley.end, (PULLEY, 0.0, -DROP))]
    moves, ceiling = {}, []
    if carrier == GROUND:
        carrier = f"ceiling of {pulley.name}"
        ceiling = [DrawnBody(carrier, "ground", (0.0, 0.0, PULLEY + 0.6), size=(1.6, 0.9, 0.2))]
    else:
        moves = {carrier: (0.0, 0.0, 1.0)}
        turns[carrier] = (0.0, -turns_per_metre, 0.0)
        mates.append(Mate(name, carrier, (0.0, 0.0, PULLEY + 0.8)))
    wheel = DrawnBody(name, "disc", moves=moves, turns=turns, size=(2 * PULLEY, 0.2, 2 * PULLEY), color="#d9dfe5", label="")
    links = (
        DrawnLink(f"{pulley.name}, hanger", "rod", carrier, name, offset=(0.0, 0.14, 0.0)),
        DrawnLink(pulley.name, "belt", pulley.start, pulley.end, over=name),
    )
    return DrawnTie(Piece((wheel, *ceiling)), tuple(mates), links)


# Directions and magnifications.

#: Direction of positive displacements in a layout, and the axis about which positive angles turn counter-clockwise.
ALONG, ABOUT = np.array([1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])

UP = np.array([0.0, 0.0, 1.0])

#: A direction with a larger vertical component is steep.
STEEP = 0.8

#: Shorter components of a unit vector perpendicular to another: the two are parallel.
PARALLEL = 1e-6

#: Largest drawn change of distance between neighbours, about half of the gap between them, drawing units.
NEIGHBOURS = 0.8

#: Largest drawn displacement of a body: a whole chain may move further than its bodies relative to each other, drawing units.
ABSOLUTE = 2.4

#: Smaller angles are magnified, rad.
VISIBLE_ANGLE = 0.35

#: Largest magnified angle, rad: at larger ones the oscillation of a wheel is hard to see.
WIDEST_ANGLE = 2 * VISIBLE_ANGLE

#: Smaller motion counts as none.
SMALLEST_MOTION = 1e-290


def turn_to(along: Sequence[float] | None, about: Sequence[float] | None, own: Sequence[float] = (1.0, 0.0, 0.0)) -> Vector:
    """The orientation of a layout with these two perpendicular directions.

    >>> turn_to([0, 0, 2], None)
    (0.0, -1.5707963267948966, 0.0)
    >>> turn_to(None, None)
    (0.0, 0.0, 0.0)
    >>> turn_to([0, 0, 1], None, own=[0, 0, 1])  # a car, which moves upwards as it is drawn
    (0.0, 0.0, 0.0)
    """
    frame = _frame(along, about)
    return as_tuple(vector_of(frame @ _frame(own, None).T if along is not None else frame))


def turned_piece(piece: Piece, directions: Mapping[str, Sequence[float]], gears=()) -> Piece:
    """A piece in which bodies move along, or turn about, directions of their own.

    The ground of a body is turned with it. Bodies of one direction that are linked, or are wheels in mesh, are turned
    together about the first of them, so that they keep their relative positions.
    """
    coordinates = {body.name: (*body.moves, *body.turns) for body in piece.bodies}
    own = {body: tuple(directions[name]) for body, names in coordinates.items() for name in names if name in directions}
    for link in piece.links:
        for one, other in ((link.start, link.end), (link.end, link.start)):
            if coordinates[one] and one in own and not coordinates[other]:
                own[other] = own[one]
    pairs = [(link.start, link.end) for link in piece.links] + list(gears)
    pairs += [(body.name, name) for body in piece.bodies for name in body.turns]  # the further wheels of a body
    in_order = [body.name for body in piece.bodies if body.name in own]
    for names in groups(in_order, [pair for pair in pairs if len({own.get(name) for name in pair}) == 1]):
        moved = [body for body in piece.bodies if body.name in names and coordinates[body.name]]
        if moved:
            piece = _turned_together(piece, names, moved[0], own[moved[0].name])
    return piece


def _turned_together(piece: Piece, names: Collection[str], first: DrawnBody, direction: Sequence[float]) -> Piece:
    if first.moves:
        rotation = _frame(direction, None) @ _frame(next(iter(first.moves.values())), None).T
    else:
        rotation = _frame(None, direction) @ _frame(None, next(iter(first.turns.values()))).T
    middle = np.array(first.rest)
    bodies, links = list(piece.bodies), list(piece.links)
    for i, body in enumerate(bodies):
        if body.name in names:
            moves, turns = ({key: as_tuple(rotation @ vector) for key, vector in own.items()} for own in (body.moves, body.turns))
            rest, rest_turn = middle + rotation @ (body.rest - middle), vector_of(rotation @ matrix_of(body.rest_turn))
            bodies[i] = replace(body, rest=as_tuple(rest), rest_turn=as_tuple(rest_turn), moves=moves, turns=turns)
    for i, link in enumerate(links):
        if link.start in names and link.end in names:
            offset, end_offset = (as_tuple(rotation @ each) for each in (link.offset, link.end_offset))
            turn = as_tuple(vector_of(rotation @ matrix_of(link.turn)))
            links[i] = replace(link, offset=offset, end_offset=end_offset, turn=turn)
    return Piece(tuple(bodies), tuple(links))


def direction_of(body: DrawnBody) -> np.ndarray:
    """The unit vector along which a body is displaced by its first coordinate, or about which that turns it."""
    return _unit(next(iter((*body.moves.values(), *body.turns.values()))))


def _frame(along: Sequence[float] | None, about: Sequence[float] | None) -> np.ndarray:
    """The rotation (3, 3) of a layout with these two directions; the identity without both."""
    if along is None and about is None:
        return np.eye(3)
    first = _unit(along) if along is not None else _across(ALONG, _unit(about))
    if about is not None:
        second = _unit(about)
    else:  # down stays down, unless the direction is steep
        second = _across(ABOUT, first) if abs(first[2]) > STEEP else np.cross(first, _across(UP, first))
    return np.column_stack([first, -second, np.cross(first, -second)])


def as_tuple(vector: np.ndarray) -> Vector:
    """The components of a vector; -0.0 is 0.0."""
    return tuple((np.asarray(vector) + 0.0).tolist())


def _unit(vector) -> np.ndarray:
    vector = np.array(vector, dtype=float)
    return vector / np.linalg.norm(vector)


def _across(usual: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """The direction perpendicular to an axis that is nearest to the usual one, or to the vertical."""
    parts = (wanted - (wanted @ axis) * axis for wanted in (usual, UP))
    return _unit(next(part for part in parts if np.linalg.norm(part) > PARALLEL))


def displacement_scale(moves: dict[str, np.ndarray], pairs: Iterable[tuple[str, str]]) -> float:
    """Magnification of displacements."""
    zero = np.zeros(1)
    furthest = max((_peak(move) for move in moves.values()), default=0.0)
    both = ((moves.get(a, zero), moves.get(b, zero)) for a, b in pairs)  # of amplitudes the sum counts
    closest = max((_peak(a - b) if max(len(a), len(b)) > 1 else _peak(a) + _peak(b) for a, b in both), default=0.0)
    scales = [limit / size for limit, size in ((ABSOLUTE, furthest), (NEIGHBOURS, closest)) if size > SMALLEST_MOTION]
    return _rounded_down(min(scales, default=1.0))


def angle_scale(angles: Iterable[np.ndarray]) -> float:
    """Magnification of angles (T,): 1 unless all of them are too small to be visible."""
    largest = max(map(_peak, angles), default=0.0)
    return 1.0 if largest < SMALLEST_MOTION or largest >= VISIBLE_ANGLE else _rounded_down(WIDEST_ANGLE / largest)


def _peak(values: np.ndarray) -> float:
    return float(np.abs(values).max(initial=0.0))


def two_digits(number: float) -> float:
    """The next smaller number of two digits.

    >>> two_digits(0.7), two_digits(1.2345e-7), two_digits(99.9)
    (0.7, 1.2e-07, 99.0)
    """
    return _rounded_down(number, range(10, 100))


def _rounded_down(number: float, steps: Iterable[int] = (10, 15, 20, 30, 50, 70)) -> float:
    """The next smaller number of a step of two digits times a power of ten."""
    power = math.floor(math.log10(number)) - 1
    return float(f"{max(step for step in steps if step <= number / 10.0**power * (1 + noise_of(1.0)))}e{power}")
