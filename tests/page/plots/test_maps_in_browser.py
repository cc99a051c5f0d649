"""Maps, points and rows of names in a browser: they follow the zoom, and names show and hide what belongs to them."""

import numpy as np
import pytest

from mbconstrained.analyses.sweep.plots import row_plot
from mbconstrained.page.content import Cells, Curve, Marks, PageContent, Plot
from mbconstrained.page.html import write_page
from tests.page.browser import needs_chromium
from tests.page.plots.in_browser import pointed, tables, wheel

pytestmark = needs_chromium

EDGES = np.array([0.0, 1.0, 2.0])
CELLS = Cells(EDGES, EDGES, np.array([[1.0, np.nan], [3.0, 4.0]]), [["a", "b"], ["c", "d <e>"]], "Hz")


@pytest.fixture(scope="module")
def opened(browser, tmp_path_factory):
    points = np.array([[0.0, 0.0], [1.0, 1.0]])
    hidden = Curve("f", np.zeros(2), drawn=np.zeros(2, dtype=bool))
    plots = (
        Plot("map", "m", EDGES, (), across_unit="m", quantity="up", variable="across", cells=CELLS),
        Plot("points", "m", EDGES[:2], (hidden,), variable="across", marks=(Marks("", points, ("p", "q"), "dot", 0),)),
        row_plot("rows", ["stiffness", "mass"], {"low": [-1.0, 2.0], "high": [1.0, -0.5]}, "change"),
    )
    browser.size(1280, 900)
    return browser.open(write_page(tmp_path_factory.mktemp("maps") / "page.html", PageContent("t", plots=plots)))


def test_a_map_has_its_cells_and_is_zoomed(opened):
    assert opened.evaluate("document.querySelectorAll('.guides rect').length") == 4
    before = opened.evaluate("document.querySelector('.guides rect').getBoundingClientRect().width")
    wheel(opened, 0, 0.25, 0.25, -200)
    assert opened.evaluate("document.querySelector('.guides rect').getBoundingClientRect().width") > 1.2 * before
    opened.evaluate("document.querySelector('.whole').click()")
    opened.wait(0.1)
    assert opened.messages == []


def test_a_cell_without_a_value_has_the_colour_of_the_theme(opened):
    fills = "[...document.querySelectorAll('.guides rect')].map((cell) => getComputedStyle(cell).fill)"
    light = opened.evaluate(fills)
    opened.evaluate("document.getElementById('theme').click()")
    dark = opened.evaluate(fills)
    opened.evaluate("document.getElementById('theme').click()")
    assert [one == other for one, other in zip(light, dark)] == [True, False, True, True]


@pytest.mark.parametrize(("number", "count"), [(1, 2), (2, 2)])
def test_a_name_hides_its_marks_and_shows_them_again(opened, number, count):
    marks = f"[...document.querySelectorAll('.plot-figure')[{number}].querySelectorAll('.mark[data-curve=\"0\"]')]"
    shown = f"{marks}.filter(mark => mark.getAttribute('visibility') !== 'hidden').length"
    press = f"document.querySelectorAll('.plot-figure')[{number}].querySelector('.legend button').click()"
    assert opened.evaluate(shown) == count
    opened.evaluate(press)
    assert opened.evaluate(shown) == 0
    opened.evaluate(press)
    assert opened.evaluate(shown) == count and opened.messages == []


def test_rows_have_names_and_no_numbers_also_when_zoomed(opened):
    ticks = "[...document.querySelectorAll('svg.plot')[2].querySelectorAll('.ticks text[text-anchor=\"end\"]')].length"
    names = "[...document.querySelectorAll('svg.plot')[2].querySelectorAll('.mark text')].map(text => text.textContent)"
    assert opened.evaluate(ticks) == 0 and opened.evaluate(names) == ["stiffness", "mass"]
    wheel(opened, 2, 0.5, 0.5, -200)
    assert opened.evaluate(ticks) == 0 and opened.messages == []
    opened.evaluate("document.querySelectorAll('.whole')[2].click()")
    opened.wait(0.1)


def test_the_cell_and_the_mark_at_the_pointer_are_read(opened):
    reading = "document.querySelector('.reading:not([hidden])')?.textContent"
    for place, text in (((0.25, 0.25), "a"), ((0.75, 0.25), "b"), ((0.75, 0.75), "d <e>")):
        pointed(opened, 0, *place)
        assert opened.evaluate(reading) == text
    pointed(opened, 1, 0.01, 0.02)  # near the first point, not on it
    assert opened.evaluate(reading) == "p"
    pointed(opened, 1, 0.5, 0.2)
    assert opened.evaluate(reading) is None
    rows = "[...document.querySelectorAll('svg.plot')[2].querySelectorAll('.mark')].map(m => [parseFloat(m.getAttribute('x')) / 100, m.getAttribute('y')])"
    (x, y), height = opened.evaluate(rows)[0], opened.evaluate("document.querySelectorAll('svg.plot')[2].clientHeight")
    pointed(opened, 2, x, 1 - float(y) / height)
    assert opened.evaluate(reading) == "stiffness, low: -1" and opened.messages == []


def test_what_is_drawn_is_saved_as_a_table(opened):
    cells, points, rows = tables(opened)
    assert cells.splitlines() == ["across (m),up (m),value (Hz)", "0.5,0.5,1", "1.5,0.5,NaN", "0.5,1.5,3", "1.5,1.5,4"]
    assert points.splitlines() == ["across (s),f (m),note", "0,0,p", "1,1,q"]
    assert rows.splitlines() == ["parameter,low: change,high: change", "stiffness,-1,1", "mass,2,-0.5"]


def test_a_finger_leaves_what_it_has_pointed_at(opened):
    x, y = opened.place("svg.plot", 0.25, 0.75)
    opened.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
    opened.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    opened.wait(0.05)
    assert opened.evaluate("document.querySelector('.reading:not([hidden])')?.textContent") == "c"
