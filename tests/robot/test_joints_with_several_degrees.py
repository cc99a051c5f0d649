"""Joints with several degrees of freedom in the table of a posture, and joints without limits."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import mbconstrained as mb
from mbconstrained.scene.build.robot_model import _place


def swinging(joint, name="j"):
    """A rod on one joint, as a pinocchio model."""
    model = pinocchio.Model()
    number = model.addJoint(0, joint, pinocchio.SE3.Identity(), name)
    model.appendBodyToJoint(
        number, pinocchio.Inertia(1.0, np.array([0, 0, -0.5]), np.diag([0.01, 0.02, 0.03])), pinocchio.SE3.Identity()
    )
    model.addBodyFrame("rod", number, pinocchio.SE3.Identity(), 0)
    return model


@pytest.mark.parametrize(
    ("joint", "texts"),
    [
        (pinocchio.JointModelRY(), ["0 rad"]),
        (pinocchio.JointModelPX(), ["0 m"]),
        (pinocchio.JointModelSpherical(), ["roll, pitch, yaw (0, 0, 0) rad"]),
        (pinocchio.JointModelTranslation(), ["(0, 0, 0) m"]),
        (pinocchio.JointModelPlanar(), ["(0, 0) m", "0 rad"]),
        (pinocchio.JointModelFreeFlyer(), ["(0, 0, 0) m", "roll, pitch, yaw (0, 0, 0) rad"]),
    ],
)
def test_places_are_written_by_their_units(joint, texts):
    robot = mb.Robot(swinging(joint))
    units = dict(zip(robot.coordinates, robot.units))
    (name,) = robot.tangent.joints
    value = robot.tangent.values(pinocchio.neutral(robot.model))[name]
    text = _place(value, [units[one] for one in robot.tangent.coordinates_of(name)])
    assert all(one in text for one in texts), text


def test_a_quarter_turn_of_a_ball_is_its_yaw():
    half = np.sqrt(0.5)
    assert _place((0.0, 0.0, half, half), ["rad"] * 3) == "roll, pitch, yaw (0, 0, 1.5708) rad"


@pytest.mark.parametrize("limits", [None, (-np.inf, np.inf), (-np.inf, 1.0), (-1.0, np.inf)])
def test_joints_without_limits_are_not_beyond_them(limits):
    """Pinocchio has the largest float64 number where there is no limit."""
    model = swinging(pinocchio.JointModelRY())
    if limits:
        model.lowerPositionLimit[:], model.upperPositionLimit[:] = limits
    robot = mb.Robot(model)
    assert not [notice for notice in robot.equilibrium().notices if "limits" in notice.text]
    assert (robot.limits == {}) == (limits in (None, (-np.inf, np.inf)))
    assert robot.tangent.outside_limits({"j": 2.0}, 1e-9, 0.1) == (
        "" if limits != (-np.inf, 1.0) else robot.tangent.outside_limits({"j": 2.0}, 0.0)
    )
