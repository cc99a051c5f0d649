"""Scenes of extreme sizes are solved without a warning of NumPy, which the runs of tests turn into errors."""

import pytest

import mbconstrained as mb

SCENES = {  # by the sizes that overflow or divide by zero on the way
    "massless_joints_formula": {"parameters.m": "1e-5 kg"},  # poles coincide at zero
    "four_bar": {"time.end": "1.2e12 s"},  # values near zero next to bounds of a growing motion
}


@pytest.mark.parametrize("name", SCENES)
def test_extreme_sizes_run(name):
    scene = mb.read_scene(f"examples/{name}.toml", SCENES[name])
    assert scene.run().tables
