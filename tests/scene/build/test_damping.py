"""Damping of a model as a whole: Rayleigh damping and damping ratios, of lumped models, matrices and robots."""

import numpy as np
import pytest

from mbconstrained.analyses.formula import formula_of, written
from mbconstrained.ground.errors import SceneError
from tests.scene.robots import press
from tests.scene.scenes import MATRICES, OSCILLATOR, scene_of


def scene(tmp_path, kind, damping):
    if kind == "robot":
        model = f'[model]\nkind = "robot"\nrobot = "robots/press"\n{damping}\n'
        press(tmp_path)
        return scene_of(tmp_path, model + "\n[time]\nend = 1\npoints = 3\n")
    text = {"lumped": OSCILLATOR, "matrices": MATRICES}[kind]
    return scene_of(tmp_path, text.replace(f'kind = "{kind}"', f'kind = "{kind}"\n{damping}'))


@pytest.mark.parametrize("kind", ["lumped", "matrices", "robot"])
def test_rayleigh_damping_adds_multiples_of_mass_and_stiffness(tmp_path, kind):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    free = scene(tmp_path / "a", kind, "").equations.system
    damped = scene(tmp_path / "b", kind, 'rayleigh_damping = { mass = "0.4 1/s", stiffness = "2 ms" }').equations.system
    wanted = free.damping + 0.4 * free.mass + 0.002 * free.stiffness
    assert damped.damping == pytest.approx(wanted, rel=1e-14)


@pytest.mark.parametrize("kind", ["lumped", "matrices"])
def test_modal_damping_is_that_of_every_mode(tmp_path, kind):
    modes = scene(tmp_path, kind, "modal_damping = 0.02").equations.system.modes()
    assert modes.damping_ratios == pytest.approx(np.full(len(modes.natural_frequencies), 0.02), rel=1e-9)


def test_a_formula_has_the_factors_of_rayleigh_damping_as_symbols(tmp_path):
    """2 x'' + 8 b x' + 8 x = 0 decays with exp(-2 b t)."""
    text = '[parameters]\nb = "0.1 s"\n' + OSCILLATOR
    read = scene_of(tmp_path, text.replace('"lumped"', '"lumped"\nrayleigh_damping = { stiffness = "=b" }'))
    assert "b" in written(formula_of(read), "text", None)
    assert "exp(-0.2 t)" in written(formula_of(read, numbers=True), "text", 6)


@pytest.mark.parametrize(
    ("damping", "message"),
    [
        ("modal_damping = [0.1, 0.2]", r"model.modal_damping: damping ratios: found 2; there is 1 oscillating mode"),
        ("modal_damping = -0.1", r"model.modal_damping: damping ratios: found -0.1; expected 0 or a positive number"),
        ('modal_damping = "2 s"', r'model.*modal_damping: found "2 s"; expected a plain number'),
        ("rayleigh_damping = { mass = -1 }", r"model.rayleigh_damping.mass: found -1.0; expected at least 0"),
        ('rayleigh_damping = { stiffness = "1 kg" }', r'found "1 kg", a mass; expected a time'),
    ],
)
def test_what_is_no_damping_is_refused(tmp_path, damping, message):
    with pytest.raises(SceneError, match=message):
        scene(tmp_path, "lumped", damping)
