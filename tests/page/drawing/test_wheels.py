"""Wheels: they touch, their teeth stand in the gaps of each other, and stay there while they turn."""

import math

import numpy as np
import pytest

from mbconstrained.models.lumped import LumpedModel
from mbconstrained.page.automatic_drawing import lumped_drawing


def drawing_of(*gears, shafts=()):
    model = LumpedModel()
    names = dict.fromkeys(name for gear in gears for name in gear[:2]) | dict.fromkeys(name for pair in shafts for name in pair)
    for name in names:
        model.inertia(name, 1.0)
    for start, end in shafts:
        model.torsion_spring(start, end, 1.0)
    for gear in gears:
        model.gear(*gear)
    return lumped_drawing(model.elements, model.coordinates)


def tooth(body, direction, turn=0.0):
    """How many pitches of the wheel lie between its first tooth and a direction, modulo one."""
    first = -body.rest_turn[1] + turn
    return (direction - first) * body.teeth / (2 * math.pi) % 1.0


def direction(one, other):
    gap = np.subtract(other.rest, one.rest)
    return math.atan2(gap[2], gap[0])


@pytest.mark.parametrize("radii", [(20, 60), (0.02, 0.03), (1.0, 1.0), (30, 11), (0.5, 2.2)])
def test_outer_toothing_meshes_at_every_angle(radii):
    one, other = drawing_of(("a", "b", *radii)).bodies
    assert math.dist(one.rest, other.rest) == pytest.approx((one.size[0] + other.size[0]) / 2)
    assert one.size[0] / other.size[0] == pytest.approx(radii[0] / radii[1])
    assert one.teeth / other.teeth == pytest.approx(radii[0] / radii[1], rel=0.03)
    there = direction(one, other)
    for turn in (0.0, 0.1, 1.7):
        # q_b = -q_a r_a / r_b; a tooth of one in a gap of the other: their shares add up to one half
        shares = tooth(one, there, turn), tooth(other, there + math.pi, -turn * one.teeth / other.teeth)
        assert math.cos(2 * math.pi * (sum(shares) - 0.5)) == pytest.approx(1.0)


@pytest.mark.parametrize("radii", [(20, 60), (90, 30)])
def test_inner_toothing_meshes_at_every_angle(radii):
    one, other = drawing_of(("a", "b", *radii, True)).bodies
    ring, wheel = sorted((one, other), key=lambda body: -body.size[0])
    assert (ring.shape, wheel.shape) == ("ring", "gear")
    assert math.dist(one.rest, other.rest) == pytest.approx((ring.size[0] - wheel.size[0]) / 2)
    there = direction(ring, wheel)
    for turn in (0.0, 0.1, 1.7):
        # the ring's outline is a hole: its tooth is a gap, and both turn the same way
        shares = tooth(ring, there, turn * wheel.teeth / ring.teeth), tooth(wheel, there, turn)
        assert math.cos(2 * math.pi * (shares[0] - shares[1])) == pytest.approx(1.0)


def test_a_compound_wheel_meshes_in_two_planes():
    bodies = {body.name: body for body in drawing_of(("a", "b", 20, 60), ("b", "c", 15, 45)).bodies}
    assert bodies["b, wheel 2"].label == ""
    assert bodies["a"].rest[1] == bodies["b"].rest[1]
    assert bodies["c"].rest[1] == bodies["b, wheel 2"].rest[1] != bodies["b"].rest[1]


def test_three_wheels_around_one_do_not_stand_in_each_other():
    bodies = {body.name: body for body in drawing_of(("a", "b", 20, 20), ("a", "c", 20, 20), ("a", "d", 20, 20)).bodies}
    for one, other in (("b", "c"), ("b", "d"), ("c", "d")):
        assert math.dist(bodies[one].rest, bodies[other].rest) > 2.5


def test_positive_angles_turn_counter_clockwise():
    assert drawing_of(("a", "b", 20, 20)).bodies[0].turns == {"a": (0, -1, 0)}
