"""Motions with events: every compared method against the closed form of a bouncing ball, and the report of a scene."""

import numpy as np
import pytest

from mbconstrained.analyses.accuracy.accuracy import Accuracy, AccuracySettings, accuracy_report
from mbconstrained.analyses.accuracy.measure import reference_solution
from mbconstrained.analyses.accuracy.methods import SWITCHED_METHODS, ComparedMethod, MethodSetting
from mbconstrained.analyses.study_problem import problem_of
from tests.scene.scenes import scene_of

DROP = """
[model]
kind = "lumped"
gravity = -9.81
[[model.mass]]
name = "ball"
mass = "2 kg"
[[model.contact]]
start = "ground"
end = "ball"
restitution = 0.7
[initial]
displacement = { ball = "1 m" }
[time]
end = "2 s"
points = 101
"""

FRICTION = """
[model]
kind = "lumped"
[[model.mass]]
name = "block"
mass = 1.0
[[model.spring]]
start = "ground"
end = "block"
stiffness = 100.0
[[model.dry_friction]]
start = "ground"
end = "block"
normal_force = 10.0
coefficient = 0.3
[initial]
displacement = { block = 0.2 }
[time]
end = "1 s"
points = 11
"""


def ball(times: np.ndarray) -> np.ndarray:
    """Parabolas between the bounces at t_0 + 2 t_0 (e + e^2 + ...)."""
    g, e = 9.81, 0.7
    fall = np.sqrt(2 / g)
    bounces = fall + 2 * fall * np.concatenate([[0.0], np.cumsum(e ** np.arange(1, 40))])
    place = np.searchsorted(bounces, times, side="right") - 1
    since = np.where(place < 0, times, times - bounces[np.maximum(place, 0)])
    speed = g * fall * e ** (place + 1)
    return np.where(place < 0, 1 - g * since**2 / 2, speed * since - g * since**2 / 2)


@pytest.fixture
def problem(tmp_path):
    return problem_of(scene_of(tmp_path, DROP))


def errors_of(method: ComparedMethod, problem) -> list[float]:
    return [
        float(np.abs(method.prepare(problem, setting.value)()[0] - ball(problem.times)).max())
        for setting in method.settings_for(problem)
    ]


def named(name: str) -> ComparedMethod:
    return next(method for method in SWITCHED_METHODS if method.name == name)


def test_the_reference_is_the_motion_of_the_ball(problem):
    reference = reference_solution(problem)
    assert np.abs(reference.values[0] - ball(problem.times[reference.places])).max() < 1e-13
    assert reference.error_bound < 1e-11 and "agrees to" in reference.source
    assert reference.error(ball(problem.times)[None]) == reference.error_bound


@pytest.mark.parametrize("name", ["solve_ivp DOP853 with events", "solve_ivp RK45 with events"])
def test_integration_converges_to_the_ball(problem, name):
    assert max(errors_of(named(name), problem)) < 1e-6  # parabolas are exact for these methods: the events count


def test_moreaus_time_stepping_is_of_first_order(problem):
    coarse, fine, _ = errors_of(named("Moreau's time stepping"), problem)
    assert 4 < coarse / fine < 25 and fine < 5e-3


def test_moreaus_time_stepping_is_for_plain_contacts_only(tmp_path):
    problem = problem_of(scene_of(tmp_path, FRICTION))
    assert "rigid contacts" in named("Moreau's time stepping").refusal(problem)


def test_friction_is_integrated_to_its_tolerance(tmp_path):
    problem = problem_of(scene_of(tmp_path, FRICTION))
    reference = reference_solution(problem)
    method = named("solve_ivp DOP853 with events")
    errors = [reference.error(method.prepare(problem, rtol)()) for rtol in (1e-4, 1e-8, 1e-12)]
    assert errors[0] > 10 * errors[1] > 100 * errors[2] and errors[2] < 1e-10


def test_the_report_of_a_scene_has_all_methods(tmp_path):
    answer = Accuracy.solve(scene_of(tmp_path, DROP), AccuracySettings(seconds=0.5))
    assert {run["method"] for run in answer.data["runs"]} == {method.name for method in SWITCHED_METHODS}
    assert answer.data["runs"][0]["error"] == answer.data["reference_error"] < 1e-11
    assert not any(notice.doubtful for notice in answer.notices)


def test_a_failed_integration_is_reported(problem):
    def lost(problem, value):
        return lambda: np.full((1, len(problem.times)), np.nan)

    methods = (SWITCHED_METHODS[0], ComparedMethod("lost", lost, (MethodSetting("", 1.0),)))
    report = accuracy_report(problem, methods, seconds=1.0)
    assert [run.failure for run in report.failures] == ["gives no numbers"]
