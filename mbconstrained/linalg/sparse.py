"""Matrices that are mostly diagonal, sparse or full: solved by division, and questions that rounding must not decide."""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import csr_array

from ..tolerances import noise_of
from .kinds import Matrix, alike, entries, entry_count, full, is_diagonal
from .scaling import equilibration

#: A matrix of this condition is not brought to better scales: no more than two digits are at stake.
WELL_CONDITIONED = 100.0


def solved(matrix: Matrix, right: Matrix) -> Matrix:
    """matrix^-1 @ right, of the kind of the right side; where the matrix is diagonal by division.

    Raises:
        numpy.linalg.LinAlgError: it is singular.
    """
    if is_diagonal(matrix):
        divisors = matrix.diagonal()[:, None]
        return right / divisors if isinstance(right, np.ndarray) else csr_array(right.multiply(1 / divisors))
    return alike(solution(full(matrix), full(right)), right)


def solution(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """matrix^-1 @ right for a real matrix; where they are small in a quarter of the time of ``numpy.linalg.solve``.

    Raises:
        numpy.linalg.LinAlgError: it is singular.

    >>> solution(np.array([[4.0]]), np.array([[2.0, 8.0]])).tolist()
    [[0.5, 2.0]]
    """
    if not right.size:
        return np.zeros(right.shape)
    found, info = (lapack.zgesv if right.dtype.kind == "c" else lapack.dgesv)(matrix, right)[2:]
    if info:
        raise np.linalg.LinAlgError("singular matrix")
    return found


def divided(matrix: Matrix, right: Matrix) -> Matrix:
    """The same without what a rounding of the matrix would bring in (Skeel 1979): a coupling that is not there."""
    if is_diagonal(matrix) or not right.shape[1]:
        return solved(matrix, right)
    divisor, dividend = full(matrix), full(right)
    inverse = np.abs(solution(divisor, np.eye(len(divisor))))
    size = inverse @ (np.abs(divisor) @ (inverse @ np.abs(dividend)))
    return alike(without_noise(solution(divisor, dividend), size), right)


def without_noise(matrix: Matrix, size: Matrix) -> Matrix:
    """The same without entries that are rounding of terms of this size: they would couple what is not, in any units."""
    if isinstance(matrix, np.ndarray):
        found = matrix.copy()
        found[~(np.abs(matrix) > noise_of(size))] = 0.0
        return found
    found = matrix.tocoo()
    if not found.nnz:
        return found.tocsr()
    kept = np.abs(found.data) > noise_of(np.asarray(csr_array(size)[found.row, found.col]).reshape(-1))
    return csr_array((found.data[kept], (found.row[kept], found.col[kept])), shape=found.shape)


def is_symmetric(matrix: Matrix) -> bool:
    """Whether it is to rounding, each entry beside its row and its column: no unit of a coordinate decides."""
    apart = abs(matrix - matrix.T)
    if not entry_count(apart):
        return True
    size = np.sqrt(full(abs(matrix).max(axis=1)).reshape(-1))
    if isinstance(apart, np.ndarray):
        return bool((apart <= noise_of(np.multiply.outer(size, size))).all())
    row, column, difference = entries(apart)
    return bool((difference <= noise_of(size[row] * size[column])).all())


def is_semidefinite(matrix: Matrix) -> bool:
    """Whether a symmetric matrix has no negative eigenvalue beyond rounding, its diagonal brought to 1 where it is not 0."""
    diagonal = matrix.diagonal()
    if (diagonal < 0).any():
        return False
    root = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scaled = matrix * (1 / root[:, None]) * (1 / root)
    size, noise = np.asarray(abs(scaled).sum(axis=1)).reshape(-1), noise_of(1.0, len(root))
    dominated = (2 * scaled.diagonal() - size >= -noise).all()  # then it has none, at no cost
    return bool(dominated) or float(np.linalg.eigvalsh(full(scaled))[0]) >= -noise


def condition(matrix: Matrix, enough: float = WELL_CONDITIONED) -> float:
    """The condition (1-norm, estimated) of a square matrix, its rows and columns brought to one size where it is more than enough."""
    if not matrix.shape[0] or is_diagonal(matrix):
        return 1.0
    matrix = full(matrix)
    found = _condition(matrix)
    if found <= enough:
        return found
    rows, columns = equilibration(np.abs(matrix))
    return _condition(rows[:, None] * matrix * columns)


def _condition(matrix: np.ndarray) -> float:
    factors, _, info = lapack.dgetrf(matrix)
    reciprocal = lapack.dgecon(factors, lapack.dlange("1", matrix))[0] if info == 0 else 0.0
    return 1 / reciprocal if reciprocal > 0 else np.inf
