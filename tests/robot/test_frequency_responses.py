"""Frequency responses and prescribed motions of robots against the referee's matrices."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbconstrained as mb
from tests.robot import linkages
from tests.robot.linkages import joint, link, urdf
from tests.robot.reference import Reference

ANGLES = {"j1": 0.3, "j2": -0.7, "j3": 0.4}
FREQUENCIES = np.array([0.05, 0.8, 3.0, 20.0])
TIP = (0.1, 0.05, -0.4)


def arm() -> str:
    """Three joints in space, no axis or centre of mass on another."""
    return urdf(
        link("root", 3.0, (0.1, 0, 0), (0.1, 0.2, 0.15)),
        link("upper", 2.0, (0.05, 0.02, -0.2), (0.05, 0.06, 0.02)),
        link("lower", 1.2, (0, 0.03, -0.15), (0.02, 0.03, 0.01)),
        link("hand", 0.5, (0.02, 0, -0.05), (0.004, 0.005, 0.003)),
        joint("j1", "root", "upper", at=(0.1, 0, 0.3), axis=(0, 1, 0.2)),
        joint("j2", "upper", "lower", at=(0, 0.05, -0.4), axis=(1, 0.3, 0)),
        joint("j3", "lower", "hand", "prismatic", at=(0, 0, -0.3), axis=(0, 0.2, -1)),
    )


OPTIONS = {
    "joint_stiffness": {"j1": 30.0, "j2": 25.0, "j3": 400.0},
    "joint_rest": ANGLES,
    "joint_damping": {"j1": 0.3, "j2": 0.2, "j3": 1.0},
}


class Referee:
    """M, D and K of ``Reference`` at given angles."""

    def __init__(self, base: str):
        self.reference = reference = Reference(arm(), base, **OPTIONS)
        q = reference.configuration(ANGLES, (0, 0, 0, 0, 0, 0, 1))
        self.M, self.D, self.K = reference.mass(q), reference.damping(q), reference.stiffness(q, None)
        self.weight, self.tool = -reference.applied(q), reference.end("hand", TIP, (0, 0, 0))

    def dynamic(self, f):
        s = 2j * np.pi * f
        return self.K + s * self.D + s**2 * self.M


def robot(base="fixed"):
    built = mb.Robot(arm(), base=base, **OPTIONS)
    return built, built.equilibrium(ANGLES, hold="all")


def test_compliance_at_the_tool_by_forces_and_moments():
    referee, (built, posture) = Referee("fixed"), robot()
    directions = {axis: mb.PointMotion("hand", TIP, along) for axis, along in zip("xyz", np.eye(3))}
    H = built.linearize(posture).frequency_response(
        FREQUENCIES, directions | {"turn": mb.PointMotion("hand", TIP, (0, 1, 0), True)}, directions
    )
    J, spin = referee.tool.moves, referee.tool.turns[1]
    for line, f in enumerate(FREQUENCIES):
        expected = J @ np.linalg.solve(referee.dynamic(f), np.vstack([J, spin]).T)
        assert np.abs(H.values[..., line] - expected).max() <= 1e-8 * np.abs(expected).max()
    assert H.units.tolist() == [["m/N"] * 3 + ["m/(N m)"]] * 3
    assert H.error_estimate.max() <= 1e-10


def test_the_same_directions_by_name_and_as_a_state_space():
    built, posture = robot()
    tip = {"tool": mb.PointMotion("hand", TIP, (0, 0, 1))}
    system = built.linearize(posture, inputs=tip, outputs=tip)
    H = system.frequency_response(FREQUENCIES, ["tool", "j2"], ["tool", "j1"])
    other = built.linearize(posture).frequency_response(FREQUENCIES, tip | {"torque": "j2"}, tip | {"angle": "j1"})
    assert (H.values == other.values).all()
    space = system.to_state_space(["force on tool"], ["tool", "tool velocity"])
    values = np.array([space(2j * np.pi * f)[:, 0] for f in FREQUENCIES]).T
    np.testing.assert_allclose(values[0], H.values[0, 0], rtol=1e-9)
    np.testing.assert_allclose(values[1], H.values[0, 0] * 2j * np.pi * FREQUENCIES, rtol=1e-9)


def test_a_moving_base_moves_the_joints_and_needs_forces():
    """Rows of the joints M_jj d'' + D d' + K_jj d = -(M_jb b'' + K_jb b); the reaction keeps the ground's directions."""
    referee, (built, posture) = Referee("free"), robot("moving")
    system = built.linearize(posture)
    rows = [f"motion of base {axis}" for axis in ("x", "y", "z", "rx", "ry", "rz")]
    H = system.frequency_response(FREQUENCIES, rows, ["j1", "j2", "j3"])
    R = system.frequency_response(FREQUENCIES, rows, rows[:3], quantity="reaction")
    b, j = slice(6), slice(6, None)
    turned = np.zeros((3, 6))  # the force at rest in the frame of the base turns with it
    turned[:, 3:] = -np.array([np.cross(referee.weight[:3], axis) for axis in np.eye(3)]).T
    for line, f in enumerate(FREQUENCIES):
        Z = referee.dynamic(f)
        d = -np.linalg.solve(Z[j, j], Z[j, b])
        force = (Z[b, b] + Z[b, j] @ d)[:3] + turned
        assert np.abs(H.values[..., line] - d).max() <= 1e-8 * np.abs(d).max()
        assert np.abs(R.values[..., line] - force).max() <= 1e-8 * np.abs(force).max()


def test_prescribed_joints_and_base_in_time():
    """A record of the base's velocity and a joint that follows a sine, integrated by DOP853 with the referee's matrices."""
    referee, (built, posture) = Referee("free"), robot("moving")
    rate, amplitude = 2.0, 0.01
    system = built.linearize(posture).prescribe({"j2": mb.harmonic([amplitude], angular_frequency=rate)})
    system = system.prescribe({"base z": mb.step([0.05])}, level="velocity")
    assert [row.name for row in system.rows][-2:] == ["motion of j2", "motion of base z"]
    moved, base, free = 7, 2, [6, 8]
    M, D, K = (matrix[np.ix_(free, free)] for matrix in (referee.M, referee.D, referee.K))

    def rates(t, y):
        d, v = y[:2], y[2:]
        known = np.zeros((3, 9))
        known[:, moved] = (
            amplitude * np.cos(rate * t),
            -amplitude * rate * np.sin(rate * t),
            -amplitude * rate**2 * np.cos(rate * t),
        )
        known[:2, base] = 0.05 * t, 0.05
        load = referee.K @ known[0] + referee.D @ known[1] + referee.M @ known[2]
        return [*v, *np.linalg.solve(M, -load[free] - D @ v - K @ d)]

    start = {"j2": amplitude}
    motion = system.solve(start, {"base z": 0.05})
    times = np.linspace(0.0, 3.0, 7)
    y = solve_ivp(rates, (0, 3), np.zeros(4), t_eval=times, rtol=1e-11, atol=1e-13, method="DOP853").y
    assert np.abs(motion(times)[free] - y[:2]).max() <= 1e-8 * np.abs(y[:2]).max()
    np.testing.assert_allclose(motion(times)[moved], amplitude * np.cos(rate * times), atol=1e-14)
    np.testing.assert_allclose(motion(times)[base], 0.05 * times, atol=1e-14)


def test_a_prescribed_joint_is_an_input_and_its_torque_a_reaction():
    referee, (built, posture) = Referee("fixed"), robot()
    system = built.linearize(posture).prescribe("j1")
    H = system.frequency_response(FREQUENCIES, ["motion of j1"], ["j2", "j3"])
    R = system.frequency_response(FREQUENCIES, ["motion of j1"], quantity="reaction")
    for line, f in enumerate(FREQUENCIES):
        Z = referee.dynamic(f)
        d = -np.linalg.solve(Z[1:, 1:], Z[1:, :1])
        assert np.abs(H.values[..., line] - d).max() <= 1e-8 * np.abs(d).max()
        torque = Z[0, 0] + Z[0, 1:] @ d
        assert np.abs(R.values[..., line] - torque).max() <= 1e-8 * np.abs(torque).max()
    assert R.units.item() == "N m/rad"


def test_reactions_in_loops_are_those_of_the_motion():
    """From the state of the steady motion at t = 0 the motion in time has its reactions, by another elimination of the loop."""
    linkage = linkages.four_bar(linkages.given("four-bar with dampers"))
    robot = mb.Robot(linkage.text, **linkage.options)
    system = robot.linearize(robot.equilibrium(linkage.guess))
    f, load = 1.7, mb.harmonic(np.eye(3)[0], frequency_hz=1.7)
    H = system.frequency_response([f], ["j1"]).values[:, 0, 0]
    R = system.frequency_response([f], ["j1"], quantity="reaction")
    assert [name.split()[0] for name in R.outputs] == ["closure"] * 2
    motion = system.solve(H.real, (2j * np.pi * f * H).real, force=load)
    times = np.linspace(0.1, 2.0, 9)
    expected = np.real(np.outer(R.values[:, 0, 0], np.exp(2j * np.pi * f * times)))
    np.testing.assert_allclose(motion.reaction(times), expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("motions", "message"),
    [
        ({"jj1": 0.0}, 'there is no "jj1"; did you mean "j1"'),
        ({"j1": "fast"}, "motion of j1"),
        ({"j1": mb.step([1.0, 2.0])}, "found a signal with 2 rows"),
    ],
)
def test_bad_motions_are_refused(motions, message):
    built, posture = robot()
    with pytest.raises(mb.InputError, match=message):
        built.linearize(posture).prescribe(motions)
