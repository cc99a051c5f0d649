"""The command sensitivity."""

import json
from pathlib import Path

import pytest

SCENE = """
[parameters]
k = "4 N/m"
m = "1 kg"
[model]
kind = "lumped"
mass = [{ name = "cart", mass = "=m" }]
spring = [{ between = ["ground", "cart"], stiffness = "=k" }]
damper = [{ between = ["ground", "cart"], damping = "0.2 N s/m" }]
[time]
end = "1 s"
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path


@pytest.mark.long
def test_frequency_and_damping_of_one_mass(command, scene):
    """f = sqrt(k / m) / 2 pi and zeta = c / 2 sqrt(k m): half a per cent per per cent, and half of zeta = 0.05."""
    code, text, _ = command("sensitivity", scene)
    assert code == 0
    rows = {
        line.split()[0]: [float(entry) for entry in line.split()[1:]]
        for line in text.splitlines()
        if line.startswith(("  k ", "  m "))
    }
    assert rows["k"] == pytest.approx([0.5, -0.025], abs=1e-3)
    assert rows["m"] == pytest.approx([-0.5, -0.025], abs=1e-3)
    assert max(map(len, text.splitlines())) <= 80


@pytest.mark.long
def test_an_unknown_name_is_a_message(command, scene):
    code, _, errors = command("sensitivity", scene, "--to", "kk")
    assert code == 1
    assert "kk" in errors and "Traceback" not in errors


@pytest.mark.long
def test_real_eigenvalues_are_no_oscillating_modes(command, scene):
    """Overdamped, s = -c/2m +- root: all eigenvalues depend on k, but no natural frequency of the table does."""
    scene.write_text(SCENE.replace("0.2 N s/m", "20 N s/m"))
    code, text, _ = command("sensitivity", scene, "--to", "k")
    assert code == 0
    assert "No oscillating mode depends on k;" in text
    slopes = json.loads(command("sensitivity", scene, "--to", "k", "--json")[1])["sensitivities"][0]["eigenvalues"]
    root = 96**0.5  # of (c / 2 m)^2 - k / m
    assert sorted(value for value, _ in slopes) == pytest.approx([-0.5 / root, 0.5 / root], rel=1e-12)


@pytest.mark.long
def test_state_spaces_with_a_normal_form_have_their_entries(command):
    """The system of a state space in normal form is varied by the entries of its matrices."""
    code, text, errors = command("sensitivity", Path(__file__).parents[2] / "examples" / "unseen_mass.toml")
    assert code == 0 and not errors
    assert "stiffness[" in text
