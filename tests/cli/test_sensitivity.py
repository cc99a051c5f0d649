"""The command sensitivity."""

import json

import pytest

SCENE = """
[parameters]
k = "4 N/m"
m = "1 kg"
[model]
kind = "lumped"
[[model.mass]]
name = "cart"
mass = "=m"
[[model.spring]]
between = ["ground", "cart"]
stiffness = "=k"
[[model.damper]]
between = ["ground", "cart"]
damping = "0.2 N s/m"
[time]
end = "1 s"
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path


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


def test_json_and_chosen_names(command, scene):
    code, text, _ = command("sensitivity", scene, "--to", "k", "--json")
    assert code == 0
    assert "k" in json.dumps(json.loads(text)) and '"m"' not in json.dumps(json.loads(text))


def test_an_unknown_name_is_a_message(command, scene):
    code, _, errors = command("sensitivity", scene, "--to", "kk")
    assert code == 1
    assert "kk" in errors and "Traceback" not in errors
