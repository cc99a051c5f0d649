"""The minimal realization of a polynomial matrix H_0 + H_1 s + ... = C (I - s J)^-1 B with nilpotent J.

The block Hankel matrix of H_0, H_1, ... factors into observability times reachability (Ho and Kalman). Its
rank and the kernels of the powers of J are known from the structure at infinity: no rank is guessed here.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from ..errors import IllConditioned


def minimal_nilpotent(terms: list[np.ndarray], chains: tuple[int, ...]):
    """(C, J, B) with C J^i B = H_i for the given terms H_0, H_1, ..., J strictly upper triangular, of these chain lengths.

    Raises:
        IllConditioned: the smallest of the terms is lost beside the largest.
    """
    r, size = len(terms[0]), sum(chains)
    if size == 0:
        return np.zeros((r, 0)), np.zeros((0, 0)), np.zeros((0, r))
    u, values, vt = scipy.linalg.svd(_hankel(terms, 0))
    if not values[size - 1]:
        raise IllConditioned("the polynomial part of A(s)^-1 spans more orders of magnitude than float64 can hold")
    root = np.sqrt(values[:size])
    observe, reach = u[:, :size] * root, root[:, None] * vt[:size]
    J = (u[:, :size] / root).T @ _hankel(terms, 1) @ (vt[:size].T / root)
    turn = _triangular_basis(J, chains)
    return observe[:r] @ turn, np.triu(turn.T @ J @ turn, 1), turn.T @ reach[:, :r]


def _hankel(terms, shift) -> np.ndarray:
    """The block matrix with H_(i + j + shift) at (i, j), zero beyond the last term."""
    depth, zero = len(terms), np.zeros_like(terms[0])
    padded = list(terms) + [zero] * (depth + shift)
    return np.block([[padded[i + j + shift] for j in range(depth)] for i in range(depth)])


def _triangular_basis(J, chains) -> np.ndarray:
    """Orthogonal basis adapted to ker J < ker J^2 < ..., in which a nilpotent J is strictly upper triangular."""
    size = len(J)
    basis, power = np.zeros((size, 0)), np.eye(size)
    for depth in range(1, max(chains) + 1):
        power = power @ J
        dimension = sum(min(depth, chain) for chain in chains)
        kernel = scipy.linalg.svd(power)[2][size - dimension :].T
        fresh = kernel - basis @ (basis.T @ kernel)
        new = dimension - basis.shape[1]
        basis = np.hstack([basis, scipy.linalg.svd(fresh, full_matrices=False)[0][:, :new]])
    return basis
