"""What all tests of pages in a browser share."""

import pytest

from tests.page.browser import Browser


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """One Chromium for the tests of a file."""
    browser = Browser(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()
