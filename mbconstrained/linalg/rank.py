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
class RowCompression:
    """An orthogonal ``left`` with left @ S = [S_1; 0], S_1 of full row rank."""

    left: np.ndarray
    decision: RankDecision


@dataclass(frozen=True)
class ColumnCompression:
    """``left @ S @ right`` = [diag(values), 0] with an orthogonal right, for an S of full row rank."""

    left: np.ndarray
    right: np.ndarray
    values: np.ndarray
    decision: RankDecision


def compress_rows(matrix: np.ndarray, noise: np.ndarray) -> RowCompression:
    """Rotate the rows of a matrix with entrywise noise so that the dependent ones vanish, at the end."""
    rows = len(matrix)
    kept, null, decisions = [np.zeros((0, rows))], [np.zeros((0, rows))], []
    for i, _, part in _decided_components(matrix, noise, scale_columns=True):
        directions = np.zeros((len(i), rows))
        directions[:, i] = _null_last(part).T
        kept.append(directions[: part.decision.rank])
        null.append(directions[part.decision.rank :])
        decisions.append(part.decision)
    return RowCompression(np.vstack(kept + null), _joined(decisions))


def compress_columns(matrix: np.ndarray, noise: np.ndarray) -> ColumnCompression:
    """Rotate the columns of a matrix with entrywise noise so that the first ones hold all of it."""
    rows, columns = matrix.shape
    lefts, firsts, rest, values, decisions = [np.zeros((0, rows))], [], [], [], []
    for i, j, part in _decided_components(matrix, noise, scale_columns=False):
        rank = part.decision.rank
        left, right = np.zeros((rank, rows)), np.zeros((columns, len(j)))
        left[:, i] = (part.u * part.row_scale[:, None]).T[:rank]
        right[j] = part.vt.T
        lefts.append(left)
        firsts.append(right[:, :rank])
        rest.append(right[:, rank:])
        values.append(part.values[:rank])
        decisions.append(part.decision)
    right = np.hstack(firsts + rest) if firsts else np.eye(columns)
    return ColumnCompression(np.vstack(lefts), right, np.concatenate([[], *values]), _joined(decisions))


@dataclass(frozen=True)
class _Decided:
    """row_scale * S * column_scale = u diag(values) vt, and the rank decided for S."""

    u: np.ndarray
    values: np.ndarray
    vt: np.ndarray
    row_scale: np.ndarray
    decision: RankDecision


def _decided_components(matrix, noise, scale_columns):
    """(row indices, column indices, decision) of every connected group; entries within their noise are zero."""
    matrix = np.where(np.abs(matrix) <= NOISE_SAFETY * noise, 0.0, matrix)
    for i, j in _components(matrix):
        yield i, j, _decide(matrix[np.ix_(i, j)], noise[np.ix_(i, j)], scale_columns)


def _components(matrix):
    """Row and column indices of the connected groups; an empty row or column is a group with none of the other."""
    rows, columns = matrix.shape
    i, j = np.nonzero(matrix)
    size = rows + columns
    if not size:
        return
    graph = coo_array((np.ones(len(i)), (i, rows + j)), shape=(size, size))
    count, labels = connected_components(graph, directed=False)
    order = np.argsort(labels, kind="stable")
    for members in np.split(order, np.cumsum(np.bincount(labels, minlength=count))[:-1]):
        yield members[members < rows], members[members >= rows] - rows


def _decide(matrix, noise, scale_columns) -> _Decided:
    rows, columns = matrix.shape
    if not rows or not columns:
        return _Decided(np.eye(rows), np.zeros(0), np.eye(columns), np.ones(rows), RankDecision(0, np.inf, 0.0))
    size = np.abs(matrix) if scale_columns else np.abs(matrix).max(axis=1, keepdims=True)
    row_scale, column_scale = equilibration(size)
    column_scale = column_scale if scale_columns else np.ones(columns)
    u, values, vt = scipy.linalg.svd(row_scale[:, None] * matrix * column_scale, lapack_driver="gesvd")
    scaled_noise = row_scale[:, None] * noise * column_scale
    count = len(values)
    carried = np.einsum("ij,ik,kj->j", np.abs(u[:, :count]), scaled_noise, np.abs(vt[:count].T))
    own = EPS * values[0] * (rows * columns > 1)  # a single number is decomposed without rounding
    ratios = values / np.maximum(NOISE_SAFETY * (carried + own), np.finfo(float).tiny)
    rank = int((ratios > 1).sum())
    decision = RankDecision(rank, float(ratios[:rank].min(initial=np.inf)), float(ratios[rank:].max(initial=0.0)))
    return _Decided(u, values, vt, row_scale, decision)


def _null_last(part: _Decided) -> np.ndarray:
    """An orthogonal basis of the row space whose last columns span the left null space in unscaled rows."""
    rank = part.decision.rank
    if rank == len(part.u):
        return np.eye(rank)
    turned = scipy.linalg.qr(part.u[:, rank:] * part.row_scale[:, None])[0]
    return np.roll(turned, rank, axis=1)


def _joined(decisions) -> RankDecision:
    return RankDecision(
        sum(decision.rank for decision in decisions),
        min((decision.smallest_kept for decision in decisions), default=np.inf),
        max((decision.largest_dropped for decision in decisions), default=0.0),
    )
