"""Forces and moments of multipliers do the same work as J^T lambda, with pinocchio's own Jacobians of frames."""

import numpy as np
import pinocchio
import pytest

import mbconstrained as mb
from mbconstrained.robot.visualization import coordinate_wrench, row_wrenches
from tests.robot.linkages import joint, link, urdf

AXES = [(0, 0, 1), (1, 0, 0.4), (0.2, 1, 0), (0, 1, 0)]
BODIES = ["root", "body 0", "body 1", "body 2", "body 3"]


def spatial_arm(rng, more: str = "") -> str:
    """Hinges and a slide, each turned anyhow."""
    parts = [link("root")]
    for i, axis in enumerate(AXES):
        parts.append(link(f"body {i}", 1.0, rng.uniform(-0.2, 0.2, 3), (0.1, 0.1, 0.1)))
        place = {"at": rng.uniform(-0.4, 0.4, 3), "turned": rng.uniform(-1, 1, 3)}
        element = joint(f"j{i}", BODIES[i], BODIES[i + 1], "prismatic" if i == 2 else "revolute", axis=axis, **place)
        parts.append(element.replace("</joint>", more + "</joint>") if i == 3 else element)
    return urdf(*parts)


def work(text: str, configuration, body: str, point, force, moment) -> np.ndarray:
    """J^T of a force and moment in the frame of a body at its point, on that body; ("ground": none)."""
    model = pinocchio.buildModelFromXML(text)
    data = model.createData()
    number = model.getFrameId(body)
    pinocchio.computeJointJacobians(model, data, configuration)
    pinocchio.updateFramePlacements(model, data)
    J = pinocchio.getFrameJacobian(model, data, number, pinocchio.ReferenceFrame.LOCAL)
    return J.T @ np.concatenate([force, moment + np.cross(point, force)])


def on_other_body(text, configuration, wrench, other: str, parts) -> np.ndarray:
    """The same force and moment at the same place, on another body."""
    model = pinocchio.buildModelFromXML(text)
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, configuration)
    first, second = (data.oMf[model.getFrameId(body)] for body in (wrench.body, other))
    there = second.actInv(first)
    force, moment = (there.rotation @ part for part in parts)
    return work(text, configuration, other, there.act(wrench.point), force, moment)


@pytest.mark.parametrize("kind", ["point", "hinge", "rigid"])
@pytest.mark.parametrize("second", ["ground", "body 1"])
def test_a_loop_does_the_work_of_its_multipliers(kind, second):
    rng = np.random.default_rng(7)
    text = spatial_arm(rng)
    loop = mb.Loop(
        "body 3", rng.uniform(-0.3, 0.3, 3), second, kind=kind, rotation1=rng.uniform(-1, 1, 3), axis=(0.3, 1, -0.4), name="tie"
    )
    robot = mb.Robot(text, loops=[loop])
    posture = robot.equilibrium(dict(zip(robot.joints, (0.3, -0.7, 0.2, 0.9))), hold="all")
    (wrench,) = row_wrenches(posture)
    multipliers = rng.normal(size=len(posture.multipliers))
    parts = wrench.force @ multipliers, wrench.moment @ multipliers
    own = work(text, posture.configuration, "body 3", wrench.point, *parts)
    expected = posture.balance.jacobian.T @ multipliers
    if second == "ground":
        assert (wrench.on, wrench.body) == ("body 3", "body 3")
        assert own == pytest.approx(expected, abs=1e-12)
    else:
        assert (wrench.on, wrench.body) == ("body 1", "body 3")
        assert on_other_body(text, posture.configuration, wrench, "body 1", parts) - own == pytest.approx(expected, abs=1e-12)
    assert wrench.moment.any() == (kind != "point") and np.linalg.matrix_rank(np.vstack(parts)) <= 2
    assert np.linalg.matrix_rank(np.vstack([wrench.force, wrench.moment])) == len(multipliers)


def test_a_loop_that_begins_at_the_ground_acts_there():
    loop = mb.Loop("ground", (0.1, 0.2, 0.3), "body 3", name="tie")
    text = spatial_arm(np.random.default_rng(3))
    robot = mb.Robot(text, loops=[loop])
    posture = robot.equilibrium(dict(zip(robot.joints, (0.3, -0.7, 0.2, 0.9))), hold="all")
    (wrench,) = row_wrenches(posture)
    assert (wrench.body, wrench.on) == ("ground", "body 3")
    assert np.array_equal(wrench.force, np.eye(3)) and wrench.point == pytest.approx([0.1, 0.2, 0.3])


def test_coordinates_and_mimic_rows_act_along_and_about_the_axes_of_joints():
    rng = np.random.default_rng(5)
    text = spatial_arm(rng, '<mimic joint="j2" multiplier="-1.5" offset="0.2"/>')
    robot = mb.Robot(text, joint_stiffness={"j0": 50.0, "j1": 50.0, "j2": 50.0})
    posture = robot.equilibrium({"j0": 0.3, "j1": -0.7, "j2": 0.2}, hold="all")
    total = np.zeros(4)
    for place in range(4):
        wrench = coordinate_wrench(posture, place)
        parts = wrench.force[:, 0], wrench.moment[:, 0]
        acts = work(text, posture.configuration, wrench.body, wrench.point, *parts)
        parent = BODIES[place]
        if place:  # the parent of the first is the ground, on which nothing works
            acts = acts - on_other_body(text, posture.configuration, wrench, parent, parts)
        assert acts == pytest.approx(np.eye(4)[place], abs=1e-12)
        assert (
            wrench.body == BODIES[place + 1] and wrench.moment.any() == (place != 2) and np.linalg.norm(parts) == pytest.approx(1)
        )
    follower, leader = row_wrenches(posture)
    assert (follower.on, leader.on) == ("body 3", "body 2") and follower.name == leader.name == "j3 follows j2"
    for wrench, place in ((follower, 3), (leader, 2)):
        unit = coordinate_wrench(posture, place)
        factor = posture.balance.jacobian[0, place]
        assert wrench.force == pytest.approx(factor * unit.force) and wrench.moment == pytest.approx(factor * unit.moment)
        total[place] = factor
    assert total == pytest.approx([0, 0, 1.5, 1])
