"""Visual and collision shapes of the links of a robot as data, for drawings: the mechanics use neither."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from ...ground.checks import counted, nearest
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from .mesh_files import MeshFiles, MissingMesh
from .mesh_parts import Texture
from .mjcf import geom_kind, pose
from .models import ModelFile
from .urdf import numbers


@dataclass(frozen=True, eq=False)
class Visual:
    """One shape of a link.

    Attributes:
        link: its name.
        kind: "box", "cylinder" (axis z), "sphere" or "mesh".
        size: x, y, z; radius, length; radius; nothing for a mesh (m).
        placement: shape (4, 4), from the shape's frame into that of the link.
        color: red, green, blue, opacity from 0 to 1, or None.
        vertices, faces: of a mesh, or of those parts of it that look alike: corners (k, 3) in m, triangles (f, 3) of their numbers.
        texture: of the faces, or None.
        triangles: of the whole mesh.
        note: on textures that are not drawn, or an empty string.
    """

    link: str
    kind: str
    size: tuple[float, ...]
    placement: np.ndarray
    color: tuple[float, float, float, float] | None
    vertices: np.ndarray | None = None
    faces: np.ndarray | None = None
    texture: Texture | None = None
    triangles: int = 0
    note: str = ""

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
            placement = _placement(visual.find("origin"), where)
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
        corners, triangles = (slice(start, start + count) for start, count in _mesh_places(mj, mesh))
        return "mesh", (), np.array(mj.mesh_vert[corners], dtype=float), np.array(mj.mesh_face[triangles], dtype=int)
    return "", (), None, None


def _mesh_places(mj, mesh: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """First place and number of the corners and triangles of a mesh."""
    vertices, faces = (mj.mesh_vertadr[mesh], mj.mesh_vertnum[mesh]), (mj.mesh_faceadr[mesh], mj.mesh_facenum[mesh])
    return vertices, faces


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


def _placement(origin, where: str) -> np.ndarray:
    import pinocchio

    placement = np.eye(4)
    if origin is not None:
        xyz, rpy = (numbers(origin.get(key, "0 0 0"), 3, f"{where}, {key}") for key in ("xyz", "rpy"))
        placement[:3, :3], placement[:3, 3] = pinocchio.rpy.rpyToMatrix(*rpy), xyz
    return placement


def _color(material) -> tuple[float, float, float, float] | None:
    color = material.find("color")
    if color is None:
        return None
    return tuple(min(1.0, max(0.0, part)) for part in numbers(color.get("rgba", ""), 4, "urdf, color, rgba"))
