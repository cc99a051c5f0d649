"""Moysis et al., section 5.2: a mass on springs and dampers in series, joined by massless joints.

The trajectories are those of moysis.json; structure, H_i and the jump projector were worked out in rational arithmetic.
"""

from __future__ import annotations

import numpy as np

import mbconstrained as mb
from tests.oracles.models import close, massless_joints, table

TIMES = table("ex52", "t")
A = mb.PolynomialMatrix(massless_joints(), coordinates=["u1", "u2", "u3"])
CONSISTENT = np.array([[2 / 3, 1.0, 2.0], [0.0, 0.0, 0.0]])


def test_trajectory_is_the_table():
    assert close(mb.solve(A, CONSISTENT)(TIMES), [table("ex52", name) for name in ("u1", "u2", "u3")])


def test_velocities_are_the_table():
    """u1' = u2' = u3'/3."""
    fast = table("ex52", "u3_dot")
    assert close(mb.solve(A, CONSISTENT).derivative()(TIMES), [fast / 3, fast / 3, fast])


def test_consistent_start_is_continuous():
    x = mb.solve(A, CONSISTENT)
    assert not x.jump.any()
    assert x.impulses == ()
    assert x.notices == ()


def test_structure_has_no_infinite_zeros_but_an_infinite_pair():
    """det = 1080 s^3 + 288 s^2 + 216 s; Smith at infinity diag(s^2, s, 1): mu = 1, the printed count of Eq. (23) is 0."""
    structure = A.structure()
    assert structure.at_infinity == (2, 1, 0)
    assert structure.infinite_divisors == (0, 1, 2)
    assert structure.finite_count == 3
    assert structure.highest_impulse == 0
    assert structure.infinite_chains == (1,)
    origin, pair = structure.finite_zeros
    assert (origin.value, origin.multiplicity) == (0, 1)
    assert abs(pair.value - complex(-2 / 15, 41**0.5 / 15)) < 1e-15
    assert pair.multiplicity == 1


def test_laurent_coefficients():
    pairs = A.jordan_pairs()
    assert close(pairs.laurent(0), np.diag([1 / 9, 0, 0]), 1e-14)
    assert close(pairs.laurent(-1), np.diag([0, 1 / 12, 0]), 1e-14)
    assert close(pairs.laurent(-2), np.array([[1, 1, 3], [1, 1, 3], [3, 3, 9]]) / 90, 1e-14)
    assert not pairs.laurent(1).any()


def test_infinite_pair_is_minimal_of_size_one():
    """C_inf = (1/9, 0, 0)^T, J_inf = (0), B_inf = (1, 0, 0), up to a factor between C and B."""
    pair = A.jordan_pairs().infinite
    assert pair.J.tolist() == [[0.0]]
    assert close(pair.C @ pair.B, np.diag([1 / 9, 0, 0]), 1e-14)


def test_inconsistent_values_jump_without_an_impulse():
    """(1, 1, 2; 0, 1, 0) -> (2/3, 1, 2; 0, 0, 0)."""
    x = mb.solve(A, [[1.0, 1.0, 2.0], [0.0, 1.0, 0.0]])
    assert close(x.start, CONSISTENT, 1e-15)
    assert x.impulses == ()
    assert {notice.text.split(":")[0] for notice in x.notices} == {"u1", "u2"}
    assert close(x(TIMES), mb.solve(A, CONSISTENT)(TIMES))


def test_projector_on_consistent_values():
    """u1 -> u3/3, u2 -> u2, u3 -> u3, u1' and u2' -> u3'/3, u3' -> u3'."""
    P = np.zeros((6, 6))
    P[0, 2] = P[3, 5] = P[4, 5] = 1 / 3
    P[1, 1] = P[2, 2] = P[5, 5] = 1
    for column in range(6):
        start = mb.solve(A, np.eye(6)[column].reshape(2, 3)).start
        assert np.abs(start.ravel() - P[:, column]).max() <= 1e-15


def test_unit_step_on_every_coordinate():
    """f = (1, 1, 1): stack(0+) = (7/9, 1, 2; 0, 1/12, 0); the printed condition (64) misses the 1/12."""
    x = mb.solve(A, CONSISTENT, mb.step([1.0, 1.0, 1.0]))
    assert close(x.start, [[7 / 9, 1, 2], [0, 1 / 12, 0]], 1e-15)
    assert close(x(0.0), [7 / 9, 1, 2])
    assert close(x.derivative()(0.0), [0, 1 / 12, 0])
    assert x.impulses == ()
