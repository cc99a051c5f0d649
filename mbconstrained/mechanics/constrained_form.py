"""The constrained form [V^T (M s^2 + C s + K); A s^level] x = [V^T f; b]: as many equations as coordinates.

V is a basis of null(A): multiplied by V^T the equations of motion lose the constraint forces A^T lambda, and
the constraint rows take the freed places (Antoniou et al. 2016; Moysis et al., Eqs. 79-82). M may be singular.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..ground.checks import counted
from ..ground.display import Displayed
from ..ground.errors import IllConditioned, NotUnique
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import ASSEMBLED_SPREAD, DOUBTFUL_SUM, EPS, LARGEST_SPREAD
from ..linalg.arrays import block_diag, full, kept
from ..linalg.precise import is_worthwhile
from ..linalg.rank import Noisy, null_columns
from ..linalg.scaling import equilibration
from ..polynomial.coefficients import Factors
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.inputs import ImpulsiveSmooth, step
from .constraints import IndependentRows, right_sides
from .element_matrix import ElementMatrix


@dataclass(frozen=True, repr=False, eq=False)
class ConstrainedForm(Displayed):
    """The constrained equations of a system with n coordinates and k independent constraint rows.

    Attributes:
        null_space: V, shape (n, n - k).
        rows: A, shape (k, n).
        values: the constant part of b, shape (k,).
        polynomial_matrix: [V^T (M s^2 + C s + K); A s^level], always of degree 2.
        notices: sums of entries of M, C, K that cancel almost.
        excitation: the part of b that varies in time, k rows; None where b is constant.
    """

    null_space: np.ndarray
    rows: np.ndarray
    values: np.ndarray
    polynomial_matrix: PolynomialMatrix
    notices: tuple[Notice, ...] = ()
    excitation: ImpulsiveSmooth | None = None

    def _summary(self) -> str:
        return f"{counted(len(self.null_space), 'coordinate')}, {counted(len(self.values), 'constraint row')}"

    def force(self, applied: ImpulsiveSmooth) -> ImpulsiveSmooth:
        """The right-hand side [V^T f; b] for t > 0 from f with n rows; a constant b is a step."""
        if not len(self.values):
            return applied
        padding = np.zeros((len(self.values), self.null_space.shape[0]))
        values = np.concatenate([np.zeros(self.null_space.shape[1]), self.values])
        is_zero = applied.is_zero and not applied.exact_inputs
        projected = applied if is_zero else applied.mapped(np.vstack([self.null_space.T, padding]))
        projected = projected + step(values) if values.any() else projected
        if self.excitation is None:
            return projected
        size = len(values)
        return projected + self.excitation.mapped(np.eye(size)[:, size - len(self.values) :])


def constrained_form(
    motion: Sequence[np.ndarray | ElementMatrix],
    uncertainty: Sequence[np.ndarray],
    independent: IndependentRows,
    names: Sequence[str],
    orders: Sequence[int],
) -> ConstrainedForm:
    """Stack the projected equations of motion and the constraint rows."""
    V, A = independent.null_space, independent.matrix
    spread = max((matrix.spread for matrix in motion[:2] if isinstance(matrix, ElementMatrix)), default=1.0)
    if spread > LARGEST_SPREAD:
        raise IllConditioned(
            f"the stiffest spring or damper is {spread:.3g} times the softest; a ratio above {LARGEST_SPREAD:g} cannot be solved: "
            "look for a wrong unit, or make the stiffest ones rigid ties"
        )
    # assembled, the softest element loses as many digits; where that is unavoidable, the evidence of the answer reports it
    by_elements = is_worthwhile(spread, 2 * len(names)) or spread > ASSEMBLED_SPREAD
    orders = np.array(orders, dtype=int)
    selected = [orders == power for power in range(len(motion))]
    doubts = np.zeros((V.shape[1], 0))
    if by_elements or not len(A):
        given = motion if by_elements else map(_assembled, motion)
        coefficients = [_stacked(matrix, V, A, rows) for matrix, rows in zip(given, selected)]
    else:
        projected, doubts = _projected(V, np.hstack([_assembled(matrix) for matrix in motion]))
        parts = [projected[:, begin : begin + len(V)] for begin in range(0, projected.shape[1], len(V))]
        coefficients = [np.vstack([part, A * rows[:, None]]) for part, rows in zip(parts, selected)]
    doubt = None
    if any(extra.any() for extra in (independent.uncertainty, *uncertainty)):
        doubt = [
            _stacked_uncertainty(matrix, extra, independent, rows) for matrix, extra, rows in zip(motion, uncertainty, selected)
        ]
    equations = [f"motion {i + 1}" if free is None else f"motion of {names[free]}" for i, free in enumerate(independent.motions)]
    equations += [f"constraint {row.name}" for row in independent.rows]
    values = np.array([row.value for row in independent.rows])
    matrix = PolynomialMatrix(coefficients, names, equations, doubt)
    are_doubtful = doubt is None and ((doubts >= DOUBTFUL_SUM[0]) & (doubts < DOUBTFUL_SUM[1])).any()
    notices = tuple(_cancelled(coefficients, doubts, equations, names)) if are_doubtful else ()
    return ConstrainedForm(V, A, values, matrix, notices, right_sides(independent.rows))


def _assembled(matrix: np.ndarray | ElementMatrix) -> np.ndarray:
    return matrix.matrix if isinstance(matrix, ElementMatrix) else matrix


def _stacked(matrix: np.ndarray | ElementMatrix, V, A, selected) -> np.ndarray | ElementMatrix | Factors:
    """[V^T matrix; the selected rows of A], as factors of a matrix given by its elements; the matrix itself without rows."""
    if not len(A):
        return matrix
    rows = A * selected[:, None]
    if not isinstance(matrix, ElementMatrix):
        return np.vstack([_projected(V, matrix)[0], rows])
    left = block_diag(_projected(V, matrix.directions.T)[0], np.eye(len(rows)))
    return Factors(left, np.concatenate([matrix.constants, np.ones(len(rows))]), np.vstack([matrix.directions, rows]))


def _stacked_uncertainty(matrix, uncertainty: np.ndarray, independent: IndependentRows, selected) -> np.ndarray:
    """The error bounds of the stacked matrix: V is as uncertain as the rows, dV = -G^T dA V with A G^T = I."""
    V, rows = np.abs(independent.null_space), independent.uncertainty
    bound = V.T @ uncertainty
    if rows.any():
        bound += (np.abs(independent.left_inverse).T @ rows @ V).T @ np.abs(_assembled(matrix))
    return np.vstack([bound, rows * selected[:, None]])


def _projected(V, matrix) -> tuple[np.ndarray, np.ndarray]:
    """V^T times the matrix; and its sums relative to the rounding errors of their terms where these decide, 0 elsewhere.

    Sums that cancel leave an exact zero, not rounding errors of their terms. Whole numbers in V are exact, and so are the entries of
    the matrix: where V has no others, what is left of a sum counts as long as it is more than the rounding errors of its terms. The
    equations of coordinates in no constraint row stay as they are.
    """
    alone = ((V != 0).sum(axis=0) == 1) & (V.max(axis=0, initial=0.0) == 1.0)
    whole = ~alone & (V == np.round(V)).all(axis=0)
    product, ratio = np.empty((V.shape[1], matrix.shape[1])), np.zeros((V.shape[1], matrix.shape[1]))
    product[alone] = matrix[V[:, alone].argmax(axis=0)]
    if (mixed := ~(alone | whole)).any():
        used = V[:, mixed].any(axis=1)
        product[mixed] = (Noisy.rounded(V[used][:, mixed].T) @ Noisy.rounded(matrix[used])).cleaned()
    if whole.any():
        rows, right = kept(V[:, whole].T), kept(matrix)
        sums = full(rows.astype(np.longdouble) @ right.astype(np.longdouble))
        share = np.abs(sums) / np.maximum(EPS * full(abs(rows) @ abs(right)), np.finfo(float).tiny)
        product[whole], ratio[whole] = np.where(share > 1.0, sums, 0.0), share
    return product, ratio


def _cancelled(coefficients, ratio, equations, names) -> Iterator[Notice]:
    """Notices on sums of entries of [K, C, M] that are left of their terms by little more, or hardly less, than their rounding."""
    for i, place in np.argwhere((ratio >= DOUBTFUL_SUM[0]) & (ratio < DOUBTFUL_SUM[1])):
        power, j = divmod(place, len(names))
        what = ("stiffness", "damping", "mass")[power]
        left = coefficients[power][i, j]
        outcome = f"{left:.3g} is kept" if left else "it counts as zero"
        text = (
            f"{what}: the constraints leave of the entries of {names[j]} in the equation {equations[i]} a sum that is "
            f"{ratio[i, place]:.2g} times the rounding errors of its terms; {outcome}; give the {what} as elements (ElementMatrix) if it is not"
        )
        yield Notice(NoticeKind.RANK, text, doubtful=True)


# The acceleration of a constrained system at a given state, and the test whether there is only one.


def explicit_acceleration(
    mass: np.ndarray, independent: IndependentRows, load: np.ndarray, values: np.ndarray, names: Sequence[str]
) -> np.ndarray:
    """x'' = [(I - A^+ A) M; A]^+ [Q; b], M possibly singular (Udwadia and Phohomsiri 2006).

    The columns of V span the range of I - A^+ A, so that the equations that the pseudo-inverse solves are those of
    [V^T M; A] x'' = [V^T Q; b]: n equations for n unknowns, whose rows and columns may be scaled freely. M alone and
    A alone decide whether there is one solution: rank [M; A] = n.
    """
    V, A = independent.null_space, independent.matrix
    stacked = np.vstack([(Noisy.rounded(V.T) @ Noisy.rounded(mass)).cleaned(), A])
    _check_unique(stacked, names)
    row_scale, column_scale = equilibration(np.abs(stacked))
    right = row_scale * np.concatenate([V.T @ load, values])
    return column_scale * np.linalg.solve(row_scale[:, None] * stacked * column_scale, right)


def _check_unique(stacked: np.ndarray, names: Sequence[str]) -> None:
    """The test rank [M; A] = n on [V^T M; A], which is equivalent for every positive semidefinite M."""
    columns, size = null_columns(Noisy.rounded(stacked)), len(names)
    rank = columns.decision.rank
    if rank == size:
        return
    left_open = columns.null.data.any(axis=0)
    free = ", ".join(f'"{name}"' for name, is_open in zip(names, left_open) if is_open)
    raise NotUnique(
        f"the acceleration of {free} is not determined: rank [M; A] = {rank}, with {size} coordinates; "
        "give them mass or constrain them, or use solve(), which computes the motion of massless "
        "coordinates from springs and dampers"
    )
