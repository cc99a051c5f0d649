"""The answer to a large plain problem from its reduced equations (``polynomial.reduction``), for a start that fits them.

Coordinates that have mass keep their values at 0- and coordinates that only dampers hold theirs; what is held to others
by an algebraic equation has to obey it at 0-, with its velocity, where mass or damping goes with it. All others take at 0+ the
values that the equations give them: they jump there without impulses, as they do where the force jumps later.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse
from scipy.sparse import csr_array

from ..jordan.evidence import Evidence
from ..jordan.pairs import JordanPairs
from ..linalg.precise import MOST_STATES, is_worthwhile
from ..notices import Notice
from ..polynomial.matrix import PolynomialMatrix
from ..polynomial.reduction import Reduction
from ..signals.impulsive import ImpulsiveSmooth
from ..tolerances import noise_of, rounding_radius
from .cost import LEAST_STATES, Way, way_of
from .events import Event
from .flow import Flow, FlowFunction


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
    def structure_is_clear(self) -> bool:
        """The structure is read off exact zeros, and nothing that was divided by is near singular."""
        return True

    @property
    def is_precise(self) -> bool:
        """It is computed in float64."""
        return False

    @property
    def written(self) -> None:
        """No entry counted as zero."""
        return None

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """The condition of the parts that were divided by."""
        reduction = self.function.flow.reduction
        text = "largest condition of the masses, dampers and algebraic equations that were divided by, brought to one size"
        return (Evidence("condition", reduction.largest_condition, text),)

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Growing motions."""
        reduction = self.function.flow.reduction
        if reduction.is_dissipative:
            return ()
        zeros = np.concatenate([np.linalg.eigvals(block) for block in reduction.decoupled.blocks])
        zeros = zeros[zeros.imag >= 0]
        noise = np.maximum(rounding_radius(1) * np.abs(zeros), noise_of(np.abs(zeros).max(initial=0.0)))
        growing = zeros.real[zeros.real > noise]
        text = f"{len(growing)} zero(s) in the right half plane: the motion grows, fastest like e^({max(growing, default=0):.6g} t)"
        return (Notice("unstable", text),) if len(growing) else ()


def reduced_solution(A: PolynomialMatrix, initial: np.ndarray, force: ImpulsiveSmooth) -> ReducedSolution | None:
    """The solution of A(d/dt) x = f from values at 0-, None where A(s) or its start is not plain.

    Args:
        A: the polynomial matrix, degree q <= 2.
        initial: x^(i)(0-) as row i, shape (q, r).
        force: f with r rows.
    """
    reduction = reduction_for(A, force)
    if reduction is None or not fitting(reduction, initial[..., None], force)[0]:
        return None
    flow, output = flow_of(reduction, initial, force)
    at_zero = derivatives_of(flow, output, flow.start_with_force[:, None], initial[..., None])
    events = _events(flow, output, len(initial)) if len(force.knots) > 1 else ()
    return ReducedSolution(A, FlowFunction(flow, output), at_zero[..., 0], events)


def reduction_for(A: PolynomialMatrix, force: ImpulsiveSmooth) -> Reduction | None:
    """The reduction of A(s), None where it does not serve for a force."""
    reduction = A.reduction
    if reduction is None or force.impulses or force.later or not reduction.is_finite or _is_stiff(reduction):
        return None
    return reduction


def flow_of(reduction: Reduction, initial: np.ndarray, force: ImpulsiveSmooth) -> tuple[Flow, csr_array]:
    """The states with their start and the output that makes x of them."""
    smooth, start = force.smooth, reduction.state(initial)
    if not smooth.blocks:
        return Flow(reduction, force, start, csr_array((len(start), 0))), reduction.output
    J, columns = csr_array(smooth.generator), csr_array(smooth.coefficients)
    held, right = columns[reduction.algebraic], columns[np.concatenate([reduction.second, reduction.first])]
    output = scipy.sparse.hstack([reduction.output, reduction.Y @ held], format="csr")
    if held.nnz:
        for matrix in reduction.through:
            right, held = right - matrix @ held, held @ J
    accelerations, rates = reduction.solved(right)
    drive = scipy.sparse.vstack([csr_array(accelerations.shape), accelerations, rates], format="csr")
    return Flow(reduction, force, start, drive), output


def _events(flow: Flow, output: csr_array, orders: int) -> tuple[Event, ...]:
    """Jumps of x and x' where the force jumps after t = 0."""
    knots = flow.force.knots
    found = _later_jumps(flow, output, flow.force.smooth.with_knots(knots).restarts.jumps[:, 1:], orders)
    happens = np.flatnonzero(found.any(axis=(0, 1)))
    return tuple(Event(float(knots[1 + k]), found[:, :, k].copy(), ()) for k in happens)


def derivatives_of(flow: Flow, output: csr_array, states: np.ndarray, less: np.ndarray) -> np.ndarray:
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


def _later_jumps(flow: Flow, output: csr_array, changes: np.ndarray, orders: int) -> np.ndarray:
    """The jumps of x^(i), i < orders, where the states of the force jump by changes (m, K), shape (orders, r, K)."""
    found = np.zeros((orders, output.shape[0], changes.shape[1]))
    n, S = len(flow.start), flow.generator
    matrix, bound = output, abs(output)
    for jumps in found:
        through, size = matrix[:, n:].toarray(), bound[:, n:].toarray()
        rows = np.flatnonzero(through.any(axis=1))
        values = through[rows] @ changes
        jumps[rows] = np.where(np.abs(values) <= noise_of(size[rows] @ np.abs(changes)), 0.0, values)
        matrix, bound = matrix @ S, bound @ abs(S)
    return found


def fitting(reduction: Reduction, initial: np.ndarray, force: ImpulsiveSmooth) -> np.ndarray:
    """Whether what algebraic equations hold obeys them at 0-, with its velocity, and is not made to jump later.

    Args:
        initial: S starts at once, shape (q, r, S).

    Returns:
        Shape (S,).
    """
    smooth, held = force.smooth, reduction.algebraic[reduction.held]
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
    states = max(A.degree, 1) * A.size
    found = reduced_solution(A, initial, force) if states >= LEAST_STATES else None
    flow = found and found.function.flow
    return way_of(flow and flow.reduction, states, len(times), flow and flow.turned(times))
