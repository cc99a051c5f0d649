"""Mesh files with colours and textures: the surface, its parts, and what broken and hostile files lead to."""

import io
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import mbconstrained as mb
from mbconstrained.ground.errors import InputError
from mbconstrained.robot.description import mjcf
from mbconstrained.robot.description.meshes import MeshFiles, UnreadableMesh, collada_mesh, wavefront_mesh
from mbconstrained.robot.description.urdf import xml_element
from mbconstrained.robot.visualization import visuals_of
from tests.robot.mjcf_models import compiled_here

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
SIDES = ["0 1 3 2", "4 6 7 5", "0 4 5 1", "2 3 7 6", "0 2 6 4", "1 5 7 3"]  # counter-clockwise from outside

RED, GREEN = (1.0, 0.0, 0.0, 1.0), (0.0, 0.5, 0.0, 1.0)


def floats(name: str, values, width: int) -> str:
    text = " ".join(f"{value:g}" for value in np.ravel(values))
    parameters = "".join(f'<param name="{axis}" type="float"/>' for axis in ("XYZ" if width == 3 else "ST"))
    return f"""<source id="{name}"><float_array id="{name}-array" count="{np.size(values)}">{text}</float_array>
<technique_common><accessor source="#{name}-array" count="{np.size(values) // width}" stride="{width}">{parameters}</accessor></technique_common></source>"""


def effect(name: str, diffuse: str, more: str = "") -> str:
    return f"""<effect id="{name}-effect"><profile_COMMON>
<newparam sid="surface"><surface type="2D"><init_from>picture</init_from></surface></newparam>
<newparam sid="sampler"><sampler2D><source>surface</source></sampler2D></newparam>
<technique sid="common"><phong><diffuse>{diffuse}</diffuse>{more}</phong></technique></profile_COMMON></effect>"""


def polygons(material: str, corners: list[str], kind: str = "polylist") -> str:
    """Polygons with the corner's number as the place in the texture, too."""
    rows = [" ".join(f"{number} {number}" for number in row.split()) for row in corners]
    counts = f"<vcount>{' '.join(str(len(row.split())) for row in corners)}</vcount>" if kind == "polylist" else ""
    content = "".join(f"<p>{row}</p>" for row in rows) if kind == "polygons" else f"<p>{' '.join(rows)}</p>"
    return f"""<{kind} material="{material}" count="{len(corners)}"><input semantic="VERTEX" source="#corners" offset="0"/>
<input semantic="TEXCOORD" source="#spots" offset="1"/>{counts}{content}</{kind}>"""


def collada(primitives: str, nodes: str = "", image: str = "picture.png", transparency: str = "") -> str:
    instance = """<instance_geometry url="#cube"><bind_material><technique_common>
<instance_material symbol="a" target="#red"/><instance_material symbol="b" target="#green"/><instance_material symbol="c" target="#shown"/>
</technique_common></bind_material></instance_geometry>"""
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_images><image id="picture"><init_from>{image}</init_from></image></library_images>
<library_effects>{effect("red", "<color>1 0 0 1</color>", transparency)}{effect("green", "<color>0 0.5 0 1</color>")}
{effect("shown", '<texture texture="sampler" texcoord="uv"/>')}</library_effects>
<library_materials>{"".join(f'<material id="{m}"><instance_effect url="#{m}-effect"/></material>' for m in ("red", "green", "shown"))}
</library_materials>
<library_geometries><geometry id="cube"><mesh>{floats("places", CORNERS, 3)}{floats("spots", CORNERS[:, :2], 2)}
<vertices id="corners"><input semantic="POSITION" source="#places"/></vertices>{primitives}</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene">{(nodes or "<node>INSTANCE</node>").replace("INSTANCE", instance)}</visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#scene"/></scene></COLLADA>"""


TWO_COLORS = polygons("a", SIDES[:2]) + polygons("b", SIDES[2:])


def wavefront(*blocks: tuple[str, list[str]], spots: bool = False) -> str:
    lines = [f"v {x} {y} {z}" for x, y, z in CORNERS] + [f"vt {x} {y}" for x, y, _ in CORNERS]
    for material, rows in blocks:
        numbers = [[int(number) + 1 for number in row.split()] for row in rows]
        lines += [f"usemtl {material}", *("f " + " ".join(f"{n}/{n}" if spots else str(n) for n in row) for row in numbers)]
    return "\n".join(["mtllib cube.mtl", *lines])


MATERIALS = "newmtl red\nKd 1 0 0\nnewmtl green\nd 1.0\nKd 0 0.5 0\nnewmtl shown\nmap_Kd -s 1 1 1 picture.png\n"


def area(vertices, faces) -> float:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def volume(mesh) -> float:
    return float(np.linalg.det(mesh.vertices[mesh.whole.faces]).sum() / 6)


@pytest.mark.parametrize(
    "counts, faces", [([2, 1, 3, 0], 1), ([0, 2, 4], 2), ([6], 4), ([], 0), ([3, 4], None), ([3], None), ([7, -1], None)]
)
def test_polygons_become_triangles_whatever_their_number_of_corners(counts, faces):
    """From corners 0 to 5, without them where there is no polygon."""
    row = "".join(f"{number} {number} " for number in range(6 if counts else 0))
    more = f"""<polylist material="a" count="{len(counts)}"><input semantic="VERTEX" source="#corners" offset="0"/>
<input semantic="TEXCOORD" source="#spots" offset="1"/><vcount>{" ".join(map(str, counts))}</vcount><p>{row}</p></polylist>"""
    if faces is None:
        with pytest.raises(UnreadableMesh):
            collada_mesh(collada(more))
        return
    mesh = collada_mesh(collada(polygons("b", ["5 6 7"]) + more))
    corners = np.vstack([part.faces for part in mesh.parts if part.color == RED] + [np.zeros((0, 3), int)])
    first = sum(counts[:-1]) if counts != [2, 1, 3, 0] else 3
    assert corners.tolist() == [[first, first + k, first + k + 1] for k in range(1, faces + 1)]


@pytest.mark.parametrize(
    "mesh",
    [
        collada_mesh(collada(TWO_COLORS)),
        collada_mesh(collada(polygons("a", SIDES[:2], "polygons") + polygons("b", SIDES[2:], "polygons"))),
        wavefront_mesh(wavefront(("red", SIDES[:2]), ("green", SIDES[2:])), lambda name: MATERIALS),
        wavefront_mesh(wavefront(("green", SIDES[2:4]), ("red", SIDES[:2]), ("green", SIDES[4:])), lambda name: MATERIALS),
    ],
)
def test_a_cube_of_two_colours_is_closed_and_has_its_area_in_each(mesh):
    assert volume(mesh) == pytest.approx(1.0, abs=1e-15)
    assert {part.color: area(mesh.vertices, part.faces) for part in mesh.parts} == pytest.approx({RED: 2.0, GREEN: 4.0})


def test_nodes_move_turn_and_stretch_in_the_order_of_the_file():
    nodes = """<node><translate>10 0 0</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>
<node><matrix>1 0 0 0  0 1 0 5  0 0 3 0  0 0 0 1</matrix>INSTANCE</node></node><node>INSTANCE</node>"""
    mesh = collada_mesh(collada(TWO_COLORS, nodes))
    moved, still = np.split(mesh.vertices, 2) if np.allclose(mesh.vertices[8:], CORNERS) else np.split(mesh.vertices, 2)[::-1]
    # (x, y, z) -> (x, y + 5, 3 z) -> (2 x, y + 5, 3 z) -> (-y - 5, 2 x, 3 z) -> (5 - y, 2 x, 3 z)
    expected = np.stack([5 - CORNERS[:, 1], 2 * CORNERS[:, 0], 3 * CORNERS[:, 2]], axis=1)
    assert np.allclose(moved, expected, atol=8e-15) and np.allclose(still, CORNERS)
    assert volume(mesh) == pytest.approx(6 + 1)
    assert len(mesh.parts) == 2


def sorted_triangles(vertices, faces) -> np.ndarray:
    rows = np.sort(np.round(vertices[faces], 6).view("f8,f8,f8"), axis=1).view(float).reshape(len(faces), 9)
    return rows[np.lexsort(rows.T)]


@pytest.mark.parametrize(
    "name, text",
    [
        (
            "cube.dae",
            collada(polygons("a", ["0 1 3", "0 3 2", "4 6 7"], "triangles"), "<node><translate>1 2 3</translate>INSTANCE</node>"),
        ),
        ("cube.obj", wavefront(("red", ["0 1 3", "0 3 2", "4 6 7"]))),
    ],
)
def test_triangles_of_one_material_are_those_of_coal(tmp_path, name, text):
    import coal

    (tmp_path / name).write_text(text)
    mesh = MeshFiles(tmp_path, ()).mesh(name, (1, 2, -1), "here")
    peer = coal.MeshLoader().load(str(tmp_path / name), np.array([1.0, 2.0, -1.0]))
    faces = np.array([[peer.tri_indices(i)[k] for k in range(3)] for i in range(peer.num_tris)])
    assert np.array_equal(sorted_triangles(mesh.vertices, mesh.whole.faces), sorted_triangles(np.array(peer.vertices()), faces))


def test_negative_numbers_count_from_the_last_line():
    mesh = wavefront_mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3//-1 -2 \\\n -1\nv 0 0 1\nf 1 2 -1", lambda name: "")
    assert mesh.whole.faces.tolist() == [[0, 1, 2], [0, 1, 3]]


@pytest.mark.parametrize(
    "more, opacity",
    [
        ("", 1.0),
        ("<transparency><float>0.25</float></transparency>", 0.25),
        ("<transparent><color>1 1 1 0.5</color></transparent><transparency><float>0.5</float></transparency>", 0.25),
        ('<transparent opaque="RGB_ZERO"><color>0.2 0.2 0.2 1</color></transparent>', 0.8),
        # written by exporters that mean opaque (SketchUp, Blender)
        ("<transparent><color>1 1 1 1</color></transparent><transparency><float>0.0</float></transparency>", 1.0),
    ],
)
def test_opacity_is_that_of_the_standard_and_invisible_is_opaque(more, opacity):
    (part,) = collada_mesh(collada(polygons("a", SIDES), transparency=more)).parts
    assert part.color == pytest.approx((1.0, 0.0, 0.0, opacity))


def picture(path: Path, size=(4, 2)) -> Path:
    Image.effect_noise(size, 50).convert("RGB").save(path)
    return path


URDF = '<robot name="r"><material name="grey"><color rgba="0.5 0.5 0.5 1"/></material><link name="a"><visual><geometry>{}</geometry>{}</visual></link></robot>'


def visuals(folder: Path, mesh: str, material: str = "", **options):
    return visuals_of(xml_element(URDF.format(mesh, material), "urdf"), MeshFiles(folder, ()), **options)


@pytest.mark.parametrize(
    "name, text", [("cube.dae", collada(polygons("c", SIDES[:1]))), ("cube.obj", wavefront(("shown", SIDES[:1]), spots=True))]
)
def test_a_texture_is_a_small_image_with_the_places_of_the_corners(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    (tmp_path / "cube.mtl").write_text(MATERIALS)
    picture(tmp_path / "picture.png", (1400, 700))
    (visual,) = visuals(tmp_path, f'<mesh filename="{name}"/>')
    with Image.open(io.BytesIO(visual.texture.image)) as image:
        assert (image.format, image.size) == ("JPEG", (512, 256))
    assert np.array_equal(visual.texture.places, visual.vertices[visual.faces][:, :, :2])
    assert (visual.color, visual.note, visual.triangles) == (None, "", 2)


def test_the_colour_of_the_urdf_takes_the_place_of_those_of_the_file(tmp_path):
    (tmp_path / "cube.dae").write_text(collada(TWO_COLORS))
    mesh = '<mesh filename="cube.dae"/>'
    assert [visual.color for visual in visuals(tmp_path, mesh)] == [RED, GREEN]
    (grey,) = visuals(tmp_path, mesh, '<material name="grey"/>')
    assert (grey.color, len(grey.faces)) == ((0.5, 0.5, 0.5, 1.0), 12)
    assert len(visuals(tmp_path, mesh, '<material name="unknown"/>')) == 2


@pytest.mark.parametrize("kind", ["missing", "outside", "link", "no image", "another kind", "too many pixels", "broken"])
def test_images_that_are_not_drawn_are_told_and_nothing_outside_is_read(tmp_path, kind):
    folder = tmp_path / "robot"
    folder.mkdir()
    name, place = "picture.png", folder / "picture.png"
    if kind == "outside":
        name = "../secret/picture.png"
        (tmp_path / "secret").mkdir()
        picture(tmp_path / "secret" / "picture.png")
    elif kind == "link":
        place.symlink_to(picture(tmp_path / "outside.png"))
    elif kind == "no image":
        place.write_text("<html>")
    elif kind == "another kind":
        name = "picture.svg"
        (folder / name).write_text("<svg/>")
    elif kind == "too many pixels":
        Image.new("1", (20_000, 20_000)).save(place)
    elif kind == "broken":
        picture(place, (64, 64))
        place.write_bytes(place.read_bytes()[:2000])
    (folder / "cube.dae").write_text(collada(polygons("c", SIDES) + polygons("a", SIDES), image=name))
    shown, red = visuals(folder, '<mesh filename="cube.dae"/>')
    assert shown.texture is None and shown.color is None
    assert shown.note == red.note == f"'{name.rpartition('/')[2]}' of cube.dae"


def stl_bytes(count: int | None = None, header: bytes = b"binary", tail: bytes = b"", corners=CORNERS) -> bytes:
    """A binary STL file of the cube; the count in its header may be wrong."""
    rows = [corners[[int(row.split()[k]) for k in (0, j, j + 1)]] for row in SIDES for j in (1, 2)]
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in rows)
    return header.ljust(80) + struct.pack("<I", len(rows) if count is None else count) + body + tail


def stl_text(*, name: str = "cube", end: str = "endsolid", blank: str = "\n") -> str:
    rows = [[int(row.split()[k]) for k in (0, j, j + 1)] for row in SIDES for j in (1, 2)]
    facets = (f"outer loop\n{''.join('vertex {:g} {:g} {:g}{}'.format(*CORNERS[n], chr(10)) for n in row)}endloop" for row in rows)
    return f"solid {name}\n" + "".join(f"facet normal 0 0 0\n{facet}\nendfacet\n" for facet in facets).replace("\n", blank) + end


@pytest.mark.parametrize(
    "data",
    [stl_bytes(), stl_bytes(header=b"solid cube"), stl_text().upper()]
    + [stl_text(name=name).encode() for name in ("", "cube", "vertex", "endsolid", "\xe9")]
    + [
        stl_text(end=""),
        stl_text(blank="\r\n"),
        stl_text(blank="\n   "),
        stl_text().replace("cube", "\ufeff"),
        stl_text(blank=" "),
    ],
)
def test_stl_files_with_all_kinds_of_headers_are_the_closed_cube(tmp_path, data):
    (tmp_path / "cube.stl").write_bytes(data if isinstance(data, bytes) else data.encode())
    mesh = MeshFiles(tmp_path, ()).mesh("cube.stl", (1, 2, -1), "here")
    assert (mesh.vertices.shape, mesh.whole.faces.shape, mesh.whole.color) == ((8, 3), (12, 3), None)
    assert volume(mesh) == pytest.approx(-2.0, abs=1e-15)


@pytest.mark.parametrize(
    "data",
    [
        stl_bytes(13),
        stl_bytes(11, b"solid"),
        stl_bytes(2**32 - 1),
        stl_bytes(tail=b"more"),
        stl_bytes()[:-30],
        stl_bytes()[:84],
        stl_bytes(corners=np.full((8, 3), np.nan)),
        b"solid",
    ]
    + [stl_bytes(corners=np.zeros((8, 3))), stl_text().replace("vertex 0 0 1", "vertex 0 0 nan").encode()]
    + [stl_text().replace("vertex 0 0 1", f"vertex {word}").encode() for word in ("0 0 x", "0 0 1e400")],
)
def test_stl_files_without_a_mesh_are_named(tmp_path, data):
    (tmp_path / "cube.stl").write_bytes(data)
    with pytest.raises(InputError, match="cube.stl cannot be read"):
        MeshFiles(tmp_path, ()).mesh("cube.stl", (1, 1, 1), 'link "a"')


def test_what_is_not_drawn_may_be_broken():
    """A camera, a light, a highlight, an unused library, a sampler without its surface (as in ANYmal's foot)."""
    nodes = "<node><instance_camera url='#none'/><instance_light url='#none'/><rotate>0 0 3 90</rotate>INSTANCE</node>"
    text = collada(polygons("a", SIDES) + "<lines/>", nodes, transparency="<specular><color>x</color></specular>")
    text = text.replace("<asset>", "<asset><created>yesterday</created>").replace(
        "<source>surface</source>", "<source>none</source>"
    )
    text = text.replace("<library_images>", "<library_nodes><node><instance_node url='#n'/></node></library_nodes><library_images>")
    (part,) = (mesh := collada_mesh(text.replace('texture="sampler"', 'texture="picture"'))).parts
    assert part.color == RED
    assert np.allclose(np.sort(mesh.vertices[:, 0]), np.sort(-CORNERS[:, 1]), atol=1e-15)  # x becomes y, whatever the axis's length
    (part,) = collada_mesh(text.replace('texture="sampler"', 'texture="picture"').replace('material="a"', 'material="c"')).parts
    assert (part.color, part.texture.image) == (None, "picture.png")


@pytest.mark.parametrize(
    "old, new",
    [
        ("<p>0 0 1 1", "<p>-1 0 1 1"),
        ("<p>0 0 1 1", "<p>8 0 1 1"),
        ("<p>0 0 1 1", "<p>0 -1 1 1"),
        ("<p>0 0 1 1", "<p>0 8 1 1"),
        ("0 0 0 0 0 1", "nan 0 0 0 0 1"),
        ("0 0 0 0 0 1", "1e400 0 0 0 0 1"),
        ("0 0 0 0 0 1", "zero 0 0 0 0 1"),
        ('count="8" stride="3"', 'count="6" stride="4"'),
        ("<instance_geometry", "<instance_node url='#n'/><instance_geometry"),
        ("<instance_geometry", "<instance_controller url='#n'/><instance_geometry"),
    ],
)
def test_what_would_be_misread_is_refused(old, new):
    text = collada(polygons("c", SIDES))
    assert old in text
    with pytest.raises(UnreadableMesh):
        collada_mesh(text.replace(old, new))


def test_what_the_reader_does_not_know_coal_reads_without_colours(tmp_path):
    strips = polygons("a", ["0 1 2 3"], "tristrips")
    with pytest.raises(UnreadableMesh, match="tristrips"):
        collada_mesh(collada(strips))
    (tmp_path / "cube.dae").write_text(collada(strips))
    (visual,) = visuals(tmp_path, '<mesh filename="cube.dae"/>')
    assert (visual.color, len(visual.faces)) == (None, 2)


@pytest.mark.parametrize(
    "text", ["", "<COLLADA/>", "v 1 2\n", "no mesh at all", '<!DOCTYPE a [<!ENTITY b "c">]><COLLADA>&b;</COLLADA>']
)
@pytest.mark.parametrize("name", ["cube.dae", "cube.obj"])
def test_a_file_without_a_mesh_is_named(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=f"{name} cannot be read"):
        MeshFiles(tmp_path, ()).mesh(name, (1, 1, 1), 'link "a"')


TEXTS = [collada(TWO_COLORS + polygons("c", SIDES)), wavefront(("red", SIDES), ("shown", SIDES), spots=True)]


@given(st.data())
def test_broken_files_are_a_mesh_or_unreadable_and_nothing_else(data):
    which = data.draw(st.integers(0, 1))
    text = TEXTS[which]
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(text) - 1))
        stop = data.draw(st.integers(start, min(len(text), start + 40)))
        new = data.draw(
            st.sampled_from(["", "-1", "nan", "1e400", "99999999999999999999", "#cube", "<p>", "/", " ", "3.5", "\n", "f"])
        )
        text = text[:start] + new + text[stop:]
    try:
        mesh = wavefront_mesh(text, lambda name: MATERIALS) if which else collada_mesh(text)
    except (UnreadableMesh, InputError):
        return
    assert np.isfinite(mesh.vertices).all() and mesh.whole.faces.max() < len(mesh.vertices) and mesh.whole.faces.min() >= 0


BODIES = {
    "urdf": """<robot name="m"><link name="w"/><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>
</inertial><visual><geometry><box size="1 2 3"/></geometry></visual><visual><geometry><mesh filename="nothing.stl"/></geometry></visual></link>
<joint name="j" type="continuous"><parent link="w"/><child link="a"/></joint></robot>""",
    "sdf": """<sdf version="1.9"><model name="m"><link name="a"><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>
</inertial><visual name="v"><geometry><box><size>1 2 3</size></box></geometry></visual><visual name="w"><geometry><mesh><uri>nothing.stl</uri>
</mesh></geometry></visual></link><joint name="j" type="revolute"><parent>world</parent><child>a</child></joint></model></sdf>""",
    "xml": """<mujoco><asset><mesh name="n" file="nothing.stl"/></asset><worldbody><body name="a"><joint name="j"/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><geom type="box" size=".5 1 1.5"/><geom type="mesh" mesh="n"/></body></worldbody></mujoco>""",
}


@pytest.mark.parametrize("ending", BODIES)
def test_without_a_mesh_the_other_shapes_are_drawn(ending, tmp_path, monkeypatch):
    if ending == "xml":
        pytest.importorskip("mujoco")
        monkeypatch.setattr(mjcf, "_compiled", compiled_here)
    (tmp_path / f"m.{ending}").write_text(BODIES[ending])
    robot = mb.Robot(tmp_path / f"m.{ending}")
    (visual,) = robot.visuals()
    assert (visual.link, visual.kind) == ("a", "box")
    np.testing.assert_allclose(visual.size, (1, 2, 3), rtol=1e-15)
    (notice,) = (*robot.description_notices, *robot.mesh_notices())
    assert "1 mesh not drawn" in notice.text and "nothing.stl" in notice.text and not notice.doubtful
