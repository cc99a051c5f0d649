"""Readers of mesh files: pycollada reads COLLADA files (.dae), trimesh STL files, and coal what is left, without colours.

Colours are those of the files: trimesh's readers round them to 8 bits and leave out factors of the opacity, and its reader of Wavefront
files (.obj) counts negative numbers of corners from the end of the file, and takes a time of vertices times materials. Corners are in
the lengths and axes of the file: the unit and the upward axis are not applied, as in RViz.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from .mesh_parts import Color, Mesh, Surfaces, UnreadableMesh, visible
from .urdf import xml_element

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
