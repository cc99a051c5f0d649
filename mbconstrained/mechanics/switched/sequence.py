"""The motion through all phases, one after another: each in closed form, each switch at the first zero of a guard.

At a switch the states that the switches take are found by trial: a state whose guard is negative just after the switch is left for the
one that follows it, until no guard is. Rigid contacts that touch have their impulses by Newton's law all at once (``phase``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from itertools import combinations, islice, product
from typing import TYPE_CHECKING

import numpy as np

from ...ground.errors import InputError, NotUnique
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS
from ..constraints import Constraint
from .flow import NOISE, Crossing
from .phase import STILL, ContactSet, Phase, PhaseEntry, Source, row_impulses
from .switches import ForceBranch, Functional, Guard, Switch, TimedChange, UnilateralContact

if TYPE_CHECKING:
    from ..system import MechanicalSystem

Key = tuple[str, ...]

#: Most switches within one motion by default.
MOST_EVENTS = 10_000

#: Trials of states at one time, impacts at one time before they are taken without rebound, and combinations of states in a search.
TRIALS, REPEATED, COMBINATIONS = 64, 24, 256

#: Bounces are summed once the velocity after one is this part of the largest impact, if their sum is geometric to rounding errors.
SMALL_BOUNCE = EPS**0.5


@dataclass(eq=False)
class PhaseSegment:
    """One phase between two times."""

    phase: Phase
    time: float  # of the begin, s
    remainder: float  # its rounding error
    state: np.ndarray  # y there
    maps: Sequence[Callable[[], np.ndarray]]  # derivatives of (x, x') after each step of the switch with respect to those before it
    duration: float = 0.0  # s
    event: SwitchRecord | None = None  # the switch at the begin, where there is one

    @cached_property
    def jump(self) -> np.ndarray:
        """The derivative of (x, x') at the begin with respect to those before the switch, shape (2 n, 2 n)."""
        first, *others = self.maps
        return reduce(lambda total, one: one() @ total, others, first())


@dataclass(eq=False)
class SwitchRecord:
    """A switch, while the phase that follows is searched and afterwards."""

    time: float  # in s
    remainder: float  # its rounding error
    before: Key
    after: Key
    x: list[np.ndarray]  # displacement before and after
    v: list[np.ndarray]  # velocity before and after
    terms: tuple[np.ndarray, np.ndarray]  # sums of the moduli of the terms of x and v before
    force: np.ndarray  # the states of the force after it
    loads: Sequence[np.ndarray] = ()  # impulses of the force that are still to act
    # how many derivatives of outputs, the value among them, are exactly zero, whatever their rounding errors
    zeros: dict[Functional, int] = field(default_factory=dict)
    impulses: dict[str, list[float]] = field(default_factory=dict)  # by name, by order
    coordinate_impulses: tuple[np.ndarray, ...] = ()  # of x, by order
    guard: Guard | None = None  # that fell to zero
    guard_row: np.ndarray | None = None  # its row on the states before
    phases: tuple[Phase, ...] = ()  # before and after
    grazing: bool = False  # whether the guard only touches zero
    resting: float | None = None  # where infinitely many bounces are summed, the time of rest
    texts: list[str] = field(default_factory=list)  # what happens
    # derivatives of (x, x') after each step with respect to those before it
    maps: list[Callable[[], np.ndarray]] = field(default_factory=list)
    impacts: int = 0  # their number

    def turn(self, place: int, state: str) -> None:
        """Let one switch take a state."""
        self.after = _replaced(self.after, place, state)

    def enter(self, phase: Phase) -> PhaseEntry:
        """The values in a phase that may follow."""
        return phase.enter(self.x[1], self.v[1], self.force, self.loads, np.concatenate(self.size))

    @property
    def size(self) -> tuple[np.ndarray, np.ndarray]:
        """The sums of moduli from which rounding errors of x and x' follow."""
        return np.maximum(self.terms[0], np.abs(self.x[1])), np.maximum(self.terms[1], np.abs(self.v[1]))

    def add_impulse(self, name: str, sizes: Sequence[float]) -> None:
        """Add impulses of a row or a contact, by order."""
        own = self.impulses.setdefault(name, [])
        own += [0.0] * (len(sizes) - len(own))
        for order, size in enumerate(sizes):
            own[order] += size

    def forget(self, displacement_jumps: bool) -> None:
        """Zeros that a jump leaves: those of displacements where only velocities jump."""
        self.zeros = {} if displacement_jumps else {key: 1 for key in self.zeros if key[0] == "displacement"}


class Machine:
    """The equations of all phases: common ones with those of the states of switches, or whole ones by the state of the only switch."""

    def __init__(self, system: MechanicalSystem, switches: Sequence[Switch], systems: Mapping[str, MechanicalSystem] | None = None):
        self.system, self.switches, self.systems = system, tuple(switches), systems

    def label(self, key: Key) -> str:
        """A phase in words."""
        if len(key) == 1:
            return key[0]
        return ", ".join(f"{switch.name} {state}" for switch, state in zip(self.switches, key))

    def guards(self, key: Key) -> list[tuple[int, Guard]]:
        """All guards of a phase, each with the place of its switch; those with a dwell also with the opposite sign, which ends it."""
        listed = []
        for place, (switch, state) in enumerate(zip(self.switches, key)):
            for guard in switch.states[state].guards:
                listed += [(place, guard), (place, guard.opposite)] if guard.dwell else [(place, guard)]
        return listed

    def system_of(self, key: Key) -> tuple[MechanicalSystem, Sequence[ForceBranch]]:
        """The equations of a phase, and the branches among them."""
        if self.systems is not None:
            return self.systems[key[0]], ()
        states = [switch.states[state] for switch, state in zip(self.switches, key)]
        branches = [branch for state in states for branch in state.branches]
        rows = [row for state in states for row in state.rows]
        return with_parts(self.system, branches, rows), branches


def with_parts(system: MechanicalSystem, branches: Sequence[ForceBranch], rows: Sequence[Constraint]) -> MechanicalSystem:
    """A system with further forces and rows."""
    springs = [branch for branch in branches if branch.stiffness]
    dampers = [branch for branch in branches if branch.damping]
    if springs or dampers:
        K, C, M = system.given
        K, C = _with_branches(K, springs, "stiffness"), _with_branches(C, dampers, "damping")
        system = copy(system)
        system.stiffness, system.damping = (
            system._matrix(one, name, system.size) for one, name in ((K, "stiffness"), (C, "damping"))
        )
        system.given, system._forms = (K, C, M), {}
        system.part_source = system._named_parts = None
        system.__dict__.pop("energy_parts", None)
    return system.with_constraints(*rows) if rows else system


def _with_branches(matrix, branches: Sequence[ForceBranch], field: str):
    from ..element_matrix import ElementMatrix

    if not branches:
        return matrix
    constants = [getattr(branch, field) for branch in branches]
    part = ElementMatrix(np.array([branch.direction for branch in branches]), constants)
    if isinstance(matrix, ElementMatrix) and min(constants) > 0:
        return matrix + part
    return (matrix.matrix if isinstance(matrix, ElementMatrix) else matrix) + part.matrix


class PhaseSequence:
    """The computation of one motion up to its end, s, or an error after too many events; phases are made when first entered."""

    def __init__(self, machine: Machine, source: Source, end: float, most_events: int):
        self.machine, self.source, self.end, self.most = machine, source, end, most_events
        self.phases: dict[Key, Phase] = {}
        self.segments: list[PhaseSegment] = []
        self.records: list[SwitchRecord] = []
        self.notices: list[Notice] = []
        self.impacts: dict[tuple, ContactSet] = {}
        self.largest_impact = 0.0

    def phase(self, key: Key) -> Phase:
        """The phase of a key."""
        if key not in self.phases:
            machine = self.machine
            guards = [guard for _, guard in machine.guards(key)]
            self.phases[key] = Phase(key, machine.label(key), *machine.system_of(key), self.source, guards, self.end)
        return self.phases[key]

    @property
    def lasting(self) -> list[PhaseSegment]:
        """The segments that last, of a sequence that has been run."""
        return [segment for segment in self.segments if segment.duration > 0]

    # The course.

    def run(self, key: Key, x: np.ndarray, v: np.ndarray, accepted: bool) -> None:
        """All phases from values at 0- to the end."""
        self.deadlines: dict[tuple[int, str], float] = {}
        source, switches = self.source, self.machine.switches
        self._check_start(key, x, v, accepted)
        knots = [*source.knots[1:], np.inf][::-1]
        changes = sorted((change.time, place, change) for place, switch in enumerate(switches) for change in switch.times)[::-1]
        self._settle(
            SwitchRecord(0.0, 0.0, key, key, [x, x], [v, v], (np.abs(x), np.abs(v)), source.at(0.0), source.loads.get(0.0, ()))
        )
        while True:
            segment, key = self.segments[-1], self.key
            phase = segment.phase
            until = min(knots[-1], changes[-1][0] if changes else np.inf, *self.deadlines.values(), self.end)
            horizon = (until - segment.time) - segment.remainder
            crossing = phase.flow.first_crossing(segment.state, self.size, self.orders, self.signs, horizon)
            if crossing is None:
                segment.duration, time, remainder = horizon, until, 0.0
                if time >= self.end:
                    return
                state = phase.flow.states(segment.state, horizon)
            else:
                segment.duration, state = crossing.time, crossing.state
                time, remainder = _later(segment.time, segment.remainder, crossing.time)
            x, v = phase.C @ state, phase.V @ state
            moduli = np.maximum(np.abs(state), np.abs(segment.state))
            size = phase.C_size @ moduli, phase.V_size @ moduli
            record = SwitchRecord(time, remainder, key, key, [x, x], [v, v], size, phase.force_states(state))
            record.zeros.update(phase.zeros)
            if crossing is not None:
                self._fire(record, phase, crossing)
            else:
                if time == knots[-1]:
                    knots.pop()
                    record.force, record.loads = source.at(time), source.loads.get(time, ())
                while changes and changes[-1][0] == time:
                    _, place, change = changes.pop()
                    if not change.sources or record.after[place] in change.sources:
                        record.turn(place, change.target)
                        record.texts.append(self._text(place, change) if change.text else "")
                for place, guard in self.machine.guards(key):
                    if guard.dwell and self.deadlines.get((place, guard.target)) == time:
                        record.turn(place, guard.target)
                        record.texts.append(self._text(place, guard))
                        del self.deadlines[place, guard.target]
            self._settle(record)

    def _check_start(self, key: Key, x, v, accepted: bool) -> None:
        """Raise an InputError where a rigid contact is penetrated at the start."""
        for switch, state in zip(self.machine.switches, key):
            contact = switch.contact
            if contact is None or state != contact.open:
                continue
            gap, size = float(contact.row @ x) + contact.gap, float(np.abs(contact.row) @ np.abs(x)) + abs(contact.gap)
            if gap < -NOISE * size and not accepted:
                closed = self.phase(_replaced(key, self.machine.switches.index(switch), contact.closed))
                entry = closed.enter(x, v, self.source.at(0.0))
                impulse = _named_impulses(closed, entry.reactions).get(switch.name, [0.0])
                sizes = " and ".join(
                    f"{size:.6g} {_impulse_unit(switch.unit, order)}" for order, size in enumerate(impulse) if size
                )
                raise InputError(
                    f"{switch.name}: at the start it is penetrated by {-gap:.6g} {switch.unit}; closing it there would need an "
                    f"impulse of {sizes or '0'}. Start outside, or accept the jump with penetration=True (in a scene, "
                    "penetration = true below [initial])"
                )

    def _settle(self, record: SwitchRecord) -> None:
        """Find the phase that follows a switch, record the switch, and begin a segment."""
        visited: list[Key] = []
        while True:
            phase = self.phase(record.after)
            entry = record.enter(phase)
            if self._slips(record, phase, entry):
                continue
            order, sign = self._signs(record, phase, entry)
            negative = [int(number) for number in np.flatnonzero(sign < 0) if phase.guards[number].dwell == 0]
            if not negative:
                break
            if len(visited) > TRIALS or (record.after in visited and entry.is_smooth):
                phase, entry = self._by_search(record, visited, negative)
                order, sign = self._signs(record, phase, entry)
                break
            visited.append(record.after)
            if not entry.is_smooth:
                self._move(record, phase, entry)
            if self._leave(record, order, negative):
                visited.clear()
        if not entry.is_smooth:
            self._move(record, phase, entry)
        record.x[1], record.v[1] = phase.C @ entry.state, phase.V @ entry.state
        record.maps.append(phase.entry_map)
        self._begin(record, phase, entry, order, sign)

    def _begin(self, record: SwitchRecord, phase: Phase, entry: PhaseEntry, order: np.ndarray, sign: np.ndarray) -> None:
        old = self.segments[-1].phase if self.segments else phase
        record.phases, record.texts = (old, phase), list(filter(None, record.texts))
        segment = PhaseSegment(phase, record.time, record.remainder, entry.state, record.maps)
        later = record.texts or record.after != record.before or entry.jump.any() or record.grazing
        if record.impulses or record.coordinate_impulses or (self.segments and later):
            self.records.append(record)
            segment.event = record
            if len(self.records) > self.most:
                last = ", ".join(f"{one.time:.9g} s" for one in self.records[-3:])
                raise NotUnique(
                    f"the motion switches more than {self.most} times before {self.end:g} s, last at {last}; give an earlier end, or a "
                    "larger most_events"
                )
        self.segments.append(segment)
        self.key, self.size, self.orders, self.signs = record.after, entry.size, order, sign
        self.deadlines = {
            (place, guard.target): self.deadlines.get((place, guard.target), record.time + guard.dwell)
            for (place, guard), own in zip(self.machine.guards(record.after), sign)
            if guard.dwell and own < 0 and not guard.is_opposite
        }

    # Guards.

    @staticmethod
    def _signs(record: SwitchRecord, phase: Phase, entry: PhaseEntry) -> tuple[np.ndarray, np.ndarray]:
        """The orders of the zeros of the guards of a phase, and the signs after them."""
        x, v = (record.x[1], record.v[1]) if entry.is_smooth else (phase.C @ entry.state, phase.V @ entry.state)
        size = record.size
        known = np.array(
            [max(record.zeros.get(guard.functional, 0), guard.zeros(x, v, size, NOISE)) for guard in phase.guards], int
        )
        return phase.flow.orders(entry.state, entry.size, known, record.time)

    def _fire(self, record: SwitchRecord, phase: Phase, crossing: Crossing) -> None:
        """Let the switches turn whose guards fell to zero."""
        listed = self.machine.guards(record.before)
        hit = [listed[number] for number in crossing.guards]
        for place, guard in hit:
            contact = self.machine.switches[place].contact
            if contact is not None and contact.sliding and record.before[place] == contact.closed:
                continue  # the forces that it takes across end with that along it, and change all others
            record.zeros[guard.functional] = 2 if crossing.grazing else 1
            if guard.functional[0] == "displacement" and not crossing.grazing:  # lest rounding errors add up from impact to impact
                free = phase.system.undelayed_form().null_space
                d, off = free.T @ guard.displacement, guard.displacement @ record.x[1] - guard.value
                record.x[1] = record.x[1] - free @ d * (off / (d @ d) if d.any() else 0.0)
            if contact is not None and guard.reactions:
                record.zeros[contact.functional] = 3  # without its force nothing accelerates it
        if not hit:
            return
        record.guard, record.grazing = hit[0][1], crossing.grazing
        record.guard_row = phase.flow.rows[crossing.guards[0]]
        if record.grazing:
            return
        striking = {place: guard for place, guard in hit if guard.restitution is not None}
        for place, guard in hit:
            if guard.restitution is None and guard.dwell == 0:
                record.texts.append(self._text(place, guard))
                record.turn(place, guard.target)
        if striking:
            self._impact(record, striking)

    def _leave(self, record: SwitchRecord, order: np.ndarray, negative: Sequence[int]) -> bool:
        """Leave a phase with guards that are negative just after a switch; whether by an impact."""
        listed = self.machine.guards(record.after)
        approaching = [listed[number] for number in negative if order[number] == 1]
        striking = {place: guard for place, guard in approaching if guard.restitution is not None}
        if striking:
            self._impact(record, striking)
            return True
        place, guard = listed[negative[0]]
        passes = guard.beyond is not None and order[negative[0]] == 0
        contact, target = self.machine.switches[place].contact, guard.beyond if passes else guard.target
        text = f"{self.machine.switches[place].name} slips" if passes else self._text(place, guard)
        if contact is not None and contact.sliding and target == contact.closed and order[negative[0]] > 1:
            target, text = contact.sliding, f"{self.machine.switches[place].name} slides"  # without an impact nothing stops it
        record.texts.append(text)
        record.turn(place, target)
        return False

    def _text(self, place: int, guard: Guard | TimedChange) -> str:
        return guard.text if self.machine.systems is not None else f"{self.machine.switches[place].name} {guard.text}"

    # Jumps.

    def _slips(self, record: SwitchRecord, phase: Phase, entry: PhaseEntry) -> bool:
        """Let bounded forces slip that would have to pass on an impulse; whether there are any."""
        before, places = record.after, phase.row_places
        for place, (switch, state) in enumerate(zip(self.machine.switches, before)):
            slips = switch.states[state].slips
            if slips is not None and switch.name in places and any(load[places[switch.name]] for load in entry.reactions):
                record.turn(place, slips)
        return record.after != before

    def _move(self, record: SwitchRecord, phase: Phase, entry: PhaseEntry) -> None:
        """Pass through the jump of an entry, with its impulses."""
        for name, sizes in _named_impulses(phase, entry.reactions).items():
            record.add_impulse(name, sizes)
        if entry.impulses:
            record.coordinate_impulses = entry.impulses
        record.maps.append(phase.entry_map)
        record.x[1], record.v[1] = phase.C @ entry.state, phase.V @ entry.state
        record.loads = ()
        record.forget(bool(entry.jump[0].any()))
        record.zeros.update(phase.zeros)

    # Impacts.

    def _touching(self, record: SwitchRecord, striking: Mapping[int, Guard]) -> dict[int, UnilateralContact]:
        """The rigid contacts that touch, by the places of their switches: closed, open without gap, or about to close."""
        contacts = {}
        for place, (switch, state) in enumerate(zip(self.machine.switches, record.after)):
            contact = switch.contact
            if contact is None and place in striking:  # of whole phases
                own = striking[place]
                contacts[place] = UnilateralContact(own.displacement, -own.value, own.restitution or 0.0, state, own.target)
            elif contact is not None and (place in striking or state == contact.closed or contact.touches(record.x[1], STILL)):
                contacts[place] = contact
        return contacts

    def _impact(self, record: SwitchRecord, striking: Mapping[int, Guard]) -> None:
        """The velocities after an impact of all rigid contacts that touch, and their states."""
        touching = self._touching(record, striking)
        sticking = {place: contact for place, contact in touching.items() if contact.sliding}
        if sticking:
            touching = {place: contact for place, contact in touching.items() if not contact.sliding}
            if not self._stick(record, sticking, touching, striking):
                touching |= {place: replace(one, closed=str(one.sliding), sliding=None) for place, one in sticking.items()}
            if not touching:
                return
        key, switches = self._without(record.after, touching), self.machine.switches
        phase, contacts = self.phase(key), list(touching.values())
        named = {place: self._named(place, contact, phase) for place, contact in touching.items()}
        names = {place: name for place, (name, _) in named.items()}
        impact = self._contact_set(key, touching)
        for place, contact, massless in zip(touching, contacts, impact.massless):
            if massless:
                record.turn(place, contact.closed)
                record.texts.append(f"{names[place]} closes")
                if contact.restitution:
                    text = f"{names[place]}: the point that comes into contact has no mass; it stays in contact, without the restitution"
                    self._note(NoticeKind.OMITTED, text)
        if any(impact.massless):
            return
        quoted = ", ".join(f'"{name}"' for name in names.values())
        if impact.is_dependent:
            text = f"the contacts {quoted} depend on each other: the motion is unique, the shares of their impulses are not"
            self._note(NoticeKind.REDUNDANT, text)
        u, size = impact.rows @ record.v[1], np.abs(impact.rows) @ record.size[1]
        u[np.abs(u) <= NOISE * size] = 0.0
        record.impacts += 1
        self.largest_impact = max(self.largest_impact, float(np.abs(u).max()))
        y, e = record.enter(phase).state, impact.restitution * (record.impacts <= REPEATED)
        try:
            p, rests = impact.solve(u, e, size)
        except NotUnique:
            e = np.zeros(len(e))
            p, rests = impact.solve(u, e, size)
        if not e.any() and impact.restitution.any():
            text = f"the contacts {quoted} rebound from each other without end at one time; they are taken without rebound"
            self._note(NoticeKind.OMITTED, text)
        summed = self._summed(record, touching, impact, y + impact.response @ p, rests, e)
        if summed.any():
            e = np.where(summed, 0.0, e)
            p, rests = impact.solve(u, e, size)
        y = y + impact.response @ p
        before = record.x[1], record.v[1]
        record.x[1], record.v[1] = phase.C @ y, phase.V @ y
        record.forget(False)
        for (place, contact), impulse, own in zip(touching.items(), p, rests):
            if impulse:
                record.add_impulse(names[place], [named[place][1] * float(impulse)])
            if place in striking or impulse:
                was_closed = switches[place].contact is contact and record.before[place] == contact.closed
                record.texts.append(f"{names[place]} {'impact' if not own else 'stays closed' if was_closed else 'closes'}")
            record.turn(place, contact.closed if own else contact.open)
            record.zeros[contact.functional] = 2 if own else 1
        for name, own in impact.row_impulses(p, record.x[1] - before[0], record.v[1] - before[1]).items():
            record.add_impulse(name, [own])
        record.maps.append(lambda: impact.derivative(e, p))

    def _contact_set(self, key: Key, touching: Mapping[int, UnilateralContact]) -> ContactSet:
        if (key, *touching) not in self.impacts:
            self.impacts[key, *touching] = ContactSet(self.phase(key), list(touching.values()))
        return self.impacts[key, *touching]

    def _stick(self, record: SwitchRecord, sticking: Mapping[int, UnilateralContact], others, striking) -> bool:
        """Close those of the contacts that stick which must press to come to rest, so that the rest of them separates.

        The sets of closed contacts are tried, the approaching and the closed ones first; whether one is consistent.
        """
        record.impacts += 1
        names = {place: self.machine.switches[place].name for place in sticking}
        if record.impacts > TRIALS:
            raise NotUnique(f"at t = {record.time:.9g} s the contacts {', '.join(names.values())} close and separate without end")
        free = self._without(record.after, {**sticking, **others})
        likely = {place for place, one in sticking.items() if place in striking or record.after[place] == one.closed}
        sets = (set(own) for count in range(len(sticking) + 1) for own in combinations(sticking, count))
        for closed in sorted(sets, key=lambda own: len(own ^ likely)):
            key = free
            for place in closed:
                key = _replaced(key, place, sticking[place].closed)
            phase = self.phase(key)
            entry = record.enter(phase)
            y, other = entry.state, np.zeros(phase.system.size)
            if others:
                impact = self._contact_set(key, others)
                u = impact.rows @ phase.V @ y
                size = np.abs(impact.rows) @ record.size[1]
                p = impact.solve(np.where(np.abs(u) <= NOISE * size, 0.0, u), impact.restitution, size)[0]
                y, other = y + impact.response @ p, impact.rows.T @ p
            v = phase.V @ y
            own = row_impulses(phase.system, other, phase.C @ y - record.x[1], v - record.v[1])
            speeds = {place: float(one.row @ v) for place, one in sticking.items()}
            noise = {place: STILL * float(np.abs(one.row) @ (record.size[1] + np.abs(v))) for place, one in sticking.items()}
            if all(own.get(names[place], 0.0) >= 0 if place in closed else speeds[place] >= -noise[place] for place in sticking):
                break
        else:
            return False
        before = record.after
        for place, contact in sticking.items():
            record.turn(place, contact.closed if place in closed else contact.open)
            if place in striking or before[place] != record.after[place]:
                record.texts.append(f"{names[place]} {'closes' if place in closed else 'opens'}")
        if not entry.is_smooth:
            after = record.after
            self._move(record, phase, entry)
            record.after = after
        for place, contact in sticking.items():
            record.zeros[contact.functional] = 2 if abs(speeds[place]) <= noise[place] else 1
        return True

    def _without(self, key: Key, touching: Mapping[int, UnilateralContact]) -> Key:
        """The phase without contacts and with bounded forces that slip."""
        for place, contact in touching.items():
            key = _replaced(key, place, contact.open)
        for place, (switch, state) in enumerate(zip(self.machine.switches, key)):
            slips = switch.states[state].slips
            key = key if slips is None else _replaced(key, place, slips)
        return key

    def _summed(
        self, record: SwitchRecord, touching, impact: ContactSet, y: np.ndarray, rests: np.ndarray, e: np.ndarray
    ) -> np.ndarray:
        """Which contacts bounce so little, and geometrically to rounding errors, that all further bounces are summed."""
        x, v, key = impact.phase.C @ y, impact.phase.V @ y, record.after
        summed = np.zeros(len(e), bool)
        speeds = impact.rows @ v
        small = ~rests & (speeds > 0) & (speeds <= SMALL_BOUNCE * self.largest_impact) & (e < 1)
        if not small.any():
            return summed
        for (place, contact), own in zip(touching.items(), rests):
            key = _replaced(key, place, contact.closed if own else contact.open)
        following = self.phase(key)
        state = following.enter(x, v, record.force).state
        for number, contact in enumerate(touching.values()):
            if small[number]:
                row = contact.row @ following.V @ following.J
                acceleration, rate = row @ state, row @ (following.J @ state)
                rest = 2 * speeds[number] / max(-acceleration, np.finfo(float).tiny) / (1 - e[number])
                limits = abs(acceleration) / 8, abs(acceleration) * EPS * (record.time + rest)
                summed[number] = acceleration < 0 and abs(rate) * rest <= limits[0] and abs(rate) * rest**2 <= limits[1]
                if summed[number]:
                    record.resting = record.time + rest
        return summed

    def _named(self, place: int, contact: UnilateralContact, phase: Phase) -> tuple[str, float]:
        """The name of a contact, or of the row along it that the following phase adds, and the factor of impulses of this name."""
        if self.machine.systems is None:
            return self.machine.switches[place].name, 1.0
        for row in self.machine.systems[contact.closed].rows:
            a = row.coefficients
            factor = float(contact.row @ a) / float(a @ a)
            if row.name not in phase.row_places and np.abs(contact.row - factor * a).max() <= NOISE * np.abs(contact.row).max():
                return row.name, factor
        return contact.closed, 1.0

    def _note(self, kind: NoticeKind, text: str) -> None:
        if all(notice.text != text for notice in self.notices):
            self.notices.append(Notice(kind, text))

    # Search.

    def _by_search(self, record: SwitchRecord, visited: Sequence[Key], negative: Sequence[int]) -> tuple[Phase, PhaseEntry]:
        """The first consistent phase among the combinations of the states of the switches that alternate."""
        listed, switches = self.machine.guards(record.after), self.machine.switches
        alternating = {listed[number][0] for number in negative}
        alternating |= {place for place, states in enumerate(zip(*visited)) if len(set(states)) > 1}
        contacts = {place for place in range(len(switches)) if switches[place].contact}
        for places in (sorted(alternating), sorted(alternating | contacts)):
            for states in islice(product(*(list(switches[place].states) for place in places)), COMBINATIONS):
                for place, state in zip(places, states):
                    record.turn(place, state)
                phase = self.phase(record.after)
                entry = record.enter(phase)
                if entry.is_smooth and not (self._signs(record, phase, entry)[1] < 0).any():
                    return phase, entry
        names = ", ".join(f'"{switches[place].name}"' for place in sorted(alternating))
        raise NotUnique(
            f"at t = {record.time:.9g} s no phase is consistent: the states of {names} alternate "
            "without end; look for conditions that contradict each other, such as one that closes and opens at the same value"
        )


def _replaced(key: Key, place: int, state: str) -> Key:
    return (*key[:place], state, *key[place + 1 :])


def _later(time: float, remainder: float, duration: float) -> tuple[float, float]:
    """A later time with its rounding error, by Knuth's two-sum."""
    later = time + duration
    added = later - time
    error = (time - (later - added)) + (duration - added) + remainder
    rounded = later + error
    return rounded, error - (rounded - later)


def _named_impulses(phase: Phase, reactions) -> dict[str, list[float]]:
    """Impulses of constraint rows by name, by order."""
    named: dict[str, list[float]] = {}
    for name, place in phase.row_places.items():
        sizes = [float(load[place]) for load in reactions]
        if any(sizes):
            named[name] = sizes
    return named


def _impulse_unit(unit: str, order: int) -> str:
    from ...ground.units import force_unit, impulse_unit

    return impulse_unit(force_unit(unit), order)
