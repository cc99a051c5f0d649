"""What an input was made of, before any rounding: the exact engine takes it from here.

The coefficients of v t^3 / 3! and of v cos(w t + p) are rounded when they become a Bohl function, and so are the states that
it is given at later knots. The numbers that the user gave are not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..tolerances import EPS

if TYPE_CHECKING:
    from .bohl import BohlFunction
    from .impulsive import Blow


@dataclass(frozen=True)
class TermOrigin:
    """vector t^power e^{rate t} cos(angular_frequency t + phase) / divisor."""

    vector: np.ndarray
    power: int = 0
    rate: float = 0.0
    angular_frequency: float = 0.0
    phase: float = 0.0
    divisor: int = 1


@dataclass(frozen=True)
class ImpulseOrigin:
    """vector times the derivative of this order of Dirac's delta."""

    vector: np.ndarray
    order: int


@dataclass(frozen=True)
class RecordOrigin:
    """Linear between samples, values (r, T) at times (T,), zero before and after."""

    times: np.ndarray
    values: np.ndarray


@dataclass(frozen=True)
class StatesOrigin:
    """Nothing but the Bohl function itself, its states at each knot taken as they are, and impulses."""

    smooth: BohlFunction
    impulses: tuple[np.ndarray, ...]
    later: tuple[Blow, ...]


@dataclass(frozen=True)
class Origin:
    """Something that an input was made of, and what was done to it since.

    Attributes:
        data: what it was.
        maps: matrices (p, r) and factors that multiply it, in the order in which they do.
        delays: in s, in the order in which they were added; each sum is rounded to float64, as the knots of the input are.
        derivatives: how often it was differentiated, in the sense of distributions.
    """

    data: TermOrigin | ImpulseOrigin | RecordOrigin | StatesOrigin
    maps: tuple[np.ndarray | float, ...] = ()
    delays: tuple[float, ...] = ()
    derivatives: int = 0

    def multiplied(self, factor: np.ndarray | float) -> Origin:
        """Multiplied from the left."""
        return replace(self, maps=(*self.maps, factor))

    def delayed(self, delay: float) -> Origin:
        """Later by so much."""
        return replace(self, delays=(*self.delays, delay))

    def differentiated(self) -> Origin:
        """Its derivative in the sense of distributions."""
        return replace(self, derivatives=self.derivatives + 1)

    def time(self, start: float = 0.0) -> float:
        """When that happens which without delays happens at start."""
        for delay in self.delays:
            start = float(start + delay)
        return start


#: A larger phase, in rad, is so coarse that nobody can have meant a quarter turn by it.
LARGEST_MEANT = 1e6


def beyond_noise(value: float, phase: float) -> float:
    """The cosine or sine of a phase, zero where it is not more than the rounding of the phase.

    With the phase -pi/2 a harmonic is a sine: it does not jump at its start.
    """
    return 0.0 if abs(value) <= EPS * min(abs(phase), LARGEST_MEANT) else value
