"""Every example against values from elsewhere: published, exact, or a closed form written down here."""

import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from mbconstrained.scene.run.scene import read_scene
from tests.oracles.models import close, table

EXAMPLES = Path(__file__).parents[1] / "examples"
TESTS = (
    "test_examples.py",
    "test_robot_examples.py",
    "test_control_examples.py",
    "test_vibration_examples.py",
    "test_switched_examples.py",
)
SQRT5 = math.sqrt(5)


def run(name, settings=None):
    return read_scene(EXAMPLES / f"{name}.toml", settings).run()


def nothing_happens_at_zero(motion) -> bool:
    return not motion.jump.any() and not any(impulse.any() for impulse in motion.impulses)


# Moysis et al., section 5.1.
FREQUENCIES = [(5 - SQRT5) / 10, (5 + SQRT5) / 10]  # rad/s, roots of s^4 + 3/5 s^2 + 1/25


@pytest.mark.parametrize("name", ["two_masses", "two_masses_position", "two_masses_formula"])
def test_two_masses_follow_the_published_solution(name):
    result = run(name)
    times, *states = (table("ex51", name) for name in ("t", "x1bar", "q1", "q2bar"))
    assert close(result.motion(times), states)
    assert close(result.motion.velocity(times)[[0, 2]], [table("ex51", name) for name in ("x1bar_dot", "q2bar_dot")])
    assert nothing_happens_at_zero(result.motion)
    assert result.modes.natural_frequencies == pytest.approx(FREQUENCIES, rel=1e-14)
    assert result.is_trusted and result.error_estimate < 1e-12


def test_two_masses_drift_at_acceleration_level():
    result = run("two_masses")
    assert [(mode.kind, mode.multiplicity) for mode in result.modes] == [("drift", 2), ("oscillation", 1), ("oscillation", 1)]
    assert sum(zero.count for zero in result.finite_pair.zeros) == 6  # det A = -100 s^6 - 60 s^4 - 4 s^2
    assert any(notice.kind == "drift" and "-0.4 m" in notice.text for notice in result.notices)


def test_two_masses_at_position_level_have_no_drift():
    result = run("two_masses_position")
    assert [mode.kind for mode in result.modes] == ["oscillation", "oscillation"]
    assert result.values[0] - result.values[1] == pytest.approx(np.full(1001, -0.4), rel=1e-14)
    # The link between x1 and q1 carries the elastic force of the second spring: x1 - q1 row, 10 x1'' + 2 x1 = lambda.
    force = 10 * result.motion.acceleration(result.times)[0] + 2 * result.values[0]
    assert result.curves("reaction").values[0] == pytest.approx(force, abs=1e-12)
    assert result.curves("reaction").values[0] == pytest.approx(2 * result.values[2], abs=1e-11)


# Moysis et al., section 5.2: u3 = e^(-a t) (2 cos b t + (2 a/b) sin b t), a = 2/15, b = sqrt(41)/15; u1 = u3/3;
# u2 = u3/3 + (u2(0) - 2/3), from the equilibrium of the massless joints.
A, B = 2 / 15, math.sqrt(41) / 15


def third_mass(t):
    return np.exp(-A * t) * (2 * np.cos(B * t) + 2 * A / B * np.sin(B * t))


@pytest.mark.parametrize("name", ["massless_joints", "massless_joints_formula", "inconsistent_start"])
def test_massless_joints_follow_the_mass(name):
    result = run(name)
    u3 = third_mass(result.times)
    assert result.values == pytest.approx(np.array([u3 / 3, u3 / 3 + 1 / 3, u3]), rel=1e-12, abs=1e-13)
    assert [(mode.kind, mode.multiplicity) for mode in result.modes] == [("offset", 1), ("oscillation", 1)]
    assert result.modes[1].eigenvalue == pytest.approx(complex(-A, B), rel=1e-14)


def test_massless_joints_reach_the_published_values():
    motion = run("massless_joints").motion
    times, *states = (table("ex52", name) for name in ("t", "u1", "u2", "u3"))
    assert motion(times) == pytest.approx(np.array(states), rel=1e-12)
    assert nothing_happens_at_zero(motion)


def test_inconsistent_start_jumps_without_impulses():
    # The projector of section 5.2: u1(0+) = u3(0-)/3, u1'(0+) = u2'(0+) = u3'(0-)/3, all else stays.
    motion = run("inconsistent_start").motion
    assert motion.start == pytest.approx(np.array([[2 / 3, 1, 2], [0, 0, 0]]), abs=1e-15)
    assert not any(impulse.any() for impulse in motion.impulses)
    texts = " ".join(notice.text for notice in motion.notices)
    assert "u1: its displacement jumps at t = 0" in texts and "u2: its velocity jumps at t = 0" in texts


def test_rigid_link_is_closed_by_a_derivative_of_delta():
    # By hand: the rows give (2 s^2 + 1) Q = s and Lambda = -s^2 Q = -s/2 + (s/2)/(2 s^2 + 1): -1/2 delta' and a cosine.
    result = run("rigid_link")
    motion, t = result.motion, result.times
    assert motion.start == pytest.approx(np.array([[0.5, 0.5, 0.25], [0, 0, 0]]), abs=1e-15)
    assert len(motion.impulses) == 2
    assert motion.impulses[0] == pytest.approx([0, 0, 0], abs=1e-15)
    assert motion.impulses[1] == pytest.approx([0, 0, -0.5], rel=1e-14)
    cosine = np.cos(t / math.sqrt(2))
    assert result.values == pytest.approx(np.array([cosine / 2, cosine / 2, cosine / 4]), abs=1e-13)
    (zero,) = result.finite_pair.zeros
    assert zero.value == pytest.approx(1j / math.sqrt(2), rel=1e-14)


def test_critically_damped_mass_creeps_home():
    result = run("critically_damped")
    t = result.times
    assert result.values[0] == pytest.approx(0.1 * (1 + 2 * t) * np.exp(-2 * t), rel=1e-12)
    (mode,) = result.modes
    assert (mode.kind, mode.multiplicity) == ("decay", 2)
    assert mode.eigenvalue == pytest.approx(-2, rel=1e-7)  # a double zero is known to half the digits


def test_wagons_roll_off_and_swing():
    # Modes of the free chain of three: (1, 1, 1) at 0, (1, 0, -1) at w = sqrt(k/m) = 10 rad/s, (1, -2, 1) at sqrt(3) w.
    result = run("rigid_body")
    t, fast = result.times, 10 * math.sqrt(3)
    rolling, first, second = t / 3, np.sin(10 * t) / 20, np.sin(fast * t) / (6 * fast)
    expected = np.array([rolling + first + second, rolling - 2 * second, rolling - first + second])
    assert result.values == pytest.approx(expected, abs=1e-12)
    assert next((mode.kind, mode.multiplicity) for mode in result.modes) == ("rigid body", 2)
    assert result.modes.natural_frequencies == pytest.approx([10, fast], rel=1e-13)
    assert result.curves("energy").values[-1] == pytest.approx(np.full(len(t), 0.5 * 20_000), rel=1e-12)


def test_gear_mesh_follows_the_error_of_the_pitch():
    """The steady force between the teeth, k e + c e' with e'' + 2 zeta w e' + w^2 e = w^2 e0 sin(w0 t), w = 1000 rad/s, zeta = 5 %."""
    result = run("gear_mesh")
    assert result.modes.natural_frequencies == pytest.approx([1000.0], rel=1e-12)
    w0, motion = 2 * np.pi * 140, result.motion
    t = np.linspace(1.0, 1.01, 9)  # the free oscillation has decayed to e^-50
    late = motion(t)
    approach = 1e-3 * (20 * late[0] + 60 * late[1])
    expected = (20e-6 * 1e6 / (1e6 - w0**2 + 100j * w0) * np.exp(1j * w0 * t)).imag
    assert approach == pytest.approx(expected, abs=1e-14)


def test_gear_train_is_two_equal_inertias_on_the_shaft():
    # Reduced to the shaft: J = 0.02 on both ends of k = 40; twist d = (T/2k)(1 - cos w t), w = sqrt(2 k/J), mean 25 t^2.
    result = run("gear_train")
    t, w = result.times, math.sqrt(2 * 40 / 0.02)
    twist = 2 / (2 * 40) * (1 - np.cos(w * t))
    motor, pinion = 25 * t**2 + twist / 2, 25 * t**2 - twist / 2
    names = result.scene.equations.coordinates.names
    expected = {"motor": motor, "pinion": pinion, "wheel": -pinion / 3}
    assert result.values == pytest.approx(np.array([expected[name] for name in names]), abs=1e-12)
    # The pinion has no inertia: the torque of the teeth on it balances the shaft, 40 (motor - pinion).
    assert result.curves("reaction").values[0] == pytest.approx(-40 * twist, abs=1e-10)
    assert result.modes.natural_frequencies == pytest.approx([w], rel=1e-13)


def test_pulled_joint_follows_the_closed_forms_of_its_pieces():
    # By hand: x'' + 25 x = F/12 and u = x/4 + F/400. A slope s from t0 on adds s/12 (d/25 - sin(5 d)/125) with
    # d = t - t0 > 0, a step F adds F/12 (1 - cos 5 d)/25, and the impulse 1.5/3 sin(5 d)/5.
    result = run("pulled_joint")
    t = result.times

    def since(t0):
        return np.maximum(t - t0, 0.0)

    def ramp(d):
        return (d / 25 - np.sin(5 * d) / 125) / 12

    load = 80 * ramp(since(0.5)) - 160 * ramp(since(1.0)) + 80 * ramp(since(1.5))
    load += 20 * (np.cos(5 * since(2.4)) - np.cos(5 * since(2.0))) / 300 + 0.1 * np.sin(5 * since(3.0))
    force = np.interp(t, [0.5, 1.0, 1.5], [0.0, 40.0, 0.0]) + 20 * ((t >= 2.0) & (t < 2.4))
    assert result.values == pytest.approx(np.array([load / 4 + force / 400, load]), abs=1e-14)
    assert nothing_happens_at_zero(result.motion)
    # Jumps of (u, x) and of their velocities: u' by the change of F'/400, u by F/400, x' by 1.5/3 and u' by a quarter.
    known = {
        0.5: (0, 0, 0.2, 0),
        1.0: (0, 0, -0.4, 0),
        1.5: (0, 0, 0.2, 0),
        2.0: (0.05, 0, 0, 0),
        2.4: (-0.05, 0, 0, 0),
        3.0: (0, 0, 0.125, 0.5),
    }
    assert {event.time: pytest.approx(event.jump.ravel(), rel=1e-14, abs=0) for event in result.motion.events} == known
    assert not any(event.impulses for event in result.motion.events)


def test_flexible_joint_has_two_frequencies():
    # a q'''' + b q'' + g q = 1 from q = 0.1 at rest: q = 1/g + c1 cos w1 t + c2 cos w2 t with c1 + c2 = 0.1 - 1/g and
    # c1 w1^2 + c2 w2^2 = 0.
    a, b, g = 0.05 * 0.5 / 200, 0.5 + 0.05 + 0.05 * 5 / 200, 5.0
    root = math.sqrt(b * b - 4 * a * g)
    slow, fast = 2 * g / (b + root), (b + root) / (2 * a)  # squares of the frequencies
    result = run("flexible_joint")
    t, offset = result.times, 0.1 - 1 / g
    expected = 1 / g + offset * (fast * np.cos(math.sqrt(slow) * t) - slow * np.cos(math.sqrt(fast) * t)) / (fast - slow)
    assert result.values[0] == pytest.approx(expected, abs=1e-13)
    assert [zero.value.imag for zero in result.finite_pair.zeros] == pytest.approx([math.sqrt(slow), math.sqrt(fast)], rel=1e-12)


def test_flexible_joint_agrees_with_its_two_bodies():
    # The same joint before the angle of the motor was eliminated, as link and motor on a spring.
    from mbconstrained.mechanics.system import MechanicalSystem
    from mbconstrained.signals.inputs import step

    result = run("flexible_joint")
    motor = 0.1 + 5 * 0.1 / 200  # q + (M q'' + G q)/K with q'' = 0
    pair = MechanicalSystem(np.diag([0.5, 0.05]), stiffness=[[205.0, -200.0], [-200.0, 200.0]])
    motion = pair.solve([0.1, motor], force=step([0.0, 1.0]))
    assert motion(result.times)[0] == pytest.approx(result.values[0], abs=1e-12)


@pytest.mark.parametrize(
    ("settings", "damper", "height"), [({}, 1200.0, 0.015), ({"damper": "3 kN*s/m", "height": "1 cm"}, 3000.0, 0.01)]
)
def test_the_quarter_car_takes_the_bump_of_its_parameters(settings, damper, height):
    """Against a Runge-Kutta method that is started anew at both ends of the bump."""
    result = run("quarter_car", settings)
    stiffness, damping = np.array([[200e3, -20e3], [-20e3, 20e3]]), damper * np.array([[1.0, -1.0], [-1.0, 1.0]])
    mass = np.array([40.0, 300.0])
    state = np.zeros(4)
    for begin, end, road in ((0.25, 0.37, height), (0.37, 2.0, 0.0)):
        force = np.array([180e3 * road, 0.0])

        def rate(t, y, force=force):
            return np.concatenate([y[2:], (force - stiffness @ y[:2] - damping @ y[2:]) / mass])

        state = solve_ivp(rate, (begin, end), state, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
        assert result.motion(end)[1:] == pytest.approx(state[:2], abs=1e-10)
    assert [event.jump[0].tolist() for event in result.motion.events] == [[height, 0, 0], [-height, 0, 0]]  # of the road alone
    assert not result.motion(np.nextafter(0.25, 0)).any() and not any(notice.doubtful for notice in result.notices)
    times = np.linspace(0.0, 2.0, 20001)
    road = height * ((times >= 0.25) & (times < 0.37))
    assert (180e3 * (result.motion(times)[1] - road)).max() < 340 * 9.81  # a tyre does not pull: it stays on the road


def test_every_example_is_in_the_index_and_has_a_test():
    names = {path.name for path in EXAMPLES.glob("*.toml")}
    assert set(re.findall(r"\((\w+\.toml)\)", (EXAMPLES / "README.md").read_text("utf-8"))) == names


def test_pitch_and_bounce():
    """The rows x_point = x + d q, put in by hand, leave two equations in bounce and pitch; their values by an exponential."""
    result = run("pitch_and_bounce")
    m, J, k, c, d = 1200.0, 1500.0, np.array([35e3, 30e3]), np.array([1500.0, 1500.0]), np.array([-1.5, 1.2])
    points = np.column_stack([np.ones(2), d])
    M, C, K = np.diag([m, J]), points.T @ np.diag(c) @ points, points.T @ np.diag(k) @ points
    start = np.linalg.solve(points, [0.0, 0.05])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    step = expm(A * result.times[1])
    states = [np.concatenate([start, np.zeros(2)])]
    for _ in result.times[1:]:
        states.append(step @ states[-1])
    minimal = np.array(states).T[:2]
    assert result.values == pytest.approx(np.vstack([minimal, points @ minimal]), abs=1e-13)
    values = np.linalg.eigvals(A)
    frequencies = np.sort(np.abs(values[values.imag > 0])) / (2 * math.pi)
    assert result.modes.frequencies_hz == pytest.approx(frequencies, rel=1e-12)
    # undamped: (k11 - m w^2)(k22 - J w^2) = k12^2, a quadratic equation in w^2
    undamped = run("pitch_and_bounce", {"model.damper": []}).modes.natural_frequencies
    k11, k12, k22 = K[0, 0], K[0, 1], K[1, 1]
    mean, half = (k11 / m + k22 / J) / 2, (k11 / m - k22 / J) / 2
    root = math.sqrt(half**2 + k12**2 / (m * J))
    assert undamped**2 == pytest.approx([mean - root, mean + root], rel=1e-12)
    assert nothing_happens_at_zero(result.motion) and result.is_trusted


def test_reservoirs_follow_their_recursion():
    result = run("reservoirs")
    upper, lower = 2.0, 0.0
    for k in result.numbers:
        assert result.values[:, k] == pytest.approx([upper, lower, upper + lower], rel=1e-13, abs=1e-14)
        upper, lower = 0.8 * upper + np.cos(0.1 * np.pi * k), 0.1 * upper + 0.9 * lower
    assert result.is_trusted and result.error_estimate < 1e-15


def test_samples_of_the_quarter_car_lie_on_its_continuous_motion():
    result = run("sampled_quarter_car")
    motion = result.scene.equations.solve()
    assert result.values == pytest.approx(motion.displacement(result.times), abs=1e-12 * np.abs(result.values).max())


def test_chosen_gripper_follows_the_choice_and_drags_the_arm():
    """2 x'' + 4 x' + 200 x = 200 g; on the ramp g = 0.1 t the arm is behind by 4 * 0.1 / 200, and swings with 9.95 rad/s."""
    result = run("chosen_gripper")
    t = np.linspace(0.0, 1.0, 30)
    arm, gripper, tool = result.motion(t)
    decay, w = 1.0, np.sqrt(99.0)
    free = np.exp(-decay * t) * (0.002 * np.cos(w * t) + (0.002 - 0.1) / w * np.sin(w * t))  # x(0) = 0, x'(0) = 0
    np.testing.assert_allclose(arm, 0.1 * t - 0.002 + free, atol=1e-14)
    np.testing.assert_allclose([gripper, tool], [0.1 * t, (arm + 0.1 * t) / 2], atol=1e-14)
    assert any('"gauge" follows from the others' in notice.text for notice in result.notices)


def test_every_scene_has_a_thumbnail_in_the_index():
    names = {path.stem for path in EXAMPLES.glob("*.toml")}
    pictures = {path.stem: path.read_bytes() for path in (EXAMPLES / "thumbnails").glob("*")}
    assert set(pictures) == names, "python examples/thumbnails.py NAME.toml makes one"
    assert set(re.findall(r'src="thumbnails/(\w+)\.png"', (EXAMPLES / "README.md").read_text("utf-8"))) == names
    assert all(content[1:4] == b"PNG" and len(content) <= 25_000 for content in pictures.values())
    tested = "".join((Path(__file__).parent / file).read_text("utf-8") for file in TESTS)
    assert [name for name in sorted(names) if f'"{name}"' not in tested and f'"{name}.toml"' not in tested] == []


def test_every_example_says_what_it_is():
    for path in EXAMPLES.glob("*.toml"):
        tables = tomllib.loads(path.read_text("utf-8"))
        assert tables["title"] and tables["source"] and path.read_text("utf-8").startswith("# "), path.name


def test_the_stiff_stack_follows_its_soft_spring():
    """Screws of 1e16 N/m make the slow frequency 1 rad/s smaller by 1e-16 of it: over 1000 periods that is 1e-12 rad."""
    result = run("stiff_stack")
    times = 2 * math.pi * np.array([0.0, 0.25, 1.0, 999.6, 1000.0])
    assert np.abs(result.motion(times) - 0.01 * np.cos(times)).max() <= 0.01 * 1e-11
    assert result.modes.natural_frequencies[0] == pytest.approx(1.0, rel=1e-14)
    assert result.is_trusted and nothing_happens_at_zero(result.motion)
    total = result.curves("energy").values[-1]  # 4 N/m, 1 cm
    assert np.abs(total - 2e-4).max() <= 2e-4 * 1e-9
