"""A regular pencil s E - F with regular E as s I - T, T in real Schur form.

E^-1 F is never formed from an ill-conditioned E: next to fast zeros it has entries so large that the rounding
of its eigenvalues swamps the slow ones. The QZ algorithm works on the equilibrated pencil instead, where a
zero lambda suffers a relative error of about eps (|lambda| + 1 / |lambda|) in the pencil's own unit of time,
and only then the two triangular factors are divided.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from .scaling import equilibration


@dataclass(frozen=True)
class TriangularForm:
    """left (s E - F) right = s I - T, all of shape (n, n)."""

    left: np.ndarray
    right: np.ndarray
    T: np.ndarray


def triangular_form(E: np.ndarray, F: np.ndarray) -> TriangularForm:
    """Bring s E - F, E regular, to s I - T with T in standardized real Schur form."""
    n = len(E)
    if not n:
        return TriangularForm(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0)))
    rows, columns = equilibration(np.maximum(np.abs(E), np.abs(F)))
    S, P, Q, Z = scipy.linalg.qz(rows[:, None] * F * columns, rows[:, None] * E * columns, output="real")
    T = scipy.linalg.solve_triangular(P, S)
    left = scipy.linalg.solve_triangular(P, Q.T * rows)
    right = columns[:, None] * Z
    _standardize(T, S, left, right)
    return TriangularForm(left, right, T)


def _standardize(T, S, left, right) -> None:
    """Clear what the division left below the diagonal and give the 2 x 2 blocks equal diagonals, in place."""
    at = 0
    while at < len(T):
        if at + 1 < len(T) and S[at + 1, at] != 0:
            pair = slice(at, at + 2)
            block, turn = scipy.linalg.schur(T[pair, pair], output="real")
            T[pair] = turn.T @ T[pair]
            T[:, pair] = T[:, pair] @ turn
            T[pair, pair] = block
            left[pair] = turn.T @ left[pair]
            right[:, pair] = right[:, pair] @ turn
            at += 1
        at += 1
    keep = np.diag(T, -1).copy()
    T[np.tril_indices(len(T), -1)] = 0.0
    T[np.arange(1, len(T)), np.arange(len(T) - 1)] = np.where(np.diag(S, -1) != 0, keep, 0.0)
