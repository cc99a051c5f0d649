"""Ellipsoids that stand for the inertia of bodies: solid ellipsoids in closed form, and the tensors of pinocchio."""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb
from tests.robot.linkages import GROUND, joint, link, urdf


def test_a_solid_ellipsoid_is_itself():
    m, (a, b, c) = 3.0, (0.3, 0.2, 0.1)
    moments = (m * (b**2 + c**2) / 5, m * (a**2 + c**2) / 5, m * (a**2 + b**2) / 5)
    text = urdf(GROUND, link("arm", m, (0.4, 0.1, -0.2), moments, (0.3, -0.2, 0.5)), joint("j", "frame", "arm"))
    robot = mb.Robot(text)
    found = robot.inertia_ellipsoids()
    assert set(found) == {"arm"}
    E = found["arm"]
    assert E[:3, 3] == pytest.approx([0.4, 0.1, -0.2]) and E[3].tolist() == [0, 0, 0, 1]
    assert np.sort(np.linalg.norm(E[:3, :3], axis=0)) == pytest.approx([c, b, a], rel=1e-9)
    assert np.linalg.det(E[:3, :3]) == pytest.approx(a * b * c, rel=1e-9)  # no mirror image


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
