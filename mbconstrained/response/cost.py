"""What the ways to evaluate a large motion cost, in products of two matrices of the size of its states.

Measured with OpenBLAS on machines of one to two cores: LAPACK's QR algorithm (geev) takes the time of 40 products for 2000 states
and of 100 for 200, a symmetric eigenproblem of half the size that of 2 and of 7; powers of e^{S h} are counted (``linalg.propagation``).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log2

from ..linalg.propagation import DEGREE, LARGEST, ROOT, best_doublings, use_cost
from ..polynomial.reduction import Reduction

#: Smaller models are solved through the pencil of A(s), with every decision's evidence: it takes them milliseconds.
LEAST_STATES = 48

#: Of eigenvectors: for very many states, and more for few.
GENERAL, GENERAL_SMALL = 40.0, 12000.0
SYMMETRIC, SYMMETRIC_SMALL = 1.5, 1000.0


def decomposition_cost(reduction: Reduction) -> float:
    """Of decoupling S."""
    n = max(reduction.state_count, 1)
    large, small = (SYMMETRIC, SYMMETRIC_SMALL) if reduction.is_symmetric else (GENERAL, GENERAL_SMALL)
    return large + small / n


def stepping_cost(states: int, times: int, turned: float, known: bool) -> float:
    """Of powers of e^{S h}, |S| h = turned, at so many times; where e^{S h} is known only of its use."""
    doublings = best_doublings(states, times)
    use = use_cost(states, times, doublings)
    if known:
        return use - doublings
    return DEGREE // ROOT + ROOT - 2 + max(0, ceil(log2(max(turned, LARGEST) / LARGEST))) + use


@dataclass(frozen=True)
class Way:
    """How values are found for the first time, and why so.

    Attributes:
        name: "powers", "symmetric", "eigenvectors" or "pairs".
        reason: a sentence.
    """

    name: str
    reason: str


def way_of(reduction: Reduction | None, states: int, times: int, turned: float | None) -> Way:
    """The way that costs least for one run.

    Args:
        reduction: the reduced equations, None where there are none or the start does not fit them.
        states: of A(s).
        times: how many.
        turned: |S| h for even times 0, h, 2 h, ..., None for others.
    """
    if reduction is None:
        small = states < LEAST_STATES
        return Way("pairs", f"by the Jordan pairs: {f'{states} states are few' if small else 'the model or its start is not plain'}")
    modes = decomposition_cost(reduction)
    name, text = ("symmetric", "a symmetric eigenproblem") if reduction.is_symmetric else ("eigenvectors", "eigenvectors")
    if turned is None:
        return Way(name, f"by {text}: the times are not even, or the force starts anew")
    powers = stepping_cost(reduction.state_count, times, turned, known=False)
    compared = f"cost about {powers:.0f} products of matrices of {reduction.state_count} states, {text} {modes:.0f}"
    return Way("powers", f"by powers of e^(S h): they {compared}") if powers <= modes else Way(name, f"by {text}: powers {compared}")
