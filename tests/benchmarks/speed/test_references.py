"""References agree with one another and with formulas; peers are written as right as they can be."""

from dataclasses import replace

import numpy as np
import pytest

from tests.benchmarks.speed.measure import Effort, measured, ours, relative_error
from tests.benchmarks.speed.models import chain, even_times, forty_periods
from tests.benchmarks.speed.peers import PEERS, Method
from tests.benchmarks.speed.reductions import Equations, as_fractions, reduced_chain
from tests.benchmarks.speed.references import by_balls, by_taylor, record_by_taylor
from tests.benchmarks.speed.workloads import WORKLOADS, free_chain, harmonic_chain, recorded_chain

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
    return [method for method in PEERS if method.suits(problem) and not method.once]


@pytest.mark.parametrize("make", [lambda: free_chain(10), lambda: free_chain(10, damped=False), lambda: harmonic_chain(10)])
def test_peers_are_right(make):
    problem = make()
    truth, methods = problem.truth(), suitable(problem)
    assert len(methods) >= 4
    for method in methods:
        assert relative_error(method.prepare(problem)(problem.times), truth) < 1e-11, method.name


def test_lsim_is_right_about_a_record():
    problem = recorded_chain(10)
    (lsim,) = suitable(problem)
    assert relative_error(lsim.prepare(problem)(problem.times), problem.truth()) < 1e-12


def test_solve_ivp_is_as_right_as_it_is_told_to_be():
    problem = next(workload for workload in WORKLOADS if workload.name == "example 5.1").make()
    integrated = [method for method in PEERS if method.once]
    errors = [relative_error(method.prepare(problem)(problem.times), problem.truth()) for method in integrated]
    assert len(errors) == 2 and all(error < 1e-10 for error in errors)


def test_chosen_coordinates_are_rows_of_all():
    whole, some = free_chain(10), free_chain(10, chosen=(2, 7))
    np.testing.assert_array_equal(some.truth(), whole.truth()[[2, 7]])
    assert relative_error(ours().prepare(some)(some.times), some.truth()) < 1e-11


def test_what_fails_is_told_and_the_others_go_on():
    def failing(problem):
        raise FloatingPointError("lost")

    problem = replace(free_chain(10), times=even_times(20.0, 5), truth=lambda: np.ones((12, 5)))
    peers = (Method("failing", failing), Method("quick", lambda _: lambda times: np.full((12, len(times)), 1.5)))
    found = measured(problem, 20, peers, Effort(2, 2, 0.0), lambda method: "not tried" if method.name == "mbconstrained" else "")
    assert [one.failure for one in found] == ["not tried", "FloatingPointError: lost", ""]
    assert found[2].error == 0.5 and len(found[2].further.seconds) == 2


@pytest.mark.parametrize("workload", [one for one in WORKLOADS if one.states <= 250], ids=lambda workload: workload.name)
def test_every_small_workload_is_as_large_as_it_is_said_to_be(workload):
    equations = workload.make().equations
    assert equations.S.shape == (workload.states,) * 2 and len(equations.E) == workload.coordinates
