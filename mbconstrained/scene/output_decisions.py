"""Which stages the [output] of a scene asks for, and why: curves, proofs, formulas, and what is written."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ..checks import counted
from .model_decisions import Decision

if TYPE_CHECKING:
    from .scene import Scene

Decide = Callable[["Scene"], Decision]


def always(reason: str) -> Decide:
    """A stage that no scene can do without."""
    return lambda scene: (True, reason)


def never(reason: str) -> Decide:
    """A stage that other programs have."""
    return lambda scene: (False, reason)


def plotted(kind: str) -> Decide:
    """Curves that are only there to be shown."""

    def decide(scene: Scene) -> Decision:
        asked = kind in scene.table.output.plots
        return asked, f"{kind} is{'' if asked else ' not'} among the plots"

    return decide


def velocities(scene: Scene) -> Decision:
    """Besides plots, an animation needs them."""
    asked, reason = plotted("velocity")(scene)
    if "phase" in scene.table.output.plots and not asked:
        asked, reason = True, "phase is among the plots"
    moves = animation(scene)[0] and not asked
    return (True, "the animation moves by displacements and velocities") if moves else (asked, reason)


def reactions(scene: Scene) -> Decision:
    """The forces of the constraint rows over time."""
    output, system = scene.table.output, scene.equations.system
    if system is None or not system.rows:
        return False, "no constraint rows"
    asked = output.reactions or "reaction" in output.plots
    if not asked and output.arrows and animation(scene)[0]:
        return True, "arrows in the animation show them"
    return asked, "asked for in [output]" if asked else "not asked for in [output]"


def outputs(scene: Scene) -> Decision:
    """Of a robot or a state space."""
    equations = scene.equations
    if equations.outputs is None:
        return False, "there is no C" if equations.control else "no outputs are named"
    if equations.has_outputs_among_coordinates:
        return True, "C x + D u, solved for together with the states"
    asked = "output" in scene.table.output.plots
    found = "C x + D u, of the states that were given" if equations.control else "of the links, from the deviations of the joints"
    return asked, found if asked else "output is not among the plots"


def certificate(scene: Scene) -> Decision:
    """Digits that exact arithmetic proves."""
    certify = scene.table.output.certify
    if not certify:
        return False, "not asked for (--certify, or certify = true in [output])"
    from .certificate import too_large

    if reason := too_large(scene.equations):
        return False, reason
    return True, "digits of every coordinate" if certify is True else f"digits of {', '.join(certify)}"


def symbols(scene: Scene) -> Decision:
    """A formula for the page."""
    output, count = scene.table.output, len(scene.parameters.values)
    if not output.formula:
        return False, "nothing symbolic is asked for"
    if not output.page:
        return False, "no page to show the formula on"
    from .formula import too_large

    if reason := too_large(scene):
        return False, reason
    return True, f"formula = true: {counted(count, 'parameter')} as symbols" if count else "formula = true: with exact numbers"


def animation(scene: Scene) -> Decision:
    """The drawing that moves."""
    output, pictured = scene.table.output, still(scene)[0]
    if not (output.page or pictured):
        return False, "no page"
    if not (output.animation or pictured):
        return False, "animation = false"
    if not _has_places(scene):
        return False, "states and outputs are no places: a [drawing] would say how they move"
    if not (output.page and output.animation):
        return True, "the still picture shows the model where it is then"
    return True, "the model moves on the page, by displacements and velocities"


def is_animated(scene: Scene) -> bool:
    """Whether a page shows the model moving."""
    output = scene.table.output
    return output.page and output.animation and _has_places(scene)


def _has_places(scene: Scene) -> bool:
    drawing = scene.table.drawing
    return not scene.equations.has_outputs_among_coordinates or (drawing is not None and drawing.is_own)


def still(scene: Scene) -> Decision:
    """A picture of the model, for which a browser is needed."""
    time = scene.table.output.still
    if time is None:
        return False, "not asked for (--still TIME, or still = TIME in [output])"
    if not _has_places(scene):
        return False, "states and outputs are no places: a [drawing] would say where they are"
    from ..page.photograph import NONE_INSTALLED, browser

    return (True, f"{scene.name}.still.png, the model at {time:g} s") if browser() else (False, NONE_INSTALLED)


def plot_images(scene: Scene) -> Decision:
    """The plots as files."""
    asked = scene.table.output.plot_images
    return asked, f"{scene.name}.*.svg and .png" if asked else "not asked for (--plots, or plot_images = true in [output])"


def robot_meshes(scene: Scene) -> Decision:
    """Files of the robot's looks."""
    meshes = scene.equations.robot_scene.data.names.meshes
    if not meshes:
        return False, "the robot is drawn from boxes, cylinders and spheres"
    drawn = animation(scene)[0]
    return drawn, f"{counted(len(meshes), 'mesh', 'meshes')} to draw" if drawn else "meshes are read only where they are drawn"


def wanted(kind: str) -> Decide:
    """A file."""

    def decide(scene: Scene) -> Decision:
        asked = getattr(scene.table.output, kind)
        return asked, f"{scene.name}.{'html' if kind == 'page' else kind}" if asked else f"{kind} = false"

    return decide
