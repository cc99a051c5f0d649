"""The response to a right-hand side with a rational transform: x with A(s) X(s) = b(s), exactly.

X = N / D with polynomials N (Cramer) and D = det A times the denominator of b. Division splits off Dirac's impulses, the rest
at s = infinity has the values at 0+, and at s = 0 the part that is a polynomial in time; none of these is rounded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import flint

from ..core.ring import series_at_infinity
from ..rational.flint_numbers import enclosed_roots
from ..rational.rational_matrix import RationalMatrix
from ..rational.rational_ring import RATIONALS

ZERO = flint.fmpq(0)


class RationalResponse:
    """x with A X = b / denominator.

    Args:
        matrix: A, regular.
        b: r polynomials.
        denominator: a polynomial.
        rows: the requested rows of x.
    """

    def __init__(self, matrix: RationalMatrix, b: Sequence[flint.fmpq_poly], denominator: flint.fmpq_poly, rows: range):
        self.size = len(rows)
        self.denominator = matrix.determinant * denominator
        numerators = matrix.numerators(b)
        self._divided = [divmod(numerators[row], self.denominator) for row in rows]
        self._series = [series_at_infinity(RATIONALS, rest, self.denominator, -1) for _, rest in self._divided]
        self._derivatives: list[list[flint.fmpq]] = []
        self._fractions: dict[int, PartialFractions] = {}

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
        while len(self._derivatives) <= order:
            self._derivatives.append([next(series) for series in self._series])
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
        if flint.ctx.prec not in self._fractions:
            self._fractions[flint.ctx.prec] = PartialFractions.of(self._irreducible, self._whole_denominator, self._rests)
        return self._fractions[flint.ctx.prec]

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
        series = [_quotient(_series(rest, order), below) for _, rest in self._divided]
        return [[column[order - 1 - k] for column in series] for k in range(order)]

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


def _quotient(above: Sequence, below: Sequence) -> list:
    """The first coefficients of the quotient of two power series, as many as those of the numerator."""
    terms: list = []
    for k, entry in enumerate(above):
        for i in range(1, k + 1):
            entry = entry - below[i] * terms[k - i]
        terms.append(entry / below[0])
    return terms


# Partial fractions in balls: the sum over the roots z of D of c_j t^(j-1)/(j-1)! e^{z t}, each root isolated for certain.


@dataclass(frozen=True, eq=False)
class Pole:
    """A root z of D of multiplicity m.

    Attributes:
        value: a ball that contains z and no other root.
        weight: 1 for a real root, 2 for one that stands for a complex pair.
        columns: c_1 ... c_m, shape (r,) each.
    """

    value: flint.acb
    weight: int
    columns: list[list[flint.acb]]


@dataclass(frozen=True, eq=False)
class PartialFractions:
    """The strictly proper part of N / D without its pole at s = 0.

    Attributes:
        poles: one for each real root of D and each complex pair.
    """

    poles: list[Pole]

    @classmethod
    def of(cls, factors, denominator: flint.fmpz_poly, numerators: Sequence[flint.fmpq_poly]) -> PartialFractions:
        """At the working precision.

        Args:
            factors: irreducible polynomials without the root 0, and to what power each divides D.
            denominator: D.
            numerators: N.

        Returns:
            The partial fractions at all roots.
        """
        poles = []
        for factor, power in factors:
            taylor = [_balls(p) for p in _taylor(denominator, 2 * power)[power:]]
            above = [[_balls(p) for p in _taylor(numerator, power)] for numerator in numerators]
            vanishing = [_order(numerator, factor, power) for numerator in numerators]
            for root, weight in _roots(tuple(map(int, factor.coeffs())), flint.ctx.prec):
                below = [p(root) for p in taylor]
                rows = [_quotient(_known([p(root) for p in own], zeros), below) for own, zeros in zip(above, vanishing)]
                poles.append(Pole(root, weight, [[row[power - 1 - j] for row in rows] for j in range(power)]))
        return cls(poles)

    def derivative(self, order: int) -> PartialFractions:
        """Of the function of time."""
        poles = self.poles
        for _ in range(order):
            poles = [Pole(pole.value, pole.weight, _differentiated(pole)) for pole in poles]
        return PartialFractions(poles)

    @cached_property
    def matrix(self) -> flint.arb_mat:
        """What ``weights`` are multiplied by: real and imaginary parts of all columns, shape (r, 2 K)."""
        columns = [[c * pole.weight for c in column] for pole in self.poles for column in pole.columns]
        parts = [part for column in columns for part in ([c.real for c in column], [-c.imag for c in column])]
        return flint.arb_mat(parts).transpose()

    def weights(self, calls: Sequence[tuple[flint.fmpq, flint.arb]]) -> list[flint.arb]:
        """The sum over calls (t, amount) of amount times the function at t is ``matrix`` times these, 2 K of them."""
        parts: list[flint.arb] = []
        since = [(flint.arb(time), amount) for time, amount in calls]
        for pole in self.poles:
            weighted = [(pole.value * time).exp() * amount for time, amount in since]
            for j in range(len(pole.columns)):
                if j:
                    weighted = [value * flint.arb(time / j) for value, (time, _) in zip(weighted, calls)]
                whole = sum(weighted, flint.acb(0))
                parts += [whole.real, whole.imag]
        return parts


def _differentiated(pole: Pole) -> list[list[flint.acb]]:
    """d/dt of sum of c_j t^(j-1)/(j-1)! e^{zt}: z c_j + c_(j+1)."""
    after = [*pole.columns[1:], [flint.acb(0)] * len(pole.columns[0])]
    return [[pole.value * a + b for a, b in zip(one, two)] for one, two in zip(pole.columns, after)]


@lru_cache(maxsize=256)
def _roots(coefficients: tuple[int, ...], precision: int) -> list[tuple[flint.acb, int]]:
    """Real roots and those above the real axis; FLINT certifies them, and real ones as real."""
    roots = enclosed_roots(flint.fmpz_poly(list(coefficients)), precision)
    return [(root, 1 if root.imag == 0 else 2) for root in roots if root.imag == 0 or root.imag > 0]


def _order(numerator: flint.fmpq_poly, factor: flint.fmpz_poly, most: int) -> int:
    """How often an irreducible factor divides a numerator, at most so often: there is no more of it in X then."""
    order, p = 0, flint.fmpq_poly(factor)
    while order < most and not numerator % p:
        numerator, order = numerator // p, order + 1
    return order


def _known(values: list[flint.acb], zeros: int) -> list[flint.acb]:
    """The first Taylor coefficients are zero, not balls about zero: what grows with the root does not grow in this row."""
    return [flint.acb(0)] * zeros + values[zeros:]


def _taylor(p, count: int) -> list:
    """p(z + h) = sum of h^k p_k(z)."""
    terms, divisor = [], 1
    for k in range(count):
        divisor *= max(k, 1)
        terms.append(flint.fmpq_poly(p) / divisor)
        p = p.derivative()
    return terms


def _balls(p: flint.fmpq_poly) -> flint.acb_poly:
    return flint.acb_poly([flint.acb(flint.arb(c)) for c in p.coeffs()])
