"""The regular part: x(t) for t > 0 as a Bohl function, from a new start wherever the force starts, stops or changes.

In block diagonal coordinates of the finite part, y_b' = T_b y_b + sum over k of D_bk w_k and w_k' = J_k w_k for the parts
k of the force. With T_b X - X J_k = -D_bk the motion that w_k causes is X w_k and a free one. Where X is large, zeros
close to those of the force, y_b and a copy of w_k are evaluated together from rest instead. So a force that has ended
is over exactly, and a short pulse on a free body keeps its digits for ever.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from ..jordan.weierstrass import WeierstrassForm
from ..linalg.blocks import BlockDiagonal, block_diagonalize, block_slices
from ..linalg.exponential import block_states
from ..linalg.recursion import advance, shared_gaps
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.restarts import FreeRestarts
from .driven import Driven, driven_form
from .events import Kicks
from .forcing import power_of_two_of
from .parts import Start

#: A zero of A(s) and one of the force are separated where their distance is at least this part of the largest rate: the two
#: motions that are told apart cancel until they have come apart, and only so long as nothing else has moved much the Taylor
#: series takes their place. With very many pieces the digits that it costs add up.
SEPARATION, SEPARATION_OF_PIECES = 32.0, 8.0

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
    free, driven, n, time = part.free, part.driven, len(part.start), part.time
    knots, forcing = force.knots, force.smooth.blocks
    finite, outer = block_slices(free.blocks), block_slices(forcing)
    X, coupled = _separated(free, driven, finite, outer, max(SEPARATION_OF_PIECES, SEPARATION / len(knots)) / _rate(free, driven))
    blocks = (*free.blocks, *(driven.generator[of, of] for of in outer), *(pair.block for pair in coupled))
    own_output = part.output @ free.basis
    inputs = force.smooth.with_knots(knots).restarts.states / driven.units[:, None]
    states = _forced_states(inputs, X, coupled)
    if len(knots) == 1:
        states[:n, 0] += free.inverse @ part.start
    else:
        states[:n] += _own_states(part, blocks, inputs, time * shared_gaps(knots), X, coupled)
    outputs = [own_output, driven.through + own_output @ X]
    outputs += [_padded(pair.unit * own_output[:, pair.own], len(pair.block)) for pair in coupled]
    scaled = tuple(time * block for block in blocks)
    function = BohlFunction(
        part.columns[:, None] * np.hstack(outputs),
        scaled,
        states[:, 0] if len(knots) == 1 else FreeRestarts(knots, states, scaled),
    )
    return function, max(free.coupling, float(np.abs(X).max(initial=0.0)))


def _rate(free: BlockDiagonal, driven: Driven) -> float:
    """The largest rate of the motion and of the force, 1 where there is none."""
    return max((float(np.abs(block).max()) for block in (*free.blocks, driven.generator) if block.any()), default=1.0)


def _separated(free: BlockDiagonal, driven: Driven, finite, outer, limit) -> tuple[np.ndarray, list[Coupled]]:
    """X, zero where a block and a part of the force cannot be separated, and those pairs."""
    drive, generator = free.inverse @ driven.drive, driven.generator
    X, coupled = np.zeros_like(drive), []
    for own, T in zip(finite, free.blocks):
        for of in outer:
            D, J = drive[own, of], generator[of, of]
            if D.any():
                solution, scale, info = lapack.dtrsyl(T, J, -D, isgn=-1)
                if info == 0 and np.abs(solution).max() <= limit * scale * np.abs(D).max():
                    X[own, of] = solution / scale
                else:
                    coupled.append(_coupled(own, of, T, D, J))
    return X, coupled


def _coupled(own, of_force, T, D, J) -> Coupled:
    unit = power_of_two_of(D) / power_of_two_of([np.abs(T).max(), np.abs(J).max()])
    return Coupled(own, of_force, np.block([[T, D / unit], [np.zeros((len(J), len(T))), J]]), unit)


def _forced_states(inputs, X, coupled) -> np.ndarray:
    """Those of all blocks from y = 0, for states (m, K) of the force."""
    return np.vstack([-X @ inputs, inputs, *(pair.start(inputs) for pair in coupled)])


def _own_states(part: FinitePart, blocks, inputs, gaps, X, coupled) -> np.ndarray:
    """y in its block diagonal coordinates at every knot, shape (n, K + 1), for gaps (K,) and states (m, K + 1) of the force."""
    states = np.empty((len(part.start), len(gaps) + 1))
    states[:, 0] = part.free.inverse @ part.start
    with np.errstate(over="ignore", invalid="ignore"):  # told when the function is evaluated
        _gains_into(states[:, 1:], blocks, inputs[:, :-1], gaps, X, coupled)
        struck = np.flatnonzero(part.kicks.any(axis=0))
        states[:, 1 + struck] += part.free.inverse @ part.kicks[:, struck]
        advance(part.free.blocks, states, gaps)
    return states


def _gains_into(found, blocks, inputs, gaps, X, coupled) -> None:
    """What y becomes from zero within each gap, into an array (n, K), for states (m, K) of the force where it begins.

    Where few gaps differ, by the matrix that takes the states of the force to it.
    """
    (n, m), (different, which) = X.shape, np.unique(gaps, return_inverse=True)
    if len(different) * m * FEW_GAPS < len(gaps):
        units = np.tile(_forced_states(np.eye(m), X, coupled), len(different))
        taken = _finite_part(block_states(blocks, units, np.repeat(different, m)), X, coupled).reshape(n, len(different), m)
        if np.isfinite(taken).all():
            for gap in range(len(different)):
                at = slice(None) if len(different) == 1 else which == gap
                found[:, at] = taken[:, gap] @ inputs[:, at]
            return
    found[...] = _finite_part(block_states(blocks, _forced_states(inputs, X, coupled), gaps), X, coupled)


def _finite_part(states, X, coupled) -> np.ndarray:
    """y from the states of all blocks."""
    n, m = X.shape
    y, begin = states[:n] + X @ states[n : n + m], n + m
    for pair in coupled:
        size = pair.own.stop - pair.own.start
        y[pair.own] += pair.unit * states[begin : begin + size]
        begin += len(pair.block)
    return y


def _padded(columns, size) -> np.ndarray:
    return np.hstack([columns, np.zeros((len(columns), size - columns.shape[1]))])
