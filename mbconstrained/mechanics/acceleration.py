"""The acceleration of a constrained system at a given state, and the test whether there is only one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import NotUnique
from ..linalg.noise import Noisy
from ..linalg.rank import null_columns
from ..linalg.scaling import equilibration
from .independence import IndependentRows


def explicit_acceleration(
    mass: np.ndarray, independent: IndependentRows, load: np.ndarray, values: np.ndarray, names: Sequence[str]
) -> np.ndarray:
    """x'' = [(I - A^+ A) M; A]^+ [Q; b], M possibly singular (Udwadia and Phohomsiri 2006).

    The columns of V span the range of I - A^+ A, so that the equations that the pseudo-inverse solves are those of
    [V^T M; A] x'' = [V^T Q; b]: n equations for n unknowns, whose rows and columns may be scaled freely. M alone and
    A alone decide whether there is one solution: rank [M; A] = n.

    Args:
        mass: M, shape (n, n).
        independent: the rows A, shape (k, n), and the basis V of null(A).
        load: Q = f - C x' - K x, shape (n,).
        values: b, the value of A x'', shape (k,).
        names: of the coordinates.

    Returns:
        x'', shape (n,).

    Raises:
        NotUnique: rank [M; A] < n; names the coordinates whose acceleration is left open.
    """
    V, A = independent.null_space, independent.matrix
    stacked = np.vstack([(Noisy.rounded(V.T) @ Noisy.rounded(mass)).cleaned(), A])
    _check_unique(stacked, names)
    row_scale, column_scale = equilibration(np.abs(stacked))
    right = row_scale * np.concatenate([V.T @ load, values])
    return column_scale * np.linalg.solve(row_scale[:, None] * stacked * column_scale, right)


def _check_unique(stacked: np.ndarray, names: Sequence[str]) -> None:
    """The test rank [M; A] = n, made on [V^T M; A]: the same for every positive semidefinite M."""
    found, size = null_columns(Noisy.rounded(stacked)), len(names)
    rank = found.decision.rank
    if rank == size:
        return
    left_open = found.null.data.any(axis=0)
    free = ", ".join(f'"{name}"' for name, is_open in zip(names, left_open) if is_open)
    raise NotUnique(
        f"the acceleration of {free} is not determined: rank [M; A] = {rank}, with {size} coordinates; "
        "give them mass or hold them by constraint rows, or use solve(), which finds the motion of massless "
        "coordinates from springs and dampers"
    )
