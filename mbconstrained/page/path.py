"""A path: where a body is and how it is turned at the times of the animation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..checks import real_array
from ..errors import InputError


@dataclass(frozen=True, eq=False)
class Path:
    """Places and orientations of a body's frame, in the axes of the drawing.

    The page interpolates both by cubic polynomials between the times, and brings the quaternions back to unit length.

    Attributes:
        positions: shape (3, T) in drawing units (m for a robot), or (3, 1) for a body that rests.
        quaternions: shape (4, T), x y z w, of any length but zero; they are normalized, and their signs are chosen so
            that neighbours are near each other (q and -q are the same orientation).

    Raises:
        InputError: shapes that do not match, NaN, infinity or a quaternion that is zero.

    >>> Path([[0, 1], [0, 0], [0, 0]], [[0, 0], [0, 0], [0, 0], [1, -2]]).quaternions[3]
    array([1., 1.])
    """

    positions: np.ndarray
    quaternions: np.ndarray

    def __post_init__(self):
        positions = real_array(self.positions, "path, positions", shape=(3, None))
        if positions.shape[1] == 0:
            raise InputError("path, positions: no places found; give at least one")
        quaternions = real_array(self.quaternions, "path, quaternions", shape=(4, positions.shape[1]))
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "quaternions", _continuous(_normalized(quaternions)))

    @property
    def count(self) -> int:
        """How many poses it has."""
        return self.positions.shape[1]

    @property
    def moves(self) -> bool:
        """Whether any pose differs from the first."""
        both = np.vstack([self.positions, self.quaternions])
        return bool((both != both[:, :1]).any())

    def thinned(self, kept) -> Path:
        """Only the poses with these numbers; one pose where it does not move."""
        chosen = np.asarray(kept) if self.moves else [0]
        return Path(self.positions[:, chosen], self.quaternions[:, chosen])


def _normalized(quaternions: np.ndarray) -> np.ndarray:
    largest = np.abs(quaternions).max(axis=0)
    if (largest == 0).any():
        where = int(np.argmax(largest == 0))
        raise InputError(f"path, quaternions: column {where + 1} is zero; give x, y, z, w of an orientation")
    quaternions = quaternions / largest  # so that no square over- or underflows
    lengths = np.linalg.norm(quaternions, axis=0)
    return quaternions / lengths


def _continuous(quaternions: np.ndarray) -> np.ndarray:
    """Of each pair q, -q the one nearer to the one before; the first stays as it is."""
    turned = (quaternions[:, 1:] * quaternions[:, :-1]).sum(axis=0) < 0
    signs = np.concatenate([[1.0], np.cumprod(np.where(turned, -1.0, 1.0))])
    return quaternions * signs
