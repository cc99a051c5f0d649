"""Scene texts that tests change."""

from pathlib import Path

from mbconstrained.scene.run.scene import Scene, read_scene

EXAMPLES = Path(__file__).parents[2] / "examples"

CART_ON_SPRING = """
[model]
kind = "lumped"

[[model.mass]]
name = "cart"
mass = "2 kg"

[[model.spring]]
between = ["ground", "cart"]
stiffness = "8 N/m"
"""

OSCILLATOR = f"""{CART_ON_SPRING}
[initial]
displacement = {{ cart = 0.1 }}

[time]
end = "5 s"
points = 11
"""

MACHINE = """
[model]
kind = "lumped"
mass = [{ name = "machine", mass = "2 kg" }]
spring = [{ between = ["ground", "machine"], stiffness = "200 N/m" }]
damper = [{ between = ["ground", "machine"], damping = "4 N*s/m" }]
[time]
end = 1
"""

MATRICES = """
[model]
kind = "matrices"
coordinates = ["a", "b"]
mass = [[1, 0], [0, 1]]
stiffness = [[1, 0], [0, 4]]

[time]
end = 1
points = 5
"""

COEFFICIENTS = """
[model]
kind = "matrices"
coordinates = ["q"]
units = { q = "rad" }
coefficients = [[[4]], [[0]], [[1]]]

[time]
end = 1
points = 5
"""

#: Two masses, each on a spring of its own, to be filled in.
SLOW_AND_FAST = """
[model]
kind = "lumped"
[[model.mass]]
name = "slow"
mass = 1
[[model.mass]]
name = "fast"
mass = 1
[[model.spring]]
between = ["ground", "slow"]
stiffness = {slow}
[[model.spring]]
between = ["ground", "fast"]
stiffness = {fast}
{damper}
[initial]
displacement = {{ slow = 1, fast = {amplitude} }}
{force}
[time]
end = {end}
points = {points}
"""


def scene_of(folder: Path, text: str, name: str = "scene.toml", settings: dict | None = None) -> Scene:
    """The scene of a text, written into a folder."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return read_scene(path, settings)


#: An engine at 1500 rpm with a torque of 62.5 Hz on a damped chain of wheels: 125 periods, 3.2 of 401 even times in each.
DRIVELINE = """
title = "Marine driveline: engine, soft coupling, gear, propeller"
[parameters]
speed = "1500 rpm"
coupling = "12 kN*m/rad"
[model]
kind = "lumped"
inertia = [
  { name = "damper wheel", inertia = "0.8 kg*m^2" }, { name = "engine", inertia = "2.5 kg*m^2" },
  { name = "flywheel", inertia = "6 kg*m^2" }, { name = "pinion", inertia = "0.4 kg*m^2" },
  { name = "wheel", inertia = "3 kg*m^2" }, { name = "propeller", inertia = "20 kg*m^2" },
]
torsion_spring = [
  { between = ["damper wheel", "engine"], stiffness = "300 kN*m/rad" },
  { between = ["engine", "flywheel"], stiffness = "2 MN*m/rad" },
  { name = "coupling", between = ["flywheel", "pinion"], stiffness = "=coupling" },
  { name = "shaft", between = ["wheel", "propeller"], stiffness = "500 kN*m/rad" },
]
torsion_damper = [
  { between = ["damper wheel", "engine"], damping = "200 N*m*s/rad" },
  { between = ["flywheel", "pinion"], damping = "60 N*m*s/rad" },
  { between = ["ground", "propeller"], damping = "40 N*m*s/rad" },
]
gear = [{ name = "gear", between = ["pinion", "wheel"], teeth = [21, 63] }]
[[force]]
coordinate = "engine"
kind = "harmonic"
value = "300 N*m"
angular_frequency = "=2.5*speed"
[time]
end = "2 s"
[frequency]
inputs = ["engine"]
from = "0.5 Hz"
to = "200 Hz"
[output]
units = "mrad, kN"
plots = ["velocity", "reaction"]
reactions = true
[[output.quantity]]
of = "coupling"
quantity = "force"
"""
