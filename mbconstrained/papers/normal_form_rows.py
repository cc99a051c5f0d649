"""The rows X^T of the mechanical normal form by the formulas of Mayet: section 2 with appendix C, and section 3.

Views for comparison: they succeed for fewer systems than the method "extension" of ``mb.mechanical_normal_form``.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from ..ground.errors import InputError
from ..ground.tolerances import DEFECTIVE_CONDITION, PAIRED_EIGENVALUES, SINGULAR_CONDITION

#: Unknowns n^2 of the Kronecker system up to which it is solved; its singular values take n^6 operations.
MOST_UNKNOWNS = 1600

#: Combinations tried of the null space of the Kronecker system.
TRIES = 40

ADVICE = 'use method="extension", which finds a transformation wherever there is one'


def null_space_rows(A: np.ndarray, F: np.ndarray, driven: np.ndarray) -> np.ndarray:
    """X^T by Eqs. 9-14: X = U_B2 [U_K1, U_K2 Z], with Z from appendix C, corrected: the eigenvalues of G in pairs.

    A complex pair makes a column by itself (C.1), two different real eigenvalues make one (C.2, with the value
    (lambda_1 - lambda_2)/2). Real ones are paired across the middle of their order, which separates a multiple eigenvalue if
    anything among the real ones does.
    """
    A, B = np.linalg.solve(F, A), driven
    n, p = B.shape
    U_B = np.linalg.svd(B)[0] if p else np.eye(n)
    U_K = np.linalg.svd(U_B[:, p:].T @ A @ U_B[:, :p])[0] if p else np.eye(n)
    U_K1, U_K2 = U_B[:, p:] @ U_K[:, :p], U_B[:, p:] @ U_K[:, p:]
    X = np.hstack([U_K2 @ _appendix_c(U_K2.T @ A @ U_K2), U_K1])
    return np.linalg.solve(F.T, _unified(X.T, A, B).T).T


def kronecker_rows(A: np.ndarray, F: np.ndarray, B: np.ndarray) -> np.ndarray:
    """X^T by the linear system (15) for all entries of T, and (16) for a descriptor form, where F^T stands in place of F.

    The solution of least norm is regular by luck only. Combinations of it with the null space are tried, and the one with
    the least sum of cosines between its columns is chosen. It needs n^6 operations.
    """
    n, p = B.shape
    if n * n > MOST_UNKNOWNS:
        raise InputError(f'method: found "kronecker" for {n} states; its {n * n} unknowns take n^6 operations: {ADVICE}')
    upper, lower = np.eye(n // 2, n), np.eye(n // 2, n, k=n // 2)
    L = np.vstack([np.kron(A.T, upper) - np.kron(F.T, lower), np.kron(B.T, np.eye(n))])
    right = np.concatenate([np.zeros(n * n // 2), np.eye(n, p, k=p - n).ravel(order="F")])
    U, values, rows = np.linalg.svd(L)
    rank = n * n - (n // 2) * (n - 2 * p)  # the solutions have this dimension wherever rank [B, A B] = 2 p
    least = rows[:rank].T @ ((U[:, :rank].T @ right) / values[:rank])
    random, size = np.random.default_rng(n), max(1.0, float(np.linalg.norm(least)))
    tried = [least, *(least + size * rows[rank:].T @ random.standard_normal(len(rows) - rank) / n for _ in range(TRIES))]
    T = min((vector.reshape(n, n, order="F") for vector in tried), key=_cosines)
    if np.linalg.cond(T) > SINGULAR_CONDITION:
        raise InputError(f'method: found "kronecker", but every solution of the Kronecker system tried is singular; {ADVICE}')
    return T[: n // 2]


def _appendix_c(G) -> np.ndarray:
    """Z, shape (N, N/2), with Z^T G Z_perp regular."""
    values, vectors = scipy.linalg.eig(G)
    if len(G) and np.linalg.cond(vectors) > DEFECTIVE_CONDITION:
        raise InputError(
            f'method: found "null space", but G is defective and appendix C does not cover all Jordan blocks; {ADVICE}'
        )
    real = sorted(np.flatnonzero(values.imag == 0), key=lambda place: values[place].real)
    half = len(real) // 2
    left = np.linalg.inv(vectors).conj().T if len(G) else vectors  # columns: V^-T
    columns = [left[:, place].real for place in np.flatnonzero(values.imag > 0)]
    for one, other in zip(real[:half], real[half:]):
        if abs(values[one] - values[other]) <= PAIRED_EIGENVALUES * np.linalg.norm(G):
            raise InputError(
                f'method: found "null space", but G has the eigenvalue {values[one].real:.6g} too often to pair it with others; '
                f"Eq. 11 leaves out the transformations that mix U_K1 and U_K2, and appendix C those of such blocks; {ADVICE}"
            )
        columns.append(left[:, one].real / np.linalg.norm(left[:, one]) + left[:, other].real / np.linalg.norm(left[:, other]))
    return np.array(columns).T.reshape(len(G), len(G) // 2)


def _unified(rows, A, B) -> np.ndarray:
    """W_1 X^T with W_1 X^T A B = [0; I_p] (Eq. 14)."""
    p, inputs = B.shape[1], rows @ A @ B
    rest = np.linalg.svd(inputs)[0][:, p:] if p else np.eye(len(rows))
    return np.linalg.solve(np.hstack([rest, inputs]), rows)


def _cosines(T) -> float:
    """The paper's cost: the sum of the cosines between columns; infinite for a singular T."""
    if not np.isfinite(T).all() or np.linalg.cond(T) > SINGULAR_CONDITION:
        return np.inf
    unit = T / np.linalg.norm(T, axis=0)
    return float(np.abs(unit.T @ unit).sum())
