"""Where the links of a robot are while it moves about a posture: for pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...checks import real_array, real_number
from ...errors import InputError
from .equilibrium import Search, closed, rows_of

if TYPE_CHECKING:
    from .posture import Posture


@dataclass(frozen=True)
class Poses:
    """Positions (3, T) in m and unit quaternions (4, T) x y z w of a link; both signs of a quaternion are the same rotation."""

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
    robot, tree = posture.robot, posture.robot.tree
    count = len(robot.coordinates)
    d = real_array(displacements, "displacements", shape=(None, None))
    if len(d) < count:
        raise InputError(f"displacements: found {len(d)} rows; expected one for each of the {count} coordinates")
    d = d[:count] * real_number(scale, "scale")
    on_loops = _onto_loops(posture)
    numbers = [robot.link_frames.number(name) for name in robot.bodies]
    positions, quaternions = np.empty((len(numbers), 3, d.shape[1])), np.empty((len(numbers), 4, d.shape[1]))
    for k, step in enumerate(d.T):
        frames = tree.frames(on_loops(tree.moved(posture.configuration, step)), numbers)
        for body, (position, quaternion) in enumerate(frames):
            positions[body, :, k], quaternions[body, :, k] = position, quaternion
    return {name: Poses(positions[i], quaternions[i]) for i, name in enumerate(robot.bodies)}


#: Loops are closed for a picture when they are open by less than this, in rad or as a share of the robot's size.
PICTURE = 1e-5

#: Steps with the rows of the posture after which those of the place itself are taken.
MOST_CHORDS = 6


def _onto_loops(posture: Posture) -> Callable[[np.ndarray], np.ndarray]:
    """From a configuration near the posture to one with closed loops.

    First by steps with the rows of the posture itself, which need no new derivatives, and where they fail, by Gauss-Newton's.
    """
    balance, load = posture.balance, posture.balance.load
    if not load.is_held:
        return lambda q: q
    everywhere = Search(posture.robot.tree, load, np.ones(len(load.units), bool))
    rows = rows_of(balance.scaled_jacobian)

    def on_loops(q: np.ndarray) -> np.ndarray:
        here = everywhere.at(q)
        for _ in range(MOST_CHORDS):
            if np.abs(here.scaled_gaps).max() <= PICTURE:
                return here.configuration
            here = everywhere.moved(here, -rows.shortest(here.scaled_gaps) * load.lengths)
        return closed(everywhere, q).configuration

    return on_loops
