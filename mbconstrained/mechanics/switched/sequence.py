"""The motion through all phases, one after another: each in closed form, each switch at the first zero of a guard.

At a switch the states that the switches take are found by trial: a state whose guard is negative just after the switch is left for the
one that follows it, until no guard is. Rigid contacts that touch have their impulses by Newton's law all at once (``impact``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from ...ground.errors import InputError, NotUnique
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS
from ..constraints import Constraint
from .flow import NOISE
from .impact import impulses_of_contacts
from .phase import STILL, Phase, PhaseEntry, Source
from .switches import ForceBranch, Guard, Switch, TimedChange, UnilateralContact

if TYPE_CHECKING:
    from ..system import MechanicalSystem

Key = tuple[str, ...]

#: Most switches within one motion by default.
MOST_EVENTS = 10_000

#: Trials of states at one time.
TRIALS = 64

#: Bounces are summed once the velocity after one is this part of the largest impact, if their sum is geometric to rounding errors.
SMALL_BOUNCE = EPS**0.5


@dataclass(eq=False)
class PhaseSegment:
    """One phase between two times.

    Attributes:
        phase: with its equations.
        time: the begin, s, and its rounding error.
        state: y there.
        duration: s.
        entered: how z = (x, x') at the begin depends on that before it, shape (2 n, 2 n), and y on z, for sensitivities.
    """

    phase: Phase
    time: float
    remainder: float
    state: np.ndarray
    duration: float = 0.0
    jump: Callable[[], np.ndarray] | None = None
    event: SwitchRecord | None = None


@dataclass(eq=False)
class SwitchRecord:
    """A switch as it is computed, before it is reported."""

    time: float
    remainder: float
    before: Key
    after: Key
    x: tuple[np.ndarray, np.ndarray]
    v: tuple[np.ndarray, np.ndarray]
    impulses: dict[str, list[float]] = field(default_factory=dict)
    coordinate_impulses: tuple[np.ndarray, ...] = ()
    guard: Guard | None = None
    guard_row: np.ndarray | None = None
    phases: tuple[Phase, ...] = ()
    grazing: bool = False
    resting: float | None = None
    texts: tuple[str, ...] = ()


class Machine:
    """The phases of a switched system, each made when it is first entered.

    Args:
        system: the equations common to all phases; None where every phase has its own.
        switches: its switches.
        systems: the whole systems by state of the only switch, where there is one.
    """

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
    """The computation of one motion.

    Args:
        machine: the phases.
        source: the force.
        end: of the motion, s.
        most_events: it stops with a message after so many switches.
    """

    def __init__(self, machine: Machine, source: Source, end: float, most_events: int):
        self.machine, self.source, self.end, self.most = machine, source, end, most_events
        self.phases: dict[Key, Phase] = {}
        self.segments: list[PhaseSegment] = []
        self.records: list[SwitchRecord] = []
        self.notices: list[Notice] = []
        self.largest_impact = 0.0

    def phase(self, key: Key) -> Phase:
        """The phase of a key."""
        if key not in self.phases:
            machine = self.machine
            guards = [guard for _, guard in machine.guards(key)]
            self.phases[key] = Phase(machine.label(key), *machine.system_of(key), self.source, guards, self.end)
        return self.phases[key]

    # The course.

    def run(self, key: Key, x: np.ndarray, v: np.ndarray, accepted: bool) -> None:
        """All phases from values at 0- to the end."""
        self.deadlines: dict[tuple[int, str], float] = {}
        time, remainder = 0.0, 0.0
        self._check_start(key, x, v, accepted)
        knots = iter([*self.source.knots[1:], np.inf])
        knot = next(knots)
        changes = sorted(
            (change.time, place, change) for place, switch in enumerate(self.machine.switches) for change in switch.times
        )
        loads = self.source.loads.get(0.0, ())
        w = self.source.at(0.0)
        self._entered(key, key, x, v, w, loads, [], 0.0, 0.0, None, None)
        while True:
            segment = self.segments[-1]
            key, phase, y = self.key, segment.phase, segment.state
            pending = min((deadline for deadline in self.deadlines.values()), default=np.inf)
            next_change = changes[0][0] if changes else np.inf
            until = min(knot, next_change, pending, self.end)
            crossing = phase.flow.first_crossing(y, self.orders, (until - time) - remainder, self.active)
            if crossing is None:
                segment.duration = (until - time) - remainder
                state = phase.flow.states(y, segment.duration)
                time, remainder = until, 0.0
                if time >= self.end:
                    return
                x, v = phase.C @ state, phase.V @ state
                w = phase.force_states(state)
                loads, target, texts = (), key, []
                if time == knot:
                    w, loads = self.source.at(time), self.source.loads.get(time, ())
                    knot = next(knots)
                while changes and changes[0][0] == time:
                    _, place, change = changes.pop(0)
                    if not change.sources or target[place] in change.sources:
                        target = _replaced(target, place, change.target)
                        texts.append(self._text(place, change) if change.text else "")
                for due in [due for due, deadline in self.deadlines.items() if deadline == time]:
                    target = _replaced(target, *due)
                    del self.deadlines[due]
                self._entered(key, target, x, v, w, loads, texts, time, remainder, None, None)
                continue
            segment.duration = crossing.time
            time, remainder = _later(time, remainder, crossing.time)
            state = crossing.state
            x, v, w = phase.C @ state, phase.V @ state, phase.force_states(state)
            hit = [(place, guard) for place, guard in (self.listed[number] for number in crossing.guards)]
            self._entered(key, key, x, v, w, (), [], time, remainder, hit, crossing)

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

    def _entered(self, before: Key, key: Key, x, v, w, loads, texts, time, remainder, hit, crossing) -> None:
        """Find the phase that follows a switch, record the switch, and begin a segment."""
        machine, old = self.machine, self.segments[-1].phase if self.segments else None
        start = (x, v)
        record = SwitchRecord(time, remainder, before, key, (x, x), (v, v))
        maps: list[Callable[[], np.ndarray]] = []
        fired = hit is not None and not crossing.grazing
        if hit is not None:
            record.guard, record.grazing = hit[0][1], crossing.grazing
            record.guard_row = old.flow.rows[crossing.guards[0]] if old is not None else None
        known_zero = {(place, guard.target, guard.text) for place, guard in hit} if hit else set()
        visited: set[Key] = set()
        tried = 0
        if fired:
            key, x, v = self._fire(before, hit, x, v, w, record, maps, texts)
        while True:
            phase, listed = self.phase(key), machine.guards(key)
            entry = phase.enter(x, v, w, loads)
            slipping = self._slipping(key, entry, phase)
            if slipping is not None:
                key = slipping
                continue
            known_rows = np.array(
                [
                    (place, guard.target, guard.text) in known_zero or self._is_touching(place, guard, key, record)
                    for place, guard in listed
                ],
                dtype=bool,
            )
            order, sign, values = phase.flow.orders(entry.state, known_rows)
            negative = [
                number
                for number in np.flatnonzero(sign < 0)
                if listed[number][1].dwell == 0 and self._counts(phase, entry.state, listed[number][1])
            ]
            if not negative:
                break
            tried += 1
            if tried > TRIALS or (key in visited and not self._moves(entry)):
                key, entry = self._by_search(key, x, v, w, loads, listed, negative)
                phase, listed = self.phase(key), machine.guards(key)
                order, sign, values = phase.flow.orders(entry.state, np.zeros(len(listed), bool))
                break
            visited.add(key)
            if not entry.is_smooth:
                x, v = self._moved(phase, entry, record, maps)
                loads = ()
            key, x, v = self._left(
                key, phase, entry, [(number, listed[number]) for number in negative], order, values, x, v, w, record, maps, texts
            )
        x1, v1 = phase.C @ entry.state, phase.V @ entry.state
        if not entry.is_smooth:
            self._moved(phase, entry, record, maps)
        maps.append(_map_of(phase))
        self._begin(
            record, before, key, start, (x1, v1), phase, entry, listed, order, sign, maps, tuple(filter(None, texts)), old, time
        )

    def _begin(self, record, before, key, start, after, phase, entry, listed, order, sign, maps, texts, old, time) -> None:
        self.key, self.listed, self.orders = key, listed, order
        self.active = sign > 0
        record.after, record.x, record.v, record.texts = key, (start[0], after[0]), (start[1], after[1]), texts
        jumps = np.abs(after[1] - start[1]).max(initial=0.0) > STILL * (np.abs(start[1]) + np.abs(after[1])).max(initial=0.0)
        happened = bool(
            record.impulses or record.coordinate_impulses or record.grazing or (self.segments and (key != before or texts))
        )
        record.phases = (old if old is not None else phase, phase)
        segment = PhaseSegment(phase, record.time, record.remainder, entry.state, jump=_product(maps))
        if happened or (jumps and self.segments):
            self.records.append(record)
            segment.event = record
            if len(self.records) > self.most:
                self._stop(record)
        self.segments.append(segment)
        self._set_deadlines(listed, sign, time)

    def momentum_residual(self, record: SwitchRecord) -> float:
        """|M jump of x' + C jump of x - sum of impulses| relative to the largest term, where all impulses are Dirac impulses."""
        if not record.impulses or any(any(sizes[1:]) for sizes in record.impulses.values()) or record.coordinate_impulses:
            return 0.0
        rows = {row.name: row.coefficients for phase in record.phases for row in phase.system.rows}
        for switch in self.machine.switches:
            if switch.contact is not None:
                rows.setdefault(switch.name, switch.contact.row)
        if not set(record.impulses) <= set(rows):
            return 0.0
        system = record.phases[1].system
        terms = [system.mass @ (record.v[1] - record.v[0]), system.damping @ (record.x[1] - record.x[0])]
        terms += [-rows[name] * sizes[0] for name, sizes in record.impulses.items()]
        largest = max(float(np.abs(term).max(initial=0.0)) for term in terms)
        return float(np.abs(sum(terms)).max(initial=0.0)) / largest if largest else 0.0

    def _stop(self, record: SwitchRecord) -> None:
        last = [one.time for one in self.records[-3:]]
        raise NotUnique(
            f"the motion switches more than {self.most} times before {self.end:g} s, last at {', '.join(f'{t:.9g} s' for t in last)}; "
            "give an earlier end, or a larger most_events"
        )

    # Guards.

    def _set_deadlines(self, listed, sign, time: float) -> None:
        """The times at which guards have been negative for their dwell."""
        waiting = [(place, guard) for (place, guard), own in zip(listed, sign) if guard.dwell and own < 0 and not guard.is_opposite]
        self.deadlines = {
            (place, guard.target): self.deadlines.get((place, guard.target), time + guard.dwell) for place, guard in waiting
        }

    def _counts(self, phase: Phase, y: np.ndarray, guard: Guard) -> bool:
        """Whether the condition of a guard is met."""
        if guard.condition is None:
            return True
        own = guard.condition
        row = own.displacement @ phase.C + own.velocity @ phase.V
        return float(row @ y) - own.value > 0

    def _is_touching(self, place: int, guard: Guard, key: Key, record: SwitchRecord) -> bool:
        """Whether the gap of a contact is zero because it was closed, or struck, just before."""
        contact = self.machine.switches[place].contact
        if contact is None or guard.restitution is None:
            return False
        return record.before[place] == contact.closed or self.machine.switches[place].name in record.impulses

    def _slipping(self, key: Key, entry: PhaseEntry, phase: Phase) -> Key | None:
        """The phase with those bounded forces slipping that would have to pass on an impulse; None where there are none."""
        if not entry.reactions:
            return None
        result, places = key, phase.row_places
        for place, (switch, state) in enumerate(zip(self.machine.switches, key)):
            own = switch.states[state]
            if own.slips is not None and switch.name in places and any(load[places[switch.name]] for load in entry.reactions):
                result = _replaced(result, place, own.slips)
        return result if result != key else None

    def _moves(self, entry: PhaseEntry) -> bool:
        return not entry.is_smooth

    # Changes of state.

    def _fire(self, key: Key, hit, x, v, w, record, maps, texts):
        """The states after guards that fell to zero."""
        impacts = [(place, guard) for place, guard in hit if guard.restitution is not None]
        others = [(place, guard) for place, guard in hit if guard.restitution is None and guard.dwell == 0]
        for place, guard in others:
            texts.append(self._text(place, guard))
            key = _replaced(key, place, guard.target)
        if impacts:
            return self._impact(key, impacts, x, v, w, record, maps, texts)
        return key, x, v

    def _text(self, place: int, guard: Guard | TimedChange) -> str:
        return guard.text if self.machine.systems is not None else f"{self.machine.switches[place].name} {guard.text}"

    def _left(self, key: Key, phase: Phase, entry: PhaseEntry, negative, order, values, x, v, w, record, maps, texts):
        """The states after guards that are negative just after a switch."""
        impacts = [(place, guard) for number, (place, guard) in negative if guard.restitution is not None and order[number] == 1]
        if impacts:
            return self._impact(key, impacts, x, v, w, record, maps, texts)
        number, (place, guard) = negative[0]
        passes = guard.beyond is not None and order[number] == 0
        texts.append(f"{self.machine.switches[place].name} slips" if passes else self._text(place, guard))
        return _replaced(key, place, guard.beyond if passes else guard.target), x, v

    def _contacts(self, key: Key, x, impacts) -> list[tuple[int, UnilateralContact]]:
        """The rigid contacts that touch: closed, or open with no gap, or about to strike."""
        found = []
        striking = {place for place, _ in impacts}
        for place, (switch, state) in enumerate(zip(self.machine.switches, key)):
            contact = switch.contact
            if contact is None:
                own = next((guard for at, guard in impacts if at == place), None)
                if own is not None:
                    found.append(
                        (place, UnilateralContact(own.displacement, -own.value, own.restitution or 0.0, state, own.target))
                    )
                continue
            gap, size = float(contact.row @ x) + contact.gap, float(np.abs(contact.row) @ np.abs(x)) + abs(contact.gap)
            if place in striking or state == contact.closed or (state == contact.open and abs(gap) <= STILL * size):
                found.append((place, contact))
        return found

    def _impact(self, key: Key, impacts, x, v, w, record, maps, texts):
        """The velocities after an impact of all rigid contacts that touch, and their states."""
        machine = self.machine
        contacts = self._contacts(key, x, impacts)
        free = key
        for place, contact in contacts:
            free = _replaced(free, place, contact.open)
        for place, (switch, state) in enumerate(zip(machine.switches, free)):
            slips = switch.states[state].slips
            free = free if slips is None else _replaced(free, place, slips)
        phase = self.phase(free)
        entry = phase.enter(x, v, w)
        responses = [phase.impulse_response(contact.row) for _, contact in contacts]
        massless = [place for place, contact in contacts if phase.has_massless(contact.row)]
        if massless:
            for place, contact in contacts:
                if place in massless:
                    key = _replaced(key, place, contact.closed)
                    texts.append(f"{machine.switches[place].name} closes")
                    if contact.restitution:
                        self._note_massless(machine.switches[place].name)
            return key, x, v
        A = np.array([contact.row for _, contact in contacts])
        u = A @ v
        B = np.array(responses).T
        W = A @ phase.V @ B
        e = np.array([contact.restitution for _, contact in contacts])
        size = np.abs(A) @ np.abs(v)
        u = np.where(np.abs(u) <= NOISE * size, 0.0, u)
        p = impulses_of_contacts(W, u, e)
        self._check_dependent(W, p, contacts)
        y = entry.state + B @ p
        x1, v1 = phase.C @ y, phase.V @ y
        after = A @ v1
        self.largest_impact = max(self.largest_impact, float(np.abs(u).max(initial=0.0)))
        strikers = {place for place, _ in impacts}
        for number, (place, contact) in enumerate(contacts):
            name = self._impulse_name(place, contact, phase)
            rests = abs(after[number]) <= STILL * (np.abs(contact.row) @ np.abs(v1) + np.abs(contact.row) @ np.abs(v))
            if p[number] and not rests and self._is_summed(phase, y, contact, float(after[number]), record):
                rests, q = True, -after[number] / W[number, number]
                p[number] += q
                y = y + B[:, number] * q
                x1, v1 = phase.C @ y, phase.V @ y
            if p[number]:
                record.impulses.setdefault(name, [0.0])[0] += float(p[number])
            if place in strikers or p[number]:
                texts.append(f"{name} {'closes' if rests else 'strikes'}")
            key = _replaced(key, place, contact.closed if rests else contact.open)
        self._of_other_rows(phase, record, A, p, x1 - x, v1 - v)
        maps.append(_impact_map(phase, A, B, W, e, p))
        return key, x1, v1

    def _of_other_rows(self, phase: Phase, record: SwitchRecord, A, p, moved, gained) -> None:
        """Impulses of the constraint rows of the phase in an impact."""
        system = phase.system
        if system.rows:
            terms = [system.mass @ gained, system.damping @ moved, -A.T @ p]
            total = system.multiplier_map @ sum(terms)
            size = STILL * (np.abs(system.multiplier_map) @ sum(map(np.abs, terms)))
            for row, impulse in zip(system.rows, np.where(np.abs(total) > size, total, 0.0)):
                if impulse:
                    record.impulses.setdefault(row.name, [0.0])[0] += float(impulse)

    def _impulse_name(self, place: int, contact: UnilateralContact, phase: Phase) -> str:
        """The name of a contact: its own, or that of the row which the following phase adds."""
        if self.machine.systems is None:
            return self.machine.switches[place].name
        added = [row.name for row in self.machine.systems[contact.closed].rows if row.name not in phase.row_places]
        return added[0] if len(added) == 1 else contact.closed

    def _note_massless(self, name: str) -> None:
        text = f"{name}: the point that strikes has no mass; it stays in contact, without the restitution"
        if all(notice.text != text for notice in self.notices):
            self.notices.append(Notice(NoticeKind.OMITTED, text))

    def _check_dependent(self, W, p, contacts) -> None:
        """Notice where the impulses of contacts that touch are not unique."""
        if len(W) < 2:
            return
        scale = np.sqrt(np.maximum(np.diag(W), 0.0))
        scale[scale == 0] = 1.0
        values = np.linalg.eigvalsh((W / scale / scale[:, None] + (W / scale / scale[:, None]).T) / 2)
        if values[0] <= STILL * len(W) * values[-1]:
            names = ", ".join(f'"{self.machine.switches[place].name}"' for place, _ in contacts)
            text = f"the contacts {names} depend on each other: the motion is unique, the shares of their impulses are not"
            if all(notice.text != text for notice in self.notices):
                self.notices.append(Notice(NoticeKind.REDUNDANT, text))

    def _is_summed(self, phase: Phase, y, contact: UnilateralContact, velocity: float, record: SwitchRecord) -> bool:
        """Whether all further bounces are summed: they are small, and geometric to rounding errors; the time of rest is recorded."""
        if velocity <= 0 or velocity > SMALL_BOUNCE * self.largest_impact or contact.restitution >= 1:
            return False
        acceleration = contact.row @ phase.V @ (phase.J @ y)
        rate = contact.row @ phase.V @ (phase.J @ (phase.J @ y))
        if acceleration >= 0:
            return False
        rest = 2 * velocity / -acceleration / (1 - contact.restitution)
        if abs(rate) * rest > abs(acceleration) / 8 or abs(rate / acceleration) * rest**2 > EPS * (record.time + rest):
            return False
        record.resting = record.time + rest
        return True

    def _moved(self, phase: Phase, entry: PhaseEntry, record: SwitchRecord, maps) -> tuple[np.ndarray, np.ndarray]:
        """The values after the jump of an entry, whose impulses are recorded."""
        for name, sizes in _named_impulses(phase, entry.reactions).items():
            own = record.impulses.setdefault(name, [])
            for order, size in enumerate(sizes):
                if order == len(own):
                    own.append(0.0)
                own[order] += size
        if entry.impulses:
            record.coordinate_impulses = entry.impulses
        maps.append(_map_of(phase))
        return phase.C @ entry.state, phase.V @ entry.state

    def _by_search(self, key: Key, x, v, w, loads, listed, negative) -> tuple[Key, PhaseEntry]:
        """The first consistent phase among all combinations of the states of the switches that alternate."""
        places = sorted(
            {listed[number][0] for number in negative}
            | {place for place, _ in enumerate(key) if self.machine.switches[place].contact}
        )
        for states in product(*(list(self.machine.switches[place].states) for place in places)):
            tried = key
            for place, state in zip(places, states):
                tried = _replaced(tried, place, state)
            phase = self.phase(tried)
            entry = phase.enter(x, v, w, loads)
            if not entry.is_smooth:
                continue
            _, sign, _ = phase.flow.orders(entry.state, np.zeros(len(phase.guards), bool))
            if not (sign < 0).any():
                return tried, entry
        names = ", ".join(f'"{self.machine.switches[place].name}"' for place in places)
        raise NotUnique(
            f"at t = {self.segments[-1].time if self.segments else 0.0:.9g} s or later no phase is consistent: the states of {names} alternate "
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
    from ...ground.coordinate_units import force_unit, impulse_unit

    return impulse_unit(force_unit(unit), order)


# Sensitivities of values after a switch to those before it.


def _map_of(phase: Phase) -> Callable[[], np.ndarray]:
    """The derivative of (x, x') at the begin of a phase with respect to those just before it."""
    return lambda: np.vstack([phase.C, phase.V]) @ phase.start[:, : 2 * phase.system.size]


def _impact_map(phase: Phase, A, B, W, e, p) -> Callable[[], np.ndarray]:
    def derivative() -> np.ndarray:
        n = phase.system.size
        total, own = np.eye(2 * n), np.flatnonzero(p > 0)
        if len(own):
            by = np.linalg.solve(W[np.ix_(own, own)], (1 + e[own])[:, None] * A[own])
            total[:, n:] -= np.vstack([phase.C, phase.V]) @ B[:, own] @ by
        return total

    return derivative


def _product(maps: Sequence[Callable[[], np.ndarray]]) -> Callable[[], np.ndarray]:
    def derivative() -> np.ndarray:
        result = maps[0]()
        for one in maps[1:]:
            result = one() @ result
        return result

    return derivative
