"""Drawings made from the elements of a model: everything is there, nothing overlaps, motion is to scale."""

from itertools import combinations

import numpy as np
import pytest

from mbconstrained.models.lumped import LumpedModel
from mbconstrained.page.animation import Animation, key_frames
from mbconstrained.page.automatic_drawing import coordinate_drawing, lumped_drawing
from mbconstrained.page.drawing import quaternions_of, rotated
from mbconstrained.page.layout import turn_to
from tests.page.contents import positions
from tests.page.models import gallery

TIMES = np.linspace(0, 10, 51)
GALLERY = gallery()
models = pytest.mark.parametrize("animation", GALLERY.values(), ids=GALLERY.keys())


def coordinates_of(drawing) -> list[str]:
    """Names of the coordinates that move a body."""
    return [name for body in drawing.bodies for name in (*body.moves, *body.turns)]


def chain(count: int, *, both_ends: bool = False) -> LumpedModel:
    model = LumpedModel()
    for i in range(count):
        model.mass(f"m{i}", 1.0)
        model.spring("ground" if i == 0 else f"m{i - 1}", f"m{i}", 1.0)
    if both_ends:
        model.spring(f"m{count - 1}", "ground", 1.0)
    return model


def places(drawing) -> dict:
    return {body.name: np.array(body.rest) for body in drawing.bodies}


def test_no_elements_make_an_empty_drawing():
    assert lumped_drawing((), ()).bodies == ()


@pytest.mark.parametrize("count", [1, 2, 3, 15])
def test_a_chain_stands_in_its_order_with_room_between(count):
    drawing = lumped_drawing(chain(count).elements, [f"m{i}" for i in range(count)])
    x = [places(drawing)[f"m{i}"][0] for i in range(count)]
    assert (np.diff([0.1, *x]) > 1.2).all()
    assert sum(body.shape == "ground" for body in drawing.bodies) == 1


TURNS = (((0, 0, 3), None), ((1, 2, 0), None), ((-1, 0, 0), None), (None, (1, 0, 0)), ((0, 1, 0), (1, 0, 0)), (None, (0, 1, 1e-9)))


@pytest.mark.parametrize(("along", "about"), TURNS)
def test_a_drawing_is_turned_so_that_it_moves_and_turns_as_asked(along, about):
    turn = quaternions_of(np.array(turn_to(along, about))[:, None])
    moved, axis = rotated(turn, np.array([[1.0, 0, 0], [0, -1, 0]]).T)[:, :, 0].T
    for found, wanted in ((moved, along), (axis, about)):
        assert wanted is None or found == pytest.approx(np.array(wanted) / np.linalg.norm(wanted), abs=1e-9)


@models
def test_every_body_is_drawn_and_everything_else_is_drawn_or_told(animation):
    drawing = animation.drawing
    assert set(animation.names) <= {body.name for body in drawing.bodies}
    assert {*coordinates_of(drawing)} == {*animation.names}


def test_what_no_link_can_show_is_told():
    assert GALLERY["machines"].drawing.note == "not drawn: sum"
    assert all(GALLERY[name].drawing.note == "" for name in ("series", "gears", "ropes"))


def test_every_connection_is_a_link():
    model = chain(2)
    model.damper("m0", "m1", 1.0)
    model.rigid_tie("m0", "m1")
    drawing = lumped_drawing(model.elements, model.coordinates)
    assert [(link.kind, link.start, link.end) for link in drawing.links] == [
        ("spring", "m0", "m1"),
        ("damper", "m0", "m1"),
        ("rod", "m0", "m1"),
        ("spring", "ground left of m0", "m0"),
    ]
    assert len({link.offset for link in drawing.links[:3]}) == 3  # side by side


@models
def test_bodies_do_not_run_into_each_other(animation):
    frames = key_frames(Animation(animation.drawing, animation.names, animation.times, animation.values))
    bodies = [body for body in animation.drawing.bodies if body.shape in ("box", "sphere")]
    tracks = [positions(animation.drawing, body, frames.names, frames.values) for body in bodies]
    for (one, a), (other, b) in combinations(zip(bodies, tracks), 2):
        room = (np.array(one.size) + np.array(other.size))[:, None] / 2
        assert (np.abs(a - b) >= room - 1e-9).any(axis=0).all(), (one.name, other.name)


def test_a_spring_is_drawn_longer_by_as_much_as_it_is_stretched():
    model = LumpedModel()
    for name in ("a", "b"):
        model.mass(name, 1.0)
    model.spring("ground", "a", 1.0, rest_length=2.0)
    model.spring("a", "b", 1.0, rest_length=3.0)
    values = np.array([[2.0, 2.1, 2.2], [5.0, 5.4, 5.1]])  # natural first, then stretched by 0.3 and -0.1
    drawing = lumped_drawing(model.elements, model.coordinates, values)
    a, b = (positions(drawing, body, model.coordinates, values)[0] for body in drawing.bodies if body.shape == "box")
    assert np.diff(b - a, prepend=(b - a)[0]) == pytest.approx(drawing.scale * np.array([0.0, 0.3, -0.4]))
    assert (b - a)[0] == pytest.approx(2.3)  # the layout's distance: a gap of 1.5 and twice half a body of 0.8


@pytest.mark.parametrize("size", [1e-9, 1e-3, 1.0, 1e6])
def test_motion_of_any_size_is_drawn_visibly(size):
    model = chain(2)
    values = size * np.array([np.sin(TIMES), -np.sin(TIMES)])
    drawing = lumped_drawing(model.elements, model.coordinates, values)
    assert 0.3 < drawing.scale * 2 * size <= 0.8


@pytest.mark.parametrize("values", [None, [0.0, 0.0], np.zeros((2, 5)), [1e-300, 0.0]])
def test_without_motion_nothing_is_magnified(values):
    model = chain(2)
    assert lumped_drawing(model.elements, model.coordinates, values).scale == 1.0


def test_small_angles_are_magnified_and_large_ones_are_not():
    model = LumpedModel()
    model.inertia("disc", 1.0)
    model.torsion_spring("ground", "disc", 1.0)
    scales = [lumped_drawing(model.elements, ["disc"], [angle]).turn_scale for angle in (0.007, 0.5, 100.0)]
    assert scales == [100.0, 1.0, 1.0]


def test_a_body_is_drawn_where_the_model_puts_it_in_line():
    model = LumpedModel()
    for name, position in (("right", 2.0), ("left", 0.0), ("middle", 1.0)):
        model.mass(name, 1.0, position)
    model.spring("left", "right", 1.0)
    model.spring("right", "middle", 1.0)
    x = places(lumped_drawing(model.elements, model.coordinates))
    assert x["left"][0] < x["middle"][0] < x["right"][0]


def test_a_relation_between_an_angle_and_a_place_is_told():
    model = LumpedModel()
    model.mass("cart", 1.0)
    model.inertia("wheel", 1.0)
    model.constrain({"cart": 1, "wheel": -1}, name="rolling")
    assert lumped_drawing(model.elements, model.coordinates).note == "not drawn: rolling"


def test_a_lever_turns_about_its_pivot():
    # the pivot stays on the line between the ends whatever they do within the lever's row
    animation = GALLERY["machines"]
    place = places(animation.drawing)
    pivot = next(place[name] for name in place if name.startswith("pivot"))
    for a in (-0.3, 0.7):
        ends = [place["a"] + (a, 0, 0), place["b"] - (a / 2, 0, 0)]  # x_a / 2 + x_b / 1 = 0
        assert np.cross(ends[0] - pivot, ends[1] - pivot) == pytest.approx(np.zeros(3))


@pytest.mark.parametrize("units", [("N",), ("1",), ()])
def test_nothing_is_drawn_of_what_has_no_place(units):
    drawing = coordinate_drawing(("f",)[: len(units)], None, units)
    assert (drawing.bodies, drawing.scale, drawing.turn_scale) == ((), 1.0, 1.0)


def test_a_body_that_only_supports_another_is_a_plate_below_it_as_long_as_their_relative_motion():
    model = LumpedModel()
    model.mass("block", 1.0), model.node("belt"), model.spring("ground", "block", 9.0)
    model.dry_friction("belt", "block", normal_force=10.0, coefficient=0.3, name="rub")
    drawing = lumped_drawing(model.elements, ["block", "belt"], [[0.0, 0.1], [0.0, 2.0]])
    block, belt = ({body.name: body for body in drawing.bodies}[name] for name in ("block", "belt"))
    assert belt.shape == "box" and belt.size[0] > 2 * 1.9 * drawing.scale
    assert block.rest[2] - belt.rest[2] == pytest.approx((block.size[2] + belt.size[2]) / 2 + 0.1) and belt.rest[0] == block.rest[0]
    assert [link.kind for link in drawing.links if link.name == "rub"] == ["pad"]
