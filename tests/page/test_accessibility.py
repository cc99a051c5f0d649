"""The rules of accessibility, as axe-core knows them, on each kind of page, light and dark, wide and narrow.

axe-core is installed into a temporary folder when these tests run; without npm or without a network they are skipped.
"""

import shutil
import subprocess
from pathlib import Path

import pytest

from mbconstrained.page.html import page_html, write_page
from tests.page.browser import needs_chromium
from tests.page.contents import plotted_content
from tests.page.mode_pages import two_modes
from tests.page.switched_motions import ball

pytestmark = [needs_chromium, pytest.mark.long]


@pytest.fixture(scope="module")
def axe(tmp_path_factory):
    """The script of axe-core."""
    npm = shutil.which("npm")
    if npm is None:
        pytest.skip("no npm is installed, which brings axe-core")
    folder = tmp_path_factory.mktemp("axe")
    shutil.copy(Path(__file__).with_name("axe") / "package.json", folder)
    quietly = ("--ignore-scripts", "--no-audit", "--no-fund", "--no-update-notifier")
    try:
        done = subprocess.run([npm, "install", *quietly], cwd=folder, capture_output=True, text=True, timeout=120)
    except subprocess.TimeoutExpired:
        pytest.skip("npm could not install axe-core within two minutes")
    if done.returncode:
        pytest.skip(f"npm could not install axe-core: {done.stderr.strip()[-200:]}")
    return (folder / "node_modules/axe-core/axe.min.js").read_text(encoding="utf-8")


def violations(browser, axe):
    """Rule, element and what is wrong with it."""
    browser.evaluate(f"{axe}; true")
    return browser.evaluate("""axe.run(document, {resultTypes: ["violations"]}).then(({violations}) =>
        violations.flatMap(rule => rule.nodes.map(node => [rule.id, node.html.slice(0, 100), node.failureSummary])))""")


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    (folder / "modes.html").write_text(page_html(two_modes()), encoding="utf-8")
    run = write_page(folder / "run.html", plotted_content())
    return {"run": run, "modes": folder / "modes.html", "phases": ball().write_page(folder / "phases.html")}


@pytest.mark.parametrize("name", ["run", "modes", "phases"])
def test_no_rule_is_broken(browser, axe, pages, name):
    for scheme, width in (("light", 1100), ("dark", 1100), ("light", 400)):
        browser.prefers(color_scheme=scheme, reduced_motion="reduce")
        browser.size(width, 900)
        browser.open(pages[name])
        assert violations(browser, axe) == [], (scheme, width)
    if name == "run":
        browser.evaluate("document.querySelector('.legend button').click()")
        browser.evaluate("document.querySelectorAll('details').forEach(details => details.open = true)")
        assert violations(browser, axe) == [], "with everything unfolded"
        browser.evaluate("document.querySelector('#keys').click()")
        assert violations(browser, axe) == [], "with the list of keys"
        browser.evaluate("document.querySelector('#close').click(), document.body.style.setProperty('--muted', '#999')")
        assert {rule for rule, *_ in violations(browser, axe)} >= {"color-contrast"}  # what is wrong is found
