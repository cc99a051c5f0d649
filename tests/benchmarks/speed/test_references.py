"""References agree with one another and with formulas; peers are written as right as they can be."""

from __future__ import annotations

import numpy as np
import pytest

from tests.benchmarks.speed.models import chain, even_times, forty_periods
from tests.benchmarks.speed.motions import INTEGRATORS, MOTIONS, PEERS, Method, free_chain, harmonic_chain, recorded_chain
from tests.benchmarks.speed.reductions import Equations, as_fractions, reduced_chain
from tests.benchmarks.speed.references import by_balls, by_taylor, record_by_taylor
from tests.benchmarks.tables import Measured, fastest, relative_error

EXTENDED = np.finfo(np.longdouble).nmant > 60


def test_balls_of_an_oscillator_over_a_million_radians():
    """x'' = -x."""
    equations = Equations(*map(as_fractions, ([[0, 1], [-1, 0]], [[1, 0]], [1, 0], [0, 0])))
    times = even_times(2.0**20, 5)
    np.testing.assert_allclose(by_balls(equations, times)[0], np.cos(times), rtol=0, atol=1e-15)


def test_balls_and_taylor_steps_agree():
    given, times = chain(20), even_times(forty_periods(20), 100)
    exact = by_balls(reduced_chain(given, as_fractions), times)
    found = by_taylor(reduced_chain(given, np.longdouble), times)
    assert relative_error(found, exact) < (1e-15 if EXTENDED else 1e-11)


def test_a_record_that_is_constant_is_a_step():
    """x'' = -x + 1 from rest: 1 - cos t."""
    equations = Equations(*(np.array(array, dtype=np.longdouble) for array in ([[0, 1], [-1, 0]], [[1, 0]], [0, 0], [0, 1])))
    times = even_times(40.0, 50)
    np.testing.assert_allclose(record_by_taylor(equations, times, np.ones(50))[0], 1 - np.cos(times), atol=1e-15)


def suitable(problem) -> list[Method]:
    return [method for method in PEERS if method.suits(problem)]


@pytest.mark.parametrize("make", [lambda: free_chain(10), lambda: free_chain(10, damped=False), lambda: harmonic_chain(10)])
def test_peers_are_right(make):
    problem = make()
    truth, methods = problem.truth(), suitable(problem)
    assert len(methods) >= 3
    for method in methods:
        assert relative_error(method.prepare(problem)(problem.times), truth) < 1e-11, method.name


def test_lsim_is_right_about_a_record():
    problem = recorded_chain(10)
    (lsim,) = suitable(problem)
    assert relative_error(lsim.prepare(problem)(problem.times), problem.truth()) < 1e-12


def test_solve_ivp_reaches_its_tolerance():
    problem = MOTIONS[0].make()
    (integrator,) = INTEGRATORS
    assert relative_error(integrator.prepare(problem)(problem.times), problem.truth()) < 1e-10


def test_a_faster_method_is_bold():
    rival = Measured("lsim", 1e-15, 2e-3, 1e-3)
    assert fastest(rival, "one_run", 1e-3) == "2 ms (lsim)" and fastest(rival, "further", 2e-3) == "**1 ms (lsim)**"
    assert fastest(None, "one_run", 1.0) == "no correct digit"


@pytest.mark.parametrize("motion", [one for one in MOTIONS if one.states <= 250], ids=lambda motion: motion.name)
def test_every_small_model_has_its_number_of_states(motion):
    assert motion.make().equations.S.shape == (motion.states,) * 2
