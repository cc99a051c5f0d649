"""From the [[force]] tables to the force: a signal for each table, on its coordinate, with its unit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from operator import add
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .. import signals
from ..checks import nearest
from ..errors import InputError
from .files import record_of
from .problems import at
from .units import quantity, shown
from .values import FORCE_UNITS, Coordinates, with_time

if TYPE_CHECKING:
    from ..models.robot import LinearizedRobot


def force_of(
    tables: Sequence, coordinates: Coordinates, folder: Path, file_name: str, robot: LinearizedRobot | None = None
) -> signals.ImpulsiveSmooth | None:
    """The sum of the [[force]] tables, each on a coordinate or an input of a robot, or None when there are none."""
    forces = []
    for number, table in enumerate(tables, 1):
        with at(file_name, f"force[{number}]"):
            row, _, signal = placed_signal(table, coordinates, folder, robot)
            forces.append(signal.mapped(row[:, None]))
    return reduce(add, forces) if forces else None


def placed_signal(
    table, coordinates: Coordinates, folder: Path, robot: LinearizedRobot | None
) -> tuple[np.ndarray, str, signals.ImpulsiveSmooth]:
    """Of one [[force]] table: how it acts on all coordinates, the unit of what it works along, and what acts, one row."""
    row, unit = _place(table.coordinate, coordinates, robot)
    return row, unit, _signal(table, FORCE_UNITS.get(unit), folder).delayed(table.delay)


def input_of(tables: Sequence, inputs: Coordinates, folder: Path, file_name: str) -> signals.ImpulsiveSmooth | None:
    """The same for the inputs of a transfer function or state space: a row for each, values in the units of the inputs."""
    found = []
    for number, table in enumerate(tables, 1):
        with at(file_name, f"force[{number}]"):
            if table.coordinate not in inputs.names:
                known = f"the inputs are {', '.join(inputs.names)}" if inputs.names else "the model has none: give B"
                hint = nearest(table.coordinate, inputs.names)
                raise InputError(f"there is no input {shown(table.coordinate)}{hint}; {known}")
            row = inputs.names.index(table.coordinate)
            signal = _signal(table, inputs.units[row], folder).delayed(table.delay)
            found.append(signal.mapped(np.eye(len(inputs.names))[:, row : row + 1]))
    return reduce(add, found) if found else None


def _place(name: str, coordinates: Coordinates, robot: LinearizedRobot | None) -> tuple[np.ndarray, str]:
    """How a force on a coordinate or input acts on all coordinates, and the unit of what it works along."""
    inputs = robot.inputs if robot else {}
    if name in inputs:
        return inputs[name], robot.input_units[name]
    number = coordinates.number(name, *inputs)
    return np.eye(len(coordinates.names))[number], coordinates.units[number]


def _signal(table, unit: str | None, folder: Path) -> signals.ImpulsiveSmooth:
    """What acts there, one row."""
    if table.kind == "sampled":
        return _record(table, unit, folder)
    return _SIGNALS[table.kind][1](table, [amplitude_of(table, unit)])


def amplitude_of(table, unit: str | None) -> float:
    """The value of a force of any kind but "sampled", on what has this unit."""
    return value_of(table.value, "value", unit, _SIGNALS[table.kind][0](table))


def value_of(value, what: str, unit: str | None, time_power: int = 0) -> float:
    """A force, times s^time_power.

    Raises:
        InputError: another kind of quantity; it says which one is wrong.
    """
    try:
        return quantity(value, with_time(unit, time_power) if unit else "1")
    except InputError as problem:
        raise InputError(f"{what}: {problem}") from None


def _record(table, unit: str | None, folder: Path) -> signals.ImpulsiveSmooth:
    if table.file is None:
        values = [value_of(value, f"values[{number}]", unit) for number, value in enumerate(table.values, 1)]
        return signals.sampled(table.times, [values])
    times, values = record_of(table, folder)
    try:
        return signals.sampled(times, [values])
    except InputError as problem:
        raise InputError(f"{table.file}: {problem}") from None


def angular_frequency(table) -> float:
    """Of a harmonic force or a term, in rad/s."""
    return table.angular_frequency or 2 * math.pi * (table.frequency or 0.0)


_SIGNALS = {  # kind: (power of seconds in the unit of its value, the signal)
    "step": (lambda t: 0, lambda t, v: signals.step(v)),
    "ramp": (lambda t: -1, lambda t, v: signals.ramp(v)),
    "power": (lambda t: 1 - t.gamma, lambda t, v: signals.power(v, t.gamma)),
    "impulse": (lambda t: t.order + 1, lambda t, v: signals.impulse(v, order=t.order)),
    "harmonic": (lambda t: 0, lambda t, v: signals.harmonic(v, angular_frequency=angular_frequency(t), phase=t.phase)),
    "term": (
        lambda t: -t.power,
        lambda t, v: signals.term(v, power=t.power, rate=t.rate, angular_frequency=angular_frequency(t), phase=t.phase),
    ),
    "pulse": (lambda t: 0, lambda t, v: signals.pulse(v, start=t.start, duration=t.duration)),
}
