"""Overlay in a browser: faint bodies, arrows and lists come and go with the time; a drawing is seen as it asks for."""

import math

import numpy as np
import pytest

from mbconstrained.page.animation import Animation, Arrow, DrawnEvent, ForceArrows, ImpulseArrow, Overlay
from mbconstrained.page.content import PageContent
from mbconstrained.page.drawing import Drawing, DrawnBody, Path, View
from mbconstrained.page.html import write_page
from tests.page.browser import needs_chromium

pytestmark = needs_chromium

TIMES = np.linspace(0.0, 50.0, 101)
X = np.cos(TIMES)
HOSTILE = "<img src=x onerror=alert(1)>"

#: What is seen: names of the visible objects below bodies and marks, the list, and what is written at arrows.
SEEN = """(() => {
    const tree = mbconstrained.viewer.scene_tree;
    const below = (name) => {
        const { children } = tree.find(["mbconstrained", name]);
        return Object.keys(children).filter((child) => children[child].object.visible);
    };
    const labels = [...document.querySelectorAll(".label.force, .label.impulse")].map((label) => label.textContent);
    return { bodies: below("bodies"), overlay: below("overlay"), list: document.querySelector(".event.shown")?.textContent ?? "",
             labels: labels.filter(Boolean) };
})()"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A cart with jumps and impulses at t = 0 and at t = 20 s, and a force that is drawn all the time."""
    bodies = (DrawnBody("cart", moves={"x": (1, 0, 0)}), DrawnBody("wheel", "disc", rest=(4, 0, 0), turns={"x": (0, -1, 0)}))
    first = DrawnEvent(
        0.0,
        ("at t = 0 s", HOSTILE),
        np.array([0.4]),
        np.array([1.0]),
        (ImpulseArrow(Arrow("cart", (1, 0, 0), "N s"), -3.0, "3 N s"),),
    )
    later = DrawnEvent(
        20.0, ("at t = 20 s",), X[40:41], X[40:41], (ImpulseArrow(Arrow("wheel", (0, -1, 0), "N m s", True), 2.0, "2 N m s"),)
    )
    force = ForceArrows("rod", 5 * X, -5 * np.sin(TIMES), ((Arrow("cart", (0, 0, 1), "N"), 1.0),))
    drawing = Drawing(bodies, view=View(0.0, 0.0, 2.0), turn=(0.0, -math.pi / 2, 0.0))
    given = Animation(drawing, ("x",), TIMES, [X], [-np.sin(TIMES)], Overlay((first, later), (force,)))
    return write_page(tmp_path_factory.mktemp("marks") / "page.html", PageContent("Impulses", animation=given))


def test_marks_come_and_go_with_the_time(browser, page):
    state = browser.open(page, "#t=0").state()
    assert (state["errors"], browser.messages, browser.dialogs) == ([], [], [])
    assert state["coordinates"] == pytest.approx({"x": 1.0, "force: rod": 5.0})
    seen = browser.evaluate(SEEN)
    assert seen == {
        "bodies": ["body 0", "body 1", "before 0"],
        "overlay": ["force 0 0", "impulse 0 0"],
        "list": f"at t = 0 s\n{HOSTILE}",
        "labels": ["5 N", "3 N s"],
    }
    seen = browser.evaluate(f"mbconstrained.seek(10), {SEEN}")
    assert (seen["bodies"], seen["overlay"], seen["list"]) == (["body 0", "body 1"], ["force 0 0"], "")
    assert seen["labels"] == [f"{abs(5 * math.cos(10)):.3g} N"]
    seen = browser.evaluate(f"mbconstrained.seek(20.5), {SEEN}")
    assert (seen["list"], seen["labels"][-1]) == ("at t = 20 s", "2 N m s") and "impulse 1 0" in seen["overlay"]
    assert browser.evaluate(f"mbconstrained.seek(0.1), {SEEN}.list.split('\\n')[0]") == "at t = 0 s"
    box = "document.querySelector('{}').getBoundingClientRect()".format
    below = f"{box('.events')}.top - {box('#stage')}.bottom"
    assert browser.evaluate(below) == pytest.approx(0, abs=1)  # the list is below the model, not over it


def test_an_arrow_of_a_body_that_turns_turns_with_it(browser, tmp_path):
    still, angles = np.zeros(101), TIMES / 10
    path = Path([5 * np.cos(angles), 5 * np.sin(angles), still], [still, still, np.sin(angles / 2), np.cos(angles / 2)])
    hold = (Arrow("hook", None, "N", point=(1, 0, 0)), 1.0)
    force = ForceArrows("pin", np.array([2 + still, X, still]), np.array([still, -np.sin(TIMES), still]), (hold,))
    given = Animation(
        Drawing((DrawnBody("hook", path=path),)), (), TIMES, np.zeros((0, 101)), np.zeros((0, 101)), Overlay((), (force,))
    )
    browser.open(write_page(tmp_path / "page.html", PageContent("t", animation=given)))
    for time in (0.0, 7.3):
        place, way, labels = browser.evaluate(f"""(() => {{
            mbconstrained.seek({time});
            const {{ object }} = mbconstrained.viewer.scene_tree.find(["mbconstrained", "overlay", "force 0 0"]);
            const way = new MeshCat.THREE.Vector3(1, 0, 0).applyQuaternion(object.quaternion);
            return [object.position.toArray(), way.toArray(), document.querySelector(".label.force").textContent];
        }})()""")
        angle, size = time / 10, np.hypot(2, np.cos(time))
        toward = angle + np.arctan2(np.cos(time), 2)
        assert place == pytest.approx([6 * np.cos(angle), 6 * np.sin(angle), 0], abs=1e-4)
        assert way == pytest.approx([np.cos(toward), np.sin(toward), 0], abs=1e-4) and labels == f"{size:.3g} N"
    assert browser.state()["errors"] == []


def test_a_turned_drawing_moves_the_way_it_was_turned_to(browser, page):
    heights = """(() => {
        const tree = mbconstrained.viewer.scene_tree;
        const cart = tree.find(["mbconstrained", "bodies", "body 0"]).object;
        return [0, Math.PI].map((time) => {
            mbconstrained.seek(time);
            cart.updateMatrixWorld(true);
            return cart.matrixWorld.elements.slice(12, 15);
        });
    })()"""
    (x, up, _), (x_later, up_later, _) = browser.open(page).evaluate(heights)
    assert (x, x_later) == pytest.approx((0, 0), abs=1e-6) and up - up_later == pytest.approx(2.0, abs=1e-3)
