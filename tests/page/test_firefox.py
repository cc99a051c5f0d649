"""The page in another browser: it runs without errors there, with the 3-D view or, where there is no WebGL, without it."""

import json

import pytest

from mbconstrained.scene.run.scene import read_scene
from tests.page.firefox import Firefox, needs_firefox
from tests.scene.scenes import EXAMPLES

pytestmark = [needs_firefox, pytest.mark.long]

#: Whether the 3-D view is there, or the words that say why not are seen.
VIEW = "[Boolean(mbconstrained.viewer), getComputedStyle(document.querySelector('.missing')).display]"


@pytest.fixture(scope="module")
def firefox(tmp_path_factory):
    browser = Firefox(tmp_path_factory.mktemp("firefox"))
    yield browser
    browser.close()


def test_a_robot_with_arrows_and_plots_runs_in_firefox(firefox, tmp_path):
    result = read_scene(EXAMPLES / "four_bar.toml").run()
    firefox.open(result.write_page(tmp_path / "page.html"))
    view, missing = firefox.evaluate(VIEW)
    assert missing == ("none" if view else "block")
    state = json.loads(firefox.evaluate("(mbconstrained.pause(), mbconstrained.seek(0.3), document.body.dataset.state)"))
    assert [error for error in state["errors"] if view or "WebGL" not in error] == []
    assert state["coordinates"]["crank pivot"] == pytest.approx(result.motion(0.3)[0], abs=1e-7)
    assert firefox.evaluate("document.getElementById('clock').textContent") == "0.300 s"
    firefox.evaluate("document.getElementById('theme').click()")
    assert firefox.evaluate("document.documentElement.dataset.theme") in ("dark", "light")
    assert firefox.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth") == 0
