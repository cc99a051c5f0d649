"""The exact solution of A(d/dt) x + sum of A_j(d/dt) x(t - delay_j) = f, and intervals that contain x(t).

X(s) is the sum of e^(-s tau) Z_tau(s) over all sums tau of delays, with rational functions from

    A(s) Z_0 = X_in + F,    A(s) Z_tau = - sum of (A_j(s) Z_(tau - delay_j), at tau = delay_j less the values at 0-):

one polynomial matrix with A(s) on its diagonal and A_j(s) below it, whose response is x(t) = sum over tau <= t of z_tau(t - tau). The
terms cancel, the more the more delays have passed; balls of as many bits as that takes leave every digit.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import flint
import numpy as np

from ...ground.errors import InputError
from ...polynomial.delayed_terms import DelayedTerm
from ...signals.impulsive import ImpulsiveSmooth
from ..rational import RationalMatrix, fraction, rational
from .exact_response import ExactResponse
from .exact_sources import sources_of

#: Largest number of coordinates times sums of delays: the time of a determinant grows with its third power.
MOST_ROWS = 240


class ExactDelayedResponse(ExactResponse):
    """The exact solution with delays, all data taken as exact numbers, the delays as the decimal numbers that they were written as."""

    def __init__(
        self,
        A: RationalMatrix,
        terms: Sequence[DelayedTerm],
        initial: np.ndarray,
        force: ImpulsiveSmooth,
        rows: range | None = None,
    ):
        super().__init__(A, initial.tolist(), sources_of(force), rows)
        self._given = A, tuple(terms), np.asarray(initial), force
        self._whole: dict[int, tuple[tuple[Fraction, ...], ExactResponse]] = {}

    def with_rows(self, rows: range) -> ExactDelayedResponse:
        """The exact response of other rows of x."""
        return ExactDelayedResponse(*self._given, rows)

    def _sums(self, end: flint.fmpq) -> tuple[Fraction, ...]:
        """The sums of delays up to a time, ascending."""
        delays, last = [term.decimal for term in self._given[1]], Fraction(int(end.p), int(end.q))
        known, level = {Fraction(0)}, {Fraction(0)}
        while level:
            level = {one + delay for one in level for delay in delays if one + delay <= last} - known
            known |= level
            if len(known) * self.matrix.size > MOST_ROWS:
                raise InputError(
                    f"time: until {float(last):g} s there are more than {MOST_ROWS // self.matrix.size} sums of delays, too many for exact "
                    "determinants; ask for earlier times"
                )
        return tuple(sorted(known))

    def _response(self, sums: tuple[Fraction, ...]) -> ExactResponse:
        """All z of these sums of delays, one below the other."""
        A, terms, initial, force = self._given
        r, count = A.size, len(sums)
        if count not in self._whole:
            place = {one: k for k, one in enumerate(sums)}
            own = _fractions(A)
            powers = max(len(own), *(len(term.coefficients) for term in terms))
            total = np.full((powers, r * count, r * count), Fraction(0), dtype=object)
            for tau, k in place.items():
                at = slice(k * r, (k + 1) * r)
                total[: len(own), at, at] = own
                for term in terms:
                    other = place.get(tau - term.decimal)
                    if other is not None:
                        total[: len(term.coefficients), at, other * r : (other + 1) * r] += term.coefficients.astype(object)
            start = np.zeros((powers - 1, r * count))
            start[: len(initial), :r] = initial
            matrix = RationalMatrix(total.tolist())
            self._whole[count] = sums, ExactResponse(matrix, start.tolist(), sources_of(force.mapped(np.eye(r * count, r))))
        return self._whole[count][1]

    def _values(self, times, order: int, through: flint.arb_mat | None = None) -> list[list[flint.arb]]:
        if not times or not self.size:
            return [[] for _ in times]
        sums, r = self._sums(max(times)), self.matrix.size
        whole = self._response(sums)
        calls = [
            (place, k, time - rational(tau))
            for place, time in enumerate(times)
            for k, tau in enumerate(sums)
            if rational(tau) <= time
        ]
        columns = [[flint.arb(0)] * self.size for _ in times]
        for (place, k, _), column in zip(calls, whole._values([since for *_, since in calls], order)):
            own = column[k * r : (k + 1) * r]
            columns[place] = [total + own[row] for total, row in zip(columns[place], self.rows)]
        return columns if through is None else [(through * flint.arb_mat([[a] for a in own])).entries() for own in columns]


def _fractions(A: RationalMatrix) -> np.ndarray:
    """The coefficients of A(s) as Fractions, shape (q + 1, r, r)."""
    return np.array([[[fraction(entry) for entry in row] for row in matrix.tolist()] for matrix in A.coefficients], dtype=object)
