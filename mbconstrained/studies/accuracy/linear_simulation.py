"""scipy.signal.lsim and control.forced_response on the reduced equations: exact where the force is linear between samples.

Both take evenly spaced samples of the input and are exact for inputs that are linear between them, by the exponential of one
matrix. For other forces the steps are also divided by 4, 16 and 64. They get as few inputs as the
force has independent rows, and restart where it jumps or has an impulse at one of the samples: two samples at one time cannot
be given to them. What the force does to x at once is added from its formula.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from importlib.util import find_spec
from itertools import pairwise

import numpy as np

from ...ground.tolerances import EPS
from ..study_problem import StudyProblem
from .first_order import reduced, refusal_without_states
from .force_intervals import SAME_TIME, jumps_of, knots_of
from .method import ComparedMethod, Evaluate, Failure, MethodSetting

SETTINGS = (MethodSetting("", 1), *(MethodSetting(f"step / {refinement}", refinement) for refinement in (4, 16, 64)))

#: Most numbers of samples, states and outputs together.
MOST_NUMBERS = 2e7

#: A, B, C, samples of the inputs (p, L), times, start -> C z (r, L) and the last z.
Simulate = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@lru_cache(maxsize=8)
def _samples(problem: StudyProblem, refinement: int):
    """B and C for the inputs, a unit of z, the step, and for each part of time the samples (p, L) and the impulses at its end.

    A part ends where the force jumps or has an impulse at a sample; there the samples are the limits from within. The inputs
    are as few as B f has independent rows. In units of z in which they are about 1 and their matrix is about as large as S the
    exponential keeps its digits, and python-control, which takes inputs below 1e-8 for none, sees them.
    """
    equations, force, end = reduced(problem), problem.force, problem.times[-1]
    count = (len(problem.times) - 1) * refinement
    if (count + refinement) * (equations.S.size + equations.C.size) > MOST_NUMBERS * equations.count:
        raise Failure(f"{count + refinement} samples of all states and coordinates are too many")
    times, step = np.linspace(0.0, end, count + 1), end / count
    loads, jumps = {load.time: load.impulses for load in force.later}, jumps_of(force.smooth)
    cuts = {0: 0.0, count: float(end)}
    for knot in map(float, knots_of(force, problem.times)[1:]):
        place = round(knot / step)
        is_even = abs(knot - place * step) <= SAME_TIME * EPS * end
        if knot in loads and not is_even:
            raise Failure(f"the Dirac impulse at {knot:g} s lies between the samples; there is no input for it")
        if is_even and (knot in loads or np.any(jumps.get(knot, 0.0))):
            cuts[place] = times[place] = knot
    excitation = equations.B @ force.smooth(times)
    basis, sizes, _ = np.linalg.svd(excitation, full_matrices=False)
    matrix = basis[:, : max(1, int((sizes > max(excitation.shape) * EPS * sizes[0]).sum()))]
    size, parts = np.abs(equations.S).max() or 1.0, []
    unit = (np.abs(excitation).max() or 1.0) / size
    for first, last in pairwise(sorted(cuts)):
        inputs = excitation[:, first : last + 1].copy()
        if cuts[last] in jumps:
            inputs[:, -1] -= equations.B @ jumps[cuts[last]]
        parts.append((matrix.T @ inputs / (size * unit), loads.get(cuts[last], ())))
    return size * matrix, unit * equations.C, unit, step, parts


def _prepare(simulate: Simulate, problem: StudyProblem, refinement: int) -> Evaluate:
    """Sample the inputs; the solver has no set-up of its own."""
    equations = reduced(problem)
    B, C, unit, step, parts = _samples(problem, int(refinement))

    def evaluate() -> np.ndarray:
        state, blocks = equations.start / unit, []
        for inputs, impulses in parts:
            times = step * np.arange(inputs.shape[1])
            outputs, state = simulate(equations.S, B, C, inputs, times, state)
            blocks.append(outputs[:, :-1])
            state = state + equations.jump(impulses) / unit
        x = np.hstack([*blocks, (C @ state)[:, None]])[:, ::refinement]
        return x if equations.through.is_zero else x + equations.through(problem.times)

    return evaluate


def _lsim(A, B, C, inputs, times, start) -> tuple[np.ndarray, np.ndarray]:
    from scipy.signal import lsim

    system = (A, B, C, np.zeros((len(C), B.shape[1])))
    _, outputs, states = lsim(system, inputs.T if inputs.any() else None, times, start)
    return outputs.reshape(len(times), -1).T, states.reshape(len(times), -1)[-1]


def _forced_response(A, B, C, inputs, times, start) -> tuple[np.ndarray, np.ndarray]:
    from control import StateSpace, forced_response

    system = StateSpace(A, B, C, np.zeros((len(C), B.shape[1])))
    result = forced_response(system, times, inputs, start, return_states=True, squeeze=False)
    return result.outputs.reshape(len(C), -1), result.states.reshape(len(A), -1)[:, -1]


def _matters(problem: StudyProblem, refinement: float) -> bool:
    """Whether a finer step has an effect: not for a force that is linear between the times."""
    knots, last = knots_of(problem.force, problem.times), problem.times[-1]
    nearest = np.abs(knots[:, None] - problem.times).min(axis=1)
    return refinement == 1 or not problem.force.derivative(2).is_zero or bool((nearest > SAME_TIME * EPS * last).any())


def _refusal(package: str, problem: StudyProblem) -> str:
    times = problem.times
    if not find_spec(package):
        return "python-control is not installed"
    if len(times) < 2:
        return "needs at least two times"
    if np.abs(times - np.linspace(0.0, times[-1], len(times))).max() > SAME_TIME * EPS * times[-1]:
        return "needs even times that begin at t = 0"
    return refusal_without_states(problem)


METHODS = tuple(
    ComparedMethod(name, partial(_prepare, simulate), SETTINGS, partial(_refusal, package), matters=_matters, library=library)
    for name, simulate, package, library in (
        ("scipy.signal.lsim", _lsim, "scipy", "scipy.signal"),
        ("control.forced_response", _forced_response, "control", "control"),
    )
)
