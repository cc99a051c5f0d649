"""Intervals that contain a motion with exact values at both ends: x(t) = x_p(t) + sum of c_j x_j(t), solved for c in ball arithmetic."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import flint
import numpy as np

from ...ground.checks import counted
from ...ground.errors import InputError
from ..rational import pivots, rational, rational_matrix
from .exact_response import MOST_BITS, ZERO, ExactResponse


class ExactValue(NamedTuple):
    """x_i^(order) at 0+, or at T-."""

    coordinate: int
    order: int
    at_end: bool
    value: float


@dataclass(repr=False, eq=False)
class ExactBoundary(ExactResponse):
    """The exact solution of A(d/dt) x = f with as many values at both ends as there are finite zeros.

    x_p is the motion from zero values at 0- under f, x_j are independent free motions.
    """

    conditions: tuple[ExactValue, ...] = ()
    duration: flint.fmpq = ZERO

    def __post_init__(self):
        super().__post_init__()
        count = self.matrix.determinant.degree()
        if len(self.conditions) != count:
            raise InputError(
                f"enclose: found {counted(len(self.conditions), 'boundary value')}; expected {count}, one for each finite zero, which "
                "determine one motion"
            )

    @property
    def start(self) -> np.ndarray:
        raise InputError("start: with boundary values it is no rational number; enclose at t = 0 gives it as intervals")

    @cached_property
    def _free(self) -> list[ExactResponse]:
        """Independent free motions, from values at 0- of which one is 1, in the requested rows."""
        degree, size = len(self.initial), self.matrix.size
        units = np.eye(degree * size, dtype=int).reshape(-1, degree, size)
        starts = [ExactResponse(self.matrix, unit.tolist(), ()).start.ravel() for unit in units]
        if not starts:
            return []
        places = pivots(*rational_matrix(np.array(starts).T).rref())
        return [ExactResponse(self.matrix, units[k].tolist(), (), self.rows) for k in places]

    def _amounts(self) -> list[flint.arb]:
        """c at the working precision; not finite where more bits may separate the conditions."""
        whole = range(self.matrix.size)
        before = [source for source in self.sources if source.time < self.duration]  # left limits at T
        motions = [ExactResponse(self.matrix, self.initial, before), *(one.with_rows(whole) for one in self._free)]
        known: dict[tuple[bool, int], list[list[flint.arb]]] = {}
        for one in self.conditions:
            if (key := (one.at_end, one.order)) not in known:
                time = self.duration if one.at_end else ZERO
                known[key] = [motion._values([time], one.order)[0] for motion in motions]
        rows = [[column[one.coordinate] for column in known[one.at_end, one.order]] for one in self.conditions]
        right = [[flint.arb(rational(one.value)) - own[0]] for one, own in zip(self.conditions, rows)]
        try:
            return flint.arb_mat([own[1:] for own in rows]).solve(flint.arb_mat(right)).entries()
        except ZeroDivisionError:
            if flint.ctx.prec > MOST_BITS:
                raise InputError(
                    "enclose: the boundary values cannot be proved to be independent; T may be a conjugate point"
                ) from None
            return [flint.arb("nan")] * len(rows)

    def _values(self, times: Sequence[flint.fmpq], order: int) -> list[list[flint.arb]]:
        columns = super()._values(times, order)
        if not times or not self.size or not self.conditions:
            return columns
        for amount, motion in zip(self._amounts(), self._free):
            own = motion._values(times, order)
            columns = [[a + amount * b for a, b in zip(*pair)] for pair in zip(columns, own)]
        return columns


def with_boundary_values(x: ExactResponse, values: Sequence[ExactValue], duration: float) -> ExactBoundary:
    """Return the same equations and sources with values at both ends instead of those at 0-."""
    rest = [[0] * x.matrix.size for _ in x.initial]
    return ExactBoundary(x.matrix, rest, x.sources, x.rows, tuple(values), rational(duration))
