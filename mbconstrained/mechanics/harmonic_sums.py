"""Sums of harmonics, f(t) = Re sum of c_l e^{i w_l t}: amplitudes as given, their common period, RMS value and largest modulus."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import lcm

import numpy as np

from ..ground.tolerances import EPS, SAME_FREQUENCY
from .equations import EquationsOfMotion

#: Most periods of the lowest frequency in the common one, and of the highest.
MOST_PERIODS, MOST_TURNS = 1000, 100_000

#: Samples in a period of the highest frequency, maxima of these that are refined, and steps of Newton's method.
SAMPLES, REFINED, STEPS = 16, 3, 3

#: Numbers in one transform.
CHUNK = 1 << 22


def complex_amplitudes(system: EquationsOfMotion, given, what: str) -> np.ndarray:
    """Complex numbers for all coordinates of a system, given in order or by name, shape (n,)."""
    real, imaginary = (
        system._vector({name: part(one) for name, one in given.items()} if isinstance(given, Mapping) else part(given), what)
        for part in (np.real, np.imag)
    )
    return real + 1j * imaginary


def common_rate(rates: Sequence[float] | np.ndarray) -> float | None:
    """The largest rate of which all are whole multiples, 0 without any positive one; None where there is none.

    >>> common_rate([0.0, 1.0, 1.5, 4.0]), common_rate([1.0, 2.0**0.5])
    (0.5, None)
    """
    positive = sorted(rate for rate in rates if rate > 0)
    if not positive:
        return 0.0
    parts = [Fraction(rate / positive[0]).limit_denominator(MOST_PERIODS) for rate in positive]
    if any(abs(float(part) * positive[0] - rate) > SAME_FREQUENCY * rate for part, rate in zip(parts, positive)):
        return None
    periods = lcm(*(part.denominator for part in parts))
    return positive[0] / periods if periods <= MOST_PERIODS and float(parts[-1]) * periods <= MOST_TURNS else None


def root_mean_square(rates: Sequence[float] | np.ndarray, amplitudes: np.ndarray) -> np.ndarray:
    """RMS values of sums with distinct rates, amplitudes of shape (L, ...).

    >>> root_mean_square([0.0, 1.0], np.array([[3.0], [4.0j]])).round(9)
    array([4.12310563])
    """
    weights = np.where(np.asarray(rates) > 0, 0.5, 1.0)
    return np.sqrt(np.tensordot(weights, np.abs(amplitudes) ** 2, axes=1))


def largest_modulus(rates: Sequence[float] | np.ndarray, amplitudes: np.ndarray) -> np.ndarray:
    """The largest modulus of sums with distinct rates, amplitudes of shape (L, N): over the common period, or that of all times.

    Without a common period phases come arbitrarily near to any others, and the sum of all amplitudes is the supremum; where some of the rates
    depend on each other it is a bound.

    >>> largest_modulus([1.0, 2.0], np.array([[1.0], [1.0j]])).round(9), largest_modulus([1.0, 2.0**0.5], np.array([[1.0], [1.0j]]))
    (array([1.76017259]), array([2.]))
    """
    base, sums = common_rate(rates), np.abs(amplitudes).sum(axis=0)
    if not base:
        return sums
    turns = np.rint(np.asarray(rates) / base).astype(int)
    if (np.abs(amplitudes) > 0).sum() == (sums > 0).sum() or turns[-1] == 0:  # one harmonic alone
        return sums
    result, known = np.full(amplitudes.shape[1], np.inf), np.isfinite(amplitudes).all(axis=0)
    result[np.isnan(amplitudes).any(axis=0)] = np.nan
    count = 1 << int(np.ceil(np.log2(SAMPLES * max(turns.max(), 1))))
    for places in np.array_split(np.flatnonzero(known), max(1, known.sum() * count // CHUNK)):
        result[places] = _largest(turns, amplitudes[:, places], count)
    return result


def _largest(turns: np.ndarray, amplitudes: np.ndarray, count: int) -> np.ndarray:
    """The maxima of samples, each raised to that of its parabola by the exact derivatives; the highest are refined by Newton's method."""
    spectrum = np.zeros((amplitudes.shape[1], count // 2 + 1), dtype=complex)
    spectrum[:, turns] = amplitudes.T / np.where(turns > 0, 2, 1)
    values, slopes, bends = (
        np.fft.irfft(spectrum * (1j * np.arange(count // 2 + 1)) ** k, count, norm="forward") for k in range(3)
    )
    signs = np.where(values < 0, -1.0, 1.0)
    values, slopes, bends = signs * values, signs * slopes, signs * bends
    with np.errstate(divide="ignore", invalid="ignore"):
        steps = np.where(bends < 0, -slopes / bends, np.inf)
    near = np.abs(steps) <= 2 * np.pi / count
    tops = values + np.where(near, slopes * np.where(near, steps, 0.0) / 2, 0.0)
    best = np.argpartition(-tops, min(REFINED, count - 1), axis=1)[:, :REFINED]
    angles = 2 * np.pi * best / count + np.where(np.take_along_axis(near, best, 1), np.take_along_axis(steps, best, 1), 0.0)
    for _ in range(STEPS):
        terms = amplitudes[:, :, None] * np.exp(1j * turns[:, None, None] * angles)
        slope, bend = ((terms * (1j * turns[:, None, None]) ** k).sum(axis=0).real for k in (1, 2))
        is_top = np.abs(bend) > EPS * np.abs(terms).sum(axis=0) * turns.max() ** 2
        step = np.divide(-slope, bend, out=np.zeros_like(slope), where=is_top)
        angles = angles + np.clip(step, -np.pi / count, np.pi / count)
    terms = amplitudes[:, :, None] * np.exp(1j * turns[:, None, None] * angles)
    return np.maximum(np.abs(terms.sum(axis=0).real).max(axis=1), values.max(axis=1))
