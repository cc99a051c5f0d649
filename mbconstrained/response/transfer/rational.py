"""A transfer function b(s)/a(s) as its user gives it, exactly: read, without leading zeros, its common factor apart."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from numbers import Rational, Real

import numpy as np

from ...checks import counted
from ...errors import InputError
from ...notices import Notice
from .polynomials import ONE, Polynomial, common_factor, divided, trimmed

EXPECTED = "expected its coefficients as a list of real numbers, the highest power first, e.g. [1.0, 3.0, 2.0]"


@dataclass(frozen=True)
class RationalFunction:
    """b(s)/a(s) with exact coefficients, lowest power first.

    Attributes:
        numerator, denominator: b and a as given, without zeros at the highest powers; b empty where it is zero.
        left_out: how many zeros were left out of both.
        rounded: whether some coefficient was given in float64, known to a rounding only; other numbers are exact.
    """

    numerator: Polynomial
    denominator: Polynomial
    left_out: tuple[int, int] = (0, 0)
    rounded: bool = False

    @cached_property
    def as_written(self) -> RationalFunction:
        """With the shortest decimals that stand for the floats: 0.1 as 1/10."""
        if not self.rounded:
            return self
        numerator, denominator = (tuple(map(_as_written, p)) for p in (self.numerator, self.denominator))
        return RationalFunction(numerator, denominator, self.left_out, True)

    @cached_property
    def common_factor(self) -> Polynomial:
        """What b and a have in common, exactly: as the numbers that they are, or else as they are written."""
        return self._common_factor if len(self._common_factor) > 1 else self.as_written._common_factor

    @cached_property
    def reduced(self) -> RationalFunction:
        """Without the common factor."""
        if len(self.common_factor) == 1:
            return self
        exact = self if len(self._common_factor) > 1 else self.as_written
        b, a = (divided(p, self.common_factor)[0] for p in (exact.numerator, exact.denominator))
        return RationalFunction(b, a, (0, 0), self.rounded)

    @cached_property
    def written_reduced(self) -> RationalFunction:
        """Without the common factor, with short numbers where they are to be had."""
        return self.reduced if len(self.common_factor) > 1 else self.as_written

    @cached_property
    def zero_poles(self) -> int:
        """n0, the order of the pole of 1/a(s) at s = 0 (Hauksdottir and Sigurdsson, Eq. 34)."""
        return next(k for k, c in enumerate(self.denominator) if c)

    def without_zero_poles(self, gamma: int) -> tuple[RationalFunction, int]:
        """The same response of a fraction without zeros and poles at s = 0, with them in the input (Eq. 34): exactly as often.

        >>> found, gamma = rational_function([1, 0], [1, 2, 0, 0]).without_zero_poles(-1)  # s / (s^2 (s + 2)) and delta'
        >>> [int(c) for c in found.denominator], gamma
        ([2, 1], 0)
        """
        zeros = next((k for k, c in enumerate(self.numerator) if c), 0)
        found = RationalFunction(self.numerator[zeros:], self.denominator[self.zero_poles :], rounded=self.rounded)
        return found, gamma + self.zero_poles - zeros

    @property
    def notices(self) -> tuple[Notice, ...]:
        """What of the given coefficients does not act on the response."""
        found = [
            Notice("left out", f"{name}: {counted(count, 'leading zero')} left out")
            for name, count in zip(("numerator", "denominator"), self.left_out)
            if count
        ]
        if len(self.common_factor) > 1:
            text = "numerator and denominator have the common factor"
            found.append(Notice("left out", f"{text} {shown(self.common_factor)}: it does not act on a response from rest"))
        return tuple(found)

    @cached_property
    def _common_factor(self) -> Polynomial:
        return common_factor(self.numerator, self.denominator) if self.numerator else ONE


def rational_function(numerator, denominator) -> RationalFunction:
    """Read b and a, highest power first as in scipy.signal.

    Raises:
        InputError: not a list of real finite numbers, an empty list, a zero denominator.

    >>> found = rational_function([0, 1, 1], [1.0, 3.0, 2.0])
    >>> found.left_out, [int(c) for c in found.common_factor], [int(c) for c in found.reduced.denominator]
    ((1, 0), [1, 1], [2, 1])
    """
    read = [_coefficients(value, what) for value, what in ((numerator, "numerator"), (denominator, "denominator"))]
    b, a = (trimmed(coefficients[::-1]) for coefficients, _ in read)
    if not a:
        raise InputError("denominator: every coefficient is zero; a transfer function needs a denominator other than zero")
    left_out = tuple(len(coefficients) - max(len(kept), 1) for (coefficients, _), kept in zip(read, (b, a)))
    return RationalFunction(b, a, left_out, any(rounded for _, rounded in read))


def shown(polynomial: Polynomial) -> str:
    """The polynomial in s as text.

    >>> shown((Fraction(-1), Fraction(5, 2), Fraction(1)))
    's^2 + 2.5 s - 1'
    """
    words = ""
    for power, c in reversed(list(enumerate(polynomial))):
        if c:
            sign = (" - " if c < 0 else " + ") if words else "-" * (c < 0)
            size = f"{float(abs(c)):.6g}" if abs(c) != 1 or not power else ""
            words += sign + " ".join(filter(None, (size, _power(power))))
    return words or "0"


def _power(power: int) -> str:
    return "" if power == 0 else "s" if power == 1 else f"s^{power}"


def _coefficients(value, what: str) -> tuple[list[Fraction], bool]:
    """The numbers as Fractions, and whether some are floats other than whole numbers."""
    items = [value] if isinstance(value, (Real, Decimal)) or np.ndim(value) == 0 and isinstance(value, np.ndarray) else value
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
        number = Fraction(int(item.numerator), int(item.denominator)) if isinstance(item, Rational) else _of_real(item)
        lost = bool(number) and float(number) == 0.0
    except (ValueError, OverflowError):
        raise InputError(
            f"{what}: the coefficient at {place} is {_short(item)}; expected a finite number in the range of float64"
        ) from None
    if lost:
        raise InputError(f"{what}: the coefficient at {place} lies below the range of float64; choose another unit of time")
    return number


def _of_real(item) -> Fraction:
    return Fraction(item) if isinstance(item, Decimal) else Fraction(float(item))


def _as_written(number: Fraction) -> Fraction:
    value = float(number)
    return Fraction(repr(value)) if Fraction(value) == number else number


def _short(value) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
