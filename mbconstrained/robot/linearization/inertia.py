"""Masses and momenta of the bodies of a robot at a posture."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..robot_model import RobotModel

if TYPE_CHECKING:
    from ..posture import Posture


#: Least semi-axis of an ellipsoid (m): a point mass is drawn, and the normals of a flat one exist.
THINNEST = 0.001


def body_masses(posture: Posture) -> list[tuple[str, np.ndarray]]:
    """The contribution S_j^T I_j S_j of each body to M, shape (nv, nv), with the name of its heaviest link."""
    names, inertias = posture.robot.link_frames.heaviest_links(), posture.robot.model.inertias
    return [
        (
            names.get(joint, str(posture.robot.model.names[joint])),
            inertias[joint].mass * v.T @ v + w.T @ np.array(inertias[joint].inertia) @ w,
        )
        for joint, _, v, w, _ in _motions(posture)
    ]


def momentum(posture: Posture) -> np.ndarray:
    """Momentum and angular momentum about the origin of the ground by velocity of each coordinate, shape (6, nv)."""
    total = np.zeros((6, posture.robot.model.nv))
    for joint, centre, v, w, R in _motions(posture):
        inertia = posture.robot.model.inertias[joint]
        total[:3] += inertia.mass * v
        total[3:] += inertia.mass * np.cross(centre, v, axis=0) + R @ np.array(inertia.inertia) @ w
    return total


def inertia_ellipsoids(robot: RobotModel) -> dict[str, np.ndarray]:
    """Inertia ellipsoids as in ``Robot.inertia_ellipsoids``, with semi-axes a, b, c of at least THINNEST: m (b^2 + c^2) / 5 = I_1."""
    ellipsoids = {}
    for joint, name in robot.link_frames.heaviest_links().items():
        inertia = robot.model.inertias[joint]
        if joint == 0 or inertia.mass <= 0:
            continue
        moments, axes = np.linalg.eigh(np.array(inertia.inertia))
        squares = 2.5 * (moments.sum() - 2 * moments) / inertia.mass
        link, placement = robot.link_frames.link(name), np.eye(4)
        axes[:, 0] *= np.linalg.det(axes)  # a rotation
        placement[:3, :3] = link.rotation.T @ axes * np.maximum(np.sqrt(np.maximum(squares, 0.0)), THINNEST)
        placement[:3, 3] = link.rotation.T @ (np.array(inertia.lever) - link.point)
        ellipsoids[name] = placement
    return ellipsoids


def _motions(posture: Posture) -> Iterator[tuple[int, np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Joint, centre of mass, its velocity (3, nv), angular velocity in principal axes (3, nv), and these axes, for each body."""
    model, kinematics = posture.robot.model, posture.balance.kinematics
    for joint in range(1, model.njoints):
        R = kinematics.rotations[joint]
        centre = kinematics.origins[joint] + R @ np.array(model.inertias[joint].lever)
        yield joint, centre, kinematics.of_point(joint, centre), R.T @ kinematics.velocity(joint)[3:], R
