"""The excitation stands in the plot of the answer: random spectra, shocks, and under a moving support the relative motion."""

import numpy as np
import pytest

import mbconstrained as mb
from tests.scene.scenes import EXAMPLES


def test_a_response_over_its_input_is_the_squared_transmissibility():
    """Of one mass on a spring and a damper, in closed form; the input has the corners of the scene, with straight lines between their logarithms."""
    answer = mb.read_scene(EXAMPLES / "electronics_box.toml").random()
    plot = next(iter(answer.plots()))
    box, shaker = plot.curves
    assert (box.name, shaker.name) == ("box", "input: shaker") and shaker.drawn.all()
    r = plot.times / 30.0
    squared = (1 + (0.1 * r) ** 2) / ((1 - r**2) ** 2 + (0.1 * r) ** 2)
    assert box.values / shaker.values == pytest.approx(squared, rel=1e-9)
    corners, values = np.log([20.0, 80.0, 350.0, 2000.0]), np.log([0.01, 0.04, 0.04, 0.007])
    assert answer.facts[0][1] == "shaker: acceleration, table from 20 Hz to 2000 Hz"  # in the unit shown, without its size in SI
    assert plot.unit == "g²/Hz" and shaker.values == pytest.approx(np.exp(np.interp(np.log(plot.times), corners, values)), rel=1e-9)


def test_a_road_stands_with_an_acceleration_as_its_second_derivative():
    """ISO 8608, class C: 256e-6 m^3 at 0.1 cycles/m, falling with the square of the wave number; n = f / v."""
    plot = next(iter(mb.read_scene(EXAMPLES / "car_on_road.toml").random().plots()))
    front = next(curve for curve in plot.curves if curve.name == "input: front wheels")
    f, v = plot.times, 20.0
    inside = front.drawn & (f > 0.011 * v) & (f < 2.83 * v)
    expected = 256e-6 * (f / v / 0.1) ** -2 / v * (2 * np.pi * f) ** 4
    assert inside.sum() > 100 and front.values[inside] == pytest.approx(expected[inside], rel=1e-9)


def test_an_input_of_another_unit_has_its_own_plot():
    """The Kanai-Tajimi spectrum at its natural frequency: G0 (1 + 4 z^2) / (4 z^2), under displacements that answer it."""
    *_, plot = mb.read_scene(EXAMPLES / "building_in_earthquake.toml").random().plots()
    assert plot.title == "spectrum of the input, acceleration" and "(m/s" in plot.unit
    (curve,) = plot.curves
    low, middle = np.interp([plot.times[0], 2.5], plot.times, curve.values)
    assert middle / low == pytest.approx((1 + 4 * 0.36) / (4 * 0.36), rel=1e-3)


def test_a_shock_stands_with_the_accelerations_that_answer_it():
    """The half sine of 50 g and 11 ms, and the largest acceleration of the instrument as the roots of its closed form have it."""
    answer = mb.read_scene(EXAMPLES / "half_sine_drop.toml").shock()
    plots = {one.title: one for one in answer.plots()}
    plot = plots["acceleration"]
    crate, instrument = plot.curves
    inside = plot.times < 0.011
    assert (crate.name, instrument.name) == ("crate", "instrument")
    pulse = 50 * 9.80665 * np.sin(np.pi * plot.times[inside] / 0.011)
    assert crate.values[inside] == pytest.approx(pulse, abs=1e-3 * 490) and np.abs(crate.values[plot.times > 0.012]).max() < 1e-6
    peak = next(row for row in answer.data["peaks"] if (row["quantity"], row["of"]) == ("acceleration", "instrument"))
    assert instrument.values.max() == pytest.approx(peak["maximum"], rel=1e-3)
    assert plot.times[instrument.values.argmax()] == pytest.approx(peak["maximum_time"], abs=1e-3)
    assert "acceleration of crate" not in plots


def test_under_a_moving_support_the_relative_displacement_is_the_first_plot():
    """Of a machine on a floor that shakes with four times its natural frequency: r^2 / sqrt((1 - r^2)^2 + (2 zeta r)^2) mm at the end."""
    result = mb.read_scene(EXAMPLES / "vibration_isolation.toml").run()
    relative, absolute = result.plots()
    assert (relative.title, absolute.title) == ("displacement relative to floor", "displacement")
    (machine,) = relative.curves
    r, zeta = 4.0, 0.1
    late = relative.times > 1.8
    expected = r**2 / np.hypot(1 - r**2, 2 * zeta * r)
    assert machine.name == "machine" and np.abs(machine.values[late]).max() == pytest.approx(expected, abs=0.03)
    functions, row = machine.function
    floor, own = (curve.function[0].at(np.array([0.3, 1.1]))[curve.function[1]] for curve in absolute.curves)
    assert functions.at(np.array([0.3, 1.1]))[row] == pytest.approx(own - floor, rel=1e-12)


@pytest.mark.parametrize(
    "more", ['[output]\nplots = ["displacement"]', '[[model.spring]]\nbetween = ["ground", "machine"]\nstiffness = "1 N/m"']
)
def test_plots_that_are_named_stay_and_what_another_spring_holds_is_not_relative(tmp_path, more):
    text = (EXAMPLES / "vibration_isolation.toml").read_text()
    text = text.replace("[output]", f"{more}\n", 1) if "[output]" in more else text + "\n" + more + "\n"
    path = tmp_path / "scene.toml"
    path.write_text(text)
    assert [plot.title for plot in mb.read_scene(path).run().plots()] == ["displacement"]


STEADY = """
[model]
kind = "lumped"
node = [{ name = "floor" }]
mass = [{ name = "machine", mass = 2 }]
spring = [{ name = "mount", between = ["floor", "machine"], stiffness = 800 }]
damper = [{ name = "oil", between = ["floor", "machine"], damping = 4 }]
[time]
end = 1
[[motion]]
name = "shaker"
coordinate = "floor"
kind = "harmonic"
value = "3 mm"
angular_frequency = 15
[[force]]
coordinate = "machine"
kind = "sampled"
times = [0, 0.1, 0.1000000001, 0.41887902047863906]
values = [3, 3, 0, 0]
"""


def test_the_excitation_of_a_steady_state_stands_with_its_amplitudes(tmp_path):
    """A square wave of 3 N over 0.1 s of the period T = 2 pi / 15 s: 2 * 3 |sin(pi k 0.1 / T)| / (pi k), and its mean; w^2 3 mm of the floor."""
    path = tmp_path / "scene.toml"
    path.write_text(STEADY)
    period = 2 * np.pi / 15
    answer = mb.read_scene(path).steady(period=period, quantity="acceleration", harmonics=20)
    plots = {plot.title: plot for plot in answer.plots()}
    force = plots["amplitudes (N)"]
    assert [curve.name for curve in force.curves] == ["input: force on machine"]
    k = np.arange(1, 21)
    expected = [3 * 0.1 / period, *6 * np.abs(np.sin(np.pi * k * 0.1 / period)) / (np.pi * k)]
    points = force.marks[0].points
    orders = np.rint(points[:, 0] * period).astype(int)
    assert points[:, 1] == pytest.approx(np.array(expected)[orders], abs=1e-6) and len(points) >= 19
    accelerations = plots["amplitudes (m/s^2)"]
    assert [curve.name for curve in accelerations.curves] == ["machine", "input: floor"]
    assert accelerations.marks[1].points == pytest.approx(np.array([[15 / (2 * np.pi), 15**2 * 3e-3]]))
