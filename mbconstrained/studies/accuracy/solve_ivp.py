"""scipy.integrate.solve_ivp and odeint (LSODA without Python between its steps) on the reduced equations."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from ..study_problem import StudyProblem
from .first_order import reduced, refusal_without_states
from .force_intervals import Formula, Interval, intervals_of, stepped
from .method import ComparedMethod, Evaluate, Failure, tolerances

#: scipy refuses to go below 100 eps with the relative tolerance; finer ones than these take the implicit methods minutes.
EXPLICIT, IMPLICIT = tolerances(3, 5, 7, 9, 11, 13), tolerances(3, 5, 7, 9)

#: Steps of odeint from one time to the next: more than the time of any run allows.
MOST_STEPS = 10**8

#: S, force, begin, z(begin), times, options -> z at the times, shape (n, T).
Integrate = Callable[[np.ndarray, Formula, float, np.ndarray, np.ndarray, dict], np.ndarray]


def _prepare(integrate: Integrate, problem: StudyProblem, rtol: float) -> Evaluate:
    """Set up the options.

    The absolute tolerance is rtol times the size of each state (``Reduced.sizes``): one size for all coordinates, since
    errors are measured against the largest of them, and one for their derivatives. The implicit methods are given the
    Jacobian S. The solver restarts wherever the force starts, stops, changes or has an impulse, as its order demands.
    """
    equations, parts = reduced(problem), intervals_of(problem)
    options = {"rtol": rtol, "atol": rtol * equations.sizes}

    def advance(_, interval: Interval, state: np.ndarray) -> np.ndarray:
        return integrate(equations.S, interval.force, interval.begin, state, interval.stops, options)

    return lambda: stepped(problem, equations, parts, advance)


def _by_solve_ivp(name: str, jacobian: Callable[[np.ndarray], dict], S, force, begin, state, stops, options) -> np.ndarray:
    from scipy.integrate import solve_ivp

    span, given = (begin, stops[-1]), {**options, **jacobian(S)}
    answer = solve_ivp(lambda t, z: S @ z + force(t), span, state, method=name, t_eval=stops, **given)
    if answer.status != 0:
        raise Failure(answer.message)
    return answer.y


def _by_odeint(S, force, begin, state, stops, options) -> np.ndarray:
    from scipy.integrate import odeint

    times = stops if stops[0] == begin else np.concatenate([[begin], stops])
    given = {"tfirst": True, "Dfun": lambda t, z: S, "mxstep": MOST_STEPS, "full_output": True, **options}
    states, information = odeint(lambda t, z: S @ z + force(t), state, times, **given)
    if information["message"] != "Integration successful.":
        raise Failure(information["message"])
    return states[len(times) - len(stops) :].T


#: Name, function, tolerances.
TABLE = (
    ("solve_ivp DOP853", partial(_by_solve_ivp, "DOP853", lambda S: {}), EXPLICIT),
    ("solve_ivp LSODA", partial(_by_solve_ivp, "LSODA", lambda S: {"jac": lambda t, z: S}), EXPLICIT),
    ("odeint", _by_odeint, EXPLICIT),
    ("solve_ivp Radau", partial(_by_solve_ivp, "Radau", lambda S: {"jac": S}), IMPLICIT),
    ("solve_ivp BDF", partial(_by_solve_ivp, "BDF", lambda S: {"jac": S}), IMPLICIT),
)

METHODS = tuple(
    ComparedMethod(name, partial(_prepare, integrate), settings, refusal_without_states, library="scipy.integrate")
    for name, integrate, settings in TABLE
)
