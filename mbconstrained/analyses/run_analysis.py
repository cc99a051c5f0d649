"""The analysis ``run``: the motion over time, or samples alone in discrete time."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from ..scene.run.plan import Costs, Stage
from ..scene.run.stages import plan_of, steps_of
from .base import Analysis
from .run import RunAnswer

if TYPE_CHECKING:
    from ..scene.run.scene import Scene


class Run(Analysis):
    """The motion of a scene, or its samples in discrete time, by the stages of its plan."""

    name = "run"
    handles_choices = True
    switches = "all"

    @classmethod
    def answer(  # type: ignore[override]  # it has no settings
        cls, scene: Scene, progress: Callable[[Stage], None] | None = None, *, folder: str | Path | None = None
    ) -> RunAnswer:
        """The answer, written into a folder unless it is None: the needed stages run one after another, and each is measured."""
        kind = RunAnswer
        if scene.table.time.step_domain == "discrete":
            from .discrete_run import DiscreteRunAnswer as kind  # loads state spaces and sequences in balls
        plan, costs = plan_of(scene, writing=folder is not None), Costs()
        answer = kind(scene, plan, None if folder is None else Path(folder))
        with nullcontext() if folder is None else answer.writing_together():
            for step, stage in zip(steps_of(scene), plan.stages):
                if stage.needed and step.work:
                    if progress:
                        progress(stage)
                    step.work(answer)
                    costs.lap(step.name)
        answer.plan = plan.with_costs(costs.by_name)
        return answer
