"""The constrained form: equations, levels, forces."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.mechanics.constraints import Constraint
from mbconstrained.mechanics.system import MechanicalSystem
from tests.mechanics.systems import two_masses


def test_the_paper_example_up_to_the_order_of_the_columns_of_V():
    # Moysis et al., Eq. 84 with m = 10, k = 2, its first two rows exchanged
    A = two_masses().polynomial_matrix()
    assert A.degree == 2
    assert A.coefficients.tolist() == [
        [[2, 0, 0], [0, 0, 2], [0, 0, 0]],
        [[0, 0, 0], [0, 0, 0], [0, 0, 0]],
        [[10, 10, 10], [0, 10, 10], [1, -1, 0]],
    ]
    assert A.equations == ("motion of q1", "motion of q2", "constraint link")
    assert A.coordinates == ("x1", "q1", "q2")


@pytest.mark.parametrize("power, level", [(0, "position"), (1, "velocity"), (2, "acceleration")])
def test_a_row_stands_in_the_coefficient_of_its_level(power, level):
    coefficients = two_masses(level).polynomial_matrix().coefficients
    assert [matrix[2].tolist() == [1, -1, 0] for matrix in coefficients] == [i == power for i in range(3)]
    assert sum(np.abs(matrix[2]).sum() for matrix in coefficients) == 2


@pytest.mark.parametrize("level", ["position", "velocity", "acceleration"])
def test_the_position_form_has_no_drift(level):
    A = two_masses(level).position_form().polynomial_matrix
    assert np.array_equal(A.coefficients, two_masses("position").polynomial_matrix().coefficients)


@pytest.mark.parametrize("ratio", [0.1, 0.3, 1 / 3, 0.7, 1e-3])
def test_rounding_makes_no_stiffness(ratio):
    # springs that a geared motion does not stretch: V^T K = 0 by ratio * k - k * ratio, which rounding must not fill
    K = 0.7 * np.array([[1.0, -ratio], [-ratio, ratio * ratio]])
    gear = MechanicalSystem(np.eye(2), stiffness=K, constraints=Constraint([1, -ratio]))
    assert not gear.polynomial_matrix().coefficients[0][0].any()
    assert [(mode.kind, mode.multiplicity) for mode in gear.modes()] == [("rigid body", 2)]


def test_forces_are_projected_and_values_become_steps():
    form = two_masses("position", value=-0.4).constrained_form()
    right = form.force(mb.ramp([1.0, 2.0, 3.0]) + mb.impulse([1.0, 1.0, 0.0]))
    assert np.allclose(right(2.0), [6.0, 6.0, -0.4])  # rows: motion of q1 = x1 + q1, motion of q2, the row
    assert np.allclose(right.impulses[0], [2.0, 0.0, 0.0])


def test_everything_held():
    system = MechanicalSystem(np.eye(2), constraints=Constraint(np.eye(2), value=[1.0, 2.0]))
    motion = system.solve([1.0, 2.0])
    assert motion(3.0).tolist() == [1.0, 2.0]
    assert not motion.notices


def test_a_singular_form_names_equations_and_coordinates():
    loose = MechanicalSystem(np.diag([1.0, 0.0]), stiffness=np.diag([1.0, 0.0]), names=["cart", "joint"])
    with pytest.raises(mb.SingularPolynomialMatrix, match='"motion of joint".*"joint"'):
        loose.solve()


@pytest.mark.parametrize("spring", [7e-15, 1.4e-14, 1e-9, -7e-15])
def test_a_tiny_spring_under_a_rigid_link_is_data(spring):
    """x1 = x2 over K = [[1 + g, -1], [-1, 1]]: what float64 holds of g moves both masses."""
    K = np.array([[1 + spring, -1], [-1, 1]])
    system = MechanicalSystem(np.eye(2), None, K, constraints=[Constraint([1, -1])])
    rate = np.emath.sqrt(-(K[0, 0] - 1) / 2)
    assert np.allclose(system.solve([1.0, 1.0])(1e7), np.cosh(rate * 1e7).real, rtol=1e-12)
    assert np.isclose(max(mode.eigenvalue.imag or mode.eigenvalue.real for mode in system.modes()), abs(rate), rtol=1e-12)
    assert not any(notice.doubtful for notice in system.solve([1.0, 1.0]).notices)


@pytest.mark.parametrize("units, kind", [(1, "rigid body"), (2, "rigid body"), (4, "oscillation"), (6, "oscillation")])
def test_a_sum_of_the_size_of_its_rounding_is_reported(units, kind):
    spring = units * np.finfo(float).eps
    system = MechanicalSystem(np.eye(2), None, [[1 + spring, -1], [-1, 1]], constraints=[Constraint([1, -1])])
    assert [mode.kind for mode in system.modes()] == [kind]
    (notice,) = system.solve([1.0, 1.0]).notices
    assert notice.doubtful and "stiffness: the constraints leave of the entries of x1" in notice.text


@pytest.mark.parametrize("seed", range(5))
def test_tied_free_bodies_with_assembled_springs_stay_free(seed):
    springs = np.random.default_rng(seed).uniform(0.1, 3.0, 5)
    B = np.diff(np.eye(6), axis=0)
    system = MechanicalSystem(np.eye(6), None, B.T @ np.diag(springs) @ B, constraints=[Constraint(B[[1, 3]])])
    assert system.modes()[0].kind == "rigid body"
    assert not any(notice.doubtful for notice in system.solve(np.ones(6)).notices)
