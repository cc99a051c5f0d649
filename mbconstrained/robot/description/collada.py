"""Meshes of COLLADA files (.dae) with colours and names of textures.

Corners are as coal gives them: in the lengths and axes of the file, moved by the nodes of the scene; the unit and the upward axis
of the file are not applied, as in RViz. Skins, nodes from libraries, strips and fans of triangles are not read.
"""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np
from scipy.spatial.transform import Rotation

from .mesh_parts import Color, Mesh, Surfaces, UnreadableMesh, visible
from .urdf import xml_element

#: Primitives without area, which are not drawn, and those that are not read.
_LINES, _UNREAD = ("lines", "linestrips"), ("tristrips", "trifans")

_MODELS = ("phong", "lambert", "blinn", "constant")


def collada_mesh(text: str, scale=(1.0, 1.0, 1.0)) -> Mesh:
    """The mesh of a COLLADA file."""
    root = xml_element(text, "dae")
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    file = _Collada(root)
    surfaces = Surfaces()
    for placement, instance in file.instances():
        file.add(surfaces, placement, instance)
    return surfaces.mesh(scale)


class _Collada:
    def __init__(self, root: Element):
        self.root = root
        self.by_id = {element.get("id"): element for element in root.iter() if element.get("id")}

    def target(self, address: str | None) -> Element:
        """The element that an address "#id" names."""
        name = (address or "").removeprefix("#")
        if name not in self.by_id:
            raise UnreadableMesh(f"nothing is named {name[:40]!a}")
        return self.by_id[name]

    def instances(self) -> Iterator[tuple[np.ndarray, Element]]:
        """Placement (4, 4) and element of each geometry in the scene."""
        scene = self.target(_child(self.root, "scene/instance_visual_scene").get("url"))
        nodes = [(np.eye(4), node) for node in scene.findall("node")]
        for before, node in nodes:  # grows, level by level
            placement = before
            for element in node:
                if element.tag in _TRANSFORMS:
                    placement = placement @ _TRANSFORMS[element.tag](_numbers(element))
                elif element.tag == "instance_geometry":
                    yield placement, element
                elif element.tag == "node":
                    nodes.append((placement, element))
                elif element.tag in ("instance_controller", "instance_node", "lookat", "skew"):
                    raise UnreadableMesh(f"<{element.tag}> is not read")

    def add(self, surfaces: Surfaces, placement: np.ndarray, instance: Element) -> None:
        """The primitives of a geometry, with the materials that its instance binds."""
        mesh = _child(self.target(instance.get("url")), "mesh")
        bound = {item.get("symbol"): item.get("target") for item in instance.iterfind(".//instance_material")}
        starts: dict[str, int] = {}
        for primitive in mesh:
            if primitive.tag in _UNREAD:
                raise UnreadableMesh(f"<{primitive.tag}> is not read")
            if primitive.tag not in ("triangles", "polylist", "polygons"):
                continue
            inputs = {item.get("semantic"): item for item in reversed(primitive.findall("input"))}  # the first of a kind counts
            vertices = self.target(_attribute(inputs, "VERTEX", "source"))
            position = next((item for item in vertices.findall("input") if item.get("semantic") == "POSITION"), None)
            source = "" if position is None else position.get("source", "")
            if source not in starts:
                places = self.source(source, 3)
                starts[source] = surfaces.add_vertices(places @ placement[:3, :3].T + placement[:3, 3])
            sides, table = _corners(primitive)
            if not len(sides):
                continue
            corners = _column(table, inputs["VERTEX"]) + starts[source]
            color, image = self.surface(bound.get(primitive.get("material")))
            spots = None
            if image and "TEXCOORD" in inputs:
                spots = self.source(inputs["TEXCOORD"].get("source"), 2)
                numbers = _column(table, inputs["TEXCOORD"])
                if numbers.min() < 0 or numbers.max() >= len(spots):
                    raise UnreadableMesh("places in the texture that do not exist")
                spots = spots[numbers]
            surfaces.add_polygons(sides, corners, color, image, spots)

    def source(self, address: str | None, width: int) -> np.ndarray:
        """The first columns of an array of numbers, shape (k, width)."""
        source = self.target(address)
        accessor = _child(source, "technique_common/accessor")
        stride, offset = _whole(accessor.get("stride", "1")), _whole(accessor.get("offset", "0"))
        values = _numbers(self.target(accessor.get("source")))[offset:]
        if not width <= stride <= len(values) or len(values) % stride:
            raise UnreadableMesh("an array of another size than given")
        return values.reshape(-1, stride)[:, :width]

    def surface(self, address: str | None) -> tuple[Color | None, str]:
        """Colour and name of the texture of a material; None and an empty string for what it does not have."""
        if address is None:
            return None, ""
        effect = self.target(_child(self.target(address), "instance_effect").get("url"))
        model = next((element for element in effect.iter() if element.tag in _MODELS), None)
        diffuse = None if model is None else model.find("diffuse")
        if model is None or diffuse is None:
            return None, ""
        texture = diffuse.find("texture")
        if texture is not None:
            return None, self.image(effect, texture.get("texture", ""))
        color = diffuse.find("color")
        if color is None:
            return None, ""
        red, green, blue, *_ = (*_numbers(color).tolist(), 0.0, 0.0, 0.0)
        return visible((red, green, blue, _opacity(model))), ""

    def image(self, effect: Element, name: str) -> str:
        """The name of the image file of a sampler, a surface or an image."""
        parameters = {item.get("sid"): item for item in effect.iter("newparam")}
        for path in ("sampler2D/source", "surface/init_from"):
            if name in parameters:
                name = (parameters[name].findtext(path) or name).strip()
        return "".join(_child(self.target(name), "init_from").itertext()).strip()


def _corners(primitive: Element) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of corners of the polygons, and per corner the numbers of all its inputs, shape (n, w)."""
    width = 1 + max((_whole(item.get("offset", "0")) for item in primitive.findall("input")), default=0)
    rows = [_numbers(p) for p in primitive.findall("p")]
    if any(len(row) % width for row in rows):
        raise UnreadableMesh("corners with missing numbers")
    table = _indices(np.concatenate([np.zeros(0), *rows])).reshape(-1, width)
    if primitive.tag == "polygons":
        return np.array([len(row) // width for row in rows], int), table
    if primitive.tag == "polylist":
        return _indices(_numbers(_child(primitive, "vcount"))), table
    return np.full(len(table) // 3, 3), table


def _column(table: np.ndarray, item: Element) -> np.ndarray:
    return table[:, _whole(item.get("offset", "0"))]


def _indices(values: np.ndarray) -> np.ndarray:
    if not (np.abs(values) < np.iinfo(np.int32).max).all():
        raise UnreadableMesh("corners that do not exist")
    return values.astype(int)


def _opacity(model: Element) -> float:
    """Opacity from <transparent>, 1 by default, and the factor <transparency>."""
    factor, transparent = _numbers(model.find("transparency/float")), model.find("transparent")
    share = float(factor[0]) if factor.size else 1.0
    if transparent is None:
        return share
    color = np.append(_numbers(transparent.find("color")), [1.0] * 4)[:4]
    if transparent.get("opaque", "A_ONE") == "RGB_ZERO":
        return 1 - share * float(color[:3].mean())
    return share * float(color[3])


def _matrix(values: np.ndarray) -> np.ndarray:
    return _sized(values, 16).reshape(4, 4)


def _shift(values: np.ndarray) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = _sized(values, 3)
    return matrix


def _turn(values: np.ndarray) -> np.ndarray:
    """About an axis, by an angle in degrees."""
    *axis, angle = _sized(values, 4)
    length = float(np.linalg.norm(axis))
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_rotvec(np.deg2rad(angle) * np.array(axis) / (length or 1.0)).as_matrix()
    return matrix


def _stretch(values: np.ndarray) -> np.ndarray:
    return np.diag([*_sized(values, 3), 1.0])


_TRANSFORMS = {"matrix": _matrix, "translate": _shift, "rotate": _turn, "scale": _stretch}


def _sized(values: np.ndarray, count: int) -> np.ndarray:
    if len(values) != count:
        raise UnreadableMesh(f"a transformation of {len(values)} numbers instead of {count}")
    return values


def _child(element: Element, path: str) -> Element:
    child = element.find(path)
    if child is None:
        raise UnreadableMesh(f"no <{path.rpartition('/')[2]}> in <{element.tag}>")
    return child


def _attribute(inputs: dict, semantic: str, key: str) -> str | None:
    if semantic not in inputs:
        raise UnreadableMesh(f"a primitive without {semantic}")
    return inputs[semantic].get(key)


def _whole(text: str) -> int:
    try:
        return max(0, int(text))
    except ValueError:
        raise UnreadableMesh(f"found {text[:40]!a} instead of a whole number") from None


def _numbers(element: Element | None) -> np.ndarray:
    """The numbers in an element, shape (n,); none without one."""
    try:
        return np.array(((element.text if element is not None else "") or "").split(), float)
    except ValueError:
        raise UnreadableMesh("found words instead of numbers") from None
