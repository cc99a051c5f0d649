"""Parts: their extents, and what they refuse; meshes that are the same are stored once."""

import base64

import numpy as np
import pytest

from mbconstrained.errors import InputError
from mbconstrained.page import Part
from mbconstrained.page.meshes import Meshes, parts_data

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
    "part, low, high",
    [
        (Part("box", (2, 4, 6)), (-1, -2, -3), (1, 2, 3)),
        (Part("box", (2, 4, 6), placement((10, 0, 0), quarter=True)), (8, -1, -3), (12, 1, 3)),
        (Part("cylinder", (0.5, 4)), (-0.5, -0.5, -2), (0.5, 0.5, 2)),
        (Part("sphere", 0.5), (-0.5,) * 3, (0.5,) * 3),
        (Part("sphere", (0.5,)), (-0.5,) * 3, (0.5,) * 3),
        (Part("mesh", vertices=TETRAHEDRON, faces=FACES), (0, 0, 0), (1, 2, 3)),
        (Part("box", (0, 0, 0)), (0, 0, 0), (0, 0, 0)),
    ],
)
def test_corners_are_those_of_a_box_around_it(part, low, high):
    assert part.corners.min(axis=1) == pytest.approx(low)
    assert part.corners.max(axis=1) == pytest.approx(high)


@pytest.mark.parametrize("vertices, faces", [(None, None), (np.zeros((0, 3)), np.zeros((0, 3))), (TETRAHEDRON, [])])
def test_a_mesh_without_faces_has_no_extent_and_is_not_stored(vertices, faces):
    part, meshes = Part("mesh", vertices=vertices, faces=faces), Meshes()
    assert part.corners.shape == (3, 0)
    assert parts_data((part,), "#000000", meshes) == []
    assert meshes.data == []


def test_vertices_at_one_place_are_one_and_faces_without_area_are_none():
    # as an STL file gives it: three vertices of its own to each face
    part = Part("mesh", vertices=TETRAHEDRON[FACES].reshape(-1, 3), faces=[*np.arange(12).reshape(4, 3), (0, 0, 1)])
    assert part.vertices.shape == (4, 3)
    corners = {tuple(sorted(map(tuple, part.vertices[face]))) for face in part.faces}
    assert corners == {tuple(sorted(map(tuple, TETRAHEDRON[face]))) for face in FACES}


def test_a_mesh_is_stored_once_however_many_parts_show_it():
    meshes = Meshes()
    parts = [Part("mesh", placement=placement((i, 0, 0)), vertices=TETRAHEDRON, faces=FACES) for i in range(3)]
    parts.append(Part("mesh", vertices=2 * TETRAHEDRON, faces=FACES))
    assert [row["mesh"] for row in parts_data(tuple(parts), "#000000", meshes)] == [0, 0, 0, 1]
    vertices = np.frombuffer(base64.b64decode(meshes.data[1]["vertices"]), "<f4").reshape(-1, 3)
    assert np.array_equal(np.unique(vertices, axis=0), np.unique(2 * TETRAHEDRON, axis=0))
    assert np.frombuffer(base64.b64decode(meshes.data[0]["faces"]), "<u4").shape == (12,)


def test_a_part_without_a_colour_has_that_of_the_body_and_one_that_is_clear_is_left_out():
    parts = (Part("sphere", 1), Part("sphere", 1, color="#123456", opacity=0.5), Part("sphere", 1, opacity=0))
    data = parts_data(parts, "#abcdef", Meshes())
    assert [(row["color"], row["opacity"]) for row in data] == [("#abcdef", 1), ("#123456", 0.5)]


def test_the_placement_goes_column_by_column():
    (row,) = parts_data((Part("sphere", 1, placement((7, 8, 9), quarter=True)),), "#000000", Meshes())
    assert row["matrix"] == [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1]


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: Part("capsule", (1, 1)), "part, kind: found capsule; expected one of box, cylinder, sphere, mesh"),
        (lambda: Part("cylindre", (1, 1)), 'did you mean "cylinder"'),
        (lambda: Part("box", (1, 2)), "part, box, size: expected shape 3, found 2"),
        (lambda: Part("box", (1, 2, np.nan)), "part, box, size: the entry at .* is nan"),
        (lambda: Part("sphere", -1), "part, sphere, size: found -1; expected no negative number"),
        (lambda: Part("sphere", 1, np.eye(3)), "part, sphere, placement: expected shape 4 x 4, found 3 x 3"),
        (lambda: Part("sphere", 1, 2 * np.eye(4)), "found a matrix that is no rotation and shift"),
        (lambda: Part("sphere", 1, np.diag([1, 1, -1, 1])), "found a matrix that is no rotation and shift"),
        (lambda: Part("sphere", 1, color="red"), "part, sphere, color: found red; expected six hexadecimal digits"),
        (lambda: Part("sphere", 1, opacity=-0.1), "part, sphere, opacity: found -0.1; expected at least 0"),
        (lambda: Part("mesh", vertices=[[0, 0, np.inf]], faces=[]), "part, mesh, vertices: the entry at .* is inf"),
        (
            lambda: Part("mesh", vertices=TETRAHEDRON, faces=[[0, 1, 4]]),
            "found 4; expected numbers of vertices, whole and from 0 to 3",
        ),
        (lambda: Part("mesh", vertices=TETRAHEDRON, faces=[[0, 1, -1]]), "part, mesh, faces: found -1; expected numbers"),
        (lambda: Part("mesh", vertices=TETRAHEDRON, faces=[[0, 1, 1.5]]), "part, mesh, faces: found 1.5; expected numbers"),
        (lambda: Part("mesh", vertices=TETRAHEDRON, faces=[[0, 1]]), "part, mesh, faces: expected shape any x 3, found 1 x 2"),
    ],
)
def test_what_is_no_part_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
