"""What can be pressed, pointed at and chosen on the page of a run, with the mouse, the keyboard and the system's settings."""

import numpy as np
import pytest

from mbconstrained.page.html import write_page
from tests.page.browser import needs_chromium
from tests.page.contents import plotted_content, two_masses

pytestmark = [needs_chromium, pytest.mark.long]


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return write_page(tmp_path_factory.mktemp("pages") / "page.html", plotted_content())


@pytest.fixture(scope="module")
def opened(browser, page):
    """The page once, for tests that leave it playing or not wherever it is."""
    browser.size(1100, 900)
    return browser.open(page)


@pytest.fixture
def begun(opened):
    """The same page, paused at the start, with nothing in focus."""
    opened.evaluate("document.activeElement.blur(), mbconstrained.pause(), mbconstrained.seek(0)")
    return opened


def attribute(browser, selector, name):
    return browser.evaluate(f"document.querySelector({selector!r}).getAttribute({name!r})")


def values(browser, plot):
    return browser.evaluate(f"[...document.querySelectorAll('figure')[{plot}].querySelectorAll('.value')].map(v => v.textContent)")


def said(browser):
    return browser.evaluate("document.querySelector('[role=status]').textContent")


def test_without_the_loop_it_stops_at_the_end_and_plays_again_from_the_start(begun):
    begun.click("#loop")
    assert attribute(begun, "#loop", "aria-pressed") == "false"
    assert said(begun) == "stops at the end"
    begun.evaluate("mbconstrained.seek(49.9), mbconstrained.play()")
    begun.until("!state.playing")
    state = begun.state()
    assert (state["time"], state["playing"], state["loop"]) == (50, False, False)
    begun.click("#play")
    assert begun.state()["playing"] is True and begun.state()["time"] < 5
    begun.evaluate("mbconstrained.pause()")
    begun.press("l")
    assert begun.state()["loop"] is True


def test_keys_move_the_time_and_choose_the_speed(begun):
    found = []
    for key in ("ArrowRight", "ArrowRight", "ArrowLeft", "End", "ArrowRight", "Home"):
        begun.press(key)
        found.append(begun.state()["time"])
    assert found == pytest.approx([0.5, 1, 0.5, 50, 50, 0])
    speeds = []
    for key in ("+", "+", "-", "-"):
        begun.press(key)
        speeds.append(begun.evaluate("document.querySelector('#speed').value"))
    assert speeds == ["2.0", "5.0", "2.0", "1.0"]
    assert said(begun) == "speed × 1"
    begun.press(" ")
    assert (said(begun), begun.state()["playing"]) == ("playing", True)


def test_keys_that_belong_to_something_else_are_left_to_it(begun):
    begun.evaluate("document.querySelector('#speed').focus()")
    begun.press("End")
    assert begun.state()["time"] == 0
    assert begun.evaluate("document.querySelector('#speed').selectedIndex") == 6
    begun.evaluate("document.querySelector('#speed').selectedIndex = 3")
    begun.evaluate("document.querySelector('#time').focus()")
    begun.press("ArrowRight")
    assert begun.state()["time"] == pytest.approx(0.5, abs=0.01)  # the slider's own step, once
    begun.evaluate("document.querySelector('.scroll').focus()")
    begun.press("ArrowRight")
    assert begun.state()["time"] == pytest.approx(0.5, abs=0.01)


def test_values_stand_beside_the_names_at_the_time_and_at_the_pointer(begun):
    begun.evaluate("mbconstrained.seek(12.5)")
    known, shown = two_masses(np.array([12.5]))[:, 0], values(begun, 0)
    assert [float(text[:-2].replace("−", "-")) for text in shown] == pytest.approx(known, abs=1e-3)  # lines between the points
    begun.point("svg.plot", 0.5)
    at_pointer = [float(text[:-2].replace("−", "-")) for text in values(begun, 0)]
    assert at_pointer == pytest.approx(two_masses(np.array([25.0]))[:, 0], abs=5e-3)
    told = "[...document.querySelectorAll('.pointer-time')].map(text => text.textContent)"
    assert begun.evaluate(told)[0].startswith("25.0") or begun.evaluate(told)[0].startswith("24.9")
    assert begun.state()["time"] == 12.5  # the pointer alone moves nothing
    begun.point("h1", 0.1)
    assert (values(begun, 0), begun.evaluate(told)[0]) == (shown, "")


def test_a_drag_in_a_plot_moves_the_time_and_the_dot_of_a_phase_plane(begun):
    where = "parseFloat(document.querySelectorAll('svg.plot')[1].querySelector('circle').getAttribute('cx'))"
    places = []
    begun.point("svg.plot", 0.2, "mousePressed", button="left", buttons=1, clickCount=1)
    for across in (0.3, 0.6):
        begun.point("svg.plot", across, button="left", buttons=1)
        places.append((begun.state()["time"], begun.evaluate(where)))
    begun.point("svg.plot", 0.6, "mouseReleased", button="left", clickCount=1)
    begun.point("svg.plot", 0.9)
    assert [time for time, _ in places] == pytest.approx([15, 30], abs=0.1)
    assert begun.state()["time"] == places[-1][0]
    left, right = map(float, attribute(begun, "svg.plot[data-over=phase]", "data-across").split()[:2])
    known = two_masses(np.array([time for time, _ in places]))[0]
    assert [left + dot / 100 * (right - left) for _, dot in places] == pytest.approx(known, abs=5e-3)


def test_a_click_in_a_phase_plane_goes_to_when_the_motion_was_there(begun):
    begun.point("h1", 0.1)
    begun.evaluate("mbconstrained.seek(20)")
    dot = begun.place("svg.plot[data-over=phase] circle", 0.5)
    begun.evaluate("mbconstrained.seek(17)")
    begun.press_at(*dot)
    assert begun.state()["time"] == pytest.approx(20, abs=0.3)
    begun.point("h1", 0.1)


def test_names_show_and_hide_their_curves(begun):
    names = "[...document.querySelectorAll('figure')[2].querySelectorAll('li button')]"
    shown = f"{names}.map(name => name.getAttribute('aria-pressed') === 'true')"
    drawn = "[...document.querySelectorAll('figure')[2].querySelectorAll('.curves path')].filter(p => getComputedStyle(p).display !== 'none').length"
    assert begun.evaluate(shown) == [True] * 8 + [False] * 2
    begun.evaluate(f"({names}[9].click(), {names}[0].click())")
    assert begun.evaluate(shown) == [False] + [True] * 7 + [False, True]
    assert begun.evaluate(drawn) == 8
    assert [bool(text) for text in values(begun, 2)] == begun.evaluate(shown)


def test_dark_and_light_follow_the_system_and_the_button_and_are_remembered(browser, page):
    ground = "getComputedStyle(document.body).backgroundColor"
    browser.prefers(color_scheme="dark")
    dark = browser.open(page).evaluate(ground)
    browser.prefers(color_scheme="light")
    light = browser.evaluate(ground)
    assert light != dark
    browser.click("#theme")
    assert (browser.evaluate(ground), browser.evaluate("document.querySelector('#theme').textContent")) == (dark, "Switch to light")
    assert browser.open(page).evaluate(ground) == dark
    browser.click("#theme")
    browser.evaluate("localStorage.clear()")
    assert (browser.evaluate(ground), browser.messages) == (light, [])


def test_on_paper_there_are_pictures_and_whole_tables_and_no_buttons(browser, page):
    browser.open(page, "#t=5")
    unfolded = "document.querySelector('.folded td').checkVisibility()"
    assert not browser.evaluate(unfolded)
    printed = browser.evaluate("dispatchEvent(new Event('beforeprint')), document.querySelectorAll('#stage canvas.paper').length")
    browser.call("Emulation.setEmulatedMedia", media="print")
    hidden = "['.controls', '#theme', '#stage .view'].map(s => getComputedStyle(document.querySelector(s)).display)"
    assert (printed, browser.evaluate(hidden)) == (1, ["none"] * 3)
    assert browser.evaluate("getComputedStyle(document.querySelector('canvas.paper')).display") == "block"
    browser.until(unfolded)
    assert browser.evaluate("document.querySelector('.folded').getBoundingClientRect().height") > 60
    colors = browser.evaluate("""(() => {
        const flat = document.querySelector("canvas.paper");
        const pixels = flat.getContext("2d").getImageData(0, 0, flat.width, flat.height).data;
        return new Set(Array.from({length: pixels.length / 400}, (_, i) => pixels.slice(400 * i, 400 * i + 4).join())).size;
    })()""")
    assert colors > 50  # the model is on it
    browser.call("Emulation.setEmulatedMedia", media="")
    browser.until(f"!{unfolded}")
    browser.click(".folded summary")
    assert browser.evaluate(unfolded)
    assert browser.evaluate("dispatchEvent(new Event('afterprint')), document.querySelectorAll('canvas.paper').length") == 0


def test_on_a_phone_nothing_is_cut_off_and_texts_are_readable(browser, page):
    browser.size(400, 800, mobile=True)
    browser.open(page)
    assert browser.evaluate("document.documentElement.scrollWidth") == 400
    sizes = browser.evaluate("[...document.querySelectorAll('svg.plot text')].map(t => t.getBoundingClientRect().height)")
    assert all(size == 0 or size >= 11 for size in sizes)
    widths = browser.evaluate("[...document.querySelectorAll('svg.plot')].map(svg => svg.getBoundingClientRect().width)")
    assert min(widths) > 250
    rows = browser.evaluate("[...document.querySelectorAll('tbody tr')].map(row => row.getBoundingClientRect().height)")
    assert max(rows) < 120
    browser.size(800, 600)
