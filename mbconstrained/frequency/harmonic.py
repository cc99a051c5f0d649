"""A(i w) X = B for many frequencies: elimination by the common pattern of all lines, with refinement and errors."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Protocol

import numpy as np
import scipy

from ..ground.errors import InputError
from ..ground.notices import Notice
from ..ground.tolerances import EPS, LARGEST_POWER, LINE_ACCURACY, LINE_ROUNDING, TRUST_LIMIT
from ..linalg.arrays import lapack
from ..linalg.elimination import as_slice
from ..linalg.scaling import Scaling, joint_scaling
from ..polynomial.delayed_terms import DelayedTerm
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.bohl import consecutive
from .pole_residue_form import ModalSum, PoleResidueForm

# A(i w) X = B for many lines w at once, with an error estimate of every entry of C X.
# The pattern of A(s) = A_0 + A_1 s + ... is eliminated once, in an order that SuperLU chooses at one line (fill-reducing columns,
# rows by threshold pivoting), with vectors over the lines in the place of numbers. An elimination of that kind has a small error
# entry by entry: of a chain in its stop band every digit is kept, where a sum of modes cancels. What the order loses at other lines
# is seen in the residual; those lines get an order of their own, in the end LAPACK's pivoting. Lines whose estimate is still too
# large are refined with residuals in extended precision (Wilkinson 1963; Skeel 1980).
# The estimate of entry (p, j) is z_p^T (|A X - B| + u (|A_0| + w |A_1| + ...) |X|)_j with C A^-1 = Z^T and u some rounding errors: the
# first-order bound of the errors by residuals and by relative errors of every entry of every coefficient. Where nothing is lost the
# factors A = L D U bound it, |A X - B| <= u |L| |D| |U| |X|, and the coefficients of an entry whose real and imaginary part have one
# term each are no larger than the entry.

#: Number of complex entries of factors and vectors computed at once; and the least number of lines.
CHUNK, LEAST = 3 << 20, 64

#: A threshold pivot is at least this part of the largest of its column.
THRESHOLD = 0.1

#: Orders that are tried, each chosen at a line where the one before loses digits.
ORDERS = 3

#: LAPACK solves full matrices where the elimination has more operations than this part of r^3 / 3.
FULL = 1 / 16

#: Full matrices of more rows are refined only where no digit is sure: products in extended precision take much longer than factors.
REFINED = 60

#: Steps of refinement, with residuals in extended precision.
STEPS = 3

#: Products for each line are those of matrices where they have so many entries.
BY_MATRICES = 16


@dataclass(frozen=True, eq=False)
class Lines:
    """C A(i w)^-1 B at F lines."""

    values: np.ndarray  # shape (p, m, F)
    errors: np.ndarray  # estimates of the absolute errors; infinite where A(i w) is singular to working precision
    solutions: np.ndarray | None = None  # A(i w)^-1 B, shape (r, m, F), where they were requested

    @property
    def relative(self) -> np.ndarray:
        """The errors relative to the values, at most infinite; 0 of an exact zero."""
        size = np.abs(self.values)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            result = np.divide(self.errors, size, out=size)
        result[self.errors == 0] = 0.0
        return result  # infinite where a value is zero, and its error is not


class StructuredSolver:
    """C A(i w)^-1 B by elimination along the pattern of A(s)."""

    def __init__(
        self, coefficients, inputs, outputs, sizes=None, delayed: Sequence[DelayedTerm] = (), *, is_assembled: bool = False
    ):
        """The matrices of one transfer function, A(s) with its delayed terms; coefficients that are assembled are rounded."""
        self.is_assembled = is_assembled
        coefficients = np.asarray(coefficients)
        self.powers, self.delays = np.arange(len(coefficients)), np.zeros(len(coefficients))
        largest = np.abs(coefficients)
        for term in delayed:
            count = len(term.coefficients)
            coefficients = np.concatenate([coefficients, term.coefficients])
            sizes = None if sizes is None else np.concatenate([sizes, np.abs(term.coefficients)])
            self.powers, self.delays = np.append(self.powers, np.arange(count)), np.append(self.delays, np.full(count, term.delay))
            largest = np.pad(largest, ((0, max(0, count - len(largest))), (0, 0), (0, 0)))
            largest[:count] += np.abs(term.coefficients)
        scaling = joint_scaling(largest)
        self.is_symmetric = all((matrix == matrix.T).all() for matrix in coefficients)
        if self.is_symmetric:
            both = np.exp2(np.rint((np.log2(scaling.rows) + np.log2(scaling.columns)) / 2))
            scaling = Scaling(scaling.time, both, both)
        self.time, self.delays = scaling.time, self.delays * scaling.time
        powers = scaling.time ** self.powers[:, None, None]
        factors = scaling.rows[:, None] * scaling.columns * powers
        self.coefficients = coefficients * factors
        self.sizes = np.abs(self.coefficients) if sizes is None else np.maximum(np.abs(coefficients), sizes) * factors
        self.rounded = sizes is not None and bool((self.sizes > np.abs(self.coefficients)).any())
        self.inputs = scaling.rows[:, None] * inputs
        self.outputs = outputs * scaling.columns
        self.columns = scaling.columns
        self._orders: dict[float, _Pattern | None] = {}
        self.entries = self.sizes.any(axis=0).nonzero()
        own = self.coefficients[:, *self.entries]
        parts, turns = np.array([own.real, own.imag]) != 0, (np.arange(2)[:, None] + self.powers) % 2
        several = (parts[turns == 0].sum(axis=0) > 1) | (parts[turns == 1].sum(axis=0) > 1) | self.delays.any()
        several |= (self.sizes[:, *self.entries] > np.abs(own)).any(axis=0)
        self.sums = tuple(places[several] for places in self.entries)  # whose real or imaginary part is a sum, which may cancel
        self._together = None
        if self.is_symmetric:
            both = np.hstack([self.inputs, self.outputs.T])
            _, first, where = np.unique(both, axis=1, return_index=True, return_inverse=True)
            order = np.argsort(first)  # as they come: most often parts are slices, which need no copies
            self._together, where = both[:, first[order]], np.argsort(order)[where.reshape(-1)]
            self._where = [as_slice(places.tolist()) for places in np.split(where, [self.inputs.shape[1]])]

    @property
    def size(self) -> int:
        """r."""
        return self.coefficients.shape[1]

    def is_sparse(self, omega: np.ndarray) -> bool:
        """Whether elimination along the pattern is faster than full matrices."""
        return self._factors(float(np.max(omega) / self.time)) is not None

    def solve(self, omega: np.ndarray, accuracy: float = LINE_ACCURACY, with_solutions: bool = False) -> Lines:
        """Values and errors at these angular frequencies."""
        nu = np.asarray(omega) / self.time
        p, m, F = len(self.outputs), self.inputs.shape[1], len(nu)
        values, errors = np.zeros((p, m, F), dtype=complex), np.full((p, m, F), np.inf)
        solutions = np.zeros((self.size, m, F), dtype=complex) if with_solutions else None
        left = np.arange(F)
        for attempt in range(ORDERS):  # first where inertia dominates: stop bands need pivots on the diagonal most
            at = np.argsort(nu[left])[len(left) // 2 if attempt else -1] if len(left) else 0
            factors = self._factors(float(nu[left[at]])) if len(left) else None
            if factors is None:
                break
            self._pass(values, errors, solutions, left, nu, factors, accuracy, is_first=not attempt)
            own = consecutive(left)
            left = left[(errors[..., own] > accuracy * np.abs(values[..., own])).any(axis=(0, 1))]
        self._pass(values, errors, solutions, left, nu, None, accuracy)
        if solutions is not None:
            solutions *= self.columns[:, None, None]
        return Lines(values, errors, solutions)

    def _pass(self, values, errors, solutions, lines, nu, factors, accuracy, is_first=False) -> None:
        """Solve some lines in parts and keep improved values; without an order of elimination lines are pivoted and refined."""
        columns = self.inputs.shape[1] + len(self.outputs) if self._together is None else self._together.shape[1]
        entries = self.size**2 if factors is None else 2 * len(factors.rows) + 3 * self.size * columns
        count = min(len(lines), max(LEAST, CHUNK // max(entries, 1)))
        memory = _Memory(count * entries if factors else 0)
        for part in np.array_split(lines, -(-len(lines) // count)) if len(lines) else ():
            lost: list[str] = []
            with np.errstate(all="ignore", under="call", call=lambda kind, _, kinds=lost: kinds.append(kind)):
                own = nu[part].astype(float)
                solver = _Full(self, own) if factors is None else _Eliminated(self, own, factors, memory)
                solutions_of_both, right, left = self._both(solver)
                X, Z = solutions_of_both[:, right], solutions_of_both[:, left]
                sizes = np.abs(solutions_of_both, out=memory.array("sizes", solutions_of_both.shape))
                H, error = _contracted(self.outputs, X), solver.bound(X, sizes, right, left)
                loose = ~(error <= accuracy * np.abs(H)).all(axis=(0, 1))
                if factors is not None and loose.any():
                    error[..., loose] = _bilinear(sizes[:, left][..., loose], solver.at(loose).terms(X[..., loose]))
                limit = TRUST_LIMIT if factors is None and self.size > REFINED else accuracy
                bad = loose & ~(error <= limit * np.abs(H)).all(axis=(0, 1)) & np.isfinite(error).all(axis=(0, 1))
                if bad.any():
                    refined = self._refined(solver.at(bad), nu[part][bad], X[..., bad], Z[..., bad])
                    H[..., bad], error[..., bad], X[..., bad] = refined
            if lost:  # below the range of float64 a value is no digit of the answer
                error = np.where(np.abs(H) < np.finfo(float).tiny / EPS, np.inf, error)
            if not (finite := np.isfinite(error) & np.isfinite(H)).all():
                H[~finite], error[~finite] = 0.0, np.inf
            own = consecutive(part)
            if not is_first:
                better = error < errors[..., own]
                H, error = np.where(better, H, values[..., own]), np.where(better, error, errors[..., own])
            values[..., own], errors[..., own] = H, error
            if solutions is not None:
                solutions[..., own] = np.where(np.isfinite(X), X, 0)

    def _both(self, solver: _Eliminated | _Full) -> tuple[np.ndarray, slice | np.ndarray, slice | np.ndarray]:
        """A^-1 B and Z with C A^-1 = Z^T among columns, shape (r, any, F), and the places of both."""
        if self._together is not None:
            right, left = self._where
            return solver.solved(self._together), right, left
        m = self.inputs.shape[1]
        both = solver.solved(self.inputs), solver.solved(self.outputs.T, transposed=True)
        return np.concatenate(both, axis=1), slice(0, m), slice(m, None)

    # The functions of s that the coefficients multiply.

    def functions(self, nu) -> np.ndarray:
        """s^k e^(-s delay) at s = i nu, shape (K, F)."""
        values = (1j * nu) ** self.powers[:, None]
        return values * np.exp(-1j * nu * self.delays[:, None]) if self.delays.any() else values

    def function_sizes(self, nu) -> np.ndarray:
        """The moduli of these functions; those with delays in units of the rounding errors of a phase."""
        values = nu.astype(float) ** self.powers[:, None]
        return values * (1 + nu.astype(float) * self.delays[:, None]) if self.delays.any() else values

    # Errors.

    def residual(self, nu, X) -> np.ndarray:
        """A X - B in the precision of the lines and of X."""
        return _product(self.coefficients, self.entries, self.functions(nu), X, _Memory()) - self.inputs[..., None]

    def _refined(self, solver, nu, X, Z):
        """Steps of refinement with residuals in extended precision, and the error after them."""
        unit, X = float(np.finfo(np.longdouble).eps), X.astype(np.clongdouble)
        rounding = LINE_ROUNDING * (unit * self.sizes + EPS * (self.sizes - np.abs(self.coefficients)))
        if self.is_assembled:
            rounding = rounding + EPS / 2 * np.abs(self.coefficients)
        functions, sizes, residual, error = self.function_sizes(nu), np.abs(Z), self.residual(nu, X), np.inf
        for _ in range(STEPS):
            X = X - solver.solved(residual.astype(complex))
            residual = self.residual(nu, X)
            terms = np.abs(residual).astype(float)
            terms += _product(rounding, self.entries, functions, np.abs(X).astype(float), _Memory())
            H, before, error = _contracted(self.outputs, X), error, _bilinear(sizes, terms)
            if (error > before / 2).all() or (error <= EPS * np.abs(H)).all():
                break
        H = H.astype(complex)
        return H, error + EPS * np.abs(H), X.astype(complex)

    # The order of elimination.

    def _factors(self, nu: float) -> _Pattern | None:
        """The filled pattern of SuperLU's elimination at one line; None where full matrices are faster, or that line is singular."""
        if nu not in self._orders:
            self._orders[nu] = self._ordered(nu)
        return self._orders[nu]

    def _ordered(self, nu: float) -> _Pattern | None:
        r = self.size
        pattern = (self.coefficients != 0).any(axis=0)
        if pattern.sum() > FULL * r * r + 4 * r and r > 4:
            return None
        A = self._at(nu)
        for matrix in (np.where(pattern & (A == 0), EPS, A), self._at(nu * (1 + THRESHOLD) + THRESHOLD)):
            with suppress(RuntimeError):  # exactly singular: another line has an order
                sparse = scipy.sparse.csc_array(matrix)
                lu = scipy.sparse.linalg.splu(sparse, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=THRESHOLD)
                break
        else:
            return None
        rows, columns = np.argsort(lu.perm_r), np.argsort(lu.perm_c)
        is_symmetric = self.is_symmetric and bool((rows == columns).all())
        result = _Pattern.of(pattern[np.ix_(rows, columns)], rows, columns, is_symmetric)
        return None if result.operations > FULL * r**3 / 3 + 8 * r else result

    def _at(self, nu: float) -> np.ndarray:
        """A(i nu), shape (r, r)."""
        return _matrices(self.coefficients, self.functions(np.array([nu])))[0]


def _sums(coefficients, powers, memory: _Memory) -> np.ndarray:
    """Sums of K functions, shape (K, F), with coefficients of shape (K, E): shape (E, F)."""
    result = memory.array(powers.dtype.char, (coefficients.shape[1], powers.shape[1]), powers.dtype)
    is_pair = np.iscomplexobj(powers) and not np.iscomplexobj(coefficients)
    own, out = (one.view(one.real.dtype) if is_pair else one for one in (powers, result))
    np.matmul(coefficients.T, own, out=out)
    return result


class _Memory:
    """Arrays by name that are used again for further lines, in one block: new pages of memory take longer than the work in them."""

    def __init__(self, size: int = 0):
        """A block of so many complex numbers; what exceeds it is added."""
        self._free, self._arrays = np.empty(size, dtype=complex), {}

    def array(self, name: str, shape: tuple[int, ...], dtype=float) -> np.ndarray:
        """An array of any content."""
        size = math.prod(shape)
        if name not in self._arrays or len(self._arrays[name]) < size:
            count = -(-size * np.dtype(dtype).itemsize // 16)
            block = self._free if count <= len(self._free) else np.empty(count, dtype=complex)
            self._arrays[name], self._free = block[:count].view(dtype), self._free[count:]
        return self._arrays[name][:size].reshape(shape)


def _product(coefficients, entries, functions, X, memory: _Memory) -> np.ndarray:
    """(A_0 f_0 + A_1 f_1 + ...) X of some entries of coefficients, with functions of shape (K, F) and X of shape (r, m, F)."""
    A = _sums(coefficients[:, *entries], functions, memory)
    total, product = memory.array("product", X.shape, A.dtype), np.empty(X.shape[1:], A.dtype)
    total[:] = 0.0
    for own, i, j in zip(A, *(at.tolist() for at in entries)):
        total[i] += np.multiply(own, X[j], out=product)
    return total


def _contracted(outputs, X) -> np.ndarray:
    """C X, each row from its nonzero columns only."""
    result = np.zeros((len(outputs), *X.shape[1:]), dtype=X.dtype)
    for row, line in zip(result, outputs):
        for place in np.flatnonzero(line):
            row += line[place] * X[place]
    return result


def _bilinear(sizes, terms) -> np.ndarray:
    """sizes^T terms for each line, shape (p, m, F)."""
    if sizes.shape[1] * terms.shape[1] < BY_MATRICES:
        return np.einsum("rpf,rmf->pmf", sizes, terms)
    by_line = (np.ascontiguousarray(np.moveaxis(one, 2, 0)) for one in (sizes.swapaxes(0, 1), terms))
    return np.ascontiguousarray(np.moveaxis(np.matmul(*by_line), 0, 2))


# The two solvers: along a pattern, and by LAPACK.


@dataclass(frozen=True, eq=False)
class _Pattern:
    """The filled pattern of the permuted matrix, and the factors L D U with 1 on the diagonals of L and U; of a symmetric one U = L^T."""

    row_order: np.ndarray  # the permutations, shape (r,)
    column_order: np.ndarray
    rows: np.ndarray  # of the entries of the factors, in the permuted matrix
    columns: np.ndarray
    lower: list[list[tuple[int, int]]]  # for each pivot the rows below it, with the places of their entries
    upper: list[list[tuple[int, int]]]  # and the columns right of it
    changed: list[
        list[list[tuple[int, int]]]
    ]  # for each row below: the entries that the pivot changes, and those that it multiplies
    is_symmetric: bool
    operations: int  # of the elimination

    @classmethod
    def of(cls, pattern, row_order, column_order, is_symmetric: bool) -> _Pattern:
        r, below, right, operations = len(pattern), [], [], 0
        by_row, by_column = ([set() for _ in range(r)] for _ in range(2))
        for i, j in np.argwhere(pattern).tolist():
            by_row[i].add(j)
            by_column[j].add(i)
        for k in range(r):
            below.append(sorted(i for i in by_column[k] if i > k))
            right.append(sorted(j for j in by_row[k] if j > k))
            for i in below[k]:
                by_row[i].update(right[k])
            for j in right[k]:
                by_column[j].update(below[k])
            operations += len(below[k]) * (1 + len(right[k]))
        entries = [(k, k) for k in range(r)]
        entries += [(k, j) for k, own in enumerate(right) for j in own]
        entries += [] if is_symmetric else [(i, k) for k, own in enumerate(below) for i in own]
        place = {entry: n for n, entry in enumerate(entries)}
        if is_symmetric:
            place |= {(j, k): n for (k, j), n in place.items()}
        lower = [[(i, place[i, k]) for i in own] for k, own in enumerate(below)]
        upper = [[(j, place[k, j]) for j in own] for k, own in enumerate(right)]
        changed = [
            [[(place[i, j], other) for j, other in upper[k] if j >= i or not is_symmetric] for i in own]
            for k, own in enumerate(below)
        ]
        rows, columns = np.array(entries, dtype=int).reshape(-1, 2).T
        return cls(row_order, column_order, rows, columns, lower, upper, changed, is_symmetric, operations)


class _Eliminated:
    """The factors at some lines; rows of the permuted matrix are equations, its columns unknowns."""

    def __init__(self, solver: StructuredSolver, nu, pattern: _Pattern, memory: _Memory):
        self.solver, self.nu, self.pattern, self.memory = solver, nu, pattern, memory
        places = pattern.row_order[pattern.rows], pattern.column_order[pattern.columns]
        self.W = W = _sums(solver.coefficients[:, *places], solver.functions(nu), memory)
        factor, product = np.empty_like(W, shape=(2, len(nu)))
        for inverse, below, right, changed in zip(W, pattern.lower, pattern.upper, pattern.changed):
            np.reciprocal(inverse, out=inverse)
            for (_, at), entries in zip(below, changed):
                np.multiply(W[at], inverse, out=factor)
                for one, other in entries:
                    W[one] -= np.multiply(factor, W[other], out=product)
                W[at] = factor
            for _, at in () if pattern.is_symmetric else right:
                W[at] *= inverse

    def at(self, lines: np.ndarray) -> _Eliminated:
        """The factors at some of the lines."""
        part = copy(self)
        part.W, part.nu, part.memory = self.W[:, lines], self.nu[lines], _Memory()
        return part

    def solved(self, right, transposed: bool = False) -> np.ndarray:
        """A^-1 right or A^-T right, of right with shape (r, m) or (r, m, F)."""
        pattern, W = self.pattern, self.W
        before, after, lower, upper = pattern.row_order, pattern.column_order, pattern.lower, pattern.upper
        if transposed:
            before, after, lower, upper = after, before, upper, lower
        x, place = self.memory.array(f"x{transposed}", (*right.shape[:2], W.shape[1]), complex), after.tolist()
        x[after] = right[before] if right.ndim == 3 else right[before, :, None]
        filled = right[before].any(axis=tuple(range(1, right.ndim))).tolist()
        product = np.empty_like(x[:1])[0]
        for k, below in enumerate(lower):
            if filled[k]:
                own = x[place[k]]
                for i, at in below:
                    x[place[i]] -= np.multiply(W[at], own, out=product)
                    filled[i] = True
                own *= W[k]
        for k, beyond in reversed(list(enumerate(upper))):
            own = x[place[k]]
            for j, at in beyond:
                own -= np.multiply(W[at], x[place[j]], out=product)
        return x

    def terms(self, X) -> np.ndarray:
        """|A X - B| + u |A| |X|, shape (r, m, F)."""
        solver = self.solver
        rounding = _product(solver.sizes, solver.entries, solver.function_sizes(self.nu), np.abs(X), _Memory())
        return np.abs(solver.residual(self.nu, X)) + LINE_ROUNDING * EPS * rounding

    def bound(self, X, sizes, right, left) -> np.ndarray:
        """A bound of |Z|^T ``terms`` by the factors: u (|L^T| |Z|)^T |D| |U| |X| and the same of A, shape (p, m, F)."""
        solver, pattern, memory = self.solver, self.pattern, self.memory
        if len(solver.outputs) * X.shape[1] >= BY_MATRICES:  # two such products take longer than the terms
            return _bilinear(sizes[:, left], self.terms(X))
        W = np.abs(self.W, out=memory.array("W size", self.W.shape))
        roots = np.reciprocal(W[: solver.size], out=W[: solver.size])
        np.sqrt(roots, out=roots)
        Z = self._spread(W, sizes, pattern.row_order, pattern.lower)
        own = Z if pattern.is_symmetric else self._spread(W, sizes, pattern.column_order, pattern.upper)
        rounding = _product(solver.sizes, solver.sums, solver.function_sizes(self.nu), sizes[:, right], memory)
        return LINE_ROUNDING * EPS * (2 * _bilinear(Z[:, left], own[:, right]) + _bilinear(sizes[:, left], rounding))

    def _spread(self, W, sizes, order, upper) -> np.ndarray:
        """|D|^(1/2) |U| sizes with the moduli of the entries."""
        result = np.take(
            sizes, order, axis=0, out=self.memory.array(f"spread {upper is self.pattern.lower}", sizes.shape), mode="clip"
        )
        product = np.empty(sizes.shape[1:])
        for own, beyond in zip(result, upper):
            for j, at in beyond:
                own += np.multiply(W[at], result[j], out=product)
        result *= W[: len(result), None]
        return result


class _Full:
    """Factors by LAPACK with partial pivoting, line by line."""

    def __init__(self, solver: StructuredSolver, nu):
        self.solver, self.nu, self.memory = solver, nu, _Memory()
        self.matrices = _matrices(solver.coefficients, solver.functions(nu))
        self.factors = [_lu(matrix) for matrix in self.matrices]

    def at(self, lines: np.ndarray) -> _Full:
        """The factors at some of the lines."""
        part = copy(self)
        part.factors = [self.factors[line] for line in np.flatnonzero(lines)]
        return part

    def solved(self, right, transposed: bool = False) -> np.ndarray:
        """A^-1 right or A^-T right, of right with shape (r, m) or (r, m, F)."""
        result = np.full((len(self.factors), *right.shape[:2]), np.nan, dtype=complex)
        for line, factors in enumerate(self.factors):
            if factors is not None:
                own = right if right.ndim == 2 else right[..., line]
                result[line] = scipy.linalg.lu_solve(factors, own, trans=int(transposed), check_finite=False)
        return np.moveaxis(result, 0, 2)

    def terms(self, X) -> np.ndarray:
        """|A X - B| + u |A| |X|, shape (r, m, F)."""
        X = np.moveaxis(X, 2, 0)
        sizes = LINE_ROUNDING * EPS * _matrices(self.solver.sizes, self.solver.function_sizes(self.nu))
        return np.moveaxis(np.abs(self.matrices @ X - self.solver.inputs) + sizes @ np.abs(X), 0, 2)

    def bound(self, X, sizes, right, left) -> np.ndarray:
        """|Z|^T ``terms``, which are no more than a product of matrices."""
        return _bilinear(sizes[:, left], self.terms(X))


def _matrices(coefficients, powers) -> np.ndarray:
    """The matrix at F points, shape (F, r, r)."""
    flat = _sums(coefficients.reshape(len(coefficients), -1), powers, _Memory())
    return np.ascontiguousarray(flat.T).reshape(powers.shape[1], *coefficients.shape[1:])


def _lu(matrix):
    lu, pivots, info = lapack.zgetrf(matrix)
    return (lu, pivots) if info == 0 else None


# The matrices of a frequency response: s^p C A(s)^-1 B, with names and units of its inputs and outputs.


class LeftOut(Protocol):
    """Part of the response that a reduced model omits."""

    @property
    def highest_hz(self) -> float:
        """The highest frequency up to which the errors are bounded."""

    def bound(self, omega: np.ndarray) -> np.ndarray:
        """Bounds of the absolute errors of C A^-1 B at w in rad/s, shape (p, m, F)."""


@dataclass(frozen=True, eq=False)
class Harmonic:
    """s^p C A(s)^-1 B, the matrices of a frequency response; A(s) may have a constant imaginary part, of structural damping.

    Attributes:
        A: the real polynomial matrix.
        inputs: B, shape (r, m).
        outputs: C, shape (p, r).
        power: p.
        imaginary: the imaginary part of A_0, shape (r, r); None for none. It holds for w > 0 and changes its sign with w.
        sizes: sizes of the terms that coefficients are sums of, shape (q + 1, r, r); None for those of the coefficients.
        input_names, output_names: texts.
        units: units of the entries of H, shape (p, m), "" where unknown.
        quantity: its name.
        left_out: bound of the omitted part of a model that these matrices reduce; None for the model itself.
        notices: notices on the model.
        delayed: terms with dead time, A(s) + sum of A_j(s) e^(-s delay_j).
        input_delays: dead time of each input in s, H_j(s) e^(-s delay_j); empty for none. Poles, residues, polynomial part and the
            solver are those without it.
        output_quantities: the quantity of each output; empty where all have that of the response.
        elements: returns A(s) by the elements that A is assembled from; None where A is the data.
    """

    A: PolynomialMatrix
    inputs: np.ndarray
    outputs: np.ndarray
    power: int = 0
    imaginary: np.ndarray | None = None
    sizes: np.ndarray | None = None
    input_names: tuple[str, ...] = ()
    output_names: tuple[str, ...] = ()
    units: np.ndarray = field(default_factory=lambda: np.array([[""]]))
    quantity: str = "response"
    left_out: LeftOut | None = None
    notices: tuple[Notice, ...] = ()
    delayed: tuple[DelayedTerm, ...] = ()
    input_delays: tuple[float, ...] = ()
    output_quantities: tuple[str, ...] = ()
    elements: Callable[[], PolynomialMatrix] | None = None

    def quantity_of(self, outputs: Sequence[int] | None = None) -> str:
        """The quantities of all outputs, or of some by their places, as text."""
        own = self.output_quantities or (self.quantity,) * len(self.output_names)
        names = list(dict.fromkeys(own if outputs is None else (own[i] for i in outputs)))
        return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]])) if names else self.quantity

    def dead_time(self, j: int) -> float:
        """The dead time of an input in s."""
        return self.input_delays[j] if self.input_delays else 0.0

    def phases(self, omega: np.ndarray) -> np.ndarray:
        """w delay of each input in the precision of w in rad/s, shape (m, F); all 0 without delays."""
        return np.multiply.outer(np.array(self.input_delays or np.zeros(self.inputs.shape[1]), dtype=omega.dtype), omega)

    @property
    def coefficients(self) -> np.ndarray:
        """A_0, A_1, ..., A_0 with its imaginary part."""
        if self.imaginary is None:
            return self.A.coefficients
        return self.A.coefficients + 1j * np.array([self.imaginary, *np.zeros_like(self.A.coefficients[1:])])

    def known(self, before: Harmonic | None) -> Harmonic:
        """The one before, of the same system, with all that it has computed, where both have the same contents."""
        if before is None:
            return self
        pairs = [
            (getattr(self, part.name), getattr(before, part.name)) for part in fields(self) if part.name not in ("A", "elements")
        ]
        pairs += [
            (getattr(self.A, name), getattr(before.A, name)) for name in ("coefficients", "uncertainty", "coordinates", "equations")
        ]
        return before if all(np.array_equal(*pair) for pair in pairs) else self

    @cached_property
    def solver(self) -> StructuredSolver:
        """Solutions at given lines."""
        return StructuredSolver(
            self.coefficients, self.inputs, self.outputs, self.sizes, self.delayed, is_assembled=self.elements is not None
        )

    def check(self, frequencies: np.ndarray) -> None:
        """Raise an InputError for frequencies beyond the range of the computation."""
        highest = frequencies.max(initial=0.0)
        if self.left_out is not None and highest >= self.left_out.highest_hz:
            raise InputError(
                f"frequencies_hz: found {highest:g} Hz; the computed modes reach {self.left_out.highest_hz:.6g} Hz: increase count, "
                "the number of modes, or leave out the higher frequencies"
            )
        limit = self.solver.time * LARGEST_POWER ** (1 / max(self.A.degree, 1)) / (2 * np.pi)
        if highest > limit:
            raise InputError(
                f"frequencies_hz: found {highest:g} Hz; powers of it leave the range of float64, expected at most {limit:.3g} Hz"
            )

    @cached_property
    def real(self) -> tuple[PolynomialMatrix, np.ndarray, np.ndarray]:
        """A real A(s) with B and a C, complex where A(s) is complex.

        [[A, -H], [H, A]] (u, v) = (b, 0) has the solution u + i v of (A + i H) x = b.
        """
        if self.imaginary is None:
            return self.A, self.inputs, self.outputs
        H = [self.imaginary, *np.zeros_like(self.A.coefficients[1:])]
        doubled = [np.block([[own, -other], [other, own]]) for own, other in zip(self.A.coefficients, H)]
        inputs = np.vstack([self.inputs, 0 * self.inputs])
        return PolynomialMatrix(doubled), inputs, np.hstack([self.outputs, 1j * self.outputs])

    @cached_property
    def form(self) -> PoleResidueForm:
        """Poles, residues and polynomial part."""
        if self.delayed:
            raise InputError(
                "poles: equations with delays have infinitely many, and no sum of residues; system.characteristic_roots has the rightmost ones"
            )
        A, inputs, outputs = self.real
        return PoleResidueForm(A.jordan_pairs(), inputs, outputs, self.power)

    @cached_property
    def modal_sum(self) -> ModalSum | None:
        """The sum over modes in graded coordinates, where the matrices have that form."""
        return None if self.delayed else ModalSum.of(self.coefficients, self.inputs, self.outputs)
