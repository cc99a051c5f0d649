"""Pictures of a run for reports: plots as SVG and PNG, a still picture of the model, asked for by a scene or by options."""

import pytest
from typer.testing import CliRunner

from mbconstrained.cli.commands import app
from mbconstrained.ground.errors import InputError, MbconstrainedError, SceneError
from mbconstrained.page import photograph
from tests.page.browser import needs_chromium
from tests.scene.scenes import MATRICES, OSCILLATOR, scene_of

PLOTS = '[output]\nplots = ["displacement", "velocity"]\npage = false\ncsv = false\nnpz = false\n'
FILES = "scene.displacement.png", "scene.displacement.svg", "scene.velocity.png", "scene.velocity.svg"


def call(*arguments):
    return CliRunner().invoke(app, list(map(str, arguments)))


def stages(scene) -> dict:
    return {stage.name: stage for stage in scene.plan().stages}


def test_plots_are_written_as_svg_and_png(tmp_path):
    result = scene_of(tmp_path, MATRICES + PLOTS + "plot_images = true\n").run(tmp_path / "out")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(FILES)
    assert [path.name for path in result.files] == [
        "scene.displacement.svg",
        "scene.displacement.png",
        "scene.velocity.svg",
        "scene.velocity.png",
    ]
    assert (tmp_path / "out" / "scene.velocity.png").read_bytes()[1:4] == b"PNG"


@pytest.mark.long
@needs_chromium
def test_the_options_write_both(tmp_path):
    path = scene_of(tmp_path, OSCILLATOR + "[output]\npage = false\n").path
    done = call("run", path, "--plots", "--still", "1250 ms", "--out", tmp_path / "out")
    assert done.exit_code == 0 and "scene.still.png" in done.output
    names = {file.name for file in (tmp_path / "out").iterdir()}
    assert names == {"scene.csv", "scene.npz", "scene.displacement.png", "scene.displacement.svg", "scene.still.png"}
    assert (tmp_path / "out" / "scene.still.png").read_bytes()[1:4] == b"PNG"


@pytest.mark.parametrize(
    ("still", "code", "message"),
    [
        ("6 s", 1, "scene.toml: still picture: found 6 s; expected a time from 0 to 5 s"),
        ("3 kg", 2, 'found "3 kg", a mass; expected a time'),
        ("soon", 2, 'found "soon"; expected a time'),
    ],
)
def test_a_time_that_is_none_of_the_scene_is_said(tmp_path, still, code, message):
    done = call("run", scene_of(tmp_path, OSCILLATOR).path, "--still", still, "--out", tmp_path / "out")
    assert done.exit_code == code and message in " ".join(done.output.split()) and not (tmp_path / "out").exists()
    with pytest.raises(SceneError, match=r"output\.still is 6 s; expected a time from 0 to time\.end, which is 5 s"):
        scene_of(tmp_path, OSCILLATOR + "[output]\nstill = 6\n")


def test_without_a_browser_the_option_is_refused_and_a_scene_that_asks_runs_without(tmp_path, monkeypatch):
    monkeypatch.setattr(photograph, "BROWSERS", ("no-such-browser",))
    scene = scene_of(tmp_path, OSCILLATOR + '[output]\nstill = "1 s"\npage = false\n')
    assert "no Chromium or Chrome is installed" in stages(scene)["still picture (Chromium)"].reason
    result = scene.run(tmp_path / "out")
    assert "still picture: left out: no Chromium or Chrome is installed" in result.summary()
    assert {path.name for path in result.files} == {"scene.csv", "scene.npz"}
    done = call("run", scene.path, "--still", "1s")
    assert done.exit_code == 2 and "no Chromium or Chrome is installed" in done.output
    with pytest.raises(MbconstrainedError, match="install one"):
        result.write_still(tmp_path / "x.png", 1.0)


def test_a_browser_that_fails_costs_the_picture_and_nothing_else(tmp_path, monkeypatch):
    program = tmp_path / "browser"
    program.write_text("#!/bin/sh\necho broken >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setattr(photograph, "BROWSERS", (str(program),))
    result = scene_of(tmp_path, OSCILLATOR + '[output]\nstill = "1 s"\npage = false\n').run(tmp_path / "out")
    assert [notice.text for notice in result.notices if notice.kind == "omitted"] == ["still picture: browser failed: broken"]
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"scene.csv", "scene.npz"}
    with pytest.raises(InputError, match="expected a time from 0 to 5 s"):
        result.write_still(tmp_path / "x.png", 7.0)
