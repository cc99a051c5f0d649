"""Impacts of rigid contacts: Newton's law of restitution for all contacts that touch at one time, as a linear complementarity problem.

0 <= u+ + e u- complementary to p >= 0 with u+ = u- + W p, W the inverse effective masses of the contacts (Pfeiffer and Glocker,
Multibody Dynamics with Unilateral Contacts, 1996, chapter 8). Lemke's method solves it; for positive semidefinite W it ends in a solution
where there is one (Cottle, Pang and Stone, The Linear Complementarity Problem, 1992, section 4.4).
"""

from __future__ import annotations

import numpy as np

from ...ground.errors import NotUnique
from ...ground.tolerances import EPS

#: Most pivots by the number of contacts.
PIVOTS = 50


def impulses_of_contacts(W: np.ndarray, before: np.ndarray, restitution: np.ndarray) -> np.ndarray:
    """p >= 0 with W p + (1 + e) u- >= 0, complementary, shape (k,).

    Args:
        W: velocities u by unit impulses, shape (k, k).
        before: u-, shape (k,).
        restitution: e, shape (k,).

    Raises:
        NotUnique: there is no solution.

    >>> W, u = np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 0.0])  # a ball strikes one that touches a wall
    >>> impulses_of_contacts(W, u, np.zeros(2)).round(12).tolist()
    [0.666666666667, 0.333333333333]
    """
    return complementary(W, (1 + restitution) * before)


def complementary(M: np.ndarray, q: np.ndarray) -> np.ndarray:
    """z >= 0 with w = M z + q >= 0 and w z = 0, by Lemke's method with lexicographic ratios."""
    k = len(q)
    if (q >= 0).all():
        return np.zeros(k)
    if k == 1 and M[0, 0] > 0:
        return -q / M[0, 0]
    table = np.hstack([np.eye(k), -M, -np.ones((k, 1)), q[:, None]])  # w - M z - z0 = q
    right = np.hstack([q[:, None], np.eye(k)])
    basis = list(range(k))
    row = int(min(range(k), key=lambda i: tuple(right[i])))
    entering = 2 * k
    size = np.abs(table).max()
    for _ in range(PIVOTS * k):
        pivot = table[row, entering]
        factor = table[:, entering] / pivot
        factor[row] = 0.0
        own, its = table[row] / pivot, right[row] / pivot
        table, right = table - np.outer(factor, table[row]), right - np.outer(factor, right[row])
        table[row], right[row] = own, its
        leaving, basis[row] = basis[row], entering
        if leaving == 2 * k:
            z = np.zeros(2 * k + 1)
            z[basis] = table[:, -1]
            return np.maximum(z[k : 2 * k], 0.0)
        entering = leaving + k if leaving < k else leaving - k
        column = table[:, entering]
        candidates = np.flatnonzero(column > EPS * size * k)
        if not len(candidates):
            break
        row = int(min(candidates, key=lambda i: (*(right[i] / column[i]), basis[i] != 2 * k)))
        first = right[candidates, 0] / column[candidates]
        if 2 * k in basis:  # z0 leaves where it may
            place = basis.index(2 * k)
            if place in candidates and right[place, 0] / column[place] <= first.min() * (1 + EPS):
                row = place
    raise NotUnique(
        "the impulses of contacts that touch at one time have no solution; look for contacts that press against each other"
    )
