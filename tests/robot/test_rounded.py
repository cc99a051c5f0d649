"""Angles of a URDF with few digits: where loops stay open or lock by them it is said which they are."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.robot.posture_search import rounded_to
from tests.robot.linkages import GROUND, bar, joint, urdf

LENGTHS = (0.2, 0.5, 0.4)
GUESS = {"j1": 1.2, "j2": -0.8, "j3": 1.5}
MANY = repr(np.pi / 2)


def four_bar(first: str, second: str, middle: str = "0", **options) -> mb.Robot:
    """A four-bar in the vertical plane, as a program for drawing writes it: all joints turn about z, the plane is turned."""
    parts = [bar(name, 0.5, length) for name, length in zip(("crank", "coupler", "rocker"), LENGTHS)]
    placed = [("j1", "frame", "crank", 0.0, first), ("j2", "crank", "coupler", 0.2, middle), ("j3", "frame", "rocker", 0.5, second)]
    joints = [
        joint(name, parent, child, at=(at, 0, 0)).replace('rpy="0.0 0.0 0.0"', f'rpy="{turned} 0 0"')
        for name, parent, child, at, turned in placed
    ]
    loop = mb.Loop("coupler", (0.5, 0, 0), "rocker", (0.4, 0, 0), name="pin", **options)
    return mb.Robot(urdf(GROUND, *parts, *joints), loops=[loop], joint_stiffness={"j1": 20.0}, joint_rest={"j1": 1.2})


@pytest.mark.parametrize(
    ("text", "eighths"),
    [("1.57", 2), ("1.5708", 2), ("-1.571", -2), ("3.14159", 4), ("0.785", 1), ("6.28", 8)]
    + [(text, None) for text in ("0", "1.6", "1.50", "1.5699", "0.0008", MANY, "1.5707963268")],
)
def test_multiples_of_an_eighth_of_a_turn_are_known_by_their_digits(text, eighths):
    assert rounded_to(text) == eighths


@pytest.mark.parametrize("kind", ["point", "hinge"])
def test_a_loop_that_rounding_keeps_open_is_reported_with_its_gap_and_the_remedy(kind):
    with pytest.raises(mb.InputError, match=r"pin \w+ stays open by 0.0\d+ m; the rpy 1.57 of joint \"j1\" is rounded.*1.57079632"):
        four_bar("1.57", MANY, kind=kind).equilibrium(GUESS)
    with pytest.raises(mb.InputError, match=r'rpy 1.57 of joint "j1", the rpy 1.5708 of joint "j3" are rounded'):
        four_bar("1.57", "1.5708", kind=kind).equilibrium(GUESS)


def test_a_loop_that_rounding_locks_is_doubtful():
    robot = four_bar(MANY, MANY, middle="3.14")
    notices = [notice for notice in robot.equilibrium({"j1": 1.2, "j2": 0.8, "j3": 1.5}).notices if notice.doubtful]
    assert len(notices) == 1 and "leave 0 motions" in notices[0].text and 'rpy 3.14 of joint "j2"' in notices[0].text


def test_a_gap_that_rounding_cannot_make_is_not_blamed_on_it():
    robot = four_bar("1.57", "-1.57")
    with pytest.raises(mb.InputError) as problem:
        robot.equilibrium(GUESS)
    assert "rounded" not in str(problem.value)


def crossed_crank(turned: float) -> tuple[mb.Robot, dict]:
    """A parallelogram with a third crank that closes exactly but is turned: with it nothing moves, parallel it moves."""
    end = np.array([0.25, 0.0]) + 0.3 * np.array([np.cos(1.2), np.sin(1.2)])
    pivot = end - 0.3 * np.array([np.cos(1.2 + turned), np.sin(1.2 + turned)])
    parts = [bar(name, 0.5, 0.5 if name == "coupler" else 0.3) for name in ("crank", "coupler", "rocker", "third")]
    joints = [
        joint(name, parent, child, at=(*at, 0))
        for name, parent, child, at in [
            ("j1", "frame", "crank", (0, 0)),
            ("j2", "crank", "coupler", (0.3, 0)),
            ("j3", "frame", "rocker", (0.5, 0)),
            ("j4", "frame", "third", pivot.tolist()),
        ]
    ]
    pins = [mb.Loop("coupler", (at, 0, 0), body, (0.3, 0, 0), name=body) for at, body in ((0.5, "rocker"), (0.25, "third"))]
    robot = mb.Robot(urdf(GROUND, *parts, *joints), loops=pins, joint_stiffness={"j1": 20.0}, joint_rest={"j1": 1.2})
    return robot, {"j1": 1.2, "j2": -1.2, "j3": 1.2, "j4": 1.2 + turned}


@pytest.mark.parametrize("digits", range(2, 12))
def test_a_redundant_crank_that_is_nearly_parallel_on_purpose_is_never_trusted_to_move(digits):
    robot, guess = crossed_crank(10.0**-digits)
    posture = robot.equilibrium(guess, hold="all")
    freedom = len(robot.coordinates) - len(posture.independent_rows)
    assert freedom == 0 or any(notice.doubtful and "less" in notice.text for notice in posture.notices)


@pytest.mark.parametrize("turned", [0.0, 1e-15])
def test_a_parallel_crank_is_redundant_without_a_doubt(turned):
    robot, guess = crossed_crank(turned)
    posture = robot.equilibrium(guess)
    assert len(robot.coordinates) - len(posture.independent_rows) == 1
    assert not any(notice.doubtful for notice in posture.notices)


def standing_twice_on_a_foot(distance: float) -> mb.Posture:
    """The quadruped, one foot of which stands on two points at a distance from each other."""
    bare, data = mb.read_robot("robots/quadruped")
    second = np.array(bare.loops[0].point1) + distance * np.array([0.6, 0.0, 0.8])
    loops = [*bare.loops, mb.Loop(bare.loops[0].body1, tuple(second), "ground", name="second point")]
    guess = data.posture["guess"]
    closed = bare.equilibrium(guess, hold="all")
    return mb.Robot(data.names.path, loops=loops, base="free").equilibrium(closed.configuration, hold="all")


@pytest.mark.parametrize("digits", range(2, 15, 2))
def test_a_second_point_of_a_foot_is_never_left_out_without_a_doubt(digits):
    """It takes two motions; where it lies so near to the first that they count as one, only rounding errors need no notice."""
    posture = standing_twice_on_a_foot(10.0**-digits)
    independent = len(posture.independent_rows)
    assert independent == 12 + 2 * (digits <= 4)
    assert any(notice.doubtful for notice in posture.notices) == (4 <= digits < 12)
