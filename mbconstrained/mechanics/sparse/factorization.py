"""K - s M of a constrained sparse pencil as L U: solutions, and how many of its eigenvalues lie below s.

SuperLU takes the pivots from the diagonal, in an order of minimum degree that is the same for rows and columns: P^T (K - s M) P
= L D L^T then, and the signs of D are those of the eigenvalues of K - s M (Sylvester). Whether it did, and whether the
factors are as good as the signs need, is checked: by the permutations, and by the residual of a solution. Rows that were
not eliminated enter by their Schur complement, whose signs are counted too (Haynsworth 1968).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse
from scipy.sparse.linalg import SuperLU, splu

from ...ground.errors import SingularPolynomialMatrix
from ...ground.tolerances import EPS, NOISE_SAFETY, PIVOT_RESIDUAL


@dataclass(frozen=True, eq=False)
class Factorization:
    """Solutions of [[P, L^T], [L, 0]] with P = K - s M.

    Attributes:
        lower_upper: SuperLU's factors of P.
        negative: number of eigenvalues of the pencil below s; None where it could not be counted.
        reach: P^-1 L^T, shape (r, k); None without rows.
        schur: the factors of L P^-1 L^T.
        rows: L.
    """

    lower_upper: SuperLU
    negative: int | None
    reach: np.ndarray | None = None
    schur: tuple | None = None
    rows: scipy.sparse.csr_array | None = None

    def solve(self, right: np.ndarray) -> np.ndarray:
        """x in the null space of L with P x = right up to forces of the rows, for one or several right sides."""
        solution = self.lower_upper.solve(np.asfortranarray(right))
        if self.rows is None:
            return solution
        return solution - self.reach @ scipy.linalg.lu_solve(self.schur, self.rows @ solution)


def factorize(matrix: scipy.sparse.csc_array, rows: scipy.sparse.csr_array, describe, counted: bool = True) -> Factorization:
    """Factorize a symmetric matrix (real or complex) bordered by sparse rows."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", scipy.sparse.SparseEfficiencyWarning)
            factors = splu(
                scipy.sparse.csc_array(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
    except RuntimeError:
        raise _singular(matrix, describe) from None
    negative = _negative(matrix, factors) if counted else None
    if not rows.shape[0]:
        return Factorization(factors, negative)
    reach = factors.solve(np.asfortranarray(rows.T.toarray().astype(matrix.dtype)))
    schur = rows @ reach
    if negative is not None:
        signs = np.linalg.eigvalsh((schur + schur.T) / 2)
        negative += int((signs > 0).sum()) - rows.shape[0]
    return Factorization(factors, negative, reach, scipy.linalg.lu_factor(schur), rows)


def _negative(matrix, factors) -> int | None:
    """The number of negative eigenvalues of the matrix, None where the pivots are not accurate enough."""
    if not np.array_equal(factors.perm_r, factors.perm_c):
        return None
    pivots = factors.U.diagonal()
    probe = np.where(np.arange(matrix.shape[0]) % 2, 1.0, -0.75)
    solution = factors.solve(probe)
    size = abs(matrix) @ np.abs(solution) + np.abs(probe)
    if not np.isfinite(solution).all() or (np.abs(matrix @ solution - probe) > PIVOT_RESIDUAL * size).any():
        return None
    return int((pivots < 0).sum())


def _singular(matrix, describe) -> SingularPolynomialMatrix:
    """The error for coordinates with neither mass nor stiffness, from the pivots of a slightly changed matrix."""
    size = abs(matrix.diagonal())
    added = NOISE_SAFETY * EPS * np.where(size > 0, size, size.max(initial=0.0) or 1.0)
    changed = scipy.sparse.csc_array(matrix + scipy.sparse.diags_array(added))
    factors = splu(changed, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    pivots = np.abs(factors.U.diagonal())[factors.perm_c]
    loose = np.flatnonzero(pivots <= NOISE_SAFETY * added)
    named = describe(loose[:3]) if len(loose) else "some coordinates"
    return SingularPolynomialMatrix(
        f"{named}{f' and {len(loose) - 3} more' if len(loose) > 3 else ''} have neither mass nor stiffness: the modes are not "
        "determined; give them mass or stiffness (a damper alone does not do), or tie them by a constraint",
        coordinates=tuple(map(int, loose)),
    )
