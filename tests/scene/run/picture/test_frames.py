"""Key frames: those of the scene, or more where the motion is faster than its times."""

import numpy as np
import pytest

from mbconstrained.scene.run.animation import frames_of
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import SLOW_AND_FAST


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
