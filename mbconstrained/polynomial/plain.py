"""A(s) of degree two or less brought to first-order equations w' = S w + ... by its structure alone, no pencil formed.

Rows without a power of s hold coordinates to others: x = V x_f + Y g, g their right sides (a constraint at position level, a
massless joint without damper). Of the rest, rows with s^2 make accelerations of as many coordinates x_m, those without make
velocities of the others, x_d; the states are w = (x_m, x_m', x_d). Which row is of which kind is read off entries that are
exactly zero, and each part that is divided by must be well conditioned: where that does not hold, the staircase algorithm
(``linalg.staircase``) is the one to ask. For large models this takes milliseconds where that takes minutes, for small ones a part
of a millisecond. Zeros at s = 0 are those of rows without stiffness (``polynomial.conserved``), or of sums of
rows without (``polynomial.free_bodies``), or there are none.
"""

from __future__ import annotations

import numpy as np

from ..linalg.kinds import Matrix, filled_columns, filled_rows, full, kept
from ..linalg.sparse import condition
from .conserved import Conserved, conserved, lowest
from .elimination import MOST_CONDITION, eliminated, matching_rows, pivots_of, product
from .free_bodies import freed
from .matrix import PolynomialMatrix
from .reduction import FEW_STATES, Reduction

#: The rows' lowest coefficients may be conditioned so badly: beyond, a body may be free, which is for the rank decisions to say.
MOST_STIFFNESS_CONDITION = 1e10


def reduction_of(A: PolynomialMatrix) -> Reduction | None:
    """The reduction of A(s), None where its structure is not so plain or a part that has to be regular is not by far."""
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is not regular
        return _reduction_of(A)


def _reduction_of(A: PolynomialMatrix) -> Reduction | None:
    if not 1 <= A.degree <= 2 or A.uncertainty.any() or any(factors is not None for factors in A.factors):
        return None
    A0, A1, A2 = given = [kept(matrix) for matrix in A.coefficients] + [kept(np.zeros((A.size, A.size)))] * (2 - A.degree)
    rows, columns = A.coefficients[1:].any(axis=2), A.coefficients[1:].any(axis=1)
    slow, heavy = rows[0], rows[1] if A.degree == 2 else np.zeros(A.size, dtype=bool)
    algebraic, second, first = (kind.nonzero()[0] for kind in (~(slow | heavy), heavy, slow & ~heavy))
    moving = columns.any(axis=0)
    found = eliminated(A.coefficients[0][algebraic], static=~moving, like=A0)
    if found is None or len(second) + len(first) != found[0].shape[1]:
        return None
    V, Y, free, own = found
    M = product(A2[second], V)
    m, columns = len(second), filled_columns(M)
    if np.count_nonzero(columns) != m:
        return None
    if not columns[:m].all():  # coordinates with mass first
        order = np.argsort(~columns, kind="stable")
        V, free, M = V[:, order], free[order], M[:, order]
    matching = matching_rows(M[:, :m])
    if matching is None:
        return None
    second, M = second[matching], M[matching][:, :m]
    rest = np.concatenate([second, first])
    K, C = product(A0[rest], V), product(A1[rest], V)
    largest = max(own, condition(M), condition(C[m:, m:]) if len(first) else 1.0)
    if not largest <= MOST_CONDITION:  # a row may be left without anything
        return None
    floor, powers = lowest(M, C, K)
    if len(algebraic) and powers.any() and _is_doubtful(powers, A0[rest] @ V, A1[rest] @ V):
        return None
    equations, sums = (M, C, K), None
    if not _is_regular(floor):
        found = freed(M, C, K) if 2 * m + len(first) >= FEW_STATES else None
        if found is None:
            return None
        equations, sums = (found.M, found.C, found.K), found.sums
        floor, powers = lowest(*equations)
        if not _is_regular(floor):
            return None
    momenta = _conserved(*equations, full(floor), powers) if powers.any() else None
    return Reduction(given, algebraic, second, first, free, V, Y, M, C, K, moving, momenta, sums, largest)


def _is_regular(floor: Matrix) -> bool:
    return condition(floor, MOST_STIFFNESS_CONDITION) <= MOST_STIFFNESS_CONDITION


def _is_doubtful(powers: np.ndarray, K: Matrix, C: Matrix) -> bool:
    """Whether a row lacks stiffness or damping to rounding only: what was lost there the rank decisions have to say."""
    return bool(filled_rows(K)[powers > 0].any() or filled_rows(C)[powers > 1].any())


def _conserved(M, C, K, floor: np.ndarray, powers: np.ndarray) -> Conserved:
    """What rows without stiffness conserve, in the places of coordinates that nothing depends on where there are such."""
    rows = np.argsort(-powers, kind="stable")[: np.count_nonzero(powers)]  # rows of s^2 first: x_d is in none of them
    ignorable = ~filled_columns(K) & ~(filled_columns(C) & (powers.max() > 1))
    return conserved(M, C, rows, powers[rows], pivots_of(floor[rows], ignorable))
