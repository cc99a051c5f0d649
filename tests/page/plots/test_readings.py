"""Values beside the curves of a page: of what is shown no digit is off by more than one unit, whatever the page reads it from."""

import re

import numpy as np
import pytest

from mbconstrained.page.animation.animation import Animation
from mbconstrained.page.content import Curve, PageContent, Plot
from mbconstrained.page.drawing.bodies import Body, Drawing
from mbconstrained.page.html import write_page
from mbconstrained.page.plots.svg_plot import CELLS, plotted
from tests.page.browser import needs_chromium
from tests.page.contents import phase_plane

#: Of the two coordinates, in rad/s, and how large they are, in m.
FREQUENCIES, SIZES = np.array([[3.0], [7.3]]), np.array([[1.0], [0.02]])


def displacement(times):
    return SIZES * np.exp(-0.05 * times) * np.sin(FREQUENCIES * times)


def velocity(times):
    return SIZES * np.exp(-0.05 * times) * (FREQUENCIES * np.cos(FREQUENCIES * times) - 0.05 * np.sin(FREQUENCIES * times))


def energy(times):
    """One that jumps at t = 1 s."""
    return np.array([4e6 * velocity(times)[0] ** 2, 1e7 * (times >= 1.0)])


def written(folder, times):
    names = ("x", "y")
    bodies = tuple(Body(name, rest=(2 * i, 0, 0), moves={name: (1, 0, 0)}) for i, name in enumerate(names))
    told = {"displacement": displacement, "velocity": velocity, "energy": energy}
    curves = {title: tuple(map(Curve, names, values(times))) for title, values in told.items()}
    plots = [Plot(title, "u", times, drawn) for title, drawn in curves.items()]
    plane = phase_plane("phase", "x", times, displacement(times)[0], velocity(times)[0], ("u", "u"))
    animation = Animation(Drawing(bodies), names, times, displacement(times), velocity(times))
    return write_page(folder / "page.html", PageContent("t", animation=animation, plots=(*plots, plane)))


def animated(plot, times):
    """A page with a plot and something that moves."""
    drawing = Drawing((Body("b", moves={"x": (1, 0, 0)}),))
    return PageContent("t", animation=Animation(drawing, ("x",), times, np.sin(times)[None]), plots=(plot,))


def read(text):
    """Each number in a value with its unit in the last digit, both times the power of ten of its unit; after ≈ the first digit."""
    digits = {sign: str(i) for i, sign in enumerate("⁰¹²³⁴⁵⁶⁷⁸⁹")}
    found = []
    for number, power in re.findall(r"(−?[\d.]+) (?:10([⁰¹²³⁴⁵⁶⁷⁸⁹]+) )?u", text):
        factor = 10.0 ** int("".join(digits[sign] for sign in power) or 0)
        last = 10.0 ** (len(number.lstrip("−")) - 1) if text.startswith("≈") else 10.0 ** -len(number.partition(".")[2])
        found.append((factor * float(number.replace("−", "-")), factor * last))
    return found


VALUES = "[...document.querySelectorAll('.plot-figure')].map(f => [...f.querySelectorAll('.value')].map(v => v.textContent))"


@needs_chromium
@pytest.mark.parametrize("times", [np.linspace(0, 3, 301), np.linspace(0, 40, 20_001), 3 * np.linspace(0, 1, 400) ** 3])
def test_no_digit_that_is_shown_is_off_by_more_than_one_unit(browser, tmp_path, times):
    browser.open(written(tmp_path, times))
    moments = np.random.default_rng(5).uniform(0, times[-1], 12).tolist()
    for time, rows in zip(moments, browser.evaluate(f"{moments}.map(time => (mbconstrained.seek(time), {VALUES}))")):
        at = np.array([time])
        known = [displacement(at)[:, 0], velocity(at)[:, 0], energy(at)[:, 0], [(displacement(at)[0, 0], velocity(at)[0, 0])]]
        for texts, values in zip(rows, known):
            for text, value in zip(texts, values):
                for (number, unit), true in zip(read(text), np.atleast_1d(value)):
                    assert abs(number - true) <= unit * (1 + 1e-9), (time, text, true)
        assert [len(read(text)) for text in rows[0]] == [1, 1]
        units = [unit for text in rows[0] for _, unit in read(text)]
        assert max(units) <= 1e-3  # of an axis from -1 to 1: a coordinate is known as well as it can be read


@needs_chromium
def test_a_value_at_the_pointer_is_that_of_the_time_told_there(browser, tmp_path):
    browser.open(written(tmp_path, np.linspace(0, 3, 31)))
    browser.point("svg.plot", 0.617)
    told, texts = browser.evaluate(f"[document.querySelector('.pointer-time').textContent, {VALUES}[0]]")
    at = np.array([float(told.removesuffix(" s"))])
    slope = np.abs(velocity(at)[:, 0])
    for text, value, steep in zip(texts, displacement(at)[:, 0], slope):
        ((number, unit),) = read(text)
        assert abs(number - value) <= unit + 1e-4 * steep  # the time itself has a last digit


@needs_chromium
def test_a_jump_costs_digits_only_where_it_is(browser, tmp_path):
    times = np.linspace(0, 3, 301)
    curve = Curve("a", np.where(times > 1.005, 100.0, 0.0) + np.sin(times))
    browser.open(write_page(tmp_path / "page.html", animated(Plot("acceleration", "u", times, (curve,)), times)))
    ((after, unit),) = read(browser.evaluate(f"(mbconstrained.seek(2.123), {VALUES})")[0][0])
    assert unit <= 0.1 and abs(after - 100 - np.sin(2.123)) <= unit
    within = read(browser.evaluate(f"(mbconstrained.seek(1.0031), {VALUES})")[0][0])
    assert all(unit >= 100 for _, unit in within)


def test_the_error_of_a_path_is_that_of_its_cells_where_the_curve_is_straight_and_sees_what_is_left_out():
    times = np.linspace(0.0, 1.0, 101)
    straight = plotted(times, CELLS * times, CELLS * times / 3, phase=False)[1]
    assert straight == pytest.approx((0.0, 0.4), abs=0.1)
    fine = np.linspace(0.0, 1.0, 50_001)
    wave = 5000 + 5000 * np.sin(40_000 * fine)
    assert plotted(fine, CELLS * fine, wave, phase=False)[1][1] > 2000
