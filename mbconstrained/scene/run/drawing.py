"""The drawing of a scene, given or automatic with the changes in [drawing]; of a robot; and of shapes that swing."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ...ground.checks import counted, nearest
from ...ground.errors import InputError
from ...ground.tolerances import NOT_DRAWN, noise_of
from ...page.animation import cycle
from ...page.drawing import Drawing, DrawnBody, DrawnLink, Path, SliderPosing, Solid, Vector, View, matrix_of
from ...page.layout import ABSOLUTE, ALONG, NEIGHBOURS, WIDEST_ANGLE, turn_to, two_digits
from ..file import at
from .scene_data import SceneData

if TYPE_CHECKING:
    from ...models.elements import Element
    from ...page.animation import DrawnEvent
    from ...robot.visualization import Poses, Visual
    from ..build.robot_model import RobotScene
    from ..schema.scene_schema import BodyTable, DrawingTable

#: A chain longer than this, in drawing units, is not drawn standing.
TALLEST = 8.0


def drawing_of(scene: SceneData, values=None, **scales: float) -> Drawing:
    """The drawing of a scene whose coordinates are positions, given or automatic."""
    model, speed = scene.equations.model, getattr(scene.table.model, "speed", None)
    drawing = own_drawing(scene) or automatic_drawing(scene, model and model.elements, values, **scales)
    if speed:
        return replace(drawing, revolution=2 * np.pi / abs(speed))
    if not any(body.traced for body in drawing.bodies):
        return drawing
    return replace(drawing, bodies=tuple(replace(body, traced=()) for body in drawing.bodies))


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
    from ...page.automatic_drawing import coordinate_drawing, lumped_drawing

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
    model = scene.equations.model
    gravity = 0.0 if model is None else model.gravity_along
    hangs = gravity and any(element.kind == "pulley" for element in model.elements)
    stands = any(body.shape == "base" or any(move[2] for move in body.moves.values()) for body in drawing.bodies)
    length = np.ptp([body.rest[0] for body in drawing.bodies]) if drawing.bodies else 0.0
    return (
        turn_to((0.0, 0.0, -np.sign(gravity)), None) if gravity and not (hangs or stands) and length <= TALLEST else (0.0, 0.0, 0.0)
    )


def _body_place(number: int, row: BodyTable) -> str:
    return f'drawing.body[{number}] (of "{row.name}")'


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
    links = []
    for number, link in enumerate(scene.table.drawing.link, 1):
        with at(scene.file_name, f"drawing.link[{number}]"):
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
    """Check the names in the table [drawing], and that it can be drawn; otherwise a SceneError."""
    if scene.equations.robot:
        with at(scene.file_name, "drawing"):
            return _check_robot(scene.table.drawing)
    drawing = scene.table.drawing
    if not (drawing.body or drawing.link):
        return None
    bodies = [body.name for body in drawing.body]
    for number, body in enumerate(drawing.body, 1):
        with at(scene.file_name, _body_place(number, body)):
            if bodies.count(body.name) > 1:
                raise InputError("this name is used twice; names must differ")
            for name in (*(body.moves or ()), *(body.turns or ())):
                scene.equations.coordinates.number(name)
    for number, link in enumerate(drawing.link, 1):
        with at(scene.file_name, f"drawing.link[{number}]"):
            if link.start == link.end:
                raise InputError(f'start and end are the same body, "{link.start}"; name two bodies')
    if drawing.is_own:
        own_drawing(scene)
    elif not scene.equations.has_outputs_among_coordinates:  # which are no places
        drawing_of(scene)


def _check_robot(drawing) -> None:
    if drawing.body or drawing.link:
        raise InputError("a robot is drawn from its URDF: leave out body and link; scale, view and note may stand here")
    if drawing.stack:
        raise InputError("a robot is drawn from its URDF: leave out stack")
    if drawing.along or drawing.about:
        raise InputError("a robot is drawn in the axes of its URDF: leave out along and about; use view to set the camera")


#: Shares of the robot's size: thickness of plates, least width of the base plate, width of the plates under fixed points, height of a
#: mount on the ground, and radius of the ball for a link without a shape.
_PLATE, _WIDTH, _PAD, _MOUNT, _BALL = 0.012, 0.15, 0.06, 0.08, 0.014

#: Width relative to the root of a base plate under it, and of one over it, which must not hide it.
_MARGIN, _COVER = 1.2, 0.6

#: Triangles of a mesh; one with more is drawn with fewer unless all are asked for.
MOST_TRIANGLES = 20_000

#: Cells along the longest side of a mesh that is simplified, at most, and by what their number shrinks until few triangles are left.
_CELLS, _FEWER = 256, 0.8

#: Names of further bodies begin with a blank, which no link's name does.
BASE_PLATE, PAD = " base plate", " plate"


def robot_drawing(
    solids: Mapping[str, Sequence[Solid]],
    poses: Mapping[str, Any],
    connections: Iterable[Any] = (),
    *,
    scale=1.0,
    fixed=True,
    note="",
    ellipsoids: Mapping[str, np.ndarray] | None = None,
    collision: Mapping[str, Sequence[Solid]] | None = None,
) -> Drawing:
    """Every link of a robot as a body with a path."""
    placements = {name: tuple(matrix.T.ravel().tolist()) for name, matrix in (ellipsoids or {}).items()}
    connections = tuple(connections)
    paths = {name: Path(pose.positions, pose.quaternions) for name, pose in poses.items()}
    points = link_points(solids, paths)
    size = robot_size(points)
    shapeless = not any(solids.values())  # then, and for a connection at a link without a shape, a ball
    ball = Solid("sphere", (_BALL * size,))
    connected = {end for row in connections for end in (row.body1, row.body2)}
    bodies = []
    for name, path in paths.items():
        own = solids.get(name) or [ball] * (shapeless or name in connected)
        further = {"collision": tuple((collision or {}).get(name, ())), "ellipsoid": placements.get(name)}
        bodies.append(DrawnBody(name, "solids", solids=tuple(own), path=path, label=None if own else "", **further))
    bodies += [_plate(points, paths, size)] if fixed else []
    ends = [_ends(row, points, _MOUNT * size) for row in connections]
    bodies += _pads(connections, ends, size)
    if "ground" not in paths:
        bodies.append(DrawnBody("ground", "solids", label=""))
    return Drawing(tuple(bodies), tuple(_connection_links(connections, ends)), scale, note=note)


def simplified(vertices: np.ndarray, faces: np.ndarray, most: int = MOST_TRIANGLES) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A mesh of few triangles: the vertices in each cell of a grid become one at their mean (Rossignac and Borrel 1993)."""
    low, side, cells = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max()) or 1.0, _CELLS
    while True:
        i, j, k = np.round((vertices - low) * (cells / side)).astype(int).T
        _, number, count = np.unique((i * (cells + 1) + j) * (cells + 1) + k, return_inverse=True, return_counts=True)
        a, b, c = number[faces].T
        kept = (a != b) & (b != c) & (c != a)
        if np.count_nonzero(kept) <= most:
            return np.stack([np.bincount(number, column) / count for column in vertices.T], axis=1), number[faces][kept], kept
        cells = int(_FEWER * cells)


def solids_of(visuals: Iterable[Any], *, full: bool = True) -> dict[str, list[Solid]]:
    solids: dict[str, list[Solid]] = {}
    shared: dict[int, Solid] = {}  # by the identity of the faces, which links may share
    for visual in visuals:
        color, opacity = None, 1.0
        if visual.color is not None:
            *parts, opacity = visual.color
            color = "#" + "".join(f"{round(255 * part):02x}" for part in parts)
        own = {"placement": visual.placement, "color": color, "opacity": opacity}
        if visual.faces is None:
            solid = Solid(visual.kind, visual.size, **own)
        elif id(visual.faces) in shared:
            solid = replace(shared[id(visual.faces)], **own)
        else:
            solid = shared[id(visual.faces)] = Solid(visual.kind, **own, **_mesh_of(visual, full))
        solids.setdefault(visual.link, []).append(solid)
    return solids


def _mesh_of(visual: Any, full: bool) -> dict[str, Any]:
    """Vertices, faces and texture of a mesh or of a part of one, which has its share of the triangles that the mesh may have."""
    vertices, faces = visual.vertices, visual.faces
    image, places = (None, None) if visual.texture is None else (visual.texture.image, visual.texture.places)
    if not full and visual.triangles > MOST_TRIANGLES:
        vertices, faces, kept = simplified(vertices, faces, MOST_TRIANGLES * len(faces) // visual.triangles)
        places = None if places is None else places[kept]
    return {"vertices": vertices, "faces": faces, "image": image, "places": places}


def _plate(points: Mapping[str, np.ndarray], paths: Mapping[str, Path], size: float) -> DrawnBody:
    """A plate under the first link, which is the root, or over it where the other links hang from it."""
    names = list(points)
    rests = bool(names) and not paths[names[0]].moves
    root = points[names[0]][:, :, 0] if rests else np.zeros((3, 1))
    low, high = root.min(axis=1), root.max(axis=1)
    heights = np.concatenate([block[2, :, 0] for block in points.values()] or [root[2]])
    hangs = low[2] - heights.min() > max(heights.max() - high[2], _WIDTH * size)
    width, depth = np.maximum((_COVER if hangs else _MARGIN) * (high - low)[:2], _WIDTH * size)
    thickness = _PLATE * size
    level = high[2] + thickness / 2 if hangs else low[2] - thickness / 2
    middle = (low + high) / 2
    return DrawnBody(BASE_PLATE, "base", (middle[0], middle[1], level), size=(width, depth, thickness))


_Point = tuple[float, ...]


def _ends(row: Any, points: Mapping[str, np.ndarray], height: float) -> tuple[_Point, _Point]:
    """The points that a connection is drawn between: those of a mount on the ground coincide, and its foot is moved out of the body."""
    ends, bodies = [list(map(float, point)) for point in (row.point1, row.point2)], (row.body1, row.body2)
    if row.kind == "bushing" and bodies.count("ground") == 1:
        foot, body = bodies.index("ground"), points.get(bodies[1 - bodies.index("ground")])
        is_above = body is None or body[2, :, 0].mean() >= ends[foot][2]
        ends[foot][2] -= height if is_above else -height
    return tuple(ends[0]), tuple(ends[1])


def _pads(connections: tuple[Any, ...], ends: Sequence[tuple[_Point, _Point]], size: float) -> list[DrawnBody]:
    """A small plate under each point that is fixed to the ground."""
    attached = [(name, point) for row, two in zip(connections, ends) for name, point in zip((row.body1, row.body2), two)]
    points = dict.fromkeys(point for name, point in attached if name == "ground")
    width, thickness = _PAD * size, _PLATE * size
    places = [(x, y, z - thickness / 2) for x, y, z in points]
    return [DrawnBody(f"{PAD} {i}", "base", place, size=(width, width, thickness)) for i, place in enumerate(places, start=1)]


def _connection_links(connections: tuple[Any, ...], ends: Sequence[tuple[_Point, _Point]]) -> Iterable[DrawnLink]:
    between: dict[tuple, list[Any]] = {}
    for row, points in zip(connections, ends):
        kind = "strut" if row.kind in ("spring", "damper") else row.kind
        between.setdefault((kind, row.body1, row.body2, *points), []).append(row)
    for (_, start, end, start_point, end_point), rows in between.items():
        kinds = {row.kind for row in rows}
        kind = "strut" if kinds == {"spring", "damper"} else rows[0].kind
        yield DrawnLink(rows[0].name, kind, start, end, start_point=start_point, end_point=end_point)


def link_points(solids: Mapping[str, Sequence[Solid]], poses: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The origin of each link, then the corners of its solids."""
    points = {}
    for name, pose in poses.items():
        corners = np.hstack([np.zeros((3, 1)), *(solid.corners for solid in solids.get(name, ()))])
        points[name] = Path(pose.positions, pose.quaternions).of_points(corners)
    return points


def robot_size(points: Mapping[str, np.ndarray]) -> float:
    """Diagonal of a box around all points at the first time; 1 for a single point.

    >>> robot_size({"arm": np.array([[0.0, 3.0], [0.0, 0.0], [0.0, 4.0]])[:, :, None]})
    5.0
    """
    first = np.hstack([block[:, :, 0] for block in points.values()] or [np.zeros((3, 1))])
    return float(np.linalg.norm(np.ptp(first, axis=1))) or 1.0


NOTE = "small motions about the equilibrium"


def event_with_poses(event: DrawnEvent, picture: RobotPicture, scale: float) -> DrawnEvent:
    """The event with the poses of the links just before and just after it, where they differ."""
    values = np.column_stack([event.before, event.after])
    if np.ptp(values, axis=1).max(initial=0.0) <= NOT_DRAWN * np.abs(values).max(initial=0.0):
        return event
    poses = picture.poses(values, scale)
    return replace(event, paths={name: Path(pose.positions, pose.quaternions) for name, pose in poses.items()})


def drawing_of_robot(picture: RobotPicture, values: np.ndarray, table=None) -> Drawing:
    if table and "scale" in table.model_fields_set:
        scale = table.scale
    else:  # at least 1, so that the point of largest displacement visibly moves
        scale = max(1.0, picture.room(values[:, np.unique(np.abs(values).argmax(axis=1))]))
    drawing = picture.drawing(picture.poses(values, scale), scale, (table.note if table else "") or NOTE)
    return replace(drawing, view=view_of(table), posing=picture.posing())


#: Largest drawn displacement of a point of the robot, as a share of the robot's size.
VISIBLE = 0.15

#: Largest drawn angle of a joint, rad: seen well, and loops can still be closed.
TURN = 0.25

#: Largest entry of a motion so small that it is straight.
SMALL = 1e-4


class RobotPicture:
    """A robot in its posture, to be drawn.

    Attributes:
        scene: the robot with its posture and system.
        solids: of its links, by name: their collision shapes where a robot has no others.
        note: on these, on meshes that are drawn with fewer triangles, and on textures that are not, or an empty string.

    Raises:
        SceneError: a shape or a mesh file that cannot be drawn; names the URDF.
    """

    def __init__(self, scene: RobotScene, table: DrawingTable | None = None):
        self.scene = scene
        self._full = full = table is not None and table.full_meshes
        with at(scene.data.urdf_place):
            own = scene.robot.visuals()
            shapes = own or scene.robot.visuals(collision=True)
            self._visuals = visuals = shapes or self._bones()
        large = {id(item.vertices) for item in visuals if item.triangles > MOST_TRIANGLES}
        missing = dict.fromkeys(item.note for item in visuals if item.note)
        notes = ["links drawn as their collision geometry"] * bool(shapes and not own)
        notes += ["links drawn as bones between their joints"] * bool(visuals and not shapes)
        notes += [f"{counted(len(large), 'mesh', 'meshes')} drawn with fewer triangles"] * bool(large and not full)
        notes += [f"textures not drawn: {', '.join(missing)}"] * bool(missing)
        self.note = ", ".join(notes)
        with at(scene.data.urdf_place):
            self.solids = solids_of(visuals, full=full)

    def _bones(self) -> tuple[Visual, ...]:
        from ...robot.visualization import bones_of

        robot = self.scene.robot
        return bones_of(robot.model, robot.link_frames, robot.connection_points(self.scene.posture))

    def poses(self, values: np.ndarray, scale: float = 1.0) -> dict[str, Poses]:
        return self.scene.robot.poses(self.scene.posture, values, scale)

    def drawing(self, poses: dict[str, Poses], scale: float = 1.0, note: str = "") -> Drawing:
        points = self.scene.robot.connection_points(self.scene.posture)
        fixed = self.scene.data.table.base == "fixed"
        note = "\n".join(filter(None, (note, self.note)))
        ellipsoids = self.scene.robot.inertia_ellipsoids()
        collision = self._collision
        return robot_drawing(
            self.solids, poses, points, scale=scale, fixed=fixed, note=note, ellipsoids=ellipsoids, collision=collision
        )

    @cached_property
    def _collision(self) -> dict[str, list[Solid]]:
        """The collision shapes of the links that differ from all visual ones."""
        drawn: dict[str, list[Visual]] = {}
        for item in self._visuals:
            drawn.setdefault(item.link, []).append(item)
        shapes = self.scene.robot.visuals(collision=True)
        return solids_of([item for item in shapes if not any(map(item.has_shape_of, drawn.get(item.link, ())))], full=self._full)

    @cached_property
    def at_rest(self) -> dict[str, Poses]:
        """The poses of the posture."""
        return self.poses(np.zeros((len(self.scene.robot.coordinates), 1)))

    @cached_property
    def _points(self) -> np.ndarray:
        """All points at rest, shape (3, k, 1)."""
        return self._of(self.at_rest)

    @property
    def points_of_links(self) -> dict[str, np.ndarray]:
        """The origin of each link and the corners of its solids, relative to the origin and turned as at rest, shape (3, k) each."""
        return {name: points[:, :, 0] - points[:, :1, 0] for name, points in link_points(self.solids, self.at_rest).items()}

    @property
    def size(self) -> float:
        """Diagonal of a box around all links (m)."""
        return robot_size({"all": self._points})

    def room(self, values: np.ndarray) -> float:
        """The largest magnification of a motion at which no joint turns, and no point moves, too far for the drawing.

        The number has two digits; it is 1 where nothing moves. Motors are not drawn and do not count.
        """
        room = self._rooms(values).min(initial=np.inf)
        return two_digits(room) if np.isfinite(room) else 1.0

    def _rooms(self, values: np.ndarray) -> np.ndarray:
        """The largest magnification of each column, without rounding; infinite where nothing moves."""
        links = values[: len(self.scene.robot.coordinates)]
        turning = np.array([unit == "rad" for unit in self.scene.robot.units], dtype=bool)
        angles = np.abs(links[turning]).max(axis=0, initial=0.0)
        with np.errstate(divide="ignore"):
            return np.minimum(VISIBLE * self.size / self._reach(links), TURN / angles)

    def _reach(self, links: np.ndarray) -> np.ndarray:
        """The largest displacement of any point in each column (m)."""
        largest = np.abs(links).max(axis=0, initial=0.0)
        steps = self._of(self.poses(links / np.where(largest, largest, 1.0), SMALL)) - self._points
        return np.linalg.norm(steps, axis=0).max(axis=0) / SMALL * largest

    def posing(self) -> SliderPosing:
        """Sliders for the independent motions, each over the range of ``room`` for it alone."""
        from ...robot.visualization import joint_motions

        motions = joint_motions(self.scene.posture)
        rooms = self._rooms(motions.columns)
        shown = np.flatnonzero(np.isfinite(rooms))
        return SliderPosing(
            tuple(motions.names[k] for k in shown),
            tuple(motions.units[k] for k in shown),
            tuple(two_digits(rooms[k]) for k in shown),
            motions.columns[:, shown],
            motions.twists,
            motions.moving,
            {name: Path(pose.positions, pose.quaternions) for name, pose in self.at_rest.items()},
        )

    def _of(self, poses: dict[str, Poses]) -> np.ndarray:
        return np.hstack(list(link_points(self.solids, poses).values()))


LENGTHS = ("rest_length", "rest_angle", "distance", "value")

#: Parts of a cycle at which it is looked how far points move; between them they go 8 % further at most.
PARTS = 8


class ShapeDrawing:
    """The drawing of a scene, given or automatic, as on the page of a run, or its robot at rest.

    Modes are motions about the state in which every spring has its length: rest lengths only shift them and are left out.

    Attributes:
        drawing: at rest.
        robot: the robot, if the scene has one.
    """

    def __init__(self, scene: SceneData, shapes: Sequence[np.ndarray]):
        equations, table = scene.equations, scene.table.drawing
        self.names = equations.coordinates.names
        self.robot = RobotPicture(equations.robot_scene, table) if equations.robot_scene else None
        if self.robot is not None:
            rest = self.robot.drawing(self.robot.at_rest, note=table.note if table else "")
            self.drawing = replace(rest, view=view_of(table), posing=self.robot.posing())
            return
        elements = None if equations.model is None else [_at_rest(element) for element in equations.model.elements]
        values = _typical_values(shapes, equations.coordinates.units)
        self.drawing = own_drawing(scene) or automatic_drawing(scene, elements, values)

    def amplitude(self, shape: np.ndarray) -> float:
        """The factor of two digits at which a shape, whose amplitude is free, is drawn, besides the magnification of the drawing.

        Bodies and the distances between linked ones move, and wheels turn, as far as there is room for; 1 where nothing is drawn.
        """
        if self.robot is not None:
            return self.robot.room(cycle(_clean(shape), PARTS + 1))
        drawing, entries = self.drawing, dict(zip(self.names, _clean(shape)))
        moves = {body.name: drawing.scale * _sum(body.moves, entries) for body in drawing.bodies}
        turns = [drawing.turn_scale * _sum(body.turns, entries) for body in drawing.bodies]
        between = [moves[link.end] - moves[link.start] for link in drawing.links if link.kind != "shaft"]
        limits = ((ABSOLUTE, moves.values()), (NEIGHBOURS, between), (WIDEST_ANGLE, turns))
        furthest = [(limit, float(max(map(np.linalg.norm, vectors), default=0.0))) for limit, vectors in limits]
        return two_digits(min((limit / size for limit, size in furthest if size), default=1.0))

    def paths(self, shape: np.ndarray, factor: float) -> dict[str, Path]:
        """The poses of all links of a robot over one cycle; none of other models."""
        links = self.robot.poses(cycle(_clean(shape)), factor) if self.robot is not None else {}
        return {name: Path(poses.positions, poses.quaternions) for name, poses in links.items()}


def _at_rest(element: Element) -> Element:
    lengths: dict[str, Any] = {key: 0.0 for key in LENGTHS if getattr(element, key, None)}
    return replace(element, **lengths)


def _typical_values(shapes: Sequence[np.ndarray], units: Sequence[str]) -> np.ndarray:
    """Typical cycles that set the magnification of displacements and angles: of all shapes, or of the one that has both."""
    turning = np.array([unit == "rad" for unit in units], dtype=bool)
    both = [shape for shape in shapes if min(_largest(shape[turning]), _largest(shape[~turning])) > noise_of(1.0, len(shape))]
    if both:
        turned = [WIDEST_ANGLE / _largest(shape[turning]) * shape for shape in both]
        turned.sort(key=lambda shape: _largest(shape[~turning]))
        return cycle(turned[(len(turned) - 1) // 2])  # at the largest angle drawn it moves neither far nor hardly
    return np.hstack([cycle(shape) for shape in shapes] or [np.zeros((len(units), 1))])


def _largest(entries: np.ndarray) -> float:
    return float(np.abs(entries).max(initial=0.0))


def _sum(vectors: Mapping[str, Vector], entries: dict[str, complex]) -> np.ndarray:
    return sum((np.array(vector) * entries.get(name, 0.0) for name, vector in vectors.items()), np.zeros(3))


def _clean(shape: np.ndarray) -> np.ndarray:
    """The shape without rounding errors, which would be visible where motors move and links hardly do."""
    return np.where(np.abs(shape) > noise_of(1.0, len(shape)), shape, 0.0)


#: Small motion by which the links are moved to see where each coordinate takes them, in rad and as a share of the robot's size.
STEP = 0.02


class LinearRobot:
    """A robot whose links move along straight lines and turn about fixed axes, as small motion does.

    Attributes:
        drawing: bodies that move with the coordinates, at rest.
    """

    def __init__(self, scene: RobotScene, table: DrawingTable | None = None):
        from scipy.spatial.transform import Rotation

        picture = RobotPicture(scene, table)
        count, names = len(scene.robot.coordinates), scene.coordinates.names
        turning = np.array([unit == "rad" for unit in scene.robot.units], dtype=bool)
        steps = np.where(turning, STEP, STEP * picture.size)
        self.size, moved = picture.size, np.diag(steps)
        forwards, backwards = picture.poses(_padded(moved, len(names))), picture.poses(_padded(-moved, len(names)))
        moves = {name: (forwards[name].positions - backwards[name].positions) / (2 * steps) for name in forwards}
        turns = {}
        for name, ahead in forwards.items():
            rotation = Rotation.from_quat(ahead.quaternions.T) * Rotation.from_quat(backwards[name].quaternions.T).inv()
            turns[name] = rotation.as_rotvec().T / (2 * steps)
        self.turns = np.vstack(list(turns.values()))
        corners = picture.points_of_links
        self.moves = np.vstack([_of_points(corners[name], moves[name], turns[name]) for name in moves])
        rest = picture.drawing(picture.at_rest, note=(table.note if table else "") or NOTE)
        still = np.zeros((3, count))

        def by_coordinate(columns: np.ndarray) -> dict[str, Vector]:
            """The columns that are more than rounding errors, by the names of the coordinates."""
            largest = np.abs(columns).max(axis=0)
            moving = np.flatnonzero(largest > noise_of(largest.max(initial=0.0), count))
            return {names[i]: (float(columns[0, i]), float(columns[1, i]), float(columns[2, i])) for i in moving}

        def linear(body: DrawnBody) -> DrawnBody:
            """The body without its path."""
            if body.path is None:
                return body
            (x, y, z), turn = (
                body.path.positions[:, 0].tolist(),
                Rotation.from_quat(body.path.quaternions[:, 0]).as_rotvec().tolist(),
            )
            own = by_coordinate(moves.get(body.name, still)), by_coordinate(turns.get(body.name, still))
            return replace(body, path=None, rest=(x, y, z), rest_turn=(turn[0], turn[1], turn[2]), moves=own[0], turns=own[1])

        bodies = tuple(map(linear, rest.bodies))
        self.drawing = replace(rest, bodies=bodies, scale=1.0, turn_scale=1.0, view=view_of(table))

    def factors(self, shapes: np.ndarray) -> np.ndarray:
        """Magnification of each shape, at which no link moves or turns too far for the drawing."""
        links = shapes[:, :, : self.moves.shape[1]]
        vectors = ((links @ rows.T).reshape(*links.shape[:2], -1, 3) for rows in (self.moves, self.turns))
        reach, angle = (np.linalg.norm(np.abs(each), axis=3).max(axis=2, initial=0.0) for each in vectors)
        with np.errstate(divide="ignore"):
            room = np.minimum(VISIBLE * self.size / reach, TURN / angle)
        return np.vectorize(lambda factor: two_digits(factor) if np.isfinite(factor) else 1.0)(room)


def _of_points(points: np.ndarray, moves: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Motion of points of a link by the coordinates, three rows for each: v + omega x r."""
    moved = moves.T[:, None, :] + np.cross(turns.T[:, None, :], points.T[None, :, :])
    return moved.reshape(len(moved), -1).T


def _padded(values: np.ndarray, count: int) -> np.ndarray:
    """Values with rows of zeros for motors."""
    return np.vstack([values, np.zeros((count - len(values), values.shape[1]))])
