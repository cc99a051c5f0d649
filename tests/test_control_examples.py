"""The examples of control engineering against published values, lumped models and closed forms written down here."""

import json
import math
import runpy
from pathlib import Path

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.scene.run.scene import read_scene

EXAMPLES = Path(__file__).parents[1] / "examples"


def run(name):
    return read_scene(EXAMPLES / f"{name}.toml").run()


# Hauksdottir and Sigurdsson, Eq. (47): y_2 at t = 1, 10, 100 s, rigorous enclosures, and the DC gain as a fraction.
RAMP = {1: 0.0070121242560890860894757065861656, 10: 131.18767570451995806147247349107, 100: 8200.0345467066184141515490506938}
STEP = {1: 0.033832953263242946872566884595169, 10: 40.795547852808303057519299818904, 100: 96.664772697369375799832049162454}


def test_transfer_function_reaches_the_published_values():
    result = run("transfer_function")
    times = np.array(list(RAMP), dtype=float)
    assert result.motion(times)[0] == pytest.approx(np.array(list(RAMP.values())), rel=1e-13)
    assert result.motion.derivative(1)(times)[0] == pytest.approx(np.array(list(STEP.values())), rel=1e-13)
    assert result.is_trusted
    ((_, _, found),) = result.scene.equations.control.transfers
    assert found.dc_gain == pytest.approx(79177500000 / 819000391, rel=1e-14)
    assert [zero.multiplicity for zero in found.poles] == [2, 1, 1, 1]


def test_transfer_function_is_accurate_where_sums_of_modes_cancel():
    """y_2 = t^5/120 - 1.02 t^6/720 + ...: the quotients of the coefficients, b_4 = 1 and b_3 - a_7 = 1.78 - 2.8."""
    y = run("transfer_function").motion([1e-4])[0, 0]
    assert y == pytest.approx(1e-20 / 120 - 1.02e-24 / 720 + 0.4893e-28 / 5040, rel=1e-13)


def two_masses():
    model = mb.LumpedModel()
    model.mass("one", 2.0), model.mass("two", 1.0)
    model.spring("ground", "one", stiffness=200.0), model.spring("one", "two", stiffness=100.0)
    model.damper("ground", "one", 4.0), model.damper("one", "two", 1.0)
    return model.assemble()


def test_identified_model_is_that_of_the_two_masses():
    result, masses = run("identified"), two_masses()
    inverse = np.linalg.inv(masses.mass)  # q = M x, so that the forces act as they are
    assert result.system.stiffness == pytest.approx(masses.stiffness @ inverse, rel=1e-10)
    assert result.system.damping == pytest.approx(masses.damping @ inverse, abs=1e-10 * 150)
    assert result.modes.natural_frequencies == pytest.approx(masses.modes().natural_frequencies, rel=1e-12)
    assert result.modes.damping_ratios == pytest.approx(masses.modes().damping_ratios, rel=1e-10)
    assert result.scene.equations.control.form.is_unique


def test_identified_model_moves_like_the_two_masses():
    result, masses = run("identified"), two_masses()
    expected = masses.solve(force=mb.step([0.0, 10.0]))(result.times)
    assert result.curves("output").values == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())
    assert result.values == pytest.approx(masses.mass @ expected, abs=1e-9 * np.abs(expected).max())
    assert result.curves("output").units == ("m", "m") and result.is_trusted
    assert result.curves("output").values[:, -1] == pytest.approx([10 / 200, 10 / 200 + 10 / 100], rel=0.2)  # near the rest


def test_unseen_mass_swings_by_itself():
    # x1'' + x1 = 0 from 0.5, x2'' + 4 x2 = 1 from rest
    result = run("unseen_mass")
    t, form = result.times, result.scene.equations.control.form
    expected = np.array([0.5 * np.cos(t), (1 - np.cos(2 * t)) / 4])
    assert result.curves("output").values == pytest.approx(expected, abs=1e-13)
    states = np.vstack([expected, -0.5 * np.sin(t), 0.5 * np.sin(2 * t)])
    largest = np.abs(states).max()
    assert np.abs(result.values - form.displacement_velocity(states)[0]).max() <= largest * max(result.error_estimate, 1e-13)
    assert result.modes.natural_frequencies == pytest.approx([1, 2], rel=1e-9)
    assert not form.is_unique and form.condition < 10


def test_the_obvious_displacements_of_the_unseen_mass_do_not_do():
    """Appendix B: X = [e1, e3] gives [X^T; X^T A] of rank 2, X = [e1, e2] the identity."""
    A = read_scene(EXAMPLES / "unseen_mass.toml").equations.control.system.A
    ranks = [np.linalg.matrix_rank(np.vstack([np.eye(4)[rows], np.eye(4)[rows] @ A])) for rows in ([0, 2], [0, 1])]
    assert ranks == [2, 4]


def test_descriptor_has_the_impulse_of_the_capacitor():
    # i = C1 u' + (u - v2)/R: 0.5 delta and 2.5 e^(-2 t); v2 = 5 (1 - e^(-2 t))
    result = run("descriptor")
    t, decay = result.times, np.exp(-2 * result.times)
    assert result.curves("output").values == pytest.approx(np.array([2.5 * decay, 5 * (1 - decay)]), abs=1e-14)
    assert result.values == pytest.approx(
        np.array([5 + 0 * t, 5 * (1 - decay), 2.5 * decay, 2.5 * decay, 5 * (1 - decay)]), abs=1e-14
    )
    (impulse,) = result.motion.impulses
    assert impulse == pytest.approx([0, 0, 0.5, 0.5, 0], rel=1e-15, abs=0)
    assert "current  δ           0.5 A s" in result.summary()
    (zero,) = result.finite_pair.zeros
    assert zero.value == pytest.approx(-2.0, rel=1e-14)
    assert math.isclose(result.scene.equations.control.transfers[1][2].dc_gain, 1.0, rel_tol=1e-14)


def test_identified_descriptor_is_the_moved_table():
    model = mb.LumpedModel()
    model.mass("table", 3.0), model.mass("one", 2.0), model.mass("two", 1.0)
    model.spring("table", "one", stiffness=200.0), model.spring("one", "two", stiffness=100.0)
    model.damper("table", "one", 4.0), model.damper("one", "two", 1.0)
    model.prescribe("table", mb.step([0.01]))
    motion, result = model.assemble().solve(), run("identified_descriptor")
    outputs, form = result.curves("output").values, result.scene.equations.control.form
    expected = motion(result.times)[1:]
    assert outputs[:2] == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    assert result.modes.natural_frequencies == pytest.approx(model.assemble().modes().natural_frequencies, rel=1e-9)
    assert [matrix[2, 0] for matrix in form.polynomial] == pytest.approx([192, 4, 3], rel=1e-9)
    impulses = [impulse[-1] for impulse in result.scene.equations.control.response.output_impulses]
    assert impulses == pytest.approx([0.04, 0.03], rel=1e-9) and form.infinite.index == 3


def test_models_without_a_normal_form_say_why(capsys):
    runpy.run_path(str(EXAMPLES / "no_normal_form.py"), run_name="__main__")
    first, second = capsys.readouterr().out.split("two uncoupled states")
    assert "rank [B, A B] = 1, but 2 p = 2 is needed" in first
    assert "rank [A - lambda I, B] = 2 at the eigenvalue lambda = 5, but at least n/2 + p = 3 is needed" in second


def test_a_scene_of_such_a_model_is_refused_with_the_same_words(tmp_path):
    text = (EXAMPLES / "unseen_mass.toml").read_text("utf-8")
    assert "[-1, 0, 0, 0], [0, -4, 0, 0]" in text
    path = tmp_path / "scene.toml"
    path.write_text(
        text.replace(
            "[[0, 0, 1, 0], [0, 0, 0, 1], [-1, 0, 0, 0], [0, -4, 0, 0]]", "[[5, 0, 0, 0], [0, 0, 0, 1], [0, 0, 5, 0], [0, 0, 0, 0]]"
        ),
        "utf-8",
    )
    with pytest.raises(mb.SceneError, match=r"scene\.toml: model\.normal_form: .*eigenvalue lambda = 5") as caught:
        read_scene(path)
    assert isinstance(caught.value.__cause__, mb.NoNormalForm)


def test_a_scene_with_a_singular_pencil_names_its_own_rows_and_states(tmp_path):
    text = (EXAMPLES / "identified_descriptor.toml").read_text("utf-8")
    (tmp_path / "scene.toml").write_text(
        text.replace("    [-1, 0, 0, 0, 0, 0, 0],\n]\nB", "    [0, 0, 0, 0, 0, 0, 0],\n]\nB"), "utf-8"
    )
    with pytest.raises((mb.SceneError, mb.SingularPolynomialMatrix), match='zero for every s.*"row 7".*"s1"'):
        read_scene(tmp_path / "scene.toml")


@pytest.mark.parametrize("name", ["transfer_function", "identified", "identified_descriptor", "unseen_mass", "descriptor"])
def test_transfer_functions_are_told_as_data(name):
    result = run(name)
    data = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    for entry in data["transfer_functions"]:
        s = 0.3 + 0.7j
        zeros, poles = ([complex(*pair) for pair in entry[key]] for key in ("zeros", "poles"))
        expected = entry["gain"] * np.prod(s - np.array(zeros)) / np.prod(s - np.array(poles))
        assert expected == pytest.approx(value(result.scene.equations.control, entry, s), rel=1e-9, abs=1e-13)
    assert ("normal_form" in data) == (name in ("identified", "identified_descriptor", "unseen_mass"))


def value(control, entry, s):
    if control.system is not None:
        row, column = control.system.outputs.index(entry["output"]), control.system.inputs.index(entry["input"])
        return control.system(s)[row, column]
    b, a = (
        [float(c) for c in p]
        for p in (control.transfer_function.fraction.numerator, control.transfer_function.fraction.denominator)
    )
    return np.polyval(b[::-1], s) / np.polyval(a[::-1], s)
