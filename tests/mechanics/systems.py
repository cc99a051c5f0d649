"""Systems used by several tests of this folder, and the constrained equations in another form."""

import numpy as np

import mbconstrained as mb
from mbconstrained.mechanics.constraints import Constraint
from mbconstrained.mechanics.system import MechanicalSystem


def two_masses(level="acceleration", m=10.0, k=2.0, value=0.0):
    """Moysis et al., section 5.1 (Eqs. 77-78): the second mass by its distance q2 from a redundant coordinate q1."""
    mass = [[m, 0, 0], [0, m, m], [0, m, m]]
    row = Constraint([1, -1, 0], level=level, value=value, names="link")
    return MechanicalSystem(mass, stiffness=np.diag([k, 0, k]), constraints=row, names=["x1", "q1", "q2"])


def massless_joints(m=10.0, k2=3.0, c2=4.0):
    """Section 5.2 (Eq. 91) with k1 = 2 k2, c1 = 2 c2."""
    damping = [[0, 0, 0], [0, 3 * c2, -c2], [0, -c2, c2]]
    stiffness = [[3 * k2, 0, -k2], [0, 0, 0], [-k2, 0, k2]]
    return MechanicalSystem(np.diag([0, 0, m]), damping, stiffness, names=["u1", "u2", "u3"])


def saddle_point(system, start, force):
    """The same motion with the multipliers as unknowns: [[M s^2 + C s + K, -A^T], [A s^level, 0]] [x; lambda] = [f; b].

    No null space, no elimination of multipliers: an independent way to the constraint forces and their impulses.
    """
    A, k, n = system.constraint_matrix, len(system.rows), system.size
    coefficients = [np.zeros((n + k, n + k)) for _ in range(3)]
    for power, matrix in enumerate((system.stiffness, system.damping, system.mass)):
        coefficients[power][:n, :n] = matrix
        for i, row in enumerate(system.rows):
            if row.order == power:
                coefficients[power][n + i, :n] = row.coefficients
    coefficients[0][:n, n:] = -A.T
    embed = np.eye(n + k, n)
    values = np.concatenate([np.zeros(n), [row.value for row in system.rows]])
    right = (system.force + force).mapped(embed) + mb.step(values)
    return mb.solve(mb.PolynomialMatrix(coefficients), initial=np.asarray(start) @ embed.T, force=right)


def assert_same(found, expected):
    """Close and of the same shape: np.allclose alone finds an empty array close to anything."""
    assert np.shape(found) == np.shape(expected)
    assert np.allclose(found, expected)
