"""Readers of mesh files: pycollada reads COLLADA files (.dae), trimesh Wavefront (.obj) and STL files, and coal what is left.

Colours come from the files as they are; trimesh's own reader of COLLADA files rounds them to 8 bits and leaves out factors of the
opacity. Corners are in the lengths and axes of the file: the unit and the upward axis are not applied, as in RViz.
"""

from __future__ import annotations

import io
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
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

    surfaces, starts = Surfaces(), {}
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
                color, image = (None, "") if bound is None else _appearance(bound.target.effect)
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
    """The mesh of a Wavefront file: its polygons, without lines, points and curves."""
    from trimesh.exchange.obj import load_obj

    surfaces, materials = Surfaces(), {}
    with _unreadable():
        lines = list(_lines(text))
        for name in dict.fromkeys(" ".join(words) for key, *words in lines if key == "mtllib"):
            materials |= _materials(read(name))
        names = "\n".join(f"newmtl {name}" for name in materials)
        loaded = load_obj(io.StringIO("\n".join(_triangles(lines))), defaultdict(lambda: names))  # which reads no file
        for part in reversed(loaded["geometry"].values()):
            color, image = materials.get(getattr(getattr(part["visual"], "material", None), "name", None), (None, ""))
            places, faces = getattr(part["visual"], "uv", None), part["faces"]
            start = surfaces.add_vertices(part["vertices"])
            surfaces.add_faces(start, faces, color, image, None if places is None else places[faces])
        return surfaces.mesh(scale)


def _lines(text: str) -> Iterator[list[str]]:
    """The words of each line; one that ends in a backslash goes on in the next."""
    return (line.split() or [""] for line in text.replace("\\\r\n", " ").replace("\\\n", " ").splitlines())


def _triangles(lines: list[list[str]]) -> Iterator[str]:
    """Lines with triangles, whose corners count from the first of the file.

    trimesh counts negative numbers from the last corner of the file, and takes a hexagon for a triangle with a texture beside one.
    """
    counts = Counter[str]()
    for key, *words in lines:
        counts[key] += 1
        if key == "f":
            corners = [[_number(n, counts[k]) for n, k in zip(word.split("/"), ("v", "vt")) if n or k == "v"] for word in words]
            first, *others = ["/".join(corner) for corner in corners]
            yield from (f"f {first} {second} {third}" for second, third in pairwise(others))
        else:
            yield " ".join((key, *words))


def _number(text: str, count: int) -> str:
    number = int(text)
    if not 0 < abs(number) <= count:
        raise UnreadableMesh("corners that do not exist")
    return str(number if number > 0 else count + 1 + number)


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
        surfaces.add_faces(surfaces.add_vertices(corners[first]), numbers)
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
