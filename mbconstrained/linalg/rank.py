"""Rank decisions against carried rounding noise, with their evidence.

A matrix S comes with a matrix N >= 0 of the rounding noise of each entry. Independent groups of rows and
columns (the connected components of the pattern of nonzeros) are decided apart, so that exact zeros stay
exact and one group's scale cannot hide another's. Each group is scaled to unit rows and columns, which
changes no rank, and a singular value sigma_i with vectors u_i, v_i counts as zero when
sigma_i <= |u_i|^T N |v_i|, the first-order bound of what the noise can do to it, plus the rounding of the
decomposition itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..tolerances import CLEAR_GAP, EPS, NOISE_SAFETY
from .scaling import equilibration


@dataclass(frozen=True)
class RankDecision:
    """What a rank decision was based on.

    Attributes:
        rank: the rank decided.
        smallest_kept: the least ratio (singular value / its noise) of those kept; inf when none was kept.
        largest_dropped: the largest such ratio of those dropped; zero when none was dropped.
    """

    rank: int
    smallest_kept: float
    largest_dropped: float

    @property
    def clear(self) -> bool:
        """True where no kept value is near the noise."""
        return self.smallest_kept >= CLEAR_GAP


@dataclass(frozen=True)
class Compression:
    """S = inverse(left) [[diag(values), 0], [0, 0]] inverse(right), up to noise.

    ``left @ S @ right`` has the kept singular values first, zeros after. Rows and columns are scaled, so left
    and right are orthogonal matrices times positive diagonal ones.
    """

    left: np.ndarray
    right: np.ndarray
    values: np.ndarray
    decision: RankDecision


def compress(matrix: np.ndarray, noise: np.ndarray, *, scale_columns: bool = True) -> Compression:
    """Split a matrix with entrywise noise into its row and column space and the rest.

    Without column scaling ``right`` is orthogonal: wanted where its columns become part of a basis.
    """
    matrix = np.where(np.abs(matrix) <= NOISE_SAFETY * noise, 0.0, matrix)
    rows, columns = matrix.shape
    left, right = np.zeros((rows, rows)), np.zeros((columns, columns))
    kept_values: list[float] = []
    kept: list[tuple[np.ndarray, np.ndarray]] = []
    null_left: list[np.ndarray] = []
    null_right: list[np.ndarray] = []
    margins_kept, margins_dropped = [np.inf], [0.0]
    for i, j in _components(matrix):
        part = _compress_component(matrix[np.ix_(i, j)], noise[np.ix_(i, j)], scale_columns)
        rank = len(part.values)
        placed_left, placed_right = np.zeros((len(i), rows)), np.zeros((columns, len(j)))
        placed_left[:, i], placed_right[j] = part.left, part.right
        kept += [(placed_left[k], placed_right[:, k]) for k in range(rank)]
        kept_values += list(part.values)
        null_left += list(placed_left[rank:])
        null_right += list(placed_right.T[rank:])
        margins_kept.append(part.decision.smallest_kept)
        margins_dropped.append(part.decision.largest_dropped)
    left = np.array([row for row, _ in kept] + null_left).reshape(rows, rows)
    right = np.array([column for _, column in kept] + null_right).reshape(columns, columns).T
    decision = RankDecision(len(kept), min(margins_kept), max(margins_dropped))
    return Compression(left, right, np.array(kept_values), decision)


def _components(matrix):
    """Row and column indices of the connected groups, empty rows and columns included (with none of the other)."""
    rows, columns = matrix.shape
    i, j = np.nonzero(matrix)
    size = rows + columns
    graph = coo_array((np.ones(len(i)), (i, rows + j)), shape=(size, size))
    count, labels = connected_components(graph, directed=False)
    order = np.argsort(labels, kind="stable")
    for members in np.split(order, np.cumsum(np.bincount(labels, minlength=count))[:-1]) if size else []:
        yield members[members < rows], members[members >= rows] - rows


def _compress_component(matrix, noise, scale_columns) -> Compression:
    rows, columns = matrix.shape
    if not rows or not columns:
        return Compression(np.eye(rows), np.eye(columns), np.zeros(0), RankDecision(0, np.inf, 0.0))
    if scale_columns:
        row_scale, column_scale = equilibration(np.abs(matrix))
    else:
        row_scale, column_scale = equilibration(np.abs(matrix).max(axis=1, keepdims=True))[0], np.ones(columns)
    scaled = row_scale[:, None] * matrix * column_scale
    scaled_noise = row_scale[:, None] * noise * column_scale
    u, values, vt = scipy.linalg.svd(scaled, lapack_driver="gesvd")
    count = len(values)
    carried = np.einsum("ij,ik,kj->j", np.abs(u[:, :count]), scaled_noise, np.abs(vt[:count].T))
    own = EPS * values[0] * (rows * columns > 1)  # a single number is decomposed without rounding
    ratios = values / np.maximum(NOISE_SAFETY * (carried + own), np.finfo(float).tiny)
    rank = int((ratios > 1).sum())
    decision = RankDecision(rank, float(ratios[:rank].min(initial=np.inf)), float(ratios[rank:].max(initial=0.0)))
    return Compression(u.T * row_scale, vt.T * column_scale[:, None], values[:rank], decision)
