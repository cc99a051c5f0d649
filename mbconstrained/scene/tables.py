"""The tables of a result, as texts with units: for the terminal and the page alike."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from ..mechanics.conservation import Conservation
from ..mechanics.modes import Kind, Mode, Modes, cleaned
from ..mechanics.units import force_unit, rate_unit
from ..notices import Notice
from ..response.events import Event
from ..response.notices import counts
from ..signals import Blow
from .control_report import control_tables
from .happenings import Impulse, folded, impulses_of, jumps_of, later_jumps_of, number, sized
from .robot_report import posture_evidence, posture_tables
from .text_table import TextTable

if TYPE_CHECKING:
    from .result import Result

MOST_LATER_ROWS = 20  # of the jumps and impulses after t = 0 that are listed; JSON and npz have all


def tables_of(result: Result) -> list[TextTable]:
    """Posture, constraints, zeros, jumps, impulses, evidence, proved digits; those without rows are left out, but for the zeros."""
    at_zero = [jump_table(result), impulse_table(result)]
    posture = posture_tables(result.scene.equations.robot_scene)
    before = [*posture, constraint_table(result), _zeros_or_poles(result), *control_tables(result.scene.equations.control)]
    proved = [result.certificate.table] if result.certificate else []
    tables = [*before, *at_zero, later_table(result), evidence_table(result), *proved]
    return [table for table in tables if table.rows or table.title in ("Zeros", "Poles")]


def notices_of(result: Result) -> tuple[Notice, ...]:
    """The notices to stand beside the tables: jumps and impulses, which have tables, are counted in one sentence."""
    later = counts(_later(result))
    return folded(result.notices, len(jump_table(result).rows), len(impulse_table(result).rows), later)


def constraint_table(result: Result) -> TextTable:
    """The rows in force with their levels."""
    rows = result.system.rows if result.system else ()
    cells = tuple((row.name, row.level, sized(row.value, rate_unit(row.unit, row.order))) for row in rows)
    note = "Rows held for velocities or accelerations keep what is wrong at the start: their zeros at 0 are drift."
    drifting = any(row.order for row in rows)
    return TextTable("Constraints", ("row", "held for", "value"), cells, note if drifting else "")


def _zeros_or_poles(result: Result) -> TextTable:
    """The zeros of A(s), which are the poles of a transfer function."""
    table = zero_table(result)
    if result.scene.equations.control is None or result.system:
        return table
    return replace(table, title="Poles", columns=tuple(column.replace("zero (", "pole (") for column in table.columns))


def zero_table(result: Result) -> TextTable:
    """The finite zeros of A(s), with their meaning where the system is mechanical."""
    rows = result.modes.table() if result.system else _plain_rows(result)
    columns = tuple(rows[0]) if rows else ()
    note = "" if rows else "There are none: the motion follows the force at once."
    return TextTable("Zeros", columns, tuple(tuple(row.values()) for row in rows), note)


def _plain_rows(result: Result) -> list[dict[str, str]]:
    """Zeros of coefficients of which it is not known what they stand for, in the columns of ``Modes.table``."""
    names = result.scene.equations.coordinates.names
    modes = [_plain_mode(zero, len(names)) for zero in result.finite_pair.zeros]
    return [
        {**row, "kind": mode.kind if mode.value else "at 0", "meaning": _plain_meaning(mode.value, mode.multiplicity)}
        for mode, row in zip(modes, Modes(tuple(modes), names).table())
    ]


def _plain_mode(zero, size: int) -> Mode:
    value = cleaned(complex(zero.value), zero.multiplicity, Conservation(passive=False, lossless=False))
    return Mode(_plain_kind(value), value, zero.multiplicity, np.zeros((size, 0)))


def _plain_kind(value: complex) -> Kind:
    if value == 0:
        return "offset"
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
    found = jumps_of(result.motion, result.scene.equations.coordinates)
    cells = tuple((jump.name, jump.what, jump.before, jump.after, jump.size) for jump in found)
    return TextTable("Jumps at t = 0", ("coordinate", "of its", "before", "after", "jump"), cells)


def impulse_table(result: Result) -> TextTable:
    """Dirac's delta and its derivatives at t = 0, in coordinates and in constraint forces."""
    coordinates = result.scene.equations.coordinates
    found = impulses_of(result.motion.impulses, coordinates.names, coordinates.units)
    if result.system is not None and result.system.rows:
        found += _impulses_of_rows(result, result.motion.constraint_impulses)
    cells = tuple((impulse.name, f"δ{_primes(impulse.order)}", impulse.size) for impulse in found)
    return TextTable("Impulses at t = 0", ("of", "multiplies", "size"), cells)


def _impulses_of_rows(result: Result, impulses) -> list[Impulse]:
    rows = result.system.rows
    return impulses_of(impulses, [f"force of {row.name}" for row in rows], [force_unit(row.unit) for row in rows])


def later_table(result: Result) -> TextTable:
    """Jumps and impulses after t = 0, where the force starts, stops, changes or strikes; the first of them."""
    rows = (row for happening in _later(result) for row in _happening_rows(result, happening))
    jumps, impulses = counts(_later(result))
    note = f"The first {MOST_LATER_ROWS} of {jumps + impulses} are shown." if jumps + impulses > MOST_LATER_ROWS else ""
    columns = ("time", "of", "what", "before", "after", "size")
    return TextTable("Jumps and impulses after t = 0", columns, tuple(islice(rows, MOST_LATER_ROWS)), note)


def _later(result: Result) -> list[Event | Blow]:
    """The events of the motion and the impulses of its constraint forces, by time."""
    found = [*result.motion.events, *getattr(result.motion, "later_constraint_impulses", ())]
    return sorted(found, key=lambda happening: happening.time)


def _happening_rows(result: Result, happening: Event | Blow) -> list[tuple[str, ...]]:
    when, coordinates = f"{number(happening.time)} s", result.scene.equations.coordinates
    if isinstance(happening, Blow):
        jumps, impulses = [], _impulses_of_rows(result, happening.impulses)
    else:
        jumps = later_jumps_of(result.motion, happening, coordinates)
        impulses = impulses_of(happening.impulses, coordinates.names, coordinates.units)
    cells = [(when, jump.name, f"{jump.what} jumps", jump.before, jump.after, jump.size) for jump in jumps]
    return cells + [(when, impulse.name, f"multiplies δ{_primes(impulse.order)}", "", "", impulse.size) for impulse in impulses]


def _primes(order: int) -> str:
    return "′" * order if order < 4 else f"^({order})"


def evidence_table(result: Result) -> TextTable:
    """What tells how far the answer can be trusted."""
    estimates = [
        (f"error estimate: {_estimated(result, kind)}", f"{value:.2g}", "largest error over largest value, over all times")
        for kind, value in result.error_estimates.items()
    ]
    found = [(item.name, f"{item.value:.2g}", item.text) for item in result.motion.evidence]
    posture = posture_evidence(result.scene.equations.robot_scene)
    return TextTable("Evidence", ("what", "value", "meaning"), (*estimates, *found, *posture))


def _estimated(result: Result, kind: str) -> str:
    """States and outputs are no displacements."""
    equations = result.scene.equations
    return equations.coordinates_called if kind == "displacement" and equations.has_outputs_among_coordinates else kind
