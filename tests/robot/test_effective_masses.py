"""Effective masses and the ellipsoids of inertia: closed forms, and the tensors of pinocchio."""

import numpy as np
import pinocchio as pin
import pytest

import mbconstrained as mb
from tests.robot.linkages import GROUND, joint, link, urdf
from tests.robot.test_compliant_ground import box


def mass_of(robot: mb.Robot) -> float:
    return sum(inertia.mass for inertia in list(robot.model.inertias)[1:])


@pytest.mark.parametrize("tilt", [0.0, 0.1])
def test_all_modes_on_springs_have_the_whole_mass(tilt):
    """On compliant ground every body can follow the base: the sum is the mass, and about the origin the inertia of the whole."""
    robot = box((0.02, 0.01, 0.3), tilt=tilt)
    posture = robot.equilibrium()
    found = robot.linearize(posture).effective_masses(["x", "y", "z", "rx", "ry", "rz"])
    data = robot.model.createData()
    assert found.masses.shape == (6, 6) and found.units == ("kg",) * 3 + ("kg m^2",) * 3
    assert found.totals == pytest.approx(found.masses.sum(axis=0), rel=1e-11)
    assert found.totals[:3] == pytest.approx([4.0] * 3, rel=1e-12)
    centre = pin.centerOfMass(robot.model, data, posture.configuration)  # and the places of the joints
    inertia = data.oMi[1].rotation @ np.diag([0.1, 0.2, 0.3]) @ data.oMi[1].rotation.T
    about_origin = inertia + 4.0 * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    assert found.totals[3:] == pytest.approx(np.diag(about_origin), rel=1e-11)


def test_participation_is_the_momentum_of_pinocchio():
    robot, data = mb.read_robot("robots/seven_joint_arm")
    posture = robot.equilibrium(**data.posture)
    system = robot.linearize(posture)
    found = system.effective_masses(["x", "y", "z", "rx", "ry", "rz"])
    oracle = robot.model.createData()
    A = pin.computeCentroidalMap(robot.model, oracle, posture.configuration)
    centre = pin.centerOfMass(robot.model, oracle, posture.configuration)
    A = np.vstack([A[:3], A[3:] + pin.skew(centre) @ A[:3]])
    modes = system.modes(damped=False)
    shapes = modes.shapes.real / np.sqrt(np.einsum("im,ij,jm->m", modes.shapes.real, system.mass, modes.shapes.real))
    expected = (A @ shapes[: A.shape[1]]) ** 2
    assert found.masses == pytest.approx(expected.T, rel=1e-8, abs=1e-10 * expected.max())


def test_the_forces_of_a_shaken_base_show_the_effective_masses():
    """The force on a base that moves by 1 is -w^2 (m_fixed + sum of m_i / (1 - (w / w_i)^2)) without gravity."""
    masses = {"frame": 1.0, "cart": 3.0, "bob": 2.0}
    parts = [link(name, mass, (0, 0, 0), (1, 1, 1)) for name, mass in masses.items()]
    slides = (
        joint("first", "frame", "cart", "prismatic", axis=(1, 0, 0)),
        joint("second", "cart", "bob", "prismatic", axis=(1, 0, 0)),
    )
    text = urdf(*parts, *slides)
    springs = {"joint_stiffness": {"first": 500.0, "second": 300.0}, "gravity": 0}
    fixed, moving = (mb.Robot(text, base=base, **springs) for base in ("fixed", "moving"))
    own, shaken = (robot.linearize(robot.equilibrium()) for robot in (fixed, moving))
    found = own.effective_masses("x")
    assert found.masses == pytest.approx(shaken.effective_masses("x").masses, rel=1e-11)
    assert found.totals == pytest.approx([5.0], rel=1e-12)
    f = np.array([0.3, 1.0, 5.0])
    R = shaken.frequency_response(f, ["motion of base x"], ["motion of base x"], quantity="reaction").values[0, 0]
    w, wi = 2 * np.pi * f, 2 * np.pi * found.frequencies_hz
    expected = -(w**2) * (1.0 + (found.masses[:, 0] / (1 - (w[:, None] / wi) ** 2)).sum(axis=1))
    assert R.real == pytest.approx(expected, rel=1e-9)


def test_rows_of_a_moving_base_give_the_same_as_directions():
    arm = mb.Robot(
        "robots/double_pendulum/double_pendulum.urdf", base="moving", joint_stiffness={"shoulder": 900.0, "elbow": 300.0}
    )
    system = arm.linearize(arm.equilibrium({"shoulder": 0.5, "elbow": 0.4}))
    rows = super(mb.LinearizedRobot, system).effective_masses([f"motion of base {axis}" for axis in "xyz"])
    own = system.effective_masses()
    assert rows.totals == pytest.approx(own.totals, rel=1e-9, abs=1e-12)
    assert rows.masses == pytest.approx(own.masses, rel=1e-9, abs=1e-12)


def test_free_bodies_have_no_effective_mass_and_directions_are_checked():
    robot, data = mb.read_robot("robots/satellite")
    system = robot.linearize(robot.equilibrium(**data.posture))
    found = system.effective_masses()
    assert found.masses == pytest.approx(np.zeros_like(found.masses), abs=1e-12 * mass_of(robot))
    assert found.totals == pytest.approx([mass_of(robot)] * 3, rel=1e-12)
    with pytest.raises(mb.InputError, match="base: found 'w'; expected x, y, z, rx, ry, rz"):
        system.effective_masses("w")
    with pytest.raises(mb.InputError, match="base: found 3"):
        system.effective_masses(3)
    follower = mb.MechanicalSystem(np.eye(2), None, [[2.0, 1.0], [0.0, 2.0]], [mb.Constraint([0, 1])])
    with pytest.raises(mb.InputError, match="effective masses: the stiffness matrix is not symmetric"):
        follower.effective_masses()


def test_groups_of_rows_of_other_models_move_together():
    K = 100.0 * np.array([[2.0, -1.0, -1.0], [-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    beam = mb.MechanicalSystem(np.diag([2.0, 0, 0]), None, K, [mb.Constraint([0, 1, 0], names="left"), mb.Constraint([0, 0, 1], names="right")])  # fmt: skip
    both = beam.effective_masses({"ground": ["left", "right"]})
    assert both.directions == ("ground",) and both.masses == pytest.approx(np.array([[2.0]]))
    assert beam.effective_masses().masses == pytest.approx(np.array([[0.5, 0.5]]))
    assert beam.effective_masses({"one": "left"}).masses == pytest.approx(np.array([[0.5]]))
    with pytest.raises(mb.InputError, match="base: there is no constraint row 'lft'"):
        beam.effective_masses("lft")
    with pytest.raises(mb.InputError, match="base: there is no constraint row 3"):
        beam.effective_masses(3)


@pytest.mark.parametrize("name", ["seven_joint_arm", "quadruped", "delta"])
def test_ellipsoids_have_the_inertia_of_the_bodies(name):
    robot, _ = mb.read_robot(f"robots/{name}")
    ellipsoids = robot.inertia_ellipsoids()
    for number, body in robot.link_frames.heaviest_links().items():
        inertia = robot.model.inertias[number]
        if not number or not inertia.mass:
            continue
        E, frame = ellipsoids[body], robot.link_frames.link(body)
        S = frame.rotation @ E[:3, :3]
        assert np.linalg.det(E[:3, :3]) > 0 and E[3].tolist() == [0, 0, 0, 1]  # no mirror image
        second = inertia.mass / 5 * S @ S.T  # integral of x x^T dm
        tensor = np.trace(second) * np.eye(3) - second
        assert tensor == pytest.approx(np.array(inertia.inertia), rel=1e-3, abs=1e-3 * np.abs(inertia.inertia).max())
        assert frame.rotation @ E[:3, 3] + frame.point == pytest.approx(np.array(inertia.lever), abs=1e-12)


def test_payloads_count_and_points_have_a_size():
    text = urdf(GROUND, link("arm", 1.0, (0, 0, 0.5), (0, 0, 0)), joint("j", "frame", "arm", axis=(0, 1, 0)))
    robots = [mb.Robot(text, payloads=given) for given in ((), [mb.Payload("arm", 1.0, (0, 0, 1.5))])]
    point, both = (robot.inertia_ellipsoids()["arm"] for robot in robots)
    assert point[:3, 3] == pytest.approx([0, 0, 0.5]) and (np.linalg.norm(point[:3, :3], axis=0) > 0).all()
    assert both[:3, 3] == pytest.approx([0, 0, 1.0])
    assert np.linalg.norm(both[:3, :3], axis=0).max() == pytest.approx(np.sqrt(5) / 2)  # 2 m (1/2)^2 = m_all c^2 / 5
