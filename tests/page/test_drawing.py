"""Bodies, links and drawings: what they accept, and where bodies are."""

import numpy as np
import pytest

from mbconstrained.errors import InputError
from mbconstrained.page import Body, Drawing, Link


def test_an_empty_drawing_is_a_drawing():
    assert Drawing(()).coordinates == frozenset()


def test_positions_are_linear_in_the_coordinates():
    body = Body("b", rest=(1, 2, 3), moves={"x": (1, 0, 0), "y": (0, 0, 2)})
    drawing = Drawing((body,), scale=10)
    values = np.array([[0.0, 1.0], [0.0, 0.5]])
    assert drawing.positions(body, ("x", "y"), values).tolist() == [[1, 11], [2, 2], [3, 13]]


def test_only_bodies_with_something_to_say_are_named():
    assert [Body("n", shape).label for shape in ("box", "disc", "ground", "mark", "rail")] == ["n", "n", "", "", ""]
    assert Body("n", "ground", label="floor").label == "floor"


def test_a_link_has_the_same_offset_at_both_ends_unless_told_otherwise():
    assert Link("k", "spring", "a", "b", offset=(0, 0, 1)).end_offset == (0, 0, 1)
    assert Link("k", "spring", "a", "b", (0, 0, 1), (0, 0, 2)).end_offset == (0, 0, 2)


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: Body("b", "bx"), 'body "b", shape: found bx; expected one of box, .*did you mean "box"'),
        (lambda: Body("b", rest=(1, 2)), 'body "b", rest: expected shape 3, found 2'),
        (lambda: Body("b", moves={"x": (1, np.nan, 0)}), 'body "b", moves, "x": the entry at .* is nan'),
        (lambda: Body("b", size=(1, 0, 1)), 'body "b", size: found 0; expected numbers greater than zero'),
        (lambda: Body("b", color="red"), 'body "b", color: found red; expected six hexadecimal digits'),
        (lambda: Body("b", "gear", teeth=2), 'body "b", teeth: found 2; expected a whole number of at least 3'),
        (lambda: Link("k", "spirng", "a", "b"), 'link "k", kind: found spirng; .*did you mean "spring"'),
        (lambda: Drawing((Body("b"), Body("b"))), 'two bodies are named "b"'),
        (
            lambda: Drawing((Body("mass"),), (Link("k", "spring", "mass", "mas"),)),
            'link "k" is tied to "mas", which is no body; did you mean "mass"',
        ),
        (lambda: Drawing((), scale=np.inf), "drawing, scale: .* inf"),
    ],
)
def test_what_cannot_be_drawn_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_a_long_name_is_shortened_in_messages():
    with pytest.raises(InputError) as caught:
        Body("x" * 10_000, "nothing")
    assert len(str(caught.value)) < 250
