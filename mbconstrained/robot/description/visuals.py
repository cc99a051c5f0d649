"""Visual and collision shapes of the links of a robot as data, for drawings: the mechanics use neither."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np

from ...ground.checks import counted, nearest
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from .urdf import numbers

#: Largest mesh file in bytes; the page embeds it.
LARGEST_MESH = 50_000_000

MESH_ENDINGS = (".stl", ".obj", ".dae", ".ply")


@dataclass(frozen=True, eq=False)
class Visual:
    """One shape of a link.

    Attributes:
        link: its name.
        kind: "box", "cylinder" (axis z), "sphere" or "mesh".
        size: x, y, z; radius, length; radius; nothing for a mesh (m).
        placement: shape (4, 4), from the shape's frame into that of the link.
        color: red, green, blue, opacity from 0 to 1, or None.
        vertices, faces: of a mesh: corners (k, 3) in m, and triangles (f, 3) of their numbers.
    """

    link: str
    kind: str
    size: tuple[float, ...]
    placement: np.ndarray
    color: tuple[float, float, float, float] | None
    vertices: np.ndarray | None = None
    faces: np.ndarray | None = None

    def has_shape_of(self, other: Visual) -> bool:
        """Whether the other one is the same shape at the same place."""
        alike = (self.kind, self.size) == (other.kind, other.size) and np.array_equal(self.placement, other.placement)
        if not alike or self.vertices is None or other.vertices is None:
            return alike
        return np.array_equal(self.vertices, other.vertices) and np.array_equal(self.faces, other.faces)


def visuals_of(
    description: ElementTree.Element, folder: Path | None, package_dirs: tuple[Path, ...], meshes: dict, *, collision: bool = False
) -> tuple[Visual, ...]:
    """The visuals of all links, without meshes whose files are missing (``mesh_notices``).

    Args:
        description: the element <robot>.
        folder: of the URDF, in which its mesh files lie, or None where the URDF was given as a text.
        package_dirs: folders that hold the packages of package://NAME/...
        meshes: those that were read already, by path and scale; others are added.
        collision: whether the collision shapes are read instead; those that cannot be are left out.

    Returns:
        The shapes of all links, in the order of the URDF.

    Raises:
        InputError: numbers that make no sense, mesh files that cannot be read.
    """
    colors = {m.get("name"): _color(m) for m in description.findall("material")}
    visuals = []
    tag = "collision" if collision else "visual"
    for link, visual in _elements(description, tag):
        where = f'urdf, link "{link}", {tag}'
        material = visual.find("material")
        color = None if material is None else _color(material) or colors.get(material.get("name"))
        try:
            kind, size, mesh = _shape(visual.find("geometry"), where, folder, package_dirs, meshes)
            visuals.append(Visual(link, kind, size, _placement(visual.find("origin"), where), color, *mesh))
        except InputError as problem:
            if not collision and not isinstance(problem, MissingMesh):
                raise
    return tuple(visuals)


def visuals_of_mjcf(model, path: Path, *, collision: bool = False) -> tuple[Visual, ...]:
    """The visuals of an MJCF file; planes are left out, and ellipsoids are meshes.

    Args:
        model: of pinocchio, read from the file.
        path: of the file.
        collision: whether the collision shapes are read instead.

    Returns:
        The shapes of all links.

    Raises:
        InputError: a mesh that cannot be read.
    """
    import pinocchio

    wanted = pinocchio.GeometryType.COLLISION if collision else pinocchio.GeometryType.VISUAL
    try:
        geometry = pinocchio.buildGeomFromMJCF(model, str(path), wanted)
    except (ValueError, RuntimeError) as problem:
        raise InputError(f"mjcf: the shapes cannot be read ({(str(problem).splitlines() or ['unknown'])[0][:200]})") from None
    visuals = []
    for item in geometry.geometryObjects:
        frame = model.frames[item.parentFrame]
        placement = frame.placement.inverse() * item.placement  # those of shapes are relative to the joint
        kind, size, vertices, faces = _coal_shape(item.geometry)
        if kind:
            color = tuple(min(1.0, max(0.0, float(part))) for part in item.meshColor)
            visuals.append(Visual(str(frame.name), kind, size, placement.homogeneous, color, vertices, faces))
    return tuple(visuals)


def _coal_shape(shape) -> tuple[str, tuple[float, ...], np.ndarray | None, np.ndarray | None]:
    """Kind, size, vertices and faces of a shape of coal; an empty kind for what is not drawn."""
    name = type(shape).__name__
    if name == "Box":
        return "box", tuple((2 * shape.halfSide).tolist()), None, None
    if name in ("Cylinder", "Capsule"):
        return "cylinder", (float(shape.radius), 2 * float(shape.halfLength)), None, None
    if name == "Sphere":
        return "sphere", (float(shape.radius),), None, None
    if name == "Ellipsoid":
        return "mesh", (), *_ellipsoid(np.array(shape.radii))
    if hasattr(shape, "tri_indices"):
        return "mesh", (), *_mesh_arrays(shape)
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


class MissingMesh(InputError):
    """A mesh file that is not there, or not in a folder from which files are read."""


def mesh_notices(description: ElementTree.Element, folder: Path | None, package_dirs: tuple[Path, ...]) -> tuple[Notice, ...]:
    """A notice on the meshes that are not drawn; no file is opened.

    Args:
        description, folder, package_dirs: as of ``visuals_of``.

    Returns:
        One notice, or none.
    """
    missing = []
    for link, visual in _elements(description):
        for mesh in visual.findall("geometry/mesh"):
            try:
                mesh_file(mesh.get("filename", ""), f'link "{link}"', folder, package_dirs)
            except MissingMesh as problem:
                missing.append(str(problem))
    if not missing:
        return ()
    text = f"{counted(len(missing), 'mesh', 'meshes')} not drawn: {missing[0]}"
    return (Notice(NoticeKind.OMITTED, text),)


def _shape(geometry, where: str, folder, package_dirs, meshes: dict):
    """Kind, size, and vertices and faces of a mesh."""
    if geometry is None or len(geometry) == 0:
        raise InputError(f"{where}: found no geometry; expected a box, cylinder, sphere or mesh")
    shape = geometry[0]
    keys = {
        "box": {"size": 3},
        "cylinder": {"radius": 1, "length": 1},
        "sphere": {"radius": 1},
        "capsule": {"radius": 1, "length": 1},
    }
    if shape.tag == "mesh":
        return "mesh", (), _mesh(shape, where, folder, package_dirs, meshes)
    if shape.tag not in keys:
        raise InputError(f"{where}: found <{shape.tag}>{nearest(shape.tag, (*keys, 'mesh'))}; expected {', '.join(keys)} or mesh")
    counts = keys[shape.tag].items()
    size = [value for key, count in counts for value in numbers(shape.get(key), count, f"{where}, {key}", minimum=0.0)]
    if not all(size):
        raise InputError(f"{where}: found <{shape.tag}> with a size of 0; expected {', '.join(keys[shape.tag])} greater than zero")
    return ("cylinder" if shape.tag == "capsule" else shape.tag), tuple(size), (None, None)


def _mesh(shape, where: str, folder, package_dirs, meshes: dict) -> tuple[np.ndarray, np.ndarray]:
    """Corners and triangles; a file that several links share is read once for each scale."""
    path = mesh_file(shape.get("filename", ""), where, folder, package_dirs)
    scale = tuple(numbers(shape.get("scale", "1 1 1"), 3, f"{where}, scale"))
    if (path, scale) not in meshes:
        meshes[path, scale] = _read_mesh(path, scale, where)
    return meshes[path, scale]


def _read_mesh(path: Path, scale, where: str) -> tuple[np.ndarray, np.ndarray]:
    import coal

    try:
        vertices, faces = _mesh_arrays(coal.MeshLoader().load(str(path), np.array(scale)))
    except (ValueError, RuntimeError) as problem:
        reason = (str(problem).strip().splitlines() or ["unknown"])[-1][:120]
        raise InputError(f"{where}: the mesh file {path.name} cannot be read ({reason})") from None
    if not np.isfinite(vertices).all():
        raise InputError(f"{where}: the mesh file {path.name} has corners that are no finite numbers")
    return vertices, faces


def _mesh_arrays(mesh) -> tuple[np.ndarray, np.ndarray]:
    """Corners (k, 3) and triangles (f, 3) of a mesh of coal."""
    triangles = (mesh.tri_indices(i) for i in range(mesh.num_tris))  # which know their length, but not their end
    faces = np.fromiter((triangle[k] for triangle in triangles for k in range(3)), int).reshape(-1, 3)
    return np.array(mesh.vertices()).reshape(-1, 3), faces


def mesh_file(name: str, where: str, folder: Path | None, package_dirs: tuple[Path, ...]) -> Path:
    """The path of a mesh: in the folder of the URDF, in its package, or in a package directory.

    package://NAME/... is looked for in the folder NAME of a package directory, and in the folder NAME that the URDF lies in.

    Args:
        name: as it stands in the URDF.
        where: its place, for messages.
        folder: of the URDF, None where it was given as a text.
        package_dirs: folders that contain packages.

    Returns:
        The path of the file.

    Raises:
        MissingMesh: any other place, also by a symbolic link; no such file, too large, another kind of file.
    """
    rule = "mesh files lie in the folder of the URDF, in its package, or in package_dirs: name their folder there"
    given, name = name, unquote(name)
    if name.startswith("package://"):
        package, _, name = name.removeprefix("package://").lstrip("/").partition("/")
        roots = _packages(package, folder, package_dirs)
        if not roots:
            raise MissingMesh(f'{where}: found the mesh of the package "{package[:60]}", which is in none of package_dirs; {rule}')
        allowed = roots
    elif folder is None and not package_dirs:
        raise MissingMesh(
            f"{where}: found the mesh {given[:60]!a}, but the URDF was given as a text; give its path, or package_dirs"
        )
    else:
        name = name.removeprefix("file://")
        roots = allowed = (*([folder] if folder else []), *package_dirs)
    if "://" in name or "\0" in name or not name:
        raise MissingMesh(f"{where}: found the mesh {given[:60]!a}; {rule}")
    paths = [(root / name).resolve() for root in roots]
    path = next((path for path in paths if path.is_file()), paths[0])
    if not any(path.is_relative_to(place.resolve()) for place in allowed):
        raise MissingMesh(f"{where}: the mesh {given[:60]!a} leads out of its folder; {rule}")
    if path.suffix.lower() not in MESH_ENDINGS:
        raise MissingMesh(f"{where}: found the mesh {path.name[:60]!a}; expected a file that ends in {', '.join(MESH_ENDINGS)}")
    if not path.is_file():
        raise MissingMesh(f"{where}: there is no mesh file {given[:60]!a}")
    if path.stat().st_size > LARGEST_MESH:
        raise MissingMesh(f"{where}: the mesh {path.name} has {path.stat().st_size:,} bytes; at most {LARGEST_MESH:,} are read")
    return path


def _packages(package: str, folder: Path | None, package_dirs: tuple[Path, ...]) -> tuple[Path, ...]:
    """The folders of a package."""
    if package in ("", ".", ".."):
        return ()
    above = [place for place in (folder.resolve(), *folder.resolve().parents) if place.name == package] if folder else []
    return (*(directory / package for directory in package_dirs if (directory / package).is_dir()), *above)


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
