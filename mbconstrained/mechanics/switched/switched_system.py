"""Systems whose equations change: phases with transitions, and models with contacts, friction, clutches and latches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING

import numpy as np

from ...ground.by_name import answering
from ...ground.checks import counted, nearest, real_number, whole_number
from ...ground.display import Displayed, TextTable
from ...ground.errors import InputError, within_float64
from ...response.problem import Problem
from .phase import Source, checked_source
from .sequence import MOST_EVENTS, Key, Machine, PhaseSequence
from .switched_motion import SwitchedMotion, SwitchedSolution
from .switches import Switch, SwitchState, TimedChange, Transition

if TYPE_CHECKING:
    import numpy as np

    from ..system import MechanicalSystem
    from .frequency_curve import FrequencyCurve
    from .periodic import PeriodicMotion


@answering
class SwitchedSystem(Displayed):
    """A mechanical system that changes its equations: each phase M x'' + C x' + K x = f + A^T lambda with rows of its own.

    The motion starts in one phase. Where the condition of a transition is met, the next phase begins with the values just before it
    as values at 0-: those that do not fit its equations jump, with impulses, as its Jordan pairs say (Moysis et al., section 4).

    Args:
        phases: the systems by name, with the same coordinates.
        transitions: from phase to phase.
        start: the first phase; by default the first of ``phases``.

    Raises:
        InputError: phases with different coordinates, transitions between unknown phases or with unknown names.

    A mass on a spring meets a stop at x = 0.5 and stays there:

    >>> import mbconstrained as mb
    >>> free = mb.MechanicalSystem([[1.0]], stiffness=[[4.0]])
    >>> stopped = free.with_constraints(mb.Constraint([1.0], value=0.5, names="stop"))
    >>> machine = SwitchedSystem({"free": free, "stopped": stopped}, [Transition("free", "stopped", when={"x1": 1.0}, above=0.5)])
    >>> x = machine.solve(velocity=[2.0], end=3.0)
    >>> [(event.before, event.after, round(event.time, 6), round(event.impulses["stop"], 6)) for event in x.events]
    [('free', 'stopped', 0.261799, -1.732051)]
    """

    def __init__(self, phases: Mapping[str, MechanicalSystem], transitions: Sequence[Transition] = (), start: str | None = None):
        phases = dict(phases)
        if not phases:
            raise InputError("phases: found none; expected systems by name")
        first = next(iter(phases.values()))
        for name, system in phases.items():
            self._check_phase(name, system, first)
        start = next(iter(phases)) if start is None else start
        for name in [start, *(name for one in transitions for name in (one.source, one.target))]:
            if name not in phases:
                raise InputError(f'there is no phase "{name}"{nearest(str(name), phases)}; there are {", ".join(phases)}')
        guards: dict[str, list] = {name: [] for name in phases}
        changes = []
        for one in transitions:
            if one.at is not None:
                changes.append(TimedChange(one.at, one.target, (one.source,), f"to {one.target}"))
            else:
                guards[one.source].append(one.guard(phases[one.source]))
        ordered = [start, *(name for name in phases if name != start)]
        states = {name: SwitchState(guards=tuple(guards[name])) for name in ordered}
        switch = Switch("phase", states, sorted(changes, key=lambda change: change.time))
        self._set(Machine(phases[start], [switch], phases), phases, tuple(transitions))

    def _set(self, machine: Machine, phases, transitions) -> None:
        self.machine, self.phases, self.transitions = machine, phases, transitions
        self.system = machine.system

    @classmethod
    def of_switches(cls, system: MechanicalSystem, switches: Sequence[Switch]) -> SwitchedSystem:
        """The system of common equations and switches, whose phases are all combinations of the states of these.

        Args:
            system: the equations common to all phases.
            switches: the parts with several states.

        Returns:
            The switched system.
        """
        cls._check_phase(", ".join(switch.name for switch in switches), system, system)
        switched = cls.__new__(cls)
        switched._set(Machine(system, switches), {}, ())
        return switched

    @staticmethod
    def _check_phase(name: str, system, first) -> None:
        from ..equations import EquationsOfMotion

        if not isinstance(system, EquationsOfMotion):
            raise InputError(f'phase "{name}": found {type(system).__name__}; expected a MechanicalSystem')
        if system.is_sparse or system.delayed:
            what = "sparse matrices" if system.is_sparse else "delays"
            raise InputError(f'phase "{name}": {what} are not available in switched systems')
        if system.names != first.names:
            raise InputError(
                f'phase "{name}": its coordinates are {", ".join(system.names)}; expected {", ".join(first.names)} as in the first'
            )

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates."""
        return self.system.names

    @property
    def switches(self) -> tuple[Switch, ...]:
        """The parts with several states."""
        return self.machine.switches

    def phase(self, *states: str) -> MechanicalSystem:
        """The equations of one phase, for its modes and responses.

        Args:
            states: the name of the phase, or the states of all switches in their order.

        Raises:
            InputError: an unknown phase.
        """
        if len(states) != len(self.switches):
            raise InputError(
                f"phase: found {counted(len(states), 'state')}; expected one of each of {', '.join(one.name for one in self.switches)}"
            )
        for switch, state in zip(self.switches, states):
            if state not in switch.states:
                raise InputError(
                    f'{switch.name}: there is no state "{state}"{nearest(state, switch.states)}; there are {", ".join(switch.states)}'
                )
        system, branches = self.machine.system_of(states)
        loads = sum((branch.load for branch in branches), np.zeros(system.size))
        if loads.any():
            system = copy(system)
            system.static_force = system.static_force + loads
        return system

    def solve(
        self,
        displacement=None,
        velocity=None,
        force=None,
        *,
        end: float,
        penetration: bool = False,
        most_events: int = MOST_EVENTS,
    ) -> SwitchedMotion:
        """Solve for the motion through all phases up to a time.

        Every phase is solved in closed form by its Jordan pairs. It ends at the first zero of one of its guards, which is isolated by
        Bernstein coefficients of Taylor polynomials and refined to rounding errors: none is missed. Impacts follow Newton's law of
        restitution, those at one time all at once. Bounces that accumulate are summed where they are geometric.

        Args:
            displacement, velocity: x and x' at 0-, shape (n,), or by name.
            force: in addition to the system's own, as of ``MechanicalSystem.solve``.
            end: the last time, in s.
            penetration: whether contacts may be penetrated at the start; they close then, with a jump and impulses.
            most_events: more events end in an error.

        Returns:
            A ``SwitchedMotion`` with ``events``.

        Raises:
            InputError: a start in penetration, unknown names.
            NotUnique: more events than ``most_events``; states that alternate without end.
            SingularPolynomialMatrix: a phase whose motion is not unique; the text names its free coordinates.

        A ball dropped from 1 m bounces with e = 0.8 and comes to rest:

        >>> import mbconstrained as mb
        >>> model = mb.LumpedModel()
        >>> _ = model.mass("ball", 1.0), model.gravity(-9.81), model.contact("ground", "ball", restitution=0.8)
        >>> x = model.assemble().solve({"ball": 1.0}, end=5.0)
        >>> round(x.events[-1].time, 12), x.events[-1].after
        (4.063712768872, 'closed')
        """
        end = real_number(end, "end", positive=True)
        most = whole_number(most_events, "most_events", minimum=1)
        start = self.system._start(displacement, velocity)
        with within_float64():
            sequence = PhaseSequence(self.machine, self._source(force), end, most)
            sequence.run(self._first_key(*start), start[0], start[1], penetration)
            return self._motion(sequence, start, force)

    def _source(self, force) -> Source:
        """All that acts from outside in any phase."""
        self.system._refuse_loss_factors()
        return checked_source(self._systems, force)

    @property
    def _systems(self) -> tuple[MechanicalSystem, ...]:
        """The given systems: all phases, or the equations common to them."""
        return tuple(self.phases.values()) or (self.system,)

    def _first_key(self, x: np.ndarray, v: np.ndarray) -> Key:
        """The states of the switches at the start."""
        return tuple(switch.start(x, v) for switch in self.switches)

    def _motion(self, sequence: PhaseSequence, start: np.ndarray, force) -> SwitchedMotion:
        """The motion of a computed sequence of phases, from x and x' at 0-."""
        form = sequence.segments[0].phase.system.undelayed_form()
        applied = self.system._applied(force)
        problem = Problem(form.polynomial_matrix, start, form.force(applied))
        return SwitchedMotion(problem, SwitchedSolution(sequence, start), self.system, applied)

    def periodic(self, period: float | None = None, guess=None, force=None) -> PeriodicMotion:
        """Find a motion that repeats after a period, stable or not.

        Newton's method on the state z = (x, x') at the start of a period, P(z) = z (shooting). The Jacobian P' - I is the product of the
        transitions of all phases and the saltation matrices of all events; directions in which it is singular (free bodies, the time
        shift of a free motion) are left as they are. Under a force, which may be a record of one period, and with transitions at times,
        these are repeated in every period. Without them the period is unknown, too, and found with the state.

        Args:
            period: in s; by default that of the harmonic forces. Without a force a first approximation, by default from the motion after
                some time.
            guess: displacement and velocity near the periodic motion: a pair of arrays or of mappings by name, an array of shape
                (2, n), or a ``PeriodicMotion``. By default the state after some periods.
            force: in addition to the system's own, as of ``solve``.

        Returns:
            A ``PeriodicMotion``.

        Raises:
            InputError: a force that does not repeat after the period, a guess of another form.
            NotUnique: no convergence, with the last residual; a motion that repeats after several periods only.

        A mass meets a stop once in each period of the force:

        >>> import mbconstrained as mb
        >>> model = mb.LumpedModel()
        >>> _ = model.mass("cart", 1.0), model.spring("ground", "cart", stiffness=1.0), model.damper("ground", "cart", damping=0.1)
        >>> _ = model.contact("ground", "cart", gap=0.5, restitution=0.8, name="stop")
        >>> x = model.assemble().periodic(force=mb.harmonic([1.0], angular_frequency=1.5))
        >>> len(x.events), x.is_stable
        (1, True)
        """
        from .periodic import find_periodic

        return find_periodic(self, period, guess, force)

    def frequency_curve(
        self, force_pattern, frequencies_hz, start=None, *, periods: int = 1, most_points: int = 1000
    ) -> FrequencyCurve:
        """Follow a branch of periodic motions over the frequency of a harmonic force, around its folds, stable or not.

        Each point is a periodic motion as of ``periodic``; between them the branch is followed along its arc. Where a multiplier passes
        through +1 or -1, a pair leaves the unit circle, or the number of events changes, the frequency is located and reported.

        Args:
            force_pattern: amplitudes F of the force Re(F e^{i w t}), real or complex, shape (n,), or by name.
            frequencies_hz: of the force, in Hz: the first and the last, and any between at which points are wanted, too.
            start: a guess for the first, as of ``periodic``.
            periods: periods of the force in one of the motion, 2 for motions after a period doubling.
            most_points: the branch ends after so many.

        Returns:
            A ``FrequencyCurve``.

        Raises:
            InputError: frequencies that are not positive, a pattern with unknown names.
            NotUnique: no periodic motion at the first frequency.

        A vibration isolator with an elastic stop:

        >>> import mbconstrained as mb
        >>> model = mb.LumpedModel()
        >>> _ = model.mass("m", 1.0), model.spring("ground", "m", stiffness=1.0), model.damper("ground", "m", damping=0.1)
        >>> _ = model.contact("ground", "m", gap=1.0, stiffness=4.0)
        >>> curve = model.assemble().frequency_curve({"m": 0.3}, [0.17, 0.2])
        >>> curve.bifurcations[0]
        Bifurcation(at 0.19654029 Hz: the branch turns: a multiplier is 1)
        """
        from .frequency_curve import follow

        return follow(self, force_pattern, frequencies_hz, start, periods, most_points)

    def _lacks(self, name: str) -> str:
        from ..system import MechanicalSystem

        if not hasattr(MechanicalSystem, name):
            return super()._lacks(name)
        states = ", ".join(repr(next(iter(switch.states))) for switch in self.switches)
        return (
            f"a switched system has no {name}: its equations change. Take those of one phase, such as system.phase({states}).{name}"
        )

    def _summary(self) -> str:
        if self.phases:
            return f"{counted(len(self.names), 'coordinate')}, {counted(len(self.phases), 'phase')}, {counted(len(self.transitions), 'transition')}"
        return f"{counted(len(self.names), 'coordinate')}, {counted(len(self.switches), 'switch', 'switches')}"

    def _tables(self) -> tuple[TextTable, ...]:
        if self.phases:
            rows = ((one.source, one.target, _condition(one)) for one in self.transitions)
            return (TextTable("Transitions", ("from", "to", "when"), tuple(rows)),)
        return (TextTable("Switches", ("name", "states"), tuple((one.name, ", ".join(one.states)) for one in self.switches)),)


def _condition(one: Transition) -> str:
    if one.at is not None:
        return f"t = {one.at:g} s"
    terms = " + ".join(f"{factor:g} {name}" for name, factor in (one.when or {}).items())
    side, limit = ("above", one.above) if one.above is not None else ("below", one.below)
    return f"{terms} {side} {limit:g}"
