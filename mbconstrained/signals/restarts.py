"""States that start anew at given times: what makes a Bohl function piecewise, with one generator for all pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..checks import counted
from ..errors import InputError
from ..linalg.exponential import block_states


def as_slice(numbers: np.ndarray) -> slice | np.ndarray:
    """Whole numbers, at least one, as a slice where each follows the one before: of what it takes no copy is made.

    >>> as_slice(np.array([3, 4, 5])), as_slice(np.array([3, 5, 4])).tolist()
    (slice(3, 6, None), [3, 5, 4])
    """
    first, last = int(numbers[0]), int(numbers[-1])
    follow = last - first == len(numbers) - 1 and (np.diff(numbers) == 1).all()
    return slice(first, last + 1) if follow else numbers


@dataclass(frozen=True, repr=False)
class Restarts:
    """z(t) = e^{J (t - t_j)} z_j for t_j <= t < t_(j+1), and z = 0 before t = 0.

    What is known to change at a knot is kept beside the states themselves: the difference of two states is only known
    to rounding, and whether a force jumps at all decides whether there is an impulse.

    Attributes:
        knots: t_j in s, shape (K,), ascending, the first is 0.
        states: z_j = z(t_j+), shape (n, K).
        jumps: z(t_j+) - z(t_j-), shape (n, K); exactly zero where nothing changes.
    """

    knots: np.ndarray
    states: np.ndarray
    jumps: np.ndarray

    def __repr__(self) -> str:
        return f"Restarts({counted(len(self.states), 'state')}, set at {counted(len(self.knots), 'time')})"

    def located(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For each time the number of its piece, and the time since this began."""
        piece = np.searchsorted(self.knots, times, side="right") - 1
        return piece, times - self.knots[piece]

    def rows(self, at: slice) -> Restarts:
        """Some of the states."""
        return Restarts(self.knots, self.states[at], self.jumps[at])

    def delayed(self, delay: float) -> Restarts:
        """The same, later by delay > 0.

        Raises:
            InputError: as ``later_times``.
        """
        first = 0 if self.jumps[:, 0].any() else 1  # without the knot 0 of what is delayed already
        nothing, later = np.zeros((len(self.states), 1)), later_times(self.knots[first:], delay)
        return Restarts(
            np.append(0.0, later), np.hstack([nothing, self.states[:, first:]]), np.hstack([nothing, self.jumps[:, first:]])
        )

    def on(self, blocks: Sequence[np.ndarray], knots: np.ndarray) -> Restarts:
        """The same function of time with more knots; blocks are those of J."""
        if np.array_equal(knots, self.knots):
            return self
        piece, local = self.located(knots)
        with np.errstate(over="ignore", invalid="ignore"):  # told when the function is evaluated
            states = block_states(blocks, self.states[:, piece], local)
        jumps, own = np.zeros_like(states), np.searchsorted(knots, self.knots)
        states[:, own], jumps[:, own] = self.states, self.jumps
        return Restarts(knots, states, jumps)


class FreeRestarts(Restarts):
    """Restarts of which the states alone are given; what changes at the knots is found when something asks for it.

    Args:
        knots, states: as of ``Restarts``; before t = 0 the state is zero.
        blocks: those of J.
    """

    def __init__(self, knots: np.ndarray, states: np.ndarray, blocks: Sequence[np.ndarray]):
        for name, value in (("knots", knots), ("states", states), ("blocks", blocks)):
            object.__setattr__(self, name, value)

    @cached_property
    def jumps(self) -> np.ndarray:
        """z(t_j+) - z(t_j-), shape (n, K)."""
        jumps = self.states.copy()
        with np.errstate(over="ignore", invalid="ignore"):  # told when the function is evaluated
            jumps[:, 1:] -= block_states(self.blocks, self.states[:, :-1], np.diff(self.knots))
        return jumps


def later_times(times: np.ndarray, delay: float) -> np.ndarray:
    """Ascending times, later by delay.

    Raises:
        InputError: one would leave the range of float64, or two would be rounded to the same time: what acts between
            them would be lost, however much it is.
    """
    with np.errstate(over="ignore"):
        later = times + delay
    if not np.isfinite(later).all():
        raise InputError(f"delay: {delay:g} s after {times.max():g} s is beyond the range of float64; give a shorter delay")
    if (joined := np.diff(later) <= 0).any():
        at = int(np.argmax(joined))
        raise InputError(
            f"delay: {delay:g} s would bring the changes of the signal at {times[at]:.6g} s and {times[at + 1]:.6g} s to one and "
            "the same float64 time, and what acts between them would be lost; give a shorter delay, or count time from later on"
        )
    return later
