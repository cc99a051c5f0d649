"""Very long and very short times, growth."""

from __future__ import annotations

import numpy as np

from ....signals import ramp, step
from ...problem import Problem
from .building import bodies, equations, moving, spaced
from .system import System, Varied, decades


def long_horizon(end: float) -> Problem:
    """Two undamped oscillators up to a million periods."""
    coefficients = [[[3.0, -1.0], [-1.0, 2.5]], np.zeros((2, 2)), np.diag([1.0, 1.25])]
    return equations("Many periods", coefficients, [[1.0, 0.5], [0.0, -1.0]], spaced(1.0, end))


def free_chain(end: float) -> Problem:
    """Seven bodies that nothing holds, pushed by a constant force."""
    springs = [(body, body + 1, 4.0 + body) for body in range(1, 7)]
    dampers = [(body, body + 1, 0.125) for body in range(1, 7)]
    system = bodies([1.0, 1.5, 2.0, 1.0, 1.5, 2.0, 1.0], springs, dampers)
    start = ([0.5, 2.0, -2.0, 0.0, -1.0, -0.5, 0.0], [-1.5, -0.75, 0.75, 0.75, 0.25, -1.0, 0.5])
    return moving("A free chain", system, spaced(0.1, end), start, step([0.5, 0, 0, 0, 0, 0, 0]))


def unstable_growth(end: float) -> Problem:
    """Three bodies, one on a negative spring: it grows like e^(3.12 t)."""
    springs = [(0, 1, 4.0), (1, 2, 3.0), (2, 3, 2.0), (0, 3, -12.0)]
    dampers = [(0, 1, 0.5), (2, 3, 0.25)]
    system = bodies([1.0, 1.0, 1.0], springs, dampers)
    return moving("Growth", system, np.linspace(1.0, end, 10), ([1.0, -1.0, 0.5], [0.0, 0.0, 1.0]))


def first_moments(end: float) -> Problem:
    """The last of three masses in a row, from rest, while a ramp pulls at the first: (s^6 + 5 s^4 + 6 s^2 + 1) x = 1 / s^2."""
    coefficients = [[[value]] for value in (1.0, 0.0, 6.0, 0.0, 5.0, 0.0, 1.0)]
    return equations("First moments", coefficients, np.zeros((6, 1)), spaced(end / 10, end), ramp([1.0]))


SYSTEMS = (
    System(
        "long_horizon",
        "Undamped, to a million periods",
        "An error of eps in a frequency is an error of eps w t in the phase: with the horizon all lose digits, and should say so.",
        "referee case long_1e6",
        Varied("end", "s", (*decades(1, 6), 5e6, 1e8, 1e10)),
        long_horizon,
        {"finite_zeros": 4, "undamped": True, "symmetric": True, "longest_chain": 1},
    ),
    System(
        "free_chain",
        "A chain that nothing holds, pushed",
        "A double zero at 0 with one chain: x grows like t^2, and a zero at 1e-9 instead would oscillate.",
        "referee case rigid7",
        Varied("end", "s", decades(0, 8)),
        free_chain,
        {"finite_zeros": 14, "zeros_at_0": 2, "longest_chain": 2, "symmetric": True, "growing_zeros": 0},
    ),
    System(
        "unstable_growth",
        "Growth up to e^300 and beyond the range of float64",
        "What grows hides all else; beyond 1e308 there is no answer, which is to be said.",
        "referee case unstable300",
        Varied("end", "s", (2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 250.0)),
        unstable_growth,
        {"finite_zeros": 6, "growing_zeros": 1, "symmetric": True},
    ),
    System(
        "first_moments",
        "The first moments after rest",
        "Sums over modes cancel to t^7: at t = 1e-4 all 16 digits of each term, and 12 more.",
        "made for this gallery: the closed form of Hauksdottir and Sigurdsson, section 5, at small t",
        Varied("end", "s", decades(1, -10)),
        first_moments,
        {"finite_zeros": 6, "undamped": True, "jumps": False, "impulses": 0},
    ),
)
