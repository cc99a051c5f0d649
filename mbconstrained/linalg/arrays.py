"""Matrices that are sparse where they are large and full where they are small, with common operations; the routines of LAPACK.

A sparse operation takes ten to a hundred times as long as one of NumPy on a few entries; products, sums, rows and columns are
written alike for both. The rest is here.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from typing import Any, TypeAlias

import numpy as np
import scipy

Matrix: TypeAlias = "np.ndarray | scipy.sparse.csr_array"

#: Matrices with so many rows are kept sparse.
LARGE = 150


def kept(matrix: np.ndarray) -> Matrix:
    """The matrix, sparse or full according to its size."""
    return compressed(matrix) if len(matrix) >= LARGE else matrix


def compressed(matrix: np.ndarray) -> scipy.sparse.csr_array:
    """The matrix without stored zeros."""
    values = np.ascontiguousarray(matrix).reshape(-1)
    places = np.flatnonzero(values != 0)
    rows, columns = np.divmod(places, max(matrix.shape[1], 1))
    return scipy.sparse.csr_array((values[places], columns, np.searchsorted(rows, np.arange(len(matrix) + 1))), shape=matrix.shape)


def of_like_kind(matrix, other: Matrix) -> Matrix:
    """A matrix of the kind of another one."""
    if isinstance(other, np.ndarray):
        return full(matrix)
    return compressed(matrix) if isinstance(matrix, np.ndarray) else scipy.sparse.csr_array(matrix)


def full(matrix: Matrix) -> np.ndarray:
    """All entries as an array."""
    return matrix if isinstance(matrix, np.ndarray) else matrix.toarray()


def matrix_of(shape: tuple[int, int], like: Matrix, *parts: tuple[int, int, Matrix]) -> Matrix:
    """Zeros with parts, each with its first row and column, sparse or full like another matrix; a vector is a diagonal.

    >>> matrix_of((2, 3), np.zeros((1, 1)), (0, 1, np.array([5.0, 6.0])), (0, 0, np.array([[1.0], [2.0]]))).tolist()
    [[1.0, 5.0, 0.0], [2.0, 0.0, 6.0]]
    """
    if isinstance(like, np.ndarray):
        result = np.zeros(shape)
        for row, column, part in parts:
            if part.ndim == 1:
                result[range(row, row + len(part)), range(column, column + len(part))] = part
            else:
                result[row : row + part.shape[0], column : column + part.shape[1]] = part
        return result
    stored = [(row, column, entries(scipy.sparse.diags_array(part) if part.ndim == 1 else part)) for row, column, part in parts]
    shifted = [np.array([own[0] + row, own[1] + column, own[2]]) for row, column, own in stored]
    rows, columns, values = np.concatenate([np.zeros((3, 0)), *shifted], axis=1)
    return scipy.sparse.csr_array((values, (rows.astype(int), columns.astype(int))), shape=shape)


def entries(matrix: Matrix) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows, columns and values of the stored entries."""
    if isinstance(matrix, np.ndarray):
        row, column = matrix.nonzero()
        return row, column, matrix[row, column]
    result = matrix.tocoo()
    return result.row, result.col, result.data


def diagonal_parts(matrix: Matrix, groups: Sequence[np.ndarray]) -> list[Matrix]:
    """The parts of a square matrix on groups of its rows that no entry couples to each other, each sparse only where it is large.

    >>> [part.tolist() for part in diagonal_parts(np.diag([1.0, 2.0, 3.0]), [np.array([0, 2]), np.array([1])])]
    [[[1.0, 0.0], [0.0, 3.0]], [[2.0]]]
    """
    if isinstance(matrix, np.ndarray) or len(groups) == 1:
        return [matrix[rows][:, rows] for rows in groups]
    group, place = np.empty((2, matrix.shape[0]), dtype=int)
    for number, rows in enumerate(groups):
        group[rows], place[rows] = number, np.arange(len(rows))
    row, column, values = entries(matrix)
    order = np.argsort(group[row], kind="stable")
    ends = np.searchsorted(group[row[order]], np.arange(len(groups) + 1))
    parts = []
    for rows, own in zip(groups, np.split(order, ends[1:-1])):
        at, shape = (place[row[own]], place[column[own]]), (len(rows),) * 2
        if len(rows) >= LARGE:
            parts.append(scipy.sparse.csr_array((values[own], at), shape=shape))
            continue
        part = np.zeros(shape)
        part[at] = values[own]
        parts.append(part)
    return parts


def block_diag(*blocks: np.ndarray) -> np.ndarray:
    """The blocks on the diagonal of a full matrix.

    >>> block_diag(np.ones((1, 2)), np.eye(1)).tolist()
    [[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    result = np.zeros(np.sum([(0, 0), *map(np.shape, blocks)], axis=0), dtype=np.result_type(*blocks or (0.0,)))
    row = column = 0
    for block in blocks:
        end, last = row + len(block), column + len(block.T)
        result[row:end, column:last] = block
        row, column = end, last
    return result


def others(size: int, places: np.ndarray) -> np.ndarray:
    """All indices below a size other than the given ones."""
    free = np.ones(size, dtype=bool)
    free[places] = False
    return free.nonzero()[0]


def entry_count(matrix: Matrix) -> int:
    """Number of stored or nonzero entries."""
    return np.count_nonzero(matrix) if isinstance(matrix, np.ndarray) else matrix.nnz


def filled(matrix: Matrix, axis: int) -> np.ndarray:
    """Which rows (axis 1) or columns (axis 0) have entries."""
    return matrix.any(axis=axis) if isinstance(matrix, np.ndarray) else np.diff((matrix if axis else matrix.tocsc()).indptr) > 0


def is_diagonal(matrix: Matrix) -> bool:
    """Whether a square matrix has all its entries on the diagonal, none of them zero."""
    count = np.count_nonzero(matrix.diagonal())
    return count == matrix.shape[0] == (np.count_nonzero(matrix) if isinstance(matrix, np.ndarray) else matrix.nnz)


def product(matrix: Matrix, columns: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """matrix @ columns for a real matrix, of complex columns both parts at once, and the sums of the sizes of its terms.

    >>> product(np.array([[-2.0]]), np.array([[3.0 + 4.0j]]), np.array([[5.0]]))
    (array([[-6.-8.j]]), array([[10.]]))
    """
    if isinstance(matrix, np.ndarray) and is_diagonal(matrix):
        diagonal = matrix.diagonal()[:, None]
        return diagonal * columns, np.abs(diagonal) * size
    return (matrix @ np.ascontiguousarray(columns).view(float)).view(columns.dtype), abs(matrix) @ size


class _Lapack:
    """The compiled routines of LAPACK by name, e.g. ``lapack.dgeev``, without ``scipy.linalg``.

    That package takes longer to import than a small scene to run: it loads the testing tools, the masked arrays and the compiler of NumPy.
    """

    _file = "scipy.linalg._flapack"

    def __getattr__(self, name: str) -> Any:
        if self._file not in sys.modules:
            spec = PathFinder.find_spec(self._file, [os.path.join(os.path.dirname(scipy.__file__), "linalg")])
            if spec is None or spec.loader is None:  # another build of SciPy
                return getattr(scipy.linalg.lapack, name)
            module = module_from_spec(spec)
            spec.loader.exec_module(module)
            sys.modules[self._file] = module
        self.__dict__[name] = routine = getattr(sys.modules[self._file], name)
        return routine


lapack = _Lapack()
