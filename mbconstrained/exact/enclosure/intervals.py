"""Guaranteed intervals that contain the values of a response."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction

import flint
import numpy as np

from ...ground.by_name import Public
from ...ground.checks import counted, whole_number
from ...ground.errors import InputError, Overflow
from ...ground.notices import Notice
from ...polynomial.delayed_terms import DelayedTerm
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ..rational import known_matrix, rational, rational_matrix, value_at, working_precision


@dataclass(frozen=True, repr=False, eq=False)
class Enclosure(Public):
    """Lower and upper bounds of values, proved by ball arithmetic.

    Attributes:
        lower, upper: decimal strings, of the shape of x(t): (r,) for a number t, (r, T) for times. ``astype(float)`` rounds them to
            the nearest floats, which are values but no bounds any more.
        times: t in s.
        digits: the requested number of digits.
        notices: remarks about the values.
    """

    lower: np.ndarray
    upper: np.ndarray
    times: np.ndarray
    digits: int
    notices: tuple[Notice, ...] = ()

    @classmethod
    def of(cls, balls: Sequence, times: np.ndarray, digits: int) -> Enclosure:
        """Return the enclosure of balls (r,) or (r, T).

        Args:
            balls: shape (r,) or (r, T).
            times: times in s.
            digits: the requested number of digits.

        Returns:
            The balls as decimal strings, rounded outwards.
        """
        bounds = [
            [decimal_bounds(b, digits) for b in row] if isinstance(row, list) else decimal_bounds(row, digits) for row in balls
        ]
        table = np.array(bounds, dtype=str).reshape(len(balls), *np.shape(times), 2)
        return cls(table[..., 0], table[..., 1], times, digits)

    @property
    def middle(self) -> np.ndarray:
        """The middle of each interval in float64."""
        return (self.lower.astype(float) + self.upper.astype(float)) / 2

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.lower.shape))
        remark = f"; {counted(len(self.notices), 'notice')}: {self.notices[0].text}" if self.notices else ""
        return f"Enclosure({shape} values, {self.digits} requested digits{remark})"

    def with_notices(self, notices: tuple[Notice, ...]) -> Enclosure:
        """Return the enclosure with further notices."""
        return replace(self, notices=(*self.notices, *notices))

    def contains(self, values) -> np.bool_:
        """Return whether every value lies between its bounds.

        Args:
            values: of the same shape: ints, Fractions, Decimals or decimal strings, exact numbers; or floats, each of which stands
                for all numbers that round to it (half a unit in the last place to both sides).

        Raises:
            InputError: another shape, or an entry that is no number.
        """
        given = self._shaped(values)
        low, high, exact, around = _exact(self.lower), _exact(self.upper), _exact(given), np.vectorize(_rounding, [object])(given)
        return np.bool_(np.all((low <= exact + around) & (exact - around <= high)))

    def error_bounds(self, values) -> np.ndarray:
        """Return a proved bound of the error of each value, as floats, rounded up.

        Args:
            values: values of the same shape; floats are the exact numbers that they are.

        Raises:
            InputError: as ``contains``.
        """
        low, high, exact = _exact(self.lower), _exact(self.upper), _exact(self._shaped(values))
        bounds = np.maximum(exact - low, high - exact)
        return np.vectorize(_rounded_up, [float])(bounds)

    def _shaped(self, values) -> np.ndarray:
        """The values in an array of the requested shape."""
        try:
            array = np.array(values, dtype=object)
        except ValueError:
            raise InputError("values: the rows have different lengths; expected the shape of the bounds") from None
        if array.shape != self.lower.shape:
            raise InputError(f"values: found shape {array.shape}; expected {self.lower.shape}, that of the bounds")
        return array


def _number(value) -> Fraction:
    try:
        return Fraction(Decimal(value)) if isinstance(value, str) else Fraction(value.item() if hasattr(value, "item") else value)
    except (ArithmeticError, TypeError, ValueError):
        raise InputError(f"values: found {value!r}; expected finite numbers, or decimal strings") from None


_exact = np.vectorize(_number, [object])


def _rounding(value) -> Fraction:
    """Half a unit in the last place of a float of any size, nothing for other numbers."""
    return Fraction(float(np.spacing(abs(value)))) / 2 if isinstance(value, (float, np.floating)) else Fraction(0)


def _rounded_up(value: Fraction) -> float:
    try:
        near = float(value)
    except OverflowError:
        return np.inf
    return near if Fraction(near) >= value else float(np.nextafter(near, np.inf))


# From balls to decimal strings: rounded outwards, so that what they bound stays between them.

#: Digits of the strings beyond the requested ones.
MORE_DIGITS = 3

#: Ends of balls are rounded outwards to so many bits more than the strings have.
GUARD_BITS = 24

#: The largest power of ten that is written out; what is smaller than its inverse has an interval of that size about zero.
LARGEST_POWER = 100_000


def bits_of(digits: int) -> int:
    """Number of bits that contain this number of decimal digits."""
    return digits * 10 // 3 + 2


def has_digits(value: flint.arb, digits: int) -> bool:
    """Whether the ball has the digits, or is small enough to need none."""
    return value.rel_accuracy_bits() >= bits_of(digits) or bool(value.abs_upper() < flint.arb(10) ** -LARGEST_POWER)


def decimal_bounds(value: flint.arb, digits: int) -> tuple[str, str]:
    """Two decimal numbers that contain the ball, with some more digits than requested."""
    with working_precision(bits_of(digits) + GUARD_BITS):
        largest = value.abs_upper()
        if not largest < flint.arb(10) ** LARGEST_POWER:
            raise Overflow(
                f"a value may be larger than 1e{LARGEST_POWER}: a zero of A(s) in the right half plane grows beyond; "
                "ask for earlier times"
            )
        if not largest.is_zero() and largest < flint.arb(10) ** -LARGEST_POWER:
            low, high = value.lower() < 0, value.upper() > 0
            return f"-1E-{LARGEST_POWER}" if low else "0", f"1E-{LARGEST_POWER}" if high else "0"
        return _decimal(value.lower(), digits, ROUND_FLOOR), _decimal(value.upper(), digits, ROUND_CEILING)


def _decimal(value: flint.arb, digits: int, rounding: str) -> str:
    """An exact ball, that is a number, rounded to some more digits than requested."""
    (mantissa, exponent), context = map(int, value.man_exp()), Context(prec=digits + MORE_DIGITS, rounding=rounding)
    quotient = context.divide(Decimal(mantissa << max(exponent, 0)), Decimal(1 << max(-exponent, 0)))
    return str(context.normalize(quotient))


# Intervals that contain s^p C A(s)^-1 B at s = 2 pi f i, for exact data.

#: Working precision in bits beyond the digits, in turn; the last is a sign of a pole.
GUARDS = (64, 256, 1024, 4096)

#: What is smaller than 2 to this power is zero in float64: of a response that vanishes no digits are asked.
BELOW_FLOAT64 = -1075


def enclosed_transfer(
    A: PolynomialMatrix,
    imaginary,
    inputs,
    outputs,
    power: int,
    frequency_hz: float,
    digits: int,
    delayed: Sequence[DelayedTerm] = (),
    input_delays: Sequence[float] = (),
) -> Enclosure:
    """s^p C (A(s) + i H + delayed terms)^-1 B at one frequency, with the dead times of the inputs."""
    digits = whole_number(digits, "digits", minimum=1)
    exact = known_matrix(A).coefficients
    late = [(rational(term.decimal), [rational_matrix(one) for one in term.coefficients]) for term in delayed]
    for guard in GUARDS:
        with working_precision(bits_of(digits) + guard):
            values = _transfer(exact, imaginary, inputs, outputs, power, frequency_hz, late, input_delays)
            if values is not None and all(_is_known(value, digits) for value in values):
                return Enclosure.of([[v.real for v in values], [v.imag for v in values]], np.zeros(len(values)), digits)
    raise InputError(f"frequency_hz: found {frequency_hz:g} Hz, where the response has a pole; enclose it at another frequency")


def _is_known(value: flint.acb, digits: int) -> bool:
    if not value.is_finite():
        return False
    size = value.abs_upper()
    limit = size * flint.arb(10) ** -digits
    return bool(size < flint.arb(2) ** BELOW_FLOAT64) or all(
        part == 0 or has_digits(part, digits) or bool(part.abs_upper() < limit) for part in (value.real, value.imag)
    )


def _transfer(
    exact: Sequence[flint.fmpq_mat],
    imaginary,
    inputs,
    outputs,
    power: int,
    frequency_hz: float,
    delayed: Sequence[tuple[flint.fmpq, Sequence[flint.fmpq_mat]]],
    input_delays: Sequence[float],
) -> list[flint.acb] | None:
    omega = 2 * flint.arb.pi() * flint.arb(rational(Fraction(frequency_hz)))
    s = flint.acb(0, omega)
    matrix = value_at([flint.acb_mat(one) for one in exact], s)
    for delay, term in delayed:
        matrix = matrix + value_at([flint.acb_mat(one) for one in term], s) * (-s * flint.arb(delay)).exp()
    if imaginary is not None:
        matrix = matrix + flint.acb_mat(rational_matrix(imaginary)) * flint.acb(0, 1)
    try:
        X = matrix.solve(flint.acb_mat(inputs.tolist()))
    except ZeroDivisionError:
        return None
    H = flint.acb_mat(outputs.tolist()) * X * s**power
    for j, delay in enumerate(input_delays):
        late = (-s * flint.arb(rational(Fraction(repr(delay))))).exp()
        for i in range(H.nrows()):
            H[i, j] *= late
    return [H[i, j] for i in range(H.nrows()) for j in range(H.ncols())]
