"""The report as a page: the diagram, who is fastest at which error, all run times."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from ...page.content import PageContent
from ..figures import Picture
from .measure import Measured
from .report import AccuracyReport, further, one_run
from .series import MeasuredPoint, Series
from .tables import failure_table, fastest_table, run_table, time_table
from .work_precision import work_precision


def page_content(report: AccuracyReport, picture: Picture) -> PageContent:
    """What the page shows."""
    tables = [fastest_table(report), time_table(report), *([failure_table(report)] if report.failures else [])]
    return PageContent(
        title=f"Error against run time: {report.problem.title}",
        figures=(picture.on_page(),),
        tables=(*(table.on_page() for table in tables), run_table(report).on_page(folded=True)),
        facts=(("problem", report.size), ("true values", report.truth.how), *report.machine.items()),
    )


def picture_of(report: AccuracyReport) -> Picture:
    """The work-precision diagram."""
    refused = [(run.method.name if run.method.refusal(report.problem) else run.label, run.failure) for run in report.failures]
    failed = tuple(dict.fromkeys(refused))
    return work_precision(
        f"Error against run time: {report.problem.title}", tuple(_series(report.answers)), report.truth.floor, failed
    )


def _series(runs: tuple[Measured, ...]) -> Iterator[Series]:
    for method, mine in groupby(runs, key=lambda run: run.method):
        yield Series(method.name, tuple(_point(run) for run in mine), method.is_ours)


def _point(run: Measured) -> MeasuredPoint:
    return MeasuredPoint(run.setting.label, run.error, one_run(run), further(run), *run.one_run.quartiles)
