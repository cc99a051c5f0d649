"""A start of which only some values are given: the others follow from the constraint rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..linalg.scaling import equilibration
from .problems import at
from .units import shown
from .values import DERIVATIVES, Coordinates

if TYPE_CHECKING:
    from ..mechanics import MechanicalSystem

#: Below this, relative to the rows after scaling, a singular value or a residual is rounding: rows come from geometry
#: that is known to 1e-12, and a mechanism this near to a dead centre is no longer told from one that stands in it.
RANK = 1e-9


def following(initial: np.ndarray, table, system: MechanicalSystem | None, coordinates: Coordinates, file_name: str) -> np.ndarray:
    """The values at 0-, with what the [initial] table leaves out chosen so that the rows hold.

    Of the rows A x^(level) = b those of position level hold for positions, and their derivatives with 0 for velocities,
    to which those of velocity level come. Where the rows hold with 0 for all that is left out, and in coordinates that
    are in none of these rows, 0 it is.

    Raises:
        SceneError: rows that the given values contradict, values that the rows leave open.
    """
    if system is None or not system.rows:
        with at(file_name, "initial.follow"):
            raise InputError("there are no constraint rows that anything could follow; leave it out")
    found = initial.copy()
    for order, row in enumerate(initial):
        given = table.rows[order] if order < len(table.rows) else {}
        known = np.array([name in given for name in coordinates.names])
        with at(file_name, f"initial.{DERIVATIVES[order]}"):
            found[order] = _followed(row, known, system, order, coordinates.names)
    return found


def _followed(values: np.ndarray, known: np.ndarray, system: MechanicalSystem, order: int, names) -> np.ndarray:
    chosen = [i for i, row in enumerate(system.rows) if row.order <= order]
    A = system.constraint_matrix[chosen]
    b = np.array([system.rows[i].value if system.rows[i].order == order else 0.0 for i in chosen])
    if _holds(A, values, b).all():
        return values
    free = np.flatnonzero(~known & A.any(axis=0))
    result = values.copy()
    result[free] = _solved(A[:, free], b - A @ values, [names[i] for i in free])
    held = _holds(A, result, b)
    if not held.all():
        worst = system.rows[chosen[int(np.argmin(held))]].name
        raise InputError(f"the given values contradict the constraint row {shown(worst)}; leave out one of them, or follow")
    return result


def _holds(A: np.ndarray, x: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Whether each row of A x = b does, but for rounding in units in which the entries of A are of one size."""
    _, columns = _scales(A)
    size = np.abs(A * columns).max(axis=1, initial=0.0) * np.abs(x / columns).max(initial=0.0)
    return np.abs(A @ x - b) <= RANK * (size + np.abs(b))


def _scales(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return equilibration(np.abs(A)) if A.size else (np.ones(A.shape[0]), np.ones(A.shape[1]))


def _solved(A: np.ndarray, b: np.ndarray, names: list[str]) -> np.ndarray:
    """x with A x = b as well as it can be.

    Raises:
        InputError: the rows leave entries of x open.
    """
    rows, columns = _scales(A)
    u, s, vt = np.linalg.svd(rows[:, None] * A * columns)
    rank = int((s > RANK * s.max(initial=0.0)).sum())
    null = vt[rank:]
    loose = [name for name, column in zip(names, null.T) if np.abs(column).max(initial=0.0) > RANK]
    if loose:
        many = f"{len(null)} of them" if len(null) > 1 else "one of them"
        raise InputError(f"the constraint rows leave {', '.join(map(shown, loose))} open; give {many} a value")
    return columns * (vt[:rank].T @ ((u[:, :rank].T @ (rows * b)) / s[:rank]))
