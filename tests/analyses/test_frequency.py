"""The frequency response of a scene: what is chosen, its units and files, its pictures, and what wrong entries are answered."""

import json

import numpy as np
import pytest

from mbconstrained.analyses.frequency import Frequency
from mbconstrained.ground.display import TextTable, table_text
from mbconstrained.ground.errors import SceneError
from tests.scene.scenes import COEFFICIENTS, OSCILLATOR, scene_of

#: A machine of 2 kg and 50 Hz on a mount of damping ratio 0.05, on a floor that moves.
K = 2 * (2 * np.pi * 50) ** 2
ISOLATED = f"""
[model]
kind = "lumped"
mass = [{{ name = "machine", mass = 2 }}]
node = [{{ name = "floor" }}]
spring = [{{ name = "mount", between = ["floor", "machine"], stiffness = {K!r} }}]
damper = [{{ between = ["floor", "machine"], damping = {2 * 0.05 * float(np.sqrt(2 * K))!r} }}]
[[motion]]
coordinate = "floor"
kind = "harmonic"
frequency = "5 Hz"
value = "1 mm"
[time]
end = 1
"""


def frequency_of(folder, text, **options):
    scene = scene_of(folder, text)
    return Frequency(scene, Frequency.changed(scene.table.frequency, options, scene.file_name))


def transmissibility(f, zeta=0.05, natural=50.0):
    """Of a mass on a spring and a damper in parallel (Inman, Engineering Vibration, section 2.4)."""
    r = np.asarray(f) / natural
    return (1 + 2j * zeta * r) / (1 - r**2 + 2j * zeta * r)


def test_a_prescribed_motion_is_the_input_and_the_free_coordinates_are_outputs(tmp_path):
    own = frequency_of(tmp_path, ISOLATED + '[frequency]\nquantity = "transmissibility"\nfrom = "5 Hz"\nto = "30000 rpm"')
    response = own.response
    assert (response.inputs, response.outputs) == (("motion of floor",), ("machine",))
    assert response.frequencies_hz[[0, -1]] == pytest.approx([5.0, 500.0], rel=1e-15)
    assert np.allclose(response.values[0, 0], transmissibility(response.frequencies_hz), rtol=1e-12)
    (peak,) = own.peaks
    r = np.sqrt((np.sqrt(1 + 8 * 0.05**2) - 1) / (4 * 0.05**2))  # of the largest amplitude (Inman, equation 2.71)
    assert np.isclose(peak.frequency_hz, 50 * r, rtol=1e-9) and np.isclose(peak.amplitude, abs(transmissibility(50 * r)))


@pytest.mark.parametrize("spacing", ["linear", "log"])
def test_even_steps_and_given_frequencies(tmp_path, spacing):
    own = frequency_of(tmp_path, ISOLATED, **{"from": "1 Hz", "to": 100, "spacing": spacing, "points": 5})
    steps = np.diff(own.response.frequencies_hz if spacing == "linear" else np.log(own.response.frequencies_hz))
    assert len(steps) == 4 and np.allclose(steps, steps[0])
    given = frequency_of(tmp_path, ISOLATED, frequencies=["120 rpm", 1])
    assert given.response.frequencies_hz == pytest.approx([1.0, 2.0], rel=1e-15)


def test_units_of_output_hold_for_values_peaks_and_files(tmp_path):
    own = frequency_of(tmp_path, ISOLATED + '[output]\nunits = "mm, kN"', inputs=["machine"], axis="rpm")
    answer = own.to_answer()
    answer.write(tmp_path / "out")
    assert [each.tolist() for each in own.shown] == [[["mm/kN"]], [[1e6]]]
    (peak,) = own.peaks
    text = "\n".join(table_text(block) if isinstance(block, TextTable) else block for block in answer.blocks())
    assert f"{1e6 * peak.amplitude:.4g} mm/kN" in text and f"{60 * peak.frequency_hz:.5g}" in text and "rev/min" in text
    head, *lines = (tmp_path / "out" / "scene.frequency.csv").read_text("utf-8").splitlines()
    assert head.split(",") == ["frequency (Hz)", "real machine/machine (mm/kN)", "imag machine/machine (mm/kN)"]
    first = np.array([float(cell) for cell in lines[0].split(",")])
    assert np.allclose(first[1] + 1j * first[2], 1e6 * own.response.values[0, 0, 0], rtol=1e-15)
    with np.load(tmp_path / "out" / "scene.frequency.npz", allow_pickle=False) as arrays:
        assert np.array_equal(arrays["values"], own.response.values) and arrays["units"].tolist() == [["m/N"]]


def test_a_run_computes_and_writes_it_where_the_scene_has_the_table(tmp_path):
    result = scene_of(tmp_path, ISOLATED + "[frequency]\n").run(tmp_path / "out")
    assert {path.name for path in result.files} >= {f"scene.frequency.{ending}" for ending in ("html", "csv", "npz")}
    assert any(table.title == "Peaks of the receptance" for table in result.tables)
    assert {"frequency response", "frequency page and files"} <= {stage.name for stage in result.plan.needed}
    without = scene_of(tmp_path, ISOLATED)
    assert "frequency response" in {stage.name for stage in without.plan().left_out}


@pytest.mark.parametrize("amplitude", ["log", "linear", "dB"])
def test_the_curves_of_the_page_are_the_response_at_every_frequency(tmp_path, amplitude):
    own = frequency_of(tmp_path, ISOLATED, quantity="transmissibility", amplitude=amplitude, axis="rad/s", plots=["bode", "parts"])
    size, phase, real, imaginary = own.to_answer().page().plots
    assert size.unit == ("dB re 1" if amplitude == "dB" else "")
    functions, row = size.curves[0].function
    omega = np.geomspace(size.times[0], size.times[-1], 50)
    T = transmissibility(omega / (2 * np.pi))
    expected = 20 * np.log10(np.abs(T)) if amplitude == "dB" else np.abs(T)
    assert np.allclose(functions.at(omega)[row], expected, rtol=1e-9, atol=1e-9)
    functions, row = phase.curves[0].function
    assert np.allclose(functions.at(omega)[row], np.degrees(np.unwrap(np.angle(T))), atol=1e-9)
    assert np.allclose(real.curves[0].values + 1j * imaginary.curves[0].values, transmissibility(real.times / (2 * np.pi)))
    assert [curve.name for curve in size.curves] == ["machine", "as the support"] and phase.unit == "°"


def test_the_picture_of_an_undamped_resonance_is_finite_and_its_phase_falls_by_half_a_turn(tmp_path):
    own = frequency_of(tmp_path, OSCILLATOR, plots=["bode", "nyquist"])
    size, phase, nyquist = own.to_answer().page().plots
    assert size.axes[1].high < 1e5 and np.isfinite(nyquist.curves[0].values).all()
    assert set(phase.curves[0].values.tolist()) == {0.0, -180.0}
    data = own.to_answer().to_dict()
    (peak,) = data["peaks"]
    assert peak["amplitude"] is None and np.isclose(peak["frequency_hz"], 1 / np.pi)
    json.dumps(data, allow_nan=False)


def test_models_of_coefficients_have_responses_without_units(tmp_path):
    own = frequency_of(tmp_path, COEFFICIENTS)
    omega = own.response.angular_frequencies
    far = np.abs(omega - 2) > 1e-3  # nearer to the pole 4 - w^2 loses digits
    assert np.allclose(own.response.values[0, 0, far], 1 / (4 - omega[far] ** 2), rtol=1e-10)
    with pytest.raises(SceneError, match="frequency: loss_factor belongs to models with mass"):
        frequency_of(tmp_path, COEFFICIENTS, loss_factor=0.1).response


def test_structural_damping_by_spring_is_that_of_the_formula(tmp_path):
    own = frequency_of(tmp_path, OSCILLATOR.replace("[[model.spring]]", '[[model.spring]]\nname = "s"'), loss_factor={"s": 0.1})
    assert np.allclose(own.response.values[0, 0], 1 / (8 * (1 + 0.1j) - 2 * own.response.angular_frequencies**2))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"inputs": ["machin"]}, "frequency: inputs: there is no \"machin\"; did you mean \"machine\"?"),
        ({"outputs": ["mashine"]}, "did you mean \"machine\"?"),
        ({"quantity": "mobilty"}, 'frequency.quantity: found "mobilty"; expected "receptance", "mobility"'),
        ({"from": "-1 Hz"}, "frequency.from: found"),
        ({"from": "2 kg"}, "frequency.from: found"),
        ({"to": float("inf")}, "frequency.to: found"),
        ({"from": 3, "to": 2}, "frequency: from is 3 Hz and to 2 Hz; expected a range that ascends"),
        ({"frequencies": [1, -2]}, "frequency.frequencies: found -2 Hz"),
        ({"frequencies": [1], "to": 2}, "frequencies and to cannot both be given"),
        ({"spacing": "log", "from": 0, "to": 2}, "need a positive lowest frequency"),
        ({"spacing": "linear"}, 'needs the range: give from and to'),
        ({"points": 10}, 'points needs spacing = "linear" or "log"'),
        ({"qantity": "mobility"}, 'frequency: unknown key "qantity"; did you mean "quantity"?'),
        ({"loss_factor": {"mout": 0.1}}, "there is no spring 'mout'; did you mean \"mount\"?"),
        ({"quantity": "transmissibility", "inputs": ["machine"]}, 'the input "machine" is a force; expected supports'),
    ],
)  # fmt: skip
def test_wrong_entries_name_their_place(tmp_path, options, words):
    with pytest.raises(SceneError) as caught:
        frequency_of(tmp_path, ISOLATED, **options).response
    assert words in str(caught.value) and str(caught.value).startswith("scene.toml: frequency")


def test_transmissibility_and_reactions_need_a_support(tmp_path):
    with pytest.raises(SceneError, match=r"transmissibility is by a prescribed motion, and there is none: add a \[\[motion\]\]"):
        frequency_of(tmp_path, OSCILLATOR, quantity="transmissibility").response
    with pytest.raises(SceneError, match="reaction is the force of a constraint row, and there are none"):
        frequency_of(tmp_path, OSCILLATOR, quantity="reaction").response


def test_motion_relative_to_a_support_is_absolute_motion_less_that_of_the_support(tmp_path):
    options = {"quantity": "transmissibility", "frequencies": [1, 45, 200]}
    absolute, relative = (frequency_of(tmp_path, ISOLATED, **options, **more) for more in ({}, {"relative_to": "floor"}))
    assert np.allclose(relative.response.values, absolute.response.values - 1, rtol=1e-13)


def test_the_name_of_a_support_is_its_motion(tmp_path):
    of_row, of_support = (
        frequency_of(tmp_path, ISOLATED, inputs=[name], frequencies=[1, 45]) for name in ("motion of floor", "floor")
    )
    assert (of_support.response.values == of_row.response.values).all() and of_support.response.inputs == ("floor",)
    assert np.allclose(of_support.response.values[0, 0], transmissibility([1, 45]), rtol=1e-13)


def test_an_input_that_reaches_nothing_is_reported(tmp_path):
    scene = ISOLATED.replace('name = "machine", mass = 2 }', 'name = "machine", mass = 2 }, { name = "other", mass = 1 }')
    own = frequency_of(tmp_path, scene, inputs=["other"], outputs=["machine"], frequencies=[1, 2])
    assert any('the input "other" reaches none of the outputs' in notice.text for notice in own.notices)
