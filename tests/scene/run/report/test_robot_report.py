"""The tables of a posture: units and angles of every kind of joint, rounding as 0 in texts and as it is in JSON."""

import math
from types import SimpleNamespace

import pytest

from mbconstrained.scene.build.robot_model import posture_json, posture_tables
from tests.scene.robots import SCENE, TOML, URDF, press
from tests.scene.scenes import scene_of


def with_posture(found, **changes):
    """The robot's scene with numbers of its posture that are made up."""
    posture = found.posture
    kept = {
        key: getattr(posture, key)
        for key in ("joints", "torques", "reactions", "ground_reactions", "residual", "loop_error", "balance")
    }
    return SimpleNamespace(data=found.data, robot=found.robot, posture=SimpleNamespace(**{**kept, **changes}))


@pytest.fixture
def found(tmp_path):
    press(tmp_path)
    return scene_of(tmp_path, SCENE).equations.robot_scene


@pytest.mark.parametrize(
    ("torque", "text"),
    [(-2.22045e-16, "0 N m"), (0.0, "0 N m"), (-1e-9, "-1e-09 N m"), (2.5, "2.5 N m")],
    ids=["rounding", "0", "small", "usual"],
)
def test_a_torque_that_is_rounding_is_printed_as_0_and_stays_in_json(found, torque, text):
    made_up = with_posture(found, torques={"pivot": torque})
    assert posture_tables(made_up)[0].rows[0][2] == text
    assert posture_json(made_up)["posture"]["torques"] == {"pivot": torque}


def test_a_planar_joint_has_units_and_an_angle(tmp_path):
    old = URDF[URDF.index('<joint name="slide"') : URDF.index("</robot>")]
    planar = '<joint name="slide" type="planar"><parent link="base"/><child link="ram"/><axis xyz="0 0 1"/></joint>\n'
    toml = (
        TOML.replace(', slide = "3 N/mm"', "")
        .replace(", slide = 0", "")
        .replace(', slide = "4 N*s/m"', "")
        .replace(', slide = "2 cm"', "")
    )
    assert "slide" not in toml
    press(tmp_path, toml, URDF.replace(old, planar))
    scene = scene_of(tmp_path, SCENE.replace('displacement = { pivot = "1 deg" }', ""))
    found = scene.equations.robot_scene
    value = found.posture.joints["slide"]
    assert len(value) == 3
    made_up = with_posture(found, joints={"slide": (0.1, -1e-17, math.pi / 6)})
    assert posture_tables(made_up)[0].rows == (("slide", "(0.1, 0) m, 0.523599 rad (30°)"),)
