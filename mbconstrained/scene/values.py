"""Values whose unit depends on the coordinate they belong to: starts and constraint values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..checks import nearest
from ..errors import InputError
from ..mechanics.constraint import LEVELS
from ..tolerances import noise_of
from .origins import EntryError
from .problems import at
from .units import quantity, shown

DERIVATIVES = ("displacement", "velocity", "acceleration", "jerk")
FORCE_UNITS = {"m": "N", "rad": "N*m"}


def derivative_name(unit: str, order: int) -> str:
    """What the derivative of a coordinate of this unit is called.

    >>> derivative_name("m", 1), derivative_name("rad", 0), derivative_name("N", 0), derivative_name("m", 5)
    ('velocity', 'angle', 'value', 'derivative 5')
    """
    if order >= len(DERIVATIVES) or unit not in FORCE_UNITS:
        return "value" if order == 0 else f"derivative {order}"
    if unit == "m":
        return DERIVATIVES[order]
    return "angle" if order == 0 else f"angular {DERIVATIVES[order]}"


def with_time(unit: str, power: int) -> str:
    """A unit times s^power.

    >>> with_time("m", -2), with_time("N", 1), with_time("1", -1)
    ('m/s^2', 'N*s', '1/s')
    """
    if power == 0:
        return unit
    seconds = "s" if abs(power) == 1 else f"s^{abs(power)}"
    if power < 0:
        return f"{unit}/{seconds}"
    return seconds if unit == "1" else f"{unit}*{seconds}"


@dataclass(frozen=True)
class Coordinates:
    """Names of coordinates with their SI units."""

    names: tuple[str, ...]
    units: tuple[str, ...]

    def number(self, name: str, *others: str) -> int:
        """The place of a coordinate; the others are names that could have stood there as well.

        Raises:
            InputError: no such coordinate.
        """
        if name not in self.names:
            hint = nearest(name, (*self.names, *others))
            inputs = f", the inputs {', '.join(others)}" if others else ""
            raise InputError(f"there is no coordinate {shown(name)}{hint}; the coordinates are {', '.join(self.names)}{inputs}")
        return self.names.index(name)

    @property
    def listed(self) -> str:
        """All names with their units, but for the unit 1."""
        return ", ".join(name if unit == "1" else f"{name} ({unit})" for name, unit in zip(self.names, self.units))

    def derivative_unit(self, index: int, order: int) -> str:
        """The unit of a derivative of a coordinate, e.g. m/s^2."""
        return with_time(self.units[index], -order)


def initial_values(table, coordinates: Coordinates, degree: int, file_name: str) -> np.ndarray:
    """x^(i)(0-) as row i, shape (degree, r), from the [initial] table."""
    return initial_entries(table, coordinates, degree, file_name).astype(float)


def initial_entries(table, coordinates: Coordinates, degree: int, file_name: str) -> np.ndarray:
    """The same with the entries that are expressions of parameters as such."""
    rows = table.rows
    result = np.full((degree, len(coordinates.names)), 0.0, dtype=object)
    for order, row in enumerate(rows):
        key = DERIVATIVES[order] if table.derivatives is None else f"derivatives[{order + 1}]"
        with at(file_name, f"initial.{key}"):
            if order >= degree and row:
                raise InputError(f"the equations have degree {degree}: they start from {_start_names(degree)}, nothing higher")
            result[order] = _row(row, coordinates, order)
    return result


def state_values(given, states: Coordinates, file_name: str) -> np.ndarray:
    """x(0-), shape (n,), from the state of the [initial] table."""
    return state_entries(given, states, file_name).astype(float)


def state_entries(given, states: Coordinates, file_name: str) -> np.ndarray:
    """The same with the entries that are expressions of parameters as such."""
    with at(file_name, "initial.state"):
        for name in given if isinstance(given, dict) else ():
            if name not in states.names:
                hint = nearest(name, states.names)
                raise InputError(f"there is no state {shown(name)}{hint}; the states are {', '.join(states.names)}")
        return _row(given or {}, states, 0)


def _start_names(degree: int) -> str:
    return "no values" if degree == 0 else ", ".join(DERIVATIVES[:degree])


def _row(row: dict | list, coordinates: Coordinates, order: int) -> np.ndarray:
    if isinstance(row, list):
        if len(row) != len(coordinates.names):
            names = ", ".join(coordinates.names)
            raise InputError(f"found {len(row)} values; expected {len(coordinates.names)}, one for each of {names}")
        row = dict(zip(coordinates.names, row))
    values = np.full(len(coordinates.names), 0.0, dtype=object)
    for name, value in row.items():
        try:
            index = coordinates.number(name)
        except InputError as problem:
            raise EntryError(str(problem), name) from None
        try:
            values[index] = quantity(value, coordinates.derivative_unit(index, order))
        except InputError as problem:
            raise EntryError(f"{name}: {problem}", name) from None
    return values


def beyond_noise(jump: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Indices of the jumps that are more than the rounding of the values that they lie between."""
    size = max(np.abs(values).max(initial=0.0) for values in (before, after))
    return np.flatnonzero(np.abs(jump) > noise_of(size, len(jump)))


def constraint_value(table, coordinates: Coordinates) -> float:
    """The right hand side of a constraint row: a unit is understood where all its coordinates have the same."""
    power = LEVELS.index(table.level)
    units = {coordinates.derivative_unit(coordinates.number(name), power) for name in table.rows}
    if isinstance(table.value, str) and len(units) > 1:
        raise InputError(f"value: found {shown(table.value)}; this row mixes {' and '.join(sorted(units))}: give a plain number")
    try:
        return quantity(table.value, units.pop())
    except InputError as problem:
        raise InputError(f"value: {problem}") from None
