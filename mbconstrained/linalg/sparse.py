"""Sparse matrices that are mostly diagonal: solved by division, and questions about them that rounding must not decide."""

from __future__ import annotations

import numpy as np
import scipy.sparse
from scipy.linalg import lapack
from scipy.sparse import csr_array

from ..tolerances import noise_of
from .scaling import equilibration


def solved(matrix: csr_array, right: csr_array | np.ndarray) -> csr_array | np.ndarray:
    """matrix^-1 @ right, sparse or not as that is; where the matrix is diagonal by division."""
    diagonal, sparse = matrix.diagonal(), scipy.sparse.issparse(right)
    if matrix.nnz == np.count_nonzero(diagonal) == matrix.shape[0]:
        return csr_array(right.multiply(1 / diagonal[:, None])) if sparse else right / diagonal[:, None]
    found = np.linalg.solve(matrix.toarray(), right.toarray() if sparse else right)
    return csr_array(found) if sparse else found


def without_noise(matrix: csr_array, size: csr_array) -> csr_array:
    """The same without entries that are rounding of terms of this size: they would couple what is not, in any units."""
    found = matrix.tocoo()
    if not found.nnz:
        return found.tocsr()
    kept = np.abs(found.data) > noise_of(np.asarray(csr_array(size)[found.row, found.col]).reshape(-1))
    return csr_array((found.data[kept], (found.row[kept], found.col[kept])), shape=found.shape)


def is_symmetric(matrix: csr_array) -> bool:
    """Whether it is to rounding, each entry beside its row and its column: no unit of a coordinate decides."""
    difference = abs(matrix - matrix.T).tocoo()
    if not difference.nnz:
        return True
    size = np.sqrt(abs(matrix).max(axis=1).toarray().reshape(-1))
    return bool((difference.data <= noise_of(size[difference.row] * size[difference.col])).all())


def is_semidefinite(matrix: csr_array) -> bool:
    """Whether a symmetric matrix has no negative eigenvalue beyond rounding, its diagonal brought to 1 where it is not 0."""
    diagonal = matrix.diagonal()
    if (diagonal < 0).any():
        return False
    root = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scaled = csr_array(matrix.multiply(1 / root[:, None]).multiply(1 / root))
    size, noise = np.asarray(abs(scaled).sum(axis=1)).reshape(-1), noise_of(1.0, len(root))
    dominated = (2 * scaled.diagonal() - size >= -noise).all()  # then it has none, at no cost
    return bool(dominated) or float(np.linalg.eigvalsh(scaled.toarray())[0]) >= -noise


def condition(matrix: np.ndarray | csr_array) -> float:
    """The condition (1-norm, estimated) of a square matrix whose rows and columns are brought to one size."""
    if not matrix.shape[0]:
        return 1.0
    if scipy.sparse.issparse(matrix):
        if matrix.nnz == matrix.shape[0] and matrix.diagonal().all():  # diagonal
            return 1.0
        matrix = matrix.toarray()
    rows, columns = equilibration(np.abs(matrix))
    scaled = rows[:, None] * matrix * columns
    factors, _, info = lapack.dgetrf(scaled)
    reciprocal = lapack.dgecon(factors, np.abs(scaled).sum(axis=0).max())[0] if info == 0 else 0.0
    return 1 / reciprocal if reciprocal > 0 else np.inf
