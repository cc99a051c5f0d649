"""The answer to a plain problem from its reduced equations (``polynomial.reduction``), for a start that fits them.

Coordinates that have mass keep their values at 0- and coordinates that only dampers hold theirs; what is held to others
by an algebraic equation has to obey it at 0-, with its velocity, where mass or damping goes with it. All others take at 0+ the
values that the equations give them: they jump there without impulses, as they do where the force jumps later.
What a small model says of itself is read off its Jordan pairs, found when it is asked; of a large one they would take minutes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..jordan.evidence import Evidence
from ..jordan.pairs import JordanPairs
from ..linalg.kinds import Matrix, alike, below, beside, entry_count, full, nothing
from ..linalg.precise import MOST_STATES, is_worthwhile
from ..notices import Notice
from ..polynomial.matrix import PolynomialMatrix
from ..polynomial.reduction import Reduction
from ..signals.impulsive import ImpulsiveSmooth
from ..tolerances import noise_of, rounding_radius
from .cancellation import cancels
from .cost import LEAST_STATES, Way, way_of
from .events import Event
from .flow import Flow, FlowFunction
from .records import cost_of_knots
from .solution import PairSolution


@dataclass(frozen=True)
class ReducedSolution:
    """x of a plain problem.

    Attributes:
        polynomial_matrix: A(s).
        function: the regular part.
        jump: x^(i)(0+) - x^(i)(0-), shape (q, r).
        events: jumps after t = 0.
    """

    polynomial_matrix: PolynomialMatrix
    function: FlowFunction
    jump: np.ndarray
    events: tuple[Event, ...]

    @property
    def impulses(self) -> tuple[np.ndarray, ...]:
        """There are none."""
        return ()

    @property
    def coupling(self) -> float:
        """The largest entry of the transformation that separates the modes."""
        return self.function.flow.coupling

    @cached_property
    def pairs(self) -> JordanPairs:
        """The Jordan pairs of A(s); the answer does not need them."""
        return self.polynomial_matrix.jordan_pairs()

    @property
    def rank_tolerance(self) -> None:
        """None was asked for."""
        return None

    @property
    def is_small(self) -> bool:
        """Whether the Jordan pairs take milliseconds."""
        return is_small(self.polynomial_matrix)

    @property
    def structure_is_clear(self) -> bool:
        """Whether no rank decision is doubtful; a large structure is read off exact zeros, and nothing divided by is near singular."""
        return not self.is_small or self._as_pairs.structure_is_clear

    @property
    def is_precise(self) -> bool:
        """It is computed in float64."""
        return False

    @property
    def written(self) -> JordanPairs | None:
        """The pairs of the data as they are written, where some of them counted as zero at s = 0."""
        return self.pairs.as_written if self.is_small else None

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """The condition of the parts that were divided by, and what the pairs of a small model tell."""
        reduction = self.function.flow.reduction
        text = "largest condition of the masses, dampers and algebraic equations that were divided by, brought to one size"
        more = self.pairs.evidence if self.is_small else ()
        return more or (Evidence("condition", reduction.largest_condition, text),)

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Growing motions; of a small model what the pairs tell."""
        if self.is_small:
            return self._as_pairs.notices
        reduction = self.function.flow.reduction
        if reduction.is_dissipative:
            return ()
        zeros = reduction.zeros
        zeros = zeros[zeros.imag >= 0]
        noise = np.maximum(rounding_radius(1) * np.abs(zeros), noise_of(np.abs(zeros).max(initial=0.0)))
        growing = zeros.real[zeros.real > noise]
        text = f"{len(growing)} zero(s) in the right half plane: the motion grows, fastest like e^({max(growing, default=0):.6g} t)"
        return (Notice("unstable", text),) if len(growing) else ()

    @property
    def _as_pairs(self) -> PairSolution:
        return PairSolution(self.pairs, self.function, self.coupling)


def is_small(A: PolynomialMatrix) -> bool:
    """Whether the Jordan pairs of A(s) take milliseconds."""
    return max(A.degree, 1) * A.size < LEAST_STATES


def reduced_solution(A: PolynomialMatrix, initial: np.ndarray, force: ImpulsiveSmooth) -> ReducedSolution | None:
    """The solution of A(d/dt) x = f from values at 0-, None where A(s) or its start is not plain.

    Args:
        A: the polynomial matrix, degree q <= 2.
        initial: x^(i)(0-) as row i, shape (q, r).
        force: f with r rows.
    """
    reduction = reduction_for(A, force)
    try:
        with np.errstate(over="raise", invalid="raise"):
            if reduction is None or not fitting(reduction, initial[..., None], force)[0]:
                return None
            flow, output = flow_of(reduction, initial, force)
            if reduction.is_small and cancels(flow):
                return None
            jump = _jump(flow, output, initial)
            events = _events(flow, output, len(initial)) if len(force.knots) > 1 else ()
    except FloatingPointError:  # out of the range of float64 on the way: the general route has units of its own
        return None
    return ReducedSolution(A, FlowFunction(flow, output), jump, events)


def reduction_for(A: PolynomialMatrix, force: ImpulsiveSmooth) -> Reduction | None:
    """The reduction of A(s), None where it does not serve for a force."""
    reduction = A.reduction
    if reduction is None or force.impulses or force.later or not reduction.is_finite or _is_stiff(reduction):
        return None
    if not reduction.is_small:
        return reduction
    starts_anew = len(force.knots) > 1  # then sums of modes from knot to knot may cancel at any of them
    return reduction if not starts_anew and reduction.is_apart and not reduction.is_driven_apart else None


def flow_of(reduction: Reduction, initial: np.ndarray, force: ImpulsiveSmooth) -> tuple[Flow, Matrix]:
    """The states with their start and the output that makes x of them."""
    smooth, start = force.smooth, reduction.state(initial)
    if not smooth.blocks:
        return Flow(reduction, force, start, nothing((len(start), 0), reduction.K)), reduction.output
    J, columns = (alike(matrix, reduction.K) for matrix in (smooth.generator, smooth.coefficients))
    held, right = columns[reduction.algebraic], columns[np.concatenate([reduction.second, reduction.first])]
    output = beside(reduction.output, reduction.Y @ held)
    if entry_count(held):
        for matrix in reduction.through:
            right, held = right - matrix @ held, held @ J
    accelerations, rates = reduction.solved(right)
    drive = below(nothing(accelerations.shape, reduction.K), accelerations, rates)
    return Flow(reduction, force, start, drive), output


def _jump(flow: Flow, output: Matrix, initial: np.ndarray) -> np.ndarray:
    """x^(i)(0+) - x^(i)(0-), shape (q, r)."""
    if len(flow.reduction.second) == initial.shape[1]:  # all values are states, which are kept
        return np.zeros(initial.shape)
    return derivatives_of(flow, output, flow.start_with_force[:, None], initial[..., None])[..., 0]


def _events(flow: Flow, output: Matrix, orders: int) -> tuple[Event, ...]:
    """Jumps of x and x' where the force jumps after t = 0."""
    knots, found = flow.force.knots, _later_jumps(flow, output, orders)
    happens = np.flatnonzero(np.any([values.any(axis=0) for _, values in found], axis=0))
    jumps = np.zeros((orders, output.shape[0], len(happens)))
    for jump, (rows, values) in zip(jumps, found):
        jump[rows] = values[:, happens]
    return tuple(Event(float(knots[1 + k]), jumps[:, :, place].copy(), ()) for place, k in enumerate(happens))


def derivatives_of(flow: Flow, output: Matrix, states: np.ndarray, less: np.ndarray) -> np.ndarray:
    """x^(i) of states (n, K) less what is given, shape (q, r, K); zero where the difference is rounding."""
    found, sizes, S, reduction = [], np.abs(states), flow.generator, flow.reduction
    Y, rows = reduction.Y, reduction.given[0][reduction.algebraic]
    for order, given in enumerate(less):
        if order:
            states, sizes = S @ states, abs(S) @ sizes
        difference, size = output @ states - given, np.abs(given)
        size = abs(output) @ sizes + size + abs(Y) @ (abs(rows) @ size)  # the last: how far a start may be off that fits
        found.append(np.where(np.abs(difference) <= noise_of(size, len(size)), 0.0, difference))
    return np.array(found).reshape(less.shape)


def _later_jumps(flow: Flow, output: Matrix, orders: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """For each of x, x', ... the rows that jump where the states of the force do, and by how much, shape (rows, K)."""
    changes, n, S = flow.force.smooth.restarts.jumps[:, 1:], len(flow.start), flow.generator
    found, matrix, bound = [], output, abs(output)
    for order in range(orders):
        if order:
            matrix, bound = matrix @ S, bound @ abs(S)
        through, size = full(matrix[:, n:]), full(bound[:, n:])
        rows = np.flatnonzero(through.any(axis=1))
        values = through[rows] @ changes
        found.append((rows, np.where(np.abs(values) <= noise_of(size[rows] @ np.abs(changes)), 0.0, values)))
    return found


def fitting(reduction: Reduction, initial: np.ndarray, force: ImpulsiveSmooth) -> np.ndarray:
    """Whether what algebraic equations hold obeys them at 0-, with its velocity, and is not made to jump later.

    Args:
        initial: S starts at once, shape (q, r, S).

    Returns:
        Shape (S,).
    """
    held = reduction.algebraic
    if not (len(held) and len(held := held[reduction.held])):
        return np.ones(initial.shape[2], dtype=bool)
    smooth = force.smooth
    rows, columns = reduction.given[0][held], smooth.coefficients[held]
    start, jumps, found = smooth.start_at_zero[:, None], smooth.restarts.jumps[:, 1:], np.ones(initial.shape[2], dtype=bool)
    for values in initial:
        noise = noise_of(abs(rows) @ np.abs(values) + np.abs(columns) @ np.abs(start), len(values))
        found &= (np.abs(rows @ values - columns @ start) <= noise).all(axis=0) & (not (columns @ jumps).any())
        columns = columns @ smooth.generator
    return found


def _is_stiff(reduction: Reduction) -> bool:
    """Whether precise arithmetic would be worth its time, by the slowest and the fastest motion."""
    n = reduction.state_count
    return n <= MOST_STATES and is_worthwhile(reduction.spread, n)


def way_to_evaluate(A: PolynomialMatrix, initial: np.ndarray, force: ImpulsiveSmooth, times: np.ndarray) -> Way:
    """How the answer of ``solve`` finds its values at these times, asked for the first time."""
    found = reduced_solution(A, initial, force)
    flow = found and found.function.flow
    steps = flow and cost_of_knots(flow, found.function.output, times)
    return way_of(flow and flow.reduction, len(times), flow and flow.turned(times), steps)
