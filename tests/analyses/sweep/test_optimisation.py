"""The best values of parameters against exact optima."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.sweep import optimisation


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


SCENE = """
[parameters]
c = "1 N*s/m"
k = "3 N/m"
[model]
kind = "lumped"
mass = [{ name = "cart", mass = "1 kg" }]
spring = [{ between = ["ground", "cart"], stiffness = "=k" }]
damper = [{ between = ["ground", "cart"], damping = "=c" }]
[initial]
displacement = { cart = 1 }
[time]
end = 1
"""


def test_an_interrupted_search_keeps_its_best(tmp_path, monkeypatch):
    """Ctrl-C after three batches of samples: the best of all that were computed, of a frequency sqrt(k / m) / (2 pi)."""
    (tmp_path / "cart.toml").write_text(SCENE, encoding="utf-8")
    scene, seen = mb.read_scene(tmp_path / "cart.toml"), []
    evaluated = optimisation.evaluate

    def interrupted(job, rows):
        if len(seen) > 60:
            raise KeyboardInterrupt
        seen.extend(rows)
        return evaluated(job, rows)

    monkeypatch.setattr(optimisation, "evaluate", interrupted)
    said = []
    optimum = optimisation.optimise(scene, {"k": "2..4 N/m", "c": "0.1..1"}, minimise="frequency 1", message=said.append)
    frequencies = [np.sqrt(row["k"]) / (2 * np.pi) for row in seen if row]
    assert optimum.interrupted and optimum.value == pytest.approx(min(frequencies), rel=1e-12)
    assert optimum.parameters == [row for row in seen if row][int(np.argmin(frequencies))]
    answer = optimum.answer()
    assert not answer.is_trusted and f"interrupted after {len(seen)} samples" in str(answer.notices)
    assert answer.to_dict()["interrupted"] is True and len(list(answer.plots())) == 1
    assert said[0].startswith("generation (of at most 60) 1: frequency 1 0.2") and "N/m, c = " in said[0]


def test_an_interruption_before_any_answer_is_one(tmp_path, monkeypatch):
    (tmp_path / "cart.toml").write_text(SCENE, encoding="utf-8")

    def interrupted(job, rows):
        raise KeyboardInterrupt

    monkeypatch.setattr(optimisation, "evaluate", interrupted)
    with pytest.raises(KeyboardInterrupt):
        mb.read_scene(tmp_path / "cart.toml").optimise({"k": "2..4 N/m"}, minimise="frequency 1")
