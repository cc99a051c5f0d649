"""Robots of example-robot-data: Talos on two feet, legged robots, all others, against differences of all forces and exponentials.

They are looked for in the folder that the environment variable MBCONSTRAINED_ROBOT_DATA names (the one that holds "robots"), then
next to numpy, where the wheel puts them: <site-packages>/cmeel.prefix/share/example-robot-data.
"""

import os
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
import scipy.linalg

import mbconstrained as mb
from tests.robot.linkages import allowed, null_space
from tests.robot.reference import Reference

SOLES = ("left_sole_link", "right_sole_link")


def folder() -> Path | None:
    """The folder that holds "robots"."""
    requested = os.environ.get("MBCONSTRAINED_ROBOT_DATA")
    places = [Path(requested)] if requested else []
    places.append(Path(np.__file__).parents[1] / "cmeel.prefix/share/example-robot-data")
    return next((place for place in places if (place / "robots").is_dir()), None)


def file(name: str) -> Path:
    return folder() / "robots" / name


def half_sitting() -> dict:
    """Of the SRDF of Talos, by joint; the base as 7 numbers."""
    tree = ElementTree.parse(file("talos_data/srdf/talos.srdf"))
    state = next(item for item in tree.iter("group_state") if item.get("name") == "half_sitting")
    values = {item.get("name"): [float(x) for x in item.get("value").split()] for item in state.iter("joint")}
    return {name: value if len(value) > 1 else value[0] for name, value in values.items()}


def talos_on_two_feet():
    """(robot, guess): on two feet, joint springs of 3000 N m/rad and dampers of 10 N m s/rad."""
    sitting = half_sitting()
    loops = [mb.Loop(sole, (0, 0, 0), "ground", kind="rigid", name=sole.split("_")[0]) for sole in SOLES]
    path = file("talos_data/robots/talos_reduced.urdf")
    guess = {name: sitting.get(name, 0.0) for name in mb.Robot(path).joints}
    stiffness, damping = dict.fromkeys(guess, 3000.0), dict.fromkeys(guess, 10.0)
    robot = mb.Robot(path, loops=loops, base="free", joint_stiffness=stiffness, joint_rest=guess, joint_damping=damping)
    return robot, {**guess, "base": sitting["root_joint"]}


UNITREE, ANYMAL = "FL_foot FR_foot RL_foot RR_foot", "LF_FOOT RF_FOOT LH_FOOT RH_FOOT"

#: Legged robots: folder, URDF, SRDF with a posture (None: all joints at 0), feet, and what each foot does to the ground.
LEGGED = {
    "anymal c": ("anymal_c_simple_description", "urdf/anymal", "srdf/anymal", ANYMAL, "point"),
    "hyq": ("hyq_description", "robots/hyq_no_sensors", "srdf/hyq", "lf_foot rf_foot lh_foot rh_foot", "point"),
    "go1": ("go1_description", "urdf/go1", "srdf/go1", UNITREE, "point"),
    "g1": ("g1_description", "urdf/g1_29dof_rev_1_0", None, "left_ankle_roll_link right_ankle_roll_link", "rigid"),
    "romeo": ("romeo_description", "urdf/romeo_small", "srdf/romeo_small", "l_sole r_sole", "rigid"),
    "a1": ("a1_description", "urdf/a1", "srdf/a1", UNITREE, "point"),
    "go2": ("go2_description", "urdf/go2", "srdf/go2", UNITREE, "point"),
    "b1": ("b1_description", "urdf/b1", "srdf/b1", UNITREE, "point"),
    "laikago": ("laikago_description", "urdf/laikago", None, UNITREE, "point"),
    "solo12": ("solo_description", "robots/solo12", "srdf/solo", "FL_FOOT FR_FOOT HL_FOOT HR_FOOT", "point"),
    "anymal": ("anymal_b_simple_description", "robots/anymal", "srdf/anymal", ANYMAL, "point"),
    "anymal-kinova": ("anymal_b_simple_description", "robots/anymal-kinova", "srdf/anymal-kinova", ANYMAL, "point"),
}


def legged_urdf(name: str) -> Path:
    folder, urdf, *_ = LEGGED[name]
    return file(f"{folder}/{urdf}.urdf")


def standing(name: str, seed: int):
    """(robot, guess): on two to four feet, or on two soles, near the posture of the SRDF; joint springs and dampers of any size."""
    rng = np.random.default_rng(seed)
    own, _, srdf, feet, kind = LEGGED[name]
    urdf, state = legged_urdf(name), ()
    if srdf:
        state = next(ElementTree.parse(file(f"{own}/{srdf}.srdf")).iter("group_state"), ())
    given = {item.get("name"): [float(x) for x in item.get("value").split()] for item in state}
    bare = mb.Robot(urdf, base="free")
    guess = {}
    for joint in bare.joints[1:]:
        low, high = bare.limits.get(joint, (-np.inf, np.inf))
        value = given.get(joint, [0.0])[0] + 0.1 * rng.standard_normal()
        guess[joint] = float(np.clip(value, low + 0.01, high - 0.01))
    standing_on = feet.split()[: 2 + seed % 3]
    loops = [mb.Loop(foot, (0, 0, 0), "ground", kind=kind, name=foot) for foot in standing_on]
    stiffness, damping = ({name: float(10 ** rng.uniform(*decades)) for name in guess} for decades in ((1.5, 3.5), (-1, 1)))
    robot = mb.Robot(urdf, loops=loops, base="free", joint_stiffness=stiffness, joint_rest=guess, joint_damping=damping)
    base = next((value for value in given.values() if len(value) == 7), [0, 0, 1, 0, 0, 0, 1])
    return robot, {**guess, "base": base}


pytestmark = pytest.mark.skipif(
    folder() is None,
    reason="example-robot-data is not installed (131 MB; pip install example-robot-data, or MBCONSTRAINED_ROBOT_DATA=its folder)",
)


@pytest.fixture(scope="module")
def talos():
    """(robot, posture, system, the referee's robot, its configuration)."""
    robot, guess = talos_on_two_feet()
    posture = robot.equilibrium(guess, hold="all")
    text = file("talos_data/robots/talos_reduced.urdf").read_text()
    joints = {name: value for name, value in guess.items() if name != "base"}
    options = {"joint_stiffness": dict.fromkeys(joints, 3000.0), "joint_rest": joints, "joint_damping": dict.fromkeys(joints, 10.0)}
    reference = Reference(text, "free", loops=robot.loops, **options)
    q = reference.start = reference.configuration(joints, guess["base"])
    return robot, posture, robot.linearize(posture), reference, q


def order(robot, reference):
    return [reference.coordinates.index(name) for name in robot.coordinates]


def test_talos_stands(talos):
    _, posture, system, reference, q = talos
    assert system.size == 38 and len(system.rows) == 12
    assert np.abs(pin.difference(reference.model, q, posture.configuration)).max() < 1e-12
    f = reference.applied(q) + reference.rows(q).T @ reference.multipliers(q, posture.ground_reactions)
    for name, torque in posture.torques.items():
        f[reference.coordinates.index(name)] += torque
    weight = -9.81 * sum(inertia.mass for inertia in reference.model.inertias)
    assert np.abs(f).max() < 1e-9 * abs(weight)
    reference.place(q)
    pushed = [reference.ends(loop)[0].turn @ posture.reactions[loop.name][:3] for loop in reference.loops]
    assert sum(pushed) == pytest.approx([0, 0, weight], abs=1e-9 * abs(weight))  # on the ground


def test_talos_stiffness_is_the_derivative_of_all_forces(talos):
    robot, posture, system, reference, q = talos
    places = order(robot, reference)
    N = null_space(reference.rows(q)[:, places])
    same = allowed(system)
    assert same.shape == N.shape == (38, 26) and np.abs(same - N @ (N.T @ same)).max() < 1e-9
    K = reference.stiffness(q, reference.multipliers(q, posture.ground_reactions))[np.ix_(places, places)]
    expected, actual = N.T @ K @ N, N.T @ system.stiffness @ N
    assert np.abs(actual - expected).max() <= 1e-9 * np.abs(expected).max()
    assert np.abs(actual - actual.T).max() <= 1e-10 * np.abs(actual).max()
    # weight and reactions matter: without them, springs alone, the lowest frequency is another by a per cent and more
    M = N.T @ reference.mass(q)[np.ix_(places, places)] @ N
    both = [
        np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, X)).real))
        for X in (expected, N.T @ np.diag([0.0] * 6 + [3000.0] * 32) @ N)
    ]
    assert abs(both[1][0] / both[0][0] - 1) > 0.01
    D = N.T @ reference.damping(q)[np.ix_(places, places)] @ N
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, expected), -np.linalg.solve(M, D)]])
    zeros = np.linalg.eigvals(A)
    known = np.sort(np.abs(zeros[zeros.imag > 1e-6]))
    assert system.modes().natural_frequencies == pytest.approx(known, rel=1e-8)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", LEGGED)
def test_legged_robots_are_trusted_where_they_are_right(name, seed):
    """The motion against the matrix exponential of the equations on an orthonormal basis of null(J)."""
    robot, guess = standing(name, seed)
    system = robot.linearize(robot.equilibrium(guess, hold="all"))
    N = null_space(system.constraint_matrix)
    rng = np.random.default_rng(seed)
    start = 0.01 * N @ (rng.standard_normal(N.shape[1]) if seed % 2 else N.T[:, rng.integers(6, system.size)])  # of few legs
    motion = system.solve(displacement=start)
    M, C, K = (N.T @ matrix @ N for matrix in (system.mass, system.damping, system.stiffness))
    n, times = len(M), np.linspace(0.0, 1.0, 11)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    known = np.array([N @ (scipy.linalg.expm(A * t)[:n, :n] @ (N.T @ start)) for t in times]).T
    error = np.abs(motion.displacement(times) - known).max() / np.abs(known).max()
    assert error <= max(motion.error_estimate(times), 1e-11) <= 1e-6
    assert not [notice.text for notice in motion.notices if notice.doubtful]


def test_a_head_that_is_a_point_on_three_axes_is_trusted():
    """iCub upright: the mass matrix has a direction u without mass, which follows at once: u^T (C x' + K x) = 0 with x = Y y + u z."""
    path = file("icub_description/robots/icub.urdf")
    names = mb.Robot(path).joints
    robot = mb.Robot(path, joint_stiffness=dict.fromkeys(names, 300.0), joint_damping=dict.fromkeys(names, 2.0))
    system = robot.linearize(robot.equilibrium())
    M, C, K = system.mass, system.damping, system.stiffness
    masses, V = np.linalg.eigh(M)
    assert abs(masses[0]) < 1e-15 < 1e-5 < masses[1]
    Y, u, n = V[:, 1:], V[:, 0], len(M) - 1
    rates = np.zeros((2 * n + 1, 2 * n + 1))  # of y, z, y'
    rates[:n, n + 1 :] = np.eye(n)
    rates[n] = -np.concatenate([u @ K @ Y, [u @ K @ u], u @ C @ Y]) / (u @ C @ u)
    forces = np.column_stack([Y.T @ K @ Y, Y.T @ K @ u, Y.T @ C @ Y]) + np.outer(Y.T @ C @ u, rates[n])
    rates[n + 1 :] = -np.linalg.solve(Y.T @ M @ Y, forces)
    start = 0.01 * np.random.default_rng(0).standard_normal(n + 1)
    motion, times = system.solve(displacement=start), np.linspace(0.0, 1.0, 11)
    states = [scipy.linalg.expm(rates * t) @ np.concatenate([Y.T @ start, [u @ start], np.zeros(n)]) for t in times]
    known = np.array([Y @ state[:n] + u * state[n] for state in states]).T
    error = np.abs(motion.displacement(times) - known).max() / np.abs(known).max()
    assert error <= max(motion.error_estimate(times), 1e-11) <= 1e-6
    assert not [notice.text for notice in motion.notices if notice.doubtful]


#: Of one link, without moving joints on a fixed base, or no URDF at all.
NO_TREES = {"ur3.urdf", "quadrotor_base.urdf", "iris_simple.urdf"}


def every_robot():
    """Paths of all URDFs of the package, none where it is not installed."""
    place = folder()
    return sorted(path for path in place.rglob("*.urdf") if path.name not in NO_TREES) if place else []


@pytest.mark.long
@pytest.mark.parametrize("path", every_robot(), ids=lambda path: path.stem)
def test_every_robot_hangs_in_its_joint_springs_as_finite_differences_of_its_weight_say(path):
    text = path.read_text()
    bare = re.sub(r"<mimic[^>]*(/>|>\s*</mimic>)", "", text)
    model = pin.buildModelFromXML(bare)
    names = [str(name) for name in model.names[1:]]
    robot = mb.Robot(path, joint_stiffness=dict.fromkeys(names, 150.0))
    posture = robot.equilibrium(dict.fromkeys(names, 0.1))
    system = robot.linearize(posture)
    data, h = model.createData(), 1e-4
    q = pin.neutral(model)
    for name, joint in zip(names, list(model.joints)[1:]):
        value = posture.joints[name]
        q[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else (np.cos(value), np.sin(value))

    def weight(step):
        return pin.computeGeneralizedGravity(model, data, pin.integrate(model, q, step)).copy()

    steps = h * np.eye(model.nv)
    K = np.array([(8 * (weight(e) - weight(-e)) - (weight(2 * e) - weight(-2 * e))) / (12 * h) for e in steps]).T + 150.0 * np.eye(
        model.nv
    )
    M = pin.crba(model, data, q)
    N = null_space(system.constraint_matrix) if len(system.rows) else np.eye(model.nv)
    M, K = N.T @ M @ N, N.T @ (K + K.T) @ N / 2
    if np.linalg.eigvalsh(M)[0] <= 1e-9 * np.linalg.eigvalsh(M)[-1]:
        assert len(system.modes().natural_frequencies) <= len(M)  # joints without mass follow at once
        return
    known = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True))
    assert robot.coordinates == tuple(names)
    damped = np.any(system.damping)
    if not damped:
        assert system.modes().natural_frequencies == pytest.approx(known, rel=1e-8)
        return
    C, n = N.T @ system.damping @ N, len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    ours, others = (np.sort(np.abs(values)) for values in (system.modes().eigenvalues, np.linalg.eigvals(A)))
    mirrored = np.sort(np.concatenate([ours, np.abs(system.modes().eigenvalues[system.modes().eigenvalues.imag != 0])]))
    assert mirrored == pytest.approx(others, rel=1e-8)


@pytest.mark.parametrize("distance", [1e-5, 1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("name", ["anymal c", "hyq"])
def test_loops_made_almost_dependent_are_never_trusted(name, distance):
    """A second point of a foot on the ground, so near that its rows are left out: they would keep the foot from turning."""
    robot, guess = standing(name, 3)
    foot = robot.loops[0].body1
    springs = {joint: k for joint, k in zip(robot.coordinates, robot.joint_stiffness) if k}
    loops = [*robot.loops, mb.Loop(foot, (0, 0.6 * distance, 0.8 * distance), "ground", name="extra")]
    twice = mb.Robot(legged_urdf(name), base="free", loops=loops, joint_stiffness=springs)
    system = twice.linearize(twice.equilibrium(guess, hold="all"))
    assert len(system.rows) == len(robot.linearize(robot.equilibrium(guess, hold="all")).rows)
    assert [notice for notice in system.notices if notice.doubtful]
