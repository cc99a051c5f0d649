"""Maxima, minima and mean squares of functions of time in closed form: complete, and as accurate as the function.

Extrema are those of branch and bound.

On a panel of width h the third derivative of f = C e^{J t} v is at most B_3 = sum over blocks |c J^3| |v(t_0)| e^{max(mu, 0) h}, mu the
logarithmic norm of the block. A panel is left out where no value on it exceeds the best one known: f <= max(f_0, f_1) + B_2 h^2 / 8, where the
curvature of a block counts no more than twice its amplitude, and f is at most the sum of all amplitudes. A panel has at most one extremum, which
is refined, where f'' keeps its sign, |f''| at the middle > B_3 h / 2; all others are halved, those that promise most first. A motion of so many
periods that the work exceeds ``MOST_WORK`` keeps a margin: how far a value that was not searched may lie beyond the best one. Sources:
logarithmic norm, Dahlquist, Trans. Royal Inst. of Technology Stockholm 130 (1959); branch and bound, Piyavskii, USSR Comput. Math. 12 (1972).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..ground.errors import InputError, Overflow
from ..ground.tolerances import EPS, EXTREMA_ACCURACY, ROUGH_PART, SHOWN_MARGIN, VISIBLE_PART
from ..linalg.blocks import block_slices
from ..linalg.exponential import block_states
from ..linalg.scaling import balanced
from ..signals.bohl import BohlFunction
from ..signals.inputs import step

#: Most steps that refine the time of an extremum.
STEPS = 60

#: Panels that are evaluated at once, times the number of states and rows.
CHUNK = 1 << 18

#: Panels are not halved beyond this share of the time at which they are.
NARROWEST = 8 * EPS

#: Rounding errors of a value, relative to the largest of its function.
NOISE = 16 * EPS

#: Panels at the start, so that a good value is known early.
FIRST_PANELS = 256

#: Numbers that are computed at most, about a second: panels times states and rows.
MOST_WORK = 1 << 23

#: Samples in a radian of the fastest part of a function that is sampled, and the most of all; refinements of the best one.
SAMPLES, MOST_SAMPLES, ZOOMS = 6, 200_000, 9

#: Points of Gauss's rule on a panel, and the longest panel in radians of the fastest part: the square of a sum of exponentials is
#: integrated with an error of (12^32 (16!)^4) / (33 (32!)^3) = 1e-20 of its largest value by amplitudes.
GAUSS, RADIANS = 16, 6.0

#: Times at which functions are compared with more accurate ones.
COMPARED = 64

#: The smallest normal number: the size of a function that is zero.
TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class Extrema:
    """The largest and the smallest value of each of r functions, and their times; all of shape (r,)."""

    maximum: np.ndarray
    minimum: np.ndarray
    maximum_time: np.ndarray  # in s; that of a limit from the left is the last float64 number before the jump
    minimum_time: np.ndarray
    # Bound of the excess of the extrema over these values: 0 except for motions of very many periods, infinite for modes below rounding.
    margin: np.ndarray

    @property
    def is_open(self) -> np.ndarray:
        """Which functions may exceed their values visibly, shape (r,)."""
        return self.margin > SHOWN_MARGIN * self.largest

    @property
    def largest(self) -> np.ndarray:
        """max |f|, shape (r,)."""
        return np.maximum(self.maximum, -self.minimum)

    @property
    def largest_time(self) -> np.ndarray:
        """Times of the largest moduli in s, shape (r,)."""
        return np.where(self.maximum >= -self.minimum, self.maximum_time, self.minimum_time)

    def with_values(self, function: Callable[[np.ndarray], np.ndarray]) -> Extrema:
        """The values of a more accurate evaluation at the times of the extrema."""
        count = len(self.maximum)
        times, place = np.unique([*self.maximum_time, *self.minimum_time], return_inverse=True)
        maximum, minimum = function(times)[np.tile(np.arange(count), 2), place].reshape(2, -1) if count else np.zeros((2, 0))
        noise = NOISE * np.maximum(np.abs(maximum), np.abs(minimum))
        maximum, minimum = (np.where(np.abs(one) > noise, one, 0.0) for one in (maximum, minimum))
        return replace(self, maximum=maximum, minimum=minimum)

    def shifted(self, constants: np.ndarray) -> Extrema:
        """Extrema of f + constants."""
        return replace(self, maximum=self.maximum + constants, minimum=self.minimum + constants)


def extrema(function: BohlFunction, start: float, end: float) -> Extrema:
    """The extrema of f(t) on [start, end]."""
    search = _ExtremumSearch(getattr(function, "rough", function), start, end)
    search.run()
    searched = Extrema(search.best[0], -search.best[1], search.times[0], search.times[1], search.margin)
    extremes = searched.with_values(function)
    if not hasattr(function, "rough"):
        return extremes
    differences = np.abs([searched.maximum - extremes.maximum, searched.minimum - extremes.minimum]).max(axis=0, initial=0.0)
    unlike = differences > EPS**0.5 * extremes.largest  # modes that float64 does not resolve were not searched
    return replace(extremes, margin=np.where(unlike & (extremes.largest > 0), np.inf, extremes.margin))


@dataclass(frozen=True, eq=False)
class RootMeanSquares:
    """The square root of the mean of f^2 over an interval, for each of r functions."""

    values: np.ndarray  # shape (r,)
    error_estimate: np.ndarray  # absolute, shape (r,)


def root_mean_squares(
    function: BohlFunction, start: float, end: float, constants: np.ndarray | None = None, accurate: Callable | None = None
) -> RootMeanSquares:
    """The RMS values of f(t) + constants over [start, end], by integrals of the closed form.

    From knot to knot f^2 is integrated by Gauss's rule on panels that are short for the fastest part, which is exact to rounding
    errors. Where that takes too many panels, integrals of the states are doubled, G(2 h) = G(h) + E G(h) E^T with E = e^{J h}.
    """
    rough = getattr(function, "rough", function)
    if constants is not None and np.any(constants):
        rough = rough + step(constants).smooth
    edges, panels = _panels(rough, start, end)
    wanted = GAUSS * panels.sum()
    doubt = np.zeros(rough.size)
    if accurate is not None:
        times = np.unique([*np.linspace(start, end, COMPARED), *edges[:-1][:: max(1, len(edges) // COMPARED)]])
        proved = accurate(times)
        doubt, size = np.abs(rough(times) - proved).max(axis=1, initial=0.0), np.sqrt((proved**2).mean(axis=1))
        if (doubt > np.maximum(ROUGH_PART * size, NOISE * size.max(initial=0.0))).any():
            if wanted > MOST_SAMPLES:
                raise InputError(
                    "the motion has too many periods for the accuracy that its values need; choose an earlier end in [time]"
                )
            sums, errors = _by_values(accurate, edges, panels)
            return RootMeanSquares(np.sqrt(sums / (end - start)), NOISE * np.sqrt(sums / (end - start)))
    if wanted <= MOST_SAMPLES:
        sums, errors = _by_values(rough, edges, panels)
        states = BohlFunction(np.eye(rough.state_count), rough.blocks, rough.start)(edges)
        doubt = doubt + NOISE * (np.abs(rough.coefficients) @ np.abs(states)).max(axis=1)  # where modes cancel
    else:
        sums, errors = _by_doubling(rough, edges, panels)
    values = np.sqrt(sums / (end - start))
    return RootMeanSquares(
        values, doubt + np.minimum(errors / (2 * np.sqrt(np.maximum(sums, TINY))), np.sqrt(errors)) / np.sqrt(end - start)
    )


def _panels(function: BohlFunction, start: float, end: float) -> tuple[np.ndarray, np.ndarray]:
    """The knots between the ends with these, and a power of two of panels in each interval."""
    knots = function.restarts.knots
    edges = np.unique([start, *knots[(knots > start) & (knots < end)], end])
    rate = 0.0
    for block in function.blocks:
        with np.errstate(invalid="ignore", over="ignore"):
            rate = max(rate, float(np.linalg.norm(balanced(block)[0], 2)))
    needed = np.maximum(np.diff(edges) * rate / RADIANS, 1.0)
    return edges, 2.0 ** np.ceil(np.log2(needed))


def _by_values(function: Callable, edges: np.ndarray, panels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Integrals of f^2 by its values, and estimates of their errors."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
    counts = panels.astype(int)
    width = np.repeat(np.diff(edges) / counts, counts)
    begin = np.concatenate([low + (high - low) / n * np.arange(n) for low, high, n in zip(edges, edges[1:], counts)])
    times = (begin[:, None] + width[:, None] * (nodes + 1) / 2).reshape(-1)
    squares = function(times) ** 2
    sums = squares @ (width[:, None] * weights / 2).reshape(-1)
    return sums, NOISE * sums


def _by_doubling(function: BohlFunction, edges: np.ndarray, panels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Integrals of f^2, with error estimates, by integrals of w w^T over the first panel after each knot, repeatedly doubled."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
    states = BohlFunction(np.eye(function.state_count), function.blocks, function.start)  # one set of states for all rows
    C, unit = function.coefficients, np.eye(function.state_count)
    sums, errors = np.zeros((2, len(C)))
    for low, high, count in zip(edges, edges[1:], panels):
        h, doublings = (high - low) / count, int(np.log2(count))
        W = states(low + h * (nodes + 1) / 2) * np.sqrt(h * weights / 2)
        G = W @ W.T
        for number in range(doublings):
            E = block_states(function.blocks, unit, np.full(len(unit), h * 2.0**number))
            G = G + E @ G @ E.T
        sums += np.maximum(np.einsum("ij,jk,ik->i", C, G, C), 0.0)
        errors += NOISE * (doublings + 1) * (np.abs(C) @ np.sqrt(G.diagonal())) ** 2
    if not np.isfinite(errors).all():
        raise Overflow("the motion grows beyond the range of float64; choose an earlier end")
    return sums, errors


def fastest_rate(function: BohlFunction) -> float:
    """The largest modulus in 1/s of an eigenvalue of a block whose part of a row counts next to the largest amplitude of the row."""
    search = _ExtremumSearch(function, 0.0, 0.0)
    sizes = search.bounds[0] * search._norms(function.restarts.states / search.scale[:, None]).max(axis=1, initial=0.0)
    counts = (sizes > VISIBLE_PART * sizes.max(axis=1, initial=0.0)[:, None]).any(axis=0)
    return float(np.sqrt(search.curvature[counts, 0]).max(initial=0.0))


def sampled_extrema(at: Callable[[np.ndarray], np.ndarray], breaks: np.ndarray, rate: float, start: float, end: float) -> Extrema:
    """Extrema of functions that are no sums of exponentials, such as energies: of samples, refined by parabolas."""
    times = _sampled_times(breaks, rate, start, end)
    values = at(times)
    rows, sides = np.repeat(np.arange(len(values)), 2), np.tile([1.0, -1.0], len(values))
    place = (sides[:, None] * values[rows]).argmax(axis=1)
    best, when = values[rows, place], times[place]
    low, high = times[np.maximum(place - 1, 0)], times[np.minimum(place + 1, len(times) - 1)]
    for _ in range(ZOOMS if len(values) else 0):  # eight times finer each, about the best one
        grid = np.linspace(low, high, 17)
        fine, back = np.unique(grid, return_inverse=True)
        own = sides * at(fine)[rows[None, :], back.reshape(grid.shape)]
        place, column = own.argmax(axis=0), np.arange(len(rows))
        better = own[place, column] > sides * best
        best, when = np.where(better, sides * own[place, column], best), np.where(better, grid[place, column], when)
        low, high = grid[np.maximum(place - 1, 0), column], grid[np.minimum(place + 1, 16), column]
    margin = np.full(len(values), np.inf if len(times) > MOST_SAMPLES else 0.0)
    return Extrema(best[::2], best[1::2], when[::2], when[1::2], margin)


def _sampled_times(breaks: np.ndarray, rate: float, start: float, end: float) -> np.ndarray:
    """Enough times to resolve the fastest part, and both sides of the breaks."""
    wanted = int(min(max(FIRST_PANELS, SAMPLES * rate * (end - start)), MOST_SAMPLES))
    inside = breaks[(breaks > start) & (breaks < end)]
    return np.unique([*np.linspace(start, end, wanted + 1), *inside, *np.nextafter(inside, start)])


def positive_times(
    at: Callable[[np.ndarray], np.ndarray], breaks: np.ndarray, rate: float, start: float, end: float
) -> tuple[np.ndarray, np.ndarray]:
    """The times at which functions are largest, and those at which they first become positive, by bisection."""
    extremes = sampled_extrema(at, breaks, rate, start, end)
    largest, first = np.full((2, len(extremes.maximum)), np.inf)
    (rows,) = (extremes.maximum > 0).nonzero()
    if len(rows):
        largest[rows] = extremes.maximum_time[rows]
        times = np.unique([*_sampled_times(breaks, rate, start, end), *largest[rows]])
        place = (at(times)[rows] > 0).argmax(axis=1)
        low, high = times[np.maximum(place - 1, 0)], times[place]
        for _ in range(STEPS):
            own, back = np.unique(low + (high - low) / 2, return_inverse=True)
            is_positive = at(own)[rows, back] > 0
            low, high = np.where(is_positive, low, own[back]), np.where(is_positive, own[back], high)
        first[rows] = high
    return largest, first


class _ExtremumSearch:
    """State of one search. Signs: each step is done for f and for -f."""

    def __init__(self, function: BohlFunction, start: float, end: float):
        function = BohlFunction(function.coefficients, function.blocks, function.start)  # one set of states for all derivatives
        knots = function.restarts.knots
        self.edges = np.unique([start, *knots[(knots > start) & (knots < end)], end])
        slices, J = block_slices(function.blocks), function.blocks
        self.first = np.array([at.start for at in slices], dtype=int)
        scales, growth, self.curvature = [np.ones(0)], [], np.zeros((len(J), 1))
        for number, block in enumerate(J):
            matrix, scale = balanced(block)
            scales.append(scale)
            growth.append(np.linalg.eigvalsh((matrix + matrix.T) / 2)[-1])
            with np.errstate(over="ignore", invalid="ignore"):
                self.curvature[number] = np.nan_to_num(np.linalg.norm(matrix @ matrix, 2), nan=np.inf)
        self.scale, self.growth = np.concatenate(scales), np.maximum(np.array(growth), 0.0)
        self.states = BohlFunction(np.eye(len(self.scale)) / self.scale[:, None], J, function.start)
        self.tables = [function.derivative(order).coefficients * self.scale for order in range(4)]
        self.bounds = [self._norms(table.T).T for table in self.tables]
        self.best = np.full((2, function.size), -np.inf)
        self.times = np.full((2, function.size), float(start))
        self.margin = np.zeros(function.size)

    def _norms(self, columns: np.ndarray) -> np.ndarray:
        """The Euclidean norm over the states of each block, shape (number of blocks, P)."""
        return np.sqrt(np.add.reduceat(np.square(columns), self.first, axis=0)) if len(self.first) else columns

    def _at(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """f, f' and f'' at times, and the sizes of the blocks."""
        states = self.states(times)
        f, slope, bend = (table @ states for table in self.tables[:3])
        return f, slope, bend, self._norms(states)

    def run(self) -> None:
        """Search all panels, the most promising first."""
        count = len(self.scale) + 4 * len(self.margin)
        most, work = max(1, CHUNK // max(count, 1)), max(MOST_WORK // max(count, 1), 16 * len(self.edges))
        a, b = self.edges[:-1], np.nextafter(self.edges[1:], self.edges[:-1])  # the limits from the left
        b[-1:] = self.edges[-1]
        inner = np.linspace(self.edges[0], self.edges[-1], FIRST_PANELS + 1)[1:-1]
        inner = inner[~np.isin(inner, self.edges)] if len(a) <= FIRST_PANELS else inner[:0]
        a, b = np.sort(np.append(a, inner)), np.sort(np.append(b, inner))
        if not len(a):
            self._note(self.edges, self._at(self.edges)[0])
            return
        fa, da, _, sizes = self._at(a)
        fb, db, *_ = self._at(b)
        for times, values in ((a, fa), (b, fb)):
            self._note(times, values)
        panels = {"a": a, "b": b, "fa": fa, "da": da, "fb": fb, "db": db, "sizes": sizes, "hope": np.full((2, *fa.shape), np.inf)}
        waiting = [(np.inf, _part(panels, part)) for part in np.split(np.arange(len(a)), range(most, len(a), most))]
        while waiting:
            _, panels = waiting.pop(max(range(len(waiting)), key=lambda i: waiting[i][0]))
            panels = _part(panels, self._excess(panels) > EXTREMA_ACCURACY)
            if (work := work - panels["a"].shape[-1]) < 0:
                for each in (panels, *(each for _, each in waiting)):
                    self.margin = np.maximum(self.margin, (each["hope"].max(axis=-1) - self.best).max(axis=0, initial=0.0))
                return
            if panels["a"].shape[-1]:
                panels = self._halved(panels)
                excess = self._excess(panels)
                order = np.argsort(-excess, kind="stable")
                order = order[: np.count_nonzero(excess > EXTREMA_ACCURACY)]
                waiting += [
                    (excess[part[0]], _part(panels, part)) for part in np.split(order, range(most, len(order), most)) if len(part)
                ]

    def _excess(self, panels: dict[str, np.ndarray]) -> np.ndarray:
        """Largest relative excess of the bounds of panels over the best values, over all rows; 0 for panels too narrow to halve."""
        size = np.abs(self.best).max(axis=0)
        with np.errstate(invalid="ignore", over="ignore"):
            excess = (panels["hope"] - self.best[:, :, None]) / np.where(size > 0, size, TINY)[:, None]
        wide = panels["b"] - panels["a"] > NARROWEST * np.abs(panels["b"])
        return np.where(wide, np.nan_to_num(excess, nan=np.inf).max(axis=(0, 1), initial=0.0), 0.0)

    def _note(self, times: np.ndarray, values: np.ndarray, rows: np.ndarray | None = None) -> None:
        """Keep values (r, P) at times (P,), or values (P,) of single rows, where they exceed the best ones."""
        if not values.size:
            return
        for side, signed in enumerate((values, -values)):
            if rows is None:
                place = signed.argmax(axis=1)
                candidates, at, own = signed[np.arange(len(signed)), place], times[place], np.arange(len(signed))
            else:
                order = np.argsort(signed, kind="stable")  # the best of each row is written last
                own, candidates, at = rows[order], signed[order], times[order]
            better = candidates > self.best[side, own]
            self.best[side, own[better]], self.times[side, own[better]] = candidates[better], at[better]

    def _halved(self, panels: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Halves of the panels, with upper bounds of their values."""
        a, b, sizes = panels["a"], panels["b"], panels["sizes"]
        h, middle = b - a, a + (b - a) / 2
        f, slope, bend, new = self._at(middle)
        self._note(middle, f)
        with np.errstate(over="ignore", invalid="ignore"):
            grown = sizes * np.exp(np.minimum(np.multiply.outer(self.growth, h), 700.0))
            largest, _, second, third = (np.nan_to_num(bound @ grown, nan=np.inf) for bound in self.bounds)
            parts = np.nan_to_num(self.bounds[0] @ (grown * np.minimum(self.curvature * h**2 / 8, 2.0)), nan=np.inf)
            reach = np.minimum(np.minimum(second, np.abs(bend) + third * h / 2) * h**2 / 8, parts)
            is_bent = np.abs(bend) > third * h / 2
        hope = np.empty_like(panels["hope"])
        for side, sign in enumerate((1.0, -1.0)):
            top = np.minimum(np.maximum(sign * panels["fa"], sign * panels["fb"]) + reach, largest)
            open_ = top > self.best[side][:, None] + EXTREMA_ACCURACY * np.abs(self.best).max(axis=0)[:, None]
            row, place = np.nonzero(open_ & is_bent & (sign * panels["da"] > 0) & (sign * panels["db"] < 0))
            if len(row):
                self._refine(row, a[place], b[place], panels["da"][row, place], panels["db"][row, place])
            hope[side] = np.where(is_bent, -np.inf, top)
        first = panels | {"b": middle, "fb": f, "db": slope, "hope": hope}
        other = panels | {"a": middle, "fa": f, "da": slope, "sizes": new, "hope": hope}
        return {name: np.concatenate([first[name], other[name]], axis=-1) for name in first}

    def _refine(self, row, low, high, above, below) -> None:
        """The extrema between these times, one each."""
        slopes, size = self.tables[1][row], np.abs(self.best).max(axis=0)[row]

        def rate(times):
            return np.sign(above) * np.einsum("ps,sp->p", slopes, self.states(times))

        def is_enough(now, width):
            return (np.abs(now) * width <= NOISE * size).all()

        times = falling_root(rate, low, high, np.abs(above), -np.abs(below), is_enough)
        self._note(times, np.einsum("ps,sp->p", self.tables[0][row], self.states(times)), row)


def _part(panels: dict[str, np.ndarray], chosen) -> dict[str, np.ndarray]:
    return {name: values[..., chosen] for name, values in panels.items()}


def falling_root(rate: Callable, low, high, above, below, is_enough: Callable | None = None) -> np.ndarray:
    """Sign changes of functions from positive to negative, by the Illinois method."""
    last, middle = np.zeros(len(low)), low
    for _ in range(STEPS):
        with np.errstate(invalid="ignore"):
            share = np.nan_to_num(above / (above - below), nan=0.5)
        middle = low + (high - low) * share
        now = rate(middle)
        side = np.sign(now)
        above, below = (
            np.where(side > 0, now, np.where(last < 0, above / 2, above)),
            np.where(side > 0, np.where(last > 0, below / 2, below), now),
        )
        low, high, last = np.where(side > 0, middle, low), np.where(side > 0, high, middle), side
        narrow = high - low <= np.spacing(np.abs(high))
        if (narrow | (now == 0)).all() or (is_enough is not None and is_enough(now, high - low)):
            break
    return middle
