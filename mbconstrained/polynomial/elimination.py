"""Coordinates that algebraic rows hold taken out of a polynomial matrix, and which equation belongs to which coordinate."""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import min_weight_full_bipartite_matching

from ..linalg.kinds import Matrix, entries, entry_count, full, kept, nothing, others, shifted_unit
from ..linalg.scaling import column_units
from ..linalg.sparse import condition, is_symmetric, solution, without_noise

#: So few rows are matched one after another.
FEW_ROWS = 16

#: What is divided by may be conditioned so badly, its rows and columns brought to one size: it costs as many digits at most.
MOST_CONDITION = 1e4


def eliminated(rows: np.ndarray, static: np.ndarray, like: Matrix) -> tuple[Matrix, Matrix, np.ndarray, float] | None:
    """V, Y with x = V x_f + Y g where rows x = g, which coordinates x_f are, and the condition of the others' part."""
    size = len(static)
    if not len(rows):
        return shifted_unit(size, size, 0, like), nothing((size, 0), like), np.arange(size), 1.0
    pivots = pivots_of(rows, static)
    own = np.inf if pivots is None else condition(rows[:, pivots])
    if own > MOST_CONDITION:
        return None
    free = others(size, pivots)
    V, Y = np.zeros((size, len(free))), np.zeros((size, len(rows)))
    V[free, range(len(free))], V[pivots] = 1.0, -solution(rows[:, pivots], rows[:, free])
    Y[pivots] = solution(rows[:, pivots], np.eye(len(rows)))
    return kept(V), kept(Y), free, own


def product(left: Matrix, V: Matrix) -> Matrix:
    """left @ V; what is rounding of its terms exactly zero: a mass, damper or spring that is not there."""
    found = left @ V
    return without_noise(found, abs(left) @ abs(V)) if V.shape[0] > V.shape[1] and entry_count(V) > V.shape[1] else found


def matching_rows(M: Matrix) -> np.ndarray | None:
    """An order of rows that brings the large entries to the diagonal: equations may be named after other coordinates."""
    if is_symmetric(M):
        return np.arange(M.shape[0])
    if M.shape[0] <= FEW_ROWS:
        size = np.abs(full(M))
        with np.errstate(divide="ignore"):
            return _assigned(np.log(size.max() / size).tolist())
    row, column, values = entries(abs(M))
    weights = csr_array((1 + np.log(values.max(initial=1.0) / values), (row, column)), shape=M.shape)
    try:
        rows, columns = min_weight_full_bipartite_matching(weights)
    except ValueError:  # no matching: it is singular
        return None
    return rows[np.argsort(columns)]


def _assigned(costs: list[list[float]]) -> np.ndarray | None:
    """For each column a row of its own, of least costs together, by shortest augmenting paths (Kuhn 1955, Munkres 1957)."""
    n = len(costs)
    of_rows, of_columns, held = [0.0] * n, [0.0] * (n + 1), [-1] * (n + 1)  # costs that they bear; the row that a column holds
    for row in range(n):
        held[n], column, least, before, seen = row, n, [math.inf] * n, [n] * n, []  # the path begins at a column beyond the last
        while (at := held[column]) >= 0:
            seen.append(column)
            rest = [j for j in range(n) if j not in seen]
            for j in rest:
                cost = costs[at][j] - of_rows[at] - of_columns[j]
                if cost < least[j]:
                    least[j], before[j] = cost, column
            column = min(rest, key=least.__getitem__)
            if (step := least[column]) == math.inf:
                return None
            for j in seen:
                of_rows[held[j]] += step
                of_columns[j] -= step
            for j in rest:
                least[j] -= step
        while column < n:
            held[column], column = held[before[column]], before[column]
    return np.array(held[:n])


def pivots_of(rows: np.ndarray, static: np.ndarray) -> np.ndarray | None:
    """A pivot column for each row by elimination, static coordinates before others; None where rows depend on each other."""
    if len(rows) == 1:  # any entry of one row serves
        there = rows[0] != 0
        return (there & static if (there & static).any() else there).argmax(keepdims=True) if there.any() else None
    work, found = rows, []
    if len(work):
        work = work * column_units(np.abs(work))
    for at, row in enumerate(work):
        size = np.abs(row)
        still = np.where(static, size, 0.0)
        pivot = int((still if still.max() * MOST_CONDITION > size.max() else size).argmax())
        if not row[pivot]:
            return None
        found.append(pivot)
        below = at + 1 + np.flatnonzero(work[at + 1 :, pivot])
        if below.size:
            work[below] -= np.multiply.outer(work[below, pivot] / row[pivot], row)
            work[below, pivot] = 0.0
    return np.array(found, dtype=int)
