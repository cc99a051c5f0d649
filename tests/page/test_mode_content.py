"""Modes: one cycle of each as key frames."""

import numpy as np
import pytest

from mbconstrained.ground.errors import InputError
from mbconstrained.page.animation import PHASES, ModePicture, cycle
from mbconstrained.page.drawing import Path
from tests.page.mode_pages import NAMES, two_bodies, two_modes


def test_a_cycle_is_a_circle_in_the_plane_of_real_and_imaginary_part():
    values = cycle([2.0, 1 - 1j])
    phases = 2 * np.pi * np.linspace(0, 1, PHASES)
    assert np.allclose(values, [2 * np.cos(phases), np.cos(phases) + np.sin(phases)], atol=1e-14)


def test_frames_have_the_factor_of_the_mode_in_their_values():
    content = two_modes().animation
    frames = content.modes[0].frames(content.drawing, content.names)
    assert (frames.times[0], frames.times[-1], len(frames.times)) == (0, 1, PHASES)
    assert np.allclose(frames.values, 1.2 * content.modes[0].values)


@pytest.mark.parametrize(
    "mode",
    [
        ModePicture("m"),
        ModePicture("m", values=np.full((2, 7), 3.0)),
        ModePicture("m", values=cycle([1.0, 2.0]), scale=0),
        ModePicture("m", paths={"a": Path(np.zeros((3, 9)), np.ones((4, 9)))}),
    ],
    ids=["nothing", "constant values", "scale 0", "path that rests"],
)
def test_a_mode_in_which_nothing_moves_is_one_key_frame(mode):
    frames = mode.frames(two_bodies(), NAMES)
    assert (frames.times.tolist(), frames.values.shape) == ([0], (2, 1))


def test_a_mode_that_cannot_be_drawn_is_refused():
    with pytest.raises(InputError, match="animation, values: found 1e.300, which is too large to draw"):
        ModePicture("m", values=np.array([[1e300], [0]])).frames(two_bodies(), NAMES)
