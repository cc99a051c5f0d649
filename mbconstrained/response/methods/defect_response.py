"""The error of a sum of modes to first order: the response of the equations to their residual.

The values C e^(J t) v, put into A(d/dt) x = f as it was given, leave a residual R e^(J t) v, and at t = 0 they differ from the start
by d. In the coordinates of the modes X of w' = S w + B f the error is the solution of

e' = J e + E e^(J t) v,    E = X^-1 B R,    e(0) = X^-1 d

(variation of constants; Hairer, Norsett and Wanner, "Solving ordinary differential equations I", I.11). E has signs: how the error of
each mode grows or decays, and what was lost of the data altogether, is in it. R and d are computed with twice the digits. Rounding errors
of the evaluation, which no residual shows, are added as independent ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from ...ground.tolerances import EPS, EQUAL_EIGENVALUES, PROVED_RESTARTS, SINGULAR_CONDITION
from ...linalg.accurate_products import accurate_product
from ...linalg.arrays import full
from ...linalg.blocks import block_eigenvalues, block_matrix, block_slices
from ...linalg.division import solution
from ...linalg.exponential.block_exponential import block_states
from ..flow import Flow

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
