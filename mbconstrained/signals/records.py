"""Inputs known at samples, and rectangular pulses: the same formulas on every piece, with states set anew at the knots."""

from __future__ import annotations

import numpy as np

from ..checks import real_array, real_number
from ..errors import InputError
from ..tolerances import noise_of
from .bohl import BohlFunction
from .impulsive import ImpulsiveSmooth
from .inputs import step
from .origins import Origin, RecordOrigin
from .restarts import Restarts

#: A linear piece has two states, its value and its slope.
LINEAR = np.array([[0.0, 1.0], [0.0, 0.0]])


def pulse(vector, *, start: float = 0.0, duration: float) -> ImpulsiveSmooth:
    """v for start <= t < start + duration, zero before and after.

    Args:
        vector: v, shape (r,).
        start, duration: in s, start >= 0 and duration > 0.

    >>> pulse([2.0], start=1.0, duration=0.5)([0.5, 1.0, 1.4, 1.5])
    array([[0., 2., 2., 0.]])
    """
    start, duration = real_number(start, "start", minimum=0.0), real_number(duration, "duration", positive=True)
    end = start + duration
    if end == start:
        raise InputError(f"duration: {duration:g} s vanishes beside the start at {start:g} s; give a longer one")
    if end == np.inf:
        raise InputError(f"duration: {duration:g} s after the start at {start:g} s is beyond the range of float64; shorten it")
    return step(vector).delayed(start) - step(vector).delayed(end)


def sampled(times, values) -> ImpulsiveSmooth:
    """A record: linear between its samples, zero before the first and after the last, exact at any time.

    It jumps at its first and last sample if the values there are not zero. Two samples at the same time are a jump of
    the record: the first is the value before it, the second the value after it.

    Args:
        times: shape (T,), T >= 2, in s, ascending, the first >= 0; a time may stand there twice.
        values: shape (r, T).

    Raises:
        InputError: shapes that do not fit; times that do not ascend, stand there three times, or lie too close.

    >>> triangle = sampled([1.0, 2.0, 3.0], [[0.0, 4.0, 0.0]])
    >>> triangle([0.5, 1.5, 2.0, 2.25, 9.0])
    array([[0., 2., 4., 3., 0.]])
    """
    times = real_array(times, "times", shape=(None,))
    values = _rows(values, len(times))
    first = _first_samples(times)
    last = np.append(first[1:], len(times)) - 1
    acting = np.flatnonzero(values.any(axis=1))  # rows that stay zero need no states
    knots, left, right = times[first], values[np.ix_(acting, first)], values[np.ix_(acting, last)]
    slopes, changes = _slopes(knots, left, right)
    jumps = right - left
    jumps[:, 0], jumps[:, -1] = right[:, 0], -left[:, -1]
    right[:, -1] = 0.0
    start = _from_zero(Restarts(knots, _alternating(right, slopes), _alternating(jumps, changes)))
    rows = np.kron(np.eye(len(values))[:, acting], [1.0, 0.0])
    record = ImpulsiveSmooth(BohlFunction(rows, (LINEAR,) * len(acting), start))
    return record.coming_from(Origin(RecordOrigin(times, values)))


def _rows(values, count: int) -> np.ndarray:
    values = real_array(values, "values")
    if values.ndim != 2 or values.shape[1] != count:
        found = " x ".join(map(str, values.shape)) or "a single number"
        raise InputError(f"values: found shape {found}; expected one row per coordinate, each of {count} values, e.g. [[1, 2]]")
    return values


def _first_samples(times) -> np.ndarray:
    """Where each time stands first."""
    if len(times) < 2:
        raise InputError(f"times: found {len(times)}; a record needs at least two samples")
    if times[0] < 0:
        raise InputError(f"times: the first is {times[0]:g} s; a record begins at t = 0 or later")
    gaps = np.diff(times)
    if (gaps < 0).any():
        at = int(np.argmax(gaps < 0))
        raise InputError(f"times: {times[at]:.17g} s is followed by {times[at + 1]:.17g} s; times must ascend")
    if (same := (gaps[1:] == 0) & (gaps[:-1] == 0)).any():
        raise InputError(
            f"times: {times[int(np.argmax(same))]:.17g} s stands there three times; twice is a jump, the value before and after"
        )
    first = np.flatnonzero(np.append(True, gaps > 0))
    if len(first) < 2:
        raise InputError(f"times: all are {times[0]:g} s; a record needs a duration")
    return first


def _slopes(knots, left, right) -> tuple[np.ndarray, np.ndarray]:
    """The slope after each knot, and by how much it changes there: not at all where that is rounding."""
    gaps = np.diff(knots)
    with np.errstate(over="ignore", invalid="ignore"):
        slopes = (left[:, 1:] - right[:, :-1]) / gaps
        size = np.abs(left[:, 1:]) + np.abs(right[:, :-1]) + np.abs(slopes) * (knots[1:] + knots[:-1])
        noise = noise_of(size / gaps)
    if not np.isfinite(noise).all():
        at = int(np.argmin(np.isfinite(noise).all(axis=0)))
        raise InputError(f"values: the slope after t = {knots[at]:.17g} s is beyond the range of float64; the times lie too close")
    nothing = np.zeros((len(left), 1))
    slopes, noise = np.hstack([nothing, slopes, nothing]), np.hstack([nothing, noise, nothing])
    changes = np.diff(slopes, axis=1)
    real = np.abs(changes) > np.maximum(noise[:, 1:], noise[:, :-1])
    return slopes[:, 1:], np.where(real, changes, 0.0)


def _alternating(values, slopes) -> np.ndarray:
    """Value and slope of every row, one below the other, shape (2 r, K)."""
    return np.stack([values, slopes], axis=1).reshape(2 * len(values), values.shape[1])


def _from_zero(record: Restarts) -> Restarts:
    """With the knot 0 in front, where the record begins later."""
    if record.knots[0] == 0:
        return record
    nothing = np.zeros((len(record.states), 1))
    return Restarts(np.append(0.0, record.knots), np.hstack([nothing, record.states]), np.hstack([nothing, record.jumps]))
