"""Whether states are small remainders of large modes: then the general route, which keeps clusters of zeros together, knows them better.

Balanced units do not tell it: of two like parts that are hardly coupled backward, what one drives the other by is a
difference of large motions until these have come apart. So is a slow motion at the times of a fast force.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..linalg.kinds import full

if TYPE_CHECKING:
    from .flow import Flow

#: Modes may be so many times larger than the states that they make: it costs as many digits at most.
MOST_CANCELLED = 1000.0


def cancels(flow: Flow) -> bool:
    """Whether, when it starts, a state is that small beside its modes and beside what couplings make of all states in some steps."""
    return bool(cancelled(flow, flow.states.restarts.states).any())


def cancelled(flow: Flow, states: np.ndarray) -> np.ndarray:
    """The same of several starts, their modes' states (n, S): shape (S,)."""
    G = np.abs(full(flow.generator))
    modes, states = flow.seen(np.eye(len(G))), states / np.where(states.any(axis=0), np.abs(states).max(axis=0, initial=0.0), 1.0)
    power, reached = G / flow.rate, np.abs(modes @ states)
    for _ in range(len(G).bit_length()):  # the largest in 0, 1, 2, ... steps, as many as lead to any state
        power, reached = power @ power, np.maximum(reached, power @ reached)
    return (np.abs(modes) @ np.abs(states) > MOST_CANCELLED * reached).any(axis=0)
