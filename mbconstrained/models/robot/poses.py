"""Where the links of a robot are while it moves about a posture: for pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...checks import real_array, real_number
from .equilibrium import Search, closed

if TYPE_CHECKING:
    from .posture import Posture


@dataclass(frozen=True)
class Poses:
    """Positions (3, T) in m and unit quaternions (4, T) x y z w of a link, without jumps of sign."""

    positions: np.ndarray
    quaternions: np.ndarray


def link_poses(posture: Posture, displacements, scale: float = 1.0) -> dict[str, Poses]:
    """The poses of all links for small motions d, drawn larger.

    The configuration is q0 (+) scale d, put back onto the loops by the shortest way: linear motion leaves them by the
    square of its size, and a picture in which joints come apart would be wrong in another way.

    Args:
        posture: where the motion is about.
        displacements: d, shape (n, T), rows beyond the links' coordinates (motors) are not looked at.
        scale: how much larger than true.
    """
    robot, load = posture.robot, posture.balance.load
    tree, count = robot.tree, len(robot.coordinates)
    d = real_array(displacements, "displacements", shape=(None, None))[:count] * real_number(scale, "scale")
    everywhere = Search(tree, load, np.ones(count, bool))
    numbers = [robot.link_frames.number(name) for name in robot.bodies]
    positions, quaternions = np.empty((len(numbers), 3, d.shape[1])), np.empty((len(numbers), 4, d.shape[1]))
    for k, step in enumerate(d.T):
        q = tree.moved(posture.configuration, step)
        if load.is_held:
            q = closed(everywhere, q, tolerance=PICTURE).configuration
        for body, (position, quaternion) in enumerate(tree.frames(q, numbers)):
            positions[body, :, k], quaternions[body, :, k] = position, quaternion
    return {name: Poses(positions[i], _continuous(quaternions[i])) for i, name in enumerate(robot.bodies)}


#: Loops are closed for a picture when they are open by less than this share of the robot's size.
PICTURE = 1e-6


def _continuous(quaternions: np.ndarray) -> np.ndarray:
    """Of the two quaternions for a rotation always the one nearer to that before."""
    flips = np.sum(quaternions[:, 1:] * quaternions[:, :-1], axis=0) < 0
    signs = np.cumprod(np.concatenate([[1.0], np.where(flips, -1.0, 1.0)]))
    return quaternions * signs[: quaternions.shape[1]]
