"""The constrained form [V^T (M s^2 + C s + K); A s^level] x = [V^T f; b]: as many equations as coordinates.

V is a basis of null(A): multiplied by V^T the equations of motion lose the constraint forces A^T lambda, and
the constraint rows take the freed places (Antoniou et al. 2016; Moysis et al., Eqs. 79-82). M may be singular.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..errors import IllConditioned
from ..linalg.noise import Noisy
from ..linalg.precise import is_worthwhile
from ..polynomial.factors import Factors
from ..polynomial.matrix import PolynomialMatrix
from ..signals.inputs import ImpulsiveSmooth, step
from .element_matrix import ElementMatrix
from .independence import IndependentRows

#: Assembled in float64, elements that differ by more leave the softest fewer than four digits.
ASSEMBLED_SPREAD = 1e12

#: Springs or dampers that differ by more leave nothing of the softest even in precise arithmetic.
MOST_SPREAD = 1e40


@dataclass(frozen=True)
class ConstrainedForm:
    """The constrained equations of a system with n coordinates and k independent constraint rows.

    Attributes:
        null_space: V, shape (n, n - k).
        rows: A, shape (k, n).
        values: b, shape (k,).
        polynomial_matrix: [V^T (M s^2 + C s + K); A s^level], always of degree 2.
    """

    null_space: np.ndarray
    rows: np.ndarray
    values: np.ndarray
    polynomial_matrix: PolynomialMatrix

    def force(self, applied: ImpulsiveSmooth) -> ImpulsiveSmooth:
        """f with n rows -> [V^T f; b], b as a step: what stands on the right for t > 0."""
        if not len(self.values):
            return applied
        padding = np.zeros((len(self.values), self.null_space.shape[0]))
        held = np.concatenate([np.zeros(self.null_space.shape[1]), self.values])
        nothing = applied.is_zero and not applied.origins
        projected = applied if nothing else applied.mapped(np.vstack([self.null_space.T, padding]))
        return projected + step(held) if held.any() else projected


def constrained_form(
    motion: Sequence[np.ndarray | ElementMatrix],
    uncertainty: Sequence[np.ndarray],
    independent: IndependentRows,
    names: Sequence[str],
    orders: Sequence[int],
) -> ConstrainedForm:
    """Stack the projected equations of motion and the constraint rows.

    Args:
        motion: K, C, M, the coefficients of s^0, s^1, s^2, each of shape (n, n), assembled or as elements.
        uncertainty: by how much their entries may be wrong beyond rounding, each of shape (n, n).
        independent: the constraint rows and their null space.
        names: of the n coordinates.
        orders: for each row the derivative that it holds.
    """
    V, A = independent.null_space, independent.matrix
    spread = max((matrix.spread for matrix in motion[:2] if isinstance(matrix, ElementMatrix)), default=1.0)
    if spread > MOST_SPREAD:
        raise IllConditioned(
            f"the stiffest spring or damper is {spread:.3g} times the softest; a ratio above {MOST_SPREAD:g} cannot be solved: "
            "look for a wrong unit, or make the stiffest ones rigid ties"
        )
    # assembled, the softest element would lose as many digits; where it cannot be helped the answer has to say so
    apart = is_worthwhile(spread, 2 * len(names)) or spread > ASSEMBLED_SPREAD
    orders = np.array(orders, dtype=int)
    held = [orders == power for power in range(len(motion))]
    coefficients = _all_stacked([matrix if apart else _assembled(matrix) for matrix in motion], V, A, held)
    doubt = None
    if independent.uncertainty.any() or any(extra.any() for extra in uncertainty):
        doubt = [_stacked_uncertainty(matrix, extra, independent, rows) for matrix, extra, rows in zip(motion, uncertainty, held)]
    equations = [*_motion_names(independent.motions, names), *_row_names(independent.rows)]
    values = np.array([row.value for row in independent.rows])
    return ConstrainedForm(V, A, values, PolynomialMatrix(coefficients, names, equations, doubt))


def _assembled(matrix: np.ndarray | ElementMatrix) -> np.ndarray:
    return matrix.matrix if isinstance(matrix, ElementMatrix) else matrix


def _all_stacked(matrices, V, A, held) -> list[np.ndarray | ElementMatrix | Factors]:
    """Each with its rows; those that are assembled are projected together."""
    if not len(A) or any(isinstance(matrix, ElementMatrix) for matrix in matrices):
        return [_stacked(matrix, V, A, rows) for matrix, rows in zip(matrices, held)]
    projected, size = _projected(V, np.concatenate(matrices, axis=1)), len(V)
    parts = (projected[:, power * size : (power + 1) * size] for power in range(len(matrices)))
    return [np.concatenate([part, A * rows[:, None]]) for part, rows in zip(parts, held)]


def _stacked(matrix: np.ndarray | ElementMatrix, V, A, held) -> np.ndarray | ElementMatrix | Factors:
    """[V^T matrix; the held rows of A], as factors where the matrix is given by its elements; itself without rows, V = I."""
    if not len(A):
        return matrix
    rows = A * held[:, None]
    if not isinstance(matrix, ElementMatrix):
        return np.vstack([_projected(V, matrix), rows])
    left = scipy.linalg.block_diag(_projected(V, matrix.directions.T), np.eye(len(rows)))
    return Factors(left, np.concatenate([matrix.constants, np.ones(len(rows))]), np.vstack([matrix.directions, rows]))


def _stacked_uncertainty(matrix, uncertainty: np.ndarray, independent: IndependentRows, held) -> np.ndarray:
    """The same of what entries may be wrong by: V is as uncertain as the rows, dV = -G^T dA V with A G^T = I."""
    V, rows = np.abs(independent.null_space), independent.uncertainty
    found = V.T @ uncertainty
    if rows.any():
        found += (np.abs(independent.left_inverse).T @ rows @ V).T @ np.abs(_assembled(matrix))
    return np.vstack([found, rows * held[:, None]])


def _projected(V, matrix) -> np.ndarray:
    """V^T times the matrix; sums that cancel leave an exact zero, not the rounding of their terms.

    Coordinates that no row holds are free: their equations stay as they are.
    """
    alone = ((V != 0).sum(axis=0) == 1) & (V.max(axis=0, initial=0.0) == 1.0)
    found = np.empty((V.shape[1], matrix.shape[1]))
    found[alone] = matrix[V[:, alone].argmax(axis=0)]
    held = V[:, ~alone]
    used = held.any(axis=1)
    found[~alone] = (Noisy.rounded(held[used].T) @ Noisy.rounded(matrix[used])).cleaned()
    return found


def _motion_names(motions, names) -> list[str]:
    return [f"motion {i + 1}" if free is None else f"motion of {names[free]}" for i, free in enumerate(motions)]


def _row_names(rows) -> list[str]:
    return [f"constraint {row.name}" for row in rows]
