"""Rotors in a browser: the shaft bends as a beam through its stations, and orbits are the paths of its points."""

import numpy as np
import pytest

from mbconstrained.page.animation import Animation
from mbconstrained.page.automatic_drawing import lumped_drawing
from mbconstrained.page.content import PageContent
from mbconstrained.page.html import write_page
from tests.page.browser import needs_chromium
from tests.page.contents import positions
from tests.page.drawing.test_bars import shaft

pytestmark = [needs_chromium, pytest.mark.long]
SPEED, TIME = 4 * np.pi, 0.8
TIMES = np.linspace(0, 1, 201)  # two revolutions


def rings(name: str, sides: int) -> str:
    """The middle line of a wire, in the units of the drawing."""
    return f"""(() => {{
        const found = [];
        mbconstrained.viewer.scene_tree.find(["mbconstrained", "links", "{name}", "<object>"]).object.traverse((mesh) => {{
            if (mesh.geometry && mesh.geometry.type === "BufferGeometry") found.push(mesh.geometry.attributes.position.array);
        }});
        const [array] = found, points = [], scale = mbconstrained.viewer.scene_tree.find(["mbconstrained", "bodies"]).object.scale.x;
        for (let i = 0; i < array.length; i += 3 * {sides}) {{
            const sum = [0, 0, 0];
            for (let k = 0; k < 3 * {sides}; k++) sum[k % 3] += array[i + k] / {sides} / scale;
            points.push(sum);
        }}
        return points;
    }})()"""


@pytest.fixture(params=[2 * np.pi / SPEED, None], ids=["run", "cycle"])
def whirling(request, browser, tmp_path):
    """The page of a rotor in circular whirl with a tilt, its drawing and the values of its coordinates."""
    model = shaft()
    names = model.coordinates
    amplitudes = {"compressor": 1.0, "disc": 1.6, "turbine": -0.8, "left": 0.7, "right": -0.5, "inner": 1.2, "near": -1.0}
    values = []
    for name in names:
        body, plane, *angle = name.split(" ")
        amplitude = 1e-3 * (-1.0 if angle else amplitudes[body])
        values.append(amplitude * np.cos(SPEED * TIMES - (np.pi / 2 if plane == "z" else 0.0)))
    drawing = lumped_drawing(model.elements, names, np.array(values))
    drawing = type(drawing)(**{**vars(drawing), "revolution": request.param})
    animation = Animation(drawing, names, TIMES, np.array(values))
    browser.open(write_page(tmp_path / "page.html", PageContent("t", animation=animation)))
    browser.evaluate(f"mbconstrained.pause(), mbconstrained.seek({TIME})")
    return browser, drawing, names, np.array(values)


def test_the_shaft_bends_as_a_beam_without_load_between_its_stations(whirling):
    browser, drawing, *_ = whirling
    (number,) = [i for i, link in enumerate(drawing.links) if link.kind == "shaft"]
    stations = drawing.links[number].stations
    nodes = browser.state()["nodes"]
    line = np.array(browser.evaluate(rings(f"link {number}", 24)))
    assert len(line) == 12 * (len(stations) - 1) + 1

    def pose(body):
        x, y, z, w = nodes[body]["quaternion"]
        turn = np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ])  # fmt: skip
        return np.array(nodes[body]["position"]), turn

    places, slopes = [], []
    for body, point, tilts in stations:
        place, turn = pose(body)
        places.append(place + turn @ point)
        slopes.append(turn[:, 0] if tilts else None)
    assert np.abs(line[::12] - places).max() < 1e-6
    k = next(i for i in range(len(stations) - 1) if slopes[i] is not None and slopes[i + 1] is not None and i)
    # the middle of a beam without load: mean of its ends, and an eighth of its length times the difference of its slopes
    length = np.linalg.norm(places[k + 1] - places[k])
    middle = (places[k] + places[k + 1]) / 2 + length / 8 * (slopes[k] - slopes[k + 1])
    assert line[12 * k + 6] == pytest.approx(middle, abs=1e-6)
    assert browser.messages + browser.state()["errors"] == []


def test_an_orbit_is_the_path_over_the_last_revolution_that_ends_at_the_point_or_over_the_whole_motion(whirling):
    browser, drawing, names, values = whirling
    bodies = {body.name: body for body in drawing.bodies}
    orbit = np.array(browser.evaluate(rings("orbit 0", 6)))
    path, last = positions(drawing, bodies["compressor"], names, values), TIME if drawing.revolution else TIMES[-1]
    assert orbit[-1] == pytest.approx(path[:, np.searchsorted(TIMES, last)], abs=1e-4)
    assert orbit[0] == pytest.approx(orbit[-1], abs=1e-4)
    radius = np.linalg.norm(orbit - bodies["compressor"].rest, axis=1)
    assert radius == pytest.approx(1e-3 * drawing.scale, rel=1e-3)
    angle = np.unwrap(np.arctan2(orbit[:, 2] - bodies["compressor"].rest[2], orbit[:, 1] - bodies["compressor"].rest[1]))
    assert angle[-1] - angle[0] == pytest.approx(2 * np.pi * (1 if drawing.revolution else 2), rel=1e-3)
    caption = browser.evaluate("document.querySelector('.magnification').textContent")
    assert "orange: orbits" in caption and ("over the last revolution" in caption) is bool(drawing.revolution)
