"""The report in words and tables, for the terminal and the page."""

from __future__ import annotations

import math

from ...scene.text_table import TextTable
from .point import Point
from .report import StabilityReport
from .sweeps import Sweep

NOTE = (
    "digits right: against exact arithmetic, 16 at most; expected: what the condition of the data allows; claimed: by the error "
    "estimate. told: a warning came with the answer; wrong: more than one digit fewer than claimed, and no warning. "
    "Constraint rows that were left out because they say nothing new but for rounding are not in the truth either."
)


def blocks(report: StabilityReport) -> list[str | TextTable]:
    """Heading, verdict, tables."""
    return [f"Numerical stability: {report.title}", "\n".join(report.verdict), digit_table(report), *told_tables(report)]


def digit_table(report: StabilityReport) -> TextTable:
    """A line for each sweep, those of the gallery by their themes."""
    head = ("what is turned",) if report.of_scene else ("theme", "system")
    columns = (*head, "from … to", "points", "right", "told", "refused", "wrong", "fewest digits", "expected", "claimed")
    rows, theme = [], ""
    for sweep in report.sweeps:
        named = (sweep.title,) if report.of_scene else (sweep.theme if sweep.theme != theme else "", sweep.name)
        rows.append((*named, *_row(sweep)))
        theme = sweep.theme
    return TextTable("Digits", columns, tuple(rows), NOTE)


def _row(sweep: Sweep) -> tuple[str, ...]:
    counts = [str(sweep.count(verdict) or "–") for verdict in ("right", "told", "refused", "wrong")]
    least = min(sweep.answers, key=lambda point: point.right, default=None)
    digits = ("–",) * 3 if least is None else tuple(map(_digits, (least.right, least.expected, least.claimed)))
    return (_span(sweep), str(len(sweep.points)), *counts, *digits)


def _digits(digits: float) -> str:
    return "–" if math.isnan(digits) else f"{digits:.1f}"


def _span(sweep: Sweep) -> str:
    first, last = sweep.points[0], sweep.points[-1]
    return f"{first.parameter:.3g} … {last.parameter:.3g}"


def told_tables(report: StabilityReport) -> list[TextTable]:
    """What was wrong, and what was told or refused and why; the same reasons once."""
    titles = {"wrong": "Wrong without a warning", "told": "Warnings", "refused": "Refused", "not judged": "Not judged"}
    found = [(title, _told_rows(report, verdict)) for verdict, title in titles.items()]
    return [TextTable(title, ("what is turned", "at", "why"), rows) for title, rows in found if rows]


def _told_rows(report: StabilityReport, verdict: str) -> tuple[tuple[str, str, str], ...]:
    rows: dict[tuple[str, str], list[str]] = {}
    for sweep in report.sweeps:
        for point in sweep.points:
            if point.verdict == verdict:
                rows.setdefault((sweep.name, _short(point)), []).append(f"{point.parameter:.3g}")
    return tuple((name, ", ".join(parameters), reason) for (name, reason), parameters in rows.items())


def _short(point: Point) -> str:
    """Of several warnings the first, without its figures: they are in the data."""
    return point.warnings[0].partition(":")[0] if point.verdict == "told" else point.reason


def gallery_table(report: StabilityReport) -> TextTable:
    """What each system is, what is hard about it, and where it is from."""
    rows = tuple((sweep.name, sweep.title, sweep.parameter, sweep.hard, sweep.source) for sweep in report.sweeps)
    return TextTable("The systems", ("system", "what it is", "what is turned", "what is hard", "source"), rows)
