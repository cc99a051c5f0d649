"""Paths, the poses of a body at the times of the animation, and rotations.

A rotation is a rotation vector (axis times angle, rad), a unit quaternion x y z w, or a matrix. The few formulas are written
here because importing ``scipy.spatial.transform`` takes 0.4 s, many times as long as a whole page.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Path:
    """Positions and orientations of a body's frame, in the axes of the drawing.

    The page interpolates both by cubic polynomials between the times, and brings the quaternions back to unit length.

    >>> Path([[0, 1], [0, 0], [0, 0]], [[0, 0], [0, 0], [0, 0], [1, -1]]).quaternions[3]
    array([1., 1.])
    """

    positions: np.ndarray  # shape (3, T) in drawing units (m for a robot), or (3, 1) for a body that rests
    # shape (4, T), x y z w, of unit length; their signs are chosen so that neighbours are near each other (q and -q are the same
    # orientation)
    quaternions: np.ndarray

    def __post_init__(self):
        quaternions = np.asarray(self.quaternions, dtype=float)
        flipped = (quaternions[:, 1:] * quaternions[:, :-1]).sum(axis=0) < 0
        signs = np.cumprod([1.0, *np.where(flipped, -1.0, 1.0)])
        object.__setattr__(self, "positions", np.asarray(self.positions, dtype=float))
        object.__setattr__(self, "quaternions", quaternions * signs)

    @property
    def count(self) -> int:
        """Number of poses."""
        return self.positions.shape[1]

    @property
    def moves(self) -> bool:
        """Whether any pose differs from the first."""
        both = np.vstack([self.positions, self.quaternions])
        return bool((both != both[:, :1]).any())

    def thinned(self, kept) -> Path:
        """The poses with these indices; one pose where it does not move."""
        chosen = np.asarray(kept) if self.moves else [0]
        return Path(self.positions[:, chosen], self.quaternions[:, chosen])

    def of_points(self, points) -> np.ndarray:
        """Positions of points (3, k) that are fixed in the body's frame, shape (3, k, T)."""
        return self.positions[:, None] + rotated(self.quaternions, np.asarray(points, dtype=float))


def quaternions_of(turns: np.ndarray) -> np.ndarray:
    """Quaternions (4, T) of rotation vectors (3, T) in rad.

    >>> quaternions_of(np.array([[0.0], [0.0], [np.pi]])).round(12).T
    array([[0., 0., 1., 0.]])
    """
    angles = np.linalg.norm(turns, axis=0)
    return np.vstack([turns * (np.sinc(angles / (2 * np.pi)) / 2), np.cos(angles / 2)])


def rotated(quaternions: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Rotated points R p, with R = (w² - u·u) I + 2 u uᵀ + 2 w [u]×."""
    u, w = quaternions[:3], quaternions[3]
    x, y, z = u
    cross = np.array([[0 * w, -z, y], [z, 0 * w, -x], [-y, x, 0 * w]])
    matrices = np.eye(3)[:, :, None] * (w**2 - (u**2).sum(axis=0)) + 2 * u[:, None] * u + 2 * w * cross
    return np.einsum("ijt,jk->ikt", matrices, points)


def after(second: np.ndarray, first: np.ndarray) -> np.ndarray:
    """The product of quaternions: of one rotation after another."""
    (u, w), (v, s) = (second[:3], second[3]), (first[:3], first[3])
    return np.vstack([w * v + s * u + np.cross(u, v, axis=0), w * s - (u * v).sum(axis=0)])


def matrix_of(turn) -> np.ndarray:
    """The matrix (3, 3) of a rotation vector (3,)."""
    return rotated(quaternions_of(np.array(turn, dtype=float)[:, None]), np.eye(3))[:, :, 0]


def vector_of(matrix: np.ndarray) -> np.ndarray:
    """The rotation vector (3,) of a matrix; half a turn included.

    >>> vector_of(np.diag([-1.0, -1.0, 1.0])).round(12)
    array([0.        , 0.        , 3.14159265])
    """
    sine = np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]]) / 2
    cosine = (np.trace(matrix) - 1) / 2
    angle = np.arctan2(np.linalg.norm(sine), cosine)
    if cosine < -0.9:
        outer = (matrix + matrix.T) / 2 - cosine * np.eye(3)  # axis times axis, up to a factor
        column = outer[:, int(np.argmax(np.diag(outer)))]
        axis = column / np.linalg.norm(column) * (-1.0 if column @ sine < 0 else 1.0)
        return angle * axis
    return sine * (angle / np.linalg.norm(sine)) if angle else sine
