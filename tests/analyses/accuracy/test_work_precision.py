"""The work-precision diagram: every measured point is in it, whatever was measured."""

import pytest

from mbconstrained.analyses.accuracy.accuracy import BAR, LOWEST, MARKERS, work_precision
from mbconstrained.analyses.accuracy.measure import Measurement
from mbconstrained.analyses.accuracy.methods import ComparedMethod, MethodSetting
from mbconstrained.analyses.figures import WIDTH, Picture
from mbconstrained.analyses.timing import Timing
from mbconstrained.ground.tolerances import EPS
from mbconstrained.page.animation.figure import PALETTE
from mbconstrained.page.plots.images import INK
from tests.analyses.pictures import HOSTILE, HOSTILE_SHOWN, drawn, texts

pytestmark = pytest.mark.long  # pictures are drawn by Matplotlib one by one


def timing(seconds: float) -> Timing:
    return Timing((0.8 * seconds, 0.9 * seconds, seconds, 1.2 * seconds, 1.3 * seconds))


def run(method: ComparedMethod, error: float, seconds: float, label: str = "") -> Measurement:
    """One run takes so many seconds, a further evaluation 0.4 of them."""
    return Measurement(method, MethodSetting(label), error, timing(0.5 * seconds), timing(0.5 * seconds), timing(0.4 * seconds))


def named(name: str, is_ours: bool = False) -> ComparedMethod:
    return ComparedMethod(name, lambda problem, value: None, is_ours=is_ours)


def peer(name: str, start: float = 1e-3) -> list[Measurement]:
    method = named(name)
    return [run(method, 1e-3 * 100.0**-i, start * 3.0**i, f"rtol 1e-{2 * i + 3:02d}") for i in range(4)]


OURS = [run(named("closed form", is_ours=True), 3e-16, 4e-3)]
PEERS = [peer(f"method {i}", 1e-3 * 1.7**i) for i in range(14)]
SOME = [*OURS, *PEERS[0], *PEERS[1], *PEERS[2]]


def example(runs=SOME, floor=0.0, failed=()) -> Picture:
    return work_precision("Error against run time", runs, floor, failed)


def alone(*points: tuple[float, float]) -> Picture:
    method = named("a")
    return work_precision("One", [run(method, *point) for point in points])


def curves(axes):
    """Lines with markers, by their colours; legends have no places."""
    return [line for line in axes.lines if line.get_marker() != "None" and len(line.get_xdata())]


def test_each_method_is_in_both_panels_and_once_in_the_legend_with_its_settings():
    picture = example()
    assert [[line.get_color() for line in curves(axes)] for axes in drawn(picture).axes] == [[INK, *PALETTE[:3]]] * 2
    names = {"closed form", *(f"method {i}, rtol 10⁻³ … 10⁻⁹" for i in range(3))}
    assert names <= set(texts(picture)) and all(texts(picture).count(name) == 1 for name in names)
    assert {"one run, set-up and evaluation", "each further evaluation", "run time"} <= set(texts(picture))


@pytest.mark.parametrize("kind", ["one_run", "further"])
def test_points_have_their_times_and_errors(kind):
    axes = drawn(example()).axes[kind == "further"]
    points = [pair for line in curves(axes) for pair in zip(line.get_xdata(), line.get_ydata())]
    assert points == [(getattr(run, kind).median, run.error) for run in SOME]
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert all(left < x < right and low < y < high for x, y in points)
    assert axes.get_xscale() == axes.get_yscale() == "log"


def test_ours_is_drawn_over_all_others():
    assert max(curves(drawn(example()).axes[0]), key=lambda line: line.get_zorder()).get_marker() == "*"


def test_fourteen_methods_and_ours_all_look_different_and_have_room_in_the_legend():
    figure = drawn(example([*OURS, *(run for runs in PEERS for run in runs)]))
    looks = [(line.get_color(), line.get_marker(), line.get_linestyle()) for line in curves(figure.axes[0])]
    assert len(set(looks)) == 15 and [marker for _, marker, _ in looks] == ["*", *MARKERS]
    legend = figure.legends[0].get_window_extent()
    assert 0 <= legend.x0 and legend.x1 <= WIDTH * figure.dpi and legend.y0 >= 0
    assert legend.y1 <= min(axes.get_tightbbox().y0 for axes in figure.axes)


def test_long_names_fit_into_the_legend():
    figure = drawn(example([run for i in range(6) for run in peer(f"{i} method of integration" * 9)]))
    legend = figure.legends[0].get_window_extent()
    assert legend.x0 >= 0 and legend.y0 >= 0 and legend.x1 <= WIDTH * figure.dpi


def test_the_spread_is_a_bar_between_the_quartiles_of_one_run():
    one, further = drawn(alone((1e-6, 1e-3))).axes
    bars = [tuple(line.get_xdata()) for line in one.lines if line.get_linewidth() == BAR]
    assert bars == [pytest.approx((0.9e-3, 1.2e-3))]
    assert not [line for line in further.lines if line.get_linewidth() == BAR]


@pytest.mark.parametrize("floor, lines", [(0.0, {EPS}), (1e-12, {EPS, 1e-12})])
def test_grey_lines_at_the_floors(floor, lines):
    axes = drawn(example(floor=floor)).axes[0]
    assert {line.get_ydata()[0] for line in axes.lines if line.get_zorder() < 2} == lines
    assert ("accuracy of the reference solution" in texts(example(floor=floor))) == (floor > 0)
    assert "rounding error of a double" in texts(example(floor=floor))


@pytest.mark.parametrize("error", [0.0, 1e-30])
def test_what_is_too_small_is_open_at_the_bottom_and_named_in_the_note(error):
    picture = alone((error, 1e-3), (1e-9, 2e-3))
    (line,) = [line for line in drawn(picture).axes[0].lines if line.get_markerfacecolor() == "white"]
    assert list(line.get_ydata()) == [LOWEST] and line.get_marker() == "o"
    assert "Open markers at the bottom: the error is 0 or below 1e-17." in picture.note
    assert drawn(picture).axes[0].get_ylim()[0] < LOWEST
    assert "Open" not in example().note and "Not in" not in example().note


def test_nothing_measured_is_a_picture_that_says_so():
    assert texts(example([])) == ["nothing was measured"]


@pytest.mark.parametrize("points", [[(1e-6, 1e-3)], [(1e-6, 1e-3)] * 5, [(EPS, 1e-9)], [(0.99, 1e6)], [(0.0, 1e-3)]])
def test_single_and_equal_points_have_axes_with_ticks_around_them(points):
    for axes in drawn(alone(*points)).axes:
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        assert right / left >= 19.9 and high / low > 1e4
        assert any(left <= tick <= right for tick in axes.get_xticks())
        assert sum(low <= tick <= high for tick in axes.get_yticks()) >= 2


def test_names_and_settings_are_texts():
    picture = example([run(named(HOSTILE), 1e-9, 1e-3, "<b>$x"), run(named("b"), 1e-9, 1e-3, "<b>$x")])
    assert {"b, <b>$x", (HOSTILE_SHOWN + ", <b>$x")[:39] + "…"} & set(texts(picture)) and picture.png()[1:4] == b"PNG"


def test_the_description_has_the_numbers_and_the_note_the_failed():
    picture = example([*OURS, *PEERS[0]], failed=("IDA, index 3", "lsim"))
    assert picture.description == (
        "Relative error against run time. closed form: 3e-16 in 4 ms. "
        "method 0: 0.001 in 1 ms (rtol 1e-03), 1e-09 in 27 ms (rtol 1e-09)."
    )
    assert "Not in the picture: IDA, index 3; lsim." in picture.note


def test_the_same_measurements_give_the_same_picture():
    assert example().svg == example().svg and example().png() == example().png()
