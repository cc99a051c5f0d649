"""Mesh files of a robot, where they may lie, and their contents in parts, each of one colour or texture.

Colours are those of the files: trimesh's readers round them to 8 bits and leave out factors of the opacity, and its reader of Wavefront
files (.obj) counts negative numbers of corners from the end of the file, and takes a time of vertices times materials. Corners are in
the lengths and axes of the file: the unit and the upward axis are not applied, as in RViz.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import pairwise
from pathlib import Path
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np

from ...ground.errors import InputError
from .urdf import xml_element

#: Red, green, blue and opacity from 0 to 1.
Color = tuple[float, float, float, float]


class UnreadableMesh(ValueError):
    """A file that is broken, or uses what the reader does not know."""


@dataclass(frozen=True, eq=False)
class Texture:
    """An image over triangles."""

    image: bytes | str  # a JPEG file, or, from a reader, the name of an image file
    places: np.ndarray  # of the corners of each triangle in the image, shape (f, 3, 2), from (0, 0) at its lower left to (1, 1)


@dataclass(frozen=True, eq=False)
class MeshPart:
    """Triangles of a mesh that look alike."""

    faces: np.ndarray  # numbers of the corners, shape (f, 3)
    color: Color | None = None  # None where the file gives none
    texture: Texture | None = None  # takes the place of the colour, or None


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh."""

    vertices: np.ndarray  # corners (k, 3) in m
    parts: tuple[MeshPart, ...]  # with their triangles
    notes: tuple[str, ...] = ()  # on textures that are not drawn

    @cached_property
    def whole(self) -> MeshPart:
        """All triangles, without their colours."""
        return MeshPart(np.vstack([part.faces for part in self.parts]))


class Surfaces:
    """Triangles, collected by how they look; ``mesh`` gives the parts."""

    def __init__(self) -> None:
        self._vertices: list[np.ndarray] = [np.zeros((0, 3))]
        self._count = 0
        self._faces: dict[tuple[Color | None, str], tuple[list[np.ndarray], list[np.ndarray]]] = {}

    def add_vertices(self, vertices: np.ndarray) -> int:
        """The number of the first one of further corners (k, 3)."""
        self._vertices.append(vertices)
        self._count += len(vertices)
        return self._count - len(vertices)

    def add_faces(self, start: int, faces: np.ndarray, color: Color | None = None, image: str = "", places=None) -> None:
        """Triangles of corners counted from ``start``; an image is shown where the places of the corners in it are given."""
        if faces.size and not 0 <= faces.min() <= faces.max() < self._count - start:
            raise UnreadableMesh("triangles with corners that do not exist")
        shown = bool(image) and places is not None
        corners, spots = self._faces.setdefault((None, image) if shown else (color, ""), ([], []))
        corners.append(faces.reshape(-1, 3) + start)
        spots += [places.reshape(-1, 3, 2)] if shown else []

    def mesh(self, scale=(1.0, 1.0, 1.0)) -> Mesh:
        """The mesh, its corners times the scale."""
        vertices, parts = np.vstack(self._vertices) * scale, []
        for (color, image), (faces, places) in self._faces.items():
            if sum(map(len, faces)):
                parts.append(MeshPart(np.vstack(faces), color, Texture(image, np.vstack(places)) if image else None))
        if not parts:
            raise UnreadableMesh("no triangles")
        if not all(np.isfinite(array).all() for array in (vertices, *(part.texture.places for part in parts if part.texture))):
            raise UnreadableMesh("corners that are no finite numbers")
        return Mesh(vertices, tuple(parts))


def visible(color: Color) -> Color:
    """A colour within its range; an opacity of 0 is 1, since exporters write it where they mean opaque."""
    red, green, blue, opacity = (min(1.0, max(0.0, part)) for part in color)
    return red, green, blue, opacity or 1.0


#: Elements of COLLADA files that are left out, so that nothing is refused because of them, and those that are not read: pycollada
#: overlooks some, and instances of nodes may multiply without end.
_UNUSED = {
    *(f"library_{name}" for name in ("animations", "animation_clips", "cameras", "controllers", "lights", "nodes")),
    *("asset", "extra", "instance_camera", "instance_light", "lines", "linestrips"),
    *("emission", "ambient", "specular", "shininess", "reflective", "reflectivity", "index_of_refraction"),
}
_UNREAD = ("instance_controller", "instance_node", "lookat", "skew", "tristrips", "trifans")


@contextmanager
def _unreadable() -> Iterator[None]:
    """Whatever a broken file leads to in a reader is a mesh that cannot be read; NumPy only warns of words among numbers."""
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "string or file could not be read", DeprecationWarning)
        try:
            yield
        except Exception as problem:
            raise UnreadableMesh(str(problem)) from None


def collada_mesh(text: str, scale=(1.0, 1.0, 1.0)) -> Mesh:
    """The mesh of a COLLADA file."""
    import collada

    surfaces, starts, appearance = Surfaces(), {}, cache(_appearance)
    with _unreadable():
        document = collada.Collada(_simplified(text), ignore=[collada.common.DaeUnsupportedError])
        for instance in document.scene.objects("geometry"):
            starts.clear()
            for primitive in instance.original.primitives:
                if isinstance(primitive, collada.polylist.Polylist):
                    if primitive.nvertices != len(primitive.index):
                        raise UnreadableMesh("polygons with another number of corners than given")
                    primitive = primitive.triangleset()
                if not primitive.ntriangles:
                    continue
                source = primitive.sources["VERTEX"][0][4]
                if source not in starts:
                    starts[source] = surfaces.add_vertices(source.data @ instance.matrix[:3, :3].T + instance.matrix[:3, 3])
                bound = instance.materialnodebysymbol.get(primitive.material)
                color, image = (None, "") if bound is None else appearance(bound.target.effect)
                places = (
                    primitive.texcoordset[0][primitive.texcoord_indexset[0].astype(np.uint32)] if primitive.texcoordset else None
                )
                surfaces.add_faces(starts[source], primitive.vertex_index, color, image, places)
        return surfaces.mesh(scale)


def _simplified(text: str) -> io.BytesIO:
    """A COLLADA file of what is drawn, in one namespace, without samplers of images that are not there (anymal_foot.dae)."""
    from scipy.spatial.transform import Rotation

    root = xml_element(text, "dae")
    surfaces = {element.get("sid") for element in root.iter()}
    for element in root.iter():
        for child in list(element):
            name = child.tag.rpartition("}")[2]
            spread = name == "accessor" and (child.get("stride", "1"), child.get("offset", "0")) != (str(len(child)), "0")
            if name in _UNREAD or spread or (name == "float_array" and "nan" in (child.text or "").lower()):
                raise UnreadableMesh(f"<{name}> is not read")
            if name == "rotate":  # whose sines pycollada rounds to 7 digits, and whose axis it takes to have the length 1
                *axis, angle = map(float, (child.text or "").split())
                matrix = np.eye(4)
                matrix[:3, :3] = Rotation.from_rotvec(
                    np.array(axis) * (angle / (np.linalg.norm(axis) or 1.0)), degrees=True
                ).as_matrix()
                child.tag, child.text = "matrix", " ".join(map(str, matrix.ravel()))
            source = child.find("{*}sampler2D/{*}source") if name == "newparam" else None
            if name in _UNUSED or (source is not None and source.text not in surfaces):
                element.remove(child)
        element.tag = "{http://www.collada.org/2005/11/COLLADASchema}" + element.tag.rpartition("}")[2]
    return io.BytesIO(ElementTree.tostring(root))


def _appearance(effect) -> tuple[Color | None, str]:
    """Colour and name of the texture of an effect; None and an empty string for what it does not have."""
    if hasattr(effect.diffuse, "sampler"):
        return None, (effect.diffuse.sampler.surface.image.path or "").strip()
    if effect.xmlnode.find(".//{*}diffuse/{*}color") is None:
        return None, ""
    share = effect.transparency if effect.xmlnode.find(".//{*}transparency/{*}float") is not None else 1.0
    transparent = effect.transparent if isinstance(effect.transparent, tuple) else (1.0, 1.0, 1.0, 1.0)
    opaque_at_zero = effect.opaque_mode == "RGB_ZERO"
    return visible((*effect.diffuse[:3], 1 - share * np.mean(transparent[:3]) if opaque_at_zero else share * transparent[3])), ""


def wavefront_mesh(text: str, read: Callable[[str], str], scale=(1.0, 1.0, 1.0)) -> Mesh:
    """The mesh of a Wavefront file: its polygons, cut into triangles from their first corners, without lines, points and curves."""
    vertices, spots, materials, libraries = [], [], {}, {}
    faces: dict[str, list[tuple[int, int]]] = {}  # three corners a triangle, by the name of the material
    own = faces.setdefault("", [])
    surfaces = Surfaces()
    with _unreadable():
        for key, *words in _lines(text):
            if key == "v":
                vertices.append(words[:3])
            elif key == "vt":
                spots.append(words[:2])
            elif key == "f":
                corners = [_corner(word, len(vertices), len(spots)) for word in words]
                own += [corner for pair in pairwise(corners[1:]) for corner in (corners[0], *pair)]
            elif key == "usemtl":
                own = faces.setdefault(" ".join(words), [])
            elif key == "mtllib":
                libraries.setdefault(" ".join(words))
        for name in libraries:
            materials |= _materials(read(name))
        start = surfaces.add_vertices(np.array(vertices, float).reshape(len(vertices), 3))
        places = np.array(spots, float).reshape(len(spots), 2)
        for name, rows in faces.items():
            numbers, spot = np.array(rows, int).reshape(-1, 3, 2).transpose(2, 0, 1)
            color, image = materials.get(name, (None, ""))
            surfaces.add_faces(start, numbers, color, image, places[spot] if rows and spot.min() >= 0 else None)
        return surfaces.mesh(scale)


def _lines(text: str) -> Iterator[list[str]]:
    """The words of each line; one that ends in a backslash goes on in the next."""
    return (line.split() or [""] for line in text.replace("\\\r\n", " ").replace("\\\n", " ").splitlines())


def _corner(text: str, vertices: int, spots: int) -> tuple[int, int]:
    """Numbers, counted from 0, of the vertex and of the place in the texture, -1 without one."""
    vertex, spot, *_ = (*text.split("/"), "")
    return _number(vertex, vertices), _number(spot, spots) if spot else -1


def _number(text: str, count: int) -> int:
    """A number counted from 0; negative ones count from the last line."""
    number = int(text)
    if not 0 < abs(number) <= count:
        raise UnreadableMesh("corners that do not exist")
    return number - 1 if number > 0 else count + number


def _materials(text: str) -> dict[str, tuple[Color | None, str]]:
    """Colour and name of the texture of each material of a material file; lines that make no sense are left out."""
    values: dict[str, dict[str, list[str]]] = {}
    own: dict[str, list[str]] = {}
    for key, *words in _lines(text):
        if key == "newmtl":
            own = values.setdefault(" ".join(words), {})
        else:
            own[key] = words
    return {name: (_color(entries), _image(entries.get("map_Kd", []))) for name, entries in values.items()}


def _color(entries: dict[str, list[str]]) -> Color | None:
    try:
        red, green, blue = map(float, entries["Kd"][:3])
        return visible((red, green, blue, float(entries["d"][0] if "d" in entries else 1 - float(entries.get("Tr", ["0"])[0]))))
    except (KeyError, IndexError, ValueError):
        return None


def _image(words: list[str]) -> str:
    """The file of a texture, behind its options, whose values have no blanks."""
    return words[-1] if words and words[0].startswith("-") else " ".join(words)


def stl_mesh(data: bytes, scale=(1.0, 1.0, 1.0)) -> Mesh:
    """The mesh of an STL file, whose equal corners become one."""
    import trimesh

    surfaces = Surfaces()
    with _unreadable():
        corners = np.asarray(trimesh.load_mesh(io.BytesIO(data), "stl", process=False).triangles).reshape(-1, 3) + 0.0  # not -0.0
        first, numbers = trimesh.grouping.unique_rows(corners.view(np.int64))
        faces = numbers.reshape(-1, 3)
        has_area = (np.diff(np.sort(faces, axis=1), axis=1) > 0).all(axis=1)
        surfaces.add_faces(surfaces.add_vertices(corners[first]), faces[has_area])
        return surfaces.mesh(scale)


def coal_mesh(path: Path, scale=(1.0, 1.0, 1.0)) -> Mesh:
    """The mesh of a file without its colours, as coal reads it, which knows more of the formats but mixes up corners of several materials."""
    import coal

    surfaces = Surfaces()
    with _unreadable():
        mesh = coal.MeshLoader().load(str(path), np.ones(3))
        triangles = (mesh.tri_indices(i) for i in range(mesh.num_tris))  # which know their length, but not their end
        faces = np.fromiter((triangle[k] for triangle in triangles for k in range(3)), int)
        surfaces.add_faces(surfaces.add_vertices(np.array(mesh.vertices()).reshape(-1, 3)), faces)
        return surfaces.mesh(scale)


#: Largest mesh file and image file in bytes.
LARGEST_MESH = 50_000_000

#: Endings of files with colours, which have their own readers, and of all.
WITH_COLORS = (".obj", ".dae")
MESH_ENDINGS = (".stl", ".ply", *WITH_COLORS)

#: Formats and endings of images, the most pixels of one, and those along the longer side of one that the page embeds.
_IMAGES = {"PNG": (".png",), "JPEG": (".jpg", ".jpeg"), "BMP": (".bmp",), "TGA": (".tga",), "TIFF": (".tif", ".tiff")}
_MOST_PIXELS, _SIDE = 50_000_000, 512

_RULE = "mesh files lie in the folder of the URDF, in its package, or in package_dirs: name their folder there"


class MissingMesh(InputError):
    """A mesh file that is not there, or not in a folder from which files are read."""


class MeshFiles:
    """The mesh files of a robot; those that were read are kept, since links and collision shapes share them.

    Args:
        folder: of the URDF, None where it was given as a text.
        package_dirs: folders that hold the packages of package://NAME/...
    """

    def __init__(self, folder: Path | None, package_dirs: tuple[Path, ...]):
        self.folder, self.package_dirs = folder, package_dirs
        self._meshes: dict[tuple, Mesh] = {}

    def mesh(self, name: str, scale, where: str, *, images: bool = False) -> Mesh:
        """The mesh of a file times a scale, with the images that its textures name, or with their names."""
        path, roots = self._file(name, where)
        key = (path, tuple(scale), images)
        if key not in self._meshes:
            whole = self.mesh(name, scale, where) if images else read_mesh(path, scale, roots, where)
            self._meshes[key] = _with_images(whole, path, roots) if images else whole
        return self._meshes[key]

    def path(self, name: str, where: str) -> Path:
        """The path of a mesh: in the folder of the URDF, in its package, or in a package directory.

        package://NAME/... is looked for in the folder NAME of a package directory, and in the folder NAME that the URDF lies in.
        """
        return self._file(name, where)[0]

    def _file(self, name: str, where: str) -> tuple[Path, tuple[Path, ...]]:
        """The path of a mesh, and the folders from which it and what it names may be read."""
        (roots, rest), given = self._roots(name, where), name
        paths = [(root / rest).resolve() for root in roots]
        path = next((path for path in paths if path.is_file()), paths[0])
        if not _lies_in(path, roots):
            raise MissingMesh(f"{where}: the mesh {given[:60]!a} leads out of its folder; {_RULE}")
        if path.suffix.lower() not in MESH_ENDINGS:
            raise MissingMesh(f"{where}: found the mesh {path.name[:60]!a}; expected a file that ends in {', '.join(MESH_ENDINGS)}")
        if not path.is_file():
            raise MissingMesh(f"{where}: there is no mesh file {given[:60]!a}")
        if path.stat().st_size > LARGEST_MESH:
            raise MissingMesh(f"{where}: the mesh {path.name} has {path.stat().st_size:,} bytes; at most {LARGEST_MESH:,} are read")
        return path, roots

    def _roots(self, name: str, where: str) -> tuple[tuple[Path, ...], str]:
        """The folders from which a mesh may be read, and its path in them."""
        given, name = name, unquote(name)
        kind, _, rest = name.partition("://")
        if kind in ("package", "model") and (rest.startswith("/") or "/" not in rest):  # no package: next to the file
            name = rest.lstrip("/")
            kind = ""
        if kind in ("package", "model"):
            package, _, name = rest.partition("/")
            roots = self._packages(package)
            if not roots:
                raise MissingMesh(
                    f'{where}: found the mesh of the {kind} "{package[:60]}", which is in none of package_dirs; {_RULE}'
                )
        elif self.folder is None and not self.package_dirs:
            raise MissingMesh(
                f"{where}: found the mesh {given[:60]!a}, but the URDF was given as a text; give its path, or package_dirs"
            )
        else:
            name = name.removeprefix("file://")
            roots = (*([self.folder] if self.folder else []), *self.package_dirs)
        if "://" in name or "\0" in name or not name:
            raise MissingMesh(f"{where}: found the mesh {given[:60]!a}; {_RULE}")
        return roots, name

    def _packages(self, package: str) -> tuple[Path, ...]:
        """The folders of a package."""
        if package in ("", ".", ".."):
            return ()
        own = self.folder.resolve() if self.folder else None
        above = [place for place in (own, *own.parents) if place.name == package] if own else []
        return (*(directory / package for directory in self.package_dirs if (directory / package).is_dir()), *above)


def read_mesh(path: Path, scale, roots: tuple[Path, ...], where: str) -> Mesh:
    """The mesh of a file; what no other reader can read, coal reads without colours, or names what is wrong."""
    with suppress(UnreadableMesh):
        if path.suffix.lower() == ".dae":
            return collada_mesh(_text(path), scale)
        if path.suffix.lower() == ".obj":

            def materials(name: str) -> str:
                file = _named_file(path, name, roots, (".mtl",))
                return "" if file is None else _text(file)

            return wavefront_mesh(_text(path), materials, scale)
        if path.suffix.lower() == ".stl":
            return stl_mesh(path.read_bytes(), scale)
    try:
        return coal_mesh(path, scale)
    except UnreadableMesh as problem:
        reason = (str(problem).strip().splitlines() or ["unknown"])[-1][:120]
        raise InputError(f"{where}: the mesh file {path.name} cannot be read ({reason})") from None


def _lies_in(path: Path, roots: tuple[Path, ...]) -> bool:
    return any(path.is_relative_to(root.resolve()) for root in roots)


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace")


def _named_file(mesh: Path, name: str, roots: tuple[Path, ...], endings: tuple[str, ...]) -> Path | None:
    """The file that a mesh file names: by its path or, since exporters write paths of their own machine, by its name alone."""
    name = unquote(name).removeprefix("file://").replace("\\", "/").replace("\0", "")
    for place in (mesh.parent / name, mesh.parent / name.rpartition("/")[2]):
        path = place.resolve()
        if path.suffix.lower() in endings and _lies_in(path, roots) and path.is_file() and path.stat().st_size <= LARGEST_MESH:
            return path
    return None


def _with_images(mesh: Mesh, path: Path, roots: tuple[Path, ...]) -> Mesh:
    """The mesh with the images that its textures name, and notes on those that are not drawn."""
    parts, notes, images = [], [], {}
    endings = tuple(ending for endings in _IMAGES.values() for ending in endings)
    for part in mesh.parts:
        if part.texture is not None:
            name = str(part.texture.image)
            if name not in images:
                file = _named_file(path, name, roots, endings)
                images[name] = None if file is None else _image_data(file)
                if images[name] is None:
                    notes.append(f"{name.replace(chr(92), '/').rpartition('/')[2][:60]!a} of {path.name[:60]}")
            image = images[name]
            part = replace(part, texture=None if image is None else replace(part.texture, image=image))
        parts.append(part)
    return replace(mesh, parts=tuple(parts), notes=tuple(notes))


def _image_data(path: Path) -> bytes | None:
    """The image as a JPEG file of at most 512 pixels along its longer side; None where it cannot be read."""
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("error")  # an image of very many pixels, or a broken file
        try:
            with Image.open(path, formats=tuple(_IMAGES)) as image:
                if image.width * image.height > _MOST_PIXELS:
                    return None
                image.draft("RGB", (_SIDE, _SIDE))  # a JPEG file is decoded at a size near to it
                small = image.convert("RGB")
            small.thumbnail((_SIDE, _SIDE))
            stream = io.BytesIO()
            small.save(stream, "JPEG", quality=85, optimize=True)
        except Exception:  # decoders raise whatever a broken file leads to
            return None
    return stream.getvalue()
