"""Scenes whose equations leave a coordinate free or are redundant: check and run report it, [[motion]] chooses."""

import re

import numpy as np
import pytest

import mbconstrained as mb
from tests.scene.scenes import EXAMPLES, scene_of

EXAMPLE = (EXAMPLES / "chosen_gripper.toml").read_text("utf-8")
MOTION = EXAMPLE[EXAMPLE.index("[[motion]]\n") : EXAMPLE.index("[initial]")]
CONTRADICTION = '\n[[force]]\ncoordinate = "gauge"\nkind = "step"\nvalue = 0.3\ndelay = "1 s"\n'


def test_without_a_choice_check_and_run_report_the_free_coordinates(tmp_path, command):
    path = tmp_path / "scene.toml"
    path.write_text(EXAMPLE.replace(MOTION, ""), encoding="utf-8")
    for name in ("check", "run"):
        code, _, error = command(name, path)
        assert code == 1
        assert 'leave 1 coordinate free. Choose its motion by [[motion]] with coordinate = "arm"' in error
        assert '2 "tool" - "gauge": satisfied' in error


def test_contradictory_rows_are_refused_with_size_and_time(tmp_path):
    with pytest.raises(mb.NotSolvable, match='2 "tool" - "gauge": .* is -0.3 from t = 1 s on'):
        scene_of(tmp_path, EXAMPLE + CONTRADICTION)


def test_consistent_rows_run_with_a_notice(tmp_path):
    """Twice the force of the row that is doubled: 2 t - x - g = 0.3, and the tool is moved by 0.15."""
    both = CONTRADICTION + CONTRADICTION.replace("gauge", "tool").replace("0.3", "0.15")
    scene = scene_of(tmp_path, EXAMPLE + both)
    assert [notice.text for notice in scene.notices if notice.kind == mb.NoticeKind.REDUNDANT] == [
        '"gauge" follows from the others and is left out: 2 "tool" - "gauge" leaves no coordinate and no force'
    ]
    x = scene.run().motion
    t = np.array([0.5, 2.0, 5.0])
    arm, gripper, tool = x(t)
    np.testing.assert_allclose(tool, (arm + gripper) / 2 + 0.15 * (t > 1), atol=1e-14)
    np.testing.assert_allclose(gripper, [0.05, 0.1, 0.0], atol=1e-15)


@pytest.mark.parametrize(
    "old, new, text",
    [
        ('coordinate = "gripper"', 'coordinate = "griper"', 'motion[1]: there is no coordinate "griper"; did you'),
        ('kind = "sampled"', 'level = "velocity"\nkind = "sampled"', 'chosen once, at the level "position"; found'),
        (MOTION, MOTION + MOTION, "found a second one"),
        (MOTION, MOTION + MOTION.replace("gripper", "arm"), "1 coordinate may be chosen"),
        ("[output]", '[frequency]\nfrom = "1 Hz"\nto = "5 Hz"\n[output]', "frequency: the equations are no regular"),
        ('end = "6 s"', 'end = "6 s"\nstep_domain = "discrete"\nstep = "1 s"', "in discrete time coefficients must"),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path, old, new, text):
    with pytest.raises(mb.SceneError, match=re.escape(text)):
        scene_of(tmp_path, EXAMPLE.replace(old, new))


@pytest.mark.parametrize("name", ["modes", "random"])
def test_modes_and_spectra_are_refused_by_name(tmp_path, name):
    with pytest.raises(mb.InputError, match=f"{name}: the equations are no regular system"):
        getattr(scene_of(tmp_path, EXAMPLE), name)()


def test_a_mechanical_system_names_the_coordinates_that_may_be_prescribed(tmp_path):
    text = '[model]\nkind = "matrices"\ncoordinates = ["a", "b"]\nmass = [[1, 0], [0, 0]]\n[time]\nend = 1\n'
    with pytest.raises(mb.SingularPolynomialMatrix, match='(?s)det A.*\\[\\[motion\\]\\] with coordinate = "b"'):
        scene_of(tmp_path, text)
    scene_of(tmp_path, text + '[[motion]]\ncoordinate = "b"\nkind = "ramp"\nvalue = 1\n')
