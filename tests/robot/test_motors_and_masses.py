"""Motors with rigid gears, payloads, other masses, gears of joints, joints that follow: against closed forms and the referee of finite differences."""

import re

import numpy as np
import pytest
from scipy.optimize import brentq

import mbconstrained as mb
from tests.robot.linkages import GROUND, PLANE, allowed, bar, joint, link, urdf

G = 9.81
PENDULUM = urdf(GROUND, link("bob", 1.7, (0, 0, -0.6), (0.02, 0.05, 0.03)), joint("swing", "frame", "bob", axis=(0, 1, 0)))
INERTIA = 0.05 + 1.7 * 0.36


def linear(robot: mb.Robot, guess: dict) -> mb.LinearizedRobot:
    return robot.linearize(robot.equilibrium(guess))


def test_a_motor_adds_its_inertia_and_its_gains():
    motor = mb.Motor(armature=0.3, rotor_inertia=2e-5, gear_ratio=50, position_gain=200.0, velocity_gain=4.0)
    robot = mb.Robot(PENDULUM, motors={"swing": motor})
    posture = robot.equilibrium({"swing": 0.5})
    system = robot.linearize(posture)
    assert posture.joints["swing"] == 0.5 and posture.torques["swing"] == pytest.approx(1.7 * G * 0.6 * np.sin(0.5))
    assert system.mass[0, 0] == pytest.approx(INERTIA + 0.35, rel=1e-14)
    assert system.stiffness[0, 0] == pytest.approx(1.7 * G * 0.6 * np.cos(0.5) + 200.0, rel=1e-13)
    assert system.damping[0, 0] == 4.0
    (mode,) = system.modes().oscillating
    assert sum(mode.shares[0].kinetic.values()) == pytest.approx(1.0) and mode.shares[0].kinetic["rotor of swing"] > 0.3
    assert mode.shares[0].strain["control of swing"] > 0.9


def test_a_payload_is_a_body_fixed_to_the_link():
    # the same robot with a further link behind a fixed joint
    given = (0.03, 0.001, -0.002, 0.02, 0.003, 0.04)
    payload = mb.Payload("bob", 2.5, (0.1, -0.05, -0.8), given)
    fixed = PENDULUM.replace(
        "</robot>",
        link("load", 2.5, (0, 0, 0), (given[0], given[3], given[5], given[1], given[2], given[4]))
        + joint("grip", "bob", "load", "fixed", at=(0.1, -0.05, -0.8))
        + "</robot>",
    )
    ours, other = (
        linear(robot, {"swing": 0.4})
        for robot in (
            mb.Robot(PENDULUM, payloads=[payload], joint_stiffness={"swing": 30.0}),
            mb.Robot(fixed, joint_stiffness={"swing": 30.0}),
        )
    )
    assert ours.mass == pytest.approx(other.mass, rel=1e-13) and ours.stiffness == pytest.approx(other.stiffness, rel=1e-12)


def test_another_mass_changes_the_inertia_in_the_same_ratio():
    robot = mb.Robot(PENDULUM, masses={"bob": 3.4})
    assert linear(robot, {}).mass[0, 0] == pytest.approx(2 * INERTIA, rel=1e-14)
    robot = mb.Robot(PENDULUM, masses={"bob": 3.4}, inertias={"bob": (0.1, 0.2, 0.3)})
    assert linear(robot, {}).mass[0, 0] == pytest.approx(0.2 + 3.4 * 0.36, rel=1e-14)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"masses": {"bab": 1.0}}, 'masses: there is no link "bab"; did you mean "bob"'),
        ({"masses": {"frame": 1.0}}, 'masses: the link "frame" has no <inertial>'),
        ({"masses": {"bob": -1.0}}, "masses: bob"),
        ({"inertias": {"bob": (1, 1)}}, "expected 3 principal moments"),
        ({"inertias": {"bob": (1, -1, 1)}}, "expected 0 or more"),
        ({"payloads": mb.Payload("bob", 1.0)}, "expected a list"),
        ({"payloads": [mb.Payload("hand", 1.0)]}, 'there is no body "hand"'),
        ({"motors": {"swing": 3.0}}, "make it with mb.Motor"),
        ({"motors": {"swim": mb.Motor()}}, 'motors: there is no joint "swim"'),
        ({"motors": {"swing": mb.Motor()}, "flexible_joints": {"swing": mb.FlexibleJoint(1.0)}}, "is a flexible joint"),
        ({"gears": [mb.JointGear("swing", "swim", 1.0)]}, 'gears: "swim" is no joint'),
        ({"gears": [mb.JointGear("swing", "swing", 1.0)]}, '"swing" follows itself'),
        ({"gears": [mb.JointGear("swing", "swing", 1.0)] * 2}, '"swing" follows "swing" and another joint'),
    ],
)
def test_messages(options, message):
    with pytest.raises(mb.InputError, match=re.escape(message)):
        mb.Robot(PENDULUM, **options)


@pytest.mark.parametrize("train", [False, True])
def test_a_gear_and_a_rack(train):
    # a wheel of inertia I with a torsion spring k, geared by r to a second wheel, and by a pinion of radius a to a mass on a spring
    parts = [
        link("wheel", 1.0, (0, 0, 0), (1, 1, 0.4)),
        link("second", 1.0, (0, 0, 0), (1, 1, 0.1)),
        link("slide", 3.0, (0, 0, 0), (1, 1, 1)),
    ]
    joints = [
        joint("turn", "frame", "wheel"),
        joint("other", "frame", "second"),
        joint("rail", "frame", "slide", "prismatic", axis=(1, 0, 0)),
    ]
    r, a, k, c = -2.0, 0.05, 8.0, 700.0
    shift = 0.3 * a / r - 0.02 if train else 0.0  # of the rack, which the second wheel drives in a train of gears
    second = mb.JointGear("other", "turn", r, 0.3 if train else 0.0)
    rack = mb.JointGear("rail", "other", a / r, -0.02) if train else mb.JointGear("rail", "turn", a)
    robot = mb.Robot(
        urdf(GROUND, *parts, *joints),
        gravity=PLANE,
        joint_stiffness={"turn": k, "rail": c},
        joint_rest={"turn": 0.0, "rail": 0.0},
        gears=[rack, second],
    )
    posture = robot.equilibrium({"turn": 0.2})
    turn = -c * a * shift / (k + a**2 * c)
    rests = {"turn": turn, "other": r * turn + second.offset, "rail": a * turn + shift}
    assert posture.joints == pytest.approx(rests, abs=1e-12)
    (frequency,) = robot.linearize(posture).modes().natural_frequencies
    assert frequency**2 == pytest.approx((k + a**2 * c) / (0.4 + r**2 * 0.1 + a**2 * 3.0), rel=1e-12)


# Joints that follow others (URDF <mimic>): one coordinate less, found by putting one angle into the energies by hand.

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


@pytest.mark.parametrize(
    ("ratio", "offset", "guess", "kind"),
    [(1.0, 0.0, -1.5, "revolute"), (0.5, -0.9, -1.5, "continuous"), (2.0, 1.2, -1.4, "revolute"), (-1.0, -3.0, -1.5, "continuous")],
)
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


def test_fixed_joints_and_the_ones_that_follow():
    """j2 = -j1: the forearm does not turn, so it is a point of mass m2 at the elbow."""
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


@pytest.mark.parametrize("length", [None, 0.5])
def test_a_rod_has_its_length_or_that_at_the_guess(length):
    """A slide along x that a rod of l holds to a point h above it: x^2 + h^2 = l^2."""
    slide = link("cart", 2.0, (0, 0, 0), (1, 1, 1)), joint("x", "frame", "cart", "prismatic", axis=(1, 0, 0))
    rod = mb.Loop("ground", (0, 0, 0.3), "cart", (0, 0, 0), kind="rod", length=length)
    posture = mb.Robot(urdf(GROUND, *slide), loops=[rod]).equilibrium({"x": 0.35})
    assert posture["x"] == pytest.approx(0.35 if length is None else 0.4, rel=1e-12)


def test_loop_forces_in_the_directions_of_the_ground_add_up_to_the_weight():
    text = urdf(
        link("body", 4.0, (0.02, 0.01, 0), (0.1, 0.1, 0.1)),
        link("leg", 0.5, (0, 0, -0.1), (0.01, 0.01, 0.01)),
        joint("knee", "body", "leg", at=(0.1, 0, 0)),
    )
    robot = mb.Robot(text, base="free", loops=[mb.Loop("leg", (0, 0, -0.3), "ground", kind="rigid", name="foot")])
    posture = robot.equilibrium({"base": (0, 0, 1, 0.4, 0.2, 0.1), "knee": 0.3}, hold="all")
    assert posture.ground_reactions["foot"][:3] == pytest.approx([0, 0, -4.5 * G], abs=1e-9)  # on the ground


@pytest.mark.parametrize(
    ("slope", "friction", "text"), [(0.0, 0.1, None), (0.3, 0.4, None), (0.3, 0.25, "slips"), (np.pi, 0.5, "lifts off")]
)
def test_a_foot_on_a_slope_slips_where_the_tangent_exceeds_the_coefficient_of_friction(slope, friction, text):
    normal = (np.sin(slope), 0.0, np.cos(slope))
    body = urdf(link("body", 4.0, (0, 0, 0), (0.1, 0.1, 0.1)), bar("arm", 0.1, 0.1), joint("j", "body", "arm"))
    for ends in (("body", (0, 0, -0.1), "ground"), ("ground", (0, 0, 0.9), "body")):
        foot = mb.Loop(*ends, kind="rigid", friction=friction, normal=normal, name="foot")
        posture = mb.Robot(body, base="free", loops=[foot]).equilibrium({"base": (0, 0, 1, 0, 0, 0)}, hold="all")
        notices = [notice.text for notice in posture.notices if "foot" in notice.text]
        assert len(notices) == bool(text) and all(text in notice for notice in notices)
        assert text != "slips" or f"a coefficient of friction of {np.tan(slope):.3g}" in notices[0]
