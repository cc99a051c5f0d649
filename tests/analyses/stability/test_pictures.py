"""Pictures of digits: what is wrong is red, what was claimed can be compared with what is right, every point is there."""

import math

import numpy as np
import pytest

from mbconstrained.analyses.stability.point import Point
from mbconstrained.analyses.stability.stability import digit_plots, overview_plot
from mbconstrained.page.plots import plot_image
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


def test_all_sweeps_together_have_their_digits_and_marks():
    (plot,) = overview_plot([CALM, MIXED])
    factors = sorted({point.parameter for sweep in (CALM, MIXED) for point in sweep.points})
    assert plot.times.tolist() == factors and plot.shown == 2
    for curve, one in zip(plot.curves, (CALM, MIXED)):
        right = {point.parameter: point.right for point in one.points if point.right is not None}
        assert curve.name == one.title
        assert dict(zip(plot.times[curve.drawn], curve.values[curve.drawn])) == pytest.approx(right)
    assert {marks.curve for marks in plot.marks} == {1} and len(plot.marks) == 4
    assert plot_image(plot, "png") == plot_image(plot, "png")
