"""A real matrix decoupled by its eigenvectors: blocks of size one and two, where its zeros stand apart.

The eigenvectors x_i and the rows y_i of their inverse give each zero once more as y_i S x_i (Rayleigh's quotient), its error
the square of theirs: rounding of the QR algorithm grows with the size of S, that of the quotient with that of S x_i. The states are
measured in units that balance S. How far a zero stands apart from the others tells the sum of |y_i| |x_i| over its states
(its condition for small relative errors of S, after Skeel 1979), which no unit of theirs enters.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
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
    with one_thread(len(matrix)):
        values, vectors = scipy.linalg.eig(matrix)
    real, upper = np.flatnonzero(values.imag == 0), np.flatnonzero(values.imag > 0)
    pairs, n, count = vectors[:, upper], len(matrix), len(upper)
    twos = np.empty((n, count, 2))
    twos[:, :, 0], twos[:, :, 1] = pairs.real, pairs.imag
    basis = np.hstack([vectors[:, real].real, twos.reshape(n, 2 * count)])
    try:
        inverse = np.linalg.inv(basis)
    except np.linalg.LinAlgError:
        return None
    worst = _worst_condition(basis, inverse, len(real))
    if not worst <= DECOUPLING_LIMIT:
        return None
    turned = csr_array(matrix) @ basis
    ones = np.einsum("ij,ji->i", inverse[: len(real)], turned[:, : len(real)])
    after = turned[:, len(real) :].reshape(n, count, 2)
    quotients = np.einsum("kin,nkj->kij", inverse[len(real) :].reshape(count, 2, n), after)
    a = (quotients[:, 0, 0] + quotients[:, 1, 1]) / 2
    b = (quotients[:, 0, 1] - quotients[:, 1, 0]) / 2
    blocks = [np.array([[value]]) for value in ones]
    blocks += list(np.stack([np.stack([a, b], axis=1), np.stack([-b, a], axis=1)], axis=1))
    return BlockDiagonal(basis, inverse, tuple(blocks), worst)


def _worst_condition(basis, inverse, singles: int) -> float:
    """The largest sum of |y_i| |x_i| for the zeros with real x, y, which come first, and for pairs of complex ones."""
    n, pairs = len(basis), (len(basis) - singles) // 2
    ones = np.einsum("ik,ki->k", np.abs(basis[:, :singles]), np.abs(inverse[:singles]))
    right = np.linalg.norm(basis[:, singles:].reshape(n, pairs, 2), axis=2)
    left = np.linalg.norm(inverse[singles:].reshape(pairs, 2, n), axis=1) / 2
    return float(max(ones.max(initial=0.0), np.einsum("ik,ki->k", right, left).max(initial=0.0)))
