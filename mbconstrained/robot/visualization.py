"""The data of drawings of a robot: shapes of its links, and positions and loads of links about a posture, in link frames.

``link_poses`` gives the motion of the links, ``joint_motions`` its independent directions, ``connection_points`` the ends of loops and springs, ``row_wrenches`` and
``coordinate_wrench`` the forces and moments of multipliers and generalized forces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Literal
from xml.etree import ElementTree

import numpy as np
import scipy.linalg

from ..ground.checks import counted, nearest, real_array, real_number
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.units import GROUND
from .connections import Attached, BodySpring, Connection, LinkFrames, Loop
from .description.meshes import MeshFiles, MissingMesh, Texture
from .description.mjcf import geom_kind, pose
from .description.urdf import ModelFile, numbers, place_of
from .kinematics import Anchor
from .statics import Posture, Search, closed, rows_of
from .tangent import MimicRow


@dataclass(frozen=True, eq=False)
class Visual:
    """One shape of a link."""

    link: str  # its name
    kind: str  # "box", "cylinder" (axis z), "sphere" or "mesh"
    size: tuple[float, ...]  # x, y, z; radius, length; radius; nothing for a mesh (m)
    placement: np.ndarray  # shape (4, 4), from the shape's frame into that of the link
    color: tuple[float, float, float, float] | None  # red, green, blue, opacity from 0 to 1, or None
    # of a mesh, or of those parts of it that look alike: corners (k, 3) in m, triangles (f, 3) of their numbers
    vertices: np.ndarray | None = None
    faces: np.ndarray | None = None
    texture: Texture | None = None  # of the faces, or None
    triangles: int = 0  # of the whole mesh
    note: str = ""  # on textures that are not drawn, or an empty string

    def has_shape_of(self, other: Visual) -> bool:
        """Whether the other one is the same shape, or of the same mesh, at the same place."""
        alike = (self.kind, self.size) == (other.kind, other.size) and np.array_equal(self.placement, other.placement)
        if not alike or self.vertices is None or other.vertices is None:
            return alike
        return self.vertices is other.vertices or np.array_equal(self.vertices, other.vertices)


def visuals_of(description: ElementTree.Element, files: MeshFiles, *, collision: bool = False) -> tuple[Visual, ...]:
    """The visuals of all links, without meshes whose files are missing (``mesh_notices``).

    A mesh without a colour of its own in the URDF has those of its file, and is one visual for each of them.
    """
    colors = {m.get("name"): _color(m) for m in description.findall("material")}
    visuals: list[Visual] = []
    tag = "collision" if collision else "visual"
    for link, visual in _elements(description, tag):
        where = f'urdf, link "{link}", {tag}'
        material = visual.find("material")
        color = None if material is None else _color(material) or colors.get(material.get("name"))
        try:
            shape = _geometry(visual, where)
            placement = place_of(visual.find("origin"), where).homogeneous
            if shape.tag != "mesh":
                visuals.append(Visual(link, *_kind_and_size(shape, where), placement, color))
                continue
            scale = numbers(shape.get("scale", "1 1 1"), 3, f"{where}, scale")
            alike = collision or color is not None
            mesh = files.mesh(shape.get("filename", ""), scale, where, images=not alike)
            more = {"triangles": sum(len(part.faces) for part in mesh.parts), "note": ", ".join(mesh.notes)}
            visuals += [
                Visual(link, "mesh", (), placement, color or part.color, mesh.vertices, part.faces, part.texture, **more)
                for part in ((mesh.whole,) if alike else mesh.parts)
            ]
        except InputError as problem:
            if not collision and not isinstance(problem, MissingMesh):
                raise
    return tuple(visuals)


def visuals_of_mjcf(source: ModelFile, *, collision: bool = False) -> tuple[Visual, ...]:
    """The geoms of a compiled MJCF file; planes and height fields are left out, ellipsoids are meshes, and capsules have no round ends.

    Geoms that touch nothing are visual shapes alone, those of group 3 collision shapes alone, and all others are both.
    """
    mj, visuals = source.drawn, []
    for geom in range(mj.ngeom):
        touches = mj.geom_contype[geom] or mj.geom_conaffinity[geom]
        if geom in source.undrawn or (not touches if collision else touches and mj.geom_group[geom] == _COLLISION_GROUP):
            continue
        kind, size, vertices, faces = _compiled_shape(mj, geom)
        if kind:
            material = int(mj.geom_matid[geom])
            own = material < 0 or not np.allclose(mj.geom_rgba[geom], _USUAL_COLOR)
            color = tuple(np.clip(mj.geom_rgba[geom] if own else mj.mat_rgba[material], 0.0, 1.0).tolist())
            count = 0 if faces is None else len(faces)
            placement, link = pose(mj.geom_pos[geom], mj.geom_quat[geom]), source.links[mj.geom_bodyid[geom]]
            if (mesh := int(mj.geom_dataid[geom])) >= 0 and kind == "mesh":  # MuJoCo moves meshes into their principal axes
                moved = pose(mj.mesh_pos[mesh], mj.mesh_quat[mesh])
                placement, vertices = placement * moved.inverse(), vertices @ moved.rotation.T + moved.translation
            visuals.append(Visual(link, kind, size, placement.homogeneous, color, vertices, faces, triangles=count))
    return tuple(visuals)


#: The colour of a geom that gives none, and the group of geoms that are not drawn.
_USUAL_COLOR, _COLLISION_GROUP = (0.5, 0.5, 0.5, 1.0), 3


def _compiled_shape(mj, geom: int) -> tuple[str, tuple[float, ...], np.ndarray | None, np.ndarray | None]:
    """Kind, size, vertices and faces of a geom; an empty kind for what is not drawn."""
    kind, size = geom_kind(mj, geom), mj.geom_size[geom]
    if kind == "BOX":
        return "box", tuple((2 * size).tolist()), None, None
    if kind in ("CYLINDER", "CAPSULE"):
        return "cylinder", (float(size[0]), 2 * float(size[1])), None, None
    if kind == "SPHERE":
        return "sphere", (float(size[0]),), None, None
    if kind == "ELLIPSOID":
        return "mesh", (), *_ellipsoid(np.array(size))
    if kind in ("MESH", "SDF") and (mesh := int(mj.geom_dataid[geom])) >= 0:
        corner, triangle = int(mj.mesh_vertadr[mesh]), int(mj.mesh_faceadr[mesh])
        vertices = mj.mesh_vert[corner : corner + int(mj.mesh_vertnum[mesh])]
        faces = mj.mesh_face[triangle : triangle + int(mj.mesh_facenum[mesh])]
        return "mesh", (), np.array(vertices, dtype=float), np.array(faces, dtype=int)
    return "", (), None, None


#: Rows and columns of the mesh of an ellipsoid.
_ROWS, _COLUMNS = 12, 24


def _ellipsoid(radii: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners (k, 3) and triangles (f, 3) of an ellipsoid about the origin."""
    polar, around = np.meshgrid(np.linspace(0, np.pi, _ROWS + 1), np.linspace(0, 2 * np.pi, _COLUMNS + 1), indexing="ij")
    corners = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1).reshape(-1, 3)
    first = (np.arange(_ROWS)[:, None] * (_COLUMNS + 1) + np.arange(_COLUMNS)).ravel()
    below = first + _COLUMNS + 1
    return corners * radii, np.vstack([np.stack([first, below, below + 1], 1), np.stack([first, below + 1, first + 1], 1)])


def _elements(description: ElementTree.Element, tag: str = "visual"):
    return ((str(link.get("name")), element) for link in description.findall("link") for element in link.findall(tag))


#: Radii of the bones and joints of a robot without shapes, as shares of its longest bone.
BONE, JOINT = 0.035, 0.06


def bones_of(model, links: LinkFrames, connections: Iterable[ConnectionPoints] = ()) -> tuple[Visual, ...]:
    """Cylinders from the joint of each link to those behind it and to its connections, and balls at the joints.

    The last link of a chain reaches as far beyond its centre of mass as a uniform rod with its moment of inertia would.
    """
    heaviest = links.heaviest_links()
    ends: dict[int, list[np.ndarray]] = {joint: [] for joint in heaviest}
    for joint in range(1, model.njoints):
        if (parent := int(model.parents[joint])) in ends:
            ends[parent].append(np.array(model.jointPlacements[joint].translation))
    for anchor in map(links.link, links.names):
        ends[anchor.joint].append(anchor.point)
    for one in connections:
        for body, point in ((one.body1, one.point1), (one.body2, one.point2)):
            if body != GROUND:
                anchor = links.link(body)
                ends[anchor.joint].append(anchor.point + anchor.rotation @ point)
    for joint, own in ends.items():
        inertia, lever = model.inertias[joint], np.array(model.inertias[joint].lever)
        if joint and inertia.mass > 0 and not any(map(np.any, own)) and lever.any():
            beyond = np.sqrt(3 * np.linalg.eigvalsh(inertia.inertia)[-1] / inertia.mass) / np.linalg.norm(lever)
            own.append((1 + min(1.0, beyond)) * lever)
    longest = max((float(np.linalg.norm(end)) for own in ends.values() for end in own), default=0.0)
    visuals = []
    for joint, name in heaviest.items():
        link = links.link(name)
        pose = np.eye(4)
        pose[:3, 3] = -link.rotation.T @ link.point
        visuals.append(Visual(name, "sphere", (JOINT * longest,), pose.copy(), None))
        for end in ends[joint]:
            if length := float(np.linalg.norm(end)):
                axis = link.rotation.T @ (end / length)
                pose[:3, :3] = np.column_stack([*scipy.linalg.null_space(axis[None]).T, axis])
                pose[:3, 0] *= np.sign(np.linalg.det(pose[:3, :3]))
                pose[:3, 3] = link.rotation.T @ (end / 2 - link.point)
                visuals.append(Visual(name, "cylinder", (BONE * longest, length), pose.copy(), None))
    return tuple(visuals) if longest else ()


def mesh_notices(description: ElementTree.Element, files: MeshFiles) -> tuple[Notice, ...]:
    """A notice on the meshes that are not drawn; no file is opened."""
    missing = []
    for link, visual in _elements(description):
        for mesh in visual.findall("geometry/mesh"):
            try:
                files.path(mesh.get("filename", ""), f'link "{link}"')
            except MissingMesh as problem:
                missing.append(str(problem))
    if not missing:
        return ()
    text = f"{counted(len(missing), 'mesh', 'meshes')} not drawn: {missing[0]}"
    return (Notice(NoticeKind.OMITTED, text),)


_SIZES = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "capsule": {"radius": 1, "length": 1},
}


def _geometry(visual, where: str) -> ElementTree.Element:
    """The element of a box, cylinder, sphere, capsule or mesh."""
    geometry = visual.find("geometry")
    if geometry is None or len(geometry) == 0:
        raise InputError(f"{where}: found no geometry; expected a box, cylinder, sphere or mesh")
    tag = geometry[0].tag
    if tag not in (*_SIZES, "mesh"):
        raise InputError(f"{where}: found <{tag}>{nearest(tag, (*_SIZES, 'mesh'))}; expected {', '.join(_SIZES)} or mesh")
    return geometry[0]


def _kind_and_size(shape, where: str) -> tuple[str, tuple[float, ...]]:
    counts = _SIZES[shape.tag].items()
    size = [value for key, count in counts for value in numbers(shape.get(key), count, f"{where}, {key}", minimum=0.0)]
    if not all(size):
        expected = ", ".join(_SIZES[shape.tag])
        raise InputError(f"{where}: found <{shape.tag}> with a size of 0; expected {expected} greater than zero")
    return ("cylinder" if shape.tag == "capsule" else shape.tag), tuple(size)


def _color(material) -> tuple[float, float, float, float] | None:
    color = material.find("color")
    if color is None:
        return None
    return tuple(min(1.0, max(0.0, part)) for part in numbers(color.get("rgba", ""), 4, "urdf, color, rgba"))


#: Loops count as closed in a drawing below this gap, in rad or relative to the robot's size.
DRAWING_GAP = 1e-5

#: Chord steps with the Jacobian of the posture before Gauss-Newton steps with that of the configuration itself.
MOST_CHORDS = 6

#: A base that moves has the first coordinates.
BASE_COORDINATES = 6


@dataclass(frozen=True, eq=False)
class Poses:
    """Positions (3, T) in m and unit quaternions (4, T) x y z w of a link; both signs of a quaternion are the same rotation."""

    positions: np.ndarray
    quaternions: np.ndarray


def link_poses(posture: Posture, displacements, scale: float = 1.0) -> dict[str, Poses]:
    """The poses of all links for small displacements d, enlarged.

    The configuration is q0 (+) scale d, moved onto the loops by the shortest step: linear motion opens them by the square
    of its size.
    """
    robot, tree = posture.robot, posture.robot.tree
    count = len(robot.coordinates)
    d = real_array(displacements, "displacements", shape=(None, None))
    if len(d) < count:
        raise InputError(f"displacements: found {len(d)} rows; expected one for each of the {count} coordinates")
    d = d[:count] * real_number(scale, "scale")
    on_loops = _onto_loops(posture)
    numbers = [robot.link_frames.number(name) for name in robot.bodies]
    positions, quaternions = np.empty((len(numbers), 3, d.shape[1])), np.empty((len(numbers), 4, d.shape[1]))
    for k, step in enumerate(d.T):
        frames = tree.frames(on_loops(tree.moved(posture.configuration, step)), numbers)
        for body, (position, quaternion) in enumerate(frames):
            positions[body, :, k], quaternions[body, :, k] = position, quaternion
    return {name: Poses(positions[i], quaternions[i]) for i, name in enumerate(robot.bodies)}


@dataclass(frozen=True, eq=False)
class JointMotions:
    """The independent motions of a robot near its posture: q = columns s, with loops closed to first order.

    A link moves by the product exp(S_1 q_1) ... exp(S_n q_n) over its own coordinates; without loops this is exact.
    """

    # names and units of the r independent coordinates s
    names: tuple[str, ...]
    units: tuple[str, ...]
    columns: np.ndarray  # columns of all coordinates for a unit of each, shape (n, r)
    twists: np.ndarray  # S_i of each coordinate in ground axes, the velocity at the origin above the rate of rotation, shape (6, n)
    moving: dict[str, tuple[int, ...]]  # the places of the coordinates that move each link, ascending, by its name


def joint_motions(posture: Posture) -> JointMotions:
    """The motions that the loops of a robot allow, each named by the coordinate that is 1 in it while the other named ones are 0.

    The names are those of the rows of the null space's basis that a QR decomposition with column pivoting takes first.
    """
    robot, balance = posture.robot, posture.balance
    lengths, columns = balance.load.lengths, np.eye(len(robot.coordinates))
    chosen = np.arange(len(columns))
    if balance.load.has_rows:
        basis = rows_of(balance.scaled_jacobian).motions
        chosen = np.sort(scipy.linalg.qr(basis.T, mode="economic", pivoting=True)[2][: basis.shape[1]])
        columns = lengths[:, None] * np.linalg.solve(basis[chosen].T, basis.T).T / lengths[chosen]
    moves = balance.kinematics.tree.moving
    moving = {name: tuple(np.flatnonzero(moves[robot.link_frames.link(name).joint]).tolist()) for name in robot.bodies}
    names, units = (tuple(texts[i] for i in chosen) for texts in (robot.coordinates, robot.units))
    return JointMotions(names, units, columns, balance.kinematics.columns, moving)


def _onto_loops(posture: Posture) -> Callable[[np.ndarray], np.ndarray]:
    """Map from a configuration near the posture to one with closed loops.

    Chord steps with the Jacobian of the posture come first, since they need no new derivatives; then Gauss-Newton steps. A base
    with a prescribed motion stays where it is moved to.
    """
    robot, load, free = posture.robot, posture.balance.load, np.ones(len(posture.balance.load.units), bool)
    if robot.moving_base is not None:
        load = replace(load, loops=tuple(item for item in load.loops if item.connection != robot.moving_base))
        free[:BASE_COORDINATES] = False
    if not load.has_rows:
        return lambda q: q
    search = Search(robot.tree, load, free)
    rows = rows_of(search.at(posture.configuration).scaled_jacobian[:, free])

    def on_loops(q: np.ndarray) -> np.ndarray:
        here = search.at(q)
        for _ in range(MOST_CHORDS):
            if np.abs(here.scaled_gaps).max() <= DRAWING_GAP:
                return here.configuration
            step = np.zeros(len(free))
            step[free] = -rows.shortest(here.scaled_gaps)
            here = search.moved(here, step * load.lengths)
        return closed(search, q).configuration

    return on_loops


@dataclass(frozen=True, eq=False)
class ConnectionPoints:
    """The two ends of a loop or spring."""

    name: str  # name of the loop or spring
    kind: Literal["loop", "spring", "damper", "bushing"]  # a spring with a parallel damper is listed as each of the two
    # links, or "ground", with points in their frames (m), shape (3,)
    body1: str
    point1: np.ndarray
    body2: str
    point2: np.ndarray


def connection_points(posture: Posture) -> tuple[ConnectionPoints, ...]:
    """The ends of all loops, then of all springs; a moving base is not drawn as a loop."""
    load, points = posture.balance.load, []
    for item in (*load.loops, *load.springs):
        connection = item.connection
        if connection == posture.robot.moving_base:
            continue
        ends = [
            _in_frame(posture.robot.link_frames.link(body), anchor.point)
            for body, anchor in ((connection.body1, item.first), (connection.body2, item.second))
        ]
        points += [
            ConnectionPoints(connection.name, kind, connection.body1, ends[0], connection.body2, ends[1])
            for kind in _kinds(connection)
        ]
    return tuple(points)


def _kinds(connection: Connection) -> tuple[str, ...]:
    if isinstance(connection, Loop):
        return ("loop",)
    if isinstance(connection, BodySpring):
        return ("spring",) * bool(connection.stiffness or not connection.damping) + ("damper",) * bool(connection.damping)
    return ("bushing",)


@dataclass(frozen=True, eq=False)
class Wrench:
    """A force F = force @ x and a moment T = moment @ x about the point, for multipliers or a generalized force x.

    Attributes:
        name: name of the loop, coupling or coordinate.
        on: the link under the load.
        body, point: the link, or "ground", whose frame gives the directions, and the point of action in it (m).
        force, moment: shape (3, m), in N and N m for a unit of each entry of x.
    """

    name: str
    on: str
    body: str
    point: np.ndarray
    force: np.ndarray
    moment: np.ndarray


def row_wrenches(posture: Posture) -> tuple[Wrench, ...]:
    """The wrenches of all loops and mimic_rows, x the multipliers of all their rows, shape (m,).

    A loop's acts on its second body, or on the first where the second is the ground. A coupling's are two: on the link
    of the joint that follows, and on that of the joint which it follows, each along or about the axis of the joint.
    """
    load = posture.balance.load
    every = np.eye(len(load.row_names))
    wrenches = [_of_loop(posture, item, G, every[places]) for item, _, G, places in posture.balance.loops]
    for item, row in zip(load.mimic_rows, every[len(every) - len(load.mimic_rows) :]):
        wrenches += _of_mimic_row(posture, item, row)
    return tuple(wrenches)


def _of_loop(posture: Posture, item: Attached, gradient: np.ndarray, rows: np.ndarray) -> Wrench:
    """Wrenches of a loop: J^T mu is the work of (R1 f; R1 t) on body 2 and its opposite on body 1, (f; t) = gradient^T mu."""
    loop, body = item.connection, item.connection.body1
    link = posture.robot.link_frames.link(body)
    on, sign = (loop.body2, 1.0) if loop.body2 != GROUND else (body, -1.0)
    parts = sign * gradient.T @ rows
    turn = link.rotation.T @ item.first.rotation
    return Wrench(loop.name, on, body, _in_frame(link, item.first.point), turn @ parts[:3], turn @ parts[3:])


def _of_mimic_row(posture: Posture, item: MimicRow, row: np.ndarray) -> Iterator[Wrench]:
    for joint, factor in ((item.follower, 1.0), (item.leader, -item.multiplier)):
        acting = coordinate_wrench(posture, posture.robot.model.joints[joint].idx_v)
        force, moment = (factor * part @ row[None] for part in (acting.force, acting.moment))
        yield Wrench(item.name, acting.on, acting.body, acting.point, force, moment)


def coordinate_wrench(posture: Posture, place: int) -> Wrench:
    """Wrench of a generalized force along a coordinate of the links, x its value, shape (1,): at the joint, on the link behind it."""
    robot, kinematics = posture.robot, posture.balance.kinematics
    joint = next(number for number, joint in enumerate(robot.model.joints) if number and 0 <= place - joint.idx_v < joint.nv)
    body = robot.link_frames.link_behind(joint)
    link = robot.link_frames.link(body)
    turn = (kinematics.rotations[link.joint] @ link.rotation).T
    velocity, rate = turn @ kinematics.columns[:3, [place]], turn @ kinematics.columns[3:, [place]]
    none, turns = np.zeros((3, 1)), bool(robot.units[place] == "rad")
    return Wrench(
        robot.coordinates[place], body, body, _in_frame(link, np.zeros(3)), none if turns else velocity, rate if turns else none
    )


def _in_frame(link: Anchor, point: np.ndarray) -> np.ndarray:
    """A point of the joint's frame in that of the link."""
    return link.rotation.T @ (point - link.point)
