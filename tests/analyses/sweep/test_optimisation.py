"""The best values of parameters against exact optima."""

import numpy as np
import pytest

import mbconstrained as mb


@pytest.mark.long
def test_the_tuned_mass_damper_has_its_exact_optimum():
    """Both peaks of the response are equal at the optimum of Den Hartog's absorber, mass ratio 0.05: 6.407921 of the static deflection.

    The textbook's sqrt(1 + 2 / 0.05) = 6.4031 belongs to the fixed points, which no damping makes the peaks.
    """
    scene = mb.read_scene("examples/tuned_mass_damper.toml")
    optimum = scene.optimise({"tuning": "0.85..1.05", "zeta": "0.05..0.3"}, minimise="response peak machine by machine")
    values = scene.parameters.values
    static = values["m"] * (2 * np.pi * values["natural"]) ** 2
    assert optimum.value * static == pytest.approx(6.407921, rel=1e-6)
    assert optimum.parameters["tuning"] == pytest.approx(values["tuning"], abs=1e-5)  # the exact optimum, as the scene has it
    assert optimum.parameters["zeta"] == pytest.approx(values["zeta"], abs=1e-5)
    assert not optimum.at_bounds


@pytest.mark.long
def test_a_bound_that_is_reached_is_reported():
    scene = mb.read_scene("examples/tuned_mass_damper.toml")
    optimum = scene.optimise({"zeta": "0.2..0.3"}, minimise="response peak machine by machine")
    assert optimum.parameters["zeta"] == pytest.approx(0.2, rel=1e-5)
    assert list(optimum.at_bounds) == ["zeta"]


@pytest.mark.parametrize(
    ("parameters", "options", "message"),
    [
        ({"zeta": "0.1..0.2"}, {}, "figure"),
        ({"zeta": "0.1..0.2"}, {"minimise": "respons peak"}, "response peak"),
        ({"zeta": [0.1, 0.2]}, {"minimise": "response peak machine by machine"}, "zeta"),
        ({"zeda": "0.1..0.2"}, {"minimise": "response peak machine by machine"}, "zeta"),
        ({}, {"minimise": "response peak machine by machine"}, "parameter"),
    ],
)
def test_wrong_questions_are_messages(parameters, options, message):
    with pytest.raises(mb.InputError, match=message):
        mb.read_scene("examples/tuned_mass_damper.toml").optimise(parameters, **options)
