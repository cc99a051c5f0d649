"""The states of a decoupled real matrix as complex scalars z_k' = s_k z_k, one for each real zero or pair, and what is left.

Of a block a I + R with R^2 = -w^2 I the first state and -1/w times the first row of R y make one complex number. Zeros that are
together in a block and no conjugate pair are left as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import eye_array

from .blocks import BlockDiagonal, block_matrix, block_slices
from .exponential import BlockGroups
from .kinds import Matrix
from .structured import StructuredModes


@dataclass(frozen=True, eq=False)
class Modes:
    """w = basis y: (z, rest) from y and y from (z, rest), with z_k(t) = e^{s_k t} z_k(0) and rest' = diag(blocks) rest.

    Attributes:
        decoupled: basis and blocks.
        rates: s, of pairs above the real axis, shape (p,).
        single: the places in y of real zeros.
        first, frequency: the first places of pairs, and w.
        turn: (R_11, R_12) of the pairs, shape (pairs, 2).
        rest, blocks: the places in y of what is left, and its blocks.
    """

    decoupled: BlockDiagonal | StructuredModes
    rates: np.ndarray
    single: np.ndarray
    first: np.ndarray
    frequency: np.ndarray
    turn: np.ndarray
    rest: np.ndarray
    blocks: tuple[np.ndarray, ...]

    @staticmethod
    def of(decoupled: BlockDiagonal | StructuredModes) -> Modes:
        """Those of a decoupled matrix.

        >>> from .blocks import block_diagonalize
        >>> modes = Modes.of(block_diagonalize(np.array([[0.0, 2.0], [-2.0, 0.0]])))
        >>> modes.rates.tolist(), [part.tolist() for part in modes.split(np.array([3.0, 4.0]))]
        ([2j], [[(3-4j)], []])
        """
        groups = BlockGroups.of(decoupled.blocks)
        turning = np.flatnonzero(groups.square < 0)
        first, w = groups.first[turning], np.sqrt(-groups.square[turning])
        taken = {*groups.single.tolist(), *first.tolist()}
        left = [(block, at) for block, at in zip(decoupled.blocks, block_slices(decoupled.blocks)) if at.start not in taken]
        rest = np.concatenate([np.zeros(0, dtype=int), *(np.arange(at.start, at.stop) for _, at in left)])
        rates, blocks = np.concatenate([groups.rates, groups.mean[turning] + 1j * w]), tuple(block for block, _ in left)
        return Modes(decoupled, rates, groups.single, first, w, groups.rest[turning, 0], rest, blocks)

    def split(self, coordinates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """z and the rest of y, of shape (n,) or (n, any)."""
        first, second = coordinates[self.first], coordinates[self.first + 1]
        turned = ((self.turn[:, 0] * first.T + self.turn[:, 1] * second.T) / self.frequency).T
        return np.concatenate([coordinates[self.single], first - 1j * turned]), coordinates[self.rest]

    def states(self, scalars: np.ndarray, rest: np.ndarray) -> np.ndarray:
        """w of z and the rest of y, shape (n,)."""
        single, pairs = np.split(scalars, [len(self.single)])
        y = np.empty(len(self.single) + 2 * len(self.first) + len(self.rest))
        y[self.single], y[self.first], y[self.rest] = single.real, pairs.real, rest
        y[self.first + 1] = -(self.frequency * pairs.imag + self.turn[:, 0] * pairs.real) / self.turn[:, 1]
        return self.decoupled.seen(eye_array(len(y), format="csr")) @ y

    def seen(self, output: Matrix, order: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """The derivative of this order of output @ w: what multiplies real and imaginary parts of z in turn, and the rest of y."""
        found = self.decoupled.seen(output)
        second, (own, coupling) = found[:, self.first + 1], self.turn.T
        pairs = found[:, self.first] - second * (own / coupling) + 1j * (second * (self.frequency / coupling))
        scalars, rest = np.hstack([found[:, self.single], pairs]), found[:, self.rest]
        for _ in range(order):
            scalars, rest = scalars * self.rates, rest @ self._generator
        return np.ascontiguousarray(scalars.conj()).view(float), rest

    @cached_property
    def _generator(self) -> np.ndarray:
        return block_matrix(self.blocks)
