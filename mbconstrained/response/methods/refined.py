"""Separate modes of few states, corrected by their residual with twice the digits of float64, and a bound of the error of their sums.

First-order perturbation of eigenpairs (Stewart and Sun, "Matrix Perturbation Theory", V.2): the residual of a mode in the equations as
they were given, in the coordinates of all modes, is what its pole and its shape lack. The response to a state of the force is corrected
like a free mode, from zero. Each correction squares the relative error. Matrices that are given by their elements are multiplied element
by element, so that soft springs next to stiff ones keep their digits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from ...ground.tolerances import EPS, LEAST_NUMBER
from ...linalg.arrays import block_diag, full
from ...linalg.blocks import CHUNK_ENTRIES
from ...linalg.division import accurate_product, sum_with_error
from ...linalg.double_double import DOUBLED_EPS, EXPONENTIAL_EPS, DoubleDouble, exponential, outer, stacked, turns
from ...linalg.exponential import even_step
from ...polynomial.coefficients import Factors
from ...polynomial.reduced_equations import Reduction
from ...signals.bohl import BohlFunction, FreeRestarts, Restarts
from ..flow import Flow
from .defect import FORCE_ROUNDING, BoundedModes, Defect, are_right, divided_by_masses

#: Rounding errors of a sum of modes in float64, whose phases are more precise, in units of EPS relative to the size of its terms.
SUMMED_IN_FLOAT64 = 12.0

#: Residuals are corrected to first order up to this part of the distance of two poles.
SMALL_RESIDUAL = 2.0**-10

#: A force within this part of a pole resonates with its mode.
RESONANCE = 2.0**-30

#: After a correction smaller than this what is left is below rounding errors of exponentials; at most so many.
LAST_CORRECTION, CORRECTIONS = 2.0**-36, 8

#: The residual after a correction smaller than this is the one before and its change, which float64 computes to the same digits.
SMALL_CORRECTION = 2.0**-44

#: The inverse follows corrections of modes that are larger.
LARGE_CORRECTION = 2.0**-26

#: A change of poles below this part of them mixes no modes.
MIXING_CHANGE = 2.0**-66

#: Condition of eigenvectors of a block of several poles up to which these are separate.
SEPARATE = 2.0**20

#: Fewer even times than these are not worth a table.
FEWEST_EVEN = 64

#: Solutions by an approximate inverse end with a residual of this part of the right side, after so many steps at most.
LAST_REST, STEPS = 2.0**-72, 4

#: The elements that A_0, A_1, A_2 consist of; None for a matrix whose entries are data.
Elements = tuple[Factors | None, ...]

ENTIRE: Elements = (None, None, None)


@dataclass(frozen=True, eq=False)
class RefinedModes:
    """w = W e^(L t) b: n free modes, then the responses to the m states of the force; complex pairs side by side.

    Attributes:
        poles: the leading ones on and above the real axis, of the diagonal of L.
        shapes: x of the leading modes, shape (r, L).
        states: the leading columns of W, n rows.
        left: approximate inverse of the first n columns of W, shape (n, n).
        leading: the leading poles, as indices.
        above: those above the real axis; their conjugates are the next ones.
        rows: bounds of the residual of each mode in each row of A(s), shape (r, n + m).
        parts: the effect of residuals of rows with masses or dampers on each free mode, bounds with the rounding errors of the inverses.
        driven: bounds of the effect of the residual of each mode on each free mode, shape (n, n + m).
    """

    poles: DoubleDouble
    shapes: DoubleDouble
    states: DoubleDouble
    left: np.ndarray
    leading: np.ndarray
    above: np.ndarray
    rows: np.ndarray
    parts: np.ndarray
    driven: np.ndarray

    @classmethod
    def of(cls, flow: Flow, elements: Elements, unresolved: tuple[np.ndarray, ...] = ()) -> RefinedModes | None:
        """Refined modes; None where modes are not separate, or a force is a ramp."""
        reduction, blocks = flow.reduction, flow.force.smooth.blocks
        if not all(map(_turns_evenly, blocks)):
            return None
        free = reduction.decoupled
        own, forced = _Separated.of(free.blocks), _Separated.of(blocks)
        if own is None or forced is None:
            return None
        n, m = len(flow.start), len(reduction.second)
        given, above = np.concatenate([own.poles, forced.poles]), np.concatenate([own.pairs, n + forced.pairs])
        first = np.ones(len(given), dtype=bool)
        first[above + 1] = False
        leading = np.flatnonzero(first)
        at = np.arange(np.count_nonzero(leading < n))
        of_modes, conjugate = leading[at], np.arange(n)
        conjugate[own.pairs], conjugate[own.pairs + 1] = own.pairs + 1, own.pairs
        left, start = own.back @ free.inverse, np.zeros((len(full(flow.output)), len(leading)), dtype=complex)
        start[:, at] = full(flow.output)[:, :n] @ (free.basis @ own.turn[:, of_modes])
        equations = _RefinedEquations.of(flow, elements)
        residual = equations.residual(DoubleDouble.of(start), DoubleDouble.of(given[leading]), leading)
        Y, eliminated = full(reduction.Y), [-full(matrix) for matrix in reduction.through]
        parts, sizes, _, noise = divided_by_masses(left, reduction)
        largest, step, turned = np.ones(len(leading)), 0, False
        for _ in range(CORRECTIONS):
            shapes, poles = residual.shapes, residual.poles
            change = parts @ _eliminated(reduction, residual.values, poles.high, eliminated)
            others, rest = (_whole(part[at], leading[at], own.pairs, n) for part in (poles.high, poles.low))
            distance = (poles.high - others[:, None]) + (poles.low - rest[:, None])
            is_pair = np.isin(of_modes, own.pairs)
            turned = not turned and bool(
                groups := _mixed(change[of_modes][:, at], distance[of_modes][:, at], poles.high[at], is_pair)
            )
            if turned:  # the next step corrects the combined modes
                high, low = poles.high.copy(), poles.low.copy()
                for group, values, turn in groups:
                    shape = shapes.high[:, group] @ turn
                    shapes.high[:, group], shapes.low[:, group] = shape, 0.0
                    places = of_modes[group]
                    left[places] = np.linalg.solve(turn, left[places])
                    left[places + 1] = left[places].conj()
                    separate = poles[np.repeat(group[:1], len(group))] + values
                    high[group], low[group] = separate.high, separate.low
                residual = equations.residual(shapes, DoubleDouble(high, low), leading)
                parts, sizes, _, noise = divided_by_masses(left, reduction)
                continue
            small = np.abs(distance) > RESONANCE * np.abs(poles.high)
            small[:, at] = np.abs(change[:, at]) < SMALL_RESIDUAL * np.abs(distance[:, at])
            corrections = np.divide(change, distance, out=np.zeros_like(change), where=small)
            bent = -_whole(shapes.high[:, at], leading[at], own.pairs, n) @ corrections
            size = np.abs(corrections).max(axis=0, initial=0.0)
            if len(reduction.algebraic):
                slaved = Y @ residual.values[reduction.algebraic]
                size = np.maximum(size, np.abs(slaved).max(axis=0) / (np.abs(shapes.high).max(axis=0) + LEAST_NUMBER))
                bent -= slaved
            moved = np.zeros(len(leading), dtype=complex)
            moved[at] = -change[of_modes, at]
            if not step:
                largest[len(at) :] = size[len(at) :]
            step += 1
            if size.max(initial=0.0) <= SMALL_CORRECTION:
                residual = equations.changed(residual, bent, moved)
                break
            residual = equations.residual(shapes + bent, poles + moved, leading)
            if (size <= LAST_CORRECTION * largest).all():
                break
            if size[at].max(initial=0.0) > LARGE_CORRECTION:
                left = left + _paired(corrections[:, at], leading[at], own.pairs, conjugate) @ left
                parts, sizes, _, noise = divided_by_masses(left, reduction)
        shapes, poles, uncertain = residual.shapes, residual.poles, residual.errors
        for order, matrix in enumerate(unresolved):
            uncertain = uncertain + matrix @ np.abs(shapes.high) * np.abs(poles.high) ** order
        bound = np.abs(residual.values) + uncertain
        known, effects = _eliminated(reduction, residual.values, poles.high, eliminated), np.abs(parts) + noise * sizes
        uncertain, most = _eliminated_sizes(reduction, (uncertain, bound), poles.high)
        driven, of_rows = np.zeros((n, len(given))), np.zeros((len(bound), len(given)))
        driven[:, leading] = np.abs(parts @ known) + np.abs(parts) @ uncertain + noise * (sizes @ most)
        of_rows[:, leading] = bound
        driven[:, above + 1], of_rows[:, above + 1] = driven[conjugate][:, above], of_rows[:, above]
        moving, velocities = shapes[reduction.chosen], residual.first[reduction.chosen[:m]]
        states = stacked(moving[:m], velocities, moving[m:])
        return cls(poles, shapes, states, left, leading, above, of_rows, effects, driven)

    @property
    def free(self) -> int:
        """The number of leading poles of free modes."""
        return int(np.count_nonzero(self.leading < len(self.left)))

    @cached_property
    def weights(self) -> np.ndarray:
        """2 for leading poles of pairs, of which the sum with the conjugate is taken, 1 for others."""
        weights = np.ones(len(self.leading))
        weights[self.leading.searchsorted(self.above)] = 2.0
        return weights

    def whole(self, values: np.ndarray) -> np.ndarray:
        """Values of all poles from those of the leading ones, along the last axis."""
        return _whole(values, self.leading, self.above, self.rows.shape[1])

    @property
    def residual(self) -> float:
        """The largest change of a mode by residuals, relative to its pole or its distance from others."""
        n = len(self.left)
        poles = self.whole(self.poles.high)[:n]
        distance = np.maximum(np.abs(np.subtract.outer(poles, poles)), np.abs(poles)[:, None])
        with np.errstate(divide="ignore", invalid="ignore"):  # of poles that coincide at zero: infinite, or not a number
            return float(np.max(self.driven[:, :n] / distance, initial=0.0))

    @cached_property
    def turns(self) -> tuple[DoubleDouble, DoubleDouble]:
        """The poles as growth in powers of two and in full turns, each per second."""
        return turns(self.poles)

    @cached_property
    def exponentials(self) -> dict[bytes, _Exponentials]:
        """Exponentials at the last even times, which displacement, velocity and acceleration have in common."""
        return {}

    @cached_property
    def inexact(self) -> np.ndarray:
        """|X^-1 X - I| of the approximate inverse, with the rounding errors of the product."""
        n = len(self.left)
        basis = self.whole(self.states.high)[:, :n]
        return np.abs(self.left @ basis - np.eye(n)) + EPS * (n + 2) * (np.abs(self.left) @ np.abs(basis))

    def solved(self, right: DoubleDouble) -> tuple[DoubleDouble, np.ndarray]:
        """X^-1 @ right of states (n, K) for the leading modes, and bounds of its error for all, to first order."""
        n, count = len(self.left), self.free
        result, weights = DoubleDouble.of(np.zeros((count, right.shape[1]), dtype=complex)), self.weights[:count, None]
        X, back, rest, largest = (
            self.states[:, :count],
            self.left[self.leading[:count]],
            right,
            np.abs(right.high).max(axis=0, initial=0.0),
        )
        errors = 0.0
        for _ in range(STEPS):
            change = back @ rest.high
            result, left = result + change, rest.high
            if (np.abs(left) <= SMALL_CORRECTION * largest).all():
                left = left - (X.high @ (weights * change)).real
                errors = (n + 4) * EPS * (np.abs(rest.high) + np.abs(X.high) @ (weights * np.abs(change)))
                break
            rest = right - self.summed(X, result, weights)
            left = rest.high
            if (np.abs(left) <= LAST_REST * largest).all():
                break
        sizes = np.abs(X.high) @ (weights * np.abs(result.high)) + np.abs(right.high) + LEAST_NUMBER
        return result, np.abs(self.left) @ (np.abs(left) + errors + (n + 4) * DOUBLED_EPS * sizes)

    @staticmethod
    def summed(states: DoubleDouble, amplitudes: DoubleDouble, weights: np.ndarray) -> DoubleDouble:
        """The real part of states @ amplitudes with the conjugate modes."""
        columns, factors = DoubleDouble(states.high.T, states.low.T)[..., None], amplitudes.scaled(weights)[:, None]
        return (stacked(columns.real, -columns.imag) * stacked(factors.real, factors.imag)).sum()


def _paired(matrix: np.ndarray, leading: np.ndarray, above: np.ndarray, conjugate: np.ndarray) -> np.ndarray:
    """A real matrix in the coordinates of all modes from the columns of the leading ones."""
    result = np.zeros((len(matrix), len(matrix)), dtype=complex)
    result[:, leading] = matrix
    result[:, above + 1] = result[conjugate][:, above].conj()
    return result


def _whole(values: np.ndarray, leading: np.ndarray, above: np.ndarray, count: int) -> np.ndarray:
    result = np.zeros((*values.shape[:-1], count), dtype=values.dtype)
    result[..., leading] = values
    result[..., above + 1] = result[..., above].conj()
    return result


@dataclass(frozen=True, eq=False)
class _Separated:
    """Blocks of single zeros and pairs as turn @ diag(poles) @ back; pairs are the first indices of pairs."""

    poles: np.ndarray
    pairs: np.ndarray
    turn: np.ndarray
    back: np.ndarray

    @classmethod
    def of(cls, blocks: Sequence[np.ndarray]) -> _Separated | None:
        if not blocks:
            none = np.zeros((0, 0), dtype=complex)
            return cls(none.reshape(0), np.zeros(0, dtype=int), none, none)
        if any(
            len(block) > 2 or (len(block) == 2 and not -block[0, 1] * block[1, 0] > ((block[0, 0] - block[1, 1]) / 2) ** 2)
            for block in blocks
        ):
            return cls._by_eigenvectors(blocks)
        sizes = np.array([len(block) for block in blocks], dtype=int)
        starts, count = np.cumsum(sizes) - sizes, int(sizes.sum())
        poles, turn, back = (matrix.astype(complex) for matrix in (np.zeros(count), np.eye(count), np.eye(count)))
        poles[starts[sizes == 1]] = [block[0, 0] for block in blocks if len(block) == 1]
        pairs = starts[sizes == 2]
        if len(pairs):
            (a, b), (c, d) = np.array([block for block in blocks if len(block) == 2]).transpose(1, 2, 0)
            square = -b * c - ((a - d) / 2) ** 2
            w = np.where((a == d) & (b == -c), np.abs(b), np.sqrt(square))
            poles[pairs] = (a + d) / 2 + 1j * w
            poles[pairs + 1] = poles[pairs].conj()
            lower, divisor = (poles[pairs] - a) / b, -2j * w / b
            turn[pairs, pairs] = turn[pairs, pairs + 1] = 1
            turn[pairs + 1, pairs], turn[pairs + 1, pairs + 1] = lower, lower.conj()
            back[pairs, pairs], back[pairs, pairs + 1] = lower.conj() / divisor, -1 / divisor
            back[pairs + 1, pairs], back[pairs + 1, pairs + 1] = -lower / divisor, 1 / divisor
        return cls(poles, pairs, turn, back)

    @classmethod
    def _by_eigenvectors(cls, blocks: Sequence[np.ndarray]) -> _Separated | None:
        """Eigenvectors of blocks of several poles, each with its pairs first; None where these are not separate."""
        poles, pairs, turns, begin = [], [], [], 0
        for block in blocks:
            values, vectors = np.linalg.eig(block.astype(complex))
            above = np.flatnonzero(values.imag > 0)
            alone = np.flatnonzero(values.imag == 0)
            if 2 * len(above) + len(alone) != len(block) or not np.linalg.cond(vectors) < SEPARATE:
                return None
            order = np.zeros(2 * len(above), dtype=int)
            order[::2] = order[1::2] = above
            values, vectors = (np.concatenate([part[..., order], part[..., alone]], axis=-1) for part in (values, vectors))
            odd = np.arange(1, len(order), 2)
            values[odd], vectors[:, odd] = values[odd].conj(), vectors[:, odd].conj()
            pairs.append(begin + odd - 1)
            poles.append(values)
            turns.append(vectors)
            begin += len(block)
        turn = block_diag(*turns)
        return cls(np.concatenate(poles), np.concatenate(pairs), turn, block_diag(*map(np.linalg.inv, turns)))


def _mixed(
    change: np.ndarray, distance: np.ndarray, poles: np.ndarray, is_pair: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Groups of pairs that are not yet separate, their poles relative to the first one's, and the combinations that separate them."""
    size = np.sqrt(np.abs(change * change.T))
    mixed = ~(size < SMALL_RESIDUAL * np.abs(distance)) & (size > MIXING_CHANGE * np.abs(poles))
    np.fill_diagonal(mixed, False)
    if not mixed.any():
        return []
    result, which = [], scipy.sparse.csgraph.connected_components(scipy.sparse.csr_array(mixed), directed=False)[1]
    for number in range(which.max() + 1):
        group = np.flatnonzero(which == number)
        if len(group) < 2 or not is_pair[group].all():
            continue
        values, turn = np.linalg.eig(np.diag(distance[group[0], group]) - change[np.ix_(group, group)])
        if np.linalg.cond(turn) < SEPARATE:
            result.append((group, values, turn))
    return result


def _eliminated(reduction: Reduction, residual: np.ndarray, poles: np.ndarray, through: Sequence[np.ndarray]) -> np.ndarray:
    """Residuals at some poles of the rows with masses or dampers, those of algebraic rows through the coordinates that these eliminate."""
    result, part = residual[np.concatenate([reduction.second, reduction.first])], residual[reduction.algebraic]
    for matrix in through if len(part) else ():
        result, part = result + matrix @ part, part * poles
    return result


def _eliminated_sizes(reduction: Reduction, bounds: Sequence[np.ndarray], poles: np.ndarray) -> list[np.ndarray]:
    """Bounds of residuals after the same elimination as the residuals."""
    rest, Y = np.concatenate([reduction.second, reduction.first]), np.abs(full(reduction.Y))
    through = [np.abs(full(A)[rest]) @ Y for A in reduction.given if Y.size]
    return [_eliminated(reduction, one, np.abs(poles), through) for one in bounds]


def _turns_evenly(block: np.ndarray) -> bool:
    """Whether (1, i) or (1, -i) is an eigenvector of a pair."""
    return len(block) == 1 or (len(block) == 2 and bool(block[0, 0] == block[1, 1] and block[0, 1] == -block[1, 0]))


def _second_state(smooth: BohlFunction, pairs: np.ndarray) -> np.ndarray:
    """The second entry of the eigenvector (1, i) or (1, -i) of pairs of states of a force, by the first states."""
    return 1j * np.sign(smooth.generator[pairs, pairs + 1])


@dataclass(frozen=True, eq=False)
class _RefinedEquations:
    """A(s) x = F by the elements of all coefficients, left @ diag(values) @ right @ (x, s x, s^2 x).

    Attributes:
        differences: which rows of right are differences of two entries, that are rounded relative to themselves.
        terms: bounds of the number of rounding errors in each row.
    """

    flow: Flow
    left: np.ndarray
    values: np.ndarray
    right: np.ndarray
    differences: np.ndarray
    terms: np.ndarray

    @classmethod
    def of(cls, flow: Flow, elements: Elements) -> _RefinedEquations:
        given, size = [full(A) for A in flow.reduction.given], len(full(flow.output))
        parts = [own or Factors(A, np.ones(size), np.eye(size)) for A, own in zip(given, elements)]
        left, values = np.concatenate([part.left for part in parts], axis=1), np.concatenate([part.values for part in parts])
        right, begin = np.zeros((len(values), 3 * size)), 0
        for order, part in enumerate(parts):
            right[begin : begin + len(part.values), order * size : (order + 1) * size] = part.right
            begin += len(part.values)
        used = right.any(axis=1) & left.any(axis=0) & (values != 0)
        left, values, right = left[:, used], values[used, None], right[used]
        counts = np.count_nonzero(right, axis=1)
        differences = ((np.abs(right) == 1) | (right == 0)).all(axis=1) & (counts <= 2)
        terms = np.count_nonzero(left, axis=1) + counts.max(initial=0) + 8
        return cls(flow, left, values, right, differences[:, None], terms[:, None])

    def residual(self, shapes: DoubleDouble, poles: DoubleDouble, leading: np.ndarray) -> _ModalResidual:
        """A(s) x - F at some poles s."""
        first = shapes * poles
        x = stacked(shapes, first, first * poles)
        strains = self.right @ x
        total, terms_of_strains = self.left @ strains.times(self.values), np.abs(self.right) @ (np.abs(x.high) + LEAST_NUMBER)
        strained = np.where(self.differences, np.abs(strains.high) + LEAST_NUMBER, terms_of_strains)
        sizes = np.abs(self.left) @ (np.abs(self.values) * strained)
        smooth, n = self.flow.force.smooth, len(self.flow.start)
        forced = leading[leading >= n] - n
        if len(forced):
            F = smooth.coefficients
            load, driven = np.zeros(total.shape, dtype=complex), slice(len(leading) - len(forced), None)
            load[:, driven] = F[:, forced]
            paired = np.flatnonzero(poles.high[driven].imag > 0)
            load[:, driven][:, paired] += _second_state(smooth, forced[paired]) * F[:, forced[paired] + 1]
            total, sizes = total - load, sizes + np.abs(load)
        return _ModalResidual(total.high, self.terms * DOUBLED_EPS * sizes, shapes, first, poles)

    def changed(self, residual: _ModalResidual, change: np.ndarray, moved: np.ndarray) -> _ModalResidual:
        """The residual after small changes of shapes and poles, to a rounding error of the change."""
        x, poles = residual.shapes.high, residual.poles.high
        shapes, after = residual.shapes + change, residual.poles + moved
        s = after.high
        first = s * change + moved * x
        rates = np.concatenate([change, first, s * s * change + (poles + s) * moved * x])
        x, change, moved, s = np.abs(x), np.abs(change), np.abs(moved), np.abs(s)
        sizes = np.concatenate([change, s * change + moved * x, s * s * change + (np.abs(poles) + s) * moved * x])
        more = self.left @ (self.values * (self.right @ rates))
        sizes = np.abs(self.left) @ (np.abs(self.values) * (np.abs(self.right) @ sizes))
        errors = residual.errors + self.terms * EPS * sizes
        return _ModalResidual(residual.values + more, errors, shapes, residual.first + first, after)


@dataclass(frozen=True, eq=False)
class _ModalResidual:
    """A(s) x - F at some poles s, rounded, bounds of its rounding errors, shape (r, L) each, and x, s x and s."""

    values: np.ndarray
    errors: np.ndarray
    shapes: DoubleDouble
    first: DoubleDouble
    poles: DoubleDouble


@dataclass(frozen=True, eq=False)
class RefinedDefect(Defect):
    """The error of sums of refined modes with twice the digits.

    Attributes:
        before: the piece before, None for the first one.
    """

    before: RefinedDefect | None = None

    @cached_property
    def refined(self) -> RefinedModes | None:
        """The modes; None where they cannot be refined."""
        rounding = self.rounding
        elements = ENTIRE if rounding is None else rounding.elements
        return None if elements is None else refined_modes(self.flow, elements, () if rounding is None else rounding.unresolved)

    @cached_property
    def identity(self) -> np.ndarray:
        """The matrix of x itself, one for x and its derivatives, whose bounds are kept with it."""
        return np.eye(len(full(self.flow.output))) if self.before is None else self.before.identity

    @property
    def states(self) -> BohlFunction:
        """z as a sum of the refined modes, rounded."""
        refined, n, m = self.refined, len(self.flow.start), self.flow.force.smooth.state_count
        forced = refined.leading[refined.free :] - n
        of_force = np.zeros((m, len(refined.leading)), dtype=complex)
        of_force[forced, np.arange(refined.free, len(refined.leading))] = 1.0
        pairs, paired = forced[refined.weights[refined.free :] > 1], np.flatnonzero(refined.weights > 1)
        of_force[pairs + 1, paired[paired >= refined.free]] = _second_state(self.flow.force.smooth, pairs)
        columns, poles = np.concatenate([refined.states.high, of_force]), refined.poles.high
        amplitudes, begin = self._amplitudes_of_pieces[0].high, np.cumsum(refined.weights).astype(int) - 1
        C, v = np.zeros((n + m, n + m)), np.zeros((n + m, len(self._knots)))
        C[:, begin], v[begin] = columns.imag * refined.weights, -amplitudes.imag  # of single poles replaced by the next line
        begin = begin - refined.weights.astype(int) + 1
        C[:, begin], v[begin] = columns.real * refined.weights, amplitudes.real
        blocks = [
            np.array([[a, b], [-b, a]]) if pair else np.array([[a]])
            for a, b, pair in zip(poles.real.tolist(), poles.imag.tolist(), refined.weights > 1)
        ]
        start = v[:, 0] if len(self._knots) == 1 else FreeRestarts(self._knots, v, self._force.remainders, tuple(blocks))
        return BohlFunction(C, tuple(blocks), start)

    def proved(self, matrix: np.ndarray, order: int, times: np.ndarray, accuracy: float) -> tuple[np.ndarray, np.ndarray]:
        """The derivative of this order of matrix @ x, and bounds of its errors, with this accuracy of the largest value where possible.

        Phases have always twice the digits; exponentials and sums where those of float64 do not suffice.
        """
        values, errors = self.rounded(matrix, order, times, accuracy)
        if len(late := np.flatnonzero(~are_right(values, errors, accuracy))):
            values[:, late], errors[late] = self.doubled(matrix, order, times[late], accuracy)
        return values, errors

    def rounded(self, matrix: np.ndarray, order: int, times: np.ndarray, accuracy: float) -> tuple[np.ndarray, np.ndarray]:
        """Sums in float64, and bounds of their errors."""
        return self._summed(matrix, order, times, accuracy, SUMMED_IN_FLOAT64 * EPS, self._in_float64)

    def doubled(self, matrix: np.ndarray, order: int, times: np.ndarray, accuracy: float) -> tuple[np.ndarray, np.ndarray]:
        """Sums with twice the digits, and bounds of their errors."""
        return self._summed(matrix, order, times, accuracy, 2 * EXPONENTIAL_EPS, self._with_twice_the_digits)

    def _summed(self, matrix, order, times, accuracy, rounding, sums) -> tuple[np.ndarray, np.ndarray]:
        restarts, values, errors = self._force, np.empty((len(matrix), len(times))), np.full(len(times), np.inf)
        pieces, since = restarts.located(times)
        many = len(restarts.knots) > 1
        for piece in np.unique(pieces).tolist() if many else range(min(len(times), 1)):
            at, own = np.flatnonzero(pieces == piece) if many else slice(None), self._pieces[piece]
            exact = DoubleDouble.of(times[at])
            if piece:
                exact = exact - restarts.knots[piece] - np.broadcast_to(restarts.remainders, restarts.knots.shape)[piece]
            values[:, at] = _in_chunks(sums, own._weights(matrix, order), exact)
            allowed = accuracy * np.abs(values[:, at]).max(axis=0, initial=0.0)
            errors[at] = own._late(matrix, order, since[at], allowed, rounding)
        return values, errors

    def _in_float64(self, weights: DoubleDouble, times: DoubleDouble) -> np.ndarray:
        known, key = self.refined.exponentials, times.high.tobytes()
        if key in known and not times.low.any():
            return known[key].summed(weights.high)
        exponentials = _Exponentials.of(*self.refined.turns, times)
        if exponentials.count:
            known.clear()
            known[key] = exponentials
        return exponentials.summed(weights.high)

    def _with_twice_the_digits(self, weights: DoubleDouble, times: DoubleDouble) -> np.ndarray:
        return _sums(weights, *self.refined.turns, times)

    def _weights(self, matrix: np.ndarray, order: int) -> DoubleDouble:
        """Factors of the exponentials of the leading poles."""
        known = self._known_weights
        if order not in known or known[order][0] is not matrix:
            known[order] = matrix, self._output(matrix, order) * self._amplitude.scaled(self.refined.weights)
        return known[order][1]

    @cached_property
    def _known_weights(self) -> dict[int, tuple[np.ndarray, DoubleDouble]]:
        """The last factors of each order."""
        return {}

    def _output(self, matrix: np.ndarray, order: int) -> DoubleDouble:
        output = self.refined.shapes if matrix is self.identity else matrix @ self.refined.shapes
        for _ in range(order):
            output = output * self.refined.poles
        return output

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
    def _amplitudes_of_pieces(self) -> tuple[DoubleDouble, np.ndarray]:
        """Amplitudes of the leading modes at all knots, and bounds of errors of all free ones without those of poles, shape (n, K)."""
        if self.before is not None:
            return self.before._amplitudes_of_pieces
        refined, n, gaps, v = self.refined, len(self.flow.start), self._gaps, self._force.states
        count, back, (jumps, uncertain) = refined.free, np.abs(refined.left), self._impulsive
        responses, weights, at = refined.states[:, count:], refined.weights[count:, None], refined.leading[count:] - n
        starts, paired = v[at].astype(complex), refined.weights[count:] > 1
        pairs = at[paired]
        starts[paired] = (v[pairs] - _second_state(self.flow.force.smooth, pairs)[:, None] * v[pairs + 1]) / 2
        right = DoubleDouble.of(np.concatenate([self._initial[:, None], jumps[:, 1:]], axis=1))
        changes = -starts[:, :1], np.zeros((len(at), 1))
        if len(gaps):
            moved = exponential(*(outer(part, DoubleDouble.of(gaps)) for part in refined.turns))
            ends = moved[count:] * starts[:, :-1] - starts[:, 1:]
            changes = np.concatenate([changes[0], ends.high], axis=1), np.concatenate([changes[1], ends.low], axis=1)
        if len(at):
            right = right + refined.summed(responses, DoubleDouble(*changes), weights)
        begun, errors = refined.solved(right)
        errors[:, 0] += back.sum(axis=1) * self._inconsistent
        if not len(gaps):
            return stacked(begun, DoubleDouble.of(starts)), errors + back @ uncertain
        pieces = [begun[:, 0]]
        for k in range(len(gaps)):
            pieces.append(moved[:count, k] * pieces[-1] + begun[:, k + 1])
        high, low = (np.array(part).T for part in zip(*((piece.high, piece.low) for piece in pieces)))
        amplitudes = stacked(DoubleDouble(high, low), DoubleDouble.of(starts))
        rounded = 2 * EXPONENTIAL_EPS + (8 + 2 * np.multiply.outer(np.abs(refined.poles.high), gaps)) * DOUBLED_EPS
        turned = np.abs(moved.high) * np.abs(amplitudes.high[:, :-1]) * rounded
        lost = weights * (turned[count:] + DOUBLED_EPS * np.abs(starts[:, 1:]))
        errors[:, 1:] += back @ (np.abs(responses.high) @ lost) + refined.whole(turned.T).T[:n]
        return amplitudes, errors + back @ uncertain

    @property
    def _inconsistent(self) -> float:
        """A bound of the jump by initial values that satisfy algebraic equations to rounding errors only."""
        flow, smooth = self.flow, self.flow.force.smooth
        constraining = flow.reduction.algebraic[flow.reduction.constraining]
        if not len(constraining):
            return 0.0
        left, at_zero = full(flow.reduction.given[0])[constraining] @ DoubleDouble.of(flow.initial.T), smooth.start_at_zero[:, None]
        if len(at_zero):
            states = np.concatenate(
                [np.linalg.matrix_power(smooth.generator, k) @ at_zero for k in range(len(flow.initial))], axis=1
            )
            left = left - smooth.coefficients[constraining] @ DoubleDouble.of(states)
        if left.high.any():
            return 4 * EPS * float(np.abs(flow.initial).max())
        return 0.0

    @property
    def _amplitude(self) -> DoubleDouble:
        return self._amplitudes_of_pieces[0][:, self.piece]

    @cached_property
    def _modes(self) -> BoundedModes | None:
        if self.refined is None:
            return None
        poles = self.refined.whole(self.refined.poles.high)
        nothing, sizes = np.zeros(len(poles)), np.abs(self.refined.whole(self._amplitude.high))
        return BoundedModes(np.diag(np.abs(poles)), np.arange(len(poles)), sizes, poles, poles.real, nothing > 0, nothing + 1, None)

    @cached_property
    def _modal_start(self) -> np.ndarray:
        own = self._amplitudes_of_pieces[1][:, self.piece]
        return own if self.before is None else own + self.before._at_end()

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
        if not errors.any():
            return driven
        (through,) = _eliminated_sizes(self.flow.reduction, [errors], self._modes.zeros[n:])
        return np.concatenate([driven[:, :n], driven[:, n:] + self.refined.parts @ through], axis=1)

    @property
    def _force_errors(self) -> np.ndarray:
        """Errors of the force in each row, by its poles."""
        F, n = np.abs(self.flow.force.smooth.coefficients), len(self.flow.start)
        load = F * self._lost + (0.0 if self.rounding is None else self.rounding.force[:, None])
        pairs = self.refined.above[self.refined.above >= n] - n
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
        return np.abs(self.refined.whole(self._output(place, order).high))

    def _direct(self, place: np.ndarray, order: int) -> tuple[np.ndarray | float, np.ndarray | float]:
        algebraic, rates, n = self.flow.reduction.algebraic, np.abs(self._modes.zeros), len(self.flow.start)
        total = np.abs(place) @ (np.abs(full(self.flow.reduction.Y)) @ self._residual[algebraic]) * rates**order
        for k in range(order):
            total += (self._derived(place, order - 1 - k)[:, :n] @ self._modal_residual) * rates**k
        return total.max(axis=0) * self._modes.sizes, 0.0

    @property
    def _unit(self) -> tuple[float, float]:
        return 2 * EXPONENTIAL_EPS, 4 * DOUBLED_EPS


def refined_modes(flow: Flow, elements: Elements, unresolved: tuple[np.ndarray, ...]) -> RefinedModes | None:
    """The refined modes of a flow, computed once; None where there are none."""
    if elements not in flow.computed:
        with np.errstate(all="ignore"):
            flow.computed[elements] = RefinedModes.of(flow, elements, unresolved)
    return flow.computed[elements]


def _in_chunks(sums: Callable, weights: DoubleDouble, times: DoubleDouble) -> np.ndarray:
    """Sums at so many times at once that memory stays near that of the answer."""
    count, width = len(times.high), max(1, CHUNK_ENTRIES // max(*weights.shape, 1))
    if count <= width:
        return sums(weights, times)
    parts = (times[begin : begin + width] for begin in range(0, count, width))
    return np.concatenate([sums(weights, part) for part in parts], axis=1)


@dataclass(frozen=True, eq=False)
class _Exponentials:
    """e^(s t) in float64, of exact phases; at many even times t = T + tau as e^(s T) e^(s tau).

    Attributes:
        first: at all times, or at the times T, shape (T, m).
        second: at the times tau, if there are such.
        beyond: the times less T + tau, rounding errors; None where they turn nothing.
        rates: s, rounded.
        count: the number of even times.
    """

    first: np.ndarray
    second: np.ndarray | None = None
    beyond: np.ndarray | None = None
    rates: np.ndarray | None = None
    count: int = 0

    @classmethod
    def of(cls, growth: DoubleDouble, turned: DoubleDouble, times: DoubleDouble) -> _Exponentials:
        """2^(growth t) e^(2 pi i turned t)."""
        given = times.high
        step = even_step(given) if len(given) >= FEWEST_EVEN and not times.low.any() else None
        if step is None:
            return cls(_exponentials(growth, turned, times))
        fine = 2 * int(len(given) ** 0.5)  # every row has its own factors at the times T
        coarse, tau = given[::fine], step * np.arange(fine)
        table = _exponentials(growth, turned, DoubleDouble.of(np.concatenate([coarse, tau])))
        between, error = sum_with_error(given, -np.repeat(coarse, fine)[: len(given)])
        beyond = (between - np.tile(tau, len(coarse))[: len(given)]) + error
        rates = np.log(2.0) * growth.high + 2j * np.pi * turned.high
        turning = np.abs(beyond).max() * np.abs(rates).max(initial=0.0) > EPS
        return cls(table[: len(coarse)], table[len(coarse) :], beyond if turning else None, rates, len(given))

    def summed(self, weights: np.ndarray) -> np.ndarray:
        """The real part of weights @ e^(s t), shape (r, T)."""
        if self.second is None:
            both = np.concatenate([weights.real, -weights.imag], axis=1)
            return both @ np.concatenate([self.first.real, self.first.imag], axis=1).T
        if self.beyond is None:
            return np.ascontiguousarray(self._by_table(weights))
        both = self._by_table(np.concatenate([weights, weights * self.rates]))
        return both[: len(weights)] + self.beyond * both[len(weights) :]

    def _by_table(self, weights: np.ndarray) -> np.ndarray:
        left = np.multiply(weights[:, None], self.first, order="C").view(float).reshape(-1, 2 * self.first.shape[1])
        return (left @ np.conj(self.second).view(float).T).reshape(len(weights), -1)[:, : self.count]


def _exponentials(growth: DoubleDouble, turned: DoubleDouble, times: DoubleDouble) -> np.ndarray:
    """2^(growth t) e^(2 pi i turned t) in float64 with exact phases, shape (T, m)."""
    exponents, m = outer(times, stacked(growth, turned)), len(growth.high)
    turn = exponents.high[:, m:]
    angles = 2 * np.pi * ((turn - np.rint(turn)) + exponents.low[:, m:])
    result = np.empty(angles.shape, dtype=complex)
    result.real, result.imag = np.cos(angles), np.sin(angles)
    if growth.high.any():
        factors = np.exp2(exponents.high[:, :m])
        result *= factors + factors * (np.log(2.0) * exponents.low[:, :m])
    return result


def _sums(weights: DoubleDouble, growth: DoubleDouble, turned: DoubleDouble, times: DoubleDouble) -> np.ndarray:
    """The real part of weights @ 2^(growth t) e^(2 pi i turned t) with the accuracy of exponentials, relative to each term in any row."""
    parts = exponential(outer(growth, times), outer(turned, times))
    sizes = np.abs(weights.high).max(axis=0, initial=0.0)
    unit = np.ldexp(1.0, np.frexp(sizes)[1])
    left, small = (np.concatenate([part.real, -part.imag], axis=1) for part in (weights.high / unit, weights.low / unit))
    unit = unit[:, None]
    right, rest = (np.concatenate([part.real, part.imag]) for part in (parts.high * unit, parts.low * unit))
    high, low = accurate_product(left, right)
    return high + (low + left @ rest + small @ right)
