"""Examples 5.1 and 5.2 of Moysis et al.: as they are given, and by hand as first-order equations in fractions."""

from fractions import Fraction

import numpy as np

from mbconstrained import Constraint, MechanicalSystem
from tests.benchmarks.speed.reductions import Equations, as_fractions

#: Places at rest, m.
STARTS = {"5.1": (0.8, 1.2, 2.0), "5.2": (float(Fraction(2, 3)), 1.0, 2.0)}


def example_system(name: str) -> MechanicalSystem:
    """Two masses held at acceleration level (5.1); massless joints between springs and dampers (5.2)."""
    if name == "5.1":
        return MechanicalSystem(
            mass=[[10, 0, 0], [0, 10, 10], [0, 10, 10]],
            stiffness=np.diag([2.0, 0.0, 2.0]),
            constraints=[Constraint([1, -1, 0], level="acceleration")],
        )
    return MechanicalSystem(
        mass=np.diag([0.0, 0.0, 10.0]), damping=[[0, 0, 0], [0, 12, -4], [0, -4, 4]], stiffness=[[9, 0, -3], [0, 0, 0], [-3, 0, 3]]
    )


def example_equations(name: str) -> Equations:
    """5.1: six states, x'' from 10 x1'' + 10 q1'' + 10 q2'' = -2 x1, 10 q1'' + 10 q2'' = -2 q2, x1'' = q1''.

    5.2: 9 u1 = 3 u3, 12 u2' = 4 u3', 10 u3'' = 3 u1 - 3 u3 + 4 u2' - 4 u3'; three states.
    """
    start = as_fractions(STARTS[name])
    if name == "5.1":
        acceleration = as_fractions([[-1, 0, 1], [-1, 0, 1], [1, 0, -2]]) / 5
        S = as_fractions(np.zeros((6, 6)))
        S[:3, 3:], S[3:, :3] = as_fractions(np.eye(3)), acceleration
        return Equations(S, as_fractions(np.eye(3, 6)), np.concatenate([start, start * 0]), S[0] * 0)
    S = as_fractions(np.zeros((3, 3)))
    S[0, 2], S[1, 2], S[2, 1], S[2, 2] = Fraction(1, 3), Fraction(1), Fraction(-1, 5), Fraction(-4, 15)
    E = as_fractions([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    E[0, 1] = Fraction(1, 3)
    return Equations(S, E, np.array([start[1], start[2], start[0] * 0]), S[0] * 0)
