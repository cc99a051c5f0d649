"""Bodies, links and drawings: what they accept, and where bodies are."""

import pytest

from mbconstrained.ground.errors import InputError
from mbconstrained.page.drawing import Drawing, DrawnBody, DrawnLink
from tests.page.contents import positions


def test_positions_are_linear_in_the_coordinates():
    body = DrawnBody("b", rest=(1, 2, 3), moves={"x": (1, 0, 0), "y": (0, 0, 2)})
    drawing = Drawing((body,), scale=10)
    assert positions(drawing, body, ("x", "y"), [[0.0, 1.0], [0.0, 0.5]]).tolist() == [[1, 11], [2, 2], [3, 13]]


def test_only_bodies_with_something_to_say_are_named():
    assert [DrawnBody("n", shape).label for shape in ("box", "disc", "ground", "mark", "rail")] == ["n", "n", "", "", ""]
    assert DrawnBody("n", "ground", label="floor").label == "floor"


def test_a_link_has_the_same_offset_at_both_ends_unless_told_otherwise():
    assert DrawnLink("k", "spring", "a", "b", offset=(0, 0, 1)).end_offset == (0, 0, 1)
    assert DrawnLink("k", "spring", "a", "b", (0, 0, 1), (0, 0, 2)).end_offset == (0, 0, 2)


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: DrawnBody("b", size=(1, 0, 1)), "size: found 0; expected numbers greater than zero"),
        (lambda: Drawing((DrawnBody("b"), DrawnBody("b"))), 'two bodies are named "b"'),
    ],
)
def test_what_cannot_be_drawn_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
