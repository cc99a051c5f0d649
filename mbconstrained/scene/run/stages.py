"""The stages of a scene, in the order in which they run.

One list serves the plan (``plan_of``) and the run (``run_stages``): stages listed as taken run, no others. The first
stages, down to the staircase, run while a scene is read; ``decisions`` decides about the others.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from operator import attrgetter, methodcaller
from pathlib import Path

from . import decisions
from .decisions import Decision
from .plan import PAGE, Plan, Stage
from .result import Result
from .scene_data import SceneData
from .stage_costs import Costs


@dataclass(frozen=True)
class PossibleStage:
    """A stage that a scene may need.

    Attributes:
        name: name of the stage.
        decide: whether a scene needs it, and the reason; the same for all scenes where it is no function.
        work: does it; None where reading the scene, or another stage, does it.
        writes: whether only files need it.
        part_of: the stage that does it, where it is not measured itself.
    """

    name: str
    decide: Callable[[SceneData], Decision] | Decision
    work: Callable[[Result], object] | None = None
    writes: bool = False
    part_of: str = ""


FILE_STEPS = (
    PossibleStage("read the scene", (True, "checked against the schema")),
    PossibleStage("units", decisions.units),
)
ROBOT_STEPS = (
    PossibleStage("robot model (pinocchio)", decisions.robot_model),
    PossibleStage("equilibrium", decisions.equilibrium),
    PossibleStage("robot meshes", decisions.robot_meshes, writes=True, part_of="animation"),
    PossibleStage("collision geometry", decisions.collision_geometry, writes=True, part_of="animation"),
)
NO_ROBOT_STEPS = (PossibleStage("robot model (pinocchio)", (False, "no robot in the scene")),)
OUTPUTS = PossibleStage("outputs", decisions.outputs, methodcaller("curves", "output"))
ROBOT_NEXT = {
    "displacements": (OUTPUTS,),
    "reactions": (
        PossibleStage("forces of loops and springs", decisions.connection_forces, methodcaller("curves", "ground_reaction")),
    ),
}  # the stage before: those of a robot that come next
CONTROL_NEXT = {  # the same of a state space
    "assemble the model": (PossibleStage("mechanical normal form", decisions.normal_form),),
    "displacements": (OUTPUTS,),
    "modes": (PossibleStage("transfer functions", decisions.transfer_functions, attrgetter("scene.equations.control.transfers")),),
}
STEPS = (
    PossibleStage("assemble the model", decisions.assembly),
    PossibleStage("dependent constraint rows", decisions.constraint_rows, part_of="assemble the model"),
    PossibleStage("constrained form", decisions.constrained_form, part_of="assemble the model"),
    PossibleStage("scaling and staircase", (True, "splits the finite from the infinite part by rank decisions")),
    PossibleStage("finite pair", decisions.finite_pair, attrgetter("finite_pair")),
    PossibleStage("infinite pair", decisions.infinite_pair, attrgetter("infinite_pair")),
    PossibleStage("response", decisions.response, attrgetter("motion")),
    PossibleStage("displacements", (True, "the answer itself"), methodcaller("curves", "displacement")),
    PossibleStage("velocities", decisions.velocities, methodcaller("curves", "velocity")),
    PossibleStage("accelerations", partial(decisions.plotted, kind="acceleration"), methodcaller("curves", "acceleration")),
    PossibleStage("reactions", decisions.reactions, methodcaller("curves", "reaction")),
    PossibleStage("energy", partial(decisions.plotted, kind="energy"), methodcaller("curves", "energy")),
    PossibleStage("element quantities", decisions.element_quantities, methodcaller("curves", "quantity")),
    PossibleStage("modes", decisions.modes, attrgetter("modes")),
    PossibleStage("error estimate", (True, "an answer carries its evidence"), attrgetter("error_estimate")),
    PossibleStage("proof (python-flint)", decisions.proof, part_of="error estimate"),
    PossibleStage("certificate (python-flint)", decisions.certificate, attrgetter("certificate")),
    PossibleStage("symbols (sympy)", decisions.symbols, attrgetter("formula"), writes=True),
    PossibleStage("frequency response", decisions.frequency, attrgetter("frequency.response")),
    PossibleStage("frequency page and files", decisions.frequency_files, methodcaller("write_frequency"), writes=True),
    PossibleStage("animation", decisions.animation, attrgetter("animation"), writes=True),
    PossibleStage("CSV", partial(decisions.written, kind="csv"), methodcaller("write_csv"), writes=True),
    PossibleStage("npz", partial(decisions.written, kind="npz"), methodcaller("write_npz"), writes=True),
    PossibleStage("other formats", decisions.formats, methodcaller("write_formats"), writes=True),
    PossibleStage("plots as images (matplotlib)", decisions.plot_images, methodcaller("write_plots"), writes=True),
    PossibleStage("still picture (Chromium)", decisions.still, methodcaller("try_still"), writes=True),
    PossibleStage(
        PAGE, partial(decisions.written, kind="page"), methodcaller("write_page"), writes=True
    ),  # after the stages that it lists
)


def steps_of(scene: SceneData) -> tuple[PossibleStage, ...]:
    """The stages of a kind of scene: those of a robot or a state space only where there is one."""
    kind = scene.table.model.kind
    first = ROBOT_STEPS if kind == "robot" else NO_ROBOT_STEPS
    following = {"robot": ROBOT_NEXT, "state-space": CONTROL_NEXT}.get(kind, {})
    return (*FILE_STEPS, *first, *(each for step in STEPS for each in (step, *following.get(step.name, ()))))


def plan_of(scene: SceneData, *, writing: bool = True) -> Plan:
    """Decide about every stage without running any."""
    requested = scene if writing else scene.unwritten()
    return Plan(tuple(_stage(step, requested, writing) for step in steps_of(scene))).with_costs(scene.costs)


def _stage(step: PossibleStage, scene: SceneData, writing: bool) -> Stage:
    if step.writes and not writing:
        return Stage(step.name, False, "no folder to write to was given")
    decision = step.decide if isinstance(step.decide, tuple) else step.decide(scene)
    return Stage(step.name, *decision, part_of=step.part_of)


def run_stages(scene: SceneData, folder: Path | None, progress: Callable[[Stage], None] | None) -> Result:
    """Run the needed stages one after another and measure each."""
    result = Result(scene, plan_of(scene, writing=folder is not None), folder)
    with result.writing_together():
        for step, stage in zip(steps_of(scene), result.plan.stages):
            if stage.needed and step.work:
                if progress:
                    progress(stage)
                costs = Costs()
                step.work(result)
                result.plan = result.plan.with_costs({step.name: costs.lap(step.name)})
    return result
