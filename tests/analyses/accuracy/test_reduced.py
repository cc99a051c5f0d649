"""The reduced equations are those that one finds by hand."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.accuracy.first_order import reduced
from mbconstrained.analyses.study_problem import StudyProblem, mechanical_problem
from tests.analyses.accuracy.problems import FORCES, SYSTEMS, problem

TIMES = np.linspace(0.0, 1.0, 11)


def test_what_the_force_does_at_once_is_not_a_state():
    """x1' = f1 - x1, x2 = f2: the second follows its force."""
    A = mb.PolynomialMatrix([np.eye(2), np.diag([1.0, 0.0])])
    found = reduced(StudyProblem("descriptor", A, np.array([[2.0, 0.0]]), mb.ramp([1.0, 3.0]), TIMES))
    assert found.count == 1
    np.testing.assert_array_equal(found.through(TIMES), [0 * TIMES, 3 * TIMES])
    np.testing.assert_array_equal(found.C @ found.start, [2.0, 0.0])


@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("system", SYSTEMS)
def test_states_are_coordinates_and_derivatives_less_what_the_force_does_at_once(system, force):
    """C z(0+) and the force give x(0+), and C S z + C B f and the derivative of the rest give x'(0+)."""
    found = problem(system, force)
    equations, response = reduced(found), found.solve()
    z, f = equations.start, found.force(0.0)
    rate = equations.S @ z + equations.B @ f
    scale = max(np.abs(response(found.times)).max(), 1.0)
    np.testing.assert_allclose(equations.C @ z + equations.through(0.0), response(0.0), atol=1e-12 * scale)
    derivative = equations.C @ rate + equations.through.derivative(1)(0.0)
    np.testing.assert_allclose(derivative, response.derivative(1)(0.0), atol=1e-11 * scale)


def test_the_jump_of_a_free_mass_under_an_impulse():
    found = reduced(mechanical_problem("mass", mb.MechanicalSystem([[2.0]]), TIMES))
    np.testing.assert_array_equal(found.jump([np.array([6.0])]), [0.0, 3.0])
    np.testing.assert_array_equal(found.jump([np.array([0.0]), np.array([6.0])]), [3.0, 0.0])
