"""e^{J t} v for a block diagonal J at many times: pairs a +- i w, clusters of close or defective zeros, all blocks together."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import scipy

from ..ground.errors import IllConditioned
from ..ground.tolerances import CLUSTER_DEGREE, EPS, MODERATE_EXPONENT
from .blocks import CHUNK_ENTRIES, block_eigenvalues, block_slices

# e^{a t} cos w t and e^{a t} sin w t for many pairs a +- i w at many times, only the requested ones.
# For many even times they are computed from few: of t = T + tau, T on a coarse grid and tau on a fine one, by the sine and cosine of
# a sum, so that the square root of the number of times is all that is evaluated.

#: From this number of values on, those at even times are products of fewer, and decayed ones are left out; for few rows this many
#: less.
MANY, SEVERAL = 20_000, 1500

#: What is this part of something is far below its rounding. So many pairs, the slowest, are what others are compared with; they are
#: looked at so many rows at a time,and again in so many parts of the times.
NOTHING, SLOW, ROWS, PARTS = EPS / 256, 8, 32, 8

#: The number of values computed at once where they are multiplied right away; of many pairs so many that with the coefficients they
#: take three quarters of a matrix of all states.
AT_ONCE = 1 << 17


@dataclass(frozen=True, eq=False)
class Oscillations:
    """The functions e^{a t} cos w t of the pairs ``cosines`` and e^{a t} sin w t of the pairs ``sines``.

    Attributes:
        growth, frequency: a and w, shape (m,).
        cosines, sines: indices of pairs.
    """

    growth: np.ndarray
    frequency: np.ndarray
    cosines: np.ndarray
    sines: np.ndarray

    def __call__(self, times: np.ndarray) -> np.ndarray:
        """The cosines, below them the sines, shape (number of both, T); denormal numbers are replaced by zero."""
        step = even_step(times) if self.are_many(times) else None
        return self._each(times) if step is None else self._of_sums(times, *self._grids(times, step))

    def combined(self, coefficients: np.ndarray, times: np.ndarray, lasting: Lasting | None = None) -> np.ndarray:
        """coefficients @ self(times), shape (r, T), with no table of the functions at all times."""
        if not self.are_many(times):
            return coefficients @ self._each(times)
        step, room = even_step(times), max(AT_ONCE, 3 * len(self.growth) ** 2 - coefficients.size)
        coarse, fine = (None, np.empty(1)) if step is None else self._grids(times, step)
        result, size = np.empty((len(coefficients), len(times))), fine.shape[-1]
        width = max(1, room // max(1, coefficients.shape[1]))
        width = size * max(1, (width if lasting is None else min(width, len(times) // PARTS)) // size)
        for begin in range(0, len(times), width):
            place = slice(begin, begin + width)
            part, columns = self._remaining(coefficients, times[place], lasting)
            at = slice(begin // size, (begin + width) // size)
            table_of = part._each if step is None else partial(part._of_sums, coarse=coarse[..., at], fine=fine)
            np.matmul(
                columns, table_of(times[place]), out=result[:, place]
            )  # without a name a table is gone before the next is made
        return result

    def _remaining(self, coefficients, times, lasting) -> tuple[Oscillations, np.ndarray]:
        """The functions that have not decayed at these times, and their coefficients."""
        kept = None if lasting is None else lasting.at(times)
        if kept is None or kept.all():
            return self, coefficients
        cosines, sines = np.split(kept, [len(self.cosines)])
        return replace(self, cosines=self.cosines[cosines], sines=self.sines[sines]), coefficients[:, kept]

    def are_many(self, times: np.ndarray) -> bool:
        """Whether a table of all functions is large enough to consider alternatives."""
        return len(self.growth) * len(times) >= MANY

    def _grids(self, times, step) -> tuple[np.ndarray, np.ndarray]:
        """(cos; sin) of all pairs at coarse and at fine times, shape (m, 2, number of times)."""
        fine = int(len(times) ** 0.5)
        return self._both(times[::fine]), self._both(step * np.arange(fine))

    def _both(self, times) -> np.ndarray:
        """e^{a t} cos w t and e^{a t} sin w t of all pairs, shape (m, 2, T)."""
        turn, exponents = np.multiply.outer(self.frequency, times), np.multiply.outer(self.growth, times)
        result = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        result *= np.where(exponents < -MODERATE_EXPONENT, 0.0, np.exp(exponents))[:, None]
        return result

    def _each(self, times) -> np.ndarray:
        result, begin, last = np.empty((len(self.cosines) + len(self.sines), len(times))), 0, times.max(initial=0.0)
        for chosen, function in ((self.cosines, np.cos), (self.sines, np.sin)):
            if not len(chosen):
                continue
            part, growth = result[begin : begin + len(chosen)], self.growth[chosen]
            function(np.multiply.outer(self.frequency[chosen], times), out=part)
            if np.abs(growth).max() * last > EPS / 4:  # else e^{a t} is rounded to 1
                part *= np.exp(np.multiply.outer(growth, times))
            begin += len(chosen)
        return self._without_decayed(result, times)

    def _of_sums(self, times, coarse, fine) -> np.ndarray:
        """Values by small products: (cos T, -sin T) or (sin T, cos T), by (cos tau; sin tau)."""
        result, begin = np.empty((len(self.cosines) + len(self.sines), coarse.shape[2], fine.shape[2])), 0
        for chosen, part in (
            (self.cosines, np.stack([-coarse[:, 1], coarse[:, 0]], axis=1)[:, ::-1]),
            (self.sines, coarse[:, ::-1]),
        ):
            right = fine if np.array_equal(chosen, np.arange(len(fine))) else fine[chosen]
            np.matmul(part[chosen].transpose(0, 2, 1), right, out=result[begin : begin + len(chosen)])
            begin += len(chosen)
        return self._without_decayed(result.reshape(len(result), coarse.shape[2] * fine.shape[2])[:, : len(times)], times)

    def _without_decayed(self, result, times) -> np.ndarray:
        """The values with zeros in place of denormal numbers."""
        last = times.max(initial=0.0)
        if self.growth.min(initial=0.0) * last < -MODERATE_EXPONENT:
            rates = np.concatenate([self.growth[self.cosines], self.growth[self.sines]])
            decayed = np.flatnonzero(rates * last < -MODERATE_EXPONENT)
            result[decayed] *= np.multiply.outer(rates[decayed], times) >= -MODERATE_EXPONENT
        return result


@dataclass(frozen=True, eq=False)
class Lasting:
    """Duration for which functions matter next to the slowest ones, until their decayed values add no digit.

    Attributes:
        rates: a of each function, shape (k,).
        logarithms: logarithms of its largest coefficient in any row relative to that of the slowest ones, times k / NOTHING.
        slowest: the smallest a of these.
        since: a time by which all of them have turned by a radian: from then on their rounding is that of their size.
    """

    rates: np.ndarray
    logarithms: np.ndarray
    slowest: float
    since: float

    @staticmethod
    def of(functions: Oscillations, coefficients: np.ndarray) -> Lasting | None:
        """The durations; None where nothing decays."""
        if not (functions.growth < 0).any() or not coefficients.size:
            return None
        pairs = np.concatenate([functions.cosines, functions.sines])
        slow = np.argsort(-functions.growth, kind="stable")[: max(1, min(SLOW, len(functions.growth) // 4))]
        chosen, ratios = np.isin(pairs, slow), np.zeros(len(pairs))
        with np.errstate(divide="ignore", invalid="ignore"):
            for begin in range(0, len(coefficients), ROWS):
                size = np.abs(coefficients[begin : begin + ROWS])
                size /= size[:, chosen].max(axis=1, initial=0.0)[:, None]  # infinite in rows without slow ones
                ratios = np.fmax(ratios, np.fmax.reduce(size, axis=0))
            logarithms = np.log(ratios * (len(pairs) / NOTHING))
        since = 1 / functions.frequency[slow].min()
        return Lasting(functions.growth[pairs], logarithms, float(functions.growth[slow].min()), float(since))

    def at(self, times: np.ndarray) -> np.ndarray | None:
        """Which functions matter within these times, None for all: the others together are less than NOTHING of the slow ones."""
        first, last = times.min(), times.max()
        if first < self.since:
            return None
        largest = np.maximum(self.rates * first, self.rates * last)
        return self.logarithms + largest > min(self.slowest * first, self.slowest * last)


def step_of_few_rows(rows: int, pairs: int, times: np.ndarray) -> float | None:
    """h where times are even and a table of all functions at all of them is more than ``of_phasors`` needs, else None."""
    return even_step(times) if rows**2 <= len(times) and 2 * pairs * len(times) >= SEVERAL else None


def of_phasors(phasors: np.ndarray, rates: np.ndarray, times: np.ndarray, step: float) -> np.ndarray:
    """The real part of the sum of conj(z) e^{s t}, that is of e^{a t} (c cos w t + d sin w t) for z = c + i d, s = a + i w.

    At even times t = T + tau: z e^{conj(s) T} is made for the coarse ones, and one real product takes them all to the fine ones.
    """
    fine, decays = int(len(times) ** 0.5), rates.real.min(initial=0.0) * times[-1] < -MODERATE_EXPONENT
    coarse = np.multiply(phasors[:, None], _exponentials(rates.conj(), times[::fine], decays), order="C")
    table = _exponentials(rates, step * np.arange(fine), decays)
    result = coarse.view(float).reshape(-1, 2 * len(rates)) @ table.view(float).T
    return np.ascontiguousarray(result.reshape(len(phasors), coarse.shape[1] * fine)[:, : len(times)])


def _exponentials(rates: np.ndarray, times: np.ndarray, decays: bool) -> np.ndarray:
    """e^{s t}, shape (T, m), with denormal numbers of decayed ones replaced by zero."""
    exponents = np.multiply.outer(times, rates)
    result = np.exp(exponents)
    if decays:
        result[exponents.real < -MODERATE_EXPONENT] = 0.0
    return result


def even_step(times: np.ndarray) -> float | None:
    """h where times are t0, t0 + h, t0 + 2 h, ... to rounding, else None."""
    if len(times) < 2:
        return None
    step = float(times[-1] - times[0]) / (len(times) - 1)
    deviation = np.abs(times - (times[0] + step * np.arange(len(times)))).max()
    return step if step > 0 and deviation <= 4 * EPS * times[-1] else None


# e^{J t} v for blocks J of one size, each a cluster of close or defective eigenvalues, all at once.
# Each is shifted by the mean of its zeros, which leaves a small, nearly nilpotent rest whose Taylor series ends quickly; what is left
# of its size is halved away and squared back (Moler and Van Loan 2003, method 3). At 1000 times a block of size four takes 4 ms,
# with SciPy's exponential 500 ms, which also loses digits on triangular matrices with close diagonal entries.

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


# e^{J t} v for a block diagonal J at many times, without stepping from one time to the next.
# Blocks of size one and two have a formula; larger ones are the clusters above.

#: Clusters are taken together in arrays of at most so many states.
CLUSTERED_AT_ONCE = 1 << 17


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


def block_states(blocks: Sequence[np.ndarray] | BlockGroups, start: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The states e^{J t} v, shape (n, T), for J = diag(blocks) and times (T,)."""
    groups = blocks if isinstance(blocks, BlockGroups) else BlockGroups.of(blocks)
    states = np.empty((len(start), len(times)))
    start = start[:, None] if start.ndim == 1 else start
    if groups.single.size:
        states[groups.single] = _scaled(start[groups.single], np.multiply.outer(groups.rates, times))
    with np.errstate(over="ignore"):
        oscillating = (groups.square < 0) & (groups.mean * times.max(initial=0.0) < MODERATE_EXPONENT)
    drifting = (groups.square == 0) & (groups.mean == 0)  # pairs of zeros at 0: v + R v t
    for kind in (oscillating, drifting):
        if not len(chosen := kind.nonzero()[0]):
            continue
        at, w, even, odd = groups.first[chosen], np.ones(len(chosen)), np.ones(()), times
        if kind is oscillating:
            w, every = np.sqrt(-groups.square[chosen]), np.arange(len(chosen))
            even, odd = np.split(Oscillations(groups.mean[chosen], w, every, every)(times), 2)
        for row in (0, 1):
            factors = groups.rest[chosen, row] / w[:, None]
            turned = factors[:, 0, None] * start[at] + factors[:, 1, None] * start[at + 1]
            states[at + row] = start[at + row] * even + turned * odd
    if not (oscillating | drifting).all():
        _any_pairs(groups, np.flatnonzero(~oscillating & ~drifting), start, times, states)
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
        width = max(1, CLUSTERED_AT_ONCE // max(size * len(when), 1))
        for begin in range(0, len(same) if len(when) else 0, width):
            at = same[begin : begin + width]
            places = at[:, None, None], np.arange(size)[:, None], when
            states[places] = cluster_states(blocks[at], start[places], times[when])
    return states


def _any_pairs(groups: BlockGroups, chosen, start, times, states) -> None:
    """Pairs of two real zeros, of one that is double, or out of range."""
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
