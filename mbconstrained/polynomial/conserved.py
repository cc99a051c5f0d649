"""Zeros at s = 0 that can be read off A(s): rows without stiffness, exactly.

A row i of M x'' + C x' + K x with K_i = 0 conserves p_i = M_i x' + C_i x, and one with C_i = 0 too lets q_i = M_i x grow with it,
q_i' = p_i: a free mass, the drift of a constraint at velocity or acceleration level. Of the states w these numbers are z = L w
with L S = J L, where J has blocks [0] and [[0, 1], [0, 0]] and nothing is rounded. They take the place of as many states, and the
others are decoupled from them by a linear equation: S has no more zeros at 0 where the matrix of the rows' lowest coefficients,
each of its power of s, is regular (``lowest``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..linalg.blocks import BlockDiagonal, block_diagonalize, block_matrix
from ..linalg.kinds import Matrix, filled_rows, full, others
from ..linalg.sparse import solution
from ..tolerances import DECOUPLING_LIMIT


@dataclass(frozen=True)
class Conserved:
    """The conserved numbers z = L w of the states w = (x_m, x_m', x_d).

    Attributes:
        rows: L, shape (k, n).
        blocks: of J.
        places: which states they replace, shape (k,).
    """

    rows: np.ndarray
    blocks: tuple[np.ndarray, ...]
    places: np.ndarray


def lowest(M: Matrix, C: Matrix, K: Matrix) -> tuple[Matrix, np.ndarray]:
    """Each row's lowest coefficient that is not zero, and its power of s, for M of shape (m, m), C and K of (m + d, m + d).

    >>> lowest(np.array([[5.0]]), np.zeros((2, 2)), np.array([[0.0, 0.0], [0.0, 3.0]]))[0].tolist()
    [[5.0, 0.0], [0.0, 3.0]]
    """
    stiff = filled_rows(K)
    if stiff.all():
        return K, np.zeros(len(stiff), dtype=int)
    powers = ~stiff * (2 - filled_rows(C))
    found, m = full(K).copy(), M.shape[0]
    slow, free = powers == 1, (powers == 2).nonzero()[0]
    found[slow] = full(C)[slow]
    found[free, :m] = full(M)[free]
    return found, powers


def conserved(M: Matrix, C: Matrix, rows: np.ndarray, powers: np.ndarray, pivots: np.ndarray) -> Conserved:
    """What rows without stiffness conserve.

    Args:
        M, C: coefficients of the equations.
        rows: which ones.
        powers: of s that they are divisible by, 1 or 2.
        pivots: a coordinate for each.
    """
    m, n = M.shape[0], M.shape[0] + C.shape[0]
    M, C = full(M), full(C)
    L, places, blocks = [], [], []
    for row, power, pivot in zip(rows.tolist(), powers.tolist(), pivots.tolist()):
        momentum, place = np.zeros(n), pivot if pivot < m else m + pivot
        if row < m:
            momentum[m : 2 * m] = M[row]
        if power == 1:
            momentum[:m], momentum[2 * m :] = C[row, :m], C[row, m:]
            L, places, blocks = [*L, momentum], [*places, place], [*blocks, np.zeros((1, 1))]
        else:
            L += [np.concatenate([M[row], np.zeros(n - m)]), momentum]
            places, blocks = [*places, place, m + pivot], [*blocks, np.array([[0.0, 1.0], [0.0, 0.0]])]
    return Conserved(np.array(L), tuple(blocks), np.array(places))


def decoupled_beside(
    S: np.ndarray, given: Conserved, decoupled: Callable[[np.ndarray, np.ndarray | None], BlockDiagonal]
) -> BlockDiagonal:
    """S decoupled, what is conserved last.

    Args:
        decoupled: does the same for a matrix without zeros at 0; told which states of S it is the part of, None where it is none.
    """
    L, n, J = given.rows, len(S), block_matrix(given.blocks)
    count, rest = n - len(L), others(n, given.places)
    basis, inverse = np.zeros((n, n)), np.zeros((n, n))
    basis[rest, range(count)] = inverse[range(count), rest] = 1.0
    basis[given.places] = solution(L[:, given.places], np.concatenate([-L[:, rest], np.eye(len(L))], axis=1))
    inverse[count:] = L
    moving = S[rest] @ basis  # [A, D] of the other states y' = A y + D z
    A, D = moving[:, :count], moving[:, count:]
    rows, own, is_part = inverse[:count], basis[:, count:], not np.count_nonzero(D)
    if not is_part:
        X = _separating(A, D, J)
        rows, own = rows - X @ L, own + basis[:, :count] @ X
    if not (np.abs(own) * np.abs(L.T)).sum(axis=0).max() <= DECOUPLING_LIMIT:
        return _by_clusters(A, D, J, basis, inverse)
    return _beside(decoupled(A, rest if is_part else None), basis[:, :count], rows, own, given)


def _separating(A: np.ndarray, D: np.ndarray, J: np.ndarray) -> np.ndarray:
    """X with A X - X J = -D, for J J = 0."""
    X = solution(A, -D)
    return X + solution(A, X @ J)


def _beside(parts: BlockDiagonal, basis, inverse, own, given: Conserved) -> BlockDiagonal:
    """The conserved numbers after the others; what grows with a momentum is measured in the others' unit of time."""
    rate = max((float(np.abs(block).max()) for block in parts.blocks), default=0.0)
    unit = float(2.0 ** np.rint(np.log2(rate))) if rate else 1.0
    units = np.concatenate([[1.0, unit][: len(block)] for block in given.blocks])
    return BlockDiagonal(
        np.concatenate([basis @ parts.basis, own * units], axis=1),
        np.concatenate([parts.inverse @ inverse, given.rows / units[:, None]]),
        (*parts.blocks, *(unit * block for block in given.blocks)),
        parts.coupling,
    )


def _by_clusters(A, D, J, basis, inverse) -> BlockDiagonal:
    """Where the two are hardly apart: by the Schur form of both, as far as this can be decoupled."""
    triangle, rotation = scipy.linalg.schur(A, output="real")
    turn = scipy.linalg.block_diag(rotation, np.eye(len(J)))
    found = block_diagonalize(np.block([[triangle, rotation.T @ D], [np.zeros(D.T.shape), J]]))
    return BlockDiagonal(basis @ turn @ found.basis, found.inverse @ turn.T @ inverse, found.blocks, found.coupling)
