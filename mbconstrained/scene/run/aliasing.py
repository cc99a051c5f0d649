"""Aliasing: times too coarse for the motion, so that curves show a slower motion that does not exist."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import NOT_DRAWN
from ...linalg.blocks import block_slices, zeros_of
from .scene_data import SceneData

if TYPE_CHECKING:
    from ...mechanics.motion import Motion

#: Fewer times in a period than the first cannot represent it; the second show it smoothly.
FEWEST, SMOOTH = 3, 20

#: Rounding errors of a number of points.
COUNT_NOISE = 1e-12

#: Points in a period of times that follow the motion, and the most of these times.
FOLLOWED, MOST_TIMES = 12, 20_001

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


def following_times(scene: SceneData, motion: Motion) -> np.ndarray:
    """Equidistant times that resolve the fastest visible motion, from the default number to ``MOST_TIMES``."""
    time = scene.table.time
    fastest = _fastest_visible(scene, motion, 2 * math.pi / (FOLLOWED * time.spacing))
    if fastest is None:
        return time.times
    points = math.ceil((1 - COUNT_NOISE) * (time.end - time.start) * FOLLOWED * fastest[0] / (2 * math.pi)) + 1
    return np.linspace(time.start, time.end, min(points, MOST_TIMES))


def aliasing_notices(scene: SceneData, motion: Motion, count: int) -> tuple[Notice, ...]:
    """A notice where this number of times is too coarse for the fastest visible motion, with the entry to write instead."""
    time = scene.table.time
    spacing = (time.end - time.start) / (count - 1)
    fastest = _fastest_visible(scene, motion, 2 * math.pi / (FEWEST * spacing))
    if fastest is None:
        return ()
    angular, name, amplitude = fastest
    period = 2 * math.pi / angular
    points = math.ceil((time.end - time.start) * SMOOTH / period) + 1
    end = f'end = "{time.start + period * (count - 1) / SMOOTH:.2g} s"'  # which shows only the first of the motion
    few = f"points = {points}" if time.step is None else f'step = "{period / SMOOTH:.2g} s"'
    instead = few if points <= time.MOST_POINTS else end
    text = (
        f"the times are {spacing:.3g} s apart, but the fastest visible motion has a period of {period:.3g} s ({1 / period:.4g} Hz, with "
        f"{amplitude} in {name}): a table of these times, and lines between its values, show a slower motion that does not exist "
        "(aliasing), while the values at the times are right and the plots of page and images follow the motion; "
        f"for a table that shows it, write {instead} below [time]"
    )
    return (Notice(NoticeKind.ALIASING, text),)


def _fastest_visible(scene: SceneData, motion: Motion, slowest: float) -> tuple[float, str, str] | None:
    """The highest angular frequency above ``slowest`` of a visible component that does not decay at once, a coordinate, its amplitude."""
    frequencies = _angular_frequencies(scene, motion)
    for highest in _octaves([each for each in frequencies if each > slowest]):
        frequency = _visible_frequency(scene, motion, [each for each in frequencies if SLOWER * highest <= each <= highest])
        if frequency and frequency[0] > slowest:
            return frequency
    return None


def _angular_frequencies(scene: SceneData, motion: Motion) -> list[float]:
    """Angular frequencies of the eigenvalues and the forces, in descending order."""
    zeros = {abs(value.imag) for value in scene.equations.polynomial_matrix.eigenvalues}
    smooth = motion.force.smooth  # prescribed motions, too
    used = [np.abs(smooth.coefficients[:, at]).any() for at in block_slices(smooth.blocks)]
    forces = {abs(value.imag) for value in zeros_of([block for block, one in zip(smooth.blocks, used) if one])}
    return sorted(zeros | forces, reverse=True)


def _octaves(descending: Iterable[float]) -> Iterator[float]:
    """The highest of each octave."""
    last = math.inf
    for each in descending:
        if each <= last / 2:
            last = each
            yield each


def _visible_frequency(scene: SceneData, motion: Motion, descending: list[float]) -> tuple[float, str, str] | None:
    """The highest of these angular frequencies, or of the octave below the first, that is visible in the motion."""
    kept = list(_distinct(descending))
    coordinates = scene.equations.coordinates
    some = motion(scene.times)
    for begin, length in _stretches(scene, 2 * math.pi / kept[0]):
        local = np.linspace(0.0, length, LOOKS)
        both = [motion(begin + local), motion(begin + length + local)]
        scale = visible(np.hstack([some, *both]), coordinates.units)
        parts = _parts(np.array(kept), local / length, length)
        amplitudes = np.minimum(*(_amplitudes(parts, values) for values in both))  # a jump or a kink is in one of the two
        visible_parts = (amplitudes > VISIBLE * scale.T).any(axis=1)
        if visible_parts.any():
            fastest = int(np.argmax(visible_parts))
            place = int(np.argmax(amplitudes[fastest] / scale[:, 0]))
            text = coordinates.shown.text(float(f"{amplitudes[fastest, place]:.3g}"), coordinates.units[place])
            return kept[fastest], coordinates.names[place], text
    return None


def _amplitudes(parts: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Amplitudes of the oscillations in the coordinates, by frequency and coordinate."""
    factors = np.linalg.lstsq(parts, values.T, rcond=ALIKE)[0][3:]
    return np.hypot(*factors.reshape(2, -1, len(values)))


def _stretches(scene: SceneData, period: float) -> Iterator[tuple[float, float]]:
    """Stretches of time to search for oscillations of this period: beginnings and lengths, in s, each followed by an equal one."""
    time, force = scene.table.time, scene.equations.force
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
    """A parabola, cosines and sines, one column each, at fractions of a stretch of time."""
    phases = np.outer(length * share, angular)
    return np.hstack([np.vander(share, 3), np.cos(phases), np.sin(phases)])


def visible(values: np.ndarray, units: tuple[str, ...]) -> np.ndarray:
    """Range of the coordinates by unit, which decides what is visible."""
    reach = np.ptp(values, axis=1)
    furthest = {unit: max(own for own, other in zip(reach, units) if other == unit) for unit in units}
    return np.array([max(furthest[unit] / 2, NOT_DRAWN * np.abs(values).max()) for unit in units])[:, None]
