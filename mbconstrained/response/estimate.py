"""Error estimates of responses: proved ones of small models, for larger ones by the response to the residual."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from ..ground.checks import real_array
from ..ground.errors import Overflow, within_float64
from ..ground.tolerances import (
    EPS,
    EQUAL_EIGENVALUES,
    PROVED_ACCURACY,
    PROVED_RESTARTS,
    ROUNDED_FREE,
    SINGULAR_CONDITION,
    TRUST_LIMIT,
    UNCLEAR_ERROR,
)
from ..linalg.arrays import full
from ..linalg.blocks import CHUNK_ENTRIES, block_eigenvalues, block_matrix, block_slices
from ..linalg.division import accurate_product, solution
from ..linalg.exponential import block_states
from ..signals.bohl import BohlFunction
from .flow import Flow
from .methods.defect import are_right
from .methods.proved import ProvedFunction
from .methods.reduced_solution import FlowFunction
from .response_notices import SolvedProblem

# The error of a sum of modes to first order: the response of the equations to their residual.
# The values C e^(J t) v, put into A(d/dt) x = f as it was given, leave a residual R e^(J t) v, and at t = 0 they differ from the start
# by d. In the coordinates of the modes X of w' = S w + B f the error is the solution of
# e' = J e + E e^(J t) v,    E = X^-1 B R,    e(0) = X^-1 d
# (variation of constants; Hairer, Norsett and Wanner, "Solving ordinary differential equations I", I.11). E has signs: how the error of
# each mode grows or decays, and what was lost of the data altogether, is in it. R and d are computed with twice the digits. Rounding errors
# of the evaluation, which no residual shows, are added as independent ones.

#: The response to the defect of so many states is computed: 400 take a quarter of a second.
MOST_STATES = 400

#: Rounding errors of a term of the sum in units of EPS, and of its phase for each radian.
SUMMED, TURNED = 2.0, 1.0


#: Without separate modes each time takes an exponential: the usual number of times up to so many states, at least so few of more.
EXPONENTIAL_STATES, FEWEST = 96, 6


@dataclass(frozen=True, eq=False)
class DefectResponse:
    """The error of the values of a flow by its modes.

    Attributes:
        flow: the reduced equations with start and force.
        end: the last time at which it is requested, in s.
    """

    flow: Flow
    end: float

    @classmethod
    def of(cls, flow: Flow, end: float) -> DefectResponse | None:
        """The defect response of a flow."""
        few = flow.reduction.state_count + flow.force.smooth.state_count <= MOST_STATES
        if not few or len(flow.knots) - 1 > PROVED_RESTARTS or (flow.impulsive is not None and flow.impulsive[:, 1:].any()):
            return None
        return cls(flow, end)

    def most_times(self, usual: int) -> int:
        """The number of times worth computing: fewer where each takes an exponential of very many states."""
        if self._diagonal is not None:
            return usual
        return int(np.clip(usual * (EXPONENTIAL_STATES / len(self._J)) ** 3, FEWEST, usual))

    def errors(self, place: np.ndarray, order: int, times: np.ndarray) -> np.ndarray:
        """Estimates of the largest error in any row of the derivative of this order of place @ z."""
        pieces, since = self.flow.states.restarts.located(times)
        C, result = self.flow.modal_output(place), np.empty(len(times))
        with np.errstate(all="ignore"):
            for k, (piece, t) in enumerate(zip(pieces.tolist(), since.tolist())):
                v = self._starts[:, piece]
                result[k] = np.abs(self._error(C, order, piece, t)).max(initial=0.0) + self._rounding(C, order, v, t)
        return np.where(np.isfinite(result), result, np.inf)

    def _error(self, C: np.ndarray, order: int, piece: int, t: float) -> np.ndarray:
        """C e, or its derivative: e^(k) = J e^(k - 1) + E J^(k - 1) e^(J t) v."""
        n, v, (residual, driven, _) = len(self.flow.start), self._starts[:, piece], self._drives(piece)
        e, total = self._coordinates(piece, self._errors_at_starts[piece], t), 0.0
        if order or len(self.flow.reduction.algebraic):
            moved = block_states(self.flow.states.blocks, v[:, None], np.array([t]))[:, 0]
            for _ in range(order):
                e, moved = self._J[:n, :n] @ e + driven @ moved, self._J @ moved
            algebraic = self.flow.reduction.algebraic
            if len(algebraic):
                total = np.abs(full(self.flow.reduction.Y) @ (residual[algebraic] @ moved)).max(initial=0.0)
        return np.abs(C[:, :n] @ e) + total

    def _rounding(self, C: np.ndarray, order: int, v: np.ndarray, t: float) -> float:
        """Rounding errors of the terms of the sum, as independent errors, with phase errors of oscillations."""
        sizes = np.abs(block_states(self.flow.states.blocks, v[:, None], np.array([t]))[:, 0])
        amplitudes, pairs = sizes.copy(), self._pairs
        amplitudes[pairs] = amplitudes[pairs + 1] = np.hypot(sizes[pairs], sizes[pairs + 1])
        errors = (SUMMED * sizes + TURNED * self._rates * t * amplitudes) * self._rates**order
        return EPS * float(np.sqrt(C**2 @ errors**2).max(initial=0.0))

    def _coordinates(self, piece: int, start: np.ndarray, t: float) -> np.ndarray:
        """e at a time after the start of a piece, from e there."""
        n = len(start)
        if self._diagonal is None:
            return self._coordinates_by_blocks(piece, start, t)
        turn, back, zeros = self._diagonal
        driven = self._drives(piece)[2] * divided_exponentials(zeros[:n], zeros, t)
        v = back @ self._starts[:, piece]
        return (turn[:n, :n] @ (np.exp(zeros[:n] * t) * (back[:n, :n] @ start) + driven @ v)).real

    def _coordinates_by_blocks(self, piece: int, start: np.ndarray, t: float) -> np.ndarray:
        """The coordinates where eigenvectors do not separate the modes: the integral is a block of an exponential (Van Loan 1978)."""
        n, v, driven = len(start), self._starts[:, piece], self._drives(piece)[1]
        # The drive has the size of J there, so that rounding errors of e^(J t) do not hide it.
        unit = np.abs(driven).max(initial=0.0) / (np.abs(self._J).max() or 1.0) or 1.0
        both = np.block([[self._J[:n, :n], driven / unit], [np.zeros((len(v), n)), self._J]])
        exponential = scipy.linalg.expm(both * t)[:n]
        return exponential[:, :n] @ start + unit * (exponential[:, n:] @ v)

    @cached_property
    def _errors_at_starts(self) -> list[np.ndarray]:
        """e at the start of each piece: the error of the piece before, and the difference of v from the states there."""
        flow, starts = self.flow, self._starts
        result = [self._mismatch(starts[:, 0], flow.start)]
        for piece, h in enumerate(flow.states.restarts.gaps[: starts.shape[1] - 1].tolist()):
            end = block_states(flow.states.blocks, starts[:, piece, None], np.array([h]))[:, 0]
            change = self._mismatch(starts[:, piece + 1] - end, np.zeros(len(flow.start)))
            result.append(self._coordinates(piece, result[-1], h) + change)
        return result

    def _mismatch(self, v: np.ndarray, states: np.ndarray) -> np.ndarray:
        """X^-1 (Z v - states)."""
        high, low = self._own_states
        whole, rest = accurate_product(high, v[:, None])
        return self.flow.reduction.decoupled.inverse @ ((whole[:, 0] - states) + (rest[:, 0] + low @ v))

    @property
    def _starts(self) -> np.ndarray:
        """v of each piece, shape (N, K)."""
        return self.flow.states.restarts.states

    @cached_property
    def _slices(self) -> list[slice]:
        return block_slices(self.flow.states.blocks)

    @cached_property
    def _rates(self) -> np.ndarray:
        """The largest modulus of an eigenvalue of the block of each state."""
        rates = [np.abs(block_eigenvalues(block)).max() for block in self.flow.states.blocks]
        return np.repeat(rates, list(map(len, self.flow.states.blocks)))

    @cached_property
    def _pairs(self) -> np.ndarray:
        """The first states of oscillations."""
        blocks = self.flow.states.blocks
        return np.array([at.start for at, block in zip(self._slices, blocks) if len(block) == 2 and block[1, 0]], dtype=int)

    @cached_property
    def _J(self) -> np.ndarray:
        return block_matrix(self.flow.states.blocks)

    @cached_property
    def _states(self) -> np.ndarray:
        """Z of z = Z e^(J t) v."""
        if not self.flow.force.smooth.state_count:
            return self.flow.reduction.decoupled.basis
        return self.flow.modal_output(np.eye(len(self.flow.start_with_force)))

    @cached_property
    def _own_states(self) -> tuple[np.ndarray, np.ndarray]:
        """Z of the states of A(s), and its rounding errors; velocities are those of the displacements, Z J."""
        n, m = len(self.flow.start), len(self.flow.reduction.second)
        high, low = self._states[:n].copy(), np.zeros((n, len(self._J)))
        high[m : 2 * m], low[m : 2 * m] = accurate_product(high[:m], self._J)
        return high, low

    def _drives(self, piece: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """R, E and U^-1 E U in a piece; copies of the states of the force count with these, so that their large parts cancel."""
        v = self._starts[:, piece]
        copies = [(copy, of) for copy, of in self.flow.copies if v[copy].any() and np.array_equal(v[copy], v[of])]
        key = tuple((copy.start, of.start) for copy, of in copies)
        if key not in self._known_drives:
            total, rest = (part.copy() for part in self._residual)
            for copy, of in copies:
                for part in (total, rest):
                    part[:, of] += part[:, copy]
                    part[:, copy] = 0.0
            driven, n, separated = self._driven(total + rest), len(self.flow.start), None
            if self._diagonal is not None:
                turn, back, _ = self._diagonal
                separated = back[:n, :n] @ driven @ turn
            self._known_drives[key] = total + rest, driven, separated
        return self._known_drives[key]

    @cached_property
    def _known_drives(self) -> dict:
        return {}

    @cached_property
    def _residual(self) -> tuple[np.ndarray, np.ndarray]:
        """R = A_0 C + A_1 C J + A_2 C J^2 - F, C = P Z as evaluated, in the rows of A(s), shape (r, N), as a sum of two parts."""
        flow, n = self.flow, len(self.flow.start)
        A, high = np.concatenate([full(matrix) for matrix in flow.reduction.given], axis=1), full(flow.output) @ self._states
        columns, rests = [high], [np.zeros(high.shape)]
        for _ in flow.reduction.given[1:]:
            high, low = accurate_product(columns[-1], self._J)
            columns.append(high)
            rests.append(low + rests[-1] @ self._J)
        total, rest = accurate_product(A, np.concatenate(columns))
        rest = rest + A @ np.concatenate(rests)
        if len(self._states) > n:
            force, lost = accurate_product(flow.force.smooth.coefficients, self._states[n:])
            total, rest = total - force, rest - lost
        return total, rest

    def _driven(self, residual: np.ndarray) -> np.ndarray:
        """E = X^-1 B R, shape (n, N)."""
        reduction, left = self.flow.reduction, self.flow.reduction.decoupled.inverse
        m, right = len(reduction.second), residual[np.concatenate([reduction.second, reduction.first])]
        if len(reduction.algebraic):
            values = residual[reduction.algebraic]
            for matrix in reduction.through:
                right, values = right - matrix @ values, values @ self._J
        C = full(reduction.C)
        rates = solution(C[m:, m:], right[m:])
        return left[:, m : 2 * m] @ solution(full(reduction.M), right[:m] - C[:m, m:] @ rates) + left[:, 2 * m :] @ rates

    @cached_property
    def _diagonal(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """U, U^-1 and the eigenvalues of J; None where the eigenvectors of a block do not separate its modes."""
        count = len(self._J)
        turn, back, zeros = np.zeros((count, count), complex), np.zeros((count, count), complex), np.zeros(count, complex)
        for block, at in zip(self.flow.states.blocks, self._slices):
            zeros[at], turn[at, at] = np.linalg.eig(_simple(block, self.end).astype(complex))
            if len(block) > 1 and not np.linalg.cond(turn[at, at]) < SINGULAR_CONDITION:
                return None
            back[at, at] = np.linalg.inv(turn[at, at])
        return turn, back, zeros


def _simple(block: np.ndarray, end: float) -> np.ndarray:
    """A block perturbed slightly to make its eigenvalues simple, without effect on e^(J t) until the end."""
    size, count = np.abs(block).max(), len(block)
    if count == 1 or not size or (count == 2 and block[0, 0] == block[1, 1] and block[0, 1] == -block[1, 0]):
        return block
    values, distance = (
        block_eigenvalues(block),
        min(EQUAL_EIGENVALUES, EQUAL_EIGENVALUES**0.5 / (size * end)) if end else EQUAL_EIGENVALUES,
    )
    if (np.abs(np.subtract.outer(values, values)) + size * np.eye(count)).min() > distance * size:
        return block
    return block + distance**count * size * np.random.default_rng(0).uniform(0.5, 1, block.shape)


def divided_exponentials(left: np.ndarray, right: np.ndarray, t: float) -> np.ndarray:
    """(e^(b t) - e^(a t)) / (b - a) for all a and b, t e^(a t) where they are equal.

    >>> divided_exponentials(np.array([0.0]), np.array([0.0, 1.0]), 1.0).real.round(3).tolist()
    [[1.0, 1.718]]
    """
    larger = np.where(np.greater_equal.outer(left.real, right.real), left[:, None], right)
    z = (left[:, None] + right - 2 * larger) * (t + 0j)
    quotients = np.divide(np.expm1(z), z, out=np.ones(z.shape, complex), where=z != 0)
    return t * np.exp(larger * t) * quotients


# Error estimate of a response: proved, from the defect of its values, or by solutions of the problem with perturbed data.
# The values of a small model are compared with balls of the exact engine, at each time relative to the largest value then.
# Of a larger model that the reduced equations serve, values by modes leave a residual in the given equations, and the response to it is
# their error (``DefectResponse``); values by other methods are compared with those by modes. Nothing but the true error makes
# this estimate large.
# Of all others, and before the Taylor series of the start ends, the data of A(s), of the values at 0- and of the force are
# moved entry by entry by a unit in the last place. The largest change of the answer over a few such trials, times a safety factor, is
# the estimate: it sees the condition of the problem and the rounding errors of the algorithm at once, for the solution and for all
# that is derived from it.
# Where a rank decision was not clear, the estimate is at least the difference from the solution with the other decision, or
# a tenth where there is none. Ranks of moved data
# are decided like those of the given ones: data that counted as zero at s = 0 enter by one more trial, with the data as they
# are written, where that makes more of a difference than a free body may. The trials are seeded: the estimate is reproducible.
# Moved data are summed up by the same rounded functions of time, so cancellation in the sum of modes enters separately, by the
# size of its terms.

#: Number of solved problems with perturbed data.
TRIALS = 3

#: An algorithm in float64 adds errors of its own to those of the data, of the same kind; precise arithmetic only those of
#: the evaluation.
SAFETY, PRECISE_SAFETY = 2.5, 1.0

#: The response to the defect is right to a few percent where the modes are well separated.
DEFECT_SAFETY = 2.0

#: Bounds at so many times make the estimate.
MOST_PROVED = 64

#: No solution is claimed to be better than so many rounding errors: its evaluation makes as many.
LEAST = 8 * EPS


def error_estimate(x: SolvedProblem, times, view: Callable[[Any], BohlFunction] = lambda response: response.function) -> float:
    """Estimate of max |error| / max |y| over the times, at least a few rounding errors; of a small model a proved bound.

    It is infinite where the error may be as large as the answer.
    """
    with within_float64():
        return _estimate(x, real_array(times, "time"), view)


def _estimate(x: SolvedProblem, times: np.ndarray, view: Callable[[Any], BohlFunction]) -> float:
    function = view(x)
    values = np.asarray(function(times))
    largest, times = np.abs(values).max(initial=0.0), np.atleast_1d(times)
    values = values.reshape(function.size, len(times))
    if largest and isinstance(function, ProvedFunction) and (error := _proved_error(function, times, values)) < np.inf:
        rounded = min(_phase(function, times, largest), PROVED_ACCURACY)  # what rounded data move, within what is proved
        return max(error, 2 * LEAST, rounded)
    if isinstance(function, FlowFunction) and (error := _error_by_defect(function, times, values)) is not None:
        early = times < function.flow.taylor_start(modal=True).end
        estimate = error / largest if largest else np.inf * (error > 0)
        if estimate <= TRUST_LIMIT and not early.any():
            return max(_relative_to_truth(estimate), LEAST)
        if estimate <= TRUST_LIMIT:
            times, values = times[early], values[:, early]
    else:
        estimate = 0.0
    return max(_relative_to_truth(estimate), _estimate_by_trials(x, times, values, largest, view)) if largest else EPS


def errors_at(function: BohlFunction, times: np.ndarray) -> np.ndarray | None:
    """Estimates of max |error| / max |y| at each of some times, without further solutions; None where these are necessary."""
    if not isinstance(function, FlowFunction):
        return None
    values = np.asarray(function(times))
    if (errors := [_error_by_defect(function, times[k : k + 1], values[:, k : k + 1]) for k in range(len(times))]).count(None):
        return None
    sizes = np.abs(values).max(axis=0, initial=0.0)
    relative = np.divide(np.array(errors, dtype=float), sizes, out=np.zeros(len(times)), where=sizes > 0)
    return np.array([_relative_to_truth(one) for one in relative])


def _error_by_defect(function: FlowFunction, times: np.ndarray, values: np.ndarray) -> float | None:
    """The largest error of some of the values after the first moments; None where it is not known."""
    late = np.flatnonzero(times >= function.flow.taylor_start(modal=True).end)
    if not len(late):
        return 0.0
    response = DefectResponse.of(function.flow, float(times[late].max()))
    if response is None:
        return None
    if len(late) > (most := response.most_times(MOST_PROVED)):
        late = late[np.linspace(0, len(late) - 1, most).astype(int)]
    errors = DEFECT_SAFETY * response.errors(function.place, function.order, times[late])
    return float((errors + np.abs(values[:, late] - function.by_modes(times[late])).max(axis=0, initial=0.0)).max())


def _phase(function: BohlFunction, times: np.ndarray, largest: float) -> float:
    """Error of the phase: eigenvalues are accurate to half a unit in the last place at best."""
    return EPS / 2 * float(np.abs(times * np.asarray(function.derivative()(times)) / largest).max())


def _estimate_by_trials(x: SolvedProblem, times: np.ndarray, values: np.ndarray, largest: float, view) -> float:
    """Error estimate from perturbed problems, for the values at these times, relative to the largest of all."""
    function = view(x)
    change = max(_largest_change(lambda other=other: view(other)(times) - values, largest) for other in x._moved)
    written = 0.0 if x._written is None else _largest_change(lambda: view(x._written)(times) - values, largest)
    change = max(change, written if written > ROUNDED_FREE * largest else 0.0)
    summed = EPS * summands(function, times) / largest
    safety = PRECISE_SAFETY if x.solution.is_precise else SAFETY
    estimate = _relative_to_truth(max(safety * (change / largest), _phase(function, times, largest), summed))
    if x.solution.has_clear_ranks:
        return max(estimate, LEAST)
    other = x._decided_otherwise
    if other is None:
        return max(estimate, UNCLEAR_ERROR)
    return max(estimate, LEAST, _relative_to_truth(_largest_change(lambda: view(other)(times) - values, largest) / largest))


def _proved_error(function: ProvedFunction, times: np.ndarray, values: np.ndarray) -> float:
    """A bound of the largest |error| / |y|, of very many times at the smallest values and even samples; infinite where none is known."""
    size = np.abs(values).max(axis=0)
    if len(times) > MOST_PROVED:
        even = np.linspace(0, len(times) - 1, MOST_PROVED // 2).astype(int)
        chosen = np.union1d(np.argsort(size)[: MOST_PROVED // 2], even)
        times, values, size = times[chosen], values[:, chosen], size[chosen]
    evaluated, bounds = function.evaluated(times, accuracy=0.0)
    if not are_right(evaluated, bounds).all():
        return np.inf
    error = np.abs(values - evaluated).max(axis=0) + bounds
    return float(np.divide(error, size, out=np.where(error > 0, 1.0, 0.0), where=size > 0).max())


def _relative_to_truth(error: float) -> float:
    """An error relative to the computed value y converted to one relative to the true value, which is at least (1 - error) |y|.

    It is infinite where the error may be all of y: a growing mode that rounding alone excites is larger than the truth by any factor.
    """
    return error / (1 - error) if error < 1 else float("inf")


def summands(function: BohlFunction, times) -> float:
    """Size of the terms of the sum C e^{J t} v, the largest of any row and time: the root of the sum of their squares.

    Rows are left out while they are evaluated in another way, by their Taylor series for example, in which nothing cancels.
    """
    times, summed_from = np.atleast_1d(times), function.summed_from
    times = times[times >= summed_from.min(initial=np.inf)]
    if not times.size:
        return 0.0
    C, largest = function.coefficients, 0.0
    units = np.abs(C).max(axis=0, initial=0.0)
    squares = (C / np.where(units > 0, units, 1.0)) ** 2
    width = max(1, CHUNK_ENTRIES // max(*C.shape, 1))
    for begin in range(0, times.size, width):
        piece, since = function.restarts.located(part := times[begin : begin + width])
        states = units[:, None] * block_states(function.blocks, function.restarts.states[:, piece], since)
        size = np.abs(states).max(initial=0.0)
        if 0 < size < np.inf:
            sizes = size * np.sqrt(squares @ (states / size) ** 2)
            largest = max(largest, sizes.max(where=np.less_equal.outer(summed_from, part), initial=0.0))
    return float(largest)


def _largest_change(changes: Callable[[], np.ndarray], largest: float) -> float:
    """The largest of the changes, as large as the value itself where the perturbed problem has none in the range of float64."""
    try:
        return float(np.abs(changes()).max())
    except Overflow:
        return largest
