"""e^{J t} v for blocks J of one size, each a cluster of close or defective eigenvalues, all at once.

Each is shifted by the mean of its zeros, which leaves a small, nearly nilpotent rest whose Taylor series ends quickly; what is left
of its size is halved away and squared back (Moler and Van Loan 2003, method 3). At 1000 times a block of size four takes 4 ms,
with SciPy's exponential 500 ms, which also loses digits on triangular matrices with close diagonal entries.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import scipy.linalg

from ...ground.errors import IllConditioned
from ...ground.tolerances import CLUSTER_DEGREE, MODERATE_EXPONENT
from ..blocks import CHUNK_ENTRIES, block_eigenvalues

#: Up to so many doublings the Taylor polynomial is applied to the vectors, 2^doublings times; beyond that it is
#: cheaper to square the matrices.
APPLIED_DOUBLINGS = 4

#: Units of states down to this leave room for the states themselves in the range of float64.
LEAST_UNIT = 2.0**-500

#: Where no such unit is left a coupling may be so many times larger than the zeros: ten more doublings.
LARGEST_COUPLING = 1024.0

RATES_TOO_DIFFERENT = (
    "the force or the motion changes within times too short relative to the others, by more than 150 powers of ten, for float64 to "
    "follow both; check the units of time, or leave out samples that lie that close"
)


def cluster_states(blocks, start, times) -> np.ndarray:
    """e^{J t} v for blocks (k, n, n), v (k, n, T) and times (T,), shape (k, n, T).

    Shifted by the middle of its zeros; where these have turned about it by then, the two halves each by their own middle.
    Before that the halves are large and cancel: zeros a +- i w with a chain between them have not separated at w t < 1.
    """
    speeds = _speeds(blocks)
    speeds[speeds * times.max() <= 1.0] = 0.0
    if not speeds.any():
        return _whole_states(blocks, start, times)
    states = np.empty(start.shape)
    for at in equal_groups(np.frexp(speeds)[1], speeds > 0):
        turned = speeds[at].min() * times > 1.0
        for halved in {*turned.tolist()}:
            when = np.flatnonzero(turned == halved)
            places = at[:, None, None], np.arange(start.shape[1])[:, None], when
            states[places] = (_halved_states if halved else _whole_states)(blocks[at], start[places], times[when])
    return states


def equal_groups(*keys: Iterable) -> list[np.ndarray]:
    """The indices of equal keys, in ascending order for each.

    >>> [places.tolist() for places in equal_groups([1, 2, 1], [True, True, True])]
    [[0, 2], [1]]
    """
    result: dict[tuple, list[int]] = {}
    for place, key in enumerate(zip(*keys)):
        result.setdefault(key, []).append(place)
    return [np.array(places) for places in result.values()]


def _speeds(blocks) -> np.ndarray:
    """The middle of the zeros above the real axis where these are well separated from their conjugates, its imaginary part;
    elsewhere 0."""
    count, size = blocks.shape[:2]
    if size % 2:
        return np.zeros(count)
    values = block_eigenvalues(blocks)
    above = values.imag > 0
    middle = np.where(above, values, 0.0).sum(axis=1) * 2 / size
    spread = np.where(above, np.abs(values - middle[:, None]), 0.0).max(axis=1)
    separated = (2 * above.sum(axis=1) == size) & (values.imag.min(axis=1, where=above, initial=np.inf) > 2 * spread)
    return np.where(separated, middle.imag, 0.0)


def _centred(blocks) -> tuple[np.ndarray, np.ndarray]:
    """Blocks without the mean of their zeros, and this mean, shape (k,)."""
    size = blocks.shape[1]
    shift = np.trace(blocks, axis1=1, axis2=2) / size
    return blocks - shift[:, None, None] * np.eye(size), shift


def _whole_states(blocks, start, times) -> np.ndarray:
    return _shifted_states(*_centred(blocks), start, times)


def _halved_states(blocks, start, times) -> np.ndarray:
    """Twice the real part of the half above the real axis.

    A real block with the zeros near a + i w and near a - i w would be shifted by a alone, leaving a large
    rotation w; the part above the axis can be shifted by a + i w, and the other half is its conjugate.
    """
    basis, triangles, rows = map(np.array, zip(*map(_upper_half, blocks)))
    rest, middle = _centred(triangles)
    are_pairs = rest.shape[1] == 2 and np.abs(_root(rest).real).max() * times.max() < MODERATE_EXPONENT
    return 2 * (basis @ (_pair_states if are_pairs else _shifted_states)(rest, middle, rows @ start, times)).real


def _root(rest) -> np.ndarray:
    """d with rest^2 = d^2 I for matrices of size two without trace."""
    return np.sqrt(rest[:, 0, 0] ** 2 + rest[:, 0, 1] * rest[:, 1, 0])


def _pair_states(rest, shift, start, times) -> np.ndarray:
    """e^{(rest + shift) t} start for two complex zeros: rest^2 = d^2 I, a motion and a force near resonance."""
    turned = np.multiply.outer(_root(rest), times)[:, None]
    safe = np.where(turned == 0, 1.0, turned)
    odd = np.where(turned == 0, 1.0, np.sinh(safe) / safe) * times
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):  # the caller sees and reports what is not finite
        return (start * np.cosh(turned) + (rest @ start) * odd) * np.exp(np.multiply.outer(shift, times))[:, None]


def _upper_half(block):
    """The invariant part of the zeros above the real axis: its basis, its matrix, and the rows that give its coordinates."""
    even, odd = slice(0, None, 2), slice(1, None, 2)
    if np.array_equal(block[even, even], block[odd, odd]) and np.array_equal(block[even, odd], -block[odd, even]):
        half = np.kron(np.eye(len(block) // 2), [[1.0], [1j]])  # pairs [[a, b], [-b, a]] coupled alike: small couplings stay exact
        return half, block[even, even] + 1j * block[even, odd], half.conj().T / 2
    triangle, basis, count = scipy.linalg.schur(block, output="complex", sort=lambda value: value.imag > 0)
    top, corner, bottom = triangle[:count, :count], triangle[:count, count:], triangle[count:, count:]
    coupling = scipy.linalg.solve_sylvester(top, -bottom, -corner)
    adjoint = basis.conj().T
    return basis[:, :count], top, adjoint[:count] - coupling @ adjoint[count:]


def _shifted_states(rest, shift, start, times) -> np.ndarray:
    """e^{(rest + shift) t} start for every t, by Taylor series of the rest and doubling, as often as each t requires."""
    ends = (shift == 0) & ~np.tril(rest).any(axis=(1, 2))
    if ends.all():  # a polynomial in t, which ends by itself
        return _applied(rest, shift, start, times, start.shape[1] - 1)
    units = _units(rest, times)
    rest, start = rest * units[:, None] / units[..., None], start / units[..., None]
    states = np.empty(start.shape, dtype=np.result_type(rest, start))
    norm = np.abs(rest).sum(axis=1).max(axis=1)
    with np.errstate(over="ignore"):
        if not np.isfinite(norm * times.max(initial=0.0)).all():
            raise IllConditioned(RATES_TOO_DIFFERENT)
    for at in equal_groups(ends, np.frexp(norm)[1]):  # those of about one size are doubled together
        if ends[at[0]]:
            states[at] = _applied(rest[at], shift[at], start[at], times, start.shape[1] - 1)
        else:
            states[at] = _doubled(rest[at], shift[at], start[at], times, norm[at].max())
    return states * units[..., None]


def _doubled(rest, shift, start, times, norm) -> np.ndarray:
    """The states where all norms of the rest are at most this one."""
    states = np.empty(start.shape, dtype=np.result_type(rest, start))
    doublings = np.ceil(np.log2(np.maximum(norm * times, 1.0))).astype(int)
    for count in np.flatnonzero(np.bincount(doublings)).tolist():
        at = np.flatnonzero(doublings == count)
        part, step = start[..., at], times[at] / 2.0**count
        if count <= APPLIED_DOUBLINGS:
            for _ in range(2**count):
                part = _applied(rest, shift, part, step, CLUSTER_DEGREE + start.shape[1] - 1)
        else:
            part = _squared(rest, shift, part, step, count)
        states[..., at] = part
    return states


def _units(rest, times) -> np.ndarray:
    """Powers of two for the states of quasi-triangular matrices in which no coupling is larger than the zeros, shape (k, n).

    A coupling that is, such as that of a slow decay with the fast unit of time that it came with, would have the
    exponential doubled more often than anything moves, and each doubling doubles the rounding errors too.
    """
    units, sizes, latest = np.ones(rest.shape[:2]), np.abs(rest), times.max(initial=0.0)
    if not latest:
        return units
    target = np.maximum(np.abs(block_eigenvalues(rest)).max(axis=1), 1 / latest)
    if (np.triu(sizes, 1).max(axis=(1, 2)) <= target).all():  # mostly
        return units
    for at in range(1, rest.shape[1]):
        above, pair = sizes[:, :at, at].copy(), rest[:, at, at - 1] != 0
        if pair.any():  # its two states have one unit
            above[pair, at - 1] = 0.0
            above[pair, : at - 1] = np.maximum(above[pair, : at - 1], sizes[pair, : at - 1, at - 1])
        with np.errstate(over="ignore"):
            coupling = (above / units[:, :at]).max(axis=1)
        large = coupling > target
        if large.any():
            # The end of a long chain keeps a coupling of its own size.
            needed = np.maximum(target[large] / coupling[large], LEAST_UNIT)
            if (coupling[large] * needed > LARGEST_COUPLING * target[large]).any():
                raise IllConditioned(RATES_TOO_DIFFERENT)
            units[large, at] = 2.0 ** np.floor(np.log2(needed))
            units[large & pair, at - 1] = units[large & pair, at]
    return units


def _applied(rest, shift, start, times, degree) -> np.ndarray:
    """The Taylor polynomial of e^{rest t}, applied to the vectors, and e^{shift t}."""
    total = np.array(start, dtype=np.result_type(rest, start), order="C")
    term = total
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):  # the caller sees and reports what is not finite
        for power in range(1, degree + 1):
            term = rest @ term
            term *= times / power
            total += term
        total *= np.exp(np.multiply.outer(shift, times))[:, None]
    return total


def _squared(rest, shift, start, steps, doublings) -> np.ndarray:
    """States by matrices squared the given number of times, from times / 2^doublings."""
    states, (count, size, _) = np.empty(start.shape, dtype=np.result_type(rest, start)), rest.shape
    chunk = max(1, CHUNK_ENTRIES // (count * size**2))
    for begin in range(0, len(steps), chunk):
        part = slice(begin, begin + chunk)
        matrices = _taylor_exponential(rest, shift, steps[part], doublings)
        states[..., part] = np.einsum("btij,bjt->bit", matrices, start[..., part])
    return states


def _taylor_exponential(rest, shift, times, doublings) -> np.ndarray:
    """e^{(rest + shift) t 2^doublings}, shape (k, T, n, n), with the shift before the squaring, so that a decay keeps it in range.

    A chain of n states needs n - 1 powers to be there at all: the degree grows with the size.
    """
    steps, size = rest[:, None] * times[:, None, None], rest.shape[1]
    identity, degree = np.eye(size), CLUSTER_DEGREE + size - 1
    total = identity + steps / degree
    for power in range(degree - 1, 0, -1):
        total = identity + steps @ total / power
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):  # the caller sees and reports what is not finite
        total = total * np.exp(np.multiply.outer(shift, times))[..., None, None]
        for _ in range(doublings):
            total = total @ total
    return total
