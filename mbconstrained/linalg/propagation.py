"""e^{S t} v at even times by powers of e^{S h}, with no decomposition: the cheapest way to see all of one motion once.

e^{S h} is a Taylor polynomial of S h 2^-j (Paterson and Stockmeyer 1973), squared j times (Moler and Van Loan 2003, method 3),
S balanced before. What is squared is E = e^X - I, by 2 E + E E: slow motions beside fast ones are small in it and keep digits
that e^X would round away, each squaring twice as many. Its power for w steps takes w states at once w steps further. Entries that
are nothing beside others of their row and column are set to zero after every product: they would be denormal numbers soon, which
processors handle slowly, and where S couples neighbours only, all products stay those of band matrices (``linalg.bands``).
"""

from __future__ import annotations

from math import ceil, log2

import numpy as np
import scipy.linalg

from ..tolerances import EPS
from .bands import ROWS, banded_product, bandwidth, multiply_in_place, narrow_order
from .kinds import Matrix, full

#: e^X by its Taylor polynomial of this degree, as a polynomial of degree 8 in X^2, is exact to rounding for |X| <= LARGEST. In X^4 it
#: would take two products less, and two matrices more.
DEGREE, ROOT, LARGEST = 16, 2, 0.78

#: A product of a matrix with fewer columns than these takes as long: it waits for memory.
WIDTH = 25

#: So many states are taken to values at once, or a part of their own number.
CHUNK, PART = 512, 4

#: Below this size a product of full matrices is faster than finding out where they are zero.
SMALL = 400

#: Entries of e^{S t} below this part of the largest of their row and of their column count as zero: all of them together do not
#: make a rounding of anything, be it apart from motions that grow. Nor do products of numbers below LEAST, which would be denormal.
NOTHING, LEAST = EPS * 1e-6, np.finfo(float).tiny ** 0.5


class Propagator:
    """e^{S k h} v for k = 0, 1, 2, ...

    Args:
        generator: S, shape (n, n), in 1/s, dense or sparse.
        step: h, in s.
    """

    def __init__(self, generator: Matrix, step: float):
        self.step = step
        self.first = _exponential(self._scaled(generator))
        self._jumps: tuple[int, np.ndarray, int] | None = None

    @property
    def matrix(self) -> np.ndarray:
        """e^{S h}, shape (n, n)."""
        found = np.empty_like(self.first[0])
        found[np.ix_(self.order, self.order)] = self.units[:, None] * self.first[0] / self.units
        return found

    def _scaled(self, generator: Matrix) -> np.ndarray:
        """S h in the order and units of this class, which it sets."""
        balanced, (units, _) = scipy.linalg.matrix_balance(full(generator), permute=False, separate=True)
        self.order = narrow_order(balanced) if len(balanced) >= SMALL else np.arange(len(balanced))
        self.units = units[self.order]
        balanced = balanced[np.ix_(self.order, self.order)]
        balanced *= self.step
        return balanced

    def jump(self, doublings: int) -> tuple[np.ndarray, int]:
        """e^{S h 2^doublings}, rows and columns in the order and units of this class, and its bandwidth; the last is kept."""
        if doublings == 0:
            return self.first
        if self._jumps is None or self._jumps[0] != doublings:
            matrix, band = self.first
            for _ in range(doublings):
                matrix, band = _cleaned(banded_product(matrix, matrix, band, band))
            self._jumps = doublings, matrix, band
        return self._jumps[1:]

    def values(self, output, start: np.ndarray, count: int) -> np.ndarray:
        """output @ e^{S k h} start for k = 0 ... count - 1.

        Args:
            output: shape (r, n), dense or sparse.
            start: v, shape (n,) -> (r, count), or (n, m), as many starts at once -> (r, count, m).
        """
        states = (start.reshape(len(self.units), -1)[self.order].T / self.units).T
        starts, rows = states.shape[1], output[:, self.order] * self.units
        doublings, (matrix, band) = best_doublings(len(self.units), count, starts), self.first
        together = [states]
        for _ in range(min(2**doublings, count) - 1):
            together.append(banded_product(matrix, together[-1], band))
        states = np.hstack(together)
        matrix, band = self.jump(doublings)
        width, done, found = states.shape[1], 0, np.empty((output.shape[0], count * starts))
        block = np.empty((len(states), width * max(1, min(CHUNK, len(states) // PART, count * starts) // width)))
        while done < found.shape[1]:
            for at in range(0, block.shape[1], width):
                block[:, at : at + width] = states
                states = banded_product(matrix, states, band)
            here = found[:, done : done + block.shape[1]]
            here[...] = (rows @ block)[:, : here.shape[1]]
            done += here.shape[1]
        return found.reshape(output.shape[0], count, -1) if start.ndim > 1 else found


def best_doublings(size: int, count: int, starts: int = 1) -> int:
    """How often to square e^{S h} before states are taken on by it, many at once, so that the work is least.

    >>> best_doublings(200, 1000), best_doublings(2000, 1000), best_doublings(2000, 1)
    (5, 3, 0)
    """
    return min(range(1 + ceil(log2(max(count, 1)))), key=lambda doublings: use_cost(size, count, doublings, starts))


def use_cost(size: int, count: int, doublings: int, starts: int = 1) -> float:
    """Of count states, in products of matrices of this size, e^{S h} being known."""
    width = starts * 2**doublings
    return doublings + count * starts / width * max(width, WIDTH) / max(size, 1)


def _exponential(X: np.ndarray) -> tuple[np.ndarray, int]:
    """e^X and its bandwidth; X is overwritten, and no more than three matrices are there at a time."""
    size = min(np.linalg.norm(X, order) for order in (1, np.inf)) if len(X) else 0.0
    halvings = max(0, ceil(log2(size / LARGEST))) if size > 0 else 0
    X /= 2.0**halvings
    change, band = _cleaned(_change(X))
    del X
    for _ in range(halvings):
        square = banded_product(change, change, band, band)
        square += change
        square += change
        change, band = _cleaned(square)
        del square
    change[np.diag_indices(len(change))] += 1.0
    return change, band


def _change(X: np.ndarray) -> np.ndarray:
    """e^X - I for |X| <= LARGEST."""
    band = _band(X)
    square = banded_product(X, X, band, band)
    factors = np.cumprod([1.0, *(1 / np.arange(1.0, DEGREE + 1))])
    total, reached = factors[DEGREE] * square, ROOT * band
    for j in range(DEGREE // ROOT - 1, -1, -1):
        _add_multiple(total, X, factors[ROOT * j + 1])
        if j:
            total[np.diag_indices(len(X))] += factors[ROOT * j]
            multiply_in_place(square, total, ROOT * band, reached)
            reached += ROOT * band
    return total


def _add_multiple(total, matrix, factor) -> None:
    for begin in range(0, len(total), ROWS):
        total[begin : begin + ROWS] += factor * matrix[begin : begin + ROWS]


def _cleaned(matrix: np.ndarray) -> tuple[np.ndarray, int]:
    """Without entries that are nothing beside others of their row and column, and its bandwidth; a small one is taken as full."""
    rows, columns = (np.maximum(matrix.max(axis=axis, initial=0.0), -matrix.min(axis=axis, initial=0.0)) for axis in (1, 0))
    rows, columns = np.maximum(NOTHING * rows, LEAST), np.maximum(NOTHING * columns, LEAST)
    for begin in range(0, len(matrix), ROWS):
        part = matrix[begin : begin + ROWS]
        size = np.abs(part)
        part *= (size >= rows[begin : begin + ROWS, None]) | (size >= columns)
    return matrix, _band(matrix)


def _band(matrix: np.ndarray) -> int:
    return bandwidth(matrix) if len(matrix) >= SMALL else len(matrix)
