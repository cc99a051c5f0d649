"""The exact motion of a mechanical system, in multiplier form: [M s^2 + C s + K, -A^T; A s^level, 0] [x; lambda] = [f; b].

It has the motions of the constrained form and needs no null space, whose entries are rounded: masses, springs and rows enter
as they are, and the multipliers come along.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..exact.enclosure import ExactResponse, sources_of
from ..exact.rational import RationalMatrix, regular
from ..polynomial.matrix import PolynomialMatrix
from ..signals.inputs import step

if TYPE_CHECKING:
    from .motion import Motion


def exact_motion(motion: Motion) -> ExactResponse:
    """x of the motion, n rows; the k rows below them, which are not asked for, are its multipliers.

    Raises:
        SingularPolynomialMatrix: taken exactly, the data determine no motion.
    """
    n, k = motion.system.size, len(motion.system.rows)
    start = np.hstack([motion.initial, np.zeros((len(motion.initial), k))])
    force = motion.applied.mapped(np.eye(n + k)[:, :n])
    values = np.array([row.value for row in motion.system.rows])
    if values.any():
        force = force + step(np.append(np.zeros(n), values))
    return ExactResponse(_regular_form(motion.system), start, sources_of(force), range(n))


def _regular_form(system) -> RationalMatrix:
    equations = [*(f"motion of {name}" for name in system.names), *(f"constraint {row.name}" for row in system.rows)]
    coordinates = [*system.names, *(f"force of {row.name}" for row in system.rows)]
    return regular(RationalMatrix(_multiplier_form(system)), equations, coordinates)


def _multiplier_form(system) -> list[list[list]]:
    """Nested lists of exact numbers, for s^0, s^1, s^2."""
    n, A = system.size, system.constraint_matrix.astype(object)
    k = len(A)
    found = []
    for power, matrix in enumerate(PolynomialMatrix(system.given).exact_coefficients):
        whole = np.zeros((n + k, n + k), dtype=object)
        whole[:n, :n] = matrix
        if power == 0:
            whole[:n, n:] = -A.T
        held = [i for i, row in enumerate(system.rows) if row.order == power]
        whole[[n + i for i in held], :n] = A[held]
        found.append(whole.tolist())
    return found
