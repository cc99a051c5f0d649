"""The drawing of a scene, given or automatic with the changes in [drawing], and its validation."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ....ground.checks import nearest
from ....ground.errors import InputError
from ....page.drawing.bodies import Drawing, DrawnBody, DrawnLink, Vector, View
from ....page.drawing.layout import ALONG, turn_to
from ....page.drawing.paths import matrix_of
from ...file.messages import at
from ..scene_data import SceneData

if TYPE_CHECKING:
    from ...schema.drawing_tables import BodyTable, DrawingTable

#: A chain longer than this, in drawing units, is not drawn standing.
TALLEST = 8.0


def drawing_of(scene: SceneData, values=None, **scales: float) -> Drawing:
    """The drawing of a scene whose coordinates are positions, given or automatic."""
    model = scene.equations.model
    return own_drawing(scene) or automatic_drawing(scene, model and model.elements, values, **scales)


def own_drawing(scene: SceneData) -> Drawing | None:
    """The drawing of a scene with a complete [drawing]."""
    table = scene.table.drawing
    if table is None or not table.is_own:
        return None
    bodies = []
    for number, row in enumerate(table.body, 1):
        with at(scene.file_name, _body_place(number, row)):
            bodies.append(_body(row))
    links = _links(scene, [body.name for body in bodies])
    return Drawing(bodies, links, table.scale, table.turn_scale, table.note, view_of(table))


def automatic_drawing(scene: SceneData, elements, values, **scales: float) -> Drawing:
    """The drawing of the elements of a model, or of the coordinates, with the changes in [drawing]."""
    from ....page.drawing.automatic_drawing import coordinate_drawing, lumped_drawing

    names, units = scene.equations.coordinates.names, scene.equations.coordinates.units
    table = scene.table.drawing
    if elements is not None:
        laid_out = partial(lumped_drawing, elements, names, values, **scales, stack=table and table.stack)
    else:
        laid_out = partial(coordinate_drawing, names, values, units, **scales, stack=table and table.stack)
    drawing = laid_out()
    if table is None:
        return replace(drawing, turn=_upright(scene, drawing))
    turn = turn_to(table.along, table.about, _own_direction(drawing)) if table.along or table.about else _upright(scene, drawing)
    if directions := _directions(scene, drawing, turn):
        drawing = laid_out(directions=directions)
    return _changed(scene, replace(drawing, turn=turn))


def _own_direction(drawing: Drawing) -> np.ndarray:
    """The common direction of displacement of all bodies of a drawing; the default where there are several."""
    moves = [np.array(move) / np.linalg.norm(move) for body in drawing.bodies for move in body.moves.values() if any(move)]
    alike = bool(moves) and np.allclose(moves, moves[0])
    return moves[0] if alike else ALONG


def _upright(scene: SceneData, drawing: Drawing) -> Vector:
    """Direction of a drawing: models under gravity stand upright, unless too tall, or on pulleys already."""
    model = scene.table.model
    stands = any(body.shape == "base" or any(move[2] for move in body.moves.values()) for body in drawing.bodies)
    falls = model.kind == "lumped" and model.gravity and not (model.pulley or stands)
    length = np.ptp([body.rest[0] for body in drawing.bodies]) if drawing.bodies else 0.0
    return turn_to((0.0, 0.0, -np.sign(model.gravity)), None) if falls and length <= TALLEST else (0.0, 0.0, 0.0)


def _body_place(number: int, row: BodyTable) -> str:
    """Location of a body in the file, for messages."""
    return f'drawing.body[{number}] (of "{row.name}")'


def _link_place(number: int) -> str:
    """Location of a link in the file, for messages."""
    return f"drawing.link[{number}]"


def _directions(scene: SceneData, drawing: Drawing, turn: Vector) -> dict[str, Vector]:
    """Directions of motion of bodies that state one, by name, in the axes of a drawing before it is turned."""
    bodies = {body.name: body for body in drawing.bodies}
    directions = {}
    for number, row in enumerate(scene.table.drawing.body, 1):
        if row.along or row.about:
            with at(scene.file_name, _body_place(number, row)):
                _check_direction(row, bodies)
            directions[row.name] = tuple((matrix_of(turn).T @ (row.along or row.about)).tolist())
    return directions


def _check_direction(row: BodyTable, bodies: dict[str, DrawnBody]) -> None:
    """Check the direction of motion of a body that is drawn automatically."""
    body, key = bodies.get(row.name), "along" if row.along else "about"
    if body is not None:
        own = {"along": body.moves, "about": body.turns}
        if row.name not in own[key]:
            other, moves = ("about", "turns") if key == "along" else ("along", "is displaced")
            does = f"it {moves}: say {other}" if row.name in own[other] else "it stays where it is"
            raise InputError(f"it has {key}, but {does}")
    elif row.shape is not None:
        raise InputError(f"{key} is for bodies of the automatic drawing; moves and turns state the motion of this one")


def _changed(scene: SceneData, drawing: Drawing) -> Drawing:
    table, bodies = scene.table.drawing, {body.name: body for body in drawing.bodies}
    for number, row in enumerate(table.body, 1):
        with at(scene.file_name, _body_place(number, row)):
            bodies[row.name] = _changed_body(row, bodies)
    note = " ".join(filter(None, (drawing.note, table.note)))
    links = (*drawing.links, *_links(scene, bodies))
    return replace(drawing, bodies=tuple(bodies.values()), links=links, note=note, view=view_of(table))


def _changed_body(row: BodyTable, bodies: dict[str, DrawnBody]) -> DrawnBody:
    if row.name in bodies:
        return replace(bodies[row.name], **_given(row))
    if row.shape is not None:
        return _body(row)
    hint = nearest(row.name, bodies)
    raise InputError(f"there is no such body in the automatic drawing{hint}; give it a shape to draw a new one")


def _body(row: BodyTable) -> DrawnBody:
    if row.shape is None:
        raise InputError("it has no shape; give it one, or automatic = true where it is drawn anyway")
    return DrawnBody(**_given(row))


def _links(scene: SceneData, bodies: Collection[str]) -> tuple[DrawnLink, ...]:
    """The links of the scene, between bodies of these names."""
    links = []
    for number, link in enumerate(scene.table.drawing.link, 1):
        with at(scene.file_name, _link_place(number)):
            for name in filter(None, (link.start, link.end, link.over)):
                if name not in bodies:
                    raise InputError(f'there is no body "{name}" in the drawing{nearest(name, bodies)}')
            links.append(DrawnLink(**{"name": f"{link.kind} from {link.start} to {link.end}", **_given(link)}))
    return tuple(links)


def view_of(table: DrawingTable | None) -> View | None:
    """The view that the scene requests; None without one."""
    return None if table is None or table.view is None else View(table.view.yaw, table.view.pitch, table.view.zoom)


def _given(entry) -> dict:
    """The keys of a table that defaults of the drawing must not fill; the direction is already part of the motion."""
    return {key: value for key, value in entry if value is not None and key not in ("along", "about")}


def check_drawing(scene: SceneData) -> None:
    """Check that [drawing] can be drawn."""
    if scene.equations.robot:
        with at(scene.file_name, "drawing"):
            return _check_robot(scene.table.drawing)
    _check_names(scene)
    if scene.table.drawing.is_own or not scene.equations.has_outputs_among_coordinates:  # which are no places
        drawing_of(scene)


def _check_robot(drawing) -> None:
    if drawing.body or drawing.link:
        raise InputError("a robot is drawn from its URDF: leave out body and link; scale, view and note may stand here")
    if drawing.stack:
        raise InputError("a robot is drawn from its URDF: leave out stack")
    if drawing.along or drawing.about:
        raise InputError("a robot is drawn in the axes of its URDF: leave out along and about; use view to set the camera")


def _check_names(scene: SceneData) -> None:
    drawing = scene.table.drawing
    bodies = [body.name for body in drawing.body]
    for number, body in enumerate(drawing.body, 1):
        with at(scene.file_name, _body_place(number, body)):
            if bodies.count(body.name) > 1:
                raise InputError("this name is used twice; names must differ")
            for name in (*(body.moves or ()), *(body.turns or ())):
                scene.equations.coordinates.number(name)
    for number, link in enumerate(drawing.link, 1):
        with at(scene.file_name, _link_place(number)):
            if link.start == link.end:
                raise InputError(f'start and end are the same body, "{link.start}"; name two bodies')
