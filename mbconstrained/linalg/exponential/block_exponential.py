"""e^{J t} v for a block diagonal J at many times, without stepping from one time to the next.

Blocks of size one and two have a formula; for larger ones, clusters of close or defective zeros, see
``linalg.exponential.clusters``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...ground.tolerances import MODERATE_EXPONENT
from ..blocks import block_slices
from .clusters import cluster_states, equal_groups
from .oscillations import Oscillations

#: Clusters are taken together in arrays of at most so many states.
AT_ONCE = 1 << 17


@dataclass(frozen=True, eq=False)
class BlockGroups:
    """Diagonal blocks sorted by size, so that all of a size are taken at once.

    Attributes:
        single, rates: the states of blocks of size one, and their rates.
        first: the first state of each block of size two.
        pairs: these blocks, shape (k, 2, 2), mean I + rest with rest^2 = square I.
        larger: states of the blocks of each other size, shape (k, n), and these blocks, (k, n, n).
    """

    single: np.ndarray
    rates: np.ndarray
    first: np.ndarray
    pairs: np.ndarray
    mean: np.ndarray
    rest: np.ndarray
    square: np.ndarray
    larger: tuple[tuple[np.ndarray, np.ndarray], ...]

    @staticmethod
    def of(blocks: Sequence[np.ndarray]) -> BlockGroups:
        """The groups of diag(blocks)."""
        of_size: dict[int, tuple[list[int], list[np.ndarray]]] = {1: ([], []), 2: ([], [])}  # where they begin, and they
        for at, block in zip(block_slices(blocks), blocks):
            begins, same = of_size.setdefault(len(block), ([], []))
            begins.append(at.start)
            same.append(block)
        stacks = {
            size: (np.array(begins, dtype=int), np.array(same).reshape(-1, size, size)) for size, (begins, same) in of_size.items()
        }
        (single, rates), (first, pairs) = stacks.pop(1), stacks.pop(2)
        rest, mean = pairs.copy(), (pairs[:, 0, 0] + pairs[:, 1, 1]) / 2
        rest[:, 0, 0] -= mean
        rest[:, 1, 1] -= mean
        square = rest[:, 0, 0] ** 2 + rest[:, 0, 1] * rest[:, 1, 0]
        larger = tuple((begins[:, None] + np.arange(size), same) for size, (begins, same) in stacks.items())
        return BlockGroups(single, rates[:, 0, 0], first, pairs, mean, rest, square, larger)

    @cached_property
    def growth(self) -> np.ndarray:
        """Largest real part of the eigenvalues of each block of size two."""
        pairs = self.pairs
        determinant = pairs[:, 0, 0] * pairs[:, 1, 1] - pairs[:, 0, 1] * pairs[:, 1, 0]
        return _larger_real_part(self.mean, self.square, determinant)

    def drifts(self, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The states of zeros at 0, which are v + R v t, and R v for v of shape (n,)."""
        resting, pairs = self.single[self.rates == 0], (self.square == 0) & (self.mean == 0)
        places = self.first[pairs, None] + np.arange(2)
        turned = self.rest[pairs] @ start[places][:, :, None]
        return np.concatenate([resting, places.reshape(-1)]), np.concatenate([np.zeros(len(resting)), turned.reshape(-1)])

    def oscillate(self, times: np.ndarray) -> np.ndarray:
        """Which of the pairs oscillate, and stay in range within these times."""
        with np.errstate(over="ignore"):
            return (self.square < 0) & (self.mean * times.max(initial=0.0) < MODERATE_EXPONENT)


def block_states(blocks: Sequence[np.ndarray] | BlockGroups, start: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The states e^{J t} v, shape (n, T), for J = diag(blocks) and times (T,)."""
    groups = blocks if isinstance(blocks, BlockGroups) else BlockGroups.of(blocks)
    states = np.empty((len(start), len(times)))
    start = start[:, None] if start.ndim == 1 else start
    if groups.single.size:
        states[groups.single] = _scaled(start[groups.single], np.multiply.outer(groups.rates, times))
    _two_by_two(groups, start, times, states)
    for places, same in groups.larger:
        states[places] = _clusters(same, start[places], times)
    return states


def _clusters(blocks, start, times) -> np.ndarray:
    """Blocks (k, n, n) at times (T,), grouped by equal starts, from (k, n, T) or (k, n, 1)."""
    count, size = blocks.shape[:2]
    start = np.broadcast_to(start, (count, size, len(times)))
    states, started = np.zeros(start.shape), start.any(axis=1)  # what does not start stays zero, however fast it would grow
    for same in equal_groups(map(bytes, np.packbits(started, axis=1))):
        when = np.flatnonzero(started[same[0]])
        width = max(1, AT_ONCE // max(size * len(when), 1))
        for begin in range(0, len(same) if len(when) else 0, width):
            at = same[begin : begin + width]
            places = at[:, None, None], np.arange(size)[:, None], when
            states[places] = cluster_states(blocks[at], start[places], times[when])
    return states


def _two_by_two(groups: BlockGroups, start, times, states) -> None:
    in_range, drifting = groups.oscillate(times), (groups.square == 0) & (groups.mean == 0)
    _oscillations(groups, np.flatnonzero(in_range), start, times, states)
    _drifts(groups, np.flatnonzero(drifting), start, times, states)
    _any_pairs(groups, np.flatnonzero(~in_range & ~drifting), start, times, states)


def _drifts(groups: BlockGroups, chosen, start, times, states) -> None:
    """Pairs of zeros at 0: v + R v t."""
    if not chosen.size:
        return
    at, rest = groups.first[chosen], groups.rest[chosen]
    for row in (0, 1):
        turned = rest[:, row, 0, None] * start[at] + rest[:, row, 1, None] * start[at + 1]
        states[at + row] = start[at + row] + turned * times


def _oscillations(groups: BlockGroups, chosen, start, times, states) -> None:
    """Pairs that oscillate and stay in range."""
    if not chosen.size:
        return
    at, rest, w, every = groups.first[chosen], groups.rest[chosen], np.sqrt(-groups.square[chosen]), np.arange(len(chosen))
    even, odd = np.split(Oscillations(groups.mean[chosen], w, every, every)(times), 2)
    for row in (0, 1):
        factors = rest[:, row] / w[:, None]
        turned = factors[:, 0, None] * start[at] + factors[:, 1, None] * start[at + 1]
        states[at + row] = start[at + row] * even + turned * odd


def _any_pairs(groups: BlockGroups, chosen, start, times, states) -> None:
    if not chosen.size:
        return
    at, rest = groups.first[chosen], groups.rest[chosen]
    pair = np.stack([start[at], start[at + 1]], axis=1)
    turned = np.einsum("bij,bjt->bit", rest, pair)
    even, odd = _even_and_odd(groups.square[chosen], times)
    growth = np.multiply.outer(groups.growth[chosen], times)
    for row in (0, 1):
        states[at + row] = _scaled(pair[:, row] * even + turned[:, row] * odd, growth)


def _larger_real_part(mean, square, determinant):
    """mean + sqrt(square) where that is real, else mean, without cancellation for a slow decay next to a fast one."""
    root = np.sqrt(np.maximum(square, 0.0))
    return np.where((square > 0) & (mean < 0), determinant / np.where(mean < 0, mean - root, 1.0), mean + root)


def _even_and_odd(square, times):
    """cosh(d t) and sinh(d t)/d with d = sqrt(square), both divided by e^{d t} where d is real so that they never overflow."""
    root = np.sqrt(np.abs(square))
    angle = np.multiply.outer(root, times)
    exponent = np.where((square > 0)[:, None], angle, 0.0)
    decay = np.exp(-2 * exponent)
    safe = np.where(root == 0, 1.0, root)[:, None]
    oscillating = (square < 0)[:, None]
    even = np.where(oscillating, np.cos(angle), (1 + decay) / 2)
    odd = np.where(oscillating, np.sin(angle), -np.expm1(-2 * exponent) / 2) / safe
    odd = np.where((root == 0)[:, None], times[None, :], odd)
    return even, odd


def _scaled(values, exponents):
    """values * e^exponents in two halves: a tiny value may compensate an exponential beyond the range; zeros stay zero."""
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        half = np.exp(exponents / 2)
        return np.where(values == 0, 0.0, values * half * half)
