"""Functions of time as stored in a page, from which its script evaluates and draws curves at any time, with an error bound.

A function is a polynomial on each of some panels. A panel has its values at the Chebyshev points of the second kind, from
which the barycentric formula gives all others (Trefethen, Approximation Theory and Approximation Practice, chapter 5). The
degree is the lowest of ``DEGREES`` with which the polynomial meets the function at the points of twice the degree; where the
highest does not, the panel is divided. The values are whole multiples of a step, a power of two for each function and panel;
no value is off by more than ``BOUNDS`` of them.

Under a long record the functions are stored by the samples of the record and the propagation between them.

Between two samples a function is a polynomial whose values at the Chebyshev points are linear, those of energies quadratic, in the
state at the first of them and in both samples; so is the state at the second one, linear. With even gaps the matrices are the same
for all. They are identified by least squares from values of the solver. The page has them, the samples, and the state at the
first sample of each block, from which its script computes the others. What that costs in accuracy is measured between all
samples; what does not serve is stored by panels (``readings.py``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .animation import packed
from .content import RecordResponse, TimeFunctions

#: Degrees of the polynomials; the points of each are among those of the next.
DEGREES = (2, 4, 8, 16)

#: The largest error in steps, by the degree. Rounding the values to whole steps costs at most half the Lebesgue constant: 0.63
#: of degree 2 and 1.3 of degree 16. A panel of degree 0 is a line to the value of the next one.
BOUNDS = {0: 1.0, 2: 1.0, 4: 2.0, 8: 2.0, 16: 2.0}

#: The largest difference from the function, in steps, at the points where a polynomial is compared with it.
MEETS = 0.25

#: Steps in the largest value of a panel: eight digits, six where these would be many numbers, four where they would make the page
#: too large; nine digits of a few points.
FINEST, FINE, MIDDLE, COARSE = 2.0**30, 2.0**26, 2.0**20, 2.0**15

#: More numbers of a set of functions than the first are not stored finely, more than the second coarsely.
MOST_FINE, MOST_MIDDLE = 40_000, 400_000

#: More times than this at which a function restarts are those of a record, each in a panel of its own.
FEW_BREAKS = 2_000

#: Panels at the start of a motion without restarts.
FIRST_PANELS = 8

#: Times at which the size of the functions is sampled.
SAMPLES = 257

#: Panels are not divided beyond this number, nor below this share of the duration.
MOST_PANELS, SHORTEST = 300_000, 1e-9

#: Values below this share of the largest count as zero.
SMALLEST_SHARE = 1e-60

#: Panels that are evaluated at once.
AT_ONCE = 8_000

#: Drawn times of a curve: at first, and the most; the share of the height by which a line between two of them may leave the curve, half a
#: pixel; where in an interval that is tried; the golden ratio, whose multiples spread evenly.
FIRST_DRAWN, MOST_DRAWN, FOLLOWED, INNER, GOLDEN = 241, 20_001, 1 / 400, np.array([0.382, 0.71]), (5**0.5 - 1) / 2

#: How far the first and last point of a panel are inside it, as a share of its length: a function may jump at its ends.
INSIDE = 1e-9


@dataclass(frozen=True, eq=False)
class Readings:
    """Functions of time as stored in a page."""

    edges: np.ndarray  # edges of the k panels, shape (k + 1,), ascending
    degrees: np.ndarray  # shape (k,)
    exponents: np.ndarray  # exponents of the steps, by function and panel, shape (r, k)
    codes: np.ndarray  # values in steps, panel after panel in the order of time, shape (r, N)

    def as_data(self) -> dict:
        """Plain data for the page, numbers as packed bytes; edges by their number of units where they are such multiples."""
        gaps = np.diff(self.edges[:-1])
        unit = gaps[gaps > 0].min(initial=np.inf)
        counts = np.rint(gaps / unit)
        unit = gaps.sum() / max(1.0, counts.sum())  # without the rounding errors of one gap
        even = gaps.size > 0 and counts.max() < 2**16
        even = even and np.abs(self.edges[0] + unit * np.cumsum(counts) - self.edges[1:-1]).max() <= INSIDE * unit
        largest = np.abs(self.codes).max(initial=0)
        size = next(size for size in (2, 3, 4) if largest < 2 ** (8 * size - 1))
        base = int(self.exponents.min())
        inner = {"unit": float(unit), "counts": packed(counts, "<u2")} if even else {"edges": packed(self.edges[1:-1], "<f8")}
        return {
            "start": float(self.edges[0]),
            "end": float(self.edges[-1]),
            **inner,
            "degrees": packed(self.degrees, "u1"),
            "exponents": packed(self.exponents - base, "u1"),
            "base": base,
            "bytes": size,
            "codes": packed(self.codes.astype("<i4").ravel().view("u1").reshape(-1, 4)[:, :size], "u1"),
        }


def linear_readings(times: np.ndarray, values: np.ndarray) -> Readings:
    """Straight lines from point to point.

    >>> linear_readings(np.array([0.0, 1.0, 3.0]), np.array([[1.0, 2.0, 2.0]])).codes.shape
    (1, 3)
    """
    fineness = FINEST if values.size <= MOST_FINE else MIDDLE if values.size <= MOST_MIDDLE else COARSE
    exponents = _exponents(np.abs(values), fineness, SMALLEST_SHARE * np.abs(values).max())
    codes = _codes(values[:, :, None], exponents, fineness)[:, :, 0]
    return Readings(np.append(times, times[-1]), np.zeros(len(times), int), exponents, codes)


def readings_of(functions: TimeFunctions, start: float, end: float, largest: float = 0.0) -> Readings:
    """The readings of functions over a stretch of time.

    >>> wave = TimeFunctions(lambda times: np.array([np.sin(times)]), np.array([]))
    >>> len(readings_of(wave, 0.0, 10.0).degrees)
    8
    """
    inside = np.unique(functions.breaks[(functions.breaks > start) & (functions.breaks < end)])
    rows = len(functions.at(np.array([start])))
    fineness = FINE if len(inside) <= FEW_BREAKS else MIDDLE if 4 * rows * len(inside) <= MOST_MIDDLE else COARSE
    first = np.linspace(start, end, FIRST_PANELS + 1) if len(inside) <= FEW_BREAKS else [start, end]
    edges = np.union1d(first, inside)
    some = np.append(np.linspace(start, end, SAMPLES), edges[:: len(edges) // SAMPLES + 1])
    largest = float(np.abs(functions.at(np.unique(some))).max(initial=largest))
    floor = max(functions.noise, SMALLEST_SHARE) * largest
    levels = [one for one in ((FINE, MOST_FINE), (MIDDLE, MOST_MIDDLE), (COARSE, np.inf)) if one[0] <= fineness]
    tried = (_resolved(functions, edges, level, floor, most, rows * (DEGREES[0] + 1)) for level, most in levels)
    return _joined(next(panels for panels in tried if panels is not None), end)


def drawn_times(functions: TimeFunctions, start: float, end: float, units: Sequence[str]) -> np.ndarray:
    """Times between which straight lines follow the curves, so that their fastest visible part is resolved.

    An interval is divided where a curve leaves the straight line between its ends by more than ``FOLLOWED`` of the height of its plot, at two
    places inside it that are no multiples of each other. Of a motion of too many periods they are spread, each at another phase: the extremes
    of many of them, pixel by pixel, are its envelope.

    >>> wave = TimeFunctions(lambda times: np.array([np.sin(50 * times)]), np.array([]))
    >>> times = drawn_times(wave, 0.0, 10.0, ["m"])  # 80 periods
    >>> bool(np.interp(3.3, times, np.sin(50 * times)).round(2) == np.sin(165.0).round(2))
    True
    """
    inside = functions.breaks[(functions.breaks > start) & (functions.breaks < end)]
    inside = inside if 2 * len(inside) < MOST_DRAWN else inside[:0]
    times = np.unique([*np.linspace(start, end, FIRST_DRAWN), *inside, *np.nextafter(inside, start)])
    values = functions.at(times)
    groups = [np.array([unit == other for other in units]) for unit in dict.fromkeys(units)]
    waiting = np.arange(len(times) - 1)
    while len(waiting):
        if len(times) + len(INNER) * len(waiting) > MOST_DRAWN:
            number = np.arange(MOST_DRAWN - 2)
            spread = (number + number * GOLDEN % 1) / MOST_DRAWN
            return np.unique([start, *(start + (end - start) * spread), end])
        left, right = times[waiting], times[waiting + 1]
        inner = (left + np.multiply.outer(INNER, right - left)).T
        new = functions.at(inner.ravel()).reshape(len(values), *inner.shape)
        a, b = values[:, waiting, None], values[:, waiting + 1, None]
        low = np.minimum(values.min(axis=1), new.min(axis=(1, 2)))
        high = np.maximum(values.max(axis=1), new.max(axis=(1, 2)))
        height = np.empty((len(values), 1, 1))
        for rows in groups:
            height[rows] = high[rows].max() - low[rows].min()
        bent = (
            (np.abs(new - a - (b - a) * INNER) > FOLLOWED * height).any(axis=(0, 2)) & (inner[:, 0] > left) & (inner[:, -1] < right)
        )
        places = np.repeat(waiting[bent] + 1, len(INNER))
        first = waiting[bent] + len(INNER) * np.arange(bent.sum())
        times = np.insert(times, places, inner[bent].ravel())
        values = np.insert(values, places, new[:, bent].reshape(len(values), -1), axis=1)
        waiting = (first[:, None] + np.arange(len(INNER) + 1)).ravel()
    return times


def _resolved(
    functions: TimeFunctions, edges: np.ndarray, fineness: float, floor: float, most: float, least: int
) -> list[_Panels] | None:
    """Panels of the functions, refined until the error is below the fineness; None once they must have more than ``most`` numbers.

    A panel has ``least`` numbers or more.
    """
    left, right = edges[:-1], edges[1:]
    done: list[_Panels] = []
    kept, numbers = 0, 0
    while len(left):
        last = kept + 2 * len(left) > MOST_PANELS or (right - left).max() <= SHORTEST * (edges[-1] - edges[0])
        met, failed = _met(functions, left, right, fineness, floor, last)
        done += met
        kept += sum(len(panels.left) for panels in met)
        numbers += sum(panels.codes.size for panels in met)
        if numbers + 2 * len(failed) * least > most:
            return None
        a, b = left[failed], right[failed]
        middle = (a + b) / 2
        left, right = np.column_stack([a, middle]).ravel(), np.column_stack([middle, b]).ravel()
    return done


@dataclass(frozen=True, eq=False)
class _Panels:
    """Panels of one degree: their starts (k,), exponents (r, k) and codes (r, k, degree + 1)."""

    left: np.ndarray
    exponents: np.ndarray
    codes: np.ndarray


def _met(functions, left, right, fineness: float, floor: float, is_last: bool) -> tuple[list[_Panels], np.ndarray]:
    """The panels on which a polynomial meets the functions, and the indices of the others; of the last level all are taken."""
    met, failed = [], []
    for begin in range(0, len(left), AT_ONCE):
        part = np.arange(begin, min(begin + AT_ONCE, len(left)))
        values = None
        for degree in DEGREES:
            if not len(part):
                break
            values = panel_values(functions, left[part], right[part], 2 * degree, values)
            nodes = values[:, :, ::2]
            errors = np.abs(nodes @ between_points(degree).T - values[:, :, 1::2]).max(axis=2)
            exponents = _exponents(np.abs(values).max(axis=2), fineness, floor)
            good = (errors <= np.ldexp(MEETS, exponents)).all(axis=0)
            if is_last and degree == DEGREES[-1]:
                exponents = np.maximum(exponents, np.frexp(errors)[1] + 1)
                good[:] = True
            if good.any():
                codes = _codes(nodes[:, good], exponents[:, good], fineness)
                met.append(_Panels(left[part[good]], exponents[:, good], codes))
            part, values = part[~good], values[:, ~good]
        failed.append(part)
    return met, np.concatenate(failed) if failed else np.arange(0)


def panel_values(functions, left, right, degree: int, known: np.ndarray | None) -> np.ndarray:
    """The functions at the points of panels; those at every second point may be known."""
    shares = (1 - np.cos(np.pi * np.arange(degree + 1) / degree)) / 2
    shares[[0, -1]] = INSIDE, 1 - INSIDE
    new = shares if known is None else shares[1::2]
    times = left[:, None] + (right - left)[:, None] * new
    tiny = 4 * np.spacing(np.abs(right))  # where the panel is so short that this is all there is
    times = np.clip(times, (left + tiny)[:, None], np.maximum(left + tiny, right - tiny)[:, None])
    order = np.argsort(times, axis=None, kind="stable")
    computed = functions.at(times.ravel()[order])
    fresh = np.empty_like(computed)
    fresh[:, order] = computed
    fresh = fresh.reshape(len(computed), *times.shape)
    if known is None:
        return fresh
    values = np.empty((len(fresh), len(left), degree + 1))
    values[:, :, ::2], values[:, :, 1::2] = known, fresh
    return values


def between_points(degree: int) -> np.ndarray:
    """The matrix that takes values at the points of a degree to those at the further points of twice the degree."""
    points = -np.cos(np.pi * np.arange(2 * degree + 1) / (2 * degree))
    return interpolation(degree, points[1::2])


def interpolation(degree: int, points: np.ndarray) -> np.ndarray:
    """Barycentric interpolation between the Chebyshev points of the second kind.

    >>> interpolation(2, np.array([0.5])) @ [1.0, 0.0, 1.0]
    array([0.25])
    """
    nodes = -np.cos(np.pi * np.arange(degree + 1) / degree)
    weights = (-1.0) ** np.arange(degree + 1)
    weights[[0, -1]] /= 2
    distances = np.asarray(points, dtype=float)[:, None] - nodes
    hits = distances == 0
    shares = weights / np.where(hits, 1.0, distances)
    shares = np.where(hits.any(axis=1, keepdims=True), hits, shares)
    return shares / shares.sum(axis=1, keepdims=True)


def _exponents(sizes: np.ndarray, fineness: float, floor: float) -> np.ndarray:
    """Exponents of steps that are powers of two: the largest value divided by the fineness, but no step below the noise."""
    return np.frexp(np.maximum(np.maximum(sizes, np.finfo(float).tiny * fineness) / fineness, floor))[1]


def _codes(values: np.ndarray, exponents: np.ndarray, fineness: float) -> np.ndarray:
    """Values (r, k, n) in steps (r, k)."""
    return np.clip(np.rint(np.ldexp(values, -exponents[:, :, None])), 1 - fineness, fineness - 1).astype("<i4")


def _joined(parts: Sequence[_Panels], end: float) -> Readings:
    """The panels of all degrees in the order of time."""
    lefts = np.concatenate([part.left for part in parts])
    degrees = np.concatenate([np.full(len(part.left), part.codes.shape[2] - 1) for part in parts])
    exponents = np.concatenate([part.exponents for part in parts], axis=1)
    order = np.argsort(lefts, kind="stable")
    place = np.empty(len(order), int)
    place[order] = np.concatenate([[0], np.cumsum(degrees[order] + 1)])[:-1]
    codes = np.empty((len(exponents), int((degrees + 1).sum())), "<i4")
    begin = 0
    for part in parts:
        at = place[begin : begin + len(part.left), None] + np.arange(part.codes.shape[2])
        codes[:, at] = part.codes
        begin += len(part.left)
    return Readings(np.append(lefts[order], end), degrees[order], exponents[:, order], codes)


#: Gaps of a record are even where no sample is further than this share of a gap from its place.
EVEN = 1e-6

#: Samples of a block.
BLOCK = 256

#: Gaps from which the matrices are identified, and how many times more of them than unknowns there are at least.
FITTED, REDUNDANCY = 3_000, 4

#: Singular values below this share of the largest do not count as a direction of the motion; nor do so small equations decide.
NEGLIGIBLE = 1e-12

#: States of a system, and products of two numbers of a gap, of which there are too many to be identified.
MOST_STATES, MOST_PRODUCTS = 400, 700

#: Errors, as shares of the largest value of a function: of the polynomials, and of all in at least half of the blocks.
POLYNOMIAL, SERVES = 2.0**-28, 2.0**-19

#: Where errors are measured, as shares of a gap, and by how much the bounds exceed them.
MEASURED, SAFETY = (0.07, 0.6), 2.0

#: Values that are computed at once.
VALUES_AT_ONCE = 4_000_000


@dataclass(frozen=True, eq=False)
class RecordSteps:
    """A motion from sample to sample."""

    # time of the first sample and time between samples, s
    start: float
    gap: float
    samples: np.ndarray  # samples of the forces, shape (m, K + 1)
    matrix: np.ndarray  # matrix of a step, from coordinates, three samples and 1 to the next coordinates, shape (p, p + 3 m + 1)
    exact: np.ndarray  # the coordinates at the samples, shape (p, K)
    computed: np.ndarray  # the values as the page computes them

    @property
    def count(self) -> int:
        """K, the number of gaps."""
        return self.exact.shape[1]

    @property
    def end(self) -> float:
        """The end of the last gap, s."""
        return self.start + self.count * self.gap

    def features(self, coordinates: np.ndarray, gaps: np.ndarray) -> np.ndarray:
        """Features from which the values in some gaps are computed."""
        return np.vstack([coordinates[:, gaps], self.samples[:, gaps], self.samples[:, gaps + 1], np.ones(len(gaps))])

    def as_data(self) -> dict:
        return {
            "start": self.start,
            "gap": self.gap,
            "count": self.count,
            "block": BLOCK,
            "forces": len(self.samples),
            "samples": packed(self.samples),
            "first": packed(self.exact[:, ::BLOCK].T, "<f8"),
            "matrix": packed(self.matrix, "<f8"),
        }


def record_steps(record: RecordResponse, start: float, end: float) -> RecordSteps | None:
    """The steps of a motion through the longest stretch of even samples."""
    inside = np.flatnonzero((record.knots >= start) & (record.knots <= end))
    knots, force = record.knots[inside], record.force[:, inside]
    first, last = _longest_even(knots)
    count = last - first - 1  # the force may end at the last sample with a jump
    if count <= FEW_BREAKS:
        return None
    gap = (knots[last] - knots[first]) / (last - first)
    places = knots[first] + gap * np.arange(count)
    if np.abs(places - knots[first : first + count]).max() > EVEN * gap:
        return None
    states = record.states(knots[first : first + count])
    coordinates, samples = _coordinates(states), _independent(force[:, first : first + count + 1]).astype("<f4").astype(float)
    if coordinates is None:
        return None
    inputs = np.vstack(
        [coordinates, samples[:, :-1], samples[:, 1:], np.append(samples[:, 2:], samples[:, -1:], 1), np.ones(count)]
    )
    some = _some(count - 2, len(inputs))
    matrix = _fitted(inputs[:, some], coordinates[:, some + 1])
    computed = _computed(matrix, coordinates, inputs[len(coordinates) :])
    return RecordSteps(float(knots[first]), float(gap), samples, matrix, coordinates, computed)


def _longest_even(knots: np.ndarray) -> tuple[int, int]:
    """First and last index of the longest run of knots with one gap."""
    gaps = np.diff(knots)
    if not len(gaps):
        return 0, 0
    uneven = np.flatnonzero(np.abs(gaps - np.median(gaps)) > EVEN * np.median(gaps))
    ends = np.concatenate([[-1], uneven, [len(gaps)]])
    longest = int(np.diff(ends).argmax())
    return int(ends[longest]) + 1, int(ends[longest + 1])


def _coordinates(states: np.ndarray) -> np.ndarray | None:
    """The states by as few coordinates as they need: along the singular vectors of some of them."""
    sizes = np.abs(states).max(axis=1)
    states = states[sizes > 0] / sizes[sizes > 0, None]
    if not 0 < len(states) <= MOST_STATES:
        return None
    directions, values, _ = np.linalg.svd(states[:, _some(states.shape[1], len(states))], full_matrices=False)
    return directions[:, values > NEGLIGIBLE * values[0]].T @ states


def _independent(force: np.ndarray) -> np.ndarray:
    """The independent rows of a force, from whose values at both ends of a gap the others follow, such as slopes of a record."""
    kept = [row for row in range(len(force)) if np.ptp(force[row]) > 0]
    some = _some(force.shape[1] - 1, 2 * len(kept))
    for row in reversed(kept.copy()):
        others = force[[each for each in kept if each != row]]
        ends = np.vstack([others[:, some], others[:, some + 1], np.ones(len(some))])
        own = force[[row]][:, some]
        if np.abs(_fitted(ends, own) @ ends - own).max() <= 1e-9 * np.abs(own).max():
            kept.remove(row)
    return force[kept]


def _some(count: int, unknowns: int) -> np.ndarray:
    """Ascending indices below a count, enough to identify unknowns."""
    number = min(count, max(FITTED, REDUNDANCY * unknowns))
    return np.sort(np.random.default_rng(count).choice(count, number, replace=False))


def _fitted(inputs: np.ndarray, outputs: np.ndarray) -> np.ndarray:
    """The matrix X with X inputs = outputs, by least squares with scaled rows."""
    sizes = np.abs(inputs).max(axis=1, initial=0.0)
    sizes[sizes == 0] = 1.0
    solution = np.linalg.lstsq((inputs / sizes[:, None]).T, outputs.T, rcond=NEGLIGIBLE)[0]
    return solution.T / sizes


def _computed(matrix: np.ndarray, exact: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """The coordinates as the page computes them: all blocks side by side, from their first samples."""
    count = exact.shape[1]
    computed = np.empty_like(exact)
    own, free, forced = exact[:, ::BLOCK], matrix[:, : len(exact)], matrix[:, len(exact) :]
    for place in range(BLOCK):
        at = np.arange(place, count, BLOCK)
        own = own[:, : len(at)]
        computed[:, at] = own
        own = free @ own + forced @ forces[:, at]
    return computed


@dataclass(frozen=True, eq=False)
class RecordReadings:
    """Functions by the steps of a record."""

    steps: RecordSteps  # of the motion
    place: int  # the number of the steps among those of the page
    rows: np.ndarray  # the matrices to the values at the points of the polynomials, shape (degree + 1, r, features)
    quadratic: bool  # whether the features are the products of two
    bounds: np.ndarray  # bounds of the errors, as exponents of two by function and block, shape (r, blocks)
    largest: float  # the largest value of any function

    def as_data(self) -> dict:
        return {
            "steps": self.place,
            "degree": len(self.rows) - 1,
            "quadratic": self.quadratic,
            "rows": packed(self.rows, "<f8"),
            "bounds": packed(self.bounds, "<i2"),
        }


def record_readings(functions: TimeFunctions, steps: RecordSteps, place: int) -> RecordReadings | None:
    """The readings of functions over the stretch of steps."""
    for quadratic in (False, True):
        features = len(steps.features(steps.exact, np.zeros(1, int)))
        unknowns = features * (features + 1) // 2 if quadratic else features
        if quadratic and unknowns > MOST_PRODUCTS:
            return None
        some = _some(steps.count, unknowns)
        nodes = _nodes(functions, steps, some)
        if nodes is None:
            return None
        largest = np.abs(nodes).max(axis=(1, 2), initial=0.0)
        inputs = _products(steps.features(steps.exact, some), quadratic)
        rows = _fitted(inputs, nodes.transpose(2, 0, 1).reshape(-1, len(some)))
        residuals = np.abs(rows @ inputs - nodes.transpose(2, 0, 1).reshape(-1, len(some))).max(axis=1)
        rows = rows.reshape(nodes.shape[2], len(nodes), -1)
        floor = functions.noise * largest.max()
        if (residuals.reshape(rows.shape[:2]) <= SERVES * largest + floor).all():
            errors = np.hstack(list(_errors(functions, steps, rows, quadratic)))
            bounds = np.frexp(np.maximum(SAFETY * errors, max(floor, np.finfo(float).tiny)))[1]
            serves = np.median(np.ldexp(1.0, bounds), axis=1) <= SERVES * largest + 4 * floor
            return RecordReadings(steps, place, rows, quadratic, bounds, float(largest.max())) if serves.all() else None
    return None


def _nodes(functions: TimeFunctions, steps: RecordSteps, some: np.ndarray) -> np.ndarray | None:
    """The values at the points of the lowest degree that serves, shape (r, gaps, degree + 1)."""
    left, values = steps.start + steps.gap * some, None
    for degree in DEGREES:
        values = panel_values(functions, left, left + steps.gap, 2 * degree, values)
        errors = np.abs(values[:, :, ::2] @ between_points(degree).T - values[:, :, 1::2]).max(axis=(1, 2))
        largest = np.abs(values).max(axis=(1, 2))
        if (errors <= POLYNOMIAL * largest + functions.noise * largest.max()).all():
            return values[:, :, ::2]
    return None


def _products(features: np.ndarray, quadratic: bool) -> np.ndarray:
    if not quadratic:
        return features
    first, second = np.triu_indices(len(features))
    return features[first] * features[second]


def _errors(functions: TimeFunctions, steps: RecordSteps, rows: np.ndarray, quadratic: bool) -> Iterator[np.ndarray]:
    """The largest error in each block, some of them at once, shape (r, blocks)."""
    degree, count = len(rows) - 1, rows.shape[1]
    shares = interpolation(degree, 2 * np.array(MEASURED) - 1)
    matrices = np.tensordot(shares, rows, axes=1)
    together = BLOCK * max(1, VALUES_AT_ONCE // (BLOCK * max(count, rows.shape[2])))
    for begin in range(0, steps.count, together):
        gaps = np.arange(begin, min(begin + together, steps.count))
        times = steps.start + steps.gap * (gaps[:, None] + np.array(MEASURED))
        exact = functions.at(times.ravel()).reshape(count, len(gaps), len(MEASURED))
        read = matrices @ _products(steps.features(steps.computed, gaps), quadratic)
        errors = np.abs(exact - read.transpose(1, 2, 0)).max(axis=2)
        yield np.maximum.reduceat(errors, np.arange(0, len(gaps), BLOCK), axis=1)
