"""Axes of plots: a range and its ticks."""

from __future__ import annotations

import math
from dataclasses import dataclass

#: A range narrower than this share of its values is rounding error and drawn as a constant.
NOISE_SPAN = 1e-9

#: Most steps between the ends of an axis before it is widened.
MOST_STEPS = 6

#: Values smaller than this count as zero.
SMALLEST = 1e-290


@dataclass(frozen=True)
class Axis:
    """A range and its ticks.

    Attributes:
        low, high: the range; every tick lies in it.
        ticks: values of the ticks.
        labels: their texts, in units of 10^exponent.
        exponent: a multiple of three, or 0 for labels without a power of ten.
    """

    low: float
    high: float
    ticks: tuple[float, ...]
    labels: tuple[str, ...]
    exponent: int


def axis_of(low: float, high: float, *, widen: bool = True) -> Axis:
    """An axis with ticks at even steps of 1, 2 or 5 times a power of ten.

    Args:
        low, high: the range of the data.
        widen: whether the axis ends at ticks.

    Returns:
        The axis; around a constant it has an interval that shows it.

    >>> axis_of(-0.93, 1.7).labels
    ('−1.0', '−0.5', '0.0', '0.5', '1.0', '1.5', '2.0')
    >>> axis_of(0.0, 50.0, widen=False).labels
    ('0', '10', '20', '30', '40', '50')
    """
    size = max(abs(low), abs(high))
    if size < SMALLEST:
        low, high = -1.0, 1.0
    elif high - low <= NOISE_SPAN * size:
        low, high = min(0.5 * low, 1.5 * low), max(0.5 * high, 1.5 * high)
    rough = (high - low) / MOST_STEPS
    power = 10.0 ** math.floor(math.log10(rough))
    step = power * next(factor for factor in (1.0, 2.0, 5.0, 10.0) if rough <= factor * power * (1 + NOISE_SPAN))
    down, up = (math.floor, math.ceil) if widen else (math.ceil, math.floor)
    outwards = NOISE_SPAN if widen else -NOISE_SPAN  # an end within rounding error of a tick is one
    ticks = tuple(k * step for k in range(down(low / step + outwards), up(high / step - outwards) + 1))
    if widen:
        low, high = ticks[0], ticks[-1]
    largest = math.floor(math.log10(max(abs(low), abs(high))))
    exponent = 0 if -3 <= largest <= 4 else 3 * (largest // 3)
    digits = max(0, exponent - math.floor(math.log10(step) + NOISE_SPAN))
    labels = (f"{tick / 10.0**exponent:z.{digits}f}".replace("-", "−") for tick in ticks)
    return Axis(low, high, ticks, tuple(labels), exponent)
