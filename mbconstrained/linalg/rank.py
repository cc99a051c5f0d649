"""Rank decisions against carried rounding noise, with their evidence.

A matrix is reduced by Gauss's elimination with complete pivoting while the rounding noise of every entry is
carried along. What is left when all remaining entries are no larger than their noise is zero, and the pivots
so far are the rank. Elimination, not orthogonal factors: exact zeros and ratios of the data stay exact, and a
small entry that is known accurately (a light mass) is not lost beside large ones. The connected components of the
pattern of nonzeros are decided apart.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..tolerances import CLEAR_DROPPED, CLEAR_KEPT, EPS, NOISE_SAFETY
from .noise import Noisy, stacked
from .precise import magnitude, of_kind, rounded_to_float, unit
from .scaling import equilibration

#: By how much a row that is to become a pivot may be smaller than others.
PREFERENCE = 30.0

#: Below this size the elimination is as fast as asking whether it is needed.
SMALL = 24


@dataclass(frozen=True)
class RankDecision:
    """What a rank decision was based on.

    Attributes:
        rank: the rank decided.
        smallest_kept: the least ratio (pivot / bound below which it counts as zero); inf when none was kept.
        largest_dropped: the largest such ratio of the entries dropped; zero when none was dropped.
        singular_values: where the decision is not clear, those of the equilibrated matrix, descending.
    """

    rank: int
    smallest_kept: float
    largest_dropped: float
    singular_values: tuple[float, ...] = ()

    @property
    def clear(self) -> bool:
        """True where no value kept or dropped is near the bound that decides."""
        return self.smallest_kept >= CLEAR_KEPT and self.largest_dropped <= CLEAR_DROPPED


@dataclass(frozen=True)
class RowCompression:
    """The rows of S (m, n): ``pivots`` are independent, and null @ S = 0.

    Attributes:
        pivots: indices of k independent rows.
        null: combinations of rows that vanish, shape (m - k, m), with their noise.
    """

    pivots: np.ndarray
    null: Noisy
    decision: RankDecision

    @property
    def left(self) -> Noisy:
        """The regular matrix (m, m) that selects the pivot rows, then combines the vanishing ones."""
        selection = np.eye(self.null.data.shape[1])[self.pivots]
        return stacked(Noisy.exact(selection), self.null)

    def apply(self, rows: Noisy) -> Noisy:
        """left @ rows, without multiplying by ones and zeros."""
        return stacked(rows[self.pivots], self.null @ rows)


def compress_rows(
    matrix: Noisy,
    weights: np.ndarray | None = None,
    preferred: np.ndarray | None = None,
    decided: RankDecision | None = None,
) -> RowCompression:
    """Find the dependent rows of a matrix with noise.

    Args:
        matrix: S, shape (m, n).
        weights: factors (n,) by which columns count in the choice of pivots.
        preferred: rows (m,) that become pivots rather than others, where this does not cost more than a digit or two.
        decided: a decision made before, on the same matrix with fewer digits; where it is given the noise only ranks pivots.
    """
    rows, columns = matrix.data.shape
    weights = np.ones(columns) if weights is None else weights
    favour = np.ones(rows) if preferred is None else np.where(preferred, PREFERENCE, 1.0)
    pivots, nulls, decisions = [np.zeros(0, dtype=int)], [_zeros_like(matrix, (0, rows))], []
    if decided is not None and decided.rank == rows:
        return RowCompression(np.arange(rows), _zeros_like(matrix, (0, rows)), decided)
    if decided is not None:
        return RowCompression(*_eliminated(matrix, weights, favour, decided))
    cleaned = Noisy(matrix.cleaned(), matrix.noise)
    for i, j in _components(cleaned.data):
        order, combinations, decision = _eliminated(cleaned[np.ix_(i, j)], weights[j], favour[i])
        placed = _zeros_like(matrix, (len(combinations.data), rows))
        placed[:, i] = combinations
        pivots.append(i[order])
        nulls.append(placed)
        decisions.append(decision)
    decision = _joined(decisions)
    dropped = max(decision.largest_dropped, _largest_ratio(matrix[cleaned.data == 0]))
    decision = _with_singular_values(replace(decision, largest_dropped=dropped), matrix)
    return RowCompression(np.concatenate(pivots), stacked(*nulls), decision)


def null_columns(
    matrix: Noisy, preferred: np.ndarray | None = None, decided: RankDecision | None = None
) -> RowCompression:
    """The same for the columns of S: S[:, pivots] are independent, and S @ null.T = 0; preferred ones become pivots if they can."""
    size = matrix.size.max(axis=1, initial=0.0)
    weights = 1 / np.where(size > 0, size, 1.0)
    return compress_rows(matrix.T, weights, preferred, decided)


def _zeros_like(matrix: Noisy, shape) -> Noisy:
    return Noisy.exact(of_kind(np.zeros(shape), matrix.data))


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


def _eliminated(matrix: Noisy, weights, favour, decided=None) -> tuple[np.ndarray, Noisy, RankDecision]:
    """Pivot rows in order, the combinations of rows that vanish, and the decision, for one component.

    The rows are reduced together with an identity, in which the combination that each has become is recorded.
    """
    rows, columns = matrix.data.shape
    if decided is None and (margin := _regular_by_far(matrix)) is not None:
        return np.arange(rows), Noisy.exact(np.zeros((0, rows))), RankDecision(rows, margin, 0.0)
    identity = of_kind(np.eye(rows), matrix.data)
    work = Noisy(np.hstack([matrix.data, identity]), np.hstack([matrix.noise, np.zeros((rows, rows))]))
    order, rank, kept, dropped = np.arange(rows), 0, np.inf, 0.0
    most = min(rows, columns) if decided is None else decided.rank
    while rank < most:
        row, column = _pivot(work[rank:, :columns], weights * favour[order[rank:], None], at_any_rate=decided is not None)
        if row is None:
            break
        swap = [rank + row, rank]
        order[swap], work[swap] = order[swap[::-1]], work[swap[::-1]]
        bound = NOISE_SAFETY * work.noise[rank, column]
        kept = min(kept, float(abs(work.data[rank, column])) / bound if bound else np.inf)
        dropped = max(dropped, _eliminate(work, rank, column, columns, clean=decided is None))
        rank += 1
    decision = decided or _with_singular_values(RankDecision(rank, float(kept), dropped), matrix)
    return order[:rank], work[rank:, columns:], decision


def _pivot(rest: Noisy, weights, at_any_rate: bool):
    """Row and column of the largest entry above the noise, or if there is none and must be one, of the one nearest to it."""
    told = rest.size > NOISE_SAFETY * rest.noise
    size = np.where(told, rest.size * weights, 0.0)
    if at_any_rate and not told.any():
        size = rest.size / np.where(rest.noise > 0, rest.noise, 1.0)
    row, column = np.unravel_index(size.argmax(), size.shape)
    return (row, column) if size[row, column] else (None, None)


def _with_singular_values(decision: RankDecision, matrix: Noisy) -> RankDecision:
    if decision.clear or decision.singular_values:
        return decision
    rows, columns = equilibration(matrix.size)
    values = np.linalg.svd(rows[:, None] * rounded_to_float(matrix.data) * columns, compute_uv=False)
    return replace(decision, singular_values=tuple(map(float, values)))


def _regular_by_far(matrix: Noisy) -> float | None:
    """How far the smallest singular value is above the noise, for a large square matrix that is regular beyond doubt.

    A factorization by LAPACK settles what the elimination with noise, much slower, would find as well.
    """
    size = len(matrix.data)
    if size < SMALL or matrix.data.shape != (size, size):
        return None
    rows, columns = equilibration(matrix.size)
    scaled, noise = rows[:, None] * rounded_to_float(matrix.data) * columns, rows[:, None] * matrix.noise * columns
    norm = np.abs(scaled).sum(axis=0).max()
    factors, _, info = lapack.dgetrf(scaled)
    reciprocal = lapack.dgecon(factors, norm)[0] if info == 0 else 0.0
    margin = reciprocal * norm / (NOISE_SAFETY * max(noise.sum(axis=0).max(), EPS * norm))
    return float(margin) if margin >= CLEAR_KEPT else None


def _eliminate(work: Noisy, pivot: int, column: int, columns: int, clean: bool) -> float:
    """Subtract multiples of the pivot row from those below it; return the largest entry dropped as noise, over its bound."""
    top, below = work[pivot], work[pivot + 1 :]
    touched = np.flatnonzero(below.data[:, column])
    if not touched.size:
        return 0.0
    rest = below[touched]
    factor = rest.data[:, column] / top.data[column]
    times, size = magnitude(factor), top.size
    factor_noise = np.hypot(rest.noise[:, column], times * top.noise[column]) / size[column]
    change = np.multiply.outer(factor, top.data)
    rounds = unit(change) * ((rest.data != 0) & (change != 0))
    data = rest.data - change
    squared = rest.noise**2 + np.multiply.outer(times**2, top.noise**2) + np.multiply.outer(factor_noise**2, size**2)
    noise = np.sqrt(squared + rounds**2 * (rest.size**2 + magnitude(change) ** 2))
    data[:, column], noise[:, column] = data[:, column] * 0, 0.0
    small = magnitude(data[:, :columns]) <= NOISE_SAFETY * noise[:, :columns]
    dropped = _largest_ratio(Noisy(data[:, :columns][small], noise[:, :columns][small]))
    if clean:
        data[:, :columns][small] = data[:, :columns][small] * 0
    work[pivot + 1 + touched] = Noisy(data, noise)
    return dropped


def _largest_ratio(dropped: Noisy) -> float:
    """The largest of the values dropped, over the bound below which they count as zero."""
    bound = NOISE_SAFETY * dropped.noise
    return float((dropped.size / np.where(bound > 0, bound, 1.0)).max(initial=0.0))


def _joined(decisions) -> RankDecision:
    return RankDecision(
        sum(decision.rank for decision in decisions),
        min((decision.smallest_kept for decision in decisions), default=np.inf),
        max((decision.largest_dropped for decision in decisions), default=0.0),
        tuple(sorted((value for decision in decisions for value in decision.singular_values), reverse=True)),
    )
