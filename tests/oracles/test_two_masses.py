"""Moysis et al., section 5.1: two masses with a redundant coordinate, the constraint kept at each of three levels.

The trajectories are those of moysis.json; H_i, Smith forms and jumps were worked out in rational arithmetic.
"""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb
from tests.oracles.models import close, table, two_masses, two_masses_with_multiplier

TIMES = table("ex51", "t")
OFFSET = mb.step([0.0, 0.0, -0.4])  # x1 - q1 = -2/5, what the row asks for at position level
START = np.array([[0.8, 1.2, 2.0], [0.0, 0.0, 0.0]])
NO_FORCE = mb.zero(3)

#: level -> (force, at infinity q_i, number of finite zeros)
LEVELS = {0: (OFFSET, (2, 2, 0), 4), 1: (NO_FORCE, (2, 2, 1), 5), 2: (NO_FORCE, (2, 2, 2), 6)}
FAST, SLOW = (5 + 5**0.5) / 10, (5 - 5**0.5) / 10  # the two angular frequencies, s^4 + 3/5 s^2 + 1/25 = 0

levels = pytest.mark.parametrize("level", LEVELS)


def matrix(level: int) -> mb.PolynomialMatrix:
    return mb.PolynomialMatrix(two_masses(level), coordinates=["x1", "q1", "q2"])


def motion(level: int, start=START) -> mb.Response:
    return mb.solve(matrix(level), start, LEVELS[level][0])


@levels
def test_trajectory_is_the_table_at_every_level(level):
    known = [table("ex51", name) for name in ("x1bar", "q1", "q2bar")]
    assert close(motion(level)(TIMES), known)


@levels
def test_velocities_are_the_table_at_every_level(level):
    known = [table("ex51", name) for name in ("x1bar_dot", "x1bar_dot", "q2bar_dot")]
    assert close(motion(level).derivative()(TIMES), known)


@levels
def test_accelerations_satisfy_the_equations_of_motion(level):
    """Eq. (83): x1'' = k (q2 - x1)/m, q1'' = x1'', q2'' = -k (2 q2 - x1)/m."""
    x = motion(level)
    x1, _, q2 = x(TIMES)
    known = [0.2 * (q2 - x1), 0.2 * (q2 - x1), -0.2 * (2 * q2 - x1)]
    assert close(x.derivative(2)(TIMES), known)


@levels
def test_consistent_start_neither_jumps_nor_gets_impulses(level):
    x = motion(level)
    assert not x.jump.any()
    assert x.impulses == ()
    assert not [notice for notice in x.notices if notice.kind in ("jump", "impulse")]


@levels
def test_structure_at_each_level(level):
    _, at_infinity, count = LEVELS[level]
    structure = matrix(level).structure()
    assert structure.at_infinity == at_infinity
    assert structure.infinite_divisors == tuple(2 - q for q in at_infinity)
    assert structure.finite_count == count
    drift = count - 4  # a row at velocity or acceleration level adds zeros at 0
    zeros = {round(abs(zero.value), 12): zero.multiplicity for zero in structure.finite_zeros}
    assert zeros == {**({0.0: drift} if drift else {}), round(SLOW, 12): 1, round(FAST, 12): 1}


@pytest.mark.parametrize("level, at_infinity", [(0, (2, 2, 0, 0)), (1, (2, 2, 1, 0)), (2, (2, 2, 2, 0))])
def test_multiplier_form_has_no_infinite_zeros_because_the_mass_matrix_is_singular(level, at_infinity):
    assert mb.PolynomialMatrix(two_masses_with_multiplier(level)).structure().at_infinity == at_infinity


def test_multiplier_is_the_force_that_keeps_the_row():
    """Row 1 of M x'' + K x = row^T lambda: lambda = m x1'' + k x1."""
    start = np.column_stack([START, [0.0, 0.0]])
    x = mb.solve(mb.PolynomialMatrix(two_masses_with_multiplier(2)), start)
    times = TIMES[1:]
    x1, _, _, multiplier = x(times)
    assert close(multiplier, 10 * x.derivative(2)(times)[0] + 2 * x1)
    assert close(x1, table("ex51", "x1bar")[1:])


def test_laurent_coefficients_at_acceleration_level():
    """H_{-2} = Mbar^{-1}, H_{-4} = Mbar^{-1} Kbar Mbar^{-1} (A_0 = -Kbar)."""
    pairs = matrix(2).jordan_pairs()
    known = {
        -2: [[-1 / 10, 1 / 10, 0], [-1 / 10, 1 / 10, -1], [1 / 5, -1 / 10, 1]],
        -4: [[3 / 50, -1 / 25, 1 / 5], [3 / 50, -1 / 25, 1 / 5], [-1 / 10, 3 / 50, -2 / 5]],
    }
    for index, H in known.items():
        assert close(pairs.laurent(index), H, 1e-14)
    for index in (0, -1, -3):
        assert np.abs(pairs.laurent(index)).max() < 1e-15
    assert pairs.infinite.J.shape == (0, 0)


def test_laurent_coefficients_at_position_level():
    pairs = matrix(0).jordan_pairs()
    assert close(pairs.laurent(0), [[0, 0, 0], [0, 0, -1], [0, 0, 1]], 1e-14)
    assert close(pairs.laurent(-2), [[-1 / 10, 1 / 10, 1 / 5], [-1 / 10, 1 / 10, 1 / 5], [1 / 5, -1 / 10, -2 / 5]], 1e-14)
    assert not pairs.laurent(-1).any()
    assert pairs.infinite.J.shape == (1, 1)  # mu = 1 from one q_i = 0


def test_forgotten_offset_makes_the_coordinates_jump():
    """Position level with f = 0 asks for x1 = q1: stack(0+) = (4/5, 4/5, 12/5, 0, 0, 0)."""
    x = mb.solve(matrix(0), START)
    assert close(x.start, [[0.8, 0.8, 2.4], [0, 0, 0]], 1e-14)
    assert close(x(0.0), [0.8, 0.8, 2.4])
    assert x.impulses == ()
    named = [notice.text for notice in x.notices if notice.kind == "jump"]
    assert len(named) == 2
    assert named[0].startswith("q1: its value jumps") and named[1].startswith("q2: its value jumps")


def test_velocity_that_violates_the_row_jumps_at_position_level():
    """q1'(0-) = 1/10: the velocities jump to (0, 0, 1/10)."""
    x = motion(0, start=[START[0], [0.0, 0.1, 0.0]])
    assert close(x.start, [[0.8, 1.2, 2.0], [0.0, 0.0, 0.1]], 1e-14)
    assert not x.jump[0].any()


def test_velocity_error_drifts_linearly_at_acceleration_level():
    """q1'(0-) = 1/10: q1 - x1 = 0.4 + 0.1 t, and x1, q2 move as in the table."""
    x = motion(2, start=[START[0], [0.0, 0.1, 0.0]])
    x1, q1, q2 = x(TIMES)
    assert close(q1 - x1, 0.4 + 0.1 * TIMES)
    assert close(x1, table("ex51", "x1bar"))
    assert close(q2, table("ex51", "q2bar"))


def test_projector_on_consistent_values_at_position_level():
    """stack(0+) = P stack(0-) with P = diag(N, N), N = [[1,0,0],[1,0,0],[-1,1,1]]."""
    N = np.array([[1, 0, 0], [1, 0, 0], [-1, 1, 1]])
    for column in range(6):
        start = np.eye(6)[column].reshape(2, 3)
        assert close(mb.solve(matrix(0), start).start, start @ N.T, 1e-14)
