"""How large motion is drawn: enough to be seen, not so much that bodies run into each other."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from ...tolerances import noise_of

#: Largest drawn change of distance between neighbours, in drawing units, about half of the gap between them.
NEIGHBOURS = 0.8

#: Largest drawn displacement of a body: a whole chain may move further than its bodies to each other.
ABSOLUTE = 2.4

#: Angles smaller than this are drawn larger, rad.
VISIBLE_ANGLE = 0.35

#: Largest angle that a drawing is made to show, rad: further, a wheel is no longer seen to swing back and forth.
WIDEST_ANGLE = 2 * VISIBLE_ANGLE

#: Motion smaller than this is none.
NONE = 1e-290


def displacement_scale(moves: dict[str, np.ndarray], pairs: Iterable[tuple[str, str]]) -> float:
    """Magnification for displacements (T,) by name, and pairs of neighbours; a name without displacements rests."""
    furthest = max((_peak(move) for move in moves.values()), default=0.0)
    zero = np.zeros(1)
    closest = max((_peak_difference(moves.get(a, zero), moves.get(b, zero)) for a, b in pairs), default=0.0)
    scales = [limit / size for limit, size in ((ABSOLUTE, furthest), (NEIGHBOURS, closest)) if size > NONE]
    return _plain(min(scales, default=1.0))


def angle_scale(angles: Iterable[np.ndarray]) -> float:
    """Magnification for angles, arrays (T,): 1 unless all of them are too small to be seen."""
    largest = max(map(_peak, angles), default=0.0)
    return 1.0 if largest < NONE or largest >= VISIBLE_ANGLE else _plain(WIDEST_ANGLE / largest)


def two_digits(number: float) -> float:
    """The next smaller number of two digits.

    >>> two_digits(0.7), two_digits(1.2345e-7), two_digits(99.9)
    (0.7, 1.2e-07, 99.0)
    """
    power = int(np.floor(np.log10(number))) - 1
    return float(f"{np.floor(number / 10.0**power * (1 + noise_of(1.0))):g}e{power}")


def _peak(values: np.ndarray) -> float:
    return float(np.abs(values).max(initial=0.0))


def _peak_difference(one: np.ndarray, other: np.ndarray) -> float:
    """Of values over time; of single values, which are amplitudes, the sum."""
    return _peak(one - other) if max(len(one), len(other)) > 1 else _peak(one) + _peak(other)


def _plain(number: float) -> float:
    """The next smaller number of 1, 1.5, 2, 3, 5 or 7 times a power of ten."""
    power = math.floor(math.log10(number))
    digit = max(digit for digit in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0) if digit <= number / 10.0**power * (1 + 1e-12))
    return float(f"{digit:g}e{power}")
