"""The page in a browser, opened from disk: what it shows, what it can be asked, what it asks for."""

import json

import numpy as np
import pytest

from mbconstrained.page.animation import Animation
from mbconstrained.page.content import PageContent
from mbconstrained.page.drawing import Drawing, DrawnBody, DrawnLink
from mbconstrained.page.html import write_page
from tests.page.browser import needs_chromium
from tests.page.contents import HOSTILE, TIMES, hostile_content, positions, two_masses, two_masses_content, two_masses_drawing
from tests.page.models import gallery

pytestmark = [needs_chromium, pytest.mark.long]


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return write_page(tmp_path_factory.mktemp("pages") / "two masses.html", two_masses_content())


def written(tmp_path, content):
    return write_page(tmp_path / "page.html", content)


def test_it_opens_at_a_time_as_the_solution_is_then_and_asks_for_nothing_but_itself(browser, page):
    state = browser.open(page, "#t=1.25").state()
    browser.wait(0.3)
    assert (browser.messages, browser.requests, state["errors"]) == ([], [page.as_uri()], [])
    assert (state["time"], state["duration"], state["playing"]) == (1.25, 50.0, False)
    names, drawing, values = ("x1", "q1", "q2"), two_masses_drawing(), two_masses(np.array([1.25]))
    assert tuple(state["coordinates"]) == names
    assert list(state["coordinates"].values()) == pytest.approx(values[:, 0], rel=1e-11)
    for body in drawing.bodies:
        place = positions(drawing, body, names, values)[:, 0]
        assert state["nodes"][body.name]["position"] == pytest.approx(place, abs=1e-9)


def test_the_state_at_any_other_time_is_that_of_the_solution_too(browser, page):
    browser.open(page)
    for time in (0.0, 0.05, 1.3, 33.33, 49.99, 50.0):
        state = browser.evaluate(f"mbconstrained.seek({time}), mbconstrained.state()")
        known = two_masses(np.array([time]))[:, 0]
        assert list(state["coordinates"].values()) == pytest.approx(known, abs=1e-6), time


def test_the_play_button_plays_and_pauses(browser, page):
    browser.open(page)
    assert browser.state()["playing"] is False
    browser.click("#play")
    browser.until("state.time > 0.1")
    state = browser.state()
    assert state["playing"] is True
    assert 0.1 < state["time"] < 5
    assert state["coordinates"]["x1"] == pytest.approx(two_masses(np.array([state["time"]]))[0, 0], abs=1e-6)
    assert browser.evaluate("document.querySelector('#play').textContent") == "Pause"
    browser.click("#play")
    time = browser.state()["time"]
    browser.wait(0.2)
    assert browser.state()["time"] == time
    assert browser.state()["playing"] is False


def test_it_starts_again_at_the_end(browser, page):
    browser.open(page, "#t=49.9")
    browser.click("#play")
    browser.until("state.time < 10")
    assert browser.state()["playing"] is True


def test_the_slider_seeks(browser, page):
    browser.open(page)
    browser.evaluate("""(() => {
        const slider = document.querySelector("#time");
        slider.value = 1.25;
        slider.dispatchEvent(new Event("input", {bubbles: true}));
    })()""")
    assert browser.state()["time"] == 1.25
    assert browser.evaluate("document.querySelector('#clock').textContent") == "1.25 s"
    browser.click("#time")
    assert browser.state()["time"] == pytest.approx(25, abs=1)


def test_an_address_seeks_and_pauses_and_one_beyond_the_motion_is_brought_into_it(browser, page):
    browser.open(page, "#t=soon")
    found = [browser.state()["time"]]
    browser.click("#play")
    for fragment in ("#t=2.5", "#t=999", "#t=-3", "#other"):
        browser.evaluate(f"new Promise(done => {{ addEventListener('hashchange', done); location.hash = '{fragment}' }})")
        found.append(browser.state()["time"])
        assert browser.state()["playing"] is False
    assert found == [0, 2.5, 50, 0, 0]
    assert browser.state()["errors"] == []


def test_programs_can_seek_play_and_pause(browser, page):
    browser.open(page)
    state = browser.evaluate("mbconstrained.seek(1.25), mbconstrained.play(), mbconstrained.pause(), mbconstrained.state()")
    assert (state["time"], state["playing"]) == (1.25, False)
    assert state == browser.state()
    assert browser.evaluate("(() => { try { mbconstrained.seek('x') } catch (error) { return error.message } })()") == (
        "seek: found x; expected a time in seconds"
    )


def test_the_cursor_of_a_plot_follows_and_a_click_on_the_plot_seeks(browser, page):
    browser.open(page, "#t=25")
    place = "(() => { const b = document.querySelector('svg .cursor').getBoundingClientRect(); return b.x + b.width / 2 })()"
    middle = browser.evaluate(place)
    browser.press_at(*browser.place("svg.plot", 0.3))
    time = browser.state()["time"]
    assert time == pytest.approx(15, abs=0.1)
    left, _, width, _ = browser.box("svg .curves path")
    assert middle == pytest.approx(left + width / 2, abs=2)
    assert browser.evaluate(place) == pytest.approx(left + width * time / 50, abs=2)


def test_the_wheel_scrolls_the_page_and_zooms_only_with_the_control_key(browser, page):
    browser.open(page)
    middle, zooms = browser.place("#stage", 0.5), []
    for modifiers, effect in ((0, "window.scrollY > 0"), (2, "mbconstrained.viewer.camera.zoom < 1")):
        browser.mouse("mouseWheel", *middle, deltaX=0, deltaY=120, modifiers=modifiers)
        browser.until(effect)
        zooms.append(browser.evaluate("mbconstrained.viewer.camera.zoom"))
    assert zooms[0] == 1 and zooms[1] < 1
    browser.click("#reset")
    assert browser.evaluate("mbconstrained.viewer.camera.zoom") == 1


def test_dragging_turns_the_picture_and_not_the_model(browser, page):
    browser.open(page)
    before, nodes = browser.picture("#stage"), browser.state()["nodes"]
    for kind, across in (("mousePressed", 0.3), ("mouseMoved", 0.5), ("mouseReleased", 0.5)):
        browser.point("#stage", across, kind, button="left", clickCount=1)
    browser.wait(0.2)
    assert browser.picture("#stage") != before
    assert browser.state()["nodes"] == nodes


def test_a_spring_is_as_long_as_the_gap_it_spans(browser, tmp_path):
    bodies = (DrawnBody("wall", "ground"), DrawnBody("b", rest=(3, 0, 0), moves={"x": (1, 0, 0)}))
    drawing = Drawing(bodies, (DrawnLink("k", "spring", "wall", "b"),))
    path = written(tmp_path, PageContent("t", animation=Animation(drawing, ("x",), [0, 1], [[0, 0.5]])))
    browser.open(path)
    lengths = [
        browser.evaluate(f"""(() => {{
            mbconstrained.seek({time});
            const spring = mbconstrained.viewer.scene_tree.find(["mbconstrained", "links", "link 0", "<object>"]).object;
            spring.geometry.computeBoundingBox();
            return spring.geometry.boundingBox.max.x - spring.geometry.boundingBox.min.x;
        }})()""")
        for time in (0, 1)
    ]
    assert lengths == pytest.approx([3 - 0.1 - 0.4, 3.5 - 0.1 - 0.4], abs=1e-5)


def test_hostile_texts_are_shown_as_texts(browser, tmp_path):
    content = hostile_content()
    browser.open(written(tmp_path, content), "#t=1").wait(0.2)
    assert (browser.dialogs, browser.messages) == ([], [])
    assert browser.evaluate("document.querySelector('.label').textContent") == HOSTILE
    assert browser.evaluate("document.querySelector('h1').textContent") == content.title
    assert browser.state()["coordinates"] == {HOSTILE: 1}
    assert browser.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_names_that_are_special_in_javascript_are_names(browser, tmp_path):
    names = ("__proto__", "constructor", "toString")
    bodies = tuple(DrawnBody(name, rest=(i, 0, 0), moves={name: (1, 0, 0)}) for i, name in enumerate(names))
    animation = Animation(Drawing(bodies), names, [0, 1], [[0, 1], [0, 2], [0, 3]])
    browser.open(written(tmp_path, PageContent("t", animation=animation)), "#t=1")
    assert json.loads(browser.evaluate("document.body.dataset.state"))["coordinates"] == dict(zip(names, (1, 2, 3)))
    assert browser.state()["nodes"]["__proto__"]["position"] == [1, 0, 0]


def test_no_other_script_can_run(browser, page):
    browser.open(page)
    browser.evaluate("""(() => {
        const script = document.createElement("script");
        script.textContent = "window.entered = true";
        document.body.append(script);
    })()""")
    assert browser.evaluate("window.entered") is None
    assert browser.state()["errors"] == ["blocked: inline"]


@pytest.mark.parametrize("name", gallery().keys())
def test_every_kind_of_drawing_is_drawn(browser, tmp_path, name):
    path = written(tmp_path, PageContent(name, animation=gallery()[name]))
    browser.open(path)
    pictures = [(browser.evaluate(f"mbconstrained.seek({time})"), browser.picture("#stage"))[1] for time in (0, 4)]
    assert (browser.messages, browser.state()["errors"]) == ([], [])
    assert pictures[0] != pictures[1]
    assert browser.evaluate("mbconstrained.viewer.renderer.info.render.triangles") > 1000


def test_a_turned_body_is_turned(browser, tmp_path):
    disc = DrawnBody("disc", "disc", turns={"angle": (0, -1, 0)}, rest_turn=(0, -0.5, 0))
    animation = Animation(Drawing((disc,), turn_scale=2), ("angle",), [0, 1], [[0, 0.75]])
    state = browser.open(written(tmp_path, PageContent("t", animation=animation)), "#t=1").state()
    assert state["nodes"]["disc"]["quaternion"] == pytest.approx([0, -np.sin(1), 0, np.cos(1)])  # half of 0.5 + 2 * 0.75
    assert state["magnification"] == {"scale": 1, "turn_scale": 2}


@pytest.mark.parametrize(
    "drawing, times",
    [(Drawing(()), [0.5]), (Drawing((DrawnBody("still"),)), [0.0, 2.0])],
    ids=["no bodies and one time", "a body at rest"],
)
def test_pages_with_little_to_show(browser, tmp_path, drawing, times):
    animation = Animation(drawing, ("x",), times, np.full((1, len(times)), 3.0))
    browser.open(written(tmp_path, PageContent("t", animation=animation))).wait(0.1)
    browser.click("#play")
    state = browser.state()
    assert (browser.messages, state["errors"]) == ([], [])
    assert state["coordinates"] == {"x": 3}
    assert state["playing"] is (len(times) > 1)


def test_a_frame_moves_what_is_there_and_makes_nothing_new(browser, tmp_path):
    bodies = tuple(DrawnBody(f"b{i}", rest=(2.0 * i, 0, 0), moves={"x": (0.1 * (i % 2), 0, 0)}) for i in range(51))
    links = tuple(DrawnLink(f"k{i}", "spring", f"b{i}", f"b{i + 1}") for i in range(50))
    animation = Animation(Drawing(bodies, links), ("x",), TIMES, np.sin(TIMES)[None])
    browser.open(written(tmp_path, PageContent("t", animation=animation)))
    kept, moved, shapes = browser.evaluate("""(() => {
        const looks = () => {
            const found = [];
            mbconstrained.viewer.scene.traverse(object => object.geometry && found.push(
                [object.uuid, object.geometry.uuid, object.geometry.attributes.position.array, object.matrixWorld.elements.join()]
            ));
            return found;
        };
        mbconstrained.seek(0);
        mbconstrained.viewer.scene.updateMatrixWorld(true);
        const before = looks();
        for (let i = 1; i <= 20; i++) mbconstrained.seek(0.1 * i);
        mbconstrained.viewer.scene.updateMatrixWorld(true);
        const after = looks();
        const same = (one, other) => one[0] === other[0] && one[1] === other[1] && one[2] === other[2];
        return [
            before.length === after.length && before.every((one, i) => same(one, after[i])),
            before.filter((one, i) => one[3] !== after[i][3]).length,
            before.length,
        ];
    })()""")
    assert kept and moved >= 25 and shapes < 1000  # every second mass moves


def test_without_webgl_everything_else_is_shown(browser, page):
    with browser.beginning_with("HTMLCanvasElement.prototype.getContext = () => null"):
        state = browser.open(page, "#t=1.25").state()
    assert state["coordinates"]["x1"] == pytest.approx(two_masses(np.array([1.25]))[0, 0])
    assert state["errors"][0].startswith("The 3-D view cannot be shown: ")
    assert browser.evaluate("getComputedStyle(document.querySelector('.missing')).display") == "block"
    browser.click("#play")
    assert browser.state()["playing"] is True
