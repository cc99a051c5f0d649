"""Arrays of numbers with twice the digits of float64, the same on every processor: unevaluated sums of two float64 numbers.

Sums are right to 3 * 2^-106 of themselves even where they cancel (Joldes, Muller and Popescu 2017), products are Dekker's ("A
floating-point technique for extending the available precision", 1971). Numbers below 1e-290 lose digits by underflow.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from .division import product_with_error, split, sum_with_error

#: Bound of the relative error of a sum or a product of real or complex numbers, relative to the sum of the absolute values.
DOUBLED_EPS = 2.0**-103

#: Bound of the relative error of ``exponential``, and of sums of products with it.
EXPONENTIAL_EPS = 2.0**-64

#: e^z is a product of tabulated e^(2 pi i j / PARTS) and 2^(k / PARTS), and of a short series.
PARTS = 256

#: Digits of the tables, in bits.
TABLE_BITS = 160


@dataclass(frozen=True, eq=False)
class DoubleDouble:
    """high + low of float64 or complex arrays, low at most half a unit in the last place of high."""

    high: np.ndarray
    low: np.ndarray

    __array_ufunc__ = None  # products with arrays are those below

    @classmethod
    def of(cls, values) -> DoubleDouble:
        """The numbers themselves; of arrays in extended precision the nearest numbers."""
        if isinstance(values, DoubleDouble):
            return values
        values = np.asarray(values)
        if values.dtype in (float, complex):
            return cls(values, np.zeros(values.shape, values.dtype))
        high = values.astype(complex if values.dtype.kind == "c" else float)
        return cls(high, (values - high).astype(high.dtype))

    @property
    def shape(self) -> tuple[int, ...]:
        return self.high.shape

    @property
    def real(self) -> DoubleDouble:
        return DoubleDouble(self.high.real, self.low.real)

    @property
    def imag(self) -> DoubleDouble:
        return DoubleDouble(self.high.imag, self.low.imag)

    def __getitem__(self, key) -> DoubleDouble:
        return DoubleDouble(self.high[key], self.low[key])

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.high, -self.low)

    def __add__(self, other) -> DoubleDouble:
        if not isinstance(other, DoubleDouble):
            other = DoubleDouble.of(other)
            if not other.low.any():
                total, error = sum_with_error(self.high, other.high)
                return _renormalized(total, self.low + error)
        (total, error), (small, rest) = sum_with_error(self.high, other.high), sum_with_error(self.low, other.low)
        result = _renormalized(total, error + small)
        return _renormalized(result.high, result.low + rest)

    __radd__ = __add__

    def __sub__(self, other) -> DoubleDouble:
        return self + -other

    def __mul__(self, other) -> DoubleDouble:
        other = DoubleDouble.of(other)
        is_complex, is_other_complex = (number.high.dtype.kind == "c" for number in (self, other))
        if not (is_complex or is_other_complex):
            total, error = product_with_error(self.high, other.high)
            return _renormalized(total, error + (self.high * other.low + self.low * other.high))
        if not is_complex:
            return other * self
        (high, low), axes = self._parts(), max(self.high.ndim, other.high.ndim)
        (high, low) = (part.reshape(2, *[1] * (axes - self.high.ndim), *self.shape) for part in (high, low))
        if not is_other_complex:
            total, error = product_with_error(high, other.high)
            return _paired(*_renormalized_parts(total, error + (high * other.low + low * other.high)))
        (own, rest), one = other._parts(), (2, 1, *[1] * (axes - other.high.ndim), *other.shape)
        own, high = own.reshape(one), np.array([high, high[::-1]])
        total, error = product_with_error(high, own)  # (a c, b c) and (b d, a d)
        if other.low.any():
            error += high * rest.reshape(one)
        if self.low.any():
            error += np.array([low, low[::-1]]) * own
        total[1, 0], error[1, 0] = -total[1, 0], -error[1, 0]
        total, more = sum_with_error(total[0], total[1])
        return _paired(*_renormalized_parts(total, error[0] + error[1] + more))

    def times(self, factors: np.ndarray) -> DoubleDouble:
        """The numbers times float64 numbers, which may be powers of two."""
        return self.scaled(factors) if (np.abs(np.frexp(factors)[0]) == 0.5).all() else self * factors

    def scaled(self, units) -> DoubleDouble:
        """The numbers times powers of two."""
        return DoubleDouble(self.high * units, self.low * units)

    def _parts(self) -> tuple[np.ndarray, np.ndarray]:
        """Real and imaginary parts along a new first axis."""
        return np.array([self.high.real, self.high.imag]), np.array([self.low.real, self.low.imag])

    def __rmatmul__(self, matrix: np.ndarray) -> DoubleDouble:
        """matrix @ self of a float64 matrix with few entries, each row summed entry by entry."""
        if np.iscomplexobj(self.high):
            parts = (np.ascontiguousarray(part).view(float) for part in (self.high, self.low))
            both = matrix @ DoubleDouble(*parts)
            return DoubleDouble(both.high.view(complex), both.low.view(complex))
        row, column = matrix.nonzero()
        counts, factors = np.bincount(row, minlength=len(matrix)), matrix[row, column][:, None]
        own = self[column].times(factors)
        if (counts == 1).all():
            return own
        place = np.arange(len(row)) - (np.cumsum(counts) - counts)[row]
        terms = np.zeros((2, counts.max(initial=0), len(matrix), self.shape[1]))
        terms[0, place, row], terms[1, place, row] = own.high, own.low
        return DoubleDouble(*terms).sum()

    def sum(self) -> DoubleDouble:
        """The sum along the first axis, pairwise; the errors of the sums are summed in float64."""
        high, low = self.high, self.low
        if not len(high):
            return DoubleDouble(np.zeros(self.shape[1:]), np.zeros(self.shape[1:]))
        while (count := len(high)) > 1:
            half = count // 2
            total, error = sum_with_error(high[:half], high[half : 2 * half])
            error += low[:half] + low[half : 2 * half]
            if count % 2:
                total, error = np.concatenate([total, high[-1:]]), np.concatenate([error, low[-1:]])
            high, low = total, error
        return _renormalized(high[0], low[0])


def _renormalized(high: np.ndarray, low: np.ndarray) -> DoubleDouble:
    return DoubleDouble(*_renormalized_parts(high, low))


def _renormalized_parts(high: np.ndarray, low: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    total = high + low
    return total, low - (total - high)


def _complex(real: DoubleDouble, imaginary: DoubleDouble) -> DoubleDouble:
    return DoubleDouble(real.high + 1j * imaginary.high, real.low + 1j * imaginary.low)


def _paired(high: np.ndarray, low: np.ndarray) -> DoubleDouble:
    """Complex numbers from their real and imaginary parts along the first axis."""
    result = np.empty((2, *high.shape[1:]), dtype=complex)
    result.real, result.imag = (high[0], low[0]), (high[1], low[1])
    return DoubleDouble(*result)


def stacked(*parts: DoubleDouble) -> DoubleDouble:
    """Arrays one after another, along the first axis."""
    return DoubleDouble(np.concatenate([part.high for part in parts]), np.concatenate([part.low for part in parts]))


def outer(left: DoubleDouble, right: DoubleDouble) -> DoubleDouble:
    """The products of real numbers of two vectors; the factors are split before they are multiplied."""
    (a, b), (c, d) = split(left.high), split(right.high)
    total = np.multiply.outer(left.high, right.high)
    error = np.multiply.outer(a, c)
    error -= total
    for one, other in ((a, d), (b, c), (b, d), (left.high, right.low), (left.low, right.high)):
        error += np.multiply.outer(one, other)
    return _renormalized(total, error)


def turns(exponents: DoubleDouble) -> tuple[DoubleDouble, DoubleDouble]:
    """The real parts in units of log 2, and the imaginary parts in full turns."""
    constants = _constants()[0]
    return exponents.real * constants[0], exponents.imag * constants[1]


def exponential(growth: DoubleDouble, turned: DoubleDouble) -> DoubleDouble:
    """2^growth e^(2 pi i turned) to ``EXPONENTIAL_EPS``."""
    constants, circle, powers = _constants()
    angle, step = _parted(turned)
    angle = angle * constants[2]
    square = angle.high**2
    cosine = square * (square * (1 / 24 - square / 720) - 0.5)
    sine = angle.high * square * (square * (1 / 120 - square / 5040) - 1 / 6)
    series = _renormalized(1 + 1j * angle.high, cosine + 1j * (angle.low + sine))
    result = circle[step % PARTS] * series
    if not growth.high.any():
        return result
    exponent, step = _parted(growth)
    exponent = exponent * constants[3]
    x = exponent.high
    rest = x * x * (0.5 + x * (1 / 6 + x * (1 / 24 + x * (1 / 120 + x / 720))))
    series = DoubleDouble(np.ones(x.shape), np.zeros(x.shape)) + exponent + rest
    result = result * (powers[step % PARTS] * series)
    unit = np.ldexp(1.0, step // PARTS)
    return DoubleDouble(result.high * unit, result.low * unit)


def _parted(values: DoubleDouble) -> tuple[DoubleDouble, np.ndarray]:
    """The distance to the nearest multiple of 1 / PARTS, and the multiple as a whole number."""
    whole = np.rint(values.high)
    rest = (values - whole).scaled(PARTS)
    nearest = np.rint(rest.high)
    return (rest - nearest).scaled(1.0 / PARTS), (whole * PARTS + nearest).astype(np.int64)


@cache
def _constants() -> tuple[DoubleDouble, DoubleDouble, DoubleDouble]:
    """(1 / log 2, 1 / (2 pi), 2 pi, log 2), the circle and the powers of two, from whole numbers of ``TABLE_BITS`` bits."""
    one = 1 << TABLE_BITS

    def atanh_or_atan(divisor: int, sign: int) -> int:
        total, power, k = 0, one // divisor, 0
        while power:
            total += sign**k * (power // (2 * k + 1))
            power, k = power // divisor**2, k + 1
        return total

    two_pi = 32 * atanh_or_atan(5, -1) - 8 * atanh_or_atan(239, -1)  # Machin
    log_two = 2 * atanh_or_atan(3, 1)

    def series(x: int, i: bool) -> tuple[int, int]:
        parts, term, k = [0, 0], one, 0
        while term:
            parts[i and k % 2] += -term if i and k % 4 > 1 else term
            k += 1
            term = term * x // one // k
        return parts[0], parts[1]

    (cosine, sine), (ratio, _) = series(two_pi // PARTS, True), series(log_two // PARTS, False)
    circle, powers = [(one, 0)], [one]
    for _ in range(PARTS - 1):
        real, imaginary = circle[-1]
        circle.append(((real * cosine - imaginary * sine) // one, (real * sine + imaginary * cosine) // one))
        powers.append(powers[-1] * ratio // one)
    constants = _of_whole([one * one // log_two, one * one // two_pi, two_pi, log_two])
    return constants, _complex(*(_of_whole(list(part)) for part in zip(*circle))), _of_whole(powers)


def _of_whole(values: list[int]) -> DoubleDouble:
    """Whole numbers divided by 2^TABLE_BITS."""
    unit = 2.0**-TABLE_BITS
    high = [float(value) for value in values]
    low = [float(value - int(part)) for value, part in zip(values, high)]
    return DoubleDouble(np.array(high) * unit, np.array(low) * unit)
