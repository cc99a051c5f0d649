"""A building stands upright: slabs one above the other, columns that stay on their slabs, braces for dampers."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.page.automatic_drawing import lumped_drawing
from tests.scene.scenes import scene_of

NAMES = ["floor 1", "floor 2", "roof"]


def building(names=NAMES) -> mb.LumpedModel:
    model = mb.LumpedModel()
    for name, low in zip(names, ["ground", *names]):
        model.mass(name, 2.0)
        model.spring(low, name, 4.0)
    model.damper(names[1], names[2], 1.0)
    return model


def heights(drawing) -> dict[str, float]:
    return {body.name: body.rest[2] for body in drawing.bodies}


def test_storeys_are_known_by_their_names_and_move_sideways():
    drawing = lumped_drawing(building().elements, NAMES, np.ones((3, 2)))
    height = heights(drawing)
    assert [*height] == ["ground", *NAMES] and list(height.values()) == sorted(height.values())
    slabs = [body for body in drawing.bodies if body.name in NAMES]
    assert all(body.moves == {body.name: (1.0, 0.0, 0.0)} for body in slabs)
    assert len({body.rest[0] for body in slabs}) == 1
    columns = [link for link in drawing.links if link.kind == "rod"]
    assert len(columns) == 6 and [link.kind for link in drawing.links if link not in columns] == ["damper"]
    for link in drawing.links:  # an end lies on the face of its slab
        for end, point, face in ((link.start, link.start_point, 1), (link.end, link.end_point, -1)):
            body = next(body for body in drawing.bodies if body.name == end)
            assert abs(point[0]) < body.size[0] / 2 and point[2] == pytest.approx(face * body.size[2] / 2)
    assert not drawing.note


def test_storeys_stand_on_the_soil_that_moves_them():
    model = mb.LumpedModel()
    names = ["roof", "first floor", "second floor", "soil"]
    for name in names[:3]:
        model.mass(name, 2.0)
    model.node("soil")
    for low, high in (("soil", "first floor"), ("first floor", "second floor"), ("second floor", "roof")):
        model.spring(low, high, 4.0)
    drawing = lumped_drawing(model.elements, model.coordinates, np.ones((4, 2)))
    height = heights(drawing)
    assert sorted(height, key=height.get) == ["soil", "first floor", "second floor", "roof"]
    soil, *slabs = sorted(drawing.bodies, key=lambda body: body.rest[2])
    assert soil.moves == {"soil": (1.0, 0.0, 0.0)} and soil.size[0] > slabs[0].size[0]
    for link in drawing.links:
        low = next(body for body in drawing.bodies if body.name == link.start)
        assert link.start_point[2] == pytest.approx(low.size[2] / 2) and link.kind == "rod"


def test_a_scene_requests_it(tmp_path):
    scene = """[model]
kind = "matrices"
coordinates = ["a", "b"]
mass = [[1, 0], [0, 1]]
stiffness = [[2, -1], [-1, 1]]
[initial]
displacement = { a = 1 }
[time]
end = 1
points = 3
[drawing]
stack = "vertical"
"""
    drawing = scene_of(tmp_path, scene).run().animation.drawing
    assert [body.shape for body in drawing.bodies] == ["base", "box", "box"]
    with pytest.raises(mb.SceneError, match="stack is for the automatic drawing"):
        scene_of(tmp_path, scene + '[[drawing.body]]\nname = "a"\nshape = "box"\n')
