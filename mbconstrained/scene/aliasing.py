"""Times that are too far apart for the motion: between them it swings to and fro, and curves through them show a slower motion
that there is not (aliasing)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..notices import Notice
from .forces import angular_frequency
from .frames import visible

if TYPE_CHECKING:
    from .result import Result

#: Fewer times than this in a period are too few to tell it; so many show it as it is.
FEWEST, SMOOTH = 3, 20

#: A part of the motion that is smaller than this share of it is not seen in a plot.
SEEN = 0.01

#: Where the motion is looked at, as shares of all its time: what lasts is seen there.
PLACES = (0.25, 0.5, 0.75)

#: And so many spacings of times after the start and after forces change: what has decayed by then is few points of a curve.
LASTS = 5

#: At most so many of these changes are looked at, those after which the longest time passes without another.
MOST_CHANGES = 16

#: How closely: twice, over so many periods of what is looked for, at so many times; fewer than the least tell nothing.
PERIODS, LEAST_PERIODS, LOOKS = 4, 2, 256

#: Parts slower than this share of a frequency look like a parabola beside it; frequencies this near each other look like one.
SLOWER, NEAR = 0.01, 1.1

#: Parts that the looks cannot tell from each other, relative to the largest singular value.
ALIKE = 1e-3


def aliasing_notices(result: Result) -> tuple[Notice, ...]:
    """What the period of the fastest motion that is seen is, where the times miss it, and what to write instead."""
    time = result.scene.table.time
    spacing = time.end / (time.points - 1)
    angular = fastest_seen(result, 2 * math.pi / (FEWEST * spacing))
    if angular is None:
        return ()
    from .schema import MOST_POINTS

    period = 2 * math.pi / angular
    points = math.ceil(time.end * SMOOTH / period) + 1
    end = f'end = "{period * (time.points - 1) / SMOOTH:.2g} s"'  # which shows only the first of the motion
    instead = f"points = {points}" if points <= MOST_POINTS else end
    text = (
        f"the times are {spacing:.3g} s apart, but the fastest motion that is seen has a period of {period:.3g} s: curves through "
        "these times show a slower motion that does not exist (aliasing), while the values at the times are right; "
        f"to see the true one, write {instead} below [time]"
    )
    return (Notice("aliased", text),)


def fastest_seen(result: Result, slowest: float) -> float | None:
    """The highest angular frequency above this one of any part of the motion that is seen, and does not decay at once."""
    found = _angular_frequencies(result)
    for highest in _octaves([each for each in found if each > slowest]):
        seen = _seen(result, [each for each in found if SLOWER * highest <= each <= highest])
        if seen and seen > slowest:
            return seen
    return None


def _angular_frequencies(result: Result) -> list[float]:
    """Of the zeros and the forces, the highest first."""
    zeros = {abs(zero.value.imag) for zero in result.finite_pair.zeros}
    forces = {abs(angular_frequency(table)) for table in result.scene.table.force if table.kind in ("harmonic", "term")}
    return sorted(zeros | forces, reverse=True)


def _octaves(descending: Iterable[float]) -> Iterator[float]:
    """The highest of each octave."""
    last = math.inf
    for each in descending:
        if each <= last / 2:
            last = each
            yield each


def _seen(result: Result, descending: list[float]) -> float | None:
    """The highest of these angular frequencies, or of the octave below the first, with which the motion is seen to move."""
    kept = list(_apart(descending))
    units = result.scene.equations.coordinates.units
    for begin, length in _stretches(result, 2 * math.pi / kept[0]):
        local = np.linspace(0.0, length, LOOKS)
        both = [result.motion(begin + local), result.motion(begin + length + local)]
        scale = visible(np.hstack([result.values, *both]), units)
        parts = _parts(np.array(kept), local / length, length)
        amplitudes = np.minimum(*(_amplitudes(parts, values) for values in both))  # a jump or a kink is in one of the two
        seen = (amplitudes > SEEN * scale.T).any(axis=1)
        if seen.any():
            return kept[int(np.argmax(seen))]
    return None


def _amplitudes(parts: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Of the oscillations in the coordinates, by frequency and coordinate."""
    factors = np.linalg.lstsq(parts, values.T, rcond=ALIKE)[0][3:]
    return np.hypot(*factors.reshape(2, -1, len(values)))


def _stretches(result: Result, period: float) -> Iterator[tuple[float, float]]:
    """Where the motion is looked at for what has this period: beginnings and lengths, in s; as long again behind each."""
    time, force = result.scene.table.time, result.scene.equations.force
    length = min(PERIODS * period, time.end / 2)
    yield from ((min(place * time.end, time.end - 2 * length), length) for place in PLACES)
    changes = np.array([0.0]) if force is None else force.knots[force.knots < time.end]
    begins = changes + LASTS * time.end / (time.points - 1)
    left = np.append(changes[1:], time.end) - begins
    for k in np.argsort(-left, kind="stable")[:MOST_CHANGES]:
        if left[k] >= 2 * LEAST_PERIODS * period:
            yield float(begins[k]), min(length, float(left[k]) / 2)


def _apart(descending: Iterable[float]) -> Iterator[float]:
    last = math.inf
    for each in descending:
        if each * NEAR <= last:
            last = each
            yield each


def _parts(angular: np.ndarray, share: np.ndarray, length: float) -> np.ndarray:
    """A parabola, cosines and sines, one column each, at shares of a stretch of time."""
    phases = np.outer(length * share, angular)
    return np.hstack([np.vander(share, 3), np.cos(phases), np.sin(phases)])
