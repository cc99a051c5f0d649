"""Rotors in scenes: of matrices and of lumped elements, at rest and at speed, with the force of their unbalance."""

import re

import numpy as np
import pytest

import mbconstrained as mb
from tests.scene.scenes import scene_of

MATRICES = """
[model]
kind = "matrices"
coordinates = ["y", "z"]
mass = [[2, 0], [0, 2]]
stiffness = [[2e4, 0], [0, 2e4]]
damping = [[20, 0], [0, 20]]
gyroscopic = [[0, 0.4], [-0.4, 0]]
circulatory = [[0, 5], [-5, 0]]
speed = "600 rpm"

[[model.unbalance]]
coordinates = ["y", "z"]
moment = "50 g*mm"
angle = "30 deg"

[time]
end = "0.5 s"
points = 6
"""

ELEMENTS = """
[parameters]
k = "2 kN/mm"

[model]
kind = "lumped"
speed = "3000 rpm"

[[model.bearing]]
between = ["ground", "left"]
stiffness = ["=k", "3 kN/mm"]
damping = "200 N*s/m"

[[model.bearing]]
name = "film"
between = ["ground", "right"]
speeds = ["1000 rpm", "5000 rpm"]
stiffness = ["=k", [["=2*k", "0.1 kN/mm"], ["-0.1 kN/mm", "=2*k"]]]

[[model.rotor]]
name = "disc"
mass = "20 kg"
diametral_inertia = "0.5 kg*m^2"
polar_inertia = "0.3 kg*m^2"
points = { left = "-0.2 m", right = "0.3 m" }

[[model.unbalance]]
on = "disc"
moment = "20 g*mm"

[time]
end = "0.1 s"
points = 5
"""

W = 600 * 2 * np.pi / 60


def test_matrices_at_speed(tmp_path):
    equations = scene_of(tmp_path, MATRICES).equations
    assert equations.system.damping.tolist() == [[20, 0.4 * W], [-0.4 * W, 20]]
    assert equations.system.stiffness.tolist() == [[2e4, 5 * W], [-5 * W, 2e4]]
    assert equations.rotor.damping.tolist() == [[20, 0], [0, 20]] and equations.rotor.turns
    at_rest = scene_of(tmp_path, MATRICES.replace('speed = "600 rpm"\n', "")).equations
    assert at_rest.system.damping.tolist() == [[20, 0], [0, 20]] and not at_rest.loads


def test_the_unbalance_of_a_scene_is_a_turning_force(tmp_path):
    """Its steady state is (K + i W C - W^2 M)^-1 W^2 u; the start from rest decays."""
    scene = scene_of(tmp_path, MATRICES.replace('"0.5 s"', '"20 s"'))
    u = 5e-5 * np.exp(1j * np.pi / 6) * np.array([1.0, -1j])
    system, times = scene.equations.system, scene.times[-2:]
    steady = np.linalg.solve(system.stiffness + 1j * W * system.damping - W**2 * system.mass, W**2 * u)
    expected = (steady[:, None] * np.exp(1j * W * times)).real
    np.testing.assert_allclose(scene.run().motion.displacement(times), expected, atol=1e-8 * np.abs(steady).max())


def test_elements_of_a_rotor(tmp_path):
    equations = scene_of(tmp_path, ELEMENTS).equations
    assert equations.coordinates.names[:4] == ("disc y", "disc y angle", "left y", "right y")
    names, K = list(equations.system.names), equations.system.stiffness
    right = [names.index(f"right {plane}") for plane in "yz"]
    np.testing.assert_allclose(K[np.ix_(right, right)], [[3e6, 5e4], [-5e4, 3e6]], rtol=1e-12)
    assert K[names.index("left z"), names.index("left z")] == 3e6
    assert [load.name for load in equations.loads] == ["disc y", "disc z"]
    np.testing.assert_allclose(np.abs(equations.rotor.unbalance[names.index("disc z")]), 2e-5)


def test_sensitivities_of_a_rotor_are_at_its_speed(tmp_path):
    """dw/dk of the table's entries too, against central differences of whole scenes."""
    scene = scene_of(tmp_path, ELEMENTS)
    slope, step = scene.sensitivities(["k"]).natural_frequencies[0], 1e2
    up, down = (
        mb.read_scene(scene.path, {"k": 2e6 + sign * step}).equations.system.modes().natural_frequencies for sign in (1, -1)
    )
    np.testing.assert_allclose(slope, (up - down) / (2 * step), rtol=1e-5)


@pytest.mark.parametrize(
    "text, old, new, message",
    [
        (MATRICES, "gyroscopic", "gyroscopik", '"gyroscopik"; did you mean "gyroscopic"'),
        (MATRICES, '"600 rpm"', '"10 Hz"', 'model.speed: found "10 Hz"'),
        (MATRICES, "[[0, 0.4], [-0.4, 0]]", "[[0, 0.4]]", "model.gyroscopic: found 1 rows and 2 columns"),
        (MATRICES, "[[0, 0.4], [-0.4, 0]]", "[[0]]", "gyroscopic: expected shape"),
        (MATRICES, '["y", "z"]\nmoment', '["y", "x"]\nmoment', 'there is no coordinate "x"'),
        (MATRICES, "50 g*mm", "50 g", "model.unbalance[1].moment: "),
        (ELEMENTS, '"3000 rpm"', '"6000 rpm"', '628.319 rad/s; the table of the bearing "film" is from 104.72'),
        (ELEMENTS, 'speeds = ["1000 rpm", "5000 rpm"]', 'speeds = ["5000 rpm", "1000 rpm"]', "ascending"),
        (ELEMENTS, 'speeds = ["1000 rpm", "5000 rpm"]', "", "stiffness: "),
        (ELEMENTS, "diametral_inertia", "diametrical_inertia", 'did you mean "diametral_inertia"'),
        (ELEMENTS, '"0.3 kg*m^2"', '"-0.3 kg*m^2"', "polar inertia: found -0.3"),
        (ELEMENTS, '"200 N*s/m"', '"200 N/m"', "model.bearing[1].damping: "),
        (ELEMENTS, 'on = "disc"', 'on = "disk"', '"disk y"; did you mean "disc y"'),
    ],
)
def test_errors_name_the_place(tmp_path, text, old, new, message):
    with pytest.raises(mb.SceneError, match=re.escape(message)):
        scene_of(tmp_path, text.replace(old, new, 1))


def test_a_speed_of_what_does_not_turn(tmp_path):
    text = '[model]\nkind = "matrices"\nmass = [[1]]\nspeed = 3\n[time]\nend = 1\n'
    with pytest.raises(mb.SceneError, match=r"model.speed: nothing of this model turns"):
        scene_of(tmp_path, text)


def test_there_is_no_formula_of_a_rotor(tmp_path):
    with pytest.raises(mb.SceneError, match=r"output.formula: .*rotor"):
        scene_of(tmp_path, MATRICES + "[output]\nformula = true\n")
