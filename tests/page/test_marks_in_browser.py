"""Names, frames and centres of mass that can be shown, and the film of the motion, in a browser."""

import base64
import zipfile
from io import BytesIO

import numpy as np
import pytest
from matplotlib.image import imread

from mbconstrained.page.animation import Animation
from mbconstrained.page.content import PageContent
from mbconstrained.page.drawing import Drawing, DrawnBody, Path, Solid
from mbconstrained.page.html import write_page
from tests.page.browser import needs_chromium
from tests.page.robots import turned

pytestmark = [needs_chromium, pytest.mark.long]

ELLIPSOID = (0.2, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, 0.05, 0, 0.3, 0, 0.1, 1)  # column by column


def swinging(note: str = "", **options) -> PageContent:
    times = np.linspace(0, 1, 21)
    path = Path(np.zeros((3, 21)), turned((0, -1, 0), 0.4 * np.sin(6 * times)))
    bodies = (
        DrawnBody("arm", "solids", solids=(Solid("box", (0.6, 0.1, 0.1)),), path=path, **options),
        DrawnBody("wall", "ground"),
    )
    drawing = Drawing(bodies, note=note)
    return PageContent("A film: of <an> arm", animation=Animation(drawing, ("j",), times, np.sin(6 * times)[None]))


@pytest.fixture
def opened(browser, tmp_path):
    return browser.open(write_page(tmp_path / "page.html", swinging(ellipsoid=ELLIPSOID)))


def test_frames_and_centres_of_mass_are_shown_and_hidden(opened):
    def transparent():
        return opened.evaluate("""(() => {
            const found = [];
            mbconstrained.viewer.scene_tree.find(["mbconstrained", "bodies"]).object.traverseVisible((object) => {
                if (object.isMesh && !object.material.depthTest) found.push([object.position.toArray(), object.scale.toArray()]);
            });
            return found;
        })()""")

    def lines():
        return opened.evaluate("""(() => {
            let count = 0;
            mbconstrained.viewer.scene_tree.find(["mbconstrained", "bodies"]).object.traverseVisible((object) => {
                if (object.isLineSegments && !object.material.depthTest) count += 1;
            });
            return count;
        })()""")

    assert lines() == 0 and transparent() == []
    opened.click("input[data-shows=frames]")
    opened.click("input[data-shows=masses]")
    assert lines() == 1
    (place, scale), (dot, _) = transparent()
    assert place == pytest.approx([0.3, 0, 0.1]) and dot == pytest.approx(place) and scale == pytest.approx([0.2, 0.1, 0.05])
    opened.click("input[data-shows=frames]")
    opened.click("input[data-shows=masses]")
    assert lines() == 0 and transparent() == [] and opened.messages == []


def test_collision_geometry_is_shown_through_the_body_and_hidden(browser, tmp_path):
    page = write_page(tmp_path / "page.html", swinging(collision=(Solid("sphere", (0.3,)), Solid("box", (0.7, 0.2, 0.2)))))
    opened = browser.open(page)
    seen = """(() => {
        const opacities = [];
        mbconstrained.viewer.scene_tree.find(["mbconstrained", "bodies"]).object.traverseVisible((object) => {
            if (object.isMesh) opacities.push(object.material.opacity);
        });
        return opacities.sort();
    })()"""
    without, picture = opened.evaluate(seen), opened.picture("#stage")
    opened.click("input[data-shows=collision]")
    assert opened.evaluate(seen) == [0.35, 0.35, *without]
    assert opened.picture("#stage") != picture
    opened.click("input[data-shows=collision]")
    assert opened.evaluate(seen) == without and opened.picture("#stage") == picture
    assert opened.messages == []


def test_perspective_keeps_what_is_at_the_target_in_its_place_and_size_and_enlarges_what_is_nearer(opened):
    # from the target of the view: nothing, across, upwards in the picture, and towards the eye and across
    seen = """(() => {
        const { camera, controls } = mbconstrained.viewer;
        camera.updateMatrixWorld();
        const [across, up, near] = [0, 1, 2].map((k) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, k).multiplyScalar(2));
        const points = [new THREE.Vector3(), across, up, near.add(across)];
        return points.map((point) => point.add(controls.target).project(camera).toArray().slice(0, 2));
    })()""".replace("THREE", "MeshCat.THREE")
    picture, flat = opened.picture("#stage"), np.array(opened.evaluate(seen))
    opened.click("input[data-shows=perspective]")
    deep = np.array(opened.evaluate(seen))
    assert deep[:3] == pytest.approx(flat[:3], abs=1e-6)
    assert deep[3, 0] - deep[0, 0] > 1.05 * (flat[3, 0] - flat[0, 0])
    assert opened.picture("#stage") != picture
    opened.evaluate("document.querySelector('#reset').click()")
    assert np.array(opened.evaluate(seen)) == pytest.approx(deep, abs=1e-6)
    opened.click("input[data-shows=perspective]")
    assert opened.picture("#stage") == picture and np.array(opened.evaluate(seen)) == pytest.approx(flat, abs=1e-6)
    assert opened.messages == [] and opened.state()["errors"] == []


def keep_what_is_saved(opened):
    """In window.saved: each file that the page saves from now on, then its name."""
    opened.evaluate("""void (() => {
        if (window.saved) return void (saved.length = 0);
        const make = URL.createObjectURL;
        window.saved = [];
        URL.createObjectURL = (blob) => (saved.push(blob), make.call(URL, blob));
        HTMLAnchorElement.prototype.click = function () { saved.push(this.download); };
    })()""")


def saved(opened) -> tuple[str, str, bytes]:
    """Type, name and content of the first file, once it is saved."""
    opened.until("window.saved.length === 2")
    kind, name, text = opened.evaluate("""(async () => {
        const bytes = new Uint8Array(await window.saved[0].arrayBuffer());
        return [window.saved[0].type, window.saved[1], btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""))];
    })()""")
    return kind, name, base64.b64decode(text)


def pictures_of(archive: bytes) -> dict[str, bytes]:
    """The PNG files in a ZIP archive."""
    with zipfile.ZipFile(BytesIO(archive)) as files:
        assert files.testzip() is None  # checks every CRC
        return {name: files.read(name) for name in files.namelist()}


def test_a_film_has_the_motion_from_start_to_end(opened):
    keep_what_is_saved(opened)
    assert opened.evaluate("document.getElementById('record').hidden") is False
    opened.evaluate("mbconstrained.seek(0.7), (document.getElementById('speed').selectedIndex = 6)")  # as short as it gets
    opened.click("#record")
    assert opened.evaluate("document.getElementById('record').textContent") == "Stop"
    assert opened.state()["time"] < 0.7
    kind, name, content = saved(opened)
    assert len(content) > 1000  # more than the header
    assert (kind, name, content[:4]) == ("video/webm", "A_film_of_an_arm.webm", b"\x1a\x45\xdf\xa3")  # EBML
    state = opened.state()
    assert (state["playing"], state["time"], state["errors"]) == (False, 1, []) and opened.messages == []
    assert opened.evaluate("document.getElementById('record').textContent") == "Record"


def grey(browser, png: bytes) -> np.ndarray:
    """A picture of the stage in the box of the text over it, from 0 to 1."""
    left, top, width, height = np.round(np.subtract(browser.box(".magnification"), [*browser.box("#stage")[:2], 0, 0])).astype(int)
    return imread(BytesIO(png))[top : top + height, left : left + width, :3].mean(axis=2)


def test_frames_are_pictures_of_the_whole_motion_in_an_archive(opened):
    keep_what_is_saved(opened)
    opened.evaluate("document.getElementById('speed').selectedIndex = 6")
    speed = float(opened.evaluate("document.getElementById('speed').value"))
    opened.click("#frames")
    kind, name, content = saved(opened)
    assert (kind, name) == ("application/zip", "A_film_of_an_arm.zip")
    names, frames = map(list, zip(*pictures_of(content).items()))
    assert len(frames) == int(30 / speed + 1e-6) + 1  # 1 s at 30 a second
    assert names[0] == "frame_0001.png" and names == sorted(names)
    assert all(frame.startswith(b"\x89PNG\r\n\x1a\n") for frame in frames) and len(set(frames)) == len(frames)
    assert opened.evaluate("document.getElementById('frames').textContent") == "Save frames" and opened.messages == []
