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

# Section 5.1 with m = 10, k = 2, x(0) = (0.8, 1.2, 2), at rest: t, x1, q1, q2, x1', q2'. From the closed form
# x1 = c_a phi^2 cos w_a t + c_b phi^-2 cos w_b t (w_a, w_b = (5 +- sqrt 5)/10) and from a 60-digit matrix exponential.
TWO_MASSES = np.array("""
0    0.8 1.2 2.0 0.0 0.0
0.5  0.82954374510880989736807025 1.2295437451088098973680702 1.9207882718138686328184324 0.11635825510275700160218488 -0.31370737324639116093942327
1    0.91279875330444957214782638 1.3127987533044495721478264 1.6924509088650784254315416 0.21145670759006875322642102 -0.59062386363696409454048185
2    1.170886343657463554974266   1.570886343657463554974266  0.90923710548940196469282846 0.26968595154057381037952956 -0.91445885635993525301468031
5    0.87488327242276163606479125 1.2748832724227616360647913 -0.79719351152473922141469149 -0.62342093021359114180532668 0.11434461301236856262882724
10   -1.7595621693078020193897349 -1.3595621693078020193897349 -0.21523689709457451535918327 0.246963626650329977400172 -0.7353607777535082044602335
20   1.2939919765973919898460743  1.6939919765973919898460743 0.30478915889112180232759945 0.73928862824477588577760759 -0.57198653389816895094754243
50   0.42495383113354081890954406 0.82495383113354081890954406 0.34092706255110139776015372 -0.87341414444106984941057467 0.54816911653854423170893412
""".split(), float).reshape(-1, 6).T  # fmt: skip

# Section 5.2 with m = 10, k2 = 3, c2 = 4, u(0) = (2/3, 1, 2), at rest: t, u1, u2, u3, u3'. From the closed form
# u3 = e^(-a t) (2 cos b t + (2 a/b) sin b t), a = 2/15, b = sqrt(41)/15, u1 = u3/3, u2 = u3/3 + 1/3, in 30 digits.
MASSLESS_JOINTS = np.array("""
0    0.66666666666666666666666667 1.0 2.0 0.0
0.5  0.65078244534269315923097747 0.9841157786760264925643108 1.9523473360280794776929324 -0.18568404459408274716200388
1    0.60654454973530868858992481 0.93987788306864202192325815 1.8196336492059260657697744 -0.33953404019496502358656277
2    0.45577496584448242944061276 0.7891082991778157627739461 1.3673248975334472883218383 -0.54097198828885170354039172
5    -0.092473951120438354542050331 0.240859382212894978791283 -0.27742185336131506362615099 -0.40669202003783540523117721
10   -0.12500485184830809595841831 0.20832848148502523737491502 -0.37501455554492428787525493 0.22309085338779012450005983
20   -0.018035287909317539733241273 0.31529804542401579360009206 -0.054105863727952619199723818 -0.050482631319165001406762125
50   -0.00051692035227767701027472471 0.33281641298105565632305861 -0.0015507610568330310308241741 -0.00071922242430432551641448481
""".split(), float).reshape(-1, 5).T  # fmt: skip

START = [0.8, 1.2, 2.0]


def close(found, expected):
    """Relative to the largest value, as an error of a trajectory is."""
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("level, value", [("acceleration", 0.0), ("velocity", 0.0), ("position", -0.4)])
def test_two_masses(level, value):
    motion = two_masses(level, value=value).solve(START)
    times = TWO_MASSES[0]
    close(motion(times), TWO_MASSES[1:4])
    close(motion.velocity(times)[[0, 2]], TWO_MASSES[4:])
    # the row of the distance q2 alone reads M x'' + K x = lambda A: lambda = k q2, the force of the second spring
    close(motion.reaction(times)[0], 2.0 * TWO_MASSES[3])
    assert not motion.jump.any() and not motion.impulses and not motion.constraint_impulses


def test_acceleration_level_drifts_with_an_error_of_the_velocity():
    times = np.array([0.0, 1.0, 20.0, 50.0])
    motion = two_masses("acceleration").solve(START, [0, 0.1, 0])
    consistent = two_masses("acceleration").solve(START)(times)
    close(motion(times), consistent + np.outer([0, 1, 0], 0.1 * times))


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
    times = MASSLESS_JOINTS[0]
    close(motion(times), MASSLESS_JOINTS[1:4])
    close(motion.velocity(times)[2], MASSLESS_JOINTS[4])
    assert not motion.jump.any() and not motion.impulses
    assert motion.reaction(times).shape == (0, 8) and motion.reaction(1.0).shape == (0,)


def test_massless_joints_from_values_that_do_not_fit():
    motion = massless_joints().solve([1, 1, 2], [0, 1, 0])
    assert np.allclose(motion.start, [[2 / 3, 1, 2], [0, 0, 0]], atol=1e-14)
    assert not motion.impulses


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
