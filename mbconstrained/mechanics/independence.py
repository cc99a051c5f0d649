"""Constraint rows freed of what they say twice, and refused where they contradict each other.

The rows are taken strongest level first, so that of rows that coincide the strongest stays. A row held at position
level holds the derivatives of a x at zero: only kept rows of its own level contribute to the value that is
implied for a dependent row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import ContradictoryConstraints
from ..linalg.noise import Noisy
from ..linalg.sparse import solution
from ..notices import Notice
from ..tolerances import CLEAR_KEPT, EPS
from .constraint import LEVELS, ConstraintRow
from .elimination import reduce_rows
from .units import rate_unit


@dataclass(frozen=True)
class IndependentRows:
    """What is left of the constraint rows of a system with n coordinates.

    Attributes:
        rows: the k independent rows, strongest level first.
        matrix: A, their coefficients, shape (k, n).
        uncertainty: by how much they may be wrong beyond rounding, shape (k, n).
        null_space: V, a basis of null(A), shape (n, n - k).
        motions: the coordinate that each column of V is named for, None where it mixes them.
        pivots: columns in which A is regular, shape (k,).
        notices: one for each row that was left out, and for each that was kept by a narrow margin.
    """

    rows: tuple[ConstraintRow, ...]
    matrix: np.ndarray
    uncertainty: np.ndarray
    null_space: np.ndarray
    motions: tuple[int | None, ...]
    pivots: tuple[int, ...]
    notices: tuple[Notice, ...]

    @cached_property
    def left_inverse(self) -> np.ndarray:
        """G with G A^T = I, shape (k, n): turns a constraint force A^T lambda into lambda."""
        found, pivots = np.zeros(self.matrix.shape), list(self.pivots)
        found[:, pivots] = solution(self.matrix[:, pivots], np.eye(len(pivots))).T
        return found


def independent_rows(rows: Sequence[ConstraintRow], size: int) -> IndependentRows:
    """Take dependent rows out and find the null space of the rest.

    Raises:
        ContradictoryConstraints: a dependent row asks for another value than the rows that it depends on imply.
    """
    if not rows:
        return _nothing_held(size)
    rows = sorted(rows, key=lambda row: row.order)
    matrix = np.array([row.coefficients for row in rows]).reshape(len(rows), size)
    uncertainty = np.array([row.uncertainty + np.zeros(size) for row in rows]).reshape(matrix.shape)
    reduction = reduce_rows(Noisy(matrix, np.maximum(EPS * np.abs(matrix), uncertainty)), _carried(rows))
    notices = [_redundant(rows, place, rest) for place, rest in reduction.dependent.items()]
    notices += [
        _doubtful(rows[place], margin) for place, margin in zip(reduction.kept, reduction.margins) if margin < CLEAR_KEPT
    ]
    kept = list(reduction.kept)
    held, (null_space, motions) = tuple(rows[place] for place in kept), reduction.null_space()
    return IndependentRows(held, matrix[kept], uncertainty[kept], null_space, motions, reduction.pivots, tuple(notices))


def _nothing_held(size: int) -> IndependentRows:
    """Without rows every coordinate is free."""
    none = np.zeros((0, size))
    return IndependentRows((), none, none, np.eye(size), tuple(range(size)), (), ())


def _carried(rows) -> Noisy:
    """Carried along with each row: its value in the column of its level, and an exact unit vector."""
    carried = Noisy.exact(np.zeros((len(rows), len(LEVELS) + len(rows))))
    for place, row in enumerate(rows):
        carried.data[place, row.order], carried.noise[place, row.order] = row.value, EPS * abs(row.value)
        carried.data[place, len(LEVELS) + place] = 1.0
    return carried


def _redundant(rows, place, rest) -> Notice:
    """The notice of a row that the rows before it imply, or the error where they imply another value."""
    row, levels = rows[place], len(LEVELS)
    others = [f'"{rows[i].name}" ({rows[i].level} level)' for i in np.flatnonzero(rest[levels:]) if i != place]
    reason = f"it follows from {' and '.join(others)}" if others else "all its coefficients are zero"
    left_over = rest[row.order]
    if left_over:
        unit = rate_unit(row.unit, row.order)
        raise ContradictoryConstraints(
            f'constraint "{row.name}" ({row.level} level) asks for {row.value:.6g} {unit}, but {reason}, '
            f"with the value {row.value - left_over:.6g} {unit}; make the values agree or take one of the rows out"
        )
    return Notice(
        "redundant",
        f'constraint "{row.name}" ({row.level} level) says nothing new and was left out: {reason}; '
        "multipliers are those of the rows that are left",
    )


def _doubtful(row: ConstraintRow, margin: float) -> Notice:
    return Notice(
        "rank",
        f'constraint "{row.name}" ({row.level} level) is almost a combination of other rows: what is new in it stands only '
        f"{margin:.3g} times above the rounding noise; it was kept",
        doubtful=True,
    )
