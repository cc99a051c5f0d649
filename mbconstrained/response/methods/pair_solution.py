"""Responses by Jordan pairs, at small times by power series and Taylor polynomials."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil, exp, factorial, log

import numpy as np

from ...ground.checks import counted, real_array, whole_number
from ...ground.errors import IllConditioned
from ...ground.notices import Evidence, Notice
from ...ground.tolerances import CLEAR_KEPT, EPS, NOISE_SAFETY
from ...linalg.blocks import CHUNK_ENTRIES, block_diagonalize
from ...linalg.rank import Noisy, stacked
from ...polynomial.decoupling import WeierstrassForm
from ...polynomial.jordan_pairs import JordanPairs
from ...signals.bohl import BohlFunction
from ...signals.impulsive import ImpulsiveSmooth
from ..choose import Method
from ..events import Event, KnotJumps, Start, knot_jumps, start_of
from ..problem import Problem, driven_form, scaled_data
from ..response_notices import modal_sums, pair_notices
from .finite_motion import FinitePart, driven_motion

# Taylor series of a response just after t = 0+, and a function that uses it while it is more accurate than the modes.
# From rest a coordinate far from the force begins like t^p, a tiny difference of modes that are not small:
# their sum cancels, the series does not.
# The series loses up to e^(2 rate t) units in the last place, where the rate bounds the growth from one
# derivative to the next. The modal sum's loss is measured: by how much more than the noise of the series it differs
# from it for rate t <= 1. Each row is left to the modal sum where the noise of its series exceeds that.

#: The series serves for rate * t up to this: e^(2 rate t) times EPS is then the root of EPS, half of the digits.
REACH = -log(EPS) / 4

#: Terms after the first one that is not zero: the tail (e REACH / k)^k of REACH^k / k! is then below EPS.
TERMS = ceil(6 * REACH)

#: The norm of the power 2^SQUARINGS of a matrix, its root taken, is the Perron root to a percent for all usual sizes.
SQUARINGS = 10

#: The range of float64 ends here.
LARGEST = float(np.finfo(float).max)

#: Points of comparison, in spans: two times per factor of two, down to the rounding error of the span.
PLACES = 2.0 ** (-np.arange(2 * 52) / 2)

#: Of these the ones up to rate t = 1.
EARLY = slice(int((PLACES > 1 / REACH).sum()), None)


@dataclass(frozen=True, repr=False, eq=False)
class Series:
    """The sum over k of c_k t^k for 0 <= t <= span, each coefficient with its rounding noise.

    Attributes:
        span: in s; the series has converged up to here.
        coefficients: c_k span^k, shape (r, K).
        noise: their errors, about, shape (r, K).
    """

    span: float
    coefficients: np.ndarray
    noise: np.ndarray

    def __repr__(self) -> str:
        rows, terms = self.coefficients.shape
        return f"Series({counted(rows, 'row')}, {counted(terms, 'term')}, for 0 <= t <= {self.span:.6g} s)"

    def __call__(self, times) -> np.ndarray:
        """The sum at a time (-> (r,)) or at times (T,) (-> (r, T)), none later than span."""
        return self.coefficients @ self._powers(times)

    def noise_at(self, times) -> np.ndarray:
        """The approximate rounding error of the sum, in the shape of the sum."""
        return self._errors @ self._powers(times)

    def derivative(self, order: int = 1) -> Series:
        """The series of the derivative of this order."""
        series = self
        for _ in range(whole_number(order, "order")):
            with np.errstate(over="ignore", invalid="ignore"):  # a row whose series leaves the range is not evaluated by it
                factors = np.arange(1.0, max(series.coefficients.shape[1], 1)) / series.span
                series = Series(series.span, series.coefficients[:, 1:] * factors, series.noise[:, 1:] * factors)
        return series

    def mapped(self, matrix) -> Series:
        """The series of matrix @ x(t), matrix of shape (p, r)."""
        matrix = np.asarray(matrix, dtype=float)
        return Series(self.span, matrix @ self.coefficients, np.abs(matrix) @ self._errors)

    def rows(self, indices) -> Series:
        return Series(self.span, self.coefficients[indices], self.noise[indices])

    def within(self, span: float) -> Series:
        """The series over a shorter span."""
        powers = (span / self.span) ** np.arange(self.coefficients.shape[1])
        return Series(span, self.coefficients * powers, self.noise * powers)

    def __mul__(self, factor: float) -> Series:
        return Series(self.span, self.coefficients * factor, self.noise * abs(factor))

    def __add__(self, other: Series) -> Series:
        span = min(self.span, other.span)
        one, two = self.within(span), other.within(span)
        return Series(span, _padded_sum(one.coefficients, two.coefficients), _padded_sum(one._errors, two._errors))

    @property
    def _errors(self) -> np.ndarray:
        """The noise with the rounding errors of the coefficients."""
        return self.noise + EPS * np.abs(self.coefficients)

    def _powers(self, times):
        """t^0, t^1, ... by doubling, in units of the span, shape (K,) or (K, T)."""
        first, count = np.asarray(times, dtype=float) / self.span, self.coefficients.shape[1]
        powers = np.ones((1, *first.shape))
        while len(powers) < count:
            powers = np.concatenate([powers, powers * (powers[-1] * first)])
        return powers[:count]


@dataclass(frozen=True, repr=False)
class ResponseFunction(BohlFunction):
    """A Bohl function that is evaluated by its Taylor series while that is more accurate than the sum of modes.

    Attributes:
        series: its Taylor series at t = 0+.
    """

    series: Series

    def _values(self, times) -> np.ndarray:
        """Values, each row by its series before the time ``switch`` of the row."""
        values = super()._values(times)
        if not times.size or times.min() >= self.series.span:
            return values
        some = np.flatnonzero(times < self.switch.max(initial=0.0))
        width = max(1, CHUNK_ENTRIES // max(*self.series.coefficients.shape, 1))
        for part in (some[begin : begin + width] for begin in range(0, len(some), width)):
            early = times[part]
            values[:, part] = np.where(np.greater.outer(self.switch, early), self.series(early), values[:, part])
        return values

    @cached_property
    def switch(self) -> np.ndarray:
        """Time in s before which each row is evaluated by its series, shape (r,)."""
        series, table = self.series, _powers_of_places(self.series.coefficients.shape[1])
        places = series.span * PLACES
        with np.errstate(over="ignore", invalid="ignore"):  # infinite values do not enter: no comparison with them is true
            noise, sums = series._errors @ table, series.coefficients @ table[:, EARLY]
            difference = np.abs(super()._values(places[EARLY]) - sums)
            error = (difference - NOISE_SAFETY * noise[:, EARLY]).max(axis=1, initial=0.0)
        worse = ~(noise <= error[:, None])
        first_good = np.where(worse.all(axis=1), len(places), worse.argmin(axis=1))
        return np.append(places, 0.0)[first_good]

    @property
    def summed_from(self) -> np.ndarray:
        """First time of evaluation by modes, as in ``BohlFunction``."""
        return self.switch

    def derivative(self, order: int = 1) -> ResponseFunction:
        """The classical derivative."""
        return with_series(super().derivative(order), self.series.derivative(order))

    def mapped(self, matrix) -> ResponseFunction:
        """The function matrix @ f(t), matrix of shape (p, r)."""
        matrix = real_array(matrix, "matrix", shape=(None, self.size))
        return with_series(super().mapped(matrix), self.series.mapped(matrix))

    def rows(self, indices) -> ResponseFunction:
        indices = np.asarray(indices, dtype=int)
        return with_series(super().rows(indices), self.series.rows(indices))

    def __add__(self, other: BohlFunction) -> ResponseFunction:
        if not isinstance(other, BohlFunction):
            return NotImplemented
        series = other.series if isinstance(other, ResponseFunction) else series_of(other, self.series.span)
        return with_series(super().__add__(other), self.series + series)

    __radd__ = __add__

    def __mul__(self, factor: float) -> ResponseFunction:
        return with_series(super().__mul__(factor), self.series * factor)

    __rmul__ = __mul__


def with_series(function: BohlFunction, series: Series) -> ResponseFunction:
    """The function together with its series, which ends at the first restart of the function."""
    knots = function.restarts.knots
    if len(knots) > 1 and knots[1] < series.span:
        series = series.within(float(knots[1]))
    return ResponseFunction(function.coefficients, function.blocks, function.start, series)


def series_of(function: BohlFunction, longest: float) -> Series:
    """The Taylor series of C e^{J t} v, over no more than the longest span."""
    J, v = function.generator, function.start_at_zero
    rate, steps = growth(np.abs(J), v != 0)
    span = min(span_of(rate, longest), longest)
    state, columns = v, []
    for k in range(TERMS + steps):
        columns.append(function.coefficients @ state)
        state = span / (k + 1) * (J @ state)
    coefficients = np.stack(columns, axis=1)
    return Series(span, coefficients, EPS * np.abs(coefficients))


def growth(bounds: np.ndarray, begun: np.ndarray) -> tuple[float, int]:
    """Perron root of the states that are reachable from the first ones, and the number of steps to reach all of them."""
    pattern, steps, last = bounds > 0, 0, begun
    while (last := pattern[:, last].any(axis=1) & ~begun).any():
        begun, steps = begun | last, steps + 1
    return _perron_root(bounds[np.ix_(begun, begun)]), steps


def _perron_root(matrix: np.ndarray) -> float:
    """The largest eigenvalue of a nonnegative matrix, slightly above: the root of a norm of a high power (Gelfand)."""
    logarithm = 0.0
    for _ in range(SQUARINGS):
        size = min(matrix.sum(axis=1).max(initial=0.0), LARGEST)
        if size == 0:
            return 0.0
        matrix, logarithm = matrix / size, 2 * (logarithm + log(size))
        matrix = matrix.dot(matrix)
    return exp(min(logarithm / 2**SQUARINGS, log(LARGEST)))


def span_of(rate: float, otherwise: float) -> float:
    """The span of a series; a finite series without growth serves at all times."""
    return REACH / rate if rate > 0 else otherwise


@lru_cache
def _powers_of_places(count: int) -> np.ndarray:
    """PLACES^0, PLACES^1, ..., shape (count, T)."""
    return np.power.outer(PLACES, np.arange(count)).T


def _padded_sum(one, two) -> np.ndarray:
    count = max(one.shape[1], two.shape[1])
    return sum(np.pad(part, ((0, 0), (0, count - part.shape[1]))) for part in (one, two))


# Taylor series of a response at t = 0+ from its equations instead of its modes.
# With z = Z w the pencil's staircase form reads
#     E11 w1' = F11 w1 + F12 w2 - E12 w2' + b1,    w2 = -(b2 + N b2' + N^2 b2'' + ...)
# and gives w1^(k+1) from w1^(k). The form results from elimination, so zeros of the structure stay zeros, and the noise
# of every coefficient is computed with it.


def taylor_series(form: WeierstrassForm, initial: np.ndarray, jump: np.ndarray, force: ImpulsiveSmooth) -> Series:
    """The Taylor series at t = 0+ of x with A(d/dt) x = f from values at 0-."""
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


# The solution by the Jordan pairs of A(s): its function of time, evidence and notices.


@dataclass(frozen=True, eq=False)
class PairSolution:
    """x from the pairs.

    Attributes:
        method: the Jordan pairs, chosen with a reason.
        pairs: the pairs themselves.
        function: the regular part.
        coupling: the largest entry of the transformation that separates the zeros.
        jump: x^(i)(0+) - x^(i)(0-), shape (q, r).
        impulses: arrays (r,); the k-th multiplies the k-th derivative of Dirac's delta at t = 0.
        events: jumps and impulses after t = 0.
    """

    method: Method
    pairs: JordanPairs
    function: BohlFunction
    coupling: float
    jump: np.ndarray
    impulses: tuple[np.ndarray, ...]
    events: tuple[Event, ...]

    @classmethod
    def of(cls, problem: Problem, method: Method, pairs: JordanPairs) -> PairSolution:
        """The solution of a problem from its pairs."""
        form, initial, force = pairs.form, problem.initial, problem.force
        start, later = start_of(form, initial, force), knot_jumps(form, force, len(initial))
        function, coupling = _regular_part(form, start, force, later)
        function = with_series(function, taylor_series(form, initial, start.jump, force))
        return cls(method, pairs, function, coupling, start.jump, start.impulses, later.events)

    def sums(self, count: int, times: np.ndarray | None = None) -> tuple[np.ndarray, list[np.ndarray], np.ndarray, float]:
        """Rows and states whose products are the derivatives, as ``response_notices.modal_sums``."""
        return modal_sums(self.function, count, times)

    @property
    def is_precise(self) -> bool:
        """Whether the solution was computed with more digits than float64."""
        return self.pairs.form.companion.is_precise

    @property
    def has_clear_ranks(self) -> bool:
        """Whether no rank decision was doubtful."""
        return all(decision.clear for decision in self.pairs.form.decisions)

    @property
    def dropped_near_bound(self) -> bool:
        """Whether the only doubtful rank decisions are those with dropped entries near their bounds."""
        doubtful = [decision for decision in self.pairs.form.decisions if not decision.clear]
        return bool(doubtful) and all(decision.smallest_kept >= CLEAR_KEPT for decision in doubtful)

    @property
    def as_written(self) -> JordanPairs | None:
        """The pairs of the given data, without entries set to zero at s = 0."""
        return self.pairs.as_written

    @property
    def finite_count(self) -> int:
        """The number of finite zeros of A(s)."""
        return self.pairs.structure.finite_count

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """Residuals, conditions and gaps of the pairs."""
        with np.errstate(all="ignore"):
            return self.pairs.evidence

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Growth and doubtful decisions."""
        with np.errstate(all="ignore"):
            return pair_notices(self.pairs)


def _regular_part(form: WeierstrassForm, start: Start, force: ImpulsiveSmooth, later: KnotJumps) -> tuple[BohlFunction, float]:
    """x(t) for t > 0 in the user's units and the largest decoupling entry."""
    free, driven, scaling = block_diagonalize(form.T), driven_form(form, force), form.companion.scaling
    return driven_motion(FinitePart(free, form.C, driven, start.finite, later.finite, scaling.time, scaling.columns), force)[:2]
