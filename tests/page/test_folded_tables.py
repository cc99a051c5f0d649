"""Folded tables on a page, and what a browser makes of them."""

import re

import pytest

from mbconstrained.ground.display import TextTable
from mbconstrained.ground.notices import Notice
from mbconstrained.page.content import Curve, PageContent, Plot
from mbconstrained.page.html import page_html, write_page
from tests.page.browser import needs_chromium


def content(**parts) -> PageContent:
    return PageContent(
        "Report",
        notices=(Notice("rank", "a notice"),),
        **{
            "plots": (Plot("a plot", "m", [0, 1], (Curve("x", [0, 1]),)),),
            **parts,
        },
    )


def test_a_folded_table_shows_its_title_only():
    table = TextTable("Plan <1>", ("stage",), (("solve",),), "a note", folded=True)
    page = page_html(content(tables=(table,)))
    inside = re.search(r"<details><summary><h2>Plan &lt;1&gt;</h2></summary>(.*?)</details>", page, re.DOTALL)[1]
    assert "<td>solve</td>" in inside and "a note" in inside
    assert "<details>" not in page_html(content(tables=(TextTable("Plan", ("stage",), (("solve",),)),)))


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    table = TextTable("Plan", ("stage",), (("solve",),), "a note", folded=True)
    return write_page(tmp_path_factory.mktemp("pages") / "tables.html", content(tables=(table,)))


def sized(browser, width: int):
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=800, deviceScaleFactor=1, mobile=False)


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
