"""Order of elimination of the coordinates of a symmetric matrix with little fill-in, and the entries of each elimination.

The coordinates with the fewest neighbours are next (minimum degree: Tinney and Walker 1967; George and Liu 1981, chapter 5), as many
as are not neighbours of each other together (Liu 1985); the neighbours of each become neighbours of each other, its front. A chain
or a tree has fronts of one coordinate, a ring and a ladder of two, a beam of three. With fronts twice as wide very many can be
eliminated together.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property
from heapq import heapify, heappop, heappush
from itertools import pairwise

import numpy as np

from ..arrays import Matrix, entries

#: Wider fronts are not worth it, and those of more than one coordinate only where there are so many coordinates for each of theirs:
#: else LAPACK's QR algorithm (geev) is as fast (measured: ladders from 250 coordinates, bands of 3 from 350, of 6 from 550).
WIDEST, EACH = 8, 120

#: Largest number of coordinates eliminated together, whose data fit into the cache.
TOGETHER = 64


@dataclass(frozen=True, eq=False)
class Inheritance:
    """Updates that the coordinates of a step take over from children in an earlier step.

    Attributes:
        step: the earlier one.
        first, others: positions in (_, 1 + front, G, S) and (_, front, front, G, S) of the receiving step.
        given: coordinates of the earlier step.
        is_last: whether no later step takes updates from there.
    """

    step: int
    first: tuple
    others: tuple | None
    given: slice | np.ndarray
    is_last: bool


@dataclass(frozen=True, eq=False)
class EliminationStep:
    """G coordinates that are eliminated together, all with fronts of one size.

    Attributes:
        own: their positions in the order.
        fronts: positions of their fronts in the order, shape (front, G).
        links: updates from their children.
    """

    own: slice
    fronts: np.ndarray
    links: tuple[Inheritance, ...]

    @cached_property
    def spread(self) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray], ...]:
        """Positions in the order, without repetition in one array, with their entries of (front, G), until all are listed."""
        return tuple((self.fronts[one, other], one, other) for one, other in _without_repetition(self.fronts))


@dataclass(frozen=True, eq=False)
class EliminationOrder:
    """An order of coordinates.

    Attributes:
        nodes: the coordinates in this order, shape (N,).
        fronts: places in the order, later ones, that are neighbours when each coordinate is eliminated, ascending; the first is the
            parent in the elimination tree (Liu 1990).
        rounds: numbers of coordinates eliminated together.
    """

    nodes: np.ndarray
    fronts: tuple[tuple[int, ...], ...]
    rounds: tuple[int, ...]

    @property
    def width(self) -> int:
        """Width of the widest front."""
        return max(map(len, self.fronts), default=0)

    @cached_property
    def steps(self) -> tuple[EliminationStep, ...]:
        """The order in steps."""
        bounds = [(at.start, at.stop) for at in self._slices]
        step_of = np.repeat(np.arange(len(bounds)), [end - begin for begin, end in bounds]).tolist()
        children = [[] for _ in self.fronts]
        for child, front in enumerate(self.fronts):
            if front:
                children[front[0]].append(child)
        result = []
        for own in self._slices:
            groups = defaultdict(list)
            for slot, node in enumerate(range(own.start, own.stop)):
                repeats = defaultdict(int)
                for child in children[node]:
                    rest = tuple(self.fronts[node].index(place) for place in self.fronts[child][1:])
                    repeats[step_of[child], rest] += 1  # alike children of one coordinate apart: += takes a place once
                    groups[step_of[child], rest, repeats[step_of[child], rest]].append((slot, child))
            result.append((own, groups))
        last = {key[0]: number for number, (_, groups) in enumerate(result) for key in groups}
        return tuple(self._step(number, own, groups, bounds, last) for number, (own, groups) in enumerate(result))

    def _step(self, number: int, own: slice, groups: dict, bounds: list, last: dict) -> EliminationStep:
        links, steps = [], [key[0] for key in groups]
        for at, ((step, rest, _), pairs) in enumerate(groups.items()):
            slots, children = zip(*pairs)
            own_slots, given = as_slice(slots), as_slice([child - bounds[step][0] for child in children])
            is_last = last[step] == number and step not in steps[at + 1 :]
            first, others = _index([0, *(place + 1 for place in rest)], own_slots), _square(rest, own_slots) if rest else None
            links.append(Inheritance(step, first, others, given, is_last))
        fronts = np.array(self.fronts[own], dtype=int).reshape(own.stop - own.start, -1).T
        return EliminationStep(own, fronts, tuple(links))

    @cached_property
    def _slices(self) -> list[slice]:
        """Slices of the order with fronts of one size each."""
        result, begin = [], 0
        for count in self.rounds:
            end = begin + count
            while begin < end:
                size, stop = len(self.fronts[begin]), begin
                while stop < min(end, begin + TOGETHER) and len(self.fronts[stop]) == size:
                    stop += 1
                result.append(slice(begin, stop))
                begin = stop
        return result

    def subtree(self, part: float) -> np.ndarray:
        """The coordinates eliminated because of one, this one included, for one that has about this fraction of all."""
        count = len(self.fronts)
        sizes, below = np.ones(count, dtype=int), np.zeros(count, dtype=bool)
        for child, front in enumerate(self.fronts):
            if front:
                sizes[front[0]] += sizes[child]
        root = int(np.abs(sizes - part * count).argmin())
        below[root] = True
        for child in range(root - 1, -1, -1):
            below[child] = bool(self.fronts[child]) and below[self.fronts[child][0]]
        return self.nodes[below]


def elimination(size: int, ends: np.ndarray, widest: int = WIDEST, together: int = 0) -> EliminationOrder | None:
    """Order of elimination of coordinates that are coupled in pairs by ``ends``; None where a front is wider.

    >>> chain = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])
    >>> [elimination(5, chain, together=width).rounds for width in (1, 2)]
    [(2, 2, 1), (3, 1, 1)]
    """
    neighbours = _neighbours(size, ends)
    rounds = _rounds(neighbours, widest, together)
    if rounds is None:
        return None
    nodes = [node for part in rounds for node in sorted(part, key=lambda node: len(neighbours[node]))]
    place = dict(zip(nodes, range(size)))
    fronts = tuple(tuple(sorted(place[node] for node in neighbours[own])) for own in nodes)
    return EliminationOrder(np.array(nodes, dtype=int), fronts, tuple(map(len, rounds)))


def _neighbours(size: int, ends: np.ndarray) -> list[set[int]]:
    """Neighbours of each coordinate."""
    result: list[set[int]] = [set() for _ in range(size)]
    for one, other in ends.T.tolist():
        result[one].add(other)
        result[other].add(one)
    return result


def _rounds(neighbours: list[set[int]], widest: int, together: int) -> list[list[int]] | None:
    """Groups of coordinates eliminated together; neighbours are updated to those at the time of elimination."""
    waiting, done, result = [(len(own), node) for node, own in enumerate(neighbours)], [False] * len(neighbours), []
    heapify(waiting)
    while waiting:
        part, touched, limit = [], set(), None
        while waiting and (limit is None or waiting[0][0] <= limit):
            degree, node = heappop(waiting)
            if done[node] or degree != len(neighbours[node]) or node in touched:  # those touched are said again
                continue
            limit = max(degree, together) if limit is None else limit
            if degree > widest:
                return None
            part.append(node)
            done[node] = True
            touched |= neighbours[node]
            for other in neighbours[node]:
                neighbours[other] |= neighbours[node]
                neighbours[other] -= {node, other}
        for node in touched:
            heappush(waiting, (len(neighbours[node]), node))
        if part:
            result.append(part)
    return result


def are_worth(width: int, size: int) -> bool:
    """Whether fronts of this width are efficient for this number of coordinates (``quadratic_modes``)."""
    return width <= 1 or size >= EACH * width


def front_width(*matrices: Matrix) -> int | None:
    """Width of the widest front in the elimination of symmetric matrices of the same first coordinates; None above ``WIDEST``.

    >>> front_width(np.eye(3), np.ones((3, 3))), front_width(np.eye(20), np.ones((20, 20)))
    (2, None)
    """
    size, pairs = max(matrix.shape[0] for matrix in matrices), coupled_pairs(*matrices)
    if pairs.shape[1] > WIDEST * size:
        return None
    neighbours = _neighbours(size, pairs)
    return None if _rounds(neighbours, WIDEST, 0) is None else max(map(len, neighbours), default=0)


def coupled_pairs(*matrices: Matrix) -> np.ndarray:
    """Row and column of all entries above the diagonal, row by row, shape (2, E)."""
    size = max(matrix.shape[0] for matrix in matrices)
    result = [(row[row < column], column[row < column]) for row, column, _ in map(entries, matrices)]
    return np.stack(np.divmod(np.unique(np.concatenate([row.astype(np.int64) * size + column for row, column in result])), size))


def as_slice(places) -> slice | np.ndarray:
    """Ascending numbers at even distances as a slice, which is faster, others as an array.

    >>> as_slice([2, 4]), as_slice([2, 4, 5]).tolist()
    (slice(2, 5, 2), [2, 4, 5])
    """
    places = list(places)
    gap = places[1] - places[0] if len(places) > 1 else 1
    if gap > 0 and all(following - place == gap for place, following in pairwise(places)):
        return slice(places[0], places[-1] + 1, gap)
    return np.array(places)


def _index(rows, slots) -> tuple:
    """Rows and slots in (_, rows, G, S)."""
    rows = as_slice(rows)
    return (slice(None), rows if isinstance(rows, slice) or isinstance(slots, slice) else rows[:, None], slots)


def _square(rest, slots) -> tuple:
    """Rows, the same columns and slots in (_, rows, columns, G, S)."""
    rest = as_slice(rest)
    if isinstance(rest, slice):
        return (slice(None), rest, rest, slots)
    if isinstance(slots, slice):
        return (slice(None), rest[:, None], rest, slots)
    return (slice(None), rest[:, None, None], rest[:, None], slots)


def _without_repetition(places: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Row and column of entries, no value twice in one part."""
    repeats, parts = defaultdict(int), defaultdict(list)
    for row, column in np.ndindex(places.shape):
        value = int(places[row, column])
        parts[repeats[value]].append((row, column))
        repeats[value] += 1
    return [tuple(np.array(part).T) for part in parts.values()]
