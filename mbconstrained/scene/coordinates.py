"""Coordinates of a model: names, units, derivatives, and the units shown in place of SI; initial values, constraint values and forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..ground.checks import nearest
from ..ground.display import with_unit
from ..ground.errors import InputError, named, shown
from ..ground.quantities import dimension, meant, quantity, unit_name
from ..ground.tolerances import noise_of
from ..ground.units import DERIVATIVES, rate_unit, unit_in_si
from ..models.elements import row_in_si
from .file import EntryError, at

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


# The units of page, tables and CSV files that a scene selects in place of SI units.

ACCELERATION = "m/s^2"

#: Units that are shown by another name than in the table of units.
_SHOWN = {"gn": "g", "rpm": "rev/min"}

#: Quantities that may have a unit, by the words of a scene: the SI units in which they are measured along lines and about axes.
QUANTITIES = {
    "displacement": ("m", "rad"), "velocity": ("m/s", "rad/s"), "acceleration": (ACCELERATION, "rad/s^2"), "jerk": ("m/s^3", "rad/s^3"),
    "elongation": ("m", "rad"), "length": ("m",), "angle": ("rad",), "angular velocity": ("rad/s",), "angular acceleration": ("rad/s^2",),
    "force": ("N", "N*m"), "reaction": ("N", "N*m"), "torque": ("N*m",), "moment": ("N*m",), "impulse": ("N*s", "N*m*s"),
    "stress": ("Pa",), "pressure": ("Pa",), "energy": ("J",), "power": ("W",), "mass": ("kg",), "inertia": ("kg*m^2",),
    "stiffness": ("N/m", "N*m/rad"), "damping": ("N*s/m", "N*m*s/rad"), "voltage": ("V",), "current": ("A",), "temperature": ("K",),
}  # fmt: skip


@dataclass(frozen=True)
class OutputUnits:
    """Units in place of SI units of the same kind; derivatives and products follow, so that mm implies mm/s and kN implies kN m.

    Accelerations remain in m/s^2 unless they have a unit of their own, such as mm/s^2 or g. A result may have other units by its name.

    >>> units = OutputUnits(("mm", "deg", "rpm", "kN"), (("clutch", "N*mm"),))
    >>> units.of("m/s"), units.of("N m"), units.of("rad/s")[0], units.of("J")
    (('mm/s', 1000.0), ('kN m', 0.001), 'rev/min', ('J', 1.0))
    >>> units.of("m/s^2"), OutputUnits(("mm", "mm/s^2")).of("m/s^2")
    (('m/s^2', 1.0), ('mm/s^2', 1000.0))
    >>> units.of("N m", "clutch")
    ('N mm', 1000.0)
    """

    units: tuple[str, ...] = ()  # each of another kind; none for SI
    named: tuple[tuple[str, str], ...] = ()  # names of results, each with a unit that precedes those of all

    def of(self, unit: str, name: str = "") -> tuple[str, float]:
        """The unit in place of an SI unit, which has products with a blank, with the factor of the values; of the result of this name."""
        units = (*(own for result, own in self.named if result == name), *self.units)
        for each in units if unit != "1" else ():
            if _alike(each, unit):
                return _SHOWN.get(each, each.replace("*", " ")), _factor(unit, each)
        head, slash, below = unit.partition("/")
        if head == "m" and below.startswith("s^"):  # an acceleration, or a derivative of one
            return unit, 1.0
        if below in ("m", "rad") and (shown := self.of(below))[1] != 1.0:  # a stiffness, by what its displacements are shown in
            (own, factor), (per, scale) = self.of(head), shown
            return f"{own}/{per}", factor / scale
        first, blank, further = head.partition(" ")
        for each in units if first != "1" and (blank or slash) else ():
            if _alike(each, first):
                return f"{each}{blank}{further}{slash}{below}", _factor(first, each)
        return unit, 1.0

    def of_ratio(self, unit: str, output: str = "", source: str = "") -> tuple[str, float]:
        """The unit in place of that of a response, a ratio such as m/N or N/(m/s^2), with its factor; of an output by an input.

        >>> OutputUnits(("mm", "kN")).of_ratio("m/N")
        ('mm/kN', 1000000.0)
        """
        above, slash, below = unit.partition("/(") if "/(" in unit else unit.rpartition("/")
        if not slash:
            return self.of(unit, output)
        (above, up), (below, down) = self.of(above, output), self.of(below.removesuffix(")"), source)
        return f"{above}/({below})" if any(sign in below for sign in " /") else f"{above}/{below}", up / down

    def text(self, value: float, unit: str, name: str = "") -> str:
        """A value in SI as a text in the selected unit; of the result of this name."""
        own, factor = self.of(unit, name)
        return with_unit(factor * value, own)


def output_units(value) -> OutputUnits:
    """The units of a text such as "mm, deg, rpm, kN", of a list, or of a table with the names of quantities and of results.

    In the place of an acceleration g is the standard acceleration of gravity.

    >>> output_units({"acceleration": "g", "displacement": "mm, deg", "force of clutch": "N*mm"})
    OutputUnits(units=('gn', 'mm', 'deg'), named=(('clutch', 'N*mm'),))
    """
    if isinstance(value, OutputUnits):
        return value
    if not isinstance(value, dict):
        return OutputUnits(_distinct(_listed(value)))
    units: list[str] = []
    results: list[tuple[str, str]] = []
    for key, given in value.items():
        quantity, _, name = key.partition(" of ") if key.partition(" of ")[0] in QUANTITIES else ("", "", key)
        with named(key):
            names = _listed(given)
            for unit in names:
                _check_kind(unit, key if key in QUANTITIES else quantity)
        if key in QUANTITIES:
            units += (unit for unit in names if unit not in units)
        else:
            results += ((name, unit) for unit in names)
    for name in dict(results):
        with named(name):
            _distinct([unit for result, unit in results if result == name])
    return OutputUnits(_distinct(units), tuple(results))


def _listed(value) -> list[str]:
    """The units of a text with commas, or of a list."""
    if not isinstance(value, (str, list)):
        raise InputError(f'found {shown(value)}; expected units, e.g. "mm, deg, rpm, kN"')
    names = value.split(",") if isinstance(value, str) else value
    return [meant(unit_name(name.strip() if isinstance(name, str) else name), ACCELERATION) for name in names]


def _distinct(units: Sequence[str]) -> tuple[str, ...]:
    for number, name in enumerate(units):
        if twin := next((other for other in units[:number] if _alike(other, name)), None):
            raise InputError(f'found "{_written(twin)}" and "{_written(name)}", which measure the same; give one of them')
    return tuple(units)


def _check_kind(unit: str, quantity: str) -> None:
    kinds = QUANTITIES.get(quantity, (unit,))
    if not any(_alike(unit, kind) for kind in kinds):
        raise InputError(f'found "{_written(unit)}"; expected a unit of {quantity}, such as {" or ".join(kinds)}')


def _written(unit: str) -> str:
    """A unit as a scene may have it."""
    return _SHOWN.get(unit, unit)


def _alike(one: str, other: str) -> bool:
    """Whether both units measure the same quantity; a torque in N m is no energy."""
    is_energy = [name.endswith("J") for name in (one, other)]
    return is_energy[0] == is_energy[1] and dimension(one) == dimension(other.replace(" ", "*"))


def _factor(unit: str, chosen: str) -> float:
    return float(unit_in_si(unit.replace(" ", "*"))[0] / unit_in_si(chosen)[0])


# Coordinates, and values with their units.


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
    result = np.full((degree, len(coordinates.names)), 0.0, dtype=object)
    for order, row in enumerate(table.rows):
        key = DERIVATIVES[order] if table.derivatives is None else f"derivatives[{order + 1}]"
        with at(file_name, f"initial.{key}"):
            if order >= degree and row:
                start = ", ".join(DERIVATIVES[:degree]) or "no values"
                raise InputError(f"the equations have degree {degree}: they start from {start}, nothing higher")
            for name, value in given_values(row, coordinates, order).items():
                result[order, coordinates.names.index(name)] = value
    return result


def state_values(given: dict | list, states: Coordinates, file_name: str) -> np.ndarray:
    with at(file_name, "initial.state"):
        for name in given if isinstance(given, dict) else ():
            if name not in states.names:
                hint = nearest(name, states.names)
                raise InputError(f"there is no state {shown(name)}{hint}; the states are {', '.join(states.names)}")
        values = given_values(given or {}, states, 0)
    return np.array([values.get(name, 0.0) for name in states.names], dtype=object)


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
