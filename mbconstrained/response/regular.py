"""The regular part: x(t) for t > 0 as a Bohl function, from a new start wherever the force starts, stops or changes.

In block diagonal coordinates of the finite part, y_b' = T_b y_b + sum over k of D_bk w_k and w_k' = J_k w_k for the parts
k of the force. With T_b X - X J_k = -D_bk the motion that w_k causes is X w_k and a free one. Where X is large, zeros
close to those of the force, y_b and a copy of w_k are evaluated together from rest instead. So a force that has ended
is over exactly, and a short pulse on a free body keeps its digits for ever. Where a force begins later, all of them are for its
first moments (``response.beginnings``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import lapack

from ..jordan.weierstrass import WeierstrassForm
from ..linalg.blocks import BlockDiagonal, block_diagonalize, block_slices
from ..linalg.exponential import block_states
from ..linalg.recursion import advance, shared_gaps
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.restarts import FreeRestarts
from .beginnings import first_moments
from .driven import Driven, driven_form
from .events import Kicks
from .forcing import power_of_two_of
from .parts import Start

#: A zero of A(s) and one of the force are separated where their distance is at least this part of the largest rate: the two
#: motions that are told apart cancel until they have come apart, and only so long as nothing else has moved much the Taylor
#: series takes their place. With very many pieces the digits that it costs add up.
SEPARATION, SEPARATION_OF_PIECES = 32.0, 8.0

#: Gaps between fewer knots than these are not made equal: it is not worth what rounding moves the knots by.
FEW_KNOTS = 64

#: How long the first moments of a force that begins after t = 0 are, times the largest rate.
EARLY = 2.0

#: Gaps between knots are few where there are so many times more of them than lengths of them and states of the force.
FEW_GAPS = 4


@dataclass(frozen=True)
class Coupled:
    """A block of the finite part driven by a part of the force that cannot be separated from it.

    Attributes:
        own, of_force: which states of both.
        block: [[T_b, D_bk / unit], [0, J_k]].
        unit: what y_b is measured in, so that D_bk has the size of the zeros: what it drives grows no faster.
    """

    own: slice
    of_force: slice
    block: np.ndarray
    unit: float

    def start(self, inputs: np.ndarray) -> np.ndarray:
        """From rest, for states (m, K) of the force."""
        return np.vstack([np.zeros((self.own.stop - self.own.start, inputs.shape[1])), inputs[self.of_force]])


@dataclass(frozen=True)
class FinitePart:
    """The finite part of A(s) decoupled, what drives it, and what its states are at and after t = 0.

    Attributes:
        free: the decoupled blocks.
        output: x from the states before they were decoupled, shape (r, n), dense or sparse.
        driven: what the force does to them and to x.
        start: the states at 0+, shape (n,).
        kicks: what they gain at the later knots of the force, shape (n, K).
        time, columns: the units of time and of x.
    """

    free: BlockDiagonal
    output: np.ndarray
    driven: Driven
    start: np.ndarray
    kicks: np.ndarray
    time: float
    columns: np.ndarray


@dataclass(frozen=True)
class Forced:
    """The states that a force drives: -X w in y, w, a copy of w for X w if that is not always there, and coupled pairs.

    Attributes:
        X: zero for pairs that are never separated, shape (n, m).
        coupled: those pairs.
        apart: those that are separated but in the first moments of the force; none where there are no such moments.
    """

    X: np.ndarray
    coupled: tuple[Coupled, ...]
    apart: tuple[Coupled, ...]

    @staticmethod
    def of(X, coupled, apart, early, inputs) -> Forced:
        """With those that are separated, as the pieces need it that belong to first moments or not, and the states that begin them."""
        if not early.any():
            return Forced(X, tuple(coupled), ())
        if not inputs[:, ~early].any():
            return Forced(np.zeros_like(X), (*coupled, *apart), ())
        return Forced(X, tuple(coupled), tuple(apart))

    def blocks(self, driven: Driven, forcing) -> tuple[np.ndarray, ...]:
        """Those of all states after y."""
        own = tuple(driven.generator[of, of] for of in block_slices(forcing))
        return (*own, *(own if self.apart else ()), *(pair.block for pair in self._pairs))

    def output(self, own: np.ndarray, through: np.ndarray) -> np.ndarray:
        """x of y and these states, from what y and w add to it."""
        follows = own @ self.X
        columns = [through, follows] if self.apart else [through + follows]
        return np.hstack([own, *columns, *(_padded(pair.unit * own[:, pair.own], len(pair.block)) for pair in self._pairs)])

    def states(self, inputs: np.ndarray, early) -> np.ndarray:
        """y and these states from y = 0, for states (m, K) of the force, in its first moments or not (one or K truth values)."""
        late = inputs * ~np.asarray(early) if self.apart else inputs
        begun = [pair.start(inputs * np.asarray(early)) for pair in self.apart]
        copies = [inputs, late] if self.apart else [inputs]
        return np.vstack([-self.X @ late, *copies, *(pair.start(inputs) for pair in self.coupled), *begun])

    def finite_part(self, states: np.ndarray) -> np.ndarray:
        """y from y and these states."""
        n, m = self.X.shape
        begin = n + (2 * m if self.apart else m)
        y = states[:n] + self.X @ states[begin - m : begin]
        for pair in self._pairs:
            size = pair.own.stop - pair.own.start
            y[pair.own] += pair.unit * states[begin : begin + size]
            begin += len(pair.block)
        return y

    @property
    def _pairs(self) -> tuple[Coupled, ...]:
        return self.coupled + self.apart


def regular_part(form: WeierstrassForm, start: Start, force: ImpulsiveSmooth, kicks: Kicks) -> tuple[BohlFunction, float]:
    """x(t) for t > 0 in the user's units and the largest decoupling entry.

    Args:
        start: what happens at t = 0.
        kicks: what happens at the later knots.
    """
    free, driven, scaling = block_diagonalize(form.T), driven_form(form, force), form.companion.scaling
    return driven_motion(FinitePart(free, form.C, driven, start.finite, kicks.finite, scaling.time, scaling.columns), force)


def driven_motion(part: FinitePart, force: ImpulsiveSmooth) -> tuple[BohlFunction, float]:
    """The same of a finite part, however it was found."""
    free, driven, n, time, rate = part.free, part.driven, len(part.start), part.time, _rate(part.free, part.driven)
    forcing, count = force.smooth.blocks, len(force.knots)
    X, coupled, apart = _separated(free, driven, forcing, max(SEPARATION_OF_PIECES, SEPARATION / count) / rate)
    knots, early = first_moments(force.smooth, force.knots, EARLY / (rate * time) if apart else 0.0)
    inputs = force.smooth.with_knots(knots).restarts.states / driven.units[:, None]
    forced = Forced.of(X, coupled, apart, early, inputs)
    blocks = (*free.blocks, *forced.blocks(driven, forcing))
    states = forced.states(inputs, early)
    if count == 1:
        states[:n, 0] += free.inverse @ part.start
    else:
        kicks = np.zeros((n, len(knots) - 1))
        kicks[:, np.searchsorted(knots, force.knots[1:]) - 1] = part.kicks
        part = replace(part, kicks=kicks)
        gaps = np.diff(knots) if count < FEW_KNOTS else shared_gaps(knots)
        states[:n] += _own_states(part, blocks, inputs, time * gaps, forced, early)
    scaled = tuple(time * block for block in blocks)
    function = BohlFunction(
        part.columns[:, None] * forced.output(part.output @ free.basis, driven.through),
        scaled,
        states[:, 0] if count == 1 else FreeRestarts(knots, states, scaled),
    )
    return function, max(free.coupling, float(np.abs(X).max(initial=0.0)))


def _rate(free: BlockDiagonal, driven: Driven) -> float:
    """The largest rate of the motion and of the force, 1 where there is none."""
    return max((float(np.abs(block).max()) for block in (*free.blocks, driven.generator) if block.any()), default=1.0)


def _separated(free: BlockDiagonal, driven: Driven, forcing, limit) -> tuple[np.ndarray, list[Coupled], list[Coupled]]:
    """X, zero where a block and a part of the force cannot be separated, those pairs, and those that are separated."""
    drive, generator = free.inverse @ driven.drive, driven.generator
    X, coupled, apart = np.zeros_like(drive), [], []
    outer = block_slices(forcing)
    for own, T in zip(block_slices(free.blocks), free.blocks):
        for of in outer:
            D, J = drive[own, of], generator[of, of]
            if D.any():
                solution, scale, info = lapack.dtrsyl(T, J, -D, isgn=-1)
                separable = info == 0 and np.abs(solution).max() <= limit * scale * np.abs(D).max()
                if separable:
                    X[own, of] = solution / scale
                (apart if separable else coupled).append(_coupled(own, of, T, D, J))
    return X, coupled, apart


def _coupled(own, of_force, T, D, J) -> Coupled:
    unit = power_of_two_of(D) / power_of_two_of([np.abs(T).max(), np.abs(J).max()])
    return Coupled(own, of_force, np.block([[T, D / unit], [np.zeros((len(J), len(T))), J]]), unit)


def _own_states(part: FinitePart, blocks, inputs, gaps, forced: Forced, early) -> np.ndarray:
    """y in its block diagonal coordinates at every knot, shape (n, K + 1), for gaps (K,) and states (m, K + 1) of the force."""
    states = np.empty((len(part.start), len(gaps) + 1))
    states[:, 0] = part.free.inverse @ part.start
    with np.errstate(over="ignore", invalid="ignore"):  # told when the function is evaluated
        if forced.apart:
            for flag in (True, False):
                at = np.flatnonzero(early[:-1] == flag)
                states[:, 1 + at] = _gains(blocks, inputs[:, at], gaps[at], forced, flag)
        else:
            states[:, 1:] = _gains(blocks, inputs[:, :-1], gaps, forced, False)
        struck = np.flatnonzero(part.kicks.any(axis=0))
        states[:, 1 + struck] += part.free.inverse @ part.kicks[:, struck]
        advance(part.free.blocks, states, gaps)
    return states


def _gains(blocks, inputs, gaps, forced: Forced, early: bool) -> np.ndarray:
    """What y becomes from zero within each gap, shape (n, K), for states (m, K) of the force where it begins.

    Where few gaps differ, by the matrix that takes the states of the force to it.
    """
    (n, m), (different, which) = forced.X.shape, np.unique(gaps, return_inverse=True)
    if len(different) * m * FEW_GAPS < len(gaps):
        units = np.tile(forced.states(np.eye(m), early), len(different))
        taken = forced.finite_part(block_states(blocks, units, np.repeat(different, m))).reshape(n, len(different), m)
        if np.isfinite(taken).all():
            if len(different) == 1:
                return taken[:, 0] @ inputs
            found = np.empty((n, len(gaps)))
            for gap in range(len(different)):
                found[:, which == gap] = taken[:, gap] @ inputs[:, which == gap]
            return found
    return forced.finite_part(block_states(blocks, forced.states(inputs, early), gaps))


def _padded(columns, size) -> np.ndarray:
    return np.hstack([columns, np.zeros((len(columns), size - columns.shape[1]))])
