"""The page of mode shapes in a browser: picking, playing, arrow keys, the address."""

import numpy as np
import pytest

from mbconstrained.page.html import page_html
from tests.page.browser import needs_chromium
from tests.page.contents import HOSTILE
from tests.page.mode_pages import hostile_modes, robot_modes, two_modes, variants
from tests.page.robots import CRANK, four_bar_angles

pytestmark = [needs_chromium, pytest.mark.long]


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return written(tmp_path_factory.mktemp("pages"), two_modes())


def written(folder, content):
    path = folder / "modes.html"
    path.write_text(page_html(content), encoding="utf-8")
    return path


def text(browser, selector):
    return browser.evaluate(f"document.querySelector({selector!r}).textContent")


def test_it_opens_without_a_complaint_at_the_first_mode_and_waits(browser, page):
    browser.open(page).wait(0.2)
    state = browser.state()
    assert (browser.messages, state["errors"], browser.requests) == ([], [], [page.as_uri()])
    assert (state["mode"], state["name"], state["time"], state["playing"]) == (1, "together", 0, False)


def test_the_address_picks_a_mode_and_a_part_of_its_cycle(browser, page):
    state = browser.open(page, "#mode=2&t=0.3").state()
    assert (state["mode"], state["time"], state["playing"]) == (2, 0.3, False)
    moved = 1.2 * np.cos(0.6 * np.pi)
    assert state["coordinates"] == pytest.approx({"x": moved, "y": -moved}, abs=1e-5)
    assert state["nodes"]["a"]["position"] == pytest.approx([0.5 * moved, 0, 0], abs=1e-5)
    assert state["nodes"]["b"]["position"] == pytest.approx([3 - 0.5 * moved, 0, 0], abs=1e-5)


def test_addresses_that_ask_for_what_is_not_there(browser, page):
    browser.open(page, "#mode=9&t=0.5")
    found = [(browser.state()["mode"], browser.state()["time"])]
    for fragment in ("#mode=x", "#t=7", "#mode=2&t=-1", "#other", "#mode=3"):
        browser.evaluate(f"new Promise(done => {{ addEventListener('hashchange', done); location.hash = '{fragment}' }})")
        found.append((browser.state()["mode"], browser.state()["time"]))
    assert found == [(1, 0.5), (1, 0.5), (1, 1), (2, 0), (2, 0), (3, 0)]
    assert browser.state()["errors"] == []


def test_a_click_on_a_row_picks_its_mode_and_it_moves(browser, page):
    browser.open(page)
    browser.click("tr[data-mode='1'] td:last-child")
    browser.until("state.time > 0.05")
    state = browser.state()
    assert (state["mode"], state["playing"]) == (2, True)
    assert 0.05 < state["time"] < 0.9
    assert browser.evaluate("document.querySelector('tr.selected').dataset.mode") == "1"
    assert browser.evaluate("document.querySelector('input[name=mode]:checked').value") == "1"
    assert browser.evaluate("[...document.querySelectorAll('.details section')].map(s => s.hidden)") == [True, False, True]


def test_arrow_keys_go_from_mode_to_mode_and_the_space_bar_pauses(browser, page):
    browser.open(page)
    browser.evaluate("document.querySelector('input[name=mode]:checked').focus()")
    found = []
    for key in ("ArrowDown", "ArrowDown", "ArrowUp"):
        browser.press(key)
        found.append(browser.state()["mode"])
    assert found == [2, 3, 2]
    assert browser.state()["playing"] is True
    browser.press(" ")
    assert browser.state()["playing"] is False


def test_a_cycle_takes_two_seconds_and_goes_on(browser, page):
    browser.open(page, "#mode=1&t=0.9")
    browser.click("#play")
    browser.until("state.time < 0.85")  # beyond the end, near which it began
    assert browser.state()["playing"] is True


def test_the_pace_is_told_and_follows_the_speed(browser, page):
    browser.open(page, "#mode=2")
    assert text(browser, ".magnification").split("\n") == [
        "not to scale: displacements of the shape drawn × 0.6",
        "a cycle of 0.5 s shown in 2 s: slowed down 4 ×",
    ]
    browser.evaluate(
        "(() => { const s = document.querySelector('#speed'); s.value = '0.5'; s.dispatchEvent(new Event('change')) })()"
    )
    assert text(browser, ".magnification").endswith("a cycle of 0.5 s shown in 4 s: slowed down 8 ×")


def test_a_mode_that_does_not_move_says_why_and_cannot_be_played(browser, page):
    browser.open(page)
    browser.click("tr[data-mode='2'] td:last-child")
    state = browser.state()
    assert (state["mode"], state["playing"], state["coordinates"]) == (3, False, {"x": 0, "y": 0})
    assert browser.evaluate("document.querySelector('#play').disabled") is True
    assert text(browser, ".magnification") == "does not move"
    assert text(browser, ".details section:not([hidden]) .note") == "It does not move: a row drifts."
    browser.click("tr[data-mode='0'] td:last-child")
    assert browser.evaluate("document.querySelector('#play').disabled") is False
    assert browser.state()["playing"] is True


def test_with_little_motion_wanted_a_mode_that_is_selected_waits(browser, page):
    browser.prefers(reduced_motion="reduce")
    browser.open(page)
    browser.click("tr[data-mode='1']")
    assert (browser.state()["mode"], browser.state()["playing"]) == (2, False)
    browser.prefers(reduced_motion="no-preference")


def test_modes_by_paths_move_the_links(browser, tmp_path):
    browser.open(written(tmp_path, robot_modes()), "#mode=1&t=0.4")
    crank = four_bar_angles([0.4 * 2 * np.pi / 1.3])[0, 0]
    place = CRANK * np.array([np.cos(crank), 0, np.sin(crank)])
    assert browser.state()["nodes"]["coupler"]["position"] == pytest.approx(place, abs=1e-4)
    browser.evaluate("mbconstrained.select(2)")
    crank = four_bar_angles([0.0])[0, 0]
    assert browser.state()["nodes"]["coupler"]["position"] == pytest.approx(
        CRANK * np.array([np.cos(crank), 0, np.sin(crank)]), abs=1e-6
    )
    assert (browser.messages, browser.state()["errors"]) == ([], [])


def test_hostile_texts_are_shown_as_texts(browser, tmp_path):
    browser.open(written(tmp_path, hostile_modes())).wait(0.2)
    assert (browser.dialogs, browser.messages) == ([], [])
    assert text(browser, "tr[data-mode='0'] label span") == HOSTILE
    assert browser.state()["name"] == HOSTILE
    assert browser.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_the_slider_goes_through_the_variants(browser, tmp_path):
    browser.open(written(tmp_path, variants(5)))
    assert text(browser, "#chosen") == "sample 10"
    browser.evaluate(
        "(choice => { choice.value = 3; choice.dispatchEvent(new Event('input')); })(document.querySelector('#choice'))"
    )
    assert text(browser, "#chosen") == "sample 40"
    assert browser.evaluate("document.querySelector('tr.selected').dataset.mode") == "3"
    browser.evaluate("document.querySelector('tr[data-mode=\"1\"] input').click()")
    assert browser.evaluate("document.querySelector('#choice').value") == "1"
    assert text(browser, "#chosen") == "sample 20"
    assert browser.messages == []
