"""SRDF files: group states as guesses, rotors as motors, against what pinocchio reads from the same file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import mbconstrained as mb

URDF = "robots/double_pendulum/double_pendulum.urdf"
SRDF = """<robot name="double_pendulum">
<group name="all"><joint name="shoulder"/></group>
<group_state name="raised" group="all"><joint name="root" value="0 0 1 0 0 0 1"/><joint name="shoulder" value="0.6"/></group_state>
<group_state name="raised" group="other"><joint name="elbow" value="-0.4"/><joint name="no joint of it" value="1"/></group_state>
<rotor_params><joint name="shoulder" mass="2e-4" gear_ratio="100"/><joint name="elbow" mass="1e-4" gear_ratio="0"/></rotor_params>
</robot>"""


@pytest.fixture
def srdf(tmp_path):
    (tmp_path / "arm.srdf").write_text(SRDF)
    return tmp_path / "arm.srdf"


def test_states_and_rotors_are_those_that_pinocchio_reads(srdf):
    robot = mb.Robot(URDF, srdf=srdf, base="free")
    model = pin.buildModelFromUrdf(URDF, pin.JointModelFreeFlyer())
    pin.loadRotorParameters(model, str(srdf))
    assert np.array_equal(robot.model.armature, model.armature) and model.armature.max() == 2.0
    assert robot.states == {"raised": {"base": (0, 0, 1, 0, 0, 0, 1), "shoulder": 0.6, "elbow": -0.4}}


def test_own_motors_and_locked_joints_come_first(srdf):
    assert mb.Robot(URDF, srdf=srdf, motors={"shoulder": mb.Motor(armature=0.3)}).model.armature.tolist() == [0.3, 0.0]
    assert mb.Robot(URDF, srdf=srdf, locked={"shoulder": 0.1}).model.armature.tolist() == [0.0]
    flexible = {"shoulder": mb.FlexibleJoint(stiffness=100.0, motor_inertia=1e-4)}
    assert not mb.Robot(URDF, srdf=srdf, flexible_joints=flexible).model.armature.any()


def test_a_robot_file_and_a_scene_take_states(srdf):
    folder = srdf.parent
    (folder / "arm.urdf").write_text(Path(URDF).read_text())
    (folder / "robot.toml").write_text('urdf = "arm.urdf"\nsrdf = "arm.srdf"\n[posture]\nstate = "raised"\nhold = "all"')
    robot, data = mb.read_robot(folder)
    assert robot.equilibrium(**data.posture).joints == pytest.approx({"shoulder": 0.6, "elbow": -0.4})
    scene = folder / "scene.toml"
    text = '[model]\nkind = "robot"\nrobot = "."\nstate = "{}"\nguess = {{ elbow = "10 deg" }}\n[time]\nend = 1'
    scene.write_text(text.format("raised"))
    posture = mb.read_scene(scene).equations.posture
    assert posture.joints == pytest.approx({"shoulder": 0.6, "elbow": np.radians(10)})
    scene.write_text(text.format("lowered"))
    with pytest.raises(mb.SceneError, match='scene.toml: model: state: there is no "lowered"; there are raised'):
        mb.read_scene(scene)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<robot", "<!DOCTYPE x><robot", "srdf: found a document type"),
        ("</robot>", "", "srdf: not XML"),
        ('value="0.6"', 'value="much"', 'srdf, state "raised", joint "shoulder": found \'much\'; expected a number'),
        ('mass="2e-4"', 'mass="-2e-4"', 'rotor of "shoulder", mass: found -0.0002; expected at least 0'),
        ('mass="2e-4"', 'mass="nan"', 'rotor of "shoulder", mass: found nan'),
    ],
)
def test_what_is_wrong_is_named(srdf, old, new, message):
    srdf.write_text(SRDF.replace(old, new))
    with pytest.raises(mb.InputError, match=message):
        mb.Robot(URDF, srdf=srdf)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(mb.InputError, match="there is no such SRDF file"):
        mb.Robot(URDF, srdf=tmp_path / "arm.srdf")
