"""Motions that no spring holds back where every row has stiffness: free bodies, mechanisms, what only dampers hold.

Rows v with v K = 0 make equations v A(s) = s (v C + s v M) without stiffness: v M x' + v C x is conserved, and where v C = 0 too,
v M x grows with it (the momentum and the centre of mass of a free body). They take the places of as many equations, after which the
zeros at s = 0 are those of rows without stiffness (``polynomial.conserved``), exactly. How many there are is a decision on
rank (Businger and Golub 1965, QR with pivots), made only where it is clear: what is dropped is rounding, what is kept is far above.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..linalg.kinds import Matrix, full
from ..linalg.scaling import equilibration
from ..linalg.sparse import without_noise
from ..tolerances import EPS, noise_of

#: The smallest number that counts as not zero is this part of the largest: what lies between it and rounding decides nothing.
LEAST_KEPT = EPS**0.5

#: Entries this near to whole numbers may be meant to be these, which is tried.
NEARLY_WHOLE = EPS**0.5


@dataclass(frozen=True)
class Freed:
    """The same equations, some of them replaced by such sums of all that have no stiffness.

    Attributes:
        M, C, K: their coefficients, M of shape (m, m), C and K of (m + d, m + d).
        sums: the rows v, shape (k, m + d).
    """

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    sums: np.ndarray


def freed(M: Matrix, C: Matrix, K: Matrix) -> Freed | None:
    """The equations with those of free motions among them; None where there are none, or that is not clear.

    >>> freed(np.eye(2), np.zeros((2, 2)), np.array([[1.0, -1.0], [-1.0, 1.0]])).sums
    array([[1., 1.]])
    """
    m, (M, C, K) = M.shape[0], (full(matrix).copy() for matrix in (M, C, K))
    found = null_rows(K)
    if found is None or not len(found[0]):
        return None
    sums, places = found
    slowed = without_noise(sums @ C, np.abs(sums) @ np.abs(C))
    if slowed.any():  # sums of the sums that no damper holds back either, in the places of some
        within = null_rows(slowed) if len(sums) > 1 else (np.zeros((0, 1)), np.zeros(0, dtype=int))
        if within is None:
            return None
        combined, chosen = within
        sums[chosen], slowed[chosen] = combined @ sums, 0.0
    heavy = np.abs(sums[:, :m]).any(axis=1)
    if (heavy & (places >= m)).any():  # an equation of first order has no place for a mass
        return None
    M[places[heavy]] = sums[heavy, :m] @ M
    C[places], K[places] = slowed, 0.0
    return Freed(M, C, K, sums)


def null_rows(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """All v with v A = 0, each 1 in a place where the others are 0, and these places; None where the rank is not clear.

    >>> null_rows(np.array([[2.0, -2.0], [-1.0, 1.0]]))[0]
    array([[0.5, 1. ]])
    """
    rows, columns = equilibration(np.abs(matrix))
    Q, R, _ = scipy.linalg.qr(rows[:, None] * matrix * columns, pivoting=True)
    sizes = np.zeros(len(matrix))
    sizes[: min(R.shape)] = np.linalg.norm(R[: min(R.shape)], axis=1)
    rank = int((sizes > noise_of(sizes.max(initial=0.0), len(matrix))).sum())
    if rank == len(matrix):
        return np.zeros((0, rank)), np.zeros(0, dtype=int)
    if rank and np.abs(np.diag(R)[:rank]).min() < LEAST_KEPT * sizes.max():
        return None
    space = Q[:, rank:].T
    places = np.sort(scipy.linalg.qr(space, mode="r", pivoting=True)[1][: len(space)])
    found = np.linalg.solve(space[:, places], space) * rows / rows[places][:, None]
    for sums in (_whole(found), found):
        if not without_noise(sums @ matrix, len(matrix) ** 0.5 * np.abs(sums) @ np.abs(matrix)).any():
            return sums, places
    return None


def _whole(found: np.ndarray) -> np.ndarray:
    """With the whole numbers that entries are near, zero among them: rounding may hide what was meant."""
    whole = np.rint(found)
    return np.where(np.abs(found - whole) <= NEARLY_WHOLE, whole, found)
