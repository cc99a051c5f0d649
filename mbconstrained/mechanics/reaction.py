"""Constraint forces of a motion: the regular multipliers as a function of time, and what happens at t = 0.

The force that the constraints exert is L = M x'' + C x' + K x - f = A^T lambda, and lambda = G L with G A^T = I.
As a distribution on [0, inf), its transform taken from 0-, x' has besides its regular part the jump of x times
delta, x'' the jump of x' times delta and the jump of x times delta', and every impulse c_k delta^(k) of x itself
is differentiated along: for delta^(p)

    L_p = M (jump of x' if p = 0; jump of x if p = 1; c_(p-2)) + C (jump of x if p = 0; c_(p-1)) + K c_p - f_p.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..linalg.noise import Noisy
from ..response.response import Response
from ..signals.bohl import BohlFunction
from ..signals.inputs import ImpulsiveSmooth
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
    displacement, velocity = (_jump(response, order) for order in (0, 1))
    own = [Noisy.rounded(impulse) for impulse in response.impulses]
    parts = [
        (system.mass, [velocity, displacement, *own]),
        (system.damping, [displacement, *own]),
        (system.stiffness, own),
        (-np.eye(system.size), [Noisy.rounded(impulse) for impulse in applied.impulses]),
    ]
    found = []
    for order in range(max(len(factors) for _, factors in parts)):
        force = Noisy.exact(np.zeros(system.size))
        for matrix, factors in parts:
            if order < len(factors):
                force = force + Noisy.rounded(matrix) @ factors[order]
        found.append((Noisy.rounded(system.multiplier_map) @ force).cleaned())
    while found and not found[-1].any():
        found.pop()
    return tuple(found)


def _jump(response: Response, order: int) -> Noisy:
    """The jump of x^(order), where there is one as inaccurate as the values that it is the difference of."""
    jump = response.jump[order]
    size = np.abs(response.initial[order]) + np.abs(response.start[order])
    return Noisy(jump, EPS * np.where(jump != 0, size, 0.0))
