"""How far the linear motion of a robot carries, against closed forms and against nonlinear motions integrated by SciPy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import mbconstrained as mb
from mbconstrained.ground.notices import NoticeKind
from tests.robot.linkages import GROUND, joint, link, urdf

PENDULUM = urdf(
    GROUND, link("rod", 2.0, (0, 0, -0.5), (0.1, 0.1, 0.0)), joint("hinge", "frame", "rod", "continuous", axis=(0, 1, 0))
)

#: Two bars of 0.5 m whose far end slides, 0.15 rad from the posture in which they are in line.
AT_REST, SPRING = 0.15, 4000.0
BAR = 1e-4, 1 / 48, 1 / 48
TOGGLE = urdf(
    GROUND,
    link("crank", 1.0, (0.25, 0, 0), BAR),
    link("rod", 1.0, (0.25, 0, 0), BAR),
    link("slider", 1.0, (0, 0, 0), (1e-3, 1e-3, 1e-3)),
    joint("a", "frame", "crank", "continuous", axis=(0, -1, 0)),
    joint("b", "crank", "rod", "continuous", at=(0.5, 0, 0), axis=(0, -1, 0)),
    joint("s", "frame", "slider", "prismatic", axis=(1, 0, 0)),
)


def swing(amplitude: float):
    robot = mb.Robot(PENDULUM)
    system = robot.linearize(robot.equilibrium())
    return system, system.solve({"hinge": amplitude})


def large(notices) -> list[str]:
    return [notice.text for notice in notices if notice.kind == NoticeKind.LARGE_MOTION]


@pytest.mark.parametrize("amplitude", [1e-6, 0.01, 0.3, 1.0, 2.0])
def test_a_pendulum_is_off_by_the_sine(amplitude):
    """The restoring torque m g l sin(x) lacks x - sin(x), 10 % of it at x = 0.7867."""
    system, motion = swing(amplitude)
    carries = system.linear_range(motion)
    assert carries.deviation == pytest.approx(1 - np.sin(amplitude) / amplitude, rel=0.02, abs=1e-8)
    assert carries.limit == pytest.approx(brentq(lambda x: 1 - np.sin(x) / x - 0.1, 0.1, 2.0), rel=0.03)
    assert (carries.coordinate, carries.unit, carries.amplitude) == ("hinge", "rad", pytest.approx(amplitude, rel=1e-3))


def test_a_small_motion_has_no_notice_and_a_large_one_has():
    assert not large(swing(0.3)[1].notices)
    (text,) = large(swing(1.0)[1].notices)
    assert "hinge goes 1 rad from the posture" in text and "by 16 %" in text and "10 % are reached at 0.7" in text


def test_an_inverted_pendulum_says_where_its_growing_motion_leaves_the_linear_range():
    robot = mb.Robot(PENDULUM)
    posture = robot.equilibrium({"hinge": np.pi})
    assert any(notice.kind == NoticeKind.UNSTABLE and "hinge" in notice.text for notice in posture.notices)
    carries = robot.linearize(posture).linear_range(robot.linearize(posture).solve({"hinge": 0.01}))
    assert carries.deviation > 0.9 and 0.3 < carries.limit < 1.0  # the inertia counts, too


def toggle():
    loop = mb.Loop("rod", (0.5, 0, 0), "slider", (0, 0, 0))
    rest = {"s": np.cos(AT_REST)}
    robot = mb.Robot(TOGGLE, loops=[loop], gravity=0, joint_stiffness={"s": SPRING}, joint_rest=rest)
    return robot.linearize(robot.equilibrium({"a": AT_REST, "b": -2 * AT_REST, "s": np.cos(AT_REST)}))


def nonlinear_toggle(rate: float, times: np.ndarray) -> np.ndarray:
    """a(t) from Lagrange's equation m(a) a'' + m'(a) a'^2 / 2 + U'(a) = 0, less the angle at rest."""

    def slope(_, state):
        a, v = state
        mass = 1 / 12 + 1 / 48 + (0.75 * np.sin(a)) ** 2 + (0.25 * np.cos(a)) ** 2 + np.sin(a) ** 2
        force = SPRING * np.sin(a) * (np.cos(a) - np.cos(AT_REST)) - 1.5 * np.sin(2 * a) * v**2 / 2
        return v, force / mass

    answer = solve_ivp(slope, (0, times[-1]), (AT_REST, rate), t_eval=times, rtol=1e-10, atol=1e-13)
    return answer.y[0] - AT_REST


@pytest.mark.parametrize("amplitude", [0.001, 0.003, 0.01, 0.03])
def test_the_estimate_has_the_size_of_the_true_deviation_of_a_toggle(amplitude):
    """Over the first period; a toggle's stiffness is sin(a)^2, so that 0.01 rad beside 0.15 rad is 10 % already."""
    system = toggle()
    frequency = system.modes().frequencies_hz.max()
    rate, times = amplitude * 2 * np.pi * frequency, np.linspace(0, 1 / frequency, 200)
    motion = system.solve(velocity={"a": rate, "b": -2 * rate, "s": -np.sin(AT_REST) * rate})
    true = np.abs(nonlinear_toggle(rate, times) - motion(times)[0]).max() / amplitude
    carries = system.linear_range(motion, times)
    assert 0.4 < carries.deviation / true < 2.5
    assert carries.coordinate == "b" and carries.limit / 2 == pytest.approx(0.0128, rel=0.1)


def test_motions_that_are_linear_have_no_limit():
    """A slide on a spring, and a free body that turns about a principal axis."""
    slide = urdf(GROUND, link("cart", 2.0, (0, 0, 0), (1, 1, 1)), joint("x", "frame", "cart", "prismatic", axis=(1, 0, 0)))
    robot = mb.Robot(slide, joint_stiffness={"x": 50.0})
    system = robot.linearize(robot.equilibrium())
    carries = system.linear_range(system.solve({"x": 0.4}))
    assert carries.deviation < 1e-6 and carries.limit == np.inf

    body = mb.Robot(urdf(link("body", 1.0, (0, 0, 0), (1.0, 2.0, 3.0))), base="free", gravity=0)
    system = body.linearize(body.equilibrium())
    motion = system.solve(velocity={"base rz": 1.0})
    assert system.linear_range(motion, np.linspace(0, 1, 20)).deviation < 1e-4
    tumbling = system.solve(velocity={"base rx": 1.0, "base ry": 1.0})
    assert system.linear_range(tumbling, np.linspace(0, 1, 20)).deviation > 0.1


def test_a_motor_and_its_gear_are_linear():
    """An arm in the plane of no gravity, whose motor stands on a stiff gear: nothing is left out."""
    robot = mb.Robot(
        PENDULUM,
        gravity=0,
        joint_stiffness={"hinge": 0.0},
        flexible_joints={"hinge": mb.FlexibleJoint(stiffness=80.0, motor_inertia=1e-3, gear_ratio=10, proportional_gain=5.0)},
    )
    system = robot.linearize(robot.equilibrium())
    assert system.linear_range(system.solve({"hinge": 0.5})).deviation < 1e-6


def test_held_joints_have_no_stiffness_and_are_named():
    robot = mb.Robot(PENDULUM)
    texts = [notice.text for notice in robot.equilibrium({"hinge": 0.5}, hold=["hinge"]).notices]
    assert any("a constant load keeps hinge in place and adds no stiffness" in text for text in texts)
    stiff = mb.Robot(PENDULUM, joint_stiffness={"hinge": 100.0}).equilibrium({"hinge": 0.5}, hold=["hinge"])
    assert not any("no stiffness" in notice.text or "unstable" in notice.text for notice in stiff.notices)
