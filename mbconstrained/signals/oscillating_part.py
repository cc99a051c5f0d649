"""The oscillating part of e^{J t} v, evaluated by cosines and sines with v in their coefficients.

For a block a I + R of J with R^2 = -w^2 I the state is e^{a t} (v cos w t + R v sin w t / w). A motion from rest has no sines.
For a double eigenvalue 0 it is v + R v t.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..linalg.blocks import block_slices
from ..linalg.exponential.block_exponential import BlockGroups
from ..linalg.exponential.oscillations import Oscillations


@dataclass(frozen=True, eq=False)
class OscillatingPart:
    """The oscillating and drifting states of e^{J t} v, and the remaining ones.

    Attributes:
        growth, frequency: a and w, shape (m,).
        first: the first state of each pair, shape (m,).
        even, odd: v and R v / w, in units of these, shape (m, 2).
        units: the size of v in each pair; a large one may multiply small coefficients.
        drifting: the states of double eigenvalues 0.
        lines: v and R v of the drifting states, shape (k, 2).
        others: the remaining states.
        blocks, start: the diagonal blocks and the values at 0+ of the remaining states.
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
