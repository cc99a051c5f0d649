"""The tables of a result, as texts with units: for the terminal and the page alike."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..mechanics.units import force_unit, impulse_unit, rate_unit
from ..tolerances import noise_of
from .values import beyond_noise, derivative_name

if TYPE_CHECKING:
    from .result import Result


@dataclass(frozen=True)
class TextTable:
    """A table of texts.

    Attributes:
        title: its heading.
        columns: headings.
        rows: texts, one for each column.
        note: a sentence below, or an empty string.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def tables_of(result: Result) -> list[TextTable]:
    """Constraints, zeros, jumps, impulses and evidence; those without rows are left out, but for the zeros."""
    tables = [constraint_table(result), zero_table(result), jump_table(result), impulse_table(result), evidence_table(result)]
    return [table for table in tables if table.rows or table.title == "Zeros"]


def number(value: float) -> str:
    """A number to six digits.

    >>> number(-0.0), number(1 / 3)
    ('0', '0.333333')
    """
    return f"{value + 0.0:.6g}"


def constraint_table(result: Result) -> TextTable:
    """The rows in force with their levels."""
    rows = result.system.rows if result.system else ()
    cells = tuple((row.name, row.level, f"{number(row.value)} {rate_unit(row.unit, row.order)}") for row in rows)
    note = "Rows held for velocities or accelerations keep what is wrong at the start: their zeros at 0 are drift."
    drifting = any(row.order for row in rows)
    return TextTable("Constraints", ("row", "held for", "value"), cells, note if drifting else "")


def zero_table(result: Result) -> TextTable:
    """The finite zeros of A(s), with their meaning where the system is mechanical."""
    rows = result.modes.table() if result.system else [_plain_row(zero) for zero in result.finite_pair.zeros]
    columns = tuple(rows[0]) if rows else ()
    note = "" if rows else "There are none: the motion follows the force at once."
    return TextTable("Zeros", columns, tuple(tuple(row.values()) for row in rows), note)


def _plain_row(zero) -> dict[str, str]:
    """A zero of coefficients of which it is not known what they stand for; the columns are those of ``Modes.table``."""
    value, size, pair = _without_noise(zero.value), abs(zero.value), bool(zero.value.imag)
    real = number(value.real) if value.real or not pair else ""
    return {
        "kind": _plain_kind(value),
        "zero (1/s)": " ".join(filter(None, (real, f"± {number(value.imag)} i" if pair else ""))),
        "frequency (Hz)": number(size / math.tau) if pair else "",
        "angular frequency (rad/s)": number(size) if pair else "",
        "damping ratio": f"{-value.real / size + 0.0:.4g}" if pair else "",
        "multiplicity": str(zero.multiplicity),
        "meaning": _plain_meaning(value, zero.multiplicity),
    }


def _without_noise(value: complex) -> complex:
    """The real part of a pair beside the imaginary axis is left out where it is mere rounding."""
    return complex(0.0, value.imag) if value.imag and abs(value.real) <= noise_of(abs(value)) else value


def _plain_kind(value: complex) -> str:
    if value == 0:
        return "at 0"
    if value.real > 0:
        return "growth"
    return "oscillation" if value.imag else "decay"


def _plain_meaning(value: complex, multiplicity: int) -> str:
    if value == 0:
        return "constant" if multiplicity == 1 else "constant or growing with a power of t"
    if value.imag:
        return "undamped" if not value.real else ""
    return f"time constant {number(1 / abs(value.real))} s"


def jump_table(result: Result) -> TextTable:
    """What is different just after t = 0."""
    motion, coordinates = result.motion, result.scene.equations.coordinates
    cells = []
    for order, row in enumerate(motion.jump):
        for i in beyond_noise(row, motion.initial[order], motion.start[order]):
            unit = rate_unit(coordinates.units[i], order)
            values = (motion.initial[order, i], motion.start[order, i], row[i])
            name = derivative_name(coordinates.units[i], order)
            cells.append((coordinates.names[i], name, *(f"{number(value)} {unit}" for value in values)))
    return TextTable("Jumps at t = 0", ("coordinate", "of its", "before", "after", "jump"), tuple(cells))


def impulse_table(result: Result) -> TextTable:
    """Dirac's delta and its derivatives at t = 0, in coordinates and in constraint forces."""
    coordinates = result.scene.equations.coordinates
    cells = _impulse_rows(result.motion.impulses, coordinates.names, coordinates.units)
    if result.system is not None and result.system.rows:
        rows = result.system.rows
        names, units = [f"force of {row.name}" for row in rows], [force_unit(row.unit) for row in rows]
        cells += _impulse_rows(result.motion.constraint_impulses, names, units)
    return TextTable("Impulses at t = 0", ("of", "multiplies", "size"), tuple(cells))


def _impulse_rows(impulses, names, units) -> list[tuple[str, ...]]:
    return [
        (names[i], "δ" if order == 0 else f"δ{_primes(order)}", f"{number(row[i])} {impulse_unit(units[i], order)}")
        for order, row in enumerate(impulses)
        for i in row.nonzero()[0]
    ]


def _primes(order: int) -> str:
    return "′" * order if order < 4 else f"^({order})"


def evidence_table(result: Result) -> TextTable:
    """What tells how far the answer can be trusted."""
    estimate = ("error estimate", f"{result.error_estimate:.2g}", "largest error over largest value, over all times")
    found = [(item.name, f"{item.value:.2g}", item.text) for item in result.motion.evidence]
    return TextTable("Evidence", ("what", "value", "meaning"), (estimate, *found))
