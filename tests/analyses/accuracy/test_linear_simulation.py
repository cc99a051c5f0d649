"""lsim and forced_response are exact for what is linear between the times; otherwise the error falls with the step squared."""

from importlib.util import find_spec
from itertools import pairwise

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.accuracy import methods as linear_simulation
from mbconstrained.analyses.accuracy.methods import SIMULATIONS as METHODS
from mbconstrained.analyses.accuracy.methods import Failure
from mbconstrained.analyses.study_problem import StudyProblem
from tests.analyses.accuracy.problems import TIMES, answer, error, problem

LSIM, FORCED_RESPONSE = METHODS

#: Those that are linear between the times, and change at them.
LINEAR = ["none", "step", "ramp", "record", "pulse", "impulse at 0", "delayed impulse"]

needs_control = pytest.mark.skipif(not find_spec("control"), reason="python-control is not installed")
BOTH = pytest.mark.parametrize("method", [LSIM, pytest.param(FORCED_RESPONSE, marks=needs_control)], ids=["lsim", "control"])


@BOTH
@pytest.mark.parametrize("force", LINEAR)
@pytest.mark.parametrize(
    "system", ["regular mass", "massless and damped", "tied, inconsistent start", "tied at acceleration level"]
)
def test_forces_that_are_linear_between_the_times_are_followed_to_rounding(method, system, force):
    found = problem(system, force)
    assert [setting.value for setting in method.settings_for(found)] == [1]
    assert error(found, answer(method, found, 1)) < 1e-11


@BOTH
@pytest.mark.parametrize("force", ["harmonic", "t^2 e^(a t) cos", "two forces"])
def test_others_by_the_square_of_the_step(method, force):
    found = problem("tied", force)
    assert [setting.value for setting in method.settings_for(found)] == [1, 4, 16, 64]
    errors = [error(found, answer(method, found, refinement)) for refinement in (1, 4, 16, 64)]
    assert errors[0] < 1e-2
    for coarse, fine in pairwise(errors):
        assert 14 < coarse / fine < 18


def test_a_jump_between_the_times_is_smeared_over_a_step():
    found = problem("regular mass", "pulse between times")
    assert [setting.value for setting in LSIM.settings_for(found)] == [1, 4, 16, 64]
    coarse, fine = (error(found, answer(LSIM, found, refinement)) for refinement in (1, 64))
    assert 1e-4 < coarse < 1e-1 and fine < coarse / 10


def test_refusals(monkeypatch):
    assert LSIM.refusal(problem("tied", "none", np.array([0.0, 1.0, 3.0]))) == "needs even times that begin at t = 0"
    assert LSIM.refusal(problem("tied", "none", np.array([1.0, 2.0, 3.0]))) == "needs even times that begin at t = 0"
    assert LSIM.refusal(problem("tied", "none", np.array([0.0]))) == "needs at least two times"
    at_once = StudyProblem("at once", mb.PolynomialMatrix([[[2.0]]]), np.zeros((0, 1)), mb.ramp([1.0]), TIMES)
    assert LSIM.refusal(at_once) == "there are no states: x depends on the force at the same time only"
    assert LSIM.refusal(problem("tied", "none")) == ""
    monkeypatch.setattr(linear_simulation, "find_spec", lambda name: None)
    assert FORCED_RESPONSE.refusal(problem("tied", "none")) == "python-control is not installed"


def test_what_it_cannot_do_is_told():
    with pytest.raises(Failure, match=r"the Dirac impulse at 0.77 s lies between the samples; there is no input for it"):
        answer(LSIM, problem("tied", "delayed derivative of an impulse"), 1)
    with pytest.raises(Failure, match="6400000 samples of all states and coordinates are too many"):
        answer(LSIM, problem("tied", "harmonic", np.linspace(0.0, 4.0, 100_000)), 64)
