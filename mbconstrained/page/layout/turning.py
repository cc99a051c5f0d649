"""How a whole drawing is turned, so that its displacements go, and its angles turn, the way that is asked for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..drawing import Vector

#: The way of positive displacements in a layout, and the axis about which positive angles turn counter-clockwise.
ALONG, ABOUT = np.array([1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])


def turn_to(along: Sequence[float] | None, about: Sequence[float] | None) -> Vector:
    """The rotation vector (rad) that turns a layout to these two directions, which are at right angles.

    Args:
        along: of positive displacements; None: as it is, as far as that is at right angles to the other.
        about: of the axis about which positive angles turn counter-clockwise; None likewise.

    >>> turn_to([0, 0, 2], None)
    (0.0, -1.5707963267948966, 0.0)
    >>> turn_to(None, None)
    (0.0, 0.0, 0.0)
    """
    if along is None and about is None:
        return (0.0, 0.0, 0.0)
    first = _unit(along) if along is not None else _across(ALONG, _unit(about))
    second = _unit(about) if about is not None else _across(ABOUT, first)
    wanted = np.column_stack([first, -second, np.cross(first, -second)])
    return tuple((_rotation_vector(wanted) + 0.0).tolist())


def _unit(vector) -> np.ndarray:
    vector = np.array(vector, dtype=float)
    return vector / np.linalg.norm(vector)


def _across(usual: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """The direction at right angles to an axis that is nearest to the usual one; where that is the axis, another one."""
    for wanted in (usual, np.array([0.0, 0.0, 1.0])):
        part = wanted - (wanted @ axis) * axis
        if np.linalg.norm(part) > 1e-6:
            return _unit(part)
    raise AssertionError("two directions are never along one axis")


def _rotation_vector(matrix: np.ndarray) -> np.ndarray:
    """Axis times angle; half a turn included."""
    sine = np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]]) / 2
    cosine = (np.trace(matrix) - 1) / 2
    angle = np.arctan2(np.linalg.norm(sine), cosine)
    if cosine < -0.9:
        outer = (matrix + np.eye(3)) / 2  # axis times axis, but for small parts, which the sines mend
        column = outer[:, int(np.argmax(np.diag(outer)))]
        axis = _unit(column) * (-1.0 if column @ sine < 0 else 1.0)
        return angle * axis
    return sine * (angle / np.linalg.norm(sine)) if angle else sine
