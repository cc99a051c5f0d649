"""The constraint rows of a sparse system, gathered as one sparse matrix A with A x = b and a name for each row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse

from ...errors import InputError
from ..constraint import Constraint
from .matrices import checked_entries


@dataclass(frozen=True)
class HeldRows:
    """A x = b for k rows.

    Attributes:
        matrix: A, shape (k, n), compressed by rows.
        values: b, shape (k,).
        names: one for each row.
    """

    matrix: scipy.sparse.csr_array
    values: np.ndarray
    names: tuple[str, ...]


def held_rows(constraints, size: int) -> HeldRows:
    """All rows of constraints, or of sparse matrices of rows that are held at zero, at position level.

    Raises:
        InputError: rows of another length, at another level, names used twice, anything that is no constraint.
    """
    parts, values, names = [], [], []
    for item in _items(constraints):
        rows = checked_entries(item.rows if isinstance(item, Constraint) else item, "constraint rows")
        if rows.shape[1] != size:
            raise InputError(
                f"constraint rows: found {rows.shape[1]} entries in a row; expected one for each of the {size} coordinates"
            )
        first, count = len(names), rows.shape[0]
        given = item.names if isinstance(item, Constraint) else None
        names += given or [f"constraint {first + i + 1}" for i in range(count)]
        values.append(item.values if isinstance(item, Constraint) else np.zeros(count))
        parts.append(scipy.sparse.csr_array(rows))
    if len(set(names)) < len(names):
        seen: set[str] = set()
        repeated = next(name for name in names if name in seen or seen.add(name))
        raise InputError(f'constraint rows: the name "{repeated}" is used twice; names must differ')
    matrix = scipy.sparse.vstack(parts, format="csr") if parts else scipy.sparse.csr_array((0, size))
    return HeldRows(scipy.sparse.csr_array(matrix), np.concatenate([np.zeros(0), *values]), tuple(names))


def _items(constraints) -> list:
    """Constraints and sparse matrices, one by one."""
    if constraints is None:
        return []
    if isinstance(constraints, Constraint) or scipy.sparse.issparse(constraints):
        constraints = [constraints]
    if isinstance(constraints, (str, bytes, np.ndarray)) or not isinstance(constraints, Sequence):
        raise InputError(
            f"constraints: found {type(constraints).__name__}; give a sparse matrix of rows that are held at zero, or a list of "
            "mb.Constraint(rows, ...)"
        )
    for item in constraints:
        if not (isinstance(item, Constraint) or scipy.sparse.issparse(item)):
            raise InputError(f"constraints: found {type(item).__name__}; make each with mb.Constraint(rows, ...)")
        if isinstance(item, Constraint) and item.level != "position":
            raise InputError(
                f"constraints: found a row at {item.level} level; large sparse systems hold rows at position level only, as drift "
                "is no motion of the bodies; say level='position', or give arrays"
            )
    return list(constraints)
