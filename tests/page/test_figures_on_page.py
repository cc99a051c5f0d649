"""Still pictures and folded tables on a page: where they stand, what they may hold, what a browser makes of them."""

import html
import re

import pytest

from mbconstrained.analyses.figures import Picture
from mbconstrained.ground.display import TextTable
from mbconstrained.ground.notices import Notice
from mbconstrained.page.content import Curve, Figure, PageContent, Plot
from mbconstrained.page.html import page_html, write_page
from tests.page.browser import needs_chromium
from tests.page.contents import HOSTILE
from tests.page.svg import checked_svg

PLAIN = '<svg viewBox="0 0 4 1"><path d="M0 0H4"/><text x="0" y="1">a &lt;script&gt; onload=x url(http:)</text></svg>'


def content(**parts) -> PageContent:
    return PageContent(
        "Report",
        notices=(Notice("rank", "a notice"),),
        **{
            "plots": (Plot("a plot", "m", [0, 1], (Curve("x", [0, 1]),)),),
            "figures": (Figure("A picture", PLAIN, "A line.", "note in m/s^2"),),
            **parts,
        },
    )


def picture(text: str = HOSTILE) -> Picture:
    """A matplotlib picture with everything that its SVG may bring: markers, shades, dashes, clipping, hatches, texts."""

    def draw(figure):
        axes = figure.add_subplot()
        axes.plot([0, 1], [0, 1], "o--", label=text.replace("\u2028", ""))
        axes.fill_between([0, 1], [0, 1], alpha=0.3, hatch="//")
        axes.set_title(text.replace("\u2028", ""))
        axes.legend()

    return Picture("From matplotlib", "A line from 0 to 1.", 3.0, draw)


def test_pictures_stand_between_notices_and_plots():
    page = page_html(content())
    places = [page.index(part) for part in ("a notice", "<h2>A picture</h2>", "<path", "note in m/s²", "<h2>a plot</h2>")]
    assert places == sorted(places)


def test_the_description_is_the_name_of_the_picture_for_those_who_do_not_see_it():
    page = page_html(content(figures=(Figure(HOSTILE, PLAIN, HOSTILE, HOSTILE),), plots=()))
    assert f'<svg role="img" aria-label="{html.escape(HOSTILE)}" viewBox="0 0 4 1">' in page
    assert f"<h2>{html.escape(HOSTILE)}</h2>" in page and "<script" not in page


def test_a_page_with_pictures_has_no_script_and_its_policy_allows_none():
    pictures = content(figures=(picture().on_page(),), plots=())
    checked_svg(pictures.figures[0].svg)
    page = page_html(pictures)
    assert "<script" not in page and "script-src 'none'" in page
    assert page == page_html(pictures)


def test_a_folded_table_shows_its_title_only():
    table = TextTable("Plan <1>", ("stage",), (("solve",),), "a note", folded=True)
    page = page_html(content(tables=(table,)))
    inside = re.search(r"<details><summary><h2>Plan &lt;1&gt;</h2></summary>(.*?)</details>", page, re.DOTALL)[1]
    assert "<td>solve</td>" in inside and "a note" in inside
    assert "<details>" not in page_html(content(tables=(TextTable("Plan", ("stage",), (("solve",),)),)))


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    table = TextTable("Plan", ("stage",), (("solve",),), "a note", folded=True)
    figures = (picture().on_page(), picture("Another").on_page())
    return write_page(tmp_path_factory.mktemp("pages") / "figures.html", content(tables=(table,), figures=figures))


def sized(browser, width: int):
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=800, deviceScaleFactor=1, mobile=False)


@needs_chromium
def test_nothing_is_blocked_or_asked_for(browser, page):
    browser.open(page).wait(0.2)
    assert (browser.messages, browser.requests, browser.dialogs) == ([], [page.as_uri()], [])
    kinds = browser.evaluate("[...document.scripts].map(script => script.type)")
    assert sorted(kinds) == ["", "application/json"]  # those of the plot: one that runs, and the numbers
    assert browser.evaluate("document.querySelectorAll('svg image, svg style, img').length") == 0


@needs_chromium
def test_the_browser_shows_the_texts_and_shapes_of_the_picture(browser, page):
    browser.open(page)
    shown = browser.evaluate("[...document.querySelectorAll('.static svg text')].map(text => text.textContent)")
    assert shown.count(HOSTILE.replace("\u2028", "")) == 2
    boxes = browser.evaluate(
        "[...document.querySelectorAll('.static use, .static path')].filter(e => e.closest('defs') === null).map(e => e.getBBox().width + e.getBBox().height)"
    )
    assert len(boxes) > 20 and max(boxes) > 100
    family, size = browser.evaluate("(s => [s.fontFamily, s.fontSize])(getComputedStyle(document.querySelector('.static text')))")
    assert family.startswith("system-ui") and size == "8px"


@needs_chromium
@pytest.mark.parametrize("width", [1280, 900, 400])
def test_pictures_take_the_width_and_scroll_where_it_is_narrow(browser, page, width):
    sized(browser, width)
    browser.open(page)
    drawn, box = browser.evaluate(
        "['svg', '.scroll'].map(kind => document.querySelector('.static ' + kind).getBoundingClientRect().width)"
    )
    assert drawn == pytest.approx(max(800, box), abs=1)
    assert browser.evaluate("document.documentElement.scrollWidth <= innerWidth")


@needs_chromium
def test_a_folded_table_opens_by_a_click_and_on_paper(browser, page):
    sized(browser, 1280)
    browser.open(page)
    visible = "document.querySelector('.folded td').checkVisibility()"
    assert not browser.evaluate(visible)
    browser.call("Emulation.setEmulatedMedia", media="print")
    browser.until(visible)
    assert browser.evaluate("document.querySelector('.folded').getBoundingClientRect().height") > 60
    browser.call("Emulation.setEmulatedMedia", media="")
    browser.until(f"!{visible}")
    browser.click(".folded summary")
    assert browser.evaluate(visible)
