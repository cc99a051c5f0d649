"""IDA gets the equations as they are, in the three usual indices, and values that fit."""

from importlib.util import find_spec

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.accuracy import methods as ida
from mbconstrained.analyses.accuracy.methods import IDA_FORMS as METHODS
from mbconstrained.analyses.accuracy.methods import Failure, descriptor
from mbconstrained.analyses.study_problem import mechanical_problem
from tests.analyses.accuracy.problems import FORCES, TIMES, answer, chain, error, problem

INDEX_1, INDEX_2, INDEX_3, PLAIN = METHODS

needs_sundae = pytest.mark.skipif(not find_spec("sksundae"), reason="scikit-sundae is not installed")

#: A pendulum of 2 kg and 1 m near its rest: x is held up to second order, y = 0 is the tie; (x, y) with gravity as K.
PENDULUM = mechanical_problem(
    "pendulum",
    mb.MechanicalSystem(2 * np.eye(2), stiffness=np.diag([2 * 9.81, 0.0]), constraints=[mb.Constraint([0.0, 1.0])]),
    np.linspace(0.0, 4.0, 41),
    [0.1, 0.0],
)


@needs_sundae
@pytest.mark.parametrize("method", METHODS[:3], ids=lambda method: method.name)
def test_a_pendulum_in_every_index(method):
    values = answer(method, PENDULUM, 1e-6)
    np.testing.assert_allclose(values[0], 0.1 * np.cos(np.sqrt(9.81) * PENDULUM.times), atol=1e-4)
    np.testing.assert_allclose(values[1], 0.0, atol=1e-12)


@needs_sundae
@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("method", METHODS[:2], ids=lambda method: method.name)
def test_rows_differentiated_under_every_force(method, force):
    found = problem("tied", force)
    assert error(found, answer(method, found, 1e-8)) < 1e-4


@needs_sundae
@pytest.mark.parametrize("force", FORCES)
def test_singular_masses_under_every_force(force):
    found = problem("massless and damped", force)
    assert error(found, answer(PLAIN, found, 1e-8)) < 1e-4


@needs_sundae
@pytest.mark.parametrize("system", ["tied at velocity level", "tied at acceleration level"])
def test_rows_at_weaker_levels_keep_their_values(system):
    found = problem(system, "step")
    assert error(found, answer(INDEX_1, found, 1e-8)) < 1e-4


@needs_sundae
def test_errors_fall_with_the_tolerance():
    found = problem("tied", "harmonic")
    errors = [error(found, answer(INDEX_1, found, rtol)) for rtol in (1e-4, 1e-7, 1e-10)]
    assert errors[1] < errors[0] / 10 and errors[2] < errors[1] / 10 and errors[2] < 1e-6


@needs_sundae
def test_a_solver_that_gives_up_is_a_failure_with_its_message(monkeypatch):
    monkeypatch.setattr(ida, "IDA_STEPS", 1)
    with pytest.raises(Failure, match="max_num_steps"):
        answer(PLAIN, problem("regular mass", "harmonic"), 1e-10)


def residual(form, t: float, force) -> np.ndarray:
    y, rate = (function(t) for function in form.motion)
    return form.E @ rate + form.F @ y - force(t)


@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("index", [1, 2, 3])
def test_the_start_fits_the_equations_of_every_index(index, force):
    """E y' + F y = g for the closed form, at 0+ and later."""
    form = descriptor(problem("tied, inconsistent start", force), index)
    assert form.index == index
    for t in (0.0, 0.9, 3.3):
        np.testing.assert_allclose(residual(form, t, form.force), 0.0, atol=1e-11)


def test_refusals(monkeypatch):
    free, tied = problem("regular mass", "none"), problem("tied", "none")
    assert [method for method in METHODS if method.concerns(free)] == [PLAIN]
    assert [method for method in METHODS if method.concerns(tied)] == [INDEX_1, INDEX_2, INDEX_3]
    rolling = mb.Constraint([1.0, -1.0, 0.0], level="velocity", names="rolling")
    rolls = mechanical_problem("rolls", chain([rolling]), TIMES)
    assert INDEX_3.refusal(rolls) == (
        "needs rows at position level; rolling is at velocity level, which does not determine its position"
    )
    drifts = problem("tied at acceleration level", "none")
    assert INDEX_2.refusal(drifts) == (
        "needs rows at velocity level; constraint 1 is at acceleration level, which does not determine its velocity"
    )
    monkeypatch.setattr(ida, "find_spec", lambda name: None)
    assert INDEX_1.refusal(tied) == INDEX_2.refusal(rolls) == PLAIN.refusal(free) == "scikit-sundae is not installed"
