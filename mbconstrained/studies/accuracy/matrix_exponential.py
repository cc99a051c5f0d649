"""Steps with the matrix exponential of the reduced equations and the force together: exact up to rounding errors for Bohl forces.

With f = C_f w and w' = J_f w the states (z, w) follow one matrix [[S, B C_f], [0, J_f]], whose exponential over a step
takes them from one time to the next (Van Loan 1978). At a knot of the force w restarts.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

import numpy as np

from ...ground.tolerances import EPS
from ...linalg.blocks import block_slices
from ..study_problem import StudyProblem
from .first_order import Reduced, reduced, refusal_without_states
from .force_intervals import SAME_TIME, Interval, intervals_of, knots_of, stepped
from .method import ComparedMethod, Evaluate, Failure

#: Steps of one length computed together, as the product of one matrix with many columns.
MOST_COLUMNS = 64

#: Bytes of all propagators together.
MOST_BYTES = 2**30

#: Most states, and most work (times by states cubed), of one exponential for each time.
MOST_STATES, MOST_WORK = 100, 2e9


def _augmented(problem: StudyProblem, equations: Reduced) -> tuple[np.ndarray, np.ndarray]:
    """[[S, B C_f u], [0, J_f]], and w / u at each knot as columns, w in units u in which its input is about as large as S.

    The units are powers of two, one for all states of a block, so that its generator stays what it is.
    """
    force = problem.force.smooth.with_knots(problem.force.knots)
    input_matrix, size = equations.B @ force.coefficients, np.abs(equations.S).max(initial=0.0) or 1.0
    units = np.ones(input_matrix.shape[1])
    for at in block_slices(force.blocks):
        if largest := np.abs(input_matrix[:, at]).max(initial=0.0):
            units[at] = np.exp2(np.round(np.log2(size / largest)))
    nothing = np.zeros((input_matrix.shape[1], equations.count))
    matrix = np.block([[equations.S, input_matrix * units], [nothing, force.generator]])
    return matrix, force.restarts.states / units[:, None]


def _prepare(problem: StudyProblem, _) -> Evaluate:
    """Set up one exponential for each length of step; the evaluation makes the steps."""
    from scipy.linalg import expm

    equations, parts = reduced(problem), intervals_of(problem)
    matrix, inputs = _augmented(problem, equations)
    steps = [np.diff(part.stops, prepend=part.begin) for part in parts]
    kinds, lengths = _lengths(np.concatenate(steps), problem.times[-1])
    kinds_of = np.split(kinds, np.cumsum([len(part) for part in steps])[:-1])
    longest = np.zeros(len(lengths), dtype=int)
    for part in kinds_of:
        for kind, count in _runs(part):
            longest[kind] = max(longest[kind], count)
    doublings = np.log2(np.minimum(longest, MOST_COLUMNS)).astype(int)
    if 8 * matrix.size * (len(lengths) + doublings.sum()) > MOST_BYTES:
        raise Failure(
            f"{np.count_nonzero(lengths)} lengths of step with {len(matrix)} states each need a matrix exponential of their own"
        )
    powers_of = [[expm(matrix * length) if length else np.eye(len(matrix))] for length in lengths]
    for powers, count in zip(powers_of, doublings):
        for _ in range(count):
            powers.append(powers[-1] @ powers[-1])

    def advance(number: int, interval: Interval, state: np.ndarray) -> np.ndarray:
        blocks = [np.concatenate([state, inputs[:, number]])[:, None]]
        for kind, count in _runs(kinds_of[number]):
            blocks.append(_steps(powers_of[kind], blocks[-1][:, -1], count))
        return np.hstack(blocks[1:])[: equations.count]

    return lambda: stepped(problem, equations, parts, advance)


def _runs(kinds: np.ndarray) -> Iterator[tuple[int, int]]:
    """Kind and number of successive equal steps."""
    return ((int(kind), len(list(steps))) for kind, steps in groupby(kinds))


def _lengths(steps: np.ndarray, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Index of the length of each step, and the lengths; those that differ by rounding errors are one."""
    order = np.argsort(steps)
    is_new = np.diff(steps[order], prepend=steps[order[:1]]) > SAME_TIME * EPS * end
    kinds = np.empty(len(steps), dtype=int)
    kinds[order] = np.cumsum(is_new)
    return kinds, np.bincount(kinds, steps) / np.maximum(np.bincount(kinds), 1)


def _steps(powers: list[np.ndarray], state: np.ndarray, count: int) -> np.ndarray:
    """The states after 1, 2, ..., count steps, by P, P^2, P^4, ..."""
    block = (powers[0] @ state)[:, None]
    for power in powers[:-1]:
        block = np.hstack([block, power @ block])
    blocks = [block]
    while len(blocks) * block.shape[1] < count:
        blocks.append(powers[-1] @ blocks[-1])
    return np.hstack(blocks)[:, :count]


def _prepare_each(problem: StudyProblem, _) -> Evaluate:
    """Set up nothing: no work is shared by the times."""
    from scipy.linalg import expm

    equations = reduced(problem)
    matrix, inputs = _augmented(problem, equations)
    start = np.concatenate([equations.start, inputs[:, 0]])
    together = max(1, int(MOST_BYTES / 64 / matrix.size))  # some eight temporary copies in the exponential
    chunks = [problem.times[first : first + together, None, None] for first in range(0, len(problem.times), together)]

    def evaluate() -> np.ndarray:
        states = np.vstack([expm(chunk * matrix) @ start for chunk in chunks]).T
        return equations.coordinates(states[: equations.count], problem.times)

    return evaluate


def _refusal_each(problem: StudyProblem) -> str:
    if len(knots_of(problem.force, problem.times)) > 1:
        return "the force starts, stops, changes or has an impulse on the way; one exponential from t = 0 does not include it"
    states = reduced(problem).count + problem.force.smooth.coefficients.shape[1]
    if states > MOST_STATES or len(problem.times) * states**3 > MOST_WORK:
        return f"{len(problem.times)} exponentials of {states} states take too long"
    return refusal_without_states(problem)


STEPS = ComparedMethod("expm, steps", _prepare, refusal=refusal_without_states)
EACH = ComparedMethod("expm, each time by itself", _prepare_each, refusal=_refusal_each)
METHODS = (STEPS, EACH)
