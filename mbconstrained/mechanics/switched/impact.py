"""Impacts of rigid contacts: Newton's law of restitution for all contacts that touch at one time, as a linear complementarity problem.

0 <= u+ + e u- complementary to p >= 0 with u+ = u- + W p, W the inverse effective masses of the contacts (Pfeiffer and Glocker,
Multibody Dynamics with Unilateral Contacts, 1996, chapter 8). Lemke's method solves it; for positive semidefinite W it ends in a solution
where there is one (Cottle, Pang and Stone, The Linear Complementarity Problem, 1992, section 4.4).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...ground.errors import NotUnique
from ...ground.tolerances import EPS
from .flow import NOISE

if TYPE_CHECKING:
    from ..system import MechanicalSystem
    from .phase import Phase
    from .switches import UnilateralContact

#: Contacts depend on each other where the least eigenvalue of their scaled mobility is below this part of the largest, by number.
DEPENDENT = 16 * NOISE

#: Most pivots by the number of contacts.
PIVOTS = 50


class ContactSet:
    """Rigid contacts that touch, and what their impulses do to a phase without them, in which bounded forces slip."""

    def __init__(self, phase: Phase, contacts: Sequence[UnilateralContact]):
        self.phase = phase
        self.massless = [phase.has_massless(contact.row) for contact in contacts]
        self.rows = np.array([contact.row for contact in contacts])
        self.restitution = np.array([contact.restitution for contact in contacts])
        #: Of the states and of the velocities along the contacts to unit impulses.
        self.response = np.array([phase.impulse_response(contact.row) for contact in contacts]).T
        self.mobility = self.rows @ phase.V @ self.response

    @cached_property
    def is_dependent(self) -> bool:
        """Whether impulses of the contacts are not unique."""
        scale = np.sqrt(np.maximum(np.diag(self.mobility), np.finfo(float).tiny))
        values = np.linalg.eigvalsh(self.mobility / scale / scale[:, None])
        return bool(values[0] <= DEPENDENT * len(values) * values[-1])

    def solve(self, before: np.ndarray, restitution: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The impulses of contacts, and which are at rest afterwards, from their velocities before, whose terms have the moduli ``size``."""
        p = impulses_of_contacts(self.mobility, before, restitution)
        p[p <= 4 * EPS * p.max(initial=0.0)] = 0.0
        after = before + self.mobility @ p
        noise = NOISE * (size + np.abs(self.mobility) @ p)
        return p, np.where(p > 0, restitution * before == 0, np.abs(after) <= noise)

    def row_impulses(self, p: np.ndarray, moved: np.ndarray, gained: np.ndarray) -> dict[str, float]:
        """The impulses of the constraint rows of the phase, by name, from the changes of x and x'."""
        return row_impulses(self.phase.system, self.rows.T @ p, moved, gained)

    def derivative(self, restitution: np.ndarray, p: np.ndarray) -> np.ndarray:
        """The derivative of (x, x') after the impact with respect to those before it."""
        n = self.phase.system.size
        total, own = np.eye(2 * n), np.flatnonzero(p > 0)
        if len(own):
            by = np.linalg.solve(self.mobility[np.ix_(own, own)], (1 + restitution[own])[:, None] * self.rows[own])
            total[:, n:] -= self.phase.outputs @ self.response[:, own] @ by
        return total


def row_impulses(system: MechanicalSystem, other: np.ndarray, moved: np.ndarray, gained: np.ndarray) -> dict[str, float]:
    """The impulses of the constraint rows of a system that are more than rounding errors, next to other ones, from the changes of x and x'."""
    if not system.rows:
        return {}
    terms = [system.mass @ gained, system.damping @ moved, -other]
    total = system.multiplier_map @ sum(terms)
    noise = 16 * NOISE * (np.abs(system.multiplier_map) @ sum(map(np.abs, terms)))
    return {row.name: float(own) for row, own, least in zip(system.rows, total, noise) if abs(own) > least}


def impulses_of_contacts(W: np.ndarray, before: np.ndarray, restitution: np.ndarray) -> np.ndarray:
    """p >= 0 with W p + (1 + e) u- >= 0, complementary, shape (k,), from W, velocities by unit impulses; NotUnique where there is none.

    >>> W, u = np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 0.0])  # a ball meets one that touches a wall
    >>> impulses_of_contacts(W, u, np.zeros(2)).round(12).tolist()
    [0.666666666667, 0.333333333333]
    """
    return complementary(W, before + restitution * before)  # 1 + e would be rounded in all impacts alike


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
