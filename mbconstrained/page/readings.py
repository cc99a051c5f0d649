"""How many digits a page tells of the values beside its curves: no more than what it reads them from carries.

A curve that is a coordinate of the animation is read from the key frames; any other from the points as they are drawn,
in whole cells and straight from one to the next, where the script looks how much the curve bends there if all are drawn. A number
that is off by at most half a unit of its last digit is, once rounded, off by at most one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .content import Animation
from .keyframes import KeyFrames
from .plot_content import Curve
from .ticks import Axis, decimals_of

#: The part of what it would be with every second point left out by which a reading may be off between the points. Of lines
#: through a smooth curve it is a quarter and of cubics a sixteenth; at a kink a half.
BETWEEN = 0.5


@dataclass(frozen=True)
class Coordinates:
    """The coordinates of an animation as the page reads them.

    Attributes:
        frames: what it reads.
        unseen: by how much each may be off as the key frames are written, shape (r,).
    """

    animation: Animation
    frames: KeyFrames
    unseen: np.ndarray

    def number_of(self, curve: Curve, times: np.ndarray) -> int | None:
        """The place among the names of the coordinate that a curve shows; None where it shows something else."""
        animation = self.animation
        if curve.name not in animation.names or not np.array_equal(times, animation.times):
            return None
        number = animation.names.index(curve.name)
        return number if np.array_equal(curve.values, animation.values[number]) else None

    def error(self, number: int) -> float:
        """By how much a coordinate may be off at any time."""
        times, values, rates = self.frames.times, self.frames.values[number], self.frames.rates[number]
        given = self.animation.values[number]
        off = np.abs(_cubic(times, values, rates, self.animation.times) - given).max()
        half = np.unique([*range(0, len(times), 2), len(times) - 1])
        between = BETWEEN * np.abs(_cubic(times[half], values[half], rates[half], times) - values).max()
        rounding = np.finfo(np.float32).eps * np.abs(given).max()  # of key frames that are written with 4 bytes
        return float(max(off, between) + rounding + self.unseen[number])


def path_error(
    moments: np.ndarray, values: np.ndarray, read_moments: np.ndarray, read: np.ndarray, *, between: bool = True
) -> float:
    """By how much values (T,) at moments (T,), and between them, may be off when they are read from lines through other points (k,).

    >>> path_error(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 4.0]), np.array([0.0, 2.0]), np.array([0.0, 4.0]))
    1.5
    """
    off = float(np.abs(np.interp(moments, read_moments, read) - values).max())
    if not between:
        return off
    share = (moments[1:-1] - moments[:-2]) / (moments[2:] - moments[:-2])
    bend = values[1:-1] - values[:-2] - share * (values[2:] - values[:-2])
    return float(off + BETWEEN * np.abs(bend).max(initial=0.0))


def digits_told(error: float, axis: Axis, finest: float) -> int | None:
    """Digits after the point, in the unit of the axis' labels; negative where numbers are told in tens or hundreds.

    Args:
        error: by how much numbers may be off.
        finest: smaller steps are of no interest.

    Returns:
        None where not even the first digit is known.
    """
    unit = 10.0**axis.exponent
    digits = decimals_of(max(finest, 2 * error) / unit)
    return None if unit * 10.0**-digits > axis.high - axis.low else digits


def _cubic(keys: np.ndarray, values: np.ndarray, rates: np.ndarray, times: np.ndarray) -> np.ndarray:
    """What the page's script makes of key frames (k,) at times (T,)."""
    if len(keys) == 1:
        return np.full(len(times), values[0])
    key = np.clip(np.searchsorted(keys, times, side="right") - 1, 0, len(keys) - 2)
    length = keys[key + 1] - keys[key]
    s = (times - keys[key]) / length
    r = 1 - s
    ends = r * r * (1 + 2 * s) * values[key] + s * s * (1 + 2 * r) * values[key + 1]
    return ends + length * s * r * (r * rates[key] - s * rates[key + 1])
