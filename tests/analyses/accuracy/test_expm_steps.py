"""Stepping with matrix exponentials is exact for every force, whatever the times."""

import numpy as np
import pytest
from scipy.linalg import matrix_balance

import mbconstrained as mb
from mbconstrained.analyses.accuracy import methods as expm_steps
from mbconstrained.analyses.accuracy.first_order import reduced
from mbconstrained.analyses.accuracy.methods import EACH, STEPS, Failure
from mbconstrained.analyses.study_problem import StudyProblem, mechanical_problem, problem_of
from mbconstrained.ground.tolerances import EPS
from tests.analyses.accuracy.problems import EXAMPLES, FORCES, SYSTEMS, answer, error, problem


@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("system", SYSTEMS)
def test_every_force_is_followed_to_rounding(system, force):
    found = problem(system, force)
    values = answer(STEPS, found)
    closed = found.solve()(found.times)
    np.testing.assert_allclose(values, closed, rtol=0, atol=1e-11 * np.abs(closed).max())
    assert error(found, values) < 1e-11


@pytest.mark.parametrize("force", FORCES)
def test_uneven_times_change_nothing(force):
    uneven = np.sort(np.random.default_rng(3).uniform(0.0, 4.0, 40))
    found = problem("massless and damped", force, uneven)
    assert error(found, answer(STEPS, found), 8) < 1e-11


@pytest.mark.parametrize("force", ["none", "harmonic", "t^2 e^(a t) cos", "impulse at 0"])
def test_each_time_by_itself_gives_the_same(force):
    found = problem("tied", force)
    assert EACH.refusal(found) == ""
    assert error(found, answer(EACH, found)) < 1e-11


@pytest.mark.parametrize("scene", [scene for scene in EXAMPLES if scene != "stiff_stack.toml"])
def test_examples_agree_with_the_closed_form(scene):
    """The problem is what its scene asks, also by its equations alone, and has as many states as A(s) has finite zeros."""
    scene = mb.read_scene(f"examples/{scene}")
    found = problem_of(scene)
    closed = found.solve()(found.times)
    assert np.array_equal(closed, scene.equations.solve()(found.times))
    general = found.solve_equations()(found.times)
    assert np.abs(general - closed).max() <= 1e-11 * max(np.abs(closed).max(), 1.0)
    assert reduced(found).count == len(found.polynomial_matrix.jordan_pairs().finite.J)
    limit = max(1e-11, rounding_of_exponentials(found))
    np.testing.assert_allclose(answer(STEPS, found), closed, rtol=0, atol=limit * np.abs(closed).max())


def rounding_of_exponentials(found) -> float:
    """n eps |S| T: e^(S h) is computed as e^(S h + E) with |E| <= n eps |S h| (Higham 2005, section 2), here with S balanced.

    Over all steps to T the states change by up to T |E| / h, relative to their size: fast modes of an arm with stiff gears are many
    radians on after a second, and their phases are known to that many units in the last place.
    """
    S = matrix_balance(reduced(found).S)[0]
    return len(S) * EPS * np.linalg.norm(S, 2) * found.times[-1]


def test_refusals():
    assert EACH.refusal(problem("tied", "pulse")) == (
        "the force starts, stops, changes or has an impulse on the way; one exponential from t = 0 does not include it"
    )
    many = mechanical_problem("many", mb.MechanicalSystem(np.eye(60), stiffness=np.eye(60)), [0.0, 1.0])
    assert EACH.refusal(many) == "2 exponentials of 120 states take too long"
    at_once = StudyProblem("at once", mb.PolynomialMatrix([[[2.0]]]), np.zeros((0, 1)), mb.ramp([1.0]), np.array([0.0, 1.0]))
    assert STEPS.refusal(at_once) == EACH.refusal(at_once) == "there are no states: x depends on the force at the same time only"


def test_too_many_step_lengths_are_told(monkeypatch):
    monkeypatch.setattr(expm_steps, "MOST_BYTES", 100)
    with pytest.raises(Failure, match="1 lengths of step with 6 states each need a matrix exponential of their own"):
        STEPS.prepare(problem("regular mass", "none"), None)
