"""Arrows, jumps and impulses as data of the page: only where there are any, in the frame of the bodies, sized by unit."""

import numpy as np
import pytest

from mbconstrained.page.animation import Animation, Arrow, DrawnEvent, ForceArrows, ImpulseArrow, Overlay, arrow_at, key_frames
from mbconstrained.page.content import PageContent
from mbconstrained.page.drawing import Drawing, DrawnBody, Path
from mbconstrained.page.figure import LONGEST, figure_data, force_scale
from mbconstrained.page.html import page_html

TIMES = np.array([0.0, 1.0, 2.0])
BODIES = (DrawnBody("cart", moves={"x": (0, 0, 2)}), DrawnBody("wheel", rest=(3, 0, 0), turns={"w": (0, -1, 0)}))
PUSH = Arrow("cart", (0, 0, 2), "N s")
JUMP = DrawnEvent(
    0.0, ("x jumps from -0.5 m/s^2",), np.array([0.5, 0.0]), np.array([0.0, 0.0]), (ImpulseArrow(PUSH, -4.0, "4 N s"),)
)


def animation(**overlay) -> Animation:
    values = np.array([[0.0, 1.0, 0.0], [0.0, 0.2, 0.4]])
    return Animation(Drawing(BODIES, scale=3.0), ("x", "w"), TIMES, values, np.zeros((2, 3)), Overlay(**overlay))


def figure(given: Animation) -> dict:
    return figure_data(given.drawing, [key_frames(given)], given.overlay)


def test_a_motion_without_marks_has_no_trace_of_them():
    page = page_html(PageContent("plain", animation=animation()))
    assert "overlay" not in figure(animation()) and "class Overlay" not in page
    assert "class Overlay" in page_html(PageContent("marked", animation=animation(events=(JUMP,))))


def test_a_body_that_jumps_is_drawn_where_it_was_and_no_other():
    (event,) = figure(animation(events=(JUMP,)))["overlay"]["events"]
    assert event["ghosts"] == [[0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0]]  # 0.5 m, 2 units a metre, 3 times as large
    assert event["lines"] == ["x jumps from −0.5 m/s²"]


def test_what_a_body_was_before_belongs_to_the_picture():
    far = DrawnEvent(1.0, ("far",), np.array([10.0, 0.0]), np.array([0.0, 0.0]))
    assert figure(animation(events=(far,)))["bounds"]["high"][2] > 60 > figure(animation())["bounds"]["high"][2]


def test_a_body_with_a_path_was_where_its_own_path_says():
    turned = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    link = DrawnBody("link", path=Path(np.zeros((3, 1)), [[0], [0], [0], [1]]))
    before = DrawnEvent(0.0, ("now",), np.array([0.0]), np.array([0.0]), paths={"link": Path([[1, 0], [0, 0], [0, 0]], turned)})
    given = Animation(Drawing((link,)), ("x",), TIMES, np.zeros((1, 3)), overlay=Overlay((before,)))
    assert figure(given)["overlay"]["events"][0]["ghosts"] == [[0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]]


def test_the_largest_impulse_of_a_unit_has_the_longest_arrow():
    small = DrawnEvent(
        1.0,
        ("small",),
        np.zeros(2),
        np.zeros(2),
        (ImpulseArrow(PUSH, 1.0, "1 N s"), ImpulseArrow(Arrow("wheel", (0, -1, 0), "N m s", True), 9.0, "9 N m s")),
    )
    impulses = [impulse for event in figure(animation(events=(JUMP, small)))["overlay"]["events"] for impulse in event["impulses"]]
    assert [abs(impulse["size"]) * impulse["length"] for impulse in impulses] == pytest.approx([LONGEST, LONGEST / 4, LONGEST])
    assert [impulse["direction"] for impulse in impulses] == [[0, 0, 1], [0, 0, 1], [0, -1, 0]]


def test_forces_move_with_the_coordinates_of_the_model_and_behind_them():
    force = ForceArrows(
        "link",
        np.array([0.0, -5.0, 2.0]),
        np.zeros(3),
        ((Arrow("cart", (1, 0, 0), "N"), 1.0), (Arrow("wheel", (0, 1, 0), "N m"), -3.0)),
    )
    given = animation(forces=(force,))
    assert key_frames(given).names == ("x", "w", "force: link")
    assert key_frames(given).values[2].tolist() == [0.0, -5.0, 2.0]
    arrows = figure(given)["overlay"]["forces"][0]["arrows"]
    assert [arrow["factor"] for arrow in arrows] == [1.0, -3.0]
    assert [5 * abs(arrow["factor"]) * arrow["length"] for arrow in arrows] == pytest.approx([LONGEST, LONGEST])
    assert force_scale((force,)) == "longest arrow 5 N or 15 N m"
    assert "arrows: reactions, longest arrow 5 N or 15 N m" in page_html(PageContent("forces", animation=given))


def turning_hook() -> tuple[DrawnBody, np.ndarray]:
    """A link that goes round once about z in two seconds, and a force along its own x at a point of it."""
    angles = np.pi * TIMES
    still = np.zeros(3)
    path = Path(np.zeros((3, 3)), [still, still, np.sin(angles / 2), np.cos(angles / 2)])
    return DrawnBody("hook", path=path), np.array([[1.0, 3.0, 2.0], still, still])


def test_a_force_in_the_frame_of_a_body_has_three_rows_and_no_direction():
    hook, values = turning_hook()
    force = ForceArrows("pin", values, 0 * values, ((Arrow("hook", None, "N", point=(0, 2, 0)), 1.0),))
    given = Animation(
        Drawing((hook,)), ("x",), TIMES, np.zeros((1, 3)), np.zeros((1, 3)), Overlay((), (force,), "reactions on hook")
    )
    assert key_frames(given).names == ("x", "force: pin x", "force: pin y", "force: pin z")
    (drawn,) = figure(given)["overlay"]["forces"]
    assert drawn["rows"] == 3 and drawn["arrows"][0]["direction"] is None and drawn["arrows"][0]["point"] == [0, 2, 0]
    assert drawn["arrows"][0]["length"] == pytest.approx(LONGEST / 3)
    assert "arrows: reactions on hook, longest arrow 3 N" in page_html(PageContent("t", animation=given))


def test_a_force_along_a_coordinate_acts_on_the_body_that_it_moves_alone():
    both = DrawnBody("hook", moves={"x": (1, 0, 0), "y": (1, 0, 0)})
    drawing = Drawing((both, *BODIES))
    assert arrow_at(drawing, "x", "N") == Arrow("cart", (0.0, 0.0, 2.0), "N")
    assert arrow_at(drawing, "y", "N").body == "hook"
    assert arrow_at(drawing, "w", "N m").turns and arrow_at(drawing, "z", "N") is None
