"""What a motion says about itself: names, amounts, units."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.mechanics.constraints import Constraint
from mbconstrained.mechanics.system import MechanicalSystem
from tests.mechanics.systems import massless_joints, two_masses


def texts(motion, kind):
    return [notice.text for notice in motion.notices if notice.kind == kind]


def test_a_consistent_motion_at_position_level_is_silent():
    assert two_masses("position", value=-0.4).solve([0.8, 1.2, 2.0]).notices == ()


def test_a_gap_in_a_link():
    link = Constraint([1, -1], names="link")
    motion = MechanicalSystem(np.eye(2), constraints=link, names=["cart", "wagon"]).solve([1, 0])
    assert texts(motion, "jump") == [
        'constraint "link" (position level) is violated at 0-: its displacement is 1 m instead of 0 m, off by 1 m; it is '
        "enforced at t = 0",
        "cart: its displacement jumps at t = 0 by -0.5 m, from 1 m to 0.5 m",
        "wagon: its displacement jumps at t = 0 by 0.5 m, from 0 m to 0.5 m",
    ]
    assert texts(motion, "impulse") == [
        'constraint "link": its force contains the first derivative of a Dirac impulse of -0.5 N s^2 at t = 0'
    ]


def test_massless_joints_that_jump():
    motion = massless_joints().solve([1, 1, 2], [0, 1, 0])
    assert texts(motion, "jump") == [
        "u1: its displacement jumps at t = 0 by -0.333333 m, from 1 m to 0.666667 m",
        "u2: its velocity jumps at t = 0 by -1 m/s, from 1 m/s to 0 m/s",
    ]
    assert texts(motion, "impulse") == []


def test_a_violation_that_is_nothing_next_to_another_is_not_reported():
    """A row that an angle of rounded digits tilts by 1e-12, alone and with the row that the motion violates indeed."""
    tilted, broken = Constraint([1, 0, 1e-12], names="tilted"), Constraint([0, 1, -0.5], names="broken")
    for rows, reported in (([tilted], ["tilted"]), ([tilted, broken], ["broken"])):
        motion = MechanicalSystem(np.eye(3), constraints=rows).solve(velocity=[0, 0, 0.1])
        assert [text.split('"')[1] for text in texts(motion, "jump") if "violated" in text] == reported


def test_velocity_rows_that_do_not_hold():
    belt = MechanicalSystem([[1.0]], constraints=Constraint([1], level="velocity", value=2.0, names="belt"))
    (text, jump) = texts(belt.solve([5.0]), "jump")
    assert 'constraint "belt" (velocity level) is violated at 0-: its velocity is 0 m/s instead of 2 m/s, off by -2 m/s' in text
    assert jump == "x1: its velocity jumps at t = 0 by 2 m/s, from 0 m/s to 2 m/s"


def test_levels_below_position_say_what_they_keep():
    assert texts(two_masses().solve([0.8, 1.2, 2.0], [0, 0.1, 0]), "drift") == [
        'constraint "link" is at acceleration level (2 drift eigenvalues): its position value starts at -0.4 m and drifts at '
        "-0.1 m/s; no equation corrects it"
    ]
    assert texts(two_masses("velocity").solve([0.8, 1.2, 2.0]), "drift") == [
        'constraint "link" is at velocity level (1 drift eigenvalue): its position value starts at -0.4 m; no equation corrects it'
    ]


def test_redundant_rows_and_static_offsets():
    system = MechanicalSystem(
        np.eye(2),
        constraints=[Constraint([1, -1], names="tie"), Constraint([3, -3], names="spare")],
        names=["a", "b"],
        static_force=[-9.81, 0.0],
    )
    notices = system.solve().notices
    assert [notice.kind for notice in notices] == ["redundant", "static load"]
    assert notices[1].text == "constant forces from rest lengths and weights act from t = 0 on: a -9.81 N"
    assert not any(notice.doubtful for notice in notices)


@pytest.mark.parametrize("skew", [0.0, 1e-17, 0.5])
def test_an_unsymmetric_mass_matrix_is_reported_by_every_answer(skew):
    """Rounding errors are none."""
    system = mb.MechanicalSystem([[2.0, 0.1 + skew], [0.1, 1.0]], np.eye(2), np.diag([4.0, 9.0]))
    answers = (
        system,
        system.solve([1.0, 0.0]),
        system.frequency_response([0.1]),
        system.random_response({"x1": mb.white_noise(1.0)}),
    )
    for answer in answers:
        assert [notice.kind for notice in answer.notices].count("unsymmetric") == (skew == 0.5)


@pytest.mark.parametrize("of", [["velocity"], {"velocity"}, 3, "velocty", None])
def test_the_quantity_of_an_error_estimate_is_a_word(of):
    motion = mb.MechanicalSystem(mass=[[1.0]], stiffness=[[1.0]], names=["a"]).solve(displacement=[1.0])
    assert repr(motion) == "Motion(1 coordinate: a; 0 jumps and 0 impulses at t = 0; 0 events later)"
    with pytest.raises(mb.InputError, match="of: found .*; expected one of displacement, velocity, acceleration, reaction"):
        motion.error_estimate(1.0, of=of)
    assert motion.error_estimate([0.5, 1.0], order=1) == motion.error_estimate([0.5, 1.0], of="velocity")
