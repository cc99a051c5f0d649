"""Products of matrices whose entries lie near the diagonal, and the order of rows that brings them there.

A model that is a chain or a tree has few couplings: in the order of Cuthill and McKee (1969) they are all near the diagonal,
and e^{S t} too is zero to rounding farther away than anything has travelled. Only the blocks that are not zero are multiplied.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

#: Rows that are multiplied at once.
ROWS = 96

#: A matrix with more than this part of its entries is not worth an order.
FILLED = 1 / 8

#: A product is made block by block where that takes less than this part of the multiplications.
NARROW = 0.7


def narrow_order(matrix: np.ndarray) -> np.ndarray:
    """An order of rows and columns in which the entries of a square matrix are near the diagonal, if they are few."""
    if np.count_nonzero(matrix) > FILLED * matrix.size:
        return np.arange(len(matrix))
    pattern = csr_array(matrix != 0)
    return np.asarray(reverse_cuthill_mckee(pattern + pattern.T, symmetric_mode=True))


def bandwidth(matrix: np.ndarray) -> int:
    """The largest distance of an entry that is not zero from the diagonal.

    >>> bandwidth(np.array([[1.0, 0.0, 2.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
    2
    """
    filled = matrix != 0
    rows = np.flatnonzero(filled.any(axis=1))
    if not rows.size:
        return 0
    filled = filled[rows]
    first, last = filled.argmax(axis=1), matrix.shape[1] - 1 - filled[:, ::-1].argmax(axis=1)
    return int(max((rows - first).max(), (last - rows).max(), 0))


def banded_product(left: np.ndarray, right: np.ndarray, left_band: int, right_band: int | None = None) -> np.ndarray:
    """left @ right, left square of this bandwidth; right too, or of any shape where its bandwidth is None."""
    n = len(left)
    inner, outer = (min(2 * band + ROWS, n) for band in (left_band, n if right_band is None else left_band + right_band))
    if inner * outer >= NARROW * n**2:
        return left @ right
    product = np.zeros((n, right.shape[1]))
    for begin in range(0, n, ROWS):
        end = min(begin + ROWS, n)
        inner = slice(max(begin - left_band, 0), min(end + left_band, n))
        outer = slice(None) if right_band is None else slice(max(inner.start - right_band, 0), min(inner.stop + right_band, n))
        product[begin:end, outer] = left[begin:end, inner] @ right[inner, outer]
    return product


def multiply_in_place(left: np.ndarray, right: np.ndarray, left_band: int, right_band: int) -> None:
    """right = left @ right, both square of these bandwidths, some columns after others: no third matrix is made.

    >>> matrix = np.array([[2.0, 0.0], [0.0, 3.0]])
    >>> multiply_in_place(np.array([[0.0, 1.0], [1.0, 0.0]]), matrix, 1, 0)
    >>> matrix.tolist()
    [[0.0, 3.0], [2.0, 0.0]]
    """
    n = len(left)
    for begin in range(0, n, ROWS):
        end = min(begin + ROWS, n)
        inner = slice(max(begin - right_band, 0), min(end + right_band, n))
        outer = slice(max(inner.start - left_band, 0), min(inner.stop + left_band, n))
        right[outer, begin:end] = left[outer, inner] @ right[inner, begin:end]
