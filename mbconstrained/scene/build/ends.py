"""Ends of a motion that a scene decides: boundary values, the input of least energy to a state, input shapers; with their reports."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...frequency.extrema import extrema
from ...ground.checks import counted
from ...ground.display import TextTable, number_text, with_unit
from ...ground.errors import InputError
from ...ground.notices import Notice, doubts_of
from ...ground.tolerances import NOT_DRAWN
from ...ground.units import force_unit, rate_unit
from ...mechanics.channels import channels
from ...mechanics.input_shaper import InputShaper
from ..coordinates import DERIVATIVES, Coordinates, given_values
from ..file import at
from .forces import NONE_SHAPED, SceneForce, Shapers, shapers_of
from .model import End, Equations

if TYPE_CHECKING:
    from ...mechanics.boundary import Boundary
    from ...mechanics.least_energy import LeastEnergyInput

COLUMNS = ("what", "value", "meaning")

#: The change of a frequency at which tables list what a shaper leaves of the vibration.
OFF = 0.1


@dataclass(frozen=True, eq=False)
class ShapedEnd(End):
    """Input shapers, by what they shape."""

    key, title = "shapers", "Input shapers"
    shapers: Mapping[str, InputShaper]

    def table(self, coordinates: Coordinates) -> TextTable:
        rows = tuple((on, shaper.kind, *_shaper_cells(shaper)) for on, shaper in self.shapers.items())
        columns = ("on", "kind", "modes (Hz, damping ratio)", "impulses", "left", f"left {OFF:.0%} off")
        note = "left: the vibration after the last impulse, of that without a shaper; off: with all frequencies so much higher or lower."
        return TextTable(self.title, columns, rows, note)

    def to_dict(self) -> list[dict]:
        return [
            {
                "on": on,
                "kind": one.kind,
                "modes": [{"frequency_hz": mode.frequency_hz, "damping_ratio": mode.damping} for mode in one.modes],
                "times": one.times,
                "amplitudes": one.amplitudes,
                "residual": _left(one, 1.0),
            }
            for on, one in self.shapers.items()
        ]


def _shaper_cells(shaper: InputShaper) -> tuple[str, ...]:
    modes = ", ".join(f"{mode.frequency_hz:.5g} ({mode.damping:.3g})" for mode in shaper.modes)
    listed = [f"{amplitude:.4g} at {time:.4g} s" for time, amplitude in zip(shaper.times, shaper.amplitudes)]
    impulses = ", ".join(listed) if len(listed) <= 3 else f"{len(listed)} over {number_text(shaper.duration)} s"
    off = max(_left(shaper, 1 - OFF), _left(shaper, 1 + OFF))
    return modes, impulses, *(f"{100 * left if left > NOT_DRAWN else 0.0:.3g} %" for left in (_left(shaper, 1.0), off))


def _left(shaper: InputShaper, factor: float) -> float:
    """The largest vibration that is left of a mode, its frequency times a factor."""
    return max(float(shaper.residual(factor * mode.frequency_hz, mode.damping)) for mode in shaper.modes)


def shaped(motions: Sequence, of_motions: Shapers, forces: Sequence, of_forces: Shapers) -> tuple[End, ...]:
    own = {", ".join(motions[number - 1].rows): shaper for number, shaper in of_motions.items()}
    own |= {f"force on {forces[number - 1].title}": shaper for number, shaper in of_forces.items()}
    return (ShapedEnd(own),) if own else ()


def shaped_inputs(tables: Sequence, file_name: str) -> tuple[End, ...]:
    """The end of shaped inputs of a transfer function or state space."""
    return shaped((), NONE_SHAPED, tables, shapers_of(tables, "force", None, file_name))


@dataclass(frozen=True, eq=False)
class BoundaryEnd(End):
    """Two-point boundary values."""

    key, title = "boundary", "Boundary values"
    unproved = "the error follows from the condition of the boundary values"
    boundary: Boundary

    @property
    def duration(self) -> float:  # type: ignore[override]
        return self.boundary.duration

    @property
    def notices(self) -> tuple[Notice, ...]:  # type: ignore[override]
        return self.boundary.notices

    @property
    def uncertified(self) -> str:  # type: ignore[override]
        own = self.boundary
        determined = not own.undetermined and own.rank == len(own.conditions)
        return "" if determined else "the boundary values are not as many independent ones as there are free amounts"

    def table(self, coordinates: Coordinates) -> TextTable:
        own = self.boundary
        given = (
            (
                one.text,
                coordinates.text(one.value, rate_unit(coordinates.units[one.coordinate], one.order), one.coordinate),
                "given",
            )
            for one in own.conditions
        )
        free = len(own.undetermined)
        evidence = (
            ("T", f"{number_text(own.duration)} s", "time between start and end"),
            ("independent conditions", str(own.rank), counted(free, "motion") + " free" if free else "they determine the motion"),
            ("condition number", f"{own.condition:.2g}", "of the conditions, scaled"),
            ("residual", f"{own.residual:.2g}", "largest difference from a given value, relative"),
            ("error estimate", f"{own.error:.2g}", "relative error of the values at both ends"),
        )
        return TextTable(self.title, COLUMNS, (*given, *evidence))

    def to_dict(self) -> dict:
        own = self.boundary
        given = [
            {"of": one.text, "order": one.order, "at": "end" if one.at_end else "start", "value": one.value}
            for one in own.conditions
        ]
        return {
            "duration": own.duration,
            "conditions": given,
            "rank": own.rank,
            "free": len(own.undetermined),
            "condition_number": own.condition,
            "residual": own.residual,
            "error_estimate": own.error,
        }


@dataclass(frozen=True, eq=False)
class LeastEnergyEnd(End):
    """The input of least energy to a state."""

    key, title = "least_energy", "Input of least energy"
    input: LeastEnergyInput
    units: tuple[str, ...]  # of the inputs

    @property
    def duration(self) -> float:  # type: ignore[override]
        return self.input.duration

    @property
    def notices(self) -> tuple[Notice, ...]:  # type: ignore[override]
        return (*self.input.notices, *doubts_of("the state at the end", self.input.error))

    @property
    def unit(self) -> str:
        """The unit of the energy."""
        first, *others = self.units
        alike = first != "1" and all(one == first for one in others)
        return " ".join([*(f"{part}^2" for part in first.split()), "s"]) if alike else "1"

    def table(self, coordinates: Coordinates) -> TextTable:
        u = self.input
        size = extrema(u.signal.smooth, 0.0, u.duration).largest
        largest = tuple(
            (f"largest of {name}", coordinates.shown.text(float(one), unit, name), "largest modulus")
            for name, one, unit in zip(u.inputs, size, self.units)
        )
        energy = ("energy", with_unit(u.energy, self.unit), "integral of the squared input")
        evidence = (
            ("T", f"{number_text(u.duration)} s", "then the input is zero"),
            ("error at the end", f"{u.error:.2g}", "of the largest value on the way"),
            ("condition number", f"{u.condition:.2g}", "of the scaled Gramian"),
        )
        return TextTable(self.title, COLUMNS, (energy, *largest, *evidence))

    def to_dict(self) -> dict:
        u = self.input
        return {
            "duration": u.duration,
            "inputs": list(u.inputs),
            "energy": u.energy,
            "unit": self.unit,
            "error_at_end": u.error,
            "condition_number": u.condition,
        }


def with_end(table, equations: Equations, file_name: str) -> Equations:
    """The equations with the motion of [boundary], or under the input of [least_energy]."""
    if table.boundary is not None:
        return _with_boundary(table.boundary, equations, file_name)
    return _with_least_energy(table.least_energy, equations, file_name)


def _with_boundary(table, equations: Equations, file_name: str) -> Equations:
    from ...mechanics.boundary import boundary_solve

    start, end = (_values(getattr(table, key), equations, f"boundary.{key}", file_name) for key in ("start", "end"))
    system = equations.system
    with at(file_name, "boundary"):
        if system is not None:
            motion = boundary_solve(system, start, end, table.duration, equations.force)
        else:
            motion = boundary_solve(equations.polynomial_matrix, start, end, table.duration, equations.right_hand_side)
    return replace(equations, initial=motion.initial, response=motion, ends=(*equations.ends, BoundaryEnd(motion.boundary)))


def _with_least_energy(table, equations: Equations, file_name: str) -> Equations:
    from ...mechanics.least_energy import least_energy_input

    end = _values(table.end, equations, "least_energy.end", file_name)
    system = equations.system
    with at(file_name, "least_energy"):
        if equations.control is not None:
            space, control = equations.control.system, equations.control
            if control.delays:
                name = next(iter(control.delays))
                raise InputError(f'the input "{name}" has a dead time, which an input of least energy has not; leave out delays')
            u = least_energy_input(space, table.inputs, control.start, end.get(DERIVATIVES[0]), table.duration, force=control.input)
            total = control.input + u.force
            units = tuple(space.units[name] for name in u.inputs)
            own = {"control": replace(control, input=total), "force": space.force_with_outputs(total)}
        elif system is None:
            raise InputError("coefficients have no states; give mass, damping and stiffness, or a state space")
        else:
            start = dict(zip(DERIVATIVES, equations.initial))
            u = least_energy_input(system, table.inputs, start, end, table.duration, force=equations.force)
            loads = tuple(_loads(u, system))
            units = tuple(force_unit(load.unit) for load in loads)
            force = u.force if equations.force is None else equations.force + u.force
            own = {"loads": (*equations.loads, *loads), "force": force, "response": u.motion}
    return replace(equations, **own, ends=(*equations.ends, LeastEnergyEnd(u, units)))


def _loads(u: LeastEnergyInput, system) -> Iterator[SceneForce]:
    known = channels(system, "inputs")
    for row, name in enumerate(u.inputs):
        channel = known[name]
        assert channel is not None
        yield SceneForce(name, channel.unit, channel.direction, u.signal.mapped(np.eye(len(u.inputs))[row : row + 1]))


def _values(table, equations: Equations, where: str, file_name: str) -> dict[str, dict[str, float]]:
    """The values of one end in SI, by order and name."""
    is_space, degree = equations.control is not None, equations.polynomial_matrix.degree
    by_order = {}
    for key in (*DERIVATIVES[:3], "state"):
        if not (row := getattr(table, key)):
            continue
        with at(file_name, f"{where}.{key}"):
            if is_space != (key == "state"):
                own = "state, e.g. state = { x1 = 0.1 }" if is_space else "displacement and velocity"
                raise InputError(f"the ends of this model are given as {own}")
            order = 0 if is_space else DERIVATIVES.index(key)
            if order >= max(degree, 1):
                raise InputError(f"the equations have degree {degree}: their states end with {DERIVATIVES[max(degree, 1) - 1]}")
            by_order[DERIVATIVES[order]] = given_values(row, equations.coordinates, order)
    return by_order
