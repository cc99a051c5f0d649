"""Parallel and redundant constraint rows, inconsistent starts, drift; and the same problems in other units."""

from __future__ import annotations

import numpy as np

from ....mechanics.constraints import Constraint
from ....mechanics.system import MechanicalSystem
from ....signals.inputs import harmonic
from ...study_problem import StudyProblem
from .entry import bodies, decades, declares, equations, family, moving, spaced

#: Two directions at right angles in the space of three coordinates, along no axis, and rounded.
ONE, OTHER = np.array([2.0, -1.0, 2.0]) / 3, np.array([2.0, 2.0, -1.0]) / 3


def _parallel_rows(angle: float, level: str) -> StudyProblem:
    rows = [ONE, np.cos(angle) * ONE + np.sin(angle) * OTHER]
    constraints = [Constraint(row, level=level, names=f"row {number}") for number, row in enumerate(rows, start=1)]
    system = MechanicalSystem(np.diag([1.0, 2.0, 3.0]), stiffness=np.diag([4.0, 5.0, 7.0]), constraints=constraints)
    return moving(system, spaced(0.1, 20.0), ([1.0, -0.5, 2.0], [0.0, 1.0, 0.0]))


@family("constraints", "angle between the rows", decades(0, -16), "rad")
@declares(jumps=True, redundant_rows=lambda angle: int(angle < 1e-14))
def parallel_rows_position(angle: float) -> StudyProblem:
    """Two constraint rows turn parallel, position level.

    The difference of the second row from the first has a relative rounding error of eps / angle.
    """
    return _parallel_rows(angle, "position")


@family("constraints", "angle between the rows", decades(0, -16), "rad")
@declares(jumps=False, impulses=0, finite_zeros=6, redundant_rows=lambda angle: int(angle < 1e-14))
def parallel_rows_acceleration(angle: float) -> StudyProblem:
    """Two constraint rows turn parallel, acceleration level.

    The same, and each row leaves a double zero at 0 along which rounding drifts.
    """
    return _parallel_rows(angle, "acceleration")


@family("constraints", "scale of the third row", decades(-8, 8, 2))
@declares(finite_zeros=4, redundant_rows=1, jumps=False, impulses=0, growing_zeros=0)
def redundant_rows(factor: float) -> StudyProblem:
    """A loop of ties, one of which is redundant within rounding error, in other units.

    Taken literally the third row forbids the motion: its coefficients 0.3 f, 0.4 f, -0.7 f do not quite cancel.
    """
    ties = [[1.0, -1.0, 0.0, 0.0], [0.0, 1.0, -1.0, 0.0]]
    third = factor * (0.3 * np.array(ties[0]) + 0.7 * np.array(ties[1]))
    constraints = [Constraint(row, names=f"tie {number}") for number, row in enumerate([*ties, third], start=1)]
    system = bodies([1.0, 2.0, 3.0, 4.0], [(0, 1, 1.0), (3, 4, 2.0)], [(0, 4, 0.5)], constraints)
    return moving(system, spaced(0.1, 30.0), ([1.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]))


@family("constraints", "stiffness", (2e-16, 2e-12, 2e-8, 2e-4, 2.0, 2e4, 2e8, 2e12), "N/m")
@declares(finite_zeros=6, zeros_at_0=2, longest_chain=2, undamped=True, impulses=0, jumps=False)
def two_masses(stiffness: float) -> StudyProblem:
    """Two masses with a redundant coordinate, acceleration level.

    A double zero at 0 with one chain (the drift of the constraint) with slow or fast oscillations.

    Source: Moysis et al., section 5.1.
    """
    system = MechanicalSystem(
        [[10.0, 0.0, 0.0], [0.0, 10.0, 10.0], [0.0, 10.0, 10.0]],
        stiffness=np.diag([stiffness, 0.0, stiffness]),
        constraints=[Constraint([1.0, -1.0, 0.0], level="acceleration")],
        names=["x1", "q1", "q2"],
    )
    return moving(system, spaced(0.1, 50.0), ([0.8, 1.2, 2.0], [0.0, 0.0, 0.0]))


@family("constraints", "size of the violation", (0.0, *decades(-14, 6, 2), 1e8))
@declares(finite_zeros=4, undamped=True, infinite_divisors=(2,), impulses=0, jumps=lambda size: size > 0)
def inconsistent_start(size: float) -> StudyProblem:
    """A start that violates a position constraint.

    A violation near rounding must not become a jump that is not there, nor a large one be smeared.

    Source: referee case two_mass_pos_incons (Moysis et al., section 5.1, position level).
    """
    coefficients = [[[2, 0, 0], [0, 0, 2], [1, -1, 0]], np.zeros((3, 3)), [[10, 10, 10], [0, 10, 10], [0, 0, 0]]]
    start = [[0.8, 0.8 + (1.2 - 0.8) * size, 2.0], [1.0, 1.0 - size, -0.5]]
    return equations(coefficients, start, spaced(0.1, 60.0))


#: log2 of the units of length and force for log2 of the unit of time: from micrometres to megametres.
UNITS = {-20: (-20, -30), -10: (-10, -15), 0: (0, 0), 6: (5, 20), 12: (10, 40)}

#: Powers of two, of rows and of columns, that are made larger and larger.
ROWS, COLUMNS = np.array([1.0, -1.0, 0.5]), np.array([-0.5, 1.0, -1.0])


@family("units and scale", "unit of force", decades(-12, 12, 3), "N")
@declares(finite_zeros=6, infinite_divisors=(), growing_zeros=0, decades=2)
def unit_of_force(unit: float) -> StudyProblem:
    """Three bodies, forces in powers of ten.

    A threshold that is not relative to the data works in one unit and fails in another.

    Source: referee case huge_units.
    """
    stiffness = [[3001000.0, -3000000.0, 0.0], [-3000000.0, 3020000.0, -20000.0], [0.0, -20000.0, 20000.0]]
    damping = [[11.0, -10.0, 0.0], [-10.0, 12.0, -2.0], [0.0, -2.0, 2.0]]
    coefficients = [unit * np.array(matrix) for matrix in (stiffness, damping, np.diag([1.0, 0.4, 2.0]))]
    return equations(coefficients, [[1.75, 0.0, 0.75], [-0.25, 2.0, -0.75]], spaced(1e-4, 30.0))


@family("units and scale", "unit of time", tuple(2.0**power for power in UNITS), "s")
@declares(finite_zeros=4, longest_chain=4, infinite_divisors=(), growing_zeros=0)
def small_to_huge(time: float) -> StudyProblem:
    """A chain of length 4 from MEMS to giga units.

    Powers of two change no digit of the data: no digit of the answer may change either, nor may its structure.

    Source: referee cases mems_jordan4_qep and giga_jordan4_qep.
    """
    length, force = (2.0**power for power in UNITS[round(np.log2(time))])
    base = [[[5, 6], [-1, -1]], [[-2, -4], [4, 6]], [[-1, -2], [2, 3]]]
    coefficients = [force / length * time**power * np.array(matrix) for power, matrix in enumerate(base)]
    start = length * np.array([[1.0, 2.0], [-1.0 / time, 0.5 / time]])
    acting = harmonic([force, -force], angular_frequency=1 / time)
    return equations(coefficients, start, time * spaced(0.02, 20.0), acting)


@family("units and scale", "unit of time", tuple(2.0**power for power in range(-40, 41, 10)), "s")
@declares(finite_zeros=2, infinite_order=2, infinite_divisors=(4,), impulses=2, jumps=True)
def unit_of_time(time: float) -> StudyProblem:
    """An infinite zero of order 2 in any unit of time.

    An impulse has the unit of x times time, its derivative times time squared: which of them is zero may not depend on units.

    Source: referee case inf_order2.
    """
    base = [[[0, 5, -5], [-2, -3, 5], [3, 3, -5]], [[0, 2, -2], [0, -2, 2], [0, 2, -2]], [[0, 1, -1], [0, -1, 1], [-1, 2, -1]]]
    coefficients = [time**power * np.array(matrix, dtype=float) for power, matrix in enumerate(base)]
    start = np.array([[1.5, -0.5, -1.5], [-2.0, -0.5, -0.25]]) / np.array([[1.0], [time]])
    return equations(coefficients, start, time * spaced(0.05, 12.0))


@family("units and scale", "power of two", (0.0, 2.0, 4.0, 8.0, 12.0, 16.0, 20.0))
@declares(finite_zeros=6, infinite_divisors=(), growing_zeros=0, longest_chain=1)
def scattered_scales(power: float) -> StudyProblem:
    """Rows and columns scaled by 2^k and 2^-k.

    Nothing but units has changed, yet entries of one matrix differ by 2^(4 k).

    Source: made for this gallery, as the referee cases of the family scattered.
    """
    rows, columns = 2.0 ** np.round(power * ROWS), 2.0 ** np.round(power * COLUMNS)
    base = [[[5, -2, 0], [-2, 4, -1], [0, -1, 3]], np.diag([0.5, 0.0, 0.25]), np.diag([1, 2, 1])]
    coefficients = [rows[:, None] * np.array(matrix, dtype=float) * columns for matrix in base]
    start = np.array([[1.0, -1.0, 0.5], [0.0, 2.0, 0.0]]) / columns
    acting = harmonic(rows * [1.0, 0.0, -1.0], angular_frequency=1.5)
    return equations(coefficients, start, spaced(0.05, 40.0), acting)
