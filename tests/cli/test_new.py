"""Templates of scenes: each is right, runs, moves or plots something, and explains each of its lines."""

import re

import pytest

from mbconstrained.cli.new import COMPANIONS, template_names, template_text, write_template
from mbconstrained.ground.errors import InputError
from mbconstrained.scene.run.scene import read_scene


@pytest.mark.parametrize("name", [*template_names(), "pendulum.robot"])
def test_every_line_says_what_it_is(name):
    text = template_text(name) if name in template_names() else (_folder() / f"{name}.toml").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line.strip()]
    assert lines[0].startswith("# ") and lines[0].endswith(".")
    assert [line for line in lines if not re.search(r"(^| )# \S", line)] == []
    assert max(map(len, lines)) <= 132


@pytest.mark.parametrize("name", template_names())
def test_each_is_right_and_runs(tmp_path, name):
    write_template(tmp_path / "own.toml", name)
    scene = read_scene(tmp_path / "own.toml")
    result = scene.run(tmp_path / "out")
    assert result.is_trusted and (tmp_path / "out" / "own.html").stat().st_size > 20_000
    assert (result.values.max(axis=1) - result.values.min(axis=1) > 0).all()  # everything moves


@pytest.mark.long
def test_the_name_of_the_file_chooses_and_nothing_is_overwritten(command, tmp_path):
    code, out, err = command("new", "transfer_function")
    assert (code, err) == (0, "") and "transfer_function.toml is written from the template transfer-function. Next:" in out
    assert "mbconstrained run transfer_function.toml" in out
    assert "from the template two-masses" in command("new", "bridge.toml")[1]
    before = (tmp_path / "bridge.toml").read_text()
    code, out, err = command("new", "bridge.toml", "--template", "gears")
    assert (code, out) == (2, "") and "bridge.toml: there is such a file already, and it is left as it is" in err
    assert (tmp_path / "bridge.toml").read_text() == before


@pytest.mark.long
def test_a_robot_comes_with_its_files_or_not_at_all(command, tmp_path):
    (tmp_path / "arm.urdf").write_text("mine")
    assert command("new", "arm.toml", "--template", "robot")[0] == 2
    assert [path.name for path in tmp_path.iterdir()] == ["arm.urdf"]
    out = command("new", "my arm", "--template", "robot")[1]
    assert "my arm.toml, my arm.robot.toml, my arm.urdf are written" in out and 'run "my arm.toml"' in out
    assert len(COMPANIONS["robot"]) == 2 and command("check", "my arm.toml")[0] == 0


@pytest.mark.long
def test_what_is_wrong_is_told(command):
    assert command("new")[0] == 2
    code, _, err = command("new", "a.toml", "--template", "gaers")
    assert code == 1 and 'there is no template "gaers"; did you mean "gears"?; there are two-masses' in err
    code, _, err = command("new", "no/folder/a.toml")
    assert code == 2 and "cannot be written: no/folder: there is no such folder; make it first" in err
    with pytest.raises(InputError, match="expected one without quotes and backslashes"):
        write_template(_folder() / 'a"b.toml')


@pytest.mark.long
def test_scenes_beside_a_schema_point_to_it(command, tmp_path):
    assert "#:schema ./mbconstrained.schema.json" in command("schema", "--out", "mbconstrained.schema.json")[1]
    command("new", "gears")
    assert (tmp_path / "gears.toml").read_text().startswith("#:schema ./mbconstrained.schema.json\n# A motor")
    assert command("check", "gears.toml")[0] == 0
    assert "uses it for a\nrobot.toml in the same folder" in command("schema", "--robot", "--out", "robot.schema.json")[1]
    command("new", "arm.toml", "--template", "robot")
    assert (tmp_path / "arm.robot.toml").read_text().startswith("#:schema ./robot.schema.json\n")
    assert not (tmp_path / "arm.urdf").read_text().startswith("#") and command("check", "arm.toml")[0] == 0


def _folder():
    from mbconstrained.cli import new as templates

    return templates._FOLDER
