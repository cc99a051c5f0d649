"""The content of a page: arrays are checked where they enter."""

import numpy as np
import pytest

from mbconstrained.ground.display import TextTable
from mbconstrained.ground.errors import InputError
from mbconstrained.page.animation import Animation
from mbconstrained.page.content import Curve, Plot
from mbconstrained.page.drawing import Drawing

EMPTY = Drawing(())


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: Animation(EMPTY, ("x",), [0, 1], [[0, np.nan]]), "animation, values: the entry at .* is nan"),
        (lambda: Animation(EMPTY, ("x",), [0, 1], [[0, 1, 2]]), "animation, values: expected shape 1 x 2, found 1 x 3"),
        (lambda: Animation(EMPTY, ("x", "y"), [0, 1], [[0, 1]]), "animation, values: expected shape 2 x 2, found 1 x 2"),
        (lambda: Animation(EMPTY, ("x",), [0, 1], [[0, 1]], [[0]]), "animation, rates: expected shape 1 x 2, found 1 x 1"),
        (lambda: Animation(EMPTY, ("x",), [0, 1], [[0, 1e300]]), "found 1e.300, which is too large to draw; give an earlier end"),
        (lambda: Animation(EMPTY, (), [], np.zeros((0, 0))), "animation, times: no times found"),
        (lambda: Plot("p", "m", [0, 2, 1], ()), 'plot "p", times: 2 s is followed by 1 s; times must ascend'),
        (lambda: Plot("p", "m", [0, 0], ()), "0 s is followed by 0 s"),
        (lambda: Plot("p", "m", [0, 1], (Curve("c", [0, np.inf]),)), 'plot "p", curve "c": the entry at .* is inf'),
        (lambda: Plot("p", "m", [0, 1], (Curve("c", [0]),)), 'plot "p", curve "c": expected shape 2, found 1'),
        (lambda: TextTable("t", ("a", "b"), (("1", "2"), ("1",))), 'table "t": row 2 has 1 entries for 2 columns'),
    ],
)
def test_what_cannot_be_shown_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
