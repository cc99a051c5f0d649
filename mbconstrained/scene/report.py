"""From a result to what its page shows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..page.content import Formulas, PageContent, Table
from .control_report import control_facts
from .output_decisions import is_animated
from .plan_tables import page_table
from .plots import plots_of
from .robot_report import robot_facts
from .stages import PAGE, plan_of
from .tables import notices_of, tables_of

if TYPE_CHECKING:
    from .result import Result


def page_content(result: Result) -> PageContent:
    """Animation, plots, tables, notices and facts of a result."""
    scene = result.scene
    return PageContent(
        title=scene.title,
        source=scene.table.source,
        animation=result.animation if is_animated(scene) else None,
        plots=plots_of(result),
        tables=(*(table.on_page() for table in tables_of(result)), _plan(result)),
        notices=notices_of(result),
        formulas=formulas_of(result),
        facts=_facts(result),
    )


def formulas_of(result: Result) -> Formulas | None:
    """What the page shows of the formula, if it was asked for and found."""
    if not result.scene.table.output.formula or result.formula is None:
        return None
    from ..exact.formulas import mathml
    from .formula import DIGITS, is_short, parameters_text

    form = result.formula
    digits = None if form.parameters or is_short(form) else DIGITS
    notes = [parameters_text(form), "" if digits is None else f"Numbers to {digits} digits.", form.step_note]
    return Formulas("Formula", mathml(form, digits=digits), " ".join(filter(None, notes)))


def _plan(result: Result) -> Table:
    """The plan of a page that is written; one that is asked for afterwards belongs to a plan that wrote nothing."""
    plan = result.plan if result.folder else plan_of(result.scene).with_costs(result.plan.costs)
    return page_table(plan, PAGE).on_page(folded=True)


def _facts(result: Result) -> tuple[tuple[str, str], ...]:
    scene = result.scene
    coordinates, time = scene.equations.coordinates, scene.table.time
    return (
        *robot_facts(scene.equations.robot_scene),
        *control_facts(scene.equations.control),
        (scene.equations.coordinates_called, coordinates.listed),
        ("degree of the equations", str(scene.equations.polynomial_matrix.degree)),
        ("finite zeros", str(sum(zero.count for zero in result.finite_pair.zeros))),
        ("time", f"0 to {time.end:g} s, {time.points} points, in closed form"),
    )
