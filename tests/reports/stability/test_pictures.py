"""Pictures of digits: what is wrong is red, what was claimed can be compared with what is right, every point is there."""

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import pytest

from mbconstrained.page.look import GREY, RED, WARN
from mbconstrained.reports.stability.heat_map import REFUSED, UNJUDGED, heat_map
from mbconstrained.reports.stability.pictures import CLAIMED, EXPECTED, OVER, RESERVE, RIGHT, digit_curves, gallery, places_of
from tests.reports.pictures import HOSTILE, HOSTILE_SHOWN, drawn, markers, texts


@dataclass(frozen=True)
class Point:
    parameter: float
    right: float | None = 15.0
    expected: float = 15.5
    claimed: float | None = 14.0
    verdict: str = "right"


@dataclass(frozen=True)
class Sweep:
    title: str
    points: tuple[Point, ...] = field(default=())
    parameter: str = "stiffness ratio"


FACTORS = 10.0 ** np.arange(-8, 9, 2)
CALM = Sweep("calm", tuple(map(Point, FACTORS)))
MIXED = Sweep(
    "mixed",
    (
        Point(1e-2, 12.0, 13.0, 11.0),
        Point(1e0, 8.0, 9.0, 10.0),
        Point(1e2, 5.0, 8.0, 4.0, "told"),
        Point(1e4, 1.0, 8.0, 7.0, "wrong"),
        Point(1e6, None, 3.0, None, "refused"),
        Point(1e8, None, 0.0, None, "not judged"),
    ),
)


def test_decades_stand_evenly_and_zero_a_step_below_the_least():
    assert list(places_of([1e-2, 1.0, 1e2])) == [-2.0, 0.0, 2.0]
    assert list(places_of([0.0, 1e-4, 1e-2, 1.0])) == [-6.0, -4.0, -2.0, 0.0]
    assert list(places_of([1.0, 2.0, 5.0])) == [1.0, 2.0, 5.0] and list(places_of([-1.0, 100.0])) == [-1.0, 100.0]


def test_the_tick_of_zero_says_so():
    points = tuple(Point(x) for x in (0.0, 1e-8, 1e-4, 1.0))
    axes = drawn(digit_curves(Sweep("limit", points))).axes[0]
    labels = [tick.get_text() for tick in axes.get_xticklabels()]
    assert labels[0] == "0" and labels.count("0") == 1 and labels[-1] == "1"


def lines(axes, color):
    return [line for line in axes.lines if line.get_color() == color]


def test_the_three_curves_have_the_digits():
    axes = drawn(digit_curves(CALM)).axes[0]
    for color, digits in ((RIGHT, 15.0), (CLAIMED, 14.0), (EXPECTED, 15.5)):
        line = lines(axes, color)[0]
        assert np.allclose(line.get_xdata(), np.log10(FACTORS)) and set(line.get_ydata()) == {digits}
    assert lines(axes, CLAIMED)[0].get_linestyle() == "--" and lines(axes, RIGHT)[0].get_linestyle() == "-"
    assert axes.get_ylim()[0] < 0 and axes.get_ylim()[1] > 16


def test_each_verdict_has_a_mark_of_its_own_at_its_place():
    axes = drawn(digit_curves(MIXED)).axes[0]
    marks = {
        line.get_marker(): (line.get_color(), *line.get_xdata(), *line.get_ydata())
        for line in axes.lines
        if line.get_linestyle() == "None"
    }
    assert marks == {
        "o": (RIGHT, -2.0, 0.0, 12.0, 8.0),
        "^": (WARN, 2.0, 5.0),
        "X": (RED, 4.0, 1.0),
        "s": (GREY, 6.0, 0.0),
        "D": ("white", 8.0, 0.0),
    }


def test_the_legend_names_only_marks_that_occur():
    marks = {"fewer right than claimed", "with a warning", "refused", "not judged", "wrong without a warning"}
    assert marks <= set(texts(digit_curves(MIXED))) and not marks & set(texts(digit_curves(CALM)))


def shade(axes, color):
    from matplotlib.colors import to_hex

    (found,) = [one for one in axes.collections if to_hex(one.get_facecolor()[0]) == color]
    return [path.vertices for path in found.get_paths()]


def test_shades_end_where_right_and_claimed_cross():
    """Between 10^-2 (right 12, claimed 11) and 1 (8, 10) the lines cross after a third of the way, at 10^(-4/3)."""
    axes = drawn(digit_curves(replace(MIXED, points=MIXED.points[:2]))).axes[0]
    (more,), (over,) = shade(axes, RESERVE), shade(axes, OVER)
    assert [more[:, 0].min(), more[:, 0].max()] == pytest.approx([-2, -4 / 3])
    assert [over[:, 0].min(), over[:, 0].max()] == pytest.approx([-4 / 3, 0])


def test_where_there_is_no_answer_there_is_no_shade():
    points = (Point(1.0), Point(10.0), Point(1e2, None, verdict="refused", claimed=None), Point(1e3), Point(1e4))
    paths = shade(drawn(digit_curves(Sweep("gap", points))).axes[0], RESERVE)
    assert [(path[:, 0].min(), path[:, 0].max()) for path in paths] == [
        (0.0, pytest.approx(1.0)),
        (pytest.approx(3.0), pytest.approx(4.0)),
    ]


@pytest.mark.parametrize(
    "points",
    [
        (Point(1.0),),
        (Point(3.7e5),),
        (Point(1.0, None, 0.0, None, "refused"),),
        (Point(0.0), Point(1.0)),
        (Point(-1.0), Point(1.0)),
        (Point(2.0), Point(2.0)),
        (Point(1.0, 99.0, math.nan, -3.0), Point(10.0, math.nan, 99.0, math.inf)),
        tuple(Point(10.0**power) for power in range(-300, 300, 50)),
    ],
)
def test_odd_sweeps_are_drawn_within_the_axes(points):
    for picture in (digit_curves(Sweep("odd", points)), gallery("odd", [Sweep("odd", points)])):
        axes = drawn(picture).axes[0]
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        assert all(left <= place <= right for place in places_of([point.parameter for point in points]))
        assert len([tick for tick in axes.get_xticks() if left <= tick <= right]) >= 2
        drawn_digits = np.concatenate([line.get_ydata() for line in axes.lines])
        assert all(low < digits < high for digits in drawn_digits[~np.isnan(drawn_digits.astype(float))])
    assert heat_map("odd", [Sweep("odd", points)]).svg.startswith("<svg")


@pytest.mark.parametrize("make", [lambda: digit_curves(Sweep("a")), lambda: gallery("a", []), lambda: heat_map("a", [Sweep("b")])])
def test_nothing_measured_is_a_picture_that_says_so(make):
    assert texts(make()) == ["nothing was measured"]
    assert make().description == "Digits right: nothing was measured."


@pytest.mark.parametrize("count, columns, rows", [(1, 1, 1), (3, 3, 1), (6, 5, 2), (25, 5, 5)])
def test_a_gallery_has_a_small_picture_for_each_sweep(count, columns, rows):
    picture = gallery("All", [replace(CALM, title=f"system {i}") for i in range(count)])
    axes = drawn(picture).axes
    assert len(axes) == columns * rows
    shown = [one for one in axes if one.axison]
    assert [one.get_title() for one in shown] == [f"system {i}" for i in range(count)]
    assert len({one.get_ylim() for one in shown}) == 1


def test_texts_of_a_gallery_do_not_run_into_each_other():
    long = replace(CALM, title="A rather long title of a system that needs more than two lines to be told", parameter="W" * 60)
    figure = drawn(gallery("All", [long] * 10))
    boxes = [axes.title.get_window_extent() for axes in figure.axes] + [axes.get_window_extent() for axes in figure.axes]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    assert figure.axes[0].get_title().count("\n") == 1 and figure.axes[0].get_title().endswith("…")


def test_a_red_frame_where_an_answer_is_wrong():
    calm, mixed = drawn(gallery("Two", [CALM, MIXED])).axes
    assert all(
        spine.get_visible() and spine.get_edgecolor() == pytest.approx((200 / 255, 16 / 255, 46 / 255, 1))
        for spine in mixed.spines.values()
    )
    assert not calm.spines["top"].get_visible()


def cells(picture):
    """Colours of the cells by row and column."""
    from matplotlib.colors import to_hex

    found = {}
    for patch in drawn(picture).axes[0].patches:
        if patch.get_fill():
            found[round(patch.get_y() + 0.5), round(patch.get_x() + 0.5)] = to_hex(patch.get_facecolor())
    return found


def test_a_map_has_a_cell_for_each_point_with_its_whole_digits():
    picture = heat_map("Map", [CALM, MIXED])
    found = cells(picture)
    factors = sorted({point.parameter for sweep in (CALM, MIXED) for point in sweep.points})
    assert set(found) == {(row, factors.index(p.parameter)) for row, sweep in enumerate((CALM, MIXED)) for p in sweep.points}
    assert len({found[0, column] for column in range(len(factors))}) == 1
    assert texts(picture).count("15") == len(FACTORS) and {"12", "8", "5", "–", "?"} <= set(texts(picture))
    assert (found[1, 7], found[1, 8]) == (REFUSED, UNJUDGED)
    assert {"calm", "mixed", "digits right", "10⁻⁸", "1", "10⁸"} <= set(texts(picture))


def test_digits_are_rounded_down():
    assert "14" in texts(heat_map("Map", [Sweep("a", (Point(1.0, 14.99),))]))


def test_in_a_map_the_wrong_has_a_cross_and_the_told_a_frame():
    picture = heat_map("Map", [CALM, MIXED])
    assert len(markers(picture, RED)) == 1 + 1  # the cell and the legend
    assert "1" not in [text.get_text() for text in drawn(picture).axes[0].texts]
    frames = [patch for patch in drawn(picture).axes[0].patches if not patch.get_fill()]
    assert [(round(frame.get_x() + 0.5), round(frame.get_y() + 0.5)) for frame in frames] == [(5, 1)]


def test_colours_of_a_map_get_brighter_with_every_digit():
    """So that they can be told apart without seeing hues: relative luminance of sRGB."""
    from matplotlib.colors import to_rgb

    found = cells(heat_map("Map", [Sweep("all", tuple(Point(10.0**digits, float(digits)) for digits in range(17)))]))
    linear = [
        [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in to_rgb(found[0, k])] for k in range(17)
    ]
    brightness = [0.2126 * red + 0.7152 * green + 0.0722 * blue for red, green, blue in linear]
    assert all(a < b for a, b in pairwise(brightness))


def test_narrow_cells_have_no_numbers():
    many = Sweep("many", tuple(Point(1.0 + k) for k in range(60)))
    assert "15" not in texts(heat_map("Map", [many])) and len(cells(heat_map("Map", [many]))) == 60


def test_the_map_says_what_is_turned_if_it_is_one_thing():
    assert "stiffness ratio" in texts(heat_map("Map", [CALM, MIXED]))
    assert "times what it is" in texts(heat_map("Map", [CALM, replace(MIXED, parameter="factor on k1")]))


def test_names_are_texts():
    hostile = replace(MIXED, title=HOSTILE, parameter=HOSTILE)
    assert HOSTILE_SHOWN in texts(digit_curves(hostile))
    assert HOSTILE_SHOWN[:28] + "…" in texts(gallery(HOSTILE, [hostile]))
    assert HOSTILE_SHOWN in texts(heat_map(HOSTILE, [hostile]))


@pytest.mark.parametrize(
    "make", [lambda: digit_curves(MIXED), lambda: gallery("a", [CALM, MIXED]), lambda: heat_map("a", [CALM, MIXED])]
)
def test_the_same_points_give_the_same_picture_and_words(make):
    assert make().svg == make().svg and make().on_page().svg == make().svg
    assert (
        "mixed: 6 points, at least 1.0 digits right, 1 with a warning, 1 refused, 1 wrong without a warning." in make().description
    )
