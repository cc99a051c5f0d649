"""The response to a right-hand side with a rational transform: x with A(s) X(s) = b(s), exactly.

X = N / D with polynomials N (Cramer) and D = det A times the denominator of b. Division splits off Dirac's impulses, the rest
at s = infinity has the values at 0+, and at s = 0 the part that is a polynomial in time; none of these knows a rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import flint

from ..rational.matrix import RationalMatrix
from .partial_fractions import PartialFractions

ZERO = flint.fmpq(0)


class RationalResponse:
    """x with A X = b / denominator.

    Args:
        matrix: A, regular.
        b: r polynomials.
        denominator: a polynomial.
        rows: the rows of x that are asked for.
    """

    def __init__(self, matrix: RationalMatrix, b: Sequence[flint.fmpq_poly], denominator: flint.fmpq_poly, rows: range):
        self.size = len(rows)
        self.denominator = matrix.determinant * denominator
        numerators = matrix.numerators(b)
        self._divided = [divmod(numerators[row], self.denominator) for row in rows]
        self._derivatives: list[list[flint.fmpq]] = []

    @property
    def is_zero(self) -> bool:
        """Whether x vanishes."""
        return not any(impulse or rest for impulse, rest in self._divided)

    @property
    def impulses(self) -> list[list[flint.fmpq]]:
        """Factors of delta, delta', ... at t = 0."""
        order = max((part.degree() for part, _ in self._divided), default=-1)
        return [[part[k] for part, _ in self._divided] for k in range(order + 1)]

    def start(self, order: int) -> list[flint.fmpq]:
        """x^(order)(0+), which is the coefficient of s^(-1 - order) of X at infinity."""
        below = self.denominator
        while len(self._derivatives) <= order:
            found, place = [], below.degree() - 1 - len(self._derivatives)
            for number, (_, rest) in enumerate(self._divided):
                known = [known[number] * below[place + 1 + k] for k, known in enumerate(self._derivatives) if place + 1 + k >= 0]
                # rest = D sum d_k s^(-1-k): compare the powers s^place, of which d_order has the leading coefficient of D
                found.append(((rest[place] if place >= 0 else ZERO) - sum(known, ZERO)) / below[below.degree()])
            self._derivatives.append(found)
        return self._derivatives[order]

    def polynomial_part(self, order: int, calls: Sequence[tuple]) -> list:
        """The sum over calls (t, factor) of factor times what the zeros at s = 0 add to x^(order)(t): a polynomial in t.

        Exact for exact factors, balls for balls.
        """
        zero = calls[0][1] * 0
        total, weighted = [zero] * self.size, [factor for _, factor in calls]
        for k, column in enumerate(self._at_zero[order:]):
            if k:
                weighted = [value * (time / k) for value, (time, _) in zip(weighted, calls)]
            whole = sum(weighted, zero)
            total = [entry + whole * c for entry, c in zip(total, column)]
        return total

    def partial_fractions(self) -> PartialFractions:
        """What the other zeros add, at the working precision."""
        return PartialFractions.of(self._irreducible, self._whole_denominator, self._rests)

    @cached_property
    def _zero_order(self) -> int:
        order = 0
        while not self.denominator[order]:
            order += 1
        return order

    @cached_property
    def _at_zero(self) -> list[list[flint.fmpq]]:
        """Columns c_k with sum of c_k t^k / k!: the principal part sum of c_k / s^(k + 1) at s = 0."""
        order = self._zero_order
        if not order:
            return []
        below = _series(self.denominator.right_shift(order), order)
        found = [_quotient(rest, below, order) for _, rest in self._divided]
        return [[column[order - 1 - k] for column in found] for k in range(order)]

    @cached_property
    def _whole_denominator(self) -> flint.fmpz_poly:
        return self.denominator.numer()

    @cached_property
    def _rests(self) -> list[flint.fmpq_poly]:
        """The numerators over the whole denominator."""
        unit = flint.fmpq(self._whole_denominator[self._whole_denominator.degree()]) / self.denominator[self.denominator.degree()]
        return [rest * unit for _, rest in self._divided]

    @cached_property
    def _irreducible(self) -> list[tuple[flint.fmpz_poly, int]]:
        """The denominator without powers of s as a product of powers of irreducible polynomials."""
        others = self._whole_denominator.right_shift(self._zero_order)
        return [(factor, power) for factor, power in others.factor()[1]]


def _series(p: flint.fmpq_poly, length: int) -> list[flint.fmpq]:
    return [p[k] for k in range(length)]


def _quotient(above: flint.fmpq_poly, below: Sequence[flint.fmpq], length: int) -> list[flint.fmpq]:
    """The power series above / below."""
    found: list[flint.fmpq] = []
    for k in range(length):
        known = sum((below[i] * found[k - i] for i in range(1, k + 1)), ZERO)
        found.append((above[k] - known) / below[0])
    return found
