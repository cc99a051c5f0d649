"""Largest values of runs and sweeps are those of the closed form, and plots and tables follow the motion."""

import json
import re

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.motion_plots import plots_of
from mbconstrained.scene.run.result import Result, aliasing_notices
from mbconstrained.scene.run.scene import read_scene
from tests.page.browser import needs_chromium
from tests.scene.scenes import DRIVELINE, EXAMPLES

#: rad/s, from SciPy's matrix exponential of the reduced equations at 400,001 times and the parabola through the three values of each hump.
LARGEST = {"engine": 0.111995993, "flywheel": 0.122552647, "damper wheel": 0.107810054}


@pytest.fixture
def driveline(tmp_path):
    def scene(text=DRIVELINE):
        (tmp_path / "driveline.toml").write_text(text)
        return read_scene(tmp_path / "driveline.toml")

    return scene


def test_sweeps_and_runs_have_the_largest_values_of_the_closed_form(driveline):
    scene = driveline()
    names = list(LARGEST)
    keep = [f"largest velocity of {name}" for name in names] + [
        "largest coupling",
        "largest reaction of gear",
        "peak velocity of engine",
    ]
    study = scene.sweep({"coupling": mb.linspace("12 kN*m/rad", "14 kN*m/rad", 3)}, keep=keep).run()
    assert [study.values(name)[0] for name in keep[:3]] == pytest.approx(list(LARGEST.values()), rel=1e-8)
    answer = json.loads(json.dumps(scene.run().to_dict(), allow_nan=False))
    data = {(one["name"], one["of"]): one for one in answer["largest"]}
    for name, kept in zip(names, keep):
        assert data[name, "angular velocity"]["largest"] == pytest.approx(study.values(kept)[0], rel=1e-11)
    assert data["coupling", "torque"]["largest"] == pytest.approx(study.values("largest coupling")[0], rel=1e-11)
    assert data["gear", "reaction"]["largest"] == pytest.approx(study.values("largest reaction of gear")[0], rel=1e-11)
    assert study.values("peak velocity of engine").tolist() == study.values(keep[0]).tolist()


def test_the_absorber_at_low_damping():
    """Two coupled oscillators at resonance: SciPy's matrix exponential at 1,000,001 times and parabolas give 5.261420765 mm."""
    scene = read_scene(EXAMPLES / "tuned_mass_damper.toml")
    study = scene.sweep({"zeta": [0.05]}, keep=["largest machine", "maximum machine", "minimum machine"]).run()
    assert study.values("largest machine")[0] == pytest.approx(5.261420765e-3, rel=1e-9)
    assert study.values("largest machine")[0] == max(study.values("maximum machine")[0], -study.values("minimum machine")[0])


def test_accelerations_and_energies(driveline):
    """The acceleration at 0+ is the torque's amplitude over the inertia; energies have their own extrema."""
    result = driveline(DRIVELINE.replace('["velocity", "reaction"]', '["acceleration", "energy"]')).run()
    data = {(one["name"], one["of"]): one for one in result.to_dict()["largest"]}
    assert data["engine", "angular acceleration"]["largest"] == pytest.approx(300 / 2.5, rel=1e-12)
    t = np.linspace(0, 0.1, 200_001)
    kinetic = result.motion.energy(t).kinetic
    assert 0 <= data["kinetic", "energy"]["largest"] / kinetic.max() - 1 < 1e-6


def test_a_table_without_a_number_of_points_follows_the_motion(driveline):
    """125 periods of 12 points; no alias is left to be reported, and the page has the number."""
    result = Result(driveline())
    assert len(result.times) == 1501
    assert not aliasing_notices(result.scene, result.motion, 1501)
    given = Result(driveline(DRIVELINE.replace('end = "2 s"', 'end = "2 s"\npoints = 201')))
    assert len(given.times) == 201
    texts = [notice.text for notice in aliasing_notices(given.scene, given.motion, 201)]
    assert len(texts) == 1 and "62.5 Hz" in texts[0] and re.search(r"with \S+ mrad in \w+", texts[0])


@pytest.mark.parametrize("points", [None, 201])
def test_drawn_curves_have_no_beats(driveline, points):
    """In the steady second half each period of the drawn torque reaches the amplitude of the frequency response."""
    result = driveline(DRIVELINE if points is None else DRIVELINE.replace('end = "2 s"', f'end = "2 s"\npoints = {points}')).run()
    plot = next(plot for plot in plots_of(result) if plot.title == "torque")
    t, torque = plot.times, 1e3 * plot.curves[0].values
    exact = 1e3 * result.time_functions("quantity").at(t)[0]
    assert np.abs(torque - exact).max() <= 1e-9 * np.abs(exact).max()
    H = result.system.frequency_response([62.5], ["engine"], ["coupling"])
    steady = 300 * abs(H.values[0, 0, 0])
    assert steady == pytest.approx(3.22742449, rel=1e-8)  # (K - w^2 M + i w C, A^T; A, 0) solved by NumPy
    periods = np.floor((t - 1.0) * 62.5)
    highest = [torque[periods == number].max() for number in range(62)]
    assert np.allclose(highest, steady, rtol=5e-3)
    between = np.linspace(0, 2, 7919)
    drawn = np.interp(between, t, torque)
    assert np.abs(drawn - 1e3 * result.time_functions("quantity").at(between)[0]).max() <= 0.01 * np.ptp(torque)


@needs_chromium
def test_what_a_browser_shows_has_no_beats(driveline, browser, tmp_path):
    """The path of the torque in the page: each of its humps in the second half is as high as the others, on desktop and phone."""
    page = driveline(DRIVELINE.replace('end = "2 s"', 'end = "2 s"\npoints = 401')).run().write_page(tmp_path / "page.html")
    for width in (1280, 390):
        browser.size(width, 900, mobile=width < 500)
        path = browser.open(page).evaluate("[...document.querySelectorAll('svg.plot .curves path')].at(-1).getAttribute('d')")
        start, steps = re.fullmatch(r"M(\d+ \d+)l(.*)", path).groups()
        numbers = np.array(re.findall(r"-?\d+", f"{start} {steps}"), int).reshape(-1, 2).cumsum(axis=0)
        x, y = numbers[:, 0], 5000 - numbers[:, 1]
        humps = [y[(x >= edge) & (x < edge + 80)].max() for edge in range(5040, 9900, 80)]
        assert np.ptp(humps) <= 0.01 * max(humps)
