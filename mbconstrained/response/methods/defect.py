"""Bounds of the error of a motion of few states, by the residual of its equations and bounds of its modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, fsum, log2

import numpy as np

from ...ground.tolerances import DIVISOR_CONDITION, EPS, PROVED_ACCURACY
from ...linalg.arrays import full, kept
from ...linalg.blocks import block_matrix, block_slices
from ...linalg.exponential import block_states
from ...polynomial.coefficients import Factors
from ...polynomial.reduced_equations import Reduction
from ...signals.impulsive import ExactImpulse, ExactTerm, ImpulsiveLoad, ImpulsiveSmooth
from ..flow import Flow

# Bounds of a sum of modes e^(J t) v in the rows of its blocks: growth, turning, and the response to small changes of J.


@dataclass(frozen=True, eq=False)
class BoundedModes:
    """J and v with the bounds of e^(J t) v. An oscillating pair is one row of the bounds, with the norms of both states.

    Attributes:
        J: block diagonal, shape (N, N).
        starts: the first state of each row of the bounds, shape (K,).
        sizes: |v|, shape (K,), as all below.
        zeros: an eigenvalue, of complex pairs the one above the real axis.
        rates: the largest real part of the block of the row.
        clustered: whether the row belongs to a block of several eigenvalues.
        stretch: |e^(T t)| <= stretch e^(a t) for a pair T alone.
        links: the sizes of the entries of J between rows, shape (K, K).
    """

    J: np.ndarray
    starts: np.ndarray
    sizes: np.ndarray
    zeros: np.ndarray
    rates: np.ndarray
    clustered: np.ndarray
    stretch: np.ndarray
    links: np.ndarray | None

    @classmethod
    def of(cls, blocks: tuple[np.ndarray, ...], v: np.ndarray) -> BoundedModes | None:
        """Bounds of e^(J t) v."""
        if not blocks:
            return None
        zeros: list[complex] = []
        starts, stretch, of_block, begin = [], [], [], 0
        for number, block in enumerate(blocks):
            entries, row, size = block.tolist(), 0, len(block)
            while row < size:
                a, pair = entries[row][row], row + 1 < size and entries[row + 1][row] != 0.0
                starts.append(begin + row)
                of_block.append(number)
                if not pair:
                    zeros.append(a)
                    stretch.append(1.0)
                else:
                    up, down, half = entries[row][row + 1], entries[row + 1][row], (a - entries[row + 1][row + 1]) / 2
                    square = -up * down - half * half
                    if not square > 0:
                        return None
                    larger = (half * half + (up * up + down * down) / 2) / square  # (s^2 + 1 / s^2) / 2 of singular values s, 1 / s
                    zeros.append(complex(a - half, square**0.5))
                    stretch.append((larger + max(larger * larger - 1, 0.0) ** 0.5) ** 0.5)
                row += 1 + pair
            begin += size
        J, at, first = block_matrix(blocks), np.array(starts), np.array(zeros, dtype=complex)
        rates, clustered, links = first.real, np.zeros(len(at), dtype=bool), None
        if len(at) > len(blocks):
            if any(np.tril(block, -2).any() for block in blocks if len(block) > 2):
                return None
            links = folded(J, at, at)  # below the diagonal there are entries of pairs only
            np.fill_diagonal(links, 0.0)
            counts = np.bincount(of_block)
            clustered, rates = counts[of_block] > 1, rates.copy()
            for joined in np.flatnonzero(counts > 1):
                rates[np.equal(of_block, joined)] = rates[np.equal(of_block, joined)].max()
        sizes = np.hypot.reduceat(np.abs(v), at)
        return cls(J, at, sizes, first, rates, clustered, np.array(stretch), links)

    def spread(self, end: float) -> np.ndarray:
        """Q with |e^(J t)| <= e^(a t) Q for all t <= end."""
        total = term = np.diag(self.stretch)
        if self.clustered.any():
            step = end * (term @ self.links)
            for k in range(1, len(term)):
                term = step @ term / k
                if not term.any():
                    break
                total = total + term
        return total

    def responses(self, E: np.ndarray, Q: np.ndarray, end: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Y, Z, S and X, bounds of motions caused by a term E e^(J t) v.

        By the length of time, or by the difference of the eigenvalues: e^(T t) Y - Y e^(J t) with T Y - Y J = E.
        """
        n = len(E)
        distance = np.abs(np.subtract.outer(self.zeros[:n], self.zeros))
        direct = self.stretch[:n, None] * E * self.stretch
        if not self.clustered.any():
            by_time = end * distance < 1
            separate = np.where(by_time, 0.0, direct / distance)
            return separate, separate, by_time * direct, direct
        most, joined, separate = Q[:n, :n] @ E @ Q, self.stretch[:, None] * self.links, direct / distance
        for _ in range(2 * len(joined)):
            more = (direct + joined[:n, :n] @ separate + separate @ joined) / distance
            if more.tobytes() == separate.tobytes():
                break
            separate = more
        rows, columns = Q[:n, :n] @ separate, separate @ Q
        by_time = ~(rows + columns < end * most)
        return np.where(by_time, 0.0, rows), np.where(by_time, 0.0, columns), by_time * most, most


def folded(matrix: np.ndarray, rows: np.ndarray | None, columns: np.ndarray) -> np.ndarray:
    """Norms of the parts of a matrix."""
    squares = np.add.reduceat(matrix * matrix, columns, axis=1)
    return np.sqrt(squares if rows is None else np.add.reduceat(squares, rows, axis=0))


# A bound of the error of a small model's float64 values at each time, from the defect of the functions that give them.
# The modes give z = Z e^(J t) v, the Taylor series the solution of z' = G z; put into the equations as they were given,
# A(d/dt) P z - f, either leaves a residual. The response to it, and to the defect at t = 0, is the error of the answer. It is bounded
# entry by entry in the coordinates of the modes: a coupling that was lost, whatever its size, is in the residual of its row, and grows
# or decays with the mode that it drives. The residual is summed in extended precision where the machine has it.
# Variation of constants (Hairer, Norsett and Wanner, "Solving ordinary differential equations I", I.11), with the bound
# |e^(J t)| <= e^(a t) Q for each block of J; what is of second order in the residual is bounded by norms.

#: Rounding errors of a sum of modes in units of EPS, relative to the size of its terms, with and without clusters; and those of a
#: mode for each radian.
SUMMED, SUMMED_OF_CLUSTERS, TURNED = 4.0, 32.0, 1.0

#: Errors of second order are bounded where those of first order change the modes by at most this.
FIRST_ORDER = 0.05

#: Rounding errors of the numbers that describe a force, in units of EPS: an amplitude times a cosine, divided by a factorial.
FORCE_ROUNDING = 4.0

#: Sums in extended precision; where the machine has none their rounding errors are those of float64, and are counted so.
Extended = np.longdouble

#: Matrices of no more entries in a column, on average, are multiplied entry by entry.
FEW_ENTRIES = 16
UNIT = float(np.finfo(Extended).eps)


@dataclass(frozen=True, eq=False)
class Rounding:
    """Rounding errors of A(d/dt) x = f relative to the data from which it was computed.

    Attributes:
        coefficients: bounds of the errors of A_0, A_1, ..., shape (r, r) each.
        force: a bound of the errors of the coefficients of f, for each row, shape (r,).
        elements: the data that A_0, A_1, A_2 are assembled from, None for those that are data; None where A(s) is not just assembled.
        unresolved: bounds of what the elements still lack of A_0, A_1, ...; none where they lack nothing.
        has_exact_zeros: whether the entries of A_1 and A_2 that are zero are so for the data taken as exact numbers; False where that is
            not known.
    """

    coefficients: tuple[np.ndarray, ...]
    force: np.ndarray
    elements: tuple[Factors | None, ...] | None = None
    unresolved: tuple[np.ndarray, ...] = ()
    has_exact_zeros: bool = False

    @classmethod
    def of_elements(cls, coefficients: np.ndarray, elements: Sequence[Factors | None]) -> Rounding | None:
        """Rounding of entries that are assembled once each; None where no coefficient is."""
        if not any(elements):
            return None
        lost = [np.spacing(np.abs(A_k)) / 2 * (own is not None) for A_k, own in zip(coefficients, elements)]
        missing = max(3 - len(lost), 0)  # up to the mass matrix
        lost += [np.zeros(coefficients.shape[1:])] * missing
        return cls(tuple(lost), np.zeros(coefficients.shape[1]), (*elements, *[None] * missing))


@dataclass(frozen=True, eq=False)
class Defect:
    """The error of the values of a flow.

    Attributes:
        flow: of a small model.
        rounding: of A_0, A_1, ... and f themselves; None where they are the data.
        piece: which piece of the motion, between two knots.
        before: the error of the piece before, None for the first one.
    """

    flow: Flow
    rounding: Rounding | None = None
    piece: int = 0
    before: Defect | None = None

    def errors(self, place: np.ndarray, order: int, times: np.ndarray, allowed: np.ndarray) -> np.ndarray:
        """Bounds of the errors of this derivative of place @ z by its modes, one for all times where that is as small as allowed."""
        if self.is_whole and len(times):
            with np.errstate(all="ignore"):
                return self._late(place, order, times, allowed)
        errors, covered = np.full(len(times), np.inf), self.covers(times)
        pieces, since = self.flow.states.restarts.located(times)
        with np.errstate(all="ignore"):
            for piece in np.unique(pieces[covered]).tolist():
                at = np.flatnonzero(pieces == piece)
                errors[at] = self._pieces[piece]._late(place, order, since[at], allowed[at])
        return errors

    def covers(self, times: np.ndarray) -> np.ndarray:
        """The times at which the errors of the sums of modes are bounded: truth values, shape (T,)."""
        if self._modes is None or self.is_whole:
            return np.full(len(times), self._modes is not None)
        return self.follows_force | (self.flow.states.restarts.located(times)[0] == 0)

    @cached_property
    def has_exact_zeros(self) -> bool:
        """Whether no mass or damping is zero to rounding only, so that the data taken as exact numbers have as many states."""
        return (self.rounding is None or self.rounding.has_exact_zeros) and self.flow.reduction.has_exact_zeros

    @property
    def is_one_piece(self) -> bool:
        """Whether the motion has no restarts."""
        return len(self.flow.knots) == 1

    @cached_property
    def is_whole(self) -> bool:
        """Whether the motion has no restarts, and the errors are bounded at all times."""
        return self.is_one_piece and self._modes is not None

    @cached_property
    def in_whole_pieces(self) -> Defect | None:
        """The defect of the flow without first moments of later forces, common to all derivatives; None where no force is delayed."""
        later = len(self.flow.knots) > 1 and self.flow.force.smooth.state_count and self.flow.first_moments
        return Defect(replace(self.flow, first_moments=False), self.rounding) if later else None

    @property
    def follows_force(self) -> bool:
        """Whether the errors of the states of the force are known at its knots, as those of constant forces are."""
        smooth, lost = self.flow.force.smooth, self._force_rounding
        known = not smooth.generator.any() and not lost[smooth.restarts.states == 0].any()
        return len(smooth.restarts.knots) == 1 or known

    @cached_property
    def _force_rounding(self) -> np.ndarray:
        """The errors of the states of a constant force, sums of its jumps, shape (m, K)."""
        if self.before is not None:
            return self.before._force_rounding
        restarts = self.flow.force.smooth.restarts
        jumps, states = restarts.jumps.tolist(), restarts.states.tolist()
        lost = [[abs(fsum([*row[: k + 1], -state[k]])) for k in range(len(state))] for row, state in zip(jumps, states)]
        return np.array(lost).reshape(restarts.states.shape)

    @cached_property
    def _pieces(self) -> Sequence[Defect]:
        """The defects of all pieces, each with the errors that the pieces before leave."""
        pieces: list[Defect] = [self]
        for piece in range(1, len(self.flow.states.restarts.knots)):
            pieces.append(Defect(self.flow, self.rounding, piece, pieces[-1]))
        return pieces

    @cached_property
    def _start(self) -> np.ndarray:
        """v of the piece."""
        return self.flow.states.restarts.states[:, self.piece]

    def _at_end(self) -> np.ndarray:
        """A bound of the error in the coordinates of the modes at the start of the next piece, folded, shape (K of the own rows,)."""
        modes, own, n = self._modes, self._own, len(self._own)
        h = float(self.flow.states.restarts.gaps[self.piece])
        Q, v = modes.spread(h), modes.sizes
        start, driven, second, secular, rest = self._amplitudes(h)
        decay = np.exp(modes.rates * h)
        error = (
            (start + driven + h * (secular @ v)) * decay[:n] + second @ (v * decay) + rest * np.exp(max(modes.rates.max(), 0.0) * h)
        )
        change = self.flow.states.restarts.states[:, self.piece + 1].astype(Extended) - self._ends[:, self.piece]
        summed, radian = self._unit
        rounded = summed + 2 * radian * np.abs(modes.zeros) * h
        turned = np.repeat(rounded * (Q @ v) * decay, np.diff(np.append(modes.starts, len(modes.J))))
        states, sizes = self._start_states
        jump = (
            np.abs((states @ change - self._impulsive[0][:, self.piece + 1]).astype(float)) + self._impulsive[1][:, self.piece + 1]
        )
        jump += (len(v) + 4) * UNIT * (sizes @ np.abs(change).astype(float))
        through = np.abs((self._inverse.astype(Extended) @ states).astype(float))
        return error + np.hypot.reduceat(np.abs(self._inverse) @ jump + through @ turned, own)

    @cached_property
    def _ends(self) -> np.ndarray:
        """The states in the coordinates of the modes at the end of each piece, shape (N, K - 1)."""
        if self.before is not None:
            return self.before._ends
        restarts = self.flow.states.restarts
        return block_states(self.flow.states.blocks, restarts.states[:, :-1], restarts.gaps).astype(Extended)

    # Sums of modes.

    def _late(self, place, order, times, allowed, rounding: float | None = None) -> np.ndarray:
        """Bounds of the errors of the sums of modes, rounding errors relative to the size of their terms; one for all times where
        that is as small as allowed."""
        end = float(times.max())
        terms, constant, linear, rest = self._known_envelope(place, order, self._until(end))
        constant = constant + (self._unit[0] if rounding is None else rounding) * terms
        rates = self._modes.rates
        growth = np.exp(np.maximum(rates, 0.0) * end)
        later = rest * growth.max(initial=1.0)
        errors = np.full(len(times), (constant + end * linear) @ growth + later)
        at = np.flatnonzero(~(errors <= allowed))
        if len(at) and rest < np.inf:
            decay = np.exp(np.multiply.outer(rates, times[at]))
            errors[at] = constant @ decay + times[at] * (linear @ decay) + later
        return errors

    def _known_envelope(self, place, order: int, end: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        known, key = self._envelopes, (order, end)
        if key not in known or known[key][0] is not place:
            known[key] = place, self._envelope(place, order, end)
        return known[key][1]

    @cached_property
    def _envelopes(self) -> dict[tuple[int, float], tuple[np.ndarray, tuple[np.ndarray, np.ndarray, np.ndarray, float]]]:
        """The last bounds of each order and end."""
        return {}

    def _envelope(self, place, order: int, end: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """s, b, c and d: the error at t <= end is at most the sum of (b + c t) e^(a t), a the rates, d times the largest growth, and
        rounding errors relative to the sum of s e^(a t)."""
        modes, n, v = self._modes, len(self._own), self._modes.sizes
        Q, turned = modes.spread(end), self._unit[1]
        size = folded(self._derived(place, order), None, modes.starts)
        start, driven, second, secular, remaining = self._amplitudes(end)
        if not np.isfinite(remaining).all():
            return np.zeros(len(v)), np.zeros(len(v)), np.zeros(len(v)), np.inf
        rest = size[:, :n] @ remaining
        decaying, lasting = self._direct(place, order) if order or len(self.flow.reduction.algebraic) else (0.0, 0.0)
        rest = rest + lasting
        size, own = size.max(axis=0, initial=0.0), size[:, :n].max(axis=0, initial=0.0)
        summed = size * (Q @ v)
        constant = (own @ second) * v + decaying
        linear = turned * summed * np.abs(modes.zeros) + (own @ secular) * v
        constant[:n] += own * (start + driven)
        linear[:n] += own * (secular @ v)
        return summed, constant, linear, float(rest.max(initial=0.0))

    def _until(self, end: float) -> float:
        """The end of the piece, or of the last one the next power of two: bounds until then are known to the next evaluation."""
        if self.piece + 1 < len(self._knots):
            return float(self._gaps[self.piece])
        return 2.0 ** ceil(log2(end)) if end else 0.0

    @property
    def _gaps(self) -> np.ndarray:
        """The lengths of all pieces but the last one."""
        return self.flow.states.restarts.gaps

    @cached_property
    def _known_amplitudes(self) -> dict[float, tuple[np.ndarray, ...]]:
        return {}

    def _amplitudes(self, end: float) -> tuple[np.ndarray, ...]:
        """Errors of the states in modal coordinates, to first order from the start and the residual, by their rates."""
        if end not in self._known_amplitudes:
            self._known_amplitudes[end] = self._amplitudes_until(end)
        return self._known_amplitudes[end]

    def _amplitudes_until(self, end: float) -> tuple[np.ndarray, ...]:
        modes, n, v = self._modes, len(self._own), self._modes.sizes
        Q = modes.spread(end)
        first, second, secular, most = modes.responses(self._folded_residual, Q, end)
        start, driven = Q[:n, :n] @ self._modal_start, first @ v
        changed = end * most[:, :n] + self._inexact
        norm = changed.sum(axis=1).max(initial=0.0)
        amplitudes = start + driven + second @ v + end * (secular @ v)
        rest = changed @ amplitudes + norm**2 / (1 - norm) * amplitudes.max(initial=0.0)
        return start, driven, second, secular, rest if norm <= FIRST_ORDER else np.full(n, np.inf)

    @property
    def _unit(self) -> tuple[float, float]:
        """Rounding errors of a sum of modes relative to the size of its terms, and of a mode for each radian."""
        return EPS * (SUMMED_OF_CLUSTERS if self._modes.clustered.any() else SUMMED), EPS * TURNED

    def _derived(self, place, order: int) -> np.ndarray:
        C = self.flow.modal_output(place)
        for _ in range(order):
            C = C @ self._modes.J
        return C

    def _direct(self, place, order: int) -> tuple[np.ndarray | float, np.ndarray | float]:
        """Contribution of the residual to derivatives, the sum of C J^(k - 1 - i) E J^i v, i < k, and to algebraic coordinates.

        The first part decays with the modes, the second one, of each row, is counted with the largest growth.
        """
        n, right, total = len(self.flow.start), [self._largest], np.zeros(len(place))
        if order:
            left, steps = np.abs(self._derived(place, 0)[:, :n]), np.abs(self._modes.J)
            for _ in range(order):
                right.append(steps @ right[-1])
            for vector in right[:-1][::-1]:
                total, left = total + left @ (self._modal_residual @ vector), left @ steps[:n, :n]
        algebraic, Y = self.flow.reduction.algebraic, np.abs(full(self.flow.reduction.Y))
        through = np.abs(place).sum(axis=1).max(initial=1.0) * (Y @ (self._residual[algebraic] @ right[-1])).max(initial=0.0)
        return 0.0, total + through

    @cached_property
    def _own(self) -> np.ndarray:
        """The rows of the bounds that belong to the states of A(s), by their first states."""
        starts = self._modes.starts
        return starts[: np.searchsorted(starts, len(self.flow.start))]

    @cached_property
    def _largest(self) -> np.ndarray:
        """A bound of |e^(J t) v| e^(-a t) for each state of pairs and single zeros."""
        modes = self._modes
        return np.repeat(modes.stretch * modes.sizes, np.diff(np.append(modes.starts, len(modes.J))))

    @cached_property
    def _modes(self) -> BoundedModes | None:
        """Bounds of the modes; None where no bound of e^(J t) is known."""
        if self.before is None:
            return BoundedModes.of(self.flow.states.blocks, self._start)
        return replace(self.before._modes, sizes=np.hypot.reduceat(np.abs(self._start), self.before._modes.starts))

    @cached_property
    def _states(self) -> np.ndarray:
        """Z."""
        if self.before is not None:
            return self.before._states
        if not self.flow.force.smooth.state_count:
            return self.flow.reduction.decoupled.basis
        return self.flow.modal_states

    @property
    def _residual(self) -> np.ndarray:
        """Bounds of the residual of each mode in each row of A(s), shape (r, N)."""
        return self._residuals[1]

    @cached_property
    def _residuals(self) -> tuple[np.ndarray, np.ndarray]:
        """Residuals of the modes with their sizes, and bounds with all rounding errors, copies of force states included."""
        same = self.before is not None and (self._copies, self._resting) == (self.before._copies, self.before._resting)
        if same and not self._force_rounding.any():
            return self.before._residuals
        total, size, lost = (part.copy() for part in self._residuals_of_states)
        for copy, original in self._copies:
            for part in (total, size):
                part[:, original] += part[:, copy]
                part[:, copy] = 0.0
        if self.before is not None:
            smooth, n = self.flow.force.smooth, len(self.flow.start)
            place = smooth.restarts.located(self.flow.states.restarts.knots[[self.piece]])[0][0]
            known, own = self._force_rounding[:, place], slice(n, n + len(self._force_rounding))
            relative = np.divide(known, np.abs(smooth.restarts.states[:, place]), out=np.zeros(len(known)), where=known > 0)
            lost[:, own] += np.abs(smooth.coefficients * self._states[own, own].diagonal()) * relative
        for at in self._resting:
            for part in (total, size, lost):
                part[:, at] = 0.0
        return self._with_rounding(total, size, lost)

    @cached_property
    def _resting(self) -> list[slice]:
        """Blocks whose states are all constant."""
        return [at for at in block_slices(self.flow.states.blocks) if not self._start[at].any()]

    def _with_rounding(self, total: np.ndarray, size: np.ndarray, lost: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        terms = len(total) * len(self.flow.reduction.given) + 6
        return total.astype(float), np.abs(total).astype(float) + terms * UNIT * size + lost

    @cached_property
    def _residuals_of_states(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self._residual_of(self._states, self._modes.J) if self.before is None else self.before._residuals_of_states

    def _residual_of(self, states: np.ndarray, generator: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A_0 P Z + A_1 P Z J + A_2 P Z J^2 - F Z_v, the sizes of its terms, and bounds of the rounding errors of the data."""
        flow, n = self.flow, len(self.flow.start)
        given = [full(A) for A in flow.reduction.given]
        A, x, step = np.concatenate(given, axis=1), full(flow.output) @ states, np.abs(generator)
        columns, sizes = [x.astype(Extended)], [np.abs(x)]
        for _ in given[1:]:
            columns.append(_times(columns[-1], generator))
            sizes.append(sizes[-1] @ step)
        total, size = A.astype(Extended) @ np.concatenate(columns), np.abs(A) @ np.concatenate(sizes)
        if len(states) > n:
            F = flow.force.smooth.coefficients
            total, size = total - _times(F.astype(Extended), states[n:]), size + np.abs(F) @ np.abs(states[n:])
        lost = np.zeros(size.shape)
        if self.rounding is not None:
            lost += np.concatenate(self.rounding.coefficients, axis=1) @ np.concatenate(sizes)
            lost += np.multiply.outer(self.rounding.force, np.abs(states[n:]).sum(axis=0))
        return total, size, lost

    @cached_property
    def _copies(self) -> list[tuple[slice, slice]]:
        """States of the force evaluated together with a mode that they resonate with, and the same states alone."""
        v = self._start
        return [(copy, original) for copy, original in self.flow.copies if v[copy].any() and np.array_equal(v[copy], v[original])]

    def _driven(self, left: np.ndarray, residuals: tuple[np.ndarray, np.ndarray], generator: np.ndarray) -> np.ndarray:
        """|left B R|: contribution of residuals (r, N) of all rows to left @ w', those of algebraic rows through their derivatives.

        Errors of several rows that belong together cancel in the products, as in a quotient of Rayleigh; what is known of them by
        bounds alone does not.
        """
        signed, residual = residuals
        reduction = self.flow.reduction
        parts, sizes, rows, noise = divided_by_masses(left, reduction)
        driven = np.abs(parts @ signed[rows]) + np.abs(parts) @ (residual - np.abs(signed))[rows] + noise * (sizes @ residual[rows])
        if len(reduction.algebraic):
            right, step, matrix = [residual[reduction.algebraic]], np.abs(generator), np.concatenate(reduction.through, axis=1)
            for _ in reduction.given[1:]:
                right.append(right[-1] @ step)
            driven += (np.abs(parts @ matrix) + noise * (sizes @ np.abs(matrix))) @ np.concatenate(right)
        return driven

    @cached_property
    def _modal_residual(self) -> np.ndarray:
        """E = |X^-1 B R|, the excitation of each mode by the residual of each mode, shape (n, N)."""
        if self.before is not None and self._residuals is self.before._residuals:
            return self.before._modal_residual
        return self._driven(self._inverse, self._residuals, self._modes.J)

    @cached_property
    def _folded_residual(self) -> np.ndarray:
        return folded(self._modal_residual, self._own, self._modes.starts)

    @cached_property
    def _modal_start(self) -> np.ndarray:
        """|X^-1 (Z v - z)| at the start, folded."""
        if self.before is not None:
            return self.before._at_end()
        flow, v, (states, sizes) = self.flow, self._start, self._start_states
        defect = np.abs((states @ v.astype(Extended) - self._initial).astype(float)) + self._impulsive[1][:, 0]
        defect += (len(v) + 4) * UNIT * (sizes @ np.abs(v) + np.abs(flow.start))
        if len(flow.reduction.algebraic):  # initial values satisfy algebraic equations to rounding errors
            defect += 4 * EPS * np.abs(flow.initial).max(initial=0.0)
        return np.hypot.reduceat(np.abs(self._inverse) @ defect, self._own)

    @cached_property
    def _is_exact(self) -> bool:
        """Whether the numbers of the force are its data."""
        return is_exact(self.flow.force) if self.before is None else self.before._is_exact

    @property
    def _initial(self) -> np.ndarray:
        """The states at 0+."""
        if self.flow.impulsive is None:
            return self.flow.start.astype(Extended)
        return self.flow.reduction.state(self.flow.initial) + self._impulsive[0][:, 0]

    @property
    def _knots(self) -> np.ndarray:
        """The times at which pieces begin."""
        return self.flow.states.restarts.knots

    @cached_property
    def _impulsive(self) -> tuple[np.ndarray, np.ndarray]:
        """The jumps by impulses at each knot, M^-1 p, and bounds of their errors, shape (n, K)."""
        if self.before is not None:
            return self.before._impulsive
        flow, reduction, knots = self.flow, self.flow.reduction, self._knots
        n, m = len(flow.start), len(reduction.second)
        jumps, errors = np.zeros((n, len(knots)), dtype=Extended), np.zeros((n, len(knots)))
        if flow.impulsive is None:
            return jumps, errors
        rows, p = np.concatenate([reduction.second, reduction.first]), np.zeros((n - m, len(knots)), dtype=Extended)
        for load in (ImpulsiveLoad(0.0, flow.force.impulses), *flow.force.later):
            for impulse in load.impulses:
                p[:, knots.searchsorted(load.time)] += impulse[rows]
        B, lost = self._jumping(rows)
        inverse, result = np.linalg.inv(B.astype(float)), np.zeros(p.shape, dtype=Extended)
        for _ in range(3):
            rest = p - B @ result
            result = result + inverse @ rest.astype(float)
        rest, size, given = (np.abs(part).astype(float) for part in (p - B @ result, result, p))
        jumps[m:] = result
        uncertain = rest + lost @ size + (n + 4) * UNIT * (np.abs(B).astype(float) @ size + given)
        errors[m:] = 2 * np.abs(inverse) @ (uncertain + (0.0 if self._is_exact else FORCE_ROUNDING * EPS) * given)
        return jumps, errors

    def _jumping(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Factors of x_m'' and x_d' in the rows with masses or dampers, and bounds of its rounding errors."""
        reduction, m = self.flow.reduction, len(self.flow.reduction.second)
        given, V, Y = [full(A) for A in reduction.given], full(reduction.V).astype(Extended), np.abs(full(reduction.Y))
        bound, algebraic = np.zeros(V.shape), given[0][reduction.algebraic]
        if len(algebraic):
            V = V - full(reduction.Y) @ (algebraic.astype(Extended) @ V)
            noise = (len(V) + 4) * UNIT * (np.abs(algebraic) @ np.abs(V).astype(float))
            bound = Y @ (np.abs(algebraic.astype(Extended) @ V).astype(float) + noise)
        B, lost = np.zeros((len(rows), len(rows)), dtype=Extended), np.zeros((len(rows), len(rows)))
        for k, at in ((2, slice(m)), (1, slice(m, None))):
            A, size = given[k][rows], np.abs(given[k][rows])
            B[:, at] = A.astype(Extended) @ V[:, at]
            lost[:, at] = size @ bound[:, at] + len(V) * UNIT * (size @ np.abs(V[:, at]).astype(float))
            if self.rounding is not None and k < len(self.rounding.coefficients):
                lost[:, at] += self.rounding.coefficients[k][rows] @ np.abs(V[:, at]).astype(float)
        return B, lost

    @cached_property
    def _start_states(self) -> tuple[np.ndarray, np.ndarray]:
        """Z of the own states and its terms; velocities are those of the displacements, Z J."""
        if self.before is not None:
            return self.before._start_states
        n, m = len(self.flow.start), len(self.flow.reduction.second)
        states, sizes, step = self._states[:n].astype(Extended), np.abs(self._states[:n]), np.abs(self._modes.J)
        states[m : 2 * m], sizes[m : 2 * m] = _times(states[:m], self._modes.J), sizes[:m] @ step
        return states, sizes

    @property
    def _inverse(self) -> np.ndarray:
        return self.flow.reduction.decoupled.inverse

    @cached_property
    def _inexact(self) -> np.ndarray:
        """|X^-1 X - I| with the rounding errors of the product."""
        if self.before is not None:
            return self.before._inexact
        basis, inverse = self.flow.reduction.decoupled.basis, self._inverse
        n = len(basis)
        return folded(np.abs(inverse @ basis - np.eye(n)) + EPS * n * (np.abs(inverse) @ np.abs(basis)), self._own, self._own)

    # The Taylor series.

    def of_series(self, place: np.ndarray, order: int, times: np.ndarray) -> np.ndarray:
        """A bound of the error of place @ z by the Taylor series of the flow."""
        start = self.flow.taylor_start(modal=True)
        output, G = np.abs(place), np.abs(full(self.flow.generator))
        for _ in range(order):
            output = output @ G
        exact, changed = self._early_series
        counts = np.arange(exact.shape[1])
        series = output @ (changed + EPS * (counts + len(G) + order + 2) * exact)
        series[:, -1] += 2 * (output @ exact[:, -1])  # the terms that were left out
        if order or len(self.flow.reduction.algebraic):
            series[:, 0] += np.inf if self._modes is None else self._direct(place, order)[1]
        return series.max(axis=0) @ np.power.outer(start.unit * times, counts).T

    @cached_property
    def _early_series(self) -> tuple[np.ndarray, np.ndarray]:
        """|G|^k |z| / k! and their changes by the residual of G, as columns, in the unit of time of the series."""
        flow, start = self.flow, self.flow.taylor_start(modal=True)
        G, n = full(flow.generator), len(flow.start)
        step = kept(np.abs(G) / start.unit)
        change = self._driven(np.eye(n), self._with_rounding(*self._residual_of(np.eye(len(G)), G)), G) / start.unit
        columns, changed = [np.abs(flow.start_with_force)], [np.zeros(len(G))]
        if len(flow.reduction.algebraic):
            changed[0][:n] = 4 * EPS * np.abs(flow.initial).max(initial=0.0)
        changed[0][:n] += np.abs((self._initial - flow.start).astype(float)) + self._impulsive[1][:, 0]
        for k in range(1, start.powers.shape[1]):
            changed.append(step @ changed[-1] / k)
            changed[-1][:n] += change @ columns[-1] / k
            columns.append(step @ columns[-1] / k)
        return np.array(columns).T, np.array(changed).T


def _times(x: np.ndarray, J: np.ndarray) -> np.ndarray:
    """x @ J in extended precision, which has no fast products; most J have few entries in a column."""
    if len(J) <= 12:
        return x @ J.astype(Extended)
    row, column = J.nonzero()
    if len(column) > FEW_ENTRIES * J.shape[1]:
        return x @ J.astype(Extended)
    order = np.argsort(column, kind="stable")
    row, column = row[order], column[order]
    product, (filled, first) = np.zeros((len(x), J.shape[1]), dtype=Extended), np.unique(column, return_index=True)
    if len(first):
        product[:, filled] = np.add.reduceat(x[:, row] * J[row, column], first, axis=1)
    return product


def are_right(values: np.ndarray, errors: np.ndarray, accuracy: float = PROVED_ACCURACY) -> np.ndarray:
    """Which values are right to this accuracy relative to the largest one at their time."""
    return errors <= accuracy * np.abs(values).max(axis=0, initial=0.0)


def is_exact(force: ImpulsiveSmooth) -> bool:
    """Whether the numbers of a force are its data, without a rounding error: functions of time that differ, and impulses at different times."""
    functions: list[tuple] = []
    for part in force.exact_parts:
        if part.maps or part.derivatives:
            return False
        if isinstance(part.data, ExactImpulse):
            functions.append((part.rounded_time(), part.data.order))
        elif isinstance(part.data, ExactTerm) and part.data.phase == 0 and part.data.divisor == 1:
            functions.append((None, part.data.rate, part.data.angular_frequency))
            if part.delays and functions[-1][1:] != (0.0, 0.0):
                return False
        else:
            return False
    return len(set(functions)) == len(functions)


def divided_by_masses(left: np.ndarray, reduction: Reduction) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """left B, the effect of residuals of some rows of A(s) on left @ w', with the sizes of its terms, these rows, and its noise."""
    m, M = len(reduction.second), np.linalg.inv(full(reduction.M))
    parts, sizes, rows = left[:, m : 2 * m] @ M, np.abs(left[:, m : 2 * m]) @ np.abs(M), reduction.second
    if len(reduction.first):
        C = full(reduction.C)
        inverse, between = np.linalg.inv(C[m:, m:]), C[:m, m:]
        rates, size = (left[:, 2 * m :] - parts @ between) @ inverse, np.abs(left[:, 2 * m :]) + sizes @ np.abs(between)
        parts, sizes = np.concatenate([parts, rates], axis=1), np.concatenate([sizes, size @ np.abs(inverse)], axis=1)
        rows = np.concatenate([rows, reduction.first])
    return parts, sizes, rows, len(left) * DIVISOR_CONDITION * EPS
