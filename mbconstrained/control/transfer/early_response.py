"""A response from rest while it is small: by its exact Taylor series, where its modes cancel beyond the digits of float64.

After b(s)/a(s) has begun like t^p it stays far below its modes for a while. A Taylor series loses e^(2 |s| t), s the largest
pole; with exact coefficients in the arithmetic of ``linalg.precise`` it can afford to, for a longer time than modes cancel.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil, log, log10

import numpy as np

from ...ground.errors import Overflow
from ...ground.tolerances import EARLY_ERROR, EPS, PRECISE_DIGITS
from ...linalg.blocks import eigenvalues
from ...linalg.precise import midpoints, precise, precise_arithmetic
from ...response.methods.pair_solution import ResponseFunction
from .rational import RationalFunction, laurent

#: The least normal number of float64.
TINY = float(np.finfo(float).tiny)

#: The errors of the sum of modes are measured at so many times per factor of two, over at most so many factors of two.
PLACES, OCTAVES = 2, 24

#: The digits that may be lost, those of float64 and two for the roundings of the sum are left; and the |s| t that loses them.
SPARE_DIGITS = PRECISE_DIGITS + log10(EPS) - 2
REACH = SPARE_DIGITS * log(10) / 2

#: So many terms for |s| t = 1, at least, make the rest of the series (e / 6)^(6 |s| t), nothing relative to e^(-|s| t).
TERMS = 6

#: And so many more for small |s| t, also for each pole and each power of s: repeated poles grow before they decay.
MORE_TERMS, TERMS_A_POLE = 40, 3


@dataclass(frozen=True, repr=False)
class ExactStart(ResponseFunction):
    """The response of b(s)/a(s) to I_gamma, or a derivative of it, evaluated with as many digits as its smallness requires.

    Attributes:
        fraction: b(s)/a(s).
        gamma: of the derivative: y_gamma' = y_(gamma - 1) for t > 0.
    """

    fraction: RationalFunction
    gamma: int

    def __call__(self, times) -> np.ndarray:
        """Values, from the exact series where the modes cancel."""
        values = super().__call__(times)
        times = np.asarray(times, dtype=float)
        flat, accurate = np.atleast_1d(times), values.reshape(-1).copy()
        at = np.flatnonzero((flat > 0) & (flat <= self._reach))
        if not len(at):
            return values
        at = at[self._errors(flat[at]) > EARLY_ERROR * np.abs(accurate[at])]
        octaves = np.floor(np.log2(flat[at]))
        for octave in np.unique(octaves):  # few terms are enough for small times
            same = at[octaves == octave]
            exact, good = self._exact(flat[same])
            accurate[same] = np.where(good, exact, accurate[same])
        return accurate.reshape(values.shape)

    @property
    def summed_from(self) -> np.ndarray:
        """First time of evaluation by modes: earlier values come from the exact series."""
        return np.maximum(self.switch, self._reach)

    def derivative(self, order: int = 1) -> ExactStart:
        """The classical derivative."""
        return with_exact_start(super().derivative(order), self.fraction, self.gamma - order)

    def _errors(self, times) -> np.ndarray:
        """Approximate error without the exact series: the noise of the float64 series, then the measured errors of the modes."""
        by_series = times < self.switch[0]
        noise = self.series.noise_at(np.where(by_series, times, 0.0))[0]
        places, errors = self._measured
        after = np.searchsorted(places, times).clip(1, len(places) - 1)
        return np.where(by_series, noise, np.maximum(errors[after - 1], errors[after]))

    @cached_property
    def _measured(self) -> tuple[np.ndarray, np.ndarray]:
        """Times, ascending, and the errors of the sum of modes there: its difference from the exact series."""
        octaves = np.log2(self._reach / max(self.switch[0], self._reach / 2**OCTAVES))
        places = self._reach * 2.0 ** -(np.arange(ceil(octaves * PLACES), -1, -1) / PLACES)
        with np.errstate(over="ignore", invalid="ignore"):  # what leaves the range is no number that could be compared
            exact, good = self._exact(places)
            errors = np.abs(self._values(places)[0] - exact)
        errors = np.where(good & ~np.isnan(errors), errors, 0.0)
        return np.append(0.0, places), np.append(errors[0], errors)

    def _exact(self, times) -> tuple[np.ndarray, np.ndarray]:
        """The Taylor sums by Horner's rule, and which of them have enough digits."""
        count = min(ceil(TERMS * times.max() * self._largest_pole) + self._more_terms, len(self._derivatives))
        with precise_arithmetic():
            t, total = precise(times), precise(np.zeros(len(times)))
            for k in reversed(range(count)):
                total = midpoints(total * t / (k + 1) + self._derivatives[k])
        sizes = _exponents_of_ten(total)
        terms = self._exponents[:count] + np.multiply.outer(np.log10(times), np.arange(count))
        left = terms.max(axis=1) - sizes <= SPARE_DIGITS
        ended = terms[:, -self._more_terms // 2 :].max(axis=1) <= sizes + log10(EPS)
        return total.astype(float), left & ended

    @cached_property
    def _largest_pole(self) -> float:
        return max((float(np.abs(eigenvalues(block)).max()) for block in self.blocks), default=0.0)

    @property
    def _reach(self) -> float:
        """Range of the series in s; zero without poles other than s = 0, whose modes are the series."""
        return REACH / self._largest_pole if self._largest_pole else 0.0

    @property
    def _more_terms(self) -> int:
        return MORE_TERMS + TERMS_A_POLE * (len(self.fraction.numerator) + len(self.fraction.denominator) + abs(self.gamma))

    @cached_property
    def _derivatives(self) -> list:
        """y^(k)(0+), the coefficients of s^-(k+1) of b(s) / (a(s) s^gamma), in high precision."""
        b, a = self.fraction.numerator, self.fraction.denominator
        first, count = len(b) - len(a) - self.gamma + 1, ceil(TERMS * REACH) + self._more_terms
        with precise_arithmetic():
            above, below = (tuple(precise(np.array(p, dtype=object))) for p in (b, a))
            return [
                *precise(np.zeros(max(-first, 0))),
                *laurent(above, below, max(count + first, 0), lambda value: value.mid())[max(first, 0) :],
            ]

    @cached_property
    def _exponents(self) -> np.ndarray:
        """Powers of ten of the terms at t = 1."""
        factorials = np.cumsum(np.log10(np.maximum(np.arange(len(self._derivatives)), 1)))
        return _exponents_of_ten(self._derivatives) - factorials


def _exponents_of_ten(values) -> np.ndarray:
    """Decimal logarithms of numbers of high precision, which may exceed the range of float64."""
    return np.array([float(abs(value).log()) / log(10) if value.mid() != 0 else -np.inf for value in values])


def with_exact_start(function: ResponseFunction, fraction: RationalFunction, gamma: int) -> ExactStart:
    """A function of modes that begins with its exact series."""
    return ExactStart(function.coefficients, function.blocks, function.start, function.series, fraction, int(gamma))


def exact_start(fraction: RationalFunction, gamma: int, count: int) -> tuple[np.ndarray, tuple[np.ndarray, ...], bool]:
    """The start of a response: coefficients of s^-(i+1) and of 1, s, s^2, ... of b(s) / (a(s) s^gamma)."""
    highest = len(fraction.numerator) - len(fraction.denominator) - gamma
    series = laurent(fraction.numerator, fraction.denominator, max(highest + count + 1, 0)) if fraction.numerator else []
    try:
        terms = {highest - k: float(c) for k, c in enumerate(series) if c}
    except OverflowError:
        raise Overflow("the jumps or impulses at t = 0 are beyond the range of float64; choose another unit of time") from None
    jump = np.array([[terms.get(-1 - i, 0.0)] for i in range(count)]).reshape(count, 1)
    impulses = tuple(np.array([terms.get(k, 0.0)]) for k in range(max(terms, default=-1) + 1))
    return jump, impulses, all(abs(c) >= TINY for c in terms.values())
