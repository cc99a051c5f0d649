"""Bodies, links and drawings: what they accept, and where bodies are."""

import pytest

from mbconstrained.ground.errors import InputError
from mbconstrained.page.drawing import Drawing, DrawnBody
from tests.page.contents import positions


def test_positions_are_linear_in_the_coordinates():
    body = DrawnBody("b", rest=(1, 2, 3), moves={"x": (1, 0, 0), "y": (0, 0, 2)})
    drawing = Drawing((body,), scale=10)
    assert positions(drawing, body, ("x", "y"), [[0.0, 1.0], [0.0, 0.5]]).tolist() == [[1, 11], [2, 2], [3, 13]]


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
