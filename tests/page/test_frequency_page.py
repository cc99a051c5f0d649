"""The page of a frequency response: its plots, its peaks, and the shape at the frequency of the cursor."""

from dataclasses import replace

import numpy as np
import pytest

from mbconstrained.ground.display import TextTable
from mbconstrained.page.animation import Deflections
from mbconstrained.page.content import Curve, PageContent, Plot
from mbconstrained.page.html import page_html
from tests.page.browser import needs_chromium
from tests.page.mode_pages import NAMES, two_bodies

LINES = np.geomspace(0.1, 10.0, 41)
SHAPES = np.array([np.column_stack([1.0 / (1 + 1j * LINES), -1j / LINES]), np.column_stack([0 * LINES, 0.5 + 0 * LINES])])


def content(axis="Hz") -> PageContent:
    """Two bodies, two inputs, a plot and one peak."""
    inputs, factors = ("1 N on x", "1 m of <base>"), np.full((2, 41), 3.0)
    shapes = Deflections(two_bodies(), NAMES, inputs, axis, LINES, 1 / LINES, SHAPES, factors, ((1.0, 0),))
    plot = Plot("H", "m/N", LINES, (Curve("x", np.abs(SHAPES[0, :, 0])),), None, axis, variable="frequency", scales=("log", "log"))
    peaks = TextTable("Peaks", ("output", f"frequency ({axis})"), (("x", "1.0"),), "a note")
    return PageContent("Two", "made up", shapes, (plot,), (peaks,))


def test_it_has_the_frequency_its_inputs_and_peaks():
    page = page_html(content())
    assert 'id="line" min="0" max="40" step="1" value="20"' in page and "1 m of &lt;base&gt;" in page
    assert '<tr data-line="20" data-input="0" class=selected>' in page and "a note" in page


def test_without_a_drawing_plots_and_tables_are_there_and_no_viewer():
    page = page_html(replace(content(), animation=None))
    assert "meshcat" not in page and "<h2>Peaks</h2>" in page and 'data-over="frequency"' in page


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    path = tmp_path_factory.mktemp("pages") / "frequency.html"
    path.write_text(page_html(content("rpm")), encoding="utf-8")
    return path


def motion(frequency, source, phase):
    line = np.abs(np.log(LINES / frequency)).argmin()
    return (SHAPES[source, line] * np.exp(2j * np.pi * phase)).real


@needs_chromium
@pytest.mark.long
def test_the_shape_is_that_at_the_cursor_with_its_phase(browser, page):
    state = browser.open(page, "#f=2.5&t=0.3").state()
    assert (browser.messages, state["errors"]) == ([], [])
    assert list(state["coordinates"].values()) == pytest.approx(motion(2.5, 0, 0.3).tolist(), abs=1e-6)
    state = browser.open(page, "#f=0.3&input=2&t=0.25").state()
    assert state["input"] == "1 m of <base>" and list(state["coordinates"].values()) == pytest.approx([0, 0], abs=1e-6)
    assert "displacements drawn × 1.5" in browser.evaluate("document.querySelector('.magnification').textContent")


@needs_chromium
@pytest.mark.long
def test_pointing_at_a_frequency_shows_its_shape_and_a_press_keeps_it(browser, page):
    browser.open(page)
    browser.point("svg.plot", 0.75)  # three quarters of two decades from 0.1
    assert browser.state()["frequency"] == pytest.approx(10**0.5, rel=0.06)
    browser.mouse("mouseMoved", 5, 5)
    assert browser.state()["frequency"] == pytest.approx(1.0)
    browser.press_at(*browser.place("svg.plot", 0.75))
    browser.mouse("mouseMoved", 5, 5)
    state = browser.state()
    assert state["frequency"] == pytest.approx(10**0.5, rel=0.06) and state["errors"] == []
    browser.click("tr[data-line] td:last-child")
    browser.until("Math.abs(window.mbconstrained.state().frequency - 1) < 1e-9")
