"""Models with symmetric mass and stiffness: their undamped modes, and damped ones in the coordinates of these."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ..ground.tolerances import EPS, LARGEST_CORRECTION, LAST_CORRECTION, REFINED_SPREAD, noise_of
from .arrays import Matrix, block_diag, entries, entry_count, full, is_diagonal, lapack
from .blocks import BlockDiagonal, decoupled
from .division import condition, congruence, exact_row_sums

# Undamped modes refined: K Phi = M Phi diag(k), Phi^T M Phi = I, to rounding errors of each k, not of the largest.
# A symmetric eigenproblem leaves errors of eps times the largest k in all others: of a beam of 30 elements nine digits of the slowest
# motion. With S = X^T K X and R = I - X^T M X of approximate shapes X, computed with twice the digits, one step
# k_j = S_jj / (1 - R_jj),    E_ij = (S_ij + k_j R_ij) / (k_j - k_i),    E_jj = R_jj / 2,    Phi = X (I + E)
# squares the error (Ogita and Aishima 2018).

#: Most steps.
STEPS = 5


def refined_modes(M: np.ndarray, C: np.ndarray, K: np.ndarray, shapes: np.ndarray) -> tuple[np.ndarray, ...] | None:
    """Shapes, their stiffness k and damping Phi^T C Phi; None where the steps do not converge."""
    unit = np.eye(len(shapes))
    for _ in range(STEPS):
        S, R = congruence(shapes, K), unit - congruence(shapes, M)
        k = np.diag(S) / (1 - np.diag(R))
        if not (k > 0).all():
            return None
        change, gaps = S + k * R, k - k[:, None]
        alike = np.abs(change) <= 64 * EPS * np.sqrt(np.multiply.outer(k, k))
        np.fill_diagonal(alike, True)
        mixed = ~alike & (np.abs(change) > LARGEST_CORRECTION * np.abs(gaps))
        if mixed.any():
            shapes = shapes @ _combined(S, unit - R, mixed)
            continue
        far = ~alike | (np.abs(gaps) > LARGEST_CORRECTION * np.maximum(k, k[:, None]))
        np.fill_diagonal(far, False)
        E = np.where(far, change / np.where(far, gaps, 1.0), R / 2)
        following = shapes + shapes @ E
        if np.abs(E).max() <= LAST_CORRECTION:
            damping = congruence(shapes, C)
            return following, k, damping + E.T @ damping + damping @ E
        shapes = following
    return None


def _combined(S: np.ndarray, units: np.ndarray, mixed: np.ndarray) -> np.ndarray:
    """The matrix that decouples groups of shapes that are mixed."""
    result = np.eye(len(S))
    which = scipy.sparse.csgraph.connected_components(scipy.sparse.csr_array(mixed | mixed.T), directed=False)[1]
    for group in range(which.max() + 1):
        at = np.flatnonzero(which == group)
        if len(at) > 1:
            triangle = np.linalg.inv(np.linalg.cholesky(units[np.ix_(at, at)]))
            result[np.ix_(at, at)] = triangle.T @ np.linalg.eigh(triangle @ S[np.ix_(at, at)] @ triangle.T)[1]
    return result


# M x'' + C x' + K x = 0 with M, K symmetric, M positive definite, decoupled by one symmetric eigenproblem of half the size.
# With Phi^T M Phi = I and Phi^T K Phi = diag(k_i) the motion is sum of phi_i eta_i, eta_i'' + c_i eta_i' + k_i eta_i = 0, where
# C = 0 or Phi^T C Phi is diagonal (proportional damping: Caughey and O'Kelly 1965). Each k_i is found once more from its vector,
# in a form in which nothing of a slow motion cancels next to a stiff one:
# phi^T K phi = sum over i of (sum of row i) phi_i^2 - sum over i < j of K_ij (phi_i - phi_j)^2.

#: Where a matrix has at most so many entries in a row the differences of coordinates are taken one by one.
FEW = 12


#: A condition of K below the spread by this factor, with the diagonal of M, does not belong to modes of such a spread.
PRECHECK = 100.0

#: Largest number of refined shapes: 200 take as long as some ten symmetric eigenproblems of that size.
REFINED_SHAPES = 200


@dataclass(frozen=True, eq=False)
class SymmetricModes:
    """Undamped modes of the states (x, x'), in the form of a ``BlockDiagonal`` whose basis and inverse are computed on demand.

    The states are eta_i and eta_i' / w_i.

    Attributes:
        M: the mass matrix.
        shapes: Phi, shape (m, m).
        rates: w, 1 where a mode has none.
        blocks: [[0, w], [-w, -c]], [[0, w], [w, -c]] where k_i < 0.
        coupling: 1, as the modes of a symmetric problem are orthogonal.
        exact_blocks: 0: no block is known exactly.
    """

    M: Matrix
    shapes: np.ndarray
    rates: np.ndarray
    blocks: tuple[np.ndarray, ...]
    coupling: float = 1.0
    exact_blocks: int = 0

    @property
    def basis(self) -> np.ndarray:
        """Shape (2 m, 2 m)."""
        return self.modal_output(np.eye(2 * len(self.shapes)))

    @property
    def inverse(self) -> np.ndarray:
        """Inverse of the basis, shape (2 m, 2 m)."""
        return self.coordinates(np.eye(2 * len(self.shapes)))

    def modal_output(self, output: Matrix) -> np.ndarray:
        """output @ basis, for an output of shape (r, 2 m)."""
        m = len(self.shapes)
        result, velocities = np.zeros((output.shape[0], 2 * m)), output[:, m:]
        result[:, 0::2] = output[:, :m] @ self.shapes
        if abs(velocities).max() > 0:
            result[:, 1::2] = velocities @ self.shapes * self.rates
        return result

    def coordinates(self, states: np.ndarray) -> np.ndarray:
        """inverse @ states, of shape (2 m, any) or (2 m,)."""
        m, result = len(self.shapes), np.empty(states.shape)
        result[0::2], velocities = self.shapes.T @ (self.M @ states[:m]), self.shapes.T @ (self.M @ states[m:])
        result[1::2] = (velocities.T / self.rates).T
        return result


def symmetric_modes(M: Matrix, C: Matrix, K: Matrix, bodies: np.ndarray | None = None) -> SymmetricModes | None:
    """The states (x, x') decoupled; None where that fails."""
    shapes = undamped_shapes(M, K)
    if shapes is None:
        return None
    free = 0 if bodies is None else bodies.shape[1]
    if free:
        shapes, supports = _with_bodies(M, K, shapes, bodies)
    damping = np.zeros(len(shapes))
    if entry_count(C):
        modal = shapes.T @ (C @ shapes)
        damping = np.diag(modal).copy()
        root = np.sqrt(np.einsum("ik,ik->k", np.abs(shapes), abs(C) @ np.abs(shapes)))  # each in the units of its mode
        if (np.abs(modal - np.diag(damping)) > noise_of(np.multiply.outer(root, root), len(shapes))).any():
            return None
    stiffness = _quotients(K, shapes)
    if free:
        stiffness[:free], damping[:free] = supports
    return _of_modes(M, shapes, stiffness, damping)


def _of_modes(M: Matrix, shapes: np.ndarray, stiffness: np.ndarray, damping: np.ndarray) -> SymmetricModes:
    rates, blocks = np.sqrt(np.abs(stiffness)), np.zeros((len(shapes), 2, 2))
    rates = np.where(rates > 0, rates, 1.0)
    blocks[:, 0, 1], blocks[:, 1, 0], blocks[:, 1, 1] = rates, -stiffness / rates, -damping
    return SymmetricModes(M, shapes, rates, tuple(blocks))


def modes_of_wide_spread(M: Matrix, C: Matrix, K: Matrix, order: np.ndarray | None = None) -> SymmetricModes | BlockDiagonal | None:
    """The states (x, x') decoupled where undamped rates span many orders of magnitude, and any damping.

    In the coordinates of refined undamped modes the motion is eta'' + D eta' + diag(k) eta = 0: in the states (w eta, eta'), w^2 = k,
    nothing is larger than the fastest rate, where K has its square.
    """
    size = K.shape[0]
    if size > REFINED_SHAPES:
        return None
    order = np.arange(size) if order is None else order
    mass, damper, stiff = (full(matrix)[np.ix_(order, order)] for matrix in (M, C, K))
    shapes = undamped_shapes(mass, stiff) if may_be_wide(mass, stiff) else None
    if shapes is None:
        return None
    quotients = _quotients(stiff, shapes)
    if not quotients.max() > REFINED_SPREAD * quotients.min() or (modes := refined_modes(mass, damper, stiff, shapes)) is None:
        return None
    shapes, stiffness, modal = modes
    return _damped(M, shapes[np.argsort(order)], stiffness, modal)


def modes_of_elements(
    M: np.ndarray, C: np.ndarray, directions: np.ndarray, constants: np.ndarray
) -> SymmetricModes | BlockDiagonal | None:
    """The states (x, x') decoupled where the stiffness is B^T diag(k) B with constants of any spread; None for other masses, or free bodies.

    Singular values of k^(1/2) B M^(-1/2) by Jacobi rotations after QR with pivots are right to rounding errors of each, if B without k
    is well conditioned (Drmač and Veselić 2008).
    """
    mass = M.diagonal()
    if not is_diagonal(M) or not (mass > 0).all() or not (constants >= 0).all() or len(constants) < len(mass):
        return None
    root = np.sqrt(mass)
    factor = np.sqrt(constants)[:, None] * directions / root
    rates, _, vectors, scale, _, failed = lapack.dgejsv(factor, joba=2, jobu=3, jobv=0, jobt=0, jobp=0)
    rates = rates * (scale[0] / scale[1])
    if failed or not rates.min() > 0:
        return None
    shapes = vectors / root[:, None]
    return _damped(M, shapes, rates**2, congruence(shapes, C))


def _damped(M: Matrix, shapes: np.ndarray, stiffness: np.ndarray, modal: np.ndarray) -> SymmetricModes | BlockDiagonal:
    """The states decoupled in the coordinates of undamped modes, with the damping Phi^T C Phi."""
    size = np.sqrt(np.abs(np.diag(modal)))
    if (np.abs(modal - np.diag(np.diag(modal))) <= EPS / 2 * np.multiply.outer(size, size)).all():
        return _of_modes(M, shapes, stiffness, np.diag(modal).copy())
    rates = np.diag(np.sqrt(stiffness))
    parts = decoupled(np.block([[np.zeros_like(rates), rates], [-rates, -modal]]))
    columns, rows = block_diag(shapes / np.diag(rates), shapes), shapes.T @ full(M)
    inverse = block_diag(np.diag(rates)[:, None] * rows, rows)
    return BlockDiagonal(columns @ parts.basis, parts.inverse @ inverse, parts.blocks, parts.coupling, len(parts.blocks))


def may_be_wide(M: Matrix, K: Matrix) -> bool:
    """Whether undamped rates may span enough orders of magnitude for a refinement of modes, by a bound without eigenvalues."""
    if K.shape[0] > REFINED_SHAPES:
        return False
    root = np.sqrt(np.abs(M.diagonal()))
    return bool((root > 0).all() and condition(full(K) / np.multiply.outer(root, root), np.inf) > REFINED_SPREAD / PRECHECK)


def undamped_shapes(M: Matrix, K: Matrix) -> np.ndarray | None:
    """The shapes of M x'' + K x = 0 for symmetric M and K; of a large tridiagonal matrix by an algorithm for those. None where that fails."""
    diagonal = M.diagonal()
    if not is_diagonal(M) or not (diagonal > 0).all():
        _, vectors, failed = lapack.dsygvd(full(K), full(M))
        return None if failed else vectors
    root = np.sqrt(diagonal)
    matrix = K * (1 / root[:, None]) * (1 / root)
    matrix = (matrix + matrix.T) / 2
    vectors, failed = None if isinstance(matrix, np.ndarray) else _tridiagonal_vectors(scipy.sparse.csr_array(matrix)), False
    if vectors is None:
        _, vectors, failed = lapack.dsyevd(full(matrix))
    vectors /= root[:, None]
    return None if failed else vectors


def _with_bodies(M: Matrix, K: Matrix, shapes: np.ndarray, bodies: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The shapes with those of free bodies in place of the slowest ones, and the stiffness and damping of these.

    The others have no part in them. Supports couple both, which changes the shapes by the first order of a small number.
    """
    result, stiff, damped = bodies.transpose(0, 2, 1)
    for _ in range(2):  # once more, for shapes that are nearly alike
        triangle = np.linalg.cholesky(result.T @ (M @ result))
        result, stiff, damped = (scipy.linalg.solve_triangular(triangle, part.T, lower=True).T for part in (result, stiff, damped))
    order = np.argsort(np.abs(_quotients(K, shapes)), kind="stable")[result.shape[1] :]
    others = shapes[:, np.sort(order)]
    others = others - result @ (result.T @ (M @ others))
    others = others / np.sqrt(np.einsum("ik,ik->k", others, M @ others))
    own = _quotients(K, others)[:, None]
    mixed = others.T @ stiff / own
    if stiff.any():
        turn = np.linalg.eigh(result.T @ stiff - mixed.T @ (own * mixed))[1]
        result, stiff, damped, mixed = result @ turn, stiff @ turn, damped @ turn, mixed @ turn
    supports = np.array([np.einsum("ik,ik->k", result, part) for part in (stiff, damped)])
    supports[0] -= (own * mixed**2).sum(axis=0)
    return np.hstack([result - others @ mixed, others + result @ mixed.T]), supports


def _tridiagonal_vectors(matrix: scipy.sparse.csr_array) -> np.ndarray | None:
    """The eigenvectors of a symmetric matrix that is tridiagonal in some order; None of any other."""
    order = scipy.sparse.csgraph.reverse_cuthill_mckee(matrix, symmetric_mode=True)
    narrow = matrix[order][:, order].tocoo()
    if len(order) <= 2 or np.abs(narrow.row - narrow.col).max(initial=0) > 1:
        return None
    result = np.empty(matrix.shape)
    result[order] = scipy.linalg.eigh_tridiagonal(narrow.diagonal(), narrow.diagonal(1))[1]
    return result


def _quotients(K: Matrix, shapes: np.ndarray) -> np.ndarray:
    """phi^T K phi for every column."""
    K = (K + K.T) / 2
    row, column, values = entries(K)
    upper = row < column
    if np.count_nonzero(upper) > FEW * len(shapes):
        return np.einsum("ik,ik->k", shapes, K @ shapes)
    sums, row, column = exact_row_sums(K), row[upper], column[upper]
    return sums @ shapes**2 - values[upper] @ (shapes[row] - shapes[column]) ** 2
