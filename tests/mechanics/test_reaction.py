"""Constraint forces and impulses: the rigid link by hand, and every motion against the form with multipliers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.mechanics.constraints import Constraint
from mbconstrained.mechanics.system import MechanicalSystem
from tests.mechanics.systems import assert_same, saddle_point


def rigid_link(value=0.0, level="position"):
    """Two unit masses, a unit spring on the first, a rigid link between them."""
    link = Constraint([1, -1], level=level, value=value)
    return MechanicalSystem(np.eye(2), stiffness=np.diag([1.0, 0.0]), constraints=link)


def test_a_gap_is_closed_by_the_derivative_of_an_impulse():
    # by hand: momentum is kept, so both go to 1/2; Laplace: lambda = -s/2 + ... (1, 0) at rest
    motion = rigid_link().solve([1, 0])
    assert np.allclose(motion.start, [[0.5, 0.5], [0, 0]])
    assert_same(motion.constraint_impulses, [[0.0], [-0.5]])
    assert np.isclose(motion.reaction(0.0)[0], 0.25)


def test_an_impulse_on_one_body_is_shared_through_the_link():
    # 2 N s on the second mass: both leave with 1 m/s, the link passes 1 N s on to the first
    motion = rigid_link().solve(force=mb.impulse([0.0, 2.0]))
    assert np.allclose(motion.start[1], [1, 1])
    assert_same(motion.constraint_impulses, [[1.0]])


def test_the_scale_of_a_row_divides_its_multiplier():
    # A^T lambda is the force: a row of twice the size has half the multiplier
    for factor in (1.0, 2.0, -5.0, 1e-6):
        system = MechanicalSystem(np.eye(2), stiffness=np.diag([1.0, 0.0]), constraints=Constraint([factor, -factor]))
        motion = system.solve([1, 0])
        assert np.allclose(motion.constraint_impulses[1], -0.5 / factor)
        assert np.allclose(motion.reaction(2.0), rigid_link().solve([1, 0]).reaction(2.0) / factor)


def test_multipliers_of_redundant_rows_are_those_of_the_rows_left():
    rows = [Constraint([1, -1], names="link"), Constraint([2, -2], names="spare link")]
    motion = MechanicalSystem(np.eye(2), stiffness=np.diag([1.0, 0.0]), constraints=rows).solve([1, 1], [1, 1])
    assert [row.name for row in motion.system.rows] == ["link"]
    assert np.allclose(motion.reaction(0.0), [0.5])
    assert any(notice.kind == "redundant" and "spare link" in notice.text for notice in motion.notices)


def test_dampers_take_part_in_impulses():
    # a massless joint tied to a mass that jumps moves its damper: C times the jump of x is an impulse of force
    joint = MechanicalSystem(np.diag([0.0, 1.0]), np.diag([4.0, 0.0]), constraints=Constraint([1, -1]))
    motion = joint.solve([0.0, 1.0])
    # joint: 4 x' = lambda with x from 0 to 1; mass: x'' = -lambda, x' = -4 delta: the mass stays and leaves with -4 m/s
    assert np.allclose(motion.start, [[1, 1], [-4, -4]])
    assert_same(motion.constraint_impulses, [[4.0]])


def test_an_impulse_on_a_massless_joint_goes_through_its_spring_into_the_wall():
    # joint: k x1 = 3 delta, so the spring passes 3 N s on to the held end
    joint = MechanicalSystem(np.zeros((2, 2)), stiffness=[[7, -7], [-7, 7]], constraints=Constraint([0, 1]))
    motion = joint.solve(force=mb.impulse([3.0, 0.0]))
    assert_same(motion.impulses, [[3 / 7, 0.0]])
    assert_same(motion.constraint_impulses, [[-3.0]])


@pytest.mark.parametrize("seed", range(5))
def test_rounding_makes_no_impulse(seed):
    # two ties in turned coordinates, a gap of 1e-6 in the first beside displacements of 1e3: nothing happens in the second
    turned = np.linalg.qr(np.random.default_rng(seed).normal(size=(5, 5)))[0]
    ties = Constraint(np.array([[1, -1, 0, 0, 0], [0, 0, 1, -1, 0]]) @ turned)
    masses, springs = (turned.T @ np.diag(diagonal) @ turned for diagonal in ([1, 2, 3, 4, 5.0], [1, 0, 0, 2, 1.0]))
    motion = MechanicalSystem(masses, stiffness=springs, constraints=ties).solve(turned.T @ [1e3 + 1e-6, 1e3, 500, 500, 77])
    first, second = motion.constraint_impulses[1]
    assert np.isclose(first, -1e-6 * 1 * 2 / 3, rtol=1e-5)  # the gap times the reduced mass
    assert second == 0


@st.composite
def any_systems(draw):
    """Small systems with massless coordinates, rows at all levels, any start, and a force with an impulse."""
    n = draw(st.integers(2, 4))
    whole = st.integers(-2, 2)

    def array(*shape):
        flat = draw(st.lists(whole, min_size=int(np.prod(shape)), max_size=int(np.prod(shape))))
        return np.array(flat, float).reshape(shape)

    mass = np.diag([draw(st.integers(0, 3)) for _ in range(n)])
    b, c = array(n, n), array(n, n)
    count = draw(st.integers(1, 2))
    levels = [draw(st.sampled_from(["position", "velocity", "acceleration"])) for _ in range(count)]
    rows = array(count, n)
    rows[:, 0] += 3 * (np.abs(rows).sum(axis=1) == 0)
    constraints = [Constraint(row, level=level) for row, level in zip(rows, levels)]
    system = MechanicalSystem(mass, c.T @ c, np.eye(n) + b.T @ b, constraints)
    force = mb.harmonic(array(n), angular_frequency=1.5) + mb.impulse(array(n))
    return system, array(2, n), force


@given(any_systems())
def test_against_the_form_with_multipliers(case):
    system, start, force = case
    n, k = system.size, len(system.rows)
    try:
        expected = saddle_point(system, start, force)
    except mb.SingularPolynomialMatrix:  # the same motion is undetermined in both forms
        with pytest.raises(mb.SingularPolynomialMatrix):
            system.solve(*start, force=force)
        return
    motion = system.solve(*start, force=force)
    times = np.array([0.0, 0.7, 2.0])
    size = 1e-8 * (1 + np.abs(expected(times)).max() + max([0, *(np.abs(c).max() for c in expected.impulses)]))
    assert np.allclose(motion(times), expected(times)[:n], atol=size)
    assert np.allclose(motion.reaction(times), expected(times)[n:], atol=size)
    for order in range(max(len(expected.impulses), len(motion.constraint_impulses), len(motion.impulses))):
        both = expected.impulses[order] if order < len(expected.impulses) else np.zeros(n + k)
        own = motion.impulses[order] if order < len(motion.impulses) else np.zeros(n)
        forces = motion.constraint_impulses[order] if order < len(motion.constraint_impulses) else np.zeros(k)
        assert np.allclose(own, both[:n], atol=size)
        assert np.allclose(forces, both[n:], atol=size)


def test_the_estimate_knows_what_cancels_between_the_springs():
    """A stiff spring hardly stretched next to soft ones: the reaction is a small difference of large entries of K x."""
    model = mb.LumpedModel()
    model.node("a")
    model.node("b")
    model.spring("ground", "a", 0.12)
    model.spring("ground", "b", 0.01)
    model.spring("a", "b", 582.1338942830382)
    model.constrain({"a": 3.0, "b": 2.0}, level="velocity")
    motion, times = model.assemble().solve([0.0, -2.2], force=mb.step([0.0, 0.1])), np.linspace(0.5, 15.0, 7)
    values, exact = motion.reaction(times), motion.enclose(times, 17, of="reaction").middle
    error = np.abs(values - exact).max() / np.abs(values).max()
    assert error / 2 <= motion.error_estimate(times, of="reaction") <= 100 * error
