"""Rotations: as rotation vectors (axis times angle, rad), as unit quaternions x y z w, and as matrices."""

from __future__ import annotations

import numpy as np


def quaternions_of(turns: np.ndarray) -> np.ndarray:
    """Quaternions (4, T) of rotation vectors (3, T) in rad.

    >>> quaternions_of(np.array([[0.0], [0.0], [np.pi]])).round(12).T
    array([[0., 0., 1., 0.]])
    """
    angles = np.linalg.norm(turns, axis=0)
    return np.vstack([turns * (np.sinc(angles / (2 * np.pi)) / 2), np.cos(angles / 2)])


def rotated(quaternions: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (3, k) turned by unit quaternions (4, T), shape (3, k, T): p + 2 w (u x p) + 2 u x (u x p)."""
    u, w = quaternions[:3, None, :], quaternions[3]
    p = points[:, :, None] + np.zeros((1, 1, quaternions.shape[1]))
    across = 2 * np.cross(u + np.zeros_like(p), p, axis=0)
    return p + w * across + np.cross(u + np.zeros_like(p), across, axis=0)


def after(second: np.ndarray, first: np.ndarray) -> np.ndarray:
    """The quaternions (4, T) of one rotation after another, the product second first."""
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
