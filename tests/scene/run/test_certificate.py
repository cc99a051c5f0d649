"""Proved digits: asked for by the scene or by the command line, on the page, in JSON and in the plan; wrong answers are found."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.scene.run.certificate import Certified
from tests.scene.scenes import EXAMPLES, scene_of

SCENE = """
[model]
kind = "matrices"
coordinates = ["a", "b"]
mass = [[1, 0], [0, 1]]
stiffness = [[4, -1], [-1, 4]]

[initial]
displacement = { a = 1 }

[time]
end = 10
points = 21

[output]
plots = ["displacement", "velocity"]
"""


def scene(tmp_path, extra="", text=SCENE):
    return scene_of(tmp_path, text + extra, "pair.toml")


def test_what_is_not_asked_for_is_not_done(tmp_path):
    result = scene(tmp_path).run()
    assert result.certificate is None
    stage = next(stage for stage in result.plan.stages if stage.name.startswith("certificate"))
    assert not stage.needed and "--certify" in stage.reason


def test_chosen_coordinates(tmp_path):
    assert {c.name for c in scene(tmp_path, 'certify = ["b"]\n').run().certificate.curves} == {"b"}
    assert {c.name for c in scene(tmp_path, 'coordinates = ["a"]\n').certified().run().certificate.curves} == {"a"}
    with pytest.raises(mb.SceneError, match=r"output.certify.*there is no coordinate"):
        scene(tmp_path, 'certify = ["c"]\n')
    with pytest.raises(mb.SceneError, match=r"output.certify: found \"a\"; expected true, false or a list"):
        scene(tmp_path, 'certify = "a"\n')


def test_the_bound_is_that_of_the_values_that_are_written(tmp_path):
    """A wrong digit in the answer is found: the proof does not go through the numeric engine."""
    result = scene(tmp_path, "certify = true\n").run()
    curves = result.curves("displacement")
    values = curves.values.copy()
    values[1, 7] += 1e-2
    result._curves["displacement"] = replace(curves, values=values)
    del result.certificate
    (wrong,) = [c for c in result.certificate.curves if (c.name, c.kind) == ("b", "displacement")]
    assert wrong.bound == pytest.approx(1e-2, rel=1e-9)
    assert not result.is_trusted and any("not proved" in str(notice) for notice in result.notices)


def test_reactions_are_certified_too(tmp_path):
    text = (
        SCENE
        + 'reactions = true\ncertify = true\n[[model.constraint]]\nrows = { a = 1, b = -1 }\nname = "tie"\nlevel = "position"\nvalue = 0.0\n'
    )
    result = scene(tmp_path, text=text).run()
    assert [c.name for c in result.certificate.curves if c.kind == "reaction"] == ["tie"]


def test_data_whose_rounding_decides_a_rank_are_told(tmp_path):
    """A matrix that is singular but for a rounding: the answer has two zeros, the exact data four."""
    turn = np.linalg.qr(np.arange(9.0).reshape(3, 3) + np.eye(3))[0]
    mass = (turn @ np.diag([1.0, 2.0, 0.0]) @ turn.T).tolist()
    stiffness = (turn @ np.diag([1.0, 2.0, 3.0]) @ turn.T).tolist()
    text = f'[model]\nkind = "matrices"\nmass = {mass}\nstiffness = {stiffness}\n[initial]\ndisplacement = {{ x1 = 1 }}\n[time]\nend = 1\npoints = 3\n[output]\ncertify = true\n'
    result = scene(tmp_path, text=text).run()
    told = [str(notice) for notice in result.certificate.notices]
    assert any("taken exactly, the data have" in text or "nothing is certified" in text for text in told)
    assert not result.is_trusted


def test_too_many_states_are_left_out_with_a_reason(tmp_path, monkeypatch):
    monkeypatch.setattr("mbconstrained.scene.run.stages.MOST_CERTIFIED_STATES", 3)
    result = scene(tmp_path, "certify = true\n").run()
    assert result.certificate.curves == () and "takes too long" in result.certificate.notices[0].text
    assert result.is_trusted
    stage = next(stage for stage in result.plan.stages if stage.name.startswith("certificate"))
    assert not stage.needed and "takes too long" in stage.reason


def test_what_takes_too_long_is_broken_off(tmp_path, monkeypatch):
    monkeypatch.setattr("mbconstrained.scene.run.certificate.SECONDS", 1e-4)
    result = scene(tmp_path, "certify = true\n").run(tmp_path)
    assert result.certificate.curves == () and "took more than" in result.certificate.notices[0].text
    assert (tmp_path / "pair.html").exists()


def test_digits_are_rounded_down_and_bounds_up():
    one = Certified("a", "displacement", "m", 1.2341e-9, 1.0, 1.0)
    assert one.digits == "8.9" and one.error_at_most == "1.24e-09 m"
    assert Certified("a", "displacement", "m", 0.0, 0.0, 0.0).digits == "all"
    assert Certified("a", "displacement", "m", 2.0, 1.0, 1.0).digits == "0"


def test_digits_are_relative_to_the_curve_or_where_it_is_rounding_to_the_others():
    """An error of 1e-16 in a value of 1 is 16 digits, beside one of 1e86 too; in a value of 1e-16 beside 1 it is no loss of digits."""
    assert Certified("a", "displacement", "m", 1e-16, 1.0, 1e86).digits == "16"
    assert Certified("a", "displacement", "m", 1e-16, 1e-16, 1.0).digits == "16"


@pytest.mark.long
def test_from_the_command_line(command):
    arguments = ("run", EXAMPLES / "two_masses.toml", "--certify", "--out", "out")
    text = command(*arguments, "--verbose")[1]
    assert "Proved digits" in text and "at 101 of 1001 times" in " ".join(text.split())
    assert "Proved digits" in Path("out/two_masses.html").read_text(encoding="utf-8")
    data = json.loads(command(*arguments, "--json")[1])
    assert [curve["name"] for curve in data["certificate"]["curves"]] == ["x1", "q1", "q2"]
    assert all(curve["error_bound"] < 1e-12 for curve in data["certificate"]["curves"])
