"""scipy.integrate.solve_ivp, and odeint, which is LSODA without Python between its steps, on the reduced equations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..problem import Problem
from .exosystem import Formula, Stretch, stretches
from .method import Evaluate, Failure, Method, Setting
from .reduced import NO_STATES, Reduced, once_for_each, reduced

#: scipy refuses to go below 100 eps with the relative tolerance.
EXPLICIT = tuple(10.0**-digits for digits in range(3, 14, 2))

#: Finer ones take the implicit methods minutes.
IMPLICIT = tuple(10.0**-digits for digits in range(3, 11, 2))

#: Steps of odeint from one time to the next: more than the time of any run allows.
MOST_STEPS = 10**8

#: S, force, begin, z(begin), times, options -> z at the times, shape (n, T).
Integrate = Callable[[np.ndarray, Formula, float, np.ndarray, np.ndarray, dict], np.ndarray]


@once_for_each
def _stretches(problem: Problem) -> tuple[Stretch, ...]:
    return tuple(stretches(problem.force, problem.times, reduced(problem).B))


def _prepare(integrate: Integrate, problem: Problem, rtol: float) -> Evaluate:
    """Nothing to set up but the options.

    The absolute tolerance is rtol times the size of each state (``Reduced.sizes``): one size for all coordinates, since
    errors are measured against the largest of them, and one for their derivatives. The implicit methods are given the
    Jacobian S. The solver starts anew wherever the force starts, stops, changes or strikes, as its order demands.
    """
    equations, parts = reduced(problem), _stretches(problem)
    options = {"rtol": rtol, "atol": rtol * equations.sizes}
    return lambda: _integrated(integrate, problem, equations, parts, options)


def _integrated(
    integrate: Integrate, problem: Problem, equations: Reduced, parts: tuple[Stretch, ...], options: dict
) -> np.ndarray:
    state, found = equations.start, []
    for stretch in parts:
        if stretch.impulses:
            state = state + equations.kick(stretch.impulses)
        states = _on(integrate, stretch, state, equations.S, options)
        found.append(states[:, : len(stretch.times)])
        state = states[:, -1]
    return equations.coordinates(np.hstack(found), problem.times)


def _on(integrate: Integrate, stretch: Stretch, state: np.ndarray, S: np.ndarray, options: dict) -> np.ndarray:
    if stretch.end == stretch.begin:
        return np.repeat(state[:, None], max(1, len(stretch.times)), axis=1)
    return integrate(S, stretch.force, stretch.begin, state, stretch.stops, options)


def _by_solve_ivp(name: str, jacobian: Callable[[np.ndarray], dict]) -> Integrate:
    def integrate(S, force, begin, state, stops, options):
        from scipy.integrate import solve_ivp

        span, given = (begin, stops[-1]), {**options, **jacobian(S)}
        answer = solve_ivp(lambda t, z: S @ z + force(t), span, state, method=name, t_eval=stops, **given)
        if answer.status != 0:
            raise Failure(answer.message)
        return answer.y

    return integrate


def _by_odeint(S, force, begin, state, stops, options):
    from scipy.integrate import odeint

    times = stops if stops[0] == begin else np.concatenate([[begin], stops])
    given = {"tfirst": True, "Dfun": lambda t, z: S, "mxstep": MOST_STEPS, "full_output": True, **options}
    states, told = odeint(lambda t, z: S @ z + force(t), state, times, **given)
    if told["message"] != "Integration successful.":
        raise Failure(told["message"])
    return states[len(times) - len(stops) :].T


def _refusal(problem: Problem) -> str:
    return "" if reduced(problem).count else NO_STATES


def _method(name: str, integrate: Integrate, tolerances) -> Method:
    settings = tuple(Setting(f"rtol {rtol:.0e}", rtol) for rtol in tolerances)
    return Method(name, settings, lambda problem, rtol: _prepare(integrate, problem, rtol), _refusal, library="scipy.integrate")


METHODS = (
    _method("solve_ivp DOP853", _by_solve_ivp("DOP853", lambda S: {}), EXPLICIT),
    _method("solve_ivp LSODA", _by_solve_ivp("LSODA", lambda S: {"jac": lambda t, z: S}), EXPLICIT),
    _method("odeint", _by_odeint, EXPLICIT),
    _method("solve_ivp Radau", _by_solve_ivp("Radau", lambda S: {"jac": S}), IMPLICIT),
    _method("solve_ivp BDF", _by_solve_ivp("BDF", lambda S: {"jac": S}), IMPLICIT),
)
