"""Pages whose scripts are compressed, or whose viewer lies beside them; large pages; what is said where something is missing."""

import json
import os

import numpy as np
import pytest

from mbconstrained.page.animation import Animation
from mbconstrained.page.content import Curve, PageContent, Plot
from mbconstrained.page.drawing import Drawing, DrawnBody, DrawnLink
from mbconstrained.page.html import VIEWER_FILE, write_page
from tests.page.browser import needs_chromium
from tests.page.contents import many, two_masses, two_masses_content

pytestmark = [needs_chromium, pytest.mark.long]


def ready(browser):
    """Waits until the scripts have been unpacked."""
    until = "new Promise(resolve => (function look() { window.mbconstrained ? resolve() : setTimeout(look, 20) })())"
    browser.evaluate(until)
    return browser.state()


@pytest.mark.parametrize("viewer", ["compressed", "separate"])
def test_the_picture_moves_wherever_its_viewer_comes_from(browser, tmp_path, viewer):
    page = write_page(tmp_path / "page.html", two_masses_content(), viewer)
    state = ready(browser.open(page, "#t=1.25"))
    assert list(state["coordinates"].values()) == pytest.approx(two_masses(np.array([1.25]))[:, 0], rel=1e-11)
    assert (browser.messages, state["errors"]) == ([], [])
    files = {"page.html"} | ({VIEWER_FILE} if viewer == "separate" else set())
    assert {os.path.basename(address) for address in browser.requests} == files == set(os.listdir(tmp_path))
    assert browser.evaluate("mbconstrained.viewer.renderer.info.render.triangles") > 1000
    browser.click("#play")
    browser.until("state.time > 1.25")


@pytest.mark.parametrize("viewer", ["inside", "compressed"])
def test_a_large_page_moves_as_the_motion_does_between_its_times_too(browser, tmp_path, viewer):
    drawing, names, frequencies, times, values, rates = many()
    content = PageContent("t", animation=Animation(drawing, names, times, values, rates))
    page = write_page(tmp_path / "page.html", content, viewer)
    asked = float(times[777] + 0.4 * times[1])
    state = ready(browser.open(page, f"#t={asked!r}"))
    assert (browser.messages, state["errors"]) == ([], [])
    found = [state["nodes"][name]["position"][0] for name in names]
    wanted = np.array([body.rest[0] for body in drawing.bodies]) + 5 + np.sin(frequencies[:, 0] * asked)
    assert found == pytest.approx(wanted, abs=2e-3)  # a tenth of a pixel of 4000 for 62 drawing units is 1.6e-3
    assert page.stat().st_size < 1_400_000


def test_a_viewer_that_was_left_behind_is_named_and_the_rest_is_shown(browser, tmp_path):
    page = write_page(tmp_path / "page.html", two_masses_content(), "separate")
    (tmp_path / VIEWER_FILE).unlink()
    browser.open(page)
    missing = "The 3-D view needs the file mbconstrained-viewer.js in the folder of this page."
    assert browser.evaluate("document.querySelector('.missing').textContent") == missing
    browser.click("svg.plot")
    assert browser.state()["time"] == pytest.approx(25, abs=0.5)


def test_a_browser_that_cannot_unpack_says_so_and_shows_plots_and_tables(browser, tmp_path):
    page = write_page(tmp_path / "page.html", two_masses_content(), "compressed")
    with browser.beginning_with("delete window.DecompressionStream"):
        browser.open(page).wait(0.1)
    assert "too old to decompress it" in browser.evaluate("document.querySelector('.missing').innerText")
    assert browser.evaluate("document.querySelectorAll('svg.plot path').length") == 3
    assert browser.messages == []


def test_two_hundred_bodies_and_two_thousand_frames_play(browser, tmp_path):
    count, times = 200, np.linspace(0, 40, 2001)
    names = tuple(f"x{i}" for i in range(count))
    values = np.sin(np.outer(1 + 0.01 * np.arange(count), times))
    bodies = tuple(
        DrawnBody(f"m{i}", rest=(2 * (i % 20), 3 * (i // 20), 0), moves={name: (0.3, 0, 0)}) for i, name in enumerate(names)
    )
    links = tuple(DrawnLink(f"k{i}", "spring", f"m{i}", f"m{i + 1}") for i in range(count - 1) if i % 20 != 19)
    plot = Plot("displacement", "m", times, tuple(Curve(name, row) for name, row in zip(names, values)))
    animation = Animation(Drawing(bodies, links), names, times, values)
    page = write_page(tmp_path / "page.html", PageContent("many", animation=animation, plots=(plot,)))
    assert page.stat().st_size < 4.2e6  # 1 MB of viewer, and all 200 curves with the digits that their readings show
    state = browser.open(page, "#t=20.007").state()
    step = 2 / 65535  # of values from -1 to 1 as codes of 16 bits: half of it is a ten thousandth of a pixel here
    found = np.sin((1 + 0.01 * np.arange(count)) * 20.007)
    assert list(state["coordinates"].values()) == pytest.approx(found, abs=0.75 * step)  # and what that adds to the slopes
    assert browser.evaluate("mbconstrained.viewer.renderer.info.render.triangles") < 200_000
    reach = """((time) => {
        mbconstrained.seek(time);
        const { scale, geometry } = mbconstrained.viewer.scene_tree.find(["mbconstrained", "links", "link 9", "<object>"]).object;
        geometry.computeBoundingBox();
        return scale.x * geometry.boundingBox.max.x;
    })"""
    unit = json.loads(browser.evaluate("document.getElementById('motion-data').textContent"))["figure"]["unit"]
    first, later = (browser.evaluate(f"{reach}({float(times[key])!r})") for key in (0, 900))
    assert (later - first) * unit == pytest.approx(0.3 * (values[10, 900] - values[9, 900]), abs=1e-3)  # it stays at its bodies
    browser.evaluate("mbconstrained.seek(20.007)")
    browser.evaluate("window.drawn = 0; mbconstrained.viewer.render = () => { drawn++ }")  # without what a software renderer takes
    browser.evaluate("mbconstrained.play()")
    browser.until("drawn >= 20 && state.time > 20.5")
    assert (browser.messages, browser.state()["errors"]) == ([], [])
