"""The [[force]] tables as expressions in t, with parameters as symbols."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .files import record_of
from .forces import amplitude_of, value_of
from .problems import at
from .values import FORCE_UNITS, Coordinates

if TYPE_CHECKING:
    from ..exact.formulas.symbols import Symbols


def exact_force(
    tables: Sequence, coordinates: Coordinates, symbols: Symbols, folder: Path, file_name: str, *, inputs: bool = False
) -> list[Any]:
    """The sum of the forces on each coordinate, or of the signals on each input.

    Raises:
        SceneError: a record too long for a formula.
    """
    from ..exact.formulas import signals

    found = [symbols.of(0)] * len(coordinates.names)
    for number, table in enumerate(tables, 1):
        with at(file_name, f"force[{number}]"):
            place = coordinates.number(table.coordinate)
            unit = coordinates.units[place] if inputs else FORCE_UNITS.get(coordinates.units[place])
            signal = _signal(table, unit, symbols, folder, signals)
            found[place] = found[place] + signals.begun(signal, symbols.time, symbols.of(table.delay))
    return found


def _signal(table, unit: str | None, symbols: Symbols, folder: Path, signals) -> Any:
    t, of = symbols.time, symbols.of
    if table.kind == "sampled":
        times, values = (table.times, table.values) if table.file is None else record_of(table, folder)
        values = [
            value_of(value, f"values[{number}]", unit) if table.file is None else value for number, value in enumerate(values, 1)
        ]
        return signals.sampled([of(_plain(time)) for time in times], [of(_plain(value)) for value in values], t)
    value = of(amplitude_of(table, unit))
    if table.kind == "pulse":
        return signals.pulse(value, t, of(table.start), of(table.duration))
    if table.kind in ("impulse", "power"):
        return signals.impulse(value, t, table.order) if table.kind == "impulse" else signals.power_input(value, t, table.gamma)
    return signals.term(value, t, **_TERMS[table.kind](table, symbols, signals))


def _plain(value):
    """A number of NumPy as one of Python."""
    return value.item() if hasattr(value, "item") else value


def _frequency(table, symbols: Symbols) -> Any:
    if table.angular_frequency is not None:
        return symbols.of(table.angular_frequency)
    return 2 * symbols.pi * symbols.of(0 if table.frequency is None else table.frequency)  # 0 may be the default of a parameter


def _cosine(table, symbols: Symbols, signals) -> dict:
    return {"frequency": _frequency(table, symbols), "phase": signals.angle(symbols.of(table.phase))}


_TERMS = {
    "step": lambda table, symbols, signals: {},
    "ramp": lambda table, symbols, signals: {"power": 1},
    "harmonic": _cosine,
    "term": lambda table, symbols, signals: {
        "power": table.power,
        "rate": symbols.of(table.rate),
        **_cosine(table, symbols, signals),
    },
}
