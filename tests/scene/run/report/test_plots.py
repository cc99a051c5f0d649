"""What the page of a scene plots."""

import pytest
from typer.testing import CliRunner

from mbconstrained.cli.commands import app
from mbconstrained.scene.run.scene import read_scene

SCENE = """
[model]
kind = "matrices"
coordinates = ["x", "turn", "still"]
units = { turn = "rad" }
mass = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
stiffness = [[1, 0, 0], [0, 4, 0], [0, 0, 1]]
[initial]
displacement = { x = 1, turn = 0.5 }
[time]
end = 10
points = 101
[output]
animation = false
"""


def result(folder, output):
    path = folder / "scene.toml"
    path.write_text(SCENE + output)
    return read_scene(path).run(folder)


def test_a_phase_plane_needs_velocities_and_they_are_written_too(tmp_path):
    found = result(tmp_path, 'plots = ["phase"]')
    stage = next(stage for stage in found.plan.stages if stage.name == "velocities")
    assert (stage.needed, stage.reason) == (True, "phase is among the plots")
    assert found.kinds == ["displacement", "velocity"]
    assert "x velocity (m/s)" in (tmp_path / "scene.csv").read_text().splitlines()[0]


@pytest.mark.parametrize(
    "options, code, files",
    [
        (["--shared-viewer"], 0, {"scene.html", "scene.modes.html", "mbconstrained-viewer.js"}),
        (["--compress"], 0, {"scene.html", "scene.modes.html"}),
        (["--compress", "--shared-viewer"], 2, set()),
    ],
)
def test_the_command_line_says_where_the_viewer_is(tmp_path, options, code, files):
    (tmp_path / "scene.toml").write_text(SCENE.replace("animation = false", "csv = false\nnpz = false"))
    command = [str(tmp_path / "scene.toml"), "--out", str(tmp_path / "out"), *options]
    done = [CliRunner().invoke(app, words) for words in (["run", *command], ["modes", "--page", *command])]
    assert [answer.exit_code for answer in done] == [code, code]
    assert {path.name for path in (tmp_path / "out").glob("*")} == files
    assert code == 0 or "leave out one of the two" in done[0].output
