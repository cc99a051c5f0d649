"""The Taylor series of a response at t = 0+ from its equations, not from its modes.

With z = Z w the pencil's staircase form reads

    E11 w1' = F11 w1 + F12 w2 - E12 w2' + b1,    w2 = -(b2 + N b2' + N^2 b2'' + ...)

and gives w1^(k+1) from w1^(k). It was found by elimination, so zeros of the structure stay zeros, and the rounding
noise of every coefficient is carried along.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from ..errors import IllConditioned
from ..jordan.weierstrass import WeierstrassForm
from ..linalg.noise import Noisy, stacked
from ..signals.impulsive import ImpulsiveSmooth
from ..tolerances import EPS, NOISE_SAFETY
from .forcing import scaled_data
from .series import TERMS, Series, growth, span_of


def taylor_series(form: WeierstrassForm, initial: np.ndarray, jump: np.ndarray, force: ImpulsiveSmooth) -> Series:
    """The Taylor series at t = 0+ of x with A(d/dt) x = f from values at 0-.

    Args:
        form: the pencil of A(s), decoupled; its staircase form is used.
        initial: x^(i)(0-) as row i, shape (q, r).
        jump: x^(i)(0+) - x^(i)(0-); where it is exactly zero the value at 0- is the coefficient.
        force: f with its Dirac impulses; what happens after t = 0 is not seen.

    >>> from ..polynomial.matrix import PolynomialMatrix
    >>> from ..signals.inputs import zero
    >>> A = PolynomialMatrix([[[1.0]], [[0.0]], [[1.0]]])  # x'' + x = 0 from x = 0, x' = 1
    >>> sine = taylor_series(A.jordan_pairs().form, np.array([[0.0], [1.0]]), np.zeros((2, 1)), zero(1))
    >>> float(sine(1e-5)[0] / np.sin(1e-5)), float(sine.coefficients[0, 2])
    (1.0, 0.0)
    """
    with np.errstate(over="ignore", invalid="ignore"):  # a row with a coefficient out of range is left to the modes
        return _kept(_series(form, *scaled_data(form, initial, force), len(initial)), initial, jump)


def _series(form: WeierstrassForm, stack, f, size, more) -> Series:
    """The same, all coefficients from the equations; as many more as are lost by derivatives."""
    equations = _Equations(form, f)
    state = equations.state_at_zero(form, stack, f)
    rate, steps = growth(equations.bounds(), state.data != 0)
    span, columns = span_of(rate, 1.0), []
    for k in range(TERMS + steps + more):
        columns.append(equations.output(state))
        state = equations.derivative(state, span / (k + 1))
    units = size * form.companion.scaling.columns[:, None]
    return Series(
        span / form.companion.scaling.time,
        units * np.stack([column.data for column in columns], axis=1),
        units * np.stack([column.noise for column in columns], axis=1),
    )


class _Map:
    """A matrix with noise, applied to many vectors: ``Noisy`` products with all squares made once."""

    def __init__(self, matrix: Noisy):
        self.matrix, self.squares = matrix.data, matrix.data**2
        self.errors = matrix.noise**2 + EPS**2 * self.squares

    def __call__(self, vector: Noisy) -> Noisy:
        """matrix @ vector, entries within their noise set to zero."""
        squares = vector.noise**2
        return _clean(Noisy(self.matrix @ vector.data, np.sqrt(self.squares @ squares + self.errors @ (vector.data**2 + squares))))


class _Equations:
    """w1' = M w1 + D v, w2 = G v, v' = J v and x = output (w1, v) in scaled units, the force being C_f v."""

    def __init__(self, form: WeierstrassForm, f):
        split, r, self.count = form.split, form.companion.size, len(form.split.E11.data)
        n, self.J = self.count, Noisy.rounded(f.generator)
        loads = split.left[:, form.companion.state_count - r :] @ Noisy.rounded(f.coefficients)
        G = power = -loads[n:]
        for _ in split.deficiencies[1:]:  # so many powers of N are not zero
            power = split.nilpotent @ power @ self.J
            G = G + power
        D = split.F12 @ _clean(G) + loads[:n] + -(split.E12 @ _clean(G) @ self.J)
        self.inverse = _inverse(split.E11)
        self.M = _clean(self.inverse @ split.F11)
        self.slope, self.generator = _Map(_beside(self.M, _clean(self.inverse @ _clean(D)))), _Map(self.J)
        self.output = _Map(_beside(split.right[:r, :n], split.right[:r, n:] @ _clean(G)))

    def state_at_zero(self, form, stack, f) -> Noisy:
        """(w1, v) at 0+: the coefficient of 1/s of the transform of w, its polynomial part found from the top down."""
        split, n, r = form.split, self.count, form.companion.size
        loads, v = split.left[:, len(stack) - r :], Noisy.rounded(f.start)
        given = {order: loads @ Noisy.rounded(g) for order, g in enumerate(f.impulses)}
        own = split.left @ (Noisy.rounded(form.companion.E) @ Noisy.rounded(stack))
        given[0] = own + given[0] if 0 in given else own
        top = max(given) + len(split.deficiencies)
        for order, derivative in enumerate(f.derivatives(len(split.deficiencies) + 1)):
            given[-1 - order] = loads @ (Noisy.rounded(derivative) @ v)
        nothing = Noisy.exact(np.zeros(len(stack)))
        fast = {m: self._fast(split, given, m, nothing[n:]) for m in range(-1, top + 1)}
        w = nothing[:n]
        for m in range(top, -1, -1):
            load = _clean(split.F12 @ fast[m] + -(split.E12 @ fast[m - 1]) + given.get(m, nothing)[:n])
            w = _clean(self.M @ w + self.inverse @ load)
        return stacked(w, v)

    @staticmethod
    def _fast(split, given, order, nothing) -> Noisy:
        """The coefficient of s^order of W2 = -(I + s N + s^2 N^2 + ...) times the given."""
        total = nothing
        for i in range(len(split.deficiencies) - 1, -1, -1):
            part = given[order - i][len(split.E11.data) :] if order - i in given else nothing
            total = split.nilpotent @ total + part
        return _clean(-total)

    def derivative(self, state, factor) -> Noisy:
        """(w1', v') times the factor."""
        slope = stacked(self.slope(state), self.generator(state[self.count :]))
        return Noisy(factor * slope.data, factor * slope.noise)

    def bounds(self) -> np.ndarray:
        """Absolute values of the matrix that takes (w1, v) to its derivative."""
        below = np.hstack([np.zeros((len(self.J.data), self.count)), self.J.data])
        return np.abs(np.vstack([self.slope.matrix, below]))


def _inverse(matrix: Noisy) -> Noisy:
    try:
        inverse = np.linalg.inv(matrix.data)
    except np.linalg.LinAlgError:
        raise IllConditioned(
            "float64 finds a part of A(s) singular that the rank decisions kept; with rank_tolerance=0 nothing counts as rounding: "
            "leave it out, or give a larger one"
        ) from None
    return Noisy(inverse, np.abs(inverse) @ matrix.noise @ np.abs(inverse) + EPS * np.abs(inverse))


def _beside(left: Noisy, right: Noisy) -> Noisy:
    return stacked(left.T, right.T).T


def _kept(series: Series, initial, jump) -> Series:
    """With the values at 0-, in place of the coefficients, that do not jump: they are known better.

    Where a coefficient says otherwise, by more than its noise, a jump was lost in the noise of another way to compute it.
    """
    coefficients, noise = series.coefficients.copy(), series.noise.copy()
    for i, (values, changes) in enumerate(zip(initial, jump)):
        known = values * (series.span**i / factorial(i))
        stays = (changes == 0) & (np.abs(known - coefficients[:, i]) <= NOISE_SAFETY * (noise[:, i] + EPS * np.abs(known)))
        coefficients[:, i] = np.where(stays, known, coefficients[:, i])
        noise[:, i] = np.where(stays, EPS * np.abs(known), noise[:, i])
    return Series(series.span, coefficients, noise)


def _clean(values: Noisy) -> Noisy:
    return Noisy(values.cleaned(), values.noise)
