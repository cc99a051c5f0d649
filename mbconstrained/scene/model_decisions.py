"""Which stages the model of a scene needs, and why: from its units to the modes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..checks import counted

if TYPE_CHECKING:
    from .scene import Scene

Decision = tuple[bool, str]


def units(scene: Scene) -> Decision:
    """pint, which knows units, is loaded for texts such as "3 N/mm"."""
    found = scene.equations.robot_scene
    texts = scene.unit_texts + (found.data.unit_texts if found else 0)
    if texts:
        return True, f"{counted(texts, 'quantity', 'quantities')} with a unit"
    return False, "all quantities are plain numbers in SI"


def assembly(scene: Scene) -> Decision:
    """The equations, which every scene has."""
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


def normal_form(scene: Scene) -> Decision:
    """Of a state space: whether it is turned into a mechanical system."""
    form = scene.equations.control.form
    if form is None:
        return False, "normal_form = false: the states are taken as they are"
    return True, f"normal_form = true: {counted(form.size, 'displacement')} and as many velocities"


def robot_model(scene: Scene) -> Decision:
    """The robot's file."""
    found = scene.equations.robot_scene
    return True, f"{found.data.place}: {counted(len(found.robot.bodies), 'link')}, {counted(len(found.robot.joints), 'joint')}"


def equilibrium(scene: Scene) -> Decision:
    """Where the robot is at rest."""
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


def _load(scene: Scene):
    """What holds and loads the robot."""
    return scene.equations.posture.balance.load


def constraint_rows(scene: Scene) -> Decision:
    """Rows that say nothing new are looked for where there are rows."""
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


def constrained_form(scene: Scene) -> Decision:
    """The equations of motion freed of the constraint forces."""
    system = scene.equations.system
    if system is None or not system.rows:
        return False, "no constraint rows"
    levels = sorted({row.level for row in system.rows})
    return True, f"{counted(len(system.rows), 'independent row')} at {' and '.join(levels)} level"


def infinite_pair(scene: Scene) -> Decision:
    """Jumps and impulses come from it; free and admissible motion does without (Moysis et al., section 4.1)."""
    equations = scene.equations
    A = equations.polynomial_matrix
    if not any(A.jordan_pairs().form.split.infinite_divisors):
        return False, f"A_{A.degree} is nonsingular: there is no infinite part"
    if equations.is_free and equations.start_fits:
        return False, "no force and a start that fits: the infinite part stays zero"
    return True, f"A_{A.degree} is singular and {'the start does not fit' if equations.is_free else 'a force acts'}"


def response(scene: Scene) -> Decision:
    """The answer, and in which way its values are found."""
    from ..response.reduced import way_to_evaluate

    equations = scene.equations
    way = way_to_evaluate(equations.polynomial_matrix, equations.initial, equations.right_hand_side, scene.times)
    return True, f"from the values at 0-, with jumps and impulses; values {way.reason}"


def modes(scene: Scene) -> Decision:
    """What the zeros mean is known of a mechanical system."""
    if scene.equations.system is None:
        listed = "the zeros of A(s)" if scene.equations.control is None else "the poles"
        return False, f"no mechanical system: {listed} are listed as they are"
    return True, "tells oscillations, rigid bodies and drift apart"


def transfer_functions(scene: Scene) -> Decision:
    """From each input to each output of a state space."""
    control = scene.equations.control
    if not (control.inputs.names and control.outputs.names):
        return False, "there are no inputs or no outputs"
    if not control.looks_for_zeros:
        return False, "many states or outputs: zeros take long; DC gains are told"
    return True, "zeros, gain and DC gain from each input to each output"
