"""Impulsive-smooth functions: a piecewise Bohl function on [0, inf) plus Dirac impulses at t = 0 and later, and their exact data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property

import numpy as np

from ..ground.by_name import Public
from ..ground.checks import counted, real_array, real_number
from ..ground.errors import InputError
from ..ground.notices import Notice, distinct
from ..ground.tolerances import EPS
from .bohl import BohlFunction, later_times

# Exact descriptions of inputs: the numbers that the user gave, before any rounding, for ``mbconstrained.exact``.
# The coefficients of v t^3 / 3! and of v cos(w t + p) are rounded when they become a Bohl function, and so are its states at
# later knots. The numbers of the description are not.


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
class ImpulsiveLoad(Public):
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
    """Summand of an input: its data, and the operations applied to it."""

    data: ExactTerm | ExactImpulse | ExactRecord | ExactStates  # the summand before the operations
    maps: tuple[np.ndarray | float, ...] = ()  # matrices (p, r) and factors that multiply it, in their order
    delays: tuple[float, ...] = ()  # delays in s, in their order
    derivatives: int = 0  # number of differentiations in the sense of distributions

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


# Impulsive-smooth functions: a piecewise Bohl function on [0, inf) plus Dirac impulses at t = 0 and later.


@dataclass(frozen=True, repr=False, eq=False)
class ImpulsiveSmooth(Public):
    """An impulsive-smooth function f(t) = smooth(t) + sum of impulses[k] delta^(k)(t) + later impulses, zero before t = 0.

    Functions of equal size add; a number, or ``mapped`` a matrix, multiplies them.

    Attributes:
        smooth: the regular part, a BohlFunction with r rows.
        impulses: arrays (r,); the k-th multiplies the k-th derivative of Dirac's delta at t = 0.
        later: the Dirac impulses after t = 0, by ascending time.
        notices: reports on the function, such as the accuracy of an approximation.
        exact_inputs: the summands before any rounding, where they are known; see ``exact_parts``.

    >>> from mbconstrained.signals.inputs import impulse, step
    >>> f = step([2.0]) + 0.5 * impulse([3.0])
    >>> f(1.0), f.impulses
    (array([2.]), (array([1.5]),))
    """

    smooth: BohlFunction
    impulses: tuple[np.ndarray, ...] = ()
    later: tuple[ImpulsiveLoad, ...] = ()
    notices: tuple[Notice, ...] = ()
    exact_inputs: tuple[ExactInput, ...] = field(default=(), init=False, compare=False)

    def __repr__(self) -> str:
        parts = [counted(self.size, "row"), f"smooth part of {counted(len(self.smooth.coefficients.T), 'state')}"]
        parts += [f"impulses at {counted(len(self._impulse_times), 'time')}"] if len(self._impulse_times) else []
        return f"{type(self).__name__}({', '.join(parts)})"

    @property
    def size(self) -> int:
        """Number of rows r."""
        return self.smooth.size

    @property
    def is_zero(self) -> bool:
        """Whether the function vanishes at all times."""
        return self.smooth.is_zero and not self.impulses and not self.later

    def described_by(self, *exact_inputs: ExactInput) -> ImpulsiveSmooth:
        """Return the function with its exact description, which copies by ``dataclasses.replace`` do not keep."""
        object.__setattr__(self, "exact_inputs", exact_inputs)
        return self

    @property
    def exact_parts(self) -> tuple[ExactInput, ...]:
        """Exact summands; the function itself where they are unknown."""
        if self.exact_inputs or self.is_zero:
            return self.exact_inputs
        return (ExactInput(ExactStates(self.smooth, self.impulses, self.later)),)

    @cached_property
    def knots(self) -> np.ndarray:
        """Times in s at which the function may start, stop or change, beginning with 0."""
        knots = self.smooth.restarts.knots
        return np.union1d(knots, [load.time for load in self.later]) if self.later else knots

    def __call__(self, times) -> np.ndarray:
        """The regular part at a time (-> (r,)) or at times (T,) (-> (r, T)); t = 0 means 0+, a knot its right limit."""
        return self.smooth(times)

    def derivative(self, order: int = 1) -> BohlFunction:
        """The classical derivative of the regular part, for t > 0."""
        return self.smooth.derivative(order)

    def distribution_derivative(self) -> ImpulsiveSmooth:
        """The derivative f' on [0, inf) in the sense of distributions: each jump of f gives a Dirac impulse at its time.

        >>> from mbconstrained.signals.inputs import step
        >>> step([2.0]).distribution_derivative().impulses
        (array([2.]),)
        """
        restarts = self.smooth.restarts
        jumps = (self.smooth.coefficients @ restarts.jumps).T
        impulses_at = {float(time): (jump,) for time, jump in zip(restarts.knots, jumps) if jump.any()}
        for time, impulses in ((0.0, self.impulses), *((load.time, load.impulses) for load in self.later)):
            if impulses:
                impulses_at[time] = (*impulses_at.get(time, (np.zeros(self.size),)), *impulses)
        later = tuple(ImpulsiveLoad(time, impulses_at[time]) for time in sorted(impulses_at) if time)
        derivative = ImpulsiveSmooth(self.smooth.derivative(), impulses_at.get(0.0, ()), later, self.notices)
        return derivative.described_by(*(summand.differentiated() for summand in self.exact_parts))

    def delayed(self, delay: float) -> ImpulsiveSmooth:
        """The delayed function f(t - delay), zero before.

        Args:
            delay: in s, at least 0.

        Raises:
            InputError: a negative delay, or one so long that two changes of the input would be rounded to one time.

        >>> from mbconstrained.signals.inputs import impulse, step
        >>> late = (step([1.0]) + impulse([3.0])).delayed(0.5)
        >>> late([0.25, 0.5, 2.0]), late.later[0].time, late.later[0].impulses
        (array([[0., 1., 1.]]), 0.5, (array([3.]),))
        """
        delay = real_number(delay, "delay", minimum=0.0)
        if delay == 0:
            return self
        loads = [self.impulses] * bool(self.impulses) + [load.impulses for load in self.later]
        later = tuple(ImpulsiveLoad(float(time), load) for time, load in zip(later_times(self._impulse_times, delay), loads))
        delayed = ImpulsiveSmooth(self.smooth.delayed(delay), (), later, self.notices)
        return delayed.described_by(*(summand.delayed(delay) for summand in self.exact_parts))

    def mapped(self, matrix) -> ImpulsiveSmooth:
        """The product matrix @ f for a matrix of shape (p, r)."""
        matrix = real_array(matrix, "matrix", shape=(None, self.size))
        return self._changed(self.smooth.mapped(matrix), lambda impulse: matrix @ impulse, matrix)

    def __add__(self, other: ImpulsiveSmooth) -> ImpulsiveSmooth:
        if isinstance(other, (int, float)) and other:
            raise InputError(f"inputs: found {other!r} as a term; a constant input is mb.step({other!r})")
        if not isinstance(other, ImpulsiveSmooth):
            return NotImplemented
        if self.size != other.size:
            raise InputError(f"inputs of different sizes cannot be added: {self.size} and {other.size} rows")
        impulses, later = _sum(self.impulses, other.impulses), _joined([*self.later, *other.later])
        total = ImpulsiveSmooth(self.smooth + other.smooth, impulses, later, distinct(self.notices, other.notices))
        return total.described_by(*self.exact_parts, *other.exact_parts)

    def __radd__(self, other) -> ImpulsiveSmooth:
        """0 + f, so that sum() of inputs works."""
        return self if isinstance(other, (int, float)) and other == 0 else self + other

    def __mul__(self, factor: float) -> ImpulsiveSmooth:
        return self._changed(self.smooth * factor, lambda impulse: impulse * factor, factor)

    __rmul__ = __mul__

    def __neg__(self) -> ImpulsiveSmooth:
        return self * -1.0

    def __sub__(self, other: ImpulsiveSmooth) -> ImpulsiveSmooth:
        return self + -other

    @property
    def _impulse_times(self) -> np.ndarray:
        """The times of the Dirac impulses."""
        return np.array([0.0] * bool(self.impulses) + [load.time for load in self.later])

    def _changed(self, smooth, change, factor) -> ImpulsiveSmooth:
        later = tuple(ImpulsiveLoad(load.time, tuple(map(change, load.impulses))) for load in self.later)
        changed = ImpulsiveSmooth(smooth, tuple(map(change, self.impulses)), later, self.notices)
        return changed.described_by(*(summand.multiplied(factor) for summand in self.exact_parts))


def _joined(loads: Sequence[ImpulsiveLoad]) -> tuple[ImpulsiveLoad, ...]:
    """Impulsive loads by ascending time, those at the same time added."""
    sums: dict[float, tuple[np.ndarray, ...]] = {}
    for load in loads:
        sums[load.time] = _sum(sums.get(load.time, ()), load.impulses)
    return tuple(ImpulsiveLoad(time, sums[time]) for time in sorted(sums))


def _sum(one, two) -> tuple[np.ndarray, ...]:
    longer, shorter = (one, two) if len(one) >= len(two) else (two, one)
    return tuple(a + b for a, b in zip(longer, shorter)) + tuple(longer[len(shorter) :])
