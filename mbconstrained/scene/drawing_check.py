"""What is wrong with the drawing of a scene is found when the scene is read, although it is drawn only when a page is made."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import InputError
from .drawing import body_place, drawing_of, link_place
from .problems import at

if TYPE_CHECKING:
    from .scene import Scene


def check_drawing(scene: Scene) -> None:
    """See whether [drawing] can be drawn.

    Raises:
        SceneError: unknown bodies or coordinates, a name used twice, a direction of a body that does not move so.
    """
    if scene.equations.robot:
        with at(scene.file_name, "drawing"):
            return _check_robot(scene.table.drawing)
    _check_names(scene)
    if scene.table.drawing.is_own or not scene.equations.has_outputs_among_coordinates:  # which are no places
        drawing_of(scene)


def _check_robot(drawing) -> None:
    if drawing.body or drawing.link:
        raise InputError("a robot is drawn from its URDF: leave out body and link; scale, view and note may stand here")
    if drawing.along or drawing.about:
        raise InputError("a robot stands as its URDF says: leave out along and about; view says from where it is looked at")


def _check_names(scene: Scene) -> None:
    drawing = scene.table.drawing
    bodies = [body.name for body in drawing.body]
    for number, body in enumerate(drawing.body, 1):
        with at(scene.file_name, body_place(number, body)):
            if bodies.count(body.name) > 1:
                raise InputError("this name is used twice; names must differ")
            for name in (*(body.moves or ()), *(body.turns or ())):
                scene.equations.coordinates.number(name)
    for number, link in enumerate(drawing.link, 1):
        with at(scene.file_name, link_place(number)):
            if link.start == link.end:
                raise InputError(f'start and end are the same body, "{link.start}"; name two bodies')
