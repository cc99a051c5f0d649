"""Decisions on the stages that a scene needs: those of its model first, then those requested by [output]."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...ground.checks import counted
from ...ground.notices import NoticeKind
from ...response.choose import PAIRS, unproved
from .scene_data import SceneData

if TYPE_CHECKING:
    from ..build.equations import Equations

Decision = tuple[bool, str]

#: Most states (coordinates and multipliers times the degree) of a certificate: exact arithmetic with more takes minutes.
MOST_CERTIFIED_STATES = 240

#: Largest product of the number of coordinates and the degree for which a formula is computed.
MOST_FORMULA_STATES = 60


def units(scene: SceneData) -> Decision:
    """pint is loaded for texts with units such as "3 N/mm"."""
    robot = scene.equations.robot_scene
    texts = scene.unit_texts + (robot.data.unit_texts if robot else 0)
    if texts:
        return True, f"{counted(texts, 'quantity', 'quantities')} with a unit"
    return False, "all quantities are numbers in SI without units"


def assembly(scene: SceneData) -> Decision:
    """The equations of every scene."""
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


def normal_form(scene: SceneData) -> Decision:
    """Whether a state space is transformed to a mechanical system."""
    form = scene.equations.control.form
    if form is None:
        return False, "normal_form = false: the states as given"
    return True, f"normal_form = true: {counted(form.size, 'displacement')} and as many velocities"


def robot_model(scene: SceneData) -> Decision:
    """The file of the robot."""
    robot = scene.equations.robot_scene
    return True, f"{robot.data.place}: {counted(len(robot.robot.bodies), 'link')}, {counted(len(robot.robot.joints), 'joint')}"


def equilibrium(scene: SceneData) -> Decision:
    """Equilibrium of the robot."""
    load = _load(scene)
    rows_by_kind = [
        counted(len(rows), one, many)
        for rows, one, many in (
            (load.loops, "closed loop", "closed loops"),
            (load.mimic_rows, "joint that follows another", "joints that follow others"),
        )
        if rows
    ]
    return True, f"the motion is about a state of rest, with {' and '.join(rows_by_kind) or 'no loops to close'}"


def _load(scene: SceneData):
    """Constraints and loads of the robot."""
    return scene.equations.posture.balance.load


def constraint_rows(scene: SceneData) -> Decision:
    """Redundant constraint rows are searched for where there are rows."""
    system = scene.equations.system
    if scene.equations.control is not None:
        return False, f"a {scene.table.model.kind.replace('-', ' ')} has no constraint rows"
    if system is None:
        return False, "A_0, A_1, … are given: constraints are equations among the others"
    if scene.equations.robot:
        removed = len(_load(scene).row_names) - len(system.rows)
    else:
        removed = sum(notice.kind == NoticeKind.REDUNDANT for notice in system.notices)
    if not system.rows and not removed:
        return False, "the robot has no loops: no rows are built" if scene.equations.robot else "no constraint rows"
    return True, f"{counted(len(system.rows) + removed, 'row')}, {removed} of them dependent"


def constrained_form(scene: SceneData) -> Decision:
    """The equations of motion without constraint forces."""
    system = scene.equations.system
    if system is None or not system.rows:
        return False, "no constraint rows"
    levels = sorted({row.level for row in system.rows})
    return True, f"{counted(len(system.rows), 'independent row')} at {' and '.join(levels)} level"


def finite_pair(scene: SceneData) -> Decision:
    """Eigenvalues are always listed; the motion comes from the pair only where the chosen method uses pairs."""
    if scene.method.name == PAIRS:
        return True, "the motion for t > 0, and the eigenvalues"
    return True, "the eigenvalues; the motion comes from the reduced equations"


def infinite_pair(scene: SceneData) -> Decision:
    """Jumps and impulses come from the infinite pair; free admissible motion needs none (Moysis et al., section 4.1)."""
    equations = scene.equations
    A = equations.polynomial_matrix
    if not any(A.jordan_pairs().form.split.infinite_divisors):
        return False, f"A_{A.degree} is nonsingular: there is no infinite part"
    if equations.is_free and equations.start_fits:
        return False, "no force and a start that fits: the infinite part stays zero"
    return True, f"A_{A.degree} is singular and {'the start does not fit' if equations.is_free else 'a force acts'}"


def response(scene: SceneData) -> Decision:
    """The response, and the method that gives its values at the times of the scene."""
    return True, f"from the values at 0-, with jumps and impulses; values {scene.method.reason}"


def modes(scene: SceneData) -> Decision:
    """The mechanical meaning of the eigenvalues, for mechanical systems."""
    if scene.equations.system is None:
        listed = "the zeros of A(s)" if scene.equations.control is None else "the poles"
        return False, f"no mechanical system: {listed} are listed without a meaning"
    return True, "classifies oscillations, rigid-body modes and drift"


def proof(scene: SceneData) -> Decision:
    """Error bounds instead of estimates, for small models with exact data."""
    control, reason = scene.equations.control, unproved(scene.problem)
    if reason and control and control.form and "output" in scene.table.output.plots:
        reason = unproved(control.response.together.problem)  # the outputs are those of the state space itself
    return not reason, reason or "few states: the error is bounded, and values beyond the bound come from the exact engine"


def transfer_functions(scene: SceneData) -> Decision:
    """Transfer functions from each input to each output of a state space."""
    control = scene.equations.control
    if not (control.inputs.names and control.outputs.names):
        return False, "there are no inputs or no outputs"
    if not control.looks_for_zeros:
        return False, "many states or outputs: zeros take long; DC gains are listed"
    return True, "zeros, gain and DC gain from each input to each output"


def plotted(scene: SceneData, kind: str) -> Decision:
    """Curves for display only."""
    requested = kind in scene.table.output.plots
    return requested, f"{kind} is{'' if requested else ' not'} among the plots"


def velocities(scene: SceneData) -> Decision:
    """Velocities, which an animation needs as well as plots."""
    requested, reason = plotted(scene, "velocity")
    if "phase" in scene.table.output.plots and not requested:
        requested, reason = True, "phase is among the plots"
    moves = animation(scene)[0] and not requested
    return (True, "the animation moves by displacements and velocities") if moves else (requested, reason)


def reactions(scene: SceneData) -> Decision:
    """The forces of the constraint rows over time."""
    output, system = scene.table.output, scene.equations.system
    if system is None or not system.rows:
        return False, "no constraint rows"
    requested = output.reactions or "reaction" in output.plots
    if not requested and output.arrows and animation(scene)[0]:
        return True, "arrows in the animation show them"
    return requested, "requested in [output]" if requested else "not requested in [output]"


def connection_forces(scene: SceneData) -> Decision:
    """Forces of loops, springs and bushings of a robot in the directions of the ground."""
    output, equations = scene.table.output, scene.equations
    if not equations.has_connections:
        return False, "no loops, springs or bushings"
    if output.reactions or "ground_reaction" in output.plots:
        return True, "requested in [output]"
    feet = any(getattr(item, "friction", None) is not None for item in (*equations.robot.loops, *equations.robot.springs))
    return feet, "friction and lift-off of feet are checked" if feet else "not requested in [output]"


def outputs(scene: SceneData) -> Decision:
    """Outputs of a robot or a state space."""
    equations = scene.equations
    if equations.outputs is None:
        return False, "there is no C" if equations.control else "no outputs are named"
    if equations.has_outputs_among_coordinates:
        return True, "C x + D u, solved for together with the states"
    requested = "output" in scene.table.output.plots
    source = "C x + D u, of the states that were given" if equations.control else "of the links, from the deviations of the joints"
    return requested, source if requested else "output is not among the plots"


def element_quantities(scene: SceneData) -> Decision:
    """Forces, elongations and relative motions."""
    named = scene.table.output.quantity
    return bool(named), counted(len(named), "entry", "entries") + " of [[output.quantity]]" if named else "no [[output.quantity]]"


def certificate(scene: SceneData) -> Decision:
    """Digits that exact arithmetic proves."""
    certify = scene.table.output.certify
    if not certify:
        return False, "not requested (--certify, or certify = true in [output])"
    if reason := too_large_to_certify(scene.equations):
        return False, reason
    return True, "digits of every coordinate" if certify is True else f"digits of {', '.join(certify)}"


def symbols(scene: SceneData) -> Decision:
    """A formula for the page."""
    output, count = scene.table.output, len(scene.parameters.values)
    if not output.formula:
        return False, "no formula is requested"
    if not output.page:
        return False, "no page to show the formula on"
    if reason := too_large_for_formula(scene):
        return False, reason
    return True, f"formula = true: {counted(count, 'parameter')} as symbols" if count else "formula = true: with exact numbers"


def animation(scene: SceneData) -> Decision:
    """Animated drawing."""
    output, pictured = scene.table.output, still(scene)[0]
    if not (output.page or pictured):
        return False, "no page"
    if not (output.animation or pictured):
        return False, "animation = false"
    if not _has_places(scene):
        return False, "states and outputs have no geometry: add a [drawing]"
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
    """Still picture of the model, for which a browser is needed."""
    time = scene.table.output.still
    if time is None:
        return False, "not requested (--still TIME, or still = TIME in [output])"
    if not _has_places(scene):
        return False, "states and outputs have no geometry: add a [drawing]"
    from ...page.photograph import NONE_INSTALLED, browser

    return (True, f"{scene.name}.still.png, the model at {time:g} s") if browser() else (False, NONE_INSTALLED)


def formats(scene: SceneData) -> Decision:
    """Files for other programs."""
    requested = scene.table.output.formats
    return bool(requested), ", ".join(requested) if requested else 'not requested (formats in [output], e.g. ["mat", "uff"])'


def plot_images(scene: SceneData) -> Decision:
    """The plots as files."""
    requested = scene.table.output.plot_images
    return requested, f"{scene.name}.*.svg and .png" if requested else "not requested (--plots, or plot_images = true in [output])"


def robot_meshes(scene: SceneData) -> Decision:
    """Visual meshes of the robot."""
    meshes = scene.equations.robot_scene.data.names.meshes
    if not meshes:
        return False, "the robot is drawn from boxes, cylinders and spheres"
    drawn = animation(scene)[0]
    return drawn, f"{counted(len(meshes), 'mesh', 'meshes')} to draw" if drawn else "meshes are read only where they are drawn"


def collision_geometry(scene: SceneData) -> Decision:
    """Collision geometry of the links, for the page."""
    drawn = animation(scene)[0]
    return drawn, "the page shows it on request" if drawn else "it is read only where the robot is drawn"


def frequency(scene: SceneData) -> Decision:
    """The frequency response."""
    table = scene.table.frequency
    if table is None:
        return False, "not requested (a table [frequency], or the command frequency)"
    return True, f"[frequency]: {table.quantity}"


def frequency_files(scene: SceneData) -> Decision:
    """Page, CSV and npz of the frequency response."""
    output, requested = scene.table.output, scene.table.frequency is not None
    kinds = [ending for ending, wanted in (("html", output.page), ("csv", output.csv), ("npz", output.npz)) if wanted]
    if not (requested and kinds):
        return False, "page, csv and npz = false" if requested else "no frequency response"
    return True, f"{scene.name}.frequency.{', .'.join(kinds)}"


def written(scene: SceneData, kind: str) -> Decision:
    """A file."""
    requested = getattr(scene.table.output, kind)
    return requested, f"{scene.name}.{'html' if kind == 'page' else kind}" if requested else f"{kind} = false"


def too_large_to_certify(equations: Equations) -> str:
    """The reason why equations are not certified; empty where they are."""
    rows, A = len(equations.system.rows) if equations.system else 0, equations.polynomial_matrix
    states = (A.size + rows) * max(A.degree, 1)
    if states <= MOST_CERTIFIED_STATES:
        return ""
    return f"exact arithmetic with {states} states takes too long, {MOST_CERTIFIED_STATES} is the most"


def too_large_for_formula(scene: SceneData) -> str:
    """The reason why no formula is computed; empty where one is."""
    A = scene.equations.polynomial_matrix
    if scene.equations.robot is not None or A.size * A.degree <= MOST_FORMULA_STATES:
        return ""
    most = f"at most {MOST_FORMULA_STATES} for both multiplied"
    return f"{A.size} coordinates with equations of degree {A.degree} are too many for formulas ({most})"
