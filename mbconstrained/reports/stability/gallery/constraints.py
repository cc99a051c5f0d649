"""Constraint rows that turn parallel or say things twice, starts that do not fit, drift."""

from __future__ import annotations

import numpy as np

from ....mechanics import Constraint, MechanicalSystem
from ...problem import Problem
from .building import bodies, equations, moving, spaced
from .system import System, Varied, decades

#: Two directions at right angles in the space of three coordinates, along no axis, and rounded.
ONE, OTHER = np.array([2.0, -1.0, 2.0]) / 3, np.array([2.0, 2.0, -1.0]) / 3


def _parallel_rows(angle: float, level: str) -> Problem:
    rows = [ONE, np.cos(angle) * ONE + np.sin(angle) * OTHER]
    held = [Constraint(row, level=level, names=f"row {number}") for number, row in enumerate(rows, start=1)]
    system = MechanicalSystem(np.diag([1.0, 2.0, 3.0]), stiffness=np.diag([4.0, 5.0, 7.0]), constraints=held)
    return moving("Two rows at an angle", system, spaced(0.1, 20.0), ([1.0, -0.5, 2.0], [0.0, 1.0, 0.0]))


def parallel_rows_position(angle: float) -> Problem:
    """Two rows at this angle, held at position level."""
    return _parallel_rows(angle, "position")


def parallel_rows_acceleration(angle: float) -> Problem:
    """Two rows at this angle, held at acceleration level."""
    return _parallel_rows(angle, "acceleration")


def redundant_rows(factor: float) -> Problem:
    """Three bodies tied to each other, a fourth on a spring; the third tie is a rounded sum of the other two, in other units."""
    ties = [[1.0, -1.0, 0.0, 0.0], [0.0, 1.0, -1.0, 0.0]]
    third = factor * (0.3 * np.array(ties[0]) + 0.7 * np.array(ties[1]))
    held = [Constraint(row, names=f"tie {number}") for number, row in enumerate([*ties, third], start=1)]
    system = bodies([1.0, 2.0, 3.0, 4.0], [(0, 1, 1.0), (3, 4, 2.0)], [(0, 4, 0.5)], held)
    return moving("A row that says nothing new", system, spaced(0.1, 30.0), ([1.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]))


def two_masses(stiffness: float) -> Problem:
    """Moysis et al., section 5.1, with its data at 2 N/m."""
    system = MechanicalSystem(
        [[10.0, 0.0, 0.0], [0.0, 10.0, 10.0], [0.0, 10.0, 10.0]],
        stiffness=np.diag([stiffness, 0.0, stiffness]),
        constraints=[Constraint([1.0, -1.0, 0.0], level="acceleration")],
        names=["x1", "q1", "q2"],
    )
    return moving("Two masses with a redundant coordinate", system, spaced(0.1, 50.0), ([0.8, 1.2, 2.0], [0.0, 0.0, 0.0]))


def inconsistent_start(size: float) -> Problem:
    """The same at position level, from a start that violates the constraint, by 0.4 m and 1 m/s at size 1."""
    coefficients = [[[2, 0, 0], [0, 0, 2], [1, -1, 0]], np.zeros((3, 3)), [[10, 10, 10], [0, 10, 10], [0, 0, 0]]]
    start = [[0.8, 0.8 + (1.2 - 0.8) * size, 2.0], [1.0, 1.0 - size, -0.5]]
    return equations("A start that does not fit", coefficients, start, spaced(0.1, 60.0))


ANGLES = Varied("angle between the rows", "rad", decades(0, -16))

SYSTEMS = (
    System(
        "parallel_rows_position",
        "Two constraint rows turn parallel, position level",
        "What the second row says that the first does not is lost in the rounding of its coefficients, eps / angle of it.",
        "made for this gallery",
        ANGLES,
        parallel_rows_position,
        {"jumps": True, "redundant_rows": lambda angle: int(angle < 1e-14)},
    ),
    System(
        "parallel_rows_acceleration",
        "Two constraint rows turn parallel, acceleration level",
        "The same, and each row leaves a double zero at 0 along which rounding drifts.",
        "made for this gallery",
        ANGLES,
        parallel_rows_acceleration,
        {"jumps": False, "impulses": 0, "finite_zeros": 6, "redundant_rows": lambda angle: int(angle < 1e-14)},
    ),
    System(
        "redundant_rows",
        "A loop of ties, one of which says nothing new but for rounding, in other units",
        "Taken literally the third row forbids the motion: its coefficients 0.3 f, 0.4 f, -0.7 f do not quite cancel.",
        "made for this gallery",
        Varied("scale of the third row", "", decades(-8, 8, 2)),
        redundant_rows,
        {"finite_zeros": 4, "redundant_rows": 1, "jumps": False, "impulses": 0, "growing_zeros": 0},
    ),
    System(
        "two_masses",
        "Two masses with a redundant coordinate, acceleration level",
        "A double zero at 0 with one chain (the drift of the constraint) beside oscillations as slow or fast as one likes.",
        "Moysis et al., section 5.1",
        Varied("stiffness", "N/m", (2e-16, 2e-12, 2e-8, 2e-4, 2.0, 2e4, 2e8, 2e12)),
        two_masses,
        {"finite_zeros": 6, "zeros_at_0": 2, "longest_chain": 2, "undamped": True, "impulses": 0, "jumps": False},
    ),
    System(
        "inconsistent_start",
        "A start that violates a position constraint",
        "A violation near rounding must not become a jump that is not there, nor a large one be smeared.",
        "referee case two_mass_pos_incons (Moysis et al., section 5.1, position level)",
        Varied("size of the violation", "", (0.0, *decades(-14, 6, 2), 1e8)),
        inconsistent_start,
        {"finite_zeros": 4, "undamped": True, "infinite_divisors": (2,), "impulses": 0, "jumps": lambda size: size > 0},
    ),
)
