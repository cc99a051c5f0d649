"""Units in factors of constraint rows and in matrices, parameters in numbers of teeth."""

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from tests.scene.scenes import scene_of

CAR = """
[parameters]
a = "1.01 m"
k = "20 N/mm"

[model]
kind = "matrices"
coordinates = ["heave", "pitch", "wheel"]
units = { pitch = "rad" }
mass = [["1 t", "3 kg*m", 0], ["3 kg*m", "2000 kg*m^2", 0], [0, 0, "40 kg"]]
stiffness = [["=k", "2 kN/rad", 0], ["2 kN", "500 kNm/rad", 0], [0, 0, 150]]

[[model.constraint]]
rows = { heave = 1, pitch = "1.01 m", wheel = -1 }
value = "2 mm"

[time]
end = 1
"""

GEARS = """
[parameters]
z1 = 20

[model]
kind = "lumped"
inertia = [{ name = "a", inertia = 1 }, { name = "b", inertia = 1 }]
gear = [{ between = ["a", "b"], teeth = ["=z1", 60] }]
[time]
end = 1
"""


def system(tmp_path, text, *change):
    return scene_of(tmp_path, text.replace(*change) if change else text).equations.system


@pytest.mark.parametrize("pitch", ['"1.01 m"', '"101 cm"', '"=a"'])
def test_a_factor_has_a_unit(tmp_path, pitch):
    read = system(tmp_path, CAR, '"1.01 m"' + ",", pitch + ",")
    assert read.constraint_matrix == pytest.approx(np.array([[1, 1.01, -1]]))
    assert read.rows[0].value == 0.002


def test_a_value_with_a_unit_needs_terms_of_one_unit(tmp_path):
    with pytest.raises(SceneError, match=r'value: found "2 mm"; this row mixes m and rad: give a plain number'):
        system(tmp_path, CAR, 'pitch = "1.01 m"', "pitch = 1.01")


def test_entries_of_matrices_are_in_si(tmp_path):
    read = system(tmp_path, CAR)
    assert np.array_equal(read.mass, [[1000, 3, 0], [3, 2000, 0], [0, 0, 40]])
    assert np.array_equal(read.stiffness, [[20000, 2000, 0], [2000, 500000, 0], [0, 0, 150]])


def test_a_row_whose_factors_all_have_units_has_their_common_unit(tmp_path):
    rows = '{ heave = "1 N/m", pitch = "2 Nm/rad", wheel = "3 N/m" }'
    with pytest.raises(SceneError, match=r'pitch: found "2 Nm/rad"; expected a factor in N, so that all terms'):
        system(tmp_path, CAR, '{ heave = 1, pitch = "1.01 m", wheel = -1 }', rows)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('pitch = "1.01 m"', 'pitch = "3 N"'), 'pitch: found "3 N"; expected a factor in m, so that all terms'),
        (('pitch = "1.01 m"', 'pitch = "=k"'), 'pitch: found "=k"; expected a factor in m, so that all terms'),
        (('"2000 kg*m^2"', '"2000 kg"'), r'model.mass\[2\]\[2\]: found "2000 kg", a mass; expected a moment of inertia'),
        (('"2 kN/rad"', '"2 kN/m"'), r'model.stiffness\[1\]\[2\]: found "2 kN/m", a stiffness; expected a quantity in N/rad'),
        (('"20 N/mm"', '"20 kg"'), r'model.stiffness\[1\]\[1\]: found "=k", a mass; expected a stiffness'),
    ],
)
def test_a_unit_of_another_kind_is_refused(tmp_path, change, message):
    with pytest.raises(SceneError, match=message):
        system(tmp_path, CAR, *change)


@pytest.mark.parametrize("count", ["20.5", "0", "-3"])
def test_teeth_are_whole_numbers(tmp_path, count):
    with pytest.raises(SceneError, match=rf'teeth\[1\]: found "=z1", which is {count}; expected a whole number of teeth'):
        system(tmp_path, GEARS, "z1 = 20", f"z1 = {count}")


LOUDSPEAKER = """
[parameters]
Bl = "7 N/A"
[model]
kind = "matrices"
coordinates = ["cone", "charge"]
units = { charge = "C" }
mass = [["15 g", 0], [0, "0.5 mH"]]
damping = [["1.2 N*s/m", "=-Bl"], ["=Bl", "6 ohm"]]
stiffness = [["2000 N/m", 0], [0, 0]]
[[force]]
coordinate = "charge"
kind = "harmonic"
value = "3 V"
frequency = "50 Hz"
[time]
end = "0.1 s"
[frequency]
inputs = ["charge"]
"""


def test_a_circuit_has_electrical_units(tmp_path):
    """Loudspeaker: m x'' + d x' + k x = Bl i, L i' + R i + Bl x' = u (Beranek, Acoustics, 1954); x/u = Bl / ((R + L s)(m s^2 + d s + k) + Bl^2 s)."""
    scene = scene_of(tmp_path, LOUDSPEAKER)
    f = np.array([20.0, 200.0])
    response = scene.system.frequency_response(frequencies_hz=f, inputs=["charge"])
    s = 2j * np.pi * f
    expected = 7 / ((6 + 0.5e-3 * s) * (0.015 * s**2 + 1.2 * s + 2000) + 49 * s)
    assert response.values[0, 0] == pytest.approx(expected, rel=1e-12)
    assert [row[0] for row in response.units] == ["m/V", "C/V"]
    assert scene.run(None).curves("force").units == ("V",)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (('"3 V"', '"3 N"'), 'found "3 N", a force; expected a quantity in V'),
        (("units = { charge", "units = { cone = 'm'}\n#"), "the coordinates of matrices have their unit in units below [model]"),
        (('charge = "C"', 'charge = "H"'), "expected"),
    ],
)
def test_units_of_circuits_are_checked(tmp_path, change, says):
    with pytest.raises(SceneError) as problem:
        scene_of(tmp_path, LOUDSPEAKER.replace(*change))
    assert says in str(problem.value)


@pytest.mark.parametrize(("unit", "force"), [("A", "V"), ("V", "A")])
def test_a_current_takes_voltages_and_a_node_currents(tmp_path, unit, force):
    """L i' + R i = u with L = 0.5 H, R = 2 ohm, and C u' + u / R = i: time constants of 0.25 s."""
    text = f"""
[model]
kind = "matrices"
coordinates = ["y"]
units = {{ y = "{unit}" }}
coefficients = [[[2]], [[0.5]]]
[[force]]
coordinate = "y"
kind = "step"
value = "6 {force}"
[time]
end = "1 s"
"""
    result = scene_of(tmp_path, text).run(None)
    assert result.motion(0.25)[0] == pytest.approx(3 * (1 - np.exp(-1)), rel=1e-12)
    assert f"y ({unit})" in result.summary()
