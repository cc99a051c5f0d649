"""Robots from models of pinocchio: the same as from the URDF of the model, MJCF with a ball joint, and what is refused."""

from __future__ import annotations

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
