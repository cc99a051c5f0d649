"""How accurate is the answer? The same problem, its data moved by about a rounding error, is solved again.

The data of A(s), of the values at 0- and of the force are moved entry by entry by a unit in the last place. The
largest change of the answer over a few such trials, times a safety factor, is the estimate: it sees the condition
of the problem and the rounding of the algorithm at once, for whatever is read off the answer, its derivatives too.
Where a rank decision was not clear, the whole answer stands on it, and the estimate is at least a tenth. Moved data
are decided upon like the given ones: what counted as zero at s = 0 is seen by one more trial, with the data as they
are written, where that makes more of a difference than a free body may. The trials are seeded: the estimate is reproducible.
Moved data are summed up by the same rounded functions of time, so what cancels in the sum of modes is told beside the trials, by
the size of the terms.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..checks import real_array
from ..errors import Overflow
from ..linalg.blocks import CHUNK_ENTRIES
from ..linalg.exponential import block_states
from ..polynomial.matrix import PolynomialMatrix
from ..signals.bohl import BohlFunction
from ..signals.impulsive import Blow, ImpulsiveSmooth
from ..tolerances import EPS, PROBE_SIZE, UNCLEAR_ERROR

if TYPE_CHECKING:
    from .response import Response

TRIALS = 3

#: By how many units in the last place entries are moved: not all by the same, or ratios of theirs would stay as they are.
MOVES = (-2.0, -1.0, 1.0, 2.0)

#: An algorithm in float64 adds errors of its own to those of the data, of the same kind; precise arithmetic only those of
#: the evaluation.
SAFETY, PRECISE_SAFETY = 2.5, 1.0

#: No answer is claimed to be better than so many roundings: its evaluation takes as many.
LEAST = 8 * EPS


#: Whether a body is free or held by a stiffness of the size of rounding, data that were rounded do not tell: in a time t that
#: makes a difference of eps (w t)^2, w the fastest frequency. Over thousands of periods that is a millionth: only more is told.
ROUNDED_FREE = 1e-6


def error_estimate(x: Response, times, view: Callable[[Response], BohlFunction] = lambda response: response.function) -> float:
    """Estimate of max |error| / max |y| over the times, at least a few rounding errors.

    Args:
        x: the response.
        times: in s, a number or shape (T,).
        view: the function of time y that is read off a response; x itself when not given.
    """
    times = real_array(times, "time")
    values = np.asarray(view(x)(times))
    largest = np.abs(values).max(initial=0.0)
    if largest == 0:
        return EPS
    change = max(_largest_change(lambda: view(other)(times) - values, largest) for other in x.moved)
    written = 0.0 if x.written is None else _largest_change(lambda: view(x.written)(times) - values, largest)
    change = max(change, written if written > ROUNDED_FREE * largest else 0.0)
    phase = EPS / 2 * float(np.abs(times * (view(x).derivative()(times) / largest)).max())  # zeros are known to half a unit at best
    summed = EPS * summands(view(x), times) / largest
    estimate = max((PRECISE_SAFETY if x.solution.is_precise else SAFETY) * (change / largest), phase, summed)
    return max(estimate, LEAST if x.solution.structure_is_clear else UNCLEAR_ERROR)


def summands(function: BohlFunction, times) -> float:
    """Size of the terms that C e^{J t} v is summed of, the largest of any row and time: the root of the sum of their squares.

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
    """The largest of the changes, as large as the answer itself where the moved problem has none in the range of float64."""
    try:
        return float(np.abs(changes()).max())
    except Overflow:
        return largest


def moved_responses(x: Response) -> tuple[Response, ...]:
    """Answers to the problem of x with its data moved."""
    from .solve import solve

    found = []
    for seed in range(TRIALS):
        random = np.random.default_rng(seed)
        A = _moved_matrix(x.polynomial_matrix, random)
        found.append(solve(A, _moved(x.initial, random), _moved_force(x.force, random), x.solution.rank_tolerance))
    return tuple(found)


def written_response(x: Response) -> Response | None:
    """The answer to the problem of x with its data as they are written, where some of them counted as zero at s = 0."""
    from .solve import solve_with

    as_written = x.solution.written
    return None if as_written is None else solve_with(as_written, x.initial, x.force)


def _moved_matrix(A: PolynomialMatrix, random) -> PolynomialMatrix:
    """A coefficient that is known by its factors has its values moved, not the entries that they add up to."""
    coefficients = [
        _moved(matrix, random, uncertainty) if factors is None else replace(factors, values=_moved(factors.values, random))
        for matrix, factors, uncertainty in zip(A.coefficients, A.factors, A.uncertainty)
    ]
    return PolynomialMatrix(coefficients, A.coordinates, A.equations, A.uncertainty)


def _moved_force(force: ImpulsiveSmooth, random) -> ImpulsiveSmooth:
    smooth = replace(force.smooth, coefficients=_moved(force.smooth.coefficients, random))
    later = tuple(Blow(blow.time, _all_moved(blow.impulses, random)) for blow in force.later)
    return replace(force, smooth=smooth, impulses=_all_moved(force.impulses, random), later=later)


def _all_moved(arrays, random) -> tuple[np.ndarray, ...]:
    return tuple(_moved(array, random) for array in arrays)


def _moved(array, random, uncertainty=0.0) -> np.ndarray:
    """Each entry by a unit in the last place, or by its uncertainty where that is more; zeros stay."""
    size = np.abs(array)
    share = np.maximum(EPS, uncertainty / np.where(size > 0, size, np.inf))
    return array * (1 + PROBE_SIZE * share * random.choice(MOVES, size=np.shape(array)))
