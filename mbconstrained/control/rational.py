"""A transfer function b(s)/a(s) with exact coefficients: reading, leading zeros, the common factor."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from numbers import Rational, Real

import numpy as np

from ..ground.checks import counted
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..polynomial.structure import polynomial_text

EXPECTED = "expected its coefficients as a list of real numbers, the highest power first, e.g. [1.0, 3.0, 2.0]"


@dataclass(frozen=True)
class RationalFunction:
    """b(s)/a(s) with exact coefficients, lowest power first."""

    numerator: Polynomial  # numerator, denominator: b and a as given, without zeros at the highest powers; b empty where it is zero
    denominator: Polynomial
    left_out: tuple[int, int] = (0, 0)  # number of leading zeros removed from both
    rounded: bool = False  # whether some coefficient was given in float64, known up to its rounding error; other numbers are exact

    @cached_property
    def as_written(self) -> RationalFunction:
        """The fraction with the shortest decimals that round to the floats: 0.1 as 1/10."""
        if not self.rounded:
            return self
        numerator, denominator = (tuple(map(_as_written, p)) for p in (self.numerator, self.denominator))
        return RationalFunction(numerator, denominator, self.left_out, True)

    @cached_property
    def common_factor(self) -> Polynomial:
        """The exact common factor of b and a: of the floats as binary numbers, or else of their decimals."""
        return self._common_factor if len(self._common_factor) > 1 else self.as_written._common_factor

    @cached_property
    def reduced(self) -> RationalFunction:
        """The fraction without its common factor."""
        from ..exact.rational import fractions_of, polynomial

        if len(self.common_factor) == 1:
            return self
        exact = self if len(self._common_factor) > 1 else self.as_written
        factor = polynomial(self.common_factor)
        b, a = (fractions_of(polynomial(p) // factor) for p in (exact.numerator, exact.denominator))
        return RationalFunction(b, a, (0, 0), self.rounded)

    @cached_property
    def written_reduced(self) -> RationalFunction:
        """The fraction without its common factor, with the shortest decimals."""
        return self.reduced if len(self.common_factor) > 1 else self.as_written

    @cached_property
    def zero_poles(self) -> int:
        """n0, the order of the pole of 1/a(s) at s = 0 (Hauksdottir and Sigurdsson, Eq. 34)."""
        return next(k for k, c in enumerate(self.denominator) if c)

    def without_zero_poles(self, gamma: int) -> tuple[RationalFunction, int]:
        """The fraction without zeros and poles at s = 0, and the input I_gamma that has them (Eq. 34).

        >>> reduced, gamma = rational_function([1, 0], [1, 2, 0, 0]).without_zero_poles(-1)  # s / (s^2 (s + 2)) and delta'
        >>> [int(c) for c in reduced.denominator], gamma
        ([2, 1], 0)
        """
        zeros = next((k for k, c in enumerate(self.numerator) if c), 0)
        reduced = RationalFunction(self.numerator[zeros:], self.denominator[self.zero_poles :], rounded=self.rounded)
        return reduced, gamma + self.zero_poles - zeros

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Given coefficients without influence on the response."""
        notices = [
            Notice(NoticeKind.OMITTED, f"{name}: {counted(count, 'leading zero')} left out")
            for name, count in zip(("numerator", "denominator"), self.left_out)
            if count
        ]
        if len(self.common_factor) > 1:
            text = "numerator and denominator have the common factor"
            notices.append(
                Notice(NoticeKind.OMITTED, f"{text} {polynomial_text(self.common_factor)}: it does not act on a response from rest")
            )
        return tuple(notices)

    @cached_property
    def _common_factor(self) -> Polynomial:
        from ..exact.rational import fractions_of, polynomial

        return fractions_of(polynomial(self.numerator).gcd(polynomial(self.denominator))) if self.numerator else ONE


def rational_function(numerator, denominator) -> RationalFunction:
    """Read b and a.

    >>> fraction = rational_function([0, 1, 1], [1.0, 3.0, 2.0])
    >>> fraction.left_out, [int(c) for c in fraction.common_factor], [int(c) for c in fraction.reduced.denominator]
    ((1, 0), [1, 1], [2, 1])
    """
    read = [_coefficients(value, what) for value, what in ((numerator, "numerator"), (denominator, "denominator"))]
    b, a = (trimmed(coefficients[::-1]) for coefficients, _ in read)
    if not a:
        raise InputError("denominator: every coefficient is zero; a transfer function needs a denominator other than zero")
    left_out = tuple(len(coefficients) - max(len(kept), 1) for (coefficients, _), kept in zip(read, (b, a)))
    return RationalFunction(b, a, left_out, any(rounded for _, rounded in read))


def _coefficients(value, what: str) -> tuple[list[Fraction], bool]:
    """The coefficients as Fractions, and whether some are floats other than whole numbers."""
    items = [value] if isinstance(value, (Real, Decimal)) or (np.ndim(value) == 0 and isinstance(value, np.ndarray)) else value
    if isinstance(items, (str, bytes, dict)) or not isinstance(items, Iterable):
        raise InputError(f"{what}: found {_short(value)}; {EXPECTED}")
    numbers = [_number(item, what, place) for place, item in enumerate(items)]
    if not numbers:
        raise InputError(f"{what}: found no coefficient; {EXPECTED}")
    return numbers, any(
        not isinstance(item, (Rational, Decimal, np.integer)) and c.denominator > 1 for item, c in zip(items, numbers)
    )


def _number(item, what: str, place: int) -> Fraction:
    if isinstance(item, np.ndarray) and item.ndim == 0:
        item = item.item()
    if isinstance(item, (bool, np.bool_)) or not isinstance(item, (Real, Decimal)):
        several = isinstance(item, (Iterable, np.ndarray)) and not isinstance(item, str)
        remedy = "; of several inputs or outputs use mb.matrix_fraction_response" if several else ""
        raise InputError(f"{what}: the coefficient at {place} is {_short(item)}; {EXPECTED}{remedy}")
    try:
        number = (
            Fraction(int(item.numerator), int(item.denominator))
            if isinstance(item, Rational)
            else Fraction(item if isinstance(item, Decimal) else float(item))
        )
        lost = bool(number) and float(number) == 0.0
    except (ValueError, OverflowError):
        raise InputError(
            f"{what}: the coefficient at {place} is {_short(item)}; expected a finite number in the range of float64"
        ) from None
    if lost:
        raise InputError(f"{what}: the coefficient at {place} lies below the range of float64; choose another unit of time")
    return number


def _as_written(number: Fraction) -> Fraction:
    value = float(number)
    return Fraction(repr(value)) if Fraction(value) == number else number


def _short(value) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


# Polynomials in one variable over the rationals: tuples of Fractions, lowest power first, without zeros at the end; the zero polynomial
# is empty. FLINT computes with them: the common factor of degree 3 of two polynomials of degree 63 takes 0.3 ms, where Euclid's
# algorithm on Fractions takes 0.7 s.

Polynomial = tuple[Fraction, ...]

ONE: Polynomial = (Fraction(1),)


def trimmed(coefficients: Sequence[Fraction]) -> Polynomial:
    """The polynomial without zeros at the highest powers."""
    count = max((k + 1 for k, c in enumerate(coefficients) if c), default=0)
    return tuple(coefficients[:count])
