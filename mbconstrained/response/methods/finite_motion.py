"""The finite part of A(s), decoupled and driven by a force: x(t) for t > 0 as a Bohl function.

In block diagonal coordinates y_b' = T_b y_b + sum over k of D_bk w_k and w_k' = J_k w_k for the parts k of the force. With
T_b X - X J_k = -D_bk the motion that w_k causes is X w_k and a free one. Where X is large, eigenvalues close to those of the force,
y_b and a copy of w_k are evaluated together from rest instead. So a force that has ended is over exactly, and a short pulse on a
free body keeps its digits for ever. Where a force begins after t = 0, all of them are evaluated so in its first moments.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...linalg.arrays import lapack
from ...linalg.blocks import BlockDiagonal, block_slices
from ...linalg.exponential import block_states
from ...linalg.recursion import advance, shared_gaps
from ...signals.bohl import BohlFunction, FreeRestarts
from ...signals.impulsive import ImpulsiveSmooth
from ..problem import Driven, power_of_two_of

#: An eigenvalue of A(s) and one of the force are separated where their distance is at least this part of the largest rate: their
#: motions cancel each other at first, and only as long as nothing else has moved much the Taylor series takes their place. With
#: very many pieces the digits that this costs add up.
SEPARATION, SEPARATION_OF_PIECES = 32.0, 8.0

#: Gaps between fewer knots than these are not made equal: that is not worth the rounding errors of the knots.
FEW_KNOTS = 64

#: The length of the first moments of a force that begins after t = 0, times the largest rate.
EARLY = 2.0

#: So many equations of a block and a part of the force are solved as one linear system.
FEW_EQUATIONS = 8

#: Gaps between knots are few where there are so many times more of them than lengths of them and states of the force.
FEW_GAPS = 4


@dataclass(frozen=True, eq=False)
class _Coupled:
    """A block of the finite part driven by a part of the force that cannot be separated from it.

    Attributes:
        own, of_force: which states of both.
        block: [[T_b, D_bk / unit], [0, J_k]].
        unit: unit of y_b, so that D_bk has the size of the eigenvalues and the block no larger norm than these.
    """

    own: slice
    of_force: slice
    block: np.ndarray
    unit: float

    def start(self, inputs: np.ndarray) -> np.ndarray:
        """The start from rest, for states (m, K) of the force."""
        return np.vstack([np.zeros((self.own.stop - self.own.start, inputs.shape[1])), inputs[self.of_force]])


@dataclass(frozen=True, eq=False)
class FinitePart:
    """The finite part of A(s) decoupled, its excitation, and its states at and after t = 0.

    Attributes:
        free: the decoupled blocks.
        output: x from the states before they were decoupled, shape (r, n), dense or sparse.
        driven: the effect of the force on them and on x.
        start: the states at 0+, shape (n,).
        jumps: jumps of the states at the later knots of the force, shape (n, K).
        time, columns: the units of time and of x.
    """

    free: BlockDiagonal
    output: np.ndarray
    driven: Driven
    start: np.ndarray
    jumps: np.ndarray
    time: float
    columns: np.ndarray


@dataclass(frozen=True, eq=False)
class _Forced:
    """The states that a force drives: -X w in y, w, a copy of w for X w where that is zero at times, and coupled pairs.

    Attributes:
        X: zero for pairs that are never separated, shape (n, m).
        coupled: coupled pairs.
        separated: the pairs that are coupled in the first moments of the force only; none where there are no such moments.
    """

    X: np.ndarray
    coupled: tuple[_Coupled, ...]
    separated: tuple[_Coupled, ...]

    @staticmethod
    def of(X, coupled, separated, early, inputs) -> _Forced:
        """The states of the given pairs, with the pieces that belong to first moments and the states that begin them."""
        coupled, separated = ([_coupled(*pair) for pair in pairs] for pairs in (coupled, separated if early.any() else ()))
        if not early.any():
            return _Forced(X, tuple(coupled), ())
        if not inputs[:, ~early].any():
            return _Forced(np.zeros_like(X), (*coupled, *separated), ())
        return _Forced(X, tuple(coupled), tuple(separated))

    def blocks(self, driven: Driven, forcing) -> tuple[np.ndarray, ...]:
        """The blocks of all states after y."""
        own = tuple(driven.generator[of, of] for of in block_slices(forcing))
        return (*own, *(own if self.separated else ()), *(pair.block for pair in self._pairs))

    def copies(self, forcing) -> list[tuple[slice, slice]]:
        """Pairs of states: copies of states of the force, and the states that they copy."""
        n, m = self.X.shape
        copies = [(_moved(of, n + m), _moved(of, n)) for of in block_slices(forcing)] if self.separated else []
        begin = n + (2 * m if self.separated else m)
        for pair in self._pairs:
            begin += len(pair.block)
            copies.append((slice(begin - pair.of_force.stop + pair.of_force.start, begin), _moved(pair.of_force, n)))
        return copies

    def output(self, own: np.ndarray, through: np.ndarray) -> np.ndarray:
        """The output x of y and these states."""
        follows = own @ self.X
        columns = [through, follows] if self.separated else [through + follows]
        return np.hstack([own, *columns, *(_padded(pair.unit * own[:, pair.own], len(pair.block)) for pair in self._pairs)])

    def states(self, inputs: np.ndarray, early) -> np.ndarray:
        """y and these states from y = 0, for states (m, K) of the force, in its first moments or not (one or K truth values)."""
        late = inputs * ~np.asarray(early) if self.separated else inputs
        begun = [pair.start(inputs * np.asarray(early)) for pair in self.separated]
        copies = [inputs, late] if self.separated else [inputs]
        return np.vstack([-self.X @ late, *copies, *(pair.start(inputs) for pair in self.coupled), *begun])

    def finite_part(self, states: np.ndarray) -> np.ndarray:
        """y from y and these states."""
        n, m = self.X.shape
        begin = n + (2 * m if self.separated else m)
        y = states[:n] + self.X @ states[begin - m : begin]
        for pair in self._pairs:
            size = pair.own.stop - pair.own.start
            y[pair.own] += pair.unit * states[begin : begin + size]
            begin += len(pair.block)
        return y

    @property
    def _pairs(self) -> tuple[_Coupled, ...]:
        return self.coupled + self.separated


def driven_motion(
    part: FinitePart, force: ImpulsiveSmooth, *, first: bool = True
) -> tuple[BohlFunction, float, list[tuple[slice, slice]]]:
    """x(t) for t > 0 in the user's units, the largest entry of the transformations that decouple it, and the copies among its states."""
    free, driven, n, time, rate = part.free, part.driven, len(part.start), part.time, _rate(part.free, part.driven)
    forcing, count = force.smooth.blocks, len(force.knots)
    X, coupled, separated = _separated(free, driven, forcing, max(SEPARATION_OF_PIECES, SEPARATION / count) / rate)
    knots, early = first_moments(force.smooth, force.knots, EARLY / (rate * time) if separated and first else 0.0)
    restarts = force.smooth.with_knots(knots).restarts
    inputs = restarts.states / driven.units[:, None]
    forced = _Forced.of(X, coupled, separated, early, inputs)
    blocks = (*free.blocks, *forced.blocks(driven, forcing))
    states = forced.states(inputs, early)
    if count == 1:
        states[:n, 0] += free.inverse @ part.start
    else:
        jumps = np.zeros((n, len(knots) - 1))
        jumps[:, np.searchsorted(knots, force.knots[1:]) - 1] = part.jumps
        part = replace(part, jumps=jumps)
        gaps = restarts.gaps if count < FEW_KNOTS else shared_gaps(knots, restarts.gaps)
        states[:n] += _own_states(part, blocks, inputs, time * gaps, forced, early)
    scaled = tuple(time * block for block in blocks)
    function = BohlFunction(
        part.columns[:, None] * forced.output(part.output @ free.basis, driven.through),
        scaled,
        states[:, 0] if count == 1 else FreeRestarts(knots, states, restarts.remainders, scaled),
    )
    return function, max(free.coupling, float(np.abs(X).max(initial=0.0))), forced.copies(forcing)


def _rate(free: BlockDiagonal, driven: Driven) -> float:
    """The largest rate of the motion and of the force, 1 where there is none."""
    return max((float(np.abs(block).max()) for block in (*free.blocks, driven.generator) if block.any()), default=1.0)


def _separated(free: BlockDiagonal, driven: Driven, forcing, limit) -> tuple[np.ndarray, list[tuple], list[tuple]]:
    """X, zero where a block and a part of the force cannot be separated, those pairs, and those that are separated, as arguments of ``_coupled``."""
    excitation, generator = free.inverse @ driven.excitation, driven.generator
    X, coupled, separated = np.zeros_like(excitation), [], []
    outer = block_slices(forcing)
    starts = [of.start for of in outer]
    for own, T in zip(block_slices(free.blocks), free.blocks):
        if len(outer) > 1:  # all at once, where that is possible
            solution = _at_once(T, outer, generator, excitation[own])
            largest, given = (np.maximum.reduceat(np.abs(part).max(axis=0), starts) for part in (solution, excitation[own]))
            if (largest <= limit * given).all():
                X[own] = solution
                separated += [(own, of, T, excitation[own, of], generator[of, of]) for of, size in zip(outer, given) if size]
                continue
        for of in outer:
            D, J = excitation[own, of], generator[of, of]
            if D.any():
                solution, scale, info = lapack.dtrsyl(T, J, -D, isgn=-1)
                separable = info == 0 and np.abs(solution).max() <= limit * scale * np.abs(D).max()
                if separable:
                    X[own, of] = solution / scale
                (separated if separable else coupled).append((own, of, T, D, J))
    return X, coupled, separated


def _at_once(T: np.ndarray, outer: list[slice], generator: np.ndarray, D: np.ndarray) -> np.ndarray:
    """X of T X - X J = -D for all blocks of J, at these places, not finite where that is singular: small blocks as one stack of linear systems for each size."""
    n, sizes = len(T), {of.stop - of.start for of in outer}
    if n * max(sizes) > FEW_EQUATIONS:
        solution, scale, info = lapack.dtrsyl(T, generator, -D, isgn=-1)
        return solution if info == 0 and scale == 1 else np.full(D.shape, np.inf)
    X = np.empty(D.shape)
    for size in sizes:
        at = np.array([range(of.start, of.stop) for of in outer if of.stop - of.start == size])
        J = generator[at[:, None, :], at[:, :, None]]  # transposed
        system = np.eye(size)[:, None, :, None] * T[:, None, :] - J[:, :, None, :, None] * np.eye(n)[:, None, :]
        right = -D[:, at].transpose(1, 2, 0).reshape(len(at), size * n, 1)
        try:
            solution = np.linalg.solve(system.reshape(len(at), size * n, size * n), right)
        except np.linalg.LinAlgError:
            return np.full(D.shape, np.inf)
        X[:, at] = solution.reshape(len(at), size, n).transpose(2, 0, 1)
    return X


def _coupled(own, of_force, T, D, J) -> _Coupled:
    unit = power_of_two_of(D) / power_of_two_of([np.abs(T).max(), np.abs(J).max()])
    joined, n = np.zeros((len(T) + len(J),) * 2), len(T)
    joined[:n, :n], joined[:n, n:], joined[n:, n:] = T, D / unit, J
    return _Coupled(own, of_force, joined, unit)


def _own_states(part: FinitePart, blocks, inputs, gaps, forced: _Forced, early) -> np.ndarray:
    """y in its block diagonal coordinates at every knot, shape (n, K + 1), for gaps (K,) and states (m, K + 1) of the force."""
    states = np.empty((len(part.start), len(gaps) + 1))
    states[:, 0] = part.free.inverse @ part.start
    with np.errstate(over="ignore", invalid="ignore"):  # reported when the function is evaluated
        if forced.separated:
            for flag in (True, False):
                at = np.flatnonzero(early[:-1] == flag)
                states[:, 1 + at] = _gains(blocks, inputs[:, at], gaps[at], forced, flag)
        else:
            states[:, 1:] = _gains(blocks, inputs[:, :-1], gaps, forced, False)
        jumping = np.flatnonzero(part.jumps.any(axis=0))
        states[:, 1 + jumping] += part.free.inverse @ part.jumps[:, jumping]
        advance(part.free.blocks, states, gaps)
    return states


def _gains(blocks, inputs, gaps, forced: _Forced, early: bool) -> np.ndarray:
    """y at the end of each gap from zero at its beginning, shape (n, K), for states (m, K) of the force there.

    Where few gaps differ, by the matrix that takes the states of the force to it.
    """
    (n, m), (different, which) = forced.X.shape, np.unique(gaps, return_inverse=True)
    if len(different) * m * FEW_GAPS < len(gaps):
        units = np.tile(forced.states(np.eye(m), early), len(different))
        gains = forced.finite_part(block_states(blocks, units, np.repeat(different, m))).reshape(n, len(different), m)
        if np.isfinite(gains).all():
            if len(different) == 1:
                return gains[:, 0] @ inputs
            gained = np.empty((n, len(gaps)))
            for gap in range(len(different)):
                gained[:, which == gap] = gains[:, gap] @ inputs[:, which == gap]
            return gained
    return forced.finite_part(block_states(blocks, forced.states(inputs, early), gaps))


def _moved(at: slice, by: int) -> slice:
    return slice(at.start + by, at.stop + by)


def _padded(columns, size) -> np.ndarray:
    return np.hstack([columns, np.zeros((len(columns), size - columns.shape[1]))])


# The first moments of a force that begins after t = 0. A mass on a soft spring moves by far less then than the force would deflect it
# at rest, and the difference of the two deflections has none of its digits: a short pulse and the first moments of a lasting force are
# evaluated from the state at their beginning instead. At t = 0 the Taylor series serves.

#: A force begins where it was zero before, or so many times smaller.
MUCH_SMALLER = 8.0


def first_moments(force: BohlFunction, knots: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Knots, including those at which the first moments end, and which of the pieces beginning there belong to them."""
    nothing = knots, np.zeros(len(knots), dtype=bool)
    if len(knots) == 1 or not 0 < reach < np.inf:
        return nothing
    reach = 2.0 ** np.floor(np.log2(reach))
    states = np.abs(force.with_knots(knots).restarts.states)
    places = [_beginnings(states[at].max(axis=0)) for at in block_slices(force.blocks)]
    begins = knots[np.unique(np.concatenate([np.zeros(0, dtype=int), *places]))]
    begins = begins[(begins > 0) | (knots[1] < reach)]
    if not len(begins):
        return nothing
    ends = begins + reach
    more = np.union1d(knots, ends[ends > begins])
    last = np.searchsorted(begins, more, side="right") - 1
    return more, (last >= 0) & (more < ends[last])


def _beginnings(sizes: np.ndarray) -> np.ndarray:
    """The places at which a piece begins.

    >>> _beginnings(np.array([0.0, 1.0, 2.0, 0.5, 40.0, 0.0, 0.0, 1e-3])).tolist()
    [1, 4, 7]
    """
    places, largest = [], 0.0
    for place, size in enumerate(sizes.tolist()):
        if size > MUCH_SMALLER * largest:
            places.append(place)
        largest = max(largest, size) if size else 0.0
    return np.array(places, dtype=int)
