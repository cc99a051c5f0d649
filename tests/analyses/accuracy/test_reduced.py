"""The reduced equations are those that one finds by hand."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.accuracy.first_order import reduced
from mbconstrained.analyses.study_problem import StudyProblem, mechanical_problem, problem_of
from tests.analyses.accuracy.problems import EXAMPLES, FORCES, SYSTEMS, problem

TIMES = np.linspace(0.0, 1.0, 11)


def test_an_oscillator():
    found = reduced(mechanical_problem("oscillator", mb.MechanicalSystem([[2.0]], [[3.0]], [[8.0]]), TIMES, [0.5], [-1.0]))
    np.testing.assert_array_equal(found.S, [[0.0, 1.0], [-4.0, -1.5]])
    np.testing.assert_array_equal(found.B, [[0.0], [0.5]])
    np.testing.assert_array_equal(found.C, [[1.0, 0.0]])
    np.testing.assert_array_equal(found.start, [0.5, -1.0])
    assert found.places == ((0, 0), (0, 1)) and not found.through.coefficients.any()


def test_a_tied_pair_is_one_mass_and_its_value_reaches_the_other_at_once():
    tie = mb.Constraint([1.0, -1.0], value=0.5)
    pair = mb.MechanicalSystem(np.diag([1.0, 3.0]), stiffness=np.diag([0.0, 8.0]), constraints=[tie])
    found = reduced(mechanical_problem("pair", pair, TIMES, [0.5, 0.0]))
    np.testing.assert_allclose(found.S, [[0.0, 1.0], [-2.0, 0.0]], atol=1e-14)
    np.testing.assert_allclose(found.C, [[1.0, 0.0], [1.0, 0.0]], atol=1e-14)
    through = found.through(1.0)
    assert through[0] - through[1] == pytest.approx(0.5, abs=1e-14)


def test_a_damped_joint_without_mass_is_of_first_order():
    found = reduced(mechanical_problem("joint", mb.MechanicalSystem([[0.0]], [[2.0]], [[6.0]]), TIMES, [1.0], force=mb.step([4.0])))
    np.testing.assert_allclose(
        [found.S.item(), found.B.item(), found.C.item(), found.start.item()], [-3.0, 0.5, 1.0, 1.0], rtol=1e-15
    )


def test_what_the_force_does_at_once_is_not_a_state():
    """x1' = f1 - x1, x2 = f2: the second follows its force."""
    A = mb.PolynomialMatrix([np.eye(2), np.diag([1.0, 0.0])])
    found = reduced(StudyProblem("descriptor", A, np.array([[2.0, 0.0]]), mb.ramp([1.0, 3.0]), TIMES))
    assert found.count == 1
    np.testing.assert_array_equal(found.through(TIMES), [0 * TIMES, 3 * TIMES])
    np.testing.assert_array_equal(found.C @ found.start, [2.0, 0.0])


def test_where_nothing_moves_by_itself_there_are_no_states():
    for A in (mb.PolynomialMatrix([[[2.0]]]), mb.PolynomialMatrix([[[2.0]], [[0.0]]])):
        found = reduced(StudyProblem("at once", A, np.zeros((A.degree, 1)), mb.ramp([4.0]), TIMES))
        assert found.count == 0
        np.testing.assert_array_equal(found.coordinates(np.zeros((0, 11)), TIMES), [2 * TIMES])


@pytest.mark.parametrize("scene", [scene for scene in EXAMPLES if scene != "stiff_stack.toml"])
def test_S_has_the_finite_zeros_and_no_others(scene):
    """Compared by the traces of powers, which multiple zeros do not blur."""
    found = problem_of(mb.read_scene(f"examples/{scene}"))
    equations, J = reduced(found), found.polynomial_matrix.jordan_pairs().finite.J
    assert len(equations.S) == len(J)
    size = max(1.0, np.abs(np.linalg.eigvals(J)).max())
    for power in range(1, len(J) + 1):
        one, two = (np.trace(np.linalg.matrix_power(matrix / size, power)) for matrix in (equations.S, J))
        assert one == pytest.approx(two, abs=1e-10)


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


def test_sizes_are_those_of_the_beginning_in_a_motion_that_grows():
    growing = mechanical_problem(
        "falls", mb.MechanicalSystem([[1.0]], stiffness=[[-1.0]]), np.linspace(0.0, 30.0, 301), [1.0], [1.0]
    )
    np.testing.assert_allclose(reduced(growing).sizes, np.exp(3.0), rtol=1e-9)
    resting = mechanical_problem("rests", mb.MechanicalSystem([[1.0]]), TIMES)
    np.testing.assert_array_equal(reduced(resting).sizes, [1.0, 1.0])
