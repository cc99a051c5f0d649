"""Derivatives of the equations of scenes with respect to their [parameters], against scenes that are read with other values."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.mechanics.parameter import Parameter

LUMPED = """
[parameters]
d = "20 mm"
m = "3 kg"
ratio = 2
g = "-9.81 m/s^2"
alpha = "0.3 1/s"
rate = "50 1/s"
[model]
kind = "lumped"
gravity = "=g"
rayleigh_damping = {{ mass = "=alpha", stiffness = "1 ms" }}
[[model.mass]]
name = "a"
mass = "=m"
[[model.inertia]]
name = "w1"
inertia = "=m*d^2"
[[model.inertia]]
name = "w2"
inertia = "=2*m*d^2*ratio"
[[model.spring]]
between = ["ground", "a"]
stiffness = "=0.4*ratio*m*rate^2"
rest_length = "=5*d"
[[model.torsion_spring]]
between = ["ground", "w2"]
stiffness = "=3*d^2*m*rate^2"
[[model.gear]]
between = ["w1", "w2"]
radii = ["=d", "=ratio*d"]
[[model.rack]]
gear = "w1"
rack = "a"
radius = "=d"
[time]
end = "1 s"
{more}
"""

MATRICES = """
[parameters]
k = "10 N/m"
b = "8 N/m"
m = "3 kg"
r = 2
[model]
kind = "matrices"
mass = [["=m", 0, 0], [0, "=2*m", 0], [0, 0, 1]]
stiffness = [["=2*k", "=-k", 0], ["=-k", "=k + k^2/b", 0], [0, 0, 4]]
[[model.constraint]]
rows = { x1 = "=r", x3 = -1 }
value = "=r/10"
[time]
end = "1 s"
"""


def written(folder, text):
    path = folder / "varied.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("text", [LUMPED.format(more=""), MATRICES], ids=["lumped", "matrices"])
def test_every_parameter_against_differences(tmp_path, text):
    path = written(tmp_path, text)
    scene = mb.read_scene(path)
    named = {one.name: one for one in scene.named_parameters()}
    assert list(named) == list(scene.parameters.values)
    system = scene.equations.system
    for name, own in named.items():
        other = Parameter.of_function(name, own.value, lambda value, name=name: mb.read_scene(path, {name: value}).equations.system)
        scale = np.abs(other.matrices(system.size)).max(axis=(1, 2), keepdims=True)
        np.testing.assert_allclose(
            own.matrices(system.size) / (scale + 1e-300), other.matrices(system.size) / (scale + 1e-300), atol=1e-9
        )
        np.testing.assert_allclose(own.force + np.zeros(system.size), other.force, atol=1e-9 * (1 + np.abs(other.force).max()))
        for mine, theirs in zip(own.constraint_rows(system), other.constraint_rows(system)):
            np.testing.assert_allclose(mine, theirs, atol=1e-9 * (1 + np.abs(theirs).max(initial=0.0)))


def test_parameters_of_modal_damping_and_robots(tmp_path):
    """Their equations come from modes and from an equilibrium, which follow the parameter."""
    text = LUMPED.replace('rayleigh_damping = {{ mass = "=alpha", stiffness = "1 ms" }}\n', "modal_damping = 0.05\n")
    text = text.replace('alpha = "0.3 1/s"\n', "").format(more="")
    d = mb.read_scene(written(tmp_path, text)).sensitivities(["ratio"])
    assert np.abs(d.damping_ratios).max() < 1e-9  # given by mode, whatever the parameter is
    values = [
        mb.read_scene(written(tmp_path, text), {"ratio": 2 + e}).equations.system.modes().natural_frequencies for e in (1e-4, -1e-4)
    ]
    np.testing.assert_allclose(d.natural_frequencies[0], (values[0] - values[1]) / 2e-4, rtol=1e-6)


def test_scenes_without_a_mechanical_system():
    with pytest.raises(mb.InputError, match="mass, damping and stiffness"):
        mb.read_scene("examples/transfer_function.toml").sensitivities()
