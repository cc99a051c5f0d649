"""Printing: tables by rich in a terminal, plain text elsewhere, JSON for programs."""

from __future__ import annotations

import json as json_format
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ..ground.display import TextTable, table_text

if TYPE_CHECKING:
    from ..scene.run.plan import Stage


def show(json: bool, data: Callable[[], dict], blocks: Callable[[], Sequence[str | TextTable]]) -> None:
    """Print an answer, as the only thing that is printed.

    Args:
        json: whether as plain data.
        data: makes them.
        blocks: makes the texts and tables to be printed otherwise, one below the other.
    """
    if json:
        _say(json_format.dumps(data(), indent=2, allow_nan=False))
    elif sys.stdout.isatty():
        _say_rich(blocks())
    else:
        _say("\n\n".join(map(_text_of, blocks())))


def show_error(message: str, json: bool, code: int) -> int:
    """Print one message, as the only thing that is printed.

    Args:
        message: without traceback.
        json: whether as plain data.
        code: the exit code.

    Returns:
        The exit code.
    """
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


def _say_rich(blocks: Sequence[str | TextTable]) -> None:
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False)
    for block in blocks:
        console.print(_rich_table(block) if isinstance(block, TextTable) and block.rows else Text(_text_of(block)))
        console.print()


def _text_of(block: str | TextTable) -> str:
    return table_text(block) if isinstance(block, TextTable) else block


def _rich_table(table: TextTable):
    from rich import box
    from rich.table import Table
    from rich.text import Text

    shown = Table(title=table.title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, caption=table.note or None)
    for column in table.columns:
        shown.add_column(Text(column))
    for row in table.rows:
        shown.add_row(*map(Text, row))
    return shown


def _say(text: str) -> None:
    """Print; where the reader has gone (a closed pipe), be silent from then on."""
    try:
        print(text)
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
