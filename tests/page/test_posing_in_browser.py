"""Sliders that pose a robot, in a browser: the links stand where the model puts them."""

from functools import cache

import numpy as np
import pytest

from mbconstrained.analyses.modes import ModalAnalysis
from mbconstrained.scene.run.drawing import RobotPicture
from mbconstrained.scene.run.scene import read_scene
from tests.page.browser import needs_chromium
from tests.scene.scenes import EXAMPLES

pytestmark = [needs_chromium, pytest.mark.long]


def moved(browser, share: float) -> None:
    """All sliders at a share of their limits."""
    browser.evaluate(f"""document.querySelectorAll("input[data-joint]").forEach((slider) => {{
        slider.value = {share} * slider.max;
        slider.dispatchEvent(new Event("input"));
    }})""")


@pytest.fixture(scope="module")
def opened(browser, tmp_path_factory):
    """Opens the page of the modes of an example: the picture of its robot and how its sliders pose it."""

    @cache
    def written(name):
        scene = read_scene(EXAMPLES / f"{name}.toml")
        (page,) = ModalAnalysis.solve(scene).write(tmp_path_factory.mktemp(name), ["page"])
        picture = RobotPicture(scene.equations.robot_scene)
        return page, picture, picture.posing()

    def open_page(name):
        page, picture, posing = written(name)
        browser.open(page)
        return picture, posing

    return open_page


def error(browser, picture, posing, share) -> float:
    """Largest distance of a link from the place that the model gives it, loops closed, as a share of the robot's size."""
    values = posing.columns @ (share * np.array(posing.limits))
    poses = picture.poses(values[:, None])
    nodes = browser.state()["nodes"]
    return max(np.abs(nodes[name]["position"] - pose.positions[:, 0]).max() for name, pose in poses.items()) / picture.size


def test_links_without_loops_are_posed_exactly(browser, opened):
    picture, posing = opened("seven_joint_arm")
    for share in (1.0, -0.4):
        moved(browser, share)
        assert error(browser, picture, posing, share) < 1e-8
        for link, pose in picture.poses(posing.columns @ (share * np.array(posing.limits))[:, None]).items():
            found, known = np.array(browser.state()["nodes"][link]["quaternion"]), pose.quaternions[:, 0]
            assert abs(found @ known) == pytest.approx(1, abs=1e-8)
    assert browser.messages == []


@pytest.mark.parametrize("name", ["quadruped", "delta"])
def test_loops_are_closed_to_first_order(browser, opened, name):
    picture, posing = opened(name)
    errors = []
    for share in (0.2, 0.1):
        moved(browser, share)
        errors.append(error(browser, picture, posing, share))
    assert errors[0] < 0.01
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.2)


def test_the_posture_and_the_motion_come_back(browser, opened):
    picture, posing = opened("seven_joint_arm")
    before = browser.evaluate("mbconstrained.seek(0.3), mbconstrained.state()")["nodes"]
    moved(browser, 0.5)
    browser.evaluate("document.querySelector('.joints').open = true")
    assert browser.evaluate("getComputedStyle(document.querySelector('.magnification')).visibility") == "hidden"
    assert browser.evaluate("document.querySelector('.joints output').textContent") == "0.125 rad"
    browser.click("#posture")
    assert error(browser, picture, posing, 0.0) < 1e-8
    browser.evaluate("mbconstrained.seek(0.3)")
    assert browser.state()["nodes"] == before
    assert browser.evaluate("getComputedStyle(document.querySelector('.magnification')).visibility") == "visible"
    moved(browser, 0.5)
    browser.click("#play")
    browser.until("state.playing && document.querySelector('input[data-joint]').value === '0'")
    assert browser.messages == []


def test_the_page_of_a_run_has_sliders_too_and_hides_arrows_while_posed(browser, tmp_path):
    result = read_scene(EXAMPLES / "four_bar.toml").run()
    browser.open(result.write_page(tmp_path / "run.html"))
    moved(browser, 1.0)
    assert browser.evaluate("mbconstrained.viewer.scene_tree.find(['mbconstrained', 'overlay']).object.visible") is False
    assert browser.state()["errors"] == browser.messages == []
