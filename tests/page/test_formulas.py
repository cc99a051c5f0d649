"""The formula section of a page: MathML as it was made, everything else escaped, and a look at it in a browser."""

import sympy

from mbconstrained.exact.closed_form import ClosedForm
from mbconstrained.exact.formula_printers import mathml
from mbconstrained.page.content import Formulas, PageContent
from mbconstrained.page.html import page_html, write_page
from tests.exact.formulas.answers import hostile, t
from tests.page.browser import needs_chromium


def page_of(form: ClosedForm, note: str = "") -> PageContent:
    return PageContent("Formulas", formulas=Formulas("Formula", mathml(form), note))


def test_hostile_names_stay_texts():
    content = page_of(hostile())
    assert all(line.startswith("<math") and line.endswith("</math>") for line in content.formulas.lines)
    assert "<script" not in page_html(content)


@needs_chromium
def test_long_formulas_scroll_in_their_box_and_nothing_is_fetched(browser, tmp_path):
    wide = sum(sympy.Symbol(f"amplitude{i}") for i in range(60)) * sympy.cos(t)
    page = write_page(tmp_path / "page.html", page_of(ClosedForm(("x",), (wide,), t)))
    browser.open(page).wait(0.2)
    assert browser.messages == [] and browser.requests == [page.as_uri()]
    box, page_width = (
        browser.evaluate(f"{where}.scrollWidth > {where}.clientWidth")
        for where in ("document.querySelector('.formula')", "document.documentElement")
    )
    assert box is True and page_width is False


@needs_chromium
def test_the_browser_sets_the_formula(browser, tmp_path):
    form = ClosedForm(("x1",), (sympy.sqrt(sympy.Symbol("k")) * t / 3,), t)
    browser.open(write_page(tmp_path / "page.html", page_of(form))).wait(0.2)
    height = browser.evaluate("document.querySelector('mfrac').getBoundingClientRect().height")
    assert height > 25  # two lines: the fraction is set as one
    assert browser.evaluate("document.querySelector('math msub').textContent") == "x1"
