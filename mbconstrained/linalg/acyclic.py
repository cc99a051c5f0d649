"""Symmetric P(s) = M s^2 + C s + K whose graph is a tree, a chain above all: eliminated for many s at once.

From the leaves to the root each coordinate is eliminated while one neighbour of it is left, so that nothing fills in, and small
pivots do no harm: every rounding is a relative one of an entry of P(s) (Demmel and Gragg 1993, for acyclic matrices). All operations
are on vectors over s; coordinates of different parents are eliminated in one round, in a chain two from both of its ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from .kinds import Matrix, entries

#: What is cut off is near this part of the whole: two halves of a uniform chain would have the same zeros.
PART = 0.45

#: So many entries of P(s) are made at once.
CHUNK = 1 << 18

Round = tuple[slice, "slice | np.ndarray"]


@dataclass(frozen=True, eq=False)
class Acyclic:
    """P(s) by the entries of its coefficients, coordinates in the order of elimination, the root last.

    Attributes:
        diagonal: of K, C and M, shape (3, N).
        beside: the entries of K, C and M that couple each coordinate but the last to its parent, shape (3, N - 1).
        parent: which coordinate that is, a later one, shape (N - 1,).
        rounds: which coordinates are eliminated together, and their parents.
        places: where the coordinates are in what was given, shape (N,).
    """

    diagonal: np.ndarray
    beside: np.ndarray
    parent: np.ndarray
    rounds: tuple[Round, ...]
    places: np.ndarray

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

    def dense(self) -> np.ndarray:
        """K, C and M in the order of elimination, shape (3, N, N)."""
        found = np.zeros((3, self.size, self.size))
        every, child = np.arange(self.size), np.arange(self.size - 1)
        found[:, every, every] = self.diagonal
        found[:, child, self.parent] = found[:, self.parent, child] = self.beside
        return found

    def newton(self, s: np.ndarray) -> np.ndarray:
        """p'(s) / p(s) where p = det P, shape as s: the sum of d'/d over all pivots d."""
        width = max(1, CHUNK // self.size)
        if len(s) > width:
            return np.concatenate([self.newton(s[begin : begin + width]) for begin in range(0, len(s), width)])
        on, beside = _values_and_slopes(self.diagonal, s), _values_and_slopes(self.beside, s)
        beside[1] *= 2
        for own, parents in self.rounds:
            pivot, couple = on[:, own], beside[:, own]
            factor = couple[0] / pivot[0]
            couple[1] -= factor * pivot[1]
            couple *= factor
            on[:, parents] -= couple
        return (on[1] / on[0]).sum(axis=0)

    def factored(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pivots D, shape (N, S), and what each coordinate takes from its parent, shape (N - 1, S): P = (I + L) D (I + L)^T."""
        pivots, factors = _value(self.diagonal, s), _value(self.beside, s)
        for own, parents in self.rounds:
            beside = factors[own].copy()
            factors[own] /= pivots[own]
            pivots[parents] -= factors[own] * beside
        return pivots, factors

    def solved(self, pivots: np.ndarray, factors: np.ndarray, right: np.ndarray) -> np.ndarray:
        """P(s)^-1 right for each s, shape (N, S), from ``factored``."""
        x = right.copy()
        for own, parents in self.rounds:
            x[parents] -= factors[own] * x[own]
        x /= pivots
        for own, parents in reversed(self.rounds):
            x[own] -= factors[own] * x[parents]
        return x

    def applied(self, s: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """P(s) x, C x and M x of a vector x for each s, shape (N, S).

        Where it costs nothing P(s) x is a sum of differences of neighbours, in which nothing large cancels.
        """
        of_each, of_differences = self._parts
        apart = x[self.parent] - x[:-1]
        stiff, damped, damping, inertia = (of_each @ x.view(float)).view(x.dtype).reshape(4, *x.shape)
        more_stiff, more_damped = (of_differences @ apart.view(float)).view(x.dtype).reshape(2, *x.shape)
        return stiff + more_stiff + s * (damped + more_damped) + s * s * inertia, damping, inertia

    @cached_property
    def _parts(self) -> tuple[csr_array, csr_array]:
        """For x parts of K and C and all of C and M, shape (4 N, N), for x of parents less x of children the rest, (2 N, N - 1).

        Rows are sums of differences where their entries beside the diagonal are not the larger ones: else units of neighbours differ.
        """
        n, child = self.size, np.arange(self.size - 1)
        every = np.arange(n)
        rows, columns = np.concatenate([every, child, self.parent]), np.concatenate([every, self.parent, child])
        whole = [csr_array((line, (rows, columns)), shape=(n, n)) for line in np.hstack([self.diagonal, self.beside, self.beside])]
        of_each, of_differences = [], []
        for matrix, diagonal, beside in zip(whole[:2], self.diagonal, self.beside):
            both = np.concatenate([beside, beside])
            near = np.bincount(rows[n:], np.abs(both), n) <= 2 * np.abs(diagonal)
            sums = diagonal.astype(np.longdouble)
            np.add.at(sums, rows[n:], both)
            of_each.append(_scaled_rows(1.0 - near, matrix) + _diagonal(near * sums.astype(float)))
            signed = np.concatenate([beside, -beside]) * near[rows[n:]]
            of_differences.append(csr_array((signed, (rows[n:], np.concatenate([child, child]))), shape=(n, n - 1)))
        return (_without_zeros([*of_each, *whole[1:]]), _without_zeros(of_differences))

    def halves(self) -> tuple[Acyclic, Acyclic]:
        """What is left and right of the coupling that divides it best, that taken out: both ends of it are held."""
        sizes = np.ones(self.size, dtype=int)
        for child, parent in enumerate(self.parent.tolist()):
            sizes[parent] += sizes[child]
        cut = int(np.abs(sizes[:-1] - PART * self.size).argmin())
        below = np.zeros(self.size, dtype=bool)
        below[cut] = True
        for child in range(cut - 1, -1, -1):
            below[child] = below[self.parent[child]]
        return self._part(below, cut), self._part(~below, cut)

    def _part(self, chosen: np.ndarray, cut: int) -> Acyclic:
        kept = chosen[:-1].copy()
        kept[cut] = False
        number = np.cumsum(chosen) - 1
        ends = number[np.flatnonzero(kept)], number[self.parent[kept]]
        return acyclic(self.diagonal[:, chosen], self.beside[:, kept], *ends, self.places[chosen])


def acyclic(diagonal, beside, one: np.ndarray, other: np.ndarray, places: np.ndarray) -> Acyclic | None:
    """From the entries that couple the coordinates ``one`` and ``other``, None where their graph is not a tree.

    Args:
        diagonal, beside: as in the class, in any order.
        one, other: shape (E,).
        places: as in the class.
    """
    size = len(places)
    if len(one) != size - 1:
        return None
    graph = csr_array((np.ones(size - 1), (one, other)), shape=(size, size))
    order, before = _from_the_middle(graph)
    if len(order) < size:
        return None
    rounds = _rounds(order, before)
    nodes = order[::-1][:-1][np.argsort(rounds, kind="stable")]
    place = np.empty(size, dtype=int)
    place[nodes], place[order[0]] = np.arange(size - 1), size - 1
    couplings = np.empty(size - 1, dtype=int)
    couplings[np.minimum(place[one], place[other])] = np.arange(size - 1)
    parent, nodes = place[before[nodes]], np.append(nodes, order[0])
    together = tuple(_round(parent, *ends) for ends in zip(*_ends(rounds)))
    return Acyclic(diagonal[:, nodes], beside[:, couplings], parent, together, places[nodes])


def acyclic_of(M: Matrix, C: Matrix, K: Matrix) -> Acyclic | None:
    """From symmetric matrices, M of the first coordinates only; None where the graph is not a tree."""
    size, couplings, found = K.shape[0], _couplings(M, C, K), [entries(matrix) for matrix in (K, C, M)]
    if len(couplings) != size - 1:
        return None
    diagonal, beside = np.zeros((3, size)), np.zeros((3, len(couplings)))
    for on, couple, (row, column, values) in zip(diagonal, beside, found):
        own, above = row == column, row < column
        on[row[own]] = values[own]
        couple[np.searchsorted(couplings, row[above] * size + column[above])] = values[above]
    return acyclic(diagonal, beside, *np.divmod(couplings, size), np.arange(size))


def is_acyclic(M: Matrix, C: Matrix, K: Matrix) -> bool:
    """Whether the graph of symmetric matrices consists of trees.

    >>> is_acyclic(np.eye(3), np.zeros((3, 3)), np.ones((3, 3))), is_acyclic(np.eye(2), np.zeros((2, 2)), np.ones((2, 2)))
    (False, True)
    """
    size, couplings = K.shape[0], _couplings(M, C, K)
    if len(couplings) >= size:
        return False
    graph = csr_array((np.ones(len(couplings)), np.divmod(couplings, size)), shape=(size, size))
    return len(couplings) + connected_components(graph, directed=False)[0] == size


def _couplings(*matrices: Matrix) -> np.ndarray:
    """row * size + column of all entries above the diagonal, ascending."""
    size = max(matrix.shape[0] for matrix in matrices)
    found = [(row[row < column], column[row < column]) for row, column, _ in map(entries, matrices)]
    return np.unique(np.concatenate([row.astype(np.int64) * size + column for row, column in found]))


def _from_the_middle(graph: csr_array) -> tuple[np.ndarray, np.ndarray]:
    """The order of breadth first search from the middle of a longest path, and from where each coordinate was reached."""
    end = breadth_first_order(graph, 0, directed=False)[0][-1]
    order, before = breadth_first_order(graph, end, directed=False)
    path = [int(order[-1])]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return breadth_first_order(graph, path[len(path) // 2], directed=False)


def _rounds(order: np.ndarray, before: np.ndarray) -> np.ndarray:
    """In which round each coordinate is eliminated, the last of the order first: after its children, and no two of one parent."""
    ready, taken, found = [0] * len(order), [set() for _ in order], []
    for node, parent in zip(order[:0:-1].tolist(), before[order[:0:-1]].tolist()):
        own = ready[node]
        while own in taken[parent]:
            own += 1
        taken[parent].add(own)
        ready[parent] = max(ready[parent], own + 1)
        found.append(own)
    return np.array(found, dtype=int)


def _ends(rounds: np.ndarray) -> tuple[list[int], list[int]]:
    ends = np.cumsum(np.bincount(rounds)).tolist()
    return [0, *ends[:-1]], ends


def _round(parent: np.ndarray, begin: int, end: int) -> Round:
    """With slices where they do: they are faster than indices."""
    parents = parent[begin:end]
    if len(parents) == 1:
        return slice(begin, end), slice(parents[0], parents[0] + 1)
    if len(parents) == 2 and parents[0] < parents[1]:
        return slice(begin, end), slice(parents[0], parents[1] + 1, parents[1] - parents[0])
    return slice(begin, end), parents


def _diagonal(entries: np.ndarray) -> csr_array:
    return csr_array(scipy.sparse.diags_array(entries))


def _scaled_rows(factors: np.ndarray, matrix: csr_array) -> csr_array:
    return csr_array(_diagonal(factors) @ matrix)


def _without_zeros(parts: list[csr_array]) -> csr_array:
    found = csr_array(scipy.sparse.vstack(parts, format="csr"))
    found.eliminate_zeros()
    return found


def _value(entries: np.ndarray, s: np.ndarray) -> np.ndarray:
    K, C, M = entries[:, :, None]
    found = s * C
    if M.any():
        found += s * s * M
    found += K
    return found


def _values_and_slopes(entries: np.ndarray, s: np.ndarray) -> np.ndarray:
    _, C, M = entries[:, :, None]
    found = np.empty((2, len(C), len(s)), dtype=s.dtype)
    found[0] = _value(entries, s)
    found[1] = 2 * s * M + C if M.any() else C
    return found
