"""A Bohl function: a function of time f(t) = C e^{J t} v, that is a sum of t^k e^{a t} (cos w t, sin w t)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from ..checks import real_array, real_number, whole_number
from ..errors import InputError, Overflow
from ..linalg.exponential import block_states


@dataclass(frozen=True)
class BohlFunction:
    """f(t) = C e^{J t} v for t >= 0, evaluated at any times, in any order, with no stepping.

    Attributes:
        coefficients: C, shape (r, n).
        blocks: the diagonal blocks of J, square arrays whose sizes add up to n.
        start: v, shape (n,).

    >>> import numpy as np
    >>> decay = BohlFunction(np.array([[2.0]]), (np.array([[-1.0]]),), np.array([1.0]))
    >>> bool(np.isclose(decay(1.0)[0], 2 * np.exp(-1)))
    True
    """

    coefficients: np.ndarray
    blocks: tuple[np.ndarray, ...]
    start: np.ndarray

    @property
    def size(self) -> int:
        """Number of rows r of f(t)."""
        return self.coefficients.shape[0]

    def __call__(self, times) -> np.ndarray:
        """f at a time (-> shape (r,)) or at times of shape (T,) (-> shape (r, T)); each t >= 0, t = 0 means 0+.

        Raises:
            InputError: negative or not finite times.
            Overflow: a value leaves the range of float64.
        """
        times = real_array(times, "time")
        if times.ndim > 1:
            raise InputError(f"time: expected a number or a list of numbers, found an array of shape {times.shape}")
        if times.size and times.min() < 0:
            raise InputError(f"time: found {times.min():g} s; the function is defined for t >= 0 (0 means 0+)")
        with np.errstate(over="ignore", invalid="ignore"):  # reported below, with the time
            values = self._values(np.atleast_1d(times))
        finite = np.isfinite(values).all(axis=0)
        if not finite.all():
            first = np.atleast_1d(times)[~finite].min()
            raise Overflow(f"the value at t = {first:g} s lies beyond the range of float64; ask for earlier times")
        return values if times.ndim else values[:, 0]

    def _values(self, times) -> np.ndarray:
        """C e^{J t} v, the size of C taken into v block by block: a tiny coefficient may outweigh a huge state."""
        size = np.concatenate([np.ones(0), *(np.full(len(b), np.abs(c).max(initial=0.0)) for b, _, c in self._parts())])
        size = np.where(size > 0, size, 1.0)
        return (self.coefficients / size) @ block_states(self.blocks, self.start * size, times)

    @property
    def generator(self) -> np.ndarray:
        """J as one array of shape (n, n)."""
        return block_diag(*self.blocks) if self.blocks else np.zeros((0, 0))

    def derivative(self, order: int = 1) -> BohlFunction:
        """The classical derivative C J^order e^{J t} v."""
        coefficients = self.coefficients
        for _ in range(whole_number(order, "order")):
            coefficients = self._times_generator(coefficients)
        return BohlFunction(coefficients, self.blocks, self.start)

    def mapped(self, matrix) -> BohlFunction:
        """The function matrix @ f(t), matrix of shape (p, r)."""
        matrix = real_array(matrix, "matrix", shape=(None, self.size))
        return BohlFunction(matrix @ self.coefficients, self.blocks, self.start)

    def __add__(self, other: BohlFunction) -> BohlFunction:
        if not isinstance(other, BohlFunction):
            return NotImplemented
        if self.size != other.size:
            raise InputError(f"functions of different sizes cannot be added: {self.size} and {other.size} rows")
        return _merged(self._parts() + other._parts(), self.size)

    def __mul__(self, factor: float) -> BohlFunction:
        return BohlFunction(self.coefficients * real_number(factor, "factor"), self.blocks, self.start)

    __rmul__ = __mul__

    def __neg__(self) -> BohlFunction:
        return self * -1.0

    def __sub__(self, other: BohlFunction) -> BohlFunction:
        return self + -other

    def _times_generator(self, coefficients):
        product = np.empty_like(coefficients)
        begin = 0
        for block in self.blocks:
            end = begin + len(block)
            product[:, begin:end] = coefficients[:, begin:end] @ block
            begin = end
        return product

    def _parts(self):
        parts, begin = [], 0
        for block in self.blocks:
            end = begin + len(block)
            parts.append((block, self.start[begin:end], self.coefficients[:, begin:end]))
            begin = end
        return parts


def _merged(parts, size) -> BohlFunction:
    """Concatenate parts; a part whose generator is the tail of another's shares that one's states."""
    kept: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    for part in sorted(parts, key=lambda part: -len(part[0])):
        for place, (block, start, coefficients) in enumerate(kept):
            if _is_tail(part, block, start):
                total = coefficients.copy()
                total[:, len(block) - len(part[0]) :] += part[2]
                kept[place] = (block, start, total)
                break
        else:
            kept.append(part)
    if not kept:
        return BohlFunction(np.zeros((size, 0)), (), np.zeros(0))
    blocks, starts, coefficients = zip(*kept)
    return BohlFunction(np.hstack(coefficients), tuple(blocks), np.concatenate(starts))


def _is_tail(part, block, start) -> bool:
    generator, own_start, _ = part
    skip = len(block) - len(generator)
    return bool(
        np.array_equal(block[skip:, skip:], generator)
        and not block[skip:, :skip].any()
        and np.array_equal(start[skip:], own_start)
    )
