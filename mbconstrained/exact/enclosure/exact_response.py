"""The exact answer to A(d/dt) x = f: impulses, values at 0+, and intervals of any width that contain x(t).

Not the way of the numeric engine: no pencil, no eigenvalue, no rank decision. The transform X(s) is found as a vector of
rational functions over the rationals, and summed over its certified poles in ball arithmetic (FLINT's Arb), with more bits
until the digits asked for are there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import flint
import numpy as np

from ...checks import real_array, whole_number
from ...errors import InputError, SingularPolynomialMatrix
from ..rational.arithmetic import fraction, rational, working_precision
from ..rational.matrix import RationalMatrix
from .balls import bits_of, is_told
from .enclosure import Enclosure
from .factors import Factor, added, ball
from .partial_fractions import Exponentials, PartialFractions
from .rational_response import ZERO, RationalResponse
from .shapes import ONE, S
from .sources import Source, vector_of

#: Bits to begin with, beyond those of the digits asked for.
FIRST_BITS = 40

#: Where so many bits do not give the digits, the value is zero or cancels to so many bits: its interval is as narrow as it is.
MOST_BITS = 1 << 13

#: Who asks for more digits has mistyped.
MOST_DIGITS = 1000


@dataclass(frozen=True)
class Part:
    """A response to one function of time, and when and by how much it is called up.

    Attributes:
        response: x for a start at t = 0 with the factor one.
        calls: times and factors.
    """

    response: RationalResponse
    calls: tuple[tuple[flint.fmpq, Factor], ...]

    @property
    def factors_at_0(self) -> list[Factor]:
        """By how much it is called up at t = 0."""
        return [factor for time, factor in self.calls if time == 0]


class ExactResponse:
    """x with A(d/dt) x = f from values at 0-, all data taken as the exact numbers that they are.

    Args:
        matrix: A(s), regular.
        initial: x^(i)(0-) as row i, q rows of r exact numbers.
        sources: f.
        rows: which of the r rows of x are asked for, all by default.

    Raises:
        SingularPolynomialMatrix: A(s) is not regular.
    """

    def __init__(self, matrix: RationalMatrix, initial: Sequence[Sequence], sources: Sequence[Source], rows: range | None = None):
        self.matrix, self.initial, self.sources = matrix, [vector_of(row) for row in initial], tuple(sources)
        self.rows = range(matrix.size) if rows is None else rows
        if not matrix.determinant:
            raise SingularPolynomialMatrix("det A(s) is zero for every s: the motion is not determined", (), ())

    @property
    def size(self) -> int:
        """How many rows of x are asked for."""
        return len(self.rows)

    def with_rows(self, rows: range) -> ExactResponse:
        """The same answer with other rows of x asked for; det A(s) is not found again."""
        return ExactResponse(self.matrix, self.initial, self.sources, rows)

    @cached_property
    def impulses(self) -> tuple[np.ndarray, ...]:
        """Arrays (r,) of Fractions; the k-th multiplies the k-th derivative of Dirac's delta at t = 0, none at the end is zero.

        Raises:
            InputError: a phase makes them irrational; ``enclose_impulses`` has them as intervals.
        """
        if any(
            not isinstance(factor, flint.fmpq) for part in self._parts if part.response.impulses for factor in part.factors_at_0
        ):
            raise InputError("impulses: with this phase they are no rational numbers; enclose_impulses gives them as intervals")
        return tuple(np.array([fraction(entry) for entry in impulse], dtype=object) for impulse in self._impulses(rational))

    def enclose_impulses(self, digits: int = 15) -> tuple[Enclosure, ...]:
        """The impulses at t = 0 as intervals: the k-th multiplies the k-th derivative of Dirac's delta."""
        digits = _checked_digits(digits)

        def found() -> list[list[flint.arb]]:
            return self._impulses(ball)

        count = len(found())
        return tuple(Enclosure.of(_certain(lambda k=k: [found()[k]], digits)[0], np.zeros(()), digits) for k in range(count))

    @cached_property
    def start(self) -> np.ndarray:
        """x^(i)(0+) as row i, shape (q, r), Fractions; of multipliers and outputs, which have no values at 0-, too.

        Raises:
            InputError: a phase makes them irrational; ``enclose`` at t = 0 has them as intervals.
        """
        total = [[ZERO] * self.size for _ in self.initial]
        for part in self._parts:
            starts = [part.response.start(order) for order in range(len(total))]
            for factor in part.factors_at_0 if any(map(any, starts)) else ():
                if not isinstance(factor, flint.fmpq):
                    raise InputError("start: with this phase it is no rational number; enclose at t = 0 gives it as intervals")
                total = [[a + b * factor for a, b in zip(*rows)] for rows in zip(total, starts)]
        return np.array([[fraction(entry) for entry in row] for row in total], dtype=object).reshape(len(total), self.size)

    @property
    def jump(self) -> np.ndarray:
        """x^(i)(0+) - x^(i)(0-) as row i, shape (q, r), Fractions."""
        before = [[fraction(entry) for entry in (row[k] for k in self.rows)] for row in self.initial]
        return self.start - np.array(before, dtype=object).reshape(self.start.shape)

    def enclose(self, times, digits: int = 15, *, order: int = 0) -> Enclosure:
        """Intervals that contain x^(order)(t), t > 0 (t = 0 means 0+, the time of an event its right limit).

        Args:
            times: in s, a number or shape (T,); the floats are taken exactly.
            digits: of each value, relative to itself. A value that is zero, or that cancels to thousands of bits, has an
                interval about zero instead.
            order: of the derivative.

        Raises:
            InputError: times that are negative or not finite, digits or an order that are no whole numbers in range.
        """
        times = real_array(times, "time")
        if times.ndim > 1 or (times.size and times.min() < 0):
            raise InputError("time: expected a number or a list of numbers, none of them negative (0 means 0+)")
        digits, order = _checked_digits(digits), whole_number(order, "order")
        exact = [rational(float(time)) for time in np.atleast_1d(times)]
        columns = _certain(lambda: self._values(exact, order), digits)
        rows = [list(row) for row in zip(*columns)] if columns else [[] for _ in self.rows]
        return Enclosure.of(rows if times.ndim else [row[0] for row in rows], times, digits)

    @cached_property
    def _parts(self) -> tuple[Part, ...]:
        parts = [Part(self._from_start, ((ZERO, flint.fmpq(1)),)), *self._called()]
        return tuple(part for part in parts if not part.response.is_zero)

    @cached_property
    def _from_start(self) -> RationalResponse:
        """The response to the values at 0- and to what acts from t = 0 on with a rational factor."""
        r, below = self.matrix.size, ONE
        now = [source for source in self.sources if _is_immediate(source)]
        for source in now:
            below = below * (source.shape.denominator // below.gcd(source.shape.denominator))
        total = [p * below for p in self._initial_part()]
        for source in now:
            above = source.shape.numerator * (below // source.shape.denominator) * source.factor
            total = [total[k] + above * source.vector[k] for k in range(r)]
        return RationalResponse(self.matrix, total, below, self.rows)

    def _initial_part(self) -> list[flint.fmpq_poly]:
        """X_in: the sum of A_i s^(i-1-j) x^(j)(0-), j < i (Moysis et al., section 3)."""
        r = self.matrix.size
        total = [flint.fmpq_poly([0])] * r
        for i, matrix in enumerate(self.matrix.coefficients):
            for j in range(i):
                product = (matrix * flint.fmpq_mat([[entry] for entry in self.initial[j]])).entries()
                total = [p + S ** (i - 1 - j) * entry for p, entry in zip(total, product)]
        return total

    def _called(self) -> Iterator[Part]:
        """What acts later, or with an irrational factor: equal functions of time share their response."""
        groups: dict[tuple, list[Source]] = {}
        for source in (source.normalized() for source in self.sources if not _is_immediate(source)):
            groups.setdefault((source.shape.key, source.vector), []).append(source)
        for group in groups.values():
            shape, calls = group[0].shape, added((source.time, source.factor) for source in group)
            b = [shape.numerator * entry for entry in group[0].vector]
            if calls:
                yield Part(RationalResponse(self.matrix, b, shape.denominator, self.rows), calls)

    def _impulses(self, number) -> list[list]:
        """Factors of delta, delta', ... at t = 0, made of numbers of one kind."""
        total: list[list] = []
        for part in self._parts:
            for factor in part.factors_at_0:
                for k, impulse in enumerate(part.response.impulses):
                    if k == len(total):
                        total.append([number(ZERO)] * self.size)
                    total[k] = [a + number(factor) * number(b) for a, b in zip(total[k], impulse)]
        while total and all(entry == 0 for entry in total[-1]):
            total.pop()
        return total

    def _values(self, times: Sequence[flint.fmpq], order: int) -> list[list[flint.arb]]:
        """Columns (r,) of balls, one for each time, at the working precision."""
        columns, exponentials = [_Sum(self.size) for _ in times], Exponentials()
        for part in self._parts:
            modes = part.response.partial_fractions().derivative(order)
            calls = [(begin, factor, ball(factor)) for begin, factor in part.calls]
            for column, time in zip(columns, times):
                acting = [(time - begin, factor, amount) for begin, factor, amount in calls if begin <= time]
                column.add_start(part.response, order, [call for call in acting if not call[0]])
                column.add_later(part.response, order, modes, [call for call in acting if call[0]], exponentials)
        return [column.total() for column in columns]


class _Sum:
    """x at one time: what is rational is added up exactly, so that what cancels leaves nothing, the rest in balls."""

    def __init__(self, size: int):
        self.exact, self.balls = [ZERO] * size, [flint.arb(0)] * size

    def add_start(self, response: RationalResponse, order: int, calls) -> None:
        """What has just begun: x^(order)(0+)."""
        for _, factor, amount in calls:
            start = response.start(order)
            if isinstance(factor, flint.fmpq):
                self.exact = [a + factor * b for a, b in zip(self.exact, start)]
            else:
                self.balls = [a + amount * b for a, b in zip(self.balls, start)]

    def add_later(self, response: RationalResponse, order: int, modes: PartialFractions, calls, exponentials: Exponentials) -> None:
        """What has begun before."""
        known = [(since, factor) for since, factor, _ in calls if isinstance(factor, flint.fmpq)]
        others = [(since, amount) for since, factor, amount in calls if not isinstance(factor, flint.fmpq)]
        if known:
            self.exact = [a + b for a, b in zip(self.exact, response.polynomial_part(order, known))]
        if others:
            self.balls = [a + b for a, b in zip(self.balls, response.polynomial_part(order, others))]
        if calls and modes.poles:
            added = modes.sum_of([(since, amount) for since, _, amount in calls], exponentials)
            self.balls = [a + b for a, b in zip(self.balls, added)]

    def total(self) -> list[flint.arb]:
        """The two together."""
        return [flint.arb(a) + b for a, b in zip(self.exact, self.balls)]


def _is_immediate(source: Source) -> bool:
    return source.time == 0 and isinstance(source.factor, flint.fmpq)


def _certain(compute, digits: int) -> list[list[flint.arb]]:
    """Computed with more and more bits until each value has its digits."""
    precision = bits_of(digits) + FIRST_BITS
    while True:
        with working_precision(precision):
            columns = compute()
        entries = [entry for column in columns for entry in column]
        if all(is_told(entry, digits) for entry in entries):
            return columns
        if precision >= max(MOST_BITS, 4 * bits_of(digits)) and all(entry.is_finite() for entry in entries):
            return columns
        precision *= 2


def _checked_digits(digits) -> int:
    digits = whole_number(digits, "digits", minimum=1)
    if digits > MOST_DIGITS:
        raise InputError(f"digits: found {digits}; at most {MOST_DIGITS}")
    return digits
