"""IDA of SUNDIALS, by scikit-sundae: variable-order BDF on the original equations, with multipliers and singular masses.

The unknowns are the coordinates, with rows of constraints their multipliers too, and of each as many derivatives as occur
in the equations, less one: nothing is reduced by hand. Rows of constraints stand in the equations twice differentiated
(index 1), once (index 2) or as they are (index 3). Without rows there is one form, E y' + F y = g, E possibly singular.

What the method is given: the Jacobian; values and derivatives at 0+ that fit, taken from the closed form, and by how much
they jump where the force starts, stops, changes or has an impulse, where it restarts; absolute tolerances of rtol times the size
of each kind of unknown, as errors are measured. With index 2 multipliers and whatever else has no derivative in the equations
are kept out of the error test, with index 3 velocities too, as the manual of IDA advises for an index above 1 (scikit-sundae
does not offer IDASetSuppressAlg: their tolerance is made large instead; with the usual one the four-bar linkage, the delta
robot and the quadruped of the examples fail from rtol 1e-8 or 1e-10 on with index 2, and from 1e-6 on with index 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from importlib.util import find_spec

import numpy as np

from ...mechanics.constraints import LEVELS
from ...mechanics.exact_motion import with_multipliers
from ...mechanics.motion import reaction_function
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...signals.bohl import BohlFunction
from ...signals.impulsive import ImpulsiveSmooth
from ..study_problem import StudyProblem
from .first_order import reduced, sizes_of
from .force_intervals import Interval, intervals, jumps_of
from .method import ComparedMethod, Evaluate, Failure, tolerances

#: Most steps from one time to the next: more than the time limit of a run allows.
MOST_STEPS = 10**7

#: Absolute tolerance of an unknown that is excluded from the error test, relative to its size.
UNTESTED = 1e10

#: Most unknowns for SUNDIALS' own dense factorization; LAPACK is faster for larger ones.
MOST_SMALL = 100


@dataclass(frozen=True, eq=False)
class Descriptor:
    """E y' + F y = g, the first-order form of A_0 u + A_1 u' + ... = force.

    Attributes:
        E, F: shapes (N, N).
        force: g, N rows.
        places: unknown and order of derivative of each y, up to the order before the highest that occurs.
        function: the unknowns u, coordinates first, in closed form.
        index: differentiation index of the equations.
        count: number of unknowns that are coordinates.
        times: times of the problem, in s.
    """

    E: np.ndarray
    F: np.ndarray
    force: ImpulsiveSmooth
    places: tuple[tuple[int, int], ...]
    function: BohlFunction
    index: int
    count: int
    times: np.ndarray

    @property
    def algebraic(self) -> np.ndarray:
        """Which y have no derivative in the equations."""
        return ~self.E.any(axis=0)

    @property
    def tested(self) -> np.ndarray:
        """Which y are in the error test, as the coordinates always are."""
        requested = np.array([unknown < self.count and not order for unknown, order in self.places])
        excluded = self.algebraic & (self.index > 1) | np.array([order > 0 and self.index > 2 for _, order in self.places])
        return requested | ~excluded

    @cached_property
    def motion(self) -> tuple[BohlFunction, BohlFunction]:
        """y and y' in closed form."""
        derivatives = [self.function.derivative(order) for order in range(2 + max(order for _, order in self.places))]
        rows = (np.array([derivatives[order + more].coefficients[unknown] for unknown, order in self.places]) for more in (0, 1))
        y, rate = (BohlFunction(each, self.function.blocks, self.function.start) for each in rows)
        return y, rate

    @cached_property
    def sizes(self) -> np.ndarray:
        """Sizes of the unknowns as in ``Reduced.sizes``: common to all coordinates, all derivatives, all multipliers."""
        kinds = [(unknown < self.count, order) for unknown, order in self.places]
        values, different = self.motion[0](self.times), sorted(set(kinds))
        sizes = sizes_of([values[[kind == other for other in kinds]] for kind in different], self.times)
        return np.array([sizes[different.index(kind)] for kind in kinds])

    @cached_property
    def intervals(self) -> tuple[Interval, ...]:
        """Intervals of time with the formulas of g."""
        return intervals(self.force, self.times, np.eye(len(self.places)))


@lru_cache(maxsize=8)
def descriptor(problem: StudyProblem, index: int) -> Descriptor:
    """The equations of a problem for IDA, excluded from run times."""
    response, force = reduced(problem).response, problem.force
    coefficients, function = np.array(problem.polynomial_matrix.coefficients), response.function
    if index:
        system, order = problem.system, 3 - index
        n, k = system.size, len(system.rows)
        matrices = (system.stiffness, system.damping, system.mass)
        coefficients = np.array(with_multipliers(matrices, system.constraint_matrix, [order] * k))
        applied = system.force if problem.applied is None else system.force + problem.applied
        force = applied.mapped(np.eye(n + k, n))
        for place, row in enumerate(system.rows):
            force = force + ImpulsiveSmooth(row.right_side(order).mapped(np.eye(n + k, 1, -n - place)))
        multipliers = reaction_function(system, response, applied)
        function = function.mapped(np.eye(n + k, n)) + multipliers.mapped(np.eye(n + k, k, -n))
    size = len(coefficients[0])
    highest = [max(np.flatnonzero(coefficients[:, :, k].any(axis=1)), default=0) for k in range(size)]
    places = tuple((k, order) for order in range(len(coefficients)) for k in range(size) if order < max(highest[k], 1))
    at = {place: number for number, place in enumerate(places)}
    E, F = np.zeros((2, len(places), len(places)))
    for k in range(size):
        for order in range(highest[k] + 1):
            inside = (k, order) in at
            (F if inside else E)[:size, at[k, order] if inside else at[k, order - 1]] += coefficients[order][:, k]
    steps = [(at[k, order], at[k, order + 1]) for k, order in places if (k, order + 1) in at]
    for row, (lower, upper) in enumerate(steps, start=size):
        E[row, lower], F[row, upper] = 1.0, -1.0
    index = index or max(PolynomialMatrix([F, E]).structure().infinite_divisors, default=0)
    count = problem.system.size if problem.system is not None and problem.system.rows else size
    return Descriptor(E, F, force.mapped(np.eye(len(places), size)), places, function, index, count, problem.times)


def _prepare(index: int, problem: StudyProblem, rtol: float) -> Evaluate:
    """Set up the solver with its options."""
    form = descriptor(problem, index)
    jumps = [jumps_of(function) for function in form.motion]
    start, parts = [function(0.0) for function in form.motion], form.intervals
    coordinates = [form.places.index((unknown, 0)) for unknown in range(form.count)]
    solver = _Solver(form, rtol, rtol * form.sizes * np.where(form.tested, 1.0, UNTESTED))

    def evaluate() -> np.ndarray:
        values, blocks = start, []
        for interval in parts:
            if interval.begin > 0:
                values = [value + jump.get(interval.begin, 0.0) for value, jump in zip(values, jumps)]
            states, values = solver.on(interval, values)
            blocks.append(states[:, coordinates].T)
        return np.hstack(blocks)

    return evaluate


class _Solver:
    """IDA for one descriptor form, reused on every interval."""

    def __init__(self, form: Descriptor, rtol: float, atol: np.ndarray):
        from sksundae.ida import IDA

        self.force = None
        both = np.hstack([form.F, form.E])

        def residual(t, y, yp, res):
            res[:] = both @ np.concatenate((y, yp)) - self.force(t)

        def jacobian(t, y, yp, res, cj, J):
            J[:] = form.F + cj * form.E

        self.ida = IDA(
            residual,
            jacfn=jacobian,
            rtol=rtol,
            atol=atol,
            algebraic_idx=np.flatnonzero(form.algebraic).tolist() or None,
            max_num_steps=MOST_STEPS,
            linsolver="dense" if len(form.E) <= MOST_SMALL else "lapackdense",
        )

    def on(self, interval: Interval, values: Sequence[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray]]:
        """y at the times of an interval, shape (T, N), and y, y' at its end."""
        if interval.end == interval.begin:
            return np.repeat(values[0][None, :], len(interval.times), axis=0), values
        self.force = interval.force
        stops = np.union1d(interval.begin, interval.stops)
        # the solver reads two times as a request for its own steps: add the middle
        output_times = stops if len(stops) > 2 else np.insert(stops, 1, stops.mean())
        answer = self.ida.solve(output_times, *values)
        if not answer.success:
            raise Failure(answer.message)
        inside = np.searchsorted(output_times, interval.times)
        return answer.y[inside], [answer.y[-1], answer.yp[-1]]


def _has_rows(problem: StudyProblem) -> bool:
    return problem.system is not None and bool(problem.system.rows)


def _refusal(index: int, problem: StudyProblem) -> str:
    weaker = [row for row in problem.system.rows if row.order > 3 - index] if index else []
    if weaker:
        row, level = weaker[0], LEVELS[3 - index]
        return f"needs rows at {level} level; {row.name} is at {row.level} level, which does not determine its {level}"
    return "" if find_spec("sksundae") else "scikit-sundae is not installed"


METHODS = tuple(
    ComparedMethod(
        f"IDA, index {index}" if index else "IDA",
        partial(_prepare, index),
        tolerances(4, 6, 8, 10, 12),
        partial(_refusal, index),
        concerns=_has_rows if index else lambda problem: not _has_rows(problem),
        library="sksundae.ida",
    )
    for index in (1, 2, 3, 0)
)
