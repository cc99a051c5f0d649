"""Scenes whose equations change: the switched system, the end of its motion, and the phase for which linear analyses answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import counted, nearest
from ...ground.errors import InputError, shown
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS
from ...signals.impulsive import ImpulsiveSmooth
from ..file import at

if TYPE_CHECKING:
    from ...mechanics.switched.switched_motion import SwitchedMotion
    from ...mechanics.switched.switched_system import SwitchedSystem
    from ...mechanics.system import MechanicalSystem


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
    def has_rows(self) -> bool:
        """Whether a phase has constraint rows, and so reactions."""
        systems = self.machine.phases.values() or (self.machine.system,)
        states = (state for switch in self.machine.switches for state in switch.states.values())
        return any(system.rows for system in systems) or any(state.rows for state in states)

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
        """The phase for which a linear analysis answers."""
        text = f"modes and responses are those of the phase {self.label}, as if nothing switched; linear_phase below [model] chooses another"
        return Notice(NoticeKind.OMITTED, text)


def switching_of(table, machine: SwitchedSystem, initial: np.ndarray, force, file_name: str) -> Switching:
    """The switched system of a scene, its start checked, and the phase that the model names for linear analyses."""
    end, penetration = table.time.end, table.initial.penetration
    with at(file_name, "initial"):
        begin = machine.solve(*initial, force, end=EPS * end, penetration=penetration)
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
        if name not in names:
            raise InputError(f"there is no switch {shown(name)}{nearest(name, names)}; there are {', '.join(names)}")
    phase = tuple(given.get(name, state) for name, state in zip(names, start))
    machine.phase(*phase)
    return phase


def phase_system(switching: Switching) -> MechanicalSystem:
    """The equations of the phase for linear analyses."""
    return switching.machine.phase(*switching.phase)
