"""y' = B y + U z with z' = J z, from a new start wherever the force starts, stops or changes: y(t) as a Bohl function.

As ``response.regular`` does for the whole system: with B Y - Y J = -U the force causes Y z and a free motion; where Y is large,
near resonance, y and a copy of z are evaluated together instead.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from ...linalg.blocks import block_slices
from ...linalg.exponential import block_states
from ...linalg.recursion import recursion
from ...signals.bohl import BohlFunction
from ...signals.restarts import Restarts
from .space import ModeSpace

#: A motion and its force are told apart where Y, times the largest rate, is at most this many times U: below resonance.
SEPARATION = 32.0


class Amplitudes:
    """The states y of the kept modes and z of the force.

    Attributes:
        function: w + s rows: what multiplies the columns of W, and z.
        start: the free part of y at 0+.
    """

    def __init__(self, space: ModeSpace, start: np.ndarray, driven: np.ndarray, smooth: BohlFunction):
        self.space, restarts = space, smooth.restarts
        blocks, units, outer = [], np.ones(space.count), block_slices(smooth.blocks)
        Y, coupled = np.zeros(driven.shape), []
        for block, at in zip(space.blocks, block_slices(space.blocks)):
            for J, of in zip(smooth.blocks, outer):
                if driven[at, of].any():
                    units[at] = _units(block, J)
                    own, U = _measured(block, units[at]), driven[at, of] / units[at][:, None]
                    found = _separated(own, J, U)
                    if found is None:
                        unit = max(np.abs(U).max(), np.finfo(float).tiny) / max(np.abs(own).max(), np.abs(J).max(), 1.0)
                        coupled.append((at, of, np.block([[own, U / unit], [np.zeros((len(J), len(own))), J]]), unit * units[at]))
                    else:
                        Y[at, of] = units[at][:, None] * found
            blocks.append(block)
        self.Y, self.coupled = Y, coupled
        knots, inputs = restarts.knots, restarts.states
        caused = np.vstack([-Y @ inputs, inputs, *(_from_rest(at, inputs[of]) for at, of, _, _ in coupled)])
        blocks += [*smooth.blocks, *(block for _, _, block, _ in coupled)]
        gaps = np.diff(knots)
        with np.errstate(over="ignore", invalid="ignore"):  # told when the function is evaluated
            gained = self._finite(block_states(blocks, caused[:, :-1], gaps))
            own = recursion(space.blocks, start, gained, gaps)
            states = caused
            states[: space.count] += own
            before = np.hstack([np.zeros((len(states), 1)), block_states(blocks, states[:, :-1], gaps)])
        rows = np.vstack([self._rows(len(inputs), len(states)), self._force_rows(len(inputs), len(states))])
        at_knots = states[:, 0] if len(knots) == 1 else Restarts(knots, states, states - before)
        self.function, self.start = BohlFunction(rows, tuple(blocks), at_knots), start

    def _finite(self, states) -> np.ndarray:
        """y from the states of all blocks."""
        n, m = self.Y.shape
        y, begin = states[:n] + self.Y @ states[n : n + m], n + m
        for at, _, block, units in self.coupled:
            y[at] += units[:, None] * states[begin : begin + len(units)]
            begin += len(block)
        return y

    def _rows(self, inputs, size) -> np.ndarray:
        n, places = self.space.count, self.space.places
        rows = np.zeros((n, size))
        rows[:, :n], rows[:, n : n + inputs] = np.eye(n), self.Y
        begin = n + inputs
        for at, _, block, units in self.coupled:
            rows[at, begin : begin + len(units)] = np.diag(units)
            begin += len(block)
        return rows[places]

    def _force_rows(self, inputs, size) -> np.ndarray:
        rows = np.zeros((inputs, size))
        rows[:, self.space.count : self.space.count + inputs] = np.eye(inputs)
        return rows


def _units(block, J) -> np.ndarray:
    """What displacement and velocity of a mode are measured in: 1 and the larger rate of the two."""
    if len(block) == 1 or block[0, 1] != 1.0 or block[0, 0]:
        return np.ones(len(block))
    rate = max(abs(block[1, 0]) ** 0.5, abs(block[1, 1]), float(np.abs(np.diag(J)).max()), float(np.abs(J).max()))
    return np.array([1.0, 2.0 ** np.round(np.log2(rate)) if rate else 1.0])


def _measured(block, units) -> np.ndarray:
    return block * units / units[:, None]


def _separated(own, J, U) -> np.ndarray | None:
    """Y, or None near resonance."""
    matrix = np.kron(own, np.eye(len(J))) - np.kron(np.eye(len(own)), J.T)
    scale = max(np.abs(own).max(), np.abs(J).max())
    if not scale:
        return None
    try:
        found = scipy.linalg.solve(matrix, -U.ravel(), check_finite=False) if np.linalg.cond(matrix) < SEPARATION**4 else None
    except np.linalg.LinAlgError:
        return None
    if found is None or np.abs(found).max() * scale > SEPARATION * np.abs(U).max() * len(J):
        return None
    return found.reshape(U.shape)


def _from_rest(at, inputs) -> np.ndarray:
    return np.vstack([np.zeros((at.stop - at.start, inputs.shape[1])), inputs])
