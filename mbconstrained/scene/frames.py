"""The key frames of an animation: as many as its fastest visible motion asks for, at least 20 in a period."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .result import Result

#: Key frames in a period of the fastest motion that is seen.
FRAMES = 20

#: Cubic interpolation of a cosine between so many misses it by this share of its amplitude, which nobody sees.
ERROR = (2 * np.pi / FRAMES) ** 4 / 384

#: So many places between key frames are looked at, and so many of them may be wrong: those beside a jump or a kink always are.
PLACES, KINKS = 128, 0.05

#: What moves less than this share of the largest value only seems to.
ROUNDING = 1e-9

#: More numbers than this are a burden to the page.
MOST_NUMBERS = 400_000


def frames_of(result: Result, most: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (T,), values (r, T) and rates (r, T): those of the scene, or more of them where they are too few.

    Args:
        result: of a run.
        most: frames that there may be, unless the scene asks for more times itself.
    """
    times, values = result.times, result.values
    rates = result.curves("velocity").values
    most = min(most, MOST_NUMBERS // max(1, len(values)))
    scale = visible(values, result.scene.equations.coordinates.units)
    at, rate = result.motion, result.motion.derivative(1)
    while len(times) < most and _misses(times, values, rates, at, scale):
        times = np.linspace(times[0], times[-1], min(2 * len(times) - 1, most))
        values, rates = at(times), rate(times)
    return times, values, rates


def visible(values: np.ndarray, units: tuple[str, ...]) -> np.ndarray:
    """How far the coordinates of a unit move, which tells what is seen beside it, shape (r, 1)."""
    reach = np.ptp(values, axis=1)
    furthest = {unit: max(own for own, other in zip(reach, units) if other == unit) for unit in units}
    return np.array([max(furthest[unit] / 2, ROUNDING * np.abs(values).max()) for unit in units])[:, None]


def _misses(times, values, rates, at: Callable[[np.ndarray], np.ndarray], scale: np.ndarray) -> bool:
    """Whether the cubic polynomials between the key frames are elsewhere than the motion, seen half way between them."""
    left = np.unique(np.linspace(0, len(times) - 2, PLACES).round().astype(int))
    right, length = left + 1, np.diff(times)[left]
    middle = (values[:, left] + values[:, right]) / 2 + length * (rates[:, left] - rates[:, right]) / 8
    wrong = np.abs(at(times[left] + length / 2) - middle) > ERROR * scale
    return np.mean(wrong.any(axis=0)) > KINKS
