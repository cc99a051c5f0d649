"""A function of time given by its values: piecewise polynomials through Chebyshev points, to a stated tolerance.

The search for edges (kinks and jumps) comes first; then each interval between edges is divided evenly until the tolerance is
met. All pieces have nearly the same length, so that one chain of states for t^k in units of this length serves all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial, chebyshev

from ..ground.by_name import answering
from ..ground.checks import real_number
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import (
    APPROXIMATION_TOLERANCE,
    COEFFICIENT_NOISE,
    EDGE_UNITS,
    EPS,
    JOINT_SAFETY,
    LEAST_APPROXIMATION_TOLERANCE,
)
from .bohl import BohlFunction, Restarts
from .impulsive import ImpulsiveSmooth

# Polynomials through Chebyshev points on many intervals at once, each in its own time from 0 to 1.

#: Polynomials of this degree take four pieces for a period of a harmonic at a tolerance of 1e-12, and their
#: coefficients of powers from the left end on are larger than the values by no more than the tolerance allows.
DEGREE = 10

#: Chebyshev points of the first kind on [0, 1]: none at the ends, where the function may jump.
NODES = (1 - np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))) / 2

#: Places between the nodes at which the polynomial is compared with the function, close to both ends and within.
CHECKS = np.array([0.001, 0.17, 0.46, 0.79, 0.999])


#: The map from values at the nodes to coefficients of T_j(2 t - 1).
TO_CHEBYSHEV = np.where(np.arange(DEGREE + 1), 2.0, 1.0)[:, None] / (DEGREE + 1) * chebyshev.chebvander(2 * NODES - 1, DEGREE).T

#: The map from these to coefficients of t^k.
TO_POWERS: np.ndarray = np.column_stack(
    [np.pad(Chebyshev.basis(j, [0, 1]).convert(kind=Polynomial).coef, (0, DEGREE - j)) for j in range(DEGREE + 1)]
)

#: The matrix about the right end: T_j is even or odd about the middle.
TO_POWERS_AT_END = TO_POWERS * (-1.0) ** np.add.outer(np.arange(DEGREE + 1), np.arange(DEGREE + 1))

#: Bound on the change of the coefficients of t^k per error of the polynomial.
SENSITIVITY = np.abs(TO_POWERS).sum(axis=1)


@dataclass(frozen=True, eq=False)
class Fit:
    """Polynomials of m intervals with r rows."""

    powers: np.ndarray  # coefficients of t^k from the left end on, t = 1 at the right end, shape (r, m, DEGREE + 1)
    powers_at_end: np.ndarray  # coefficients about the right end
    error: np.ndarray  # estimated largest error, shape (m,)
    follows: np.ndarray  # whether it is within the tolerance, shape (m,)

    @property
    def size(self) -> int:
        """The number r of rows."""
        return len(self.powers)

    def at(self, k: int) -> Fit:
        """The fit of one interval."""
        one = slice(k, k + 1)
        return Fit(self.powers[:, one], self.powers_at_end[:, one], self.error[one], self.follows[one])

    def jumps(self, error: float, ratio: np.ndarray) -> np.ndarray:
        """Changes of the coefficients at all knots in the unit of the next interval, those within the error set to zero.

        They begin from zero and end at zero; shape (r, m + 1, DEGREE + 1).
        """
        scale = (ratio[:-1] / ratio[1:])[:, None] ** np.arange(DEGREE + 1.0)
        inner = self.powers[:, 1:] - self.powers_at_end[:, :-1] * scale
        change = np.concatenate([self.powers[:, :1], inner, -self.powers_at_end[:, -1:]], axis=1)
        terms = np.pad(1 + scale, ((1, 1), (0, 0)), constant_values=1.0)
        return np.where(np.abs(change) > JOINT_SAFETY * error * SENSITIVITY * terms, change, 0.0)

    def breaks(self, other: Fit, ratio: float, error: float) -> bool:
        """Whether value, slope or curvature jump to the next interval, which is shorter by the ratio."""
        own, others = (max(1.0, side) ** -np.arange(3.0) for side in (ratio, 1 / ratio))  # in units of the shorter one
        change = np.abs(other.powers[:, 0, :3] * others - self.powers_at_end[:, 0, :3] * own)
        return bool((change > JOINT_SAFETY * error * SENSITIVITY[:3] * (own + others)).any())

    def bend(self, other: Fit, own_ratio: float, other_ratio: float) -> float:
        """Change of slope and curvature to the next interval, with a unit of length over the lengths of both."""
        own, others = (ratio ** np.arange(1.0, 3.0) for ratio in (own_ratio, other_ratio))
        return float(np.abs(other.powers[:, 0, 1:3] * others - self.powers_at_end[:, 0, 1:3] * own).max())

    def meetings(self, other: Fit, length: float, other_length: float, gap: float) -> list[float]:
        """Times after the end of this interval at which its parabola meets that of an interval that begins a gap later.

        Where the parabolas only touch, or nearly so, it is the time of their least distance. This locates a kink close to
        an end of an interval, where the interpolation points missed it.
        """
        own = self.powers_at_end[:, 0, :3] / length ** np.arange(3.0)
        zero, one, two = (other.powers[:, 0, :3] / other_length ** np.arange(3.0)).T
        moved = np.stack([zero - gap * one + gap**2 * two, one - 2 * gap * two, two], axis=1)
        difference = moved - own
        row = int((np.abs(difference) * length ** np.arange(3.0))[:, 1:].max(axis=1).argmax())
        return [float(root.real) for root in np.roots(difference[row, ::-1])]


def fitted(values: np.ndarray, largest: float, tolerance: float) -> Fit:
    """Polynomials through the values at NODES, compared with those at CHECKS; values of shape (r, m, nodes and checks)."""
    at_nodes, at_checks = values[..., : DEGREE + 1], values[..., DEGREE + 1 :]
    coefficients = at_nodes @ TO_CHEBYSHEV.T
    coefficients = np.where(np.abs(coefficients) <= COEFFICIENT_NOISE * EPS * largest, 0.0, coefficients)
    missed = np.abs(coefficients @ chebyshev.chebvander(2 * CHECKS - 1, DEGREE).T - at_checks).max(axis=(0, 2))
    tail = np.abs(coefficients[..., -2:]).sum(axis=2).max(axis=0)
    rounding = EPS * (np.abs(coefficients) @ np.abs(TO_POWERS).T).sum(axis=2).max(axis=0)
    error = np.maximum(missed, tail)
    powers, powers_at_end = coefficients @ TO_POWERS.T, coefficients @ TO_POWERS_AT_END.T
    return Fit(powers, powers_at_end, error, np.maximum(error, rounding) <= tolerance * largest)


#: One over the length of a piece, and its products with the values, must stay within the range of float64.
SHORTEST_END = 1e-280


@dataclass(frozen=True, repr=False)
class Approximation(ImpulsiveSmooth):
    """An input that approximates a function given by its values.

    Attributes:
        points: number of values of the function that were computed.
        pieces: number of polynomials.
        error: estimate of max |error| / max |value|, from the last coefficients of the polynomials and from values
            between their interpolation points. Nothing is known of the function between the times at which it was evaluated.
    """

    points: int = 0
    pieces: int = 0
    error: float = 0.0


@answering
def approximated(function: Callable, end: float, *, tolerance: float = APPROXIMATION_TOLERANCE) -> Approximation:
    """The function for 0 <= t < end, zero afterwards, by piecewise polynomials of degree 10.

    Kinks and jumps are located to rounding error (Pachon, Platte and Trefethen, Piecewise-smooth chebfuns, 2010); a feature
    shorter than a hundredth of the whole between two smooth intervals may be missed. Each derivative of the force that the
    response needs loses digits.

    Args:
        function: takes times of shape (T,) and returns values (r, T) or (T,); or takes one time and returns (r,) or
            a number. It is evaluated at times from 0 to end only.
        end: in s.
        tolerance: tolerance of the error relative to the largest value.

    Returns:
        An ``Approximation`` with r rows.

    Raises:
        InputError: values that are not real, not finite, of different shapes or not approximated to the tolerance, or a
            call that fails; the text names the time.

    >>> import numpy as np
    >>> from mbconstrained import approximated
    >>> f = approximated(lambda t: np.abs(np.sin(3 * t)), 2.0)
    >>> float(abs(f(1.0)[0] - abs(np.sin(3.0)))) < 1e-12, f.error < 1e-12
    (True, True)
    """
    end, tolerance = real_number(end, "end", positive=True), real_number(tolerance, "tolerance", positive=True)
    if tolerance < LEAST_APPROXIMATION_TOLERANCE:
        raise InputError(f"tolerance: found {tolerance:g}; rounding allows at least {LEAST_APPROXIMATION_TOLERANCE:.2g}")
    values = _Values(function, tolerance)
    if end < SHORTEST_END:
        raise InputError(f"end: found {end:g} s; expected at least {SHORTEST_END:g} s, so that slopes stay in the range of float64")
    knots, fit = _even_pieces(values, _edges_of(values, end), end)
    error = float(fit.error.max() / values.largest) if values.largest else 0.0
    unseen = float(np.diff(knots).max() * np.diff(np.sort(np.concatenate([[0.0], NODES, CHECKS, [1.0]]))).max())
    text = (
        f"the force is approximated by {len(knots) - 1} polynomials from {values.points} values, at these to {error:.2g} of its "
        f"largest; what is shorter than {unseen:.2g} s may lie between them"
    )
    smooth = _function(knots, fit, tolerance * values.largest)
    return Approximation(smooth, (), (), (Notice(NoticeKind.ACCURACY, text),), values.points, len(knots) - 1, error)


def _even_pieces(values: _Values, edges: np.ndarray, end: float) -> tuple[np.ndarray, Fit]:
    """Knots and polynomials, with the intervals between edges divided evenly."""
    borders = np.concatenate([[0.0], edges, [end]])
    for halvings in range(FIRST_HALVINGS, MOST_HALVINGS + 1):
        counts = np.ceil(np.diff(borders) / end * 2**halvings - EPS**0.5).astype(int).clip(1)
        intervals = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(borders, borders[1:], counts)]
        knots = np.append(np.concatenate(intervals), end)
        fit = values.fit(knots[:-1], np.diff(knots))
        if fit.follows.all():
            return knots, fit
    place, error = knots[np.argmin(fit.follows)], fit.error[np.argmin(fit.follows)] / values.largest
    raise InputError(
        f"function: near t = {place:.6g} s {2**MOST_HALVINGS} polynomials follow it only to {error:.2g} of its largest value, "
        f"not to {values.tolerance:g}; {REMEDY}"
    )


def _function(knots: np.ndarray, fit: Fit, error: float) -> BohlFunction:
    """The pieces as one function: the states of a row are p^(k) / (k! u^k), u one over the longest piece."""
    lengths = np.diff(knots)
    ratio = lengths.max() / lengths
    powers = ratio[:, None] ** np.arange(DEGREE + 1.0)
    jumps = fit.jumps(error, ratio) * np.vstack([powers, powers[-1:]])
    states = np.concatenate([fit.powers * powers, np.zeros((fit.size, 1, DEGREE + 1))], axis=1)
    count = max(int(np.flatnonzero(states.any(axis=(0, 1))).max(initial=0)), 0) + 1
    generator = np.diag(np.arange(1.0, count), k=1) / lengths.max()
    rows = np.kron(np.eye(fit.size), np.eye(1, count)[0])
    start = Restarts(knots, _by_state(states[..., :count]), _by_state(jumps[..., :count]))
    return BohlFunction(rows, (generator,) * fit.size, start)


def _by_state(values: np.ndarray) -> np.ndarray:
    """(r, K, m) as (r m, K)."""
    return values.transpose(0, 2, 1).reshape(-1, values.shape[1])


#: Larger values leave the range of float64 in the coefficients of polynomials.
LARGEST_VALUE = 1e280

EXPECTED = "expected a number or a list of r numbers for each time"


class _Values:
    """The checked values of a user's function as arrays (r, ...), with the largest value and the number of times so far."""

    def __init__(self, function: Callable, tolerance: float):
        if not callable(function):
            raise InputError(f"function: found {function!r}; expected a function of time, e.g. lambda t: np.sin(3 * t)")
        self.function, self.tolerance = function, tolerance
        self.points, self.largest, self.by_array = 0, 0.0, True
        self.rows: int | None = None

    def __call__(self, times: np.ndarray) -> np.ndarray:
        flat = times.ravel()
        with np.errstate(all="ignore"):  # values that are not finite are reported with their time
            values = self._together(flat)
            values = self._one_by_one(flat) if values is None else values
        self._check(flat, values)
        self.points += len(flat)
        self.largest = max(self.largest, float(np.abs(values).max(initial=0.0)))
        return values.reshape(-1, *times.shape)

    def fit(self, begins: np.ndarray, lengths: np.ndarray) -> Fit:
        """Polynomials on the intervals, with the decision whether they meet the tolerance."""
        places = np.concatenate([NODES, CHECKS])
        values = self(begins[:, None] + lengths[:, None] * places)
        return fitted(values, self.largest, self.tolerance)

    def _check(self, times, values) -> None:
        fits = (np.abs(values) <= LARGEST_VALUE).all(axis=0)
        if not fits.all():
            at = int(np.argmin(fits))
            what = "too large" if np.isfinite(values[:, at]).all() else "not finite"
            raise InputError(f"function: it is {what} at t = {times[at]:.17g} s; expected values of a size up to {LARGEST_VALUE:g}")
        self.rows = len(values) if self.rows is None else self.rows
        if len(values) != self.rows:
            raise InputError(
                f"function: it has {len(values)} rows near t = {times[0]:.17g} s and {self.rows} elsewhere; {EXPECTED}"
            )

    def _together(self, times) -> np.ndarray | None:
        """The values at all times in one call, or None where the function accepts one time only."""
        if self.by_array:
            try:
                values = np.asarray(self.function(times.copy()))
            except Exception:  # the calls with one time that follow report the error with its time
                values = np.zeros(())
            if values.dtype.kind in "biuf" and values.ndim in (1, 2) and values.size and values.shape[-1] == len(times):
                return values.reshape(-1, len(times)).astype(float)
            self.by_array = False
        return None

    def _one_by_one(self, times) -> np.ndarray:
        values = [self._at(float(t)) for t in times]
        for t, value in zip(times, values):
            if len(value) != len(values[0]):
                raise InputError(
                    f"function: it has {len(value)} rows at t = {t:.17g} s and {len(values[0])} at t = {times[0]:.17g} s; {EXPECTED}"
                )
        return np.array(values).T

    def _at(self, t: float) -> np.ndarray:
        try:
            value = self.function(t)
        except ArithmeticError as problem:
            raise InputError(f"function: it is not finite at t = {t:.17g} s ({problem}); give one that always is") from problem
        except Exception as problem:
            raise InputError(
                f"function: its call with t = {t:.17g} s fails with {type(problem).__name__}: {problem}; {EXPECTED}"
            ) from problem
        return _row(value, t)


def _row(value, t: float) -> np.ndarray:
    """A value as an array (r,)."""
    try:
        array = np.asarray(value)
        if array.dtype.kind == "O":  # numbers of other kinds, such as fractions
            array = np.array([float(item) for item in array.ravel()]).reshape(array.shape)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"function: found {_shown(value)} at t = {t:.17g} s; {EXPECTED}") from None
    if array.dtype.kind == "c":
        raise InputError(f"function: found the complex {_shown(value)} at t = {t:.17g} s; expected real numbers, e.g. real parts")
    if array.dtype.kind not in "biuf" or array.ndim > 1 or not array.size:
        raise InputError(f"function: found {_shown(value)} at t = {t:.17g} s; {EXPECTED}")
    return np.atleast_1d(array).astype(float)


def _shown(value) -> str:
    if isinstance(value, np.ndarray) and value.ndim:
        return f"array of shape {value.shape}"
    text = repr(value.item() if isinstance(value, np.generic) else value)
    return text if len(text) <= 60 else text[:57] + "..."


# Edges. Intervals on which the polynomial misses the tolerance are halved; a very short one that still misses it contains an
# edge. Further halving locates a jump to rounding error; a kink, also of a derivative, lies where the polynomials of both
# sides meet.

#: The first pieces are end / 2^this long, so that no feature longer than a hundredth of the whole is missed.
FIRST_HALVINGS = 4

#: Pieces are at least end / 2^this long: a shorter interval that misses the tolerance contains an edge.
MOST_HALVINGS = 14

#: More intervals than this that miss the tolerance mean a function that is rough everywhere.
MOST_EDGES = 1000

REMEDY = "ask for a larger tolerance, a shorter time, or give a smoother function"


def _edges_of(values, end: float) -> np.ndarray:
    """The times between 0 and end at which the function jumps or has a kink."""
    length = end / 2**FIRST_HALVINGS
    begins, leaves = length * np.arange(2**FIRST_HALVINGS), []
    while len(begins):
        fit = values.fit(begins, np.full(len(begins), length))
        last = length < EDGE_UNITS * EPS * end
        done = fit.follows | last
        leaves += [(begin, length, fit.at(k)) for k, begin in enumerate(begins) if done[k]]
        if length * 2**MOST_HALVINGS < end and len(begins) > MOST_EDGES:
            raise InputError(
                f"function: it is too rough to be followed to {values.tolerance:g} near t = {begins[0]:.6g} s; {REMEDY}"
            )
        length, begins = length / 2, np.sort(np.concatenate([begins[~done], begins[~done] + length / 2]))
    return _edges_between(sorted(leaves, key=lambda leaf: leaf[0]), values, end)


def _edges_between(leaves, values, end) -> np.ndarray:
    """One edge for each group of very short intervals, and the boundaries of longer ones with a discontinuity."""
    shortest, edges, first, error = end / 2**MOST_HALVINGS, [], None, values.tolerance * values.largest
    for k, (before, after) in enumerate(zip(leaves, [*leaves[1:], None])):
        last_narrow = before[1] < shortest and (after is None or after[1] >= shortest)
        if before[1] < shortest and first is None:
            first = k
        if last_narrow:
            edges.append(_edge_among(leaves[max(first - 1, 0) : k + 2]))
            first = None
        elif (
            first is None and after is not None and after[1] >= shortest and before[2].breaks(after[2], before[1] / after[1], error)
        ):
            edges.append(after[0])
    return np.array([edge for edge in edges if 0 < edge < end])


def _edge_among(narrow) -> float:
    """The edge within very short intervals and their two neighbours.

    A jump ends the interval that misses the tolerance to the last; at a kink the polynomials next to the shortest one meet.
    """
    begin, length, fit = min(narrow, key=lambda leaf: (leaf[2].follows[0], leaf[1]))
    if not fit.follows[0]:
        return begin + length
    joints = [k for k, pair in enumerate(pairwise(narrow)) if length in (pair[0][1], pair[1][1])]
    if not joints:
        return begin + length
    bend = max(joints, key=lambda k: narrow[k][2].bend(narrow[k + 1][2], length / narrow[k][1], length / narrow[k + 1][1]))
    left, right = narrow[max(bend - 1, 0)], narrow[min(bend + 2, len(narrow) - 1)]
    end, place = left[0] + left[1], narrow[bend + 1][0]
    meetings = [end + since for since in left[2].meetings(right[2], left[1], right[1], right[0] - end)]
    return min([m for m in meetings if left[0] < m < right[0] + right[1]], key=lambda m: abs(m - place), default=place)
