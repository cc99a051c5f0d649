"""Linear recursions with a block diagonal exponential: from one time to the next, all blocks of a size at once.

The steps are taken in groups, the same step of all groups at once (a scan in two passes, Blelloch 1990): first every group from
rest, for what it gains; from one group to the next by the exponential of its whole duration; then every group again from its true
start. So a record of ten thousand samples takes some hundred operations on long arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import eye_array

from ...ground.tolerances import EPS
from ..arrays import Matrix
from ..blocks import CHUNK_ENTRIES, BlockDiagonal, block_matrix, block_slices
from ..tree_modes.residue_modes import ResidueModes
from .block_exponential import BlockGroups, block_states

#: Fewer steps are taken one by one.
FEW_STEPS = 64


def recursion(blocks: Sequence[np.ndarray], start: np.ndarray, gained: np.ndarray, gaps: np.ndarray) -> np.ndarray:
    """z_0 = start, z_(j+1) = e^{J h_j} z_j + g_j for J = diag(blocks), all z_j side by side, shape (n, K + 1).

    >>> recursion([np.array([[-np.log(2.0)]])], np.array([8.0]), np.ones((1, 2)), np.ones(2)).round(12)
    array([[8. , 5. , 3.5]])
    """
    states = np.empty((len(start), len(gaps) + 1))
    states[:, 0], states[:, 1:] = start, gained
    advance(blocks, states, gaps)
    return states


def advance(blocks: Sequence[np.ndarray], states: np.ndarray, gaps: np.ndarray) -> None:
    """Advance states (n, K + 1) in place: they begin as z_0, g_0, g_1, ... and become z_0, z_1, z_2, ..."""
    begins = np.array([at.start for at in block_slices(blocks)], dtype=int)
    for size in {len(block) for block in blocks}:
        group = [i for i, block in enumerate(blocks) if len(block) == size]
        at = begins[group][:, None] + np.arange(size)
        _advance([blocks[i] for i in group], states, at, gaps)


def shared_gaps(knots: np.ndarray, gaps: np.ndarray | None = None) -> np.ndarray:
    """The differences of ascending times, equal where they differ by rounding errors only.

    Not where the times would be moved by more than some units in their last place, or a difference lose half of its digits.

    >>> len(np.unique(shared_gaps(np.linspace(0.0, 1.0, 1000)))), shared_gaps(np.array([0.0, 1.0, 3.0])).tolist()
    (1, [1.0, 2.0])
    """
    gaps = np.diff(knots) if gaps is None else gaps
    order, limit = np.argsort(gaps), 4 * EPS * knots[-1]
    if limit > EPS**0.5 * gaps.min(initial=np.inf):
        return gaps
    first = np.append(True, np.diff(gaps[order]) > limit)[: len(gaps)]
    which = np.empty(len(gaps), dtype=int)
    which[order] = np.cumsum(first) - 1
    means = np.bincount(which, gaps) / np.bincount(which)
    shared = means[which]
    return shared if np.abs(np.cumsum(shared - gaps)).max(initial=0.0) <= limit else gaps


def propagators(blocks: Sequence[np.ndarray], gaps: np.ndarray) -> np.ndarray:
    """e^{J h} for every gap h and every one of blocks of one size."""
    size = len(blocks[0])
    columns = [block_states(blocks, np.tile(unit, len(blocks)), gaps) for unit in np.eye(size)]
    return np.array(columns).reshape(size, len(blocks), size, len(gaps)).transpose(3, 1, 2, 0)


def _advance(blocks, states, at, gaps) -> None:
    """Advance in place the states at these places, shape (number of blocks, size)."""
    chunk = max(1, CHUNK_ENTRIES // (at.size * at.shape[1]))
    for begin in range(0, len(gaps), chunk):
        part = gaps[begin : begin + chunk]
        different, which = np.unique(part, return_inverse=True)
        steps, covered = propagators(blocks, different), 0
        finite = bool(np.isfinite(steps).all())
        if finite and len(part) >= FEW_STEPS:
            covered = _scanned(blocks, states, at, begin, part, steps, which)
        for k, step in enumerate(which[covered:], start=begin + covered):
            now = states[at, k]
            if finite:
                states[at, k + 1] += (steps[step] @ now[:, :, None])[:, :, 0]
            else:  # what is zero stays zero, however fast it would grow
                states[at, k + 1] += block_states(blocks, now.ravel(), gaps[k : k + 1]).reshape(at.shape)


def _scanned(blocks, states, at, begin, gaps, steps, which) -> int:
    """Advance whole groups of steps in place; return their number, zero where the exponential of a group leaves the range."""
    length = int(len(gaps) ** 0.5)
    groups = len(gaps) // length
    covered = groups * length
    durations = gaps[:covered].reshape(groups, length).sum(axis=1)
    across = propagators(blocks, durations)
    if not np.isfinite(across).all():
        return 0
    places = slice(begin + 1, begin + 1 + covered)
    gained = states[at, places].reshape(*at.shape, groups, length).transpose(1, 3, 0, 2).copy()  # (size, length, blocks, groups)
    if len(steps) == 1:
        factors = [steps[0].transpose(1, 2, 0)[..., None]] * length
    else:
        factors = [steps[step].transpose(2, 3, 1, 0) for step in which[:covered].reshape(groups, length).T]
    starts = _starts(states[at, begin], _from(np.zeros_like(gained[:, 0]), gained, factors), across)
    _from(starts, gained, factors, keep=True)
    states[at, places] = gained.transpose(2, 0, 3, 1).reshape(*at.shape, covered)
    return covered


def _starts(start, ends, across) -> np.ndarray:
    """z where each group begins, shape (size, blocks, groups)."""
    result, now = np.empty_like(ends), start
    for group, step in enumerate(across):
        result[:, :, group] = now.T
        now = (step @ now[:, :, None])[:, :, 0] + ends[:, :, group].T
    return result


def _from(now, gained, factors, keep: bool = False) -> np.ndarray:
    """Propagate all groups from their starts (size, blocks, groups) to their ends; intermediate states can replace the gains."""
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

    >>> states = np.array([[8.0], [1.0], [1.0]], dtype=complex)
    >>> scanned(states, np.array([[0.5 + 0j]]))
    >>> states.ravel().real.tolist()
    [8.0, 5.0, 3.5]
    """
    count, p = len(states) - 1, states.shape[1]
    length = max(1, int(count**0.5))
    groups, covered = count // length, count // length * length
    gained = states[1 : covered + 1].reshape(groups, length, p)
    each = factors[:covered].reshape(groups, length, p) if len(factors) > 1 else np.broadcast_to(factors, (1, length, p))
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
    for step in range(covered, count):
        states[step + 1] += factors[step % len(factors)] * states[step]


def powers(values: np.ndarray, count: int) -> np.ndarray:
    """1, x, x^2, ..., one row for each of values (T,), shape (T, count).

    >>> powers(np.array([2.0]), 5).tolist()
    [[1.0, 2.0, 4.0, 8.0, 16.0]]
    """
    result, done = np.empty((count, len(values))), 1
    result[0] = 1.0
    while done < count:
        some = min(done, count - done)
        np.multiply(result[:some], result[done - 1] * values, out=result[done : done + some])
        done += some
    return np.ascontiguousarray(result.T)


# The states of a decoupled real matrix as complex scalars z_k' = s_k z_k, one for each real zero or pair, and what is left.
#
# Of a block a I + R with R^2 = -w^2 I the first state and -1/w times the first row of R y make one complex number. Zeros that are
# together in a block and no conjugate pair are left as they are.


@dataclass(frozen=True, eq=False)
class ModalBasis:
    """w = basis y: (z, rest) from y and y from (z, rest), with z_k(t) = e^{s_k t} z_k(0) and rest' = diag(blocks) rest.

    Attributes:
        decoupled: basis and blocks.
        rates: s, of pairs above the real axis, shape (p,).
        single: the places in y of real zeros.
        first, frequency: the first places of pairs, and w.
        turn: (R_11, R_12) of the pairs, shape (pairs, 2).
        rest, blocks: the places in y of what is left, and its blocks.
    """

    decoupled: BlockDiagonal | ResidueModes
    rates: np.ndarray
    single: np.ndarray
    first: np.ndarray
    frequency: np.ndarray
    turn: np.ndarray
    rest: np.ndarray
    blocks: tuple[np.ndarray, ...]

    @staticmethod
    def of(decoupled: BlockDiagonal | ResidueModes) -> ModalBasis:
        """The modal basis of a decoupled matrix.

        >>> from mbconstrained.linalg.blocks import block_diagonalize
        >>> modes = ModalBasis.of(block_diagonalize(np.array([[0.0, 2.0], [-2.0, 0.0]])))
        >>> modes.rates.tolist(), [part.tolist() for part in modes.split(np.array([3.0, 4.0]))]
        ([2j], [[(3-4j)], []])
        """
        groups = BlockGroups.of(decoupled.blocks)
        turning = np.flatnonzero(groups.square < 0)
        first, w = groups.first[turning], np.sqrt(-groups.square[turning])
        covered = {*groups.single.tolist(), *first.tolist()}
        left = [(block, at) for block, at in zip(decoupled.blocks, block_slices(decoupled.blocks)) if at.start not in covered]
        rest = np.concatenate([np.zeros(0, dtype=int), *(np.arange(at.start, at.stop) for _, at in left)])
        rates, blocks = np.concatenate([groups.rates, groups.mean[turning] + 1j * w]), tuple(block for block, _ in left)
        return ModalBasis(decoupled, rates, groups.single, first, w, groups.rest[turning, 0], rest, blocks)

    def split(self, coordinates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """z and the rest of y, of shape (n,) or (n, any)."""
        first, second = coordinates[self.first], coordinates[self.first + 1]
        turned = ((self.turn[:, 0] * first.T + self.turn[:, 1] * second.T) / self.frequency).T
        return np.concatenate([coordinates[self.single], first - 1j * turned]), coordinates[self.rest]

    def states(self, scalars: np.ndarray, rest: np.ndarray) -> np.ndarray:
        """w of z and the rest of y, shape (n,).

        Args:
            scalars: z, shape (p,).
            rest: the rest of y.

        Returns:
            Shape (n,).
        """
        single, pairs = np.split(scalars, [len(self.single)])
        y = np.empty(len(self.single) + 2 * len(self.first) + len(self.rest))
        y[self.single], y[self.first], y[self.rest] = single.real, pairs.real, rest
        y[self.first + 1] = -(self.frequency * pairs.imag + self.turn[:, 0] * pairs.real) / self.turn[:, 1]
        return self.decoupled.modal_output(eye_array(len(y), format="csr")) @ y

    def modal_output(self, output: Matrix, order: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """The derivative of this order of output @ w: factors of real and imaginary parts of z in turn, and of the rest of y.

        Args:
            output: shape (r, n).
            order: order of the derivative.

        Returns:
            Shapes (r, 2 p) and (r, rest).
        """
        result = self.decoupled.modal_output(output)
        second, (own, coupling) = result[:, self.first + 1], self.turn.T
        pairs = result[:, self.first] - second * (own / coupling) + 1j * (second * (self.frequency / coupling))
        scalars, rest = np.hstack([result[:, self.single], pairs]), result[:, self.rest]
        for _ in range(order):
            scalars, rest = scalars * self.rates, rest @ self._generator
        return np.ascontiguousarray(scalars.conj()).view(float), rest

    @cached_property
    def _generator(self) -> np.ndarray:
        return block_matrix(self.blocks)
