"""Universal loops: Cardan's ratio of speeds, a cross of two hinges, differences. Soles and shares of load among feet."""

import numpy as np
import pinocchio as pin
import pytest

import mbconstrained as mb
from mbconstrained.robot.kinematics import turned_product
from tests.robot.linkages import GROUND, joint, link, null_space, urdf


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 2.0, 3.1])
def test_the_product_with_a_turned_vector_and_its_derivatives(angle):
    rng = np.random.default_rng(int(10 * angle))
    a, b, w = rng.standard_normal((3, 3))
    w *= angle / np.linalg.norm(w)
    value, gradient, second = turned_product(a, b, w)
    assert value == pytest.approx(a @ pin.exp3(w) @ b, abs=1e-13)
    h, steps = 1e-3, np.eye(3)

    def difference(f, e):
        return (8 * (f(w + h * e) - f(w - h * e)) - (f(w + 2 * h * e) - f(w - 2 * h * e))) / (12 * h)

    assert gradient == pytest.approx([difference(lambda x: a @ pin.exp3(x) @ b, e) for e in steps], abs=1e-10)
    assert second == pytest.approx(np.array([difference(lambda x: turned_product(a, b, x)[1], e) for e in steps]), abs=1e-10)


BEND = 0.5


def cardan() -> mb.Robot:
    """Two shafts in the plane of x and z at an angle, joined at the origin."""
    shafts = [link(name, 1.0, (0, 0, 0.2), (0.1, 0.1, 0.02)) for name in ("driving", "driven")]
    turned = [
        joint("first", "frame", "driving", axis=(0, 0, 1)),
        joint("second", "frame", "driven", axis=(0, 0, 1), turned=(0, BEND, 0)),
    ]
    loop = mb.Loop("driving", (0, 0, 0), "driven", (0, 0, 0), kind="universal", axis=(1, 0, 0), axis2=(0, 1, 0), name="cardan")
    return mb.Robot(urdf(GROUND, *shafts, *turned), loops=[loop], joint_stiffness={"first": 5.0}, joint_rest={"first": 0.0})


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.2, 2.5])
def test_the_ratio_of_speeds_of_a_cardan_joint(angle):
    robot = cardan()
    posture = robot.equilibrium({"first": angle, "second": np.arctan2(np.sin(angle), np.cos(angle) * np.cos(BEND))}, hold=["first"])
    system = robot.linearize(posture)
    assert [row.name for row in system.rows] == ["cardan right angle"]  # the others the joints satisfy alone
    N = null_space(system.constraint_matrix)[:, 0]
    # tan(second) = tan(first) / cos(bend) where the cross lies across the plane of the shafts at 0, or tan(first) cos(bend)
    second = posture["second"]
    assert np.tan(second) == pytest.approx(
        np.tan(angle) * np.cos(BEND) ** (1 if abs(np.tan(second)) < abs(np.tan(angle)) else -1), rel=1e-9
    )
    h = 1e-4
    near = [robot.equilibrium({**posture.joints, "first": angle + s * h}, hold=["first"])["second"] for s in (1, -1)]
    assert N[1] / N[0] == pytest.approx((near[0] - near[1]) / (2 * h), rel=1e-6)


def test_a_universal_loop_moves_as_two_hinges_with_a_cross_almost_without_mass():
    inertia, lever = (0.05, 0.06, 0.02), (0.0, 0.02, -0.4)
    bob = link("bob", 2.0, lever, inertia)
    cross = link("cross", 1e-12, (0, 0, 0), (1e-14, 1e-14, 1e-14))
    hinged = mb.Robot(
        urdf(
            GROUND, cross, bob, joint("about x", "frame", "cross", axis=(1, 0, 0)), joint("about y", "cross", "bob", axis=(0, 1, 0))
        )
    )
    free = mb.Robot(
        urdf(bob),
        base="free",
        loops=[mb.Loop("ground", (0, 0, 0), "bob", (0, 0, 0), kind="universal", axis=(1, 0, 0), axis2=(0, 1, 0))],
    )
    frequencies = [
        robot.linearize(robot.equilibrium(guess)).modes().natural_frequencies for robot, guess in ((hinged, {}), (free, {}))
    ]
    assert frequencies[1] == pytest.approx(frequencies[0], rel=1e-8) and len(frequencies[1]) == 2


def standing(patch, centre, friction=0.5, **options) -> mb.Robot:
    foot = mb.Loop("box", (0, 0, 0), "ground", kind="rigid", friction=friction, patch=patch, name="sole", **options)
    return mb.Robot(urdf(link("box", 4.0, centre, (0.1, 0.1, 0.1))), base="free", loops=[foot])


@pytest.mark.parametrize(
    ("centre", "text"),
    [
        ((0.09, 0.04, 0.3), ""),
        ((0.11, 0.0, 0.3), "tips over: the centre of pressure would be 0.11 m along x from its point, and the sole ends at 0.1 m"),
        (
            (0.0, -0.06, 0.3),
            "tips over: the centre of pressure would be 0.06 m along y from its point, and the sole ends at 0.05 m",
        ),
    ],
)
@pytest.mark.parametrize("turned", [(0.0, 0.0, 0.0), (np.pi, 0.0, 0.0)])
def test_a_sole_tips_where_the_centre_of_mass_is_beside_it(centre, text, turned):
    posture = standing((0.2, 0.1), centre, rotation1=turned).equilibrium()
    tips = [notice.text for notice in posture.notices if "tips" in notice.text]
    assert (text in tips[0]) if text else not tips


def test_patches_belong_to_rigid_feet_with_friction():
    with pytest.raises(mb.InputError, match=r'loop "foot": patch: found \(0.1, 0.1\); expected two lengths of the sole'):
        mb.Loop("foot", (0, 0, 0), "ground", kind="point", friction=0.5, patch=(0.1, 0.1), name="foot")
    with pytest.raises(mb.InputError, match="axis2: found 0, 0, 0"):
        mb.Loop("a", (0, 0, 0), "b", kind="universal", axis2=(0, 0, 0))


def table(friction: float, tilt: float = 0.0) -> mb.Posture:
    """A box on four points: three forces at each, six equations."""
    feet = [
        mb.Loop("box", (x, y, 0), "ground", (x, y, 0), friction=friction, name=f"foot {x} {y}")
        for x in (-0.3, 0.3)
        for y in (-0.2, 0.2)
    ]
    g = 9.81
    robot = mb.Robot(
        urdf(link("box", 4.0, (0.28, 0.1, 0.1), (0.1, 0.1, 0.1))),
        base="free",
        loops=feet,
        gravity=(-g * np.sin(tilt), 0, -g * np.cos(tilt)),
    )
    return robot.equilibrium()


def test_feet_slip_only_where_no_share_of_the_load_keeps_them_in_place():
    least_norm = table(0.3)
    pulls = [value[2] * -1 for value in least_norm.reactions.values()]
    assert min(pulls) < 0  # the share of least norm would pull, but three feet carry the box
    assert not [notice for notice in least_norm.notices if "slip" in notice.text or "lift" in notice.text]
    slope = table(0.3, np.arctan(0.28))
    assert not [notice for notice in slope.notices if "slip" in notice.text or "lift" in notice.text]
    steep = table(0.3, np.arctan(0.32))
    assert [notice for notice in steep.notices if "slip" in notice.text or "lift" in notice.text]
