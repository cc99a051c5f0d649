"""Validation of sparse matrices and constraint rows, which are never turned into arrays, and their products."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse

from ...ground.checks import real_array
from ...ground.errors import InputError
from ...ground.tolerances import EPS, NOISE_SAFETY
from ..constraints import Constraint, row_names


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
    """The constraint rows A x = b of a system of sparse matrices.

    Attributes:
        matrix: A, shape (k, n), compressed by rows.
        values: b, shape (k,).
        names: one for each row.
    """

    matrix: scipy.sparse.csr_array
    values: np.ndarray
    names: tuple[str, ...]

    def quoted(self, places: Sequence[int], most: int = 3) -> str:
        """The names of some rows in words."""
        names = [f'"{self.names[place]}"' for place in places[:most]]
        return " and ".join(names) + (f" and {len(places) - most} more" if len(places) > most else "")


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
