"""The exact solution of A(d/dt) x + sum of A_j(d/dt) x(t - delay_j) = f, and intervals that contain x(t).

X(s) is the sum of e^(-s tau) Z_tau(s) over all sums tau of delays, with rational functions from

    A(s) Z_0 = X_in + F,    A(s) Z_tau = - sum of (A_j(s) Z_(tau - delay_j), at tau = delay_j less the values at 0-):

one polynomial matrix with A(s) on its diagonal and A_j(s) below it, whose response is x(t) = sum over tau <= t of z_tau(t - tau). The
terms cancel, the more the more delays have passed; balls of as many bits as that takes leave every digit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import flint
import numpy as np

from ...ground.errors import InputError
from ...polynomial.delayed_terms import DelayedTerm
from ..rational import RationalMatrix, rational
from .exact_response import ZERO, ExactResponse

#: Largest number of coordinates times sums of delays: the time of a determinant grows with its third power.
MOST_ROWS = 240


@dataclass(repr=False, eq=False)
class ExactDelayedResponse(ExactResponse):
    """The exact solution with delays, all data taken as exact numbers, the delays as the decimal numbers that they were written as."""

    terms: Sequence[DelayedTerm] = ()

    def _sums(self, end: flint.fmpq) -> tuple[Fraction, ...]:
        """The sums of delays up to a time, ascending."""
        delays, last = [term.decimal for term in self.terms], Fraction(int(end.p), int(end.q))
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

    @cached_property
    def _responses(self) -> dict[int, ExactResponse]:
        """All z of some sums of delays, one below the other, by their number."""
        return {}

    def _response(self, sums: tuple[Fraction, ...]) -> ExactResponse:
        if (count := len(sums)) not in self._responses:
            r, place = self.matrix.size, {one: k for k, one in enumerate(sums)}
            own = np.array([matrix.tolist() for matrix in self.matrix.coefficients], dtype=object)
            late = [(term.decimal, np.vectorize(rational, [object])(term.coefficients)) for term in self.terms]
            total = np.full((max(map(len, (own, *(matrices for _, matrices in late)))), r * count, r * count), ZERO, dtype=object)
            for tau, k in place.items():
                at = slice(k * r, (k + 1) * r)
                total[: len(own), at, at] = own
                for delay, coefficients in late:
                    if (other := place.get(tau - delay)) is not None:
                        total[: len(coefficients), at, other * r : (other + 1) * r] += coefficients
            nothing = (ZERO,) * (r * (count - 1))
            start = [(*row, *nothing) for row in self.initial] + [(ZERO,) * (r * count)] * (len(total) - 1 - len(self.initial))
            sources = [replace(source, vector=(*source.vector, *nothing)) for source in self.sources]
            self._responses[count] = ExactResponse(RationalMatrix(total.tolist()), start, sources)
        return self._responses[count]

    def _values(self, times, order: int) -> list[list[flint.arb]]:
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
        return columns
