"""Forces and prescribed motions of the [[force]] and [[motion]] tables as signals with units."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import reduce
from operator import add
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import nearest
from ...ground.errors import InputError, named, shown
from ...mechanics.constraints import LEVELS, Constraint
from ...mechanics.input_shaper import InputShaper, input_shaper
from ...signals import inputs as signals
from ..coordinates import FORCE_UNITS, Coordinates, force_value, with_time
from ..file import SceneFolder, at
from .data_files import record_of

if TYPE_CHECKING:
    from ...mechanics.modes import Modes
    from ...robot.linearized import LinearizedRobot

#: Input shapers by the number of the table that has them.
Shapers = Mapping[int, InputShaper]
NONE_SHAPED: Shapers = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class SceneForce:
    """The force of one [[force]] table at one of its places."""

    name: str  # name of the coordinate or input
    unit: str  # unit of the displacement along which the force works
    direction: np.ndarray  # the generalized forces of a unit force, shape (r,)
    signal: signals.ImpulsiveSmooth  # the force over time, one row


def loads_of(
    tables: Sequence,
    coordinates: Coordinates,
    folder: SceneFolder,
    file_name: str,
    robot: LinearizedRobot | None = None,
    shapers: Shapers = NONE_SHAPED,
) -> tuple[SceneForce, ...]:
    loads = []
    for number, table in enumerate(tables, 1):
        with at(file_name, f"force[{number}]"):
            places = _places(table, coordinates, robot)
            signal = _signal(table, FORCE_UNITS.get(_common_unit(places)), folder, shapers.get(number))
            for name, (direction, unit) in places.items():
                factor = table.places[name]
                loads.append(SceneForce(name, unit, direction, signal if factor == 1 else factor * signal))
    return tuple(loads)


def _places(table, coordinates: Coordinates, robot: LinearizedRobot | None) -> dict[str, tuple[np.ndarray, str]]:
    """The generalized forces of a unit force at each place of a [[force]] table, and the unit of the displacement along it."""
    directions = (robot.inputs, robot.input_units) if robot else ({}, {})
    return {name: _direction(name, coordinates, *directions) for name in table.places}


def _direction(name: str, coordinates: Coordinates, rows: Mapping, units: Mapping) -> tuple[np.ndarray, str]:
    """The row over the coordinates and the unit of a named input or output of a robot, or of a coordinate."""
    if name in rows:
        return rows[name], units[name]
    index = coordinates.number(name, *rows)
    return np.eye(len(coordinates.names))[index], coordinates.units[index]


def _common_unit(places: Mapping[str, tuple[np.ndarray, str]]) -> str:
    """The unit of all places of a load."""
    (first, (_, unit)), *others = places.items()
    other = next((name for name, (_, own) in others if own != unit), None)
    if other is not None:
        raise InputError(
            f"factors: {shown(first)} and {shown(other)} have the units {unit} and {places[other][1]}, so that one signal cannot be "
            "both forces; give them as two [[force]] tables"
        )
    return unit


def load_patterns(
    tables: Sequence, coordinates: Coordinates, known: Collection[str], file_name: str, robot: LinearizedRobot | None = None
) -> dict[str, tuple[np.ndarray, str]]:
    """The loads by factors as inputs of a system."""
    patterns: dict[str, tuple[np.ndarray, str]] = {}
    for number, table in enumerate(tables, 1):
        if table.factors is None:
            continue
        with at(file_name, f"force[{number}]"):
            name, places = table.title, _places(table, coordinates, robot)
            pattern = sum(factor * places[place][0] for place, factor in table.places.items())
            if name in known:
                raise InputError(f"name: {shown(name)} is the name of a coordinate, a row or an input; choose another one")
            if name in patterns and (patterns[name][0] != pattern).any():
                raise InputError(f"name: a load by other factors has the name {shown(name)}, too; choose another one")
            patterns[name] = pattern, _common_unit(places)
    return patterns


def unbalance_loads(unbalance: np.ndarray, speed: float, coordinates: Coordinates) -> tuple[SceneForce, ...]:
    loads = []
    for place in np.flatnonzero(unbalance) if speed else ():
        u, name, unit = unbalance[place], coordinates.names[place], coordinates.units[place]
        signal = signals.harmonic([abs(u) * speed**2], angular_frequency=speed, phase=float(np.angle(u)))
        loads.append(SceneForce(name, unit, np.eye(len(unbalance))[place], signal))
    return tuple(loads)


def prescribed_motions(
    tables: Sequence,
    coordinates: Coordinates,
    folder: SceneFolder,
    file_name: str,
    robot: LinearizedRobot | None = None,
    shapers: Shapers = NONE_SHAPED,
) -> list[Constraint]:
    """The constraint rows of all [[motion]] tables."""
    directions = (robot.outputs, robot.output_units) if robot else ({}, {})
    constraints = []
    for number, table in enumerate(tables, 1):
        with at(file_name, f"motion[{number}]"):
            for row, (name, factor) in table.rows.items():
                coefficients, unit = _direction(name, coordinates, *directions)
                signal = float(factor) * _motion_signal(table, unit, folder, shapers.get(number))
                constraints.append(Constraint(coefficients, level=table.level, value=signal, names=row, unit=unit))
    return constraints


def _motion_signal(table, unit: str, folder: SceneFolder, shaper: InputShaper | None) -> signals.ImpulsiveSmooth:
    """The signal of a [[motion]] table in the unit of its level; another level that the values fit is named."""

    def of_level(level: str) -> signals.ImpulsiveSmooth:
        return _signal(table, with_time(unit, -LEVELS.index(level)), folder, shaper)

    try:
        return of_level(table.level)
    except InputError as problem:
        fitting = []
        for level in LEVELS:
            with suppress(InputError):
                of_level(level)
                fitting.append(f'; with level = "{level}" it fits')
        raise InputError(f"{problem}{''.join(fitting)}") from None


def force_of(loads: Sequence[SceneForce]) -> signals.ImpulsiveSmooth | None:
    """The sum of the generalized forces of loads; None without any."""
    return reduce(add, (load.signal.mapped(load.direction[:, None]) for load in loads)) if loads else None


def input_of(tables: Sequence, inputs: Coordinates, folder: SceneFolder, file_name: str) -> signals.ImpulsiveSmooth | None:
    """The inputs of a transfer function or state space."""
    rows, shapers = [], shapers_of(tables, "force", None, file_name)
    for number, table in enumerate(tables, 1):
        with at(file_name, f"force[{number}]"):
            places = {}
            for name, factor in table.places.items():
                if name not in inputs.names:
                    known = f"the inputs are {', '.join(inputs.names)}" if inputs.names else "the model has none: give B"
                    raise InputError(f"there is no input {shown(name)}{nearest(name, inputs.names)}; {known}")
                row = inputs.names.index(name)
                places[name] = factor * np.eye(len(inputs.names))[row], inputs.units[row]
            column = sum(direction for direction, _ in places.values())[:, None]
            rows.append(_signal(table, _common_unit(places), folder, shapers.get(number)).mapped(column))
    return reduce(add, rows) if rows else None


def shapers_of(tables: Sequence, key: str, modes: Callable[[], Modes] | None, file_name: str) -> Shapers:
    """The input shapers of [[force]] or [[motion]] tables, by the number of the table."""
    shapers = {}
    for number, table in enumerate(tables, 1):
        if (own := table.shaper) is not None:
            with at(file_name, f"{key}[{number}].shaper"):
                shapers[number] = input_shaper(_aims(own.modes, modes), own.kind, vibration_limit=own.vibration_limit)
    return shapers


def _aims(given: Sequence | None, modes: Callable[[], Modes] | None):
    """Modes of the model by number, all of them where none are given, and pairs of frequency and damping ratio."""
    if given is not None and not any(isinstance(one, int) for one in given):
        return given
    if modes is None:
        raise InputError('modes: this model has none with numbers; give frequency and damping ratio, e.g. [["0.2 Hz", 0.01]]')
    own = modes()
    if given is None:
        return own
    by_number = [mode for mode in own for _ in range(max(1, mode.shapes.shape[1]))]  # as in the table of natural frequencies
    if wrong := [one for one in given if isinstance(one, int) and one > len(by_number)]:
        raise InputError(f"modes: found {wrong[0]}; expected numbers from 1 to {len(by_number)}")
    if still := [one for one in given if isinstance(one, int) and not by_number[one - 1].eigenvalue.imag]:
        raise InputError(f"modes: mode {still[0]} does not oscillate; choose others")
    return [by_number[one - 1] if isinstance(one, int) else one for one in given]


def _signal(table, unit: str | None, folder: SceneFolder, shaper: InputShaper | None = None) -> signals.ImpulsiveSmooth:
    """The signal of a table, one row, shaped where it has a shaper."""
    signal = _unshaped(table, unit, folder)
    return signal if shaper is None else shaper.shape(signal)


def _unshaped(table, unit: str | None, folder: SceneFolder) -> signals.ImpulsiveSmooth:
    if table.kind == "sampled":
        if table.file is not None:
            record = record_of(table, unit, folder)
            with named(table.file):
                return record.signal.delayed(table.later)
        times, values = sampled_force(table, unit, folder)
        return signals.sampled(times, [values]).delayed(table.later)
    value = force_value(table.value, unit, table.time_power)
    return _SIGNALS[table.kind](table, [value]).delayed(table.later)


def sampled_force(table, unit: str | None, folder: SceneFolder) -> tuple[list, list]:
    """The record of a [[force]] table of kind "sampled"."""
    if table.file is None:
        return table.own_times, [force_value(value, unit, what=f"values[{number}]") for number, value in enumerate(table.values, 1)]
    record = record_of(table, unit, folder)
    return record.times.tolist(), record.values.tolist()


_SIGNALS: dict[str, Callable] = {
    "step": lambda t, v: signals.step(v),
    "ramp": lambda t, v: signals.ramp(v),
    "power": lambda t, v: signals.power(v, t.gamma),
    "impulse": lambda t, v: signals.impulse(v, order=t.order),
    "harmonic": lambda t, v: signals.harmonic(v, angular_frequency=t.omega, phase=t.phase),
    "term": lambda t, v: signals.term(v, power=t.power, rate=t.rate, angular_frequency=t.omega, phase=t.phase),
    "pulse": lambda t, v: signals.pulse(v, start=t.start, duration=t.duration, shape=t.shape),
}
