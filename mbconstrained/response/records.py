"""Values of a large motion under a record: at its own even knots by steps, otherwise by its modes, gap by gap."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..linalg.kinds import Matrix
from ..linalg.propagation import Propagator
from ..linalg.recursion import shared_gaps
from ..linalg.stepping import cost_of_steps, values_of_steps
from .cost import decomposition_cost, exponential_cost
from .pieces import FEW_PIECES

if TYPE_CHECKING:
    from .flow import Flow, FlowFunction


def record_values(asked: FlowFunction, times: np.ndarray) -> np.ndarray | None:
    """Of a function of a flow, shape (r, T); None where its force starts anew too seldom or too late beside the motion."""
    flow = asked.flow
    if len(flow.knots) <= FEW_PIECES:
        return None
    values = _by_steps(flow, asked.output, times)
    if values is not None:
        return values
    return None if flow.pieces is None else flow.pieces.values(asked, times)


def cost_of_knots(flow: Flow, output: Matrix, times: np.ndarray) -> float | None:
    """Of output @ z by steps, in products of matrices, where times are the first knots of the force, and these even; else None."""
    knots, count = flow.knots, len(times)
    if not FEW_PIECES <= count <= len(knots) or not np.array_equal(times, knots[:count]):
        return None
    gaps = shared_gaps(times)
    if (gaps != gaps[0]).any():
        return None
    return exponential_cost(flow.rate * gaps[0]) + cost_of_steps(*output.shape, flow.force.smooth.state_count, count)


def _by_steps(flow: Flow, output: Matrix, times: np.ndarray) -> np.ndarray | None:
    """output @ z at the first knots, once, where they are even and modes cost more."""
    known = flow.spent or flow.reduction.is_small or "decoupled" in flow.reduction.__dict__
    cost, n = None if known else cost_of_knots(flow, output, times), len(flow.start)
    if cost is None or cost > decomposition_cost(flow.reduction):
        return None
    flow.spent += cost
    inputs, step = flow.force.smooth.restarts.states[:, : len(times)], float(shared_gaps(times)[0])
    step = Propagator(flow.generator, step).matrix[:n]
    found = values_of_steps(output[:, :n], step[:, :n], step[:, n:], flow.start, inputs[:, :-1])
    through = output[:, n:]
    return found + through @ inputs if abs(through).sum() else found
