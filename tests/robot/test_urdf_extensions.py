"""Tags of Drake, Gazebo and Isaac in a URDF, by closed forms of a pendulum (m = 1 kg, 0.5 m, J = 0.01 kg m^2)."""

import numpy as np
import pytest

import mbconstrained as mb

BODY = (
    '<inertial><origin xyz="0 0 -0.5"/><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>'
)
AXIS = '<parent link="base"/><child link="a"/><axis xyz="0 1 0"/>'


def pendulum(extra):
    joint = f'<joint name="j" type="continuous">{AXIS}</joint>'
    return (
        f'<robot name="r" xmlns:drake="http://drake.mit.edu"><link name="base"/><link name="a">{BODY}</link>{joint}{extra}</robot>'
    )


def of(robot):
    return robot.linearize(robot.equilibrium()).modes().natural_frequencies[-1]


@pytest.mark.parametrize("inertia, ratio", [(2.3e-5, 160.0), (1e-4, -100.0), (0.5, 1.0)])
def test_rotors_of_drake_add_their_reflected_inertia(inertia, ratio):
    tags = f'<drake:rotor_inertia value="{inertia}"/><drake:gear_ratio value="{ratio}"/>'
    robot = mb.Robot(pendulum(f'<transmission><joint name="j"/><actuator name="m">{tags}</actuator></transmission>'))
    assert of(robot) == pytest.approx(np.sqrt(9.81 * 0.5 / (0.26 + inertia * ratio**2)), rel=1e-12)


def test_springs_of_gazebo_are_read():
    robot = mb.Robot(
        pendulum('<gazebo reference="j"><springStiffness>5</springStiffness><springReference>0</springReference></gazebo>')
    )
    assert of(robot) == pytest.approx(np.sqrt((9.81 * 0.5 + 5) / 0.26), rel=1e-12)


def test_bushings_of_drake_are_read():
    ends = '<drake:bushing_frameA name="base"/><drake:bushing_frameC name="a"/><drake:bushing_torque_stiffness value="5 5 5"/>'
    robot = mb.Robot(pendulum(f"<drake:linear_bushing_rpy>{ends}</drake:linear_bushing_rpy>"))
    assert of(robot) == pytest.approx(np.sqrt((9.81 * 0.5 + 5) / 0.26), rel=1e-12)


@pytest.mark.parametrize(
    "extra, name",
    [
        ('<gazebo reference="a"><dampingFactor>0.1</dampingFactor></gazebo>', "dampingFactor"),
        ('<gazebo reference="a"><turnGravityOff>true</turnGravityOff></gazebo>', "turnGravityOff"),
        ("<drake:tendon_constraint/>", "tendon_constraint"),
        ('<mujoco><compiler boundmass="0.1"/></mujoco>', "boundmass"),
        ('<gazebo><plugin name="p" filename="libbuoyancy.so"/></gazebo>', "libbuoyancy"),
    ],
)
def test_tags_that_may_act_and_are_not_read_are_doubtful(extra, name):
    notices = mb.Robot(pendulum(extra)).description_notices
    assert [notice for notice in notices if notice.doubtful and name in notice.text]


def test_mimics_that_follow_each_other_in_a_circle_are_named():
    joints = "".join(
        f'<link name="l{n}">{BODY}</link><joint name="{own}" type="continuous"><parent link="base"/><child link="l{n}"/>'
        f'<mimic joint="{other}"/></joint>'
        for n, (own, other) in enumerate(["xy", "yz", "zx"])
    )
    with pytest.raises(mb.InputError, match='"x" -> "y" -> "z" -> "x"'):
        mb.Robot(pendulum(joints))
