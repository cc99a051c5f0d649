"""Inverse kinematics against closed forms and pinocchio's forward kinematics; modes along paths of a point, followed by shape."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import mbconstrained as mb
from mbconstrained.robot.cartesian_path import followed

ARM = "robots/double_pendulum/double_pendulum.urdf"
TIP = (0.0, 0.0, -0.3)
Y = -0.02  # where the plane of the tip lies


def place_of(robot: mb.Robot, joints: dict, body: str, point) -> pin.SE3:
    """By pinocchio alone."""
    q = robot.tangent.configuration(joints)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    frame = data.oMf[robot.model.getFrameId(body)]
    return pin.SE3(frame.rotation, frame.act(np.array(point, dtype=float)))


@pytest.mark.parametrize("elbow", [0.8, -0.8])
def test_an_arm_of_two_bars_in_closed_form(elbow):
    """cos(elbow) = (d^2 - a^2 - b^2) / (2 a b), on the side of the guess."""
    arm, (a, b) = mb.Robot(ARM), (0.4, 0.3)
    x, z = 0.35, -0.45
    joints = arm.inverse_kinematics("lower", (x, Y, z), TIP, guess={"elbow": elbow})
    expected = np.sign(elbow) * np.arccos((x**2 + z**2 - a**2 - b**2) / (2 * a * b))
    assert joints["elbow"] == pytest.approx(expected, abs=1e-9)
    assert place_of(arm, joints, "lower", TIP).translation == pytest.approx([x, Y, z], abs=1e-12)


def test_a_stretched_arm_bends():
    """From the singular posture no first-order motion shortens the arm; the place straight above the tip is reached all the same."""
    joints = mb.Robot(ARM).inverse_kinematics("lower", (0.0, Y, -0.6), TIP)
    assert place_of(mb.Robot(ARM), joints, "lower", TIP).translation == pytest.approx([0, Y, -0.6], abs=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_places_and_orientations_that_an_arm_has_are_reached(seed):
    robot, _ = mb.read_robot("robots/seven_joint_arm")
    rng = np.random.default_rng(seed)
    there = dict(zip(robot.joints, rng.uniform(-1, 1, 7)))
    guess = {name: value + rng.uniform(-0.7, 0.7) for name, value in there.items()}
    goal = place_of(robot, there, "tool", (0, 0, 0.08))
    rpy = pin.rpy.matrixToRpy(goal.rotation)
    for orientation in (None, rpy):
        joints = robot.inverse_kinematics("tool", goal.translation, (0, 0, 0.08), orientation, guess)
        reached = place_of(robot, joints, "tool", (0, 0, 0.08))
        assert reached.translation == pytest.approx(goal.translation, abs=1e-9)
        if orientation is not None:
            assert reached.rotation == pytest.approx(goal.rotation, abs=1e-9)


def test_a_parallel_robot_reaches_with_closed_loops():
    robot, data = mb.read_robot("robots/delta")
    guess = data.posture["guess"]
    start = np.array(place_of(robot, robot.equilibrium(**data.posture).joints, "platform", (0, 0, 0)).translation)
    path = start + np.linspace(0, 1, 5)[:, None] * np.array([0.1, -0.05, 0.02])
    along = robot.modes_along("platform", path, guess=guess)
    assert not along.unreachable and max(posture.loop_error for posture in along.postures) < 1e-11
    for place, posture in zip(path, along.postures):
        assert place_of(robot, posture.joints, "platform", (0, 0, 0)).translation == pytest.approx(place, abs=1e-10)
    assert along.distances.max() < 1e-10 and along.lengths[-1] == pytest.approx(np.linalg.norm(path[-1] - path[0]))


def test_frequencies_are_those_of_the_postures_one_by_one():
    robot, data = mb.read_robot("robots/seven_joint_arm")
    guess = data.posture["guess"]
    start = np.array(place_of(robot, robot.equilibrium(**data.posture).joints, "tool", (0, 0, 0.08)).translation)
    path = start + np.linspace(0, 1, 9)[:, None] * np.array([0.1, 0.3, -0.2])
    along = robot.modes_along("tool", path, (0, 0, 0.08), guess=guess)
    for posture, own in zip(along.postures, along.frequencies_hz):
        system = robot.linearize(robot.equilibrium(posture.joints, hold="all"))
        assert np.sort(own) == pytest.approx(system.modes(damped=False).frequencies_hz, rel=1e-9)
    assert np.isnan(along.assurance[0]).all() and (along.assurance[1:] > 0.5).all() and not along.notices


def test_places_out_of_reach_are_listed_and_the_others_computed():
    arm = mb.Robot(ARM, joint_stiffness={"shoulder": 900.0, "elbow": 300.0})
    path = [(x, Y, -0.5) for x in (0.2, 0.3, 0.6, 0.9, 0.35)]
    along = arm.modes_along("lower", path, TIP, guess={"elbow": 0.5})
    assert along.unreachable == (2, 3)
    reach = [np.hypot(x, 0.5) - 0.7 for x in (0.6, 0.9)]
    assert (along.distances[2:4] >= reach).all() and (along.distances[2:4] < 1.2 * np.array(reach)).all()
    assert np.isnan(along.frequencies_hz[2:4]).all()
    assert np.isfinite(along.frequencies_hz[[0, 1, 4]]).all()
    assert [notice.text[:31] for notice in along.notices] == ["2 of 5 places are not reached: "]
    tables = along._tables()
    assert tables[0].rows[2][4:] == ("", "") and len(tables[0].rows) == 5


def test_modes_that_cross_are_followed():
    """Two masses on springs of their own: their frequencies cross, and new ones get columns of their own."""

    def pair(a):
        return mb.MechanicalSystem(np.diag([1.0, 2.0]), stiffness=np.diag([1.0 + a, 2.0 * (2.0 - a)]))

    systems = [pair(a) for a in np.linspace(0, 1, 8)]
    frequencies, assurance = followed([s.mass for s in systems], [s.modes() for s in systems])
    assert frequencies == pytest.approx(np.sqrt(np.array([1 + np.linspace(0, 1, 8), 2 - np.linspace(0, 1, 8)]).T))
    assert assurance[1:] == pytest.approx(1.0)
    free = mb.MechanicalSystem(np.diag([1.0, 2.0]), stiffness=np.diag([1.0, 0.0]))
    frequencies, _ = followed([free.mass, None, systems[0].mass], [free.modes(), None, systems[0].modes()])
    assert frequencies == pytest.approx(np.array([[1.0, np.nan], [np.nan] * 2, [1.0, np.sqrt(2.0)]]), nan_ok=True)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("lower", (3, Y, 0), TIP), r"lower does not reach \(3, -0.02, 0\) m near the guess; it comes to"),
        (("lower", (0.3, 0, -0.5), TIP), r"it comes to \(0.299\d*, -0.02, -0.499\d*\) m, 0.02 m from it"),
        (("lowr", (0, 0, 0)), 'there is no body "lowr"; did you mean "lower"'),
        (("ground", (0, 0, 0)), 'found "ground", which does not move'),
        (("lower", (0, 0)), "place"),
        (("lower", (0, np.nan, 0)), "place"),
        (("lower", (0, 0, 0), TIP, (1, 2)), "orientation"),
    ],
)
def test_what_is_wrong_is_named(arguments, text):
    with pytest.raises(mb.InputError, match=text):
        mb.Robot(ARM).inverse_kinematics(*arguments)


def test_paths_without_places_are_refused():
    for places in ([], [(0, 0)], np.zeros((0, 3)), [[np.nan, 0, 0]]):
        with pytest.raises(mb.InputError, match="places"):
            mb.Robot(ARM).modes_along("lower", places)


LIMITED = '<joint name="elbow" type="revolute"><limit lower="{}" upper="{}" effort="1" velocity="1"/>'


@pytest.mark.parametrize(("limits", "sign"), [((0.1, 3.0), 1), ((-3.0, -0.1), -1), ((-0.2, 0.2), 0)])
def test_the_solution_within_the_limits_is_preferred(limits, sign):
    """Of the two elbows of the closed form the one within the limits, whatever the guess; that of the guess where neither is."""
    text = Path(ARM).read_text(encoding="utf-8").replace('<joint name="elbow" type="continuous">', LIMITED.format(*limits))
    arm, (x, z) = mb.Robot(text), (0.35, -0.45)
    expected = np.arccos((x**2 + z**2 - 0.4**2 - 0.3**2) / (2 * 0.4 * 0.3))
    for guess in (0.8, -0.8):
        joints = arm.inverse_kinematics("lower", (x, Y, z), TIP, guess={"elbow": guess})
        assert joints["elbow"] == pytest.approx((sign or np.sign(guess)) * expected, abs=1e-9)
        beyond = [notice for notice in arm.equilibrium(joints, hold="all").notices if "beyond its limits" in notice.text]
        assert len(beyond) == (sign == 0)
    along = arm.modes_along("lower", [(x, Y, z), (x, Y, z + 0.01)], TIP, guess={"elbow": 0.8})
    assert ["beyond their limits" in notice.text for notice in along.notices] == [True] * (sign == 0)


def test_loops_have_the_sizes_of_the_guess_at_all_starts():
    """A rod without a length has that at the guess, also where the search goes on from the middle of the limits."""
    text = Path(ARM).read_text(encoding="utf-8").replace('<joint name="elbow" type="continuous">', LIMITED.format(-3.0, -0.1))
    centre, guess = np.array([0.5, Y, 0.0]), {"shoulder": -0.3, "elbow": 0.8}
    arm = mb.Robot(text, loops=[mb.Loop("ground", tuple(centre), "lower", TIP, "rod")])
    radius = place_of(arm, guess, "lower", TIP).translation - centre
    place = centre + pin.utils.rotate("y", -0.1) @ radius
    joints = arm.inverse_kinematics("lower", place, TIP, guess=guess)
    assert joints["elbow"] < 0 and place_of(arm, joints, "lower", TIP).translation == pytest.approx(place, abs=1e-12)
    with pytest.raises(mb.InputError, match="does not reach"):
        arm.inverse_kinematics("lower", centre + 1.1 * radius, TIP, guess=guess)
