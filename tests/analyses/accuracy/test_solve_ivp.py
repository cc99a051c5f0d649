"""solve_ivp gets what it needs, and its error falls with its tolerance."""

from types import SimpleNamespace

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.accuracy.first_order import intervals
from mbconstrained.analyses.accuracy.methods import INTEGRATORS as METHODS
from mbconstrained.analyses.accuracy.methods import Failure
from tests.analyses.accuracy.problems import FORCES, answer, error, problem

DOP853, LSODA, ODEINT, RADAU, BDF = METHODS


@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize(
    "method, bound", [(DOP853, 1e-11), (LSODA, 1e-10), (ODEINT, 1e-10)], ids=lambda value: getattr(value, "name", "")
)
def test_every_force_is_followed_at_the_finest_tolerance(method, bound, force):
    found = problem("massless and damped", force)
    assert error(found, answer(method, found, 1e-13)) < bound


@pytest.mark.parametrize(
    "method, factor",
    [(DOP853, 20.0), (LSODA, 2000.0), (ODEINT, 2000.0), (RADAU, 20.0), (BDF, 2000.0)],
    ids=lambda value: getattr(value, "name", ""),
)
@pytest.mark.parametrize("system", ["tied", "tied, inconsistent start"])
def test_errors_fall_with_the_tolerance(method, factor, system):
    """Eight periods or so; a method of low order gathers more errors on the way."""
    found = problem(system, "two forces")
    for rtol in (1e-3, 1e-5, 1e-7):
        assert error(found, answer(method, found, rtol)) < factor * rtol


@pytest.mark.parametrize("force", [force for force in FORCES if force != "none"])
def test_formulas_are_the_force_on_every_stretch(force):
    signal, times = FORCES[force], np.linspace(0.0, 4.0, 33)
    matrix = np.array([[1.0, 2.0, 3.0], [0.0, -1.0, 1.0]])
    found = list(intervals(signal, times, matrix))
    np.testing.assert_allclose(np.concatenate([interval.times for interval in found]), times, rtol=1e-15)
    for interval in found:
        for t in np.linspace(interval.begin, interval.end, 5)[:-1]:
            np.testing.assert_allclose(interval.force(t), matrix @ signal(t), rtol=0, atol=1e-12)


def test_what_differs_by_rounding_is_one_time():
    """0.1 + 0.2 is no knot at 0.3, and no solver can step from one to the other."""
    force = mb.step([1.0]).delayed(0.1 + 0.2) + mb.step([1.0]).delayed(0.3)
    found = list(intervals(force, np.array([0.0, 0.3, 0.6]), np.eye(1)))
    assert [(interval.begin, interval.end) for interval in found] == [(0.0, 0.3), (0.3, 0.3), (0.1 + 0.2, 0.6)]
    assert [interval.times.tolist() for interval in found] == [[0.0], [0.3], [0.6]]
    late = list(intervals(mb.step([1.0]).delayed(0.3), np.array([0.0, 0.1 + 0.2, 0.6]), np.eye(1)))
    assert late[1].times.tolist() == [0.3, 0.6]


def test_a_generator_that_is_no_chain_is_evaluated_as_it_is():
    from mbconstrained.signals.bohl import BohlFunction
    from mbconstrained.signals.impulsive import ImpulsiveSmooth

    mixed = BohlFunction(np.eye(2), (np.array([[-1.0, 2.0], [0.0, -3.0]]),), np.array([1.0, 0.5]))
    (interval,) = intervals(ImpulsiveSmooth(mixed), np.array([0.0, 1.0]), np.eye(2))
    np.testing.assert_allclose(interval.force(0.7), mixed(0.7), rtol=1e-14)


def test_failures_carry_the_message_of_the_solver(monkeypatch):
    import scipy.integrate

    message = "Required step size is less than spacing between numbers."
    monkeypatch.setattr(scipy.integrate, "solve_ivp", lambda *args, **options: SimpleNamespace(status=-1, message=message))
    with pytest.raises(Failure, match=message):
        answer(BDF, problem("regular mass", "none"), 1e-3)
