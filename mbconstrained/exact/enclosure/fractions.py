"""The response to a right-hand side with a rational transform: x with A(s) X(s) = b(s), exactly.

X = N / D with polynomials N (Cramer) and D = det A times the denominator of b. Division splits off Dirac's impulses, the rest
at s = infinity has the values at 0+, and at s = 0 the part that is a polynomial in time; none of these is rounded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import factorial, lcm

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

    def partial_fractions(self) -> PartialFractions:
        """Partial fractions of the other zeros, at the working precision."""
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
    def at_zero(self) -> list[list[flint.fmpq]]:
        """Contribution of the zeros at s = 0, sum of c_k t^k / k!, as columns c_k of the principal part sum of c_k / s^(k + 1)."""
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
class RationalPole:
    """A root z of D of multiplicity m.

    Attributes:
        name: which root of which irreducible polynomial it is.
        value: a ball that contains z and no other root.
        weight: 1 for a real root, 2 for one that stands for a complex pair.
        columns: c_1 ... c_m, shape (r,) each.
    """

    name: tuple
    value: flint.acb
    weight: int
    columns: list[list[flint.acb]]


@dataclass(frozen=True, eq=False)
class PartialFractions:
    """The strictly proper part of N / D without its pole at s = 0.

    Attributes:
        poles: one for each real root of D and each complex pair.
    """

    poles: list[RationalPole]

    @classmethod
    def of(cls, factors, denominator: flint.fmpz_poly, numerators: Sequence[flint.fmpq_poly]) -> PartialFractions:
        """Partial fractions at the working precision."""
        poles = []
        for factor, power in factors:
            taylor = [_balls(p) for p in _taylor(denominator, 2 * power)[power:]]
            above = [[_balls(p) for p in _taylor(numerator, power)] for numerator in numerators]
            vanishing = [_order(numerator, factor, power) for numerator in numerators]
            coefficients = tuple(map(int, factor.coeffs()))
            for number, (root, weight) in enumerate(_roots(coefficients, flint.ctx.prec)):
                below = [p(root) for p in taylor]
                rows = [_quotient(_known([p(root) for p in own], zeros), below) for own, zeros in zip(above, vanishing)]
                columns = [[row[power - 1 - j] for row in rows] for j in range(power)]
                poles.append(RationalPole((coefficients, number), root, weight, columns))
        return cls(poles)

    def derivative(self, order: int) -> PartialFractions:
        """Partial fractions of the derivative with respect to time."""
        poles = self.poles
        for _ in range(order):
            poles = [replace(pole, columns=_differentiated(pole)) for pole in poles]
        return PartialFractions(poles)


class Begun:
    """The sum of the responses that have begun by a time, polynomials in t and sums of modes about t = 0, at the working precision.

    A later call is moved to t = 0 once, (t - b)^k e^(z (t - b)) being e^(-z b) times a sum of powers of t times e^(z t): at each time every mode has one
    exponential, however many calls there are. What is rational is summed exactly, so that it cancels exactly.

    Args:
        size: the number of rows.
    """

    def __init__(self, size: int):
        self.size = size
        self._exact: list[list[flint.fmpq]] = []
        self._balls: list[list[flint.arb]] = []
        self._modes: dict[tuple, RationalPole] = {}

    def add(self, begin: flint.fmpq, factor, polynomial: Sequence[list[flint.fmpq]], modes: PartialFractions) -> None:
        """Add a response from a time on, of columns c_k of t^k / k! and of modes."""
        amount, columns = flint.arb(factor), self._exact if isinstance(factor, flint.fmpq) else self._balls
        _add_moved(columns, polynomial, begin, factor, self.size)
        for pole in modes.poles:
            if pole.name not in self._modes:
                self._modes[pole.name] = replace(pole, columns=[])
            factor = (pole.value * -begin).exp() * amount if begin else amount
            _add_moved(self._modes[pole.name].columns, pole.columns, begin, factor, self.size)

    def at(self, times: Sequence[flint.fmpq]) -> tuple[flint.fmpz_mat, flint.fmpz, flint.arb_mat]:
        """Exact parts at some times, with a common denominator, and parts in balls, both of shape (T, r)."""
        weights: list[list[flint.arb]] = []
        columns: list[list[flint.arb]] = []
        since = [flint.arb(time) for time in times]
        for pole in self._modes.values():
            value = pole.value
            exponentials = [(value * time).exp() for time in since]
            for k, column in enumerate(pole.columns):
                if k:
                    exponentials = [one * (time / k) for one, time in zip(exponentials, times)]
                weights += [[one.real for one in exponentials], [one.imag for one in exponentials]]
                columns += [[c.real * pole.weight for c in column], [-c.imag * pole.weight for c in column]]
        for k, coefficients in enumerate(self._balls):
            weights.append([flint.arb(time**k / factorial(k)) for time in times])
            columns.append(coefficients)
        balls = flint.arb_mat(weights).transpose() * flint.arb_mat(columns) if columns else flint.arb_mat(len(times), self.size)
        return *self._exact_at(times), balls

    def _exact_at(self, times: Sequence[flint.fmpq]) -> tuple[flint.fmpz_mat, flint.fmpz]:
        """Exact parts in whole numbers, without greatest common divisors."""
        if not self._exact:
            return flint.fmpz_mat(len(times), self.size), flint.fmpz(1)
        highest, of_times = len(self._exact) - 1, lcm(*(int(time.q) for time in times))
        steps = [time.p * (of_times // time.q) for time in times]
        columns, scale = flint.fmpq_mat([[c / factorial(k) for c in own] for k, own in enumerate(self._exact)]).numer_denom()
        unit = flint.fmpz(of_times)
        powers = flint.fmpz_mat([[step**k * unit ** (highest - k) for k in range(highest + 1)] for step in steps])
        return powers * columns, scale * unit**highest


def _add_moved(columns: list[list], given: Sequence[list], begin: flint.fmpq, factor, size: int) -> None:
    """Add factor times the columns of (t - b)^k / k! to those of t^k / k!."""
    while len(columns) < len(given):
        columns.append([factor * 0] * size)
    for power in range(len(given) if begin else 1):
        if power:
            factor = factor * (-begin / power)
        for k, column in enumerate(given[power:]):
            columns[k] = [a + factor * b for a, b in zip(columns[k], column)]


def _differentiated(pole: RationalPole) -> list[list[flint.acb]]:
    """d/dt of sum of c_j t^(j-1)/(j-1)! e^{zt}: z c_j + c_(j+1)."""
    after = [*pole.columns[1:], [flint.acb(0)] * len(pole.columns[0])]
    return [[pole.value * a + b for a, b in zip(one, two)] for one, two in zip(pole.columns, after)]


@lru_cache(maxsize=256)
def _roots(coefficients: tuple[int, ...], precision: int) -> list[tuple[flint.acb, int]]:
    """Real roots and those above the real axis; FLINT certifies them, and real ones as real."""
    roots = enclosed_roots(flint.fmpz_poly(list(coefficients)), precision)
    return [(root, 1 if root.imag == 0 else 2) for root in roots if root.imag == 0 or root.imag > 0]


def _order(numerator: flint.fmpq_poly, factor: flint.fmpz_poly, most: int) -> int:
    """The power of an irreducible factor in a numerator, up to its power in the denominator."""
    order, p = 0, flint.fmpq_poly(factor)
    while order < most and not numerator % p:
        numerator, order = numerator // p, order + 1
    return order


def _known(values: list[flint.acb], zeros: int) -> list[flint.acb]:
    """Set the first Taylor coefficients, balls about zero, to zero: growth with the root is absent from this row."""
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
