"""The table [robot] of a scene and --set robot.… change what the robot.toml gives, for this scene."""

import pytest

import mbconstrained as mb
from mbconstrained import SceneError

SCENE = """
[model]
kind = "robot"
robot = "robots/four_bar"
{changes}
[time]
end = "1 s"
"""


def scene(tmp_path, changes: str = "", **settings):
    (tmp_path / "robots").symlink_to(mb.read_scene("examples/four_bar.toml").path.parents[1].absolute() / "robots")
    (tmp_path / "scene.toml").write_text(SCENE.format(changes=changes))
    return mb.read_scene(tmp_path / "scene.toml", {key.replace("_at_", "."): value for key, value in settings.items()})


def frequency(read) -> float:
    return float(read.equations.system.modes().natural_frequencies[0])


def test_changes_are_those_of_the_robot_in_python(tmp_path):
    read = scene(
        tmp_path, '[robot]\njoint_stiffness = { "crank pivot" = "30 N*m/rad" }\n[[robot.payload]]\nbody = "coupler"\nmass = 3'
    )
    original, data = mb.read_robot("robots/four_bar")
    robot = mb.Robot(
        data.names.path,
        loops=original.loops,
        joint_stiffness={"crank pivot": 30.0},
        joint_rest={"crank pivot": original.joint_rest[0]},
        payloads=[mb.Payload("coupler", 3.0)],
    )
    assert frequency(read) == robot.linearize(robot.equilibrium(**data.posture)).modes().natural_frequencies[0]
    assert frequency(read) != frequency(mb.read_scene("examples/four_bar.toml"))


def test_settings_reach_the_file_and_the_changes_of_the_scene(tmp_path):
    read = scene(tmp_path, "[robot]\ngravity = 3", robot_at_gravity=1.62, **{'robot.joint_stiffness."crank pivot"': "25 N*m/rad"})
    assert read.equations.robot.model.gravity.linear[2] == -1.62
    assert read.equations.robot.joint_stiffness[0] == 25.0
    texts = [notice.text for notice in read.notices]
    assert "robot.gravity = 1.62, instead of 3 in the file" in texts
    assert any(text.endswith("= 25 N*m/rad, instead of 20 N*m/rad in the file") for text in texts)


def test_a_parameter_of_the_scene_reaches_the_robot(tmp_path):
    read = scene(tmp_path, '[parameters]\nk = "30 N*m/rad"\n[robot.joint_stiffness]\n"crank pivot" = "=2*k"', k=10)
    assert read.equations.robot.joint_stiffness[0] == 20.0


@pytest.mark.parametrize(
    ("changes", "settings", "message"),
    [
        ('[robot.joint_stiffness]\n"crank pivot" = "3 N"', {}, 'scene.toml: robot.joint_stiffness: crank pivot: found "3 N"'),
        ("[robot]\ngravity = 3", {"robot.gravity": "3 m"}, '--set: robot.gravity: found "3 m"'),
        ("", {"robot.gravty": 3}, '--set: robot: unknown key "gravty"; did you mean "gravity"'),
        ("", {"robot.loop[2].kind": "rod"}, "--set: robot.loop\\[2\\].kind: robot.loop has no entry 2; there are coupler pin"),
        ("[[robot.loop]]\nbody1 = 'crank'", {}, "scene.toml: .*robot.loop\\[1\\]"),
        ("", {'robot.joint_stiffness."crank pivot"': -3}, "four_bar/robot.toml with --set: the robot: joint_stiffness"),
    ],
)
def test_messages_name_the_file_in_which_the_change_stands(tmp_path, changes, settings, message):
    with pytest.raises(SceneError, match=message):
        scene(tmp_path, changes, **settings)


def test_only_a_robot_has_them(tmp_path):
    (tmp_path / "scene.toml").write_text(
        '[model]\nkind = "matrices"\nmass = [[1]]\nstiffness = [[1]]\n[robot]\ngravity = 1\n[time]\nend = 1'
    )
    with pytest.raises(SceneError, match='robot changes the robot.toml of kind = "robot"'):
        mb.read_scene(tmp_path / "scene.toml")
