"""Motions against the values of the two examples of Moysis et al., and what holds for any motion."""

import json
import pathlib

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.mechanics.constraints import Constraint
from mbconstrained.mechanics.system import MechanicalSystem
from tests.mechanics.systems import massless_joints, two_masses
from tests.oracles.models import close, table

START = [0.8, 1.2, 2.0]


@pytest.mark.parametrize("level, value", [("acceleration", 0.0), ("velocity", 0.0), ("position", -0.4)])
def test_two_masses(level, value):
    motion = two_masses(level, value=value).solve(START)
    times, x1, q1, q2, *rates = (table("ex51", name) for name in ("t", "x1bar", "q1", "q2bar", "x1bar_dot", "q2bar_dot"))
    assert close(motion(times), [x1, q1, q2])
    assert close(motion.velocity(times)[[0, 2]], rates)
    # the row of the distance q2 alone reads M x'' + K x = lambda A: lambda = k q2, the force of the second spring
    assert close(motion.reaction(times)[0], 2.0 * q2)
    assert not motion.jump.any() and not motion.impulses and not motion.constraint_impulses


def test_acceleration_level_drifts_with_an_error_of_the_velocity():
    times = np.array([0.0, 1.0, 20.0, 50.0])
    motion = two_masses("acceleration").solve(START, [0, 0.1, 0])
    consistent = two_masses("acceleration").solve(START)(times)
    assert close(motion(times), consistent + np.outer([0, 1, 0], 0.1 * times))


def test_position_level_without_its_offset_jumps():
    # the row asks for q1 = x1, but q1 - x1 = 0.4 was given: q1 and q2 jump, the masses x1 and q1 + q2 stay
    motion = two_masses("position").solve(START)
    assert np.allclose(motion.start, [[0.8, 0.8, 2.4], [0, 0, 0]], atol=1e-14)
    assert not motion.impulses and not motion.constraint_impulses


def test_position_level_with_a_wrong_velocity_jumps():
    motion = two_masses("position", value=-0.4).solve(START, [0, 0.1, 0])
    assert np.allclose(motion.start, [START, [0, 0, 0.1]], atol=1e-14)
    assert not motion.constraint_impulses


def test_massless_joints():
    motion = massless_joints().solve([2 / 3, 1, 2])
    times, *values, rate = (table("ex52", name) for name in ("t", "u1", "u2", "u3", "u3_dot"))
    assert close(motion(times), values)
    assert close(motion.velocity(times)[2], rate)
    assert not motion.jump.any() and not motion.impulses
    assert motion.reaction(times).shape == (0, 8) and motion.reaction(1.0).shape == (0,)


@given(*[st.integers(1, 50)] * 3, st.lists(st.integers(-9, 9), min_size=6, max_size=6))
def test_jump_projector_of_the_massless_joints(m, k2, c2, values):
    # balance of the joints: u1 = u3/3 from the springs, u2' = u3'/3 from the dampers, hence u1' too; the mass does not jump
    (_, u2, u3), (_, _, v3) = start = np.array(values, float).reshape(2, 3)
    found = massless_joints(m, k2, c2).solve(*start).start
    assert np.allclose(found, [[u3 / 3, u2, u3], [v3 / 3, v3 / 3, v3]], atol=1e-12)


@st.composite
def tied_networks(draw):
    """Masses joined by springs, dampers and position rows that hold at the start, and one constant force."""
    n = draw(st.integers(2, 5))
    whole = st.integers(0, 4)
    mass = np.diag([draw(st.integers(1, 9)) for _ in range(n)])
    ends = st.lists(st.integers(-1, 1), min_size=n, max_size=n)
    springs, dampers = (np.array(draw(st.lists(ends, max_size=n)), float).reshape(-1, n) for _ in range(2))
    rows = np.array(draw(st.lists(ends, max_size=n - 1)), float).reshape(-1, n)
    start = np.array([[draw(whole) for _ in range(n)] for _ in range(2)], float)
    start[1] -= np.linalg.pinv(rows) @ rows @ start[1]
    force = np.array([draw(whole) for _ in range(n)], float)
    level = draw(st.sampled_from(["position", "velocity", "acceleration"]))
    value = {"position": rows @ start[0], "velocity": 0.0, "acceleration": 0.0}[level]
    row = [Constraint(rows, level=level, value=value)] if len(rows) else []
    return MechanicalSystem(mass, dampers.T @ dampers, 3 * springs.T @ springs, row), start, force


@given(tied_networks())
def test_equations_rows_and_explicit_acceleration_hold_at_all_times(case):
    system, start, force = case
    motion = system.solve(*start, force=force)
    times = np.array([0.0, 0.3, 1.0, 2.5])
    x, v, a = motion(times), motion.velocity(times), motion.acceleration(times)
    size = 1e-9 * (1 + np.abs(x).max() + np.abs(v).max() + np.abs(a).max())
    A = system.constraint_matrix
    assert np.allclose(A @ x, (A @ start[0])[:, None], atol=size)
    assert np.allclose(A @ a, 0, atol=size)
    residual = system.mass @ a + system.damping @ v + system.stiffness @ x - force[:, None]
    assert np.allclose(residual, A.T @ motion.reaction(times), atol=50 * size)
    for i in range(len(times)):
        assert np.allclose(system.acceleration(x[:, i], v[:, i], force), a[:, i], atol=10 * size)
        assert np.allclose(system.constraint_force(x[:, i], v[:, i], force), residual[:, i], atol=50 * size)


@given(tied_networks(), st.floats(0.1, 3.0))
def test_a_motion_can_be_taken_up_at_any_time(case, pause):
    system, start, force = case
    whole = system.solve(*start, force=force)
    rest = system.solve(whole(pause), whole.velocity(pause), force=force)
    expected = whole(pause + 1.0)
    assert np.allclose(rest(1.0), expected, atol=1e-9 * (1 + np.abs(expected).max()))


def test_rounding_in_place_of_zeros_does_not_choose_the_units():
    """A free-floating body with a linkage: its computed mass matrix has 1e-16 where the exact one has 0."""
    path = pathlib.Path(__file__).parents[1] / "oracles" / "rounding_for_zeros.json"
    M, C, K, J, push = (np.array(matrix) for matrix in json.loads(path.read_text()).values())
    N = scipy.linalg.null_space(J)
    jump = N @ np.linalg.solve(N.T @ M @ N, N.T @ push)
    motion = mb.MechanicalSystem(M, C, K, constraints=[mb.Constraint(J)]).solve(force=mb.impulse(push))
    assert motion.jump[1] == pytest.approx(jump, rel=1e-9, abs=1e-13 * np.abs(jump).max())
    assert motion.velocity(1e-6) == pytest.approx(jump, rel=1e-4, abs=1e-5)
