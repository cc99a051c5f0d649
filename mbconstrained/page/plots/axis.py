"""Axes of plots: a range, linear or logarithmic, and its ticks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...ground.errors import InputError
from ..typeset import superscript

Scale = Literal["linear", "log"]

#: A range narrower than this share of its values is rounding error and drawn as a constant.
NOISE_SPAN = 1e-9

#: Most steps between the ends of an axis before it is widened.
MOST_STEPS = 6

#: Values smaller than this count as zero.
SMALLEST = 1e-290

#: Powers of ten within which a tick of a logarithmic axis is labelled as a decimal number.
FIRST_POWER, LAST_POWER = -3, 4

#: Decades of a logarithmic axis up to which each has ticks at 2 and 5, too.
FEW_DECADES = 2

#: With fewer ticks at 1, 2 and 5 times powers of ten a logarithmic axis has them at even steps.
FEWEST_TICKS = 3

#: The largest number of decades of a logarithmic axis: smaller values are at its low end.
MOST_DECADES = 18


@dataclass(frozen=True)
class Axis:
    """A range and its ticks.

    Attributes:
        low, high: the range; every tick lies in it.
        ticks: values of the ticks.
        labels: their texts, in units of 10^exponent.
        exponent: a multiple of three, or 0 for labels without a common power of ten.
        scale: "linear", or "log" for even steps of the logarithm.
    """

    low: float
    high: float
    ticks: tuple[float, ...]
    labels: tuple[str, ...]
    exponent: int
    scale: Scale = "linear"

    def shares(self, values: np.ndarray) -> np.ndarray:
        """Positions of values on the axis, from 0 at its low end to 1 at its high end.

        Args:
            values: values of any shape; on a logarithmic axis those below its low end are at that end.

        Returns:
            Positions of the same shape.

        >>> axis_of(1.0, 100.0, scale="log").shares(np.array([1.0, 10.0, 0.0]))
        array([0. , 0.5, 0. ])
        """
        return self.fractions(np.maximum(values, self.low) if self.scale == "log" else values)

    def fractions(self, values) -> np.ndarray:
        """Positions of values, those outside the axis below 0 or above 1; positive ones on a logarithmic axis."""
        low, high, values = self.low, self.high, np.asarray(values, dtype=float)
        if self.scale == "log":
            low, high, values = math.log10(low), math.log10(high), np.log10(values)
        return (values - low) / (high - low)


def axis_of(low: float, high: float, *, widen: bool = True, scale: Scale = "linear") -> Axis:
    """An axis with ticks at even steps of 1, 2 or 5 times a power of ten, or at powers of ten.

    >>> axis_of(-0.93, 1.7).labels
    ('−1.0', '−0.5', '0.0', '0.5', '1.0', '1.5', '2.0')
    >>> axis_of(0.0, 50.0, widen=False).labels
    ('0', '10', '20', '30', '40', '50')
    >>> axis_of(0.02, 300.0, scale="log").labels
    ('0.01', '0.1', '1', '10', '100', '1000')
    """
    if scale == "log":
        return _log_axis(low, high, widen)
    size = max(abs(low), abs(high))
    if size < SMALLEST:
        low, high = -1.0, 1.0
    elif high - low <= NOISE_SPAN * size:
        low, high = min(0.5 * low, 1.5 * low), max(0.5 * high, 1.5 * high)
    step = _step(high - low)
    ticks = _multiples(low, high, step, widen)
    if widen:
        low, high = ticks[0], ticks[-1]
    largest = math.floor(math.log10(max(abs(low), abs(high))))
    exponent = 0 if -3 <= largest <= 4 else 3 * (largest // 3)
    digits = max(0, exponent - math.floor(math.log10(step) + NOISE_SPAN))
    labels = (f"{tick / 10.0**exponent:z.{digits}f}".replace("-", "−") for tick in ticks)
    return Axis(low, high, ticks, tuple(labels), exponent)


def _step(span: float) -> float:
    """1, 2 or 5 times a power of ten, at most ``MOST_STEPS`` of them in the span."""
    rough = span / MOST_STEPS
    power = 10.0 ** math.floor(math.log10(rough))
    return power * next(factor for factor in (1.0, 2.0, 5.0, 10.0) if rough <= factor * power * (1 + NOISE_SPAN))


def _multiples(low: float, high: float, step: float, widen: bool) -> tuple[float, ...]:
    """The multiples of a step in a range, or with those just outside it."""
    down, up = (math.floor, math.ceil) if widen else (math.ceil, math.floor)
    outwards = NOISE_SPAN if widen else -NOISE_SPAN  # an end within rounding error of a tick is one
    return tuple(k * step for k in range(down(low / step + outwards), up(high / step - outwards) + 1))


def _log_axis(low: float, high: float, widen: bool) -> Axis:
    """Ticks at powers of ten; of few decades at 2 and 5 too, and of a small part of one at even steps."""
    if high < SMALLEST:
        raise InputError(f"a logarithmic axis: found values up to {high:g}; expected positive ones, or give a linear axis")
    low = max(low, SMALLEST, high * 10.0**-MOST_DECADES)
    if high - low <= NOISE_SPAN * high:
        low, high = low / 2, high * 2
    if widen:
        low, high = 10.0 ** math.floor(math.log10(low) + NOISE_SPAN), 10.0 ** math.ceil(math.log10(high) - NOISE_SPAN)
    first, last = math.ceil(math.log10(low) - NOISE_SPAN), math.floor(math.log10(high) + NOISE_SPAN)
    stride = max(1, math.ceil((last - first) / MOST_STEPS))
    factors = (1.0, 2.0, 5.0) if last - first <= FEW_DECADES else (1.0,)
    powers = [k for k in range(first - 1, last + 1) if k % stride == 0]
    every = [factor * 10.0**k for k in powers for factor in factors]
    ticks = tuple(tick for tick in every if low * (1 - NOISE_SPAN) <= tick <= high * (1 + NOISE_SPAN))
    if len(ticks) < FEWEST_TICKS:
        ticks = _multiples(low, high, _step(high - low), widen=False)
    return Axis(low, high, ticks, tuple(map(power_label, ticks)), 0, "log")


def power_label(value: float) -> str:
    """Label of a number on a logarithmic axis.

    >>> power_label(200.0), power_label(2e6)
    ('200', '2·10⁶')
    """
    power = math.floor(math.log10(value) + NOISE_SPAN)
    if FIRST_POWER <= power <= LAST_POWER:
        return f"{value:.12g}"
    factor = value / 10.0**power
    return ("" if abs(factor - 1) < 1e-6 else f"{factor:.6g}·") + f"10{superscript(power)}"
