"""Plots: valid SVG with axes, units, legend, and curves where they belong."""

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from mbconstrained.page import Curve, Plot
from mbconstrained.page.plots import MOST_CURVES, MOST_POINTS, plot_figure, plot_svg
from tests.page.contents import HOSTILE

TIMES = np.linspace(0, 10, 11)


def points(svg: str) -> list[np.ndarray]:
    return [np.array([pair.split(",") for pair in text.split()], float) for text in re.findall(r'points="([^"]*)"', svg)]


def strokes(*curves: Curve) -> list[str]:
    return re.findall(r'<polyline class="curve" (stroke=.*?) points', plot_svg(Plot("p", "m", TIMES, curves)))


def test_curves_are_linear_images_of_their_values():
    values = TIMES**2
    x, y = points(plot_svg(Plot("p", "m", TIMES, (Curve("c", values),))))[0].T
    assert np.allclose((x - x[0]) / (x[-1] - x[0]), TIMES / 10, atol=1e-4)
    assert np.allclose((y[0] - y) / (y[0] - y[-1]), values / 100, atol=1e-4)


def test_both_axes_tell_their_quantity_and_unit():
    svg = plot_svg(Plot("displacement", "m", 1e-5 * TIMES, (Curve("c", 1e7 * TIMES),)))
    assert ">displacement in 10⁶ m<" in svg
    assert ">time in 10⁻⁶ s<" in svg


def test_every_curve_has_its_own_stroke_and_its_name_in_the_legend():
    count = MOST_CURVES
    figure = plot_figure(Plot("p", "", TIMES, tuple(Curve(f"curve {i}", i * TIMES, 2 * i) for i in range(count))))
    strokes = re.findall(r'<polyline class="curve" (stroke=.*?) points', figure)
    assert len(set(strokes)) == count
    assert re.findall(r'stroke-width="2.4" (.*?)/></svg><span title="curve (\d+)"', figure) == [
        (stroke, str(i)) for i, stroke in enumerate(strokes)
    ]


def test_a_curve_keeps_its_colour_in_whatever_plot_it_stands():
    one, two, six = Curve("one", TIMES), Curve("two", TIMES), Curve("six", TIMES, 5)
    assert strokes(one, two, six)[2] == strokes(six)[0] != strokes(one)[0]
    assert strokes(two) == strokes(one)  # without a number, by the place in the plot


@pytest.mark.parametrize("count", [MOST_CURVES, MOST_CURVES + 1, 300])
def test_of_many_curves_the_first_are_drawn_and_told(count):
    figure = plot_figure(Plot("p", "m", TIMES, tuple(Curve(f"x{i}", 10.0**i / 10**count * TIMES) for i in range(count))))
    assert re.findall(r'<span title="(\w+)"', figure) == [f"x{i}" for i in range(MOST_CURVES)]
    assert len(points(figure)) == MOST_CURVES
    assert (f"the first {MOST_CURVES} of {count} curves" in figure) is (count > MOST_CURVES)


def test_powers_of_units_are_raised():
    assert ">acceleration in m/s²<" in plot_svg(Plot("acceleration", "m/s^2", TIMES, (Curve("c", TIMES),)))


@pytest.mark.parametrize("values", [np.zeros(11), np.full(11, 1e-300), np.full(11, -7.0), 1e289 * np.linspace(-1, 1, 11)])
def test_constant_tiny_and_huge_curves_stay_inside_the_picture(values):
    y = points(plot_svg(Plot("p", "m", TIMES, (Curve("c", values),))))[0][:, 1]
    assert (y >= 12).all() and (y <= 226).all()


def test_one_time_is_a_dot():
    assert "<circle" in plot_svg(Plot("p", "m", [3.0], (Curve("c", [1.0]),)))


def test_no_curves_are_no_error():
    assert "no curves" in plot_figure(Plot("p", "m", TIMES, ()))


def test_a_thinned_curve_keeps_its_spikes():
    times = np.linspace(0, 1, 50_001)
    values = np.zeros_like(times)
    values[[12_345, 40_000]] = 1.0, -1.0
    y = points(plot_svg(Plot("p", "m", times, (Curve("c", values),))))[0][:, 1]
    assert len(y) <= MOST_POINTS + 2
    assert len(np.unique(y)) == 3


@pytest.mark.parametrize("text", [HOSTILE.replace("\u2028", " "), "x" * 10_000, "<b>&amp;"])
def test_texts_are_escaped(text):
    figure = ElementTree.fromstring(plot_figure(Plot(text, text, TIMES, (Curve(text, TIMES),))))
    assert figure.find("h2").text == text
    assert figure.find("ul/li/span").text == text
    assert {element.tag for element in figure.iter()} <= {
        "figure", "h2", "svg", "g", "line", "text", "path", "polyline", "ul", "li", "span",
    }  # fmt: skip
