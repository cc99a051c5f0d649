"""Lumped scenes: every kind of entry makes the element that the Python call makes."""

import numpy as np
import pytest

from mbconstrained.models.lumped import LumpedModel
from tests.scene.scenes import scene_of

EVERYTHING = """
[model]
kind = "lumped"
gravity = "-9.81 m/s^2"
node = [{ name = "joint" }, { name = "pinion", rotational = true }]
mass = [{ name = "cart", mass = "10 kg", position = "1 m" }, { name = "hook", mass = "5 kg" }, { name = "rod", mass = "1 kg" }]
inertia = [{ name = "motor", inertia = "0.1 kg*m^2" }, { name = "wheel", inertia = 0.4 }, { name = "drum", inertia = 0.3 }]
spring = [{ name = "front", between = ["ground", "cart"], stiffness = "3 N/mm", rest_length = "20 cm" }]
damper = [{ between = ["ground", "cart"], damping = 4 }]
torsion_spring = [{ between = ["motor", "pinion"], stiffness = "40 N*m/rad", rest_angle = "10 deg" }]
torsion_damper = [{ between = ["motor", "pinion"], damping = 0.5 }]
rigid_tie = [
  { between = ["joint", "cart"], distance = "0.5 m" }, { name = "coupling", between = ["wheel", "drum"], distance = "90 deg" },
]
lever = [{ between = ["cart", "rod"], arms = ["0.1 m", "0.3 m"] }]
gear = [{ between = ["pinion", "wheel"], teeth = [20, 60], internal = true }]
rack = [{ gear = "drum", rack = "hook", radius = "50 mm" }]
pulley = [{ between = ["cart", "hook"], over = "rod", length = "2 m" }]
constraint = [{ name = "held", rows = { motor = 1, wheel = -2 }, level = "velocity", value = "3 rad/s" }]
[time]
end = 1
"""


def everything() -> LumpedModel:
    model = LumpedModel()
    model.node("joint")
    model.node("pinion", rotational=True)
    model.mass("cart", 10.0, position=1.0)
    model.mass("hook", 5.0)
    model.mass("rod", 1.0)
    model.inertia("motor", 0.1)
    model.inertia("wheel", 0.4)
    model.inertia("drum", 0.3)
    model.spring("ground", "cart", stiffness=3000.0, rest_length=0.2, name="front")
    model.damper("ground", "cart", damping=4.0)
    model.torsion_spring("motor", "pinion", stiffness=40.0, rest_angle=np.pi / 18)
    model.torsion_damper("motor", "pinion", damping=0.5)
    model.rigid_tie("joint", "cart", distance=0.5)
    model.rigid_tie("wheel", "drum", distance=np.pi / 2, name="coupling")
    model.lever("cart", "rod", start_arm=0.1, end_arm=0.3)
    model.gear("pinion", "wheel", start_radius=20, end_radius=60, internal=True)
    model.rack("drum", "hook", radius=0.05)
    model.pulley("cart", "hook", over="rod", length=2.0)
    model.constrain({"motor": 1, "wheel": -2}, value=3.0, level="velocity", name="held")
    model.gravity(-9.81)
    return model


def test_every_entry_makes_its_element(tmp_path):
    model, system = everything(), everything().assemble()
    equations = scene_of(tmp_path, EVERYTHING).equations
    assert equations.model.elements == model.elements
    assert equations.coordinates.names == model.coordinates
    for name in ("mass", "damping", "stiffness", "static_force", "constraint_matrix"):
        assert np.array_equal(getattr(equations.system, name), getattr(system, name)), name


def test_coordinates_come_in_the_order_of_the_file(tmp_path):
    text = '[model]\nkind = "lumped"\n[[model.{}]]\nname = "a"\n{}\n[[model.{}]]\nname = "b"\n{}\n[time]\nend = 1\n{}'
    held = '[[model.spring]]\nbetween = ["a", "b"]\nstiffness = 1\n[[model.spring]]\nbetween = ["ground", "a"]\nstiffness = 1'
    for first, second in ((("node", ""), ("mass", "mass = 1")), (("mass", "mass = 1"), ("node", ""))):
        assert scene_of(tmp_path, text.format(*first, *second, held)).equations.coordinates.names == ("a", "b")


def test_gear_by_radii(tmp_path):
    by_radii = scene_of(tmp_path, EVERYTHING.replace("teeth = [20, 60]", 'radii = ["20 mm", "60 mm"]'))
    by_teeth = scene_of(tmp_path, EVERYTHING)
    assert by_radii.equations.system.constraint_matrix == pytest.approx(by_teeth.equations.system.constraint_matrix)
