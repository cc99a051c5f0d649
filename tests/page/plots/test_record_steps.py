"""Readings of motions under long records: by the steps from sample to sample, as right as those of panels and much smaller."""

import json

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.motion_plots import plots_of
from mbconstrained.analyses.python_models import result_of
from mbconstrained.page.content import RecordResponse, TimeFunctions
from mbconstrained.page.plots import PlotFunctions
from mbconstrained.page.readings import record_steps
from tests.page.browser import needs_chromium
from tests.page.plots.in_browser import number_of
from tests.page.plots.pages import certain, functions_of_data


def result_under_record(count, table, step=0.005):
    """A building under a force or on a moving soil; the record ends before the time does."""
    record = np.random.default_rng(count).normal(size=count).cumsum()
    record -= np.linspace(record[0], record[-1], count)
    model, signal = mb.LumpedModel(), mb.sampled(step * np.arange(count), record)
    model.mass("low", 1000.0), model.mass("high", 800.0), model.node("soil")
    model.spring("soil", "low", 8e5), model.damper("soil", "low", 2000.0), model.spring("low", "high", 6e5)
    if table == "motion":
        model.prescribe("soil", signal, level="acceleration")
    else:
        model.constrain({"soil": 1}), model.force("high", signal)
    return result_of(
        model.assemble().solve(), end=step * count + 2, plots=["displacement", "velocity", "acceleration", "reaction", "energy"]
    )


def readings_against_the_solver(plots, times):
    """How many readings are wrong by more than half of their last digit, and the share of those with fewer than three digits."""
    functions = PlotFunctions(plots)
    sets = functions_of_data(functions.as_data())
    wrong, few = 0, []
    for plot in plots:
        for curve in plot.curves:
            ((number, row),) = functions.places(plot, curve)
            source, own = curve.function
            exact = source.at(times)
            noise = source.noise * np.abs(exact).max()
            for time, value in zip(times, exact[own]):
                whole, power = certain(*sets[number].at(row, time))
                wrong += bool(whole) and abs(value / 10.0**power - whole) > 0.5 + 1e-9
                if abs(value) > 1e4 * noise:
                    few.append(abs(whole) < 100)
    return wrong, np.mean(few), functions


@pytest.mark.long
@pytest.mark.parametrize("table", ["force", "motion"])
def test_readings_under_a_record_are_those_of_the_solver_with_three_digits(table):
    plots = plots_of(result_under_record(3000, table))
    times = np.sort(np.random.default_rng(1).uniform(*plots[0].times[[0, -1]], 200))
    wrong, few, functions = readings_against_the_solver(plots, times)
    assert wrong == 0
    assert few < 0.01
    assert len(functions.records) == 1  # of all plots
    assert len(json.dumps(functions.as_data())) < 80_000


def motion_under(times, record):
    system = mb.MechanicalSystem(mass=[[2.0]], damping=[[0.4]], stiffness=[[300.0]])
    motion = system.solve(force=mb.sampled(times, record))
    restarts = motion.force.smooth.restarts
    return motion, RecordResponse(restarts.knots, restarts.states, lambda t: np.vstack([motion(t), motion.derivative(1)(t)]))


def test_steps_are_those_of_the_matrix_exponential():
    """One mass under a force that is linear between samples: van Loan's block exponential gives its step."""
    from scipy.linalg import expm

    step, values = 0.05, np.random.default_rng(3).normal(size=(1, 2500))
    _, record = motion_under(step * np.arange(2500), values)
    steps = record_steps(record, 0.0, 130.0)
    generator = np.array([[0, 1, 0, 0], [-150, -0.2, 0.5, 0], [0, 0, 0, 1 / step], [0, 0, 0, 0.0]])
    exact = expm(step * generator)
    from_states = np.linalg.lstsq(steps.exact.T, record.states(steps.start + steps.gap * np.arange(steps.count)).T, rcond=None)[0].T
    moved = from_states @ steps.matrix[:, :2] @ np.linalg.inv(from_states)
    np.testing.assert_allclose(moved, exact[:2, :2], atol=1e-9)
    forced = from_states @ steps.matrix[:, 2:5]
    np.testing.assert_allclose(forced, np.column_stack([exact[:2, 2] - exact[:2, 3], exact[:2, 3], [0, 0]]), atol=1e-9)


def test_uneven_samples_and_short_records_are_stored_by_panels():
    even = 0.05 * np.arange(2500)
    uneven = even + np.random.default_rng(4).uniform(0, 0.01, 2500)
    for times in (even[:1000], uneven):
        _, record = motion_under(times, np.ones((1, len(times))) * np.cos(7 * times))
        assert record_steps(record, 0.0, times[-1]) is None


def test_functions_that_do_not_follow_from_the_motion_are_stored_by_panels():
    times = 0.05 * np.arange(2500)
    motion, record = motion_under(times, np.cos(7 * times)[None])
    cube = TimeFunctions(lambda t: motion(t) ** 3 + np.sin(t), record.knots, 1e-12, record)
    steps = record_steps(record, 0.0, times[-1])
    from mbconstrained.page.readings import record_readings

    assert record_readings(cube, steps, 0) is None


@needs_chromium
def test_the_script_steps_through_a_record(browser, tmp_path):
    result = result_under_record(3000, "force")
    page = result.write_page(tmp_path / "page.html")
    browser.size(1100, 900)
    browser.open(page)
    plots = plots_of(result)
    for across in (0.9, 0.1, 0.55):  # backwards, too
        browser.point("svg.plot", across)
        shown, texts = browser.evaluate(
            "[document.querySelector('.pointer-time').textContent,"
            " [...document.querySelector('.plot-figure').querySelectorAll('.value')].map(v => v.textContent)]"
        )
        time = float(shown.removesuffix(" s"))
        for curve, text in zip(plots[0].curves, texts):
            source, row = curve.function
            assert number_of(text) == pytest.approx(source.at(np.array([time]))[row, 0], rel=5.1e-3, abs=1e-12)
    assert browser.messages == []
