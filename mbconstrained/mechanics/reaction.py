"""Constraint forces of a motion: the regular multipliers as a function of time, and what happens at t = 0 and later.

The force that the constraints exert is L = M x'' + C x' + K x - f = A^T lambda, and lambda = G L with G A^T = I.
As a distribution on [0, inf), its transform taken from 0-, x' has besides its regular part the jump of x times
delta, x'' the jump of x' times delta and the jump of x times delta', and every impulse c_k delta^(k) of x itself
is differentiated along: for delta^(p)

    L_p = M (jump of x' if p = 0; jump of x if p = 1; c_(p-2)) + C (jump of x if p = 0; c_(p-1)) + K c_p - f_p.

The same holds at the time of an event. All events are computed at once, each a column of the arrays.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..linalg.noise import Noisy
from ..response.events import Event
from ..response.parts import without_zeros
from ..response.response import Response
from ..signals.bohl import BohlFunction
from ..signals.impulsive import Blow, ImpulsiveSmooth
from ..tolerances import EPS

if TYPE_CHECKING:
    from .system import MechanicalSystem


def reaction_function(system: MechanicalSystem, response: Response, applied: ImpulsiveSmooth) -> BohlFunction:
    """The regular part of lambda for t > 0, k rows."""
    G, x = system.multiplier_map, response.function
    held = x.mapped(G @ system.stiffness) + x.derivative(1).mapped(G @ system.damping)
    return held + x.derivative(2).mapped(G @ system.mass) - applied.smooth.mapped(G)


def reaction_impulses(system: MechanicalSystem, response: Response, applied: ImpulsiveSmooth) -> tuple[np.ndarray, ...]:
    """Arrays (k,), the p-th multiplies the p-th derivative of Dirac's delta in lambda; none where there are no impulses."""
    jumps = [_jump(response, order)[:, None] for order in (0, 1)]
    own, applied_here = ([g[:, None] for g in impulses] for impulses in (response.impulses, applied.impulses))
    return without_zeros([impulse[:, 0] for impulse in _impulses(system, jumps, own, applied_here)])


def later_reaction_impulses(system: MechanicalSystem, response: Response, applied: ImpulsiveSmooth) -> tuple[Blow, ...]:
    """The impulses of lambda at later times, by ascending time; none at times without one."""
    events, blows = ({item.time: item for item in items} for items in (response.events, applied.later))
    times = sorted({*events, *blows})
    nothing = Event(0.0, np.zeros_like(response.jump), ())
    found = [events.get(time, nothing) for time in times]
    jumps = [_known(np.reshape([event.jump[order] for event in found], (len(times), system.size)).T) for order in (0, 1)]
    own = _by_order([event.impulses for event in found], system.size)
    applied_there = _by_order([blows[time].impulses if time in blows else () for time in times], system.size)
    impulses = _impulses(system, jumps, own, applied_there)
    each = [without_zeros([impulse[:, k] for impulse in impulses]) for k in range(len(times))]
    return tuple(Blow(time, own) for time, own in zip(times, each) if own)


def _impulses(system, jumps: list[Noisy], own: list[np.ndarray], applied: list[np.ndarray]) -> list[np.ndarray]:
    """The impulses of lambda by order, shape (k, K), from the jumps of x and x' and the impulses of x and f, (n, K)."""
    own = [Noisy.rounded(impulse) for impulse in own]
    parts = [
        (system.mass, [jumps[1], jumps[0], *own]),
        (system.damping, [jumps[0], *own]),
        (system.stiffness, own),
        (-np.eye(system.size), [Noisy.rounded(impulse) for impulse in applied]),
    ]
    found = []
    for order in range(max(len(factors) for _, factors in parts)):
        force = Noisy.exact(np.zeros_like(jumps[0].data))
        for matrix, factors in parts:
            if order < len(factors):
                force = force + Noisy.rounded(matrix) @ factors[order]
        found.append((Noisy.rounded(system.multiplier_map) @ force).cleaned())
    return found


def _jump(response: Response, order: int) -> Noisy:
    """The jump of x^(order), where there is one as inaccurate as the values that it is the difference of."""
    jump = response.jump[order]
    size = np.abs(response.initial[order]) + np.abs(response.start[order])
    return Noisy(jump, EPS * np.where(jump != 0, size, 0.0))


def _known(jumps: np.ndarray) -> Noisy:
    """Jumps (n, K) that a jump of the force or an impulse has caused, each event as accurate as its largest."""
    return Noisy(jumps, EPS * np.where(jumps != 0, np.abs(jumps).max(axis=0, initial=0.0), 0.0))


def _by_order(impulses, size) -> list[np.ndarray]:
    """For each order of derivative an array (n, K), from the impulses of K events."""
    count = max(map(len, impulses), default=0)
    nothing = np.zeros(size)
    return [np.array([own[k] if k < len(own) else nothing for own in impulses]).T for k in range(count)]
