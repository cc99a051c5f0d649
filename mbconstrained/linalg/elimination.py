"""Symmetric P(s) = M s^2 + C s + K of sparse topology, eliminated in an order of little fill-in for many s at once."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property
from heapq import heapify, heappop, heappush
from itertools import pairwise

import numpy as np
import scipy

from ..ground.tolerances import EPS
from .arrays import Matrix, entries

# Order of elimination of the coordinates of a symmetric matrix with little fill-in, and the entries of each elimination.
# The coordinates with the fewest neighbours are next (minimum degree: Tinney and Walker 1967; George and Liu 1981, chapter 5), as many
# as are not neighbours of each other together (Liu 1985); the neighbours of each become neighbours of each other, its front. A chain
# or a tree has fronts of one coordinate, a ring and a ladder of two, a beam of three. With fronts twice as wide very many can be
# eliminated together.

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
    """Order of elimination of coordinates that are coupled in pairs by ``ends``; None where a front is wider."""
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
    """Width of the widest front in the elimination of symmetric matrices of the same first coordinates; None above ``WIDEST``."""
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
    """Ascending numbers at even distances as a slice, which is faster, others as an array."""
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


# Symmetric P(s) = M s^2 + C s + K of sparse topology, a chain, a tree, a ring, a ladder or a beam, by its entries.

#: What is cut off is near this part of the whole: two halves of a uniform chain would have the same zeros.
PART = 0.45

#: For so few s an order with wider fronts and fewer steps is faster, if it has this many times fewer steps.
FEW, FEWER = 128, 4


@dataclass(frozen=True, eq=False)
class SparseQuadratic:
    """P(s) by the entries of its coefficients.

    Attributes:
        diagonal: diagonal of K, C and M, shape (3, N).
        off_diagonal: the entries of K, C and M that couple two coordinates, shape (3, E).
        ends: which these are, shape (2, E).
        places: positions of the coordinates in the given matrices, shape (N,).
        narrow: P(s) in the order of least fill.
    """

    diagonal: np.ndarray
    off_diagonal: np.ndarray
    ends: np.ndarray
    places: np.ndarray
    narrow: Multifrontal

    @property
    def size(self) -> int:
        """N."""
        return len(self.places)

    @cached_property
    def is_heavy(self) -> np.ndarray:
        """Which coordinates have a mass, shape (N,)."""
        return self.diagonal[2] != 0

    @property
    def zero_count(self) -> int:
        """The degree of det P(s)."""
        return self.size + int(np.count_nonzero(self.is_heavy))

    @cached_property
    def together(self) -> Multifrontal:
        """P(s) in an order of few elimination steps, where there is one."""
        width = 2 * self.narrow.order.width
        order = elimination(self.size, self.ends, 2 * WIDEST, together=width)
        if order is None or FEWER * len(order.rounds) > len(self.narrow.order.rounds):
            return self.narrow
        return Multifrontal(order, self.diagonal, self.off_diagonal, self.ends)

    def dense(self) -> np.ndarray:
        """K, C and M, shape (3, N, N)."""
        result, every, (one, other) = np.zeros((3, self.size, self.size)), np.arange(self.size), self.ends
        result[:, every, every] = self.diagonal
        result[:, one, other] = result[:, other, one] = self.off_diagonal
        return result

    def newton(self, s: np.ndarray) -> np.ndarray:
        """p'(s) / p(s) where p = det P, shape as s."""
        return (self.narrow if len(s) > FEW else self.together).newton(s)

    def applied(self, s: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """P(s) x, C x and M x of a vector x for each s, shape (N, S).

        Where it costs nothing P(s) x is a sum of differences of neighbours, in which nothing large cancels.
        """
        of_each, of_differences = self._parts
        differences = x[self.ends[1]] - x[self.ends[0]]
        stiff, damped, damping, inertia = (of_each @ x.view(float)).view(x.dtype).reshape(4, *x.shape)
        more_stiff, more_damped = (of_differences @ differences.view(float)).view(x.dtype).reshape(2, *x.shape)
        return stiff + more_stiff + s * (damped + more_damped) + s * s * inertia, damping, inertia

    def kept_digits(self, x: np.ndarray) -> float:
        """x^T K x relative to the sum of the sizes of its terms in ``applied``, x of shape (N, 1)."""
        (of_each, of_differences), n = self._parts, self.size
        terms = np.abs(of_each[:n]) @ np.abs(x) + np.abs(of_differences[:n]) @ np.abs(x[self.ends[1]] - x[self.ends[0]])
        return float(np.abs((x * self.applied(np.zeros(1), x)[0]).sum()) / (np.abs(x) * terms).sum())

    @cached_property
    def _parts(self) -> tuple[scipy.sparse.csr_array, scipy.sparse.csr_array]:
        """Matrices for parts of K and C and all of C and M, shape (4 N, N), and for differences at two ends for the rest, (2 N, E).

        Rows are sums of differences where their off-diagonal entries are not the larger ones: else units of neighbours differ.
        """
        n, (one, other), every = self.size, self.ends, np.arange(self.size)
        rows, columns, each = np.concatenate([every, one, other]), np.concatenate([every, other, one]), np.arange(len(one))
        whole = [
            scipy.sparse.csr_array((line, (rows, columns)), shape=(n, n))
            for line in np.hstack([self.diagonal, self.off_diagonal, self.off_diagonal])
        ]
        of_each, of_differences = [], []
        for matrix, diagonal, off_diagonal in zip(whole[:2], self.diagonal, self.off_diagonal):
            both = np.concatenate([off_diagonal, off_diagonal])
            near = np.bincount(rows[n:], np.abs(both), n) <= 2 * np.abs(diagonal)
            sums = diagonal.astype(np.longdouble)
            np.add.at(sums, rows[n:], both)
            of_each.append(scipy.sparse.csr_array(_diagonal(1.0 - near) @ matrix) + _diagonal(near * sums.astype(float)))
            signed = np.concatenate([off_diagonal, -off_diagonal]) * near[rows[n:]]
            of_differences.append(scipy.sparse.csr_array((signed, (rows[n:], np.concatenate([each, each]))), shape=(n, len(each))))
        return (_without_zeros([*of_each, *whole[1:]]), _without_zeros(of_differences))

    def halves(self) -> tuple[SparseQuadratic, SparseQuadratic]:
        """The coordinates eliminated because of one, and all others, without their couplings: as if their ends were fixed."""
        below = np.zeros(self.size, dtype=bool)
        below[self.narrow.order.subtree(PART)] = True
        return self._part(below), self._part(~below)

    def _part(self, chosen: np.ndarray) -> SparseQuadratic:
        kept, number = chosen[self.ends].all(axis=0), np.cumsum(chosen) - 1
        return _sparse_quadratic(
            self.diagonal[:, chosen], self.off_diagonal[:, kept], number[self.ends[:, kept]], self.places[chosen]
        )


def sparse_quadratic(M: Matrix, C: Matrix, K: Matrix) -> SparseQuadratic | None:
    """P(s) of symmetric matrices, M of the first coordinates only; None where a front is wider than ``WIDEST``."""
    size, ends, result = K.shape[0], coupled_pairs(M, C, K), [entries(matrix) for matrix in (K, C, M)]
    if ends.shape[1] > WIDEST * size:
        return None
    diagonal, off_diagonal, pairs = np.zeros((3, size)), np.zeros((3, ends.shape[1])), ends[0] * size + ends[1]
    for on, couple, (row, column, values) in zip(diagonal, off_diagonal, result):
        own, above = row == column, row < column
        on[row[own]] = values[own]
        couple[np.searchsorted(pairs, row[above].astype(np.int64) * size + column[above])] = values[above]
    return _sparse_quadratic(diagonal, off_diagonal, ends, np.arange(size))


def _sparse_quadratic(diagonal, off_diagonal, ends, places) -> SparseQuadratic | None:
    order = elimination(len(places), ends)
    return (
        None
        if order is None
        else SparseQuadratic(diagonal, off_diagonal, ends, places, Multifrontal(order, diagonal, off_diagonal, ends))
    )


def _diagonal(entries: np.ndarray) -> scipy.sparse.csr_array:
    return scipy.sparse.csr_array(scipy.sparse.diags_array(entries))


def _without_zeros(parts: list[scipy.sparse.csr_array]) -> scipy.sparse.csr_array:
    result = scipy.sparse.csr_array(scipy.sparse.vstack(parts, format="csr"))
    result.eliminate_zeros()
    return result


# Symmetric P(s) = M s^2 + C s + K of sparse topology eliminated for many s at once.
#
# Each coordinate is eliminated with the small dense matrix of its front alone, and hands what it changes there on to the first of
# it (multifrontal method: Duff and Reid 1983). All operations are on vectors over s, of coordinates that do not touch together.
# Nothing is pivoted: where fronts are one coordinate, in a tree, small pivots do no harm, since every rounding is a relative one of an
# entry of P(s) (Demmel and Gragg 1993, for acyclic matrices); in wider ones a small pivot costs digits, gained back from what is left
# of the equations.

#: So many entries of P(s) and of fronts are computed at once: they stay near the processor; so many s at least.
FRONTS, LEAST = 1 << 15, 32


class Multifrontal:
    """P(s) by the entries of K, C and M, in an order of elimination."""

    def __init__(self, order: EliminationOrder, diagonal: np.ndarray, off_diagonal: np.ndarray, ends: np.ndarray) -> None:
        """Create the factorization with coordinates in the given order."""
        self.order, self._data = order, (diagonal, off_diagonal, ends)

    def newton(self, s: np.ndarray) -> np.ndarray:
        """p'(s) / p(s) where p = det P, shape as s: the sum of d'/d over all pivots d."""
        if len(s) > self._width:
            return np.concatenate([self.newton(part) for part in np.array_split(s, -(-len(s) // self._width))])
        powers, result, waiting = np.stack([np.ones_like(s), s, s * s]), np.zeros_like(s), {}
        for number, (step, coefficients) in enumerate(zip(self.order.steps, self._columns)):
            column = _column(coefficients, powers, step)
            _reduce(column, step.links, waiting)
            pivot, off_diagonal = column[:, 0], column[:, 1:]
            inverse = 1 / pivot[0]
            pivot[1] *= inverse
            result += pivot[1].sum(axis=0)
            if len(step.fronts):
                factor = off_diagonal[0] * inverse
                pivot[1] *= -0.5
                off_diagonal[1] += pivot[1] * off_diagonal[0]
                change = factor[:, None] * off_diagonal[:, None]
                change[1] += change[1].swapaxes(0, 1)
                waiting[number] = _with_others(change, step.links, waiting)
        return result

    def factored(self, s: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """1 / d and the updates of the fronts, by steps, shapes (G, S) and (front, G, S): P = (I + L) D (I + L)^T.

        P is wanted near its zeros: a d that is exactly 0, all of it lost to rounding, becomes a rounding error of its terms
        (inverse iteration: Wilkinson 1965, chapter 5; LAPACK's stein).
        """
        powers, result, waiting = np.stack([np.ones_like(s), s, s * s]), [], {}
        for number, (step, coefficients) in enumerate(zip(self.order.steps, self._columns)):
            column = _column(coefficients[:1], powers, step)
            _reduce(column, step.links, waiting)
            pivot = column[0, 0]
            if not pivot.all():
                pivot += (pivot == 0) * (EPS * (np.abs(coefficients[0, : len(pivot)]) @ np.abs(powers)))
            inverse = 1 / pivot
            factor = column[0, 1:] * inverse
            if len(factor):
                waiting[number] = _with_others((factor[:, None] * column[0, 1:])[None], step.links, waiting)
            result.append((inverse, factor))
        return result

    def solved(self, factors: list[tuple[np.ndarray, np.ndarray]], right: np.ndarray) -> np.ndarray:
        """P(s)^-1 right for each s, shape (N, S), from ``factored``."""
        x, steps = right[self.order.nodes], list(zip(self.order.steps, factors))
        for step, (inverse, factor) in steps:
            own = x[step.own]
            for places, row, column in step.spread:
                x[places] -= factor[row, column] * own[column]
            own *= inverse
        for step, (_, factor) in reversed(steps):
            if len(factor):
                x[step.own] -= (factor * x[step.fronts]).sum(axis=0)
        result = np.empty_like(x)
        result[self.order.nodes] = x
        return result

    @cached_property
    def _width(self) -> int:
        """Number of simultaneous values of s."""
        entries = [(1 + len(step.fronts)) ** 2 * step.fronts.shape[1] for step in self.order.steps]
        return max(LEAST, FRONTS // max(entries))

    @cached_property
    def _columns(self) -> list[np.ndarray]:
        """Coefficients of (1, s, s^2) in the columns of P and of P' by steps, shape (2, (1 + front) G, 3)."""
        (diagonal, off_diagonal, ends), steps, fronts = self._data, self.order.steps, self.order.fronts
        place, begins = np.empty(len(fronts), dtype=int), [0]
        place[self.order.nodes] = np.arange(len(place))
        first, strides = np.empty((2, len(place)), dtype=int)  # where a column begins, and the distance of its entries
        for step in steps:
            count = step.own.stop - step.own.start
            first[step.own], strides[step.own] = np.arange(begins[-1], begins[-1] + count), count
            begins.append(begins[-1] + count * (1 + len(step.fronts)))
        own, other = np.sort(place[ends], axis=0)
        rows = np.array([1 + fronts[one].index(two) for one, two in zip(own.tolist(), other.tolist())], dtype=int)
        K, C, M = result = np.zeros((3, begins[-1]))
        result[:, first], result[:, first[own] + rows * strides[own]] = diagonal[:, self.order.nodes], off_diagonal
        both = np.stack([np.stack([K, C, M], axis=1), np.stack([C, 2 * M, 0 * M], axis=1)])
        return [both[:, begin:end] for begin, end in pairwise(begins)]


def _column(coefficients, powers, step: EliminationStep) -> np.ndarray:
    """Entries of P(s), and of P'(s), on and off the diagonal, shape (_, 1 + front, G, S)."""
    front, count = step.fronts.shape
    return (coefficients @ powers.view(float)).view(powers.dtype).reshape(len(coefficients), 1 + front, count, -1)


def _reduce(column: np.ndarray, links: tuple[Inheritance, ...], waiting: dict[int, np.ndarray]) -> None:
    """Subtract the updates of the children from the coordinates, in place."""
    for link in links:
        column[link.first] -= waiting[link.step][:, 0][:, :, link.given]


def _with_others(change: np.ndarray, links: tuple[Inheritance, ...], waiting: dict[int, np.ndarray]) -> np.ndarray:
    """Updates of the fronts from the coordinates and their children, shape (_, front, front, G, S)."""
    for link in links:
        if link.others is not None:
            change[link.others] += waiting[link.step][:, 1:, 1:, link.given]
        if link.is_last:
            del waiting[link.step]
    return change
