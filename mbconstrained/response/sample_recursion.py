"""Samples of A(sigma) x = f from rest by a recursion in float64, refined by residuals with twice the digits.

A start acts like a force before k = 0: X_in(z), the sum of b_p z^p, is the transform of f_(-p-1) = b_p. So one recursion gives the free
motion, also from a start that the equations do not admit, and the response to the force. Each pass solves for the residual that the sum
of those before leaves in the given equations, whose terms are exact products of float64 numbers. The last residual, carried along by
absolute values in decoupled coordinates, bounds the error: as few digits cancel there as the system itself cancels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import isqrt

import numpy as np
import scipy.linalg

from ..ground.tolerances import EPS, LEAST_NUMBER
from ..linalg.blocks import block_diagonalize, block_slices
from ..linalg.division import solution, split
from ..linalg.double_double import DOUBLED_EPS, DoubleDouble
from ..polynomial.jordan_pairs import JordanPairs
from ..polynomial.polynomial_matrix import PolynomialMatrix

#: Relative error, of the largest entry of a sample, up to which it needs no more digits.
SETTLED = 2.0**-56

#: A pass gains the digits that the recursion keeps; where it gains less than this factor it is the last one.
MOST_PASSES, LEAST_GAIN = 6, 2.0**-4

#: Leading coefficients of the rows with a larger condition are left to rank decisions.
REGULAR_CONDITION = EPS**-0.5

#: Sums with twice the digits are formed of so many numbers at once, which fit into the cache.
TOGETHER = 1 << 13

#: Sums of bounds are themselves rounded.
ROUNDED_SUM = 1 + 2.0**-10


@dataclass(frozen=True, repr=False, eq=False)
class ShiftRecursion:
    """A(sigma)^-1 in float64: w_(k+1) = step w_k + input g_k, x_k = output w_k + taps_0 g_k + taps_1 g_(k+1) + ...

    Attributes:
        coefficients: A_0 ... A_q, each row shifted forwards; g is f shifted so.
        shifts: the samples by which each row is shifted, shape (r,).
        step, input, output: shapes (n, n), (n, r), (r, n).
        taps: arrays (r, r).
        rounding: the rounding error of step, relative to its terms.
        lead: factors of f_k, f_(k+1), ... in the right side of other equations than A(sigma) x = f, of which x are the last rows.
    """

    coefficients: np.ndarray
    shifts: np.ndarray
    step: np.ndarray
    input: np.ndarray
    output: np.ndarray
    taps: tuple[np.ndarray, ...]
    rounding: float
    lead: tuple[np.ndarray, ...] = ()

    @classmethod
    def of_rows(cls, A: PolynomialMatrix) -> ShiftRecursion | None:
        """The recursion by the highest powers of the rows of A; None where their coefficients are no regular matrix."""
        given, q, r = A.coefficients, A.degree, A.size
        filled = (given != 0).any(axis=2)
        if not filled.any(axis=0).all():
            return None
        shifts = np.argmax(filled[::-1], axis=0)
        shifted = np.stack([[given[j - s, i] if j >= s else np.zeros(r) for i, s in enumerate(shifts)] for j in range(q + 1)])
        leading = shifted[-1]
        if r and not np.linalg.cond(leading / np.abs(leading).max(axis=1)[:, None]) <= REGULAR_CONDITION:
            return None
        inverse = solution(leading, np.eye(r))
        rounding = EPS * (r + 4) * float((np.abs(inverse) @ np.abs(leading)).max(initial=0.0))
        if not q:
            return cls(shifted, shifts, np.zeros((0, 0)), np.zeros((0, r)), np.zeros((r, 0)), (inverse,), rounding)
        step, entry = np.eye(q * r, k=r), np.zeros((q * r, r))
        step[-r:], entry[-r:] = -inverse @ np.hstack(list(shifted[:-1])), inverse
        return cls(shifted, shifts, step, entry, np.eye(r, q * r), (), rounding)

    @classmethod
    def of_pairs(cls, A: PolynomialMatrix, pairs: JordanPairs) -> ShiftRecursion:
        """The recursion by the finite and the infinite Jordan pair."""
        finite = pairs.finite
        H = tuple(pairs.laurent(i) for i in range(pairs.structure.highest_impulse + 1))
        rounding = EPS * (len(finite.J) + 4) * (1 + finite.coupling)
        return cls(A.coefficients, np.zeros(A.size, dtype=int), finite.J, finite.B, finite.C, H, rounding)

    @classmethod
    def realized(cls, pairs: JordanPairs) -> ShiftRecursion | None:
        """The recursion of z w - J w = B f, x - C w = H_0 f + H_1 z f + ..., the numbers of the Jordan pairs taken exactly."""
        C, J, B = pairs.finite.C, pairs.finite.J, pairs.finite.B
        H = [pairs.laurent(i) for i in range(max(pairs.structure.highest_impulse + 1, 1))]
        (r, n), sizes = C.shape, [len(J), len(C)]
        A = PolynomialMatrix([np.block([[-J, np.zeros((n, r))], [-C, np.eye(r)]]), np.diag(np.repeat([1.0, 0.0], sizes))])
        recursion = cls.of_rows(A)
        lead = tuple(np.vstack([B if not i else 0.0 * B, matrix]) for i, matrix in enumerate(H))
        return None if recursion is None else replace(recursion, lead=lead)

    @property
    def cost(self) -> int:
        """The number of products that the residual of a sample takes."""
        return int(np.count_nonzero(self.coefficients))

    def solved(self, forces: np.ndarray) -> np.ndarray:
        """x from rest in float64 under g (r, T), zero afterwards, shape (r, T)."""
        return _response(self.output, self.step, self.input, self.taps, forces)

    def shifted(self, forces: DoubleDouble) -> DoubleDouble:
        """g of f (r, T), zero before and afterwards."""
        high, low = np.zeros(forces.shape), np.zeros(forces.shape)
        for row, shift in enumerate(self.shifts):
            end = forces.shape[1] - shift
            high[row, :end], low[row, :end] = forces.high[row, shift:], forces.low[row, shift:]
        return DoubleDouble(high, low)

    def corrected(self, rest: np.ndarray, sizes: np.ndarray, change: np.ndarray) -> np.ndarray:
        """A bound of the residual after a change of x, in float64, from the one before and its bound, shape (r, T)."""
        count = max(rest.shape[1] - len(self.coefficients) + 1, 0)
        parts = [change[:, power : power + count] for power in range(len(self.coefficients))]
        left, size = rest[:, :count].copy(), np.abs(rest[:, :count])
        for matrix, part in zip(self.coefficients, parts):
            left -= matrix @ part
            size += np.abs(matrix) @ np.abs(part)
        bound = np.abs(left) + self._terms * EPS * size + 2 * (sizes[:, :count] - np.abs(rest[:, :count]))
        return np.pad(bound, ((0, 0), (0, rest.shape[1] - count)))

    @cached_property
    def _terms(self) -> int:
        """Number of terms of a residual."""
        return 2 + int(np.count_nonzero(self.coefficients, axis=(0, 2)).max(initial=0))

    def residual(self, forces: DoubleDouble, samples: DoubleDouble) -> tuple[np.ndarray, np.ndarray]:
        """g - A(sigma) x where the window has all terms, zero elsewhere, and a bound of the true residual, shapes (r, T)."""
        count = max(forces.shape[1] - len(self.coefficients) + 1, 0)
        parts = [samples[:, power : power + count] for power in range(len(self.coefficients))]
        rest = remainder(forces[:, :count], self.coefficients, parts)
        size = np.abs(forces.high[:, :count])
        for matrix, part in zip(self.coefficients, parts):
            size = size + np.abs(matrix) @ np.abs(part.high)
        lost = np.where(size > 0, self._terms**2 * (DOUBLED_EPS * size + EPS * LEAST_NUMBER), 0.0)
        wide = ((0, 0), (0, forces.shape[1] - count))
        return np.pad(rest.high, wide), np.pad((1 + 2 * EPS) * np.abs(rest.high) + lost, wide)

    @cached_property
    def _sizes(self) -> tuple[np.ndarray, ...]:
        """Absolute values of output, step and input in decoupled coordinates, and of the taps."""
        triangle, turn = scipy.linalg.schur(self.step) if len(self.step) else (self.step, self.step)
        parts = block_diagonalize(triangle)
        V, W = (turn @ parts.basis).astype(complex), (parts.inverse @ turn.T).astype(complex)
        for block, at in zip(parts.blocks, block_slices(parts.blocks)):
            rotation = scipy.linalg.schur(block, output="complex")[1]
            V[:, at], W[at] = V[:, at] @ rotation, rotation.conj().T @ W[at]
        rounding = 4 * self.rounding * (np.abs(W) @ np.abs(self.step) @ np.abs(V))
        step = np.abs(W @ self.step @ V) + rounding
        return np.abs(self.output @ V), step, np.abs(W @ self.input), *map(np.abs, self.taps)

    def propagated(self, residuals: np.ndarray) -> np.ndarray:
        """A bound of the largest entry of x at each sample under residuals of these sizes, shape (T,)."""
        output, step, entry, *taps = self._sizes
        return ROUNDED_SUM * _response(output, step, entry, taps, residuals).max(axis=0, initial=0.0)


def _response(output, step, entry, taps, forces: np.ndarray) -> np.ndarray:
    values = output @ _states(step, entry @ forces)
    for shift, tap in enumerate(taps):
        values[:, : max(values.shape[1] - shift, 0)] += tap @ forces[:, shift:]
    return values


def _states(step: np.ndarray, gained: np.ndarray) -> np.ndarray:
    """w_0 = 0, w_(k+1) = step w_k + g_k of g (n, T), shape (n, T): all groups of steps at once, from group to group, and again."""
    n, count = gained.shape
    length = max(isqrt(count), 1)
    groups = -(-count // length)
    each = np.zeros((groups * length, n))
    each[:count] = gained.T
    each = np.ascontiguousarray(each.reshape(groups, length, n).transpose(1, 2, 0))
    now = np.zeros((n, groups))
    for own in each:
        now = step @ now + own
    across = np.linalg.matrix_power(step, length)
    for group in range(1, groups):
        now[:, group] += across @ now[:, group - 1]
    now[:, 1:], now[:, :1] = now[:, :-1].copy(), 0.0
    for own in each:
        now, own[:] = step @ now + own, now
    return each.transpose(2, 0, 1).reshape(groups * length, n)[:count].T


def remainder(start: DoubleDouble, matrices: Sequence[np.ndarray] | np.ndarray, numbers: Sequence[DoubleDouble]) -> DoubleDouble:
    """start - sum of A x of matrices A and numbers x (r, T), as with twice the digits (Ogita, Rump and Oishi 2005), some columns at a time."""
    high, low = np.array(start.high), np.array(start.low)
    width = max(TOGETHER // max(len(high), 1), 1)
    halves = [(columns, entries, *split(entries)) for columns, entries in map(_nonzero, matrices)]
    for begin in range(0, high.shape[1], width):
        at = slice(begin, begin + width)
        total, rest = high[:, at], low[:, at]
        for (columns, *entries), own in zip(halves, numbers):
            x, lost = own.high[:, at], own.low[:, at]
            (one, other), is_doubled = split(x), lost.any()
            for places, a, b, c in zip(columns, *(part[..., None] for part in entries)):
                j = places[0] if (places == places[0]).all() else places
                product = a * x[j]
                error = ((b * one[j] - product) + b * other[j] + c * one[j]) + c * other[j]
                if is_doubled:
                    error += a * lost[j]
                before, total = total, total - product
                shift = total - before
                rest -= error - ((before - (total - shift)) - (product + shift))
        high[:, at] = total + rest
        low[:, at] = rest - (high[:, at] - total)
    return DoubleDouble(high, low)


def _nonzero(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The columns of the nonzero entries of each row, ascending, with these, shape (any, r); zeros in rows that have fewer."""
    most = np.count_nonzero(matrix, axis=1).max(initial=0)
    columns = np.argsort(matrix == 0, axis=1, kind="stable")[:, :most]
    return columns.T, np.take_along_axis(matrix, columns, axis=1).T


def product(matrix: np.ndarray, numbers: DoubleDouble) -> DoubleDouble:
    """matrix @ numbers, of shape (r, T), with twice the digits."""
    return remainder(DoubleDouble.of(np.zeros((len(matrix), numbers.shape[1]))), [-matrix], [numbers])


def with_start(coefficients: np.ndarray, initial: np.ndarray, forces: DoubleDouble) -> DoubleDouble:
    """The force from k = -q on with the values x_0 ... x_(q-1) in the place of the start, shape (r, q + T)."""
    q = len(initial)
    start = DoubleDouble.of(np.pad(initial.T, ((0, 0), (q, 0))))
    parts = [start[:, power : power + q] for power in range(q + 1)]
    pulses = remainder(DoubleDouble.of(np.zeros((len(forces.high), q))), -coefficients, parts)
    return DoubleDouble(np.hstack([pulses.high, forces.high]), np.hstack([pulses.low, forces.low]))


def _led(lead: Sequence[np.ndarray], forces: DoubleDouble) -> DoubleDouble:
    """The sum of lead_i f_(k+i), f zero after the last one."""
    high, low = (np.pad(part, ((0, 0), (0, len(lead)))) for part in (forces.high, forces.low))
    parts = [DoubleDouble(high[:, i:], low[:, i:])[:, : forces.shape[1]] for i in range(len(lead))]
    return remainder(DoubleDouble.of(np.zeros((len(lead[0]), forces.shape[1]))), [-matrix for matrix in lead], parts)


def refined(recursion: ShiftRecursion, forces: DoubleDouble) -> tuple[np.ndarray, np.ndarray]:
    """x from rest under f (r, T), zero before and afterwards, entries below their error zero, and errors relative to the largest.

    Returns:
        Values, shape (r, T), and bounds of their errors, shape (T,), neither finite where they leave the range of float64.
    """
    size, count = forces.shape
    reach = len(recursion.coefficients) + len(recursion.taps)  # each pass looks so far backwards and ahead
    ahead = int(recursion.shifts.max(initial=0)) + len(recursion.lead) + MOST_PASSES * reach
    wide = ((0, 0), (ahead, ahead))
    f = DoubleDouble(np.pad(forces.high, wide), np.pad(forces.low, wide))
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        g = recursion.shifted(_led(recursion.lead, f) if recursion.lead else f)
        x, rest, sizes = DoubleDouble.of(np.zeros(g.shape)), g.high, np.abs(g.high)
        bounds = errors = np.full(count, np.inf)
        own = slice(ahead, ahead + count)

        def bounded(sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            bounds = recursion.propagated(sizes)[own]
            return bounds, np.divide(bounds, largest, out=np.zeros(count), where=bounds != 0)

        for number in range(MOST_PASSES):
            change, last = recursion.solved(rest), errors
            x = x + change
            largest = np.abs(x.high[-size:, own]).max(axis=0, initial=0.0)
            if number:
                bounds, errors = bounded(recursion.corrected(rest, sizes, change))
            if not (errors <= SETTLED).all():
                rest, sizes = recursion.residual(g, x)
                bounds, errors = bounded(sizes)
            if (errors <= SETTLED).all() or not (errors < LEAST_GAIN * last)[errors > SETTLED].any():
                break
        values = np.where(np.abs(x.high[-size:, own]) > bounds, x.high[-size:, own], 0.0)
    is_finite = np.isfinite(largest) & np.isfinite(errors)
    return np.where(is_finite, values, np.inf), np.where(is_finite, errors, np.inf)
