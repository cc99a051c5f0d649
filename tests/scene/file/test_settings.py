"""Values set from outside, by --set or from Python: what they change, where they are told, what is wrong with them."""

import json

import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.scene.file import value_of
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import OSCILLATOR, scene_of

TEXT = '[parameters]\nk = "8 N/m"\nx0 = 0.1\n' + OSCILLATOR.replace('"8 N/m"', '"=k"').replace("cart = 0.1", 'cart = "=x0"')


@pytest.fixture
def scene(tmp_path):
    """Read the scene with these values set."""
    scene_of(tmp_path, TEXT)
    return lambda settings: read_scene(tmp_path / "scene.toml", settings)


@pytest.mark.parametrize(
    ("settings", "stiffness", "told"),
    [
        ({"k": "2 N/mm"}, 2000.0, "k = 2 N/mm, instead of 8 N/m in the file"),
        ({"k": 32}, 32.0, "k = 32 N/m, instead of 8 N/m in the file"),
        ({"k": "=80*x0"}, 8.0, "k = =80*x0, instead of 8 N/m in the file"),
        ({"x0": "20 cm"}, 8.0, "x0 = 20 cm, instead of 0.1 in the file"),
        ({"model.mass.cart.mass": "3 kg"}, 8.0, "model.mass.cart.mass = 3 kg, instead of 2 kg in the file"),
        ({"model.spring[1].stiffness": 5.0}, 5.0, "model.spring[1].stiffness = 5.0, instead of =k in the file"),
        ({"output.page": False}, 8.0, "output.page = false, which the file leaves out"),
        ({"title": "Set"}, 8.0, "title = Set, which the file leaves out"),
    ],
)
def test_what_is_set_is_taken_and_told(scene, settings, stiffness, told):
    found = scene(settings)
    assert found.equations.system.stiffness[0, 0] == pytest.approx(stiffness)
    assert found.notices[0].kind == "override" and found.notices[0].text == told


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"kk": 3}, '^--set: kk: there is no such parameter; did you mean "k"?; there are k, x0; give one of [parameters], or a'),
        ({"k": "3 kg"}, '^--set: k: found "3 kg", a mass; expected a stiffness, as "8 N/m" in the file'),
        ({"k": "3 fox"}, '--set: k: found "3 fox", but there is no unit "fox"'),
        ({"k": "1,5 N/m"}, 'decimals have a point: "1.5 N/m"'),
        ({"k": "=2*n"}, '--set: parameters.k: found "=2*n", but there is no parameter "n"'),
        ({"time.end": "5 m"}, '--set: time.end: found "5 m", a length; expected a time'),
        ({"time.points": 1}, "--set: time.points: found 1; expected at least 2"),
        ({"time.end.x": 1}, '--set: time.end.x: time.end is "5 s", which has no parts'),
        ({"outpt.page": False}, '--set: the file: unknown key "outpt"; did you mean "output"'),
        ({"output.pge": False}, '--set: output: unknown key "pge"; did you mean "page"'),
        ({"model.mass.crat.mass": 3}, 'model.mass has no entry "crat"; did you mean "cart"?; there are cart'),
        ({"model.mass[2].mass": 3}, "model.mass has no entry 2; there are cart"),
        ({"model.spring.1.stiffness": 3}, 'model.spring has no entry "1"; there are 1, the first is model.spring[1]'),
        ({"drawing.body[1].along": [0, 0, 1]}, "--set: drawing.body[1].along: the scene has no [[drawing.body]], so no entry 1"),
        ({"k": "1e400 N/m"}, '--set: k: found "1e400 N/m"; expected a finite number'),
        ({"time[1]": 3}, "time is a table, which has no entry 1; give a key"),
        ({"k": "-2 N/m"}, "found -2; expected a number greater than zero (with --set k)"),
        ({"model.mass.cart.mass": -1}, "found -1; expected a number greater than zero (with --set model.mass.cart.mass)"),
        ({"time.end": -1}, "time: end is -1 s; expected a time after 0 (with --set time.end)"),
        ({"model.mass[1].mass": "3 N"}, '--set: model.mass[1].mass (of "cart"): found "3 N", a force; expected a mass'),
    ],
)
def test_what_is_wrong_with_it_names_the_option(scene, settings, message):
    with pytest.raises(SceneError) as caught:
        scene(settings)
    assert message.removeprefix("^") in str(caught.value) and "--set" in str(caught.value)


def test_a_parameter_of_a_parameter_is_named_too_and_no_other(tmp_path):
    scene_of(tmp_path, TEXT.replace("x0 = 0.1", 'x0 = 0.1\nk2 = "=2*k"').replace('"=k"', '"=k2"'))
    with pytest.raises(SceneError, match=r"found -4; expected a number greater than zero \(with --set k\)$"):
        read_scene(tmp_path / "scene.toml", {"x0": 0.2, "k": -2, "title": "t"})


def test_a_scene_without_parameters_says_so(tmp_path):
    scene_of(tmp_path, OSCILLATOR)
    with pytest.raises(SceneError, match="--set: k: there is no such parameter: the scene has none; give .* e.g. time.end"):
        read_scene(tmp_path / "scene.toml", {"k": 3})


def test_texts_of_the_command_line_become_values():
    texts = ["3", "3e2", "true", "[1, 2]", "3 N/mm", "=2*k", "", "1\nother = 2", "{a = 1}", '"3 N"']
    assert [value_of(text) for text in texts] == [3, 300.0, True, [1, 2], "3 N/mm", "=2*k", "", "1\nother = 2", "{a = 1}", "3 N"]


@pytest.mark.long
def test_every_command_tells_what_was_set(command, tmp_path):
    scene_of(tmp_path, TEXT)
    words = "k = 2 N/mm"
    for arguments in (["check"], ["plan"], ["modes"], ["formula"], ["run"]):
        code, out, err = command(*arguments, "scene.toml", "--set", "k=2 N/mm", "--set", "time.end = 4")
        assert (code, err) == (0, "") and words in out and "time.end = 4" in out, arguments
    assert words in (tmp_path / "results" / "scene" / "scene.k=2_N_mm,time.end=4.html").read_text(encoding="utf-8")
    assert "k=3.0" in command("formula", "scene.toml", "--as", "python", "--set", "k=3")[1]
    code, out, _ = command("run", "scene.toml", "--json", "--set", "k=32")
    data = json.loads(out)
    assert data["eigenvalues"][0]["imaginary"] == pytest.approx(4.0) and "k = 32 N/m" in data["notices"][0]["text"]
    code, out, _ = command("stability", "scene.toml", "--set", "k=32", "--decades", "1", "--step", "1")
    assert code == 0 and "with k = 32 N/m" in out


@pytest.mark.parametrize("text", ["k", "=3", "k="])
def test_what_is_no_setting_is_the_command_line_wrong(command, tmp_path, text):
    scene_of(tmp_path, TEXT)
    code, _, err = command("check", "scene.toml", "--set", text)
    assert code == 2 and f'found "{text}"; expected NAME=VALUE' in err
    assert command("stability", "--set", "k=3")[0] == 2
