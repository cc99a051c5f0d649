"""How the bodies of a robot move in one configuration, and how that changes when they do.

All in the directions of the ground: the column s_i of S is the velocity (v of the point that passes the origin; w)
that the rate of tangent coordinate i gives to the bodies behind it. A column moves with the joints before it,

    d s_i / d q_k = s_k x s_i        where k comes before i on the way from the ground, or belongs to the same joint,

which is all that second derivatives of poses are made of.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .tree import Tree


@dataclass(frozen=True)
class Anchor:
    """A frame fixed in a joint of the model; joint 0 is the ground.

    Attributes:
        joint: number of the joint that it moves with.
        rotation: shape (3, 3), from the frame into that of the joint.
        point: its origin in the frame of the joint (m).
    """

    joint: int
    rotation: np.ndarray
    point: np.ndarray


class Kinematics:
    """Positions and velocities of the bodies of a tree in a configuration q."""

    def __init__(self, tree: Tree, configuration: np.ndarray):
        self.tree = tree
        self.configuration = configuration
        self.columns, self.rotations, self.origins = tree.placed(configuration)

    def frame(self, anchor: Anchor) -> tuple[np.ndarray, np.ndarray]:
        """Directions (3, 3) and origin (3,) of a frame as seen from the ground."""
        rotation = self.rotations[anchor.joint]
        return rotation @ anchor.rotation, self.origins[anchor.joint] + rotation @ anchor.point

    def velocity(self, joint: int) -> np.ndarray:
        """The columns of S that move a joint's body, zero for the others, shape (6, nv)."""
        return self.columns * self.tree.moving[joint]

    def of_point(self, joint: int, point: np.ndarray) -> np.ndarray:
        """Velocity of the body's point that is at a place in space, by rate of each coordinate, shape (3, nv)."""
        columns = self.velocity(joint)
        return columns[:3] + np.cross(columns[3:], point, axis=0)

    def turning(self, joint: int, wrench: np.ndarray) -> np.ndarray:
        """d(S_j^T W) / dq for a wrench W (force; torque about the origin) that stays, shape (nv, nv): -s_i . (s_k x* W)."""
        columns = self.velocity(joint)
        force, torque = np.cross(columns[3:], wrench[:3], axis=0), np.cross(columns[:3], wrench[:3], axis=0)
        torque += np.cross(columns[3:], wrench[3:], axis=0)
        return -(columns[:3].T @ force + columns[3:].T @ torque) * self.tree.carried
