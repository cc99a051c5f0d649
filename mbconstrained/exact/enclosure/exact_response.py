"""The exact solution of A(d/dt) x = f: impulses, values at 0+, and intervals of any width that contain x(t).

Independent of the numeric engine: no pencil, no eigenvalue, no rank decision. The transform X(s) is computed as a vector of
rational functions over the rationals, and summed over its certified poles in ball arithmetic (FLINT's Arb), with more bits
until the requested digits are there. X = N / D with polynomials N (Cramer) and D = det A times the denominator of b: division splits off
Dirac's impulses, the rest at s = infinity has the values at 0+, and at s = 0 the part that is a polynomial in time; none is rounded.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import zip_longest
from math import factorial, inf, isfinite, lcm, nextafter
from typing import NamedTuple, Protocol, TypeAlias

import flint
import numpy as np

from ...ground.checks import counted, real_array, whole_number
from ...ground.display import Displayed
from ...ground.errors import InputError, SingularPolynomialMatrix, within_float64
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS
from ...polynomial.delayed_terms import DelayedTerm
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...signals.impulsive import ImpulsiveSmooth
from ..engine import series_at_infinity, valuation
from ..rational import (
    RATIONALS,
    RationalMatrix,
    enclosed_roots,
    fraction,
    known_matrix,
    pivots,
    polynomial,
    rational,
    rational_matrix,
    regular_matrix,
    working_precision,
)
from .exact_sources import ONE, ExactSource, Factor, S, Shape, Vector, added, ball, sources_of, summed, vector_of
from .intervals import Enclosure, bits_of, has_digits

#: Bits to begin with, beyond those of the requested digits.
FIRST_BITS = 40

#: Where so many bits do not give the digits, the value is zero or cancels to so many bits: its interval is as narrow as it is.
MOST_BITS = 1 << 13

#: Largest number of digits; more are a typing error.
MOST_DIGITS = 1000

#: Bits of values that are rounded to float64, relative to the largest row at each time, and those of the first attempt.
ROUNDED_BITS, FIRST_ROUNDED_BITS = 56, 128

#: In larger matrices no single entry decides, and each costs a determinant.
MOST_ENTRIES = 64

#: Largest number of coordinates times sums of delays: the time of a determinant grows with its third power.
MOST_ROWS = 240

#: Bits of jumps and impulses.
EVENT_BITS = 256

#: Values below this power of two vanish in float64.
SMALLEST_EXPONENT = -1080

#: Rounding errors of larger numbers grow with them.
SMALLEST = float(np.finfo(float).tiny)


ZERO = flint.fmpq(0)


class Inverse(Protocol):
    """A(s)^-1 b as ``numerators(b)`` over a determinant."""

    @property
    def determinant(self) -> flint.fmpq_poly: ...

    def numerators(self, b: Sequence[flint.fmpq_poly]) -> list[flint.fmpq_poly]: ...


class RationalResponse:
    """The requested rows of x with A X = b / denominator, A regular, b of r polynomials."""

    def __init__(self, matrix: Inverse, b: Sequence[flint.fmpq_poly], denominator: flint.fmpq_poly, rows: range):
        self.size = len(rows)
        self.denominator = matrix.determinant * denominator
        numerators = matrix.numerators(b)
        self._divided = [divmod(numerators[row], self.denominator) for row in rows]
        self._series = [series_at_infinity(RATIONALS, rest, self.denominator, -1) for _, rest in self._divided]
        self._derivatives: list[list[flint.fmpq]] = []
        self._poles: dict[int, list[RationalPole]] = {}

    @property
    def is_zero(self) -> bool:
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

    def poles(self, order: int) -> list[RationalPole]:
        """Partial fractions of the other zeros, at the working precision, of a derivative of x: c_j becomes z c_j + c_(j+1)."""
        if flint.ctx.prec not in self._poles:
            self._poles[flint.ctx.prec] = _partial_fractions(*self._factored)
        poles, nothing = self._poles[flint.ctx.prec], [flint.acb(0)] * self.size
        for _ in range(order):
            pairs = [(pole, zip_longest(pole.columns, pole.columns[1:], fillvalue=nothing)) for pole in poles]
            poles = [replace(pole, columns=[[pole.value * a + b for a, b in zip(*two)] for two in own]) for pole, own in pairs]
        return poles

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
        below = RATIONALS.coefficients(self.denominator.right_shift(order), order)
        series = [_quotient(RATIONALS.coefficients(rest, order), below) for _, rest in self._divided]
        return [[column[order - 1 - k] for column in series] for k in range(order)]

    @cached_property
    def _factored(self) -> tuple[list[tuple[flint.fmpz_poly, int]], flint.fmpz_poly, list[flint.fmpq_poly]]:
        """Irreducible factors without s and their powers, the whole denominator, and the numerators over it."""
        whole = self.denominator.numer()
        unit = flint.fmpq(whole[whole.degree()]) / self.denominator[self.denominator.degree()]
        return whole.right_shift(self._zero_order).factor()[1], whole, [rest * unit for _, rest in self._divided]


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
    """A root z of D of multiplicity m."""

    name: tuple  # which root of which irreducible polynomial it is
    value: flint.acb  # a ball that contains z and no other root
    weight: int  # 1 for a real root, 2 for one that stands for a complex pair
    columns: list[list[flint.acb]]  # c_1 ... c_m, shape (r,) each


def _partial_fractions(factors, denominator: flint.fmpz_poly, numerators: Sequence[flint.fmpq_poly]) -> list[RationalPole]:
    """The strictly proper part of N / D without its pole at s = 0: one pole for each real root of D and each complex pair."""
    poles = []
    for factor, power in factors:
        taylor, q = _taylor(denominator, 2 * power)[power:], flint.fmpq_poly(factor)
        above = [_taylor(numerator, power) for numerator in numerators]
        vanishing = [min(power, valuation(numerator, q)) if numerator else power for numerator in numerators]
        coefficients = tuple(map(int, factor.coeffs()))
        for number, (root, weight) in enumerate(_roots(coefficients, flint.ctx.prec)):
            below = [p(root) for p in taylor]
            # The first Taylor coefficients, balls about zero, are zero where growth with the root is absent from a row.
            values = ([flint.acb(0)] * zeros + [p(root) for p in own[zeros:]] for own, zeros in zip(above, vanishing))
            rows = [_quotient(row, below) for row in values]
            columns = [[row[power - 1 - j] for row in rows] for j in range(power)]
            poles.append(RationalPole((coefficients, number), root, weight, columns))
    return poles


# A later call is moved to t = 0 once, (t - b)^k e^(z (t - b)) being e^(-z b) times a sum of powers of t times e^(z t): at each time every mode
# has one exponential, however many calls there are. What is rational is summed exactly, so that it cancels exactly.


class Begun:
    """The sum of the responses that have begun by a time, polynomials in t and sums of modes about t = 0, in ``size`` rows."""

    def __init__(self, size: int):
        self.size = size
        self._exact: list[list[flint.fmpq]] = []
        self._balls: list[list[flint.arb]] = []
        self._modes: dict[tuple, RationalPole] = {}

    def add(self, begin: flint.fmpq, factor, polynomial: Sequence[list[flint.fmpq]], poles: Sequence[RationalPole]) -> None:
        """Add a response from a time on, of columns c_k of t^k / k! and of modes."""
        amount, columns = flint.arb(factor), self._exact if isinstance(factor, flint.fmpq) else self._balls
        _add_moved(columns, polynomial, begin, factor, self.size)
        for pole in poles:
            if pole.name not in self._modes:
                self._modes[pole.name] = replace(pole, columns=[])
            factor = (pole.value * -begin).exp() * amount if begin else amount
            _add_moved(self._modes[pole.name].columns, pole.columns, begin, factor, self.size)

    def at(self, times: Sequence[flint.fmpq]) -> tuple[flint.fmpz_mat, flint.fmpz, flint.arb_mat]:
        """Exact parts at some times, with a common denominator, and parts in balls, both of shape (T, r)."""
        factors: list[list[flint.acb]] = []
        columns: list[list[flint.acb]] = []
        since = [flint.arb(time) for time in times]
        for pole in self._modes.values():
            exponentials = [(pole.value * time).exp() for time in since]
            for k, column in enumerate(pole.columns):
                if k:
                    exponentials = [one * (time / k) for one, time in zip(exponentials, times)]
                factors.append(exponentials)
                columns.append([c * pole.weight for c in column])
        for k, column in enumerate(self._balls):
            factors.append([flint.acb(flint.arb(time**k / factorial(k))) for time in times])
            columns.append([flint.acb(c) for c in column])
        balls = real_sums(factors, columns, len(times), self.size)
        if not self._exact:
            return flint.fmpz_mat(len(times), self.size), flint.fmpz(1), balls
        # in whole numbers, without greatest common divisors
        highest, of_times = len(self._exact) - 1, lcm(*(int(time.q) for time in times))
        steps = [time.p * (of_times // time.q) for time in times]
        numerators, scale = flint.fmpq_mat([[c / factorial(k) for c in own] for k, own in enumerate(self._exact)]).numer_denom()
        unit = flint.fmpz(of_times)
        powers = flint.fmpz_mat([[step**k * unit ** (highest - k) for k in range(highest + 1)] for step in steps])
        return powers * numerators, scale * unit**highest, balls


def real_sums(
    factors: Sequence[Sequence[flint.acb]], columns: Sequence[Sequence[flint.acb]], count: int, size: int
) -> flint.arb_mat:
    """The real parts of sums of factors (count,) times columns (size,), shape (count, size)."""
    if not (columns and count and size):
        return flint.arb_mat(count, size)
    left = [part for own in factors for part in ([f.real for f in own], [f.imag for f in own])]
    right = [part for own in columns for part in ([c.real for c in own], [-c.imag for c in own])]
    return flint.arb_mat(left).transpose() * flint.arb_mat(right)


def _add_moved(columns: list[list], given: Sequence[list], begin: flint.fmpq, factor, size: int) -> None:
    """Add factor times the columns of (t - b)^k / k! to those of t^k / k!."""
    while len(columns) < len(given):
        columns.append([factor * 0] * size)
    for power in range(len(given) if begin else 1):
        if power:
            factor = factor * (-begin / power)
        for k, column in enumerate(given[power:]):
            columns[k] = [a + factor * b for a, b in zip(columns[k], column)]


@lru_cache(maxsize=256)
def _roots(coefficients: tuple[int, ...], precision: int) -> list[tuple[flint.acb, int]]:
    """Real roots and those above the real axis; FLINT certifies them, and real ones as real."""
    roots = enclosed_roots(flint.fmpz_poly(list(coefficients)), precision)
    return [(root, 1 if root.imag == 0 else 2) for root in roots if root.imag == 0 or root.imag > 0]


def _taylor(p, count: int) -> list[flint.acb_poly]:
    """p(z + h) = sum of h^k p_k(z)."""
    terms, divisor = [], 1
    for k in range(count):
        divisor *= max(k, 1)
        terms.append(flint.acb_poly(flint.fmpq_poly(p) / divisor))
        p = p.derivative()
    return terms


# The response to all values and sources.

#: Times of onset of a response, with factors.
Calls: TypeAlias = tuple[tuple[flint.fmpq, Factor], ...]


@dataclass(repr=False, eq=False)
class ExactResponse(Displayed):
    """Exact solution x of A(d/dt) x = f from values at 0-, all data taken as exact numbers.

    Args:
        matrix: A(s), regular.
        initial: x^(i)(0-) as row i, q rows of r exact numbers.
        sources: f.
        rows: the requested rows of x, all by default.

    Raises:
        SingularPolynomialMatrix: A(s) is not regular.
    """

    matrix: RationalMatrix
    initial: Sequence[Sequence] | np.ndarray
    sources: Sequence[ExactSource]
    rows: range | None = None

    def __post_init__(self):
        self.initial = [vector_of(row) for row in self.initial]
        self.rows = range(self.matrix.size) if self.rows is None else self.rows
        if not self.matrix.determinant:
            raise SingularPolynomialMatrix("det A(s) is zero for every s: the motion is not determined", (), ())

    def _summary(self) -> str:
        return f"{counted(self.size, 'row')}, degree {len(self.matrix.coefficients) - 1}"

    @property
    def size(self) -> int:
        """The number of requested rows of x."""
        return len(self.rows)

    def with_rows(self, rows: range) -> ExactResponse:
        """Return the exact response of other rows of x without a new determinant."""
        return replace(self, rows=rows)

    @cached_property
    def impulses(self) -> tuple[np.ndarray, ...]:
        """Arrays (r,) of Fractions; the k-th multiplies the k-th derivative of Dirac's delta at t = 0; the last one is not zero.

        Raises:
            InputError: a phase makes them irrational; ``enclose_impulses`` has them as intervals.
        """
        try:
            total = self._impulses(rational)
        except TypeError:
            text = "impulses: with this phase they are no rational numbers; enclose_impulses gives them as intervals"
            raise InputError(text) from None
        return tuple(np.array([fraction(entry) for entry in impulse], dtype=object) for impulse in total)

    def enclose_impulses(self, digits: int = 15) -> tuple[Enclosure, ...]:
        """Return the impulses at t = 0 as intervals: the k-th multiplies the k-th derivative of Dirac's delta."""
        digits = _checked_digits(digits)
        return tuple(
            Enclosure.of(_certain(lambda k=k: [self._impulses(ball)[k]], digits)[0], np.zeros(()), digits)
            for k in range(len(self._impulses(ball)))
        )

    @cached_property
    def start(self) -> np.ndarray:
        """x^(i)(0+) as row i, shape (q, r), Fractions; also for multipliers and outputs, which have no values at 0-.

        Raises:
            InputError: a phase makes them irrational; ``enclose`` at t = 0 has them as intervals.
        """
        try:
            total = self._started(ZERO, self._values_at_start, rational) or [[ZERO] * self.size for _ in self.initial]
        except TypeError:
            raise InputError("start: with this phase it is no rational number; enclose at t = 0 gives it as intervals") from None
        return np.array([[fraction(entry) for entry in row] for row in total], dtype=object).reshape(len(total), self.size)

    @property
    def jump(self) -> np.ndarray:
        """x^(i)(0+) - x^(i)(0-) as row i, shape (q, r), Fractions."""
        before = [[fraction(entry) for entry in (row[k] for k in self.rows)] for row in self.initial]
        return self.start - np.array(before, dtype=object).reshape(self.start.shape)

    @within_float64()
    def enclose(self, times, digits: int = 15, *, order: int = 0) -> Enclosure:
        """Return intervals that contain x^(order)(t), t > 0 (t = 0 means 0+, the time of an event its right limit).

        Args:
            times: in s, a number or shape (T,); the floats are exact numbers.
            digits: significant digits of each value. A value that is zero, or that cancels to thousands of bits, has an
                interval about zero instead.
            order: order of the derivative.

        Returns:
            An ``Enclosure`` of shape (r,) for a number, (r, T) for T times.

        Raises:
            InputError: times that are negative or not finite, digits or an order that are no whole numbers in range.
        """
        times = real_array(times, "time")
        if times.ndim > 1 or (times.size and times.min() < 0):
            raise InputError("time: expected a number or a list of numbers, none of them negative (0 means 0+)")
        digits, order = _checked_digits(digits), whole_number(order, "order")
        events = {float(fraction(begin)): begin for begin in sorted({source.time for source in self.sources})}
        exact = [max(rational(time), events.get(time, ZERO)) for time in np.atleast_1d(times).tolist()]  # right limits
        columns = _certain(lambda: self._values(exact, order), digits)
        rows = [list(row) for row in zip(*columns)] if columns else [[] for _ in self.rows]
        return Enclosure.of(rows if times.ndim else [row[0] for row in rows], times, digits)

    @cached_property
    def _parts(self) -> list[tuple[RationalResponse, Calls]]:
        """Responses to functions of time from t = 0 on with the factor one; equal functions share their response."""
        now: list[tuple[Vector, Shape]] = []
        groups: dict[tuple, list[ExactSource]] = {}
        for source in self.sources:
            if source.time == 0 and isinstance(source.factor, flint.fmpq):
                now.append((tuple(source.factor * entry for entry in source.vector), source.shape))
            else:
                source = source.normalized()
                groups.setdefault((source.shape.key, source.vector), []).append(source)
        total, below = summed(now, self.matrix.size)
        started = start_transform(self.matrix.coefficients, self.initial)  # values at 0- act as impulses
        first = RationalResponse(self.matrix, [own + entry * below for own, entry in zip(total, started)], below, self.rows)
        parts: list[tuple[RationalResponse, Calls]] = [(first, ((ZERO, flint.fmpq(1)),))]
        for group in groups.values():
            if calls := added((source.time, source.factor) for source in group):
                shape, vector = group[0].shape, group[0].vector
                b = [shape.numerator * entry for entry in vector]
                parts.append((RationalResponse(self.matrix, b, shape.denominator, self.rows), calls))
        return [part for part in parts if not part[0].is_zero]

    def _impulses(self, number) -> list[list]:
        """Factors of delta, delta', ... at t = 0, in numbers of one kind."""
        total = self._started(ZERO, lambda x: x.impulses, number)
        while total and all(entry == 0 for entry in total[-1]):
            total.pop()
        return total

    def _started(self, time: flint.fmpq, rows_of: Callable[[RationalResponse], list[list[flint.fmpq]]], number) -> list[list]:
        """The sum of rows of the responses that begin at a time, in numbers of one kind."""
        total: list[list] = []
        for response, factor in ((response, factor) for response, calls in self._parts for at, factor in calls if at == time):
            if any(map(any, rows := rows_of(response))):
                amount = number(factor)
                total += [[number(ZERO)] * self.size for _ in rows[len(total) :]]
                total[: len(rows)] = [[a + amount * b for a, b in zip(*pair)] for pair in zip(total, rows)]
        return total

    def _values_at_start(self, response: RationalResponse) -> list[list[flint.fmpq]]:
        return [response.start(order) for order in range(len(self.initial))]

    def rounded(self, times, order: int = 0, matrix: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return y = matrix @ x^(order) in float64, at each time accurate to ``ROUNDED_BITS`` bits of its largest row.

        Args:
            times: in s, shape (T,).
            order: order of the derivative.
            matrix: shape (p, r), floats as the exact numbers that they are; None for x itself.

        Returns:
            The values, shape (p, T), and proved bounds of their errors, shape (p, T).
        """
        exact = [self._events.get(time) or rational(time) for time in times.tolist()]
        through = None if matrix is None else flint.arb_mat(*matrix.shape, [flint.arb(entry) for entry in matrix.ravel().tolist()])
        rows, precision = self.size if matrix is None else len(matrix), FIRST_ROUNDED_BITS
        values, errors = np.zeros((rows, len(times))), np.zeros((rows, len(times)))
        pending = list(range(len(times))) if rows else []
        while pending:
            with working_precision(precision):
                columns, late = self._values([exact[k] for k in pending], order), []
                if through is not None:
                    columns = [(through * flint.arb_mat([[entry] for entry in column])).entries() for column in columns]
                values[:, pending], errors[:, pending], certain = _as_floats(columns)
                for place in np.flatnonzero(~certain).tolist():
                    k, column = pending[place], columns[place]
                    if _is_rounded(column) or precision >= MOST_BITS:
                        values[:, k], errors[:, k] = zip(*map(_as_float, column))
                    else:
                        late.append(k)
            pending, precision = late, 2 * precision
        return values, errors

    def event(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return jumps of x, x', ... and impulses at a time, in float64; zero where they cancel to all computed bits.

        Args:
            time: of an event, in s.

        Returns:
            x^(i)(t+) - x^(i)(t-) as row i, shape (q, r), and the factors of Dirac's delta and its derivatives, shape (k, r).
        """
        begin = self._events.get(time, rational(time))
        with working_precision(EVENT_BITS):
            before = [[ball(row[k]) if begin == 0 else flint.arb(0) for k in self.rows] for row in self.initial]
            after = self._started(begin, self._values_at_start, ball) or [[flint.arb(0)] * self.size for _ in before]
            jump = [[a - b for a, b in zip(*rows)] for rows in zip(after, before)]
            impulses = self._started(begin, lambda x: x.impulses, ball)
            values = [[0.0 if entry.contains(0) else float(entry.mid()) for entry in row] for row in (*jump, *impulses)]
        table = np.array(values).reshape(-1, self.size)
        return table[: len(jump)], table[len(jump) :]

    @cached_property
    def _events(self) -> dict[float, flint.fmpq]:
        """The exact times of events by the nearest floats, which stand for the right limit at the event."""
        return {float(fraction(begin)): begin for _, calls in self._parts for begin, _ in calls}

    def _values(self, times: Sequence[flint.fmpq], order: int) -> list[list[flint.arb]]:
        """Columns (r,) of balls, one for each time, at the working precision."""
        if not times or not self.size:
            return [[] for _ in times]
        calls = [
            (begin, response, factor, response.at_zero[order:], response.poles(order))
            for response, onsets in self._parts
            for begin, factor in onsets
        ]
        calls.sort(key=lambda call: call[0])
        begun, number, columns = Begun(self.size), 0, [[] for _ in times]
        pending = sorted(range(len(times)), key=times.__getitem__)
        while pending:
            while number < len(calls) and calls[number][0] < times[pending[0]]:
                begin, _, factor, polynomial, poles = calls[number]
                begun.add(begin, factor if isinstance(factor, flint.fmpq) else ball(factor), polynomial, poles)
                number += 1
            last = calls[number][0] if number < len(calls) else None
            count = len(pending) if last is None else bisect_right(pending, last, key=times.__getitem__)
            exact, scale, balls = begun.at([times[k] for k in pending[:count]])
            rows = (balls + flint.arb_mat(exact) * (1 / flint.arb(scale))).tolist()
            for place, k in enumerate(pending[:count]):
                columns[k] = rows[place]
                if times[k] == last:
                    known, own = [flint.fmpq(entry, scale) for entry in exact.table()[place]], balls.tolist()[place]
                    columns[k] = self._with_starts(known, own, order, times[k], calls[number:])
            pending = pending[count:]
        return columns

    def _with_starts(self, exact: list[flint.fmpq], balls: list[flint.arb], order: int, time: flint.fmpq, calls) -> list[flint.arb]:
        """The values at a time with the sources that begin there: its right limit."""
        for begin, response, factor, *_ in calls:
            if begin > time:
                break
            start = response.start(order)
            if isinstance(factor, flint.fmpq):
                exact = [a + factor * b for a, b in zip(exact, start)]
            else:
                balls = [a + ball(factor) * b for a, b in zip(balls, start)]
        return [flint.arb(a) + b for a, b in zip(exact, balls)]


def start_transform(coefficients: Sequence[flint.fmpq_mat], initial: Sequence[Sequence[flint.fmpq]]) -> list[flint.fmpq_poly]:
    """X_in(s) = sum of A_i s^(i-1-j) x^(j)(0-), j < i (Moysis et al., section 3)."""
    vectors = [flint.fmpq_mat([[entry] for entry in row]) for row in initial]
    powers = [flint.fmpq_mat(coefficients[0].nrows(), 1) for _ in coefficients]
    for i, matrix in enumerate(coefficients):
        for j in range(i):
            powers[i - 1 - j] += matrix * vectors[j]
    return [flint.fmpq_poly(list(entries)) for entries in zip(*(power.entries() for power in powers))]


def _as_floats(columns: list[list[flint.arb]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The nearest float64 numbers of columns, bounds of their errors, shape (r, T), and which columns are certainly rounded."""
    values = np.array([[float(entry) for entry in column] for column in columns]).T
    radii = np.array([[float(entry.rad()) for entry in column] for column in columns]).T
    with np.errstate(all="ignore"):
        errors = radii + EPS / 2 * np.abs(values)
        errors = np.where(errors > 0, np.nextafter(errors, inf), 0.0)
        size, radius = np.abs(values).max(axis=0), radii.max(axis=0)
        certain = (radius * 2.0**ROUNDED_BITS <= (1 - 4 * EPS) * size - radius) & (size * EPS > SMALLEST) & (size < inf)
    return values, errors, certain


def _is_rounded(column: list[flint.arb]) -> bool:
    """Whether the largest entry of a column is accurate to its bits, and the others to the same absolute error."""
    radius = max([entry.rad() for entry in column], default=flint.arb(0))
    size = max([entry.abs_lower() for entry in column], default=flint.arb(0))
    return bool(radius * 2**ROUNDED_BITS <= size) or bool(size + radius < flint.arb(2) ** SMALLEST_EXPONENT)


def _as_float(entry: flint.arb) -> tuple[float, float]:
    """The nearest float64 number, and a bound of its error."""
    value = float(entry.mid())
    if not isfinite(value):
        return value, inf
    error = (entry - value).abs_upper()
    return value, nextafter(float(error), inf) if error > 0 else 0.0


def _certain(compute, digits: int) -> list[list[flint.arb]]:
    """Compute with more and more bits until each value has its digits."""
    precision = bits_of(digits) + FIRST_BITS
    while True:
        with working_precision(precision):
            columns = compute()
        entries = [entry for column in columns for entry in column]
        if all(has_digits(entry, digits) for entry in entries):
            return columns
        if precision >= max(MOST_BITS, 4 * bits_of(digits)) and all(entry.is_finite() for entry in entries):
            return columns
        precision *= 2


def _checked_digits(digits) -> int:
    digits = whole_number(digits, "digits", minimum=1)
    if digits > MOST_DIGITS:
        raise InputError(f"digits: found {digits}; at most {MOST_DIGITS}")
    return digits


# The exact response to the data of a numeric one.


def exact_response(
    A: PolynomialMatrix, initial: np.ndarray, force: ImpulsiveSmooth, delayed: Sequence[DelayedTerm] = ()
) -> ExactResponse:
    """The exact response x with A(d/dt) x + delayed terms = f from values at 0- of shape (q, r), for exact data."""
    if delayed:
        return ExactDelayedResponse(regular_matrix(A), initial, sources_of(force), terms=delayed)
    return ExactResponse(regular_matrix(A), initial, sources_of(force))


def exact_fraction_response(
    numerator: Sequence[Fraction], denominator: Sequence[Fraction], gamma: int | ImpulsiveSmooth
) -> ExactResponse:
    """y with a(d/dt) y = b(d/dt) u from rest, u = I_gamma or an input with one row; b and a with the lowest power first."""
    if isinstance(gamma, ImpulsiveSmooth):
        acting = sources_of(gamma)
    else:
        shape = Shape(ONE, S**gamma) if gamma > 0 else Shape(S**-gamma)
        acting = (ExactSource(shape, (flint.fmpq(1),), ZERO, flint.fmpq(1)),)
    sources = [replace(one, shape=one.shape.times(polynomial(numerator))) for one in acting]
    return ExactResponse(RationalMatrix([[[c]] for c in denominator]), np.zeros((len(denominator) - 1, 1)), sources)


def exact_combination(row: np.ndarray, A: PolynomialMatrix, initial: np.ndarray, force: ImpulsiveSmooth) -> ExactResponse:
    """The function N(d/dt) f with the values at 0-, N(s) (F(s) + X_in(s)), for a polynomial row N, shape (degree + 1, m)."""
    polynomials = [polynomial(column) for column in row.T]
    sources = [
        replace(source, shape=source.shape.times(p), vector=(entry,))
        for source in sources_of(force)
        for p, entry in zip(polynomials, source.vector)
        if p and entry
    ]
    start = start_transform(known_matrix(A).coefficients, [vector_of(row) for row in initial])
    if shape := sum((p * entry for p, entry in zip(polynomials, start)), flint.fmpq_poly([0])):
        sources.append(ExactSource(Shape(shape), (flint.fmpq(1),), ZERO, flint.fmpq(1)))
    return ExactResponse(RationalMatrix([[[1]]]), np.zeros((0, 1)), sources)


# Boundary values: x(t) = x_p(t) + sum of c_j x_j(t), solved for c in ball arithmetic.


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


# Delays: X(s) is the sum of e^(-s tau) Z_tau(s) over all sums tau of delays, with rational functions from
#
#     A(s) Z_0 = X_in + F,    A(s) Z_tau = - sum of (A_j(s) Z_(tau - delay_j), at tau = delay_j less the values at 0-):
#
# one polynomial matrix with A(s) on its diagonal and A_j(s) below it, whose response is x(t) = sum over tau <= t of z_tau(t - tau). The
# terms cancel, the more the more delays have passed; balls of as many bits as that takes leave every digit.


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
            self._responses[count] = ExactResponse(RationalMatrix(total), start, sources)
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


# Where the exact data have another structure than the numeric answer, and the entry of A(s) on which it depends.


def structure_notices(numeric_count: int, exact: ExactResponse) -> tuple[Notice, ...]:
    """A notice where the exact data have another number of finite zeros than the numeric answer."""
    exact_count = exact.matrix.determinant.degree()
    if numeric_count == exact_count:
        return ()
    text = (
        f"the exact data have {counted(exact_count, 'finite zero')} where the answer has {numeric_count}: it treats differences of the "
        "size of rounding errors as zero; the bounds belong to the exact data, whose motion is a different one"
    )
    return (Notice(NoticeKind.RANK, text, doubtful=True),)


def deciding_entry(A: PolynomialMatrix) -> str:
    """The entry of A(s) whose smallest relative change makes the highest coefficient of det A(s) vanish.

    det A(s) is of first degree in each entry, with an entry of adj A(s) as its slope.
    """
    exact = known_matrix(A)
    places = np.argwhere(A.coefficients).tolist()
    if len(places) > MOST_ENTRIES or not exact.determinant:
        return ""
    highest, changes = exact.determinant.degree(), {}
    for power, i, j in places:
        slope = exact.coefficients[power][i, j] * exact.adjugate[j][i][highest - power] if power <= highest else 0
        if slope:
            changes[power, i, j] = float(fraction(-exact.determinant[highest] / slope))
    if not changes:
        return ""
    (power, i, j), change = min(changes.items(), key=lambda item: abs(item[1]))
    return (
        f'the entry of A_{power} in the equation "{A.equations[i]}" for {A.coordinates[j]}, {A.coefficients[power, i, j]:.17g}, decides: '
        f"{'more' if change > 0 else 'less'} by {abs(change):.2g} of itself it lowers the rank"
    )
