"""The work-precision diagram: every measured point is in it, whatever was measured."""

import math
from dataclasses import replace

import pytest

from mbconstrained.page.figure import PALETTE
from mbconstrained.page.look import INK
from mbconstrained.reports.accuracy.diagram import BAR, MARKERS, looks_of
from mbconstrained.reports.accuracy.series import HIGHEST, LOWEST
from mbconstrained.reports.accuracy.work_precision import MeasuredPoint, Series, work_precision
from mbconstrained.reports.figures import WIDTH, Picture
from mbconstrained.tolerances import EPS
from tests.reports.pictures import HOSTILE, HOSTILE_SHOWN, drawn, markers, texts


def point(error: float, seconds: float, label: str = "") -> MeasuredPoint:
    return MeasuredPoint(label, error, seconds, 0.4 * seconds, 0.9 * seconds, 1.2 * seconds)


def peer(name: str, start: float) -> Series:
    return Series(name, tuple(point(1e-3 * 100.0**-i, start * 3.0**i, f"rtol 1e-{2 * i + 3:02d}") for i in range(4)))


OURS = Series("closed form", (point(3e-16, 4e-3),), is_ours=True)
PEERS = tuple(peer(f"method {i}", 1e-3 * 1.7**i) for i in range(14))


def example(series=(OURS, *PEERS[:3]), floor=0.0, failed=()) -> Picture:
    return work_precision("Error against run time", series, floor, failed)


def alone(*points: MeasuredPoint, floor=0.0) -> Picture:
    return work_precision("One", (Series("a", points),), floor)


def test_each_point_is_in_both_panels_and_each_method_once_in_the_legend():
    picture = example()
    assert len(markers(picture, INK)) == 2 * 1 + 1
    assert [len(markers(picture, color)) for color in PALETTE[:3]] == [2 * 4 + 1] * 3
    assert {"closed form", "method 0", "method 1", "method 2"} <= set(texts(picture))
    assert {"one run, set-up and evaluation", "each further evaluation", "run time"} <= set(texts(picture))


@pytest.mark.parametrize("further", [False, True])
def test_points_stand_at_their_times_and_errors(further):
    axes = drawn(example()).axes[further]
    found = {(line.get_xdata()[0], line.get_ydata()[0]) for line in axes.lines if line.get_marker() != "None"}
    series = (OURS, *PEERS[:3])
    assert found == {(p.evaluation if further else p.one_run, p.error) for one in series for p in one.points}
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert all(left < x < right and low < y < high for x, y in found)
    assert axes.get_xscale() == axes.get_yscale() == "log"


def test_ours_is_drawn_over_all_others():
    lines = [line for line in drawn(example()).axes[0].lines if line.get_marker() != "None"]
    assert max(lines, key=lambda line: line.get_zorder()).get_marker() == "*"
    assert max(line.get_zorder() for line in lines if line.get_marker() != "*") < 5


def test_fourteen_methods_and_ours_all_look_different_and_have_room_in_the_legend():
    series = (OURS, *PEERS)
    looks = looks_of(series)
    assert len({(look.color, look.marker, look.dashes) for look in looks}) == 15
    assert [look.marker for look in looks] == ["*", *MARKERS]
    figure = drawn(example(series))
    legend = figure.legends[0].get_window_extent()
    assert 0 <= legend.x0 and legend.x1 <= WIDTH * figure.dpi and legend.y0 >= 0
    assert legend.y1 <= min(axes.get_tightbbox().y0 for axes in figure.axes)


@pytest.mark.parametrize("letter", ["W", "N", "n", "i"])
def test_names_of_any_length_fit_into_the_legend(letter):
    figure = drawn(example(tuple(replace(one, name=letter * 200) for one in PEERS)))
    legend = figure.legends[0].get_window_extent()
    assert legend.x0 >= 0 and legend.y0 >= 0
    assert 0.6 < figure.axes[0].bbox.height / drawn(example()).axes[0].bbox.height < 1.4


def test_the_spread_is_a_bar_between_the_quartiles_of_one_run():
    one, further = drawn(alone(point(1e-6, 1e-3))).axes
    bars = [tuple(line.get_xdata()) for line in one.lines if line.get_linewidth() == BAR]
    assert bars == [pytest.approx((0.9e-3, 1.2e-3))]
    assert not [line for line in further.lines if line.get_linewidth() == BAR]


@pytest.mark.parametrize("floor, lines", [(0.0, {EPS}), (1e-12, {EPS, 1e-12})])
def test_grey_lines_at_the_floors(floor, lines):
    axes = drawn(example(floor=floor)).axes[0]
    assert {line.get_ydata()[0] for line in axes.lines if line.get_zorder() < 2} == lines
    assert ("the truth is not known better" in texts(example(floor=floor))) == (floor > 0)
    assert "rounding of a double" in texts(example(floor=floor))


@pytest.mark.parametrize("error", [0.0, 1e-30])
def test_what_is_too_small_is_open_at_the_bottom_and_told(error):
    picture = alone(point(error, 1e-3), point(1e-9, 2e-3))
    (line,) = [line for line in drawn(picture).axes[0].lines if list(line.get_ydata()) == [LOWEST]]
    assert (line.get_markerfacecolor(), line.get_marker()) == ("white", "o")
    assert "Open markers at the bottom: the error is 0 or below 1e-17." in picture.note
    assert drawn(picture).axes[0].get_ylim()[0] < LOWEST


@pytest.mark.parametrize("error", [math.nan, math.inf, 1e200])
def test_what_diverged_is_an_open_arrow_at_the_top_and_told(error):
    picture = alone(point(error, 1e-3), point(1e-9, 2e-3))
    (line,) = [line for line in drawn(picture).axes[0].lines if list(line.get_ydata()) == [HIGHEST]]
    assert (line.get_markerfacecolor(), line.get_marker()) == ("white", "^")
    assert "Open triangles at the top" in picture.note
    assert "no finite answer" in picture.description or math.isfinite(error)


def test_plain_pictures_tell_nothing_about_marks_that_they_do_not_have():
    assert "Open" not in example().note and "Not in" not in example().note


@pytest.mark.parametrize("seconds", [math.nan, math.inf, 0.0, -1.0])
def test_points_without_a_time_are_left_out(seconds):
    with_bad = alone(replace(point(1e-9, 1e-3), evaluation=seconds), point(1e-8, 2e-3))
    assert len(markers(with_bad, PALETTE[0])) == 2 * 1 + 1
    assert alone(replace(point(1e-9, 1e-3), one_run=seconds)).description.endswith("nothing was measured.")


@pytest.mark.parametrize("low, high", [(math.nan, 1.0), (0.0, 1.0), (2.0, 1.0), (1.0, math.inf)])
def test_quartiles_that_are_none_are_no_bar(low, high):
    picture = alone(replace(point(1e-9, 1.0), low=low, high=high))
    assert "Thin bars" not in picture.note and len(markers(picture, PALETTE[0])) == 3


@pytest.mark.parametrize("series", [(), (Series("a", ()),), (Series("a", (), is_ours=True), Series("b", ()))])
def test_nothing_measured_is_a_picture_that_says_so(series):
    assert texts(example(series)) == ["nothing was measured"]


@pytest.mark.parametrize(
    "points", [[(1e-6, 1e-3)], [(1e-6, 1e-3)] * 5, [(EPS, 1e-9)], [(1.0, 1e6)], [(0.0, 1e-3), (math.nan, 1e-3)]]
)
def test_single_and_equal_points_have_axes_with_ticks_around_them(points):
    for axes in drawn(alone(*(point(*values) for values in points))).axes:
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        assert right / left >= 19.9 and high / low > 1e4
        assert any(left <= tick <= right for tick in axes.get_xticks())
        assert sum(low <= tick <= high for tick in axes.get_yticks()) >= 2


def test_names_and_settings_are_texts():
    picture = work_precision(HOSTILE, (Series(HOSTILE, (point(1e-9, 1e-3, "<b>$x"), point(1e-12, 1.0, "tol 1e-12"))),))
    assert {HOSTILE_SHOWN[:33] + "…" if len(HOSTILE_SHOWN) > 34 else HOSTILE_SHOWN, "<b>$x", "tol 10⁻¹²"} <= set(texts(picture))
    assert picture.png()[1:4] == b"PNG"


def test_the_description_has_the_numbers_and_the_note_the_failed():
    picture = example((OURS, PEERS[0]), failed=(("IDA, index 3", "step size too small"), ("lsim", "needs even times")))
    assert picture.description == (
        "Relative error against run time. closed form: 3e-16 in 4 ms. "
        "method 0: 0.001 in 1 ms (rtol 1e-03), 1e-09 in 27 ms (rtol 1e-09)."
    )
    assert "Not in the picture: IDA, index 3; lsim." in picture.note


def test_our_name_stands_beside_our_point():
    assert texts(example()).count("closed form") == 2 + 1  # two panels and the legend


def test_the_same_measurements_give_the_same_picture():
    assert example().svg == example().svg and example().png() == example().png()


def test_the_coarsest_and_the_finest_setting_stand_beside_their_points_where_there_is_room():
    assert texts(example((PEERS[0],))).count("rtol 10⁻³") == texts(example((PEERS[0],))).count("rtol 10⁻⁹") == 2
    assert "rtol 10⁻⁵" not in texts(example((PEERS[0],)))
