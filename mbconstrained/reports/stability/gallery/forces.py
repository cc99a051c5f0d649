"""Forces that resonate, and slow forces on stiff systems."""

from __future__ import annotations

import numpy as np

from ....signals import ramp, step, term
from ...problem import Problem
from .building import bodies, equations, moving, spaced
from .system import System, Varied, decades

#: rad/s, of the double zero of ``resonance``.
NATURAL = 3.0


def resonance(detuning: float) -> Problem:
    """Two oscillators one after the other, both at 3 rad/s, under a sine near it: x grows like t^2."""
    coefficients = [[[18.0, -9.0], [-47.0, 28.0]], np.zeros((2, 2)), [[2.0, -1.0], [-5.0, 3.0]]]
    force = term([1.0, 1.0], angular_frequency=NATURAL * (1 + detuning), phase=-np.pi / 2)
    return equations("Resonance", coefficients, [[1.0, 1.0], [0.0, 2.0]], spaced(0.05, 60.0), force)


def ramp_on_stiff_pair(ratio: float) -> Problem:
    """Two bodies on a stiff spring, held by a soft one, pulled apart by slow ramps from a start that does not ring."""
    system = bodies([1.0, 2.0], [(0, 1, 1.0), (1, 2, ratio)], [(1, 2, 0.1 * ratio**0.5)])
    return moving("A stiff pair", system, spaced(0.1, 100.0), ([0.0, 0.0], [1.0, 1.0]), ramp([0.5, 1.0]))


def soft_mount(stiffness: float) -> Problem:
    """(s^2 + k) (s^2 + 4) x = a step: a slow zero beside an ordinary one, under a load that stays."""
    coefficients = [4 * stiffness, 0.0, 4 + stiffness, 0.0, 1.0]
    return equations("A soft mount", [[[c]] for c in coefficients], [0.0] * 4, np.linspace(0.0, 5.0, 11), step([1.0]))


def slow_pair(stiffness: float) -> Problem:
    """(s^2 + k) (s^2 + 2 k) (s^2 + 4) x = a step: two slow zeros beside an ordinary one."""
    k = stiffness
    coefficients = [8 * k**2, 0.0, 2 * k**2 + 12 * k, 0.0, 4 + 3 * k, 0.0, 1.0]
    return equations("Two soft mounts", [[[c]] for c in coefficients], [0.0] * 6, np.linspace(0.0, 5.0, 11), step([1.0]))


def prothero_robinson(rate: float) -> Problem:
    """x' = -r (x - cos t) - sin t from x = 1, whose answer is cos t at any rate r."""
    force = term([rate], angular_frequency=1.0) + term([-1.0], angular_frequency=1.0, phase=-np.pi / 2)
    return equations("Prothero and Robinson", [[[rate]], [[1.0]]], [1.0], spaced(0.01, 100.0), force)


SYSTEMS = (
    System(
        "resonance",
        "Resonance approached at a double zero",
        "Near resonance the answer is the difference of two large oscillations; at resonance a chain of length 3 with the force.",
        "referee case resonance_double",
        Varied("detuning of the force", "", (*decades(-1, -15), 0.0)),
        resonance,
        {"finite_zeros": 4, "longest_chain": 2, "undamped": True},
    ),
    System(
        "ramp_on_stiff_pair",
        "A ramp on a stiff pair",
        "The stretch of the stiff spring is 1 / r of the motion, and its ringing is sqrt(r) times as fast.",
        "made for this gallery",
        Varied("stiffness ratio", "", decades(0, 16, 2)),
        ramp_on_stiff_pair,
        {"finite_zeros": 4, "symmetric": True, "stiffness_ratio": lambda ratio: ratio, "growing_zeros": 0, "jumps": False},
    ),
    System(
        "soft_mount",
        "A load on a soft mount",
        "The load's answer is the difference of a large static deflection and a slow oscillation, until they come apart.",
        "made for this gallery",
        Varied("stiffness of the mount", "1/s^2", decades(0, -16, 2)),
        soft_mount,
        {"finite_zeros": 4, "undamped": True, "growing_zeros": 0, "zeros_at_0": 0},
    ),
    System(
        "slow_pair",
        "Two slow modes beside an ordinary one",
        "The two slow motions cancel but for a small remainder until they come apart, long after the times asked for.",
        "made for this gallery",
        Varied("stiffness of the mounts", "1/s^2", decades(0, -12, 2)),
        slow_pair,
        {"finite_zeros": 6, "zeros_at_0": 0},
    ),
    System(
        "prothero_robinson",
        "A smooth motion beside a fast decay",
        "The answer is cos t at any rate; steps that are long beside 1 / r lose the order of most methods.",
        "Prothero and Robinson, Math. Comp. 28 (1974) 145-162",
        Varied("rate r", "1/s", decades(0, 16, 2)),
        prothero_robinson,
        {"finite_zeros": 1, "growing_zeros": 0, "zeros_at_0": 0, "jumps": False},
    ),
)
