"""Robots with contacts, against pinocchio's impulse and constraint dynamics at the posture, and closed forms."""

import numpy as np
import pinocchio as pin
import pytest

import mbconstrained as mb
from tests.robot.linkages import GROUND, joint, link, urdf

ANGLES = {"j1": 0.4, "j2": -0.9, "j3": 0.5}
TIP = np.array([0.02, -0.01, -0.3])


def arm(**options) -> mb.Robot:
    """Three links in space, with springs that carry the posture."""
    parts = [link(f"l{i}", 1.0 + i, (0.01 * i, 0.02, -0.15), (0.02, 0.03, 0.01, 0.002, 0.001, -0.003)) for i in (1, 2, 3)]
    joints = [
        joint("j1", "frame", "l1", axis=(0, 1, 0)),
        joint("j2", "l1", "l2", at=(0, 0.05, -0.3), axis=(0.1, 1, 0)),
        joint("j3", "l2", "l3", at=(0, 0, -0.3), axis=(1, 0.2, 0)),
    ]
    springs = {"j1": 900.0, "j2": 500.0, "j3": 300.0}
    return mb.Robot(urdf(GROUND, *parts, *joints), **({"joint_stiffness": springs, "joint_damping": {"j2": 0.3}} | options))


def tip_jacobian(robot: mb.Robot, posture: mb.Posture) -> np.ndarray:
    """Of the tip in the directions of the ground, by pinocchio's frames."""
    model, data = robot.model, robot.model.createData()
    frame = model.getFrameId("l3")
    J = pin.computeFrameJacobian(model, data, posture.configuration, frame, pin.LOCAL_WORLD_ALIGNED)
    pin.updateFramePlacements(model, data)
    arm = data.oMf[frame].rotation @ TIP
    return J[:3] - pin.skew(arm) @ J[3:]


def standing() -> mb.Robot:
    """A block on a leg of two joints that stands on the ground, free in space."""
    parts = [link("body", 4.0, (0.02, 0, 0.05), (0.05, 0.06, 0.07)), link("thigh", 1.0, (0, 0, -0.1), (0.01, 0.01, 0.001))]
    parts.append(link("shin", 0.5, (0, 0, -0.1), (0.004, 0.004, 0.0005)))
    joints = [joint("hip", "body", "thigh", axis=(0, 1, 0)), joint("knee", "thigh", "shin", at=(0, 0, -0.2), axis=(0, 1, 0))]
    foot = mb.Loop("ground", (0, 0, 0), "shin", (0, 0, -0.2), kind="rigid", name="foot", friction=0.5, rotation1=(0, 0, 0))
    return mb.Robot(
        urdf(*parts, *joints), loops=[foot], base="free", joint_stiffness={"hip": 300.0, "knee": 400.0}, joint_damping={"knee": 0.2}
    )


def posture_of_standing(robot: mb.Robot) -> mb.Posture:
    return robot.equilibrium({"base z": 0.4})


# ---------------------------------------------------------------- joint stops


def pendulum() -> mb.Robot:
    rod = link("rod", 2.0, (0, 0, -0.5), (0.1, 0.1, 0.0))
    return mb.Robot(urdf(GROUND, rod, joint("hinge", "frame", "rod", axis=(0, 1, 0), limits=(-0.05, 1.0))))


def test_a_pendulum_bounces_from_its_stop_in_closed_form():
    e, inertia, robot = 0.7, 0.1 + 2 * 0.25, pendulum()
    w = np.sqrt(2 * 9.81 * 0.5 / inertia)
    x = (
        robot.linearize(robot.equilibrium())
        .with_switches(mb.JointStop("hinge", restitution=e))
        .solve({"hinge": 0.02}, [1.2], end=6.0)
    )
    a, b = 0.02, 1.2 / w  # x = a cos w t + b sin w t = -0.05 at first, later x = -0.05 cos + c sin
    size, phase = np.hypot(a, b), np.arctan2(b, a)
    times, speeds = [(phase + np.arccos(-0.05 / size)) / w], [-size * w * np.sin(np.arccos(-0.05 / size))]
    for _ in range(3):
        c = -e * speeds[-1] / w
        times.append(times[-1] + 2 * (np.pi / 2 + np.arctan2(0.05, c)) / w)
        speeds.append(e * speeds[-1])
    assert [event.time for event in x.events[:4]] == pytest.approx(times, rel=1e-13)
    impulses = [event.impulses["hinge stop lower"] for event in x.events[:4]]
    assert impulses == pytest.approx([-(1 + e) * inertia * v for v in speeds], rel=1e-12)


def test_an_elastic_stop_has_half_periods_of_both_stiffnesses():
    robot, inertia = pendulum(), 0.6
    free, both = np.sqrt(9.81 / inertia), np.sqrt((9.81 + 500) / inertia)
    stop = mb.JointStop("hinge", lower="-0.5 deg", stiffness="500 N*m/rad")
    x = robot.linearize(robot.equilibrium()).with_switches(stop).solve(velocity={"hinge": 0.1}, end=5.0)
    a, amplitude = np.radians(0.5), 0.1 / free
    inside = np.arcsin(a / amplitude)  # x = -a beyond the zero of the free motion
    into = np.arctan2(free * amplitude * np.cos(inside) / both, a * (free / both) ** 2)  # about the equilibrium of both springs
    expected = np.cumsum([(np.pi + inside) / free, 2 * into / both, (np.pi + 2 * inside) / free])
    assert [event.time for event in x.events[:3]] == pytest.approx(expected.tolist(), rel=1e-13)


@pytest.mark.parametrize(
    ("part", "text"),
    [
        (mb.JointStop("hinge", lower=0.1), "hinge is at 0 rad in the posture, beyond the lower stop at 0.1 rad"),
        (mb.JointStop("hing"), 'did you mean "hinge"'),
        (mb.JointStop("hinge", restitution=1.5), "restitution: found 1.5"),
        (mb.JointStop("hinge", lower="-1 m"), "lower"),
        (mb.PointContact("rod", (0, 0, -1), (1, 0, 0), gap=-0.1), "gap: found -0.1"),
        (mb.PointContact("rode"), 'did you mean "rod"'),
        (mb.PointContact("rod", friction=0.3), "add sticks=True"),
        (mb.PointContact("rod", restitution=0.3, sticks=True), "found restitution and sticks"),
        (mb.PointContact("rod", (0, 0, -1), normal=(0, 1, 0)), "does not move along the normal"),
        (mb.LiftingFoot("foot"), 'there is no loop "foot"'),
        ("hinge", "found str; expected mb.JointStop"),
    ],
)
def test_errors_name_the_part(part, text):
    robot = pendulum()
    with pytest.raises(mb.InputError) as caught:
        robot.linearize(robot.equilibrium()).with_switches(part)
    assert text in str(caught.value)


def test_loops_that_close_have_one_reason():
    loop = mb.Loop("a", (0, 0, 0), "b")
    for wrong in ({}, {"at": 1.0, "gap": 0.1}, {"at": 1.0, "released": 0.5}):
        with pytest.raises(mb.InputError):
            mb.ClosingLoop(loop, **wrong)
    with pytest.raises(mb.InputError, match="released"):
        mb.ClosingLoop("foot", at=1.0)


# ---------------------------------------------------------------- touch-down


@pytest.mark.parametrize(("sticks", "restitution"), [(False, 0.0), (False, 0.6), (True, 0.0)])
def test_touch_down_is_pinocchios_impulse(sticks, restitution):
    robot = arm()
    posture = robot.equilibrium(ANGLES, hold="all")
    normal = np.array([0.2, -0.1, 1.0]) / np.linalg.norm([0.2, -0.1, 1.0])
    contact = mb.PointContact("l3", TIP, normal, gap=0.002, restitution=restitution, sticks=sticks, name="tip")
    J = tip_jacobian(robot, posture)
    approach = np.linalg.solve(J, [0.3, 0.2, -0.6])
    x = robot.linearize(posture).with_switches(contact).solve(velocity=approach, end=0.02)
    event = x.events[0]
    assert normal @ J @ x(np.nextafter(event.time, 0)) == pytest.approx(-0.002, abs=1e-12)
    before = x.velocity(event.time) - event.jump[1]
    across = np.linalg.svd(normal[None])[2][1:]
    rows = np.vstack([normal, across]) @ J if sticks else (normal @ J)[None]
    data = robot.model.createData()
    after = pin.impulseDynamics(robot.model, data, posture.configuration, before, rows, restitution)
    assert event.jump[1] == pytest.approx(after - before, abs=1e-12 * np.abs(before).max())
    assert event.impulses["tip"] == pytest.approx(data.impulse_c[0], rel=1e-11)
    if sticks:
        own = [event.impulses[name] for name in ("tip shift 1", "tip shift 2")]
        assert np.linalg.norm(own) == pytest.approx(np.linalg.norm(data.impulse_c[1:]), rel=1e-11)
    M = pin.crba(robot.model, data, posture.configuration)
    lost = before @ M @ before / 2 - after @ M @ after / 2
    assert event.energy_lost == pytest.approx(lost, rel=1e-10)


def test_two_contacts_at_once_have_the_restitution_of_each():
    """Two points of one body touch a plane at the same time; e and the impulses of both by the inertia of pinocchio."""
    block = mb.Robot(urdf(link("block", 2.0, (0, 0, 0), (0.1, 0.2, 0.3))), base="free", gravity=0.0)
    posture = block.equilibrium()
    feet = [mb.PointContact("block", (s, 0, -0.1), gap=0.01, restitution=0.5, name=f"foot {s}") for s in (-0.2, 0.3)]
    event = block.linearize(posture).with_switches(*feet).solve(velocity={"base z": -1.0}, end=0.05).events[0]
    A = np.array([[1.0, 0.2], [1.0, -0.3]])  # of z and ry
    p = np.linalg.solve(A @ np.diag([1 / 2, 1 / 0.2]) @ A.T, [1.5, 1.5])
    if (p < 0).any():  # the nearer one alone
        raise AssertionError
    assert list(event.impulses.values()) == pytest.approx(p, rel=1e-12)


# ---------------------------------------------------------------- feet


def test_a_standing_foot_has_the_load_of_the_posture_and_of_constraint_dynamics():
    robot = standing()
    posture = posture_of_standing(robot)
    machine = robot.linearize(posture).with_switches(mb.LiftingFoot("foot"))
    rest = machine.solve(end=0.01)
    names = [row.name for row in rest._reaction_rows]
    assert not rest.events and rest.reaction(0.0)[names.index("foot")] == pytest.approx(5.5 * 9.81, rel=1e-9)
    tau = {"hip": 3.0, "knee": -2.0, "base x": 1.5, "base z": 4.0}
    x = machine.solve(force={name: mb.step(size) for name, size in tau.items()}, end=0.01)
    J = posture.balance.jacobian
    own = posture.balance.force - posture.balance.gravity
    total = np.array([tau.get(name, 0.0) for name in robot.coordinates]) - own
    total += [posture.torques.get(name, 0.0) for name in robot.coordinates]
    data, zero = robot.model.createData(), np.zeros(robot.model.nv)
    independent = J[list(posture.independent_rows)]
    a = pin.forwardDynamics(robot.model, data, posture.configuration, zero, total, independent, np.zeros(len(independent)))
    assert x.acceleration(0.0) == pytest.approx(a, abs=1e-9)
    wanted = dict(zip((robot.loops[0].row_names[i] for i in posture.independent_rows), data.lambda_c))
    assert x.reaction(0.0)[names.index("foot")] == pytest.approx(wanted["foot z"], rel=1e-9)
    assert x.reaction(0.0)[names.index("foot x")] == pytest.approx(wanted["foot x"], rel=1e-9)


def test_a_foot_that_is_pulled_up_lifts_off_and_falls_as_a_free_robot():
    robot = standing()
    posture = posture_of_standing(robot)
    machine = robot.linearize(posture).with_switches(mb.LiftingFoot("foot"))
    x = machine.solve(force={"base z": mb.step(60.0)}, end=0.02)
    assert not x.events
    data, zero = robot.model.createData(), np.zeros(robot.model.nv)
    springs = posture.balance.force - posture.balance.gravity
    force = np.array([posture.torques.get(name, 0.0) for name in robot.coordinates]) - springs
    force[robot.coordinates.index("base z")] += 60.0
    assert x.acceleration(0.0) == pytest.approx(pin.aba(robot.model, data, posture.configuration, zero, force), abs=1e-6)


def test_a_jump_and_its_landing_conserve_momentum_and_lose_energy():
    robot = standing()
    posture = posture_of_standing(robot)
    machine = robot.linearize(posture).with_switches(mb.LiftingFoot("foot"))
    x = machine.solve(velocity={"base z": 0.3}, force={"base z": mb.step(0.0)}, end=0.2)
    lands = [event for event in x.events if event.impulses.get("foot", 0.0) > 0 and event.time > 0]
    assert lands and all(event.momentum_residual < 1e-12 for event in x.events)
    J = posture.balance.jacobian
    for event in lands:
        before = x.velocity(event.time) - event.jump[1]
        data = robot.model.createData()
        after = pin.impulseDynamics(robot.model, data, posture.configuration, before, J[list(posture.independent_rows)])
        assert x.velocity(event.time) == pytest.approx(after, abs=1e-10)
        assert event.energy_lost > 0
    dense = np.linspace(0.0, 0.2, 401)
    J_foot = (robot.linearize(posture).constraint_matrix @ x(dense))[
        [row.name for row in robot.linearize(posture).rows].index("foot z")
    ]
    assert J_foot.min() > -1e-12


def test_the_energy_is_continuous_where_a_foot_lifts_off():
    robot = standing()
    machine = robot.linearize(posture_of_standing(robot)).with_switches(mb.LiftingFoot("foot"))
    x = machine.solve(force={"base z": mb.ramp(300.0), "hip": mb.step(2.0)}, end=0.5)
    opened = [event for event in x.events if "opens" in event.text and not event.impulses]
    assert opened
    for event in opened:
        assert abs(event.energy_lost) < 1e-10 * abs(event.energy_before)


def test_the_cone_of_friction_is_reported():
    robot = standing()
    machine = robot.linearize(posture_of_standing(robot)).with_switches(mb.LiftingFoot("foot"))
    calm = machine.solve(force={"base x": mb.step(1.0)}, end=0.05)
    pushed = machine.solve(force={"base x": mb.step(45.0)}, end=0.05)
    assert not any("slip" in notice.text for notice in calm.notices)
    assert any("foot would slip" in notice.text for notice in pushed.notices)


def test_a_rocking_block_has_the_times_and_the_ratio_of_speeds_of_housner():
    """Housner, Bull. Seism. Soc. Am. 53 (1963) 403: angular velocities in the ratio 1 - 1.5 sin(a)^2, small angles with cosh and sinh."""
    mass, b, h = 3.0, 0.1, 0.3
    inertia = mass * (b**2 + h**2) / 3
    feet = [mb.Loop("ground", (place, 0, 0), "block", (place, 0, 0), name=name) for name, place in (("left", -b), ("right", b))]
    robot = mb.Robot(urdf(link("block", mass, (0, 0, h), (inertia,) * 3)), loops=feet, base="free")
    machine = robot.linearize(robot.equilibrium()).with_switches(mb.LiftingFoot("left"), mb.LiftingFoot("right"))
    x = machine.solve(velocity={"base ry": 0.05, "base z": 0.05 * b}, end=1.0)
    rate = np.sqrt(mass * 9.81 * h / (4 * inertia))
    speeds = 0.05 * (1 - 1.5 * b**2 / (b**2 + h**2)) ** np.arange(12)
    times = np.cumsum(2 * np.arctanh(speeds * h / b / rate) / rate)
    assert [event.time for event in x.events[:12]] == pytest.approx(times.tolist(), rel=1e-11)
    assert [event.after for event in x.events[:2]] == ["left closed, right open", "left open, right closed"]
    assert x.events[0].energy_after / x.events[0].energy_before == pytest.approx(speeds[1] ** 2 / speeds[0] ** 2, rel=1e-9)


@pytest.mark.parametrize(
    "start",
    [
        {"velocity": {"base rx": 0.5}},
        pytest.param({"velocity": {"base z": 0.5}}, marks=pytest.mark.long),
        pytest.param({"displacement": {"base z": 0.05}}, marks=pytest.mark.long),
    ],
)
def test_four_feet_never_pass_the_ground_nor_pull(start):
    """Feet land at once and one after another; where one can neither stick nor lift off it slides, and an impulse that pulls is reported."""
    robot, data = mb.read_robot("robots/quadruped")
    machine = robot.linearize(robot.equilibrium(**data.posture)).with_switches(*(mb.LiftingFoot(loop.name) for loop in robot.loops))
    x, times = machine.solve(**start, end=0.2), np.linspace(0.0, 0.2, 401)
    names = [row.name for row in x._reaction_rows]
    for switch in machine.switches:
        assert (switch.contact.row @ x(times)).min() > -1e-12
        assert x.reaction(times)[names.index(switch.name)].min() > -1e-9
        pulled = min(event.impulses.get(switch.name, 0.0) for event in x.events)
        reported = any(notice.text.startswith(f"{switch.name}: at t =") and " pull " in notice.text for notice in x.notices)
        assert pulled > -1e-9 or reported  # in which impact of almost no strength that happens depends on rounding errors
    assert all(event.energy_lost > -1e-10 for event in x.events)
    assert any(" slides " in notice.text for notice in x.notices) == any("sliding" in name for _, name in x.phases)


def test_only_feet_lift_off():
    p = mb.Loop("l3", TIP, "ground", kind="hinge", name="hinge")
    robot = arm(loops=[p])
    with pytest.raises(mb.InputError, match="hinge loop"):
        robot.linearize(robot.equilibrium(ANGLES, hold="all")).with_switches(mb.LiftingFoot("hinge"))


# ---------------------------------------------------------------- loops


@pytest.mark.parametrize("kind", ["point", "rigid", "hinge", "universal", "rod"])
def test_a_loop_that_closes_in_motion_is_pinocchios_impulse(kind):
    robot = arm()
    posture = robot.equilibrium(ANGLES, hold="all")
    frames, kinematics = robot.link_frames, posture.balance.kinematics
    place = tuple(kinematics.frame(frames.anchor("l3", "", TIP))[1] + (0.1 if kind == "rod" else 0.0))
    loop = mb.Loop("ground", place, "l3", TIP, kind=kind, name="grip")
    x = (
        robot.linearize(posture)
        .with_switches(mb.ClosingLoop(loop, at=0.004, released=0.01))
        .solve(velocity={"j1": 1.0, "j2": 0.5, "j3": -2.0}, end=0.02)
    )
    event, released = x.events
    assert (event.time, released.time) == (0.004, 0.01) and not released.impulses
    before = x.velocity(0.004) - event.jump[1]
    J = np.eye(3)  # of a rigid loop, which blocks all three joints
    if kind != "rigid":
        J = robot.linearize(posture).with_switches(mb.ClosingLoop(loop, at=1.0)).phase("closed").constraint_matrix
    data = robot.model.createData()
    _, s, vt = np.linalg.svd(J)
    rows = vt[: int((s > 1e-9 * s[0]).sum())]
    after = pin.impulseDynamics(robot.model, data, posture.configuration, before, rows)
    assert event.jump[1] == pytest.approx(after - before, abs=1e-11)


def test_rows_of_a_point_loop_are_pinocchios_jacobian():
    robot = arm()
    posture = robot.equilibrium(ANGLES, hold="all")
    loop = mb.Loop("l3", TIP, "ground", name="grip")
    rows = robot.linearize(posture).with_switches(mb.ClosingLoop(loop, at=1.0)).phase("closed").constraint_matrix
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, posture.configuration)
    R = data.oMf[robot.model.getFrameId("l3")].rotation
    assert rows == pytest.approx(-R.T @ tip_jacobian(robot, posture), abs=1e-12)


def test_a_gripper_grasps_where_the_gap_is_closed_and_lets_go():
    fingers = [link("hand", 3.0, (0, 0, 0), (1, 1, 1)), link("part", 2.0, (0, 0, 0), (1, 1, 1))]
    slides = [joint(name, "frame", body, "prismatic", axis=(1, 0, 0)) for name, body in (("to hand", "hand"), ("to part", "part"))]
    robot = mb.Robot(urdf(GROUND, *fingers, *slides), gravity=0.0)
    grip = mb.ClosingLoop(mb.Loop("hand", None, "part", (0, 0, 0), normal=(1, 0, 0), name="grip"), gap="50 mm", released=0.5)
    x = robot.linearize(robot.equilibrium()).with_switches(grip).solve(velocity={"to hand": 0.2, "to part": -0.3}, end=1.0)
    assert [event.time for event in x.events] == pytest.approx([0.1, 0.5], rel=1e-13)
    assert x.velocity(0.9) == pytest.approx([0.0, 0.0], abs=1e-13)
    assert x.events[0].impulses["grip x"] == pytest.approx(0.6, rel=1e-12) or x.events[0].impulses["grip x"] == pytest.approx(-0.6)
    assert x(0.9)[0] - x(0.9)[1] == pytest.approx(0.05, rel=1e-12)


def test_a_loop_that_is_released_leaves_its_load():
    robot = standing()
    posture = posture_of_standing(robot)
    x = robot.linearize(posture).with_switches(mb.ClosingLoop("foot", released=0.3)).solve(end=0.4)
    data, zero = robot.model.createData(), np.zeros(robot.model.nv)
    springs = posture.balance.force - posture.balance.gravity
    force = np.array([posture.torques.get(name, 0.0) for name in robot.coordinates]) - springs
    assert np.abs(x(0.29)).max() < 1e-12
    assert x.acceleration(0.3) == pytest.approx(pin.aba(robot.model, data, posture.configuration, zero, force), abs=1e-8)


# ---------------------------------------------------------------- linear range


def test_the_deviation_is_reported_by_phase():
    robot = pendulum()
    machine = robot.linearize(robot.equilibrium()).with_switches(mb.JointStop("hinge", lower=-0.02, restitution=0.9))
    small, large = (machine.solve({"hinge": size}, end=3.0) for size in (0.05, 1.2))
    system = machine.system
    assert system.linear_range(small).deviation < 1e-3 and system.linear_range(small).phase == "open"
    # sin x is off by 1 - sin(1.2) / 1.2
    assert system.linear_range(large).deviation == pytest.approx(1 - np.sin(1.2) / 1.2, rel=2e-2)
    assert any("while open, hinge goes 1.2 rad" in notice.text for notice in large.notices)
    assert any("small about the posture" in notice.text for notice in small.notices)


def test_a_free_fall_is_in_the_linear_range_however_deep():
    """A block in flight falls as the linear one, although the loads of the posture are not in balance."""
    block = link("block", 2.0, (0, 0, 0), (1, 1, 1))
    sole = mb.Loop("ground", (0, 0, 0), "block", (0, 0, 0), kind="rigid", name="sole")
    robot = mb.Robot(urdf(block), loops=[sole], base="free")
    machine = robot.linearize(robot.equilibrium()).with_switches(mb.LiftingFoot("sole"))
    x = machine.solve(displacement={"base z": 1.0}, end=0.6)
    assert x.events[0].time == pytest.approx(np.sqrt(2 / 9.81), rel=1e-13)
    assert machine.system.linear_range(x).deviation < 1e-6


def test_a_quadruped_stands_on_lifting_feet():
    robot, data = mb.read_robot("robots/quadruped")
    posture = robot.equilibrium(**data.posture)
    linear = robot.linearize(posture)
    machine = linear.with_switches(*(mb.LiftingFoot(loop.name) for loop in robot.loops))
    push = {"base z": mb.step(-20.0), "base x": mb.step(5.0)}
    x, same = machine.solve(force=push, end=0.1), linear.solve(force=push)
    times = np.linspace(0.0, 0.1, 21)
    assert not x.events and x(times) == pytest.approx(same(times), abs=1e-12)
    rest = machine.solve(end=0.01)
    loads = rest.reaction(0.0)[[[row.name for row in rest._reaction_rows].index(loop.name) for loop in robot.loops]]
    assert loads.min() > 0 and loads.sum() == pytest.approx(178.542, rel=1e-9)  # its weight
