"""scipy.signal.lsim and control.forced_response on the reduced equations: exact where the force is linear between samples.

Both take samples of the input at even times and are exact for what runs linearly between them, by the exponential of one
matrix. Where the force does not, the same is done with the steps divided by 4, 16 and 64. They get as few inputs as the
force has independent rows, and start anew where it jumps or strikes at one of the samples: two samples at one time cannot
be given to them. What the force does to x at once is added from its formula.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np
import scipy.linalg

from ...signals import BohlFunction
from ...tolerances import EPS
from ..problem import Problem
from .exosystem import SAME_TIME, knots_of
from .method import Evaluate, Failure, Method, Setting
from .reduced import NO_STATES, Reduced, once_for_each, reduced

REFINEMENTS = (1, 4, 16, 64)

#: So many numbers of samples, states and outputs together.
MOST_NUMBERS = 2e7

#: A, B, C, samples of the inputs (p, L), step, start -> C z (r, L) and the last z.
Simulate = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float, np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Samples:
    """Even samples, and at which of them the solver has to start anew.

    Attributes:
        step: in s.
        cuts: numbers of samples, the first and the last among them.
        knots: the times of the cuts, exactly.
        inputs: as a function of time, p rows.
        matrix: B for these inputs, shape (n, p).
    """

    step: float
    cuts: tuple[int, ...]
    knots: tuple[float, ...]
    inputs: BohlFunction
    matrix: np.ndarray

    def between(self, place: int) -> np.ndarray:
        """The inputs from one cut to the next, at this one from the right and at that one from the left, shape (p, L)."""
        first, last = self.cuts[place : place + 2]
        times = self.step * np.arange(first, last + 1)
        times[0], times[-1] = self.knots[place : place + 2]
        values = self.inputs(np.maximum.accumulate(times))
        values[:, -1] -= _jump(self.inputs, times[-1])
        return values


def _jump(function: BohlFunction, time: float) -> np.ndarray:
    restarts = function.restarts
    at = int(np.searchsorted(restarts.knots, time))
    if time == 0 or at == len(restarts.knots) or restarts.knots[at] != time:
        return np.zeros(function.size)
    return function.coefficients @ restarts.jumps[:, at]


def _samples(problem: Problem, equations: Reduced, refinement: int) -> Samples:
    times, force = problem.times, problem.force
    step = times[-1] / (len(times) - 1) / refinement
    inputs, matrix = _independent(force.smooth, equations.B)
    if (times.size * refinement) * (matrix.size + equations.C.size) > MOST_NUMBERS * len(matrix):
        raise Failure(f"{times.size * refinement} samples of all states and coordinates are too many")
    blows = {blow.time for blow in force.later}
    cuts, knots = [0], [0.0]
    for knot in knots_of(force, times)[1:]:
        place = round(knot / step)
        even = abs(knot - place * step) <= SAME_TIME * EPS * times[-1]
        if knot in blows and not even:
            raise Failure(f"the Dirac impulse at {knot:g} s lies between the samples; there is no way to give it")
        if even and place > cuts[-1] and (knot in blows or _jump(inputs, knot).any()):
            cuts.append(place)
            knots.append(float(knot))
    if cuts[-1] < (len(times) - 1) * refinement:
        cuts.append((len(times) - 1) * refinement)
        knots.append(float(times[-1]))
    return Samples(step, tuple(cuts), tuple(knots), inputs, matrix)


#: Work done by hand, in nobody's time.
_SAMPLES = {
    refinement: once_for_each(lambda problem, refinement=refinement: _samples(problem, reduced(problem), refinement))
    for refinement in REFINEMENTS
}


def _independent(force: BohlFunction, B: np.ndarray) -> tuple[BohlFunction, np.ndarray]:
    """u and its matrix with B f = matrix u: chosen rows of f in units of their size, of which the others are combinations.

    In units of their size because python-control takes inputs below 1e-8 for none at all. There is one at least, of zeros.
    """
    rows = force.coefficients * B.any(axis=0)[:, None]
    if not rows.any() or force.is_zero:
        return BohlFunction(np.zeros((1, 0)), (), np.zeros(0)), np.zeros((len(B), 1))
    size = np.abs(rows).max(axis=1)
    scaled = rows / np.where(size > 0, size, 1.0)[:, None]
    triangle, order = scipy.linalg.qr(scaled.T, mode="r", pivoting=True)
    diagonal = np.abs(np.diag(triangle))
    chosen = order[: int((diagonal > max(rows.shape) * EPS * diagonal[0]).sum())]
    mixing = scaled @ np.linalg.pinv(scaled[chosen])
    mixing[chosen] = np.eye(len(chosen))
    return BohlFunction(scaled[chosen], force.blocks, force.start), B @ (size[:, None] * mixing)


def _simulated(simulate: Simulate, problem: Problem, equations: Reduced, samples: Samples, refinement: int) -> np.ndarray:
    blows = {blow.time: blow.impulses for blow in problem.force.later}
    state, found = equations.start, []
    for place in range(len(samples.cuts) - 1):
        inputs = samples.between(place)
        outputs, state = simulate(equations.S, samples.matrix, equations.C, inputs, samples.step, state)
        found.append(outputs[:, :-1])
        impulses = blows.get(samples.knots[place + 1], ())
        state = state + equations.kick(impulses)
    found.append((equations.C @ state)[:, None])
    x = np.hstack(found)[:, ::refinement]
    return x if equations.through.is_zero else x + equations.through(problem.times)


def _lsim(A, B, C, inputs, step, start) -> tuple[np.ndarray, np.ndarray]:
    from scipy.signal import lsim

    system, times = (A, B, C, np.zeros((len(C), B.shape[1]))), step * np.arange(inputs.shape[1])
    _, outputs, states = lsim(system, inputs.T if inputs.any() else None, times, start)
    return outputs.reshape(len(times), -1).T, states.reshape(len(times), -1)[-1]


def _forced_response(A, B, C, inputs, step, start) -> tuple[np.ndarray, np.ndarray]:
    from control import StateSpace, forced_response

    system = StateSpace(A, B, C, np.zeros((len(C), B.shape[1])))
    times = step * np.arange(inputs.shape[1])
    found = forced_response(system, times, inputs, start, return_states=True, squeeze=False)
    return found.outputs.reshape(len(C), -1), found.states.reshape(len(A), -1)[:, -1]


def _prepare(simulate: Simulate, problem: Problem, refinement: int) -> Evaluate:
    """Where to start anew and which inputs there are; the solver has no set-up of its own."""
    equations = reduced(problem)
    samples = _SAMPLES[int(refinement)](problem)
    return lambda: _simulated(simulate, problem, equations, samples, int(refinement))


def _matters(problem: Problem, refinement: float) -> bool:
    """A finer step changes nothing where the force is linear between the times and changes at them only."""
    if refinement == 1:
        return True
    knots, last = knots_of(problem.force, problem.times), problem.times[-1]
    nearest = np.abs(knots[:, None] - problem.times).min(axis=1)
    return not problem.force.derivative(2).is_zero or bool((nearest > SAME_TIME * EPS * last).any())


def _refusal(problem: Problem) -> str:
    times = problem.times
    if len(times) < 2:
        return "needs at least two times"
    if np.abs(times - np.linspace(0.0, times[-1], len(times))).max() > SAME_TIME * EPS * times[-1]:
        return "needs even times that begin at t = 0"
    return "" if reduced(problem).count else NO_STATES


def _refusal_of_control(problem: Problem) -> str:
    return _refusal(problem) if find_spec("control") else "python-control is not installed"


def _method(name: str, simulate: Simulate, refusal, library: str) -> Method:
    settings = tuple(Setting(f"step / {refinement}" if refinement > 1 else "", refinement) for refinement in REFINEMENTS)
    return Method(
        name, settings, lambda problem, value: _prepare(simulate, problem, value), refusal, matters=_matters, library=library
    )


LSIM = _method("scipy.signal.lsim", _lsim, _refusal, "scipy.signal")
FORCED_RESPONSE = _method("control.forced_response", _forced_response, _refusal_of_control, "control")
