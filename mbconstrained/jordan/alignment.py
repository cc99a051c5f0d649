"""Complex pairs in the basis in which a force enters at one of the two states.

A pair [[a, w], [-w, a]] is the same in every rotated basis, but not what is made of its rounded entries: of a mode that is
at rest before a blow, C B = 0, the displacement does not jump. In the basis in which B has one row only, so has C one
column, the other one, and C B = 0 holds exactly; in any other it is the difference of products, and beside a force much
faster than the mode its rounding error would be all that is left.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import block_diag

from ..linalg.precise import magnitude, precise


def aligning_rotation(T: np.ndarray, B: np.ndarray) -> np.ndarray:
    """The precise orthogonal matrix G, block diagonal as T is, for which the first row of G B is least for every pair.

    Args:
        T: shape (n, n), complex pairs as [[a, w], [-w, a]] where they have a block of their own.
        B: precise, shape (n, r).
    """
    blocks, at = [], 0
    while at < len(T):
        pair = at + 1 < len(T) and T[at + 1, at] != 0 and T[at + 1, at] == -T[at, at + 1] and T[at, at] == T[at + 1, at + 1]
        blocks.append(_rotation(B[at : at + 2]) if pair else np.eye(1))
        at += len(blocks[-1])
    return precise(np.array(block_diag(*blocks), dtype=object)) if blocks else precise(np.zeros((0, 0)))


def _rotation(B) -> np.ndarray:
    """The rotation by the direction of the column of B (2, r) that is largest."""
    column = B[:, magnitude(B).max(axis=0).argmax()] if B.size else precise(np.array([0.0, 1.0]))
    length = (column[0] * column[0] + column[1] * column[1]).sqrt()
    if not length:
        return precise(np.eye(2))
    sine, cosine = column / length
    return np.array([[cosine, -sine], [sine, cosine]])
