"""The method by which a problem is solved and evaluated: a pure function of the problem and the request.

Two questions are answered here, both from the data alone.

1. The reduced equations w' = S w + ... (``polynomial.direct_reduction``) or the Jordan pairs of A(s)? The reduced equations are much
   cheaper; the pairs serve every problem. The first condition that the reduced equations do not meet is the reason.
2. Values of the reduced equations by their modes, by powers of e^(S h), or by steps from knot to knot of a record? Where few states
   are decoupled at once, or many evaluations share the modes, by these; otherwise by what costs less for the given times, counted
   in products of two matrices of the size of the states. An evaluation at other times is chosen for by the same rule.

Measured with OpenBLAS on machines of one to two cores: LAPACK's QR algorithm (geev) takes the time of 40 products for 2000 states
and of 100 for 200, a symmetric eigenproblem of half the size that of 2 and of 7; powers of e^(S h) are counted
(``linalg.recursion``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from ..ground.checks import counted
from ..ground.errors import InputError
from ..ground.tolerances import EPS, PROVED_RESTARTS, PROVED_STATES, noise_of
from ..linalg.arrays import entry_count
from ..linalg.exponential import even_step
from ..linalg.precise import is_worthwhile
from ..linalg.recursion import cost_of_exponential, cost_of_powers, cost_of_series, cost_of_steps, shared_gaps
from ..polynomial.direct_reduction import reduction_of
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..polynomial.reduced_equations import NotReducible, Reduction
from ..signals.impulsive import ImpulsiveSmooth
from .flow import FEWEST_KNOTS, Flow
from .methods.defect import Rounding
from .methods.refined import RefinedDefect
from .problem import Problem

Evaluations = Literal["once", "many"]

#: The names of the methods.
PAIRS, MODES, POWERS, STEPS, DELAYS = "Jordan pairs", "modes", "matrix powers", "record steps", "method of steps"

#: Cost of eigenvectors in products of matrices: for very many states, and more for few.
GENERAL, GENERAL_SMALL = 40.0, 12000.0
SYMMETRIC, SYMMETRIC_SMALL = 1.5, 1000.0

#: Cost of the modes of a sparse topology (``linalg.tree_modes``), by fronts of w coordinates, in (3 + 2 w) / 5 times the number of
#: states to the power of 1.5.
TOPOLOGY = 1.6e5

#: Fewer times than these are not worth the powers of e^(S h).
FEWEST_TIMES = 32


@dataclass(frozen=True, eq=False)
class Request:
    """Requested evaluation of a solution.

    Attributes:
        evaluations: "once", each evaluation by the cheapest method for its times; "many", all of them by the modes.
        times: times of the first evaluation in s, where they are known; shape (T,).
    """

    evaluations: Evaluations = "once"
    times: np.ndarray | None = None

    def __post_init__(self):
        if self.evaluations not in ("once", "many"):
            raise InputError(f'evaluations: found {self.evaluations!r}; expected "once" or "many"')


@dataclass(frozen=True, eq=False)
class Method:
    """Method by which a problem is solved.

    Attributes:
        name: PAIRS, MODES, POWERS, STEPS or DELAYS.
        because: one phrase with the deciding condition, or a function that formats it.
        flow: the reduced equations with start and force; None with the Jordan pairs.
        evaluations: as requested.
    """

    name: str
    because: str | Callable[[], str]
    flow: Flow | None = None
    evaluations: Evaluations = "once"

    @cached_property
    def reason(self) -> str:
        """One phrase with the deciding condition."""
        return self.because if isinstance(self.because, str) else self.because()

    def __getstate__(self) -> dict:
        return {**vars(self), "because": self.reason}  # a text goes to other processes, a local function does not

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.name}, {self.reason})"


def choose(problem: Problem, request: Request = Request()) -> Method:
    """The method for a problem."""
    if problem.delayed:
        return Method(DELAYS, "by the Jordan pairs, from delay to delay", evaluations=request.evaluations)
    try:
        flow = reduced_flow(problem)
    except NotReducible as condition:
        return Method(PAIRS, f"by the Jordan pairs: {condition}", evaluations=request.evaluations)
    return Method(*evaluation_method(flow, flow.output.shape, request), flow, request.evaluations)


def unproved(problem: Problem) -> str:
    """The reason why the exact engine does not prove the values (``response.methods.proved``); empty where it does."""
    A = problem.polynomial_matrix
    states, restarts = A.degree * A.size, len(problem.force.knots) - 1
    if problem.delayed:
        return "there are delays"
    if not states:
        return "there are no states"
    if states > PROVED_STATES:
        return f"{states} states are more than {PROVED_STATES}"
    if restarts > PROVED_RESTARTS:
        return f"the force restarts at {counted(restarts, 'time')}"
    if problem.rank_tolerance is not None or A.is_uncertain:
        return "the data are uncertain, and are no exact numbers"
    return ""


# Reduced equations or Jordan pairs


def reduced_flow(problem: Problem) -> Flow:
    """The reduced equations with start and force."""
    initial, force = problem.initial, problem.force
    proved = not unproved(problem)  # no values are used then that are not right
    A = problem.polynomial_matrix
    reduction = serving_reduction(A, force, problem.rank_tolerance, proved=proved, refining=True)
    refining = proved and (reduction.by_elements is not None or _is_stiff(reduction))
    try:
        with np.errstate(over="raise", invalid="raise"):
            jumping = not satisfying(reduction, initial[..., None], force)[0]
            if jumping and (reduction.is_small or makes_constrained_jump(reduction, force)):
                raise NotReducible("the initial values or a jump of the force do not satisfy the algebraic equations")
            flow = Flow.of(reduction, initial, force, jumping=jumping)
            flow.jump, flow.events  # computed here, where overflow is still another method's to avoid
        if refining:
            modes = RefinedDefect(flow, Rounding.of_elements(A.coefficients, A.factors))
            if modes.refined is None or not modes.refined.residual <= EPS:
                raise NotReducible(_spread(reduction))
            flow.computed["residual"] = modes.refined.residual
            flow = replace(flow, refined=modes.states)
    except FloatingPointError:
        raise NotReducible("the reduced equations leave the range of float64") from None
    return flow


def reducible(A: PolynomialMatrix, initial: np.ndarray, force: ImpulsiveSmooth, rank_tolerance: float | None) -> np.ndarray:
    """Which of S starts the reduced equations serve."""
    proved = not unproved(Problem(A, initial[0], force, rank_tolerance))
    try:
        with np.errstate(over="raise", invalid="raise"):
            return satisfying(serving_reduction(A, force, rank_tolerance, proved=proved), initial.transpose(1, 2, 0), force)
    except (NotReducible, FloatingPointError):
        return np.zeros(len(initial), dtype=bool)


def serving_reduction(
    A: PolynomialMatrix,
    force: ImpulsiveSmooth,
    rank_tolerance: float | None = None,
    *,
    proved: bool = False,
    refining: bool = False,
) -> Reduction:
    """The reduction of A(s) where it serves for a force, whatever the initial values are; stiff ones where modes may be refined."""
    if rank_tolerance is not None:
        raise NotReducible("a rank tolerance is given, and the reduced equations decide no rank")
    refining = refining and proved
    reduction = reduction_of(A, by_elements=True) if refining and any(A.factors) else A.reduction
    if isinstance(reduction, NotReducible):
        raise NotReducible(str(reduction))
    if not reduction.is_finite:
        raise NotReducible("the reduced equations leave the range of float64")
    if force.impulses or force.later:
        _check_impulses(reduction, force, proved)
    restarts = len(force.knots) - 1
    if reduction.is_small and restarts and not proved:  # sums of modes may cancel at any of them
        raise NotReducible(f"the force restarts at {counted(restarts, 'time')}")
    if not refining and _is_stiff(reduction):
        raise NotReducible(_spread(reduction))
    if reduction.is_small:
        if not proved and not reduction.is_well_separated:
            raise NotReducible("the modes are not well separated")
        if not proved and reduction.drives_unstable_part:
            raise NotReducible("a part is one-way coupled to an unstable part")
    return reduction


def _check_impulses(reduction: Reduction, force: ImpulsiveSmooth, proved: bool) -> None:
    """Check that no coordinate has an impulse: impulses on masses and dampers make their velocities and displacements jump."""
    bounded = proved and not (len(reduction.algebraic) or len(reduction.first) or force.smooth.generator.any())
    if reduction.is_small and not bounded:  # the jumps of the velocities are rounded
        raise NotReducible("the force contains Dirac impulses")
    loads = [force.impulses, *(load.impulses for load in force.later)]
    if any(len(load) > 1 and any(part.any() for part in load[1:]) for load in loads):
        raise NotReducible("the force contains derivatives of Dirac impulses")
    if any(part[reduction.algebraic].any() for load in loads for part in load[:1]):
        raise NotReducible("the force contains Dirac impulses on algebraic equations")


def _is_stiff(reduction: Reduction) -> bool:
    """Whether more digits are worth their time; eigenvalues are computed only where the number of states and a bound allow it."""
    states = reduction.state_count
    if reduction.wide_modes is not None or not is_worthwhile(1 / EPS, states):  # float64 computes no larger spread
        return False
    return is_worthwhile(reduction.spread_bound, states) and is_worthwhile(reduction.spread, states)


def _spread(reduction: Reduction) -> str:
    return f"the stiffness spread is {reduction.spread:.0e}, the ratio of the fastest rate to the slowest"


def satisfying(reduction: Reduction, initial: np.ndarray, force: ImpulsiveSmooth) -> np.ndarray:
    """Which of S starts satisfy the algebraic equations at 0-, with their derivative where they involve mass or damping."""
    constraining = _constraining(reduction)
    if not len(constraining):
        return np.ones(initial.shape[2], dtype=bool)
    smooth, satisfied = force.smooth, np.full(initial.shape[2], not makes_constrained_jump(reduction, force))
    rows, columns, start = reduction.given[0][constraining], smooth.coefficients[constraining], smooth.start_at_zero[:, None]
    for values in initial:
        noise = noise_of(abs(rows) @ np.abs(values) + np.abs(columns) @ np.abs(start), len(values))
        satisfied &= (np.abs(rows @ values - columns @ start) <= noise).all(axis=0)
        columns = columns @ smooth.generator
    return satisfied


def makes_constrained_jump(reduction: Reduction, force: ImpulsiveSmooth) -> bool:
    """Whether a jump of the right sides after t = 0 makes coordinates with mass or damping jump, or their velocities."""
    columns, jumps = force.smooth.coefficients[_constraining(reduction)], force.smooth.restarts.jumps[:, 1:]
    orders = len(reduction.given) - 1
    return (
        columns.size > 0
        and jumps.size > 0
        and any((columns @ np.linalg.matrix_power(force.smooth.generator, k) @ jumps).any() for k in range(orders))
    )


def _constraining(reduction: Reduction) -> np.ndarray:
    algebraic = reduction.algebraic
    return algebraic[reduction.constraining] if len(algebraic) else algebraic


# Modes, powers or steps


def evaluation_method(flow: Flow, shape: tuple[int, int], request: Request) -> tuple[str, str | Callable[[], str]]:
    """The name of the method that evaluates an output of this shape (r, n), and the reason."""
    reduction, times = flow.reduction, request.times
    if reduction.is_small:
        refined = "" if flow.refined is None else ", refined with twice the digits, as their rates span many orders of magnitude"
        return MODES, f"by eigenvectors{refined}: {reduction.state_count} states are few"

    def by_modes(then: str) -> tuple[str, Callable[[], str]]:
        return MODES, lambda: f"by {_modes_of(reduction)}{then}"

    if reduction.is_free:
        return by_modes(", which separate the motion of a free body from all others: no rounding error moves it")
    if reduction.wide_modes is not None:
        return by_modes(", refined: their rates span many orders of magnitude, of which powers of e^(S h) keep the fastest")
    if request.evaluations == "many":
        return by_modes(", which many evaluations share")
    if times is None:
        return by_modes(", and at even times by powers of e^(S h) where these cost less")
    steps = _cost_of_steps(flow, shape, times)
    powers = None if steps is not None else _cost_of_powers(flow, times)
    if steps is None and powers is None:
        what = f"the force restarts at {counted(len(flow.knots) - 1, 'time')}" if len(flow.knots) > 1 else "the times are not even"
        return by_modes(f": {what}")
    name, text, cost = (
        (STEPS, "steps from knot to knot of the force", steps) if powers is None else (POWERS, "powers of e^(S h)", powers)
    )

    def compared() -> str:
        costs = f"about {cost:.0f} products of matrices of {reduction.state_count} states"
        return f"by {text}: they cost {costs}, {_modes_of(reduction)} {decomposition_cost(reduction):.0f}"

    if cost <= least_decomposition_cost(reduction) or cost <= decomposition_cost(reduction):
        return name, compared
    if powers is not None and cost <= decomposition_cost(reduction, by_topology=False) and reduction.topology_failed:
        return name, f"by {text}: the modes of the sparse topology were not separable, and powers cost {cost:.0f}"
    return by_modes(
        f": {text} cost about {cost:.0f} products of matrices of {reduction.state_count} states, these {decomposition_cost(reduction):.0f}"
    )


def _cost_of_powers(flow: Flow, times: np.ndarray) -> float | None:
    """Cost of e^(S h) and its use at even times 0, h, 2 h, ...; None where the times or the force do not allow it."""
    step = even_step(times) if len(times) >= FEWEST_TIMES and times[0] == 0 and len(flow.knots) == 1 else None
    if step is None:
        return None
    powers, series = _costs_at_even_times(flow, len(times), step)
    return min(powers, series)


def is_by_series(flow: Flow, times: np.ndarray) -> bool:
    """Whether vectors at these even times cost less by the series of e^(S h) than by its powers: of large sparse models."""
    powers, series = _costs_at_even_times(flow, len(times), float(times[-1]) / (len(times) - 1))
    return series < powers


def _costs_at_even_times(flow: Flow, count: int, step: float) -> tuple[float, float]:
    n, turned = flow.reduction.state_count, flow.norm * step
    return cost_of_powers(n, count, turned), cost_of_series(n, entry_count(flow.generator), count, turned)


def _cost_of_steps(flow: Flow, shape: tuple[int, int], times: np.ndarray) -> float | None:
    """Cost of steps where the times are the first knots of the force, and these are even; else None."""
    knots, count = flow.knots, len(times)
    if flow.force.later or not FEWEST_KNOTS <= count <= len(knots) or not np.array_equal(times, knots[:count]):
        return None
    gaps = shared_gaps(times)
    if (gaps != gaps[0]).any():
        return None
    return cost_of_exponential(flow.norm * gaps[0]) + cost_of_steps(*shape, flow.force.smooth.state_count, count)


def decomposition_cost(reduction: Reduction, *, by_topology: bool = True) -> float:
    """Cost of the modes of S, by its sparse topology if it has one; 0 where powers would move a free body."""
    if reduction.is_free:
        return 0.0
    n = max(reduction.state_count, 1)
    if by_topology and not reduction.is_symmetric and reduction.topology is not None:
        return TOPOLOGY * (3 + 2 * reduction.topology.width) / 5 / n**1.5
    large, small = (SYMMETRIC, SYMMETRIC_SMALL) if reduction.is_symmetric else (GENERAL, GENERAL_SMALL)
    return large + small / n


def least_decomposition_cost(reduction: Reduction) -> float:
    """A lower bound of the cost of the modes: that of the narrowest topology, since determining the topology itself takes long."""
    narrowest = TOPOLOGY / max(reduction.state_count, 1) ** 1.5
    return min(narrowest, decomposition_cost(reduction, by_topology=False))


def _modes_of(reduction: Reduction) -> str:
    """The computation of the modes, as text."""
    if reduction.is_symmetric:
        return "a symmetric eigenproblem"
    return "the modes of a sparse topology" if reduction.topology is not None else "eigenvectors"
