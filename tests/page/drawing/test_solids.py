"""Solids: their extents; meshes that are the same are stored once."""

import base64

import numpy as np
import pytest

from mbconstrained.page.animation import Animation, key_frames
from mbconstrained.page.drawing import Drawing, DrawnBody, Solid
from mbconstrained.page.figure import figure_data

TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def placement(shift=(0, 0, 0), quarter=False):
    """A shift, after a quarter turn about z if asked for."""
    matrix = np.eye(4)
    matrix[:3, 3] = shift
    if quarter:
        matrix[:2, :2] = [[0, -1], [1, 0]]
    return matrix


@pytest.mark.parametrize(
    "solid, low, high",
    [
        (Solid("box", (2, 4, 6)), (-1, -2, -3), (1, 2, 3)),
        (Solid("box", (2, 4, 6), placement((10, 0, 0), quarter=True)), (8, -1, -3), (12, 1, 3)),
        (Solid("cylinder", (0.5, 4)), (-0.5, -0.5, -2), (0.5, 0.5, 2)),
        (Solid("sphere", (0.5,)), (-0.5,) * 3, (0.5,) * 3),
        (Solid("mesh", vertices=TETRAHEDRON, faces=FACES), (0, 0, 0), (1, 2, 3)),
        (Solid("box", (0, 0, 0)), (0, 0, 0), (0, 0, 0)),
    ],
)
def test_corners_are_those_of_a_box_around_it(solid, low, high):
    assert solid.corners.min(axis=1) == pytest.approx(low)
    assert solid.corners.max(axis=1) == pytest.approx(high)


def drawn(*solids, color=None) -> tuple[list[dict], list[dict]]:
    """The data of the solids of one body, and of the meshes."""
    drawing = Drawing((DrawnBody("b", "solids", solids=solids, color=color),))
    figure = figure_data(drawing, [key_frames(Animation(drawing, (), [0.0], np.zeros((0, 1))))])
    return figure["bodies"][0]["solids"], figure["meshes"]


@pytest.mark.parametrize("vertices", [np.zeros((0, 3)), TETRAHEDRON])
def test_a_mesh_without_faces_has_no_extent_and_is_not_stored(vertices):
    solid = Solid("mesh", vertices=vertices, faces=np.zeros((0, 3), int))
    assert solid.corners.shape == (3, 0)
    assert drawn(solid) == ([], [])


def test_vertices_at_one_place_are_one_and_faces_without_area_are_none():
    # as an STL file gives it: three vertices of its own to each face
    solid = Solid("mesh", vertices=TETRAHEDRON[FACES].reshape(-1, 3), faces=np.array([*np.arange(12).reshape(4, 3), (0, 0, 1)]))
    assert solid.vertices.shape == (4, 3)
    corners = {tuple(sorted(map(tuple, solid.vertices[face]))) for face in solid.faces}
    assert corners == {tuple(sorted(map(tuple, TETRAHEDRON[face]))) for face in FACES}


def test_a_mesh_is_stored_once_however_many_parts_show_it():
    solids = [Solid("mesh", placement=placement((i, 0, 0)), vertices=TETRAHEDRON, faces=FACES) for i in range(3)]
    solids.append(Solid("mesh", vertices=2 * TETRAHEDRON, faces=FACES))
    rows, meshes = drawn(*solids)
    assert [row["mesh"] for row in rows] == [0, 0, 0, 1]
    assert np.allclose(np.unique(stored_vertices(meshes[1]), axis=0), np.unique(2 * TETRAHEDRON, axis=0), rtol=4e-16, atol=0)
    assert np.frombuffer(base64.b64decode(meshes[0]["faces"]), "<u2").shape == (12,)


def stored_vertices(mesh):
    """The vertices as the page reads them, shape (k, 3)."""
    codes = np.frombuffer(base64.b64decode(mesh["vertices"]["codes"]), "<u2").reshape(-1, 3)
    return mesh["vertices"]["low"] + mesh["vertices"]["step"] * codes


@pytest.mark.parametrize("count, size", [(3, 2), (65536, 2), (65537, 4)])
def test_vertices_are_off_by_less_than_is_visible_and_faces_name_all_of_them(count, size):
    places = np.random.default_rng(count).normal(size=(count, 3)) * [1.0, 1e-3, 100.0] + [5.0, 0.0, -1000.0]
    solid = Solid("mesh", vertices=places, faces=np.arange(3 * -(-count // 3)).reshape(-1, 3) % count)
    vertices = solid.vertices  # in ascending order, in float32
    _, [mesh] = drawn(solid)
    assert mesh["bytes"] == size
    step = np.ptp(vertices, axis=0) / 65535
    assert (np.abs(stored_vertices(mesh) - vertices) <= step / 2 * (1 + 1e-9)).all()
    faces = np.frombuffer(base64.b64decode(mesh["faces"]), f"<u{size}").reshape(-1, 3)
    assert np.array_equal(faces, solid.faces)


def test_a_flat_mesh_stays_flat():
    _, [mesh] = drawn(Solid("mesh", vertices=np.array([[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]]), faces=np.array([[0, 1, 2]])))
    assert set(stored_vertices(mesh)[:, 2]) == {float(np.float32(0.1))}


def test_a_part_without_a_colour_has_that_of_the_body_and_one_that_is_clear_is_left_out():
    solids = (Solid("sphere", (1,)), Solid("sphere", (1,), color="#123456", opacity=0.5), Solid("sphere", (1,), opacity=0))
    data, _ = drawn(*solids, color="#abcdef")
    assert [(row["color"], row["opacity"]) for row in data] == [("#abcdef", 1), ("#123456", 0.5)]


def test_the_placement_goes_column_by_column():
    (row,), _ = drawn(Solid("sphere", (1,), placement((7, 8, 9), quarter=True)))
    assert row["matrix"] == [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1]
