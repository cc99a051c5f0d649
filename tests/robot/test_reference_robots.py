"""The same machine described in two ways moves in one way: units, joints, frames, locks, motors, levels."""

import numpy as np
import pinocchio as pin
import pytest

import mbconstrained as mb
from tests.robot import linkages
from tests.robot.linkages import (
    BUILDERS,
    GROUND,
    PLANE,
    allowed,
    given,
    joint,
    known_frequencies,
    linearized,
    link,
    linkage,
    null_space,
    urdf,
)
from tests.robot.random_robots import random_case

# ---------------------------------------------------------------- units


@pytest.mark.parametrize("mass", [1e-9, 1e6])
@pytest.mark.parametrize("length", [1e-6, 1e4])
@pytest.mark.parametrize("name", ["four-bar", "skew hanging four-bar", "six-bar", "slider-crank", "four-bar with a pin"])
def test_small_and_large_linkages(name, length, mass):
    # lengths times a, masses times b, gravity times a, torsion springs times b a^2, line springs times b: the same w
    p = dict(given(name))
    lengths = {"lengths", "base", "end", "height", "coupler_point", "second_base", "pin_offset"}
    factors = dict.fromkeys(lengths, length) | {"masses": mass, "pin_mass": mass, "pin_inertia": mass * length**2}
    factors["stiffness"] = mass if name == "slider-crank" else mass * length**2
    if name == "slider-crank":
        factors |= {"rest": length, "damping": mass}
        p["guess"] = [*p["guess"][:2], p["guess"][2] * length]
    scaled = {key: (np.array(value) * factors.get(key, 1.0)).tolist() for key, value in p.items()}
    described = BUILDERS[name](scaled)
    described.options["gravity"] = tuple(length * x for x in PLANE)
    if name == "slider-crank":
        described.text = described.text.replace("damping=", "friction=")  # compared without its damper
    described.text = _scaled_constants(described.text, length, mass)
    robot, guess = described
    system = robot.linearize(robot.equilibrium(guess))
    assert system.modes().natural_frequencies == pytest.approx(known_frequencies(name), rel=1e-9)


def _scaled_constants(text: str, length: float, mass: float) -> str:
    """The moments of inertia out of the plane that linkages.py puts in as they are."""
    return text.replace('"0.001"', f'"{0.001 * mass * length**2!r}"')


# ---------------------------------------------------------------- joints


@pytest.mark.parametrize("seed", range(4))
def test_locked_joints_leave_the_others_as_they_are(seed):
    case = random_case(seed, joints=6, springs=3)
    frozen = {name: case.guess[name] for name in ("j1", "j4")}
    rest = {
        key: {name: value for name, value in getattr(case.reference, key).items() if name not in frozen}
        for key in ("joint_stiffness", "joint_rest", "joint_damping")
    }
    robot = mb.Robot(case.reference.text, locked=frozen, gravity=case.reference.gravity, springs=case.reference.springs, **rest)
    left = {name: value for name, value in case.guess.items() if name not in frozen}
    full = case.robot.linearize(case.robot.equilibrium(case.guess, hold="all"))
    part = robot.linearize(robot.equilibrium(left, hold="all"))
    keep = [full.names.index(name) for name in part.names]
    assert len(keep) == 4
    for key in ("mass", "damping", "stiffness"):
        expected = getattr(full, key)[np.ix_(keep, keep)]
        assert np.abs(getattr(part, key) - expected).max() <= 1e-11 * np.abs(expected).max()


def test_platform_on_legs_without_mass_is_a_platform_on_line_springs():
    # every spring as a leg: universal joint, slide with a stiffness, ball on the ground; 27 coordinates, 21 rows, 7 loops
    p = given("platform on springs")
    parts, loops, guess, stiffness, rest = [link("body", p["mass"], (0, 0, 0), p["inertia"])], [], {}, {}, {}
    for i, spring in enumerate(p["springs"]):
        along = np.subtract(spring["on_ground"], spring["on_body"])
        turned = (0, -np.arctan2(along[2], np.hypot(*along[:2])), np.arctan2(along[1], along[0]))
        parts += [link(f"cross {i}"), link(f"tube {i}"), link(f"rod {i}")]
        parts += [
            joint(f"u{i}", "body", f"cross {i}", at=spring["on_body"], turned=turned, axis=(0, 1, 0)),
            joint(f"v{i}", f"cross {i}", f"tube {i}"),
            joint(f"s{i}", f"tube {i}", f"rod {i}", "prismatic", axis=(1, 0, 0)),
        ]
        loops.append(mb.Loop(f"rod {i}", (0, 0, 0), "ground", spring["on_ground"], name=f"foot {i}"))
        guess[f"s{i}"], stiffness[f"s{i}"], rest[f"s{i}"] = np.linalg.norm(along), spring["stiffness"], spring["rest_length"]
    robot = mb.Robot(urdf(*parts), base="free", loops=loops, joint_stiffness=stiffness, joint_rest=rest)
    system = robot.linearize(robot.equilibrium(guess))
    assert (system.size, len(system.rows)) == (27, 21)
    assert system.modes().natural_frequencies == pytest.approx(known_frequencies("platform on springs"), rel=1e-9)


# ---------------------------------------------------------------- forces


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kinds", [[], ["point"]])
def test_stiffness_of_forces_that_keep_their_direction(seed, kinds):
    # a dead force has a potential; a torque about a fixed direction has none in space, and K shows it
    case = random_case(seed, kinds=kinds, joints=6)
    rng = np.random.default_rng(seed)
    force = mb.PointMotion("body 5", rng.normal(size=3), along=rng.normal(size=3))
    torque = mb.PointMotion("body 4", along=rng.normal(size=3), turn=True)
    case.reference.forces = ((force, 30.0), (torque, 12.0))
    posture = case.robot.equilibrium(case.guess, forces={force: 30.0, torque: 12.0}, hold="all")
    system = case.robot.linearize(posture)
    q = case.reference.configuration(case.guess)
    places = [case.reference.coordinates.index(name) for name in case.robot.coordinates]
    J = case.reference.rows(q)[:, places]
    N = null_space(J) if len(J) else np.eye(6)
    expected = (
        N.T @ case.reference.stiffness(q, case.reference.multipliers(q, posture.ground_reactions))[np.ix_(places, places)] @ N
    )
    assert np.abs(N.T @ system.stiffness @ N - expected).max() <= 1e-9 * np.abs(expected).max()


# ---------------------------------------------------------------- overconstrained in space


def bennett(a=1.0, alpha=0.9, beta=0.5):
    """Bennett's linkage: four hinges that no count of freedoms allows to move, a / sin(alpha) = b / sin(beta); it moves."""
    b = a * np.sin(beta) / np.sin(alpha)
    names, sides = ("first", "second", "third"), ((a, alpha), (b, beta), (a, alpha), (b, beta))
    links = [link(name, 1.0, (length / 2, 0.02, 0.03), (0.01, 0.09, 0.08)) for name, (length, _) in zip(names, sides)]
    joints = [joint("j1", "frame", "first")]
    joints += [joint(f"j{i + 2}", names[i], names[i + 1], at=(sides[i][0], 0, 0), turned=(sides[i][1], 0, 0)) for i in range(2)]
    return urdf(GROUND, *links, *joints), (a, alpha), (b, beta)


def test_bennetts_linkage_moves():
    text, (a, alpha), (b, beta) = bennett()
    # the fourth side, seen from the ground, ends where the first begins: frame 4 = [Rx(-beta), -b] before the turn of j1
    loop = mb.Loop(
        "third", (a, 0, 0), "ground", (-b, 0, 0), kind="hinge", rotation1=(alpha, 0, 0), rotation2=(-beta, 0, 0), name="last"
    )
    stiffness, rest = {"j1": 30.0}, {"j1": 1.0}
    described = linkage(text, {}, loops=[loop], joint_stiffness=stiffness, joint_rest=rest)
    # tan(t1/2) tan(t2/2) = sin((alpha + beta)/2) / sin((beta - alpha)/2), opposite angles equal and opposite
    t1 = 1.0
    t2 = 2 * np.arctan(np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2) / np.tan(t1 / 2))
    reference = described.reference()
    starts = [
        {"j1": u, "j2": v, "j3": w} for u, v, w in ((t1, t2, -t1), (t1, -t2, -t1), (t1, t2 + np.pi, np.pi - t1), (t1, t2, t1))
    ]
    closed = [reference.closed(reference.configuration(start)) for start in starts]
    q = min(closed, key=lambda q: np.abs(reference.gaps(q)).max())
    assert np.abs(reference.gaps(q)).max() < 1e-13, "the test's own closure"
    robot, _ = described
    posture = robot.equilibrium(reference.angles(q))
    assert {notice.kind for notice in posture.notices} <= {"redundant", "distant posture"} and not any(
        notice.doubtful for notice in posture.notices
    )
    system = robot.linearize(posture)
    N = allowed(system)
    assert N.shape == (3, 1)
    q = reference.configuration(posture.joints)
    pull = np.linalg.lstsq(reference.rows(q).T, -reference.applied(q), rcond=1e-9)[0]
    assert np.abs(reference.applied(q) + reference.rows(q).T @ pull).max() < 1e-9
    expected = N.T @ reference.stiffness(q, pull) @ N
    assert N.T @ system.stiffness @ N == pytest.approx(expected, rel=1e-8)


# ---------------------------------------------------------------- levels, motors, pictures


@pytest.mark.parametrize("name", ["four-bar", "slider-crank", "six-bar", "spatial loop"])
def test_the_level_of_the_loops_does_not_change_a_motion_that_obeys_them(name):
    robot, posture, system = linearized(name)
    N = allowed(system)
    start, rate = N @ np.ones(N.shape[1]), N @ np.full(N.shape[1], 2.0)
    times = np.linspace(0, 3, 50)
    expected = system.solve(displacement=start, velocity=rate)(times)
    for level in ("velocity", "acceleration"):
        other = robot.linearize(posture, level=level).solve(displacement=start, velocity=rate)(times)
        assert np.abs(other - expected).max() <= 1e-9 * np.abs(expected).max()


def test_four_bar_driven_through_an_elastic_gear():
    # doubled coordinates and a loop: against the same gear as a real rotor, a link of its own on the crank's axis
    p = given("four-bar")
    rotor, k, c = 0.4, 55.0, 0.3
    flexible = mb.Robot(linkages.four_bar_text(p), loops=[linkages.four_bar_loop(p)], gravity=PLANE,
                        flexible_joints={"j1": mb.FlexibleJoint(k, damping=c, motor_inertia=rotor, gear_ratio=1.0, proportional_gain=25.0)})  # fmt: skip
    posture = flexible.equilibrium(dict(zip(("j1", "j2", "j3"), p["guess"])))
    system = flexible.linearize(posture)
    fixed = posture.torques["j1"]
    text = linkages.four_bar_text(p, "revolute", link("rotor", 1.0, (0, 0, 0), (rotor,) * 3), joint("motor", "frame", "rotor"))
    text = text.replace('<parent link="frame"/><child link="crank"/>', '<parent link="rotor"/><child link="crank"/>')
    # j1 is now the twist of the gear, motor the angle of the rotor: rest of the twist so that the torque is the same
    stiffness, rest = {"j1": k, "motor": 25.0}, {"j1": 0.0}
    twist = -fixed / k
    rest["motor"] = posture.joints["j1"] - twist - fixed / 25.0 * -1.0
    real = mb.Robot(
        text, loops=[linkages.four_bar_loop(p)], gravity=PLANE, joint_stiffness=stiffness, joint_rest=rest, joint_damping={"j1": c}
    )
    there = real.equilibrium({**posture.joints, "j1": twist, "motor": posture.joints["j1"] - twist})
    assert there.joints["j1"] == pytest.approx(twist, rel=1e-9) and there.joints["j2"] == pytest.approx(
        posture.joints["j2"], rel=1e-9
    )
    expected = real.linearize(there).modes()
    assert sorted(abs(mode.eigenvalue) for mode in system.modes()) == pytest.approx(
        sorted(abs(mode.eigenvalue) for mode in expected), rel=1e-9
    )
    degree4 = system.without_motors()
    start = np.zeros(system.size)
    times = np.linspace(0, 3, 40)
    force = mb.step(np.eye(system.size)[list(system.names).index("j1 motor")])
    doubled = system.solve(displacement=start, force=force)(times)[:3]
    alone = degree4.solve(displacement=start, force=force)(times)[:3]
    assert np.abs(alone - doubled).max() <= 1e-8 * np.abs(doubled).max()


@pytest.mark.parametrize("name", ["four-bar", "spatial loop", "platform on springs", "spherical four-bar"])
def test_poses_are_those_of_the_links_with_closed_loops(name):
    robot, posture, system = linearized(name)
    reference = BUILDERS[name](given(name)).reference()
    base = posture.configuration[:7] if reference.base == "free" else None
    q0 = reference.configuration(posture.joints, base)
    places = [reference.coordinates.index(coordinate) for coordinate in robot.coordinates]
    N = allowed(system)
    shape = N[:, :1] / np.abs(N[:, 0]).max()
    d = shape * np.array([[0.0, 0.02, 0.05, -0.05]])
    actual = robot.poses(posture, d, scale=2.0)
    assert set(actual) == set(robot.bodies)
    for k, moved in enumerate(d.T):
        step = np.zeros(len(places))
        step[places] = 2.0 * moved
        q = reference.closed(pin.integrate(reference.model, q0, step))
        reference.place(q)
        for body, poses in actual.items():
            end = reference.end(body, (0, 0, 0), (0, 0, 0))
            turn = pin.Quaternion(*poses.quaternions[[3, 0, 1, 2], k]).toRotationMatrix()
            # the shortest way back onto a loop may be measured in several ways: they differ by the square of the motion
            loose = 1e-5 if not reference.loops else 1e-5 + 5 * np.abs(2 * moved).max() ** 2
            assert np.abs(poses.positions[:, k] - end.place).max() < loose and np.abs(turn - end.turn).max() < loose
