"""Bohl functions f(t) = C e^{J t} v: sums of t^k e^{a t} (cos w t, sin w t).

A function that starts, stops or changes later is piecewise: the state e^{J t} v restarts at given times.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np

from ..ground.by_name import Public
from ..ground.checks import counted, evaluation_times, real_array, real_number, whole_number
from ..ground.errors import InputError, Overflow, within_float64
from ..ground.threads import short_work
from ..ground.tolerances import EPS, MODERATE_EXPONENT
from ..linalg.blocks import CHUNK_ENTRIES, block_matrix, block_slices
from ..linalg.exponential import AT_ONCE, BlockGroups, Lasting, Oscillations, block_states, of_phasors, step_of_few_rows

# Restarts: states of a piecewise Bohl function at its knots, with one generator J for all pieces.


def consecutive(numbers: np.ndarray) -> slice | np.ndarray:
    """Consecutive whole numbers as a slice, which indexes without a copy; others unchanged."""
    follow = len(numbers) and numbers[-1] - numbers[0] == len(numbers) - 1 and (np.diff(numbers) == 1).all()
    return slice(int(numbers[0]), int(numbers[-1]) + 1) if follow else numbers


#: Gaps between knots that are this many times shorter than the spacing of float64 numbers there keep too few of their digits.
LOST_GAP = 2.0**-10


@dataclass(frozen=True, repr=False, eq=False)
class Restarts:
    """z(t) = e^{J (t - t_j)} z_j for t_j <= t < t_(j+1), and z = 0 before t = 0.

    The jumps are stored next to the states, since a difference of states has rounding errors, and whether a force jumps
    decides whether there is an impulse. The remainders are the rounding errors of the knots: a short pulse at a late time keeps
    the digits of its duration.
    """

    knots: np.ndarray  # t_j in s as float64 numbers, shape (K,), ascending, the first is 0
    states: np.ndarray  # z_j = z(t_j+), shape (n, K)
    jumps: np.ndarray  # z(t_j+) - z(t_j-), shape (n, K); exactly zero where nothing changes
    remainders: np.ndarray | float = 0.0  # t_j less the knots, shape (K,); 0.0 where there are none

    def __repr__(self) -> str:
        return f"Restarts({counted(len(self.states), 'state')}, set at {counted(len(self.knots), 'time')})"

    @property
    def moments(self) -> np.ndarray:
        """The knots as real, the remainders as imaginary parts: sorting and comparing take the remainders second."""
        return self.knots + 1j * self.remainders

    @cached_property
    def gaps(self) -> np.ndarray:
        """t_(j+1) - t_j, shape (K - 1,)."""
        return np.diff(self.knots) + np.diff(self.moments.imag)

    def located(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Index of the piece of each time (T,), and the time since its knot."""
        if len(self.knots) == 1:
            return np.zeros(len(times), dtype=int), times
        piece = self.knots.searchsorted(times, side="right") - 1
        since = times - self.knots[piece]
        if isinstance(self.remainders, np.ndarray):
            since = np.maximum(since - self.remainders[piece], 0.0)
        return piece, since

    def rows(self, at: slice) -> Restarts:
        """The restarts of some of the states."""
        return Restarts(self.knots, self.states[at], self.jumps[at], self.remainders)

    def delayed(self, delay: float) -> Restarts:
        """The restarts delayed by delay > 0, in s."""
        first = 0 if self.jumps[:, 0].any() else 1  # without the knot 0 of a function that is delayed already
        knots = self.knots[first:]
        later, nothing = later_times(knots, delay, self.gaps[first:]), np.zeros((len(self.states), 1))
        added = later - knots
        errors = (knots - (later - added)) + (delay - added)  # of the sum, exactly (Knuth's two-sum)
        errors += np.broadcast_to(self.remainders, self.knots.shape)[first:]
        rounded = later + errors
        moments = np.append(0.0, rounded + 1j * (errors - (rounded - later)))
        return restarts_at(moments, *(np.hstack([nothing, values[:, first:]]) for values in (self.states, self.jumps)))

    def on(self, blocks: Sequence[np.ndarray], moments: np.ndarray) -> Restarts:
        """The restarts of the same function at more knots."""
        own = self.moments
        if np.array_equal(moments, own):
            return self
        piece = np.searchsorted(own, moments, side="right") - 1
        since = moments - own[piece]
        with np.errstate(over="ignore", invalid="ignore"):  # reported when the function is evaluated
            states = block_states(blocks, self.states[:, piece], since.real + since.imag)
        jumps, places = np.zeros_like(states), np.searchsorted(moments, own)
        states[:, places], jumps[:, places] = self.states, self.jumps
        return restarts_at(moments, states, jumps)


def restarts_at(moments: np.ndarray, states: np.ndarray, jumps: np.ndarray) -> Restarts:
    """Restarts at distinct knots: of two knots rounded to the same number, the later one gets the next number, and a remainder."""
    knots, remainders = moments.real.copy(), moments.imag.copy()
    while (same := np.flatnonzero(np.diff(knots) <= 0) + 1).size:
        later = np.nextafter(knots[same - 1], np.inf)
        knots[same], remainders[same] = later, remainders[same] + (knots[same] - later)
    return Restarts(knots, states, jumps, remainders if remainders.any() else 0.0)


class FreeRestarts(Restarts):
    """Restarts given by their states alone, zero before t = 0; the jumps at the knots are computed when they are first read."""

    blocks: Sequence[np.ndarray]  # diagonal blocks of J

    def __init__(self, knots: np.ndarray, states: np.ndarray, remainders: np.ndarray | float, blocks: Sequence[np.ndarray]):
        self.__dict__.update(knots=knots, states=states, remainders=remainders, blocks=blocks)

    @cached_property
    def jumps(self) -> np.ndarray:
        """z(t_j+) - z(t_j-), shape (n, K)."""
        jumps = self.states.copy()
        with np.errstate(over="ignore", invalid="ignore"):  # reported when the function is evaluated
            jumps[:, 1:] -= block_states(self.blocks, self.states[:, :-1], self.gaps)
        return jumps


def later_times(times: np.ndarray, delay: float, gaps: np.ndarray | float = 0.0) -> np.ndarray:
    """Ascending times plus a delay."""
    with np.errstate(over="ignore"):
        later = times + delay
    if not np.isfinite(later).all():
        raise InputError(f"delay: {delay:g} s after {times.max():g} s is beyond the range of float64; give a shorter delay")
    if (joined := (np.diff(later) <= 0) & (gaps <= LOST_GAP * np.spacing(later[1:]))).any():
        at = int(np.argmax(joined))
        raise InputError(
            f"delay: {delay:g} s would bring the changes of the signal at {times[at]:.6g} s and {times[at + 1]:.6g} s to one and "
            "the same float64 time, and the load between them would be lost; give a shorter delay, or a later origin of time"
        )
    return later


@dataclass(frozen=True, repr=False, eq=False)
class BohlFunction(Public):
    """f(t) = C e^{J t} v for t >= 0, evaluated at any times in any order, without time steps.

    Attributes:
        coefficients: C, shape (r, n).
        blocks: the diagonal blocks of J, square arrays whose sizes add up to n.
        start: v, shape (n,); or ``Restarts``, where the states restart at later times.

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
        """The times in s from which each row is evaluated as a sum of modes, which may cancel, shape (r,)."""
        return np.zeros(self.size)

    def __call__(self, times) -> np.ndarray:
        """The values f(t).

        Args:
            times: one time, or times of shape (T,), in s, each at least 0; t = 0 means 0+, and a knot its right limit.

        Returns:
            Shape (r,) for one time, (r, T) for several.

        Raises:
            InputError: negative or not finite times.
            Overflow: a value leaves the range of float64.
        """
        times = evaluation_times(times)
        with within_float64(), short_work(self.state_count):  # what is not finite is reported below, with the time
            values = self._values(np.atleast_1d(times))
            finite = not values.size or (math.isfinite(values.min()) and math.isfinite(values.max()))
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
        oscillating = self._oscillating_part
        if oscillating is None or oscillating.growth.max() * times.max(initial=0.0) >= MODERATE_EXPONENT:
            coefficients, size = self._prepared
            return coefficients @ block_states(self._groups, self.start * size, times)
        step = step_of_few_rows(self.size, len(oscillating.first), times)
        if step is not None:
            phasors, lines, others = self._phasors
            values = of_phasors(phasors, oscillating.rates, times, step)
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
        """C v at knots, where the states restart."""
        coefficients, states = self._used
        return coefficients @ states[:, consecutive(piece)]

    @cached_property
    def _used(self) -> tuple[np.ndarray, np.ndarray]:
        """C and the states up to the last one that contributes at the knots."""
        coefficients = self.coefficients
        used = np.flatnonzero(coefficients.any(axis=0) & self.restarts.states.any(axis=1))
        count = used[-1] + 1 if used.size else 0
        return coefficients[:, :count], self.restarts.states[:count]

    @cached_property
    def _groups(self) -> BlockGroups:
        return BlockGroups.of(self.blocks)

    @cached_property
    def _prepared(self) -> tuple[np.ndarray, np.ndarray]:
        """C with columns of size one, and the sizes, which multiply v: a small column may meet a large state."""
        coefficients, each = self.coefficients, [len(block) for block in self.blocks]
        size = np.abs(coefficients).max(axis=0, initial=0.0)
        if len(size) and len(coefficients):
            size = np.repeat(np.maximum.reduceat(size, np.cumsum([0, *each[:-1]])), each)
        size = np.where(size > 0, size, 1.0)
        return coefficients / size, size

    @cached_property
    def _oscillating_part(self) -> OscillatingPart | None:
        return OscillatingPart.of(self.blocks, self._groups, self.start)

    @cached_property
    def _folded(self) -> tuple[np.ndarray, Oscillations, np.ndarray | None, BohlFunction]:
        """C e^{J t} v as D (cosines, sines), the lines a + b t, and the remaining function."""
        coefficients = self.coefficients
        return *self._oscillating_part.of_rows(coefficients), *self._remaining(coefficients)

    @cached_property
    def _phasors(self) -> tuple[np.ndarray, np.ndarray | None, BohlFunction]:
        """Phasors of the oscillations, for few rows."""
        coefficients = self.coefficients
        return self._oscillating_part.phasors(coefficients), *self._remaining(coefficients)

    def _remaining(self, coefficients) -> tuple[np.ndarray | None, BohlFunction]:
        """The lines a + b t of the drifting states, and the function of the states that neither oscillate nor drift."""
        oscillating = self._oscillating_part
        lines = coefficients[:, oscillating.drifting] @ oscillating.lines if len(oscillating.drifting) else None
        return lines, BohlFunction(coefficients[:, oscillating.others], oscillating.blocks, oscillating.start)

    @cached_property
    def _lasting(self) -> Lasting | None:
        """Duration for which each oscillation exceeds rounding errors."""
        folded, oscillations, *_ = self._folded
        return Lasting.of(oscillations, folded)

    @property
    def is_zero(self) -> bool:
        """Whether the function is known to vanish at all times."""
        return not (self.coefficients.any() and self.restarts.states.any())

    @cached_property
    def restarts(self) -> Restarts:
        """The start as ``Restarts``, with the knot t = 0 alone where there are no others."""
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
        return block_matrix(self.blocks)

    def derivative(self, order: int = 1) -> BohlFunction:
        """The classical derivative C J^order e^{J t} v."""
        coefficients = self.coefficients
        with np.errstate(over="ignore", invalid="ignore"):  # reported when the derivative is evaluated
            for _ in range(whole_number(order, "order")):
                coefficients = self._times_generator(coefficients)
        return BohlFunction(coefficients, self.blocks, self.start)

    def differential(self, *matrices: np.ndarray) -> BohlFunction:
        """Return matrices[0] @ f + matrices[1] @ f' + ..., with the same states, at the cost of one of the terms.

        Args:
            matrices: each of shape (p, r).

        Returns:
            A function with p rows.
        """
        coefficients, total = self.coefficients, matrices[0] @ self.coefficients
        for matrix in matrices[1:]:
            coefficients = self._times_generator(coefficients)
            total = total + matrix @ coefficients
        return BohlFunction(total, self.blocks, self.start)

    def mapped(self, matrix) -> BohlFunction:
        """The function matrix @ f(t), matrix of shape (p, r)."""
        matrix = real_array(matrix, "matrix", shape=(None, self.size))
        return BohlFunction(matrix @ self.coefficients, self.blocks, self.start)

    def rows(self, indices) -> BohlFunction:
        """Return the function of some rows in the given order, evaluated at the cost of these rows alone."""
        return BohlFunction(self.coefficients[np.asarray(indices, dtype=int)], self.blocks, self.start)

    def chunks(self, times, count: int | None = None) -> Iterator[Piece]:
        """Yield f at many times as pairs (times, values), for results larger than memory (``in_chunks``).

        Args:
            times: shape (T,), in s; or the first and the last one, where a count is given.
            count: number of equidistant times.

        Returns:
            Pairs in order, the values of shape (r, number of times).
        """
        return in_chunks(self, times, count)

    def delayed(self, delay: float) -> BohlFunction:
        """The delayed function f(t - delay), zero for t < delay, for a delay of at least 0 s.

        >>> import numpy as np
        >>> BohlFunction(np.eye(1), (np.zeros((1, 1)),), np.ones(1)).delayed(2.0)([1.0, 2.0])
        array([[0., 1.]])
        """
        delay = real_number(delay, "delay", minimum=0.0)
        return self if delay == 0 else BohlFunction(self.coefficients, self.blocks, self.restarts.delayed(delay))

    def with_knots(self, knots: np.ndarray) -> BohlFunction:
        """Return the function with states at these knots too."""
        own = self.restarts
        if np.array_equal(knots, own.knots):
            return self
        moments = np.union1d(own.moments, np.setdiff1d(knots, own.knots))
        return BohlFunction(self.coefficients, self.blocks, own.on(self.blocks, moments))

    def __add__(self, other: BohlFunction) -> BohlFunction:
        if not isinstance(other, BohlFunction):
            return NotImplemented
        if self.size != other.size:
            raise InputError(f"functions of different sizes cannot be added: {self.size} and {other.size} rows")
        pairs = (one.terms if isinstance(one, BohlSum) else (one,) * bool(one.state_count) for one in (self, other))
        terms = tuple(chain.from_iterable(pairs)) or (self,)
        return BohlSum(terms) if len(terms) > 1 else terms[0]

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


class BohlSum(BohlFunction):
    """A sum of Bohl functions, whose states are put together when they are first needed, those of all terms at once."""

    terms: tuple[BohlFunction, ...]

    def __init__(self, terms: tuple[BohlFunction, ...]):
        self.__dict__["terms"] = terms

    @cached_property
    def _total(self) -> tuple[np.ndarray, tuple[np.ndarray, ...], np.ndarray | Restarts]:
        restarts = [term.restarts for term in self.terms]
        moments = np.unique(np.concatenate([one.moments for one in restarts]))
        restarts = [one.on(term.blocks, moments) for term, one in zip(self.terms, restarts)]
        summands = [
            Summand(block, np.stack([own.states[at], own.jumps[at]]), term.coefficients[:, at])
            for term, own in zip(self.terms, restarts)
            for block, at in zip(term.blocks, block_slices(term.blocks))
        ]
        total = merged(summands)
        values = np.concatenate([np.zeros((2, 0, len(moments))), *(one.values for one in total)], axis=1)
        restarting = any(isinstance(term.start, Restarts) for term in self.terms)
        start = Restarts(restarts[0].knots, *values, restarts[0].remainders) if restarting else values[0, :, 0]
        coefficients = np.hstack([np.zeros((self.size, 0)), *(one.coefficients for one in total)])
        return coefficients, tuple(one.block for one in total), start

    size = property(lambda self: self.terms[0].size)
    coefficients = property(lambda self: self._total[0])
    blocks = property(lambda self: self._total[1])
    start = property(lambda self: self._total[2])


Piece = tuple[np.ndarray, np.ndarray]


def in_chunks(function, times, count: int | None = None) -> Iterator[Piece]:
    """Values of a function of time in chunks, for answers larger than memory.

    >>> clock = BohlFunction(np.array([[1.0, 0.0]]), (np.array([[0.0, 1.0], [0.0, 0.0]]),), np.array([0.0, 1.0]))
    >>> [values.tolist() for _, values in in_chunks(clock, (0.0, 2.0), 3)]
    [[[0.0, 1.0, 2.0]]]
    """
    width = max(1, CHUNK_ENTRIES // max(function.size, 1))
    if count is None:
        given = real_array(times, "times", shape=(None,))
        parts = (given[begin : begin + width] for begin in range(0, len(given), width))
    else:
        parts = _even_parts(times, whole_number(count, "count", minimum=2), width)
    return ((part, function(part)) for part in parts)


def _even_parts(ends, count: int, width: int) -> Iterator[np.ndarray]:
    first, last = real_array(ends, "times with a count, the first and the last one", shape=(2,)).tolist()
    if not 0 <= first < last:
        raise InputError(f"times: found {first:g} s to {last:g} s; expected a first one of at least 0 and a later last one")
    step = (last - first) / (count - 1)
    numbers = ((begin, min(begin + width, count)) for begin in range(0, count, width))
    return (np.minimum(first + step * np.arange(*part), last) for part in numbers)


# The oscillating part of e^{J t} v, evaluated by cosines and sines with v in their coefficients.
#
# For a block a I + R of J with R^2 = -w^2 I the state is e^{a t} (v cos w t + R v sin w t / w). A motion from rest has no sines.
# For a double eigenvalue 0 it is v + R v t.


@dataclass(frozen=True, eq=False)
class OscillatingPart:
    """The oscillating and drifting states of e^{J t} v, and the remaining ones."""

    # a and w, shape (m,)
    growth: np.ndarray
    frequency: np.ndarray
    first: np.ndarray  # the first state of each pair, shape (m,)
    # v and R v / w, in units of these, shape (m, 2)
    even: np.ndarray
    odd: np.ndarray
    units: np.ndarray  # the size of v in each pair; a large one may multiply small coefficients
    drifting: np.ndarray  # the states of double eigenvalues 0
    lines: np.ndarray  # v and R v of the drifting states, shape (k, 2)
    others: np.ndarray  # the remaining states
    # the diagonal blocks and the values at 0+ of the remaining states
    blocks: tuple[np.ndarray, ...]
    start: np.ndarray

    @staticmethod
    def of(blocks: Sequence[np.ndarray], groups: BlockGroups, start: np.ndarray) -> OscillatingPart | None:
        """The oscillating part for J = diag(blocks), or None where no state oscillates."""
        chosen = (groups.square < 0).nonzero()[0]
        if not chosen.size:
            return None
        first, w = groups.first[chosen], np.sqrt(-groups.square[chosen])
        even = start[first[:, None] + np.arange(2)]
        units = np.abs(even).max(axis=1)
        even /= (units + (units == 0))[:, None]
        odd = (groups.rest[chosen] @ even[:, :, None])[:, :, 0] / w[:, None]
        drifting, slope = groups.drifts(start)
        lines, known = np.array([start[drifting], slope]).T, {*first.tolist(), *drifting.tolist()}
        kept = [(block, at) for block, at in zip(blocks, block_slices(blocks)) if at.start not in known]
        others = np.array([place for _, at in kept for place in range(at.start, at.stop)], dtype=int)
        rest = (others, tuple(block for block, _ in kept), start[others])
        return OscillatingPart(groups.mean[chosen], w, first, even, odd, units, drifting, lines, *rest)

    @property
    def rates(self) -> np.ndarray:
        """a + i w, shape (m,)."""
        return self.growth + 1j * self.frequency

    def phasors(self, coefficients: np.ndarray) -> np.ndarray:
        """z = c + i d of the terms e^{a t} (c cos w t + d sin w t) of C e^{J t} v, shape (r, m)."""
        pairs = coefficients[:, self.first[:, None] + np.arange(2)] * self.units[:, None]
        pairs = pairs * (self.even + 1j * self.odd)
        return pairs[..., 0] + pairs[..., 1]

    def of_rows(self, coefficients: np.ndarray) -> tuple[np.ndarray, Oscillations]:
        """D and the oscillations whose product with D is the oscillating part of C e^{J t} v, without zero columns."""
        tables = []
        for vectors in (self.even, self.odd):
            used = (vectors.any(axis=1) & (self.units > 0)).nonzero()[0]
            part = _combined(coefficients, self.first[used], vectors[used], self.units[used])
            kept = part.any(axis=0)
            tables.append((used, part) if kept.all() else (used[kept], part[:, kept]))
        (cosines, even), (sines, odd) = tables
        combined = np.concatenate([even, odd], axis=1) if len(sines) else even
        return combined, Oscillations(self.growth, self.frequency, cosines, sines)


def _combined(coefficients, first, vectors, units) -> np.ndarray:
    """Columns of C combined with the entries of each pair's vector; unused columns are skipped."""
    combined = np.zeros((len(coefficients), len(first)))
    for place in (0, 1):
        if np.count_nonzero(vectors[:, place]):
            part = coefficients[:, first + place]
            part *= units
            part *= vectors[:, place]
            combined += part
    return combined


# Sums of Bohl functions: summands with the same generator share their states where possible.

#: Vectors whose entries agree to so many binary digits are compared; those that have one direction share their states.
COMPARED_DIGITS = 48


class Summand(NamedTuple):
    """A diagonal block of J, its states and their jumps at K knots, shape (2, m, K), and its columns of C, shape (r, m)."""

    block: np.ndarray
    values: np.ndarray
    coefficients: np.ndarray


def merged(summands: Sequence[Summand]) -> list[Summand]:
    """Fewer summands with the same sum, in a time that grows with their number only; all have the same knots."""
    kept: list[Summand] = []
    candidates: dict[tuple[bytes, bytes], int] = {}
    sizes = {len(one.block) for one in summands}
    for summand in sorted(summands, key=lambda summand: -len(summand.block)):
        own = [*_keys(summand, len(summand.block))]
        for key in own:
            place = candidates.get(key)
            total = None if place is None else _sum(kept[place], summand)
            if total is not None:
                kept[place] = total
                break
        else:
            smaller = (key for size in sizes if size < len(summand.block) for key in _keys(summand, size))
            for key in (*own, *smaller):
                candidates.setdefault(key, len(kept))
            kept.append(summand)
    return _by_rows(kept)


def _keys(summand: Summand, size: int) -> Iterator[tuple[bytes, bytes]]:
    """Keys of its last states, as many as a size, and of its first columns where states restart."""
    block, skip, columns = summand.block, len(summand.block) - size, summand.coefficients[:, :size]
    yield block[skip:, skip:].tobytes(), summand.values[:, skip:].tobytes()
    if summand.values.shape[2] > 1 and columns.any():
        mantissa, exponent = np.frexp(columns / columns.flat[np.abs(columns).argmax()] + 0.0)
        yield block[:size, :size].tobytes(), np.round(np.ldexp(mantissa, COMPARED_DIGITS)).tobytes() + exponent.tobytes()


def _sum(larger: Summand, summand: Summand) -> Summand | None:
    """The sum of two as one summand, or None."""
    skip, size = len(larger.block) - len(summand.block), len(summand.block)
    same_tail = np.array_equal(larger.block[skip:, skip:], summand.block) and not larger.block[skip:, :skip].any()
    if same_tail and np.array_equal(larger.values[:, skip:], summand.values):
        total = larger.coefficients.copy()
        total[:, skip:] += summand.coefficients
        return larger._replace(coefficients=total)
    factor = _factor(summand, larger) if summand.values.shape[2] > 1 else None
    if factor is None:
        return None
    values = larger.values.copy()
    values[:, :size] += factor * summand.values
    return larger._replace(values=values)


def _factor(summand: Summand, larger: Summand) -> float | None:
    """The factor by which the leading columns of a larger summand give those of this one, or None.

    Delayed steps of one vector, or the slopes and jumps of a record, then need one chain of states for all.
    """
    size = len(summand.block)
    columns = larger.coefficients[:, :size]
    if not np.array_equal(larger.block[:size, :size], summand.block) or larger.block[size:, :size].any() or not columns.any():
        return None
    place = np.unravel_index(np.abs(columns).argmax(), columns.shape)
    with np.errstate(over="ignore", invalid="ignore"):  # no factor
        factor = summand.coefficients[place] / columns[place]
        same = np.abs(summand.coefficients - factor * columns) <= EPS * np.abs(summand.coefficients)
    return float(factor) if np.isfinite(factor) and same.all() else None


def _by_rows(summands: list[Summand]) -> list[Summand]:
    """Summands with one for each row of f, where several have one block and only its first state is read."""
    groups: dict[bytes, list[Summand]] = {}
    for summand in summands:
        groups.setdefault(summand.block.tobytes(), []).append(summand)
    total = []
    for group in groups.values():
        rows = () if len(group) == 1 else np.flatnonzero(np.any([one.coefficients.any(axis=1) for one in group], axis=0))
        if len(group) <= max(len(rows), 1) or group[0].values.shape[2] == 1:
            total += group
            continue
        turn = _quarter_turn(group[0].block)
        if any(one.coefficients[:, 1 if turn is None else 2 :].any() for one in group):
            total += group
            continue
        values = np.zeros((len(rows), *group[0].values.shape))
        for one in group:
            values += one.coefficients[rows, 0, None, None, None] * one.values
            if turn is not None:
                values += one.coefficients[rows, 1, None, None, None] * (turn @ one.values)
        for row, own in zip(rows, values):
            columns = np.zeros(group[0].coefficients.shape)
            columns[row, 0] = 1.0
            total.append(Summand(group[0].block, own, columns))
    return total


def _quarter_turn(block: np.ndarray) -> np.ndarray | None:
    """N with e_1^T N = e_2^T that commutes with the block of an oscillation; None for other blocks."""
    if len(block) % 2 or block[1, 0] == 0:
        return None
    turn = np.kron(np.eye(len(block) // 2), [[0.0, 1.0], [-1.0, 0.0]])
    return turn if np.array_equal(turn @ block, block @ turn) else None
