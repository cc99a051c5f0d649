"""The constrained form: equations, levels, forces."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.mechanics import Constraint, MechanicalSystem
from tests.mechanics.systems import two_masses


def test_without_rows_it_is_the_system_itself():
    M, C, K = np.diag([2.0, 3.0]), np.eye(2), [[2, -1], [-1, 2]]
    form = MechanicalSystem(M, C, K, names=["a", "b"]).constrained_form()
    assert np.array_equal(form.polynomial_matrix.coefficients, [K, C, M])
    assert form.polynomial_matrix.equations == ("motion of a", "motion of b")


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
    assert [(mode.kind, mode.multiplicity) for mode in gear.modes().zeros] == [("rigid body", 2)]


def test_the_degree_is_two_even_without_masses():
    A = MechanicalSystem(np.zeros((2, 2)), stiffness=np.eye(2), constraints=Constraint([1, -1])).polynomial_matrix()
    assert A.degree == 2


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
