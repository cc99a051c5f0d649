"""Constraint forces of a motion: the regular multipliers as a function of time, and their impulses at t = 0 and later.

The force that the constraints exert is L = M x'' + C x' + K x - f = A^T lambda, and lambda = G L with G A^T = I.
As a distribution on [0, inf), its transform taken from 0-, x' has in addition to its regular part the jump of x times
delta, x'' the jump of x' times delta and the jump of x times delta', and every impulse c_k delta^(k) of x itself
is differentiated along: for delta^(p)

    L_p = M (jump of x' if p = 0; jump of x if p = 1; c_(p-2)) + C (jump of x if p = 0; c_(p-1)) + K c_p - f_p.

The same holds at the time of an event. All events are computed at once, each a column of the arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, reduce

import numpy as np

from ..ground.tolerances import EPS
from ..linalg.rank import Noisy
from ..response.events import Event, without_zeros
from ..response.response import Response
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveLoad, ImpulsiveSmooth
from .equations import EquationsOfMotion


class FunctionSum(BohlFunction):
    """A sum of functions, each evaluated by its own method; the states are combined only on demand."""

    terms: tuple[BohlFunction, ...]

    def __init__(self, terms: Sequence[BohlFunction]):
        object.__setattr__(self, "terms", tuple(terms))

    @cached_property
    def _closed(self) -> BohlFunction:
        return reduce(BohlFunction.__add__, self.terms)

    coefficients = property(lambda self: self._closed.coefficients)
    blocks = property(lambda self: self._closed.blocks)
    start = property(lambda self: self._closed.start)
    size = property(lambda self: self.terms[0].size)
    state_count = property(lambda self: max(term.state_count for term in self.terms))
    summed_from = property(lambda self: np.min([term.summed_from for term in self.terms], axis=0))

    def _values(self, times) -> np.ndarray:
        return sum((term._values(times) for term in self.terms[1:]), self.terms[0]._values(times))

    def derivative(self, order: int = 1) -> BohlFunction:
        """The classical derivative."""
        return FunctionSum([term.derivative(order) for term in self.terms])

    def mapped(self, matrix) -> BohlFunction:
        """matrix @ f(t), matrix of shape (p, r)."""
        return FunctionSum([term.mapped(matrix) for term in self.terms])

    def rows(self, indices) -> BohlFunction:

        return FunctionSum([term.rows(indices) for term in self.terms])

    def __mul__(self, factor: float) -> BohlFunction:
        return FunctionSum([term * factor for term in self.terms])

    __rmul__ = __mul__


def reaction_function(system: EquationsOfMotion, response: Response, applied: ImpulsiveSmooth) -> BohlFunction:
    """The regular part of lambda = G (K x + C x' + M x'' - f) for t > 0."""
    G = system.multiplier_map
    inertial = response.function.differential(*(G @ matrix for matrix in (system.stiffness, system.damping, system.mass)))
    return inertial if applied.smooth.is_zero else FunctionSum([inertial, applied.smooth.mapped(-G)])


def reaction_impulses(system: EquationsOfMotion, response: Response, applied: ImpulsiveSmooth) -> tuple[ImpulsiveLoad, ...]:
    """The impulses of lambda at t = 0 and later, by ascending time; none at times without one."""
    n, none = system.size, Event(0.0, np.zeros_like(response.jump), ())
    events = {0.0: Event(0.0, response.jump, response.impulses), **{event.time: event for event in response.events}}
    loads = {0.0: applied.impulses, **{load.time: load.impulses for load in applied.later}}
    times = sorted({*events, *loads})
    each = [events.get(time, none) for time in times]
    # a jump at t = 0 is as inaccurate as the values that it is the difference of, a later one as the largest of its event
    sizes = np.array([np.abs(event.jump).max(axis=1, keepdims=True) + 0 * event.jump for event in each])
    sizes[0] = np.abs(response.initial) + np.abs(response.start)
    jumps = np.array([event.jump for event in each])
    noise = EPS * np.where(jumps != 0, sizes, 0.0)
    x = [Noisy(jumps[:, order].T, noise[:, order].T) for order in (0, 1)]
    own, force = (_by_order(impulses, n) for impulses in ([e.impulses for e in each], [loads.get(time, ()) for time in times]))
    parts = [
        (system.mass, [x[1], x[0], *own]),
        (system.damping, [x[0], *own]),
        (system.stiffness, own),
        (-np.eye(n), force),
    ]
    total = []
    for order in range(max(len(factors) for _, factors in parts)):
        terms = [Noisy.rounded(matrix) @ factors[order] for matrix, factors in parts if order < len(factors)]
        total.append((Noisy.rounded(system.multiplier_map) @ reduce(Noisy.__add__, terms)).cleaned())
    impulses = [without_zeros([impulse[:, k] for impulse in total]) for k in range(len(times))]
    return tuple(ImpulsiveLoad(time, own) for time, own in zip(times, impulses) if own)


def _by_order(impulses, size) -> list[Noisy]:
    """Arrays (n, K) of the impulses of K events, one for each order of derivative."""
    count = max(map(len, impulses), default=0)
    none = np.zeros(size)
    return [Noisy.rounded(np.array([own[k] if k < len(own) else none for own in impulses]).T) for k in range(count)]
