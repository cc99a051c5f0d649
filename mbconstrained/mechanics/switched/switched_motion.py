"""The motion of a switched system: one function of time through all phases, with its events and their sensitivities."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ...ground.by_name import Public
from ...ground.checks import counted
from ...ground.display import TextTable, notice_table, with_unit
from ...ground.errors import InputError
from ...ground.notices import Evidence, Notice, NoticeKind, distinct
from ...ground.tolerances import EPS, TRUST_LIMIT
from ...ground.units import force_unit, impulse_unit
from ...linalg.exponential import block_states
from ...response.choose import Method
from ...response.events import Event
from ...signals.bohl import BohlFunction, FreeRestarts, Restarts
from ...signals.impulsive import ImpulsiveLoad
from ..constraints import ConstraintRow, constraint_rows
from ..energy import Energy, energy_of
from ..motion import Motion, Quantity, _order_of, _sentences, _static_offsets
from .flow import NOISE
from .phase import STILL, Phase
from .sequence import PhaseSegment, PhaseSequence, SwitchRecord
from .switches import SwitchState

if TYPE_CHECKING:
    from ...response.methods.defect import Rounding
    from .switches import Guard

#: The method that reports and plans name.
SWITCHED = Method("switched", "phase by phase by the Jordan pairs of each, switched at the zeros of its guards")

#: Rounding errors of the states of a phase, in units of EPS: at once, and by radian of the fastest rate.
OWN_NOISE, NOISE_BY_RADIAN = 8.0, 1.0

#: Estimates are so many standard deviations.
DEVIATIONS = 3.0

#: Times at which errors are estimated.
ESTIMATED = 64

#: Events that are reported in a sentence each.
REPORTED = 6


@dataclass(frozen=True, eq=False)
class SwitchEvent(Public):
    """A switch from one phase to the next, or an impact within a phase.

    Attributes:
        time: in s.
        before, after: the phases.
        jump: of x and x', shape (2, n); zero where they are continuous.
        impulses: of contacts and constraint rows by name, in N s or N m s; those that follow from a jump of the displacement are left out.
        higher_impulses: factors of derivatives of Dirac's delta by name, (N s^2, ...).
        coordinate_impulses: arrays (n,), the k-th multiplies the k-th derivative of Dirac's delta in x.
        energy_before, energy_after: kinetic, strain and static energy, J.
        momentum_residual: |M jump of x' + C jump of x - sum of the impulses| relative to the largest momentum.
        grazing: whether a guard only touches zero.
        rest_time: where infinitely many bounces end, the time at which they do, s; None elsewhere.
        text: what happens.
    """

    time: float
    before: str
    after: str
    jump: np.ndarray
    impulses: Mapping[str, float]
    higher_impulses: Mapping[str, tuple[float, ...]]
    coordinate_impulses: tuple[np.ndarray, ...]
    energy_before: float
    energy_after: float
    momentum_residual: float
    grazing: bool
    rest_time: float | None
    text: str
    _place: int = field(repr=False)
    _motion: SwitchedMotion = field(repr=False)

    @property
    def energy_lost(self) -> float:
        """The energy before less that after, J."""
        return self.energy_before - self.energy_after

    def to_dict(self) -> dict[str, Any]:
        """The event as plain data, numbers in SI."""
        named = ("time", "time_error", "before", "after", "text", "jump", "impulses", "higher_impulses", "coordinate_impulses")
        energies = ("energy_before", "energy_after", "energy_lost", "momentum_residual", "grazing", "rest_time")
        return {name: getattr(self, name) for name in (*named, *energies)}

    @property
    def time_error(self) -> float:
        """Estimate of the error of the time, s; infinite where all digits are lost."""
        return float(self._motion._time_errors[self._place])


class PhaseRestarts(FreeRestarts):
    """The states at the begin of each phase, up to the end of the motion."""

    end: float

    def __init__(self, knots: np.ndarray, states: np.ndarray, remainders: np.ndarray | float, blocks, end: float):
        super().__init__(knots, states, remainders, blocks)
        self.__dict__["end"] = end

    def located(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Index of the phase of each time (T,), and the time since its begin."""
        if len(times) and times.max() > self.end:
            raise InputError(f"times: found {times.max():g} s; the motion is known up to {self.end:g} s: give solve() a later end")
        return super().located(times)


class SwitchedSolution:
    """The solution of a switched system, as the methods of a ``Response`` read it."""

    def __init__(self, sequence: PhaseSequence, initial: np.ndarray):
        self.method, self.sequence = SWITCHED, sequence
        used = {segment.phase for segment in sequence.segments}
        self.phases = [phase for phase in sequence.phases.values() if phase in used]
        first = sequence.segments[0]
        begin = np.array([first.phase.C @ first.state, first.phase.V @ first.state])
        self.jump = first.phase.start_jump(initial, first.state)
        self.impulses = next((record.coordinate_impulses for record in sequence.records if not record.time), ())
        values = np.array([initial, begin, *(pair for one in sequence.records for pair in zip(one.x, one.v))])
        self._noise = STILL * np.abs(values).max(axis=(0, 2), initial=0.0)
        self.events = tuple(Event(one.time, self.jump_of(one), one.coordinate_impulses) for one in sequence.records if one.time > 0)

    def jump_of(self, record: SwitchRecord) -> np.ndarray:
        """The jumps of x and x' at an event, zero within rounding errors of the largest values of the motion, shape (2, n)."""
        jump = np.array([record.x[1] - record.x[0], record.v[1] - record.v[0]])
        for row, size, noise in zip(jump, record.size, self._noise):
            row[np.abs(row) <= max(noise, STILL * size.max(initial=0.0))] = 0.0
        return jump

    finite_count = property(lambda self: max(len(phase.J) for phase in self.phases))
    coupling = property(lambda self: max(phase.pairs.finite.coupling for phase in self.phases))
    is_precise = dropped_near_bound = False
    has_clear_ranks, as_written = True, None

    @cached_property
    def blocks(self) -> tuple[np.ndarray, ...]:
        """The blocks of all phases."""
        return tuple(block for phase in self.phases for block in phase.blocks)

    @cached_property
    def restarts(self) -> Restarts:
        """The states of all phases at the begin of each; those of phases that do not last are zero."""
        segments, ends = self.sequence.lasting, np.cumsum([len(phase.J) for phase in self.phases])
        states = np.zeros((ends[-1], len(segments)))
        for column, segment in enumerate(segments):
            end = ends[self.phases.index(segment.phase)]
            states[end - len(segment.state) : end, column] = segment.state
        knots, remainders = np.array([one.time for one in segments], float), np.array([one.remainder for one in segments])
        return PhaseRestarts(knots, states, remainders if remainders.any() else 0.0, self.blocks, self.sequence.end)

    def function_of(self, rows: Sequence[np.ndarray]) -> BohlFunction:
        """The function with these rows on the states of each phase."""
        return BohlFunction(np.hstack(list(rows)), self.blocks, self.restarts)

    @cached_property
    def function(self) -> BohlFunction:
        """x(t)."""
        return self.function_of([phase.C for phase in self.phases])

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """Residual and decoupling of the phases, the worst of each."""
        worst: dict[str, Evidence] = {}
        for phase in self.phases:
            for item in phase.pairs.evidence:
                own = worst.get(item.name)
                is_gap = item.name == "rank gap"
                if own is None or (item.value < own.value if is_gap else item.value > own.value):
                    worst[item.name] = item
        return tuple(worst.values())

    @property
    def notices(self) -> tuple[Notice, ...]:
        return distinct(*(phase.notices for phase in self.phases))


@dataclass(frozen=True, repr=False, eq=False)
class SwitchedMotion(Motion):
    """x(t) of a switched system through all its phases, a ``Motion`` with ``events``.

    ``x(t)`` is the regular part; at the time of an event it is the value just after it. The error estimate carries the error of each phase
    through the sensitivities of the times of events (saltation matrices) to the next.

    Attributes:
        system: the equations common to all phases, or those of the first.
    """

    solution: SwitchedSolution  # type: ignore[assignment]

    _unproved = "phases that follow each other: errors are estimated"

    # Events.

    @cached_property
    def events(self) -> tuple[SwitchEvent, ...]:  # type: ignore[override]
        """All switches and impacts, by time."""
        return tuple(self._event(place, record) for place, record in enumerate(self.solution.sequence.records))

    @property
    def _later_events(self) -> tuple[Event, ...]:
        return self.solution.events

    @property
    def end(self) -> float:
        """The time up to which the motion is computed, s."""
        return self.solution.sequence.end

    @property
    def phases(self) -> tuple[tuple[float, str], ...]:
        """The times at which phases begin, in s, and the phases."""
        collected: list[tuple[float, str]] = []
        for segment in self.solution.sequence.lasting:
            if not collected or collected[-1][1] != segment.phase.name:
                collected.append((float(segment.time), segment.phase.name))
        return tuple(collected)

    def _event(self, place: int, record: SwitchRecord) -> SwitchEvent:
        machine = self.solution.sequence.machine
        impulses = {name: sizes[0] for name, sizes in record.impulses.items() if sizes and sizes[0]}
        jump = self.solution.jump_of(record)
        moves = jump[0].any() or record.coordinate_impulses  # without, what a contact adds to its gap is a rounding error
        higher = {name: tuple(sizes[1:]) for name, sizes in record.impulses.items() if moves and any(sizes[1:])}
        return SwitchEvent(
            time=float(record.time if record.resting is None else record.resting),
            before=machine.label(record.before),
            after=machine.label(record.after),
            jump=jump,
            impulses=impulses,
            higher_impulses=higher,
            coordinate_impulses=record.coordinate_impulses,
            energy_before=record.phases[0].energy(record.x[0], record.v[0]),
            energy_after=record.phases[1].energy(record.x[1], record.v[1]),
            momentum_residual=self._momentum_residual(record),
            grazing=record.grazing,
            rest_time=None if record.resting is None else float(record.resting),
            text="; ".join(dict.fromkeys(record.texts)) or _text_of(record),
            _place=place,
            _motion=self,
        )

    def _momentum_residual(self, record: SwitchRecord) -> float:
        """The residual of the balance of momentum at an event with Dirac impulses alone; 0 at others."""
        rows, sizes = self.impulse_rows, record.impulses.values()
        if not sizes or any(any(one[1:]) for one in sizes) or record.coordinate_impulses or not set(record.impulses) <= set(rows):
            return 0.0
        system = record.phases[1].system
        terms = [system.mass @ (record.v[1] - record.v[0]), system.damping @ (record.x[1] - record.x[0])]
        terms += [-rows[name] * sizes[0] for name, sizes in record.impulses.items()]
        noisy = [*(system.mass @ v for v in record.v), *terms, np.abs(system.mass) @ record.terms[1]]
        largest = max(float(np.abs(size).max(initial=0.0)) for size in noisy)
        return float(np.abs(sum(terms)).max(initial=0.0)) / largest if largest else 0.0

    def event_table(self, text: Callable[[float, str], str] = with_unit, most: int | None = None) -> TextTable:
        """The events with their times, phases, impulses and energies.

        Args:
            text: makes a text of a value and its SI unit.
            most: the number of events that are listed, the first ones; None for all.

        Returns:
            The table.
        """
        rows = []
        for event, record in zip(self.events[:most], self.solution.sequence.records):
            named = f"{event.text.removesuffix(' impact')} "
            impulses = ", ".join(own.removeprefix(named) for own in self.impulse_texts(event, text))
            lost = text(self.lost_energy(event), "J") if self.lost_energy(event) else ""
            states = ", ".join(state for old, state in zip(record.before, record.after) if state != old)
            rows.append((f"{event.time:.9g}", f"{event.time_error:.1g}", event.text, states, impulses, lost))
        columns = ("t (s)", "error (s)", "what", "next state", "impulses", "energy lost")
        shown = [place for place in range(len(columns)) if place < 3 or any(row[place] for row in rows)]
        note = f"The first {len(rows)} of {len(self.events)} are shown." if len(rows) < len(self.events) else ""
        cells = tuple(tuple(row[place] for place in shown) for row in rows)
        return TextTable(
            "Events", tuple(columns[i] for i in shown), cells, note, times=tuple(one.time for one in self.events[:most])
        )

    def lost_energy(self, event: SwitchEvent) -> float:
        """The energy lost at an event, zero within rounding errors of the largest energy at an event.

        Args:
            event: one of the events.

        Returns:
            The energy before less that after, J.
        """
        return event.energy_lost if self.has_energy and abs(event.energy_lost) > STILL * self._largest_energy else 0.0

    @cached_property
    def has_energy(self) -> bool:
        """Whether the matrices of all phases are symmetric, so that the system has an energy."""
        systems = [phase.system for phase in self.solution.phases]
        return not any(list(system.unsymmetric(name)) for system in systems for name in ("mass", "stiffness"))

    @cached_property
    def _largest_energy(self) -> float:
        return max(max(abs(event.energy_before), abs(event.energy_after)) for event in self.events)

    def impulse_texts(self, event: SwitchEvent, text: Callable[[float, str], str]) -> list[str]:
        """The impulses of an event by name, with the factors of derivatives of Dirac's delta.

        Args:
            event: one of the events.
            text: makes a text of a value and its SI unit.

        Returns:
            A text for each.
        """
        units, collected = self._force_units, []
        for name in dict.fromkeys((*event.impulses, *event.higher_impulses)):
            sizes = (event.impulses.get(name, 0.0), *event.higher_impulses.get(name, ()))
            collected += [f"{name} {text(size, impulse_unit(units[name], k))}" for k, size in enumerate(sizes) if size]
        return collected

    # Rows of all phases.

    @property
    def _has_common_equations(self) -> bool:  # type: ignore[override]  # of other motions it is no property
        return self.solution.sequence.machine.systems is None

    @cached_property
    def _reaction_rows(self) -> tuple[ConstraintRow, ...]:
        """The constraint rows of all phases, and the directions of forces of switches, such as elastic contacts, each once by name."""
        rows: dict[str, ConstraintRow] = {}
        switches = self.solution.sequence.machine.switches
        possible = [constraint_rows(state.rows, self.system.units) for switch in switches for state in switch.states.values()]
        for row in (row for several in (*(phase.system.rows for phase in self.solution.phases), *possible) for row in several):
            rows.setdefault(row.name, row)
        for switch, branch in ((one, own) for one in switches for state in one.states.values() for own in state.branches):
            rows.setdefault(switch.name, ConstraintRow(switch.name, branch.direction, "position", 0.0, switch.unit))
        return tuple(rows.values())

    @cached_property
    def impulse_rows(self) -> dict[str, np.ndarray]:
        """The directions of the impulses of contacts and constraint rows over the coordinates, by name."""
        machine = self.solution.sequence.machine
        rows = {row.name: row.coefficients for system in (machine.systems or {}).values() for row in system.rows}
        rows |= {switch.name: switch.contact.row for switch in machine.switches if switch.contact is not None}
        return rows | {row.name: row.coefficients for row in self._reaction_rows}

    @cached_property
    def engagements(self) -> dict[str, tuple[tuple[float, int], ...]]:
        """The times at which each switch changes, in s, with its engagement: 0 without force, 1 slipping, 2 closed, stuck or taut."""
        sequence, collected = self.solution.sequence, {}
        for place, switch in enumerate(sequence.machine.switches):
            levels: list[tuple[float, int]] = []
            for segment in sequence.lasting:
                level = _engagement(switch.states[segment.phase.key[place]])
                if not levels or levels[-1][1] != level:
                    levels.append((float(segment.time), level))
            collected[switch.name] = tuple(levels)
        return collected

    @property
    def _constraint_rows(self) -> tuple[ConstraintRow, ...]:
        """The constraint rows of the phases of the motion."""
        names = {row.name for phase in self.solution.phases for row in phase.system.rows}
        return tuple(row for row in self._reaction_rows if row.name in names)

    @property
    def _force_units(self) -> dict[str, str]:
        switches = {switch.name: force_unit(switch.unit) for switch in self.solution.sequence.machine.switches}
        rows = {row.name: force_unit(row.unit) for row in self._reaction_rows}
        return defaultdict(lambda: "N", {**switches, **rows})

    @cached_property
    def reaction_function(self) -> BohlFunction:
        """The multipliers of all rows and the forces of switches along theirs, zero while they are not part of the equations."""
        return self.solution.function_of([self._reactions(phase) for phase in self.solution.phases])

    def _reactions(self, phase: Phase) -> np.ndarray:
        """The rows of all reactions on the states of a phase, shape (k, N)."""
        machine, one = self.solution.sequence.machine, phase.source.coefficients[-1] @ phase.of_force
        rows = {row.name: phase.reaction_row(row.name) for row in self._reaction_rows}
        for switch, state in zip(machine.switches, phase.key):
            for branch in switch.states[state].branches:
                elastic = branch.stiffness * (branch.rest * one - branch.direction @ phase.C)
                force = branch.constant * one + elastic - branch.damping * (branch.direction @ phase.V)
                rows[switch.name] = rows[switch.name] + force
        return np.array(list(rows.values())).reshape(-1, len(phase.J))

    @cached_property
    def _constraint_loads(self) -> tuple[ImpulsiveLoad, ...]:
        names = [row.name for row in self._reaction_rows]
        loads = []
        for record in self.solution.sequence.records:
            count = max((len(sizes) for name, sizes in record.impulses.items() if name in names), default=0)
            arrays = tuple(
                np.array([(record.impulses.get(name, []) + [0.0] * count)[order] for name in names]) for order in range(count)
            )
            if arrays:
                loads.append(ImpulsiveLoad(float(record.time), arrays))
        return tuple(loads)

    def _start_arrays(self) -> dict[str, np.ndarray]:
        """The arrays of all motions, and of the events after t = 0 their errors, phases and lost energies."""
        later = [event for event in self.events if event.time > 0]
        names, times = np.array([name for _, name in self.phases]), np.array([time for time, _ in self.phases])
        of_events = {
            "event_times": np.array([event.time for event in later]),
            "event_time_errors": np.array([event.time_error for event in later]),
            "event_phases_before": np.array([event.before for event in later]),
            "event_phases_after": np.array([event.after for event in later]),
            "event_energies_lost": np.array([event.energy_lost for event in later]),
        }
        return {**super()._start_arrays(), **(of_events if later else {}), "phase_times": times, "phases": names}

    # Energy.

    def energy(self, times) -> Energy:
        """Kinetic, strain and static energy, those of the elements of each phase included, in J.

        The springs of contacts and of other elements with several states have strain energy, none while they do not act.
        """
        times = np.asarray(times, dtype=float)
        flat = np.atleast_1d(times)
        x, v = self.displacement(flat), self.velocity(flat)
        parts = np.zeros((3, len(flat)))
        for phase, chosen in self._by_phase(flat):
            own = energy_of(phase.system.given, phase.potential_force, x[:, chosen], v[:, chosen])
            moved = (phase.potential_force - phase.system.static_force) @ x[:, chosen]
            parts[:, chosen] = own.kinetic, own.strain + phase.offset - moved, own.static + moved
        return Energy(*(part if times.ndim else part[0] for part in parts))

    def _by_phase(self, times: np.ndarray) -> list[tuple[Phase, np.ndarray]]:
        segments = self.solution.sequence.lasting
        place = np.searchsorted([segment.time for segment in segments], times, side="right") - 1
        return [
            (phase, chosen)
            for phase in self.solution.phases
            if len(chosen := np.flatnonzero([segments[i].phase is phase for i in place]))
        ]

    # Sensitivities.

    def transition_matrix(self) -> np.ndarray:
        """The derivative of (x, x') at the end with respect to those at 0-, the force unchanged.

        The product of the transition matrices of all phases and the saltation matrices of all events (Leine and Nijmeijer, Dynamics and
        Bifurcations of Non-Smooth Mechanical Systems, 2004, section 7.4). Over one period of a periodic motion its eigenvalues are the
        Floquet multipliers.

        Returns:
            Shape (2 n, 2 n); it does not exist where an event only touches its guard.

        A ball that falls for 0.2 s and bounces elastically; after the same time it is back:

        >>> import mbconstrained as mb
        >>> model = mb.LumpedModel()
        >>> _ = model.mass("ball", 1.0), model.gravity(-10.0), model.contact("ground", "ball", gap=0.2, restitution=1.0)
        >>> x = model.assemble().solve(end=0.4)
        >>> x.transition_matrix().round(9).tolist()
        [[1.0, 0.0], [10.0, 1.0]]
        """
        return transition_matrix(self.solution.sequence)

    # Errors.

    @cached_property
    def _propagated(self) -> tuple[list[np.ndarray], np.ndarray]:
        """Covariances of the errors of (x, x') at the begin of segments, and errors of the times of events."""
        sequence, n = self.solution.sequence, self.system.size
        first = sequence.segments[0]
        P = np.diag((OWN_NOISE * EPS * _sizes(first, first.state)) ** 2)
        covariances, times = [P], {}
        with np.errstate(over="ignore", invalid="ignore"):
            for previous, segment in zip(sequence.segments, sequence.segments[1:]):
                F, y = _transition(previous)
                S, along, own_along = _saltation(previous, segment, F, y)
                radians = float(previous.phase.flow.rates.max(initial=0.0)) * previous.duration
                noise = EPS * (OWN_NOISE + NOISE_BY_RADIAN * radians) * _sizes(previous, y)
                own = segment.jump @ (_without_guard(segment, n) * noise)
                if along is not None and own_along is not None:
                    # a guard is searched by what its value gains in the phase: a short flight has errors of its own size
                    gained = np.concatenate([noise[n:] * previous.duration, noise[n:]])
                    gained = own_along * np.minimum(noise, gained)
                    times[id(segment.event)] = float(np.sqrt(max(along @ P @ along + gained @ gained, 0.0)))
                    change = _change_of_rate(previous, segment, y) * (not segment.event.grazing)
                    own = np.hstack([own, np.outer(change, gained)])
                P = np.nan_to_num(S @ P @ S.T + own @ own.T, nan=np.inf, posinf=np.inf)
                covariances.append(P)
        errors = [DEVIATIONS * times.get(id(record), 0.0) + EPS * record.time for record in sequence.records]
        return covariances, np.nan_to_num(np.array(errors), nan=np.inf)

    @property
    def _time_errors(self) -> np.ndarray:
        return self._propagated[1]

    def error_estimate(self, times, of: Quantity = "displacement", *, order: int = 0) -> float:
        """Return an estimate of max |error| / max |value| over the times.

        The covariance of rounding errors is carried through all phases and events; at most 64 of the times are looked at.

        Args:
            times: in s, a number or shape (T,).
            of: the quantity.
            order: order of a derivative of it, if any.

        Returns:
            A number without unit; infinite where the error may be as large as the answer.
        """
        own = _order_of(of)
        function = self.reaction_function if own is None else self.function
        total = order + (own or 0)
        function = function.derivative(total) if total else function
        flat = np.unique(np.atleast_1d(np.asarray(times, dtype=float)))
        flat = flat[np.linspace(0, len(flat) - 1, min(len(flat), ESTIMATED)).astype(int)]
        largest = float(np.abs(function(flat)).max(initial=0.0))
        segments = self.solution.sequence.segments
        begins = np.array([segment.time for segment in segments])
        worst = 0.0
        with np.errstate(over="ignore", invalid="ignore"):
            for time in flat:
                place = int(np.searchsorted(begins, time, side="right")) - 1
                worst = max(worst, self._error_at(segments[place], self._propagated[0][place], float(time), own, total))
        if not worst or largest == 0:
            return 0.0 if not worst else np.inf
        return float(worst / largest) if np.isfinite(worst) else np.inf

    def _error_at(self, segment: PhaseSegment, P: np.ndarray, time: float, own: int | None, order: int) -> float:
        phase, n = segment.phase, self.system.size
        since = max(time - segment.time - segment.remainder, 0.0)
        rows = self._reactions(phase) if own is None else phase.C
        for _ in range(order):
            rows = rows @ phase.J
        if not len(rows):
            return 0.0
        moved = block_states(phase.blocks, phase.begin, np.full(2 * n, since))
        y = phase.flow.states(segment.state, since)
        A = rows @ moved
        radians = float(phase.flow.rates.max(initial=0.0)) * since
        noise = EPS * (OWN_NOISE + NOISE_BY_RADIAN * radians) * (np.abs(rows) @ np.abs(y))
        variance = np.einsum("ij,jk,ik->i", A, P, A) + noise**2
        return DEVIATIONS * float(np.sqrt(np.nan_to_num(variance, nan=np.inf).max(initial=0.0)))

    # Notices.

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """Evidence of the phases, the number of events and the largest error of their times."""
        worst = float(self._time_errors.max(initial=0.0))
        own = (
            Evidence("events", len(self.events), "switches and impacts"),
            Evidence("time of events", worst, "estimate of the largest error of the time of an event, s"),
            Evidence(
                "momentum",
                max((event.momentum_residual for event in self.events), default=0.0),
                "largest residual of the balance of momentum at an event, relative to the largest momentum",
            ),
        )
        return (*self.solution.evidence, *own)

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Events, doubtful decisions of the phases, and the event after which digits are lost."""
        return (*self._equation_notices, *self.system.range_notices(self))

    @cached_property
    def _equation_notices(self) -> tuple[Notice, ...]:
        return distinct(
            self._start_notices,
            self._event_notices,
            self._lost_digits,
            self.solution.sequence.notices,
            self.solution.notices,
            self.force.notices,
        )

    @property
    def _start_notices(self) -> tuple[Notice, ...]:
        """The jumps and impulses of coordinates at t = 0, and constant forces."""
        return (
            *_sentences(self, Event(0.0, self.jump, self.impulses)),
            *_static_offsets(self.system),
            *self.system.damping_notices(),
        )

    @property
    def _event_notices(self) -> tuple[Notice, ...]:
        notices = []
        for event in self.events[:REPORTED]:
            kind = (
                NoticeKind.IMPULSE
                if event.impulses or event.higher_impulses
                else NoticeKind.JUMP
                if event.jump.any()
                else NoticeKind.SWITCH
            )
            sizes = ", ".join(self.impulse_texts(event, with_unit))
            impulses = f"; impulses: {sizes}" if sizes else ""
            rest = "" if event.rest_time is None else ", after infinitely many bounces"
            notices.append(Notice(kind, f"t = {event.time:.9g} s: {event.text}{rest}{impulses}"))
        if len(self.events) > REPORTED:
            notices.append(
                Notice(
                    NoticeKind.SWITCH,
                    f"there are {counted(len(self.events), 'event')} in all, the last at t = {self.events[-1].time:.9g} s",
                )
            )
        return tuple(notices)

    @property
    def _lost_digits(self) -> tuple[Notice, ...]:
        """A notice where the errors of event times, relative to the time between events, leave no digits."""
        errors, last = self._time_errors, 0.0
        for number, (record, error) in enumerate(zip(self.solution.sequence.records, errors)):
            gap = max(record.time - last, EPS * record.time)
            if error > TRUST_LIMIT * gap and error > TRUST_LIMIT * EPS**0.5 * record.time:
                text = f"from event {number + 1} at t = {record.time:.6g} s on the motion has lost its digits: small errors grow from event to event"
                return (Notice(NoticeKind.ACCURACY, text, doubtful=True),)
            last = record.time
        return ()

    def _rounding(self) -> Rounding | None:
        return None

    def _summary(self) -> str:
        names = ", ".join(self.names)
        return f"{counted(len(self.names), 'coordinate')}: {names}; {counted(len(self.events), 'event')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return self.event_table(), notice_table(self.notices)

    def enclose(self, times, digits: int = 15, *, of: Quantity = "displacement", order: int = 0):
        """Not available: intervals are not carried through events.

        Args:
            times, digits, of, order: as of ``Motion.enclose``.

        Raises:
            InputError: always.
        """
        raise InputError(
            "enclose: not available for switched systems, whose errors are estimated (error_estimate, time_error of events)"
        )


def _engagement(state: SwitchState) -> int:
    """The engagement of a switch in a state: friction that slips has a force without energy."""
    if state.rows:
        return 2
    return 1 if any(branch.stored is None for branch in state.branches) else 2 * bool(state.branches)


def _text_of(record: SwitchRecord) -> str:
    """The text of an event at which no switch changes."""
    return "a guard touches zero" if record.grazing else "the load jumps" if record.time else "the start jumps"


def transition_matrix(sequence: PhaseSequence) -> np.ndarray:
    """The derivative of (x, x') at the end of a sequence with respect to those at 0-."""
    with np.errstate(over="ignore", invalid="ignore"):
        total = sequence.segments[0].jump
        waiting: list[tuple[float, Guard, np.ndarray]] = []
        for previous, segment in pairwise(sequence.segments):
            F, y = _transition(previous)
            F, total = F @ total, _saltation(previous, segment, F, y)[0] @ total
            waiting += _begun_dwells(previous, segment, F, y)
            if segment.event is not None and segment.event.guard is None and segment.event.before != segment.event.after:
                for time, guard, along in waiting:
                    if abs(time + guard.dwell - segment.time) <= NOISE * segment.time and guard.target in segment.event.after:
                        total = total + np.outer(_change_of_rate(previous, segment, y), along)
                        break
        last = sequence.segments[-1]
        return last.phase.outputs @ (_transition(last)[0] @ total)


def _begun_dwells(previous: PhaseSegment, segment: PhaseSegment, F: np.ndarray, y: np.ndarray):
    """The time, the guard and the derivative of the time of each guard with a dwell that may fall to zero at the end of a segment."""
    flow = previous.phase.flow
    for guard, row in zip(previous.phase.guards, flow.rows):
        rate = float(row @ (previous.phase.J @ y))
        if guard.dwell and not guard.is_opposite and rate < 0:
            yield segment.time, guard, -(row @ F) / rate


def _sizes(segment: PhaseSegment, y: np.ndarray) -> np.ndarray:
    """The sums of moduli that x and x' are made of, shape (2 n,)."""
    phase = segment.phase
    size = np.maximum(np.abs(y), np.abs(segment.state))
    return np.concatenate([phase.C_size @ size, phase.V_size @ size])


def _transition(segment: PhaseSegment) -> tuple[np.ndarray, np.ndarray]:
    """The derivative of the states at the end of a segment with respect to (x, x') at its begin, and the states there."""
    phase, n = segment.phase, segment.phase.system.size
    moved = block_states(phase.blocks, phase.begin, np.full(2 * n, segment.duration))
    return moved, phase.flow.states(segment.state, segment.duration)


def _without_guard(segment: PhaseSegment, n: int) -> np.ndarray:
    """I without the direction of a displacement that was zero at a switch: its rounding error is not carried on."""
    unit, guard = np.eye(2 * n), None if segment.event is None else segment.event.guard
    if guard is not None and guard.functional[0] == "displacement":
        d = guard.displacement
        unit[:n, :n] -= np.outer(d, d) / (d @ d)
    return unit


def _saltation(
    previous: PhaseSegment, segment: PhaseSegment, F: np.ndarray, y: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None, np.ndarray | None]:
    """The derivative of (x, x') at the begin of a segment with respect to those at the begin of the previous, and of the time of the event.

    With the guard g and its rate: S = D F - (z+' - D z-') dt, dt = -dg / g' (saltation matrix; Leine and Nijmeijer, Dynamics and Bifurcations
    of Non-Smooth Mechanical Systems, 2004, section 7.4). Then that of the time with respect to (x, x') at the end of the previous.
    """
    phase, D = previous.phase, segment.jump
    moved, record = D @ (phase.outputs @ F), segment.event
    if record is None or record.guard_row is None:
        return moved, None, None
    row = record.guard_row @ phase.J if record.grazing else record.guard_row  # grazing is the minimum of a guard
    rate = float(row @ (phase.J @ y))
    if rate == 0:
        unknown = np.full(F.shape[1], np.inf)
        return moved, unknown, unknown
    along, own_along = -(row @ F) / rate, -(row @ phase.begin) / rate
    if record.grazing:  # nothing changes there
        return moved, along, own_along
    change = _change_of_rate(previous, segment, y)
    return moved + np.outer(change, along), along, own_along


def _change_of_rate(previous: PhaseSegment, segment: PhaseSegment, y: np.ndarray) -> np.ndarray:
    """D z-' - z+', by which a later switch changes z."""
    before, after = previous.phase, segment.phase
    rate = before.outputs @ (before.J @ y)
    return segment.jump @ rate - after.outputs @ (after.J @ segment.state)
