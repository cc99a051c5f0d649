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
from .bands import banded_product, bandwidth, narrow_order

#: e^X by its Taylor polynomial of this degree, as a polynomial of degree 4 in X^4, is exact to rounding for |X| <= LARGEST.
DEGREE, ROOT, LARGEST = 16, 4, 0.78

#: A product of a matrix with fewer columns than these takes as long: it waits for memory.
WIDTH = 25

#: So many states are taken to values at once.
CHUNK = 512

#: Below this size a product of full matrices is faster than finding out where they are zero.
SMALL = 400

#: Entries of e^{S t} below this part of the largest of their row and of their column count as zero: all of them together do not
#: make a rounding of anything, be it apart from motions that grow. Nor do products of numbers below LEAST, which would be denormal.
NOTHING, LEAST = EPS * 1e-6, np.finfo(float).tiny ** 0.5


class Propagator:
    """e^{S k h} v for k = 0, 1, 2, ...

    Args:
        generator: S, shape (n, n), in 1/s.
        step: h, in s.
    """

    def __init__(self, generator: np.ndarray, step: float):
        balanced, (units, _) = scipy.linalg.matrix_balance(generator, permute=False, separate=True)
        self.order = narrow_order(balanced) if len(balanced) >= SMALL else np.arange(len(balanced))
        self.units = units[self.order]
        self.step = step
        self.first = _exponential(balanced[np.ix_(self.order, self.order)] * step)
        self._jumps: tuple[int, np.ndarray, int] | None = None

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
        found, done = np.empty((output.shape[0], count * starts)), 0
        doublings, (matrix, band) = best_doublings(len(self.units), count, starts), self.first
        together = [states]
        for _ in range(min(2**doublings, count) - 1):
            together.append(banded_product(matrix, together[-1], band))
        states = np.hstack(together)
        matrix, band = self.jump(doublings)
        while done < found.shape[1]:
            together = [states]
            while sum(part.shape[1] for part in together) < min(CHUNK, found.shape[1] - done):
                together.append(banded_product(matrix, together[-1], band))
            block = np.hstack(together)[:, : found.shape[1] - done]
            found[:, done : done + block.shape[1]] = rows @ block
            done += block.shape[1]
            if done < found.shape[1]:
                states = banded_product(matrix, together[-1], band)
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
    """e^X and its bandwidth."""
    size = min(np.abs(X).sum(axis=axis).max(initial=0.0) for axis in (0, 1))
    halvings = max(0, ceil(log2(size / LARGEST))) if size > 0 else 0
    X /= 2.0**halvings
    change, band = _change(X)
    for _ in range(halvings):
        square = banded_product(change, change, band, band)
        square += change
        square += change
        change, band = _cleaned(square)
    change[np.diag_indices(len(change))] += 1.0
    return change, band


def _change(X: np.ndarray) -> tuple[np.ndarray, int]:
    """e^X - I for |X| <= LARGEST, and its bandwidth."""
    band, powers = _band(X), [X]
    for k in range(1, ROOT):
        powers.append(banded_product(powers[-1], X, k * band, band))
    factors = np.cumprod([1.0, *(1 / np.arange(1.0, DEGREE + 1))])
    total, reached = factors[DEGREE] * powers[-1], ROOT * band
    for j in range(DEGREE // ROOT - 1, -1, -1):
        for i in range(1, ROOT):
            total += factors[ROOT * j + i] * powers[i - 1]
        if j:
            total[np.diag_indices(len(X))] += factors[ROOT * j]
            total, reached = banded_product(powers[-1], total, ROOT * band, reached), reached + ROOT * band
    return _cleaned(total)


def _cleaned(matrix: np.ndarray) -> tuple[np.ndarray, int]:
    """Without entries that are nothing beside others of their row and column, and its bandwidth; a small one is taken as full."""
    size = np.abs(matrix)
    kept = size >= np.maximum(NOTHING * size.max(axis=1, initial=0.0), LEAST)[:, None]
    kept |= size >= np.maximum(NOTHING * size.max(axis=0, initial=0.0), LEAST)
    np.multiply(matrix, kept, out=matrix)
    return matrix, _band(matrix)


def _band(matrix: np.ndarray) -> int:
    return bandwidth(matrix) if len(matrix) >= SMALL else len(matrix)
