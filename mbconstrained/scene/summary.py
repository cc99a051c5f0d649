"""A result in words: for people in a terminal, and as plain data for programs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..notices import Notice
from .control_report import control_json
from .plan_tables import totals
from .robot_report import posture_json
from .tables import TextTable, notices_of, tables_of

if TYPE_CHECKING:
    from .result import Result


def summary(result: Result) -> str:
    """Title, coordinates, tables, notices and files, as plain text."""
    return "\n\n".join(plain_table(block) if isinstance(block, TextTable) else block for block in blocks(result))


def blocks(result: Result) -> list[str | TextTable]:
    """The parts of the summary: texts, and tables that a terminal may set in its own way."""
    return [heading(result), *tables_of(result), *_notices(result), *_files(result), f"Plan: {totals(result.plan)}"]


def heading(result: Result) -> str:
    """What was solved."""
    scene = result.scene
    coordinates = scene.equations.coordinates
    what = scene.equations.coordinates_called
    end = scene.table.time.end
    lines = [scene.title, scene.table.source, f"{what[0].upper()}{what[1:]}: {coordinates.listed}; t from 0 to {end:g} s"]
    return "\n".join(line for line in lines if line)


def plain_table(table: TextTable) -> str:
    """Columns set flush left with two spaces between them."""
    if not table.rows:
        return f"{table.title}\n  {table.note}"
    lines = [table.columns, *table.rows]
    widths = [max(len(line[i]) for line in lines) for i in range(len(table.columns))]
    text = ["  " + "  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in lines]
    return "\n".join([table.title, *text, *([f"  {table.note}"] if table.note else [])])


def _notices(result: Result) -> list[str]:
    notices = notices_of(result)
    return ["Notices\n" + "\n".join(f"  {notice}" for notice in notices)] if notices else []


def _files(result: Result) -> list[str]:
    return ["Written\n" + "\n".join(f"  {path}" for path in result.files)] if result.files else []


def as_json(result: Result) -> dict:
    """The same as plain data, numbers as numbers."""
    scene, motion = result.scene, result.motion
    coordinates = scene.equations.coordinates
    return {
        "title": scene.title,
        "source": scene.table.source,
        **posture_json(scene.equations.robot_scene),
        **control_json(scene.equations.control),
        "coordinates": [{"name": name, "unit": unit} for name, unit in zip(coordinates.names, coordinates.units)],
        "constraints": [
            {"name": row.name, "level": row.level, "value": row.value} for row in (result.system.rows if result.system else ())
        ],
        "zeros": [_zero(zero) for zero in _zeros(result)],
        "initial": motion.initial.tolist(),
        "jump": motion.jump.tolist(),
        "impulses": [impulse.tolist() for impulse in motion.impulses],
        "constraint_impulses": [impulse.tolist() for impulse in getattr(motion, "constraint_impulses", ())],
        "events": [
            {"time": event.time, "jump": event.jump.tolist(), "impulses": [impulse.tolist() for impulse in event.impulses]}
            for event in motion.events
        ],
        "later_constraint_impulses": [
            {"time": blow.time, "impulses": [impulse.tolist() for impulse in blow.impulses]}
            for blow in getattr(motion, "later_constraint_impulses", ())
        ],
        "final": result.values[:, -1].tolist(),
        "error_estimate": _finite(result.error_estimate),
        "error_estimates": {kind: _finite(value) for kind, value in result.error_estimates.items()},
        "evidence": [{"name": item.name, "value": _finite(item.value), "text": item.text} for item in motion.evidence],
        **({"certificate": result.certificate.as_json()} if result.certificate else {}),
        "notices": notices_json(result.notices),
        "trusted": result.is_trusted,
        "plan": result.plan.as_json(),
        "totals": result.plan.totals_as_json(),
        "files": [str(path) for path in result.files],
    }


def notices_json(notices: Iterable[Notice]) -> list[dict]:
    """Notices as plain data."""
    return [{"kind": notice.kind, "text": notice.text, "doubtful": notice.doubtful} for notice in notices]


def _zeros(result: Result):
    return result.modes.zeros if result.system else result.finite_pair.zeros


def _zero(zero) -> dict:
    kind = {"kind": zero.kind, "meaning": zero.text} if hasattr(zero, "text") else {}
    return {"real": zero.value.real, "imaginary": zero.value.imag, "multiplicity": zero.multiplicity, **kind}


def _finite(value: float) -> float | None:
    """JSON has no infinity."""
    return value if abs(value) < float("inf") else None
