"""M x'' + C x' + K x = 0 with M, K symmetric, M positive definite, decoupled by one symmetric eigenproblem of half the size.

With Phi^T M Phi = I and Phi^T K Phi = diag(k_i) the motion is sum of phi_i eta_i, eta_i'' + c_i eta_i' + k_i eta_i = 0, where
C = 0 or Phi^T C Phi is diagonal (damping in proportion: Caughey and O'Kelly 1965). Each k_i is found once more from its vector,
in a form in which nothing of a slow motion cancels beside a stiff one:

    phi^T K phi = sum over i of (sum of row i) phi_i^2 - sum over i < j of K_ij (phi_i - phi_j)^2.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from ..tolerances import noise_of
from .blocks import BlockDiagonal

#: Where a matrix has at most so many entries in a row the differences of coordinates are taken one by one.
FEW = 12


def symmetric_modes(M: csr_array, C: csr_array, K: csr_array) -> BlockDiagonal | None:
    """The states (x, x') decoupled into blocks [[0, w], [-w, -c]], [[0, w], [w, -c]] where k_i < 0; None where that fails.

    Args:
        M, C, K: symmetric, shape (m, m), sparse.
    """
    found = _modes(M, K)
    if found is None:
        return None
    shapes, weighted = found
    damping = np.zeros(len(shapes))
    if C.nnz:
        modal = shapes.T @ (C @ shapes)
        damping = np.diag(modal).copy()
        root = np.sqrt(np.einsum("ik,ik->k", np.abs(shapes), abs(C) @ np.abs(shapes)))  # each in the units of its mode
        if (np.abs(modal - np.diag(damping)) > noise_of(np.multiply.outer(root, root), len(shapes))).any():
            return None
    return _blocks(shapes, weighted, _quotients(K, shapes), damping)


def _modes(M: csr_array, K: csr_array) -> tuple[np.ndarray, np.ndarray] | None:
    """Phi and its inverse Phi^T M, or None where M is not positive definite."""
    diagonal = M.diagonal()
    if M.nnz == len(diagonal) and (diagonal > 0).all():
        root = np.sqrt(diagonal)
        vectors = _vectors(csr_array(K.multiply(1 / root[:, None]).multiply(1 / root)))
        return vectors / root[:, None], vectors.T * root
    try:
        shapes = scipy.linalg.eigh(K.toarray(), M.toarray())[1]
    except np.linalg.LinAlgError:
        return None
    return shapes, (M @ shapes).T


def _vectors(sparse: csr_array) -> np.ndarray:
    """The eigenvectors of a symmetric matrix; of a tridiagonal one by an algorithm for those."""
    sparse = (sparse + sparse.T) / 2
    order = reverse_cuthill_mckee(csr_array(sparse), symmetric_mode=True)
    narrow = csr_array(sparse)[order][:, order].tocoo()
    if len(order) > 2 and np.abs(narrow.row - narrow.col).max(initial=0) <= 1:
        found = np.empty(sparse.shape)
        found[order] = scipy.linalg.eigh_tridiagonal(narrow.diagonal(), narrow.diagonal(1))[1]
        return found
    return scipy.linalg.eigh(sparse.toarray(), driver="evd")[1]


def _quotients(K: csr_array, shapes: np.ndarray) -> np.ndarray:
    """phi^T K phi for every column."""
    K = (K + K.T) / 2
    upper = scipy.sparse.triu(K, 1, format="coo")
    if upper.nnz > FEW * len(shapes):
        return np.einsum("ik,ik->k", shapes, K @ shapes)
    sums = np.bincount(K.tocoo().row, K.data, len(shapes))
    return sums @ shapes**2 - upper.data @ (shapes[upper.row] - shapes[upper.col]) ** 2


def _blocks(shapes, weighted, stiffness, damping) -> BlockDiagonal:
    """The states are eta_i and eta_i' / w_i."""
    rates = np.sqrt(np.abs(stiffness))
    rates = np.where(rates > 0, rates, 1.0)
    m = len(shapes)
    basis, inverse = np.zeros((2 * m, 2 * m)), np.zeros((2 * m, 2 * m))
    basis[:m, 0::2], basis[m:, 1::2] = shapes, shapes * rates
    inverse[0::2, :m], inverse[1::2, m:] = weighted, weighted / rates[:, None]
    blocks = np.zeros((m, 2, 2))
    blocks[:, 0, 1], blocks[:, 1, 0], blocks[:, 1, 1] = rates, -stiffness / rates, -damping
    return BlockDiagonal(basis, inverse, tuple(blocks), 1.0)
