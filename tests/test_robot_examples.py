"""Every robot example against mechanics written down here: other coordinates, closed forms, mpmath; never pinocchio."""

import math
from functools import cache

import mpmath
import numpy as np
import pytest
import scipy.linalg
from mpmath import mpf

from mbconstrained.scene.run.scene import read_scene
from tests.test_examples import EXAMPLES, nothing_happens_at_zero

G = 9.81


@cache
def run(name):
    return read_scene(EXAMPLES / f"{name}.toml").run()


def bar(mass, length, height):
    """Moment of inertia of a box about its middle, across its length."""
    return mass * (length**2 + height**2) / 12


def pendulum_inertia():
    """About the pivot: a cylinder of 0.2 kg, radius 10 mm, length 0.5 m, and a ball of 1 kg with the radius 50 mm."""
    return 0.2 * (3 * 0.01**2 + 0.5**2) / 12 + 0.2 * 0.25**2 + 0.4 * 0.05**2 + 0.5**2


def test_pendulum_swings_in_closed_form():
    # J a'' + 0.02 a' + g (0.2 0.25 + 1 0.5) a = 0
    result = run("pendulum")
    J, t = pendulum_inertia(), result.times
    rate, start = 0.02 / (2 * J), math.radians(8)
    w = math.sqrt(G * (0.2 * 0.25 + 0.5) / J - rate**2)
    assert result.values[0] == pytest.approx(start * np.exp(-rate * t) * (np.cos(w * t) + rate / w * np.sin(w * t)), abs=1e-12)
    assert not result.system.rows and nothing_happens_at_zero(result.motion)


def test_double_pendulum_beats():
    # Absolute angles a, b of the bars: b - a is the elbow's.
    upper, lower = bar(0.8, 0.4, 0.05) + 0.8 * 0.2**2 + 0.5 * 0.4**2, bar(0.5, 0.3, 0.04) + 0.5 * 0.15**2
    M = np.array([[upper, 0.5 * 0.4 * 0.15], [0.5 * 0.4 * 0.15, lower]])
    K = np.diag([G * (0.8 * 0.2 + 0.5 * 0.4), G * 0.5 * 0.15])
    squares, shapes = scipy.linalg.eigh(K, M)
    result = run("double_pendulum")
    weights = shapes.T @ M @ [0, math.radians(12)]
    a, b = shapes @ (weights[:, None] * np.cos(np.sqrt(squares)[:, None] * result.times))
    assert result.values == pytest.approx(np.array([a, b - a]), abs=1e-11)
    assert result.modes.natural_frequencies == pytest.approx(np.sqrt(squares), rel=1e-12)
    assert result.curves("output").values[0] == pytest.approx(0.4 * a + 0.3 * b, abs=1e-11)


class Linkage:
    """A planar linkage as a function of one angle, in 40 digits.

    Args:
        bodies: angle -> list of (mass, inertia, x, z, direction).
        energy: angle -> potential energy of springs.
        damping: angle -> sum of damping times (velocity by rate of the angle)^2.
    """

    def __init__(self, bodies, guess, energy=lambda q: 0, damping=lambda q: 0):
        with mpmath.workdps(40):
            self.bodies = bodies
            self.energy = energy
            self.rest = mpmath.findroot(lambda q: mpmath.diff(self.potential, q), guess)
            self.mass = self._mass()
            self.stiffness = mpmath.diff(self.potential, self.rest, 2)
            self.damping = damping(self.rest)

    def potential(self, q):
        return self.energy(q) + sum(mpf(G) * body[0] * body[3] for body in self.bodies(q))

    def rate(self, number, entry):
        """How fast an entry of a body changes with the angle at rest."""
        return mpmath.diff(lambda q: self.bodies(q)[number][entry], self.rest)

    def _mass(self):
        total = mpf(0)
        for number, (mass, inertia, *_) in enumerate(self.bodies(self.rest)):
            x, z, turn = (self.rate(number, entry) for entry in (2, 3, 4))
            total += mass * (x**2 + z**2) + inertia * turn**2
        return total

    @property
    def zero(self) -> complex:
        with mpmath.workdps(40):
            rate = self.damping / (2 * self.mass)
            return complex(-rate, mpmath.sqrt(self.stiffness / self.mass - rate**2))


def meeting(a, r, b, s, side):
    """Where circles of radii r and s around the points a and b meet."""
    dx, dz = b[0] - a[0], b[1] - a[1]
    distance = mpmath.hypot(dx, dz)
    along = (distance**2 + r**2 - s**2) / (2 * distance)
    across = side * mpmath.sqrt(r**2 - along**2)
    return a[0] + (along * dx - across * dz) / distance, a[1] + (along * dz + across * dx) / distance


def rod(mass, height, start, end):
    """A bar from a point to another."""
    length = mpmath.hypot(end[0] - start[0], end[1] - start[1])
    direction = mpmath.atan2(end[1] - start[1], end[0] - start[0])
    inertia = mass * (length**2 + mpf(height) ** 2) / 12
    return mpf(mass), inertia, (start[0] + end[0]) / 2, (start[1] + end[1]) / 2, direction


def polar(length, angle):
    return length * mpmath.cos(angle), length * mpmath.sin(angle)


def four_bar(q):
    crank, rocker = polar(mpf("0.2"), q), (mpf("0.5"), mpf("0.1"))
    pin = meeting(crank, mpf("0.5"), rocker, mpf("0.35"), 1)
    return [rod(mpf("0.4"), "0.04", (0, 0), crank), rod(mpf("0.7"), "0.03", crank, pin), rod(mpf("0.6"), "0.04", rocker, pin)]


def trapezoid(q):
    """By the angle of the left crank from straight down."""
    left, right = (-mpf("0.15"), mpf(0)), (mpf("0.15"), mpf(0))
    start = (left[0] + mpf("0.4") * mpmath.sin(q), -mpf("0.4") * mpmath.cos(q))
    end = meeting(start, mpf("0.6"), right, mpf("0.4"), -1)
    return [rod(mpf("0.4"), "0.03", left, start), rod(mpf("1.5"), "0.03", start, end), rod(mpf("0.4"), "0.03", right, end)]


def slider_crank(q):
    crank = polar(mpf("0.15"), q)
    slider = (crank[0] + mpmath.sqrt(mpf("0.45") ** 2 - crank[1] ** 2), mpf(0))
    return [rod(mpf("0.5"), "0.03", (0, 0), crank), rod(mpf("0.6"), "0.025", crank, slider), (mpf("1.2"), mpf(0), *slider, mpf(0))]


def slide(q):
    return slider_crank(q)[2][2]


LINKAGES = {
    "four_bar": (four_bar, "crank pivot", 1.25, lambda q: 10 * (q - mpmath.radians(75)) ** 2, lambda q: mpf("0.01")),
    "trapezoid": (trapezoid, "left pivot", -0.38, lambda q: 0, lambda q: 0),
    "slider_crank": (
        slider_crank,
        "crank pivot",
        0.9,
        lambda q: 300 * (mpf("0.89") - slide(q) - mpf("0.05") - mpf("0.32")) ** 2,
        lambda q: 5 * mpmath.diff(slide, q) ** 2,
    ),
}


@cache
def linkage_of(name):
    bodies, _, guess, energy, damping = LINKAGES[name]
    return Linkage(bodies, guess, energy, damping)


@pytest.mark.parametrize("name", LINKAGES)
def test_a_linkage_is_its_one_angle(name):
    linkage, joint, result = linkage_of(name), LINKAGES[name][1], run(name)
    posture = result.scene.equations.posture
    assert posture[joint] == pytest.approx(float(linkage.rest), abs=1e-12)
    (mode,) = result.modes
    assert mode.eigenvalue == pytest.approx(linkage.zero, rel=1e-10)
    assert posture.residual < 1e-12 and posture.loop_error < 1e-14
    assert any(notice.kind == "redundant" for notice in result.notices)


def test_four_bar_answers_the_impulse_as_one_mass():
    linkage, result = linkage_of("four_bar"), run("four_bar")
    t, zero = result.times, linkage.zero
    expected = 0.02 / float(linkage.mass) / zero.imag * np.exp(zero.real * t) * np.sin(zero.imag * t)
    assert result.values[0] == pytest.approx(expected, abs=1e-10 * abs(expected).max())
    middle = [float(linkage.rate(1, entry)) for entry in (2, 3)]
    assert result.curves("output").values == pytest.approx(np.outer(middle, expected), abs=1e-10 * abs(expected).max())


def test_swing_is_one_pendulum_on_the_stiffness_of_its_pins():
    result = run("parallelogram")
    crank = bar(0.4, 0.4, 0.03) + 0.4 * 0.2**2
    w = math.sqrt(G * (2 * 0.4 + 0.4 * 0.4) / (2 * 0.4**2 + 2 * crank))
    assert result.modes.natural_frequencies == pytest.approx([w], rel=1e-12)
    angle = 0.1 * np.cos(w * result.times)
    assert result.values == pytest.approx(np.array([angle, angle, 0.4 * angle, 0 * angle, 0 * angle]), abs=1e-12)
    assert nothing_happens_at_zero(result.motion)
    forces = result.scene.equations.posture.reactions
    assert np.array([forces["left pin"], forces["right pin"]])[:, :3] == pytest.approx(np.array([[0, 0, G]] * 2), abs=1e-12)


def test_trapezoid_swings_after_the_push():
    # On its one angle the push is 5 N dx/dq from t = 0 on, and the opposite from 0.1 s on.
    linkage, result = linkage_of("trapezoid"), run("trapezoid")
    middle = float(linkage.rate(1, 2))
    w, t, a = linkage.zero.imag, result.times, 5 * middle / float(linkage.mass)
    since = np.maximum(t - 0.1, 0.0)
    angle = a / w**2 * ((1 - np.cos(w * t)) - (1 - np.cos(w * since)))
    assert result.values[0] == pytest.approx(angle, abs=1e-11)
    assert result.curves("output").values[0] == pytest.approx(middle * angle, abs=1e-11)


def test_slider_crank_moves_off_when_it_is_loaded():
    linkage, result = linkage_of("slider_crank"), run("slider_crank")
    by_angle = float(linkage.rate(2, 2))
    zero, since = linkage.zero, np.maximum(result.times - 0.2, 0.0)
    decay = np.exp(zero.real * since) * (np.cos(zero.imag * since) - zero.real / zero.imag * np.sin(zero.imag * since))
    expected = 3 * by_angle / float(linkage.stiffness) * (1 - decay)
    names = list(result.scene.equations.coordinates.names)
    assert result.values[names.index("crank pivot")] == pytest.approx(expected, abs=1e-10)
    assert result.values[names.index("slide")] == pytest.approx(by_angle * expected, abs=1e-10)


def delta_arms(q):
    """A third of the delta robot in its own plane, by the angle of its arm: arm, two rods, a third of the platform."""
    elbow = (mpf("0.2") + mpf("0.25") * mpmath.cos(q), -mpf("0.25") * mpmath.sin(q))
    down = elbow[1] - mpmath.sqrt(mpf("0.25") - (elbow[0] - mpf("0.08")) ** 2)
    arm, rods = rod(mpf("0.3"), "0.03", (mpf("0.2"), 0), elbow), rod(mpf("0.16"), "0", elbow, (mpf("0.08"), down))
    thick = rods[1] + mpf("0.16") * 3 * mpf("0.006") ** 2 / 12
    return [arm, (rods[0], thick, *rods[2:]), (mpf("0.5") / 3, mpf(0), mpf(0), down, mpf(0))]


def test_delta_moves_up_and_down_as_one_arm_and_sidewards_alike_in_all_directions():
    result = run("delta")
    arm = Linkage(delta_arms, 0.3, lambda q: 30 * (q - mpmath.radians(16)) ** 2, lambda q: mpf("0.05"))
    assert result.scene.equations.posture["arm A drive"] == pytest.approx(float(arm.rest), abs=1e-10)
    zeros = sorted((mode.eigenvalue for mode in result.modes), key=abs)
    counts = {mode.eigenvalue: mode.count if hasattr(mode, "count") else mode.multiplicity for mode in result.modes}
    assert zeros[-1] == pytest.approx(arm.zero, rel=1e-9)
    sidewards = zeros[:-1]
    assert sum(counts[zero] for zero in sidewards) == 2 and sidewards[0] == pytest.approx(sidewards[-1], rel=1e-7)
    # Under the load of 5 N, a third on each arm, the platform goes down by the flexibility of the arms.
    down = float(arm.rate(2, 3))
    middle = result.curves("output").values[1, result.times <= 0.8]
    zero, t = arm.zero, result.times[result.times <= 0.8]
    decay = np.exp(zero.real * t) * (np.cos(zero.imag * t) - zero.real / zero.imag * np.sin(zero.imag * t))
    assert middle == pytest.approx(-5 / 3 * down**2 / float(arm.stiffness) * (1 - decay), abs=1e-9 * abs(middle).max())


ARM = [
    (0.17, 3.5, 0.065),
    (0.2, 3.0, 0.06),
    (0.2, 2.6, 0.055),
    (0.2, 2.2, 0.055),
    (0.2, 1.8, 0.05),
    (0.08, 1.2, 0.045),
    (0.08, 0.4, 0.03),
]
ARM_ANGLES = np.radians([20, 40, 15, -70, 10, 50, 0])


def turned(axis, angle):
    return scipy.linalg.expm(np.cross(np.eye(3), axis) * angle)


def arm_bodies(angles=ARM_ANGLES):
    """Of each link: mass, inertia matrix, middle; of each joint: axis and place; where the tip of the tool is."""
    R, place, bodies, joints = np.eye(3), np.array([0, 0, 0.1]), [], []
    for number, ((length, mass, radius), angle) in enumerate(zip(ARM, angles)):
        axis = np.array([0, 0, 1] if number % 2 == 0 else [0, 1, 0])
        joints.append((R @ axis, place))
        R = R @ turned(axis, angle)
        own = np.diag([mass * (3 * radius**2 + length**2) / 12] * 2 + [mass * radius**2 / 2])
        bodies.append((mass, R @ own @ R.T, place + R @ [0, 0, length / 2]))
        place = place + R @ [0, 0, length]
    return bodies, joints, place


def arm_jacobian(point, joints, count):
    columns = [np.cross(axis, point - place) if i < count else np.zeros(3) for i, (axis, place) in enumerate(joints)]
    return np.array(columns).T


def arm_mass_and_weight(angles=ARM_ANGLES):
    """M of the links, and the torques of gravity."""
    bodies, joints, _ = arm_bodies(angles)
    M, weight = np.zeros((7, 7)), np.zeros(7)
    for count, (mass, inertia, middle) in enumerate(bodies, 1):
        J, W = arm_jacobian(middle, joints, count), np.array([axis * (i < count) for i, (axis, _) in enumerate(joints)]).T
        M += mass * J.T @ J + W.T @ inertia @ W
        weight += mass * G * J[2]
    return M, weight


def test_arm_is_in_equilibrium_and_moves_off_with_the_impulse():
    result = run("seven_joint_arm")
    _, joints, tip = arm_bodies()
    M, weight = arm_mass_and_weight()
    posture = result.scene.equations.posture
    assert [posture.torques[f"j{i}"] for i in range(1, 8)] == pytest.approx(weight, abs=1e-10)
    push = arm_jacobian(tip, joints, 7)
    speed = np.linalg.solve(M, push.T @ [0, 0.5, 0])  # the motors do not feel the impulse before their gears are wound up
    assert result.motion.jump[1] == pytest.approx(np.concatenate([speed, np.zeros(7)]), abs=1e-10)
    tool = result.scene.equations.robot_scene.system.output_matrix
    assert tool[:, :7] == pytest.approx(push, abs=1e-12)
    assert len(result.system.names) == 14 and max(mode.eigenvalue.real for mode in result.modes) < 0


#: By joint: stiffness and damping of the gear, inertia of the motor after the gear, gains of its control (N m/rad, N m s/rad, kg m^2).
DRIVES = np.array(
    [[12000, 8, 0.4, 3000, 40]] * 2 + [[9000, 6, 0.3, 2500, 30]] * 2 + [[5000, 4, 0.2, 1200, 14]] * 2 + [[4000, 3, 0.1, 600, 5]]
)


def arm_frequencies(angles):
    """Natural frequencies in Hz, ascending: links with their weight, gears, motors with their controls."""
    M, _ = arm_mass_and_weight(angles)
    steps, weights = np.eye(7) * 1e-2, (4 / 5, -1 / 5, 4 / 105, -1 / 280)
    pull = [
        sum(
            w * (arm_mass_and_weight(angles + i * h)[1] - arm_mass_and_weight(angles - i * h)[1]) / 1e-2
            for i, w in enumerate(weights, 1)
        )
        for h in steps
    ]
    k, c, motor, p, d = (np.diag(column) for column in DRIVES.T)
    zero = np.zeros((7, 7))
    K = np.block([[k + np.array(pull), -k], [-k, k + p]])
    C = np.block([[c + 0.2 * np.eye(7), -c], [-c, c + d]])  # 0.2 N m s/rad in each bearing
    mass = np.block([[M, zero], [zero, motor]])
    lower = -np.linalg.solve(mass, np.hstack([K, C]))
    values = np.linalg.eigvals(np.vstack([np.hstack([np.zeros((14, 14)), np.eye(14)]), lower]))
    return np.sort(np.abs(values[values.imag > 0])) / (2 * np.pi)


@pytest.mark.long
def test_arm_workspace_has_the_frequencies_of_each_posture():
    """The corners and the middle of the map; stretched, the arm is slowest, and the shoulder hardly matters."""
    scene = read_scene(EXAMPLES / "arm_workspace.toml")
    shoulder, elbow = np.radians([0, 45, 90]), np.radians([-135, -67.5, 0])
    result = scene.sweep({"model.guess.j2": list(shoulder), "model.guess.j4": list(elbow)}).run()
    first, second = (result.values(f"frequency {number}").reshape(3, 3) for number in (1, 2))
    for i, j2 in enumerate(shoulder):
        for j, j4 in enumerate(elbow):
            angles = np.radians([20, 0, 15, 0, 10, 50, 0]) + np.array([0, j2, 0, j4, 0, 0, 0])
            assert [first[i, j], second[i, j]] == pytest.approx(arm_frequencies(angles)[:2], rel=1e-9)
    assert (first.argmin(axis=1) == 2).all()
    assert np.ptp(first, axis=0).max() < 0.03 * np.ptp(first)
    assert (np.diff(second[:, 2]) < 0).all()


def test_satellite_comes_to_rest_at_another_angle():
    result = run("satellite")
    mass, reach = 18.0, 1.2
    panel = bar(mass, 2.4, 0.03) + mass * reach**2  # about its hinge, which is 0.6 m from the middle
    both = 2 * (panel + mass * reach * 0.6)
    whole = bar(200.0, 1.0, 1.4) + 2 * (bar(mass, 2.4, 0.03) + mass * (reach + 0.6) ** 2)
    total = 200.0 + 2 * mass
    turning = 2 * panel - both**2 / whole  # panels turn alike, the body against them
    flapping = 2 * panel - (2 * mass * reach) ** 2 / total  # panels turn to each other, the body goes up and down
    modes = [mode for mode in result.modes if mode.eigenvalue.imag]
    found = sorted((mode.eigenvalue for mode in modes), key=abs)
    for value, inertia in zip(found, sorted((turning, flapping), reverse=True)):
        rate = 2 * 0.3 / (2 * inertia)
        assert value == pytest.approx(complex(-rate, math.sqrt(2 * 40 / inertia - rate**2)), rel=1e-11)
    # The angular momentum is 1.4 N m times 4 s for 12 s, with 4 s up and 4 s down: its integral is 89.6 N m s^2.
    names = list(result.scene.equations.coordinates.names)
    body, left, right = (result.values[names.index(name)] for name in ("base rx", "left hinge", "right hinge"))
    assert left == pytest.approx(right, abs=1e-10)
    after = result.times >= 20
    assert (whole * body + both * left)[after] == pytest.approx(np.full(after.sum(), 89.6), rel=1e-9)


def test_quadruped_stands_on_its_four_feet():
    result = run("quadruped")
    posture, total = result.scene.equations.posture, 12 + 4 * (0.5 + 0.8 + 0.25)
    forces = []
    for leg in ("front left", "front right", "rear left", "rear right"):
        force = -posture.reactions[f"{leg} foot"][:3]  # on the shin, in its frame
        pitch = posture[f"{leg} swing"] + posture[f"{leg} knee"] + trunk_pitch(posture)
        forces.append(turned([0, 1, 0], pitch) @ force)
    forces = np.array(forces)
    assert forces.sum(axis=0) == pytest.approx([0, 0, total * G], abs=1e-9)
    feet = np.array([[0.2, 0.15], [0.2, -0.15], [-0.2, 0.15], [-0.2, -0.15]])
    torque = (np.column_stack([feet, np.zeros(4)])[:, [1, 0]] * forces[:, [2, 2]]).sum(axis=0)
    assert torque[0] == pytest.approx(0, abs=1e-9) and abs(torque[1]) < 0.2 * total * G * 0.2
    assert len([mode for mode in result.modes if mode.eigenvalue.imag]) == 6


def trunk_pitch(posture):
    return 2 * math.atan2(*posture.joints["base"][4:7:2])


def engine_energy(height, across, stiffness):
    """V(x, z, turn) of the block in a plane: mounts that are pushed along its own axes, and its weight."""

    def energy(x, z, turn):
        total = mpf(150) * mpf(G) * z
        for side in (-across, across):
            gap = (side - x, -height - z)  # from the middle of the block to where the mount stands
            c, s = mpmath.cos(turn), mpmath.sin(turn)
            own = (c * gap[0] + s * gap[1] - side, -s * gap[0] + c * gap[1] + height)
            total += 2 * (stiffness[0] * own[0] ** 2 + stiffness[1] * own[1] ** 2) / 2
        return total

    return energy


@pytest.mark.parametrize(("across", "extent"), [(mpf("0.25"), (0.6, 0.4)), (mpf("0.2"), (0.5, 0.4))], ids=["pitch", "roll"])
def test_engine_rocks_on_its_mounts(across, extent):
    found = np.array([abs(mode.eigenvalue) for mode in run("engine").modes])
    energy, inertia = engine_energy(mpf("0.2"), across, (mpf(120_000), mpf(250_000))), bar(150, *extent)
    with mpmath.workdps(30):
        sag = -150 * mpf(G) / (4 * 250_000)
        second = {order: mpmath.diff(energy, (0, sag, 0), order) for order in ((2, 0, 0), (1, 0, 1), (0, 0, 2), (0, 2, 0))}
    K = np.array([[second[2, 0, 0], second[1, 0, 1]], [second[1, 0, 1], second[0, 0, 2]]], dtype=float)
    for square in (*scipy.linalg.eigvalsh(K, np.diag([150.0, inertia])), float(second[0, 2, 0]) / 150):
        # Damping is nearly proportional to the stiffness and turns the zero, hardly changing its size.
        assert np.abs(found / math.sqrt(square) - 1).min() < 1e-4


def test_engine_settles_into_the_period_of_its_crankshaft():
    result = run("engine")
    late = result.scene.equations.solve()
    t = np.linspace(30, 31, 50)
    period = 60 / 750
    values = late(t)
    assert values == pytest.approx(late(t + period), abs=1e-9 * np.abs(values).max())


def test_the_flexible_arm_turns_by_the_torque_of_least_energy():
    """Two inertias on an elastic shaft; the Gramian by an exponential with 40 digits."""
    arm, motor, k, c = 0.1618 + 3 * 0.4**2 + 0.003 + 2 * 0.8**2, 40e-6 * 100**2, 400.0, 0.5
    result = run("flexible_arm")
    with mpmath.workdps(40):
        A, B = mpmath.zeros(4), mpmath.matrix([0, 0, 0, 1 / mpf(motor)])
        for row, inertia, sign in ((2, arm, -1), (3, motor, 1)):
            for column, (first, second) in enumerate(((k, -k), (c, -c))):
                A[row, 2 * column], A[row, 2 * column + 1] = sign * first / mpf(inertia), sign * second / mpf(inertia)
        A[0, 2] = A[1, 3] = 1
        whole = mpmath.zeros(8)
        whole[:4, :4], whole[:4, 4:], whole[4:, 4:] = -A, B * B.T, A.T
        exponential = mpmath.expm(whole)
        W = exponential[4:, 4:].T * exponential[:4, 4:]
        end = mpmath.matrix([mpmath.pi / 2, mpmath.pi / 2, 0, 0])
        weights = mpmath.lu_solve(W, end)
        energy = (end.T * weights)[0]
        torque = [float((B.T * mpmath.expm(A.T * (1 - mpf(t))) * weights)[0]) for t in (0, 0.25, 0.75)]
    own = result.to_dict()["least_energy"]
    assert own["energy"] == pytest.approx(float(energy), rel=1e-11) and own["unit"] == "N^2 m^2 s" and own["error_at_end"] < 1e-12
    assert result.curves("force").names == ("shoulder motor",)
    assert result.functions("force")(np.array([0.0, 0.25, 0.75]))[0] == pytest.approx(torque, rel=1e-10)
    after = np.linspace(1.0, 1.5, 11)
    assert not result.functions("force")(after).any()
    assert np.abs(result.motion(after) - math.pi / 2).max() < 1e-12 > np.abs(result.motion.derivative()(after)).max() / 100
    assert not result.notices
