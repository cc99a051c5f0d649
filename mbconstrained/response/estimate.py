"""Error estimate of a response: proved, from the defect of its values, or by solutions of the problem with perturbed data.

The values of a small model are compared with balls of the exact engine, at each time relative to the largest value then.

Of a larger model that the reduced equations serve, values by modes leave a residual in the given equations, and the response to it is
their error (``methods.defect_response``); values by other methods are compared with those by modes. Nothing but the true error makes
this estimate large.

Of all others, and before the Taylor series of the start ends, the data of A(s), of the values at 0- and of the force are
moved entry by entry by a unit in the last place. The largest change of the answer over a few such trials, times a safety factor, is
the estimate: it sees the condition of the problem and the rounding errors of the algorithm at once, for the solution and for all
that is derived from it.
Where a rank decision was not clear, the estimate is at least the difference from the solution with the other decision, or
a tenth where there is none. Ranks of moved data
are decided like those of the given ones: data that counted as zero at s = 0 enter by one more trial, with the data as they
are written, where that makes more of a difference than a free body may. The trials are seeded: the estimate is reproducible.
Moved data are summed up by the same rounded functions of time, so cancellation in the sum of modes enters separately, by the
size of its terms.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..ground.checks import real_array
from ..ground.errors import Overflow, within_float64
from ..ground.tolerances import EPS, PROVED_ACCURACY, ROUNDED_FREE, TRUST_LIMIT, UNCLEAR_ERROR
from ..linalg.blocks import CHUNK_ENTRIES
from ..linalg.exponential.block_exponential import block_states
from ..signals.bohl import BohlFunction
from .methods.defect_response import DefectResponse
from .methods.proved import ProvedFunction
from .methods.reduced_solution import FlowFunction
from .response_notices import SolvedProblem

#: Number of solved problems with perturbed data.
TRIALS = 3

#: An algorithm in float64 adds errors of its own to those of the data, of the same kind; precise arithmetic only those of
#: the evaluation.
SAFETY, PRECISE_SAFETY = 2.5, 1.0

#: The response to the defect is right to a few percent where the modes are well separated.
DEFECT_SAFETY = 2.0

#: Values at so many times are compared with the exact engine.
MOST_PROVED = 64

#: No solution is claimed to be better than so many rounding errors: its evaluation makes as many.
LEAST = 8 * EPS


def error_estimate(x: SolvedProblem, times, view: Callable[[Any], BohlFunction] = lambda response: response.function) -> float:
    """Estimate of max |error| / max |y| over the times, at least a few rounding errors; of a small model a proved bound.

    It is infinite where the error may be as large as the answer.
    """
    with within_float64():
        return _estimate(x, real_array(times, "time"), view)


def _estimate(x: SolvedProblem, times: np.ndarray, view: Callable[[Any], BohlFunction]) -> float:
    function = view(x)
    values = np.asarray(function(times))
    largest, times = np.abs(values).max(initial=0.0), np.atleast_1d(times)
    values = values.reshape(function.size, len(times))
    if largest and isinstance(function, ProvedFunction) and function.is_provable:
        rounded = max(
            2 * LEAST, min(_phase(function, times, largest), PROVED_ACCURACY)
        )  # what rounded data move, within what is proved
        return max(_proved_error(function, times, values), rounded)
    if isinstance(function, FlowFunction) and (error := _error_by_defect(function, times, values)) is not None:
        early = times < function.flow.taylor_start(modal=True).end
        estimate = error / largest if largest else np.inf * (error > 0)
        if estimate <= TRUST_LIMIT and not early.any():
            return max(_relative_to_truth(estimate), LEAST)
        if estimate <= TRUST_LIMIT:
            times, values = times[early], values[:, early]
    else:
        estimate = 0.0
    return max(_relative_to_truth(estimate), _estimate_by_trials(x, times, values, largest, view)) if largest else EPS


def errors_at(function: BohlFunction, times: np.ndarray) -> np.ndarray | None:
    """Estimates of max |error| / max |y| at each of some times, without further solutions; None where these are necessary."""
    if not isinstance(function, FlowFunction):
        return None
    values = np.asarray(function(times))
    if (errors := [_error_by_defect(function, times[k : k + 1], values[:, k : k + 1]) for k in range(len(times))]).count(None):
        return None
    sizes = np.abs(values).max(axis=0, initial=0.0)
    relative = np.divide(np.array(errors, dtype=float), sizes, out=np.zeros(len(times)), where=sizes > 0)
    return np.array([_relative_to_truth(one) for one in relative])


def _error_by_defect(function: FlowFunction, times: np.ndarray, values: np.ndarray) -> float | None:
    """The largest error of some of the values after the first moments; None where it is not known."""
    late = np.flatnonzero(times >= function.flow.taylor_start(modal=True).end)
    if not len(late):
        return 0.0
    response = DefectResponse.of(function.flow, float(times[late].max()))
    if response is None:
        return None
    if len(late) > (most := response.most_times(MOST_PROVED)):
        late = late[np.linspace(0, len(late) - 1, most).astype(int)]
    errors = DEFECT_SAFETY * response.errors(function.place, function.order, times[late])
    return float((errors + np.abs(values[:, late] - function.by_modes(times[late])).max(axis=0, initial=0.0)).max())


def _phase(function: BohlFunction, times: np.ndarray, largest: float) -> float:
    """Error of the phase: eigenvalues are accurate to half a unit in the last place at best."""
    return EPS / 2 * float(np.abs(times * np.asarray(function.derivative()(times)) / largest).max())


def _estimate_by_trials(x: SolvedProblem, times: np.ndarray, values: np.ndarray, largest: float, view) -> float:
    """Error estimate from perturbed problems, for the values at these times, relative to the largest of all."""
    function = view(x)
    change = max(_largest_change(lambda other=other: view(other)(times) - values, largest) for other in x.moved)
    written = 0.0 if x.written is None else _largest_change(lambda: view(x.written)(times) - values, largest)
    change = max(change, written if written > ROUNDED_FREE * largest else 0.0)
    summed = EPS * summands(function, times) / largest
    safety = PRECISE_SAFETY if x.solution.is_precise else SAFETY
    estimate = _relative_to_truth(max(safety * (change / largest), _phase(function, times, largest), summed))
    if x.solution.has_clear_ranks:
        return max(estimate, LEAST)
    other = x.decided_otherwise
    if other is None:
        return max(estimate, UNCLEAR_ERROR)
    return max(estimate, LEAST, _relative_to_truth(_largest_change(lambda: view(other)(times) - values, largest) / largest))


def _proved_error(function: ProvedFunction, times: np.ndarray, values: np.ndarray) -> float:
    """A bound of the largest |error| / |y|; of very many times the smallest values and even samples are checked."""
    size = np.abs(values).max(axis=0)
    if len(times) > MOST_PROVED:
        even = np.linspace(0, len(times) - 1, MOST_PROVED // 2).astype(int)
        chosen = np.union1d(np.argsort(size)[: MOST_PROVED // 2], even)
        times, values, size = times[chosen], values[:, chosen], size[chosen]
    proved, bounds = function.proved(times)
    error = (np.abs(values - proved) + bounds).max(axis=0)
    return float(np.divide(error, size, out=np.where(error > 0, 1.0, 0.0), where=size > 0).max())


def _relative_to_truth(error: float) -> float:
    """An error relative to the computed value y converted to one relative to the true value, which is at least (1 - error) |y|.

    It is infinite where the error may be all of y: a growing mode that rounding alone excites is larger than the truth by any factor.
    """
    return error / (1 - error) if error < 1 else float("inf")


def summands(function: BohlFunction, times) -> float:
    """Size of the terms of the sum C e^{J t} v, the largest of any row and time: the root of the sum of their squares.

    Rows are left out while they are evaluated in another way, by their Taylor series for example, in which nothing cancels.
    """
    times, summed_from = np.atleast_1d(times), function.summed_from
    times = times[times >= summed_from.min(initial=np.inf)]
    if not times.size:
        return 0.0
    C, largest = function.coefficients, 0.0
    units = np.abs(C).max(axis=0, initial=0.0)
    squares = (C / np.where(units > 0, units, 1.0)) ** 2
    width = max(1, CHUNK_ENTRIES // max(*C.shape, 1))
    for begin in range(0, times.size, width):
        piece, since = function.restarts.located(part := times[begin : begin + width])
        states = units[:, None] * block_states(function.blocks, function.restarts.states[:, piece], since)
        size = np.abs(states).max(initial=0.0)
        if 0 < size < np.inf:
            sizes = size * np.sqrt(squares @ (states / size) ** 2)
            largest = max(largest, sizes.max(where=np.less_equal.outer(summed_from, part), initial=0.0))
    return float(largest)


def _largest_change(changes: Callable[[], np.ndarray], largest: float) -> float:
    """The largest of the changes, as large as the value itself where the perturbed problem has none in the range of float64."""
    try:
        return float(np.abs(changes()).max())
    except Overflow:
        return largest
