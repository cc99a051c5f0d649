"""Maps, points and rows of names in a browser: they follow the zoom, and names show and hide what belongs to them."""

import numpy as np
import pytest

from mbconstrained.analyses.sweep.plots import row_plot
from mbconstrained.page.content import Cells, Curve, Marks, PageContent, Plot
from mbconstrained.page.html import write_page
from tests.page.browser import needs_chromium
from tests.page.plots.test_zoom_in_browser import wheel

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


def test_a_map_has_its_cells_and_texts_and_is_zoomed(opened):
    texts = opened.evaluate("[...document.querySelectorAll('.guides rect title')].map(title => title.textContent)")
    assert texts == ["a", "b", "c", "d <e>"]
    before = opened.evaluate("document.querySelector('.guides rect').getBoundingClientRect().width")
    wheel(opened, 0, 0.25, 0.25, -200)
    assert opened.evaluate("document.querySelector('.guides rect').getBoundingClientRect().width") > 1.2 * before
    assert opened.messages == []


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
