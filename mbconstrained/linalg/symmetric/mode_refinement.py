"""Undamped modes refined: K Phi = M Phi diag(k), Phi^T M Phi = I, to rounding errors of each k, not of the largest.

A symmetric eigenproblem leaves errors of eps times the largest k in all others: of a beam of 30 elements nine digits of the slowest
motion. With S = X^T K X and R = I - X^T M X of approximate shapes X, computed with twice the digits, one step

k_j = S_jj / (1 - R_jj),    E_ij = (S_ij + k_j R_ij) / (k_j - k_i),    E_jj = R_jj / 2,    Phi = X (I + E)

squares the error (Ogita and Aishima 2018).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from ...ground.tolerances import EPS, LARGEST_CORRECTION, LAST_CORRECTION
from ..accurate_products import congruence

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
    which = connected_components(csr_array(mixed | mixed.T), directed=False)[1]
    for group in range(which.max() + 1):
        at = np.flatnonzero(which == group)
        if len(at) > 1:
            triangle = np.linalg.inv(np.linalg.cholesky(units[np.ix_(at, at)]))
            result[np.ix_(at, at)] = triangle.T @ np.linalg.eigh(triangle @ S[np.ix_(at, at)] @ triangle.T)[1]
    return result
