"""The stages of a scene: what decides whether each is needed, and what it does.

A scene is planned first (``plan_of``) and then run (``run_stages``) by the very same list: what is listed as
taken is called, nothing else is. The first stages, down to the staircase, have run when a scene has been read;
the plan is decided from what they found.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import attrgetter, methodcaller
from pathlib import Path
from typing import TYPE_CHECKING

from .plan import Plan, Stage
from .result import Result

if TYPE_CHECKING:
    from .scene import Scene

Decision = tuple[bool, str]


@dataclass(frozen=True)
class Step:
    """A stage that a scene may need.

    Attributes:
        name: what is done.
        decide: whether a scene needs it, and the reason.
        work: does it; None where reading the scene has done it already.
        writes: whether it is needed only for what is written.
    """

    name: str
    decide: Callable[[Scene], Decision]
    work: Callable[[Result], object] | None = None
    writes: bool = False


def steps_of(scene: Scene) -> tuple[Step, ...]:
    """The stages that are spoken of: those of a robot or a state space only where there is one."""
    robot = ROBOT_STEPS if scene.equations.robot_scene else NO_ROBOT_STEPS
    control = CONTROL_STEPS if scene.table.model.kind == "state-space" else {}
    return (*FILE_STEPS, *robot, *(each for step in STEPS for each in (step, *control.get(step.name, ()))))


def plan_of(scene: Scene, *, writing: bool = True) -> Plan:
    """Decide every stage, run none."""
    return Plan(tuple(_stage(step, scene, writing) for step in steps_of(scene)))


def _stage(step: Step, scene: Scene, writing: bool) -> Stage:
    if step.writes and not writing:
        return Stage(step.name, False, "no folder to write to was given")
    return Stage(step.name, *step.decide(scene), scene.seconds.get(step.name))


def run_stages(scene: Scene, folder: Path | None, progress: Callable[[Stage], None] | None) -> Result:
    """Run the taken stages one after another and note how long each takes."""
    result = Result(scene, plan_of(scene, writing=folder is not None), folder)
    stages = []
    with result.writing_together():
        for step, stage in zip(steps_of(scene), result.plan.stages):
            if stage.taken and step.work:
                if progress:
                    progress(stage)
                start = time.perf_counter()
                step.work(result)
                stage = replace(stage, seconds=time.perf_counter() - start)
            stages.append(stage)
    result.plan = Plan(tuple(stages))
    return result


def counted(count: int, one: str, many: str = "") -> str:
    """A number with its noun.

    >>> counted(1, "row"), counted(2, "row")
    ('1 row', '2 rows')
    """
    return f"{count} {one if count == 1 else many or one + 's'}"


def _always(reason: str):
    return lambda scene: (True, reason)


def _never(reason: str):
    return lambda scene: (False, reason)


def _units(scene) -> Decision:
    found = scene.equations.robot_scene
    texts = scene.unit_texts + (found.data.unit_texts if found else 0)
    if texts:
        return True, f"{counted(texts, 'quantity', 'quantities')} with a unit"
    return False, "all quantities are plain numbers in SI"


def _assembly(scene) -> Decision:
    equations = scene.equations
    count, degree = len(equations.coordinates.names), equations.polynomial_matrix.degree
    if equations.control is not None:
        return True, _control_size(equations.control)
    if equations.model is not None:
        return True, f"{counted(len(equations.model.elements), 'element')}, {counted(count, 'coordinate')}"
    return True, f"{counted(count, 'coordinate')}, degree {degree}"


def _control_size(control) -> str:
    if control.transfer_function is not None:
        b, a = control.transfer_function.fraction.numerator, control.transfer_function.fraction.denominator
        return f"numerator of degree {max(len(b) - 1, 0)}, denominator of degree {len(a) - 1}"
    counts = ((control.system.states, "state"), (control.inputs.names, "input"), (control.outputs.names, "output"))
    return ", ".join(counted(len(names), what) for names, what in counts)


def _normal_form(scene) -> Decision:
    form = scene.equations.control.form
    if form is None:
        return False, "normal_form = false: the states are taken as they are"
    return True, f"normal_form = true: {counted(form.size, 'displacement')} and as many velocities"


def _transfer_functions(scene) -> Decision:
    control = scene.equations.control
    if not (control.inputs.names and control.outputs.names):
        return False, "there are no inputs or no outputs"
    if not control.looks_for_zeros:
        return False, "many states or outputs: zeros take long; DC gains are told"
    return True, "zeros, gain and DC gain from each input to each output"


def _outputs(scene) -> Decision:
    control = scene.equations.control
    if not control.outputs.names:
        return False, "there is no C"
    if control.form is None:
        return True, "C x + D u, solved for together with the states"
    asked = "output" in scene.table.output.plots
    return asked, "C x + D u, of the states that were given" if asked else "output is not among the plots"


def _constraint_rows(scene) -> Decision:
    system = scene.equations.system
    if scene.equations.control is not None:
        return False, f"a {scene.table.model.kind.replace('-', ' ')} has no constraint rows"
    if system is None:
        return False, "A_0, A_1, … are given: constraints are equations among the others"
    if scene.equations.robot:
        removed = len(_load(scene).row_names) - len(system.rows)
    else:
        removed = sum(notice.kind == "redundant" for notice in system.notices)
    if not system.rows and not removed:
        return False, "the robot has no loops: no rows are built" if scene.equations.robot else "no constraint rows"
    return True, f"{counted(len(system.rows) + removed, 'row')}, {removed} of them dependent"


def _constrained_form(scene) -> Decision:
    system = scene.equations.system
    if system is None or not system.rows:
        return False, "no constraint rows"
    levels = sorted({row.level for row in system.rows})
    return True, f"{counted(len(system.rows), 'independent row')} at {' and '.join(levels)} level"


def _robot_model(scene) -> Decision:
    found = scene.equations.robot_scene
    return True, f"{found.data.place}: {counted(len(found.robot.bodies), 'link')}, {counted(len(found.robot.joints), 'joint')}"


def _equilibrium(scene) -> Decision:
    load = _load(scene)
    held = [
        counted(len(rows), one, many)
        for rows, one, many in (
            (load.loops, "closed loop", "closed loops"),
            (load.couplings, "joint that follows another", "joints that follow others"),
        )
        if rows
    ]
    return True, f"the motion is about a state of rest, with {' and '.join(held) or 'no loops to close'}"


def _load(scene):
    """What holds and loads the robot."""
    return scene.equations.posture.balance.load


def _robot_meshes(scene) -> Decision:
    meshes = scene.equations.robot_scene.data.names.meshes
    if not meshes:
        return False, "the robot is drawn from boxes, cylinders and spheres"
    drawn, _ = _animation(scene)
    return drawn, f"{counted(len(meshes), 'mesh', 'meshes')} to draw" if drawn else "meshes are read only where they are drawn"


def _infinite_pair(scene) -> Decision:
    equations = scene.equations
    A = equations.polynomial_matrix
    if not any(A.jordan_pairs().form.split.infinite_divisors):
        return False, f"A_{A.degree} is nonsingular: there is no infinite part"
    if equations.is_free and equations.start_fits:
        return False, "no force and a start that fits: the infinite part stays zero"
    return True, f"A_{A.degree} is singular and {'the start does not fit' if equations.is_free else 'a force acts'}"


def _reactions(scene) -> Decision:
    output, system = scene.table.output, scene.equations.system
    if system is None or not system.rows:
        return False, "no constraint rows"
    asked = output.reactions or "reaction" in output.plots
    return asked, "asked for in [output]" if asked else "not asked for in [output]"


def _plotted(kind: str):
    def decide(scene) -> Decision:
        asked = kind in scene.table.output.plots
        return asked, f"{kind} is{'' if asked else ' not'} among the plots"

    return decide


def _modes(scene) -> Decision:
    if scene.equations.system is None:
        listed = "the zeros of A(s)" if scene.equations.control is None else "the poles"
        return False, f"no mechanical system: {listed} are listed as they are"
    return True, "tells oscillations, rigid bodies and drift apart"


def _animation(scene) -> Decision:
    output = scene.table.output
    if not output.page:
        return False, "no page"
    if not output.animation:
        return False, "animation = false"
    if scene.equations.has_outputs_among_coordinates and scene.table.drawing is None:
        return False, "states and outputs are no places: a [drawing] would say how they move"
    return True, "the model moves on the page, by displacements and velocities"


def is_animated(scene: Scene) -> bool:
    """Whether a page shows the model moving."""
    return _animation(scene)[0]


def _symbols(scene) -> Decision:
    output, count = scene.table.output, len(scene.parameters.values)
    if not output.formula:
        return False, "nothing symbolic is asked for"
    if not output.page:
        return False, "no page to show the formula on"
    from .formula import too_large

    if reason := too_large(scene):
        return False, reason
    return True, f"formula = true: {counted(count, 'parameter')} as symbols" if count else "formula = true: with exact numbers"


def _certificate(scene) -> Decision:
    certify = scene.table.output.certify
    if not certify:
        return False, "not asked for (--certify, or certify = true in [output])"
    from .certificate import too_large

    if reason := too_large(scene.equations):
        return False, reason
    return True, "digits of every coordinate" if certify is True else f"digits of {', '.join(certify)}"


def _wanted(kind: str):
    def decide(scene) -> Decision:
        wanted = getattr(scene.table.output, kind)
        return wanted, f"{scene.name}.{'html' if kind == 'page' else kind}" if wanted else f"{kind} = false"

    return decide


FILE_STEPS = (
    Step("read the scene", _always("checked against the schema")),
    Step("units", _units),
)
ROBOT_STEPS = (
    Step("robot model (pinocchio)", _robot_model),
    Step("equilibrium", _equilibrium),
    Step("robot meshes", _robot_meshes, writes=True),
    Step("collision geometry", _never("it is never loaded")),
)
NO_ROBOT_STEPS = (Step("robot model (pinocchio)", _never("no robot in the scene")),)
CONTROL_STEPS = {  # the stage before: those of a state space that come next
    "assemble the model": (Step("mechanical normal form", _normal_form),),
    "displacements": (Step("outputs", _outputs, methodcaller("curves", "output")),),
    "modes": (Step("transfer functions", _transfer_functions, attrgetter("scene.equations.control.transfers")),),
}
STEPS = (
    Step("assemble the model", _assembly),
    Step("dependent constraint rows", _constraint_rows),
    Step("constrained form", _constrained_form),
    Step("scaling and staircase", _always("splits the finite from the infinite part by rank decisions")),
    Step("finite pair", _always("the motion for t > 0"), attrgetter("finite_pair")),
    Step("infinite pair", _infinite_pair, attrgetter("infinite_pair")),
    Step("response", _always("from the values at 0-, with jumps and impulses"), attrgetter("motion")),
    Step("displacements", _always("the answer itself"), methodcaller("curves", "displacement")),
    Step("velocities", _plotted("velocity"), methodcaller("curves", "velocity")),
    Step("accelerations", _plotted("acceleration"), methodcaller("curves", "acceleration")),
    Step("reactions", _reactions, methodcaller("curves", "reaction")),
    Step("energy", _plotted("energy"), methodcaller("curves", "energy")),
    Step("modes", _modes, attrgetter("modes")),
    Step("error estimate", _always("an answer carries its evidence"), attrgetter("error_estimate")),
    Step("certificate (python-flint)", _certificate, attrgetter("certificate")),
    Step("symbols (sympy)", _symbols, attrgetter("formula"), writes=True),
    Step("animation", _animation, attrgetter("animation"), writes=True),
    Step("page", _wanted("page"), methodcaller("write_page"), writes=True),
    Step("CSV", _wanted("csv"), methodcaller("write_csv"), writes=True),
    Step("npz", _wanted("npz"), methodcaller("write_npz"), writes=True),
    Step("plots as images (matplotlib)", _never("the page draws its own")),
)
