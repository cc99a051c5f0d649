"""Gauss's elimination row by row, in the order given: which rows say something new, and what they leave free.

Unlike ``linalg.rank``, which picks pivots from all rows, this keeps the first of rows that say the same. Each row in
its turn is reduced by those before it, and its pivot is the largest entry left (in columns brought to one scale by
powers of two). With pivots chosen within rows no step depends on how a row is scaled, and every multiplier is
bounded as in partial pivoting. A row whose rest is noise depends on those before it. Rows of 0, 1, -1 and plain
ratios keep their exact zeros, and so does the null space [-X; I] that is read off, X the reduced rows solved for
the pivot coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..linalg.kinds import others
from ..linalg.noise import Noisy
from ..linalg.scaling import column_units
from ..linalg.sparse import solution
from ..tolerances import EPS, NOISE_SAFETY

#: Largest entry of X for which [-X; I] is used; beyond it (nearly dependent rows) an orthonormal basis is better.
NULL_SPACE_LIMIT = 1e3


@dataclass(frozen=True)
class Reduction:
    """The rows of a matrix with n columns after elimination.

    Attributes:
        kept: places of the k independent rows.
        pivots: their pivot columns.
        rows: the reduced rows in scaled columns, upper triangular in the pivot columns, shape (k, n).
        scale: the powers of two that columns were multiplied by, shape (n,).
        margins: for each kept row by how much what was left of it stood above the noise.
        dependent: for every other place what is left of the entries that were carried along.
    """

    kept: tuple[int, ...]
    pivots: tuple[int, ...]
    rows: np.ndarray
    scale: np.ndarray
    margins: tuple[float, ...]
    dependent: dict[int, np.ndarray]

    def null_space(self) -> tuple[np.ndarray, tuple[int | None, ...]]:
        """V, shape (n, n - k), and the coordinate that each column is named for, None where it mixes them."""
        size, pivots = len(self.scale), list(self.pivots)
        free = others(size, pivots)
        solved = self.rows[:, free]
        if solved.size:
            solved = solution(self.rows[:, pivots], solved)  # LAPACK's dtrtrs wakes all threads for a single row
        if np.abs(solved).max(initial=0.0) > NULL_SPACE_LIMIT:
            orthogonal = np.linalg.qr(self.rows.T, mode="complete")[0]
            return self.scale[:, None] * orthogonal[:, len(pivots) :], (None,) * len(free)
        basis = np.zeros((size, len(free)))
        basis[pivots] = 0.0 - solved  # not -solved: no negative zeros
        basis[free, range(len(free))] = 1.0
        return self.scale[:, None] * basis / self.scale[free], tuple(free.tolist())


def reduce_rows(matrix: Noisy, carried: Noisy) -> Reduction:
    """Reduce the rows of a matrix (m, n) with noise, together with entries (m, p) that are carried along."""
    size = matrix.data.shape[1]
    scale = column_units(np.abs(matrix.data))
    data = np.concatenate([matrix.data * scale, carried.data], axis=1)
    noise = np.concatenate([matrix.noise * scale, carried.noise], axis=1)
    reduced: list[tuple[Noisy, int]] = []
    kept, margins, dependent = [], [], {}
    for place in range(len(data)):
        row = Noisy(data[place], noise[place])
        for top, pivot in reduced:
            if row.data[pivot]:
                row = _eliminated(row, top, pivot)
        row = Noisy(row.cleaned(), row.noise)
        if row.data[:size].any():
            pivot = int(np.abs(row.data[:size]).argmax())
            kept.append(place)
            margins.append(float(abs(row.data[pivot]) / (NOISE_SAFETY * row.noise[pivot])))
            reduced.append((row, pivot))
        else:
            dependent[place] = row.data[size:]
    rows = np.array([row.data[:size] for row, _ in reduced]).reshape(len(kept), size)
    return Reduction(tuple(kept), tuple(pivot for _, pivot in reduced), rows, scale, tuple(margins), dependent)


def _eliminated(row: Noisy, top: Noisy, pivot: int) -> Noisy:
    """The row less the multiple of another that makes its entry in that one's pivot column vanish."""
    factor = row.data[pivot] / top.data[pivot]
    factor_noise = (row.noise[pivot] + abs(factor) * top.noise[pivot]) / abs(top.data[pivot])
    noise = abs(factor) * top.noise + (factor_noise + EPS * abs(factor)) * np.abs(top.data)
    rest = row + Noisy(-factor * top.data, noise)
    rest[pivot] = Noisy(np.zeros(()), np.zeros(()))
    return rest
