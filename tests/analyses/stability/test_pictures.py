"""Pictures of digits: what is wrong is red, what was claimed can be compared with what is right, every point is there."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mbconstrained.analyses.stability.point import Point
from mbconstrained.analyses.stability.stability import digit_plots, heat_map
from mbconstrained.page.plots import RED, plot_image
from tests.analyses.pictures import HOSTILE, HOSTILE_SHOWN, drawn, markers, texts
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


def test_the_three_curves_have_the_digits():
    (plot,) = digit_plots([CALM])
    assert {curve.name: curve.values.tolist() for curve in plot.curves} == {
        f"digits {key}": pytest.approx([digits] * len(FACTORS))
        for key, digits in (("right", 15.0), ("claimed", 14.0), ("expected", 15.5))
    }
    assert plot.times.tolist() == FACTORS.tolist() and plot.scales == ("log", "linear") and not plot.marks
    assert plot.axes[1].low <= 0 and plot.axes[1].high >= 16


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


@pytest.mark.parametrize(
    "points",
    [
        (point(1.0),),
        (point(3.7e5),),
        (Point(1.0, refused="no"),),
        (point(0.0), point(1.0)),
        (point(-1.0), point(1.0)),
        (Point(1.0, 1e-99, math.nan), Point(10.0, math.inf, 0.0, math.inf)),
        tuple(point(10.0**power) for power in range(-300, 300, 50)),
    ],
)
def test_odd_sweeps_are_drawn(points):
    for plot in digit_plots([sweep("odd", *points)]):
        assert plot_image(plot, "png")[1:4] == b"PNG"
    assert heat_map("odd", [sweep("odd", *points)]).svg.startswith("<svg")


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


def test_digits_are_rounded_down():
    assert "14" in texts(heat_map("Map", [sweep("a", point(1.0, 14.99))]))


def test_in_a_map_the_wrong_has_a_cross_and_the_told_a_frame():
    picture = heat_map("Map", [CALM, MIXED])
    assert len(markers(picture, RED)) == 1 + 1  # the cell and the legend
    assert "1" not in [text.get_text() for text in drawn(picture).axes[0].texts]
    frames = [patch for patch in drawn(picture).axes[0].patches if not patch.get_fill()]
    assert [(int(frame.get_x()), int(frame.get_y())) for frame in frames] == [(5, 1)]


def test_narrow_cells_have_no_numbers():
    many = sweep("many", *(point(1.0 + k) for k in range(60)))
    assert "15" not in texts(heat_map("Map", [many])) and len(cells(heat_map("Map", [many]))) == 60


def test_the_map_names_the_parameter_if_there_is_one():
    assert "stiffness ratio" in texts(heat_map("Map", [CALM, MIXED]))
    assert "scaling factor" in texts(heat_map("Map", [CALM, replace(MIXED, parameter="factor on k1")]))


def test_names_are_texts():
    hostile = replace(MIXED, title=HOSTILE, parameter=HOSTILE)
    assert HOSTILE_SHOWN in texts(heat_map(HOSTILE, [hostile]))


def test_the_same_points_give_the_same_picture_and_words():
    def make():
        return heat_map("a", [CALM, MIXED])

    assert make().svg == make().svg and make().on_page().svg == make().svg
    assert (
        "mixed: 6 points, at least 1.0 digits right, 1 with a warning, 1 refused, 1 wrong without a warning." in make().description
    )
