"""What the ways to evaluate a large motion cost, in products of two matrices of the size of its states.

Measured with OpenBLAS on machines of one to two cores: LAPACK's QR algorithm (geev) takes the time of 40 products for 2000 states
and of 100 for 200, a symmetric eigenproblem of half the size that of 2 and of 7; powers of e^{S h} are counted (``linalg.propagation``).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log2

from ..linalg.propagation import DEGREE, LARGEST, ROOT, best_doublings, use_cost
from ..polynomial.reduction import Reduction

#: Of smaller models the Jordan pairs tell every decision's evidence: they take milliseconds.
LEAST_STATES = 48

#: Of eigenvectors: for very many states, and more for few.
GENERAL, GENERAL_SMALL = 40.0, 12000.0
SYMMETRIC, SYMMETRIC_SMALL = 1.5, 1000.0

#: Of modes by way of few couplings (``linalg.quadratic_modes``), by fronts of w coordinates, in (3 + 2 w) / 5 times the number of states
#: to the power of 1.5; of a chain less than half of that is counted: its modes have a digit more than powers.
COUPLED, CHAIN = 1.6e5, 7e4


def decomposition_cost(reduction: Reduction, *, by_couplings: bool = True) -> float:
    """Of decoupling S, by its few couplings if it has those; nothing where only that serves: powers of e^{S h} would push a free body."""
    if reduction.is_free:
        return 0.0
    n = max(reduction.state_count, 1)
    if by_couplings and not reduction.is_symmetric and reduction.is_chain:
        width = reduction.front_width
        return (CHAIN if width <= 1 else COUPLED * (3 + 2 * width) / 5) / n**1.5
    large, small = (SYMMETRIC, SYMMETRIC_SMALL) if reduction.is_symmetric else (GENERAL, GENERAL_SMALL)
    return large + small / n


def exponential_cost(turned: float) -> float:
    """Of e^{S h}, |S| h = turned."""
    return DEGREE // ROOT + ROOT - 2 + max(0, ceil(log2(max(turned, LARGEST) / LARGEST)))


def stepping_cost(states: int, times: int, turned: float, known: bool) -> float:
    """Of powers of e^{S h}, |S| h = turned, at so many times; where e^{S h} is known only of its use."""
    doublings = best_doublings(states, times)
    use = use_cost(states, times, doublings)
    if known:
        return use - doublings
    return exponential_cost(turned) + use


@dataclass(frozen=True)
class Way:
    """How values are found for the first time, and why so.

    Attributes:
        name: "powers", "steps", "symmetric", "chain", "eigenvectors" or "pairs".
        reason: a sentence.
    """

    name: str
    reason: str


def way_of(reduction: Reduction | None, times: int, turned: float | None, steps: float | None = None) -> Way:
    """The way that costs least for one run.

    Args:
        reduction: the reduced equations, None where there are none or the start does not fit them.
        times: how many.
        turned: |S| h for even times 0, h, 2 h, ..., None for others.
        steps: the cost from knot to knot where the times are the even knots of a record, None for others.
    """
    if reduction is None:
        return Way("pairs", "by the Jordan pairs: the model, its start or its force is not plain")
    if reduction.is_small:
        return Way("eigenvectors", f"by eigenvectors: {reduction.state_count} states are few")
    modes = decomposition_cost(reduction)
    name, text = _modes_of(reduction)
    if reduction.is_free:
        return Way(name, f"by {text}: a free body's motion is apart from all others in them, so that no rounding pushes it")
    if steps is None and turned is None:
        return Way(name, f"by {text}: the times are not even, or the force starts anew")
    other, cost = ("steps", steps) if turned is None else ("powers", stepping_cost(reduction.state_count, times, turned, known=False))
    compared = f"cost about {cost:.0f} products of matrices of {reduction.state_count} states, {text} {modes:.0f}"
    if cost > modes:
        return Way(name, f"by {text}: {other} {compared}")
    return Way(other, f"by {'powers of e^(S h)' if turned is not None else 'steps from knot to knot of the force'}: they {compared}")


def _modes_of(reduction: Reduction) -> tuple[str, str]:
    if reduction.is_symmetric:
        return "symmetric", "a symmetric eigenproblem"
    if reduction.is_chain:
        return "chain", "modes by few couplings, as of a chain or a tree, all zeros at once"
    return "eigenvectors", "eigenvectors"
