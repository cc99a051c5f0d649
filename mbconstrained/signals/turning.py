"""The oscillating part of e^{J t} v, as it is evaluated fastest: cosines and sines with v already in their coefficients.

For a block a I + R of J with R^2 = -w^2 I the state is e^{a t} (v cos w t + R v sin w t / w). A motion from rest has no sines.
Of zeros at 0 it is v + R v t.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..linalg.blocks import block_slices
from ..linalg.exponential import BlockGroups
from ..linalg.oscillations import Oscillations


@dataclass(frozen=True, eq=False)
class Turning:
    """Which states oscillate, and how; and the others.

    Attributes:
        growth, frequency: a and w, shape (m,).
        first: the first state of each pair, shape (m,).
        even, odd: v and R v / w, in units of these, shape (m, 2).
        units: the size of v in each pair; a huge one may stand beside tiny coefficients.
        drifting: the states of zeros at 0.
        lines: theirs, v and R v, shape (k, 2).
        others: the other states.
        blocks, start: theirs.
    """

    growth: np.ndarray
    frequency: np.ndarray
    first: np.ndarray
    even: np.ndarray
    odd: np.ndarray
    units: np.ndarray
    drifting: np.ndarray
    lines: np.ndarray
    others: np.ndarray
    blocks: tuple[np.ndarray, ...]
    start: np.ndarray

    @staticmethod
    def of(blocks: Sequence[np.ndarray], groups: BlockGroups, start: np.ndarray) -> Turning | None:
        """That of J = diag(blocks), None where nothing oscillates."""
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
        return Turning(groups.mean[chosen], w, first, even, odd, units, drifting, lines, *rest)

    @property
    def rates(self) -> np.ndarray:
        """a + i w, shape (m,)."""
        return self.growth + 1j * self.frequency

    def phasors(self, coefficients: np.ndarray) -> np.ndarray:
        """z = c + i d of the e^{a t} (c cos w t + d sin w t) of which C e^{J t} v consists without the other states, shape (r, m)."""
        pairs = coefficients[:, self.first[:, None] + np.arange(2)] * self.units[:, None]
        pairs = pairs * (self.even + 1j * self.odd)
        return pairs[..., 0] + pairs[..., 1]

    def of_rows(self, coefficients: np.ndarray) -> tuple[np.ndarray, Oscillations]:
        """D and the functions of which D makes C e^{J t} v, without the other states; what is not there is left out."""
        tables = []
        for vectors in (self.even, self.odd):
            used = (vectors.any(axis=1) & (self.units > 0)).nonzero()[0]
            part = _combined(coefficients, self.first[used], vectors[used], self.units[used])
            kept = part.any(axis=0)
            tables.append((used, part) if kept.all() else (used[kept], part[:, kept]))
        (cosines, even), (sines, odd) = tables
        found = np.concatenate([even, odd], axis=1) if len(sines) else even
        return found, Oscillations(self.growth, self.frequency, cosines, sines)


def _combined(coefficients, first, vectors, units) -> np.ndarray:
    """For each pair the columns of C by the entries of a vector, added; columns that no vector uses are not looked at."""
    found = np.zeros((len(coefficients), len(first)))
    for place in (0, 1):
        if np.count_nonzero(vectors[:, place]):
            part = coefficients[:, first + place]
            part *= units
            part *= vectors[:, place]
            found += part
    return found
