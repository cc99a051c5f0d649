"""Scenes in discrete time: samples against recursions and the continuous motion, refusals, files and page."""

from pathlib import Path

import numpy as np
import pytest

import mbconstrained as mb
from tests.scene.scenes import CART_ON_SPRING, scene_of

EXAMPLES = Path(__file__).parents[2] / "examples"

COEFFICIENTS = """
[model]
kind = "matrices"
coefficients = [[[-0.5, 0], [-1, 1]], [[1, 0], [0, 0]]]

[initial]
displacement = [1, 1]

[time]
step_domain = "discrete"
step = "1 s"
end = "10 s"
"""

CART = f"""{CART_ON_SPRING}
[[force]]
coordinate = "cart"
kind = "ramp"
value = "3 N/s"

[time]
step_domain = "discrete"
step = "0.3 s"
end = "6 s"
"""


def scene(tmp_path, text: str, **changes) -> mb.Scene:
    return scene_of(tmp_path, text, "own.toml", changes or None)


def test_vibrations_above_the_nyquist_frequency_are_reported():
    # 11.28 Hz of the wheel, sampled at 20 Hz and at 25 Hz
    path = EXAMPLES / "sampled_quarter_car.toml"
    (notice,) = mb.read_scene(path).run().notices
    assert "11.28 Hz, above the Nyquist frequency of 10 Hz" in notice.text
    finer = mb.read_scene(path, {"time.step": "40 ms"}).run()
    assert [notice.kind for notice in finer.notices] == ["override"]


def test_a_linear_hold_is_exact_for_a_ramp(tmp_path):
    answer = scene(tmp_path, CART).run()
    t = answer.times
    assert answer.values[0] == pytest.approx(3 / 8 * (t - np.sin(2 * t) / 2), abs=1e-14)
    assert answer.scene.table.time.hold == 1


def test_the_page_shows_points_and_nothing_between_them(tmp_path):
    answer = scene(tmp_path, COEFFICIENTS).run(tmp_path / "out")
    (plot,) = answer.plots()
    assert all(not curve.drawn.any() and curve.function is None for curve in plot.curves)
    assert [len(marks.points) for marks in plot.marks] == [11, 11]
    assert plot.variable == "sample k" and "none between" in plot.note
    assert sorted(path.name for path in answer.files) == ["own.csv", "own.html", "own.npz"]
    assert (tmp_path / "out" / "own.csv").read_text().startswith("k,time (s),x1")
    assert answer.to_xarray().sizes["k"] == 11
    assert not any("staircase" in stage.name for stage in answer.plan.stages)


def test_a_start_that_does_not_fit_is_reported(tmp_path):
    answer = scene(tmp_path, COEFFICIENTS.replace("[1, 1]", "[1, 4]")).run()
    assert answer.values[:, 0].tolist() == [1.0, 1.0]
    assert any("x2: its value at k = 0 is 1, not the given 4" in notice.text for notice in answer.notices)


def test_later_samples_alone(tmp_path):
    answer = scene(tmp_path, COEFFICIENTS, **{"time.start": 4}).run()
    assert answer.numbers.tolist() == list(range(4, 11)) and answer.values[0, 0] == 0.5**4


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (COEFFICIENTS.replace('step = "1 s"\n', ""), "needs step"),
        (COEFFICIENTS.replace('step = "1 s"', "points = 11"), "give step"),
        (COEFFICIENTS + "hold = 0\n", "leave hold out"),
        (COEFFICIENTS + 'start = "0.5 s"\n', "expected a multiple of step"),
        (COEFFICIENTS.replace('"discrete"', '"discreet"'), "discreet"),
        (CART + '[output]\nplots = ["velocity"]\n', "found velocity"),
        (CART + "[output]\nformula = true\n", "formula: it needs a motion between samples"),
        (CART.replace('step_domain = "discrete"', "hold = 0"), "hold belongs to"),
        (CART + "hold = 2\n", "hold"),
    ],
)
def test_wrong_tables_are_refused(tmp_path, text, message):
    with pytest.raises(mb.SceneError, match=message):
        scene(tmp_path, text)


def test_other_questions_to_coefficients_of_the_shift_are_refused(tmp_path):
    with pytest.raises(mb.SceneError, match="coefficients are those of the shift"):
        scene(tmp_path, COEFFICIENTS).modes()
    assert scene(tmp_path, CART).modes().data  # those of the continuous model


def test_state_spaces_and_transfer_functions(tmp_path):
    time = '[time]\nstep_domain = "discrete"\nstep = 0.5\nend = 5\n'
    space = (
        '[model]\nkind = "state-space"\nA = [[-1]]\nB = [[1]]\nC = [[2]]\n[[force]]\ncoordinate = "u1"\nkind = "step"\nvalue = 1\n'
        + time
    )
    answer = scene(tmp_path, space).run()
    assert answer.values[0] == pytest.approx(2 * (1 - np.exp(-answer.times)), abs=1e-15)
    fraction = '[model]\nkind = "transfer-function"\nnumerator = [2]\ndenominator = [1, 1]\ngamma = 2\n' + time
    answer = scene(tmp_path, fraction).run()
    assert answer.values[0] == pytest.approx(2 * (answer.times - 1 + np.exp(-answer.times)), abs=1e-14)


def test_a_normal_form_has_its_coordinates_and_the_outputs_of_the_state_space(tmp_path):
    changes = {"time.step_domain": "discrete", "time.step": 0.05, "time.hold": 0}
    form = mb.read_scene(EXAMPLES / "identified.toml", changes)
    answer, given = form.run(), mb.read_scene(EXAMPLES / "identified.toml", {**changes, "model.normal_form": False}).run()
    continuous = mb.read_scene(EXAMPLES / "identified.toml", {"time.step": 0.05}).run()
    assert answer.values[2:] == pytest.approx(given.values, abs=1e-13)
    assert answer.values[:2] == pytest.approx(continuous.values, abs=1e-13)  # a step is its own hold
    assert [name.split()[0] for name in list(answer.columns()[""])[2:]] == ["q1", "q2", "x1", "x2"]
    path = EXAMPLES / "identified_descriptor.toml"
    with pytest.raises(mb.SceneError, match='follows the second derivative of the input "table"'):
        mb.read_scene(path, {**changes, "time.hold": 1}).run()


def sampled_robot(name: str, step: float, hold: int, plots: list[str]) -> mb.Scene:
    changes = {"time.step_domain": "discrete", "time.step": step, "time.hold": hold, "output.plots": plots}
    return mb.read_scene(EXAMPLES / f"{name}.toml", changes)


def test_robots_are_sampled_on_their_motion_with_outputs_and_a_page(tmp_path):
    answer = sampled_robot("trapezoid", 0.1, 0, ["output", "displacement"]).run(tmp_path)
    continuous = mb.read_scene(EXAMPLES / "trapezoid.toml", {"time.step": 0.1}).run()
    assert np.abs(answer.values[:3] - continuous.values).max() < 1e-12 * np.abs(continuous.values).max()
    outputs = continuous.curves("output").values
    assert np.allclose(answer.values[3:], outputs, atol=1e-12 * np.abs(outputs).max())
    assert [plot.quantity for plot in answer.plots()].count("output") == 2
    assert "middle x" in (tmp_path / f"{answer.name}.csv").read_text().splitlines()[0]
    assert (tmp_path / f"{answer.name}.html").stat().st_size > 100_000 and not answer.animation.rates.any()
    path = next(body.path for body in answer.animation.drawing.bodies if body.path is not None and body.path.count > 1)
    poses = path.positions.reshape(3, -1, 6)
    assert (poses == poses[:, :, :1]).all()  # nothing moves between samples


def test_signals_between_samples_that_are_not_as_the_hold_are_reported():
    (notice,) = [one for one in sampled_robot("delta", 0.04, 0, ["output"]).run().notices if one.kind == "aliasing"]
    assert "between samples the given signal is up to 100 %" in notice.text
    assert not [one for one in sampled_robot("satellite", 0.5, 0, ["displacement"]).run().notices if one.kind == "aliasing"]


def test_impulses_on_a_robot_are_refused_by_name():
    with pytest.raises(mb.SceneError, match="Dirac impulses, which have no value at k"):
        sampled_robot("seven_joint_arm", 0.01, 1, ["displacement"]).run()


def test_a_frequency_response_is_left_out_with_a_notice(tmp_path):
    answer = scene(tmp_path, CART + '[frequency]\nfrequencies = ["1 Hz"]\n').run()
    assert any("[frequency] is left out" in notice.text for notice in answer.notices)


@pytest.mark.parametrize("domain", ['step_domain = "discrete"\nstep = "0.1 s"', "points = 11"])
def test_an_output_that_follows_its_input_at_once_is_no_fault_of_the_start(tmp_path, domain):
    model = '[model]\nkind = "state-space"\nA = [[-1]]\nB = [[1]]\nC = [[1]]\nD = [[2]]\n'
    load = '[[force]]\ncoordinate = "u1"\nkind = "step"\nvalue = 1\n'
    result = scene(tmp_path, f'{model}{load}[time]\nend = "1 s"\n{domain}\n').run()
    assert not any("does not fit" in notice.text for notice in result.notices)
    assert result.values[-1][0] == pytest.approx(2.0)  # y(0+) = D u
