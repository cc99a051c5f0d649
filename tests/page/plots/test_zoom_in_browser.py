"""Parts of plots, and the choice of curves, in a browser."""

import numpy as np
import pytest

from mbconstrained.page.content import Curve, Guide, Marks, PageContent, Plot, TimeFunctions, axis_of, curve_with_gaps
from mbconstrained.page.html import write_page
from tests.page.browser import needs_chromium
from tests.page.plots.in_browser import pointed, wheel

pytestmark = needs_chromium

TIMES = np.linspace(0.0, 10.0, 101)
COUNT = 150
LABELS = "[...document.querySelectorAll('svg.plot')[{}].querySelectorAll('.ticks text')].map(t => t.textContent)"
NAMES = "[...document.querySelectorAll('.legend.many li button')]"


def waves(times):
    return np.sin(np.outer(1 + 0.1 * np.arange(COUNT), times))


@pytest.fixture(scope="module")
def opened(browser, tmp_path_factory):
    functions = TimeFunctions(waves, np.array([]))
    many = tuple(Curve(f"storey {i}", row, function=(functions, i)) for i, row in enumerate(waves(TIMES)))
    gain = Curve("H", 1e3 / (1 + TIMES**4))
    logarithmic = Plot("gain", "m/N", TIMES + 0.1, (gain,), across_unit="Hz", variable="frequency", scales=("log", "log"))
    content = PageContent("t", plots=(Plot("displacement", "m", TIMES, many[:2]), Plot("many", "m", TIMES, many), logarithmic))
    browser.size(1100, 900)
    return browser.open(write_page(tmp_path_factory.mktemp("zoom") / "page.html", content))


def ends(labels):
    """The lowest and highest label along the horizontal axis, whose labels come first and ascend."""
    numbers = [float(text.replace("−", "-")) for text in labels]
    count = next((i for i in range(1, len(numbers)) if numbers[i] <= numbers[i - 1]), len(numbers))
    return numbers[0], numbers[count - 1]


def test_the_wheel_zooms_at_the_pointer_a_drag_moves_and_a_double_click_shows_the_whole(opened):
    whole = opened.evaluate(LABELS.format(0))
    for _ in range(4):
        x, y = wheel(opened, 0, 0.5, 0.5, -200)
    low, high = ends(opened.evaluate(LABELS.format(0)))
    assert 3.5 < low < 5 < high < 6.5 and "−1.0" not in opened.evaluate(LABELS.format(0))
    drawn = opened.evaluate("document.querySelector('svg.plot .curves path').getAttribute('d').split('L').length")
    assert drawn > 300  # the part itself, not the points of the whole that lie in it
    for kind, right in (("mousePressed", 0), ("mouseMoved", -150), ("mouseReleased", -150)):
        opened.mouse(kind, x + right, y, button="left", buttons=1, clickCount=1)
    opened.wait(0.1)
    assert ends(opened.evaluate(LABELS.format(0)))[0] > low
    for count in (1, 2):
        opened.press_at(x, y, count)
    opened.wait(0.1)
    assert opened.evaluate(LABELS.format(0)) == whole
    assert opened.messages == []


def test_two_fingers_zoom_about_their_middle_and_move_the_part(opened):
    whole = opened.evaluate(LABELS.format(0))

    def fingers(kind, *shares):
        places = [opened.place("svg.plot", share) for share in shares]
        points = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(places)]
        opened.call("Input.dispatchTouchEvent", type=kind, touchPoints=points)

    opened.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    try:
        fingers("touchStart", 0.45, 0.55)
        for spread in (0.1, 0.15, 0.2):
            fingers("touchMove", 0.5 - spread, 0.5 + spread)
        opened.wait(0.1)
        low, high = ends(opened.evaluate(LABELS.format(0)))
        assert 3.5 < low < 5 < high < 6.5  # four times as far apart: a quarter of 10 s about the middle
        fingers("touchMove", 0.2, 0.6)
        opened.wait(0.1)
        assert ends(opened.evaluate(LABELS.format(0)))[1] > high  # both fingers to the left show what is later
        fingers("touchEnd")
    finally:
        opened.call("Emulation.setTouchEmulationEnabled", enabled=False)
    opened.evaluate("document.querySelector('.whole').click()")
    opened.wait(0.1)
    assert opened.evaluate(LABELS.format(0)) == whole
    assert opened.messages == []


def test_keys_zoom_and_move_the_plot_in_focus(opened):
    opened.evaluate("document.querySelector('svg.plot').focus()")
    for key in ("+", "+", "ArrowRight"):
        opened.press(key)
    opened.wait(0.1)
    low, high = ends(opened.evaluate(LABELS.format(0)))
    assert 2 <= low < high <= 8
    opened.press("0")
    opened.wait(0.1)
    assert ends(opened.evaluate(LABELS.format(0))) == (0, 10)


def test_the_axes_of_a_part_have_the_ticks_of_an_axis_of_that_range(opened):
    for number in (0, 2):
        wheel(opened, number, 0.4, 0.6, -150)
        scale = "log" if number == 2 else "linear"
        shown = opened.evaluate(LABELS.format(number))
        (low, high), start = ((0.1, 10.1) if number == 2 else (0.0, 10.0)), 0.4 * (1 - np.exp(-0.3))
        bounds = np.log10([low, high]) if number == 2 else np.array([low, high])
        part = bounds[0] + (bounds[1] - bounds[0]) * np.array([start, start + np.exp(-0.3)])
        expected = axis_of(*(10**part if number == 2 else part), widen=False, scale=scale).labels
        assert tuple(shown[: len(expected)]) == expected
    opened.evaluate("document.querySelectorAll('.whole').forEach(button => button.click())")


def test_all_of_many_curves_can_be_found_and_shown(opened):
    opened.evaluate(f"{NAMES}[{COUNT - 1}].click()")
    values = "[...document.querySelectorAll('.legend.many .value')].map(v => v.textContent)"
    opened.point("svg.plot", 0.5)
    shown = opened.evaluate(values)
    assert [bool(text) for text in shown] == [True] * 8 + [False] * (COUNT - 9) + [True]
    opened.evaluate("""(() => {
        const search = document.querySelector(".choice input");
        search.value = "storey 14";
        search.dispatchEvent(new Event("input"));
        document.querySelector("[data-choice=none]").click();
        document.querySelector("[data-choice=all]").click();
    })()""")
    pressed = opened.evaluate(f"{NAMES}.flatMap((b, i) => b.getAttribute('aria-pressed') === 'true' ? [i] : [])")
    assert pressed == [*range(8), 14, *range(140, 150)]
    opened.evaluate(f"{NAMES}[14].dispatchEvent(new MouseEvent('dblclick'))")
    assert opened.evaluate(f"{NAMES}.filter(b => b.getAttribute('aria-pressed') === 'true').length") == 1
    assert opened.messages == []


@pytest.fixture(scope="module")
def diagrams(browser, tmp_path_factory):
    """A curve with a gap and marks; two branches in a complex plane."""
    values = np.where((TIMES < 4) | (TIMES > 6), TIMES, np.nan)
    marks = (Marks("critical speed", np.array([[2.0, 2.0], [9.0, 9.0]])), Marks("", np.array([[1.0, 1.0]]), shape="cross", curve=0))
    gap = Plot(
        "gap", "Hz", TIMES, (curve_with_gaps("c", values),), marks=marks, bands=((4.0, 6.0),), variable="speed", across_unit="rpm"
    )
    s = np.array([-TIMES + 1j * TIMES, -TIMES - 1j * TIMES])
    branches = tuple(Curve(f"branch {i}", row.imag, along=row.real) for i, row in enumerate(s))
    plane = Plot("locus", "rad/s", TIMES, branches, Curve("real part", s[0].real), "1/s", variable="c", variable_unit="N s/m")
    browser.size(1100, 900)
    return browser.open(write_page(tmp_path_factory.mktemp("diagrams") / "page.html", PageContent("t", plots=(gap, plane))))


def test_marks_follow_the_part_that_is_shown_and_their_curve(diagrams):
    looks = "[...document.querySelectorAll('svg.mark')].map(m => [m.getAttribute('visibility') || 'visible', parseFloat(m.getAttribute('x'))])"
    assert diagrams.evaluate(looks) == [["visible", 20], ["visible", 90], ["visible", 10]]
    wheel(diagrams, 0, 0.2, 0.2, -300)
    (first, x), (second, _), (third, _) = diagrams.evaluate(looks)
    assert (first, second, third) == ("visible", "hidden", "visible") and abs(x - 20) < 2
    diagrams.evaluate("document.querySelector('.legend button').click()")
    assert [look for look, _ in diagrams.evaluate(looks)] == ["visible", "hidden", "hidden"]
    diagrams.evaluate("document.querySelector('.legend button').click(); document.querySelector('.whole').click()")
    diagrams.wait(0.1)
    assert [look for look, _ in diagrams.evaluate(looks)] == ["visible"] * 3 and diagrams.messages == []


def test_a_curve_has_no_value_in_its_gap(diagrams):
    value = "document.querySelector('.legend .value').textContent"
    for place, expected in ((0.2, 2), (0.5, None), (0.8, 8)):
        diagrams.point("svg.plot", place)
        text = diagrams.evaluate(value)
        assert text == "" if expected is None else abs(float(text.removesuffix(" Hz")) - expected) < 0.05
    assert diagrams.evaluate("document.querySelector('.curves path').getAttribute('d').split('m').length") == 2
    wheel(diagrams, 0, 0.5, 0.5, -300)
    assert diagrams.evaluate("document.querySelector('.curves path').getAttribute('d').split('M').length") == 3
    diagrams.evaluate("document.querySelector('.whole').click()")


def test_a_point_of_a_complex_plane_has_the_value_of_the_parameter(diagrams):
    for up, branch in ((0.75, 0), (0.25, 1)):  # s = -5 +- 5i on axes from -10 to 0 and to 10
        pointed(diagrams, 1, 0.5, up)
        text = diagrams.evaluate("document.querySelectorAll('svg.plot')[1].querySelector('.pointer-time').textContent")
        name, number, unit = text.replace(":", "").split(" ", 2)
        assert (name, unit) == ("c", "N s/m") and abs(float(number) - 5) < 0.1
        lit = "[...document.querySelectorAll('figure')][1].querySelector('.legend .lit')?.textContent"
        assert f"branch {branch}" in diagrams.evaluate(lit)
    assert diagrams.messages == []


def test_the_name_of_a_line_stays_at_the_end_of_its_part(browser, tmp_path):
    """y = 2 x leaves the picture at the middle of its upper edge, also in a part about a point of it; elsewhere it has no name."""
    row = np.linspace(0.0, 10.0, 11)
    line = Guide("2×", (0.0, 0.0), (10.0, 20.0), "line")
    plot = Plot("frequencies", "Hz", row, (Curve("mode", row),), across_unit="rev/min", variable="speed", guides=(line,))
    browser.size(1100, 900)
    browser.open(write_page(tmp_path / "page.html", PageContent("t", plots=(plot,))))
    names = "[...document.querySelectorAll('.guide-name')].map((text) => [text.textContent, text.getAttribute('x'), text.getAttribute('y')])"
    assert browser.evaluate(names) == [["2×", "50.00%", "11.0"]]
    for _ in range(3):
        wheel(browser, 0, 0.25, 0.5, -200)
    ((text, x, y),) = browser.evaluate(names)
    assert text == "2×" and float(x.rstrip("%")) == pytest.approx(50.0, abs=0.5) and y == "11.0"
    browser.evaluate("document.querySelector('.whole').click()")
    browser.wait(0.1)
    assert browser.evaluate(names) == [["2×", "50.00%", "11.0"]]
    for _ in range(3):
        wheel(browser, 0, 0.95, 0.05, -200)
    assert browser.evaluate(names) == [] and browser.messages == []
