"""Sparse constraint rows solved for one coordinate each: x = N y + x_held with a sparse N, and rows that say nothing new.

A row with a coordinate that no other row has is solved for it at once. The others are eliminated one by one in the order
given (Gauss's elimination on rows kept as dictionaries), each entry with the rounding noise that it was made with; a row
whose rest is noise depends on those before it. Of the entries that are large enough as pivots the one whose coordinate is in
the fewest rows is taken (Markowitz 1957). Long rows, whose elimination would fill the matrices, are left as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse

from ...errors import ContradictoryConstraints
from ...tolerances import EPS, NOISE_SAFETY
from .rows import HeldRows

#: A pivot is at least this part of the largest entry of its row: the entries of N stay bounded by ten for each step.
LEAST_PIVOT = 0.1

#: Eliminating a row with m entries couples m coordinates with each other, m^2 entries; longer rows are kept as they are.
LONGEST = 64

Row = dict[int, tuple[float, float]]


@dataclass(frozen=True)
class Elimination:
    """x = basis y + offset obeys all eliminated rows.

    Attributes:
        basis: N, shape (n, r), sparse; a column has a 1 where its coordinate is.
        offset: x_held, shape (n,), zero where all values are.
        free: the coordinates that are left, shape (r,).
        kept: places of the rows that are left as they are.
        dependent: for each row that says nothing new the rows that it was reduced by.
    """

    basis: scipy.sparse.csc_array
    offset: np.ndarray
    free: np.ndarray
    kept: np.ndarray
    dependent: dict[int, tuple[int, ...]]


def eliminate(rows: HeldRows, longest: int = LONGEST) -> Elimination:
    """Solve the rows for one coordinate each.

    Raises:
        ContradictoryConstraints: a row that depends on others asks for another value.
    """
    A, size = rows.matrix, rows.matrix.shape[1]
    lengths = np.diff(A.indptr)
    kept = np.flatnonzero(lengths > longest)
    single, pivots = _single(A, lengths, longest)
    others = np.setdiff1d(np.flatnonzero(lengths <= longest), single)
    solved, dependent = _one_by_one(rows, others, _counts(A, size))
    free = np.setdiff1d(np.arange(size), [*solved, *pivots.tolist()])
    basis, offset = _with_single(A, rows.values, single, pivots, *_null_space(solved, free, size))
    return Elimination(basis, offset, free, kept, dependent)


def _counts(A, size) -> np.ndarray:
    return np.bincount(A.indices, minlength=size)


def _single(A, lengths, longest) -> tuple[np.ndarray, np.ndarray]:
    """Rows with a large enough entry in a coordinate that only they have, and this coordinate."""
    if not A.nnz:
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    row = np.repeat(np.arange(A.shape[0]), lengths)
    largest = np.zeros(A.shape[0])
    np.maximum.at(largest, row, np.abs(A.data))
    alone = _counts(A, A.shape[1])[A.indices] == 1
    good = np.flatnonzero(alone & (np.abs(A.data) >= LEAST_PIVOT * largest[row]) & (lengths[row] <= longest))
    best, first = np.unique(row[good], return_index=True)
    return best, A.indices[good[first]]


def _one_by_one(rows: HeldRows, places: Sequence[int], counts) -> tuple[dict[int, tuple[Row, float]], dict[int, tuple[int, ...]]]:
    """For each pivot, in the order found, its row without it and the value, and the rows that say nothing new."""
    A = rows.matrix
    solved: dict[int, tuple[Row, float]] = {}
    owner: dict[int, int] = {}
    dependent: dict[int, tuple[int, ...]] = {}
    for place in places:
        at = slice(A.indptr[place], A.indptr[place + 1])
        row: Row = {j: (v, EPS * abs(v)) for j, v in zip(A.indices[at].tolist(), A.data[at].tolist())}
        value = (float(rows.values[place]), EPS * abs(float(rows.values[place])))
        row, value, used = _reduced(row, value, solved)
        if row:
            size = max(abs(v) for v, _ in row.values())
            pivot = min((j for j, (v, _) in row.items() if abs(v) >= LEAST_PIVOT * size), key=lambda j: (counts[j], j))
            solved[pivot] = _solved_for(pivot, row, value)
            owner[pivot] = place
        else:
            dependent[place] = tuple(owner[pivot] for pivot in used)
            _check_value(rows, place, value, dependent[place])
    return solved, dependent


def _reduced(row: Row, value, solved) -> tuple[Row, tuple[float, float], list[int]]:
    """The row without the pivots of others; what is no more than noise is taken out."""
    used = []
    while (pivot := next((j for j in row if j in solved), None)) is not None:
        factor, noise = row.pop(pivot)
        expression, (held, held_noise) = solved[pivot]
        used.append(pivot)
        value = (value[0] - factor * held, value[1] + abs(factor) * held_noise + (noise + EPS * abs(factor)) * abs(held))
        for j, (v, n) in expression.items():
            old, old_noise = row.get(j, (0.0, 0.0))
            new = old + factor * v
            row[j] = (new, old_noise + abs(factor) * n + (noise + EPS * abs(factor)) * abs(v))
        row = {j: (v, n) for j, (v, n) in row.items() if abs(v) > NOISE_SAFETY * n}
    return row, value, used


def _solved_for(pivot: int, row: Row, value) -> tuple[Row, tuple[float, float]]:
    """x_pivot = sum of the expression + value."""
    top, noise = row[pivot]
    relative = noise / abs(top) + EPS
    found = {j: (-v / top, abs(n / top) + relative * abs(v / top)) for j, (v, n) in row.items() if j != pivot}
    return found, (value[0] / top, abs(value[1] / top) + relative * abs(value[0] / top))


def _check_value(rows: HeldRows, place: int, value, others) -> None:
    rest, noise = value
    if abs(rest) > NOISE_SAFETY * noise:
        reason = f"it follows from {told(rows, others)}" if others else "all its coefficients are zero"
        raise ContradictoryConstraints(
            f'constraint "{rows.names[place]}" asks for {rows.values[place]:.6g}, but {reason}, with the value '
            f"{rows.values[place] - rest:.6g}; make the values agree or take one of the rows out"
        )


def told(rows: HeldRows, others: Sequence[int], most: int = 3) -> str:
    """The names of some rows in words."""
    names = [f'"{rows.names[place]}"' for place in others[:most]]
    return " and ".join(names) + (f" and {len(others) - most} more" if len(others) > most else "")


def _with_single(A, values, single, pivots, basis, offset) -> tuple[scipy.sparse.csc_array, np.ndarray]:
    """The rows of N for coordinates that only one row has, all at once: they are in no other expression."""
    if not len(single):
        return basis, offset
    rows = scipy.sparse.coo_array(A[single])
    own = rows.col == pivots[rows.row]
    top = np.ones(len(single))
    top[rows.row[own]] = rows.data[own]
    entries = -rows.data[~own] / top[rows.row[~own]]
    expressions = scipy.sparse.csr_array((entries, (pivots[rows.row[~own]], rows.col[~own])), shape=(A.shape[1], A.shape[1]))
    offset = offset + expressions @ offset
    offset[pivots] += values[single] / top
    return scipy.sparse.csc_array(basis + expressions @ basis), offset


def _null_space(solved, free, size) -> tuple[scipy.sparse.csc_array, np.ndarray]:
    """The expressions, each without the pivots before it, solved backwards for the free coordinates alone."""
    column = np.full(size, -1)
    column[free] = np.arange(len(free))
    offset, done = np.zeros(size), {}
    for pivot, (expression, (value, _)) in reversed(solved.items()):
        total: dict[int, float] = {}
        for j, (factor, _) in expression.items():
            value += factor * offset[j]
            for i, v in done[j].items() if j in done else ((j, 1.0),):
                total[i] = total.get(i, 0.0) + factor * v
        done[pivot], offset[pivot] = total, value
    row = np.concatenate([free, np.repeat(list(done), [len(found) for found in done.values()])]).astype(int)
    col = np.concatenate([free, [j for found in done.values() for j in found]]).astype(int)
    data = np.concatenate([np.ones(len(free)), [v for found in done.values() for v in found.values()]])
    return scipy.sparse.csc_array((data, (row, column[col])), shape=(size, len(free))), offset
