"""A real matrix decoupled by its eigenvectors: blocks of size one and two, where its zeros stand apart.

The eigenvectors x_i and the rows y_i of their inverse give each zero once more as y_i S x_i (Rayleigh's quotient), its error
the square of theirs: rounding of the QR algorithm grows with the size of S, that of the quotient does not. The states are
measured in units that balance S: how far eigenvectors stand apart would depend on the user's otherwise.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
from scipy.sparse import csr_array

from ..tolerances import DECOUPLING_LIMIT
from .blocks import BlockDiagonal, block_diagonalize
from .threads import one_thread


def decoupled(matrix: np.ndarray) -> BlockDiagonal:
    """inverse @ S @ basis = diag(blocks) for a real square matrix S.

    Where an eigenvector is hardly apart from the others, by its Schur form and clusters instead (``linalg.blocks``).

    >>> decoupled(np.array([[0.0, 1.0], [-4.0, 0.0]])).blocks[0].tolist()
    [[0.0, 2.0], [-2.0, 0.0]]
    """
    balanced, (units, _) = scipy.linalg.matrix_balance(matrix, permute=False, separate=True)
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
    pairs = vectors[:, upper]
    n, twos = len(matrix), np.empty((len(matrix), len(upper), 2))
    twos[:, :, 0], twos[:, :, 1] = pairs.real, pairs.imag
    basis = np.hstack([vectors[:, real].real, twos.reshape(n, -1)])
    try:
        inverse = np.linalg.inv(basis)
    except np.linalg.LinAlgError:
        return None
    projectors = np.linalg.norm(inverse, axis=1) * np.linalg.norm(basis, axis=0)
    worst = float(projectors.max(initial=0.0))
    if not worst <= DECOUPLING_LIMIT:
        return None
    turned = csr_array(matrix) @ basis
    ones = np.einsum("ij,ji->i", inverse[: len(real)], turned[:, : len(real)])
    count, after = len(upper), turned[:, len(real) :].reshape(n, -1, 2)
    quotients = np.einsum("kin,nkj->kij", inverse[len(real) :].reshape(count, 2, n), after)
    a = (quotients[:, 0, 0] + quotients[:, 1, 1]) / 2
    b = (quotients[:, 0, 1] - quotients[:, 1, 0]) / 2
    blocks = [np.array([[value]]) for value in ones]
    blocks += list(np.stack([np.stack([a, b], axis=1), np.stack([-b, a], axis=1)], axis=1))
    return BlockDiagonal(basis, inverse, tuple(blocks), worst)
