"""[drawing]: what it changes in the drawing that is made anyway, what it replaces, and what it may not say."""

import math
import re

import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.page.drawing import View, matrix_of
from mbconstrained.scene.run.drawing import ShapeDrawing
from tests.scene.robots import SCENE, press
from tests.scene.scenes import COEFFICIENTS, MATRICES, OSCILLATOR, scene_of

CART = '[[drawing.body]]\nname = "cart"\n'
LINK = '[[drawing.link]]\nkind = "rod"\nstart = "cart"\nend = "hok"\n'
FALLING = OSCILLATOR.replace('kind = "lumped"', 'kind = "lumped"\ngravity = -9.81')
CHANGED = f"""
[drawing]
automatic = true
scale = 1
note = "true to scale"
{CART}color = "#aa3377"
label = "the cart"
shape = "sphere"
"""


def drawing_of(folder, text, model=OSCILLATOR):
    return scene_of(folder, f"{model}\n{text}").run().animation.drawing


def body(drawing, name):
    return next(body for body in drawing.bodies if body.name == name)


def test_what_is_not_said_stays_automatic(tmp_path):
    plain = drawing_of(tmp_path, "")
    assert drawing_of(tmp_path, "[drawing]\n") == plain and plain.scale > 1
    changed = drawing_of(tmp_path, CHANGED)
    assert (changed.scale, changed.note, len(changed.bodies)) == (1.0, "true to scale", len(plain.bodies))
    cart = body(changed, "cart")
    assert (cart.color, cart.label, cart.shape) == ("#aa3377", "the cart", "sphere")
    assert changed.links == plain.links and cart.moves == body(plain, "cart").moves


def test_bodies_with_shapes_are_the_whole_drawing_unless_they_are_added(tmp_path):
    text = '[drawing]\n[[drawing.body]]\nname = "load"\nshape = "box"\nmoves = { cart = [0, 0, 1] }\n'
    assert [body.name for body in drawing_of(tmp_path, text).bodies] == ["load"]
    added = drawing_of(tmp_path, text.replace("[drawing]\n", "[drawing]\nautomatic = true\n", 1))
    assert {"cart", "load"} <= {body.name for body in added.bodies}


def test_a_link_may_be_added_between_bodies_that_are_drawn_anyway(tmp_path):
    hook = '[[drawing.body]]\nname = "hook"\nshape = "mark"\n[[drawing.link]]\nkind = "rod"\nstart = "cart"\nend = "hook"\n'
    text = f"[drawing]\nautomatic = true\n{CART}{hook}"
    assert drawing_of(tmp_path, text).links[-1].name == "rod from cart to hook"


@pytest.mark.parametrize(
    ("text", "view"),
    [
        ('"top"', View(0.0, math.pi / 2)),
        ('"left"', View(-math.pi / 2, 0.0)),
        ('{ yaw = "30 deg", pitch = 0.5, zoom = 2 }', View(math.pi / 6, 0.5, 2.0)),
    ],
)
def test_the_view_is_a_word_or_angles(tmp_path, text, view):
    found = drawing_of(tmp_path, f"[drawing]\nview = {text}\n").view
    assert (found.yaw, found.pitch, found.zoom) == pytest.approx((view.yaw, view.pitch, view.zoom))
    press(tmp_path)
    assert drawing_of(tmp_path, f"[drawing]\nview = {text}\n", SCENE).view == found


def test_displacements_go_along_what_is_asked_for_and_up_where_there_is_gravity(tmp_path):
    up = (0.0, -math.pi / 2, 0.0)
    assert drawing_of(tmp_path, "").turn == (0.0, 0.0, 0.0)
    assert drawing_of(tmp_path, "[drawing]\nalong = [0, 0, 2]\n").turn == pytest.approx(up)
    assert drawing_of(tmp_path, "", FALLING).turn == pytest.approx(up)
    assert drawing_of(tmp_path, "[drawing]\nalong = [1, 0, 0]\n", FALLING).turn == (0.0, 0.0, 0.0)
    assert ShapeDrawing(scene_of(tmp_path, FALLING), []).drawing.turn == pytest.approx(up)


def test_one_body_goes_along_what_it_says_itself_in_space(tmp_path):
    own = f"{CART}along = [0, 2, 0]\n"
    for text, model in (("", OSCILLATOR), ("[drawing]\nalong = [0, 0, 1]\n", OSCILLATOR), ("", FALLING)):
        scene = scene_of(tmp_path, f"{model}\n{text}{own}")
        for drawing in (scene.run().animation.drawing, ShapeDrawing(scene, []).drawing):
            assert matrix_of(drawing.turn) @ body(drawing, "cart").moves["cart"] == pytest.approx((0, 1, 0), abs=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('view = "fornt"', 'view: found "fornt"; expected front, back, right, left, top or '),
        ("view = { yaw = 30 }", 'write degrees as "30 deg"'),
        ("along = [0, 0, 0]", "along is [0, 0, 0]; give a direction"),
        ("along = [1, 0, 0]\nabout = [1, 1, 0]", "not at right angles"),
        ('along = [1, 0, 0]\n[[drawing.body]]\nname = "cart"\nshape = "box"', "along and about turn the automatic drawing"),
        (f"{CART}along = [0, 0, 0]", 'body[1] (of "cart"): along is [0, 0, 0]; give a direction'),
        (f"{CART}about = [0, 0, 1]", 'body[1] (of "cart"): it has about, but it is displaced: say along'),
        (f"{CART}along = [1, 0, 0]\nabout = [0, 0, 1]", "along is for a body that is displaced"),
        (f"{CART}along = [0, 0, 1]\nmoves = {{ cart = [1, 0, 0] }}", "along, and moves or turns, say the same thing"),
        (f'{CART}shape = "box"\nalong = [0, 0, 1]', "along and about turn the automatic drawing"),
        ('[[drawing.body]]\nname = "ground left of cart"\nalong = [0, 0, 1]', "has along, but it stays"),
        ('automatic = true\n[[drawing.body]]\nname = "new"\nshape = "box"\nalong = [0, 0, 1]', "moves and turns state the motion"),
        ('automatic = false\n[[drawing.body]]\nname = "cart"', "it has no shape"),
        ('[[drawing.body]]\nname = "crat"', 'body[1] (of "crat"): there is no such body'),
        (f"automatic = true\n{CART}{LINK}", 'link[1]: there is no body "hok" in the drawing'),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path, text, message):
    """When the scene is read: before anything is solved, and without a page."""
    for output in ("", "[output]\npage = false\n"):
        with pytest.raises(SceneError, match=rf"(?s)scene\.toml: drawing.*{re.escape(message)}"):
            scene_of(tmp_path, f"{OSCILLATOR}{output}\n[drawing]\n{text}\n")


@pytest.mark.parametrize(("model", "body"), [(MATRICES, "a"), (COEFFICIENTS, "q")])
def test_so_it_is_of_what_is_drawn_from_its_coordinates(tmp_path, model, body):
    wrong, right = ("about", "along") if body == "a" else ("along", "about")
    text = f'{model}[[drawing.body]]\nname = "{body}"\n'
    assert scene_of(tmp_path, f"{text}{right} = [0, 1, 1]\n").run().animation
    with pytest.raises(SceneError, match=rf'drawing\.body\[1\] \(of "{body}"\): it has {wrong}, .*: say {right}'):
        scene_of(tmp_path, f"{text}{wrong} = [0, 1, 1]\n")


@pytest.mark.parametrize("text", ['[[drawing.body]]\nname = "crank"\n', "along = [0, 0, 1]\n", "about = [0, 0, 1]\n"])
def test_a_robot_is_drawn_from_its_urdf(tmp_path, text):
    press(tmp_path)
    with pytest.raises(SceneError, match="drawing: a robot"):
        scene_of(tmp_path, f"{SCENE}\n[drawing]\n{text}")


def test_states_are_no_places_even_with_a_view(tmp_path):
    model = '[model]\nkind = "transfer-function"\nnumerator = [1]\ndenominator = [1, 1]\ngamma = 1\n'
    text = f'{model}[time]\nend = 1\n[drawing]\nview = "top"\n'
    scene = scene_of(tmp_path, text)
    assert next(stage for stage in scene.plan().stages if stage.name == "animation").reason.startswith(
        "states and outputs have no geometry"
    )
    assert scene_of(tmp_path, MATRICES).run().animation.drawing.view is None
