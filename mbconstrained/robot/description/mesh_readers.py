"""Readers of mesh files: pycollada reads COLLADA files (.dae), trimesh Wavefront (.obj) and STL files, and coal what is left.

Colours come from the files as they are; trimesh's own reader of COLLADA files rounds them to 8 bits and leaves out factors of the
opacity. Corners are in the lengths and axes of the file: the unit and the upward axis are not applied, as in RViz.
"""

from __future__ import annotations

import io
import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
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
                places = primitive.texcoordset[0][primitive.texcoord_indexset[0]] if primitive.texcoordset else None
                surfaces.add_faces(starts[source], primitive.vertex_index, color, image, places)
        return surfaces.mesh(scale)


def _simplified(text: str) -> io.BytesIO:
    """A COLLADA file of what is drawn, in one namespace, without samplers of images that are not there (anymal_foot.dae)."""
    root = xml_element(text, "dae")
    surfaces = {element.get("sid") for element in root.iter()}
    for element in root.iter():
        for child in list(element):
            name = child.tag.rpartition("}")[2]
            if name in _UNREAD or (name == "float_array" and "nan" in (child.text or "").lower()):
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
        return None, effect.diffuse.sampler.surface.image.path.strip()
    if effect.diffuse is None:
        return None, ""
    share = effect.transparency if effect.xmlnode.find(".//{*}transparency/{*}float") is not None else 1.0
    transparent = effect.transparent if isinstance(effect.transparent, tuple) else (1.0, 1.0, 1.0, 1.0)
    opaque_at_zero = effect.opaque_mode == "RGB_ZERO"
    return visible((*effect.diffuse[:3], 1 - share * np.mean(transparent[:3]) if opaque_at_zero else share * transparent[3])), ""


class _MaterialFiles:
    """The material files that a Wavefront file names, as one; of images trimesh gets a dot, since only their names are kept."""

    def __init__(self, text: str):
        self.text = text

    def __getitem__(self, name: str) -> str:
        return self.text

    def get(self, name: str) -> bytes:
        return b"P1 1 1 0"


def wavefront_mesh(text: str, read: Callable[[str], str], scale=(1.0, 1.0, 1.0)) -> Mesh:
    """The mesh of a Wavefront file: its polygons, without lines, points and curves."""
    from trimesh.exchange.obj import load_obj

    surfaces = Surfaces()
    with _unreadable():
        text = _counted_from_first(text)
        libraries = dict.fromkeys(re.findall("^mtllib (.+)", text, re.MULTILINE))
        loaded = load_obj(io.StringIO(text), _MaterialFiles("\n".join(map(read, libraries))))
        for part in loaded["geometry"].values():
            material, faces = getattr(part["visual"], "material", None), part["faces"]
            triangles = np.vstack([faces[:, [0, k, k + 1]] for k in range(1, faces.shape[1] - 1)])
            image, spots = getattr(material, "image", None), getattr(part["visual"], "uv", None)
            name = re.sub("^-.* ", "", image.info.get("file_path", "")) if image else ""  # options stand before it
            places = None if spots is None else spots[triangles]
            start = surfaces.add_vertices(part["vertices"])
            surfaces.add_faces(start, triangles, _color(getattr(material, "kwargs", {})), name, places)
        return surfaces.mesh(scale)


def _counted_from_first(text: str) -> str:
    """The lines of a Wavefront file with single blanks, and with numbers of corners that count from the first one.

    trimesh counts negative numbers from the last corner of the file, not of the lines above.
    """
    lines, counts = [], Counter[str]()
    for line in text.replace("\\\r\n", " ").replace("\\\n", " ").splitlines():
        key, *words = line.split() or [""]
        counts[key] += 1
        if key == "f":
            words = [
                "/".join(_number(n, counts[kind]) for n, kind in zip(word.split("/"), ("v", "vt")) if n or kind == "v")
                for word in words
            ]
        lines.append(" ".join((key, *words)))
    return "\n".join(lines)


def _number(text: str, count: int) -> str:
    number = int(text)
    if not 0 < abs(number) <= count:
        raise UnreadableMesh("corners that do not exist")
    return str(number if number > 0 else count + 1 + number)


def _color(values: dict[str, Any]) -> Color | None:
    """The colour of the entries of a material in a material file."""
    try:
        red, green, blue = values["kd"][:3]
        return visible((red, green, blue, float(values["d"][0] if "d" in values else 1 - float(values.get("tr", "0")[0]))))
    except (KeyError, TypeError, ValueError):
        return None


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
