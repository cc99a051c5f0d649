"""The report in words and tables, for the terminal and the page."""

from __future__ import annotations

from itertools import groupby

from ...scene.text_table import TextTable
from ..timing import Timing, duration
from .measure import Measured
from .report import ERRORS, AccuracyReport, fastest, further, one_run


def given(report: AccuracyReport) -> str:
    """What stepping methods are given and is in nobody's time."""
    took = f" (found by this package in {duration(report.reduction.median)})" if report.reduction else ""
    return (
        f"The reduced equations that stepping methods need{took}, values at 0+ where the start jumps, and formulas of the force are "
        "given to them and not counted."
    )


def blocks(report: AccuracyReport) -> list[str | TextTable]:
    """Heading, truth, verdicts, tables."""
    failures = [failure_table(report)] if report.failures else []
    return [
        f"Error against run time: {report.problem.title}",
        f"Problem: {report.size}.",
        f"True values: {report.truth.how}.",
        fastest_table(report),
        time_table(report),
        *failures,
        "\n".join(f"{label}: {text}" for label, text in report.machine.items()),
    ]


def fastest_table(report: AccuracyReport) -> TextTable:
    """Who is fastest at which error."""
    rows = []
    for told, group in groupby(report.fastest, key=lambda row: row[1:]):
        errors = [f"{error:.0e}" for error, *_ in group]
        rows.append((" to ".join(dict.fromkeys((errors[0], errors[-1]))), *told))
    return TextTable("Fastest", ("error at most", "one run", "each further evaluation"), tuple(rows))


def time_table(report: AccuracyReport) -> TextTable:
    """How long each method takes to each of some errors."""
    columns = ("method", "least error", *(f"{error:.0e}" for error in ERRORS))
    rows = tuple(_times(name, tuple(runs)) for name, runs in groupby(report.answers, key=lambda run: run.method.name))
    note = (
        "Time to an error of at most so much: one run, that is set-up and evaluation, in brackets each further evaluation. "
        f"Times are medians of repeats, {report.clock}. {given(report)}"
    )
    return TextTable("Run times", columns, rows, note)


def _times(name: str, runs: tuple[Measured, ...]) -> tuple[str, ...]:
    least = min(run.error for run in runs)
    best = [fastest(runs, error, one_run) for error in ERRORS]
    return (name, f"{least:.0e}", *("–" if run is None else f"{duration(one_run(run))} ({duration(further(run))})" for run in best))


def run_table(report: AccuracyReport) -> TextTable:
    """One line for each setting that gave an answer."""
    columns = (
        "method",
        "setting",
        "error",
        "set-up",
        "evaluation",
        "quartiles of one run",
        "further evaluation",
        "one run / closed form",
        "further / closed form",
    )
    note = f"error: max |error| / max |x|. Times are medians of repeats that ran in turns, {report.clock}. {given(report)}"
    return TextTable("All settings", columns, tuple(_row(run, report.closed_form) for run in report.answers), note)


def failure_table(report: AccuracyReport) -> TextTable:
    """Those without an answer, settings that fail alike in one line."""
    found: dict[tuple[str, str], list[str]] = {}
    for run in report.failures:
        setting = "" if run.method.refusal(report.problem) else run.setting.label
        found.setdefault((run.method.name, run.failure), []).append(setting)
    rows = tuple((name, ", ".join(filter(None, settings)), failure) for (name, failure), settings in found.items())
    return TextTable("No answer", ("method", "settings", "why"), rows)


def _row(run: Measured, closed_form: Measured) -> tuple[str, ...]:
    ratios = ("", "")
    if not closed_form.failure:
        ratios = (ratio(one_run(run) / one_run(closed_form)), ratio(further(run) / further(closed_form)))
    return (
        run.method.name,
        run.setting.label,
        f"{run.error:.1e}",
        duration(run.set_up.median),
        duration(run.evaluation.median),
        _spread(run.one_run),
        duration(further(run)),
        *ratios,
    )


def ratio(value: float) -> str:
    """A ratio to two digits.

    >>> ratio(0.01234), ratio(123.4)
    ('0.012', '120')
    """
    return f"{float(f'{value:.2g}'):g}"


def _spread(timing: Timing) -> str:
    low, high = timing.quartiles
    return f"{duration(low)} … {duration(high)}"
