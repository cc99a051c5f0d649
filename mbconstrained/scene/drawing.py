"""The drawing of a scene: its own, or one made from its elements or coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..page.content import Animation
from ..page.drawing import Body, Drawing, Link
from .problems import at

if TYPE_CHECKING:
    from .result import Result


def animation_of(result: Result) -> Animation:
    """The drawing with the motion of the coordinates."""
    if result.scene.equations.robot_scene is not None:
        from .robot_drawing import robot_animation

        return robot_animation(result)
    coordinates = result.scene.equations.coordinates
    return Animation(_drawing(result), coordinates.names, result.times, result.values, result.curves("velocity").values)


def _drawing(result: Result) -> Drawing:
    from ..page.layout import coordinate_drawing, lumped_drawing

    table, equations = result.scene.table.drawing, result.scene.equations
    if table is not None:
        return drawing_of(table, result.scene.path.name)
    if equations.model is not None:
        return lumped_drawing(equations.model.elements, equations.coordinates.names, result.values)
    return coordinate_drawing(equations.coordinates.names, result.values, equations.coordinates.units)


def drawing_of(table, file_name: str) -> Drawing:
    """The [drawing] table as a drawing.

    Raises:
        SceneError: two bodies of one name, a link to an unknown body.
    """
    with at(file_name, "drawing"):
        bodies = [Body(**_given(body)) for body in table.body]
        links = [Link(**{"name": f"{link.kind} from {link.start} to {link.end}", **_given(link)}) for link in table.link]
        return Drawing(tuple(bodies), tuple(links), table.scale, table.turn_scale, table.note)


def _given(entry) -> dict:
    """The keys of a table that the drawing's own defaults shall not fill."""
    return {key: value for key, value in entry if value is not None}
