"""Pieces of power spectral densities between corner frequencies: power laws, straight lines, filtered white noise; analytic functions of f."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...ground.tolerances import SPECTRAL_ACCURACY


@dataclass(frozen=True)
class PowerLaw:
    """G(f) = level (f / lower)^exponent between two corner frequencies; a constant where the exponent is 0.

    Attributes:
        lower, upper: in Hz; the upper one may be infinite where the exponent is 0.
        level: G at the lower corner.
        exponent: slope in a plot with two logarithmic axes.
    """

    lower: float
    upper: float
    level: complex
    exponent: float = 0.0

    #: G ~ f^slope towards infinity.
    slope = 0

    def __call__(self, f: np.ndarray) -> np.ndarray:
        """G at real or complex frequencies in Hz."""
        return self.level * (f / self.lower) ** self.exponent if self.exponent else np.full(np.shape(f), self.level, dtype=complex)

    def within(self, low: float, high: float) -> PowerLaw:
        """The power law between two other frequencies."""
        return PowerLaw(low, high, self(np.array(low)).item() if self.exponent and low > self.lower else self.level, self.exponent)

    def ratio(self, other) -> complex:
        """c with other = c times this piece, or NaN."""
        same = isinstance(other, PowerLaw) and (self.lower, self.upper) == (other.lower, other.upper)
        return other.level / self.level if same and abs(self.exponent - other.exponent) <= SPECTRAL_ACCURACY else np.nan

    @property
    def singularities(self) -> tuple[complex, ...]:
        """Frequencies near which G is not analytic."""
        return (0j,) if self.exponent else ()


@dataclass(frozen=True)
class Line:
    """G(f) = level + slope_per_hz (f - lower) between two corner frequencies.

    Attributes:
        lower, upper: in Hz.
        level, end: G at both.
    """

    lower: float
    upper: float
    level: complex
    end: complex

    slope = 0

    def __call__(self, f: np.ndarray) -> np.ndarray:
        """G at real or complex frequencies in Hz."""
        part = (f - self.lower) / (self.upper - self.lower)
        return self.level * (1 - part) + self.end * part

    def within(self, low: float, high: float) -> Line:
        """The line between two other frequencies."""
        return Line(low, high, *self(np.array([low, high])).tolist())

    def ratio(self, other) -> complex:
        """c with other = c times this piece, or NaN."""
        if not isinstance(other, Line) or (self.lower, self.upper) != (other.lower, other.upper):
            return np.nan
        own, given = np.array([self.level, self.end]), np.array([other.level, other.end])
        c = np.vdot(own, given) / np.vdot(own, own)
        return c if (np.abs(given - c * own) <= SPECTRAL_ACCURACY * np.abs(given).max()).all() else np.nan

    @property
    def singularities(self) -> tuple[complex, ...]:
        """No singularities of a line; those of its square root, in cross spectra, are at its zero."""
        rise = self.end - self.level
        return (complex(self.lower - self.level * (self.upper - self.lower) / rise),) if rise else ()


@dataclass(frozen=True)
class Rational:
    """G(f) = intensity |F(i w)|^2, F(s) = numerator(s) / denominator(s), w = 2 pi f: white noise through a filter.

    Attributes:
        intensity: intensity of the white noise, one-sided per Hz.
        numerator, denominator: coefficients, highest power first.
        lower, upper: 0 and infinity.
    """

    intensity: float
    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    lower: float = 0.0
    upper: float = np.inf

    def __call__(self, f: np.ndarray) -> np.ndarray:
        """G at real or complex frequencies in Hz."""
        s = 2j * np.pi * np.asarray(f, dtype=complex)
        above = np.polyval(self.numerator, s) * np.polyval(self.numerator, -s)
        return self.intensity * above / (np.polyval(self.denominator, s) * np.polyval(self.denominator, -s))

    def within(self, low: float, high: float) -> Rational:
        """The rational spectrum between two other frequencies."""
        return replace(self, lower=low, upper=high)

    def ratio(self, other) -> complex:
        """c with other = c times this piece, or NaN."""
        same = isinstance(other, Rational) and (self.numerator, self.denominator) == (other.numerator, other.denominator)
        return other.intensity / self.intensity if same else np.nan

    @property
    def slope(self) -> int:
        """G ~ f^slope towards infinity."""
        return 2 * (len(self.numerator) - len(self.denominator))

    @property
    def singularities(self) -> tuple[complex, ...]:
        """The poles of F as complex frequencies, in both half planes."""
        at = np.roots(self.denominator) / (2j * np.pi)
        return tuple(at) + tuple(at.conj())
