"""The plan as tables: what is taken and left out, why, and what each stage took."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..checks import counted
from .stage_costs import memory_note
from .text_table import TextTable

if TYPE_CHECKING:
    from .plan import Plan, Stage

#: In the place of a number that there is none of.
NOTHING = "–"


def plan_table(plan: Plan) -> TextTable:
    """Taken stages first, in the order in which they run."""
    rows = [("taken", stage.name, stage.reason) for stage in plan.taken]
    rows += [("left out", stage.name, stage.reason) for stage in plan.left_out]
    return TextTable("Plan", ("", "stage", "reason"), tuple(rows))


def cost_table(plan: Plan) -> TextTable:
    """What each stage that ran took, and all together."""
    rows = [(stage.name, *_cost_cells(plan, stage), _reason(stage)) for stage in plan.taken]
    rows.append(("all", milliseconds(plan.seconds), "100 %", megabytes(plan.memory), "highest above the start of the first"))
    return TextTable("Taken", ("stage", "time (ms)", "share", "memory (MB)", "reason"), tuple(rows), memory_note())


def left_out_table(plan: Plan) -> TextTable:
    """What did not run."""
    return TextTable("Left out", ("stage", "reason"), tuple((stage.name, stage.reason) for stage in plan.left_out))


def page_table(plan: Plan, page: str) -> TextTable:
    """For the page, which is the stage of the given name and cannot tell what it takes itself."""
    shown = [stage for stage in plan.taken if stage.name != page]
    rows = [("taken", stage.name, *_numbers(stage), _reason(stage)) for stage in shown]
    rows.append(("taken", page, NOTHING, NOTHING, "this page"))
    left_out = [stage for stage in plan.left_out if stage.name != page]
    rows += [("left out", stage.name, "", "", stage.reason) for stage in left_out]
    columns = ("", "stage", "time (ms)", "memory (MB)", "reason")
    title = f"Plan: {counted(len(rows) - len(left_out), 'stage')} taken, {len(left_out)} left out"
    return TextTable(title, columns, tuple(rows), memory_note())


def totals(plan: Plan) -> str:
    """What all stages that ran took, in a line."""
    ran = sum(stage.cost is not None or bool(stage.part_of) for stage in plan.taken)
    memory = "" if plan.memory is None else f", {megabytes(plan.memory)} MB of memory"
    return f"{counted(ran, 'stage')} in {plan.seconds:.3g} s{memory}; {len(plan.left_out)} left out"


def _cost_cells(plan: Plan, stage: Stage) -> tuple[str, str, str]:
    time, memory = _numbers(stage)
    return time, NOTHING if stage.seconds is None else f"{100 * stage.seconds / plan.seconds:.1f} %", memory


def _numbers(stage: Stage) -> tuple[str, str]:
    return milliseconds(stage.seconds), megabytes(stage.memory)


def _reason(stage: Stage) -> str:
    return f"{stage.reason} (in: {stage.part_of})" if stage.part_of else stage.reason


def milliseconds(seconds: float | None) -> str:
    """A time as it stands in tables.

    >>> milliseconds(0.01234), milliseconds(None)
    ('12.3', '–')
    """
    return NOTHING if seconds is None else f"{1e3 * seconds:.1f}"


def megabytes(memory: int | None) -> str:
    """Memory as it stands in tables.

    >>> megabytes(2_345_678), megabytes(None)
    ('2.3', '–')
    """
    return NOTHING if memory is None else f"{memory / 1e6:.1f}"
