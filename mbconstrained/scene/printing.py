"""What is printed: tables set by rich in a terminal, plain text elsewhere, JSON for programs."""

from __future__ import annotations

import json as json_format
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ..checks import counted
from .summary import as_json, blocks, plain_table
from .tables import TextTable

if TYPE_CHECKING:
    from .modes import SceneModes
    from .plan import Plan, Stage
    from .result import Result
    from .scene import Scene


def show_result(result: Result, json: bool) -> None:
    """The summary of a run."""
    if json:
        _say_json(as_json(result))
    else:
        _say_blocks(blocks(result))


def show_modes(modes: SceneModes, json: bool) -> None:
    """The modes of a scene."""
    from . import modes_summary

    if json:
        _say_json(modes_summary.as_json(modes))
    else:
        _say_blocks(modes_summary.blocks(modes))


def show_plan(scene: Scene, json: bool) -> None:
    """The stages of a scene."""
    plan = scene.plan()
    if json:
        _say_json({"title": scene.title, "plan": plan.as_json()})
    else:
        _say_blocks([scene.title, plan_table(plan)])


def show_check(scene: Scene, json: bool) -> None:
    """That a scene is right, and what it holds."""
    coordinates = scene.equations.coordinates.names
    taken = len(scene.plan().taken)
    notices = [str(notice) for notice in scene.parameters.notices]
    if json:
        _say_json({"title": scene.title, "coordinates": list(coordinates), "stages": taken, "notices": notices})
    else:
        holds = f"{counted(len(coordinates), 'coordinate')} ({', '.join(coordinates)}), {counted(taken, 'stage')} to run"
        _say("\n".join([f"{scene.path.name} is fine: {scene.title}", holds, *notices]))


def show_error(message: str, json: bool, code: int) -> int:
    """One message, as the only thing that is printed."""
    if json:
        _say_json({"error": message, "exit_code": code})
    else:
        print(message, file=sys.stderr)
    return code


def show_text(text: str) -> None:
    """A text as it is, as the only thing that is printed."""
    _say(text)


def plan_table(plan: Plan) -> TextTable:
    """Taken stages first, in the order in which they run."""
    rows = [("taken", stage.name, stage.reason) for stage in plan.taken]
    rows += [("left out", stage.name, stage.reason) for stage in plan.left_out]
    return TextTable("Plan", ("", "stage", "reason"), tuple(rows))


@contextmanager
def stage_progress() -> Iterator[Callable[[Stage], None] | None]:
    """A line that names the running stage, in a terminal only."""
    with step_progress() as tell:
        yield tell and (lambda stage: tell(stage.name))


@contextmanager
def step_progress() -> Iterator[Callable[[str], None] | None]:
    """A line that says what is being done, in a terminal only."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console

    with Console(stderr=True).status("") as status:
        yield status.update


def _say_json(data: dict) -> None:
    _say(json_format.dumps(data, indent=2, allow_nan=False))


def _say_blocks(blocks: list[str | TextTable]) -> None:
    if sys.stdout.isatty():
        _say_rich(blocks)
    else:
        _say("\n\n".join(map(_plain, blocks)))


def _say_rich(blocks: list[str | TextTable]) -> None:
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False)
    for block in blocks:
        console.print(_rich_table(block) if isinstance(block, TextTable) and block.rows else Text(_plain(block)))
        console.print()


def _plain(block: str | TextTable) -> str:
    return plain_table(block) if isinstance(block, TextTable) else block


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
