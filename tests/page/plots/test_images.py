"""Plots as pictures: real PNG and SVG with the texts, colours and ticks of the page, the same bytes each time."""

import io
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from mbconstrained.page.content import Curve, Plot
from mbconstrained.page.figure import PALETTE
from mbconstrained.page.plots import plot_image
from tests.page.contents import HOSTILE

TIMES = np.linspace(0, 2, 50)


def rendered(plot, kind="svg") -> bytes:
    return plot_image(plot, kind)


def texts(svg: bytes) -> list[str]:
    return ["".join(element.itertext()).strip() for element in ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")]


def test_the_svg_has_titles_units_ticks_names_and_the_colours_of_the_page():
    curves = (Curve("x1", 1e-6 * np.sin(TIMES)), Curve("other", -1e-6 * np.cos(TIMES), color=3))
    svg = rendered(Plot("acceleration", "m/s^2", TIMES, curves))
    found = texts(svg)
    assert {"acceleration", "time in s", "acceleration in 10⁻⁶ m/s²", "x1", "other", "−1.0", "0.0", "2.0"} <= set(found)
    assert all(color in svg.decode().lower() for color in (PALETTE[0], PALETTE[3]))
    assert svg == rendered(Plot("acceleration", "m/s^2", TIMES, curves))


def test_the_png_is_a_picture_with_the_curve_in_it():
    picture = Image.open(io.BytesIO(rendered(Plot("speed", "m/s", TIMES, (Curve("x", TIMES**2),)), "png"))).convert("RGB")
    assert picture.size[0] == 1024 and picture.getpixel((0, 0)) == (255, 255, 255)
    blue = tuple(int(PALETTE[0][i : i + 2], 16) for i in (1, 3, 5))
    assert (np.asarray(picture) == blue).all(axis=2).sum() > 500


@pytest.mark.parametrize("count", [1, 9, 30])
def test_every_name_fits_and_more_curves_than_the_page_shows_are_told(count):
    plot = Plot("many", "N", TIMES, tuple(Curve(f"force of rod {i}", np.sin(TIMES + i)) for i in range(count)))
    found = texts(rendered(plot))
    assert [name for name in found if name.startswith("force of")] == [f"force of rod {i}" for i in range(min(count, 24))]
    assert ("the first 24 of 30 curves" in found) == (count > 24)


def test_names_of_the_user_are_texts_and_nothing_else():
    svg = rendered(Plot(HOSTILE, HOSTILE, TIMES[:1], (Curve(HOSTILE + "$x^2$" * 20, TIMES[:1]),)))
    assert b"<script" not in svg and b"<img" not in svg
    assert any(text.startswith("</script><script>alert(1)") for text in texts(svg))
