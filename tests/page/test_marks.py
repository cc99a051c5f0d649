"""Arrows, jumps and impulses as data of the page: only where there are any, in the frame of the bodies, sized by unit."""

import numpy as np
import pytest

from mbconstrained.errors import InputError
from mbconstrained.page import Animation, Body, Drawing, PageContent, Path, page_html
from mbconstrained.page.document import script_json
from mbconstrained.page.html import _figure, _frames
from mbconstrained.page.marks import Arrow, LastingForce, Marks, Moment, arrow_at
from mbconstrained.page.marks_data import LONGEST, told_scale

TIMES = np.array([0.0, 1.0, 2.0])
BODIES = (Body("cart", moves={"x": (0, 0, 2)}), Body("wheel", rest=(3, 0, 0), turns={"w": (0, -1, 0)}))
PUSH = Arrow("cart", (0, 0, 2), "N s")
JUMP = Moment(0.0, ("x jumps from -0.5 m/s^2",), np.array([0.5, 0.0]), np.array([0.0, 0.0]), ((PUSH, -4.0, "4 N s"),))


def animation(**marks) -> Animation:
    values = np.array([[0.0, 1.0, 0.0], [0.0, 0.2, 0.4]])
    return Animation(Drawing(BODIES, scale=3.0), ("x", "w"), TIMES, values, np.zeros((2, 3)), Marks(**marks))


def figure(given: Animation) -> dict:
    return _figure(given, _frames(given))


def test_a_motion_without_marks_has_no_trace_of_them():
    page = page_html(PageContent("plain", animation=animation()))
    assert "marks" not in figure(animation()) and "class Marks" not in page
    assert "class Marks" in page_html(PageContent("marked", animation=animation(moments=(JUMP,))))


def test_a_body_that_jumps_is_drawn_where_it_was_and_no_other():
    (moment,) = figure(animation(moments=(JUMP,)))["marks"]["moments"]
    assert moment["ghosts"] == [[0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0]]  # 0.5 m, 2 units a metre, 3 times as large
    assert moment["told"] == ["x jumps from −0.5 m/s²"]


def test_what_a_body_was_before_belongs_to_the_picture():
    far = Moment(1.0, ("far",), np.array([10.0, 0.0]), np.array([0.0, 0.0]))
    assert figure(animation(moments=(far,)))["bounds"]["high"][2] > 60 > figure(animation())["bounds"]["high"][2]


def test_a_body_with_a_path_was_where_its_own_path_says():
    turned = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    link = Body("link", path=Path(np.zeros((3, 1)), [[0], [0], [0], [1]]))
    before = Moment(0.0, ("now",), np.array([0.0]), np.array([0.0]), paths={"link": Path([[1, 0], [0, 0], [0, 0]], turned)})
    given = Animation(Drawing((link,)), ("x",), TIMES, np.zeros((1, 3)), marks=Marks((before,)))
    assert figure(given)["marks"]["moments"][0]["ghosts"] == [[0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]]


def test_the_largest_impulse_of_a_unit_has_the_longest_arrow():
    small = Moment(
        1.0,
        ("small",),
        np.zeros(2),
        np.zeros(2),
        ((PUSH, 1.0, "1 N s"), (Arrow("wheel", (0, -1, 0), "N m s", True), 9.0, "9 N m s")),
    )
    strikes = [strike for moment in figure(animation(moments=(JUMP, small)))["marks"]["moments"] for strike in moment["strikes"]]
    assert [abs(strike["size"]) * strike["length"] for strike in strikes] == pytest.approx([LONGEST, LONGEST / 4, LONGEST])
    assert [strike["direction"] for strike in strikes] == [[0, 0, 1], [0, 0, 1], [0, -1, 0]]


def test_forces_move_with_the_coordinates_of_the_model_and_behind_them():
    force = LastingForce(
        "link",
        np.array([0.0, -5.0, 2.0]),
        np.zeros(3),
        ((Arrow("cart", (1, 0, 0), "N"), 1.0), (Arrow("wheel", (0, 1, 0), "N m"), -3.0)),
    )
    given = animation(forces=(force,))
    assert _frames(given).names == ("x", "w", "force: link")
    assert _frames(given).values[2].tolist() == [0.0, -5.0, 2.0]
    arrows = figure(given)["marks"]["forces"][0]["arrows"]
    assert [arrow["factor"] for arrow in arrows] == [1.0, -3.0]
    assert [5 * abs(arrow["factor"]) * arrow["length"] for arrow in arrows] == pytest.approx([LONGEST, LONGEST])
    assert told_scale((force,)) == "longest arrow 5 N or 15 N m"
    assert "arrows: reactions, longest arrow 5 N or 15 N m" in page_html(PageContent("forces", animation=given))


def turning_hook() -> tuple[Body, np.ndarray]:
    """A link that goes round once about z in two seconds, and a force along its own x at a point of it."""
    angles = np.pi * TIMES
    still = np.zeros(3)
    path = Path(np.zeros((3, 3)), [still, still, np.sin(angles / 2), np.cos(angles / 2)])
    return Body("hook", path=path), np.array([[1.0, 3.0, 2.0], still, still])


def test_a_force_in_the_frame_of_a_body_has_three_rows_and_no_direction():
    hook, values = turning_hook()
    force = LastingForce("pin", values, 0 * values, ((Arrow("hook", None, "N", point=(0, 2, 0)), 1.0),))
    given = Animation(Drawing((hook,)), ("x",), TIMES, np.zeros((1, 3)), np.zeros((1, 3)), Marks((), (force,), "reactions on hook"))
    assert _frames(given).names == ("x", "force: pin x", "force: pin y", "force: pin z")
    (drawn,) = figure(given)["marks"]["forces"]
    assert drawn["rows"] == 3 and drawn["arrows"][0]["direction"] is None and drawn["arrows"][0]["point"] == [0, 2, 0]
    assert drawn["arrows"][0]["length"] == pytest.approx(LONGEST / 3)
    assert "arrows: reactions on hook, longest arrow 3 N" in page_html(PageContent("t", animation=given))


def test_the_picture_has_room_for_the_tips_of_all_arrows():
    hook, values = turning_hook()
    force = LastingForce("pin", values, 0 * values, ((Arrow("hook", None, "N", point=(0, 2, 0)), 1.0),))
    blow = Moment(2.0, ("t",), np.zeros(1), np.zeros(1), ((Arrow("hook", (0, 0, -1), "N s"), 7.0, "7 N s"),))
    given = Animation(Drawing((hook,)), ("x",), TIMES, np.zeros((1, 3)), np.zeros((1, 3)), Marks((blow,), (force,)))
    bounds, plain = figure(given)["bounds"], figure(Animation(Drawing((hook,)), ("x",), TIMES, np.zeros((1, 3))))["bounds"]
    assert bounds["low"] == pytest.approx([-LONGEST, -2.0, -LONGEST])  # half way round it is longest, and points back
    assert bounds["high"] == pytest.approx([2 * LONGEST / 3, 2.0, plain["high"][2]])


def test_forces_that_never_act_are_no_trouble():
    force = LastingForce("idle", np.zeros(3), np.zeros(3), ((Arrow("cart", (1, 0, 0), "N"), 1.0),))
    assert told_scale((force,)) == ""
    assert script_json(figure(animation(forces=(force,)))["marks"])


def test_an_arrow_at_a_body_that_is_not_drawn_is_refused():
    lost = Moment(0.0, ("lost",), np.zeros(2), np.zeros(2), ((Arrow("carts", (1, 0, 0), "N s"), 1.0, "1 N s"),))
    with pytest.raises(InputError, match='arrow: "carts" is no body.*cart'):
        figure(animation(moments=(lost,)))


def test_a_force_along_a_coordinate_acts_on_the_body_that_it_moves_alone():
    both = Body("hook", moves={"x": (1, 0, 0), "y": (1, 0, 0)})
    drawing = Drawing((both, *BODIES))
    assert arrow_at(drawing, "x", "N") == Arrow("cart", (0.0, 0.0, 2.0), "N")
    assert arrow_at(drawing, "y", "N").body == "hook"
    assert arrow_at(drawing, "w", "N m").turns and arrow_at(drawing, "z", "N") is None
