"""Values next to the curves of a page: of the solution at the shown time, with digits that its error leaves certain."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.analyses.motion_plots import plots_of
from mbconstrained.page.content import Curve, PageContent, Plot, TimeFunctions
from mbconstrained.page.html import write_page
from mbconstrained.page.plots import PlotFunctions
from mbconstrained.page.readings import BOUNDS, FEW_BREAKS, interpolation, linear_readings, readings_of
from mbconstrained.scene.run.scene import read_scene
from tests.page.browser import needs_chromium
from tests.page.plots.pages import StoredFunctions, certain, functions_of_data, functions_of_page, places_of_page, shown

EXAMPLES = sorted(Path("examples").glob("*.toml"))
QUICK = {"four_bar.toml", "pulled_joint.toml", "two_masses_position.toml"}
ALL_EXAMPLES = [pytest.param(path, id=path.stem, marks=() if path.name in QUICK else pytest.mark.long) for path in EXAMPLES]

TEXTS = "[...document.querySelectorAll('.plot-figure')].map(f => [...f.querySelectorAll('.value')].map(v => v.textContent))"


def stored(functions: TimeFunctions, end: float) -> StoredFunctions:
    return StoredFunctions([readings_of(functions, 0.0, end).as_data()])


def assert_within_bounds(functions: TimeFunctions, end: float, count: int = 200) -> np.ndarray:
    """Each function at random times; the bounds of the errors relative to the values, shape (r, count)."""
    times = np.sort(np.random.default_rng(7).uniform(0, end, count))
    exact, found = functions.at(times), stored(functions, end)
    read = np.array([[found.at(row, time) for time in times] for row in range(len(exact))])
    assert (np.abs(read[:, :, 0] - exact) <= read[:, :, 1]).all()
    return read[:, :, 1] / np.maximum(np.abs(exact), 1e-300)


@given(st.floats(0.01, 200.0), st.floats(-1.0, 0.5), st.floats(1e-12, 1e12))
def test_no_value_of_an_oscillation_is_off_by_more_than_its_bound(frequency, rate, size):
    def at(times):
        return size * np.exp(rate * times) * np.array([np.cos(frequency * times), 1e-3 * np.sin(2 * frequency * times)])

    assert np.median(assert_within_bounds(TimeFunctions(at, np.array([])), 10.0, 50)) < 1e-6


def test_jumps_and_kinks_where_they_are_announced_cost_no_digits():
    def at(times):
        return np.array([np.sin(times) + 5 * (times >= np.pi), np.abs(times - np.pi) + np.exp(-1000 * times)])

    assert assert_within_bounds(TimeFunctions(at, np.array([np.pi])), 10.0).max() < 1e-4
    found = stored(TimeFunctions(at, np.array([np.pi])), 10.0)
    assert found.at(0, np.pi)[0] == pytest.approx(5.0, rel=1e-6)  # the value after the jump
    assert found.at(0, np.pi * (1 - 1e-6))[0] == pytest.approx(0.0, abs=1e-5)


def test_a_kink_that_is_not_announced_is_found():
    assert np.quantile(assert_within_bounds(TimeFunctions(lambda t: np.array([np.abs(t - np.e)]), np.array([])), 10.0), 0.99) < 1e-3


def test_a_function_that_decays_keeps_its_digits_down_to_its_noise():
    times = np.array([0.5, 9.5, 19.5])
    found = stored(TimeFunctions(lambda t: np.exp(-t)[None], np.array([]), noise=1e-13), 20.0)
    assert all(found.at(0, time)[1] < 1e-4 * np.exp(-time) for time in times)


def test_rounding_errors_of_a_function_are_not_resolved():
    noise = TimeFunctions(lambda t: np.array([np.sin(t), 1e-16 * np.sin(1e5 * t)]), np.array([]), noise=1e-13)
    assert readings_of(noise, 0.0, 10.0).codes.shape[1] < 300


def test_a_record_has_a_panel_from_sample_to_sample_and_keeps_three_digits():
    knots = np.linspace(0.0, 50.0, 2 * FEW_BREAKS + 1)
    record = np.random.default_rng(1).normal(size=len(knots))
    functions = TimeFunctions(lambda t: (np.interp(t, knots, record) + np.sin(9 * t))[None], knots[1:-1])
    readings = readings_of(functions, 0.0, 50.0)
    assert len(readings.degrees) == len(knots) - 1
    assert "unit" in readings.as_data()  # even times are not listed
    assert np.quantile(assert_within_bounds(functions, 50.0), 0.9) < 1e-4


def test_without_functions_values_are_on_straight_lines():
    times, values = np.array([0.0, 1.0, 3.0]), np.array([[1.0, -2.0, 2.0], [0.0, 0.0, 1e-5]])
    found = StoredFunctions([linear_readings(times, values).as_data()])
    for row, line in enumerate(values):
        for time in (0.0, 0.25, 1.0, 2.5, 3.0):
            value, error = found.at(row, time)
            assert abs(value - np.interp(time, times, line)) <= error <= 1e-5 * np.abs(line).max()


@pytest.mark.parametrize("degree", [degree for degree in BOUNDS if degree])
def test_rounding_to_whole_steps_stays_below_the_bounds(degree):
    """Half the Lebesgue constant, which is the largest row sum of the interpolation."""
    lebesgue = np.abs(interpolation(degree, np.linspace(-1, 1, 1001))).sum(axis=1).max()
    assert lebesgue / 2 + 0.35 <= BOUNDS[degree]


@pytest.mark.parametrize("path", ALL_EXAMPLES)
def test_readings_of_example_pages_are_those_of_the_solver(path):
    """At 200 random times: no digit is off by more than half, and at least three are shown but next to zero."""
    scene = read_scene(path)
    if scene.table.time.step_domain == "discrete":
        pytest.skip("samples have no curves between them")
    plots = plots_of(scene.run())
    times = np.sort(np.random.default_rng(19).uniform(plots[0].times[0], plots[0].times[-1], 200))
    functions, found = PlotFunctions(plots), []
    sets = functions_of_data(functions.as_data())
    for plot in plots:
        pairs = [pair for one in plot.curves for pair in zip((*filter(None, [plot.across]), one), functions.places(plot, one))]
        for curve, (number, row) in pairs:
            source, own_row = curve.function
            exact = source.at(times)
            noise = max(source.noise, 1e-12) * np.abs(exact).max()
            for time, value in zip(times, exact[own_row]):
                whole, power = certain(*sets[number].at(row, time))
                if abs(value) > noise and whole:
                    assert abs(value / 10.0**power - whole) <= 0.5 + 1e-9, (plot.title, curve.name, time, value)
                    found.append(len(str(abs(whole))))
                else:
                    assert abs(value) <= max(1e3 * noise, 1e-6 * np.abs(exact[own_row]).max())
    assert not found or np.mean(np.array(found) < 3) < 0.01
    panels = max(
        len(curve.function[0].breaks) for plot in plots for curve in plot.curves
    )  # one at least between two samples of a record
    size = sum(len(part.get("codes", "")) for parts in functions.as_data()["sets"] for part in parts)
    assert size < max(40_000, 4_000 * sum(len(plot.curves) for plot in plots)) + 1_000 * panels


def waves(times):
    return np.array(
        [0.004 * np.sin(3 * times), 5.2 * np.exp(-times) * np.cos(7 * times), 1.6e-5 * np.cos(times), 7e4 * np.sin(times)]
    )


def wave_plots(times):
    functions = TimeFunctions(waves, np.array([]))
    curves = [Curve(name, row, function=(functions, i)) for i, (name, row) in enumerate(zip("abcd", waves(times)))]
    plane = Plot("plane", "m/s", times, (curves[1],), across=curves[0], across_unit="m")
    return tuple(Plot(curve.name, "J", times, (curve,)) for curve in curves) + (plane,)


@needs_chromium
def test_the_script_shows_what_the_data_determine(browser, tmp_path):
    plots = wave_plots(np.linspace(0.0, 10.0, 41))  # far too few for lines between them
    page = write_page(tmp_path / "page.html", PageContent("t", plots=plots))
    browser.size(1100, 900)
    browser.open(page)
    sets, places = functions_of_page(page.read_text()), places_of_page(page.read_text())
    for across in np.random.default_rng(4).uniform(0.02, 0.98, 12):
        browser.point("svg.plot", across)
        told, texts = browser.evaluate(f"[document.querySelector('.pointer-time').textContent, {TEXTS}]")
        time = float(told.removesuffix(" s"))  # the readings are those of the time that is shown
        for row, per_curve in zip(texts, places):
            for text, curve in zip(row, per_curve):
                for part, (number, function_row) in zip(text.split(", "), curve):
                    value, last, digits = shown(part)
                    whole, power = certain(*sets[number].at(function_row, time))
                    assert (float(value), digits) == (pytest.approx(whole * 10.0**power, rel=1e-12), len(str(abs(whole))))
                    assert abs(float(value) - waves(np.array([time]))[function_row, 0]) <= 0.5001 * float(last)
    assert browser.messages == []


@needs_chromium
def test_powers_of_ten_and_units_are_written_out(browser, tmp_path):
    browser.open(write_page(tmp_path / "page.html", PageContent("t", plots=wave_plots(np.linspace(0.0, 10.0, 41)))))
    browser.point("svg.plot", 0.5)
    small, decaying, tiny, large = (row[0] for row in browser.evaluate(TEXTS)[:4])
    assert small.endswith("J") and "·10" not in small
    assert tiny.endswith("·10⁻⁶ J") and large.endswith(" J") and len(decaying) < 16
