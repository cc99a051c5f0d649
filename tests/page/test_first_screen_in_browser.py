"""The first screen of pages of examples, on a desktop and on a phone: the motion and a plot or the modes, nothing cut or covered."""

import pytest

import mbconstrained as mb
from mbconstrained.analyses.modes import ModalAnalysis
from tests.page.browser import needs_chromium
from tests.scene.scenes import EXAMPLES

pytestmark = [needs_chromium, pytest.mark.long]
DESKTOP, PHONE = (1280, 800), (390, 844)
BOX = "(() => {{ const {{ top, bottom, left, right }} = document.querySelector('{}').getBoundingClientRect(); return [top, bottom, left, right]; }})()"


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """The pages of a run and of the modes of a flexible robot, and of a building."""
    folder, found = tmp_path_factory.mktemp("pages"), {}
    for name in ("satellite", "building_in_earthquake"):
        scene = mb.read_scene(EXAMPLES / f"{name}.toml")
        found[name, "run"] = scene.run().write_page(folder / f"{name}.html")
        ModalAnalysis.solve(scene).write(folder / "modes", ["page"])
        (found[name, "modes"],) = (folder / "modes").glob(f"{name}*.html")
    return found


@pytest.fixture
def opened(browser, pages):
    """Opens a page in a window of a size."""

    def open_page(name, kind, size):
        browser.size(*size, mobile=size == PHONE)
        return browser.open(pages[name, kind])

    yield open_page
    browser.call("Emulation.clearDeviceMetricsOverride")


@pytest.mark.parametrize("name", ["satellite", "building_in_earthquake"])
def test_motion_and_plot_are_on_the_first_screen(opened, name):
    page = opened(name, "run", DESKTOP)
    stage, plot = (page.evaluate(BOX.format(selector)) for selector in ("#stage", ".plot"))
    assert stage[3] < plot[2] and max(stage[1], plot[1]) < DESKTOP[1]  # next to each other
    page = opened(name, "run", PHONE)
    stage, plot = (page.evaluate(BOX.format(selector)) for selector in ("#stage", ".plot"))
    assert stage[1] < plot[0] and plot[1] < PHONE[1] + 60  # one below the other, the axis of time may be below the fold


@pytest.mark.parametrize("name", ["satellite", "building_in_earthquake"])
def test_the_card_of_frequencies_is_as_tall_as_its_table(opened, name):
    page = opened(name, "run", DESKTOP)
    (_, card, *_), (_, table, *_) = (page.evaluate(BOX.format(f".frequencies{part}")) for part in ("", " table"))
    assert 0 < card - table < 40
    assert page.evaluate("(box => box.scrollHeight <= box.clientHeight)(document.querySelector('.frequencies .scroll'))")


@pytest.mark.parametrize("size", [DESKTOP, PHONE])
def test_the_list_of_modes_opens_on_an_elastic_one_and_is_not_cut(opened, size):
    page = opened("satellite", "modes", size)
    assert (
        page.evaluate("[...document.querySelectorAll('tr[data-mode]')].findIndex(row => row.classList.contains('selected'))") == 0
    )
    assert page.state()["mode"] == 7  # after six rigid-body motions, which are folded
    assert page.evaluate("document.querySelector('.modes details').open") is False
    assert page.evaluate("document.querySelector('.modes summary').textContent") == "6 zero eigenvalues: rigid body"
    assert page.evaluate("(box => box.scrollWidth <= box.clientWidth)(document.querySelector('.modes .scroll'))")
    details = page.evaluate("document.querySelector('.details section:not([hidden])').textContent")
    assert "eigenvalue (1/s): " in details and "natural frequency (rad/s): " in details


def test_on_phones_further_controls_are_behind_one_button(opened):
    page = opened("satellite", "run", PHONE)
    shown = "document.getElementById('keys').offsetHeight > 0"
    assert not page.evaluate(shown)
    page.click("#more")
    assert page.evaluate(shown) and page.evaluate("document.getElementById('more').getAttribute('aria-expanded')") == "true"


@pytest.mark.parametrize("size", [DESKTOP, PHONE])
@pytest.mark.parametrize("kind", ["run", "modes"])
def test_names_lie_neither_on_the_caption_nor_on_each_other(opened, kind, size):
    page = opened("building_in_earthquake", kind, size)
    boxes = page.evaluate(
        """(() => {
            const range = document.createRange();
            range.selectNodeContents(document.querySelector(".magnification"));
            const labels = [...document.querySelectorAll(".label")].filter((label) => label.style.visibility === "visible");
            return [range, ...labels.filter((label) => label.textContent)].map((part) => {
                const { left, right, top, bottom } = part.getBoundingClientRect();
                return [left, right, top, bottom];
            });
        })()"""
    )
    assert len(boxes) >= 4
    for i, (left, right, top, bottom) in enumerate(boxes):
        for other in boxes[:i]:
            assert right <= other[0] or other[1] <= left or bottom <= other[2] or other[3] <= top
