"""Linear recursions with a block diagonal exponential: from one time to the next, all blocks of a size at once.

The steps are taken in groups, the same step of all groups at once (a scan in two passes, Blelloch 1990): first every group from
rest, for what it gains; from one group to the next by the exponential of its whole duration; then every group again from its true
start. So a record of ten thousand samples takes some hundred operations on long arrays.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..tolerances import EPS
from .blocks import CHUNK_ENTRIES, block_slices
from .exponential import block_states

#: Fewer steps are taken one by one.
FEW_STEPS = 64


def recursion(blocks: Sequence[np.ndarray], start: np.ndarray, gained: np.ndarray, gaps: np.ndarray) -> np.ndarray:
    """z_0 = start, z_(j+1) = e^{J h_j} z_j + g_j for J = diag(blocks), all z_j side by side, shape (n, K + 1).

    Args:
        start: shape (n,).
        gained: g_j, shape (n, K).
        gaps: h_j, shape (K,).

    >>> recursion([np.array([[-np.log(2.0)]])], np.array([8.0]), np.ones((1, 2)), np.ones(2)).round(12)
    array([[8. , 5. , 3.5]])
    """
    states = np.empty((len(start), len(gaps) + 1))
    states[:, 0], states[:, 1:] = start, gained
    advance(blocks, states, gaps)
    return states


def advance(blocks: Sequence[np.ndarray], states: np.ndarray, gaps: np.ndarray) -> None:
    """The same in place: states (n, K + 1) begin as z_0, g_0, g_1, ... and become z_0, z_1, z_2, ..."""
    begins = np.array([at.start for at in block_slices(blocks)], dtype=int)
    for size in {len(block) for block in blocks}:
        group = [i for i, block in enumerate(blocks) if len(block) == size]
        at = begins[group][:, None] + np.arange(size)
        _advance([blocks[i] for i in group], states, at, gaps)


def shared_gaps(knots: np.ndarray) -> np.ndarray:
    """The differences of ascending times, those that are the same but for the rounding of the times made equal.

    Not where the times would be moved by more than some units in their last place.

    >>> len(np.unique(shared_gaps(np.linspace(0.0, 1.0, 1000)))), shared_gaps(np.array([0.0, 1.0, 3.0])).tolist()
    (1, [1.0, 2.0])
    """
    gaps = np.diff(knots)
    order, limit = np.argsort(gaps), 4 * EPS * knots[-1]
    first = np.append(True, np.diff(gaps[order]) > limit)[: len(gaps)]
    which = np.empty(len(gaps), dtype=int)
    which[order] = np.cumsum(first) - 1
    means = np.bincount(which, gaps) / np.bincount(which)
    shared = means[which]
    return shared if np.abs(np.cumsum(shared - gaps)).max(initial=0.0) <= limit else gaps


def propagators(blocks: Sequence[np.ndarray], gaps: np.ndarray) -> np.ndarray:
    """e^{J h} for every gap h and every one of blocks of one size, shape (gaps, blocks, size, size)."""
    size = len(blocks[0])
    columns = [block_states(blocks, np.tile(unit, len(blocks)), gaps) for unit in np.eye(size)]
    return np.array(columns).reshape(size, len(blocks), size, len(gaps)).transpose(3, 1, 2, 0)


def _advance(blocks, states, at, gaps) -> None:
    """In place for the states at these places, shape (number of blocks, size)."""
    chunk = max(1, CHUNK_ENTRIES // (at.size * at.shape[1]))
    for begin in range(0, len(gaps), chunk):
        part = gaps[begin : begin + chunk]
        different, which = np.unique(part, return_inverse=True)
        steps, taken = propagators(blocks, different), 0
        finite = bool(np.isfinite(steps).all())
        if finite and len(part) >= FEW_STEPS:
            taken = _scanned(blocks, states, at, begin, part, steps, which)
        for k, step in enumerate(which[taken:], start=begin + taken):
            now = states[at, k]
            if finite:
                states[at, k + 1] += (steps[step] @ now[:, :, None])[:, :, 0]
            else:  # what is zero stays zero, however fast it would grow
                states[at, k + 1] += block_states(blocks, now.ravel(), gaps[k : k + 1]).reshape(at.shape)


def _scanned(blocks, states, at, begin, gaps, steps, which) -> int:
    """In place as many steps as make whole groups; how many these are, none where a group's exponential leaves the range."""
    length = int(len(gaps) ** 0.5)
    groups = len(gaps) // length
    taken = groups * length
    durations = gaps[:taken].reshape(groups, length).sum(axis=1)
    across = propagators(blocks, durations)
    if not np.isfinite(across).all():
        return 0
    places = slice(begin + 1, begin + 1 + taken)
    gained = states[at, places].reshape(*at.shape, groups, length).transpose(1, 3, 0, 2).copy()  # (size, length, blocks, groups)
    if len(steps) == 1:
        factors = [steps[0].transpose(1, 2, 0)[..., None]] * length
    else:
        factors = [steps[step].transpose(2, 3, 1, 0) for step in which[:taken].reshape(groups, length).T]
    starts = _starts(states[at, begin], _from(np.zeros_like(gained[:, 0]), gained, factors), across)
    _from(starts, gained, factors, keep=True)
    states[at, places] = gained.transpose(2, 0, 3, 1).reshape(*at.shape, taken)
    return taken


def _starts(start, ends, across) -> np.ndarray:
    """z where each group begins, shape (size, blocks, groups)."""
    found, now = np.empty_like(ends), start
    for group, step in enumerate(across):
        found[:, :, group] = now.T
        now = (step @ now[:, :, None])[:, :, 0] + ends[:, :, group].T
    return found


def _from(now, gained, factors, keep: bool = False) -> np.ndarray:
    """All groups from their starts (size, blocks, groups) to their ends; what they pass is kept in place of the gains."""
    part = np.empty_like(now[0])
    for step, factor in enumerate(factors):
        following = gained[:, step] if keep else gained[:, step].copy()
        for i, row in enumerate(factor):
            for k, entry in enumerate(row):
                following[i] += np.multiply(entry, now[k], out=part)
        now = following
    return now


def scanned(states: np.ndarray, factors: np.ndarray) -> None:
    """z_(j+1) = factors_j z_j + g_j for complex scalars side by side, in place: states (K + 1, p) begin as z_0, g_0, g_1, ...

    Args:
        factors: shape (K, p), or (1, p) where all are the same.

    >>> states = np.array([[8.0], [1.0], [1.0]], dtype=complex)
    >>> scanned(states, np.array([[0.5 + 0j]]))
    >>> states.ravel().real.tolist()
    [8.0, 5.0, 3.5]
    """
    count, p = len(states) - 1, states.shape[1]
    length = max(1, int(count**0.5))
    groups, taken = count // length, count // length * length
    gained = states[1 : taken + 1].reshape(groups, length, p)
    each = factors[:taken].reshape(groups, length, p) if len(factors) > 1 else np.broadcast_to(factors, (1, length, p))
    now, across = np.zeros((groups, p), dtype=complex), np.ones((len(each), p), dtype=complex)
    for step in range(length):
        now *= each[:, step]
        now += gained[:, step]
        across *= each[:, step]
    following = states[0]
    for group in range(groups):
        now[group], following = following, across[group % len(across)] * following + now[group]
    for step in range(length):
        now *= each[:, step]
        now += gained[:, step]
        gained[:, step] = now
    for step in range(taken, count):
        states[step + 1] += factors[step % len(factors)] * states[step]


def powers(values: np.ndarray, count: int) -> np.ndarray:
    """1, x, x^2, ..., one row for each of values (T,), shape (T, count).

    >>> powers(np.array([2.0]), 5).tolist()
    [[1.0, 2.0, 4.0, 8.0, 16.0]]
    """
    found, done = np.empty((count, len(values))), 1
    found[0] = 1.0
    while done < count:
        some = min(done, count - done)
        np.multiply(found[:some], found[done - 1] * values, out=found[done : done + some])
        done += some
    return np.ascontiguousarray(found.T)
