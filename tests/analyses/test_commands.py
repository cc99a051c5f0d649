"""The commands accuracy and stability: what they print, write and return; what they do with what is wrong."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from mbconstrained.analyses.accuracy import methods
from mbconstrained.analyses.accuracy.methods import ComparedMethod, tolerances
from mbconstrained.cli import application

SCENE = """
title = "A cart"
[model]
kind = "lumped"
[[model.mass]]
name = "cart"
mass = 2
[[model.spring]]
name = "spring"
between = ["ground", "cart"]
stiffness = 8
[initial]
displacement = { cart = 1 }
[time]
end = 3
points = 31
"""


@pytest.fixture
def app():
    return application()


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "cart.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def two_methods(monkeypatch):
    """The closed form and one that does not get through: the others are slow, and tested by themselves."""

    def fails(problem, value):
        raise ValueError("refuses singular mass")

    other = ComparedMethod("other", fails, tolerances(6))
    monkeypatch.setattr(methods, "METHODS", (methods.METHODS[0], other))


def run(app, *arguments):
    return CliRunner().invoke(app, list(map(str, arguments)))


def test_accuracy_writes_page_picture_and_data(app, scene, tmp_path, two_methods):
    done = run(app, "accuracy", scene, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert "Error against run time: A cart" in done.stdout and "refuses singular mass" in done.stdout
    files = [tmp_path / "out" / f"cart.accuracy.{ending}" for ending in ("html", "png", "json")]
    assert all(file.is_file() for file in files) and all(str(file) in done.stdout for file in files)
    data = json.loads(files[2].read_text())
    assert data["runs"][0]["error"] < 1e-14 and data["runs"][1]["failure"] == "ValueError: refuses singular mass"
    assert "<svg" in files[0].read_text() and files[1].read_bytes()[1:4] == b"PNG"


def test_an_answer_that_is_wrong_has_exit_code_3(app, scene, tmp_path, monkeypatch):
    wrong = ComparedMethod("closed form", lambda problem, value: lambda: np.zeros((1, len(problem.times))) + 0.9, is_ours=True)
    monkeypatch.setattr(methods, "METHODS", (wrong,))
    assert run(app, "accuracy", scene, "--out", tmp_path).exit_code == 3


def test_stability_of_a_scene(app, scene, tmp_path):
    done = run(app, "stability", scene, "--decades", 4, "--step", 4, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert "None of 9 answers compared with exact arithmetic is wrong without a warning." in " ".join(done.stdout.split())
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {f"cart.stability{ending}" for ending in (".html", ".png", "-2.png", "-3.png", "-4.png", ".json")}


@pytest.mark.long
def test_stability_of_systems_of_the_gallery(app, tmp_path):
    done = run(app, "stability", "--systems", "first_moments, heavy_damper", "--json", "--out", tmp_path)
    data = json.loads(done.stdout)
    assert done.exit_code == 0 and [sweep["name"] for sweep in data["sweeps"]] == ["first_moments", "heavy_damper"]
    assert (tmp_path / "gallery.stability.html").is_file()


def test_an_answer_wrong_without_a_warning_has_exit_code_3(app, scene, tmp_path, monkeypatch):
    """An estimate that lies."""
    from mbconstrained.response.response import Response

    monkeypatch.setattr(Response, "__call__", lambda self, times: self.function(times) * (1 + 1e-9))
    done = run(app, "stability", scene, "--decades", 2, "--step", 2, "--out", tmp_path)
    assert done.exit_code == 3 and "wrong without a warning" in " ".join(done.stdout.split())


def test_an_unknown_system_is_told_with_the_nearest_name(app, tmp_path):
    done = run(app, "stability", "--systems", "heavy_dampr", "--out", tmp_path)
    assert done.exit_code == 1 and '"heavy_damper"' in done.stderr


def test_a_scene_and_systems_together_are_a_wrong_command_line(app, scene):
    assert run(app, "stability", scene, "--systems", "heavy_damper").exit_code == 2
