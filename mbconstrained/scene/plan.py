"""The plan: every stage that a scene could need, taken or left out, with the reason and, once it ran, with what it took."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from .stage_costs import Cost


@dataclass(frozen=True)
class Stage:
    """One stage.

    Attributes:
        name: what is done.
        taken: whether this scene needs it.
        reason: why, or why not.
        cost: what it took, once it has run.
        part_of: the stage in which it is done and whose cost contains its own, or an empty string.
    """

    name: str
    taken: bool
    reason: str
    cost: Cost | None = None
    part_of: str = ""

    @property
    def seconds(self) -> float | None:
        """How long it took, once it has run."""
        return self.cost and self.cost.seconds

    @property
    def memory(self) -> int | None:
        """Highest resident memory above that at its start, in bytes; None where it has not run or it is not measured."""
        return self.cost and self.cost.memory

    def as_json(self) -> dict:
        """The stage as plain data."""
        told = {"name": self.name, "taken": self.taken, "reason": self.reason, "seconds": self.seconds, "memory": self.memory}
        return {**told, "part_of": self.part_of} if self.part_of else told


@dataclass(frozen=True)
class Plan:
    """The stages of a scene in the order in which they run.

    Attributes:
        stages: all of them, taken or left out.
    """

    stages: tuple[Stage, ...]

    @property
    def taken(self) -> tuple[Stage, ...]:
        """The stages that run."""
        return tuple(stage for stage in self.stages if stage.taken)

    @property
    def left_out(self) -> tuple[Stage, ...]:
        """The stages that do not run."""
        return tuple(stage for stage in self.stages if not stage.taken)

    @property
    def seconds(self) -> float:
        """What the stages took together that have run."""
        return sum(cost.seconds for cost in self.costs.values())

    @property
    def memory(self) -> int | None:
        """Highest resident memory during the stages above that at the start of the first, in bytes, or None."""
        first, peak = next(iter(self.costs.values()), None), self.peak
        return None if peak is None or first.memory is None else max(peak - (first.peak - first.memory), 0)

    @property
    def peak(self) -> int | None:
        """Highest resident memory of the process during the stages, in bytes, or None."""
        return max((cost.peak for cost in self.costs.values() if cost.peak is not None), default=None)

    @property
    def costs(self) -> dict[str, Cost]:
        """What each stage took that has run, by name."""
        return {stage.name: stage.cost for stage in self.stages if stage.cost}

    def with_costs(self, costs: Mapping[str, Cost]) -> Plan:
        """The same plan with what stages, by name, took."""
        return Plan(tuple(replace(stage, cost=costs.get(stage.name, stage.cost)) for stage in self.stages))

    def as_json(self) -> list[dict]:
        """The stages as plain data."""
        return [stage.as_json() for stage in self.stages]

    def totals_as_json(self) -> dict:
        """What all stages took, as plain data."""
        counts = {"taken": len(self.taken), "left_out": len(self.left_out)}
        return {**counts, "seconds": self.seconds, "memory": self.memory, "peak": self.peak}
