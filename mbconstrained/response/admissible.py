"""Do given values at 0- fit the equations? If not: which condition is violated, and what are the nearest that do.

Three sets of values lie in each other: those whose motion is continuous (condition (60) of Moysis et al. in its
corrected form), those without impulses (condition (58), with the force taken at 0+), and all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..polynomial.matrix import PolynomialMatrix
from ..signals.inputs import ImpulsiveSmooth
from .forcing import scaled_data
from .parts import inconsistency_of
from .solve import checked_force, checked_matrix, solve
from .violations import Violation, violations_of


@dataclass(frozen=True)
class Admissibility:
    """What a start at 0- leads to.

    Attributes:
        residuals: arrays (r,), one for each condition k = 1 ... q_hat_r of (58), the impulse of order k - 1 that the
            start causes; all zero where it is impulse-free.
        jump: x^(i)(0+) - x^(i)(0-), shape (q, r), the residual of (60); all zero where the start is continuous.
        violations: the algebraic conditions hidden in the equations that the start contradicts, each with the equations and
            coordinates involved and by how much (``.text`` is a sentence); empty where the start is continuous.
        nearest: values (q, r) without impulses, nearest to the start.
        nearest_continuous: values (q, r) without impulses and jumps, nearest to the start.
        dimensions: of the sets of continuous, of impulse-free and of all values, (n, r q - sum of q_hat_i, r q).
    """

    residuals: tuple[np.ndarray, ...]
    jump: np.ndarray
    violations: tuple[Violation, ...]
    nearest: np.ndarray
    nearest_continuous: np.ndarray
    dimensions: tuple[int, int, int]

    @property
    def is_impulse_free(self) -> bool:
        """True where no condition of (58) is violated."""
        return not any(residual.any() for residual in self.residuals)

    @property
    def is_continuous(self) -> bool:
        """True where (60), corrected, holds."""
        return self.is_impulse_free and not self.jump.any()


def admissible(A: PolynomialMatrix, initial=None, force: ImpulsiveSmooth | None = None) -> Admissibility:
    """Test values at 0- against (58) and (60) of Moysis et al., both as corrected: with f^(j)(0+), Toeplitz in (60).

    "Nearest" is the least sum of squares of the changes, each coordinate and derivative measured in the solver's own
    units (``linalg.scaling``), so that the answer does not depend on the user's.

    Args:
        A: the polynomial matrix, degree q, size r.
        initial: x^(i)(0-) as row i, shape (q, r); None for zeros.
        force: f with r rows; Dirac impulses of its own act whatever the start is and are left out here; None for zero.

    Raises:
        InputError, SingularPolynomialMatrix: as ``solve``.

    >>> A = PolynomialMatrix([[[1.0, -1.0], [-1.0, 1.0]], [[0, 0], [0, 0]], [[0, 0], [0, 1.0]]])  # a massless body on a spring
    >>> found = admissible(A, initial=[[1.0, 0.0], [0.0, 0.0]])
    >>> found.is_impulse_free, found.is_continuous, found.dimensions
    (True, False, (2, 4, 4))
    >>> (violation,) = found.violations
    >>> violation.equations, violation.coordinates, violation.amount
    ((('equation 1', 0),), (('x1', 0), ('x2', 0)), 1.0)
    """
    smooth = checked_force(force, checked_matrix(A).size).smooth
    start = solve(A, initial, ImpulsiveSmooth(smooth))
    form, structure = start.pairs.form, start.pairs.structure
    stack, f, size = scaled_data(form, start.initial, start.force)
    inconsistency = inconsistency_of(form, stack, f)
    g, to_g = size * inconsistency.data, form.infinite_start.data
    to_impulses = _impulse_map(form)
    zeros_at_infinity = sum(max(0, -order) for order in structure.at_infinity)
    residuals = (*start.impulses, *[np.zeros(A.size)] * structure.highest_impulse)[: structure.highest_impulse]
    return Admissibility(
        residuals=residuals,
        jump=start.jump,
        violations=violations_of(A, form, inconsistency, size, bool(start.impulses)) if start.jump.any() or start.impulses else (),
        nearest=start.initial + _least_change(form, to_impulses @ to_g, to_impulses @ g, zeros_at_infinity, A.degree),
        nearest_continuous=start.initial + _least_change(form, to_g, g, len(g), A.degree),
        dimensions=(structure.finite_count, A.size * A.degree - zeros_at_infinity, A.size * A.degree),
    )


def _impulse_map(form) -> np.ndarray:
    """The impulses, all orders stacked, as a linear map of the inconsistency g: -C2 N^(p + 1)."""
    rows, power = [np.zeros((0, len(form.nilpotent.data)))], np.eye(len(form.nilpotent.data))
    for _ in range(form.highest_impulse):
        power = power @ form.nilpotent.data
        rows.append(-form.C2.data @ power)
    return np.vstack(rows)


def _least_change(form, matrix, residual, rank, q) -> np.ndarray:
    """The least change of the values that makes matrix @ change = -residual, as rows (q, r) in the user's units.

    The rank of the matrix is known from the structure at infinity, so none is guessed.
    """
    scaling, r = form.companion.scaling, form.companion.size
    u, values, vt = np.linalg.svd(matrix, full_matrices=False)
    change = -vt[:rank].T @ ((u[:, :rank].T @ residual) / values[:rank])
    return scaling.columns * change.reshape(form.companion.grade, r)[:q] * scaling.time ** np.arange(q, dtype=float)[:, None]
