"""Recursions from one time to the next with a block diagonal exponential, and powers of e^{S h} without decomposition."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, log2
from typing import TYPE_CHECKING

import numpy as np
import scipy

from ..ground.tolerances import EPS, EXPONENTIAL_PRODUCTS, NARROW_PRODUCT, NEGLIGIBLE_EXPONENTIAL, PADE_NORM
from .arrays import Matrix, entries, entry_count, filled, full, of_like_kind
from .blocks import CHUNK_ENTRIES, BlockDiagonal, block_matrix, block_slices
from .exponential import BlockGroups, block_states
from .scaling import balanced, balanced_norm, balancing_units

if TYPE_CHECKING:
    from .tree_modes import ResidueModes

# Linear recursions with a block diagonal exponential: from one time to the next, all blocks of a size at once.
# The steps are taken in groups, the same step of all groups at once (a scan in two passes, Blelloch 1990): first every group from
# rest, for what it gains; from one group to the next by the exponential of its whole duration; then every group again from its true
# start. So a record of ten thousand samples takes some hundred operations on long arrays.

#: Fewer steps are taken one by one.
FEW_STEPS = 64


def recursion(blocks: Sequence[np.ndarray], start: np.ndarray, gained: np.ndarray, gaps: np.ndarray) -> np.ndarray:
    """z_0 = start, z_(j+1) = e^{J h_j} z_j + g_j for J = diag(blocks), all z_j side by side, shape (n, K + 1)."""
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
    """z_(j+1) = factors_j z_j + g_j for complex scalars side by side, in place: states (K + 1, p) begin as z_0, g_0, g_1, ..."""
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
    """1, x, x^2, ..., one row for each of values (T,), shape (T, count)."""
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
        """The modal basis of a decoupled matrix."""
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
        """w of z and the rest of y, shape (n,)."""
        single, pairs = np.split(scalars, [len(self.single)])
        y = np.empty(len(self.single) + 2 * len(self.first) + len(self.rest))
        y[self.single], y[self.first], y[self.rest] = single.real, pairs.real, rest
        y[self.first + 1] = -(self.frequency * pairs.imag + self.turn[:, 0] * pairs.real) / self.turn[:, 1]
        return self.decoupled.modal_output(scipy.sparse.eye_array(len(y), format="csr")) @ y

    def modal_output(self, output: Matrix, order: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """The derivative of this order of output @ w: factors of real and imaginary parts of z in turn, and of the rest of y."""
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


# Values at even times by powers of e^{S h}, without decomposition: the cheapest method for one motion, free or under a record.
# e^{S h} is SciPy's (Al-Mohy and Higham 2009), S balanced before. Its power for w steps takes w states at once w steps further.
# Under a record z_(j+1) = E z_j + D v_j and L steps are taken at once: P z_(gL + i) = P E^i z_(gL) + P E^(i-1) D v_(gL) + ...
# + P D v_(gL + i - 1), the same matrix for every group of steps, so one product of matrices gives all of them; from one group to the
# next by E^L. Only rows of z that P uses are computed.

#: Number of states evaluated at once, in parts of their own number.
CHUNK = 512

#: Number of values of a record computed at once.
TOGETHER = 200_000

#: An entry of a sparse matrix in a product takes so many times as long as one of a full matrix.
SPARSE = 8


class Propagator:
    """e^{S k h} v for k = 0, 1, 2, ...

    Args:
        generator: S, shape (n, n), in 1/s, dense or sparse.
        step: h, in s.
    """

    def __init__(self, generator: Matrix, step: float):
        matrix, self._units = balanced(full(generator))
        matrix *= step
        self._has_tiny_entries = _smallest(matrix) < NEGLIGIBLE_EXPONENTIAL ** (2 / 3)
        self._step_matrix = self._without_remote(scipy.linalg.expm(matrix))

    @property
    def matrix(self) -> np.ndarray:
        """e^{S h}, shape (n, n)."""
        return self._units[:, None] * self._step_matrix / self._units

    def values(self, output: Matrix, start: np.ndarray, count: int) -> np.ndarray:
        """output @ e^{S k h} start for k = 0 ... count - 1."""
        states, rows, matrix = (
            (start.reshape(len(start), -1).T / self._units).T,
            of_like_kind(output * self._units, output),
            self._step_matrix,
        )
        starts, chosen = states.shape[1], _single_entries(rows)
        for _ in range(best_doublings(len(states), count, starts)):
            states, matrix = np.hstack([states, matrix @ states]), self._without_remote(matrix @ matrix)
        width, values = states.shape[1], np.empty((output.shape[0], count * starts))
        if chosen is not None:
            columns, factors = chosen
            for begin in range(0, values.shape[1], width):
                part = values[:, begin : begin + width]
                np.multiply(states[columns, : part.shape[1]], factors, out=part)
                states = matrix @ states
            return values.reshape(-1, count, starts) if start.ndim > 1 else values
        block = np.empty((len(states), width * max(1, min(CHUNK, count * starts) // width)))
        for begin in range(0, values.shape[1], block.shape[1]):
            for at in range(0, block.shape[1], width):
                block[:, at : at + width] = states
                states = matrix @ states
            part = values[:, begin : begin + block.shape[1]]
            part[...] = (rows @ block)[:, : part.shape[1]]
        return values.reshape(-1, count, starts) if start.ndim > 1 else values

    def _without_remote(self, matrix: np.ndarray) -> np.ndarray:
        """e^{S h} or a power of it without entries whose products are denormal numbers, which make products five times slower.

        Only long chains of couplings have such entries where no entry of S h is of their kind. What they add to a higher power comes by
        shorter steps too, and by them less than 2^-50 of it. The diagonal is kept.
        """
        if self._has_tiny_entries:
            return matrix
        size = np.abs(matrix)
        remote = size < NEGLIGIBLE_EXPONENTIAL * size.max(initial=0.0)
        remote.reshape(-1)[:: len(matrix) + 1] = False
        matrix[remote] = 0.0
        return matrix


#: Sparse models of more states are taken from step to step by the series of e^{S h}; measured on chains, fewer gain little.
SERIES_STATES = 400

#: A series is summed over no more than this angle: its largest term is the first one then, and nothing cancels.
LONGEST_SERIES = 1.0


class ExponentialSeries:
    """e^{S k h} v for k = 0 ... count - 1 of a sparse S, by products of S with vectors (Al-Mohy and Higham 2011).

    In the units that balance S each step sums e^{S h} z = z + S h (z + S h / 2 (z + ...)) by Horner's scheme. Vectors at few times are kept.

    Args:
        generator: S, shape (n, n), in 1/s, dense or sparse.
        step: h, in s.
        start: v, shape (n,).
        count: number of times.
    """

    def __init__(self, generator: Matrix, step: float, start: np.ndarray, count: int):
        self._units = units = balancing_units(generator)
        self._parts, self._terms = _series(balanced_norm(generator) * step)
        self._matrix = scipy.sparse.csr_array(of_like_kind(generator * units / units[:, None], generator)) * (step / self._parts)
        self._start, self._count = start / units, count

    def values(self, output: Matrix) -> np.ndarray:
        """output @ e^{S k h} v, shape (r, count)."""
        rows = scipy.sparse.csr_array(of_like_kind(output * self._units, output))
        values, begin = np.empty((output.shape[0], self._count)), 0
        for states in self._few if self._count <= CHUNK else self._states():
            values[:, begin : begin + states.shape[1]] = rows @ states
            begin += states.shape[1]
        return values

    @cached_property
    def _few(self) -> list[np.ndarray]:
        return list(self._states())

    def _states(self) -> Iterator[np.ndarray]:
        z = self._start
        for begin in range(0, self._count, CHUNK):
            states = np.empty((len(z), min(CHUNK, self._count - begin)))
            for k in range(states.shape[1]):
                states[:, k] = z
                for _ in range(self._parts):
                    total = z
                    for order in range(self._terms, 0, -1):
                        total = z + (self._matrix @ total) / order
                    z = total
            yield states


def _series(turned: float) -> tuple[int, int]:
    """Parts of a step with norm ``turned`` of S h, and terms of the series of each, the first neglected one below rounding errors."""
    parts = max(1, ceil(turned / LONGEST_SERIES))
    size, terms = turned / parts, 0
    term = size
    while term > EPS / 16:
        terms += 1
        term *= size / (terms + 1)
    return parts, max(terms, 1)


def cost_of_series(states: int, entry_count: int, count: int, turned: float) -> float:
    """Cost of values at this number of even times by series, in products of two matrices (n, n); infinite for few states."""
    if states <= SERIES_STATES or not np.isfinite(turned):
        return np.inf
    parts, terms = _series(turned)
    return count * parts * terms * SPARSE * (entry_count + states) / states**3


def _smallest(matrix: np.ndarray) -> float:
    """Modulus of the smallest nonzero entry; the largest number without any."""
    size = np.abs(matrix)
    return float(size.min(where=size > 0, initial=np.inf))


def _single_entries(output: Matrix) -> tuple[np.ndarray, np.ndarray] | None:
    """The column and the value of the only entry of each row, shapes (r,) and (r, 1); None where a row has more or none."""
    row, column, value = entries(output)
    if not np.array_equal(row, np.arange(output.shape[0])):
        return None
    return column, value[:, None]


def best_doublings(size: int, count: int, starts: int = 1) -> int:
    """The number of squarings of e^{S h} before its application to many states at once, for least work.

    >>> best_doublings(200, 1000), best_doublings(2000, 1000), best_doublings(2000, 1)
    (4, 1, 0)
    """
    most = ceil(log2(max(count, 1)))
    return min(range(1 + most), key=lambda doublings: _cost_of_use(size, count, doublings, starts))


def _cost_of_use(size: int, count: int, doublings: int, starts: int) -> float:
    width = starts * 2**doublings
    return doublings + count * starts / width * (width + NARROW_PRODUCT) / max(size, 1)


def cost_of_exponential(turned: float) -> float:
    """Cost of e^{S h}, |S| h = turned, in products of matrices of its size."""
    return EXPONENTIAL_PRODUCTS + max(0, ceil(log2(max(turned, PADE_NORM) / PADE_NORM)))


def cost_of_powers(size: int, count: int, turned: float) -> float:
    """Cost of values at this number of even times by powers of e^{S h}."""
    return cost_of_exponential(turned) + _cost_of_use(size, count, best_doublings(size, count), 1)


def values_of_steps(
    output: Matrix, step: np.ndarray, input_matrix: np.ndarray, start: np.ndarray, inputs: np.ndarray
) -> np.ndarray:
    """P z_0, ..., P z_K, shape (r, K + 1)."""
    used = np.flatnonzero(filled(output, 0))
    if SPARSE * entry_count(output) >= (output.shape[0] - len(used)) * len(start):
        return _values(full(output), step, input_matrix, start, inputs)
    return scipy.sparse.csr_array(output[:, used]) @ _values(np.eye(len(start))[used], step, input_matrix, start, inputs)


def best_length(rows: int, states: int, driven: int, count: int) -> int:
    """Number of simultaneous steps, a power of two: many require products of matrices beforehand, few leave many groups."""
    length = (NARROW_PRODUCT * states**2 * count / (rows * (states**2 + driven * count))) ** 0.5
    return 1 << max(0, round(np.log2(max(length, 1.0))))


def cost_of_steps(rows: int, states: int, driven: int, count: int) -> float:
    """Cost of all except the values themselves, in products of two matrices (n, n)."""
    length = best_length(rows, states, driven, count)
    alone = NARROW_PRODUCT * states**2 * count / length
    return (rows * length * (states**2 + driven * count) + alone) / states**3 + np.log2(length)


def _values(rows, step, input_matrix, start, inputs) -> np.ndarray:
    (m, count), r = inputs.shape, len(rows)
    length = best_length(r, len(start), m, count)
    outputs, gained, across = _powers(rows, step, input_matrix, length)
    groups = count // length + 1
    given = np.zeros((groups * length, m))
    given[:count] = inputs.T
    given = given.reshape(groups, length * m)
    begins = _begins(across, start, given @ gained.T)
    table = _table(outputs, input_matrix)
    result = np.empty((r, groups, length))
    width = max(1, TOGETHER // (r * length))
    for begin in range(0, groups, width):
        at = slice(begin, begin + width)
        part = np.hstack([begins[at], given[at]]) @ table
        result[:, at] = part.reshape(-1, r, length).transpose(1, 0, 2)
    return result.reshape(r, -1)[:, : count + 1]


def _powers(rows, step, input_matrix, length) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """P E^i for i < L, shape (L, r, n); (E^(L-1) D, ..., D) side by side, shape (n, L m); E^L."""
    outputs, gained, across = rows[None], input_matrix, step
    while len(outputs) < length:
        outputs = np.concatenate([outputs, (outputs.reshape(-1, len(step)) @ across).reshape(outputs.shape)])
        gained = np.hstack([across @ gained, gained])
        across = across @ across
    return outputs, gained, across


def _begins(across, start, gained) -> np.ndarray:
    """The states with which groups begin, one below the other."""
    result = np.empty((len(gained), len(start)))
    now = start
    for begins, more in zip(result, gained):
        begins[:] = now
        now = across @ now
        now += more
    return result


def _table(outputs, input_matrix) -> np.ndarray:
    """Matrix from states and inputs of a group to its values, shape (n + L m, r L)."""
    (length, r, n), m = outputs.shape, input_matrix.shape[1]
    table, driven = np.zeros((n + length * m, r, length)), (outputs @ input_matrix).transpose(2, 1, 0)
    table[:n] = outputs.transpose(2, 1, 0)
    for at in range(length - 1):
        table[n + at * m : n + (at + 1) * m, :, at + 1 :] = driven[:, :, : length - 1 - at]
    return table.reshape(len(table), -1)
