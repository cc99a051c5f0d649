"""The pencil K - s M of a system of sparse matrices on the coordinates that its constraint rows leave free.

A row with a coordinate that no other row has is solved for it at once. The others are eliminated one by one in the order
given (Gaussian elimination on rows kept as dictionaries), each entry with its rounding noise; a row whose rest is noise depends
on those before it. Of the entries that are large enough as pivots the one whose coordinate is in the fewest rows is chosen
(Markowitz 1957). Long rows, whose elimination would fill the matrices, are kept as they are.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from ...ground.checks import real_array
from ...ground.errors import ContradictoryConstraints, InputError, SingularPolynomialMatrix
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS, FIRST_SHIFT, NOISE_SAFETY, PIVOT_RATIO, PIVOT_RESIDUAL, RIGID_BODY_FORCE
from ..constraints import Constraint, row_names

# Validation of sparse matrices and constraint rows, which are never turned into arrays, and their products.


def square_sparse(value, what: str, size: int | None = None) -> scipy.sparse.csc_array:
    """A square real sparse matrix without stored zeros; None is a zero matrix."""
    if value is None:
        return scipy.sparse.csc_array((size, size))
    matrix = _sparse_entries(value, what)
    if matrix.shape[0] != matrix.shape[1]:
        raise InputError(f"{what}: expected a square matrix, found {matrix.shape[0]} x {matrix.shape[1]}")
    if size is not None and matrix.shape[0] != size:
        raise InputError(f"{what}: expected shape {size} x {size}, found {matrix.shape[0]} x {matrix.shape[1]}")
    if not matrix.shape[0]:
        raise InputError(f"{what}: found no entries; a mechanical system needs at least one coordinate")
    return matrix


def _sparse_entries(value, what: str) -> scipy.sparse.csc_array:
    """A sparse matrix of finite real numbers, duplicates summed, from a sparse or a dense one."""
    if not scipy.sparse.issparse(value):
        value = np.atleast_2d(real_array(value, what))
    if value.dtype.kind not in "biuf":
        raise InputError(f"{what}: found entries of type {value.dtype}; only real numbers are accepted")
    matrix = scipy.sparse.csc_array(value, dtype=float, copy=True)
    matrix.sum_duplicates()
    if not np.isfinite(matrix.data).all():
        entries = matrix.tocoo()
        at = int(np.flatnonzero(~np.isfinite(entries.data))[0])
        place = (int(entries.row[at]), int(entries.col[at]))
        raise InputError(f"{what}: the entry at {place} is {entries.data[at]}; every entry must be a finite number")
    matrix.eliminate_zeros()
    return matrix


def asymmetry(matrix: scipy.sparse.csc_array) -> tuple[float, tuple[int, int]]:
    """The largest difference of an entry from its mirror image where it is more than rounding, and its place."""
    difference = scipy.sparse.coo_array(matrix - matrix.T)
    if not difference.nnz:
        return 0.0, (0, 0)
    at = int(np.abs(difference.data).argmax())
    largest = float(abs(difference.data[at]))
    beyond = largest > NOISE_SAFETY * EPS * np.abs(matrix.data).max()
    return (largest if beyond else 0.0), (int(difference.row[at]), int(difference.col[at]))


def symmetric(matrix: scipy.sparse.csc_array, what: str, names) -> scipy.sparse.csc_array:
    """The symmetric part of a matrix, where no more than rounding is lost."""
    largest, (row, column) = asymmetry(matrix)
    if largest:
        raise InputError(
            f"{what}: its entries for {names[row]}, {names[column]} and {names[column]}, {names[row]} differ by {largest:.3g}; "
            "sparse mass and stiffness must be symmetric; give arrays for a small unsymmetric system"
        )
    return scipy.sparse.csc_array((matrix + matrix.T) / 2)


#: Up to so many rows one product with many columns at once is faster than one for each.
FEW_ROWS = 5000


def times(matrix, columns: np.ndarray) -> np.ndarray:
    """A sparse real matrix times dense columns, one by one: several times faster than SciPy's product with many columns."""
    if matrix.shape[0] <= FEW_ROWS:
        return np.asfortranarray(matrix @ columns)
    product = np.empty((matrix.shape[0], columns.shape[1]), dtype=np.result_type(matrix.dtype, columns.dtype), order="F")
    for place, column in enumerate(columns.T):
        if product.dtype.kind == "c":  # a complex product would make the matrix complex for each column
            product.real[:, place], product.imag[:, place] = matrix @ column.real, matrix @ column.imag
        else:
            product[:, place] = matrix @ column
    return product


def quadratic_form(matrix, x: np.ndarray, rounding: float = EPS) -> float:
    """x^T A x, zero where it is no more than the rounding errors of the entries of A.

    Summed in extended precision as (sum of row i) x_i^2 and -A_ij (x_i - x_j)^2, in which nothing cancels of a structure that moves
    as a whole: an error of x enters by its square, and the rounding errors of entries as that of independent numbers. A soft support of a
    large free structure so counts as what it is.
    """
    entries, extended = matrix.tocoo(), x.astype(np.longdouble)
    row, column, data = entries.row, entries.col, entries.data.astype(np.longdouble)
    sums = np.zeros(len(x), dtype=np.longdouble)
    np.add.at(sums, row, data)
    np.add.at(sums, column, data)
    value = float((sums @ extended**2 - data @ (extended[row] - extended[column]) ** 2) / 2)
    return value if abs(value) > rounding * np.linalg.norm(np.abs(x) * (abs(matrix) @ np.abs(x))) else 0.0


def combined(basis: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Real columns times complex coordinates, without conversion of the columns."""
    product = np.empty((len(basis), coordinates.shape[1]), dtype=complex, order="F")
    product.real, product.imag = basis @ coordinates.real, basis @ coordinates.imag
    return product


@dataclass(frozen=True, eq=False)
class SparseRows:
    """The constraint rows A x = b of a system of sparse matrices."""

    matrix: scipy.sparse.csr_array  # A, shape (k, n), compressed by rows
    values: np.ndarray  # b, shape (k,)
    names: tuple[str, ...]  # one for each row

    def reason(self, places: Sequence[int]) -> str:
        """Why a row is redundant that follows from these."""
        names = [f'"{self.names[place]}"' for place in places[:3]] + [f"{len(places) - 3} more"] * (len(places) > 3)
        return f"it follows from {' and '.join(names)}" if names else "all its coefficients are zero"


def sparse_rows(constraints: Sequence[Constraint], size: int) -> SparseRows:
    """The rows of all constraints of a system with ``size`` coordinates."""
    for constraint in constraints:
        if constraint.level != "position":
            raise InputError(
                f"constraints: found a row at {constraint.level} level; sparse matrices accept rows at position level only, "
                "as drift is no motion of the bodies; set level='position', or give arrays"
            )
        if constraint.signal is not None:
            raise InputError(
                "constraints: found a prescribed motion; sparse matrices accept constant values only; give arrays, or a force of the "
                "springs and dampers at the support"
            )
    parts = [_sparse_entries(constraint.rows, "constraint rows") for constraint in constraints]
    matrix = scipy.sparse.vstack([scipy.sparse.csr_array((0, size)), *parts], format="csr")
    values = np.concatenate([np.zeros(0), *(constraint.values for constraint in constraints)])
    return SparseRows(scipy.sparse.csr_array(matrix), values, row_names(constraints))


#: Options of SuperLU for pivots from the diagonal, in an order of minimum degree.
SYMMETRIC: dict[str, Any] = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}

#: Solutions for one or several right sides.
Solver = Callable[[np.ndarray], np.ndarray]

# K - s M of a constrained sparse pencil as L U: solutions, and how many of its eigenvalues lie below s.
#
# SuperLU takes the pivots from the diagonal, in an order of minimum degree that is the same for rows and columns: P^T (K - s M) P
# = L D L^T then, and the signs of D are those of the eigenvalues of K - s M (Sylvester). Whether it did, and whether the
# factors are as good as the signs need, is checked: by the permutations, and by the residual of a solution. Rows that were
# not eliminated enter by their Schur complement, whose signs are counted too (Haynsworth 1968).


@dataclass(frozen=True, eq=False)
class Factorization:
    """The factors of P = K - s M."""

    lower_upper: scipy.sparse.linalg.SuperLU  # SuperLU's factors of P
    negative: int | None  # number of eigenvalues of the pencil below s; None where it could not be counted
    solve: Solver
    is_bordered: bool  # whether rows L remain


def bordered(solve: Solver, rows: scipy.sparse.csr_array, kind: type) -> tuple[Solver, np.ndarray]:
    """x in the null space of sparse rows L with P x = right up to forces of the rows, from solutions with P; and L P^-1 L^T."""
    reach = solve(rows.T.toarray().astype(kind))
    schur = rows @ reach
    factors = scipy.linalg.lu_factor(schur)

    def constrained(right: np.ndarray) -> np.ndarray:
        solution = solve(right)
        return solution - reach @ scipy.linalg.lu_solve(factors, rows @ solution)

    return constrained, schur


def factorize(matrix: scipy.sparse.csc_array, rows: scipy.sparse.csr_array, describe, counted: bool = True) -> Factorization:
    """Factorize a symmetric matrix (real or complex) bordered by sparse rows."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", scipy.sparse.SparseEfficiencyWarning)
            factors = scipy.sparse.linalg.splu(scipy.sparse.csc_array(matrix), **SYMMETRIC)
    except RuntimeError:
        raise _singular(matrix, describe) from None
    negative = _negative(matrix, factors) if counted else None

    def solve(right: np.ndarray) -> np.ndarray:
        return factors.solve(np.asfortranarray(right))

    if not rows.shape[0]:
        return Factorization(factors, negative, solve, False)
    constrained, schur = bordered(solve, rows, matrix.dtype)
    if negative is not None:
        signs = np.linalg.eigvalsh((schur + schur.T) / 2)
        negative += int((signs > 0).sum()) - rows.shape[0]
    return Factorization(factors, negative, constrained, True)


def _negative(matrix, factors) -> int | None:
    """The number of negative eigenvalues of the matrix, None where the pivots are not accurate enough."""
    if not np.array_equal(factors.perm_r, factors.perm_c):
        return None
    pivots = factors.U.diagonal()
    probe = np.where(np.arange(matrix.shape[0]) % 2, 1.0, -0.75)
    solution = factors.solve(probe)
    size = abs(matrix) @ np.abs(solution) + np.abs(probe)
    if not np.isfinite(solution).all() or (np.abs(matrix @ solution - probe) > PIVOT_RESIDUAL * size).any():
        return None
    return int((pivots < 0).sum())


def _singular(matrix, describe) -> SingularPolynomialMatrix:
    """The error for coordinates with neither mass nor stiffness, from the pivots of a slightly changed matrix."""
    size = abs(matrix.diagonal())
    added = NOISE_SAFETY * EPS * np.where(size > 0, size, size.max(initial=0.0) or 1.0)
    changed = scipy.sparse.csc_array(matrix + scipy.sparse.diags_array(added))
    factors = scipy.sparse.linalg.splu(changed, **SYMMETRIC)
    pivots = np.abs(factors.U.diagonal())[factors.perm_c]
    loose = np.flatnonzero(pivots <= NOISE_SAFETY * added)
    named = describe(loose[:3]) if len(loose) else "some coordinates"
    return SingularPolynomialMatrix(
        f"{named}{f' and {len(loose) - 3} more' if len(loose) > 3 else ''} have neither mass nor stiffness: the modes are not "
        "determined; give them mass or stiffness (a damper alone does not do), or tie them by a constraint",
        coordinates=tuple(map(int, loose)),
    )


#: Where stiffness is negative, the shift moves by this factor farther below zero, at most so many times.
FARTHER, FARTHEST = 100.0, 9

#: More rows than this are not bordered but eliminated, however long they are.
MOST_BORDERED = 200


@dataclass(frozen=True, eq=False)
class ReducedPencil:
    """M, C, K as N^T . N on r free coordinates y with x = N y + x_0, and the long rows L y = 0 that remain."""

    mass: scipy.sparse.csc_array  # mass, damping, stiffness: shape (r, r), sparse
    damping: scipy.sparse.csc_array
    stiffness: scipy.sparse.csc_array
    basis: scipy.sparse.csc_array  # N, shape (n, r)
    offset: np.ndarray  # x_0, shape (n,)
    rows: scipy.sparse.csr_array  # L, shape (k, r)
    row_values: np.ndarray  # the values of L y, shape (k,)
    constraints: SparseRows  # all constraint rows as given
    names: tuple[str, ...]  # names of the n coordinates
    free: np.ndarray  # the place of each of y among the n coordinates, shape (r,)
    independent: np.ndarray  # the places of the constraint rows that are not redundant
    notices: tuple[Notice, ...]  # one for each redundant row
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
        notices=tuple(
            Notice(NoticeKind.REDUNDANT, f'constraint "{rows.names[place]}" is redundant and was left out: {rows.reason(others)}')
            for place, others in elimination.dependent.items()
        ),
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
    """x = basis y + offset satisfies all eliminated rows."""

    basis: scipy.sparse.csc_array  # N, shape (n, r), sparse; a column has a 1 where its coordinate is
    offset: np.ndarray  # x_0, shape (n,), zero if all values are
    free: np.ndarray  # the places of the free coordinates, shape (r,)
    kept: np.ndarray  # the places of the rows that are not eliminated
    dependent: dict[int, tuple[int, ...]]  # for the place of each redundant row the places of the rows that imply it


def eliminate(rows: SparseRows, longest: int = LONGEST) -> Elimination:
    """Solve the rows for one coordinate each."""
    A, size = rows.matrix, rows.matrix.shape[1]
    lengths = np.diff(A.indptr)
    kept = np.flatnonzero(lengths > longest)
    single, pivots = _single(A, lengths, longest)
    others = np.setdiff1d(np.flatnonzero(lengths <= longest), single)
    solved, dependent = _one_by_one(rows, others, np.bincount(A.indices, minlength=size))
    free = np.setdiff1d(np.arange(size), [*solved, *pivots.tolist()])
    basis, offset = _with_single(A, rows.values, single, pivots, *_null_space(solved, free, size))
    return Elimination(basis, offset, free, kept, dependent)


def _single(A, lengths, longest) -> tuple[np.ndarray, np.ndarray]:
    """Rows with a large enough entry in a coordinate that occurs in no other row, and this coordinate."""
    if not A.nnz:
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    row = np.repeat(np.arange(A.shape[0]), lengths)
    largest = np.zeros(A.shape[0])
    np.maximum.at(largest, row, np.abs(A.data))
    alone = np.bincount(A.indices, minlength=A.shape[1])[A.indices] == 1
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
            if abs(value[0]) > NOISE_SAFETY * value[1]:
                raise ContradictoryConstraints(
                    f'constraint "{rows.names[place]}" has the value {rows.values[place]:.6g}, but {rows.reason(dependent[place])}, with the value '
                    f"{rows.values[place] - value[0]:.6g}; make the values agree or take one of the rows out"
                )
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
