"""The closed-form answer against the nonlinear motion (reference.py, DOP853): apart by the square of the amplitude.

If x is the linear answer and y the true motion from the same start of size a, then y - x = O(a^2). A wrong stiffness,
damping or mass leaves y - x = O(a), and (y - x) / a^2 would grow tenfold from each amplitude to the next.
"""

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp

import mbconstrained as mb
from tests.robot.linkages import BUILDERS, PLANE, Linkage, allowed, bar, given, joint, link, linkage, urdf

AMPLITUDES = (1e-3, 1e-4)


def floating_arm() -> Linkage:
    """A free body on a bushing, with two joints on springs, under its weight: eight frequencies."""
    model = urdf(
        link("hull", 3.0, (0.05, 0.02, -0.1), (0.1, 0.15, 0.12)),
        bar("upper", 0.8, 0.6, 0.01),
        link("lower", 0.5, (0.2, 0.1, 0), (0.004, 0.006, 0.005, 0.001, 0, 0)),
        joint("j1", "hull", "upper", at=(0.2, 0, 0.1), turned=(0.3, -0.2, 0.5), axis=(0, 1, 0)),
        joint("j2", "upper", "lower", "continuous", at=(0.6, 0, 0), axis=(1, 0, 1)),
    )
    stiff = {"stiffness": (300.0, 400.0, 900.0), "turning_stiffness": (60.0, 50.0, 40.0)}
    damp = {"damping": (1.0, 0.5, 2.0), "turning_damping": (0.2, 0.1, 0.3)}
    turned = {"rotation1": (0.2, 0.1, 0.0), "rotation2": (0.2, 0.1, 0.0)}
    mount = mb.Bushing("hull", (0, 0, 0.3), "ground", (0, 0, 0.3), name="mount", **stiff, **damp, **turned)
    options = {"joint_stiffness": {"j1": 12.0, "j2": 6.0}, "joint_rest": {"j1": -0.4, "j2": 0.5}, "joint_damping": {"j2": 0.05}}
    return linkage(model, {"j1": -0.3, "j2": 0.4}, base="free", springs=[mount], **options)


NAMES = (
    "double pendulum", "four-bar", "four-bar with dampers", "trapezoid", "slider-crank", "six-bar", "strut", "spatial loop", "sunk bushing"
)  # fmt: skip
LARGE = [pytest.param(name, marks=pytest.mark.long) for name in ("platform on springs", "floating arm")]


def of_name(name: str) -> Linkage:
    return floating_arm() if name == "floating arm" else BUILDERS[name](given(name))


def true_states(reference, q0, q, times) -> list:
    """(q, v) at the times, from rest at q."""
    model = reference.model

    def slope(_, y):
        q, v = pin.normalize(model, y[: model.nq]), y[model.nq :]
        return np.concatenate([pin.tangentMap(model, q) @ v, reference.acceleration(q, v, 0.0)])

    begin = np.concatenate([q, np.zeros(model.nv)])
    # the error of a step is measured against the deviation, not against q
    size = np.abs(pin.difference(model, q0, q)).max()
    actual = solve_ivp(slope, (0, times[-1]), begin, "DOP853", times, rtol=1e-12, atol=1e-9 * size)
    return [(pin.normalize(model, y[: model.nq]), y[model.nq :]) for y in actual.y.T]


def transported(reference, q, v, rows) -> np.ndarray:
    """What the loops carry in the true motion: force on body 2 in the frame on body 1, in the order of the rows' names."""
    pulls = reference.motion(q, v, 0.0)[1].reshape(-1, 3)
    reference.place(q)
    turned = {loop.name: reference.ends(loop)[0].turn.T @ pull for loop, pull in zip(reference.loops, pulls)}
    return in_rows(turned, rows)


def in_rows(forces: dict, rows) -> np.ndarray:
    """Entries of the forces by loop, for rows that are named "<loop> x" and so on."""
    return np.array([forces[row[:-2]]["xyz".index(row[-1])] for row in rows])


@pytest.mark.parametrize("name", [*NAMES, *LARGE])
def test_motion_and_reactions_are_off_by_the_square_of_the_amplitude(name):
    """Over a period of the slowest mode. The frame on the first body turns with it: statics plus multipliers are components there."""
    described = of_name(name)
    robot, guess = described
    posture = robot.equilibrium(guess)
    reference, system = described.reference(), robot.linearize(posture)
    rows, N = [row.name for row in system.rows], allowed(system)
    places = [reference.coordinates.index(coordinate) for coordinate in robot.coordinates]
    base = posture.configuration[:7] if reference.base == "free" else None
    q0 = reference.closed(reference.configuration(posture.joints, base))
    direction = N @ np.random.default_rng(1).normal(size=N.shape[1])
    times = np.linspace(0, 2 * np.pi / system.modes().natural_frequencies[0], 40)
    apart = []
    for amplitude in AMPLITUDES:
        d = np.zeros(len(places))
        d[places] = amplitude * direction / np.abs(direction).max()
        begin = reference.closed(pin.integrate(reference.model, q0, d))
        motion = system.solve(displacement=N @ (N.T @ pin.difference(reference.model, q0, begin)[places]))
        states = true_states(reference, q0, begin, times)
        true = np.array([pin.difference(reference.model, q0, q)[places] for q, _ in states]).T
        errors = [np.abs(true - motion(times)).max()]
        if rows:
            carried = np.array([transported(reference, q, v, rows) for q, v in states]).T
            errors.append(np.abs(carried - in_rows(posture.reactions, rows)[:, None] - motion.reaction(times)).max())
        apart.append(np.array(errors) / amplitude**2)
    assert apart[0][0] < 10  # radians per radian squared
    assert (np.max(apart, axis=0) < 1.1 * np.min(apart, axis=0)).all()


def test_elastic_arm_is_off_by_the_square_of_the_amplitude():
    # M(q) q'' + h(q, q') = (k + c d/dt)(theta - q), B theta'' = tau - k_p theta - ... : Spong's equations, by hand
    p = given("flexible arm with PD")
    described = of_name("flexible arm with PD")
    robot, guess = described
    posture = robot.equilibrium(guess, hold="all")
    system = robot.linearize(posture)
    model = Linkage(described.text, {"gravity": PLANE}, {}).reference()
    q0 = np.array(p["guess"])
    k, c = np.array(p["flexibility"]), np.array(p["flexible_damping"])
    B = np.array(p["motor_inertia"]) * np.array(p["gear_ratio"]) ** 2
    kp, kd = np.array(p["proportional_gain"]), np.array(p["derivative_gain"])
    fixed = -model.applied(q0)
    motor0 = q0 + fixed / k
    assert [posture.torques[name] for name in ("j1", "j2")] == pytest.approx(fixed, rel=1e-12)

    def slope(_, y):
        q, m, v, w = y.reshape(4, 2)
        gear = k * (m - q) + c * (w - v)
        turn = model.acceleration(q, v, gear)
        return np.concatenate([v, w, turn, (fixed - kp * (m - motor0) - kd * w - gear) / B])

    times = np.linspace(0, 1.5, 40)
    direction = np.array([1.0, -0.6, 0.4, 0.8])
    actual = []
    for amplitude in AMPLITUDES:
        begin = np.concatenate([q0, motor0, np.zeros(4)]) + np.concatenate([amplitude * direction, np.zeros(4)])
        y = solve_ivp(slope, (0, times[-1]), begin, "DOP853", times, rtol=1e-12, atol=1e-9 * amplitude).y
        linear = system.solve(displacement=amplitude * direction)(times)
        actual.append(np.abs(y[:4] - np.concatenate([q0, motor0])[:, None] - linear).max() / amplitude**2)
    assert max(actual) < 10 and max(actual) < 1.1 * min(actual)
