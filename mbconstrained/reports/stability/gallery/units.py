"""The same problems in other units, and rows and columns in units of their own: nothing may change."""

from __future__ import annotations

import numpy as np

from ....signals import harmonic
from ...problem import Problem
from .building import equations, spaced
from .system import System, Varied, decades

#: log2 of the units of length and force for log2 of the unit of time: from micrometres to megametres.
UNITS = {-20: (-20, -30), -10: (-10, -15), 0: (0, 0), 6: (5, 20), 12: (10, 40)}

#: Powers of two, of rows and of columns, that are made larger and larger.
ROWS, COLUMNS = np.array([1.0, -1.0, 0.5]), np.array([-0.5, 1.0, -1.0])


def unit_of_force(unit: float) -> Problem:
    """Three bodies, forces in a decimal unit: all entries are rounded anew."""
    stiffness = [[3001000.0, -3000000.0, 0.0], [-3000000.0, 3020000.0, -20000.0], [0.0, -20000.0, 20000.0]]
    damping = [[11.0, -10.0, 0.0], [-10.0, 12.0, -2.0], [0.0, -2.0, 2.0]]
    coefficients = [unit * np.array(matrix) for matrix in (stiffness, damping, np.diag([1.0, 0.4, 2.0]))]
    return equations("Another unit of force", coefficients, [[1.75, 0.0, 0.75], [-0.25, 2.0, -0.75]], spaced(1e-4, 30.0))


def small_to_huge(time: float) -> Problem:
    """Two coupled equations with one chain of length 4, from MEMS to giga units, in powers of two."""
    length, force = (2.0**power for power in UNITS[round(np.log2(time))])
    base = [[[5, 6], [-1, -1]], [[-2, -4], [4, 6]], [[-1, -2], [2, 3]]]
    coefficients = [force / length * time**power * np.array(matrix) for power, matrix in enumerate(base)]
    start = length * np.array([[1.0, 2.0], [-1.0 / time, 0.5 / time]])
    acting = harmonic([force, -force], angular_frequency=1 / time)
    return equations("From MEMS to giga units", coefficients, start, time * spaced(0.02, 20.0), acting)


def unit_of_time(time: float) -> Problem:
    """An infinite zero of order 2 in another unit of time, a power of two."""
    base = [[[0, 5, -5], [-2, -3, 5], [3, 3, -5]], [[0, 2, -2], [0, -2, 2], [0, 2, -2]], [[0, 1, -1], [0, -1, 1], [-1, 2, -1]]]
    coefficients = [time**power * np.array(matrix, dtype=float) for power, matrix in enumerate(base)]
    start = np.array([[1.5, -0.5, -1.5], [-2.0, -0.5, -0.25]]) / np.array([[1.0], [time]])
    return equations("Another unit of time", coefficients, start, time * spaced(0.05, 12.0))


def scattered_scales(power: float) -> Problem:
    """Three oscillating bodies, each row and each column in a unit of its own, up to 2^power and 2^-power."""
    rows, columns = 2.0 ** np.round(power * ROWS), 2.0 ** np.round(power * COLUMNS)
    base = [[[5, -2, 0], [-2, 4, -1], [0, -1, 3]], np.diag([0.5, 0.0, 0.25]), np.diag([1, 2, 1])]
    coefficients = [rows[:, None] * np.array(matrix, dtype=float) * columns for matrix in base]
    start = np.array([[1.0, -1.0, 0.5], [0.0, 2.0, 0.0]]) / columns
    acting = harmonic(rows * [1.0, 0.0, -1.0], angular_frequency=1.5)
    return equations("Rows and columns in units of their own", coefficients, start, spaced(0.05, 40.0), acting)


SYSTEMS = (
    System(
        "unit_of_force",
        "Three bodies, forces in powers of ten",
        "A threshold that is not relative to the data works in one unit and fails in another.",
        "referee case huge_units",
        Varied("unit of force", "N", decades(-12, 12, 3)),
        unit_of_force,
        {"finite_zeros": 6, "infinite_divisors": (), "growing_zeros": 0, "decades": 2},
    ),
    System(
        "small_to_huge",
        "A chain of length 4 from MEMS to giga units",
        "Powers of two change no digit of the data: no digit of the answer may change either, nor may its structure.",
        "referee cases mems_jordan4_qep and giga_jordan4_qep",
        Varied("unit of time", "s", tuple(2.0**power for power in UNITS)),
        small_to_huge,
        {"finite_zeros": 4, "longest_chain": 4, "infinite_divisors": (), "growing_zeros": 0},
    ),
    System(
        "unit_of_time",
        "An infinite zero of order 2 in any unit of time",
        "An impulse has the unit of x times time, its derivative times time squared: which of them is zero may not depend on units.",
        "referee case inf_order2",
        Varied("unit of time", "s", tuple(2.0**power for power in range(-40, 41, 10))),
        unit_of_time,
        {"finite_zeros": 2, "infinite_order": 2, "infinite_divisors": (4,), "impulses": 2, "jumps": True},
    ),
    System(
        "scattered_scales",
        "Rows and columns scaled by 2^k and 2^-k",
        "Nothing but units has changed, yet entries of one matrix differ by 2^(4 k).",
        "made for this gallery, as the referee cases of the family scattered",
        Varied("power of two", "", (0.0, 2.0, 4.0, 8.0, 12.0, 16.0, 20.0)),
        scattered_scales,
        {"finite_zeros": 6, "infinite_divisors": (), "growing_zeros": 0, "longest_chain": 1},
    ),
)
