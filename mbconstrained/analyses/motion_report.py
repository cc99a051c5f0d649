"""The tables of a motion, as texts with units, for the terminal and the page alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from ..ground.display import TextTable, number_text, with_unit
from ..ground.tolerances import SHOWN_MARGIN
from ..ground.units import rate_unit
from ..response.events import Event
from ..response.response_notices import counts
from ..scene.coordinates import Coordinates, OutputUnits
from ..scene.run.result import ReportedImpulse, Result, forces_of_rows, impulses_of, jumps_of
from ..signals.impulsive import ImpulsiveLoad

if TYPE_CHECKING:
    from ..mechanics.constraints import ConstraintRow
    from ..scene.build.control_model import ControlScene
    from ..scene.run.certificate import Certificate
    from .frequency import Frequency

LARGEST = "Largest values"
MOST_EVENT_ROWS = 200  # events that are listed
MOST_LATER_ROWS = 20  # of the jumps and impulses after t = 0 that are listed; JSON and npz have all


def tables_of(result: Result, certificate: Certificate | None, frequency: Frequency | None) -> tuple[TextTable, ...]:
    """Natural frequencies, then the answers, then, folded on the page, posture, constraints, eigenvalues and evidence.

    Empty tables are left out but for the natural frequencies."""
    equations, system = result.scene.equations, result.system
    of_model, shown = equations.tables(result), equations.coordinates.shown
    jumps = tuple((jump.name, jump.what, jump.before, jump.after, jump.size) for jump in result.jumps)
    impulses = tuple((impulse.name, f"δ{_primes(impulse.order)}", impulse.size) for impulse in result.impulses)
    answers = [
        *([result.motion.event_table(shown.text, MOST_EVENT_ROWS)] if result.is_switched else []),
        *of_model.first,
        *(end.table(equations.coordinates) for end in equations.ends),
        *([_output_table(equations.original)] if equations.original else []),
        TextTable("Jumps at t = 0", ("coordinate", "of its", "before", "after", "jump"), jumps),
        TextTable("Impulses at t = 0", ("of", "multiplies", "size"), impulses),
        *([_later_table(result)] if result.later else []),
        largest_table(result),
        *of_model.forces,
        *([frequency.peak_table()] if frequency else []),
        *([certificate.table] if certificate else []),
    ]
    details = [
        *of_model.details,
        *([_constraint_table(result.motion._constraint_rows if result.is_switched else result.rows, shown)] if system else []),
        eigenvalue_table(result),
        _evidence_table(result, of_model.evidence),
    ]
    tables = [*(table for table in answers if table.rows), *(replace(each, folded=True) for each in details if each.rows)]
    return (frequency_table(result), *tables)


def largest_table(result: Result) -> TextTable:
    """The largest value of each requested curve for summary and page, in the units of [output]."""
    shown, rows, open_ = result.scene.equations.coordinates.shown, [], 0
    for one in result.largest:
        unit, factor = shown.of(one.unit, one.name)
        is_open = one.margin > SHOWN_MARGIN * abs(one.value)
        open_ += is_open
        rows.append((one.name, one.title, f"{'≥ ' * is_open}{with_unit(factor * one.value, unit)}", f"{number_text(one.time)} s"))
    note = f"Largest moduli with their signs, of the closed form: none between the times is missed{'; ≥: of too many periods to search them all, or of modes below rounding' if open_ else ''}."
    return TextTable(LARGEST, ("of", "quantity", "largest", "at"), tuple(rows), note)


def _constraint_table(constraint_rows: Sequence[ConstraintRow], shown: OutputUnits) -> TextTable:
    """The rows in force with their levels."""
    cells = tuple(
        (
            row.name,
            row.level,
            shown.text(row.value, rate_unit(row.unit, row.order), row.name) if row.signal is None else row.right_side_text,
        )
        for row in constraint_rows
    )
    note = "Errors at the start persist in rows at velocity or acceleration level: their eigenvalues at 0 are drift."
    drifting = any(row.order for row in constraint_rows)
    return TextTable("Constraints", ("row", "level", "value"), cells, note if drifting else "")


#: Remark of the table of natural frequencies for an eigenvalue of this kind; none for an oscillation.
REMARKS: dict[str, str] = {
    "oscillation": "",
    "growth": "growing",
    "drift": "drift of constraint rows",
    "rigid body": "rigid-body motion",
    "offset": "offset, no restoring force",
}


def frequency_table(result: Result) -> TextTable:
    """Frequency and damping ratio by eigenvalue; a remark for multiple ones."""
    rows, switching = result.eigenvalue_rows, result.scene.equations.switching
    if not rows:
        return TextTable("Natural frequencies", (), (), "none: the model is static, without dynamic modes")
    if any(row["frequency (Hz)"] for row in rows):
        title, columns = "Natural frequencies", {"frequency (Hz)": "Hz", "damping ratio": "damping ratio"}
    else:
        title, columns = (
            "No natural frequencies: nothing oscillates",
            {"eigenvalue (1/s)": f"{result.scene.equations.root_name} (1/s)"},
        )
    cells = []
    for row, (number, count) in zip(rows, _shape_numbers(result)):
        multiplicity, kind = row["multiplicity"], row["kind"]
        if kind == "rigid body" and multiplicity == str(2 * count):  # each rigid-body motion is a double eigenvalue 0
            remark = REMARKS[kind] if count == 1 else f"{count} rigid-body motions"
        else:
            remark = REMARKS.get(kind, row["meaning"]) if kind != "growth" or row["frequency (Hz)"] else row["meaning"]
            remark = ", ".join(filter(None, (remark, f"{multiplicity} times" if multiplicity != "1" else "")))
        cells.append((number, *(row[column] for column in columns), remark))
    width = len(columns) + 1 + any(row[-1] for row in cells)
    return TextTable(
        title,
        ("no.", *columns.values(), "meaning")[:width],
        tuple(row[:width] for row in cells),
        switching.note if switching else "",
    )


def _shape_numbers(result: Result) -> list[tuple[str, int]]:
    """The numbers of the shapes of each eigenvalue in the list of modes, and how many they are, 1 where there are none."""
    counts = [max(1, mode.shapes.shape[1]) for mode in result.modes] if result.system else [1] * len(result.finite_pair.zeros)
    return [(str(end) if count == 1 else f"{end - count + 1}–{end}", count) for count, end in zip(counts, np.cumsum(counts))]


#: Parts of a mode with the largest shares of energy that the table of eigenvalues names, and the list of modes; JSON has all.
MOST_PARTS, MOST_SHARES = 3, 6

#: What is less is printed as 0.0 %.
LEAST_SHARE = 0.0005


def eigenvalue_table(result: Result) -> TextTable:
    """The finite eigenvalues of A(s): with meaning and energies where the system is mechanical, else called zeros or poles."""
    word, switching = result.scene.equations.root_name, result.scene.equations.switching
    columns = ["no.", f"{word} (1/s)", "rad/s", "multiplicity", "kind"]
    cells: list[tuple[str, ...]] = [
        (
            number,
            row["eigenvalue (1/s)"],
            row["natural frequency (rad/s)"],
            row["multiplicity"],
            row["kind"] if row["frequency (Hz)"] else row["meaning"],
        )
        for (number, _), row in zip(_shape_numbers(result), result.eigenvalue_rows)
    ]
    if result.system:
        columns += ["kinetic energy", "strain energy"]
        for place, shares in enumerate(result.modes.shares):  # those of the first of several shapes
            parts = (shares[0].kinetic, shares[0].strain) if shares else ({}, {})
            cells[place] += tuple(", ".join(share_entries(part, MOST_PARTS)) for part in parts)
    return TextTable(f"{word.capitalize()}s", tuple(columns), tuple(cells), switching.note if switching else "")


def share_entries(shares: Mapping[str, float] | None, most: int = MOST_SHARES) -> list[str]:
    """The largest shares in per cent, and the sum of the others.

    >>> share_entries({"cart": 0.25, "load": 0.75}), share_entries(None)
    (['load 75.0 %', 'cart 25.0 %'], ['none'])
    """
    if shares is None:
        return ["none"]
    names, numbers = [*shares.keys()], [*shares.values()]
    sizes = np.abs(numbers)
    least = max(np.sort(sizes)[-most:].min(initial=np.inf) * 0.999, LEAST_SHARE)  # the order of texts takes long
    listed = sorted(np.flatnonzero(sizes >= least).tolist(), key=lambda k: descending(numbers[k]))[:most]
    rest = np.delete(numbers, listed).tolist()
    others = [(f"{len(rest)} more", sum(rest))] if np.abs(rest).sum() >= LEAST_SHARE else []
    return [f"{name} {round(100 * share, 1) + 0.0:.1f} %" for name, share in [*((names[k], numbers[k]) for k in listed), *others]]


def descending(value: complex) -> float:
    """A sort key that keeps the order of values that differ by rounding errors only."""
    return -float(f"{abs(value):.9g}")


def _output_table(control: ControlScene) -> TextTable:
    """Jumps and impulses of the outputs at t = 0; those of the displacements have separate tables."""
    together, names = control.response.together, control.outputs.names
    coordinates = together.polynomial_matrix.coordinates
    jumps = jumps_of(together, Coordinates(coordinates, tuple(control.system.units[name] for name in coordinates)))
    rows: list[tuple[str, ...]] = [(jump.name, "jumps", jump.before, jump.after, jump.size) for jump in jumps if jump.name in names]
    rows += _impulse_rows(impulses_of(control.response.output_impulses, control.outputs))
    return TextTable("Outputs at t = 0", ("of", "what", "before", "after", "size"), tuple(rows))


def _later_table(result: Result) -> TextTable:
    """The first jumps and impulses after t = 0, where the force starts, stops, changes or has an impulse."""
    rows = (row for event in result.later for row in _event_rows(result, event))
    count = sum(counts(result.later))
    note = f"The first {MOST_LATER_ROWS} of {count} are shown." if count > MOST_LATER_ROWS else ""
    columns = ("time", "of", "what", "before", "after", "size")
    return TextTable("Jumps and impulses after t = 0", columns, tuple(islice(rows, MOST_LATER_ROWS)), note)


def _event_rows(result: Result, event: Event | ImpulsiveLoad) -> list[tuple[str, ...]]:
    coordinates, is_load = result.scene.equations.coordinates, isinstance(event, ImpulsiveLoad)
    jumps = [] if isinstance(event, ImpulsiveLoad) else jumps_of(result.motion, coordinates, event)
    rows: list[tuple[str, ...]] = [(jump.name, f"{jump.what} jumps", jump.before, jump.after, jump.size) for jump in jumps]
    rows += _impulse_rows(
        impulses_of(event.impulses, forces_of_rows(result.rows, shown=coordinates.shown) if is_load else coordinates)
    )
    return [(f"{number_text(event.time)} s", *row) for row in rows]


def _impulse_rows(impulses: list[ReportedImpulse]) -> list[tuple[str, ...]]:
    return [(impulse.name, f"multiplies δ{_primes(impulse.order)}", "", "", impulse.size) for impulse in impulses]


def _primes(order: int) -> str:
    return "′" * order if order < 4 else f"^({order})"


def _evidence_table(result: Result, of_model: Sequence[tuple[str, str, str]]) -> TextTable:
    """Error estimates, residuals and rank gaps: the accuracy of the answer."""
    equations, motion = result.scene.equations, result.motion
    proved: tuple[str, ...] = ("displacement", "velocity", "acceleration") if getattr(motion, "is_proved", False) else ()
    proved += ("reaction",) if proved and motion._is_decided_exactly else ()
    bound, estimate = (
        "proved bound of the error over the largest value, at each time",
        "largest error over largest value, over all times",
    )
    names = {"displacement": equations.coordinates_called} if equations.has_outputs_among_coordinates else {}  # no displacements
    estimates = [
        (f"error estimate: {names.get(kind, kind)}", f"{value:.2g}", bound if kind in proved else estimate)
        for kind, value in result.error_estimates.items()
    ]
    evidence = [(item.name, f"{item.value:.2g}", item.text) for item in motion.evidence]
    return TextTable("Evidence", ("what", "value", "meaning"), (*estimates, *evidence, *of_model))
