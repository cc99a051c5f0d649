"""States, motors and models that pinocchio reads."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import mbconstrained as mb
from tests.robot.linkages import GROUND, bar, joint, urdf

TEXT = urdf(
    GROUND,
    bar("crank", 0.5, 0.2),
    bar("coupler", 0.4, 0.5),
    joint("j1", "frame", "crank"),
    joint("j2", "crank", "coupler", at=(0.2, 0, 0)),
)

MJCF = """<mujoco model="ball"><worldbody><body name="base"><body name="bob" pos="0 0 0">
<joint name="ball" type="ball"/><inertial pos="0 0 -0.5" mass="2" diaginertia="0.03 0.04 0.01"/></body></body></worldbody></mujoco>"""


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_a_model_is_the_robot_of_its_urdf(base):
    root = (pin.JointModelFreeFlyer(),) if base == "free" else ()
    model = pin.buildModelFromXML(TEXT, *root)
    model.gravity.linear = np.array([0.0, -9.81, 0.0])
    loops = [mb.Loop("coupler", (0.5, 0, 0), "ground", kind="point" if base == "fixed" else "rigid")]
    options = {"joint_stiffness": {"j1": 20.0, "j2": 5.0}, "motors": {"j1": mb.Motor(armature=0.1)}}
    guess = {"j1": 1.2, "j2": -0.8}
    ours = mb.Robot(model, loops=loops, **options)
    other = mb.Robot(TEXT, base=base, gravity=(0, -9.81, 0), loops=loops, **options)
    assert (ours.joints, ours.bodies, ours.coordinates, ours.units) == (other.joints, other.bodies, other.coordinates, other.units)
    systems = [robot.linearize(robot.equilibrium(guess)) for robot in (ours, other)]
    for matrix in ("mass", "damping", "stiffness", "constraint_matrix"):
        assert np.array_equal(*(getattr(system, matrix) for system in systems))
    assert not model.armature.any()  # the given model stays as it is


def test_a_ball_joint_of_an_mjcf_swings_about_both_axes(tmp_path):
    (tmp_path / "ball.xml").write_text(MJCF)
    robot = mb.Robot(pin.buildModelFromMJCF(str(tmp_path / "ball.xml")))
    assert robot.coordinates == ("ball rx", "ball ry", "ball rz") and set(robot.units) == {"rad"}
    posture = robot.equilibrium({"ball": (0.0, 0.0, 0.4)}, hold=["ball rz"])
    known = np.sqrt(np.array([2 * 9.81 * 0.5 / (inertia + 2 * 0.25) for inertia in (0.04, 0.03)]))
    assert robot.linearize(posture).modes().natural_frequencies == pytest.approx(known, rel=1e-9)
    tilted = robot.equilibrium({"ball": (0.3, 0.0, 0.0)}, hold=robot.coordinates)
    assert tilted.torques["ball rx"] == pytest.approx(2 * 9.81 * 0.5 * np.sin(0.3), rel=1e-12)


def test_a_model_without_a_link_on_the_ground():
    """A physical pendulum whose only body hangs in the world: omega^2 = m g l / (I + m l^2)."""
    model = pin.Model()
    number = model.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "hinge")
    model.appendBodyToJoint(number, pin.Inertia(2.0, np.array([0, 0, -0.5]), np.diag([0.03, 0.04, 0.01])), pin.SE3.Identity())
    model.addFrame(pin.Frame("bob", number, 0, pin.SE3.Identity(), pin.FrameType.BODY))
    robot = mb.Robot(model)
    (frequency,) = robot.linearize(robot.equilibrium()).modes().natural_frequencies
    assert frequency == pytest.approx(np.sqrt(2 * 9.81 * 0.5 / (0.04 + 2 * 0.25)), rel=1e-12)


def test_what_a_model_cannot_have():
    model = pin.Model()
    number = model.addJoint(0, pin.JointModelUniversal(np.array([1.0, 0, 0]), np.array([0, 1.0, 0])), pin.SE3.Identity(), "cross")
    model.appendBodyToJoint(number, pin.Inertia.Random(), pin.SE3.Identity())
    with pytest.raises(mb.InputError, match=r"no body.*model.addBodyFrame"):
        mb.Robot(model)
    model.addBodyFrame("bob", number, pin.SE3.Identity(), 0)
    with pytest.raises(mb.InputError, match='the joint "cross" is a Universal'):
        mb.Robot(model)
    with pytest.raises(mb.InputError, match="masses, inertias: found them with a pinocchio model"):
        mb.Robot(pin.buildModelFromXML(TEXT), masses={"crank": 1.0})


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
