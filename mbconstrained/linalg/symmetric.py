"""M x'' + C x' + K x = 0 with M, K symmetric, M positive definite, decoupled by one symmetric eigenproblem of half the size.

With Phi^T M Phi = I and Phi^T K Phi = diag(k_i) the motion is sum of phi_i eta_i, eta_i'' + c_i eta_i' + k_i eta_i = 0, where
C = 0 or Phi^T C Phi is diagonal (damping in proportion: Caughey and O'Kelly 1965). Each k_i is found once more from its vector,
in a form in which nothing of a slow motion cancels beside a stiff one:

    phi^T K phi = sum over i of (sum of row i) phi_i^2 - sum over i < j of K_ij (phi_i - phi_j)^2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from ..tolerances import noise_of
from .kinds import Matrix

#: Where a matrix has at most so many entries in a row the differences of coordinates are taken one by one.
FEW = 12


@dataclass(frozen=True, eq=False)
class SymmetricModes:
    """As a ``BlockDiagonal`` of the states (x, x'), its basis and the inverse of that made when something asks for them.

    The states are eta_i and eta_i' / w_i.

    Attributes:
        M: the mass matrix.
        shapes: Phi, shape (m, m).
        rates: w, 1 where a mode has none.
        blocks: [[0, w], [-w, -c]], [[0, w], [w, -c]] where k_i < 0.
        coupling: 1, as the modes of a symmetric problem are orthogonal.
    """

    M: csr_array
    shapes: np.ndarray
    rates: np.ndarray
    blocks: tuple[np.ndarray, ...]
    coupling: float = 1.0

    @property
    def basis(self) -> np.ndarray:
        """Shape (2 m, 2 m)."""
        return self.seen(np.eye(2 * len(self.shapes)))

    @property
    def inverse(self) -> np.ndarray:
        """Of the basis, shape (2 m, 2 m)."""
        return self.coordinates(np.eye(2 * len(self.shapes)))

    def seen(self, output: Matrix) -> np.ndarray:
        """output @ basis, for an output of shape (r, 2 m)."""
        m = len(self.shapes)
        found, velocities = np.zeros((output.shape[0], 2 * m)), output[:, m:]
        found[:, 0::2] = output[:, :m] @ self.shapes
        if abs(velocities).max() > 0:
            found[:, 1::2] = velocities @ self.shapes * self.rates
        return found

    def coordinates(self, states: np.ndarray) -> np.ndarray:
        """inverse @ states, of shape (2 m, any) or (2 m,)."""
        m, found = len(self.shapes), np.empty(states.shape)
        found[0::2], velocities = self.shapes.T @ (self.M @ states[:m]), self.shapes.T @ (self.M @ states[m:])
        found[1::2] = (velocities.T / self.rates).T
        return found


def symmetric_modes(M: csr_array, C: csr_array, K: csr_array, resting: np.ndarray | None = None) -> SymmetricModes | None:
    """The states (x, x') decoupled; None where that fails.

    Args:
        M, C, K: symmetric, shape (m, m), sparse.
        resting: all shapes, one a row, that K has no forces against: exactly then.
    """
    shapes = _shapes(M, K)
    if shapes is None:
        return None
    free = 0 if resting is None else len(resting)
    if free:
        shapes = _with_resting(M, K, shapes, resting)
    damping = np.zeros(len(shapes))
    if C.nnz:
        modal = shapes.T @ (C @ shapes)
        damping = np.diag(modal).copy()
        root = np.sqrt(np.einsum("ik,ik->k", np.abs(shapes), abs(C) @ np.abs(shapes)))  # each in the units of its mode
        if (np.abs(modal - np.diag(damping)) > noise_of(np.multiply.outer(root, root), len(shapes))).any():
            return None
        damping[:free] = np.where(np.abs(damping[:free]) > noise_of(root[:free] ** 2, len(shapes)), damping[:free], 0.0)
    stiffness, blocks = _quotients(K, shapes), np.zeros((len(shapes), 2, 2))
    stiffness[:free] = 0.0
    rates = np.sqrt(np.abs(stiffness))
    rates = np.where(rates > 0, rates, 1.0)
    blocks[:, 0, 1], blocks[:, 1, 0], blocks[:, 1, 1] = rates, -stiffness / rates, -damping
    return SymmetricModes(M, shapes, rates, tuple(blocks))


def _shapes(M: csr_array, K: csr_array) -> np.ndarray | None:
    """Phi, or None where M is not positive definite."""
    diagonal = M.diagonal()
    if M.nnz == len(diagonal) and (diagonal > 0).all():
        root = np.sqrt(diagonal)
        vectors = _vectors(csr_array(K.multiply(1 / root[:, None]).multiply(1 / root)))
        vectors /= root[:, None]
        return vectors
    try:
        return scipy.linalg.eigh(K.toarray(), M.toarray())[1]
    except np.linalg.LinAlgError:
        return None


def _with_resting(M: csr_array, K: csr_array, shapes: np.ndarray, resting: np.ndarray) -> np.ndarray:
    """The shapes with so many of least frequency replaced, the others without any part in these."""
    found = resting.T
    for _ in range(2):  # once more, for shapes that are nearly alike
        triangle = np.linalg.cholesky(found.T @ (M @ found))
        found = scipy.linalg.solve_triangular(triangle, found.T, lower=True).T
    order = np.argsort(np.abs(_quotients(K, shapes)), kind="stable")[found.shape[1] :]
    others = shapes[:, np.sort(order)]
    others = others - found @ (found.T @ (M @ others))
    return np.hstack([found, others / np.sqrt(np.einsum("ik,ik->k", others, M @ others))])


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
