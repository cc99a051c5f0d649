"""URDF files: models by seed over kinds of joints, origins, axes, turned inertias, damping, springs, rotors and mimic joints, against
products of exponentials, and against MuJoCo, which reads URDF itself, but for what only Drake and Gazebo have."""

import numpy as np
import pinocchio
import pytest
import scipy.linalg

import mbconstrained as mb
from tests.robot.model_files import Mechanism, UrdfWriter
from tests.robot.test_sdf_models import order

SEEDS = range(60)


def posture_of(truth, rng):
    """Values of the coordinates in which screws and mimic joints follow."""
    q = dict(zip(truth.coordinates, rng.uniform(-1, 1, len(truth.coordinates)).tolist()))
    for joint in truth.joints:
        if joint.kind == "screw":
            q[f"{joint.name} slide"] = joint.pitch * q[joint.name]
        if joint.mimic is not None:
            leader, ratio, offset = joint.mimic
            q[joint.name] = ratio * q[leader] + offset
    return q


def weight(truth):
    """All bodies' weights (N): the size of forces of gravity on joints at most a few metres away, of which some cancel."""
    return 9.81 * sum(body.mass for body in truth.bodies)


@pytest.mark.parametrize("seed", SEEDS)
def test_trees_have_the_matrices_of_products_of_exponentials(seed):
    rng = np.random.default_rng([seed, 2])
    truth = Mechanism(rng, ["revolute", "revolute", "prismatic", "fixed", "screw"])
    robot = mb.Robot(UrdfWriter(truth, rng).text())
    assert not [notice for notice in robot.description_notices if notice.doubtful]
    guess = posture_of(truth, rng)
    q = np.array(list(guess.values()))
    places = np.ix_(order(robot, truth), order(robot, truth))
    M, K = truth.mass(q), truth.stiffness(q)
    system = robot.linearize(robot.equilibrium(guess, hold="all"))
    np.testing.assert_allclose(system.mass[places], M, rtol=0, atol=1e-12 * np.abs(M).max())
    np.testing.assert_allclose(system.stiffness[places], K, rtol=0, atol=1e-8 * np.abs(K).max())
    np.testing.assert_allclose(system.damping[places], np.diag(truth.dampers), rtol=0, atol=1e-12)
    rows, free = truth.rows(q), scipy.linalg.null_space(system.constraint_matrix[:, order(robot, truth)])
    assert free.shape[1] == len(q) - (np.linalg.matrix_rank(rows) if len(rows) else 0)
    np.testing.assert_allclose(rows @ free, 0.0, atol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_joints_with_several_degrees_of_freedom_have_the_forces_of_products_of_exponentials(seed):
    rng = np.random.default_rng([seed, 3])
    truth = Mechanism(rng, ["revolute", "prismatic", "ball", "floating", "planar"])
    robot = mb.Robot(UrdfWriter(truth, rng, extended=False).text())
    several = [f"{joint.name} " for joint in truth.joints if joint.kind in ("ball", "floating", "planar")]
    guess = {name: value for name, value in posture_of(truth, rng).items() if not name.startswith(tuple(several))}
    q = np.array([guess.get(name, 0.0) for name in truth.coordinates])
    own, places = robot.tangent.configuration(guess), order(robot, truth)
    M, g = truth.mass(q), truth.forces(q) - truth.springs * (q - truth.rests)
    np.testing.assert_allclose(robot.tree.mass(own)[np.ix_(places, places)], M, rtol=0, atol=1e-12 * np.abs(M).max())
    np.testing.assert_allclose(robot.tree.gravity(own)[places], g, rtol=0, atol=1e-13 * weight(truth))
    np.testing.assert_allclose(robot.joint_damping[places], truth.dampers, rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_trees_have_the_matrices_of_mujoco(seed):
    mujoco = pytest.importorskip("mujoco")
    rng = np.random.default_rng([seed, 4])
    truth = Mechanism(rng, ["revolute", "revolute", "prismatic", "fixed"])
    text = UrdfWriter(truth, rng, extended=False).text()
    robot = mb.Robot(text)
    guess = posture_of(truth, rng)
    system = robot.linearize(robot.equilibrium(guess, hold="all"))
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    joints = [model.joint(name) for name in robot.coordinates]
    for name, joint in zip(robot.coordinates, joints):
        data.qpos[joint.qposadr[0]] = guess[name]
    mujoco.mj_forward(model, data)
    places, M = [joint.dofadr[0] for joint in joints], np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    own = robot.tangent.configuration(guess)
    atol = 1e-11 * np.abs(M).max()  # MuJoCo diagonalizes the inertias
    np.testing.assert_allclose(system.mass, M[np.ix_(places, places)], rtol=0, atol=atol)
    forces = data.qfrc_bias[places]
    np.testing.assert_allclose(robot.tree.gravity(own), forces, rtol=0, atol=1e-12 * weight(truth))
    np.testing.assert_allclose(np.diag(system.damping), model.dof_damping[places], rtol=0, atol=1e-12)


#: A pendulum of 1 kg and 0.5 m.
BODY = (
    '<inertial><origin xyz="0 0 -0.5"/><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>'
)
AXIS = '<parent link="base"/><child link="a"/><axis xyz="0 1 0"/>'


def pendulum(extra):
    joint = f'<joint name="j" type="continuous">{AXIS}</joint>'
    return (
        f'<robot name="r" xmlns:drake="http://drake.mit.edu"><link name="base"/><link name="a">{BODY}</link>{joint}{extra}</robot>'
    )


def test_bushings_of_drake_are_read():
    ends = '<drake:bushing_frameA name="base"/><drake:bushing_frameC name="a"/><drake:bushing_torque_stiffness value="5 5 5"/>'
    robot = mb.Robot(pendulum(f"<drake:linear_bushing_rpy>{ends}</drake:linear_bushing_rpy>"))
    (frequency,) = robot.linearize(robot.equilibrium()).modes().natural_frequencies
    assert frequency == pytest.approx(np.sqrt((9.81 * 0.5 + 5) / 0.26), rel=1e-12)


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


@pytest.mark.parametrize(
    "place, wrong, name",
    [
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0"/><axis xyz="1 0 0"/>', "second <axis> of the joint"),
        ("<mass", '<mass value="9"/><mass', "second <mass> of the link"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0"/><origin XYZ="0 0 1"/>', 'XYZ = 0 0 1 in the <origin> of "j"'),
        (
            '<axis xyz="0 1 0"/>',
            '<axis xyz="0 1 0"/><origin quat_xyzw="0 0 1 0"/>',
            "quat_xyzw = 0 0 1 0 in the <origin>",
        ),  # of version 1.0
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0"/><drake:dynamics damping="3"/>', "<dynamics> of the joint"),
        ('name="r"', 'name="r" version="3.0"', "its version is '3.0'; 1.0 to 1.2 are known"),
    ],
)
def test_repeated_and_misspelt_parts_are_doubtful(place, wrong, name):
    text = pendulum("")
    assert text.count(place) == 1 and not mb.Robot(text).description_notices
    notices = mb.Robot(text.replace(place, wrong)).description_notices
    assert [notice for notice in notices if notice.doubtful and name in notice.text]


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("version", ["1.1", "1.2"])
def test_quaternions_of_origins_are_those_of_pinocchio(seed, version):
    rng, links = np.random.default_rng(seed), '<link name="base"/>'
    for number, parent in enumerate(["base", "l0", "l1"]):
        origins = [
            f'<origin xyz="0.1 0.2 {number}" quat_xyzw="{" ".join(map(repr, rng.normal(size=4).tolist()))}"/>' for _ in range(2)
        ]
        links += (
            f'<link name="l{number}"><inertial>{origins[0]}<mass value="1"/><inertia ixx="0.2" iyy="0.3" izz="0.4" ixy="0.01" '
            f'ixz="0" iyz="0"/></inertial></link><joint name="j{number}" type="continuous">{origins[1]}<parent link="{parent}"/>'
            f'<child link="l{number}"/><axis xyz="1 2 3"/></joint>'
        )
    text = f'<robot name="r" version="{version}">{links}</robot>'
    truth, robot = pinocchio.buildModelFromXML(text), mb.Robot(text)
    for one, other in zip(truth.jointPlacements, robot.model.jointPlacements):
        np.testing.assert_allclose(other.homogeneous, one.homogeneous, atol=1e-14)
    for one, other in zip(truth.inertias, robot.model.inertias):
        np.testing.assert_allclose(other.matrix(), one.matrix(), atol=1e-14)
    with pytest.raises(mb.InputError, match='urdf, link "l0", origin: found rpy and quat_xyzw; expected one of them'):
        mb.Robot(text.replace("0.1 0.2 0", '0.1 0.2 0" rpy="0 0 1'))


def test_mimics_that_follow_each_other_in_a_circle_are_named():
    joints = "".join(
        f'<link name="l{n}">{BODY}</link><joint name="{own}" type="continuous"><parent link="base"/><child link="l{n}"/>'
        f'<mimic joint="{other}"/></joint>'
        for n, (own, other) in enumerate(["xy", "yz", "zx"])
    )
    with pytest.raises(mb.InputError, match='"x" -> "y" -> "z" -> "x"'):
        mb.Robot(pendulum(joints))
