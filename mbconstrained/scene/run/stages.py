"""The stages of a scene, in the order in which they run, and the decisions which of them it needs.

One list serves the plan (``plan_of``) and the run: stages listed as taken run, no others. The first stages, down to the staircase, run
while a scene is read.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import chain
from operator import attrgetter, methodcaller
from typing import Any

from ...ground.checks import counted
from ...response.choose import PAIRS, unproved
from ..build.model import Decision, Equations
from .plan import PAGE, Plan, Stage
from .scene_data import UNWRITTEN, SceneData

LateDecision = tuple[bool, Callable[[], str]]  # whose reason takes an analysis of its own, once it is shown

#: Most states (coordinates and multipliers times the degree) of a certificate: exact arithmetic with more takes minutes.
MOST_CERTIFIED_STATES = 240

#: Largest product of the number of coordinates and the degree for which a formula is computed.
MOST_FORMULA_STATES = 60


# Decisions: those of the model first, then those requested by [output].


def units(scene: SceneData) -> Decision:
    texts = scene.unit_texts + scene.equations.unit_texts
    if texts:
        return True, f"{counted(texts, 'quantity', 'quantities')} with a unit"
    return False, "all quantities are numbers in SI without units"


def normal_form(scene: SceneData) -> Decision:
    """Whether a state space is transformed to a mechanical system."""
    form = scene.equations.control.form
    if form is None:
        return False, "normal_form = false: the states as given"
    massless = f", {counted(form.infinite.size, 'massless coordinate')}" if form.infinite else ""
    return True, f"normal_form = true: {counted(form.size, 'displacement')} and as many velocities{massless}"


def robot_model(scene: SceneData) -> Decision:
    robot = scene.equations.robot_scene
    return True, f"{robot.data.place}: {counted(len(robot.robot.bodies), 'link')}, {counted(len(robot.robot.joints), 'joint')}"


def equilibrium(scene: SceneData) -> Decision:
    load = scene.equations.posture.balance.load
    rows_by_kind = [
        counted(len(rows), one, many)
        for rows, one, many in (
            (load.loops, "closed loop", "closed loops"),
            (load.mimic_rows, "joint that follows another", "joints that follow others"),
        )
        if rows
    ]
    return True, f"the motion is about a state of rest, with {' and '.join(rows_by_kind) or 'no loops to close'}"


def constrained_form(scene: SceneData) -> Decision:
    system = scene.equations.system
    if system is None or not system.rows:
        return False, "no constraint rows"
    levels = sorted({row.level for row in system.rows})
    return True, f"{counted(len(system.rows), 'independent row')} at {' and '.join(levels)} level"


def split_off(
    scene: SceneData, reduced: str, split: Decision | Callable[[SceneData], Decision | LateDecision]
) -> Decision | LateDecision:
    """A part of the Weierstrass form, and the reason for omitting it where the reduced equations give motion and eigenvalues, and neither
    file nor frequency response needs the Jordan pairs."""
    equations, table = scene.equations, scene.table
    if equations.switching is not None:
        return False, "each phase has its own, made when the motion enters it"
    if not scene.problem.delayed:
        if equations.polynomial_matrix.large_reduction is not None:
            return False, reduced
        if not (equations.system is None or table.output.npz or table.frequency or scene.method.name == PAIRS):
            return False, reduced
    return split if isinstance(split, tuple) else split(scene)


def finite_pair(scene: SceneData) -> Decision | LateDecision:
    """Eigenvalues are always listed; the motion comes from the pair only where the chosen method uses pairs."""
    if scene.problem.delayed:
        return True, "the motion within each delay"
    only = "the eigenvalues; the motion comes from the reduced equations"
    return True, lambda: "the motion for t > 0, and the eigenvalues" if scene.method.name == PAIRS else only


def infinite_pair(scene: SceneData) -> Decision:
    """Jumps and impulses come from the infinite pair; free admissible motion needs none (Moysis et al., section 4.1)."""
    equations, A = scene.equations, scene.equations.polynomial_matrix
    if equations.has_regular_leading_coefficient or not any(A.jordan_pairs().form.split.infinite_divisors):
        return False, f"A_{A.degree} is nonsingular: there is no infinite part"
    if equations.is_free and equations.start_fits:
        return False, "no force and a start that fits: the infinite part stays zero"
    return True, f"A_{A.degree} is singular and {'the start does not fit' if equations.is_free else 'a force acts'}"


def response(scene: SceneData) -> LateDecision:
    """The response, and the method that gives its values at the times of the scene."""
    return True, lambda: f"from the values at 0-, with jumps and impulses; values {scene.method.reason}"


def modes(scene: SceneData) -> Decision:
    if scene.equations.system is None:
        listed = {"zero": "zeros of A(s)"}.get(scene.equations.root_name, "poles")
        return False, f"no mechanical system: the {listed} are listed without a meaning"
    return True, "classifies oscillations, rigid-body modes and drift"


def proof(scene: SceneData) -> Decision:
    """Error bounds instead of estimates, for small models with exact data."""
    reason = scene.equations.unproved(unproved(scene.problem), scene.table.output.plots)
    return not reason, reason or "few states: the error is bounded, and values beyond the bound come from the exact engine"


def transfer_functions(scene: SceneData) -> Decision:
    """Transfer functions from each input to each output of a state space."""
    control = scene.equations.control
    if not (control.inputs.names and control.outputs.names):
        return False, "there are no inputs or no outputs"
    if not control.looks_for_zeros:
        return False, "many states or outputs: zeros take long; DC gains are listed"
    return True, "zeros, gain and DC gain from each input to each output"


def velocities(scene: SceneData) -> Decision:
    """Velocities, which an animation needs as well as plots."""
    for plot in ("velocity", "phase"):
        if plot in scene.table.output.plots:
            return True, f"{plot} is among the plots"
    if animation(scene)[0]:
        return True, "the animation moves by displacements and velocities"
    return False, "velocity is not among the plots"


def reactions(scene: SceneData) -> Decision:
    output = scene.table.output
    if not scene.equations.has_reactions:
        return False, "no constraint rows"
    requested = output.reactions or "reaction" in output.plots
    if not requested and output.arrows and animation(scene)[0]:
        return True, "arrows in the animation show them"
    return requested, "requested in [output]" if requested else "not requested in [output]"


def connection_forces(scene: SceneData) -> Decision:
    """Forces of loops, springs and bushings of a robot in the directions of the ground."""
    output = scene.table.output
    return scene.equations.connections_decision(output.reactions or "ground_reaction" in output.plots)


def element_quantities(scene: SceneData) -> Decision:
    return True, counted(len(scene.table.output.quantity), "entry", "entries") + " of [[output.quantity]]"


def certificate(scene: SceneData) -> Decision:
    certify = scene.table.output.certify
    if reason := without_certificate(scene.equations):
        return False, reason
    return True, "digits of every coordinate" if certify is True else f"digits of {', '.join(certify)}"


def symbols(scene: SceneData) -> Decision:
    output, count = scene.table.output, len(scene.parameters.values)
    if not output.page:
        return False, "no page to show the formula on"
    if reason := too_large_for_formula(scene):
        return False, reason
    return True, f"formula = true: {counted(count, 'parameter')} as symbols" if count else "formula = true: with exact numbers"


def animation(scene: SceneData) -> Decision:
    output = scene.table.output
    pictured = output.still is not None and still(scene)[0]
    if not (output.page or pictured):
        return False, "no page"
    if not (output.animation or pictured):
        return False, "animation = false"
    if not _has_places(scene):
        return False, "states and outputs have no geometry: add a [drawing]"
    if scene.table.time.step_domain == "discrete":
        return True, "the model from sample to sample"
    if not (output.page and output.animation):
        return True, "the still picture shows the model where it is then"
    return True, "the model moves on the page, by displacements and velocities"


def is_animated(scene: SceneData) -> bool:
    """Whether a page animates the model."""
    output = scene.table.output
    return output.page and output.animation and _has_places(scene)


def _has_places(scene: SceneData) -> bool:
    drawing = scene.table.drawing
    return not scene.equations.has_outputs_among_coordinates or (drawing is not None and drawing.is_own)


def still(scene: SceneData) -> Decision:
    time = scene.table.output.still
    if time is None:
        return False, "not requested (--still TIME, or still = TIME in [output])"
    if not _has_places(scene):
        return False, "states and outputs have no geometry: add a [drawing]"
    from ...page.photograph import NONE_INSTALLED, browser

    return (True, f"{scene.name}.still.png, the model at {time:g} s") if browser() else (False, NONE_INSTALLED)


def formats(scene: SceneData) -> Decision:
    return True, ", ".join(scene.table.output.formats)


def plot_images(scene: SceneData) -> Decision:
    return True, f"{scene.name}.*.svg and .png"


def robot_meshes(scene: SceneData) -> Decision:
    meshes = scene.equations.robot_scene.data.names.meshes
    if not meshes:
        return False, "the robot is drawn from boxes, cylinders and spheres"
    drawn = animation(scene)[0]
    return drawn, f"{counted(len(meshes), 'mesh', 'meshes')} to draw" if drawn else "meshes are read only where they are drawn"


def collision_geometry(scene: SceneData) -> Decision:
    drawn = animation(scene)[0]
    return drawn, "the page shows it on request" if drawn else "it is read only where the robot is drawn"


def frequency(scene: SceneData) -> Decision:
    return True, f"[frequency]: {scene.table.frequency.quantity}"


def frequency_files(scene: SceneData) -> Decision:
    output = scene.table.output
    kinds = [ending for ending, wanted in (("html", output.page), ("csv", output.csv), ("npz", output.npz)) if wanted]
    if not kinds:
        return False, "page, csv and npz = false"
    return True, f"{scene.name}.frequency.{', .'.join(kinds)}"


def written(scene: SceneData, kind: str) -> Decision:
    return True, f"{scene.name}.{kind}"


def too_large_to_certify(equations: Equations) -> str:
    """The reason why equations are not certified; empty where they are."""
    rows, A = len(equations.system.rows) if equations.system else 0, equations.polynomial_matrix
    states = (A.size + rows) * max(A.degree, 1)
    if states <= MOST_CERTIFIED_STATES:
        return ""
    return f"exact arithmetic with {states} states takes too long, {MOST_CERTIFIED_STATES} is the most"


def without_certificate(equations: Equations) -> str:
    """The reason why the equations of a scene are not certified; empty where they are."""
    return too_large_to_certify(equations) or next((end.uncertified for end in equations.ends if end.uncertified), "")


def too_large_for_formula(scene: SceneData) -> str:
    """The reason why no formula is computed; empty where one is."""
    A = scene.equations.polynomial_matrix
    if scene.equations.robot is not None or A.size * A.degree <= MOST_FORMULA_STATES:
        return ""
    most = f"at most {MOST_FORMULA_STATES} for both multiplied"
    return f"{A.size} coordinates with equations of degree {A.degree} are too many for formulas ({most})"


# The stages.


@dataclass(frozen=True)
class PossibleStage:
    """A stage that a scene may need."""

    name: str  # name of the stage
    # whether a scene needs it, and the reason; the same for all scenes where it is no function
    decide: Callable[[SceneData], Decision | LateDecision] | Decision
    work: Callable[[Any], object] | None = None  # does it; None where reading the scene, or another stage, does it
    writes: bool = False  # whether only files need it
    part_of: str = ""  # the stage that does it, where it is not measured itself


FILE_STEPS = (PossibleStage("read the scene", (True, "checked against the schema")), PossibleStage("units", units))
ROBOT_STEPS = (
    PossibleStage("robot model (pinocchio)", robot_model),
    PossibleStage("equilibrium", equilibrium),
    PossibleStage("robot meshes", robot_meshes, writes=True, part_of="animation"),
    PossibleStage("collision geometry", collision_geometry, writes=True, part_of="animation"),
)
NO_ROBOT_STEPS = (PossibleStage("robot model (pinocchio)", (False, "no robot in the scene")),)
OUTPUTS = PossibleStage(
    "outputs", lambda scene: scene.equations.outputs_decision(scene.table.output.plots), methodcaller("curves", "output")
)
ROBOT_NEXT = {
    "displacements": (OUTPUTS,),
    "reactions": (PossibleStage("forces of loops and springs", connection_forces, methodcaller("curves", "ground_reaction")),),
}  # the stage before: those of a robot that come next
CONTROL_NEXT = {  # the same of a state space
    "assemble the model": (PossibleStage("mechanical normal form", normal_form),),
    "displacements": (OUTPUTS,),
    "modes": (PossibleStage("transfer functions", transfer_functions, attrgetter("scene.equations.control.transfers")),),
}
FORCES = PossibleStage("forces", (True, "force is among the plots"), methodcaller("curves", "force"))
STEPS = (
    PossibleStage("assemble the model", lambda scene: scene.equations.size_decision()),
    PossibleStage("dependent constraint rows", lambda scene: scene.equations.rows_decision(), part_of="assemble the model"),
    PossibleStage("constrained form", constrained_form, part_of="assemble the model"),
    PossibleStage(
        "switches",
        lambda scene: (
            (True, one.reason) if (one := scene.equations.switching) else (False, "no contacts, friction or other switches")
        ),
        part_of="response",
    ),
    PossibleStage(
        "scaling and staircase",
        partial(
            split_off,
            reduced="the equations reduce directly without rank decisions",
            split=(True, "splits the finite from the infinite part by rank decisions"),
        ),
        methodcaller("jordan_pairs"),
    ),
    PossibleStage(
        "finite pair",
        partial(split_off, reduced="the modes have the eigenvalues", split=finite_pair),
        attrgetter("finite_pair"),
    ),
    PossibleStage(
        "infinite pair",
        partial(split_off, reduced="the reduced equations, which have no infinite part, serve", split=infinite_pair),
        attrgetter("infinite_pair"),
    ),
    PossibleStage("response", response, attrgetter("motion")),
    PossibleStage("displacements", (True, "the answer itself"), methodcaller("curves", "displacement")),
    PossibleStage("velocities", velocities, methodcaller("curves", "velocity")),
    PossibleStage("accelerations", (True, "acceleration is among the plots"), methodcaller("curves", "acceleration")),
    PossibleStage("reactions", reactions, methodcaller("curves", "reaction")),
    PossibleStage("energy", (True, "energy is among the plots"), methodcaller("curves", "energy")),
    PossibleStage("element quantities", element_quantities, methodcaller("curves", "quantity")),
    PossibleStage("modes", modes, attrgetter("modes")),
    PossibleStage("error estimate", (True, "an answer carries its evidence"), attrgetter("error_estimates")),
    PossibleStage("proof", proof, part_of="error estimate"),
    PossibleStage("certificate (python-flint)", certificate, attrgetter("certificate")),
    PossibleStage("symbols (sympy)", symbols, attrgetter("formula"), writes=True),
    PossibleStage("frequency response", frequency, attrgetter("frequency.response")),
    PossibleStage("frequency page and files", frequency_files, methodcaller("write_frequency"), writes=True),
    PossibleStage("animation", animation, attrgetter("animation"), writes=True),
    PossibleStage("CSV", partial(written, kind="csv"), methodcaller("write_csv"), writes=True),
    PossibleStage("npz", partial(written, kind="npz"), methodcaller("write_npz"), writes=True),
    PossibleStage("other formats", formats, methodcaller("write_formats"), writes=True),
    PossibleStage("plots as images (matplotlib)", plot_images, methodcaller("write_plots"), writes=True),
    PossibleStage("still picture (Chromium)", still, methodcaller("try_still"), writes=True),
    PossibleStage(PAGE, partial(written, kind="html"), methodcaller("write_page"), writes=True),  # after the stages that it lists
)


#: Stages of the samples of a scene in discrete time, and of writing them.
DISCRETE_STEPS = (
    STEPS[0],
    PossibleStage("difference equations", (True, "in discrete time, in closed form"), attrgetter("sequence")),
    PossibleStage("samples", (True, "the answer itself"), attrgetter("values")),
    PossibleStage("error estimate", (True, "an answer carries its evidence"), attrgetter("error_estimates")),
    PossibleStage("animation", animation, writes=True, part_of=PAGE),
    *(step for step in STEPS if step.name in ("CSV", "npz", "plots as images (matplotlib)", PAGE)),
)


#: The entry of a scene that requests a stage, by its name, and the reason for omitting it where the entry is left out.
REQUESTS = {
    "element quantities": ("output.quantity", "no [[output.quantity]]"),
    "certificate (python-flint)": ("output.certify", "not requested (--certify, or certify = true in [output])"),
    "symbols (sympy)": ("output.formula", "no formula is requested"),
    "frequency response": ("frequency", "not requested (a table [frequency], or the command frequency)"),
    "frequency page and files": ("frequency", "no frequency response"),
    "other formats": ("output.formats", 'not requested (formats in [output], e.g. ["mat", "uff"])'),
    **{name: (f"output.{kind}", f"{kind} = false") for name, kind in (("CSV", "csv"), ("npz", "npz"), (PAGE, "page"))},
    "plots as images (matplotlib)": ("output.plot_images", "not requested (--plots, or plot_images = true in [output])"),
}

#: Plots that alone request a stage.
PLOTS = {"accelerations": "acceleration", "energy": "energy"}


def steps_of(scene: SceneData) -> tuple[PossibleStage, ...]:
    """The stages of a kind of scene: those of a robot or a state space only where there is one."""
    kind = scene.table.model.kind
    first = ROBOT_STEPS if kind == "robot" else NO_ROBOT_STEPS
    if scene.table.time.step_domain == "discrete":
        return (*FILE_STEPS, *first, *DISCRETE_STEPS)
    ends = (end for end in scene.equations.ends if end.duration)  # that the scene decides
    solved = tuple(PossibleStage(end.title.lower(), (True, f"[{end.key}]: over {end.duration:g} s")) for end in ends)
    further = {"assemble the model": solved, "energy": (FORCES,) if "force" in scene.table.output.plots else ()}
    following = {"robot": ROBOT_NEXT, "state-space": CONTROL_NEXT}.get(kind, {}), further
    extended = [(step, *(each for stages in following for each in stages.get(step.name, ()))) for step in STEPS]
    return (*FILE_STEPS, *first, *chain.from_iterable(extended))


def plan_of(scene: SceneData, *, writing: bool = True) -> Plan:
    """Decide about every stage without running any."""
    scene = scene if writing else scene.with_output(**UNWRITTEN)
    stages = []
    for step in steps_of(scene):
        if step.writes and not writing:
            stages.append(Stage(step.name, False, "no folder to write to was given"))
            continue
        decision, plot = step.decide, PLOTS.get(step.name)
        entry, unless = REQUESTS.get(step.name, ("", ""))
        if entry and not attrgetter(entry)(scene.table):
            decision = False, unless
        elif plot and plot not in scene.table.output.plots:
            decision = False, f"{plot} is not among the plots"
        stages.append(Stage(step.name, *(decision if isinstance(decision, tuple) else decision(scene)), part_of=step.part_of))
    return Plan(tuple(stages)).with_costs(scene.costs)
