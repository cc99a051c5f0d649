"""Linear recursions with a block diagonal exponential: from one time to the next, all blocks of a size at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .blocks import block_slices
from .exponential import CHUNK_ENTRIES, block_states


def recursion(blocks: Sequence[np.ndarray], start: np.ndarray, gained: np.ndarray, gaps: np.ndarray) -> np.ndarray:
    """z_0 = start, z_(j+1) = e^{J h_j} z_j + g_j for J = diag(blocks), all z_j side by side, shape (n, K + 1).

    Args:
        start: shape (n,).
        gained: g_j, shape (n, K).
        gaps: h_j, shape (K,).

    >>> recursion([np.array([[-np.log(2.0)]])], np.array([8.0]), np.ones((1, 2)), np.ones(2)).round(12)
    array([[8. , 5. , 3.5]])
    """
    states = np.column_stack([start, gained])
    begins = np.array([at.start for at in block_slices(blocks)], dtype=int)
    for size in {len(block) for block in blocks}:
        group = [i for i, block in enumerate(blocks) if len(block) == size]
        at = begins[group][:, None] + np.arange(size)
        _advance([blocks[i] for i in group], states, at, gaps)
    return states


def _advance(blocks, states, at, gaps) -> None:
    """In place for the states at these places, shape (number of blocks, size)."""
    chunk = max(1, CHUNK_ENTRIES // (at.size * at.shape[1]))
    for begin in range(0, len(gaps), chunk):
        different, which = np.unique(gaps[begin : begin + chunk], return_inverse=True)
        steps = _propagators(blocks, different)
        finite = bool(np.isfinite(steps).all())
        for k, step in enumerate(which, start=begin):
            now = states[at, k]
            if finite:
                states[at, k + 1] += (steps[step] @ now[:, :, None])[:, :, 0]
            else:  # what is zero stays zero, however fast it would grow
                states[at, k + 1] += block_states(blocks, now.ravel(), gaps[k : k + 1]).reshape(at.shape)


def _propagators(blocks, gaps) -> np.ndarray:
    """e^{J h} for every gap h and every block, shape (gaps, blocks, size, size)."""
    size = len(blocks[0])
    columns = [block_states(blocks, np.tile(unit, len(blocks)), gaps) for unit in np.eye(size)]
    return np.array(columns).reshape(size, len(blocks), size, len(gaps)).transpose(3, 1, 2, 0)
