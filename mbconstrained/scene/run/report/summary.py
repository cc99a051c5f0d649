"""A result as text for the terminal and as plain data."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ....ground.display import TextTable, table_text
from ....ground.notices import Notice
from .control_report import control_json
from .robot_report import posture_json

if TYPE_CHECKING:
    from ..result import Result


def summary(result: Result) -> str:
    """Title, coordinates, tables, notices and files, as plain text."""
    return "\n\n".join(table_text(block) if isinstance(block, TextTable) else block for block in blocks(result))


def blocks(result: Result) -> list[str | TextTable]:
    """The parts of the summary: texts, and tables that a terminal may set in its own way."""
    parts = [("Notices", result.table_notices), ("Written", result.files)]
    lists = ["\n".join([title, *(f"  {line}" for line in lines)]) for title, lines in parts if lines]
    return [heading(result), *result.tables, *lists, f"Plan: {result.plan.totals()}"]


def heading(result: Result) -> str:
    """What was solved."""
    scene = result.scene
    coordinates = scene.equations.coordinates
    what = scene.equations.coordinates_called
    end = scene.table.time.end
    lines = [scene.title, scene.table.source, f"{what[0].upper()}{what[1:]}: {coordinates.listed}; t from 0 to {end:g} s"]
    return "\n".join(line for line in lines if line)


def as_json(result: Result) -> dict:
    """The same as plain data, numbers as numbers."""
    scene, motion = result.scene, result.motion
    robot, control = scene.equations.robot_scene, scene.equations.control
    return {
        "title": scene.title,
        "source": scene.table.source,
        **(posture_json(robot) if robot else {}),
        **(control_json(control) if control else {}),
        "coordinates": scene.equations.coordinates.as_json(),
        "constraints": [
            {"name": row.name, "level": row.level, "value": row.value} for row in (result.system.rows if result.system else ())
        ],
        "eigenvalues": _eigenvalues(result),
        "initial": motion.initial.tolist(),
        "jump": motion.jump.tolist(),
        "impulses": [impulse.tolist() for impulse in motion.impulses],
        "constraint_impulses": [impulse.tolist() for impulse in getattr(motion, "constraint_impulses", ())],
        "events": [
            {"time": event.time, "jump": event.jump.tolist(), "impulses": [impulse.tolist() for impulse in event.impulses]}
            for event in motion.events
        ],
        "later_constraint_impulses": [
            {"time": load.time, "impulses": [impulse.tolist() for impulse in load.impulses]}
            for load in getattr(motion, "later_constraint_impulses", ())
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


def _eigenvalues(result: Result) -> list[dict]:
    if result.system is None:
        return [_eigenvalue(zero.value, zero.multiplicity) for zero in result.finite_pair.zeros]
    return [{**_eigenvalue(mode.eigenvalue, mode.multiplicity), "kind": mode.kind, "meaning": mode.text} for mode in result.modes]


def _eigenvalue(value: complex, multiplicity: int) -> dict:
    return {"real": value.real, "imaginary": value.imag, "multiplicity": multiplicity}


def _finite(value: float) -> float | None:
    """JSON has no infinity."""
    return value if abs(value) < float("inf") else None
