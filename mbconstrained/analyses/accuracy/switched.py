"""Motions with events: the closed form next to solve_ivp with events, phase by phase, and Moreau's time stepping.

Solve_ivp gets the phases in the coordinates of their Jordan pairs and the laws of the switches, so that it differs only in how it steps
and locates events. Moreau's stepping (Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008, section 10.1) takes all
impacts of a step at its end.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import null_space

from ...ground.errors import NotUnique
from ...mechanics.switched.flow import Crossing, PhaseFlow
from ...mechanics.switched.impact import complementary
from ...mechanics.switched.phase import Phase
from ...mechanics.switched.sequence import MOST_EVENTS, PhaseSequence
from ..study_problem import StudyProblem, chosen_places
from .measure import MOST_TIMES, ReferenceSolution
from .methods import ComparedMethod, Evaluate, Failure, MethodSetting, _evaluation, tolerances

if TYPE_CHECKING:
    from ...mechanics.switched.switched_motion import SwitchedMotion
    from ...mechanics.switched.switched_system import SwitchedSystem
    from ...scene.run.scene import Scene

#: The tolerance of the integration with which the closed form is compared.
FINEST = 1e-13

#: Steps of Moreau's method from 0 to the last time.
STEP_COUNTS = (1_000, 10_000, 100_000)


@dataclass(frozen=True, eq=False)
class SwitchedProblem(StudyProblem):
    """The problem of a switched system; the polynomial matrix and the system are those of its first phase."""

    machine: SwitchedSystem = None
    penetration: bool = False

    def solve(self) -> SwitchedMotion:
        x, v = self.initial
        return self.machine.solve(x, v, self.applied, end=float(self.times[-1]), penetration=self.penetration)


def switched_problem_of(scene: Scene) -> SwitchedProblem:
    equations = scene.equations
    switching = equations.switching
    first = switching.begin.solution.sequence.segments[-1].phase.system
    return SwitchedProblem(
        title=scene.heading,
        polynomial_matrix=first.undelayed_form().polynomial_matrix,
        initial=equations.initial,
        force=equations.right_hand_side,
        times=scene.times,
        system=first,
        applied=equations.force,
        machine=switching.machine,
        penetration=switching.penetration,
    )


def switched_reference(problem: SwitchedProblem) -> ReferenceSolution:
    """The closed form, verified to the accuracy with which solve_ivp with events agrees at its least tolerance."""
    places = chosen_places(len(problem.times), MOST_TIMES)
    motion = problem.solve()
    values = motion(problem.times[places])
    scale = float(np.abs(values).max(initial=0.0)) or 1.0
    count = len(motion.events)
    try:
        other = _stepped("DOP853", problem, FINEST)()[:, places]
        bound = float(np.abs(values - other).max(initial=0.0)) / scale
        source = (
            f"the closed form itself through its {count} events, with which solve_ivp DOP853 with events at rtol {FINEST:.0e} "
            f"agrees to {bound:.1e}; smaller errors are not resolved"
        )
    except NotUnique as problem_of_steps:
        bound, source = np.inf, f"the closed form itself; solve_ivp with events fails ({problem_of_steps})"
    return ReferenceSolution(places, values, np.zeros_like(values), bound, source)


# --- solve_ivp with events


class _SteppedFlow(PhaseFlow):
    """The flow of one phase by an integrator, which locates the zeros of guards as its events."""

    def __init__(self, flow: PhaseFlow, method: str, rtol: float, pieces: list):
        self.__dict__.update(flow.__dict__)
        self.method, self.rtol, self.pieces = method, rtol, pieces

    def first_crossing(self, y, size, order, sign, horizon) -> Crossing | None:
        """The first event within the horizon; guards that vanish at the begin are divided by their zero."""
        from scipy.integrate import solve_ivp

        J, rows, values = self.J, self.rows, self.values
        watched = np.flatnonzero(sign > 0)

        def event(guard):
            def value(t, z):
                return (rows[guard] @ z - values[guard]) / t ** int(order[guard]) if t > 0 or not order[guard] else 1.0

            value.terminal, value.direction = True, -1.0
            return value

        atol = self.rtol * max(float(np.abs(y).max(initial=0.0)), np.finfo(float).tiny)
        stepped = solve_ivp(
            lambda t, z: J @ z,
            (0.0, horizon),
            y,
            self.method,
            events=[event(guard) for guard in watched],
            dense_output=True,
            rtol=self.rtol,
            atol=atol,
        )
        if stepped.status < 0:
            raise Failure(stepped.message)
        self.pieces.append(stepped.sol)
        if stepped.status == 0:
            return None
        hit = [number for number, times in enumerate(stepped.t_events) if len(times)]
        return Crossing(float(stepped.t[-1]), stepped.y[:, -1], watched[hit])

    def states(self, y: np.ndarray, time: float) -> np.ndarray:
        return self.pieces[-1](time)


class _SteppedSequence(PhaseSequence):
    """A sequence of phases by an integrator."""

    def __init__(self, known: PhaseSequence, method: str, rtol: float):
        super().__init__(known.machine, known.source, known.end, MOST_EVENTS)
        self.pieces: list = []
        self._method, self._known = (method, rtol), known

    def phase(self, key) -> Phase:
        if key not in self.phases:
            phase = copy(self._known.phase(key))
            phase.flow = _SteppedFlow(phase.flow, *self._method, self.pieces)
            self.phases[key] = phase
        return self.phases[key]

    def values(self, times: np.ndarray) -> np.ndarray:
        """x at the times, shape (n, T)."""
        begins = np.array([segment.time for segment in self.segments])
        places = np.searchsorted(begins, times, side="right") - 1
        result = np.empty((self.machine.system.size, len(times)))
        for place in np.unique(places):
            chosen, segment = places == place, self.segments[place]
            result[:, chosen] = segment.phase.C @ self.pieces[place](times[chosen] - segment.time)
        return result


@lru_cache(maxsize=8)
def _known_sequence(problem: SwitchedProblem) -> PhaseSequence:
    """The phases of the closed form, which no run time of an integrator includes."""
    return problem.solve().solution.sequence


def _stepped(method: str, problem: Any, rtol: float) -> Evaluate:
    """Evaluate by integration from event to event."""
    known, (x, v) = _known_sequence(problem), problem.initial

    def evaluate() -> np.ndarray:
        sequence = _SteppedSequence(known, method, rtol)
        sequence.run(tuple(switch.start(x, v) for switch in known.machine.switches), x, v, problem.penetration)
        return sequence.values(problem.times)

    return evaluate


# --- Moreau's time stepping


def _moreau_refusal(problem: Any) -> str:
    """The reason why there are no steps by impulses alone; else empty."""
    machine = problem.machine
    frictionless = [switch for switch in machine.switches if switch.contact is not None and len(switch.states) == 2]
    if len(frictionless) < len(machine.switches) or any(
        len(switch.states[switch.contact.closed].rows) > 1 for switch in frictionless
    ):
        return "written for rigid contacts that slide without friction only"
    system = machine.system
    if any(row.order or row.value or row.signal is not None for row in system.rows):
        return "written for constraint rows that are zero at position level"
    return "" if np.linalg.matrix_rank(system.mass) == system.size else "needs a regular mass matrix"


def _moreau(problem: Any, count: float) -> Evaluate:
    """Set up the inverse masses; evaluate with steps of one length: x_m = x + h v / 2, impulses at contacts whose gap at x_m is closed."""
    system, contacts = problem.machine.system, [switch.contact for switch in problem.machine.switches]
    V = null_space(system.constraint_matrix) if system.rows else np.eye(system.size)
    inverse = V @ np.linalg.inv(V.T @ system.mass @ V) @ V.T
    A, gaps = np.array([one.row for one in contacts]), np.array([one.gap for one in contacts])
    W, e, end = A @ inverse @ A.T, np.array([one.restitution for one in contacts]), float(problem.times[-1])
    K, C, h = system.stiffness, system.damping, end / count
    applied = system._applied(problem.applied).smooth

    def evaluate() -> np.ndarray:
        grid = np.linspace(0.0, end, int(count) + 1)
        forces, (x, v) = applied(grid[:-1] + h / 2), problem.initial
        values = np.empty((len(x), len(grid)))
        for k in range(int(count)):
            values[:, k] = x
            middle = x + h / 2 * v
            following = v + h * inverse @ (forces[:, k] - K @ middle - C @ v)
            closed = np.flatnonzero(A @ middle + gaps <= 0)
            if len(closed):
                p = complementary(W[np.ix_(closed, closed)], A[closed] @ following + e[closed] * (A[closed] @ v))
                following = following + inverse @ (A[closed].T @ p)
            x, v = middle + h / 2 * following, following
        values[:, -1] = x
        return np.array([np.interp(problem.times, grid, row) for row in values])

    return evaluate


SWITCHED_METHODS = (
    ComparedMethod("closed form", lambda problem, _: _evaluation(problem.solve, problem.times), is_ours=True),
    *(
        ComparedMethod(f"solve_ivp {name} with events", partial(_stepped, name), tolerances(*digits), library="scipy.integrate")
        for name, digits in (("DOP853", (4, 6, 8, 10, 12)), ("RK45", (4, 6, 8, 10)))
    ),
    ComparedMethod(
        "Moreau's time stepping",
        _moreau,
        tuple(MethodSetting(f"{count:,} steps", float(count)) for count in STEP_COUNTS),
        refusal=_moreau_refusal,
    ),
)
