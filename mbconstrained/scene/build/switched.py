"""Scenes whose equations change: the switched system, the end of its motion, and the phase for which linear analyses answer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import counted, nearest
from ...ground.errors import InputError, shown
from ...ground.notices import Notice, NoticeKind
from ...ground.quantities import quantity
from ...ground.tolerances import EPS, noise_of
from ...ground.units import force_unit, rate_unit
from ...signals.impulsive import ImpulsiveSmooth
from ..file import at

if TYPE_CHECKING:
    from ...mechanics.constraints import ConstraintRow
    from ...mechanics.switched.switched_motion import SwitchedMotion
    from ...mechanics.switched.switched_system import SwitchedSystem
    from ...mechanics.switched.switches import Guard, Transition
    from ...mechanics.system import MechanicalSystem
    from ..coordinates import Coordinates


#: What scenes with switches have no answer for, by place, with the reason.
WITHOUT_SWITCHES = {
    "boundary": "values at both ends determine the motion of one phase only",
    "least_energy": "the input of least energy is that of one phase only",
    "output.certify": "exact arithmetic does not follow the motion through its phases; the errors of events and values are estimated",
    "output.formula": "there is no formula for a motion through several phases",
}


def refuse_with_switches(table, shapers: Sequence, file_name: str) -> None:
    """Raise a SceneError for a request that a motion through several phases has no answer for."""
    for place, reason in WITHOUT_SWITCHES.items():
        owner, _, key = place.rpartition(".")
        if getattr(getattr(table, owner) if owner else table, key):
            with at(file_name, place):
                raise InputError(f"{reason}. Leave it out, or leave out what switches, such as contacts and friction")
    if table.time.step_domain == "discrete":
        with at(file_name, "time.step_domain"):
            raise InputError('events are located between samples, which "discrete" has not; leave it out')
    if shapers:
        with at(file_name, "motion" if any(one.shaper for one in table.motion) else "force"):
            raise InputError("input shapers are those of the modes of one phase, which change here; leave shaper out")


@dataclass(frozen=True, eq=False)
class Switching:
    """A switched system with the end of its motion.

    Attributes:
        machine: the switched system.
        end: last time of the motion, s.
        penetration: whether contacts may be penetrated at the start.
        begin: the motion just after t = 0.
        phase: those for which linear analyses answer.
    """

    machine: SwitchedSystem
    end: float
    penetration: bool
    begin: SwitchedMotion
    phase: tuple[str, ...]

    def solve(self, initial: np.ndarray, force: ImpulsiveSmooth | None) -> SwitchedMotion:
        """The motion through all phases."""
        return self.machine.solve(initial[0], initial[1], force, end=self.end, penetration=self.penetration)

    @property
    def start(self) -> tuple[str, ...]:
        """The states of the switches just after t = 0."""
        return self.begin.solution.sequence.key

    @property
    def label(self) -> str:
        """The phase for which linear analyses answer, in words."""
        return f"{self.machine.machine.label(self.phase)}{' (at the start)' if self.phase == self.start else ''}"

    @property
    def note(self) -> str:
        """The phase whose modes a table lists."""
        is_long = self.phase == self.start and len(self.phase) > 1
        return "Of the phase at the start." if is_long else f"Of the phase {self.label}."

    @property
    def rows(self) -> tuple[ConstraintRow, ...]:
        """The constraint rows of all phases, and the directions of the forces of switches."""
        others = (row for system in (self.machine.machine.systems or {}).values() for row in system.rows)
        return tuple({row.name: row for row in (*others, *self.begin._reaction_rows)}.values())

    @property
    def has_rows(self) -> bool:
        """Whether a phase has constraint rows, or a switch a force of its own: both are reactions."""
        systems = self.machine.phases.values() or (self.machine.system,)
        states = (state for switch in self.machine.switches for state in switch.states.values())
        return any(system.rows for system in systems) or any(state.rows or state.branches for state in states)

    @property
    def reason(self) -> str:
        """The numbers of switches, or of phases and transitions, for the plan."""
        if self.machine.phases:
            size = f"{counted(len(self.machine.phases), 'phase')}, {counted(len(self.machine.transitions), 'transition')}"
        else:
            names = ", ".join(switch.name for switch in self.machine.switches)
            size = f"{counted(len(self.machine.switches), 'switch', 'switches')} ({names})"
        return f"{size}; each phase is made when the motion enters it"

    @property
    def notice(self) -> Notice:
        text = f"modes and responses are those of the phase {self.label}, as if nothing switched; linear_phase below [model] chooses another"
        return Notice(NoticeKind.OMITTED, text)


def switching_of(table, machine: SwitchedSystem, initial: np.ndarray, force, file_name: str) -> Switching:
    """The switched system of a scene, its start checked, and the phase that the model names for linear analyses."""
    end, penetration = table.time.end if table.time.is_given else np.inf, table.initial.penetration
    with at(file_name, "initial"):
        begin = machine.solve(*initial, force, end=EPS * (end if np.isfinite(end) else 1.0), penetration=penetration)
    with at(file_name, "model.linear_phase"):
        phase = _named_phase(machine, begin.solution.sequence.key, table.model.linear_phase)
    return Switching(machine, end, penetration, begin, phase)


def _named_phase(machine: SwitchedSystem, start: tuple[str, ...], given: str | Mapping[str, str] | None) -> tuple[str, ...]:
    """The states of all switches: those given, the others as at the start."""
    if given is None:
        return start
    names = [switch.name for switch in machine.switches]
    if not isinstance(given, Mapping):
        if len(names) > 1:
            raise InputError(f'found {shown(given)}; expected states by name, such as {{ "{names[0]}" = "{start[0]}" }}')
        given = {names[0]: given}
    for name in given:
        known(name, names, "switch")
    phase = tuple(given.get(name, state) for name, state in zip(names, start))
    machine.phase(*phase)
    return phase


def known(name: str, names: Iterable[str], what: str) -> str:
    """A name among others, or an InputError."""
    names = list(names)
    if name not in names:
        raise InputError(f"there is no {what} {shown(name)}{nearest(name, names)}; there are {', '.join(names)}")
    return name


def transition_of(
    table, systems: Mapping[str, MechanicalSystem], coordinates: Coordinates, number: int, file_name: str
) -> Transition:
    from ...mechanics.switched.switches import Transition

    place = f"model.transition[{number}]"
    with at(file_name, f"{place}.from"):
        source = systems[known(table.source, systems, "phase")]
    with at(file_name, f"{place}.to"):
        known(table.target, systems, "phase")
    if table.when is not None:  # names first: without them the limit has no unit
        with at(file_name, place):
            named = Transition(
                table.source, table.target, table.when, above=0.0, quantity=table.quantity, restitution=table.restitution
            )
            named.guard(source)
    limits = {}
    for side in Transition.SIDES:
        if (value := getattr(table, side)) is not None:
            with at(file_name, f"{place}.{side}"):
                limits[side] = quantity(value, _unit_of(table, source, coordinates)) if isinstance(value, str) else value
    with at(file_name, place):
        return Transition(
            table.source,
            table.target,
            table.when,
            at=table.at,
            quantity=table.quantity,
            restitution=table.restitution,
            dwell=table.dwell,
            **limits,
        )


def _unit_of(table, source: MechanicalSystem, coordinates: Coordinates) -> str:
    """The unit of the output of a transition."""
    rows = {row.name: force_unit(row.unit) for row in source.rows}
    order = int(table.quantity == "velocity")
    own = {name: rate_unit(unit, order) for name, unit in zip(coordinates.names, coordinates.units)}
    of_rows = table.quantity == "reaction" or (table.quantity is None and not set(table.when or ()) <= set(own))
    units = {(rows if of_rows else own).get(name, "1") for name in table.when or ()}
    return units.pop().replace(" ", "*") if len(units) == 1 else "1"


def phase_system(switching: Switching) -> MechanicalSystem:
    return switching.machine.phase(*switching.phase)


# Guards that are never reached, as far as the rows of a phase, the times and the graph of phases decide it.


def never_notices(switching: Switching) -> tuple[Notice, ...]:
    """Notices on transitions that cannot take place, and on phases that none leads to."""
    return (*_late(switching), *(_unreachable(switching) if switching.machine.phases else _constant_switches(switching)))


def final_notices(switching: Switching) -> tuple[Notice, ...]:
    """Notices on the phases that can be entered and that no transition leaves."""
    machine = switching.machine
    sources = {one.source for one in machine.transitions}
    final = [name for name in _reached(switching) if name not in sources] if machine.phases else []
    return tuple(Notice(NoticeKind.SWITCH, f'nothing leaves the phase "{name}"') for name in final)


def _late(switching: Switching) -> Iterator[Notice]:
    """Changes at times after the end."""
    for switch in switching.machine.switches:
        for change in switch.times:
            if change.time > switching.end:
                what = f'transition to "{change.target}"' if switching.machine.phases else f"{switch.name} {change.text}"
                text = f"{what}: at {change.time:g} s, after the last time, {switching.end:g} s"
                yield Notice(NoticeKind.OMITTED, text)


def _possible(switching: Switching) -> list[Transition]:
    """The transitions that the times and the rows of their phases do not exclude."""
    machine = switching.machine
    possible = []
    for one in machine.transitions:
        late = one.at is not None and one.at > switching.end
        constant = None if one.at is not None else _constant(one.guard(machine.phases[one.source]), machine.phases[one.source].rows)
        if not late and (constant is None or constant <= 0):
            possible.append(one)
    return possible


def _reached(switching: Switching) -> list[str]:
    """The phases that transitions lead to from the start."""
    edges, reached = _possible(switching), list(switching.machine.switches[0].states)[:1]
    for name in reached:
        reached += dict.fromkeys(one.target for one in edges if one.source == name and one.target not in reached)
    return reached


def _unreachable(switching: Switching) -> Iterator[Notice]:
    machine, possible, reached = switching.machine, _possible(switching), _reached(switching)
    for one in machine.transitions:
        if one not in possible and one.at is None:
            text = f'the transition from "{one.source}" to "{one.target}" never takes place: the rows of "{one.source}" keep its output constant'
            yield Notice(NoticeKind.SWITCH, text)
    for name in machine.phases:
        if name not in reached:
            yield Notice(NoticeKind.SWITCH, f'the phase "{name}" is never entered: no transition that can take place leads to it')


def _constant_switches(switching: Switching) -> Iterator[Notice]:
    machine = switching.machine
    for switch, state in zip(machine.switches, switching.start):
        guards = switch.states[state].guards
        constant = [_constant(guard, machine.system.rows) for guard in guards]
        if guards and not switch.times and all(value is not None and value > 0 for value in constant):
            yield Notice(
                NoticeKind.SWITCH,
                f'{switch.name} remains in the state "{state}": the constraint rows keep its bodies at one distance',
            )


def _constant(guard: Guard, rows: Sequence[ConstraintRow]) -> float | None:
    """The value of a guard that constraint rows with constant right-hand sides determine; None where they do not, 0 within rounding errors."""
    if guard.reactions:
        return None
    total, size = -guard.value, abs(guard.value)
    for order, output in enumerate((guard.displacement, guard.velocity)):
        own = [row for row in rows if row.signal is None and row.order <= order]
        A = np.array([row.coefficients for row in own]).reshape(-1, len(output))
        factors = np.linalg.lstsq(A.T, output, rcond=None)[0]
        if np.abs(factors @ A - output).max() > noise_of(float(np.abs(output).max()), len(output)):
            return None
        terms = factors * np.array([row.value if row.order == order else 0.0 for row in own])
        total, size = total + terms.sum(), size + np.abs(terms).sum()
    return 0.0 if abs(total) <= noise_of(size, len(guard.displacement)) else total
