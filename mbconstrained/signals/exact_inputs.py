"""Exact descriptions of inputs: the numbers that the user gave, before any rounding, for ``mbconstrained.exact``.

The coefficients of v t^3 / 3! and of v cos(w t + p) are rounded when they become a Bohl function, and so are its states at
later knots. The numbers of the description are not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from ..ground.tolerances import EPS
from .bohl import BohlFunction


@dataclass(frozen=True, eq=False)
class ExactTerm:
    """vector t^power e^{rate t} cos(angular_frequency t + phase) / divisor."""

    vector: np.ndarray
    power: int = 0
    rate: float = 0.0
    angular_frequency: float = 0.0
    phase: float = 0.0
    divisor: int = 1


@dataclass(frozen=True, eq=False)
class ExactImpulse:
    """vector times the derivative of this order of Dirac's delta."""

    vector: np.ndarray
    order: int


@dataclass(frozen=True, eq=False)
class ExactRecord:
    """Linear between samples, values (r, T) at times (T,), zero before and after."""

    times: np.ndarray
    values: np.ndarray


@dataclass(frozen=True, eq=False)
class ImpulsiveLoad:
    """An impulsive load: the sum over k of impulses[k] delta^(k)(t - time).

    Attributes:
        time: in s.
        impulses: arrays (r,); the k-th multiplies the k-th derivative of Dirac's delta, in N s^(k+1) for a force in N.
    """

    time: float
    impulses: tuple[np.ndarray, ...]


@dataclass(frozen=True, eq=False)
class ExactStates:
    """A Bohl function with impulses, its float64 states at each knot taken as exact."""

    smooth: BohlFunction
    impulses: tuple[np.ndarray, ...]
    later: tuple[ImpulsiveLoad, ...]


@dataclass(frozen=True, eq=False)
class ExactInput:
    """Summand of an input: its data, and the operations applied to it.

    Attributes:
        data: the summand before the operations.
        maps: matrices (p, r) and factors that multiply it, in their order.
        delays: delays in s, in their order.
        derivatives: number of differentiations in the sense of distributions.
    """

    data: ExactTerm | ExactImpulse | ExactRecord | ExactStates
    maps: tuple[np.ndarray | float, ...] = ()
    delays: tuple[float, ...] = ()
    derivatives: int = 0

    def multiplied(self, factor: np.ndarray | float) -> ExactInput:
        """The summand multiplied from the left."""
        return replace(self, maps=(*self.maps, factor))

    def delayed(self, delay: float) -> ExactInput:
        """The summand delayed by this time (s)."""
        return replace(self, delays=(*self.delays, delay))

    def differentiated(self) -> ExactInput:
        """The derivative of the summand in the sense of distributions."""
        return replace(self, derivatives=self.derivatives + 1)

    def time(self, start: float = 0.0) -> Fraction:
        """The time in s to which the delays move ``start``, exactly: durations between late times keep their digits."""
        return sum(map(Fraction, self.delays), Fraction(start))

    def rounded_time(self, start: float = 0.0) -> float:
        """The time with each sum rounded to float64, as the times of impulses are."""
        for delay in self.delays:
            start = float(start + delay)
        return start


#: Phases beyond this (rad) are too coarse in float64 to stand for a quarter turn.
LARGEST_EXACT_PHASE = 1e6


def without_phase_noise(value: float, phase: float) -> float:
    """The cosine or sine of a phase, zero where the rounding error of the phase exceeds it.

    With the phase -pi/2 a harmonic is a sine: it does not jump at its start.
    """
    return 0.0 if abs(value) <= EPS * min(abs(phase), LARGEST_EXACT_PHASE) else value
