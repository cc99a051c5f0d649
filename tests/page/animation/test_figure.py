"""The data that the page's script draws: colours, ends of links, bounds of the motion."""

import numpy as np
import pytest

from mbconstrained.ground.errors import InputError
from mbconstrained.page.animation import Animation, key_frames
from mbconstrained.page.drawing import Drawing, DrawnBody, DrawnLink, Path, Solid
from mbconstrained.page.figure import figure_data


def figure(drawing, names=(), values=None):
    times = np.arange(np.shape(values)[1] if values is not None else 1.0)
    return figure_data(drawing, [key_frames(Animation(drawing, names, times, np.zeros((0, 1)) if values is None else values))])


def test_nothing_to_draw_still_has_bounds():
    assert figure(Drawing(()))["bounds"] == {"low": [-0.5] * 3, "high": [0.5] * 3}


def test_the_magnification_is_in_the_moves():
    body = DrawnBody("b", moves={"y": (1, 2, 3)}, turns={"x": (0, -1, 0)})
    data = figure(Drawing((body,), scale=10, turn_scale=3), ("x", "y"), [[0], [0]])["bodies"][0]
    assert data["moves"] == [[1, 10, 20, 30]]
    assert data["turns"] == [[0, 0, -3, 0]]


def test_links_end_on_the_sides_that_face_each_other():
    drawing = Drawing((DrawnBody("a"), DrawnBody("b", rest=(3, 0, 0))), (DrawnLink("k", "spring", "a", "b", (0, 0, 0.2)),))
    link = figure(drawing)["links"][0]
    assert link["start_point"] == pytest.approx([0.4, 0, 0.2])
    assert link["end_point"] == pytest.approx([-0.4, 0, 0.2])
    assert link["mean"] == pytest.approx(3 - 0.8)


def test_the_sides_are_those_of_the_motion_not_of_the_zero_of_the_coordinates():
    # drawn at x = 5 and x = 2, although both are at 0 where the coordinates are 0
    bodies = (DrawnBody("a", moves={"x": (1, 0, 0)}), DrawnBody("b", moves={"y": (1, 0, 0)}))
    link = figure(Drawing(bodies, (DrawnLink("k", "spring", "a", "b"),)), ("x", "y"), [[5, 5], [2, 2.5]])["links"][0]
    assert (link["start_point"][0], link["end_point"][0]) == pytest.approx((-0.4, 0.4))
    assert (link["shortest"], link["longest"]) == pytest.approx((1.7, 2.2))


def test_an_end_outside_its_body_stands_on_a_post():
    drawing = Drawing(
        (DrawnBody("a"), DrawnBody("b", rest=(3, 0, 0))), (DrawnLink("k", "spring", "a", "b", (0, 0, 1.5), (0, 0, 0.1)),)
    )
    data = figure(drawing)
    assert [body["posts"] for body in data["bodies"]] == [[[0, 0, 1.5]], []]


def test_bounds_hold_the_whole_motion():
    drawing = Drawing((DrawnBody("b", moves={"x": (1, 0, 0)}),), scale=2)
    assert figure(drawing, ("x",), [[-1, 0, 3]])["bounds"] == {"low": [-2.4, -0.4, -0.4], "high": [6.4, 0.4, 0.4]}


def test_a_body_has_the_colour_of_its_own_curve_unless_it_brings_one():
    bodies = [DrawnBody(name, rest=(i, 0, 0), moves={name: (1, 0, 0)}) for i, name in enumerate("xyz")]
    bodies.append(DrawnBody("own", color="#123456"))
    colors = [body["color"] for body in figure(Drawing(tuple(bodies)), tuple("xyz"), np.zeros((3, 1)))["bodies"]]
    assert len(set(colors)) == 4
    assert colors[3] == "#123456"


def test_motion_too_large_to_be_seen_is_refused():
    drawing = Drawing((DrawnBody("rocket", moves={"x": (1, 0, 0)}),))
    with pytest.raises(InputError, match=r'body "rocket" is drawn up to 1e\+200 units away.*a smaller scale, or ask for earlier'):
        figure(drawing, ("x",), [[0, 1e200]])


def test_an_end_that_is_fixed_in_its_body_turns_with_it():
    path = Path(np.zeros((3, 2)), [[0, 0], [0, 0], [0, 0.5**0.5], [1, 0.5**0.5]])  # a quarter turn about z
    bodies = (DrawnBody("a", "solids", solids=(Solid("sphere", (1,)),), path=path), DrawnBody("b", rest=(0, 3, 0)))
    link = DrawnLink("k", "spring", "a", "b", start_point=(1, 0, 0), end_point=(0, 0, 0))
    data = figure(Drawing(bodies, (link,)), ("x",), [[0, 0]])
    (found,) = data["links"]
    assert (found["start_turns"], found["end_turns"]) == (True, True)
    assert (found["longest"] * data["unit"], found["shortest"] * data["unit"]) == pytest.approx((10**0.5, 2.0))


@pytest.mark.parametrize(
    "size, yaw, pitch", [((4, 4, 0.2), 0.3, 1.0), ((4, 0.2, 4), 0.3, 0.25), ((0.2, 4, 4), 1.25, 0.25), ((4, 4, 4), 0.6, 0.36)]
)
def test_what_is_flat_is_seen_from_its_broad_side(size, yaw, pitch):
    assert figure(Drawing((DrawnBody("b", "solids", solids=(Solid("box", size),)),)))["view"] == {"yaw": yaw, "pitch": pitch}


def test_a_path_too_far_away_to_be_seen_is_refused():
    far = Path([[0, 1e15], [0, 0], [0, 0]], np.ones((4, 2)))
    bodies = (DrawnBody("rocket", "solids", solids=(Solid("sphere", (1,)),), path=far),)
    with pytest.raises(InputError, match='body "rocket" is drawn up to .* units away'):
        figure(Drawing(bodies), ("x",), [[0, 0]])


def test_a_turned_drawing_is_bounded_as_it_is_seen():
    boxes = (DrawnBody("a"), DrawnBody("b", rest=(10, 0, 0)))
    turned = figure(Drawing(boxes, turn=(0, -np.pi / 4, 0)))
    reach, half = 10 * 0.5**0.5, 0.4 * 2**0.5
    assert turned["bounds"]["low"] == pytest.approx([-half, -0.4, -half])
    assert turned["bounds"]["high"] == pytest.approx([reach + half, 0.4, reach + half])
    assert turned["turn"] == pytest.approx([0, -np.sin(np.pi / 8), 0, np.cos(np.pi / 8)])
