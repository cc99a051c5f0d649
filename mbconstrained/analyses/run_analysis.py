"""The analysis ``run``: the motion over time, or samples alone in discrete time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from .base import Analysis
from .run import RunAnswer, run_scene

if TYPE_CHECKING:
    from ..scene.run.scene import Scene


class Run(Analysis):
    """The motion of a scene, or its samples in discrete time, by the stages of its plan."""

    name = "run"
    handles_choices = True
    switches = "all"

    @classmethod
    def answer(cls, scene: Scene, progress: Callable | None = None, *, folder: str | Path | None = None) -> RunAnswer:  # type: ignore[override]  # it has no settings
        """The answer, written into a folder unless it is None."""
        kind = RunAnswer
        if scene.table.time.step_domain == "discrete":
            from .discrete_run import DiscreteRunAnswer as kind  # loads state spaces and sequences in balls
        return run_scene(scene, None if folder is None else Path(folder), progress, kind)
