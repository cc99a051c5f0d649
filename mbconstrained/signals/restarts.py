"""Restarts: states of a piecewise Bohl function at its knots, with one generator J for all pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..ground.checks import counted
from ..ground.errors import InputError
from ..linalg.exponential.block_exponential import block_states


def as_slice(numbers: np.ndarray) -> slice | np.ndarray:
    """Consecutive whole numbers as a slice, which indexes without a copy; others unchanged.

    >>> as_slice(np.array([3, 4, 5])), as_slice(np.array([3, 5, 4])).tolist()
    (slice(3, 6, None), [3, 5, 4])
    """
    first, last = int(numbers[0]), int(numbers[-1])
    follow = last - first == len(numbers) - 1 and (np.diff(numbers) == 1).all()
    return slice(first, last + 1) if follow else numbers


#: Gaps between knots that are this many times shorter than the spacing of float64 numbers there keep too few of their digits.
LOST_GAP = 2.0**-10


@dataclass(frozen=True, repr=False, eq=False)
class Restarts:
    """z(t) = e^{J (t - t_j)} z_j for t_j <= t < t_(j+1), and z = 0 before t = 0.

    The jumps are stored next to the states, since a difference of states has rounding errors, and whether a force jumps
    decides whether there is an impulse. The remainders are the rounding errors of the knots: a short pulse at a late time keeps
    the digits of its duration.

    Attributes:
        knots: t_j in s as float64 numbers, shape (K,), ascending, the first is 0.
        states: z_j = z(t_j+), shape (n, K).
        jumps: z(t_j+) - z(t_j-), shape (n, K); exactly zero where nothing changes.
        remainders: t_j less the knots, shape (K,); 0.0 where there are none.
    """

    knots: np.ndarray
    states: np.ndarray
    jumps: np.ndarray
    remainders: np.ndarray | float = 0.0

    def __repr__(self) -> str:
        return f"Restarts({counted(len(self.states), 'state')}, set at {counted(len(self.knots), 'time')})"

    @property
    def moments(self) -> np.ndarray:
        """The knots as real, the remainders as imaginary parts: sorting and comparing take the remainders second."""
        return self.knots + 1j * self.remainders

    @property
    def gaps(self) -> np.ndarray:
        """t_(j+1) - t_j, shape (K - 1,)."""
        return _differences(np.diff(self.moments))

    def located(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Index of the piece of each time (T,), and the time since its knot."""
        piece = self.knots.searchsorted(times, side="right") - 1
        since = times - self.knots[piece]
        if isinstance(self.remainders, np.ndarray):
            since = np.maximum(since - self.remainders[piece], 0.0)
        return piece, since

    def rows(self, at: slice) -> Restarts:
        """The restarts of some of the states."""
        return Restarts(self.knots, self.states[at], self.jumps[at], self.remainders)

    def delayed(self, delay: float) -> Restarts:
        """The restarts delayed by delay > 0, in s.

        Raises:
            InputError: as ``later_times``.
        """
        first = 0 if self.jumps[:, 0].any() else 1  # without the knot 0 of a function that is delayed already
        knots = self.knots[first:]
        later, nothing = later_times(knots, delay, self.gaps[first:]), np.zeros((len(self.states), 1))
        added = later - knots
        errors = (knots - (later - added)) + (delay - added)  # of the sum, exactly (Knuth's two-sum)
        errors += np.broadcast_to(self.remainders, self.knots.shape)[first:]
        rounded = later + errors
        moments = np.append(0.0, rounded + 1j * (errors - (rounded - later)))
        return _restarts(moments, *(np.hstack([nothing, values[:, first:]]) for values in (self.states, self.jumps)))

    def on(self, blocks: Sequence[np.ndarray], moments: np.ndarray) -> Restarts:
        """The restarts of the same function at more knots.

        Args:
            blocks: the diagonal blocks of J.
            moments: the new knots with their remainders, its own included, as ``moments``; shape (K,).

        Returns:
            Restarts with K knots.
        """
        own = self.moments
        if np.array_equal(moments, own):
            return self
        piece = np.searchsorted(own, moments, side="right") - 1
        with np.errstate(over="ignore", invalid="ignore"):  # reported when the function is evaluated
            states = block_states(blocks, self.states[:, piece], _differences(moments - own[piece]))
        jumps, places = np.zeros_like(states), np.searchsorted(moments, own)
        states[:, places], jumps[:, places] = self.states, self.jumps
        return _restarts(moments, states, jumps)


def _restarts(moments: np.ndarray, states: np.ndarray, jumps: np.ndarray) -> Restarts:
    """Restarts at distinct knots: of two knots rounded to the same number, the later one gets the next number, and a remainder."""
    knots, remainders = moments.real.copy(), moments.imag.copy()
    while (same := np.flatnonzero(np.diff(knots) <= 0) + 1).size:
        later = np.nextafter(knots[same - 1], np.inf)
        knots[same], remainders[same] = later, remainders[same] + (knots[same] - later)
    return Restarts(knots, states, jumps, remainders if remainders.any() else 0.0)


class FreeRestarts(Restarts):
    """Restarts given by their states alone; the jumps at the knots are computed when they are first read.

    Args:
        knots, states, remainders: as in ``Restarts``; before t = 0 the state is zero.
        blocks: diagonal blocks of J.
    """

    blocks: Sequence[np.ndarray]

    def __init__(self, knots: np.ndarray, states: np.ndarray, remainders: np.ndarray | float, blocks: Sequence[np.ndarray]):
        for name, value in (("knots", knots), ("states", states), ("remainders", remainders), ("blocks", blocks)):
            object.__setattr__(self, name, value)

    @cached_property
    def jumps(self) -> np.ndarray:
        """z(t_j+) - z(t_j-), shape (n, K)."""
        jumps = self.states.copy()
        with np.errstate(over="ignore", invalid="ignore"):  # reported when the function is evaluated
            jumps[:, 1:] -= block_states(self.blocks, self.states[:, :-1], self.gaps)
        return jumps


def _differences(moments: np.ndarray) -> np.ndarray:
    return moments.real + moments.imag


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
