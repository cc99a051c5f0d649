"""Stepping with the exponential of the reduced equations and the force together: exact up to rounding for every Bohl force.

With f = C_f w and w' = J_f w the states (z, w) follow one matrix [[S, B C_f], [0, J_f]], whose exponential over a step
takes them from one time to the next (Van Loan 1978). At a knot of the force w starts anew.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...linalg.blocks import block_slices
from ...signals import BohlFunction
from ...tolerances import EPS
from ..problem import Problem
from .exosystem import SAME_TIME, knots_of
from .method import Evaluate, Failure, Method, Setting
from .reduced import NO_STATES, Reduced, reduced

#: Steps of one length are taken so many at once, as the product of one matrix with many columns.
MOST_COLUMNS = 64

#: Bytes of all propagators together.
MOST_BYTES = 2**30

#: Exponentials of larger matrices, or of so many times with so many states, one by one take minutes.
MOST_STATES, MOST_WORK = 100, 2e9


@dataclass(frozen=True)
class Augmented:
    """(z, w)' = matrix (z, w).

    Attributes:
        matrix: [[S, B C_f u], [0, J_f]], w measured in units u that make what drives z about as large as S.
        inputs: w / u at each knot, shape (m, K).
    """

    matrix: np.ndarray
    inputs: np.ndarray


def augmented(problem: Problem, equations: Reduced) -> Augmented:
    """The reduced equations and the force as one system."""
    force = problem.force.smooth.with_knots(problem.force.knots)
    drive = equations.B @ force.coefficients
    units = _units(force, drive, np.abs(equations.S).max(initial=0.0) or 1.0)
    nothing = np.zeros((drive.shape[1], equations.count))
    return Augmented(np.block([[equations.S, drive * units], [nothing, force.generator]]), force.restarts.states / units[:, None])


def _units(force: BohlFunction, drive: np.ndarray, size: float) -> np.ndarray:
    """One for all states of a block, so that its generator stays what it is: a power of two."""
    units = np.ones(drive.shape[1])
    for at in block_slices(force.blocks):
        largest = np.abs(drive[:, at]).max(initial=0.0)
        units[at] = np.exp2(np.round(np.log2(size / largest))) if largest else 1.0
    return units


@dataclass(frozen=True)
class Run:
    """Steps of one length, from one moment to another.

    Attributes:
        first, last: their numbers.
        powers: P = e^(matrix length), P^2, P^4, ... as far as they are of use.
    """

    first: int
    last: int
    powers: list[np.ndarray]


def _prepare(problem: Problem, _) -> Evaluate:
    """The exponentials are the set-up, one for each length of step; the steps are the evaluation."""
    equations = reduced(problem)
    system = augmented(problem, equations)
    knots = knots_of(problem.force, problem.times)
    moments = np.union1d(knots, problem.times)
    events, wanted = (np.searchsorted(moments, times) for times in (knots, problem.times))
    runs = _runs(system.matrix, moments, events)
    blows = {blow.time: blow.impulses for blow in problem.force.later}
    kicks = [equations.kick(blows.get(knot, ())) for knot in knots.tolist()]
    anew = dict(zip(events.tolist(), zip(kicks, system.inputs.T)))

    def evaluate() -> np.ndarray:
        return equations.coordinates(_walk(equations.start, anew, runs, len(moments))[:, wanted], problem.times)

    return evaluate


def _walk(start: np.ndarray, anew: dict, runs: list[Run], count: int) -> np.ndarray:
    """z at all moments, shape (n, count); anew: by how much z jumps at some of them, and w from there on."""
    n = len(start)

    def met(place: int, z: np.ndarray) -> np.ndarray:
        kick, inputs = anew[place]
        return np.concatenate([z + kick, inputs])

    first = met(0, start)
    states = np.empty((len(first), count))
    states[:, 0] = first
    for run in runs:
        states[:, run.first + 1 : run.last + 1] = _steps(run.powers, states[:, run.first], run.last - run.first)
        if run.last in anew:
            states[:, run.last] = met(run.last, states[:n, run.last])
    return states[:n]


def _runs(matrix: np.ndarray, moments: np.ndarray, events: np.ndarray) -> list[Run]:
    """As few as there can be: they end where the length of the steps changes, or at an event."""
    kinds, lengths = _lengths(moments)
    cuts = np.union1d(np.flatnonzero(np.diff(kinds)) + 1, [*events, len(kinds)]).astype(int)
    pairs = [(int(first), int(last)) for first, last in pairwise(cuts)]
    longest = np.ones(len(lengths), dtype=int)
    for first, last in pairs:
        longest[kinds[first]] = max(longest[kinds[first]], last - first)
    powers = _powers(matrix, lengths, np.log2(np.minimum(longest, MOST_COLUMNS)).astype(int))
    return [Run(first, last, powers[kinds[first]]) for first, last in pairs]


def _lengths(moments: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each step the number of its length, and the lengths; those that differ by rounding are one."""
    steps = np.diff(moments)
    order = np.argsort(steps)
    apart = np.diff(steps[order], prepend=steps[order[:1]]) > SAME_TIME * EPS * moments[-1]
    kinds = np.empty(len(steps), dtype=int)
    kinds[order] = np.cumsum(apart)
    return kinds, np.bincount(kinds, steps) / np.maximum(np.bincount(kinds), 1)


def _powers(matrix: np.ndarray, lengths: np.ndarray, doublings: np.ndarray) -> list[list[np.ndarray]]:
    """For each length P = e^(matrix length), P^2, P^4, ..."""
    from scipy.linalg import expm

    if 8 * matrix.size * (len(lengths) + doublings.sum()) > MOST_BYTES:
        raise Failure(f"{len(lengths)} lengths of step with {len(matrix)} states each need a matrix exponential of their own")
    found = [[expm(matrix * length)] for length in lengths]
    for powers, count in zip(found, doublings):
        for _ in range(count):
            powers.append(powers[-1] @ powers[-1])
    return found


def _steps(powers: list[np.ndarray], state: np.ndarray, count: int) -> np.ndarray:
    """The states after 1, 2, ..., count steps."""
    block = (powers[0] @ state)[:, None]
    for power in powers[:-1]:
        block = np.hstack([block, power @ block])
    blocks = [block]
    while len(blocks) * block.shape[1] < count:
        blocks.append(powers[-1] @ blocks[-1])
    return np.hstack(blocks)[:, :count]


def _prepare_each(problem: Problem, _) -> Evaluate:
    """Nothing is shared by the times, so all is evaluation."""
    equations = reduced(problem)
    system = augmented(problem, equations)
    return lambda: equations.coordinates(_each(system, equations, problem.times), problem.times)


def _each(system: Augmented, equations: Reduced, times: np.ndarray) -> np.ndarray:
    from scipy.linalg import expm

    start = np.concatenate([equations.start, system.inputs[:, 0]])
    together = max(1, int(MOST_BYTES / 64 / system.matrix.size))  # some eight temporary copies in the exponential
    parts = [times[first : first + together] for first in range(0, len(times), together)]
    return np.vstack([expm(part[:, None, None] * system.matrix) @ start for part in parts]).T[: equations.count]


def _refusal(problem: Problem) -> str:
    return "" if reduced(problem).count else NO_STATES


def _refusal_each(problem: Problem) -> str:
    if len(knots_of(problem.force, problem.times)) > 1:
        return "the force starts, stops, changes or strikes on the way; one exponential from t = 0 does not see it"
    states = reduced(problem).count + problem.force.smooth.coefficients.shape[1]
    if states > MOST_STATES or len(problem.times) * states**3 > MOST_WORK:
        return f"{len(problem.times)} exponentials of {states} states take too long"
    return _refusal(problem)


METHOD = Method("expm, steps", (Setting(),), _prepare, _refusal)
EACH = Method("expm, each time by itself", (Setting(),), _prepare_each, _refusal_each)
