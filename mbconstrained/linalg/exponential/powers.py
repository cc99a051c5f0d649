"""Values at even times by powers of e^{S h}, without decomposition: the cheapest method for one motion, free or under a record.

e^{S h} is SciPy's (Al-Mohy and Higham 2009), S balanced before. Its power for w steps takes w states at once w steps further.

Under a record z_(j+1) = E z_j + D v_j and L steps are taken at once: P z_(gL + i) = P E^i z_(gL) + P E^(i-1) D v_(gL) + ...
+ P D v_(gL + i - 1), the same matrix for every group of steps, so one product of matrices gives all of them; from one group to the
next by E^L. Only rows of z that P uses are computed.
"""

from __future__ import annotations

from math import ceil, log2

import numpy as np
import scipy.linalg
from scipy.sparse import csr_array

from ...ground.tolerances import EXPONENTIAL_PRODUCTS, NARROW_PRODUCT, NEGLIGIBLE_EXPONENTIAL, PADE_NORM
from ..arrays import Matrix, entries, entry_count, filled_columns, full, of_like_kind

#: Number of states evaluated at once, in parts of their own number.
CHUNK = 512

#: Number of values of a record computed at once.
TOGETHER = 200_000

#: An entry of a sparse matrix in a product takes so many times as long as one of a full matrix.
SPARSE = 8


class Propagator:
    """e^{S k h} v for k = 0, 1, 2, ...

    Args:
        generator: S, shape (n, n), in 1/s, dense or sparse.
        step: h, in s.
    """

    def __init__(self, generator: Matrix, step: float):
        balanced, (self._units, _) = scipy.linalg.matrix_balance(full(generator), permute=False, separate=True)
        balanced *= step
        self._has_tiny_entries = _smallest(balanced) < NEGLIGIBLE_EXPONENTIAL ** (2 / 3)
        self._step_matrix = self._without_remote(scipy.linalg.expm(balanced))

    @property
    def matrix(self) -> np.ndarray:
        """e^{S h}, shape (n, n)."""
        return self._units[:, None] * self._step_matrix / self._units

    def values(self, output: Matrix, start: np.ndarray, count: int) -> np.ndarray:
        """output @ e^{S k h} start for k = 0 ... count - 1.

        Args:
            output: shape (r, n), dense or sparse.
            start: v, shape (n,), or (n, m), as many starts at once.
            count: number of times.

        Returns:
            Shape (r, count), or (r, count, m).
        """
        states, rows, matrix = (
            (start.reshape(len(start), -1).T / self._units).T,
            of_like_kind(output * self._units, output),
            self._step_matrix,
        )
        starts, chosen = states.shape[1], _single_entries(rows)
        for _ in range(best_doublings(len(states), count, starts)):
            states, matrix = np.hstack([states, matrix @ states]), self._without_remote(matrix @ matrix)
        width, values = states.shape[1], np.empty((output.shape[0], count * starts))
        if chosen is not None:
            columns, factors = chosen
            for begin in range(0, values.shape[1], width):
                part = values[:, begin : begin + width]
                np.multiply(states[columns, : part.shape[1]], factors, out=part)
                states = matrix @ states
            return values.reshape(-1, count, starts) if start.ndim > 1 else values
        block = np.empty((len(states), width * max(1, min(CHUNK, count * starts) // width)))
        for begin in range(0, values.shape[1], block.shape[1]):
            for at in range(0, block.shape[1], width):
                block[:, at : at + width] = states
                states = matrix @ states
            part = values[:, begin : begin + block.shape[1]]
            part[...] = (rows @ block)[:, : part.shape[1]]
        return values.reshape(-1, count, starts) if start.ndim > 1 else values

    def _without_remote(self, matrix: np.ndarray) -> np.ndarray:
        """e^{S h} or a power of it without entries whose products are denormal numbers, which make products five times slower.

        Only long chains of couplings have such entries where no entry of S h is of their kind. What they add to a higher power comes by
        shorter steps too, and by them less than 2^-50 of it. The diagonal is kept.
        """
        if self._has_tiny_entries:
            return matrix
        size = np.abs(matrix)
        remote = size < NEGLIGIBLE_EXPONENTIAL * size.max(initial=0.0)
        remote.reshape(-1)[:: len(matrix) + 1] = False
        matrix[remote] = 0.0
        return matrix


def _smallest(matrix: np.ndarray) -> float:
    """Modulus of the smallest nonzero entry; the largest number without any."""
    size = np.abs(matrix)
    return float(size.min(where=size > 0, initial=np.inf))


def _single_entries(output: Matrix) -> tuple[np.ndarray, np.ndarray] | None:
    """The column and the value of the only entry of each row, shapes (r,) and (r, 1); None where a row has more or none."""
    row, column, value = entries(output)
    if not np.array_equal(row, np.arange(output.shape[0])):
        return None
    return column, value[:, None]


def best_doublings(size: int, count: int, starts: int = 1) -> int:
    """The number of squarings of e^{S h} before its application to many states at once, for least work.

    >>> best_doublings(200, 1000), best_doublings(2000, 1000), best_doublings(2000, 1)
    (4, 1, 0)
    """
    most = ceil(log2(max(count, 1)))
    return min(range(1 + most), key=lambda doublings: _cost_of_use(size, count, doublings, starts))


def _cost_of_use(size: int, count: int, doublings: int, starts: int) -> float:
    width = starts * 2**doublings
    return doublings + count * starts / width * (width + NARROW_PRODUCT) / max(size, 1)


def cost_of_exponential(turned: float) -> float:
    """Cost of e^{S h}, |S| h = turned, in products of matrices of its size."""
    return EXPONENTIAL_PRODUCTS + max(0, ceil(log2(max(turned, PADE_NORM) / PADE_NORM)))


def cost_of_powers(size: int, count: int, turned: float) -> float:
    """Cost of values at this number of even times by powers of e^{S h}."""
    return cost_of_exponential(turned) + _cost_of_use(size, count, best_doublings(size, count), 1)


def values_of_steps(
    output: Matrix, step: np.ndarray, input_matrix: np.ndarray, start: np.ndarray, inputs: np.ndarray
) -> np.ndarray:
    """P z_0, ..., P z_K, shape (r, K + 1).

    >>> half, one = np.array([[0.5]]), np.ones((1, 1))
    >>> values_of_steps(one, half, one, np.array([8.0]), np.ones((1, 2))).tolist()
    [[8.0, 5.0, 3.5]]
    """
    used = np.flatnonzero(filled_columns(output))
    if SPARSE * entry_count(output) >= (output.shape[0] - len(used)) * len(start):
        return _values(full(output), step, input_matrix, start, inputs)
    return csr_array(output[:, used]) @ _values(np.eye(len(start))[used], step, input_matrix, start, inputs)


def best_length(rows: int, states: int, driven: int, count: int) -> int:
    """Number of simultaneous steps, a power of two: many require products of matrices beforehand, few leave many groups.

    >>> best_length(100, 200, 2, 10_000), best_length(8, 200, 2, 10_000)
    (16, 64)
    """
    length = (NARROW_PRODUCT * states**2 * count / (rows * (states**2 + driven * count))) ** 0.5
    return 1 << max(0, round(np.log2(max(length, 1.0))))


def cost_of_steps(rows: int, states: int, driven: int, count: int) -> float:
    """Cost of all except the values themselves, in products of two matrices (n, n)."""
    length = best_length(rows, states, driven, count)
    alone = NARROW_PRODUCT * states**2 * count / length
    return (rows * length * (states**2 + driven * count) + alone) / states**3 + np.log2(length)


def _values(rows, step, input_matrix, start, inputs) -> np.ndarray:
    (m, count), r = inputs.shape, len(rows)
    length = best_length(r, len(start), m, count)
    outputs, gained, across = _powers(rows, step, input_matrix, length)
    groups = count // length + 1
    given = np.zeros((groups * length, m))
    given[:count] = inputs.T
    given = given.reshape(groups, length * m)
    begins = _begins(across, start, given @ gained.T)
    table = _table(outputs, input_matrix)
    result = np.empty((r, groups, length))
    width = max(1, TOGETHER // (r * length))
    for begin in range(0, groups, width):
        at = slice(begin, begin + width)
        part = np.hstack([begins[at], given[at]]) @ table
        result[:, at] = part.reshape(-1, r, length).transpose(1, 0, 2)
    return result.reshape(r, -1)[:, : count + 1]


def _powers(rows, step, input_matrix, length) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """P E^i for i < L, shape (L, r, n); (E^(L-1) D, ..., D) side by side, shape (n, L m); E^L."""
    outputs, gained, across = rows[None], input_matrix, step
    while len(outputs) < length:
        outputs = np.concatenate([outputs, (outputs.reshape(-1, len(step)) @ across).reshape(outputs.shape)])
        gained = np.hstack([across @ gained, gained])
        across = across @ across
    return outputs, gained, across


def _begins(across, start, gained) -> np.ndarray:
    """The states with which groups begin, one below the other."""
    result = np.empty((len(gained), len(start)))
    now = start
    for begins, more in zip(result, gained):
        begins[:] = now
        now = across @ now
        now += more
    return result


def _table(outputs, input_matrix) -> np.ndarray:
    """Matrix from states and inputs of a group to its values, shape (n + L m, r L)."""
    (length, r, n), m = outputs.shape, input_matrix.shape[1]
    table, driven = np.zeros((n + length * m, r, length)), (outputs @ input_matrix).transpose(2, 1, 0)
    table[:n] = outputs.transpose(2, 1, 0)
    for at in range(length - 1):
        table[n + at * m : n + (at + 1) * m, :, at + 1 :] = driven[:, :, : length - 1 - at]
    return table.reshape(len(table), -1)
