"""Separate modes of few states, corrected by their residual in extended precision, and a bound of the error of their sums.

First-order perturbation of eigenpairs (Stewart and Sun, "Matrix Perturbation Theory", V.2): the residual of a mode in the equations as
they were given, in the coordinates of all modes, is what its pole and its shape lack. The response to a state of the force is corrected
like a free mode, from zero. Each correction squares the relative error: two leave that of extended precision.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...ground.tolerances import EPS
from ...linalg.arrays import full
from ...signals.bohl import BohlFunction, Restarts
from ..flow import Flow
from .defect import FORCE_ROUNDING, UNIT, BoundedModes, Defect, Extended, divided_by_masses

#: Rounding errors of a sum of modes in float64, whose phases are more precise, in units of EPS relative to the size of its terms.
SUMMED_IN_FLOAT64 = 8.0

ExtendedComplex = np.clongdouble

#: Residuals are corrected to first order up to this part of the distance of two poles.
SMALL_RESIDUAL = 2.0**-10

#: A force within this part of a pole resonates with its mode.
RESONANCE = 2.0**-30

#: The first correction computes the response to a force in float64, and free modes with twice its digits; the second leaves rounding errors.
CORRECTIONS = 2


@dataclass(frozen=True, eq=False)
class RefinedModes:
    """w = W e^(L t) b: n free modes, then the responses to the m states of the force; complex pairs side by side.

    Attributes:
        poles: the diagonal of L, shape (n + m,).
        states: W, shape (n, n + m).
        left: approximate inverse of the first n columns of W, shape (n, n).
        leading: the poles on and above the real axis, as indices.
        above: those above it; their conjugates are the next ones.
        rows: bounds of the residual of each mode in each row of A(s), shape (r, n + m).
        parts: the effect of residuals of these rows on each free mode, bounds with the rounding errors of the inverses, shape (n, r).
        driven: bounds of the effect of the residual of each mode on each free mode, shape (n, n + m).
    """

    poles: np.ndarray
    states: np.ndarray
    left: np.ndarray
    leading: np.ndarray
    above: np.ndarray
    rows: np.ndarray
    parts: np.ndarray
    driven: np.ndarray

    @classmethod
    def of(cls, flow: Flow) -> RefinedModes | None:
        """Refined modes; None where modes are not separate, a force is a ramp, or equations are algebraic."""
        reduction, free, blocks = flow.reduction, flow.reduction.decoupled, flow.force.smooth.blocks
        V = full(reduction.V)
        if len(reduction.algebraic) or not UNIT < EPS or not _is_permutation(V):
            return None
        own, forced = _Separated.of(free.blocks), _Separated.of(blocks)
        if own is None or forced is None or not all(map(_turns_evenly, blocks)):
            return None
        n, m = len(flow.start), len(reduction.second)
        poles, above = np.concatenate([own.poles, forced.poles]), np.concatenate([own.pairs, n + forced.pairs])
        leading = np.setdiff1d(np.arange(len(poles)), above + 1)
        left, shapes = own.back @ free.inverse, np.zeros((len(V), len(poles)), dtype=ExtendedComplex)
        shapes[:, :n] = full(flow.output)[:, :n] @ (free.basis @ own.turn)
        parts, sizes, rows, noise = divided_by_masses(left, reduction)
        at = np.arange(np.count_nonzero(leading < n))
        of_modes = leading[at]
        for _ in range(CORRECTIONS):
            change = parts @ _residual(flow, shapes[:, leading], poles[leading], leading)[0][rows].astype(complex)
            distance = (poles[leading] - poles[:n, None]).astype(complex)
            small = np.abs(distance) > RESONANCE * np.abs(poles[leading]).astype(float)
            small[:, at] = np.abs(change[:, at]) < SMALL_RESIDUAL * np.abs(distance[:, at])
            corrections = np.divide(change, distance, out=np.zeros_like(change), where=small)
            shapes[:, leading] -= shapes[:, :n].astype(complex) @ corrections
            poles[of_modes] -= change[of_modes, at]
            shapes[:, above + 1], poles[above + 1] = shapes[:, above].conj(), poles[above].conj()
        signed, bound = _residual(flow, shapes[:, leading], poles[leading], leading)
        signed, effects = signed[rows], np.abs(parts) + noise * sizes
        known = np.abs(parts @ signed.astype(complex)) + np.abs(parts) @ (bound[rows] - np.abs(signed)).astype(float)
        driven, of_rows, conjugate = np.zeros((n, len(poles))), np.zeros((len(V), len(poles))), np.arange(n)
        conjugate[own.pairs], conjugate[own.pairs + 1] = own.pairs + 1, own.pairs
        driven[:, leading], of_rows[:, leading] = known + noise * (sizes @ bound[rows]), bound
        driven[:, above + 1], of_rows[:, above + 1] = driven[conjugate][:, above], of_rows[:, above]
        effects = effects[:, np.argsort(rows)]
        moving = V.T.astype(Extended) @ shapes
        states = np.concatenate([moving[:m], moving[:m] * poles, moving[m:]])
        return cls(poles, states, left, leading, above, of_rows, effects, driven)

    @cached_property
    def inexact(self) -> np.ndarray:
        """|X^-1 X - I| of the approximate inverse, with the rounding errors of the product."""
        n = len(self.states)
        basis = self.states[:, :n].astype(complex)
        return np.abs(self.left @ basis - np.eye(n)) + EPS * (n + 2) * (np.abs(self.left) @ np.abs(basis))

    def solved(self, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """X^-1 @ right of a vector of states, and a bound of its error to first order."""
        n, result = len(self.states), np.zeros(len(self.states), dtype=ExtendedComplex)
        X, rest = self.states[:, :n], right
        for _ in range(CORRECTIONS + 1):
            result = result + self.left @ rest.astype(complex)
            rest = right - X @ result
        rounded = (n + 4) * UNIT * (np.abs(X) @ np.abs(result) + np.abs(right))
        return result, np.abs(self.left) @ (np.abs(rest) + rounded).astype(float)


@dataclass(frozen=True, eq=False)
class _Separated:
    """Blocks of single zeros and pairs as turn @ diag(poles) @ back; pairs are the first indices of pairs."""

    poles: np.ndarray
    pairs: np.ndarray
    turn: np.ndarray
    back: np.ndarray

    @classmethod
    def of(cls, blocks: Sequence[np.ndarray]) -> _Separated | None:
        sizes = np.array([len(block) for block in blocks], dtype=int)
        if (sizes > 2).any():
            return None
        starts, count = np.cumsum(sizes) - sizes, int(sizes.sum())
        poles, turn, back = np.zeros(count, dtype=ExtendedComplex), np.eye(count, dtype=complex), np.eye(count, dtype=complex)
        poles[starts[sizes == 1]] = [block[0, 0] for block in blocks if len(block) == 1]
        pairs = starts[sizes == 2]
        if len(pairs):
            entries = np.array([block for block in blocks if len(block) == 2]).astype(Extended)
            (a, b), (c, d) = entries[:, 0].T, entries[:, 1].T
            square = -b * c - ((a - d) / 2) ** 2
            if not (square > 0).all():
                return None
            w = np.sqrt(square)
            poles[pairs] = (a + d) / 2 + 1j * w
            poles[pairs + 1] = poles[pairs].conj()
            lower, width = (poles[pairs] - a).astype(complex), b.astype(float)
            divisor = -2j * width * w.astype(float)
            for k, at in enumerate(pairs.tolist()):
                turn[at : at + 2, at : at + 2] = [[width[k], width[k]], [lower[k], lower[k].conj()]]
                back[at : at + 2, at : at + 2] = np.array([[lower[k].conj(), -width[k]], [-lower[k], width[k]]]) / divisor[k]
        return cls(poles, pairs, turn, back)


def _is_permutation(V: np.ndarray) -> bool:
    return bool(
        V.shape[0] == V.shape[1] and np.isin(V, (0.0, 1.0)).all() and (V.sum(axis=0) == 1).all() and (V.sum(axis=1) == 1).all()
    )


def _turns_evenly(block: np.ndarray) -> bool:
    """Whether (1, i) or (1, -i) is an eigenvector of a pair."""
    return len(block) == 1 or bool(block[0, 0] == block[1, 1] and block[0, 1] == -block[1, 0])


def _second_state(smooth: BohlFunction, pairs: np.ndarray) -> np.ndarray:
    """The second entry of the eigenvector (1, i) or (1, -i) of pairs of states of a force, by the first states."""
    return 1j * np.sign(smooth.generator[pairs, pairs + 1])


def _residual(flow: Flow, shapes: np.ndarray, poles: np.ndarray, leading: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A(s) x - F at some poles s, and bounds of its absolute value with all rounding errors, shape (r, L) each."""
    columns, smooth, n = [shapes], flow.force.smooth, len(flow.start)
    for _ in flow.reduction.given[1:]:
        columns.append(columns[-1] * poles)
    A, x = np.concatenate([full(matrix) for matrix in flow.reduction.given], axis=1), np.concatenate(columns)
    both = A.astype(Extended) @ np.concatenate([x.real, x.imag], axis=1)
    total = both[:, : len(poles)] + 1j * both[:, len(poles) :]
    sizes = np.abs(A) @ np.abs(x).astype(float)
    forced = leading[leading >= n] - n
    F = smooth.coefficients
    load = F[:, forced].astype(complex)
    paired = np.flatnonzero(poles[len(poles) - len(forced) :].imag > 0)
    load[:, paired] += _second_state(smooth, forced[paired]) * F[:, forced[paired] + 1]
    total[:, len(poles) - len(forced) :] -= load
    sizes[:, len(poles) - len(forced) :] += np.abs(load)
    terms = 0.75 * np.count_nonzero(A, axis=1)[:, None] + 6  # half a unit each, and two complex products; both parts
    return total, np.abs(total).astype(float) + terms * UNIT * sizes


def _sums(weights: np.ndarray, turned: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The real part of weights @ e^turned in float64, and bounds of its rounding errors in any row."""
    exponents, angles = turned.real.astype(float), turned.imag.astype(float)
    growth = np.exp(exponents)
    growth += growth * (turned.real - exponents).astype(float)
    cosines, sines, rest = np.cos(angles), np.sin(angles), (turned.imag - angles).astype(float)
    real, imaginary = growth * (cosines - rest * sines), growth * (sines + rest * cosines)
    left, right = np.concatenate([weights.real, -weights.imag], axis=1).astype(float), np.concatenate([real, imaginary])
    return left @ right, SUMMED_IN_FLOAT64 * EPS * np.abs(weights).astype(float).max(axis=0, initial=0.0) @ growth


@dataclass(frozen=True, eq=False)
class RefinedDefect(Defect):
    """The error of sums of refined modes in extended precision.

    Attributes:
        before: the piece before, None for the first one.
    """

    before: RefinedDefect | None = None

    @cached_property
    def refined(self) -> RefinedModes | None:
        """The modes; None where they cannot be refined."""
        if self.rounding is not None:
            return None
        return RefinedModes.of(self.flow) if self.before is None else self.before.refined

    def proved(self, place: np.ndarray, order: int, times: np.ndarray, accuracy: float) -> tuple[np.ndarray, np.ndarray]:
        """The derivative of this order of place @ z, and at which times it is guaranteed to this accuracy of the largest value.

        Phases are always those of extended precision; exponentials and sums are where those of float64 do not suffice.
        """
        lead, restarts = self.refined.leading, self._force
        values, sure = np.empty((len(place), len(times))), np.zeros(len(times), dtype=bool)
        C = self._output(place, order)[:, lead] * np.where(np.isin(lead, self.refined.above), 2, 1)
        pieces, since = restarts.located(times)
        for piece in np.unique(pieces).tolist():
            at, own = np.flatnonzero(pieces == piece), self._pieces[piece]
            exact = (
                times[at].astype(Extended)
                - restarts.knots[piece]
                - np.broadcast_to(restarts.remainders, restarts.knots.shape)[piece]
            )
            weights, turned = C * own._amplitude[lead], np.multiply.outer(self.refined.poles[lead], exact)
            values[:, at], rounded = _sums(weights, turned)
            allowed = accuracy * np.abs(values[:, at]).max(axis=0)
            sure[at] = own._late(place, order, since[at], allowed - rounded)
            late = np.flatnonzero(~sure[at])
            if len(late):
                growth, turned = np.exp(turned.real[:, late]), turned.imag[:, late]
                more = weights.real @ (growth * np.cos(turned)) - weights.imag @ (growth * np.sin(turned))
                values[:, at[late]] = more
                allowed = accuracy * np.abs(values[:, at[late]]).max(axis=0)
                sure[at[late]] = own._late(place, order, since[at[late]], allowed)
        return values, sure

    def _output(self, place: np.ndarray, order: int) -> np.ndarray:
        n = len(self.flow.start)
        states = place[:, :n].astype(Extended) @ self.refined.states
        return states * self.refined.poles**order if order else states

    @cached_property
    def _pieces(self) -> list[RefinedDefect]:
        pieces = [self]
        for piece in range(1, len(self._knots)):
            pieces.append(RefinedDefect(self.flow, self.rounding, piece, pieces[-1]))
        return pieces

    @cached_property
    def _force(self) -> Restarts:
        """The states of the force at all knots."""
        return self.flow.force.smooth.with_knots(self.flow.knots).restarts if self.before is None else self.before._force

    @property
    def _knots(self) -> np.ndarray:
        return self._force.knots

    @property
    def _gaps(self) -> np.ndarray:
        return self._force.gaps

    @cached_property
    def _start(self) -> np.ndarray:
        """The states of the force at the start of the piece in the coordinates of its poles, shape (m,)."""
        v, n = self._force.states[:, self.piece], len(self.flow.start)
        result, pairs = v.astype(complex), self.refined.above[self.refined.above >= n] - n
        result[pairs] = (v[pairs] - _second_state(self.flow.force.smooth, pairs) * v[pairs + 1]) / 2
        result[pairs + 1] = result[pairs].conj()
        return result

    @cached_property
    def _free(self) -> tuple[np.ndarray, np.ndarray]:
        """Amplitudes of the free modes at the start of the piece, and bounds of their errors, without those of the poles."""
        refined, n = self.refined, len(self.flow.start)
        responses = refined.states[:, n:]
        if self.before is None:
            result, errors = refined.solved(self._initial - responses @ self._start)
            return result, errors + np.abs(refined.left) @ self._impulsive[1][:, 0]
        before, h = self.before, Extended(self._force.gaps[self.piece - 1])
        moved = np.exp(refined.poles * h)
        change = responses @ (moved[n:] * before._start - self._start)
        jump, errors = refined.solved(change + self._impulsive[0][:, self.piece])
        errors = errors + np.abs(refined.left) @ self._impulsive[1][:, self.piece]
        turned = np.abs(moved) * np.abs(before._amplitude) * (8 + 2 * np.abs(refined.poles) * h) * UNIT
        through = np.abs(refined.left) @ (np.abs(responses) @ (turned[n:] + UNIT * np.abs(self._start))).astype(float)
        return moved[:n] * before._free[0] + jump, errors + through + turned[:n].astype(float)

    @property
    def _amplitude(self) -> np.ndarray:
        return np.concatenate([self._free[0], self._start])

    @cached_property
    def _modes(self) -> BoundedModes | None:
        if self.refined is None:
            return None
        poles, nothing = self.refined.poles.astype(complex), np.zeros(len(self.refined.poles))
        sizes = np.abs(self._amplitude).astype(float)
        return BoundedModes(np.diag(np.abs(poles)), np.arange(len(poles)), sizes, poles, poles.real, nothing > 0, nothing + 1, None)

    @cached_property
    def _modal_start(self) -> np.ndarray:
        return self._free[1] if self.before is None else self._free[1] + self.before._at_end()

    def _at_end(self) -> np.ndarray:
        modes, n, v = self._modes, len(self._own), self._modes.sizes
        h = float(self._force.gaps[self.piece])
        start, driven, second, secular, rest = self._amplitudes(h)
        decay = np.exp(modes.rates * h)
        first = (start + driven + h * (secular @ v)) * decay[:n] + second @ (v * decay)
        return first + rest * np.exp(max(modes.rates.max(), 0.0) * h)

    @cached_property
    def _lost(self) -> np.ndarray:
        """Relative errors of the states of the force."""
        smooth = self.flow.force.smooth
        lost = np.full(smooth.state_count, 0.0 if self._is_exact else FORCE_ROUNDING * EPS)
        if len(smooth.restarts.knots) > 1:
            known = self._force_rounding[:, smooth.restarts.located(self.flow.knots[[self.piece]])[0][0]]
            lost += np.divide(known, np.abs(self._force.states[:, self.piece]), out=np.zeros(len(known)), where=known > 0)
        return lost

    @cached_property
    def _residual(self) -> np.ndarray:
        n, rows = len(self.flow.start), self.refined.rows.copy()
        rows[:, n:] += self._force_errors
        return rows

    @cached_property
    def _modal_residual(self) -> np.ndarray:
        errors, n, driven = self._force_errors, len(self.flow.start), self.refined.driven
        return np.concatenate([driven[:, :n], driven[:, n:] + self.refined.parts @ errors], axis=1) if errors.any() else driven

    @property
    def _force_errors(self) -> np.ndarray:
        """Errors of the force in each row, by its poles."""
        F, n = np.abs(self.flow.force.smooth.coefficients), len(self.flow.start)
        load, pairs = F * self._lost, self.refined.above[self.refined.above >= n] - n
        both = load[:, pairs] + load[:, pairs + 1]
        load[:, pairs] = load[:, pairs + 1] = both
        return load

    @property
    def _folded_residual(self) -> np.ndarray:
        return self._modal_residual

    @property
    def _inexact(self) -> np.ndarray:
        return self.refined.inexact

    def _derived(self, place: np.ndarray, order: int) -> np.ndarray:
        return np.abs(self._output(place, order)).astype(float)

    @property
    def _unit(self) -> tuple[float, float]:
        terms = 2 * len(self._modes.sizes) + 16
        return terms * UNIT, 4 * UNIT
