"""Plots: valid SVG with axes, units, legend, and curves where they belong."""

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from mbconstrained.ground.errors import InputError
from mbconstrained.page.content import MOST_SHOWN, Curve, Guide, Marks, Plot, curve_with_gaps
from mbconstrained.page.plots import CELLS, FEW_CURVES, HELP, MOST_POINTS, plot_figures
from tests.page.contents import HOSTILE

TIMES = np.linspace(0, 10, 11)


def points(figure: str) -> list[np.ndarray]:
    """The points of each curve, shape (n, 2), in parts of the width and of the height from above."""
    drawn = sorted(
        re.findall(r'<path class="curve [^"]*" data-number="(\d+)" d="M(\d+ \d+)l([^"]*)"', figure), key=lambda row: int(row[0])
    )
    pairs = [re.findall(r"-?\d+", f"{first} {steps}") for _, first, steps in drawn]
    return [np.cumsum(np.array(numbers, int).reshape(-1, 2), axis=0) / CELLS for numbers in pairs]


def figure_of(plot: Plot) -> str:
    return (
        plot_figures((plot,))
        .partition(f'\n<p class="note plot-help">{HELP}')[0]
        .removeprefix('<div class="plots">\n')
        .removesuffix("\n</div>")
    )


def looks(*curves: Curve) -> list[str]:
    found = re.findall(r'<path class="curve ([^"]*)" data-number="(\d+)"', figure_of(Plot("p", "m", TIMES, curves)))
    return [look.removesuffix(" twin") for look, _ in sorted(found, key=lambda pair: int(pair[1]))]


def test_curves_are_linear_images_of_their_values():
    values = TIMES**2
    x, y = points(figure_of(Plot("p", "m", TIMES, (Curve("c", values),))))[0].T
    assert np.allclose(x, TIMES / 10, atol=1e-4)
    assert np.allclose(1 - y, values / 100, atol=1e-4)


def test_a_phase_plane_is_the_velocity_over_the_displacement():
    phases = np.linspace(0, 3 * np.pi, 200)
    across, curves = Curve("angle", np.cos(phases)), (Curve("q", -np.sin(phases), 2),)
    plane = Plot("phase", "rad/s", phases, curves, across=across, across_unit="rad", quantity="angular velocity")
    figure = figure_of(plane)
    x, y = points(figure)[0].T
    assert np.allclose([2 * x - 1, 1 - 2 * y], [np.cos(phases), -np.sin(phases)], atol=2e-4)
    assert ">angle in rad<" in figure and ">angular velocity in rad/s<" in figure
    assert 'class="curve c2"' in figure


def test_logarithmic_axes():
    frequencies = np.geomspace(0.1, 1000.0, 9)
    scales = ("log", "log")
    plot = Plot("gain", "", frequencies, (Curve("H", frequencies**-2.0),), across_unit="Hz", variable="frequency", scales=scales)
    x, y = points(figure_of(plot))[0].T
    assert np.allclose(x, np.linspace(0, 1, 9), atol=1e-4) and np.allclose(y, np.linspace(0, 1, 9), atol=1e-4)
    assert {">frequency in Hz<", ">0.1<", ">1000<", ">10⁻⁶<", ">100<"} <= set(re.findall(r">[^<>]+<", figure_of(plot)))
    with pytest.raises(InputError, match="no value along its vertical axis is positive"):
        Plot("gain", "", frequencies, (Curve("H", -frequencies),), scales=scales)


def test_a_picture_is_described_for_those_who_cannot_see_it():
    figure = figure_of(Plot("displacement", "m", TIMES, (Curve("a", TIMES**2), Curve("b", -TIMES))))
    assert (
        'aria-label="displacement in m over time in s, 0 to 10 s. '
        'a: from 0 to 100, lowest 0, highest 100; b: from 0 to −10, lowest −10, highest 0."'
    ) in figure.replace("-0,", "0,").replace("−0 ", "0 ").replace("from −0", "from 0").replace("highest −0", "highest 0")


def test_a_curve_keeps_its_colour_in_whatever_plot_it_stands():
    one, two, six = Curve("one", TIMES), Curve("two", TIMES), Curve("six", TIMES, 5)
    assert looks(one, two, six)[2] == looks(six)[0] != looks(one)[0]
    assert looks(two) == looks(one)  # without a number, by the place in the plot


@pytest.mark.parametrize("count", [MOST_SHOWN, MOST_SHOWN + 1, FEW_CURVES + 1, 150])
def test_of_many_curves_the_first_are_shown_and_all_can_be(count):
    figure = figure_of(Plot("p", "m", TIMES, tuple(Curve(f"x{i}", 10.0**i / 10**count * TIMES) for i in range(count))))
    assert re.findall(r"<span>(\w+)<", figure) == [f"x{i}" for i in range(count)]
    assert re.findall(r'aria-pressed="(\w+)"', figure) == ["true"] * MOST_SHOWN + ["false"] * (count - MOST_SHOWN)
    assert (len(points(figure)), figure.count("data-function=")) == (MOST_SHOWN, count)
    assert ('type="search"' in figure, f"{count} curves, " in figure) == (count > FEW_CURVES, count > MOST_SHOWN)


@pytest.mark.parametrize("values", [np.zeros(11), np.full(11, 1e-300), np.full(11, -7.0), 1e289 * np.linspace(-1, 1, 11)])
def test_constant_tiny_and_huge_curves_stay_inside_the_picture(values):
    y = points(figure_of(Plot("p", "m", TIMES, (Curve("c", values),))))[0][:, 1]
    assert (y >= 0).all() and (y <= 1).all()


def test_one_time_is_a_dot():
    assert "<circle" in figure_of(Plot("p", "m", [3.0], (Curve("c", [1.0]),)))


def test_no_curves_are_no_error():
    assert "no curves" in figure_of(Plot("p", "m", TIMES, ()))


def test_a_thinned_curve_keeps_its_spikes():
    times = np.linspace(0, 1, 50_001)
    values = np.zeros_like(times)
    values[[12_345, 40_000]] = 1.0, -1.0
    y = points(figure_of(Plot("p", "m", times, (Curve("c", values),))))[0][:, 1]
    assert len(y) <= MOST_POINTS + 2
    assert len(np.unique(y)) == 3


@pytest.mark.parametrize("text", [HOSTILE.replace("\u2028", " "), "x" * 10_000, "<b>&amp;"])
def test_texts_are_escaped(text):
    figure = ElementTree.fromstring(figure_of(Plot(text, text, TIMES, (Curve(text, TIMES),))))
    assert figure.find("h2").text == text
    assert figure.find("ul/li/button/span").text == text
    assert {element.tag for element in figure.iter()} <= {
        "figure", "h2", "svg", "g", "line", "text", "path", "ul", "li", "button", "span", "p",
    }  # fmt: skip


def test_a_curve_is_drawn_where_it_has_values():
    values = np.where((TIMES < 3) | (TIMES > 5), TIMES, np.nan)
    figure = figure_of(Plot("p", "m", TIMES, (curve_with_gaps("c", values),)))
    assert 'data-parts="0.0 2.0 6.0 10.0"' in figure
    (data,) = re.findall(r'<path class="curve c0" data-number="0" d="M([^"]*)"', figure)
    places = [np.array(re.findall(r"-?\d+", part), int).reshape(-1, 2) for part in data.replace("m", "l").split("l")]
    points = np.cumsum(np.concatenate(places), axis=0) / CELLS
    drawn = np.concatenate([[0, 1, 2], [6, 7, 8, 9, 10]]) / 10
    assert np.allclose(points, np.array([drawn, 1 - drawn]).T)


def test_curves_of_a_complex_plane_have_their_own_values_along_both_axes():
    s = np.array([TIMES - 1j * TIMES, -TIMES + 1j * TIMES**2])
    curves = tuple(Curve(str(i), row.imag, along=row.real) for i, row in enumerate(s))
    plot = Plot("locus", "rad/s", TIMES, curves, Curve("real part", s[0].real), "1/s", "imaginary part", "c", variable_unit="N s/m")
    figure = figure_of(plot)
    (across, up), drawn = plot.axes, points(figure)
    assert (across.low, across.high) == (-10, 10) and (up.low, up.high) == (-20, 100)
    for row, (x, y) in zip(s, (each.T for each in drawn)):
        assert np.allclose(x, across.shares(row.real), atol=1e-4) and np.allclose(1 - y, up.shares(row.imag), atol=1e-4)
    assert 'data-variable="c" data-variable-unit="N s/m"' in figure


def test_guides_bands_and_marks_are_where_they_belong():
    guides = (
        Guide("1×", (0.0, 0.0), (10.0, 20.0)),
        Guide("outside", (0.0, 30.0), (10.0, 30.0)),
        Guide("", (5, 0), (5, 10), "limit"),
    )
    marks = (Marks("critical speed", np.array([[5.0, 7.5]]), ("at 5",)), Marks("", np.array([[10.0, 0.0]]), shape="cross", curve=0))
    plot = Plot(
        "p", "m", TIMES, (Curve("c", TIMES),), guides=guides, marks=marks, bands=((2.0, 4.0),), includes=(-10.0,), is_large=True
    )
    figure = figure_of(plot)
    assert 'd="M0 5000L5000 0"' in figure and 'class="guide limit" d="M5000 5000L5000 0"' in figure
    assert '<rect class="band" x="2000" width="2000"' in figure
    assert re.findall(r'class="guide-name" x="([\d.]+)%"[^>]*>([^<]*)', figure) == [("50.00", "1×")]
    assert 'class="mark" x="50.00%" y="50.0" data-at="5.0 7.5"' in figure and "<title>at 5</title>" in figure
    assert 'x="100.00%" y="200.0" data-at="10.0 0.0" data-curve="0"' in figure and '<path class="cross c0"' in figure
    assert figure.count('class="of-marks"') == 1 and ">critical speed<" in figure
