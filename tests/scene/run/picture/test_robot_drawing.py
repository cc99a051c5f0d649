"""The picture of a robot: its links on their paths, its motion seen but not exaggerated."""

import numpy as np
import pytest

from mbconstrained.scene.run.animation import frames_of
from mbconstrained.scene.run.drawing import VISIBLE, RobotPicture, drawing_of_robot
from mbconstrained.scene.run.scene import read_scene
from tests.scene.robots import SCENE, press
from tests.scene.scenes import EXAMPLES, SLOW_AND_FAST, scene_of


def moving(drawing):
    return {body.name: body.path for body in drawing.bodies if body.path is not None and body.path.moves}


def test_links_springs_and_paths_are_drawn(tmp_path):
    press(tmp_path)
    result = scene_of(tmp_path, SCENE).run()
    drawing = result.animation.drawing
    names = [body.name for body in drawing.bodies]
    assert {"base", "crank", "ram"} <= set(names) and set(moving(drawing)) == {"crank", "ram"}
    assert [(link.name, link.start, link.end, link.start_point) for link in drawing.links] == [
        ("tie", "crank", "ram", (0.2, 0.0, 0.0))
    ]
    assert drawing.note == "small motions about the equilibrium"


@pytest.mark.parametrize("scale", [1.0, 0.5, 20.0])
def test_the_scale_of_the_drawing_counts(tmp_path, scale):
    press(tmp_path)
    scene = scene_of(tmp_path, SCENE + f'[drawing]\nscale = {scale}\nnote = "mine"\n')
    drawing = scene.run().animation.drawing
    assert (drawing.scale, drawing.note) == (scale, "mine")
    _, y, _, w = drawing_path(drawing, "crank").quaternions
    turn = np.ptp(2 * np.arctan2(y, w))
    values = scene.run().values[0]
    assert turn == pytest.approx(scale * np.ptp(values), rel=0.05)


def drawing_path(drawing, name):
    return next(body.path for body in drawing.bodies if body.name == name)


@pytest.mark.parametrize("start", [1e-9, 1e-4, 0.01])
def test_motion_is_drawn_so_that_it_is_seen(tmp_path, start):
    press(tmp_path)
    result = scene_of(tmp_path, SCENE.replace('"1 deg"', str(start))).run()
    path = drawing_path(result.animation.drawing, "crank")
    rest = drawing_of_robot(RobotPicture(result.scene.equations.robot_scene), np.zeros((2, 1)))
    tip = np.array([[0.2], [0], [0]])
    moved = np.linalg.norm(path_point(path, tip) - path_point(drawing_path(rest, "crank"), tip), axis=0).max()
    assert 0.4 * VISIBLE * 0.4 < moved < 2.5 * VISIBLE * 0.4


def path_point(path, point):
    x, y, z, w = path.quaternions
    turned = point + 2 * (w * cross((x, y, z), point) + cross((x, y, z), cross((x, y, z), point)))
    return path.positions + turned


def cross(a, b):
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def test_motion_at_rest_and_motion_that_goes_far_are_drawn_as_they_are(tmp_path):
    press(tmp_path)
    still = scene_of(tmp_path, SCENE.replace('{ pivot = "1 deg" }', "{}")).run()
    assert still.animation.drawing.scale == 1 and not moving(still.animation.drawing)
    assert read_scene(EXAMPLES / "satellite.toml").run().animation.drawing.scale == 1


def test_loops_stay_closed_in_the_picture():
    result = read_scene(EXAMPLES / "four_bar.toml").run()
    drawing = result.animation.drawing
    (pin,) = drawing.links
    ends = [
        path_point(drawing_path(drawing, body), np.array(point)[:, None])
        for body, point in ((pin.start, pin.start_point), (pin.end, pin.end_point))
    ]
    assert drawing.scale > 5 and np.abs(ends[0] - ends[1]).max() < 1e-5
    assert pin.kind == "loop"


def frames(folder, slow=1.0, fast=1.0, amplitude=1.0, points=101, most=4001):
    path = folder / "scene.toml"
    given = {"slow": slow, "fast": fast, "amplitude": amplitude, "points": points}
    path.write_text(SLOW_AND_FAST.format(**given, damper="", force="", end=10))
    result = read_scene(path).run()
    return result, frames_of(result, most)


@pytest.mark.parametrize("angular_frequency", [1.0, 12.0, 50.0, 100.0])
def test_the_fastest_motion_has_twenty_frames_in_a_period(tmp_path, angular_frequency):
    _, (times, values, rates) = frames(tmp_path, fast=angular_frequency**2)
    in_a_period = 2 * np.pi / angular_frequency / np.diff(times).max()
    assert in_a_period >= 0.98 * 20
    assert len(times) == 101 or in_a_period < 42  # and no more than twice as many
    assert np.allclose(values[1], np.cos(angular_frequency * times), atol=1e-9)
    assert np.allclose(rates[1], -angular_frequency * np.sin(angular_frequency * times), atol=1e-6)


def test_there_are_no_more_than_allowed_and_never_fewer_than_the_scene_has(tmp_path):
    assert len(frames(tmp_path, fast=1e6, most=500)[1][0]) == 500
    result, (times, values, _) = frames(tmp_path, fast=1e6, points=901, most=500)
    assert np.array_equal(times, result.times) and np.array_equal(values, result.values)
