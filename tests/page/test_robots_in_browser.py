"""Bodies of parts with paths in a browser: they stand where the paths put them, and links follow."""

import io

import numpy as np
import pytest
from PIL import Image

from mbconstrained.page.animation import Animation
from mbconstrained.page.content import PageContent
from mbconstrained.page.drawing import Drawing, DrawnBody, DrawnLink, Path, Solid, View
from mbconstrained.page.html import write_page
from tests.page.browser import needs_chromium
from tests.page.robots import COUPLER, CRANK, four_bar, four_bar_angles, octahedron, turned

pytestmark = [needs_chromium, pytest.mark.long]
TIMES = np.linspace(0, 6, 121)


def opened(browser, tmp_path, animation, fragment=""):
    return browser.open(write_page(tmp_path / "page.html", PageContent("t", animation=animation)), fragment)


def without_pictures(browser):
    """Times of the script alone: the software renderer is slow."""
    browser.evaluate("void (mbconstrained.viewer.render = () => {})")


def complaints(browser):
    return browser.messages + browser.state()["errors"]


@pytest.mark.parametrize("size", [0.1, 3.0])
def test_links_stand_where_the_mechanism_is_between_the_key_frames_too(browser, tmp_path, size):
    opened(browser, tmp_path, four_bar(TIMES, size))
    for time in (0.0, 0.02, 1.234, 3.0, 5.99, 6.0):
        nodes = browser.evaluate(f"mbconstrained.seek({time}), mbconstrained.state()")["nodes"]
        crank, coupler, _ = four_bar_angles([time])[:, 0]
        place = size * CRANK * np.array([np.cos(crank), 0, np.sin(crank)])
        assert nodes["coupler"]["position"] == pytest.approx(place, abs=3e-6 * size), time
        assert nodes["coupler"]["quaternion"] == pytest.approx(turned((0, -1, 0), coupler)[:, 0], abs=3e-6), time
        assert np.linalg.norm(nodes["coupler"]["quaternion"]) == pytest.approx(1, abs=1e-12)
    assert complaints(browser) == []


def test_the_error_between_key_frames_is_of_fourth_order(browser, tmp_path):
    errors = []
    for count in (31, 61):
        opened(browser, tmp_path, four_bar(np.linspace(0, 6, count)))
        without_pictures(browser)
        times = np.linspace(1.0, 5.0, 41)
        found = browser.evaluate(
            f"{times.tolist()}.map(t => (mbconstrained.seek(t), mbconstrained.state().nodes.rocker.quaternion))"
        )
        known = turned((0, -1, 0), four_bar_angles(times)[2]).T
        errors.append(np.abs(np.array(found) - known).max())
    assert errors[1] < errors[0] / 10 < 1e-2


def place_of_spring_end(name):
    return f"""(() => {{
        const spring = mbconstrained.viewer.scene_tree.find(["mbconstrained", "links", "{name}", "<object>"]).object;
        spring.geometry.computeBoundingBox();
        const unit = 1 / mbconstrained.viewer.scene_tree.find(["mbconstrained", "bodies"]).object.scale.x;
        const end = new MeshCat.THREE.Vector3(spring.geometry.boundingBox.max.x, 0, 0);
        return end.applyQuaternion(spring.quaternion).add(spring.position).multiplyScalar(unit).toArray();
    }})()"""


def test_a_spring_ends_at_its_point_on_the_body_that_turns(browser, tmp_path):
    opened(browser, tmp_path, four_bar(TIMES, 0.1))
    for time in (0.0, 2.7):
        browser.evaluate(f"mbconstrained.seek({time})")
        crank, coupler, _ = four_bar_angles([time])[:, 0]
        middle = [CRANK * np.cos(crank) + COUPLER / 2 * np.cos(coupler), 0, CRANK * np.sin(crank) + COUPLER / 2 * np.sin(coupler)]
        assert browser.evaluate(place_of_spring_end("link 1")) == pytest.approx(0.1 * np.array(middle), abs=2e-6)


def test_every_part_is_within_the_picture_at_all_times_whatever_its_size(browser, tmp_path):
    for size in (1e-2, 30.0):
        opened(browser, tmp_path, four_bar(TIMES, size))
        outermost = browser.evaluate("""(() => {
            let most = 0;
            for (let t = 0; t <= 6; t += 1) {
                mbconstrained.seek(t);
                const bodies = mbconstrained.viewer.scene_tree.find(["mbconstrained", "bodies"]).object;
                bodies.traverse((object) => {
                    if (!object.isMesh) return;
                    const place = object.geometry.attributes.position;
                    for (let i = 0; i < place.count; i++) {
                        const seen = new MeshCat.THREE.Vector3().fromBufferAttribute(place, i).applyMatrix4(object.matrixWorld);
                        seen.project(mbconstrained.viewer.camera);
                        most = Math.max(most, Math.abs(seen.x), Math.abs(seen.y), Math.abs(seen.z));
                    }
                });
            }
            return most;
        })()""")
        assert 0.5 < outermost < 1


def still(*parts, name="b", **given):
    return DrawnBody(name, "solids", solids=parts, path=Path(np.zeros((3, 1)), [[0], [0], [0], [1]]), **given)


def test_a_mesh_is_the_mesh_and_two_bodies_share_it(browser, tmp_path):
    vertices, faces = octahedron(0.2)
    bodies = [still(Solid("mesh", vertices=vertices, faces=faces), name=name) for name in "ab"]
    opened(browser, tmp_path, Animation(Drawing(bodies), (), [0.0], np.zeros((0, 1))))
    found = browser.evaluate("""(() => {
        const meshes = [];
        const bodies = mbconstrained.viewer.scene_tree.find(["mbconstrained", "bodies"]).object;
        bodies.traverse((object) => object.isMesh && meshes.push(object.geometry));
        const numbers = (name) => Array.from(meshes[0].attributes[name].array);
        return { shared: meshes[0] === meshes[1], places: numbers("position"), normals: numbers("normal") };
    })()""")
    assert found["shared"] is True
    places, normals = (np.reshape(found[key], (-1, 3, 3)) for key in ("places", "normals"))
    corners, code = vertices[faces], 0.4 / 65535  # stored in 16 bits
    assert np.abs(np.sort(places.sum(axis=1), axis=0) - np.sort(corners.sum(axis=1), axis=0)).max() <= 2 * code
    assert np.abs(places.reshape(-1, 1, 3) - vertices).max(axis=2).min(axis=1).max() <= 0.51 * code
    # faces of an octahedron are turned by 70 degrees to each other: sharp, so each corner has its face's own normal
    assert np.allclose(normals, np.sign(places.sum(axis=1))[:, None] / 3**0.5, atol=1e-4)


def test_edges_that_are_drawn_are_those_of_three_js(browser, tmp_path):
    """An open sheet with bends of all angles; the oracle is EdgesGeometry with the same angle."""
    x, y = np.meshgrid(np.arange(12.0), np.arange(9.0), indexing="ij")
    sheet = np.stack([x, y, np.random.default_rng(5).uniform(-0.6, 0.6, x.shape)], axis=-1).reshape(-1, 3)
    first = (9 * np.arange(11)[:, None] + np.arange(8)).ravel()
    faces = np.vstack([np.stack([first, first + 9, first + 1], 1), np.stack([first + 9, first + 10, first + 1], 1)])
    solid = Solid("mesh", vertices=sheet, faces=faces)
    opened(browser, tmp_path, Animation(Drawing([still(solid)]), (), [0.0], np.zeros((0, 1))))
    drawn, known = browser.evaluate("""(() => {
        let mesh;
        mbconstrained.viewer.scene_tree.find(["mbconstrained", "bodies"]).object.traverse((o) => o.isMesh && (mesh = o.geometry));
        const peer = new MeshCat.THREE.EdgesGeometry(mesh, 35);
        return [mesh.userData.edges, peer].map((edges) => Array.from(edges.attributes.position.array));
    })()""")
    drawn, known = (np.sort(np.round(np.reshape(ends, (-1, 2, 3)), 4).view("f8,f8,f8")[:, :, 0], axis=1) for ends in (drawn, known))
    assert 40 < len(known) < len(faces) * 3 / 2 - 20
    assert sorted(map(tuple, drawn.tolist())) == sorted(map(tuple, known.tolist()))


@pytest.mark.parametrize(
    "parts, times",
    [
        ((), [0.5]),
        ((Solid("mesh"),), [0.0, 2.0]),
        ((Solid("box", (0, 0, 0)),), [0.5]),
        ((Solid("cylinder", (0, 1)), Solid("sphere", (0,)), Solid("box", (1, 1, 0))), [0.0, 2.0]),
    ],
    ids=["no parts", "a mesh without faces", "a box of no size", "solids without volume"],
)
def test_robots_with_little_to_show(browser, tmp_path, parts, times):
    animation = Animation(Drawing([still(*parts)]), (), times, np.zeros((0, len(times))))
    opened(browser, tmp_path, animation).wait(0.1)
    browser.click("#play")
    assert complaints(browser) == []
    assert browser.state()["nodes"]["b"]["position"] == [0, 0, 0]


def test_links_between_coinciding_points_are_drawn(browser, tmp_path):
    bodies = [still(Solid("box", (1, 1, 1)), name="a"), still(name="b")]
    kinds = ("spring", "damper", "strut", "rod", "bushing", "loop")
    links = [DrawnLink(kind, kind, "a", "b", start_point=(0, 0, 0.5), end_point=(0, 0, 0.5)) for kind in kinds]
    opened(browser, tmp_path, Animation(Drawing(bodies, links), (), [0, 1], np.zeros((0, 2))), "#t=1").wait(0.1)
    assert complaints(browser) == []


def test_an_open_loop_shows_a_bar_across_its_gap(browser, tmp_path):
    other = DrawnBody("b", "solids", path=Path([[0, 3], [0, 0], [0, 4]], [[0, 0], [0, 0], [0, 0], [1, 1]]))
    link = DrawnLink("l", "loop", "a", "b", start_point=(0, 0, 0), end_point=(0, 0, 0))
    animation = Animation(Drawing([still(Solid("box", (1, 1, 1)), name="a"), other], (link,)), (), [0, 1], np.zeros((0, 2)))
    opened(browser, tmp_path, animation)
    gaps = [
        browser.evaluate(f"""(() => {{
            mbconstrained.seek({time});
            const find = (...path) => mbconstrained.viewer.scene_tree.find(["mbconstrained", ...path]).object;
            const bar = find("links", "link 0", "<object>").children.find((part) => part.scale.x !== 1);
            return bar.scale.x / find("bodies").scale.x;
        }})()""")
        for time in (0, 1)
    ]
    assert gaps == pytest.approx([0, 5], abs=1e-5)


def placed(name, place, size, **given):
    return DrawnBody(
        name, "solids", solids=(Solid("box", size, **given),), path=Path(np.array(place)[:, None], [[0], [0], [0], [1]])
    )


def names_shown(browser):
    return browser.evaluate(
        "[...document.querySelectorAll('.label')].filter(l => l.style.visibility === 'visible').map(l => l.textContent).filter(Boolean)"
    )


def drag(browser, selector, across):
    x, y = browser.place(selector, 0.5)
    for kind, shift in (("mousePressed", 0), ("mouseMoved", across / 2), ("mouseMoved", across), ("mouseReleased", across)):
        browser.mouse(kind, x + shift, y, buttons=0 if kind == "mouseReleased" else 1, button="left", clickCount=1)


def test_names_of_links_behind_others_are_left_out_until_the_view_is_turned(browser, tmp_path):
    wall, small = placed("wall", (0, -0.5, 0), (2, 0.1, 2)), placed("small", (0, 0.5, 0), (0.1, 0.1, 0.1))
    beside = placed("beside", (1.6, 0.5, 0), (0.1, 0.1, 0.1))
    opened(browser, tmp_path, Animation(Drawing([wall, small, beside]), (), [0.0], np.zeros((0, 1))))
    assert names_shown(browser) == ["wall", "beside"]
    height = browser.box("#stage")[3]
    drag(browser, "#stage", height / 2)  # a drag by the height of the picture is a whole turn
    browser.wait(0.1)
    assert "small" in names_shown(browser)
    browser.click("#reset")
    assert names_shown(browser) == ["wall", "beside"]
    assert complaints(browser) == []


@pytest.mark.parametrize(("x", "opacity"), [(0, 0.5), (-1.5, 1)], ids=["glass", "beside"])
def test_names_behind_glass_or_beside_a_wall_are_shown(browser, tmp_path, x, opacity):
    bodies = [placed("wall", (x, -0.5, 0), (2, 0.1, 2), opacity=opacity), placed("small", (0, 0.5, 0), (0.1, 0.1, 0.1))]
    opened(browser, tmp_path, Animation(Drawing(bodies), (), [0.0], np.zeros((0, 1))))
    assert "small" in names_shown(browser)


def test_names_behind_a_mesh_of_many_triangles_are_shown_through_its_hole_and_beside_it(browser, tmp_path):
    """A ring of 4800 triangles in any order: behind it is what is between its two radii."""
    turns, radii = np.linspace(0, 2 * np.pi, 121), np.linspace(0.5, 1.2, 21)
    vertices = np.stack([np.outer(radii, np.cos(turns)), 0 * np.outer(radii, turns), np.outer(radii, np.sin(turns))], axis=-1)
    first = (121 * np.arange(20)[:, None] + np.arange(120)).ravel()
    faces = np.vstack([np.stack([first, first + 1, first + 121], 1), np.stack([first + 1, first + 122, first + 121], 1)])
    ring = still(
        Solid("mesh", vertices=vertices.reshape(-1, 3), faces=np.random.default_rng(3).permutation(faces)), name="ring", label=""
    )
    distances = {"centre": 0.0, "inside": 0.4, "left": 0.65, "behind": 0.9, "edge": 1.1, "beside": 1.4, "far": 1.8}
    angles = 0.3 + 2.4 * np.arange(len(distances))
    small = [
        placed(name, (r * np.cos(angle), 0.05, r * np.sin(angle)), (0.02, 0.02, 0.02))
        for (name, r), angle in zip(distances.items(), angles)
    ]
    opened(browser, tmp_path, Animation(Drawing([ring, *small]), (), [0.0], np.zeros((0, 1))))
    assert set(names_shown(browser)) == {name for name, r in distances.items() if not 0.5 < r < 1.2}
    assert complaints(browser) == []


def test_an_image_lies_on_a_mesh_as_its_places_say_and_repeats_beyond_them(browser, tmp_path):
    """A square in the picture's plane that shows an image one and a half times across: its quarters are red, green, blue and yellow."""
    colors = {"top left": (255, 0, 0), "top right": (0, 160, 0), "bottom left": (0, 0, 255), "bottom right": (255, 255, 0)}
    image = Image.fromarray(np.array(list(colors.values()), np.uint8).reshape(2, 2, 3)).resize((64, 64), Image.Resampling.NEAREST)
    stream = io.BytesIO()
    image.save(stream, "JPEG", quality=95)
    corners = np.array([[-1.0, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]])
    faces, spots = np.array([[0, 1, 2], [0, 2, 3]]), (corners[:, ::2] + 1) / 2 * [1.5, 1.0]
    solid = Solid("mesh", vertices=corners, faces=faces, image=stream.getvalue(), places=spots[faces])
    drawing = Drawing([still(solid, name="square", label="")], view=View())
    opened(browser, tmp_path, Animation(drawing, (), [0.0], np.zeros((0, 1))))
    browser.wait(0.5)  # the browser decodes the image
    shown = np.asarray(Image.open(io.BytesIO(browser.picture("#stage"))).convert("RGB"), float)
    rows, columns = np.nonzero(np.ptp(shown, axis=2) > 100)  # the square, since nothing else has a colour
    square = shown[rows.min() : rows.max(), columns.min() : columns.max()]
    height, width = square.shape[:2]
    assert height == pytest.approx(width, rel=0.02)
    for across, column in ((1 / 6, "left"), (3 / 6, "right"), (5 / 6, "left")):
        for down, row in ((0.25, "top"), (0.75, "bottom")):
            found, known = square[int(down * height), int(across * width)], np.array(colors[f"{row} {column}"], float)
            assert found @ known > 0.97 * np.linalg.norm(found) * np.linalg.norm(known) > 5e3, (across, row, found)
    assert complaints(browser) == []
