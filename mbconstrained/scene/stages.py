"""The stages of a scene, in the order in which they run.

A scene is planned first (``plan_of``) and then run (``run_stages``) by the very same list: what is listed as
taken is called, nothing else is. The first stages, down to the staircase, have run when a scene has been read;
the plan is decided from what they found (``model_decisions``) and from what is asked for (``output_decisions``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter, methodcaller
from pathlib import Path
from typing import TYPE_CHECKING

from . import model_decisions as model
from . import output_decisions as output
from .model_decisions import Decision
from .plan import Plan, Stage
from .result import Result
from .stage_costs import Meter

if TYPE_CHECKING:
    from .scene import Scene

#: The stage that tells what the others took.
PAGE = "page"


@dataclass(frozen=True)
class Step:
    """A stage that a scene may need.

    Attributes:
        name: what is done.
        decide: whether a scene needs it, and the reason.
        work: does it; None where reading the scene, or another stage, does it.
        writes: whether it is needed only for what is written.
        part_of: the stage that does it, where it is not timed by itself.
    """

    name: str
    decide: Callable[[Scene], Decision]
    work: Callable[[Result], object] | None = None
    writes: bool = False
    part_of: str = ""


FILE_STEPS = (
    Step("read the scene", output.always("checked against the schema")),
    Step("units", model.units),
)
ROBOT_STEPS = (
    Step("robot model (pinocchio)", model.robot_model),
    Step("equilibrium", model.equilibrium),
    Step("robot meshes", output.robot_meshes, writes=True, part_of="animation"),
    Step("collision geometry", output.never("it is never loaded")),
)
NO_ROBOT_STEPS = (Step("robot model (pinocchio)", output.never("no robot in the scene")),)
OUTPUTS = Step("outputs", output.outputs, methodcaller("curves", "output"))
ROBOT_NEXT = {"displacements": (OUTPUTS,)}  # the stage before: those of a robot that come next
CONTROL_NEXT = {  # the same of a state space
    "assemble the model": (Step("mechanical normal form", model.normal_form),),
    "displacements": (OUTPUTS,),
    "modes": (Step("transfer functions", model.transfer_functions, attrgetter("scene.equations.control.transfers")),),
}
STEPS = (
    Step("assemble the model", model.assembly),
    Step("dependent constraint rows", model.constraint_rows, part_of="assemble the model"),
    Step("constrained form", model.constrained_form, part_of="assemble the model"),
    Step("scaling and staircase", output.always("splits the finite from the infinite part by rank decisions")),
    Step("finite pair", output.always("the motion for t > 0"), attrgetter("finite_pair")),
    Step("infinite pair", model.infinite_pair, attrgetter("infinite_pair")),
    Step("response", model.response, attrgetter("motion")),
    Step("displacements", output.always("the answer itself"), methodcaller("curves", "displacement")),
    Step("velocities", output.velocities, methodcaller("curves", "velocity")),
    Step("accelerations", output.plotted("acceleration"), methodcaller("curves", "acceleration")),
    Step("reactions", output.reactions, methodcaller("curves", "reaction")),
    Step("energy", output.plotted("energy"), methodcaller("curves", "energy")),
    Step("modes", model.modes, attrgetter("modes")),
    Step("error estimate", output.always("an answer carries its evidence"), attrgetter("error_estimate")),
    Step("certificate (python-flint)", output.certificate, attrgetter("certificate")),
    Step("symbols (sympy)", output.symbols, attrgetter("formula"), writes=True),
    Step("animation", output.animation, attrgetter("animation"), writes=True),
    Step("CSV", output.wanted("csv"), methodcaller("write_csv"), writes=True),
    Step("npz", output.wanted("npz"), methodcaller("write_npz"), writes=True),
    Step("plots as images (matplotlib)", output.plot_images, methodcaller("write_plots"), writes=True),
    Step("still picture (Chromium)", output.still, methodcaller("try_still"), writes=True),
    Step(PAGE, output.wanted("page"), methodcaller("write_page"), writes=True),  # after what it tells of
)


def steps_of(scene: Scene) -> tuple[Step, ...]:
    """The stages that are spoken of: those of a robot or a state space only where there is one."""
    kind = scene.table.model.kind
    first = ROBOT_STEPS if kind == "robot" else NO_ROBOT_STEPS
    following = {"robot": ROBOT_NEXT, "state-space": CONTROL_NEXT}.get(kind, {})
    return (*FILE_STEPS, *first, *(each for step in STEPS for each in (step, *following.get(step.name, ()))))


def plan_of(scene: Scene, *, writing: bool = True) -> Plan:
    """Decide every stage, run none; what the stages of reading took is known."""
    seen = scene if writing else scene.unwritten()
    return Plan(tuple(_stage(step, seen, writing) for step in steps_of(scene))).with_costs(scene.costs)


def _stage(step: Step, scene: Scene, writing: bool) -> Stage:
    if step.writes and not writing:
        return Stage(step.name, False, "no folder to write to was given")
    return Stage(step.name, *step.decide(scene), part_of=step.part_of)


def run_stages(scene: Scene, folder: Path | None, progress: Callable[[Stage], None] | None) -> Result:
    """Run the taken stages one after another and note what each takes."""
    result = Result(scene, plan_of(scene, writing=folder is not None), folder)
    with result.writing_together():
        for step, stage in zip(steps_of(scene), result.plan.stages):
            if stage.taken and step.work:
                if progress:
                    progress(stage)
                meter = Meter()
                step.work(result)
                result.plan = result.plan.with_costs({step.name: meter.lap()})
    return result
