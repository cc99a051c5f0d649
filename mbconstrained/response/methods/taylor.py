"""Taylor series of a response at t = 0+ from its equations instead of its modes.

With z = Z w the pencil's staircase form reads

    E11 w1' = F11 w1 + F12 w2 - E12 w2' + b1,    w2 = -(b2 + N b2' + N^2 b2'' + ...)

and gives w1^(k+1) from w1^(k). The form results from elimination, so zeros of the structure stay zeros, and the noise
of every coefficient is computed with it.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from ...ground.errors import IllConditioned
from ...ground.tolerances import EPS, NOISE_SAFETY
from ...linalg.rounding import Noisy, stacked
from ...polynomial.decoupling import WeierstrassForm
from ...signals.impulsive import ImpulsiveSmooth
from ..forcing import scaled_data
from .series import TERMS, Series, growth, span_of


def taylor_series(form: WeierstrassForm, initial: np.ndarray, jump: np.ndarray, force: ImpulsiveSmooth) -> Series:
    """The Taylor series at t = 0+ of x with A(d/dt) x = f from values at 0-.

    >>> from mbconstrained import PolynomialMatrix
    >>> from mbconstrained import zero
    >>> A = PolynomialMatrix([[[1.0]], [[0.0]], [[1.0]]])  # x'' + x = 0 from x = 0, x' = 1
    >>> sine = taylor_series(A.jordan_pairs().form, np.array([[0.0], [1.0]]), np.zeros((2, 1)), zero(1))
    >>> float(sine(1e-5)[0] / np.sin(1e-5)), float(sine.coefficients[0, 2])
    (1.0, 0.0)
    """
    with np.errstate(over="ignore", invalid="ignore"):  # a row with a coefficient out of range is left to the modes
        return _with_known_values(_series(form, *scaled_data(form, initial, force), len(initial)), initial, jump)


def _series(form: WeierstrassForm, stack, f, size, more) -> Series:
    """The series with all coefficients from the equations, and ``more`` coefficients for differentiation."""
    equations = _Equations(form, f)
    state = equations.state_at_zero(form, stack, f)
    rate, steps = growth(np.abs(equations.slope.data), state.data != 0)
    span = span_of(rate, 1.0)
    outputs = _times(equations.output, _derivatives(equations.slope, state, span, TERMS + steps + more))
    units = size * form.companion.scaling.columns[:, None]
    return Series(span / form.companion.scaling.time, units * outputs.data, units * outputs.noise)


def _derivatives(slope: Noisy, state: Noisy, span: float, count: int) -> Noisy:
    """w^(k) span^k / k! of w' = slope w as columns, shape (n, count); entries within their noise are zero.

    The noise is carried as the square of the bound that an entry has to exceed.
    """
    size, bound = len(state.data), NOISE_SAFETY**2
    squares = slope.data**2
    errors = slope.noise**2 + EPS**2 * squares
    growing, data = np.concatenate([squares + errors, bound * errors], axis=1), slope.data
    states, sources = np.empty((count, size)), np.empty((count, 2 * size))  # sources: bounds, then squares
    states[0], sources[0, :size], sources[0, size:] = state.data, bound * state.noise**2, state.data**2
    for k in range(1, count):
        factor, row, source = span / k, states[k], sources[k]
        limit, square = source[:size], source[size:]
        data.dot(states[k - 1], row)
        growing.dot(sources[k - 1], limit)
        row *= factor
        limit *= factor**2
        np.multiply(row, row, square)
        dropped = square < limit
        row[dropped] = square[dropped] = 0.0
    return Noisy(states.T, np.sqrt(sources[:, :size].T) / NOISE_SAFETY)


def _times(matrix: Noisy, columns: Noisy) -> Noisy:
    """matrix @ columns, entries within their noise set to zero; of each product one rounding error."""
    squares, noise = matrix.data**2, columns.noise**2
    errors = matrix.noise**2 + EPS**2 * squares
    return _clean(Noisy(matrix.data @ columns.data, np.sqrt(squares @ noise + errors @ (columns.data**2 + noise))))


class _Equations:
    """w1' = M w1 + D v, w2 = G v, v' = J v in scaled units, the force being C_f v: slope and output of the states (w1, v)."""

    def __init__(self, form: WeierstrassForm, f):
        split, r, n = form.split, form.companion.size, len(form.split.E11.data)
        J = Noisy.rounded(f.generator)
        loads = split.left[:, form.companion.state_count - r :] @ Noisy.rounded(f.coefficients)
        G = power = -loads[n:]
        for _ in split.deficiencies[1:]:  # so many powers of N are not zero
            power = split.nilpotent @ power @ J
            G = G + power
        G = _clean(G)
        D = split.F12 @ G + loads[:n] + -(split.E12 @ G @ J)
        self.inverse = _inverse(split.E11)
        self.M = _clean(self.inverse @ split.F11)
        below = Noisy.exact(np.zeros((len(J.data), n)))
        self.slope = stacked(_side_by_side(self.M, _clean(self.inverse @ _clean(D))), _side_by_side(below, J))
        self.output = _side_by_side(split.right[:r, :n], split.right[:r, n:] @ G)

    def state_at_zero(self, form, stack, f) -> Noisy:
        """(w1, v) at 0+: the coefficient of 1/s of the transform of w, its polynomial part computed from the highest power down."""
        split, n, chains = form.split, len(form.split.E11.data), len(form.split.deficiencies)
        given = self._given(form, stack, f)
        slow, last = given[:n, chains + 1 :], given.data.shape[1]
        powers = [given[n:, chains - i : last - i] for i in range(max(chains, 1))]  # from 1/s on, times s^i
        total = powers.pop()
        while powers:
            total = split.nilpotent @ total + powers.pop()
        fast = _clean(-total)
        load = self.inverse @ _clean(split.F12 @ fast[:, 1:] + -(split.E12 @ fast[:, :-1]) + slow)
        w = _clean(load[:, -1])
        for m in range(load.data.shape[1] - 2, -1, -1):
            w = _clean(self.M @ w + load[:, m])
        return stacked(w, Noisy.rounded(f.start))

    @staticmethod
    def _given(form, stack, f) -> Noisy:
        """The loads on w, a column for each power of s, from those below 1/s to those above the last."""
        loads, chains = form.split.left[:, len(stack) - form.companion.size :], len(form.split.deficiencies)
        given = Noisy.exact(np.zeros((len(stack), 2 * chains + 1 + max(len(f.impulses), 1))))
        if len(f.start):
            derivatives = np.stack(f.derivatives(chains + 1)[::-1])
            values = Noisy.rounded(derivatives) @ Noisy.rounded(f.start)
            given[:, : chains + 1] = loads @ values.T
        for order, impulse in enumerate(f.impulses, chains + 1):
            given[:, order] = loads @ Noisy.rounded(impulse)
        own = form.split.left @ (Noisy.rounded(form.companion.E) @ Noisy.rounded(stack))
        given[:, chains + 1] = own + given[:, chains + 1]
        return given


def _inverse(matrix: Noisy) -> Noisy:
    try:
        inverse = np.linalg.inv(matrix.data)
    except np.linalg.LinAlgError:
        raise IllConditioned(
            "float64 finds a part of A(s) singular that the rank decisions kept; with rank_tolerance=0 nothing counts as rounding: "
            "leave it out, or give a larger one"
        ) from None
    size = np.abs(inverse)
    return Noisy(inverse, size @ matrix.noise @ size + EPS * size)


def _side_by_side(left: Noisy, right: Noisy) -> Noisy:
    return stacked(left.T, right.T).T


def _with_known_values(series: Series, initial, jump) -> Series:
    """The series with the coefficients of values at 0- that do not jump replaced by these values, which are more accurate.

    Where a coefficient differs by more than its noise, a jump was lost in the noise of its own computation.
    """
    coefficients, noise = series.coefficients.copy(), series.noise.copy()
    first = slice(len(initial))
    known = np.transpose([values * (series.span**i / factorial(i)) for i, values in enumerate(initial)])
    if known.size:
        rounding, computed = EPS * np.abs(known), coefficients[:, first]
        stays = (jump.T == 0) & (np.abs(known - computed) <= NOISE_SAFETY * (noise[:, first] + rounding))
        coefficients[:, first] = np.where(stays, known, computed)
        noise[:, first] = np.where(stays, rounding, noise[:, first])
    return Series(series.span, coefficients, noise)


def _clean(values: Noisy) -> Noisy:
    return Noisy(values.cleaned(), values.noise)
