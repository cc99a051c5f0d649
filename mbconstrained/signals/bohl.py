"""A Bohl function: a function of time f(t) = C e^{J t} v, that is a sum of t^k e^{a t} (cos w t, sin w t).

Where it starts, stops or changes later, it is piecewise: the state e^{J t} v is set anew at given times.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from ..checks import counted, evaluation_times, real_array, real_number, whole_number
from ..errors import InputError, Overflow
from ..linalg.blocks import CHUNK_ENTRIES, block_slices
from ..linalg.exponential import BlockGroups, block_states
from ..linalg.oscillations import AT_ONCE, MODERATE, Lasting, Oscillations, of_phasors, step_of_few_rows
from ..linalg.threads import short_work
from .chunks import Piece, in_chunks
from .merging import Part, merged
from .restarts import Restarts, as_slice
from .turning import Turning


@dataclass(frozen=True, repr=False)
class BohlFunction:
    """f(t) = C e^{J t} v for t >= 0, evaluated at any times, in any order, with no stepping.

    Attributes:
        coefficients: C, shape (r, n).
        blocks: the diagonal blocks of J, square arrays whose sizes add up to n.
        start: v, shape (n,); or ``Restarts``, states that start anew at later times too.

    >>> import numpy as np
    >>> decay = BohlFunction(np.array([[2.0]]), (np.array([[-1.0]]),), np.array([1.0]))
    >>> bool(np.isclose(decay(1.0)[0], 2 * np.exp(-1)))
    True
    """

    coefficients: np.ndarray
    blocks: tuple[np.ndarray, ...]
    start: np.ndarray | Restarts

    def __repr__(self) -> str:
        return f"{type(self).__name__}({counted(self.size, 'row')}, {counted(self.coefficients.shape[1], 'state')})"

    @property
    def size(self) -> int:
        """Number of rows r of f(t)."""
        return self.coefficients.shape[0]

    @property
    def state_count(self) -> int:
        """Number of states n."""
        return self.coefficients.shape[1]

    @property
    def summed_from(self) -> np.ndarray:
        """From which time on, in s, each row is evaluated as a sum of modes, which may cancel; shape (r,)."""
        return np.zeros(self.size)

    def __call__(self, times) -> np.ndarray:
        """f at a time (-> shape (r,)) or at times of shape (T,) (-> shape (r, T)); each t >= 0, t = 0 means 0+.

        Raises:
            InputError: negative or not finite times.
            Overflow: a value leaves the range of float64.
        """
        times = evaluation_times(times)
        with np.errstate(over="ignore", invalid="ignore"), short_work(self.state_count):  # reported below, with the time
            values = self._values(np.atleast_1d(times))
            finite = not values.size or math.isfinite(values.min()) and math.isfinite(values.max())
        if not finite:
            first = np.atleast_1d(times)[~np.isfinite(values).all(axis=0)].min()
            raise Overflow(f"the value at t = {first:g} s lies beyond the range of float64; ask for earlier times")
        return values if times.ndim else values[:, 0]

    def _values(self, times) -> np.ndarray:
        """C e^{J t} v, so many times at once that memory stays near that of the answer."""
        chunk = max(1, CHUNK_ENTRIES // max(self.size, self.state_count, 1))
        if len(times) <= chunk:
            return self._chunk(times)
        values = np.empty((self.size, len(times)))
        for begin in range(0, len(times), chunk):
            values[:, begin : begin + chunk] = self._chunk(times[begin : begin + chunk])
        return values

    def _chunk(self, times) -> np.ndarray:
        if isinstance(self.start, Restarts):
            piece, since = self.start.located(times)
            if len(times) and not since.any():
                return self._at_knots(piece)
            coefficients, size = self._prepared
            return coefficients @ block_states(self._groups, self.start.states[:, piece] * size[:, None], since)
        turning = self._turning
        if turning is None or turning.growth.max() * times.max(initial=0.0) >= MODERATE:
            coefficients, size = self._prepared
            return coefficients @ block_states(self._groups, self.start * size, times)
        step = step_of_few_rows(self.size, len(turning.first), times)
        if step is not None:
            phasors, lines, others = self._phasors
            values = of_phasors(phasors, turning.rates, times, step)
        else:
            folded, oscillations, lines, others = self._folded
            values = oscillations.combined(folded, times, self._lasting if oscillations.are_many(times) else None)
        width = max(1, AT_ONCE // max(self.size, others.state_count, 1))  # no second array of this size is made
        for begin in range(0, len(times) if lines is not None or others.blocks else 0, width):
            part = slice(begin, begin + width)
            if lines is not None:
                values[:, part] += lines[:, 1:] * times[part] + lines[:, :1]
            if others.blocks:
                values[:, part] += others._chunk(times[part])
        return values

    def _at_knots(self, piece) -> np.ndarray:
        """C v where the states start anew."""
        coefficients, states = self._used
        return coefficients @ states[:, as_slice(piece)]

    @cached_property
    def _used(self) -> tuple[np.ndarray, np.ndarray]:
        """C and the states without the last ones if they add nothing at the knots."""
        coefficients = self.coefficients
        used = np.flatnonzero(coefficients.any(axis=0) & self.start.states.any(axis=1))
        count = used[-1] + 1 if used.size else 0
        return coefficients[:, :count], self.start.states[:count]

    @cached_property
    def _groups(self) -> BlockGroups:
        return BlockGroups.of(self.blocks)

    @cached_property
    def _prepared(self) -> tuple[np.ndarray, np.ndarray]:
        """C and its size, which is taken into v block by block, as a tiny one may outweigh a huge state."""
        coefficients, each = self.coefficients, [len(block) for block in self.blocks]
        size = np.abs(coefficients).max(axis=0, initial=0.0)
        if len(size) and len(coefficients):
            size = np.repeat(np.maximum.reduceat(size, np.cumsum([0, *each[:-1]])), each)
        size = np.where(size > 0, size, 1.0)
        return coefficients / size, size

    @cached_property
    def _turning(self) -> Turning | None:
        return Turning.of(self.blocks, self._groups, self.start)

    @cached_property
    def _folded(self) -> tuple[np.ndarray, Oscillations, np.ndarray | None, BohlFunction]:
        """C e^{J t} v as D (cosines, sines), which of them there are, a and b of a + b t, and the rest of C and J."""
        coefficients = self.coefficients
        return *self._turning.of_rows(coefficients), *self._without_turning(coefficients)

    @cached_property
    def _phasors(self) -> tuple[np.ndarray, np.ndarray | None, BohlFunction]:
        """The same of few rows: phasors of the oscillations."""
        coefficients = self.coefficients
        return self._turning.phasors(coefficients), *self._without_turning(coefficients)

    def _without_turning(self, coefficients) -> tuple[np.ndarray | None, BohlFunction]:
        """a and b of a + b t, and C and J of what neither oscillates nor drifts."""
        turning = self._turning
        lines = coefficients[:, turning.drifting] @ turning.lines if len(turning.drifting) else None
        return lines, BohlFunction(coefficients[:, turning.others], turning.blocks, turning.start)

    @cached_property
    def _lasting(self) -> Lasting | None:
        """How long each of the functions that are folded is something."""
        folded, oscillations, *_ = self._folded
        return Lasting.of(oscillations, folded)

    @property
    def is_zero(self) -> bool:
        """Whether it is known to vanish everywhere."""
        return not (self.coefficients.any() and self.restarts.states.any())

    @cached_property
    def restarts(self) -> Restarts:
        """The start as ``Restarts``, where there is no later one with t = 0 alone."""
        if isinstance(self.start, Restarts):
            return self.start
        return Restarts(np.zeros(1), self.start[:, None], self.start[:, None])

    @property
    def start_at_zero(self) -> np.ndarray:
        """v at t = 0+, shape (n,)."""
        return self.restarts.states[:, 0]

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

    def rows(self, indices) -> BohlFunction:
        """Some of its rows, in this order: what only they need is all that is computed."""
        return BohlFunction(self.coefficients[np.asarray(indices, dtype=int)], self.blocks, self.start)

    def chunks(self, times, count: int | None = None) -> Iterator[Piece]:
        """f at many times as pairs (times, values), for answers larger than memory (``signals.chunks``)."""
        return in_chunks(self, times, count)

    def delayed(self, delay: float) -> BohlFunction:
        """The function f(t - delay), zero for t < delay; delay >= 0 in s.

        >>> import numpy as np
        >>> BohlFunction(np.eye(1), (np.zeros((1, 1)),), np.ones(1)).delayed(2.0)([1.0, 2.0])
        array([[0., 1.]])
        """
        delay = real_number(delay, "delay", minimum=0.0)
        return self if delay == 0 else BohlFunction(self.coefficients, self.blocks, self.restarts.delayed(delay))

    def with_knots(self, knots: np.ndarray) -> BohlFunction:
        """The same function, its states kept at these times too."""
        if isinstance(self.start, Restarts) or len(knots) > 1:
            knots = np.union1d(self.restarts.knots, knots)
            return BohlFunction(self.coefficients, self.blocks, self.restarts.on(self.blocks, knots))
        return self

    def __add__(self, other: BohlFunction) -> BohlFunction:
        if not isinstance(other, BohlFunction):
            return NotImplemented
        if self.size != other.size:
            raise InputError(f"functions of different sizes cannot be added: {self.size} and {other.size} rows")
        one, two = self.with_knots(other.restarts.knots), other.with_knots(self.restarts.knots)
        return _of_parts(merged(one._parts() + two._parts()), self.size)

    def __mul__(self, factor: float) -> BohlFunction:
        return BohlFunction(self.coefficients * real_number(factor, "factor"), self.blocks, self.start)

    __rmul__ = __mul__

    def __neg__(self) -> BohlFunction:
        return self * -1.0

    def __sub__(self, other: BohlFunction) -> BohlFunction:
        return self + -other

    def _times_generator(self, coefficients):
        product = np.empty_like(coefficients)
        for block, at in zip(self.blocks, block_slices(self.blocks)):
            product[:, at] = coefficients[:, at] @ block
        return product

    def _parts(self) -> list[Part]:
        parts = []
        for block, at in zip(self.blocks, block_slices(self.blocks)):
            start = self.start.rows(at) if isinstance(self.start, Restarts) else self.start[at]
            parts.append(Part(block, start, self.coefficients[:, at]))
        return parts


def _of_parts(parts: list[Part], size: int) -> BohlFunction:
    if not parts:
        return BohlFunction(np.zeros((size, 0)), (), np.zeros(0))
    blocks, starts, coefficients = zip(*parts)
    return BohlFunction(np.hstack(coefficients), tuple(blocks), _together(starts))


def _together(starts) -> np.ndarray | Restarts:
    if not isinstance(starts[0], Restarts):
        return np.concatenate(starts)
    return Restarts(starts[0].knots, np.vstack([start.states for start in starts]), np.vstack([start.jumps for start in starts]))
