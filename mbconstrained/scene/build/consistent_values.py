"""Consistent initial values: those not given follow from the constraint rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...ground.errors import InputError
from ...ground.tolerances import CONSISTENT_ROWS
from ...linalg.scaling import equilibration
from ..file.messages import at, shown
from ..quantities.coordinates import DERIVATIVES, Coordinates

if TYPE_CHECKING:
    from ...mechanics.system import MechanicalSystem


def consistent_values(
    initial: np.ndarray, table, system: MechanicalSystem | None, coordinates: Coordinates, file_name: str
) -> np.ndarray:
    """The values at 0-, those omitted from the [initial] table chosen so that the constraint rows hold.

    Rows A x^(level) = b at position level hold for positions, and with the derivative of b for velocities (0 where b is constant),
    where those at velocity level join them. Omitted values remain 0 where the rows hold with 0, and in coordinates of no row.
    """
    if system is None or not system.rows:
        with at(file_name, "initial.follow"):
            raise InputError("there are no constraint rows from which values could follow; leave it out")
    values = initial.copy()
    for order, row in enumerate(initial):
        given = table.rows[order] if order < len(table.rows) else {}
        known = np.array([name in given for name in coordinates.names])
        with at(file_name, f"initial.{DERIVATIVES[order]}"):
            values[order] = _completed(row, known, system, order, coordinates.names)
    return values


def _completed(values: np.ndarray, known: np.ndarray, system: MechanicalSystem, order: int, names) -> np.ndarray:
    chosen = [i for i, row in enumerate(system.rows) if row.order <= order]
    A = system.constraint_matrix[chosen]
    b = np.array([system.rows[i].right_side(order)(0.0)[0] for i in chosen])
    if _holds(A, values, b).all():
        return values
    free = np.flatnonzero(~known & A.any(axis=0))
    result = values.copy()
    result[free] = _solved(A[:, free], b - A @ values, [names[i] for i in free])
    satisfied = _holds(A, result, b)
    if not satisfied.all():
        worst = system.rows[chosen[int(np.argmin(satisfied))]].name
        raise InputError(f"the given values contradict the constraint row {shown(worst)}; leave out one of them, or follow")
    return result


def _holds(A: np.ndarray, x: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Whether each row of A x = b holds but for rounding error, in units in which the entries of A are of one size."""
    _, columns = _scales(A)
    size = np.abs(A * columns).max(axis=1, initial=0.0) * np.abs(x / columns).max(initial=0.0)
    return np.abs(A @ x - b) <= CONSISTENT_ROWS * (size + np.abs(b))


def _scales(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return equilibration(np.abs(A)) if A.size else (np.ones(A.shape[0]), np.ones(A.shape[1]))


def _solved(A: np.ndarray, b: np.ndarray, names: list[str]) -> np.ndarray:
    """The least-squares solution of A x = b."""
    rows, columns = _scales(A)
    u, s, vt = np.linalg.svd(rows[:, None] * A * columns)
    rank = int((s > CONSISTENT_ROWS * s.max(initial=0.0)).sum())
    null = vt[rank:]
    loose = [name for name, column in zip(names, null.T) if np.abs(column).max(initial=0.0) > CONSISTENT_ROWS]
    if loose:
        many = f"{len(null)} of them" if len(null) > 1 else "one of them"
        raise InputError(f"the constraint rows leave {', '.join(map(shown, loose))} open; give {many} a value")
    return columns * (vt[:rank].T @ ((u[:, :rank].T @ (rows * b)) / s[:rank]))
