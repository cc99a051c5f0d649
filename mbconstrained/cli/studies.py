"""Commands of reports that are no answers: run, write, print."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .answer import FINE, NOT_TRUSTED

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..analyses.timing import Progress
    from ..studies.study_report import StudyReport


def published(study: Callable[[Progress], StudyReport], name: str, kind: str, out: str, json: bool) -> int:
    """Run a study, write NAME.KIND.html, ..., print its report; return the exit code."""
    from ..analyses.timing import no_progress
    from ..studies.study_report import writable
    from .printing import show, step_progress

    folder = writable(Path(out or Path("results") / name))
    with step_progress() as progress:
        report = study(progress or no_progress)
    files = report.write(folder, f"{name}.{kind}")
    show(json, report.as_json, lambda: [*report.blocks, "\n".join(f"wrote {path}" for path in files)])
    return FINE if report.is_trusted else NOT_TRUSTED
