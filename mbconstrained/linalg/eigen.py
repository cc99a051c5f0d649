"""A real matrix decoupled by its eigenvectors: blocks of size one and two, where its zeros stand apart.

The eigenvectors x_i and the rows y_i of their inverse give each zero once more as y_i S x_i (Rayleigh's quotient), its error
the square of theirs: rounding of the QR algorithm grows with the size of S, that of the quotient with that of S x_i. The states are
measured in units that balance S. How far a zero stands apart from the others tells the sum of |y_i| |x_i| over its states
(its condition for small relative errors of S, after Skeel 1979), which no unit of theirs enters.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
from scipy.linalg import lapack
from scipy.sparse import csr_array

from ..tolerances import DECOUPLING_LIMIT
from .blocks import BlockDiagonal, block_diagonalize
from .scaling import balancing_units
from .threads import one_thread


def decoupled(matrix: np.ndarray) -> BlockDiagonal:
    """inverse @ S @ basis = diag(blocks) for a real square matrix S.

    Where an eigenvector is hardly apart from the others, by its Schur form and clusters instead (``linalg.blocks``).

    >>> decoupled(np.array([[0.0, 1.0], [-4.0, 0.0]])).blocks[0].tolist()
    [[0.0, 2.0], [-2.0, 0.0]]
    """
    if not len(matrix):
        return BlockDiagonal(matrix, matrix, (), 0.0)
    units = balancing_units(csr_array(matrix))
    balanced = matrix * units / units[:, None]
    found = _by_eigenvectors(balanced) or _by_clusters(balanced)
    return BlockDiagonal(found.basis * units[:, None], found.inverse / units, found.blocks, found.coupling)


def _by_clusters(matrix: np.ndarray) -> BlockDiagonal:
    triangle, rotation = scipy.linalg.schur(matrix, output="real")
    parts = block_diagonalize(triangle)
    return BlockDiagonal(rotation @ parts.basis, parts.inverse @ rotation.T, parts.blocks, parts.coupling)


def _by_eigenvectors(matrix: np.ndarray) -> BlockDiagonal | None:
    """LAPACK's real and imaginary parts of the vectors side by side are the basis: no complex matrix is made."""
    n = len(matrix)
    room = int(lapack.dgeev_lwork(n, compute_vl=0)[0])
    with one_thread(n):
        _, imaginary, _, basis, failed = lapack.dgeev(matrix, compute_vl=0, lwork=room)
    factors, pivots, singular = lapack.dgetrf(basis)
    if failed or singular:
        return None
    inverse = lapack.dgetri(factors, pivots, lwork=room, overwrite_lu=1)[0]
    single, upper = np.flatnonzero(imaginary == 0), np.flatnonzero(imaginary > 0)
    worst = _worst_condition(basis, inverse, single, upper)
    if not worst <= DECOUPLING_LIMIT:
        return None
    turned = csr_array(matrix) @ basis

    def quotients(rows, columns) -> np.ndarray:
        return np.einsum("ki,ik->k", inverse[rows], turned[:, columns])

    a = (quotients(upper, upper) + quotients(upper + 1, upper + 1)) / 2
    b = (quotients(upper, upper + 1) - quotients(upper + 1, upper)) / 2
    found = dict(zip(single.tolist(), quotients(single, single)[:, None, None]))
    found |= zip(upper.tolist(), np.stack([a, b, -b, a], axis=1).reshape(-1, 2, 2))
    return BlockDiagonal(basis, inverse, tuple(found[at] for at in sorted(found)), worst)


def _worst_condition(basis, inverse, single, upper) -> float:
    """The largest sum of |y_i| |x_i|, of zeros with real x, y and of pairs of complex ones."""
    ones = np.einsum("ik,ki->k", np.abs(basis[:, single]), np.abs(inverse[single]))
    pairs = np.einsum("ik,ki->k", np.hypot(basis[:, upper], basis[:, upper + 1]), np.hypot(inverse[upper], inverse[upper + 1])) / 2
    return float(max(ones.max(initial=0.0), pairs.max(initial=0.0)))
