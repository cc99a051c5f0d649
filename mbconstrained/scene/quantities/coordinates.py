"""Coordinates of a model: names, units and derivatives, and the initial values, constraint values and forces with these units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...ground.checks import nearest
from ...ground.coordinate_units import DERIVATIVES, rate_unit
from ...ground.errors import InputError, named, shown
from ...ground.quantities import quantity
from ...ground.tolerances import noise_of
from ...models.elements import row_in_si
from ..file import EntryError, at
from .output_units import OutputUnits

FORCE_UNITS = {"m": "N", "rad": "N*m", "C": "V", "A": "V", "V": "A"}


def with_time(unit: str, power: int) -> str:
    """A unit times s^power.

    >>> with_time("m", -2), with_time("N", 1), with_time("1", -1)
    ('m/s^2', 'N*s', '1/s')
    """
    if power <= 0:
        return rate_unit(unit, -power)
    seconds = "s" if power == 1 else f"s^{power}"
    return seconds if unit == "1" else f"{unit}*{seconds}"


@dataclass(frozen=True)
class Coordinates:
    """Names of coordinates with their SI units, and their displayed units."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    shown: OutputUnits = OutputUnits()

    def number(self, name: str, *others: str) -> int:
        """The number of a coordinate, from 0; an InputError names the others, and those that may stand there as well."""
        if name not in self.names:
            hint = nearest(name, (*self.names, *others))
            inputs = f", the inputs {', '.join(others)}" if others else ""
            raise InputError(f"there is no coordinate {shown(name)}{hint}; the coordinates are {', '.join(self.names)}{inputs}")
        return self.names.index(name)

    @property
    def listed(self) -> str:
        """Names of all coordinates with their units, except the unit 1."""
        units = (self.shown.of(unit, name)[0] for unit, name in zip(self.units, self.names))
        return ", ".join(name if unit == "1" else f"{name} ({unit})" for name, unit in zip(self.names, units))

    def text(self, value: float, unit: str, place: int) -> str:
        """A value in SI of the coordinate at a place, or of a derivative of it, as a text in the unit shown."""
        return self.shown.text(value, unit, self.names[place])

    def to_list(self) -> list[dict[str, str]]:
        return [{"name": name, "unit": unit} for name, unit in zip(self.names, self.units)]


def beyond_noise(jump: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The jumps that exceed rounding errors."""
    size = max(np.abs(values).max(initial=0.0) for values in (before, after))
    return np.flatnonzero(np.abs(jump) > noise_of(size, len(jump)))


def initial_values(table, coordinates: Coordinates, degree: int, file_name: str) -> np.ndarray:
    """The values at 0- of the [initial] table."""
    result = np.full((degree, len(coordinates.names)), 0.0, dtype=object)
    for order, row in enumerate(table.rows):
        key = DERIVATIVES[order] if table.derivatives is None else f"derivatives[{order + 1}]"
        with at(file_name, f"initial.{key}"):
            if order >= degree and row:
                start = ", ".join(DERIVATIVES[:degree]) or "no values"
                raise InputError(f"the equations have degree {degree}: they start from {start}, nothing higher")
            result[order] = _row(row, coordinates, order)
    return result


def state_values(given: dict | list, states: Coordinates, file_name: str) -> np.ndarray:
    """The states at 0- of the [initial] table."""
    with at(file_name, "initial.state"):
        for name in given if isinstance(given, dict) else ():
            if name not in states.names:
                hint = nearest(name, states.names)
                raise InputError(f"there is no state {shown(name)}{hint}; the states are {', '.join(states.names)}")
        return _row(given or {}, states, 0)


def _row(row: dict | list, coordinates: Coordinates, order: int) -> np.ndarray:
    values = np.full(len(coordinates.names), 0.0, dtype=object)
    for name, value in given_values(row, coordinates, order).items():
        values[coordinates.names.index(name)] = value
    return values


def given_values(row: dict | list, coordinates: Coordinates, order: int) -> dict[str, Any]:
    """The values of a row in SI by name, those that are not given left out."""
    if isinstance(row, list):
        if len(row) != len(coordinates.names):
            names = ", ".join(coordinates.names)
            raise InputError(f"found {len(row)} values; expected {len(coordinates.names)}, one for each of {names}")
        row = dict(zip(coordinates.names, row))
    values = {}
    for name, value in row.items():
        try:
            index = coordinates.number(name)
            with named(name):
                values[name] = quantity(value, rate_unit(coordinates.units[index], order))
        except InputError as problem:
            raise EntryError(str(problem), name) from None
    return values


def constraint_row(table, coordinates: Coordinates) -> tuple[dict, Any, str | None]:
    """The factors and the right-hand side of a constraint row of a table in SI."""
    for name in table.coefficients:
        coordinates.number(name)
    return row_in_si(table.coefficients, table.value, table.level, dict(zip(coordinates.names, coordinates.units)))


def force_value(value, unit: str | None, time_power: int = 0, what: str = "value") -> float:
    """A force times s^time_power in SI."""
    with named(what):
        return quantity(value, with_time(unit, time_power) if unit else "1")
