"""What is measured is measured; what fails is told as a failure, in words."""

import time
import warnings

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses import timing
from mbconstrained.analyses.accuracy import measure
from mbconstrained.analyses.accuracy.accuracy import (
    AccuracyReport,
    accuracy_report,
    fastest,
    one_run,
)
from mbconstrained.analyses.accuracy.measure import measure as measured
from mbconstrained.analyses.accuracy.measure import reference_solution
from mbconstrained.analyses.accuracy.methods import OURS, ComparedMethod, Failure, MethodSetting
from mbconstrained.analyses.study_problem import mechanical_problem, problem_of
from mbconstrained.analyses.timing import Timing
from mbconstrained.scene.run.scene import read_scene

TIMES = np.linspace(0.0, 3.0, 11)
PROBLEM = mechanical_problem("oscillator", mb.MechanicalSystem([[1.0]], stiffness=[[4.0]]), TIMES, [1.0])
TRUTH = reference_solution(PROBLEM)
EXACT = np.cos(2 * TIMES)[None]


@pytest.fixture(autouse=True)
def few_repeats(monkeypatch):
    """What is measured, and not how often, nor in a heap without the garbage of all tests before."""
    monkeypatch.setattr(measure, "REPEATS", 2)
    monkeypatch.setattr(timing.gc, "collect", lambda: 0)


def test_median_and_quartiles():
    repeats = Timing((4.0, 1.0, 2.0, 3.0, 100.0))
    assert repeats.median == 3.0 and repeats.quartiles == (2.0, 4.0)
    assert repeats.to_dict() == {"median": 3.0, "lower_quartile": 2.0, "upper_quartile": 4.0, "repeats": 5}
    assert Timing((2.0,)).quartiles == (2.0, 2.0)


def off_by(error: float):
    return lambda problem, value: lambda: EXACT + error


def raising(problem_found: Exception):
    def prepare(problem, value):
        raise problem_found

    return prepare


def one(*methods: ComparedMethod, seconds: float = 5.0):
    return measured(PROBLEM, TRUTH, methods, seconds)


def test_errors_are_those_of_the_values():
    good, bad = one(ComparedMethod("good", off_by(0.0)), ComparedMethod("bad", off_by(1e-3)))
    assert good.error < 1e-15 and bad.error == pytest.approx(1e-3, rel=1e-9)
    assert good.one_run.median >= good.evaluation.median >= 0 and not good.failure


@pytest.mark.parametrize(
    "prepare, told",
    [
        (raising(Failure("refuses singular mass")), "refuses singular mass"),
        (raising(mb.InputError("mass: found 0; expected more")), "mass: found 0; expected more"),
        (raising(RuntimeError("first line\nsecond line")), "RuntimeError: first line"),
        (raising(ZeroDivisionError()), "ZeroDivisionError"),
        (lambda problem, value: lambda: EXACT * np.nan, "gives no numbers"),
        (lambda problem, value: lambda: EXACT + 40.0, "has an error of 4e+01 times the motion"),
    ],
)
def test_failures_are_told_as_failures(prepare, told):
    (found,) = one(ComparedMethod("it", prepare))
    assert found.failure == told and found.error is None and found.evaluation is None


def test_what_takes_too_long_is_broken_off_and_finer_settings_are_not_tried():
    ran = []

    def prepare(problem, value):
        ran.append(value)
        time.sleep(30.0 if value > 1 else 0.0)
        return lambda: EXACT

    settings = tuple(MethodSetting(f"step {value:g}", value) for value in (1.0, 2.0, 3.0))
    quick, slow, untried = one(ComparedMethod("stepper", prepare, settings), seconds=0.2)
    assert not quick.failure and slow.failure == "takes more than 200 ms"
    assert untried.failure == "not run: a coarser setting exceeds the time limit" and 3.0 not in ran


def test_a_library_is_loaded_before_its_first_run():
    missing, there = one(
        ComparedMethod("missing", off_by(0.0), library="no_such_library"), ComparedMethod("there", off_by(0.0), library="json")
    )
    assert missing.failure == "ModuleNotFoundError: No module named 'no_such_library'" and not there.failure


def test_warnings_and_prints_of_methods_do_not_reach_the_user(capfd):
    def prepare(problem, value):
        warnings.warn("step too large", RuntimeWarning, stacklevel=1)
        print("lsoda--")
        return lambda: EXACT + np.float64(0.0) / np.array([1.0])

    (found,) = one(ComparedMethod("noisy", prepare))
    assert not found.failure and capfd.readouterr() == ("", "")


@pytest.mark.parametrize("method", OURS, ids=lambda method: method.name)
def test_each_method_of_the_closed_form_is_right_where_it_applies(method):
    problem, truth = PROBLEM, TRUTH
    if "assembled" in method.name:
        elements = mb.ElementMatrix([[1.0, 0.0], [-1.0, 1.0]], [1e5, 1.0])
        problem = mechanical_problem("two", mb.MechanicalSystem(np.eye(2), stiffness=elements), TIMES, [1.0, 1.0])
        truth = reference_solution(problem)
    if "A(s)" in method.name:
        problem = problem_of(read_scene("examples/transfer_function.toml"))
        truth = reference_solution(problem)
    assert method.concerns(problem)
    (found,) = measured(problem, truth, [method])
    assert not found.failure and found.error < 1e-9


def report(*methods: ComparedMethod) -> AccuracyReport:
    return accuracy_report(PROBLEM, methods)


@pytest.mark.long
def test_an_answer_that_is_wrong_or_missing_is_not_trusted():
    assert not report(ComparedMethod("closed form", off_by(0.01), is_ours=True)).answer("a").is_trusted
    assert not report(ComparedMethod("closed form", raising(Failure("no")), is_ours=True)).answer("a").is_trusted


def test_the_fastest_is_told_honestly():
    """Also where it is not ours, and not where the difference is that of a busy machine."""
    runs = report(
        ComparedMethod("closed form", lambda problem, value: (sum(range(10**6)), lambda: EXACT)[1], is_ours=True),
        ComparedMethod("stepper", off_by(1e-7)),
    )
    assert fastest(runs.answers, 1e-6, one_run).method.name == "stepper"
    assert fastest(runs.answers, 1e-20, one_run) is None
    told = {error: one for error, one, _ in runs.fastest}
    assert told[1e-6].startswith("stepper (") and "times as fast as closed form (" in told[1e-6]
    assert told[1e-9].startswith("only closed form")
