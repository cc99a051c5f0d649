"""Through critical damping and far beyond, and gyroscopic forces."""

from __future__ import annotations

import numpy as np

from ....signals import harmonic
from ...problem import Problem
from .building import equations, spaced
from .system import System, Varied, decades


def damping_ratio(ratio: float) -> Problem:
    """x'' + 4 ratio x' + 4 x = 0."""
    return equations("One oscillator", [[[4.0]], [[4.0 * ratio]], [[1.0]]], [[1.0], [-3.0]], spaced(0.01, 12.0))


def near_critical(distance: float) -> Problem:
    """s^2 + 4 (1 + d) s + 4 and s^2 + 4 (1 - d) s + 4, mixed by matrices of whole numbers with determinant 1."""
    one, two = 4.0 * (1 + distance), 4.0 * (1 - distance)
    damping = [[one - two, one], [one - 2 * two, one]]
    return equations(
        "Two oscillators", [[[0, 4], [-4, 4]], damping, [[0, 1], [-1, 1]]], [[1.0, -2.0], [0.5, 3.0]], spaced(0.01, 12.0)
    )


def heavy_damper(damping: float) -> Problem:
    """x'' + c x' + x = 0, from the first moments of the fast zero to long after the slow one."""
    return equations("A heavy damper", [[[1.0]], [[damping]], [[1.0]]], [[1.0], [1.0]], spaced(1 / damping, 5 * damping))


def gyroscope(rate: float) -> Problem:
    """A vibratory gyroscope in SI units: two modes at 60 and 62 krad/s, coupled by the rate at which it turns."""
    mass, coriolis = 1e-9, 2e-9 * rate
    stiffness = np.diag([mass * 60000.0**2, mass * 62000.0**2])
    damping = [[1e-8, -coriolis], [coriolis, 1e-8]]
    force = harmonic([1e-7, 0.0], angular_frequency=60000.0)
    coefficients = [stiffness, damping, mass * np.eye(2)]
    return equations("A vibratory gyroscope", coefficients, [[1e-6, 0.0], [0.0, 1e-3]], spaced(1e-6, 2.0), force)


SYSTEMS = (
    System(
        "damping_ratio",
        "One oscillator from undamped to overdamped",
        "At ratio 1 the two zeros are one with a chain of length 2: formulas that divide by their difference divide by zero.",
        "referee case crit_exact",
        Varied("damping ratio", "", (0.0, 1e-6, 1e-3, 0.5, 1.0, 2.0, 1e2, 1e4, 1e6, 1e8)),
        damping_ratio,
        {"finite_zeros": 2, "longest_chain": lambda ratio: 2 if ratio == 1 else 1, "undamped": lambda ratio: ratio == 0},
    ),
    System(
        "near_critical",
        "Two oscillators at critical damping but for d, mixed",
        "Four zeros lie 2 sqrt(2 d) from -2, in four directions: far enough to be two in float64, and too near to be decoupled.",
        "referee case crit_near_1e9",
        Varied("distance from critical", "", (1e-2, 1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12, 1e-14, 1e-15, 0.0)),
        near_critical,
        {"finite_zeros": 4, "growing_zeros": 0, "longest_chain": lambda distance: 1 if distance else 2},
    ),
    System(
        "heavy_damper",
        "A heavy damper against a soft spring",
        "Zeros at -c and -1/c are c^2 apart; the soft one is what is left of a difference of two numbers near c.",
        "referee case rot_overdamped_1e8, not rotated",
        Varied("damping", "N s/m", (3.0, *decades(1, 10))),
        heavy_damper,
        {"finite_zeros": 2, "longest_chain": 1, "symmetric": True, "decades": lambda c: round(2 * np.log10(c)) if c > 3 else 1},
    ),
    System(
        "gyroscope",
        "A vibratory gyroscope that turns",
        "The damping matrix is not symmetric, and 2 s are 2e4 turns under a force at the first mode.",
        "referee case mems_gyro",
        Varied("rate of turn", "rad/s", decades(-4, 6)),
        gyroscope,
        {"finite_zeros": 4, "symmetric": False, "growing_zeros": 0},
    ),
)
