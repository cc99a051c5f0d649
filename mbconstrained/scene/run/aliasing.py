"""Aliasing: times too coarse for the motion, so that curves through them show a slower motion that does not exist."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...ground.notices import Notice, NoticeKind
from .curves import visible

if TYPE_CHECKING:
    from .result import Result

#: Fewer times in a period than the first cannot represent it; the second show it smoothly.
FEWEST, SMOOTH = 3, 20

#: Components below this share of the motion are invisible in a plot.
VISIBLE = 0.01

#: Places where persistent motion is sampled, as shares of the whole time.
ALIASING_PLACES = (0.25, 0.5, 0.75)

#: Spacings of times after the start and after changes of the force: motion decayed by then has only few points in a curve.
LASTS = 5

#: Most changes of the force that are sampled: those followed by the longest times without another.
MOST_CHANGES = 16

#: Each sampling covers so many periods twice, at least the second number, with so many times.
PERIODS, LEAST_PERIODS, LOOKS = 4, 2, 256

#: Components slower than this share of a frequency count as a parabola; frequencies within this factor count as one.
SLOWER, NEAR = 0.01, 1.1

#: Components that the samples cannot separate, relative to the largest singular value.
ALIKE = 1e-3


def aliasing_notices(result: Result) -> tuple[Notice, ...]:
    """A notice where the times are too coarse for the fastest visible motion, with the entry to write instead."""
    time = result.scene.table.time
    spacing = time.spacing
    angular = _fastest_visible(result, 2 * math.pi / (FEWEST * spacing))
    if angular is None:
        return ()
    period = 2 * math.pi / angular
    points = math.ceil((time.end - time.start) * SMOOTH / period) + 1
    end = f'end = "{time.start + period * (time.points - 1) / SMOOTH:.2g} s"'  # which shows only the first of the motion
    few = f"points = {points}" if time.step is None else f'step = "{period / SMOOTH:.2g} s"'
    instead = few if points <= time.MOST_POINTS else end
    text = (
        f"the times are {spacing:.3g} s apart, but the fastest visible motion has a period of {period:.3g} s: curves through "
        "these times show a slower motion that does not exist (aliasing), while the values at the times are right; "
        f"to see the true one, write {instead} below [time]"
    )
    return (Notice(NoticeKind.ALIASING, text),)


def _fastest_visible(result: Result, slowest: float) -> float | None:
    """The highest angular frequency above ``slowest`` of a visible component that does not decay at once."""
    frequencies = _angular_frequencies(result)
    for highest in _octaves([each for each in frequencies if each > slowest]):
        frequency = _visible_frequency(result, [each for each in frequencies if SLOWER * highest <= each <= highest])
        if frequency and frequency > slowest:
            return frequency
    return None


def _angular_frequencies(result: Result) -> list[float]:
    """Of the zeros and the forces, the highest first."""
    zeros = {abs(zero.value.imag) for zero in result.finite_pair.zeros}
    forces = {abs(table.omega) for table in result.scene.table.force if table.kind in ("harmonic", "term")}
    return sorted(zeros | forces, reverse=True)


def _octaves(descending: Iterable[float]) -> Iterator[float]:
    """The highest of each octave."""
    last = math.inf
    for each in descending:
        if each <= last / 2:
            last = each
            yield each


def _visible_frequency(result: Result, descending: list[float]) -> float | None:
    """The highest of these angular frequencies, or of the octave below the first, that is visible in the motion."""
    kept = list(_distinct(descending))
    units = result.scene.equations.coordinates.units
    for begin, length in _stretches(result, 2 * math.pi / kept[0]):
        local = np.linspace(0.0, length, LOOKS)
        both = [result.motion(begin + local), result.motion(begin + length + local)]
        scale = visible(np.hstack([result.values, *both]), units)
        parts = _parts(np.array(kept), local / length, length)
        amplitudes = np.minimum(*(_amplitudes(parts, values) for values in both))  # a jump or a kink is in one of the two
        visible_parts = (amplitudes > VISIBLE * scale.T).any(axis=1)
        if visible_parts.any():
            return kept[int(np.argmax(visible_parts))]
    return None


def _amplitudes(parts: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Of the oscillations in the coordinates, by frequency and coordinate."""
    factors = np.linalg.lstsq(parts, values.T, rcond=ALIKE)[0][3:]
    return np.hypot(*factors.reshape(2, -1, len(values)))


def _stretches(result: Result, period: float) -> Iterator[tuple[float, float]]:
    """Where the motion is looked at for what has this period: beginnings and lengths, in s; as long again behind each."""
    time, force = result.scene.table.time, result.scene.equations.force
    whole = time.end - time.start
    length = min(PERIODS * period, whole / 2)
    yield from ((time.start + min(place * whole, whole - 2 * length), length) for place in ALIASING_PLACES)
    changes = np.array([0.0]) if force is None else force.knots[force.knots < time.end]
    begins = np.maximum(changes + LASTS * time.spacing, time.start)
    left = np.append(changes[1:], time.end) - begins
    for k in np.argsort(-left, kind="stable")[:MOST_CHANGES]:
        if left[k] >= 2 * LEAST_PERIODS * period:
            yield float(begins[k]), min(length, float(left[k]) / 2)


def _distinct(descending: Iterable[float]) -> Iterator[float]:
    last = math.inf
    for each in descending:
        if each * NEAR <= last:
            last = each
            yield each


def _parts(angular: np.ndarray, share: np.ndarray, length: float) -> np.ndarray:
    """A parabola, cosines and sines, one column each, at shares of a stretch of time."""
    phases = np.outer(length * share, angular)
    return np.hstack([np.vander(share, 3), np.cos(phases), np.sin(phases)])
