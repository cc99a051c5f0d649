"""Taylor series of a response just after t = 0+, and a function that uses it while it is more accurate than the modes.

From rest a coordinate far from the force begins like t^p, a tiny difference of modes that are not small:
their sum cancels, the series (``response.methods.taylor``) does not.

The series loses up to e^(2 rate t) units in the last place, where the rate bounds the growth from one
derivative to the next. The modal sum's loss is measured: by how much more than the noise of the series it differs
from it for rate t <= 1. Each row is left to the modal sum where the noise of its series exceeds that.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil, exp, log

import numpy as np

from ...ground.checks import counted, real_array, whole_number
from ...ground.tolerances import EPS, NOISE_SAFETY
from ...linalg.blocks import CHUNK_ENTRIES
from ...signals.bohl import BohlFunction

#: The series serves for rate * t up to this: e^(2 rate t) times EPS is then the root of EPS, half of the digits.
REACH = -log(EPS) / 4

#: Terms after the first one that is not zero: the tail (e REACH / k)^k of REACH^k / k! is then below EPS.
TERMS = ceil(6 * REACH)

#: The norm of the power 2^SQUARINGS of a matrix, its root taken, is the Perron root to a percent for all usual sizes.
SQUARINGS = 10

#: The range of float64 ends here.
LARGEST = float(np.finfo(float).max)

#: Points of comparison, in spans: two times per factor of two, down to the rounding error of the span.
PLACES = 2.0 ** (-np.arange(2 * 52) / 2)

#: Of these the ones up to rate t = 1.
EARLY = slice(int((PLACES > 1 / REACH).sum()), None)


@dataclass(frozen=True, repr=False, eq=False)
class Series:
    """The sum over k of c_k t^k for 0 <= t <= span, each coefficient with its rounding noise.

    Attributes:
        span: in s; the series has converged up to here.
        coefficients: c_k span^k, shape (r, K).
        noise: their errors, about, shape (r, K).
    """

    span: float
    coefficients: np.ndarray
    noise: np.ndarray

    def __repr__(self) -> str:
        rows, terms = self.coefficients.shape
        return f"Series({counted(rows, 'row')}, {counted(terms, 'term')}, for 0 <= t <= {self.span:.6g} s)"

    def __call__(self, times) -> np.ndarray:
        """The sum at a time (-> (r,)) or at times (T,) (-> (r, T)), none later than span.

        >>> Series(2.0, np.array([[1.0, 2.0, 2.0]]), np.zeros((1, 3)))([0.0, 1.0]).tolist()  # 1 + t + t^2 / 2
        [[1.0, 2.5]]
        """
        return self.coefficients @ self._powers(times)

    def noise_at(self, times) -> np.ndarray:
        """The approximate rounding error of the sum, in the shape of the sum."""
        return self._errors @ self._powers(times)

    def derivative(self, order: int = 1) -> Series:
        """The series of the derivative of this order."""
        series = self
        for _ in range(whole_number(order, "order")):
            with np.errstate(over="ignore", invalid="ignore"):  # a row whose series leaves the range is not evaluated by it
                factors = np.arange(1.0, max(series.coefficients.shape[1], 1)) / series.span
                series = Series(series.span, series.coefficients[:, 1:] * factors, series.noise[:, 1:] * factors)
        return series

    def mapped(self, matrix) -> Series:
        """The series of matrix @ x(t), matrix of shape (p, r)."""
        matrix = np.asarray(matrix, dtype=float)
        return Series(self.span, matrix @ self.coefficients, np.abs(matrix) @ self._errors)

    def rows(self, indices) -> Series:
        return Series(self.span, self.coefficients[indices], self.noise[indices])

    def within(self, span: float) -> Series:
        """The series over a shorter span."""
        powers = (span / self.span) ** np.arange(self.coefficients.shape[1])
        return Series(span, self.coefficients * powers, self.noise * powers)

    def __mul__(self, factor: float) -> Series:
        return Series(self.span, self.coefficients * factor, self.noise * abs(factor))

    def __add__(self, other: Series) -> Series:
        span = min(self.span, other.span)
        one, two = self.within(span), other.within(span)
        return Series(span, _padded_sum(one.coefficients, two.coefficients), _padded_sum(one._errors, two._errors))

    @property
    def _errors(self) -> np.ndarray:
        """The noise with the rounding errors of the coefficients."""
        return self.noise + EPS * np.abs(self.coefficients)

    def _powers(self, times):
        """t^0, t^1, ... by doubling, in units of the span, shape (K,) or (K, T)."""
        first, count = np.asarray(times, dtype=float) / self.span, self.coefficients.shape[1]
        powers = np.ones((1, *first.shape))
        while len(powers) < count:
            powers = np.concatenate([powers, powers * (powers[-1] * first)])
        return powers[:count]


@dataclass(frozen=True, repr=False)
class ResponseFunction(BohlFunction):
    """A Bohl function that is evaluated by its Taylor series while that is more accurate than the sum of modes.

    Attributes:
        series: its Taylor series at t = 0+.
    """

    series: Series

    def _values(self, times) -> np.ndarray:
        """Values, each row by its series before the time ``switch`` of the row."""
        values = super()._values(times)
        if not times.size or times.min() >= self.series.span:
            return values
        some = np.flatnonzero(times < self.switch.max(initial=0.0))
        width = max(1, CHUNK_ENTRIES // max(*self.series.coefficients.shape, 1))
        for part in (some[begin : begin + width] for begin in range(0, len(some), width)):
            early = times[part]
            values[:, part] = np.where(np.greater.outer(self.switch, early), self.series(early), values[:, part])
        return values

    @cached_property
    def switch(self) -> np.ndarray:
        """Time in s before which each row is evaluated by its series, shape (r,)."""
        series, table = self.series, _powers_of_places(self.series.coefficients.shape[1])
        places = series.span * PLACES
        with np.errstate(over="ignore", invalid="ignore"):  # infinite values do not enter: no comparison with them is true
            noise, sums = series._errors @ table, series.coefficients @ table[:, EARLY]
            difference = np.abs(super()._values(places[EARLY]) - sums)
            error = (difference - NOISE_SAFETY * noise[:, EARLY]).max(axis=1, initial=0.0)
        worse = ~(noise <= error[:, None])
        first_good = np.where(worse.all(axis=1), len(places), worse.argmin(axis=1))
        return np.append(places, 0.0)[first_good]

    @property
    def summed_from(self) -> np.ndarray:
        """First time of evaluation by modes, as in ``BohlFunction``."""
        return self.switch

    def derivative(self, order: int = 1) -> ResponseFunction:
        """The classical derivative."""
        return with_series(super().derivative(order), self.series.derivative(order))

    def mapped(self, matrix) -> ResponseFunction:
        """The function matrix @ f(t), matrix of shape (p, r)."""
        matrix = real_array(matrix, "matrix", shape=(None, self.size))
        return with_series(super().mapped(matrix), self.series.mapped(matrix))

    def rows(self, indices) -> ResponseFunction:
        indices = np.asarray(indices, dtype=int)
        return with_series(super().rows(indices), self.series.rows(indices))

    def __add__(self, other: BohlFunction) -> ResponseFunction:
        if not isinstance(other, BohlFunction):
            return NotImplemented
        series = other.series if isinstance(other, ResponseFunction) else series_of(other, self.series.span)
        return with_series(super().__add__(other), self.series + series)

    __radd__ = __add__

    def __mul__(self, factor: float) -> ResponseFunction:
        return with_series(super().__mul__(factor), self.series * factor)

    __rmul__ = __mul__


def with_series(function: BohlFunction, series: Series) -> ResponseFunction:
    """The function together with its series, which ends at the first restart of the function."""
    knots = function.restarts.knots
    if len(knots) > 1 and knots[1] < series.span:
        series = series.within(float(knots[1]))
    return ResponseFunction(function.coefficients, function.blocks, function.start, series)


def series_of(function: BohlFunction, longest: float) -> Series:
    """The Taylor series of C e^{J t} v, over no more than the longest span."""
    J, v = function.generator, function.start_at_zero
    rate, steps = growth(np.abs(J), v != 0)
    span = min(span_of(rate, longest), longest)
    state, columns = v, []
    for k in range(TERMS + steps):
        columns.append(function.coefficients @ state)
        state = span / (k + 1) * (J @ state)
    coefficients = np.stack(columns, axis=1)
    return Series(span, coefficients, EPS * np.abs(coefficients))


def growth(bounds: np.ndarray, begun: np.ndarray) -> tuple[float, int]:
    """Perron root of the states that are reachable from the first ones, and the number of steps to reach all of them."""
    pattern, steps, last = bounds > 0, 0, begun
    while (last := pattern[:, last].any(axis=1) & ~begun).any():
        begun, steps = begun | last, steps + 1
    return _perron_root(bounds[np.ix_(begun, begun)]), steps


def _perron_root(matrix: np.ndarray) -> float:
    """The largest eigenvalue of a nonnegative matrix, slightly above: the root of a norm of a high power (Gelfand)."""
    logarithm = 0.0
    for _ in range(SQUARINGS):
        size = min(matrix.sum(axis=1).max(initial=0.0), LARGEST)
        if size == 0:
            return 0.0
        matrix, logarithm = matrix / size, 2 * (logarithm + log(size))
        matrix = matrix.dot(matrix)
    return exp(min(logarithm / 2**SQUARINGS, log(LARGEST)))


def span_of(rate: float, otherwise: float) -> float:
    """The span of a series; a finite series without growth serves at all times."""
    return REACH / rate if rate > 0 else otherwise


@lru_cache
def _powers_of_places(count: int) -> np.ndarray:
    """PLACES^0, PLACES^1, ..., shape (count, T)."""
    return np.power.outer(PLACES, np.arange(count)).T


def _padded_sum(one, two) -> np.ndarray:
    count = max(one.shape[1], two.shape[1])
    return sum(np.pad(part, ((0, 0), (0, count - part.shape[1]))) for part in (one, two))
