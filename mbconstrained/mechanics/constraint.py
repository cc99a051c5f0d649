"""Constraint rows A x^(level) = b: which combination of coordinates is held, in which derivative, at which value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.sparse

from ..checks import names_of, nearest, real_array
from ..errors import InputError
from ..linalg.kinds import full
from .units import check_unit

Level = Literal["position", "velocity", "acceleration"]

#: The levels, strongest first; the place of a level is the order of the derivative that it holds.
LEVELS: tuple[Level, ...] = ("position", "velocity", "acceleration")


class Constraint:
    """The rows A x^(level) = b of one constraint, b constant for t > 0.

    Args:
        rows: A, shape (k, n), or (n,) for a single row; kept sparse where it is ``scipy.sparse``.
        level: the derivative that is held: "position" A x = b, "velocity" A x' = b, or "acceleration" A x'' = b
            (the form of Udwadia and Phohomsiri 2006). The stronger level implies the weaker one with b = 0; a weaker
            level keeps what is wrong at the start, and adds drift zeros.
        value: b, a number or shape (k,).
        names: one name per row; made by the system when not given.
        unit: unit of A x, "m" or "rad" ("1" for none), so that multipliers get theirs. When not given it is the
            one of the coordinates in the row, metres where both kinds meet (a radius turns angles into lengths).
        uncertainty: by how much entries of A may be wrong, shape of the rows, where that is more than rounding.

    Raises:
        InputError: rows that are no matrix of finite real numbers, an unknown level, values that do not fit.

    >>> Constraint([1, -1, 0], level="velocity", value=0.5)
    Constraint(1 row at velocity level)
    """

    def __init__(
        self,
        rows,
        level: Level = "position",
        value=0.0,
        names: Sequence[str] | str | None = None,
        unit: str | None = None,
        uncertainty=None,
    ):
        found = _sparse_rows(rows) if scipy.sparse.issparse(rows) else real_array(rows, "constraint rows")
        if found.ndim not in (1, 2):
            raise InputError(f"constraint rows: expected one row or a matrix, found an array of shape {found.shape}")
        self.rows = found if scipy.sparse.issparse(found) else np.atleast_2d(found)
        self.level = checked_level(level, "constraint")
        values = real_array(value, "constraint value")
        if values.ndim > 1 or (values.ndim == 1 and len(values) != self.rows.shape[0]):
            raise InputError(
                f"constraint value: found shape {values.shape}; expected one number, or one for each of the {self.rows.shape[0]} rows"
            )
        self.values = values + np.zeros(self.rows.shape[0])
        if isinstance(names, str):
            names = (names,)
        self.names = None if names is None else names_of(names, self.rows.shape[0], "constraint rows", "")
        self.unit = unit if unit is None else check_unit(unit, "unit of the constraint")
        if uncertainty is None:
            self.uncertainty = abs(0.0 * self.rows)
        else:
            self.uncertainty = np.abs(np.atleast_2d(real_array(uncertainty, "constraint uncertainty", shape=found.shape)))
        self.values.flags.writeable = False
        if not scipy.sparse.issparse(self.rows):
            self.rows.flags.writeable = False

    def __repr__(self) -> str:
        count = self.rows.shape[0]
        return f"Constraint({count} row{'s' if count != 1 else ''} at {self.level} level)"


@dataclass(frozen=True)
class ConstraintRow:
    """One row a x^(level) = value of a system.

    Attributes:
        name: its name.
        coefficients: a, shape (n,).
        level: "position", "velocity" or "acceleration".
        value: the right-hand side.
        unit: unit of a x, "m", "rad" or "1".
        uncertainty: by how much entries of a may be wrong beyond rounding, shape (n,) or one number.
    """

    name: str
    coefficients: np.ndarray
    level: Level
    value: float
    unit: str
    uncertainty: np.ndarray | float = 0.0

    @property
    def order(self) -> int:
        """Order of the derivative that is held: 0, 1 or 2."""
        return LEVELS.index(self.level)


def checked_level(level, what: str) -> Level:
    """A known level, or an InputError with the nearest one."""
    if level not in LEVELS:
        raise InputError(f"{what}: found the level {level!r}; expected one of {', '.join(LEVELS)}{nearest(level, LEVELS)}")
    return level


def constraint_rows(constraints: Sequence[Constraint], units: dict[str, str]) -> tuple[ConstraintRow, ...]:
    """All rows of the constraints of a system with coordinates of these units, each with a name of its own."""
    found: list[ConstraintRow] = []
    each = tuple(units.values())
    for constraint in constraints:
        if not isinstance(constraint, Constraint):
            raise InputError(f"constraints: found {type(constraint).__name__}; make each with mb.Constraint(rows, ...)")
        if constraint.rows.shape[1] != len(units):
            raise InputError(
                f"constraint rows: found {constraint.rows.shape[1]} entries in a row; expected one for each of the "
                f"{len(units)} coordinates ({', '.join(units)})"
            )
        matrix, uncertain = full(constraint.rows), full(constraint.uncertainty)
        for place, (coefficients, value, uncertainty) in enumerate(zip(matrix, constraint.values, uncertain)):
            name = constraint.names[place] if constraint.names else f"constraint {len(found) + 1}"
            unit = constraint.unit or _unit(coefficients, each)
            found.append(ConstraintRow(name, coefficients, constraint.level, float(value), unit, uncertainty))
    names_of([row.name for row in found], len(found), "constraint rows", "")
    return tuple(found)


def _unit(coefficients, units) -> str:
    present = {units[place] for place in coefficients.nonzero()[0]}
    if len(present) == 1:
        return present.pop()
    return "m" if "m" in present else "1"


def _sparse_rows(rows) -> scipy.sparse.csr_array:
    """Sparse rows of finite real numbers, as a matrix."""
    found = scipy.sparse.csr_array(rows if rows.ndim == 2 else rows.reshape((1, -1)))
    entries = real_array(found.data, "constraint rows")
    return scipy.sparse.csr_array((entries, found.indices, found.indptr), shape=found.shape)
