"""Feet on compliant ground: the limit of stiff ground, differences of all forces, soles in closed form."""

from pathlib import Path

import numpy as np
import pytest

import mbconstrained as mb
from tests.robot.linkages import link, urdf
from tests.robot.reference import Reference

QUADRUPED = "robots/quadruped/quadruped.urdf"
FEET = {f"{end} {side} shin": (0.0, 0.0, -0.22) for end in ("front", "rear") for side in ("left", "right")}
REST = {f"{end} {side} {part}": a for end in ("front", "rear") for side in ("left", "right") for part, a in (("swing", 0.7), ("knee", -1.4))}  # fmt: skip
GUESS = {**REST, "base": (0.0, 0.0, 0.337, 0.0, 0.0, 0.0)}
SPRINGS = {f"{foot[: -len('shin')]}{part}": k for foot in FEET for part, k in (("spread", 90.0), ("swing", 120.0), ("knee", 120.0))}


def quadruped(stiffness=None, damping=(0.0, 0.0, 0.0), **options) -> mb.Robot:
    """On feet that cannot move, or on springs along the axes of the ground."""
    feet: dict = {"loops": [mb.Loop("ground", None, foot, at, name=foot, **options) for foot, at in FEET.items()]}
    if stiffness is not None:
        feet = {
            "springs": [
                mb.Bushing("ground", None, foot, at, stiffness=stiffness, damping=damping, name=foot, **options)
                for foot, at in FEET.items()
            ]
        }
    return mb.Robot(QUADRUPED, base="free", joint_stiffness=SPRINGS, joint_rest=dict.fromkeys(SPRINGS, 0.0) | REST, **feet)


@pytest.mark.long
def test_stiff_ground_tends_to_feet_that_cannot_move():
    """Frequencies and forces differ by what the ground gives way, in proportion to 1 / k."""
    robot = quadruped()
    posture = robot.equilibrium(GUESS)
    exact, forces = robot.linearize(posture).modes().natural_frequencies, posture.ground_reactions
    errors = []
    for k in (1e6, 1e8, 1e10):
        soft = quadruped((k, k, k))
        at = soft.equilibrium(GUESS)
        modes = soft.linearize(at).modes()
        assert set(at.ground_reactions) == set(forces)
        force = max(np.abs(at.ground_reactions[foot] - forces[foot]).max() for foot in FEET) / 50.0
        errors.append((np.abs(modes.natural_frequencies[:6] / exact - 1).max(), force))
    errors = np.array(errors)
    rounding = np.array([1e-13, np.finfo(float).eps * 1e10 / 50])  # of the stretches, in forces
    assert (errors[0] < 1e-2).all()
    assert (np.abs(errors[1] - errors[0] / 100) < 0.05 * errors[0] / 100).all()
    assert (errors[2] < 1.1e-4 * errors[0] + rounding).all()


def test_springs_that_are_lost_next_to_stiffer_ones_are_reported():
    """At 1e18 N/m float64 has no digits left for joints of 100 N m/rad; at 1e12 it has four."""
    for k, reported in ((1e6, False), (1e12, False), (1e18, True)):
        robot = quadruped((k, k, k))
        notices = robot.linearize(robot.equilibrium(GUESS)).notices
        assert [notice.doubtful for notice in notices if "spring of front left" in notice.text] == [True] * reported


def test_eigenvalues_are_those_of_differences_of_all_forces():
    k, c = (4e4, 3e4, 9e4), (20.0, 30.0, 80.0)
    robot = quadruped(k, c)
    posture = robot.equilibrium(GUESS)
    reference = Reference(Path(QUADRUPED).read_text(), "free", joint_stiffness=SPRINGS, joint_rest=REST, springs=robot.springs)
    reference.start = reference.configuration(REST, (0, 0, 0.337, 0, 0, 0, 1))
    q, system = posture.configuration, robot.linearize(posture)
    assert np.abs(reference.applied(q)).max() < 1e-9  # N, N m, of about 50 at each foot
    places = [reference.coordinates.index(name) for name in robot.coordinates]
    M, C, K = (part[np.ix_(places, places)] for part in (reference.mass(q), reference.damping(q), reference.stiffness(q, None)))
    assert np.abs(system.stiffness - K).max() < 1e-7 * np.abs(K).max()
    assert system.damping == pytest.approx(C, rel=1e-10, abs=1e-10 * C.max())
    n = len(M)
    first = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    expected = np.linalg.eigvals(first)
    own = system.modes().eigenvalues
    own = np.concatenate([own, own[own.imag != 0].conj()])
    assert len(own) == len(expected)
    distances = np.abs(own[:, None] - expected)
    assert (distances.min(axis=1) <= 1e-8 * np.abs(expected).max()).all()
    assert (distances.min(axis=0) <= 1e-8 * np.abs(expected).max()).all()


def test_the_feet_carry_the_weight_where_they_have_sunk():
    robot = quadruped((2e4, 2e4, 5e4))
    posture = robot.equilibrium(GUESS)
    weight = 9.81 * sum(inertia.mass for inertia in robot.model.inertias)
    forces = np.array(list(posture.ground_reactions.values()))
    assert forces.sum(axis=0)[:3] == pytest.approx([0, 0, weight], abs=1e-9)
    base = np.array(posture["base"][:3])
    assert 0 < 0.337 - base[2] < weight / (4 * 5e4) + 0.01


def box(centre, friction=0.5, patch=(0.2, 0.1), tilt=0.0, **options) -> mb.Robot:
    """A box on a sole of springs, in a field of gravity that may be tilted."""
    k = {"stiffness": (1e5, 2e5, 4e5), "turning_stiffness": (300.0, 500.0, 200.0), **options}
    sole = mb.Bushing("ground", None, "box", (0, 0, 0), friction=friction, patch=patch, name="sole", **k)
    gravity = (-9.81 * np.sin(tilt), 0, -9.81 * np.cos(tilt))
    return mb.Robot(urdf(link("box", 4.0, centre, (0.1, 0.2, 0.3))), base="free", springs=[sole], gravity=gravity)


def test_a_box_on_a_sole_in_closed_form():
    """Upright: heave and turn alone; sway and roll are pairs, with the pendulum's -m g h."""
    h, m, g = 0.3, 4.0, 9.81
    robot = box((0, 0, h))
    frequencies = robot.linearize(robot.equilibrium()).modes().natural_frequencies
    expected = [np.sqrt(4e5 / m), np.sqrt(200.0 / 0.3)]
    for k, turning, inertia in ((1e5, 500.0, 0.2), (2e5, 300.0, 0.1)):
        sunk = m * g / 4e5  # the force at rest acts at the foot, where the springs along the ground have no part in it
        M = np.array([[m, m * h], [m * h, inertia + m * h**2]])
        K = np.diag([k, turning - m * g * h])
        expected += np.sqrt(np.linalg.eigvals(np.linalg.solve(M, K)).real).tolist()
        assert sunk > 0
    assert frequencies == pytest.approx(np.sort(expected), rel=1e-10)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"centre": (0.05, 0.02, 0.1)}, ""),
        ({"centre": (0.12, 0.0, 0.01)}, "m along x from its point, and the sole ends at 0.1 m"),
        ({"centre": (0.0, 0.0, 0.1), "tilt": 0.6}, "the foot slips: it needs"),
        ({"centre": (0.0, 0.0, 0.01), "tilt": 3.0}, "the ground would have to pull by"),
    ],
)
def test_forces_of_compliant_feet_are_checked(options, text):
    found = [notice.text for notice in box(**options).equilibrium().notices if 'bushing "sole"' in notice.text]
    assert (len(found) == 1 and text in found[0]) if text else not found


def test_either_point_may_be_left_out():
    """Springs of one size in all directions are the same from either side."""
    turned = {"base": (0.1, 0.2, 0.3, 0.2, -0.4, 0.7)}
    k = {"stiffness": (1e6, 1e6, 1e6), "turning_stiffness": (1e4, 1e4, 1e4)}
    text = urdf(link("box", 4.0, (0.1, 0.0, 0.2), (0.1, 0.2, 0.3)))
    frequencies = []
    for ends in (("ground", None, "box", (0.1, 0, 0)), ("box", (0.1, 0, 0), "ground", None)):
        robot = mb.Robot(text, base="free", springs=[mb.Bushing(*ends, **k)])
        frequencies.append(robot.linearize(robot.equilibrium(turned)).modes().natural_frequencies)
    assert frequencies[0] == pytest.approx(frequencies[1], rel=1e-5)  # the axes turn with the box on one side, by 1e-3


def test_the_ground_may_slope():
    """Ground turned about y by an angle is gravity turned the other way."""
    angle, frequencies = 0.3, []
    for sole, gravity, guess in (
        ({"rotation1": (0, angle, 0)}, (0, 0, -9.81), {"base": (0, 0, 0, 0, angle, 0)}),
        ({}, (9.81 * np.sin(angle), 0, -9.81 * np.cos(angle)), {}),
    ):
        given = {"stiffness": (1e5, 2e5, 4e5), "turning_stiffness": (300.0, 500.0, 200.0), **sole}
        robot = mb.Robot(
            urdf(link("box", 4.0, (0, 0, 0.1), (0.1, 0.2, 0.3))),
            base="free",
            springs=[mb.Bushing("ground", None, "box", (0, 0, 0), **given)],
            gravity=gravity,
        )
        frequencies.append(robot.linearize(robot.equilibrium(guess)).modes().natural_frequencies)
    assert frequencies[0] == pytest.approx(frequencies[1], rel=1e-9)


def test_what_is_missing_is_named():
    with pytest.raises(mb.InputError, match='bushing "foot": point1 is missing; give one of both points'):
        mb.Bushing("ground", None, "shin", None, name="foot")
    with pytest.raises(mb.InputError, match="point1 is missing; a spring needs the point on ground that it ends at"):
        mb.BodySpring("ground", None, "shin", (0, 0, 0), stiffness=1.0)
    with pytest.raises(mb.InputError, match="found rotation2 without point1"):
        mb.Bushing("ground", None, "shin", (0, 0, 0), rotation2=(0, 0, 1))
    with pytest.raises(
        mb.InputError, match="expected two lengths of the sole of a foot with friction that is rigid or has springs about all axes"
    ):
        mb.Bushing("ground", None, "shin", (0, 0, 0), friction=0.5, patch=(0.1, 0.1))
    with pytest.raises(mb.InputError, match=r"friction: found -0\.5"):
        mb.Bushing("ground", None, "shin", (0, 0, 0), friction=-0.5)


def test_a_robot_file_has_feet_on_compliant_ground(tmp_path):
    (tmp_path / "box.urdf").write_text(urdf(link("box", 4.0, (0, 0, 0.3), (0.1, 0.2, 0.3))))
    (tmp_path / "robot.toml").write_text(
        'urdf = "box.urdf"\nbase = "free"\n[[bushing]]\nname = "sole"\nbody1 = "ground"\nbody2 = "box"\npoint2 = [0, 0, "0 mm"]\n'
        'stiffness = ["100 N/mm", "200 N/mm", "400 N/mm"]\nturning_stiffness = [300, 500, 200]\nfriction = 0.5\npatch = ["20 cm", 0.1]\n'
    )
    robot, data = mb.read_robot(tmp_path)
    own, given = (item.linearize(item.equilibrium(**data.posture)) for item in (box((0, 0, 0.3)), robot))
    assert given.stiffness == pytest.approx(own.stiffness, rel=1e-14)
    assert robot.springs[0].patch == (0.2, 0.1)
