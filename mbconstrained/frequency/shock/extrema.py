"""Maxima and minima of functions of time in closed form: all changes of sign of the derivative, refined to rounding error."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

#: Samples for each radian of the fastest motion: between two of them a sum of such motions has at most one extremum.
EACH_RADIAN = 4.0

#: Steps of the bisection that refines an extremum; a bracket of one sample is rounding error afterwards.
STEPS = 60

#: Samples at once.
CHUNK = 1 << 16


@dataclass(frozen=True)
class Extrema:
    """The largest and the smallest value of each of r functions, and their times.

    Attributes:
        maximum, minimum: shape (r,).
        maximum_time, minimum_time: in s, shape (r,).
    """

    maximum: np.ndarray
    minimum: np.ndarray
    maximum_time: np.ndarray
    minimum_time: np.ndarray

    @property
    def largest(self) -> np.ndarray:
        """max |f|, shape (r,)."""
        return np.maximum(self.maximum, -self.minimum)


def extrema(
    value: Callable, slope: Callable, start: float, end: float, rate: float, knots: Sequence[float] | np.ndarray = ()
) -> Extrema:
    """The extrema of f(t) on [start, end].

    Args:
        value: f(t) at times (T,), of shape (r, T), right-continuous at knots.
        slope: f'(t), alike.
        start, end: in s.
        rate: the largest angular frequency in f, in rad/s.
        knots: times at which f or f' may jump; the limits from the left are found by the piece before.

    Returns:
        Values and times.

    >>> wave = extrema(lambda t: np.sin(t)[None], lambda t: np.cos(t)[None], 0.0, 3.0, 1.0)
    >>> wave.maximum_time.round(12), wave.minimum
    (array([1.57079633]), array([0.]))
    """
    edges = np.unique([start, *(knot for knot in knots if start < knot < end), end])
    best = None
    for a, b in itertools.pairwise(edges):
        inside = np.nextafter(b, a)  # the limit from the left
        count = int(np.ceil(EACH_RADIAN * rate * (b - a))) + 3
        for low in range(0, count - 1, CHUNK):
            part = np.linspace(a, inside, count)[low : low + CHUNK + 1] if count > CHUNK else np.linspace(a, inside, count)
            best = _better(best, *_candidates(value, slope, part))
    if best is None:
        f = value(np.array([start]))[:, 0]
        return Extrema(f, f, np.full(len(f), start), np.full(len(f), start))
    last = value(np.array([end]))
    best = _better(best, last, np.full((len(last), 1), end), last, np.full((len(last), 1), end))
    return Extrema(*best)


def _candidates(value, slope, times) -> tuple[np.ndarray, ...]:
    """Values and times of the maxima and the minima over the samples and at changes of sign of the slope, each of shape (r, 1)."""
    f, d = value(times), slope(times)
    row, column = np.nonzero(np.sign(d[:, :-1]) * np.sign(d[:, 1:]) < 0)
    low, high, sign = times[column].copy(), times[column + 1].copy(), np.sign(d[row, column])
    # Only the highest and the lowest few can be extreme: those whose parabola reaches beyond the best sample.
    reach = np.maximum(np.abs(d[row, column]), np.abs(d[row, column + 1])) * (high - low)
    top = np.maximum(f[row, column], f[row, column + 1]) + reach >= f.max(axis=1)[row]
    bottom = np.minimum(f[row, column], f[row, column + 1]) - reach <= f.min(axis=1)[row]
    chosen = np.where(sign > 0, top, bottom)
    row, low, high, sign = row[chosen], low[chosen], high[chosen], sign[chosen]
    at, number = np.arange(len(row)), len(row)
    for _ in range(STEPS if number else 0):
        middle = (low + high) / 2
        rising = slope(middle)[row, at] * sign > 0
        low, high = np.where(rising, middle, low), np.where(rising, high, middle)
        if not ((high - low) > np.spacing(np.abs(high))).any():
            break
    middle = (low + high) / 2
    values = value(middle)[row, at] if number else np.zeros(0)
    everywhere, moments = [f.max(axis=1), f.min(axis=1)], [times[f.argmax(axis=1)], times[f.argmin(axis=1)]]
    for r in range(len(f)):
        own = row == r
        if own.any():
            for side, (choice, better) in enumerate(((np.argmax, np.greater), (np.argmin, np.less))):
                k = choice(values[own])
                if better(values[own][k], everywhere[side][r]):
                    everywhere[side][r], moments[side][r] = values[own][k], middle[own][k]
    return everywhere[0][:, None], moments[0][:, None], everywhere[1][:, None], moments[1][:, None]


def _better(best, high, high_time, low, low_time):
    """The better of two sets of extrema."""
    new = (high[:, 0], low[:, 0], high_time[:, 0], low_time[:, 0])
    if best is None:
        return new
    up, down = new[0] > best[0], new[1] < best[1]
    return (
        np.where(up, new[0], best[0]),
        np.where(down, new[1], best[1]),
        np.where(up, new[2], best[2]),
        np.where(down, new[3], best[3]),
    )
