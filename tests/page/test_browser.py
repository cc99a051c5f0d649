"""The browser of the tests: one that ends is told, and costs no other test."""

import pytest

from tests.page.browser import Browser, BrowserEnded, needs_chromium

pytestmark = needs_chromium


@pytest.mark.parametrize("how", ["killed", "crashed"])
def test_one_that_ends_is_told_and_the_next_page_has_a_new_one(tmp_path, how):
    page = tmp_path / "page.html"
    page.write_text("<title>here</title>")
    browser = Browser(tmp_path)
    try:
        browser.open(page)
        with pytest.raises(BrowserEnded, match="the browser has ended" if how == "killed" else "the tab has crashed"):
            if how == "killed":
                browser.process.kill()
                browser.process.wait()
            else:
                browser.call("Page.crash")
            browser.evaluate("document.title")
            browser.evaluate("document.title")
        assert browser.open(page).evaluate("document.title") == "here"
    finally:
        browser.close()
    browser.process.wait(0)
