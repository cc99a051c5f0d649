"""The plan: every stage that a scene could need, taken or left out, with the reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Stage:
    """One stage.

    Attributes:
        name: what is done.
        taken: whether this scene needs it.
        reason: why, or why not.
        seconds: how long it took, once it has run.
    """

    name: str
    taken: bool
    reason: str
    seconds: float | None = None


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

    def as_json(self) -> list[dict]:
        """The stages as plain data."""
        return [{"name": s.name, "taken": s.taken, "reason": s.reason, "seconds": s.seconds} for s in self.stages]
