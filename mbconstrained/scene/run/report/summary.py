"""A result as text for the terminal and as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ....ground.checks import counted
from ....ground.display import WIDTH, TextTable, table_text, wrapped
from ....ground.notices import Notice, NoticeKind
from ..curves import largest_values
from .control_report import control_json
from .force_report import forces_json
from .robot_report import posture_json

if TYPE_CHECKING:
    from ..answer import SceneAnswer

#: Lines of the short summary, at most: with the command above and the prompt below they fill a screen of 24.
SCREEN = 22


def summary(result: SceneAnswer) -> str:
    """Title, coordinates, tables, notices and files, as text of 80 columns."""
    return printed(blocks(result))


def printed(parts: Sequence[str | TextTable], width: int = WIDTH) -> str:
    """Texts and tables, one below the other."""
    return "\n\n".join(table_text(part, width) if isinstance(part, TextTable) else wrapped(part, width) for part in parts)


def blocks(result: SceneAnswer) -> list[str | TextTable]:
    """The parts of the summary: texts, and tables that a terminal may lay out itself."""
    parts = [("Notices", result.table_notices), ("Written", result.files)]
    lists = ["\n".join([title, *(f"  {line}" for line in lines)]) for title, lines in parts if lines]
    return [heading(result), *result.tables, *lists, f"Plan: {result.plan.totals()}"]


def heading(result: SceneAnswer) -> str:
    """Heading of the summary: the model, its coordinates and times."""
    scene = result.scene
    coordinates = scene.equations.coordinates
    what = scene.equations.coordinates_called
    times = scene.table.time.text
    lines = [scene.title, scene.table.source, f"{what[0].upper()}{what[1:]}: {coordinates.listed}; t from {times}"]
    return "\n".join(line for line in lines if line)


def overview(result: SceneAnswer, width: int = WIDTH, lines: int = SCREEN) -> list[str | TextTable]:
    """The parts of the summary that fit on a screen: natural frequencies, warnings, files, and the number of omitted lines."""
    scene = result.scene
    title = "\n".join(_first_lines(text, width, 2) for text in (scene.title, scene.table.source) if text)
    figures = f"Error estimate {max(result.error_estimates.values()):.2g}; {result.plan.totals()}"
    end = "\n".join(wrapped(text, width) for text in (_files(result), figures, "All tables and notices: --verbose") if text)
    left = lines + 1 - _height([title, end], width)
    notices = sorted(result.table_notices, key=_rank)
    notes = _some_notices(notices, width, max(left // 2, left - len(result.tables[0].rows) - 3))
    left -= _height(notes, width)
    shown = [_some_rows(result.tables[0], width, left - 1)]
    for table in result.tables[1:]:
        if not table.folded and _height([*shown, table], width) <= left:
            shown.append(table)
    return [title, *shown, *notes, end]


#: Notices on motions that the equations do not describe come first, those on what does not change them come last.
_FIRST = (NoticeKind.UNSTABLE, NoticeKind.LARGE_MOTION, NoticeKind.DISTANT_POSTURE)
_LAST = (NoticeKind.REDUNDANT, NoticeKind.OMITTED, NoticeKind.OVERRIDE)


def _rank(notice: Notice) -> int:
    return 0 if notice.doubtful else 1 if notice.kind in _FIRST else 3 if notice.kind in _LAST else 2


def _height(parts: Sequence[str | TextTable], width: int) -> int:
    """Lines of texts and tables, with an empty one after each."""
    return sum(printed([part], width).count("\n") + 2 for part in parts)


def _first_lines(text: str, width: int, most: int) -> str:
    """The first lines of a user's text."""
    lines = wrapped(text, width).split("\n")
    return "\n".join([*lines[: most - 1], lines[most - 1][: width - 1] + "…"] if len(lines) > most else lines)


def _files(result: SceneAnswer) -> str:
    """The path of the first file of each folder and the names of the others in it."""
    folders: dict[Path, list[str]] = {}
    for path in sorted(result.files, key=lambda path: path.suffix != ".html"):
        names = folders.setdefault(path.parent, [])
        names.append(path.name if names else str(path))
    return "\n".join(f"Written: {', '.join(names)}" for names in folders.values())


def _some_notices(notices: Sequence[Notice], width: int, lines: int) -> list[str]:
    """Notices on so many lines, one at least, and the number of the others."""
    if not notices:
        return []
    texts = [wrapped(f"  {notice}", width) for notice in notices]
    heights = [1 + sum(text.count("\n") + 1 for text in texts[:count]) for count in range(1, len(texts) + 1)]
    count = max(1, sum(height + (number < len(texts)) <= lines for number, height in enumerate(heights, 1)))
    more = [f"  and {counted(len(texts) - count, 'further notice')}"] if count < len(texts) else []
    return ["\n".join(["Notices", *texts[:count], *more])]


def _some_rows(table: TextTable, width: int, lines: int) -> TextTable:
    """The table with its first rows, as many as fit on so many lines, and the number of the others."""
    if table_text(table, width).count("\n") < lines:
        return table
    for count in range(len(table.rows) - 1, 0, -1):
        part = replace(table, rows=table.rows[:count], note=f"and {len(table.rows) - count} more")
        if table_text(part, width).count("\n") < lines:
            return part
    return replace(table, rows=(), note=f"{len(table.rows)} in all")


def as_json(result: SceneAnswer) -> dict:

    scene, motion = result.scene, result.motion
    robot, control = scene.equations.robot_scene, scene.equations.control
    return {
        "title": scene.title,
        "source": scene.table.source,
        **(posture_json(robot) | {"forces": forces_json(result)} if robot else {}),
        **(control_json(control) if control else {}),
        "coordinates": scene.equations.coordinates.as_json(),
        "constraints": [
            {"name": row.name, "level": row.level, "value": row.value if row.signal is None else "prescribed"}
            for row in (result.system.rows if result.system else ())
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
        "largest": [
            {
                "name": one.name,
                "of": one.title,
                "unit": one.unit,
                "largest": abs(one.value),
                "value": one.value,
                "time": one.time,
                "margin": _finite(one.margin),
            }
            for one in largest_values(result)
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


def _eigenvalues(result: SceneAnswer) -> list[dict]:
    if result.system is None:
        return [_eigenvalue(zero.value, zero.multiplicity) for zero in result.finite_pair.zeros]
    return [{**_eigenvalue(mode.eigenvalue, mode.multiplicity), "kind": mode.kind, "meaning": mode.text} for mode in result.modes]


def _eigenvalue(value: complex, multiplicity: int) -> dict:
    return {"real": value.real, "imaginary": value.imag, "multiplicity": multiplicity}


def _finite(value: float) -> float | None:
    """A finite number or None, since JSON has no infinity."""
    return value if abs(value) < float("inf") else None
