"""The command locus."""

import json
from pathlib import Path

import numpy as np
import pytest

import mbconstrained as mb
from tests.polynomial.variation.test_special_points import exact_break_points
from tests.scene.scenes import EXAMPLES

SCENE = EXAMPLES / "tuned_mass_damper.toml"


@pytest.mark.long
def test_a_locus_has_its_break_points(command):
    """The root of the discriminant with 30 digits."""
    system = mb.read_scene(SCENE).equations.system
    damper = np.array([[1.0, -1.0], [-1.0, 1.0]])
    (expected,) = exact_break_points(*(np.linalg.solve(system.mass, A) for A in (system.stiffness, 0 * damper, damper)), 10, 1000)
    code, text, _ = command("locus", SCENE, "--vary", "absorber damper=10..1000 N*s/m:41", "--out", "out")
    assert code == 0 and max(map(len, text.splitlines())) <= 80
    assert "1 break point" in text and f"{expected:.6g}" in text
    page = Path("out/tuned_mass_damper.locus.html").read_text(encoding="utf-8")
    assert "Root locus over absorber damper" in page and "damping ratios 0.1, 0.2" in page


@pytest.mark.long
def test_data(command):
    code, text, _ = command("locus", SCENE, "--vary", "zeta=0.5..1.5", "--out", "out", "--json")
    data = json.loads(text)
    assert code == 0 and len(data["values"]) == 101 and len(data["branches"]) == 4
    (point,) = data["break_points"]
    assert point["residual"] < 1e-14 and point["eigenvalue"][1] == 0 and 0.98 < point["value"] < 0.99


@pytest.mark.long
@pytest.mark.parametrize(
    ("scene", "vary", "message"),
    [
        ("tuned_mass_damper", "absorber damper=1..10 N/m", "absorber damper: found"),
        ("tuned_mass_damper", "zetta=1..2:3", "no parameter"),
        ("tuned_mass_damper", "zeta=normal(1, 2 %)", "expected a range"),
        ("tuned_mass_damper", "zeta=2..1:5", "reversed"),
        ("tuned_mass_damper", "zeta=-1..1:5", "expected at least 0"),
        ("transfer_function", "a=1..2:5", "mass, damping and stiffness"),
    ],
)
def test_errors(command, scene, vary, message):
    code, _, errors = command("locus", EXAMPLES / f"{scene}.toml", "--vary", vary, "--out", "out")
    assert code == 1 and message in " ".join(errors.split())
