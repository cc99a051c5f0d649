"""Scenes of robots with joint stops, contacts, feet that lift off and loops that close: tables, answers and errors."""

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from tests.scene.scenes import scene_of

URDF = """<robot name="two"><link name="base"/>
<link name="hand"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="part"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="reach" type="prismatic"><parent link="base"/><child link="hand"/><axis xyz="1 0 0"/>
<limit lower="-0.5" upper="0.5" effort="1" velocity="1"/></joint>
<joint name="slide" type="prismatic"><parent link="base"/><child link="part"/><axis xyz="1 0 0"/>
<limit lower="-0.5" upper="0.5" effort="1" velocity="1"/></joint></robot>
"""

HEAD = """
[model]
kind = "robot"
robot = "two"
"""

TAIL = """
[initial]
velocity = { reach = "0.1 m/s" }
[time]
end = "1 s"
points = 11
[output]
plots = ["displacement", "reaction"]
"""


def scene_with(tmp_path, tables: str, robot: str = ""):
    (tmp_path / "two").mkdir(exist_ok=True)
    (tmp_path / "two" / "two.urdf").write_text(URDF)
    (tmp_path / "two" / "robot.toml").write_text(f'urdf = "two.urdf"\n{robot}')
    return scene_of(tmp_path, HEAD + tables + TAIL)


def test_a_joint_stop_strikes_at_its_value(tmp_path):
    tables = '[[model.joint_stop]]\njoint = "reach"\nupper = "50 mm"\nrestitution = 0.5\n'
    result = scene_with(tmp_path, tables).run(tmp_path)
    (event,) = result.to_dict()["events"]
    assert event["time"] == pytest.approx(0.5, rel=1e-14)
    assert event["impulses"] == {"reach stop": pytest.approx(2 * 1.5 * 0.1, rel=1e-13)}
    assert result.values[0, -1] == pytest.approx(0.05 - 0.05 * 0.5, rel=1e-13)


def test_a_grasp_at_a_gap_and_its_release(tmp_path):
    tables = (
        '[[model.closing_loop]]\nname = "grip"\nbody1 = "part"\nbody2 = "hand"\npoint2 = [0, 0, 0]\nnormal = [-1, 0, 0]\n'
        'gap = "20 mm"\nreleased = "0.7 s"\n'
    )
    result = scene_with(tmp_path, tables).run(tmp_path)
    events = result.to_dict()["events"]
    assert [event["time"] for event in events] == pytest.approx([0.2, 0.7], rel=1e-13)
    assert abs(events[0]["impulses"]["grip x"]) == pytest.approx(0.1 * 2 / 3, rel=1e-13)
    assert result.values[1, -1] == pytest.approx(0.8 * 0.2 / 3, rel=1e-12)


def test_a_contact_between_two_bodies_shares_the_momentum(tmp_path):
    tables = (
        '[[model.contact]]\nname = "bump"\nbody = "hand"\nother = "part"\nnormal = [-1, 0, 0]\ngap = "20 mm"\nrestitution = 1.0\n'
    )
    result = scene_with(tmp_path, tables).run(tmp_path)
    (event,) = result.to_dict()["events"]
    assert event["jump"][1] == pytest.approx([-0.1 * 2 / 3, 0.1 * 4 / 3], rel=1e-13)
    assert any("small about the posture" in notice.text for notice in result.notices)


def test_a_loop_of_the_robot_is_released(tmp_path):
    loop = '[[loop]]\nname = "latch"\nbody1 = "hand"\nbody2 = "part"\npoint2 = [0, 0, 0]\n'
    tables = '[[model.release]]\ntarget = "latch"\nat = "0.5 s"\n[[model.joint_stop]]\njoint = "slide"\nupper = "0.4"\n'
    scene = scene_with(tmp_path, tables.replace('"0.4"', "0.4"), loop)
    result = scene.run(tmp_path)
    assert result.values[:, -1] == pytest.approx([0.1 * 2 / 3] * 2, rel=1e-12)
    assert [event["time"] for event in result.to_dict()["events"] if event["time"] > 0] == [0.5]


@pytest.mark.parametrize(
    ("tables", "text"),
    [
        ('[[model.joint_stop]]\njoint = "reech"\n', 'did you mean "reach"'),
        ('[[model.joint_stop]]\njoint = "reach"\nlower = "3 deg"\n', "joint stop"),
        ('[[model.contact]]\nbody = "hond"\n', "model.contact[1]"),
        ('[[model.lifting_foot]]\nloop = "foot"\n', 'there is no loop "foot"'),
        ('[[model.closing_loop]]\nbody1 = "hand"\nbody2 = "part"\npoint2 = [0, 0, 0]\n', "expected a time at, or a gap"),
    ],
)
def test_errors_name_the_place(tmp_path, tables, text):
    with pytest.raises(SceneError) as caught:
        _ = scene_with(tmp_path, tables).equations
    assert text in str(caught.value) and "scene.toml" in str(caught.value)


def test_linear_analyses_answer_for_the_named_phase(tmp_path):
    tables = 'linear_phase = "closed"\n[[model.joint_stop]]\njoint = "reach"\nupper = "50 mm"\n'
    scene = scene_with(tmp_path, tables)
    assert [row.name for row in scene.equations.system.rows] == ["reach stop"]
    assert np.allclose(scene.equations.system.modes().eigenvalues, 0.0)
