"""Arrays with the rounding errors of each entry, their elimination, and rank decisions with evidence."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from ..ground.tolerances import CLEAR_DROPPED, CLEAR_KEPT, EPS, NOISE_SAFETY, PIVOT_PREFERENCE, PRECISE_DECOUPLING
from .arrays import LARGE, compressed, lapack
from .blocks import coupled
from .precise import floats, is_precise, magnitude, midpoints, of_kind, precise, product, unit
from .scaling import equilibration

# Arrays with an estimate of the rounding errors of each entry, propagated through sums and products.
# Noise adds in quadrature, as independent errors do: bounds by absolute values would grow with every step of a
# staircase by more than the errors themselves, and call regular matrices singular.
# Gaussian elimination with these errors serves rank decisions and rows in a given order. Exact zeros stay zero,
# and ratios of small whole numbers are exact, where orthogonal factors would fill them with rounding errors. A sparse kernel for
# large models is ``mechanics.sparse.pencil``.


@dataclass(slots=True)
class Noisy:
    """An array whose entries have errors of about ``noise`` (same shape, >= 0); those with noise zero are exact.

    The data may be float64 or precise (``linalg.precise``), the noise is always float64.
    """

    data: np.ndarray
    noise: np.ndarray

    @staticmethod
    def exact(data: np.ndarray) -> Noisy:
        """Numbers without errors."""
        return Noisy(data, np.zeros(data.shape))

    @staticmethod
    def rounded(data: np.ndarray) -> Noisy:
        """Numbers known up to a unit in the last place, as given data is."""
        return Noisy(data, EPS * magnitude(data))

    @property
    def size(self) -> np.ndarray:
        """|data| in float64."""
        return magnitude(self.data)

    def __matmul__(self, other: Noisy) -> Noisy:
        left, right = self.data, other.data
        if not (left.size and right.size):
            return Noisy.exact(product(left, right))
        own, others, noise, others_noise = magnitude(left) ** 2, magnitude(right) ** 2, self.noise**2, other.noise**2
        signs = np.sign(own)
        few = (
            left.ndim == 2 and len(left) >= LARGE and 8 * int(np.count_nonzero(left)) < left.size
        )  # then sparse products are faster
        if few and not is_precise(left) and not is_precise(right):
            data = compressed(left) @ right
            own, noise, signs = compressed(own), compressed(noise), compressed(signs)
        else:
            data = product(left, right)
        total = own.dot(others_noise) + noise.dot(others + others_noise)
        if left.shape[-1] > 1:  # a sum of one term rounds at most once, and that is part of the noise of its factors
            several = signs.dot(np.sign(others)) > 1
            total += several * (unit(data) ** 2 * own.dot(others))
        return Noisy(data, np.sqrt(total))

    def __add__(self, other: Noisy) -> Noisy:
        data = of_kind(self.data, other.data) + of_kind(other.data, self.data)
        rounding = (unit(data) * magnitude(data)) * ((self.data != 0) & (other.data != 0))
        return Noisy(data, np.sqrt(self.noise**2 + other.noise**2 + rounding**2))

    def __neg__(self) -> Noisy:
        return Noisy(-self.data, self.noise)

    def __getitem__(self, key) -> Noisy:
        return Noisy(self.data[key], self.noise[key])

    def __setitem__(self, key, value: Noisy) -> None:
        self.data[key], self.noise[key] = of_kind(value.data, self.data), value.noise

    def copy(self) -> Noisy:
        """A copy that can be changed in place."""
        return Noisy(self.data.copy(), self.noise.copy())

    def cleaned(self) -> np.ndarray:
        """The array, entries within their noise set to zero."""
        small = self.size <= NOISE_SAFETY * self.noise
        if is_precise(self.data):  # times one would round them
            return np.where(small, self.data * 0, self.data)
        return self.data * ~small

    def settled(self) -> Noisy:
        """The array with entries within their noise as exact zeros, so that products with them do not add noise."""
        data = self.cleaned()
        return Noisy(data, np.where(data != 0, self.noise, 0.0))

    def rounded_to_float(self) -> Noisy:
        """The array in float64, with the noise of that rounding."""
        if not is_precise(self.data):
            return self
        return Noisy(floats(self.data), np.hypot(self.noise, EPS * self.size))

    @property
    def T(self) -> Noisy:
        """The transpose."""
        return Noisy(self.data.T, self.noise.T)


def stacked(*parts: Noisy) -> Noisy:
    """The parts, one below the other."""
    data = [part.data for part in parts]
    if any(map(is_precise, data)):
        data = list(map(precise, data))
    return Noisy(np.concatenate(data), np.concatenate([part.noise for part in parts]))


def columnwise(matrix: np.ndarray) -> Noisy:
    """A basis from an eigenvalue algorithm: each column is known up to the rounding error of its largest entry."""
    noise = PRECISE_DECOUPLING if is_precise(matrix) else EPS
    return Noisy(matrix, noise * magnitude(matrix).max(axis=0, initial=0.0) + np.zeros(matrix.shape))


def eliminate(work: Noisy, row: int, column: int, first: int = 0, width: int | None = None, clean: bool = True) -> float:
    """Subtract multiples of a row from others, in place, so that their entries in one column vanish.

    The rounding errors of factors, rows and differences add in quadrature.
    """
    touched = first + (work.data[first:, column] != 0).nonzero()[0]
    touched = touched[touched != row]
    if not touched.size:
        return 0.0
    top, top_noise, rest, noise = work.data[row], work.noise[row], work.data[touched], work.noise[touched]
    factor, size = rest[:, column, None] / top[column], magnitude(top)
    change, times = factor * top, magnitude(factor)
    factor_noise = np.hypot(noise[:, column, None], times * top_noise[column]) / size[column]
    data, before, subtracted = midpoints(rest - change), magnitude(rest) ** 2, magnitude(change) ** 2
    rounding = (np.minimum(before, subtracted) > 0) * (unit(change) ** 2 * (before + subtracted))
    noise = np.sqrt(noise**2 + (times * top_noise) ** 2 + (factor_noise * size) ** 2 + rounding)
    data[:, column], noise[:, column] = data[:, column] * 0, 0.0
    own, own_noise = data[:, :width], noise[:, :width]
    small = magnitude(own) <= NOISE_SAFETY * own_noise
    dropped = largest_ratio(Noisy(own[small], own_noise[small]))
    if clean:
        own *= ~small
    work.data[touched], work.noise[touched] = data, noise
    return dropped


def largest_ratio(entries: Noisy) -> float:
    """The largest of these entries over the bound below which it counts as zero; 0 where all are zero."""
    if not (entries.data != 0).any():
        return 0.0
    bound = NOISE_SAFETY * entries.noise
    return float((entries.size / np.where(bound > 0, bound, 1.0)).max())


def reduce_in_order(
    work: Noisy, width: int, preferred: np.ndarray | None = None, preference: float = 1.0
) -> tuple[list[int], list[int]]:
    """Reduce the rows of a matrix in place, each by those before it; of dependent rows the first are kept.

    With pivots chosen within rows no step depends on the scale of a row, and every factor is bounded as in partial pivoting.

    >>> work = Noisy.rounded(np.array([[1.0, -1.0, 0.0], [2.0, -2.0, 0.0], [0.0, 1.0, -1.0]]))
    >>> reduce_in_order(work, 3)
    ([0, 2], [0, 1])
    """
    work.data[:] = work.cleaned()
    kept, pivots = [], []
    for place, row in enumerate(work.data[:, :width]):
        size = np.abs(row)
        if preferred is not None and (own := np.where(preferred, size, 0.0)).max(initial=0.0) * preference > size.max(initial=0.0):
            size = own
        if size.any():
            kept.append(place)
            pivots.append(int(size.argmax()))
            eliminate(work, place, pivots[-1], place + 1)
    return kept, pivots


# Rank decisions against accumulated rounding noise, with their evidence.
# A matrix is reduced by Gauss's elimination with complete pivoting while the noise of every entry is
# carried along. What is left when all remaining entries are no larger than their noise is zero, and the pivots
# so far are the rank. Elimination, not orthogonal factors: exact zeros and ratios of the data stay exact, and a
# small entry that is known accurately (a light mass) is not lost next to large ones. The connected components of the
# pattern of nonzeros are decided separately, those of a single entry all at once.

#: Below this size the elimination is as fast as asking whether it is needed.
SMALL = 24


@dataclass(frozen=True)
class RankDecision:
    """Evidence of a rank decision.

    Attributes:
        rank: the rank decided.
        smallest_kept: the least ratio (pivot / bound below which it counts as zero); inf when none was kept.
        largest_dropped: the largest such ratio of the entries dropped; zero when none was dropped.
        singular_values: singular values of the equilibrated matrix where the decision is not clear, descending.
        is_structural: whether the rank is the largest that the pattern of all entries, dropped ones included, allows: keeping them
            would not change it.
    """

    rank: int
    smallest_kept: float
    largest_dropped: float
    singular_values: tuple[float, ...] = ()
    is_structural: bool = False

    @property
    def clear(self) -> bool:
        """True where no value that could have changed the rank is near the bound that decides."""
        return self.smallest_kept >= CLEAR_KEPT and (self.is_structural or self.largest_dropped <= CLEAR_DROPPED)


@dataclass(frozen=True, eq=False)
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
        return stacked(rows[self.pivots], self.combined(rows))

    def combined(self, rows: Noisy) -> Noisy:
        """null @ rows."""
        used = self.null.size.any(axis=0) | self.null.noise.any(axis=0)
        return self.null[:, used] @ rows[used]

    def kept(self, rows: Noisy) -> Noisy:
        """Rows, or combinations of them, that are as independent as those of S that are kept."""
        return rows[self.pivots]

    def placed(self, kept: Noisy) -> Noisy:
        """The transpose of ``kept``: k rows as m."""
        rows = _zeros_like(kept, (self.null.data.shape[1], kept.data.shape[1]))
        rows[self.pivots] = kept
        return rows


@dataclass(frozen=True, eq=False)
class RowRotation(RowCompression):
    """Row compression by orthogonal matrices: ``basis`` and ``null`` are orthonormal, and there are no pivots."""

    basis: Noisy

    def kept(self, rows: Noisy) -> Noisy:
        """basis @ rows."""
        return self.basis @ rows

    def placed(self, kept: Noisy) -> Noisy:
        """basis^T @ kept."""
        return self.basis.T @ kept


def rotate_rows(matrix: Noisy) -> RowRotation:
    """Find the dependent rows of a matrix by its singular values, which count as zero within the norm of the noise.

    Noise does not grow by orthogonal matrices, so that many steps in a row remain clear; but an entry that is small and well known is
    lost next to large ones that are not.
    """
    u, values, _ = np.linalg.svd(matrix.data)
    bound = NOISE_SAFETY * max(np.linalg.norm(matrix.noise), EPS * values.max(initial=0.0))
    rank = int((values > bound).sum())
    kept = values[rank - 1] / bound if rank and bound else np.inf
    dropped = values[rank] / bound if bound and rank < len(values) else 0.0
    decision = RankDecision(rank, float(kept), float(dropped), tuple(values.tolist()))
    basis, null = (Noisy.exact(part.T) for part in (u[:, :rank], u[:, rank:]))
    return RowRotation(np.zeros(0, dtype=int), null, decision, basis)


def compress_rows(
    matrix: Noisy, weights: np.ndarray | None = None, preferred: np.ndarray | None = None, decided: RankDecision | None = None
) -> RowCompression:
    """Find the dependent rows of a matrix with noise."""
    rows, columns = matrix.data.shape
    weights = np.ones(columns) if weights is None else weights
    favour = np.ones(rows) if preferred is None else np.where(preferred, PIVOT_PREFERENCE, 1.0)
    if decided is not None and decided.rank == rows:
        return RowCompression(np.arange(rows), _zeros_like(matrix, (0, rows)), decided)
    if decided is not None:
        return RowCompression(*_eliminated(matrix, weights, favour, decided))
    cleaned = Noisy(matrix.cleaned(), matrix.noise)
    pattern = cleaned.data != 0
    dropped = largest_ratio(matrix[~pattern])
    lone, margin = _lone(cleaned, pattern)
    empty = (~pattern.any(axis=1)).nonzero()[0]
    pattern[lone] = False
    components = [(i, *_eliminated(cleaned[i[:, None], j], weights[j], favour[i])) for i, j in coupled(pattern)]
    decision = _joined([RankDecision(len(lone), margin, dropped), *(decision for *_, decision in components)])
    pivots, first = [lone], [lone]
    for i, order, *_ in components:
        pivots.append(i[order])
        first.append(np.full(len(order), i[0]))
    in_order = np.argsort(np.concatenate(first), kind="stable")
    null = _null_rows(matrix, empty, components, rows - decision.rank)
    return RowCompression(np.concatenate(pivots)[in_order], null, _with_evidence(decision, matrix))


def _null_rows(matrix: Noisy, empty, components, count: int) -> Noisy:
    """This many vanishing combinations of all rows: empty rows and those of the components, in the order of their first rows."""
    null, first, end = _zeros_like(matrix, (count, len(matrix.data))), [*empty], len(empty)
    null.data[range(end), empty] = of_kind(np.ones(end), matrix.data)
    for i, _, combinations, _ in components:
        begin, end = end, end + len(combinations.data)
        null[begin:end, i] = combinations
        first += [i[0]] * (end - begin)
    return null[np.argsort(first, kind="stable")] if count else null


def null_columns(matrix: Noisy, preferred: np.ndarray | None = None, decided: RankDecision | None = None) -> RowCompression:
    """Column compression: S[:, pivots] are independent, and S @ null.T = 0; preferred columns become pivots if possible."""
    size = matrix.size.max(axis=1, initial=0.0)
    return compress_rows(matrix.T, 1 / (size + (size == 0)), preferred, decided)


def _zeros_like(matrix: Noisy, shape) -> Noisy:
    return Noisy.exact(of_kind(np.zeros(shape), matrix.data))


def _lone(matrix: Noisy, pattern) -> tuple[np.ndarray, float]:
    """Rows whose single entry is the only one of its column and clearly above the noise, and the smallest ratio of them."""
    i, j = (pattern & (pattern.sum(axis=1) == 1)[:, None] & (pattern.sum(axis=0) == 1)).nonzero()
    if not i.size:
        return i, np.inf
    size, bound = magnitude(matrix.data[i, j]), NOISE_SAFETY * matrix.noise[i, j]
    clear, exact = size >= CLEAR_KEPT * bound, bound == 0
    ratios = size / np.where(exact, 1.0, bound)
    return i[clear], float(ratios[clear & ~exact].min(initial=np.inf))


def _eliminated(matrix: Noisy, weights, favour, decided=None) -> tuple[np.ndarray, Noisy, RankDecision]:
    """Pivot rows in order, the combinations of rows that vanish, and the decision, for one component.

    The rows are reduced together with an identity, in which the combination that each has become is recorded.
    """
    rows, columns = matrix.data.shape
    if decided is None and (margin := _regular_by_far(matrix)) is not None:
        return np.arange(rows), Noisy.exact(np.zeros((0, rows))), RankDecision(rows, margin, 0.0)
    identity = of_kind(np.eye(rows), matrix.data)
    work = Noisy(np.concatenate([matrix.data, identity], axis=1), np.concatenate([matrix.noise, np.zeros((rows, rows))], axis=1))
    order, rank, kept, dropped, weights = np.arange(rows), 0, np.inf, 0.0, weights * favour[:, None]
    most = min(rows, columns) if decided is None else decided.rank
    while rank < most:
        row, column = _pivot(work[rank:, :columns], weights[rank:], at_any_rate=decided is not None)
        if row is None:
            break
        if row:
            swap, swapped = [rank + row, rank], [rank, rank + row]
            order[swap], work[swap], weights[swap] = order[swapped], work[swapped], weights[swapped]
        bound = NOISE_SAFETY * work.noise[rank, column]
        kept = min(kept, float(abs(work.data[rank, column])) / bound if bound else np.inf)
        dropped = max(dropped, eliminate(work, rank, column, rank + 1, columns, clean=decided is None))
        rank += 1
    decision = decided or RankDecision(rank, float(kept), dropped)
    return order[:rank], work[rank:, columns:], decision


def _pivot(rest: Noisy, weights, at_any_rate: bool):
    """Row and column of the largest entry; if a pivot is required and none is above its noise, of the entry nearest to it."""
    size = rest.size * weights
    if at_any_rate:
        certain = rest.size > NOISE_SAFETY * rest.noise
        size = size * certain if certain.any() else rest.size / (rest.noise + (rest.noise == 0))
    row, column = divmod(int(size.argmax()), size.shape[1])
    return (row, column) if size[row, column] else (None, None)


def _with_evidence(decision: RankDecision, matrix: Noisy) -> RankDecision:
    """A decision near its bound, with the sensitivity of the rank to the entries and the singular values."""
    if decision.clear:
        return decision
    decision = replace(
        decision, is_structural=decision.rank == scipy.sparse.csgraph.structural_rank(scipy.sparse.csr_array(matrix.size != 0))
    )
    if decision.clear:
        return decision
    rows, columns = equilibration(matrix.size)
    values = np.linalg.svd(rows[:, None] * floats(matrix.data) * columns, compute_uv=False)
    return replace(decision, singular_values=tuple(map(float, values)))


def _regular_by_far(matrix: Noisy) -> float | None:
    """Ratio of the smallest singular value to the noise, for a large matrix whose rows are independent beyond doubt.

    A factorization by LAPACK gives the result of the much slower elimination with noise.
    """
    size, width = matrix.data.shape
    if size < SMALL or width < size:
        return None
    rows, columns = equilibration(matrix.size)
    scaled, noise = rows[:, None] * floats(matrix.data) * columns, rows[:, None] * matrix.noise * columns
    if width > size:
        values, limit = np.linalg.svd(scaled, compute_uv=False), NOISE_SAFETY * np.linalg.norm(noise)
        margin = values[-1] / max(limit, NOISE_SAFETY * EPS * values[0])
        return float(margin) if margin >= CLEAR_KEPT else None
    norm = np.abs(scaled).sum(axis=0).max()
    factors, _, info = lapack.dgetrf(scaled)
    reciprocal = lapack.dgecon(factors, norm)[0] if info == 0 else 0.0
    margin = reciprocal * norm / (NOISE_SAFETY * max(noise.sum(axis=0).max(), EPS * norm))
    return float(margin) if margin >= CLEAR_KEPT else None


def _joined(decisions) -> RankDecision:
    return RankDecision(
        sum(decision.rank for decision in decisions),
        min(decision.smallest_kept for decision in decisions),
        max(decision.largest_dropped for decision in decisions),
    )
