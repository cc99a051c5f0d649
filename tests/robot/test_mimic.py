"""Joints that follow others (URDF <mimic>): one coordinate less, found by putting one angle into the energies by hand."""

import numpy as np
import pytest
from scipy.optimize import brentq

import mbconstrained as mb
from tests.robot.linkages import GROUND, PLANE, allowed, bar, joint, urdf

G = 9.81
MASSES, LENGTHS = (1.3, 0.8), (0.6, 0.9)


def two_pendulums(ratio: float, offset: float, kind: str = "revolute", chained: bool = False) -> str:
    """Uniform bars on hinges side by side, or one on the other; j2 = ratio j1 + offset."""
    follow = f'<mimic joint="j1" multiplier="{ratio!r}" offset="{offset!r}"/></joint>'
    second = joint("j2", "first" if chained else "frame", "second", kind, at=(LENGTHS[0] if chained else 3, 0, 0))
    return urdf(
        GROUND,
        bar("first", MASSES[0], LENGTHS[0]),
        bar("second", MASSES[1], LENGTHS[1]),
        joint("j1", "frame", "first", kind),
        second.replace("</joint>", follow),
    )


def side_by_side(ratio, offset, guess):
    """(angle, w^2): V = -m1 g l1/2 (-sin q) ..., T = (I1 + r^2 I2) q'^2 / 2, I = m l^2 / 3; weight along -y."""
    (m1, m2), (a, b) = MASSES, LENGTHS

    def slope(q):
        return G * (m1 * a / 2 * np.cos(q) + ratio * m2 * b / 2 * np.cos(ratio * q + offset))

    q = brentq(slope, guess - 0.4, guess + 0.4, xtol=1e-15)
    curvature = -G * (m1 * a / 2 * np.sin(q) + ratio**2 * m2 * b / 2 * np.sin(ratio * q + offset))
    return q, curvature / (m1 * a**2 / 3 + ratio**2 * m2 * b**2 / 3)


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
@pytest.mark.parametrize("ratio, offset, guess", [(1.0, 0.0, -1.5), (0.5, -0.9, -1.5), (2.0, 1.2, -1.4), (-1.0, -3.0, -1.5)])
def test_two_pendulums_that_follow_each_other(ratio, offset, guess, kind):
    angle, square = side_by_side(ratio, offset, guess)
    robot = mb.Robot(two_pendulums(ratio, offset, kind), gravity=PLANE)
    posture = robot.equilibrium({"j1": guess, "j2": ratio * guess + offset})
    assert posture.joints == pytest.approx({"j1": angle, "j2": ratio * angle + offset}, rel=1e-10)
    assert posture.loop_error < 1e-12
    system = robot.linearize(posture)
    assert system.modes().natural_frequencies ** 2 == pytest.approx([square], rel=1e-9)
    assert [row.name for row in system.rows] == ["j2 follows j1"]
    N = allowed(system)[:, 0]
    assert N[1] / N[0] == pytest.approx(ratio, rel=1e-13)


def test_elbow_that_keeps_a_forearm_level():
    # j2 = -j1: the forearm does not turn, so it is a point of mass m2 at the elbow
    (m1, m2), (a, _) = MASSES, LENGTHS
    robot = mb.Robot(two_pendulums(-1.0, 0.0, chained=True), gravity=PLANE)
    posture = robot.equilibrium({"j1": -1.4, "j2": 1.4})
    square = G * a * (m1 / 2 + m2) / (m1 * a**2 / 3 + m2 * a**2)
    assert posture.joints["j1"] == pytest.approx(-np.pi / 2, abs=1e-10)
    assert robot.linearize(posture).modes().natural_frequencies ** 2 == pytest.approx([square], rel=1e-9)


def test_fixed_joints_and_the_ones_that_follow():
    robot = mb.Robot(two_pendulums(-1.0, 0.0, chained=True), gravity=PLANE)
    posture = robot.equilibrium({"j1": 0.3, "j2": -0.3}, hold=["j1"])
    (m1, m2), (a, _) = MASSES, LENGTHS
    assert posture.joints == pytest.approx({"j1": 0.3, "j2": -0.3}, abs=1e-12)
    assert posture.torques["j1"] == pytest.approx(G * a * np.cos(0.3) * (m1 / 2 + m2), rel=1e-10)


def test_one_that_follows_a_locked_joint_is_locked():
    with pytest.raises(mb.InputError, match="no joint that moves"):  # both of two
        mb.Robot(two_pendulums(2.0, 1.2, chained=True), gravity=PLANE, locked={"j1": 0.2})
    with pytest.raises(mb.InputError, match='"j2" follows "j1", which moves'):
        mb.Robot(two_pendulums(2.0, 1.2, chained=True), gravity=PLANE, locked={"j2": 0.2})


def test_leaders_that_do_not_lead():
    with pytest.raises(mb.InputError, match='"j2".*mimic'):
        mb.Robot(two_pendulums(1.0, 0.0).replace('mimic joint="j1"', 'mimic joint="j2"'))


def test_numbers_that_are_none():
    with pytest.raises(mb.InputError, match='"j2".*mimic.*multiplier'):
        mb.Robot(two_pendulums(float("nan"), 0.0))
