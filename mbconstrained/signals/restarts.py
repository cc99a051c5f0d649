"""States that start anew at given times: what makes a Bohl function piecewise, with one generator for all pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..linalg.exponential import block_states


@dataclass(frozen=True)
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

    def located(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For each time the number of its piece, and the time since this began."""
        piece = np.searchsorted(self.knots, times, side="right") - 1
        return piece, times - self.knots[piece]

    def rows(self, begin: int, end: int) -> Restarts:
        """Some of the states."""
        return Restarts(self.knots, self.states[begin:end], self.jumps[begin:end])

    def delayed(self, delay: float) -> Restarts:
        """The same, later by delay > 0."""
        first = 0 if self.jumps[:, 0].any() else 1  # without the knot 0 of what is delayed already
        nothing, later = np.zeros((len(self.states), 1)), self.knots[first:] + delay
        return _joined(
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


def _joined(knots, states, jumps) -> Restarts:
    """Knots that rounding has brought to the same time become one."""
    first = np.flatnonzero(np.append(True, np.diff(knots) > 0))
    last = np.append(first[1:], len(knots)) - 1
    return Restarts(knots[first], states[:, last], np.add.reduceat(jumps, first, axis=1))
