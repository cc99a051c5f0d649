"""The connections of a lumped model as a graph: joints, connected groups of bodies, their order in a row, natural positions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np

from ...ground.coordinate_units import GROUND
from ...models import elements
from .bodies import LinkKind


@dataclass(frozen=True)
class DrawnJoint:
    """A connection that is drawn as one link; ``length`` is its natural x_end - x_start, or None."""

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


def joints_of(model: Iterable[Any]) -> list[DrawnJoint]:
    """The elements that connect two bodies along or about one axis; a relation x_b - x_a = value counts as a rod."""
    joints = []
    for element in model:
        lengths = (getattr(element, name, None) for name in ("rest_length", "distance", "rest_angle", "value"))
        length = next((length for length in lengths if length is not None), None)
        if isinstance(element, (elements.Link, elements.RigidTie)) and element.symbol in get_args(LinkKind):
            joints.append(DrawnJoint(element.name, element.symbol, element.start, element.end, length))
        elif isinstance(element, elements.Relation) and element.level == "position":
            ends = {factor: name for name, factor in element.coefficients.items()}
            if ends.keys() == {-1.0, 1.0} and len(element.coefficients) == 2:
                joints.append(DrawnJoint(element.name, "rod", ends[-1.0], ends[1.0], length))
    return joints


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
