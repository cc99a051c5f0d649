"""[time] with step and start, forces that begin after the end, matrices of no passive structure, springs without rest length."""

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.ground.notices import NoticeKind
from tests.scene.robots import SCENE, TOML, press
from tests.scene.scenes import MATRICES, OSCILLATOR, scene_of

TIME = 'end = "5 s"\npoints = 11'


@pytest.mark.parametrize(
    ("time", "times"),
    [
        ('end = 5\nstep = "500 ms"', np.linspace(0, 5, 11)),
        ("end = 0.3\nstep = 0.1", [0, 0.1, 0.2, 0.3]),
        ("end = 1\nstep = 0.3", [0, 0.3, 0.6, 0.9]),
        ("end = 5\nstart = 4\npoints = 3", [4, 4.5, 5]),
        ("end = 5\nstart = 4\nstep = 0.25", [4, 4.25, 4.5, 4.75, 5]),
    ],
)
def test_times_have_a_step_and_a_start(tmp_path, time, times):
    scene = scene_of(tmp_path, OSCILLATOR.replace(TIME, time))
    result = scene.run()
    assert result.times == pytest.approx(np.array(times), rel=1e-14)
    assert result.values[0] == pytest.approx(0.1 * np.cos(2 * result.times), abs=1e-12)
    assert f"t from {times[0]:g} to {times[-1]:g} s" in result.summary()


@pytest.mark.parametrize(
    ("time", "message"),
    [
        ("end = 5\nstep = 0.1\npoints = 3", "give either step or points"),
        ("end = 5\nstep = 0", "step is 0 s; expected a time from 0 to 5 s"),
        ("end = 5\nstep = 1e-9", "expected at most 200000"),
        ("end = 5\nstart = 5", "start is 5 s; expected a time from 0 to before the end"),
        ("end = 5\nstart = -1", "start is -1 s"),
    ],
)
def test_what_is_no_time_is_refused(tmp_path, time, message):
    with pytest.raises(SceneError, match=message):
        scene_of(tmp_path, OSCILLATOR.replace(TIME, time))


def test_a_force_after_the_end_is_reported(tmp_path):
    force = '\n[[force]]\ncoordinate = "cart"\nkind = "step"\nvalue = 1\ndelay = "{}"\n'
    late = scene_of(tmp_path, OSCILLATOR + force.format("20 s")).notices
    assert any('force[1] on "cart": it begins at 20 s, after the last time, 5 s' in str(notice) for notice in late)
    assert not scene_of(tmp_path, OSCILLATOR + force.format("2 s")).notices


MASS, STIFFNESS = "mass = [[1, 0], [0, 1]]", "stiffness = [[1, 0], [0, 4]]"


@pytest.mark.parametrize(
    ("old", "new", "kind", "text"),
    [
        (MASS, "mass = [[1, 0.5], [0, 1]]", NoticeKind.UNSYMMETRIC, "the mass matrix is not symmetric: entry [1][2] is 0.5"),
        (STIFFNESS, "stiffness = [[1, 0], [3, 4]]", NoticeKind.UNSYMMETRIC, "entry [1][2] is 0, entry [2][1] is 3"),
        (MASS, "mass = [[1, 2], [2, 1]]", NoticeKind.UNSTABLE, "the mass matrix is not positive semidefinite"),
        (MASS, "mass = [[1, 0], [0, -1]]", NoticeKind.UNSTABLE, "the mass matrix is not positive semidefinite"),
    ],
)
def test_matrices_that_no_machine_has_are_reported(tmp_path, old, new, kind, text):
    notices = scene_of(tmp_path, MATRICES.replace(old, new)).notices
    assert any(notice.kind == kind and text in notice.text for notice in notices)


def test_a_spring_without_rest_length_reports_the_length_taken(tmp_path):
    press(tmp_path, TOML.replace('preload = "5 N"\n', ""))
    notices = scene_of(tmp_path, SCENE).equations.posture.notices
    length = np.hypot(0.2 * np.cos(np.radians(5)) - 0.3, 0.2 * np.sin(np.radians(5)) - 0.02)
    assert any(f'spring "tie": it has no rest_length; its length at the guess, {length:.6g} m, is taken' in n.text for n in notices)
