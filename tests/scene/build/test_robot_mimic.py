"""Scenes of robots with a joint that follows another: plan, evidence, and what is locked with its leader."""

import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.scene.build.robot_file import read_robot
from tests.scene.robots import SCENE, TOML, URDF, press
from tests.scene.scenes import scene_of

MIMIC = URDF.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 1"/><mimic joint="pivot" multiplier="0.1" offset="0.01"/>')
PLAIN = TOML[: TOML.index("[[spring]]")]
POSTURE = '[posture]\nguess = { pivot = "5 deg", slide = "2 cm" }\nforces = { slide = "1 N" }\nhold = ["slide"]\n'

THIRD = """
  <link name="flag">
    <inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
  </link>
  <joint name="mast" type="continuous"><parent link="ram"/><child link="flag"/><axis xyz="0 0 1"/></joint>
</robot>
"""


def following(folder, toml=TOML):
    """The press with a slide that follows the pivot, and a flag on it that is free."""
    return press(folder, toml, MIMIC.replace("</robot>", THIRD))


def test_the_gap_of_a_joint_that_follows_is_evidence(tmp_path):
    following(tmp_path)
    found = scene_of(tmp_path, SCENE.replace("displacement", "follow = true\ndisplacement"))
    assert "equilibrium: loops" in found.run().summary()


@pytest.mark.parametrize("place", ["scene", "file", "argument"])
def test_what_follows_is_locked_with_its_leader_and_forgotten_wherever_it_is_named(tmp_path, place):
    toml = PLAIN + ('locked = { pivot = "0.3 rad" }\n' if place == "file" else "") + POSTURE
    folder = following(tmp_path, toml)
    if place == "argument":
        robot, data = read_robot(folder, locked={"pivot": 0.3})
    else:
        lock = 'locked = { pivot = "0.3 rad" }\n[initial]' if place == "scene" else "[initial]"
        scene = scene_of(tmp_path, SCENE.replace("[initial]", lock).replace('{ pivot = "1 deg" }', "{}"))
        robot, data = scene.equations.robot, scene.equations.robot_scene.data
    assert robot.coordinates == ("mast",)
    assert robot.locked == data.locked == pytest.approx({"pivot": 0.3, "slide": 0.04})
    assert data.posture == {"guess": {}, "forces": {}, "hold": ()}


def test_a_scene_locks_a_leader_elsewhere_than_the_file_and_what_follows_goes_along(tmp_path):
    following(tmp_path, PLAIN + 'locked = { pivot = "0.1 rad" }\n' + POSTURE)
    scene = scene_of(
        tmp_path, SCENE.replace("[initial]", 'locked = { pivot = "0.3 rad" }\n[initial]').replace('{ pivot = "1 deg" }', "{}")
    )
    assert scene.equations.robot.locked == pytest.approx({"pivot": 0.3, "slide": 0.04})


def test_a_follower_locked_alone_is_told_where_it_stands(tmp_path):
    message = 'locked: "slide" follows "pivot", which moves'
    following(tmp_path, PLAIN + "locked = { slide = 0.1 }\n" + POSTURE)
    with pytest.raises(SceneError, match=rf"^press/robot\.toml: .*{message}"):
        scene_of(tmp_path, SCENE)
    following(tmp_path)
    with pytest.raises(SceneError, match=rf"^scene\.toml: model: {message}"):
        scene_of(tmp_path, SCENE.replace("[initial]", "locked = { slide = 0.1 }\n[initial]"))
    with pytest.raises(SceneError, match=rf"^press/robot\.toml: .*{message}"):
        read_robot(tmp_path / "robots" / "press", locked={"slide": 0.1})
