"""P z_j for z_(j+1) = E z_j + D v_j and given v_j: a motion under a record by steps, with no decomposition.

L steps are taken at once: P z_(gL + i) = P E^i z_(gL) + P E^(i-1) D v_(gL) + ... + P D v_(gL + i - 1), the same matrix for every
group of steps, so one product of matrices makes all of them; from one group to the next by E^L. Only rows of z that P uses are made.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from .kinds import Matrix, entry_count, filled_columns, full

#: A product of a matrix and a vector takes so many times as long as its part of a product of matrices.
ALONE = 6.0

#: An entry of a sparse matrix in a product takes so many times as long as one of a full matrix.
SPARSE = 8

#: So many numbers of values are made at once.
TOGETHER = 200_000


def values_of_steps(output: Matrix, step: np.ndarray, drive: np.ndarray, start: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """P z_0, ..., P z_K, shape (r, K + 1).

    Args:
        output: P, shape (r, n).
        step: E, shape (n, n).
        drive: D, shape (n, m).
        start: z_0, shape (n,).
        inputs: v_0, ..., v_(K-1), shape (m, K).

    >>> half, one = np.array([[0.5]]), np.ones((1, 1))
    >>> values_of_steps(one, half, one, np.array([8.0]), np.ones((1, 2))).tolist()
    [[8.0, 5.0, 3.5]]
    """
    used = np.flatnonzero(filled_columns(output))
    if SPARSE * entry_count(output) >= (output.shape[0] - len(used)) * len(start):
        return _values(full(output), step, drive, start, inputs)
    return csr_array(output[:, used]) @ _values(np.eye(len(start))[used], step, drive, start, inputs)


def best_length(rows: int, states: int, driven: int, count: int) -> int:
    """How many steps to take at once, a power of two: many cost products of matrices beforehand, few leave many groups.

    >>> best_length(100, 200, 2, 10_000), best_length(8, 200, 2, 10_000)
    (16, 64)
    """
    length = (ALONE * states**2 * count / (rows * (states**2 + driven * count))) ** 0.5
    return 1 << max(0, round(np.log2(max(length, 1.0))))


def cost_of_steps(rows: int, states: int, driven: int, count: int) -> float:
    """Of all but the values themselves, in products of two matrices (n, n)."""
    length = best_length(rows, states, driven, count)
    alone = ALONE * states**2 * count / length
    return (rows * length * (states**2 + driven * count) + alone) / states**3 + np.log2(length)


def _values(rows, step, drive, start, inputs) -> np.ndarray:
    (m, count), r = inputs.shape, len(rows)
    length = best_length(r, len(start), m, count)
    seen, gained, across = _powers(rows, step, drive, length)
    groups = count // length + 1
    given = np.zeros((groups * length, m))
    given[:count] = inputs.T
    given = given.reshape(groups, length * m)
    begins = _begins(across, start, given @ gained.T)
    table = _table(seen, drive)
    found = np.empty((r, groups, length))
    width = max(1, TOGETHER // (r * length))
    for begin in range(0, groups, width):
        at = slice(begin, begin + width)
        part = np.hstack([begins[at], given[at]]) @ table
        found[:, at] = part.reshape(-1, r, length).transpose(1, 0, 2)
    return found.reshape(r, -1)[:, : count + 1]


def _powers(rows, step, drive, length) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """P E^i for i < L, shape (L, r, n); (E^(L-1) D, ..., D) side by side, shape (n, L m); E^L."""
    seen, gained, across = rows[None], drive, step
    while len(seen) < length:
        seen = np.concatenate([seen, (seen.reshape(-1, len(step)) @ across).reshape(seen.shape)])
        gained = np.hstack([across @ gained, gained])
        across = across @ across
    return seen, gained, across


def _begins(across, start, gained) -> np.ndarray:
    """The states with which groups begin, one below the other."""
    found = np.empty((len(gained), len(start)))
    now = start
    for begins, more in zip(found, gained):
        begins[:] = now
        now = across @ now
        now += more
    return found


def _table(seen, drive) -> np.ndarray:
    """What takes states and inputs of a group to its values, shape (n + L m, r L)."""
    (length, r, n), m = seen.shape, drive.shape[1]
    table, driven = np.zeros((n + length * m, r, length)), (seen @ drive).transpose(2, 1, 0)
    table[:n] = seen.transpose(2, 1, 0)
    for at in range(length - 1):
        table[n + at * m : n + (at + 1) * m, :, at + 1 :] = driven[:, :, : length - 1 - at]
    return table.reshape(len(table), -1)
