"""The pencil K - s M of a system of sparse matrices on the coordinates that its constraint rows leave free.

A row with a coordinate that no other row has is solved for it at once. The others are eliminated one by one in the order
given (Gaussian elimination on rows kept as dictionaries), each entry with its rounding noise; a row whose rest is noise depends
on those before it. Of the entries that are large enough as pivots the one whose coordinate is in the fewest rows is chosen
(Markowitz 1957). Long rows, whose elimination would fill the matrices, are kept as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg

from ...ground.errors import ContradictoryConstraints, InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS, FIRST_SHIFT, NOISE_SAFETY, PIVOT_RATIO, RIGID_BODY_FORCE
from ..constraints import Constraint
from .factorization import Factorization, factorize
from .sparse_matrices import SparseRows, sparse_rows, symmetric

#: Where stiffness is negative, the shift moves by this factor farther below zero, at most so many times.
FARTHER, FARTHEST = 100.0, 9

#: More rows than this are not bordered but eliminated, however long they are.
MOST_BORDERED = 200


@dataclass(frozen=True, eq=False)
class ReducedPencil:
    """M, C, K as N^T . N on r free coordinates y with x = N y + x_0, and the long rows L y = 0 that remain.

    Attributes:
        mass, damping, stiffness: shape (r, r), sparse.
        basis: N, shape (n, r).
        offset: x_0, shape (n,).
        rows: L, shape (k, r).
        row_values: the values of L y, shape (k,).
        constraints: all constraint rows as given.
        names: names of the n coordinates.
        free: the place of each of y among the n coordinates, shape (r,).
        independent: the places of the constraint rows that are not redundant.
        notices: one for each redundant row.
    """

    mass: scipy.sparse.csc_array
    damping: scipy.sparse.csc_array
    stiffness: scipy.sparse.csc_array
    basis: scipy.sparse.csc_array
    offset: np.ndarray
    rows: scipy.sparse.csr_array
    row_values: np.ndarray
    constraints: SparseRows
    names: tuple[str, ...]
    free: np.ndarray
    independent: np.ndarray
    notices: tuple[Notice, ...]
    _undamped: dict[int, Any] = field(default_factory=dict, repr=False)

    @property
    def size(self) -> int:
        """Number r of free coordinates."""
        return self.mass.shape[0]

    @cached_property
    def rounding(self) -> float:
        """Relative errors of the entries: those of the given ones, unless rows with fractional factors are eliminated."""
        return EPS if is_whole(self.basis) else RIGID_BODY_FORCE

    @cached_property
    def typical(self) -> float:
        """The median of K_ii / M_ii over coordinates with mass and stiffness, 1 where there is none."""
        mass, stiffness = self.mass.diagonal(), np.abs(self.stiffness.diagonal())
        both = (mass > 0) & (stiffness > 0)
        if both.any():
            return float(np.median(stiffness[both] / mass[both]))
        return float(stiffness.max() / mass.max()) if stiffness.any() and (mass > 0).any() else 1.0

    def described(self, places) -> str:
        """Names of some free coordinates, as text."""
        return ", ".join(f'"{self.names[self.free[place]]}"' for place in places)

    def shifted(self, shift: float, counted: bool = True) -> Factorization:
        """The factors of K - shift M."""
        return factorize(scipy.sparse.csc_array(self.stiffness - shift * self.mass), self.rows, self.described, counted)

    def below_all(self) -> tuple[float, Factorization]:
        """A shift below all eigenvalues, and the factors there."""
        shift = -FIRST_SHIFT * self.typical
        for _ in range(FARTHEST):
            factors = self.shifted(shift)
            if factors.negative in (0, None):
                return shift, factors
            shift *= FARTHER
        raise InputError(
            "stiffness: massless coordinates have a negative stiffness, or the mass matrix has negative eigenvalues: the modes of "
            "lowest frequency are not defined; check the signs of stiffness and mass"
        )


def reduced_pencil(mass, damping, stiffness, constraints: Sequence[Constraint], names: Sequence[str]) -> ReducedPencil:
    """Eliminate the constraint rows of a system of sparse matrices and project its matrices."""
    mass, stiffness = symmetric(mass, "mass", names), symmetric(stiffness, "stiffness", names)
    rows = sparse_rows(constraints, mass.shape[0])
    elimination = eliminate(rows)
    if len(elimination.kept) > MOST_BORDERED:
        elimination = eliminate(rows, longest=mass.shape[0])
    if not len(elimination.free):
        count = int((np.diff(rows.matrix.indptr) > 0).sum())
        raise InputError(f"constraints: the {count} rows leave no coordinate free; take some of them out")
    N, kept = elimination.basis, elimination.kept
    pencil = ReducedPencil(
        *(_projected(N, matrix) for matrix in (mass, damping, stiffness)),
        basis=N,
        offset=elimination.offset,
        rows=scipy.sparse.csr_array(rows.matrix[kept] @ N),
        row_values=rows.values[kept] - rows.matrix[kept] @ elimination.offset,
        constraints=rows,
        names=tuple(names),
        free=elimination.free,
        independent=np.setdiff1d(np.arange(len(rows.names)), list(elimination.dependent)),
        notices=tuple(_redundant(rows.names[place], others, rows) for place, others in elimination.dependent.items()),
    )
    return _independent(pencil, kept)


def is_whole(matrix) -> bool:
    """Whether all entries of a sparse matrix are whole numbers, and so exact."""
    return bool((matrix.data == np.round(matrix.data)).all())


def _projected(N, matrix) -> scipy.sparse.csc_array:
    """N^T matrix N; for whole numbers in N a sum is kept while it exceeds the rounding errors of its terms."""
    if N.shape[0] == N.shape[1]:
        return scipy.sparse.csc_array(matrix)
    product = scipy.sparse.csc_array(N.T @ matrix @ N)
    if is_whole(N):
        exact = N.astype(np.longdouble)
        product = scipy.sparse.csc_array(exact.T @ matrix.astype(np.longdouble) @ exact)
        sizes = scipy.sparse.csc_array(abs(N).T @ abs(matrix) @ abs(N))
        product.sort_indices()
        sizes.sort_indices()
        product.data[np.abs(product.data) <= EPS * sizes.data] = 0.0
        product = product.astype(float)
    product.eliminate_zeros()
    return product


def _redundant(name: str, others: Sequence[int], rows: SparseRows) -> Notice:
    reason = f"it follows from {rows.quoted(others)}" if others else "all its coefficients are zero"
    return Notice(NoticeKind.REDUNDANT, f'constraint "{name}" is redundant and was left out: {reason}')


def _independent(pencil: ReducedPencil, kept: np.ndarray) -> ReducedPencil:
    """The pencil without redundant long rows; there are few, so that their dense products are small."""
    if not pencil.rows.shape[0]:
        return pencil
    given = scipy.sparse.linalg.norm(pencil.constraints.matrix[kept], axis=1)
    unit = 1 / np.where(given > 0, given, 1.0)
    scaled = scipy.sparse.csr_array(scipy.sparse.diags_array(unit) @ pencil.rows)
    limit = NOISE_SAFETY * EPS * pencil.size**0.5
    gram = (scaled @ scaled.T).toarray()
    triangle, order = scipy.linalg.qr(gram, mode="r", pivoting=True)
    rank = int((np.abs(np.diag(triangle)) > limit * max(np.abs(triangle[0, 0]), 1.0)).sum()) if pencil.rows.nnz else 0
    independent, dependent = np.sort(order[:rank]), order[rank:]
    notices, values = list(pencil.notices), pencil.row_values * unit
    for place in dependent:
        mixed = np.linalg.lstsq(gram[np.ix_(independent, independent)], gram[independent, place], rcond=None)[0]
        name = pencil.constraints.names[kept[place]]
        if abs(values[place] - mixed @ values[independent]) > limit * np.abs(values).max():
            raise ContradictoryConstraints(
                f'constraint "{name}" follows from other rows with another value; make the values agree or take it out'
            )
        text = f'constraint "{name}" is redundant and was left out: it follows from other rows'
        notices.append(Notice(NoticeKind.REDUNDANT, text))
    rows, row_values = pencil.rows[independent], pencil.row_values[independent]
    kept_rows = np.setdiff1d(pencil.independent, kept[dependent])
    return replace(pencil, rows=rows, row_values=row_values, independent=kept_rows, notices=tuple(notices))


#: Eliminating a row with m entries couples m coordinates with each other, m^2 entries; longer rows are kept as they are.
LONGEST = 64

Row = dict[int, tuple[float, float]]


@dataclass(frozen=True, eq=False)
class Elimination:
    """x = basis y + offset satisfies all eliminated rows.

    Attributes:
        basis: N, shape (n, r), sparse; a column has a 1 where its coordinate is.
        offset: x_0, shape (n,), zero if all values are.
        free: the places of the free coordinates, shape (r,).
        kept: the places of the rows that are not eliminated.
        dependent: for the place of each redundant row the places of the rows that imply it.
    """

    basis: scipy.sparse.csc_array
    offset: np.ndarray
    free: np.ndarray
    kept: np.ndarray
    dependent: dict[int, tuple[int, ...]]


def eliminate(rows: SparseRows, longest: int = LONGEST) -> Elimination:
    """Solve the rows for one coordinate each."""
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
    """Rows with a large enough entry in a coordinate that occurs in no other row, and this coordinate."""
    if not A.nnz:
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    row = np.repeat(np.arange(A.shape[0]), lengths)
    largest = np.zeros(A.shape[0])
    np.maximum.at(largest, row, np.abs(A.data))
    alone = _counts(A, A.shape[1])[A.indices] == 1
    good = np.flatnonzero(alone & (np.abs(A.data) >= PIVOT_RATIO * largest[row]) & (lengths[row] <= longest))
    best, first = np.unique(row[good], return_index=True)
    return best, A.indices[good[first]]


def _one_by_one(rows: SparseRows, places: Sequence[int], counts) -> tuple[dict[int, tuple[Row, float]], dict[int, tuple[int, ...]]]:
    """For each pivot, in the order of elimination, its row without the pivot and its value; and the redundant rows."""
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
            pivot = min((j for j, (v, _) in row.items() if abs(v) >= PIVOT_RATIO * size), key=lambda j: (counts[j], j))
            solved[pivot] = _solved_for(pivot, row, value)
            owner[pivot] = place
        else:
            dependent[place] = tuple(owner[pivot] for pivot in used)
            _check_value(rows, place, value, dependent[place])
    return solved, dependent


def _reduced(row: Row, value, solved) -> tuple[Row, tuple[float, float], list[int]]:
    """The row without the pivots of others; entries below their noise are dropped."""
    used = []
    while (pivot := next((j for j in row if j in solved), None)) is not None:
        factor, noise = row.pop(pivot)
        expression, (constant, constant_noise) = solved[pivot]
        used.append(pivot)
        doubt = abs(factor) * constant_noise + (noise + EPS * abs(factor)) * abs(constant)
        value = (value[0] - factor * constant, value[1] + doubt)
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
    expression = {j: (-v / top, abs(n / top) + relative * abs(v / top)) for j, (v, n) in row.items() if j != pivot}
    return expression, (value[0] / top, abs(value[1] / top) + relative * abs(value[0] / top))


def _check_value(rows: SparseRows, place: int, value, others) -> None:
    rest, noise = value
    if abs(rest) > NOISE_SAFETY * noise:
        reason = f"it follows from {rows.quoted(others)}" if others else "all its coefficients are zero"
        raise ContradictoryConstraints(
            f'constraint "{rows.names[place]}" has the value {rows.values[place]:.6g}, but {reason}, with the value '
            f"{rows.values[place] - rest:.6g}; make the values agree or take one of the rows out"
        )


def _with_single(A, values, single, pivots, basis, offset) -> tuple[scipy.sparse.csc_array, np.ndarray]:
    """The rows of N for coordinates that occur in one row only, all at once."""
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
    """The expressions, solved backwards for the free coordinates alone."""
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
    row = np.concatenate([free, np.repeat(list(done), [len(row) for row in done.values()])]).astype(int)
    col = np.concatenate([free, [j for row in done.values() for j in row]]).astype(int)
    data = np.concatenate([np.ones(len(free)), [v for row in done.values() for v in row.values()]])
    return scipy.sparse.csc_array((data, (row, column[col])), shape=(size, len(free))), offset
