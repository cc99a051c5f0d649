"""The plan: every possible stage of a scene, needed or omitted, with the reason and, after a run, its cost; and its tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ...ground.checks import counted
from ...ground.display import TextTable
from .stage_costs import Cost, memory_note

#: The stage that lists the others.
PAGE = "page"

#: Instead of a number that is not known.
NOTHING = "–"


@dataclass(frozen=True)
class Stage:
    """Stage of the computation.

    Attributes:
        name: name of the stage.
        needed: whether this scene needs it.
        reason: the reason for needing or omitting it.
        cost: time and memory, once it has run.
        part_of: the stage that contains it, including its cost, or an empty string.
    """

    name: str
    needed: bool
    reason: str
    cost: Cost | None = None
    part_of: str = ""

    @property
    def seconds(self) -> float | None:
        """Run time in s, once it has run."""
        return self.cost and self.cost.seconds

    @property
    def memory(self) -> int | None:
        """Highest resident memory above that at its start, in bytes; None where it has not run or it is not measured."""
        return self.cost and self.cost.memory


@dataclass(frozen=True)
class Plan:
    """The stages of a scene in the order in which they run.

    Attributes:
        stages: all of them, needed or left out.
    """

    stages: tuple[Stage, ...]

    @property
    def needed(self) -> tuple[Stage, ...]:
        """The stages that run."""
        return tuple(stage for stage in self.stages if stage.needed)

    @property
    def left_out(self) -> tuple[Stage, ...]:
        """The stages that do not run."""
        return tuple(stage for stage in self.stages if not stage.needed)

    @property
    def costs(self) -> dict[str, Cost]:
        """The cost of each stage that has run, by name."""
        return {stage.name: stage.cost for stage in self.stages if stage.cost}

    @property
    def total(self) -> Cost:
        """The cost of all stages that have run; memory above that at the start of the first."""
        costs = list(self.costs.values())
        peak = max((cost.peak for cost in costs if cost.peak is not None), default=None)
        known = peak is not None and costs[0].memory is not None
        memory = max(peak - (costs[0].peak - costs[0].memory), 0) if known else None
        return Cost(sum(cost.seconds for cost in costs), memory, peak)

    def with_costs(self, costs: Mapping[str, Cost]) -> Plan:
        """The plan with the costs of stages by name."""
        return Plan(tuple(replace(stage, cost=costs.get(stage.name, stage.cost)) for stage in self.stages))

    def to_list(self) -> list[dict]:
        return [
            {"name": stage.name, "taken": stage.needed, "reason": stage.reason, "seconds": stage.seconds, "memory": stage.memory}
            | ({"part_of": stage.part_of} if stage.part_of else {})
            for stage in self.stages
        ]

    def totals_to_dict(self) -> dict:
        """The cost of all stages as plain data."""
        return {"taken": len(self.needed), "left_out": len(self.left_out), **vars(self.total)}

    def totals(self) -> str:
        """The cost of all stages in a line."""
        ran = sum(stage.cost is not None or bool(stage.part_of) for stage in self.needed)
        cost = self.total
        memory = "" if cost.memory is None else f", {_cells(cost)[1]} MB of memory"
        return f"{counted(ran, 'stage')} in {cost.seconds:.3g} s{memory}; {len(self.left_out)} left out"

    def table(self) -> TextTable:
        """Needed stages first, in the order in which they run."""
        rows = [("taken", stage.name, stage.reason) for stage in self.needed]
        rows += [("left out", stage.name, stage.reason) for stage in self.left_out]
        return TextTable("Plan", ("", "stage", "reason"), tuple(rows))

    def cost_tables(self) -> tuple[TextTable, TextTable]:
        """The cost of each stage that ran and of all together, and the stages that did not run."""
        all_stages, rows = self.total, []
        for stage in self.needed:
            share = NOTHING if stage.cost is None else f"{100 * stage.cost.seconds / all_stages.seconds:.1f} %"
            seconds, memory = _cells(stage.cost)
            rows.append((stage.name, seconds, share, memory, _reason(stage)))
        seconds, memory = _cells(all_stages)
        rows.append(("all", seconds, "100 %", memory, "highest above the start of the first"))
        columns = ("stage", "time (ms)", "share", "memory (MB)", "reason")
        left_out = tuple((stage.name, stage.reason) for stage in self.left_out)
        return TextTable("Taken", columns, tuple(rows), memory_note()), TextTable("Left out", ("stage", "reason"), left_out)

    def page_table(self) -> TextTable:
        """The plan on the page, without times and memory: the same scene gives the same page."""
        needed = [stage for stage in self.needed if stage.name != PAGE]
        left_out = [stage for stage in self.left_out if stage.name != PAGE]
        rows = [*(("taken", stage.name, _reason(stage)) for stage in needed), ("taken", PAGE, "this page")]
        title = f"Plan: {counted(len(rows), 'stage')} taken, {len(left_out)} left out"
        rows += [("left out", stage.name, stage.reason) for stage in left_out]
        return TextTable(title, ("", "stage", "reason"), tuple(rows), folded=True)


def _reason(stage: Stage) -> str:
    return f"{stage.reason} (in: {stage.part_of})" if stage.part_of else stage.reason


def _cells(cost: Cost | None) -> tuple[str, str]:
    """Milliseconds and megabytes."""
    seconds, memory = (cost.seconds, cost.memory) if cost else (None, None)
    return NOTHING if seconds is None else f"{1e3 * seconds:.1f}", NOTHING if memory is None else f"{memory / 1e6:.1f}"
