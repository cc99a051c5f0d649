"""Checks at the door for sparse matrices: square, finite, real, symmetric; never turned into arrays."""

from __future__ import annotations

import numpy as np
import scipy.sparse

from ...checks import real_array
from ...errors import InputError
from ...tolerances import EPS, NOISE_SAFETY


def sparse_matrix(value, what: str, size: int | None = None) -> scipy.sparse.csc_array:
    """A square real sparse matrix without stored zeros; None is a zero matrix.

    Raises:
        InputError: not square, another size, entries that are complex or not finite.
    """
    if value is None:
        if size is None:
            raise InputError(f"{what}: a mechanical system needs a {what} matrix (zeros for massless coordinates)")
        return scipy.sparse.csc_array((size, size))
    matrix = checked_entries(value, what)
    if matrix.shape[0] != matrix.shape[1]:
        raise InputError(f"{what}: expected a square matrix, found {matrix.shape[0]} x {matrix.shape[1]}")
    if size is not None and matrix.shape[0] != size:
        raise InputError(f"{what}: expected shape {size} x {size}, found {matrix.shape[0]} x {matrix.shape[1]}")
    if not matrix.shape[0]:
        raise InputError(f"{what}: found no entries; a mechanical system needs at least one coordinate")
    return matrix


def checked_entries(value, what: str) -> scipy.sparse.csc_array:
    """A sparse matrix of finite real numbers, duplicates summed; what is dense already is made sparse."""
    if not scipy.sparse.issparse(value):
        value = np.atleast_2d(real_array(value, what))
        if value.ndim > 2:
            raise InputError(f"{what}: expected a matrix, found an array of shape {value.shape}")
    elif value.ndim != 2:
        value = value.reshape((1, -1))
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
    """Its symmetric part, where no more than rounding is lost.

    Raises:
        InputError: it is not symmetric.
    """
    largest, (row, column) = asymmetry(matrix)
    if largest:
        raise InputError(
            f"{what}: its entries for {names[row]}, {names[column]} and {names[column]}, {names[row]} differ by {largest:.3g}; "
            "large sparse systems need symmetric mass and stiffness; a small system can be given as arrays instead"
        )
    return scipy.sparse.csc_array((matrix + matrix.T) / 2)


#: Up to so many rows one product with many columns at once is faster than one for each.
FEW_ROWS = 5000


def times(matrix, columns: np.ndarray) -> np.ndarray:
    """A sparse real matrix times dense columns, one by one: SciPy's product with many at once is several times slower."""
    if matrix.shape[0] <= FEW_ROWS:
        return np.asfortranarray(matrix @ columns)
    found = np.empty((matrix.shape[0], columns.shape[1]), dtype=np.result_type(matrix.dtype, columns.dtype), order="F")
    for place, column in enumerate(columns.T):
        if found.dtype.kind == "c":  # a complex product would make the matrix complex for each column
            found.real[:, place], found.imag[:, place] = matrix @ column.real, matrix @ column.imag
        else:
            found[:, place] = matrix @ column
    return found


def combined(basis: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Real columns times complex coordinates, for which they need not become complex themselves."""
    found = np.empty((len(basis), coordinates.shape[1]), dtype=complex, order="F")
    found.real, found.imag = basis @ coordinates.real, basis @ coordinates.imag
    return found
