"""Who is joined to whom: the connections of a lumped model, and orders and groups of its bodies made from them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ...models.elements import GROUND, Damper, Element, Relation, RigidTie, Spring, TorsionDamper, TorsionSpring
from ..drawing import LinkKind

_KINDS: dict[type, LinkKind] = {
    Spring: "spring",
    Damper: "damper",
    TorsionSpring: "torsion spring",
    TorsionDamper: "torsion damper",
    RigidTie: "rod",
    Relation: "rod",
}


@dataclass(frozen=True)
class Joint:
    """A connection that is drawn as one link; ``length`` is x_end - x_start where it is at rest, None if it has none."""

    name: str
    kind: LinkKind
    start: str
    end: str
    length: float | None

    @property
    def ends(self) -> frozenset[str]:
        """The two bodies, or a body and the ground."""
        return frozenset((self.start, self.end))

    def other(self, body: str) -> str:
        """The body at the other end."""
        return self.end if body == self.start else self.start


def joints_of(elements: Iterable[Element]) -> list[Joint]:
    """The elements that connect two bodies along or about one axis; a relation x_b - x_a = value counts as a rod."""
    found = []
    for element in elements:
        kind = _KINDS.get(type(element))
        ends = _difference(element) if isinstance(element, Relation) else kind and (element.start, element.end)
        if ends:
            found.append(Joint(element.name, kind, *ends, _length(element)))
    return found


def _difference(relation: Relation) -> tuple[str, str] | None:
    """(a, b) where the relation is x_b - x_a = value at position level."""
    ends = {factor: name for name, factor in relation.coefficients.items()}
    is_difference = len(relation.coefficients) == 2 and set(ends) == {-1.0, 1.0} and relation.level == "position"
    return (ends[-1.0], ends[1.0]) if is_difference else None


def _length(element: Element) -> float | None:
    lengths = (getattr(element, name, None) for name in ("rest_length", "distance", "rest_angle", "value"))
    return next((length for length in lengths if length is not None), None)


def groups(names: Iterable[str], pairs: Iterable[frozenset[str]]) -> list[list[str]]:
    """The names in groups that the pairs connect, each in the order given; the ground connects nothing."""
    number = {name: i for i, name in enumerate(names)}
    near = _neighbours(number, pairs)
    found: list[list[str]] = []
    met: set[str] = set()
    for name in number:
        if name in met:
            continue
        reached = {name: None}  # in the order in which they are met
        waiting = [name]
        while waiting:
            news = [other for other in near[waiting.pop()] if other not in reached]
            reached.update(dict.fromkeys(news))
            waiting += news
        met.update(reached)
        found.append(sorted(reached, key=number.__getitem__))
    return found


def _neighbours(names: Iterable[str], pairs: Iterable[frozenset[str]]) -> dict[str, dict[str, None]]:
    """To what each name is tied by a pair, itself and the ground left out."""
    near: dict[str, dict[str, None]] = {name: {} for name in names}
    for pair in pairs:
        for one in pair & near.keys():
            near[one].update(dict.fromkeys(pair - {one, GROUND}))
    return near


def walk(names: list[str], joints: list[Joint], first: str | None = None) -> list[str]:
    """The names of a group in an order in which neighbours stand side by side where that is possible.

    From an end, one to which something leads from the ground if there is one, always on to a neighbour not yet met, and
    to one that is tied to the ground last.
    """
    grounded = {joint.other(GROUND) for joint in joints if GROUND in joint.ends}
    begun = {joint.end for joint in joints if joint.start == GROUND}
    number = {name: i for i, name in enumerate(names)}
    near = _neighbours(names, (joint.ends for joint in joints))
    order: dict[str, None] = {}
    waiting = [first or min(names, key=lambda name: (len(near[name]) > 1, name not in begun, number[name]))]
    while waiting:
        name = waiting.pop()
        if name not in order:
            order[name] = None
            waiting += sorted(near[name], key=lambda other: (other in grounded, number[other]), reverse=True)
    return list(order)


def natural_positions(names: Iterable[str], joints: list[Joint]) -> dict[str, float]:
    """Coordinates at which the connections have their lengths, on ways from the ground, or from a body set to 0."""
    names = list(names)
    places: dict[str, float] = {}
    tied: dict[str, list[Joint]] = {name: [] for name in (GROUND, *names)}
    for joint in joints:
        if joint.length is not None:
            for end in joint.ends:
                tied[end].append(joint)
    for start in (GROUND, *names):
        if start in places:
            continue
        places[start] = 0.0
        reached = [start]
        for body in reached:
            for joint in tied[body]:
                if joint.other(body) not in places:
                    sign = 1.0 if body == joint.start else -1.0
                    places[joint.other(body)] = places[body] + sign * joint.length
                    reached.append(joint.other(body))
    return {name: places[name] for name in names}
