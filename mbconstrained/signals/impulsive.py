"""Inputs on [0, inf): a Bohl function, which may start anew later, plus Dirac impulses at t = 0 and later."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..checks import counted, real_array, real_number
from ..errors import InputError
from ..notices import Notice
from .bohl import BohlFunction
from .origins import Origin, StatesOrigin
from .restarts import later_times


@dataclass(frozen=True)
class Blow:
    """Dirac impulses at one time.

    Attributes:
        time: when, in s.
        impulses: arrays (r,); the k-th multiplies the k-th derivative of Dirac's delta.
    """

    time: float
    impulses: tuple[np.ndarray, ...]


@dataclass(frozen=True, repr=False)
class ImpulsiveSmooth:
    """f = smooth + sum over k of impulses[k] delta^(k), zero before t = 0.

    Attributes:
        smooth: the regular part, a BohlFunction with r rows.
        impulses: arrays (r,); the k-th multiplies the k-th derivative of Dirac's delta.
        later: the Dirac impulses after t = 0, by ascending time.
        notices: what is worth knowing about it, such as how well it approximates what was asked for.
        origins: what it was made of, before any rounding, as far as that is known (``coming_from``); see ``made_of``.
    """

    smooth: BohlFunction
    impulses: tuple[np.ndarray, ...] = ()
    later: tuple[Blow, ...] = ()
    notices: tuple[Notice, ...] = ()
    origins: tuple[Origin, ...] = field(default=(), init=False, compare=False)

    def __repr__(self) -> str:
        told = [counted(self.size, "row"), f"smooth part of {counted(len(self.smooth.coefficients.T), 'state')}"]
        told += [f"impulses at {counted(len(self._blow_times), 'time')}"] if len(self._blow_times) else []
        return f"{type(self).__name__}({', '.join(told)})"

    @property
    def size(self) -> int:
        """Number of rows r."""
        return self.smooth.size

    @property
    def is_zero(self) -> bool:
        """Whether nothing acts at any time."""
        return self.smooth.is_zero and not self.impulses and not self.later

    def coming_from(self, *origins: Origin) -> ImpulsiveSmooth:
        """The same, its origins known. What is made of other parts, by ``dataclasses.replace`` too, does not keep them."""
        object.__setattr__(self, "origins", origins)
        return self

    @property
    def made_of(self) -> tuple[Origin, ...]:
        """What it was made of; where that is not known, what it is."""
        if self.origins or self.is_zero:
            return self.origins
        return (Origin(StatesOrigin(self.smooth, self.impulses, self.later)),)

    @property
    def knots(self) -> np.ndarray:
        """The times in s at which something may start, stop or change, the first is 0."""
        knots = self.smooth.restarts.knots
        return np.union1d(knots, [blow.time for blow in self.later]) if self.later else knots

    def __call__(self, times) -> np.ndarray:
        """The regular part at a time (-> (r,)) or at times (T,) (-> (r, T)); t = 0 means 0+, a knot its right limit."""
        return self.smooth(times)

    def derivative(self, order: int = 1) -> BohlFunction:
        """The classical derivative of the regular part, for t > 0."""
        return self.smooth.derivative(order)

    def distribution_derivative(self) -> ImpulsiveSmooth:
        """f' on [0, inf) in the sense of distributions: with the jump of f at 0 and at each knot as a Dirac impulse there.

        >>> from .inputs import step
        >>> step([2.0]).distribution_derivative().impulses
        (array([2.]),)
        """
        restarts = self.smooth.restarts
        jumps = (self.smooth.coefficients @ restarts.jumps).T
        found = {float(time): (jump,) for time, jump in zip(restarts.knots, jumps) if jump.any()}
        for time, impulses in ((0.0, self.impulses), *((blow.time, blow.impulses) for blow in self.later)):
            if impulses:
                found[time] = (*found.get(time, (np.zeros(self.size),)), *impulses)
        later = tuple(Blow(time, found[time]) for time in sorted(found) if time)
        derivative = ImpulsiveSmooth(self.smooth.derivative(), found.get(0.0, ()), later, self.notices)
        return derivative.coming_from(*(origin.differentiated() for origin in self.made_of))

    def delayed(self, delay: float) -> ImpulsiveSmooth:
        """The input f(t - delay), zero before; delay >= 0 in s.

        Raises:
            InputError: a delay that is negative, or so long that two changes of the input would be rounded to one time.

        >>> from .inputs import impulse, step
        >>> late = (step([1.0]) + impulse([3.0])).delayed(0.5)
        >>> late([0.25, 0.5, 2.0]), late.later[0].time, late.later[0].impulses
        (array([[0., 1., 1.]]), 0.5, (array([3.]),))
        """
        delay = real_number(delay, "delay", minimum=0.0)
        if delay == 0:
            return self
        blows = [self.impulses] * bool(self.impulses) + [blow.impulses for blow in self.later]
        later = tuple(Blow(float(time), blow) for time, blow in zip(later_times(self._blow_times, delay), blows))
        found = ImpulsiveSmooth(self.smooth.delayed(delay), (), later, self.notices)
        return found.coming_from(*(origin.delayed(delay) for origin in self.made_of))

    def mapped(self, matrix) -> ImpulsiveSmooth:
        """matrix @ f, matrix of shape (p, r)."""
        matrix = real_array(matrix, "matrix", shape=(None, self.size))
        return self._changed(self.smooth.mapped(matrix), lambda impulse: matrix @ impulse, matrix)

    def __add__(self, other: ImpulsiveSmooth) -> ImpulsiveSmooth:
        if not isinstance(other, ImpulsiveSmooth):
            return NotImplemented
        if self.size != other.size:
            raise InputError(f"inputs of different sizes cannot be added: {self.size} and {other.size} rows")
        notices = dict.fromkeys((*self.notices, *other.notices))
        impulses, later = _sum(self.impulses, other.impulses), _joined([*self.later, *other.later])
        total = ImpulsiveSmooth(self.smooth + other.smooth, impulses, later, tuple(notices))
        return total.coming_from(*self.made_of, *other.made_of)

    def __radd__(self, other) -> ImpulsiveSmooth:
        """0 + f, so that sum() of inputs works."""
        return self if isinstance(other, (int, float)) and other == 0 else NotImplemented

    def __mul__(self, factor: float) -> ImpulsiveSmooth:
        return self._changed(self.smooth * factor, lambda impulse: impulse * factor, factor)

    __rmul__ = __mul__

    def __neg__(self) -> ImpulsiveSmooth:
        return self * -1.0

    def __sub__(self, other: ImpulsiveSmooth) -> ImpulsiveSmooth:
        return self + -other

    @property
    def _blow_times(self) -> np.ndarray:
        """The times of the Dirac impulses."""
        return np.array([0.0] * bool(self.impulses) + [blow.time for blow in self.later])

    def _changed(self, smooth, change, factor) -> ImpulsiveSmooth:
        later = tuple(Blow(blow.time, tuple(map(change, blow.impulses))) for blow in self.later)
        found = ImpulsiveSmooth(smooth, tuple(map(change, self.impulses)), later, self.notices)
        return found.coming_from(*(origin.multiplied(factor) for origin in self.made_of))


def _joined(blows: Sequence[Blow]) -> tuple[Blow, ...]:
    """By ascending time, those at the same time added."""
    found: dict[float, tuple[np.ndarray, ...]] = {}
    for blow in blows:
        found[blow.time] = _sum(found.get(blow.time, ()), blow.impulses)
    return tuple(Blow(time, found[time]) for time in sorted(found))


def _sum(one, two) -> tuple[np.ndarray, ...]:
    longer, shorter = (one, two) if len(one) >= len(two) else (two, one)
    return tuple(a + b for a, b in zip(longer, shorter)) + tuple(longer[len(shorter) :])
