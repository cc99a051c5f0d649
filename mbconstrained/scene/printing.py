"""What is printed: tables set by rich in a terminal, plain text elsewhere, JSON for programs."""

from __future__ import annotations

import json as json_format
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ..checks import counted
from .plan_tables import cost_table, left_out_table, plan_table
from .summary import as_json, blocks, notices_json, plain_table
from .tables import TextTable

if TYPE_CHECKING:
    from .modes import SceneModes
    from .plan import Stage
    from .result import Result
    from .scene import Scene


def show_result(result: Result, json: bool) -> None:
    """The summary of a run."""
    if json:
        say_json(as_json(result))
    else:
        say_blocks(blocks(result))


def show_modes(modes: SceneModes, json: bool) -> None:
    """The modes of a scene."""
    from . import modes_summary

    if json:
        say_json(modes_summary.as_json(modes))
    else:
        say_blocks(modes_summary.blocks(modes))


def show_plan(scene: Scene, json: bool) -> None:
    """The stages of a scene."""
    plan = scene.plan()
    if json:
        say_json({"title": scene.heading, "plan": plan.as_json()})
    else:
        say_blocks([scene.heading, plan_table(plan)])


def show_costs(result: Result, json: bool) -> None:
    """The stages of a scene that was run, with what each took."""
    plan, doubts = result.plan, [notice for notice in result.notices if notice.doubtful]
    if json:
        told = {"title": result.scene.heading, "plan": plan.as_json(), "totals": plan.totals_as_json()}
        say_json({**told, "notices": notices_json(doubts), "trusted": result.is_trusted})
    else:
        say_blocks([result.scene.heading, cost_table(plan), left_out_table(plan), *map(str, doubts)])


def show_check(scene: Scene, json: bool) -> None:
    """That a scene is right, what it holds, and what is worth knowing before it is run."""
    from .start_notices import start_notices

    coordinates = scene.equations.coordinates.names
    taken = len(scene.plan().taken)
    notices = [str(notice) for notice in (*scene.notices, *start_notices(scene.equations))]
    if json:
        say_json({"title": scene.title, "coordinates": list(coordinates), "stages": taken, "notices": notices})
    else:
        holds = f"{counted(len(coordinates), 'coordinate')} ({', '.join(coordinates)}), {counted(taken, 'stage')} to run"
        _say("\n".join([f"{scene.path.name} is fine: {scene.title}", holds, *notices]))


def show_error(message: str, json: bool, code: int) -> int:
    """One message, as the only thing that is printed."""
    if json:
        say_json({"error": message, "exit_code": code})
    else:
        print(message, file=sys.stderr)
    return code


def show_text(text: str) -> None:
    """A text as it is, as the only thing that is printed."""
    _say(text)


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


def say_json(data: dict) -> None:
    """Plain data, as the only thing that is printed."""
    _say(json_format.dumps(data, indent=2, allow_nan=False))


def say_blocks(blocks: list[str | TextTable]) -> None:
    """Texts and tables one below the other."""
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
