"""Functions of a motion under a long record as stored in a page: by the samples of the record and the propagation between them.

Between two samples a function is a polynomial whose values at the Chebyshev points are linear, those of energies quadratic, in the
state at the first of them and in both samples; so is the state at the second one, linear. With even gaps the matrices are the same
for all. They are identified by least squares from values of the solver. The page has them, the samples, and the state at the
first sample of each block, from which its script computes the others. What that costs in accuracy is measured between all
samples; what does not serve is stored by panels (``readings.py``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..animation.keyframes import packed
from ..content import RecordResponse, TimeFunctions
from .readings import DEGREES, FEW_BREAKS, between_points, interpolation, panel_values

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
    """A motion from sample to sample.

    Attributes:
        start, gap: time of the first sample and time between samples, s.
        samples: samples of the forces, shape (m, K + 1).
        matrix: matrix of a step, from coordinates, three samples and 1 to the next coordinates, shape (p, p + 3 m + 1).
        exact: the coordinates at the samples, shape (p, K).
        computed: the values as the page computes them.
    """

    start: float
    gap: float
    samples: np.ndarray
    matrix: np.ndarray
    exact: np.ndarray
    computed: np.ndarray

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
    """Functions by the steps of a record.

    Attributes:
        steps: of the motion.
        place: the number of the steps among those of the page.
        rows: the matrices to the values at the points of the polynomials, shape (degree + 1, r, features).
        quadratic: whether the features are the products of two.
        bounds: bounds of the errors, as exponents of two by function and block, shape (r, blocks).
        largest: the largest value of any function.
    """

    steps: RecordSteps
    place: int
    rows: np.ndarray
    quadratic: bool
    bounds: np.ndarray
    largest: float

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
