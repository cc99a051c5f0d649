"""Printing: texts and tables that fit the terminal, JSON for programs."""

from __future__ import annotations

import json as json_format
import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ..ground.display import WIDTH, TextTable, table_text, wrapped

if TYPE_CHECKING:
    from ..scene.run.plan import Stage

#: Narrower terminals are printed on as if they had this width.
LEAST_WIDTH = 40

#: Seconds between lines of progress where there is no terminal.
LINE_AFTER = 30.0


def show(json: bool, data: Callable[[], dict], blocks: Callable[[], Sequence[str | TextTable]]) -> None:
    """Print an answer, as plain data or as texts and tables one below the other; nothing else is printed."""
    if json:
        _say(json_format.dumps(data(), indent=2, allow_nan=False))
    else:
        width = line_width()
        _say("\n\n".join(table_text(each, width) if isinstance(each, TextTable) else wrapped(each, width) for each in blocks()))


def line_width() -> int:
    """Letters on a line: of the terminal, where that is what is printed on, else 80."""
    return max(shutil.get_terminal_size((WIDTH, 24)).columns, LEAST_WIDTH) if sys.stdout.isatty() else WIDTH


def show_error(message: str, json: bool, code: int) -> int:
    """Print a message, the only thing that is printed, and return the exit code."""
    if json:
        show(json, lambda: {"error": message, "exit_code": code}, list)
    else:
        print(message, file=sys.stderr)
    return code


def show_text(text: str) -> None:
    """A text as it is, as the only thing that is printed."""
    _say(text)


@contextmanager
def stage_progress() -> Iterator[Callable[[Stage], None] | None]:
    """A line that names the running stage, in a terminal only."""
    with step_progress() as report_step:
        yield report_step and (lambda stage: report_step(stage.name))


@contextmanager
def step_progress() -> Iterator[Callable[[str], None] | None]:
    """A line that names the step being done, in a terminal only."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console

    with Console(stderr=True).status("") as status:
        yield status.update


@contextmanager
def bar_progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """A bar with the remaining time, called with the numbers done and in all; outside a terminal a line every ``LINE_AFTER`` seconds."""
    if not sys.stderr.isatty():
        yield _line_progress(what)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


def _line_progress(what: str) -> Callable[[int, int], None]:
    start, first, last = time.monotonic(), None, time.monotonic()

    def report(done: int, total: int) -> None:
        nonlocal first, last
        first, now = done if first is None else first, time.monotonic()
        if now - last < LINE_AFTER:
            return
        last = now
        rate = (done - first) / (now - start)
        left = f", about {(total - done) / rate / 60:.2g} min left" if rate else ""
        print(f"{what}: {done:,} of {total:,}{left}", file=sys.stderr, flush=True)

    return report


def _say(text: str) -> None:
    """Print; where the reader has gone (a closed pipe), be silent from then on."""
    try:
        print(text)
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
