"""Pictures of digits: what is wrong is red, what was claimed can be compared with what is right, every point is there."""

import math

import numpy as np
import pytest

from mbconstrained.analyses.stability.point import Point
from mbconstrained.analyses.stability.stability import digit_plots, heat_map
from tests.analyses.pictures import drawn, texts
from tests.analyses.stability.points import point, sweep

pytestmark = pytest.mark.long  # pictures are drawn by Matplotlib one by one


FACTORS = 10.0 ** np.arange(-8, 9, 2)
CALM = sweep("calm", *map(point, FACTORS))
MIXED = sweep(
    "mixed",
    point(1e-2, 12.0, 13.0, 11.0),
    point(1e0, 8.0, 9.0, 8.5),
    point(1e2, 5.0, 8.0, 4.0, warnings=("a warning",)),
    point(1e4, 1.0, 8.0, 7.0),
    Point(1e6, refused="no"),
    Point(1e8, estimate=1.0, unknown="not known"),
)


def test_each_verdict_has_a_mark_of_its_own_at_its_place():
    (plot,) = digit_plots([MIXED])
    marks = {mark.name: (mark.shape, mark.points.tolist()) for mark in plot.marks}
    assert marks == {
        "with a warning": ("circle", [[1e2, pytest.approx(5.0)]]),
        "refused": ("diamond", [[1e6, 0.0]]),
        "not judged": ("diamond", [[1e8, 0.0]]),
        "wrong without a warning": ("cross", [[1e4, pytest.approx(1.0)]]),
    }
    assert plot.marks[0].texts == ("a warning",)
    right = plot.curves[0]
    assert right.drawn.tolist() == [True] * 4 + [False] * 2  # where there is no answer there is no curve


def test_nothing_measured_is_a_picture_that_says_so():
    assert list(digit_plots([])) == []
    empty = heat_map("a", [sweep("b")])
    assert texts(empty) == ["nothing was measured"]
    assert empty.description == "Digits right: nothing was measured."


def cells(picture):
    """Digits of the cells by row and column."""
    digits = drawn(picture).axes[0].collections[0].get_array()
    return {place: value for place, value in np.ndenumerate(digits.filled(math.nan)) if not math.isnan(value)}


def test_a_map_has_a_cell_for_each_point_with_its_whole_digits():
    picture = heat_map("Map", [CALM, MIXED])
    factors = sorted({point.parameter for sweep in (CALM, MIXED) for point in sweep.points})
    assert cells(picture) == {
        (row, factors.index(point.parameter)): math.floor(point.right)
        for row, sweep in enumerate((CALM, MIXED))
        for point in sweep.points
        if point.right is not None
    }
    assert texts(picture).count("15") == len(FACTORS) and {"12", "8", "5", "–", "?"} <= set(texts(picture))
    assert {"calm", "mixed", "digits right", "10⁻⁸", "1", "10⁸"} <= set(texts(picture))
