"""The browser of the tests: one that ends is told, and costs no other test."""

import pytest

from tests.page.browser import Browser, BrowserEnded, needs_chromium

pytestmark = needs_chromium


def crash(browser):
    browser.call("Page.crash")


def kill(browser):
    browser.process.kill()
    browser.process.wait()


def test_one_that_ends_is_told_and_the_next_page_has_a_new_one(tmp_path):
    page = tmp_path / "page.html"
    page.write_text("<title>here</title>")
    browser = Browser(tmp_path)
    try:
        for end, words in ((crash, "the tab has crashed"), (kill, "the browser has ended")):
            browser.open(page)
            with pytest.raises(BrowserEnded, match=words):
                end(browser)
                browser.evaluate("document.title")
                browser.evaluate("document.title")
            assert browser.open(page).evaluate("document.title") == "here"
    finally:
        browser.close()
    browser.process.wait(0)
