"""Robot files from strangers: nothing is executed, nothing outside their folder is read, nothing hangs."""

import os

import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.robot.description.urdf import LARGEST_URDF, MOST_LINKS
from mbconstrained.scene.build.robot_file import read_robot
from mbconstrained.scene.file import LARGEST_SCENE
from mbconstrained.scene.run.plan import time_limit
from tests.scene.robots import SCENE, TOML, URDF, press
from tests.scene.scenes import scene_of

MESH = '<geometry><mesh filename="NAME"/></geometry>'
BOX = '<geometry><box size="0.2 0.02 0.02"/></geometry>'


def with_mesh(name):
    assert BOX in URDF
    return URDF.replace(BOX, MESH.replace("NAME", name))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("/etc/passwd", "an absolute path; the URDF must lie in the robot's folder"),
        ("../../outside.urdf", "leads out of the folder; the URDF must lie"),
        ("link.urdf", "leads out of the folder"),
        ("pipe", "there is no file"),
    ],
)
def test_the_urdf_lies_in_the_folder(tmp_path, name, message):
    (tmp_path / "outside.urdf").write_text(URDF)
    folder = press(tmp_path, TOML.replace("press.urdf", name))
    (folder / "link.urdf").symlink_to(tmp_path / "outside.urdf")
    os.mkfifo(folder / "pipe")
    with pytest.raises(SceneError, match=message):
        read_robot(folder)


@pytest.mark.parametrize(
    "name",
    [
        "/etc/passwd",
        "file:///etc/passwd",
        "http://localhost/mesh.stl",
        "../../outside.stl",
        "link.stl",
        "package://meshes/../../../outside.stl",
        "package://elsewhere/outside.stl",
        "package://../outside.stl",
        "secret.txt",
    ],
)
def test_meshes_lie_in_the_folder_or_in_named_packages(tmp_path, name):
    (tmp_path / "outside.stl").write_text("solid secret\nendsolid secret\n")
    (tmp_path / "packages" / "meshes").mkdir(parents=True)
    text = TOML.replace("[[spring]]", 'package_dirs = ["../../packages"]\n[[spring]]')
    folder = press(tmp_path, text, with_mesh(name))
    (folder / "link.stl").symlink_to(tmp_path / "outside.stl")
    (folder / "secret.txt").write_text("secret")
    robot, _ = read_robot(folder)
    assert not [visual for visual in robot.visuals() if visual.kind == "mesh"]
    (notice,) = robot.mesh_notices()
    assert "1 mesh not drawn" in notice.text and "secret\n" not in notice.text
    assert notice in scene_of(tmp_path, SCENE).run().notices
    assert scene_of(tmp_path, SCENE + "\n[output]\npage = false\n").run().is_trusted  # meshes are read only where they are drawn


TETRAHEDRON = "solid t\n" + "".join(
    "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {corner}\n" for corner in face) + "endloop\nendfacet\n"
    for face in (
        ("0 0 0", "0 1 0", "1 0 0"),
        ("0 0 0", "1 0 0", "0 0 1"),
        ("0 0 0", "0 0 1", "0 1 0"),
        ("1 0 0", "0 1 0", "0 0 1"),
    )
)


@pytest.mark.parametrize(
    "name",
    [
        "meshes/t.stl",
        "package://shapes/t.stl",
        "package:///shapes/t.stl",
        "package://robots/press/meshes/t.stl",
        "file://PLACE/robots/press/meshes/t.stl",
        "PLACE/packages/shapes/t.stl",
    ],
)
def test_meshes_inside_are_read(tmp_path, name):
    for place in ("robots/press/meshes", "packages/shapes"):
        (tmp_path / place).mkdir(parents=True)
        (tmp_path / place / "t.stl").write_text(TETRAHEDRON + "endsolid t\n")
    text = TOML.replace("[[spring]]", 'package_dirs = ["../../packages"]\n[[spring]]')
    robot, _ = read_robot(press(tmp_path, text, with_mesh(name.replace("PLACE", str(tmp_path)))))
    assert not robot.mesh_notices()
    assert [len(visual.faces) for visual in robot.visuals() if visual.kind == "mesh"] == [4]


def test_package_directories_of_a_file_are_folders(tmp_path):
    with pytest.raises(SceneError, match="package_dirs: found .*; expected a folder: its path, or one relative to the robot's"):
        read_robot(press(tmp_path, TOML.replace("[[spring]]", 'package_dirs = ["nowhere"]\n[[spring]]')))
    _, data = read_robot(press(tmp_path, TOML.replace("[[spring]]", f'package_dirs = ["{tmp_path}"]\n[[spring]]')))
    assert data.package_dirs == (tmp_path.resolve(),)


BOMB = (
    '<!DOCTYPE robot [<!ENTITY a "ha">' + "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefgh", "bcdefghi")) + "]>"
)
STEAL = '<!DOCTYPE robot [<!ENTITY a SYSTEM "file:///etc/passwd">]>'


@pytest.mark.parametrize("declaration", [BOMB, STEAL])
def test_entities_are_refused(tmp_path, declaration):
    urdf = URDF.replace('<robot name="press">', f'{declaration}<robot name="&{"i" if declaration is BOMB else "a"};">')
    with pytest.raises(SceneError, match="entity"):
        read_robot(press(tmp_path, urdf=urdf))


@pytest.mark.parametrize(
    ("urdf", "message"),
    [
        ("", "not XML|no link|no element"),
        ("\0" * 100, "not XML"),
        ("<robot/>", "found no <link>"),
        ("<robot>" + "<link name='a'>" * 20_000, "not XML"),
        ("<robot name='r'>" + "<a>" * 100_000 + "</a>" * 100_000 + "</robot>", "link"),
        (URDF.replace("<robot", "<robot a='" + "x" * LARGEST_URDF + "'"), f"at most {LARGEST_URDF:,} are read"),
        (
            URDF.replace("</robot>", "".join(f'<link name="l{i}"/>' for i in range(100_000)) + "</robot>"),
            f"at most {MOST_LINKS:,} are read",
        ),
    ],
    ids=["empty", "zeros", "no link", "many open", "deep", "huge", "many links"],
)
def test_odd_urdfs_are_refused_at_once(tmp_path, urdf, message):
    folder = press(tmp_path, urdf=urdf)
    with time_limit(60.0), pytest.raises(SceneError, match=message):  # without limits some of these take hours
        read_robot(folder)


def test_odd_robot_files_are_refused(tmp_path):
    folder = press(tmp_path)
    for content, message in (("", "a robot.toml has at least urdf"), ("a" * (LARGEST_SCENE + 1), "which is no robot.toml")):
        (folder / "robot.toml").write_text(content)
        with pytest.raises(SceneError, match=message):
            read_robot(folder)


def test_a_folder_without_a_robot_is_told(tmp_path):
    with pytest.raises(SceneError, match=r"robot\.toml: there is no such file"):
        read_robot(tmp_path)


@pytest.mark.parametrize(
    ("robot", "message"),
    [
        ("/etc", 'expected a folder relative to the scene, e.g. "../robots/four_bar"'),
        ("robots/pres", "there is no such folder or file"),
        ("robots/press/press.urdf", "expected the folder of a robot, or its robot.toml"),
        ("robots", r"robots/robot\.toml: there is no such file|no such file"),
        ("scene.toml", r"/scene\.toml: .*unknown key"),
        ("", "expected a folder relative"),
    ],
)
def test_a_scene_names_a_robot_and_nothing_else(tmp_path, robot, message):
    press(tmp_path)
    with pytest.raises(SceneError, match=message):
        scene_of(tmp_path, SCENE.replace("robots/press", robot))


def test_texts_of_a_robot_are_escaped_on_the_page(tmp_path):
    evil = "<script>alert(1)</script>"
    press(tmp_path, TOML.replace('"Press"', f'"{evil}"').replace('"tests"', f'"{evil}"'), URDF.replace("crank", "&lt;b&gt;crank"))
    (tmp_path / "robots/press/robot.toml").write_text(
        (tmp_path / "robots/press/robot.toml").read_text().replace('"crank"', '"<b>crank"')
    )
    result = scene_of(tmp_path, SCENE).run()
    page = result.write_page(tmp_path / "page.html").read_text("utf-8")
    assert "alert(1)" in page and evil not in page and "<b>crank" not in page
