"""How robots are drawn in a run and on a page of modes: the same parts, the same size, no motion too far to look right."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.modes import ModalAnalysis
from mbconstrained.ground.errors import SceneError
from mbconstrained.robot.visualization import bones_of
from mbconstrained.scene.run.drawing import BASE_PLATE, MOST_TRIANGLES, TURN, VISIBLE, RobotPicture, ShapeDrawing
from mbconstrained.scene.run.scene import read_scene
from mbconstrained.scene.schema.scene_schema import DrawingTable
from tests.page.drawing.test_robot_layout import sphere
from tests.page.robots import Seen
from tests.scene.robots import ROBOTS, SCENE, TOML, URDF, press
from tests.scene.run.picture.test_robot_drawing import path_point
from tests.scene.scenes import EXAMPLES, scene_of

BOX = '<geometry><box size="0.2 0.02 0.02"/></geometry>'


def names_of(drawing):
    return [body.name for body in drawing.bodies]


def both_drawings(scene):
    """Of a run and of a page of modes."""
    return scene.run().animation.drawing, ModalAnalysis(scene).shapes().drawing


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_a_plate_is_drawn_where_the_base_is_fixed_whatever_joints_are_called(tmp_path, base):
    if base == "free":
        scene = read_scene(EXAMPLES / "engine.toml")
    else:
        press(tmp_path, TOML.replace("pivot", "base"), URDF.replace('"pivot"', '"base"'))
        scene = scene_of(tmp_path, SCENE.replace("pivot", "base"))
        assert "base" in scene.equations.robot.joints
    for drawing in both_drawings(scene):
        assert (BASE_PLATE in names_of(drawing)) is (base == "fixed")


def furthest(path, rest, points):
    return max(np.linalg.norm(path_point(path, point) - path_point(rest, point), axis=0).max() for point in points)


@pytest.mark.parametrize("example", ["engine", "four_bar", "pendulum", "satellite", "seven_joint_arm"])
def test_no_point_of_a_robot_moves_further_than_a_share_of_its_size(example):
    scene = read_scene(EXAMPLES / f"{example}.toml")
    picture = RobotPicture(scene.equations.robot_scene)
    points = {name: [np.zeros((3, 1))] for name in picture.at_rest}
    for name, parts in picture.solids.items():
        points[name] += [part.corners[:, [corner]] for part in parts for corner in range(part.corners.shape[1])]
    places = np.hstack([path_point(picture.at_rest[name], point) for name in points for point in points[name]])
    assert picture.size == pytest.approx(np.linalg.norm(np.ptp(places, axis=1)), rel=1e-12)
    for mode in ModalAnalysis(scene).shapes().modes:
        moved = max(furthest(path, picture.at_rest[name], points[name]) for name, path in mode.paths.items())
        assert moved <= 1.1 * VISIBLE * picture.size  # of a mode with phases 8 % more between the times looked at


def with_motor(ratio):
    """The crank on a gear so soft that the motor turns that much further."""
    gear = f'stiffness = "{40 / ratio} N*m/rad"\nmotor_inertia = "1 kg*m^2"\nproportional_gain = "1 N*m/rad"\n'
    return f"{TOML}\n[flexible_joints.pivot]\n{gear}"


@pytest.mark.parametrize("ratio", [1e2, 1e6])
def test_motors_do_not_limit_what_is_drawn(tmp_path, ratio):
    press(tmp_path, with_motor(ratio))
    scene = scene_of(tmp_path, SCENE)
    drawn = ShapeDrawing(scene, [])
    links = np.array([1e-3, 0.0])
    alone, besides = drawn.amplitude(np.append(links, 0.0)), drawn.amplitude(np.append(links, 1.0))
    assert alone == besides == TURN / 1e-3
    found = ModalAnalysis(scene)
    motor = max(found.lines, key=lambda line: abs(line.shape[2]) / np.abs(line.shape[:2]).max())
    assert abs(motor.shape[2]) == 1.0 and np.abs(motor.shape[:2]).max() < 0.1
    assert drawn.amplitude(motor.shape) > 10 * TURN


def test_a_shape_that_cannot_be_drawn_names_the_urdf(tmp_path):
    folder = press(tmp_path, TOML, URDF.replace(BOX, '<geometry><mesh filename="bad.obj"/></geometry>'))
    (folder / "bad.obj").write_text("no mesh at all")
    scene = scene_of(tmp_path, SCENE)
    with pytest.raises(SceneError, match=r'^press/press\.urdf: .*link "crank"'):
        scene.run(tmp_path / "out")
    with pytest.raises(SceneError, match=r'^press/press\.urdf: .*link "crank"'):
        ModalAnalysis.solve(scene).write(tmp_path / "out", ["page"])


@pytest.mark.parametrize("full", [False, True])
def test_large_meshes_are_drawn_with_fewer_triangles_which_is_told_unless_all_are_asked_for(full):
    vertices, faces = sphere(180)
    seen = [Seen(name, "mesh", (), vertices=vertices, faces=faces) for name in ("left", "right")]
    scene = SimpleNamespace(data=SimpleNamespace(urdf_place="r.urdf"), robot=SimpleNamespace(visuals=lambda: seen))
    picture = RobotPicture(scene, DrawingTable(full_meshes=full))
    counts = {len(picture.solids[name][0].faces) for name in ("left", "right")}
    assert len(counts) == 1 and (counts.pop() > MOST_TRIANGLES) is full
    assert picture.note == ("" if full else "1 mesh drawn with fewer triangles")


def with_collision(*shapes):
    """The URDF with collision shapes of the ram."""
    elements = "".join(f"<collision>{shape}</collision>" for shape in shapes)
    return URDF.replace('<link name="ram">', f'<link name="ram">{elements}')


def test_collision_shapes_are_drawn_on_request_where_they_differ_and_can_be_read(tmp_path):
    sphere_of_ram, same = '<geometry><sphere radius="0.05"/></geometry>', f'<origin xyz="0.1 0 0"/>{BOX}'
    hostile = ('<geometry><mesh filename="bad.obj"/></geometry>', '<geometry><sphere radius="-1"/></geometry>', "", "<geometry/>")
    urdf = with_collision(sphere_of_ram, *hostile).replace("</visual>\n  </link>", f"</visual><collision>{same}</collision></link>")
    assert urdf.count("<collision>") == 6
    (press(tmp_path, TOML, urdf) / "bad.obj").write_text("no mesh at all")
    for drawing in both_drawings(scene_of(tmp_path, SCENE)):
        shapes = {body.name: [solid.kind for solid in body.collision] for body in drawing.bodies if body.collision}
        assert shapes == {"ram": ["sphere"]} and "collision" not in drawing.note


def test_a_robot_without_visuals_is_drawn_as_its_collision_geometry(tmp_path):
    press(tmp_path, TOML, URDF.replace("visual>", "collision>"))
    for drawing in both_drawings(scene_of(tmp_path, SCENE)):
        kinds = {body.name: [solid.kind for solid in body.solids] for body in drawing.bodies if body.shape == "solids"}
        assert (kinds["base"], kinds["crank"]) == (["box"], ["box"]) and not any(body.collision for body in drawing.bodies)
        assert "links drawn as their collision geometry" in drawing.note


def test_a_robot_without_shapes_is_drawn_as_bones_between_its_joints():
    """The second bar of the URDF is a uniform one of 0.3 m that begins at its joint; nothing but its inertia tells where it ends."""
    urdf = (ROBOTS / "double_pendulum" / "double_pendulum.urdf").read_text()
    bare = re.sub(r"<(visual|collision)\b.*?</\1>", "", urdf, flags=re.DOTALL)
    robot = mb.Robot(bare)
    bones = bones_of(robot.model, robot.link_frames)
    ends = {}
    for bone in bones:
        if bone.kind == "cylinder":
            half = bone.size[1] / 2 * bone.placement[:3, 2]
            ends[bone.link] = sorted(np.round([bone.placement[:3, 3] + side * half for side in (1, -1)], 12).tolist())
    assert ends == {"upper": [[0, -0.02, -0.4], [0, 0, 0]], "lower": [[0, 0, -0.3], [0, 0, 0]]}
    assert all(np.linalg.det(bone.placement[:3, :3]) == pytest.approx(1, rel=1e-12) for bone in bones)
    assert [bone.link for bone in bones if bone.kind == "sphere"] == ["base", "upper", "lower"]


def test_bones_are_drawn_where_there_is_no_other_shape_and_the_page_reports_them(tmp_path):
    """The crank has no joint behind it; its bone ends at the point of the spring."""
    press(tmp_path, TOML, re.sub("<visual>.*?</visual>", "", URDF))
    for drawing in both_drawings(scene_of(tmp_path, SCENE)):
        drawn = {body.name: body for body in drawing.bodies if body.shape == "solids"}
        assert [solid.kind for solid in drawn["crank"].solids] == ["sphere", "cylinder"]
        assert drawn["crank"].solids[1].size[1] == pytest.approx(0.2) and drawn["crank"].solids[1].placement[0, 3] == pytest.approx(
            0.1
        )
        assert "links drawn as bones between their joints" in drawing.note
