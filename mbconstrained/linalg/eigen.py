"""A real matrix decoupled by its eigenvectors: blocks of size one and two, where its zeros stand apart.

The eigenvectors x_i and the rows y_i of their inverse give each zero once more as y_i S x_i (Rayleigh's quotient), its error
the square of theirs: rounding of the QR algorithm grows with the size of S, that of the quotient with that of S x_i. The states are
measured in units that balance S. How far a zero stands apart from the others tells the sum of |y_i| |x_i| over its states
(its condition for small relative errors of S, after Skeel 1979), which no unit of theirs enters. Zeros may be well known, and
their vectors hardly apart: where one of two like parts drives the other alone. The modes are huge then, and cancel.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
from scipy.linalg import lapack

from ..tolerances import DECOUPLING_LIMIT
from .blocks import BlockDiagonal, block_diagonalize
from .kinds import Matrix, alike, full, kept
from .scaling import balancing_units
from .threads import one_thread

#: Modes so many times larger than the states that they are made of are not told apart: as many digits would cancel.
MOST_AMPLIFIED = 1e4

#: So many vectors are looked at at once.
COLUMNS = 32


def decoupled(matrix: Matrix, units: np.ndarray | None = None) -> BlockDiagonal:
    """inverse @ S @ basis = diag(blocks) for a real square matrix S, dense or sparse.

    Where an eigenvector is hardly apart from the others, by its Schur form and clusters instead (``linalg.blocks``).

    Args:
        matrix: S.
        units: of the states, in which it is balanced, where they are known.

    >>> decoupled(np.array([[0.0, 1.0], [-4.0, 0.0]])).blocks[0].tolist()
    [[0.0, 2.0], [-2.0, 0.0]]
    """
    if not matrix.shape[0]:
        return BlockDiagonal(*np.zeros((2, 0, 0)), (), 0.0)
    matrix = kept(matrix) if isinstance(matrix, np.ndarray) else matrix
    units = balancing_units(matrix) if units is None else units
    balanced = alike(matrix * units / units[:, None], matrix)
    found = _by_eigenvectors(balanced) or _by_clusters(balanced)
    basis, inverse = found.basis, found.inverse
    basis *= units[:, None]
    inverse /= units
    return BlockDiagonal(basis, inverse, found.blocks, found.coupling)


def _by_clusters(matrix: Matrix) -> BlockDiagonal:
    triangle, rotation = scipy.linalg.schur(full(matrix), output="real")
    parts = block_diagonalize(triangle)
    return BlockDiagonal(rotation @ parts.basis, parts.inverse @ rotation.T, parts.blocks, parts.coupling)


def _by_eigenvectors(matrix: Matrix) -> BlockDiagonal | None:
    """LAPACK's real and imaginary parts of the vectors side by side are the basis: no complex matrix is made."""
    n = matrix.shape[0]
    room = int(lapack.dgeev_lwork(n, compute_vl=0)[0])
    with one_thread(n):
        _, imaginary, _, basis, failed = lapack.dgeev(np.array(full(matrix), order="F"), compute_vl=0, lwork=room, overwrite_a=1)
    factors, pivots, singular = lapack.dgetrf(basis)
    if failed or singular:
        return None
    inverse = lapack.dgetri(factors, pivots, lwork=room, overwrite_lu=1)[0]
    single, upper = (imaginary == 0).nonzero()[0], (imaginary > 0).nonzero()[0]
    worst = _worst_condition(basis, inverse, single, upper)
    if not (worst <= DECOUPLING_LIMIT and _largest_mode(basis, inverse) <= MOST_AMPLIFIED):
        return None
    found: dict[int, np.ndarray] = {}
    for at in _some(single):  # y S x of real x, y
        found |= zip(at.tolist(), inverse[at].dot(matrix @ basis[:, at]).diagonal()[:, None, None])
    for at in _some(upper):
        found |= zip(at.tolist(), _pairs(matrix, basis, inverse, at))
    return BlockDiagonal(basis, inverse, tuple(found[at] for at in sorted(found)), worst)


def _pairs(matrix, basis, inverse, upper) -> np.ndarray:
    """The blocks [[a, b], [-b, a]] of pairs of complex ones, shape (k, 2, 2)."""
    k, both = len(upper), np.concatenate([upper, upper + 1])
    quotients = inverse[both].dot(matrix @ basis[:, both])
    diagonal = quotients.diagonal()
    a, b = (diagonal[:k] + diagonal[k:]) / 2, (quotients.diagonal(k) - quotients.diagonal(-k)) / 2
    return np.array([a, b, -b, a]).T.reshape(-1, 2, 2)


def _worst_condition(basis, inverse, single, upper) -> float:
    """The largest sum of |y_i| |x_i|, of zeros with real x, y and of pairs of complex ones."""
    worst = 0.0
    for at in _some(single):
        worst = max(worst, _sums(np.abs(basis[:, at]), np.abs(inverse[at])).max())
    for at in _some(upper):
        sizes = np.hypot(basis[:, at], basis[:, at + 1]), np.hypot(inverse[at], inverse[at + 1])
        worst = max(worst, _sums(*sizes).max() / 2)
    return float(worst)


def _sums(columns, rows) -> np.ndarray:
    """The products of columns and rows of the same number."""
    return (columns * rows.T).sum(axis=0)


def _largest_mode(basis, inverse) -> float:
    """How many times larger than the states that it is made of a mode may be."""
    return float(np.sqrt((np.einsum("ij,ij->j", basis, basis) * np.einsum("ij,ij->i", inverse, inverse)).max()))


def _some(columns: np.ndarray) -> list[np.ndarray]:
    """Some columns at a time: what is made of them stays small beside the matrix."""
    return [columns[begin : begin + COLUMNS] for begin in range(0, len(columns), COLUMNS)]
