"""The report as a page: the verdict, a heat map and curves, tables."""

from __future__ import annotations

from collections.abc import Sequence

from ...notices import Notice
from ...page.content import PageContent
from ..figures import Picture
from .heat_map import heat_map
from .pictures import gallery
from .report import StabilityReport
from .tables import digit_table, gallery_table, told_tables


def pictures_of(report: StabilityReport) -> list[Picture]:
    """A heat map of what a scene was turned by, and the curves."""
    curves = gallery("Digits right, claimed and expected", report.sweeps)
    return [heat_map("Digits right", report.sweeps), curves] if report.of_scene else [curves]


def page_content(report: StabilityReport, pictures: Sequence[Picture]) -> PageContent:
    """What the page shows."""
    first, *others = report.verdict
    tables = [digit_table(report), *told_tables(report), *([] if report.of_scene else [gallery_table(report)])]
    return PageContent(
        title=f"Numerical stability: {report.title}",
        notices=(Notice("accuracy", " ".join([first, *others]), doubtful=not report.is_trusted),),
        figures=tuple(picture.on_page() for picture in pictures),
        tables=tuple(table.on_page() for table in tables),
        facts=tuple(report.machine.items()),
    )
