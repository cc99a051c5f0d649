"""The file of mode shapes: a row and a block to each mode, a cycle in its data."""

import re

import numpy as np
import pytest

from mbconstrained.ground.errors import InputError
from mbconstrained.page.animation import PHASES, ModePicture, Shapes, cycle
from mbconstrained.page.content import PageContent
from mbconstrained.page.drawing import Drawing, Path
from mbconstrained.page.html import page_html, viewer_script
from tests.page.mode_pages import NAMES, many_modes, two_bodies, two_modes, variants
from tests.page.test_html import data_of


def test_without_modes_there_is_a_page_without_a_script():
    page = page_html(PageContent("None", animation=Shapes(Drawing(()), ())))
    assert '<p class="note">no modes</p>' in page and "<h1>None</h1>" in page
    for word in ("<script", "<button", "<table", 'id="stage"'):
        assert word not in page


def test_bounds_hold_all_modes():
    bounds = data_of(page_html(two_modes()))["figure"]["bounds"]
    assert bounds["low"][0] == pytest.approx(-0.6 - 0.4) and bounds["high"][0] == pytest.approx(3 + 0.6 + 0.4)


def test_variants_have_a_slider_and_modes_have_none():
    page = page_html(variants(5))
    assert "<h2>Variants</h2>" in page
    assert re.search(r'<input type="range" id="choice" min="0" max="4" step="1" value="0"[^>]* aria-valuetext="sample 10">', page)
    for content in (many_modes(5), variants(1)):
        assert 'id="choice"' not in page_html(content).replace(viewer_script(), "")


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
