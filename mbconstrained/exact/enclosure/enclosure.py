"""Intervals that are sure to contain the values of a response."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction

import numpy as np

from ...checks import counted
from ...errors import InputError
from ...notices import Notice
from .balls import decimal_bounds


@dataclass(frozen=True, repr=False)
class Enclosure:
    """Lower and upper bounds of values, proved by ball arithmetic.

    Attributes:
        lower, upper: decimal strings, of the shape of x(t): (r,) for a number t, (r, T) for times. ``astype(float)`` rounds them to
            the nearest floats, which are values but no bounds any more.
        times: t in s.
        digits: how many were asked for.
        notices: what is worth knowing about them.
    """

    lower: np.ndarray
    upper: np.ndarray
    times: np.ndarray
    digits: int
    notices: tuple[Notice, ...] = ()

    @classmethod
    def of(cls, balls: Sequence, times: np.ndarray, digits: int) -> Enclosure:
        """Of balls (r,) or (r, T)."""
        bounds = [
            [decimal_bounds(b, digits) for b in row] if isinstance(row, list) else decimal_bounds(row, digits) for row in balls
        ]
        table = np.array(bounds, dtype=str).reshape(len(balls), *np.shape(times), 2)
        return cls(table[..., 0], table[..., 1], times, digits)

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.lower.shape))
        told = f"; {counted(len(self.notices), 'notice')}: {self.notices[0].text}" if self.notices else ""
        return f"Enclosure({shape} values, {self.digits} digits asked for{told})"

    def with_notices(self, notices: tuple[Notice, ...]) -> Enclosure:
        """The same with more to know."""
        return replace(self, notices=(*self.notices, *notices))

    def contains(self, values) -> np.bool_:
        """Whether every value lies between its bounds.

        Args:
            values: of the same shape: ints, Fractions, Decimals or decimal strings, exact numbers; or floats, each of which stands
                for all numbers that round to it (half a unit in the last place to both sides).

        Raises:
            InputError: another shape, or what is no number.
        """
        given = self._shaped(values)
        low, high, found, around = _exact(self.lower), _exact(self.upper), _exact(given), _each(_rounding, given)
        return np.bool_(np.all((low <= found + around) & (found - around <= high)))

    def error_bounds(self, values) -> np.ndarray:
        """For each value what its error is at most, as floats, rounded up: a proof, where an estimate is an estimate.

        Args:
            values: of the same shape, floats taken as the exact numbers that they are.

        Raises:
            InputError: as ``contains``.
        """
        low, high, found = _exact(self.lower), _exact(self.upper), _exact(self._shaped(values))
        bounds = np.maximum(found - low, high - found)
        return np.vectorize(_rounded_up, otypes=[float])(bounds) if bounds.size else np.zeros(bounds.shape)

    def _shaped(self, values) -> np.ndarray:
        """The values as they are, in an array."""
        try:
            found = np.array(values, dtype=object)
        except ValueError:
            raise InputError("values: the rows have different lengths; expected the shape of the bounds") from None
        if found.shape != self.lower.shape:
            raise InputError(f"values: found shape {found.shape}; expected {self.lower.shape}, that of the bounds")
        return found


def _exact(values: np.ndarray) -> np.ndarray:
    return _each(_number, values)


def _each(function, values: np.ndarray) -> np.ndarray:
    found = np.empty(values.shape, dtype=object)
    for place, value in np.ndenumerate(values):
        found[place] = function(value)
    return found


def _number(value) -> Fraction:
    try:
        return Fraction(Decimal(value)) if isinstance(value, str) else Fraction(value.item() if hasattr(value, "item") else value)
    except (ArithmeticError, TypeError, ValueError):
        raise InputError(f"values: found {value!r}; expected finite numbers, or decimal strings") from None


def _rounding(value) -> Fraction:
    """Half a unit in the last place of a float of any size, nothing for other numbers."""
    return Fraction(float(np.spacing(abs(value)))) / 2 if isinstance(value, (float, np.floating)) else Fraction(0)


def _rounded_up(value: Fraction) -> float:
    try:
        near = float(value)
    except OverflowError:
        return np.inf
    return near if Fraction(near) >= value else float(np.nextafter(near, np.inf))
