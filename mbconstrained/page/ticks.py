"""Sensible numbers for the axes of plots."""

from __future__ import annotations

import math
from dataclasses import dataclass

#: Where a range is narrower than this part of its values, it is rounding noise and drawn as a constant.
NOISE_SPAN = 1e-9

#: An axis has at most this many steps between its ends before it is widened.
STEPS = 6

#: Values smaller than this count as zero.
SMALLEST = 1e-290


@dataclass(frozen=True)
class Axis:
    """A range and its ticks.

    Attributes:
        low, high: the range; every tick lies in it.
        ticks: values of the ticks.
        labels: their texts, in units of 10^exponent.
        exponent: a multiple of three, or 0 where the labels are plain numbers.
    """

    low: float
    high: float
    ticks: tuple[float, ...]
    labels: tuple[str, ...]
    exponent: int


def axis_of(low: float, high: float, *, widen: bool = True) -> Axis:
    """An axis with ticks at even steps of 1, 2 or 5 times a power of ten, widened to whole steps unless told not to.

    >>> axis_of(-0.93, 1.7).labels
    ('-1.0', '-0.5', '0.0', '0.5', '1.0', '1.5', '2.0')
    >>> axis_of(0.0, 50.0, widen=False).labels
    ('0', '10', '20', '30', '40', '50')
    """
    low, high = _room(low, high)
    step = _step((high - low) / STEPS)
    down, up = (math.floor, math.ceil) if widen else (math.ceil, math.floor)
    outwards = NOISE_SPAN if widen else -NOISE_SPAN  # an end that is a tick but for rounding is one
    first, last = down(low / step + outwards), up(high / step - outwards)
    ticks = tuple(k * step for k in range(first, last + 1))
    if widen:
        low, high = ticks[0], ticks[-1]
    exponent = _exponent(max(abs(low), abs(high)))
    return Axis(low, high, ticks, tuple(_label(tick, step, exponent) for tick in ticks), exponent)


def decimals_of(step: float) -> int:
    """Digits after the point that numbers are told with which are known to a step; negative before the point.

    >>> [decimals_of(step) for step in (20.0, 0.01, 0.0006)]
    [-2, 2, 3]
    """
    return min(12, math.floor(NOISE_SPAN - math.log10(step))) if step > 0 else 0


def _room(low: float, high: float) -> tuple[float, float]:
    """The range itself, or room around a constant."""
    size = max(abs(low), abs(high))
    if size < SMALLEST:
        return -1.0, 1.0
    if high - low > NOISE_SPAN * size:
        return low, high
    return min(0.5 * low, 1.5 * low), max(0.5 * high, 1.5 * high)


def _step(rough: float) -> float:
    power = 10.0 ** math.floor(math.log10(rough))
    return power * next(factor for factor in (1.0, 2.0, 5.0, 10.0) if rough <= factor * power * (1 + NOISE_SPAN))


def _exponent(size: float) -> int:
    """0 for sizes that read well as they are, else a power of ten to take out."""
    power = math.floor(math.log10(size)) if size > 0 else 0
    return 0 if -3 <= power <= 4 else 3 * (power // 3)


def _label(tick: float, step: float, exponent: int) -> str:
    digits = max(0, exponent - math.floor(math.log10(step) + NOISE_SPAN))
    text = f"{tick / 10.0**exponent:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0 else text
