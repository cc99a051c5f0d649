"""Many bodies."""

from __future__ import annotations

import numpy as np

from ...problem import Problem
from .building import bodies, chain, moving, spaced
from .system import System, Varied


def chain_of_masses(count: float) -> Problem:
    """Equal masses on equal springs from the ground on, the last one displaced, the ground damped."""
    n = int(count)
    system = bodies([1.0] * n, chain(*[1.0] * n), [(0, 1, 0.25)])
    return moving("A chain of masses", system, spaced(0.1, 100.0, 6), (np.eye(n)[-1], np.zeros(n)))


SYSTEMS = (
    System(
        "chain_of_masses",
        "Chains of 2 to 40 masses",
        "Errors must not grow with the size faster than the size.",
        "made for this gallery",
        Varied("masses", "", (2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 40.0)),
        chain_of_masses,
        {"finite_zeros": lambda n: 2 * int(n), "symmetric": True, "mass_ratio": 1.0, "jumps": False, "impulses": 0},
    ),
)
