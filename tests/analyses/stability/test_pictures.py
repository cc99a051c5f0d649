"""Pictures of digits: what is wrong is red, what was claimed can be compared with what is right, every point is there."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mbconstrained.analyses.stability.pictures import CLAIMED, EXPECTED, OVER, RESERVE, RIGHT, digit_curves, heat_map
from mbconstrained.analyses.stability.point import Point
from mbconstrained.page.plots.images import GREY, RED, WARN
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


def test_the_tick_of_zero_is_named():
    axes = drawn(digit_curves("One", [sweep("limit", *map(point, (0.0, 1e-8, 1e-4, 1.0)))])).axes[0]
    labels = [tick.get_text() for tick in axes.get_xticklabels()]
    assert labels[0] == "0" and labels.count("0") == 1 and labels[-1] == "1"


def lines(axes, color):
    return [line for line in axes.lines if line.get_color() == color]


def test_the_three_curves_have_the_digits():
    axes = drawn(digit_curves("One", [CALM])).axes[0]
    for color, digits in ((RIGHT, 15.0), (CLAIMED, 14.0), (EXPECTED, 15.5)):
        line = lines(axes, color)[0]
        assert np.allclose(line.get_xdata(), np.log10(FACTORS)) and np.allclose(line.get_ydata(), digits)
    assert lines(axes, CLAIMED)[0].get_linestyle() == "--" and lines(axes, RIGHT)[0].get_linestyle() == "-"
    assert axes.get_ylim()[0] < 0 and axes.get_ylim()[1] > 16


def test_each_verdict_has_a_mark_of_its_own_at_its_place():
    axes = drawn(digit_curves("One", [MIXED])).axes[0]
    marks = [
        (line.get_marker(), line.get_color(), line.get_xdata()[0], pytest.approx(line.get_ydata()[0]))
        for line in axes.lines
        if line.get_linestyle() == "None"
    ]
    assert marks == [
        ("o", RIGHT, -2.0, 12.0),
        ("o", RIGHT, 0.0, 8.0),
        ("^", WARN, 2.0, 5.0),
        ("X", RED, 4.0, 1.0),
        ("s", GREY, 6.0, 0.0),
        ("D", "white", 8.0, 0.0),
    ]


def test_the_legend_names_only_marks_that_occur():
    marks = {"fewer right than claimed", "with a warning", "refused", "not judged", "wrong without a warning"}
    assert marks <= set(texts(digit_curves("One", [MIXED]))) and not marks & set(texts(digit_curves("One", [CALM])))


def shade(axes, color):
    from matplotlib.colors import to_hex

    (found,) = [one for one in axes.collections if to_hex(one.get_facecolor()[0]) == color]
    return [path.vertices for path in found.get_paths()]


def test_shades_end_where_right_and_claimed_cross():
    """Between 1 (right 12, claimed 11) and 1000 (8, 8.5) the lines cross after two thirds of the distance."""
    points = point(1.0, 12.0, 13.0, 11.0), point(1000.0, 8.0, 9.0, 8.5)
    axes = drawn(digit_curves("One", [sweep("crossing", *points)])).axes[0]
    (more,), (over,) = shade(axes, RESERVE), shade(axes, OVER)
    assert [more[:, 0].min(), more[:, 0].max()] == pytest.approx([0, 2])
    assert [over[:, 0].min(), over[:, 0].max()] == pytest.approx([2, 3])


def test_where_there_is_no_answer_there_is_no_shade():
    points = point(1.0), point(10.0), Point(1e2, refused="no"), point(1e3), point(1e4)
    paths = shade(drawn(digit_curves("One", [sweep("gap", *points)])).axes[0], RESERVE)
    assert [(path[:, 0].min(), path[:, 0].max()) for path in paths] == [(0.0, 1.0), (3.0, 4.0)]


@pytest.mark.parametrize(
    "points",
    [
        (point(1.0),),
        (point(3.7e5),),
        (Point(1.0, refused="no"),),
        (point(0.0), point(1.0)),
        (point(-1.0), point(1.0)),
        (point(2.0), point(2.0)),
        (Point(1.0, 1e-99, math.nan), Point(10.0, math.inf, 0.0, math.inf)),
        tuple(point(10.0**power) for power in range(-300, 300, 50)),
    ],
)
def test_odd_sweeps_are_drawn_within_the_axes(points):
    axes = drawn(digit_curves("odd", [sweep("odd", *points)])).axes[0]
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert all(left <= place <= right for line in axes.lines for place in line.get_xdata())
    assert len([tick for tick in axes.get_xticks() if left <= tick <= right]) >= 1
    drawn_digits = np.concatenate([line.get_ydata() for line in axes.lines])
    assert all(low < digits < high for digits in drawn_digits[~np.isnan(drawn_digits.astype(float))])
    assert heat_map("odd", [sweep("odd", *points)]).svg.startswith("<svg")


@pytest.mark.parametrize("make", [lambda: digit_curves("a", []), lambda: heat_map("a", [sweep("b")])])
def test_nothing_measured_is_a_picture_that_says_so(make):
    assert texts(make()) == ["nothing was measured"]
    assert make().description == "Digits right: nothing was measured."


@pytest.mark.parametrize("count, columns, rows", [(1, 1, 1), (3, 3, 1), (6, 5, 2), (25, 5, 5)])
def test_each_sweep_has_a_small_picture(count, columns, rows):
    picture = digit_curves("All", [replace(CALM, title=f"system {i}") for i in range(count)])
    axes = drawn(picture).axes
    assert len(axes) == columns * rows
    shown = [one for one in axes if one.axison]
    assert [one.get_title() for one in shown] == [f"system {i}" for i in range(count)]
    assert len({one.get_ylim() for one in shown}) == 1


def test_texts_of_a_gallery_do_not_run_into_each_other():
    long = replace(CALM, title="A rather long title of a system that needs more than two lines to be told", parameter="W" * 60)
    figure = drawn(digit_curves("All", [long] * 10))
    boxes = [axes.title.get_window_extent() for axes in figure.axes] + [axes.get_window_extent() for axes in figure.axes]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    assert figure.axes[0].get_title().count("\n") == 1 and figure.axes[0].get_title().endswith("…")


def test_a_red_frame_where_an_answer_is_wrong():
    calm, mixed = drawn(digit_curves("Two", [CALM, MIXED])).axes
    assert all(
        spine.get_visible() and spine.get_edgecolor() == pytest.approx((200 / 255, 16 / 255, 46 / 255, 1))
        for spine in mixed.spines.values()
    )
    assert not calm.spines["top"].get_visible()


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
    assert HOSTILE_SHOWN[:28] + "…" in texts(digit_curves(HOSTILE, [hostile]))
    assert HOSTILE_SHOWN in texts(heat_map(HOSTILE, [hostile]))


@pytest.mark.parametrize("make", [lambda: digit_curves("a", [CALM, MIXED]), lambda: heat_map("a", [CALM, MIXED])])
def test_the_same_points_give_the_same_picture_and_words(make):
    assert make().svg == make().svg and make().on_page().svg == make().svg
    assert (
        "mixed: 6 points, at least 1.0 digits right, 1 with a warning, 1 refused, 1 wrong without a warning." in make().description
    )
