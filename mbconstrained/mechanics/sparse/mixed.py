"""Undamped shapes and what damping mixes into them: all damped modes from the one real factorization that found the shapes.

P(s) = s^2 M + s C + K is projected on [X, Y]: X the undamped shapes, Y = (K - shift M)^-1 C X without its part along X, which is
to first order in C all that the modes have besides X. Each mode is then corrected outside of X with the same factors,
x <- x - (K - shift M)^-1 P(s) x, which leaves of an error along a shape of frequency w_j about |s|^2 / w_j^2 each time (one step of
Davidson's method, for quadratic pencils: Sleijpen, Booten, Fokkema and van der Vorst 1996).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ...errors import IllConditioned
from ...tolerances import EPS
from .matrices import times
from .pencil import ReducedPencil
from .undamped import UndampedModes

#: Directions that are this part of the others in the square of the energy norm are left out: rounding made them.
DEPENDENT = EPS**0.75


@dataclass(frozen=True)
class MixedSpace:
    """The space of [X, Y] with X^T M X = I, X^T K X = diag(w^2), X^T M Y = 0 and Y^T (K - shift M) Y a multiple of I.

    Attributes:
        shapes: X, shape (r, m).
        mixed: Y, shape (r, k).
        mass, damping, stiffness: M, C and K on it, shape (m + k, m + k).
    """

    shapes: np.ndarray
    mixed: np.ndarray
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray

    def slope(self, s: complex, x: np.ndarray) -> np.ndarray:
        """(2 s M + C) x."""
        return self.damping @ x + 2 * s * (self.mass @ x)

    def factors(self, s: complex) -> _Factors:
        """The factors of P(s).

        Raises:
            IllConditioned: P(s) is singular.
        """
        return _Factors(self.stiffness + s * (self.damping + s * self.mass))


class _Factors:
    def __init__(self, matrix):
        self.lower_upper = scipy.linalg.lu_factor(matrix, check_finite=False)
        if not np.diag(self.lower_upper[0]).all():
            raise IllConditioned("s^2 M + s C + K is singular")

    def solve(self, right: np.ndarray) -> np.ndarray:
        return scipy.linalg.lu_solve(self.lower_upper, right, check_finite=False)


def mixed_space(pencil: ReducedPencil, undamped: UndampedModes, moving: np.ndarray, forces: np.ndarray) -> MixedSpace:
    """The space for the moving ones of the undamped shapes.

    Args:
        forces: C X.
    """
    X, w2 = undamped.vectors[:, moving], undamped.values[moving]
    unit = float(np.abs(w2).max(initial=0.0)) ** 0.5 or 1.0  # the projected matrices are of one size then
    Y = unit * _caused(pencil, undamped, forces)
    damped = times(pencil.damping, Y)
    C = np.block([[X.T @ forces, X.T @ damped], [Y.T @ forces, Y.T @ damped]])
    M, K = (Y.T @ times(matrix, Y) for matrix in (pencil.mass, pencil.stiffness))
    return MixedSpace(X, Y, scipy.linalg.block_diag(np.eye(len(w2)), M), C, scipy.linalg.block_diag(np.diag(w2), K))


def _caused(pencil: ReducedPencil, undamped: UndampedModes, forces: np.ndarray) -> np.ndarray:
    """An orthonormal basis, in the energy of K - shift M, of what forces cause outside of the undamped shapes."""
    found = outside(pencil, undamped, forces[:, np.linalg.norm(forces, axis=0) > 0])
    for _ in range(2):  # once more, for what rounding left where directions are nearly dependent
        held = times(pencil.stiffness, found) - undamped.shift * times(pencil.mass, found)
        gram = found.T @ held
        lengths = np.maximum(np.diag(gram), np.finfo(float).tiny) ** 0.5
        squares, turn = scipy.linalg.eigh((gram + gram.T) / (2 * lengths * lengths[:, None]))
        new = squares > DEPENDENT * squares.max(initial=0.0)
        found = found @ (turn[:, new] / squares[new] ** 0.5 / lengths[:, None])
    return np.asfortranarray(found)


def outside(pencil: ReducedPencil, undamped: UndampedModes, forces: np.ndarray) -> np.ndarray:
    """(K - shift M)^-1 times real forces, without what drives the undamped shapes and without their part in the answer."""
    X = undamped.vectors
    found = undamped.factors.solve(forces - times(pencil.mass, X @ (X.T @ forces)))
    return found - X @ (X.T @ times(pencil.mass, found))
