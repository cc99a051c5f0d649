"""Scene texts that tests change."""

from pathlib import Path

from mbconstrained.scene.run.scene import Scene, read_scene

EXAMPLES = Path(__file__).parents[2] / "examples"

OSCILLATOR = """
[model]
kind = "lumped"

[[model.mass]]
name = "cart"
mass = "2 kg"

[[model.spring]]
between = ["ground", "cart"]
stiffness = "8 N/m"

[initial]
displacement = { cart = 0.1 }

[time]
end = "5 s"
points = 11
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


def scene_of(folder: Path, text: str, name: str = "scene.toml") -> Scene:
    """The scene of a text, written into a folder."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return read_scene(path)
