"""The command fatigue: a shaken box until failure, a record, and what is wrong with both."""

import json
import math

import numpy as np
import pytest

BOX = """
title = "A cart that swings"
[model]
kind = "lumped"
mass = [{ name = "cart", mass = 2 }]
spring = [{ name = "spring", between = ["ground", "cart"], stiffness = 8 }]
damper = [{ name = "damper", between = ["ground", "cart"], damping = 0.4 }]
[initial]
displacement = { cart = 0.3 }
[time]
end = 20
[[output.quantity]]
name = "stress"
of = "spring"
quantity = "force"
factor = "2 1/mm^2"
[random]
[[random.input]]
on = "cart"
white = 0.1
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "cart.toml"
    path.write_text(BOX, encoding="utf-8")
    return path


def test_damage_and_life_of_a_scene(command, scene, tmp_path):
    """Free: extremes e^{-pi k z / sqrt(1 - z^2)}; random: Rayleigh peaks with sigma^2 = G / (4 c k), n = sqrt(k/m) / 2 pi (narrow band)."""
    code, out, _ = command("fatigue", scene, "--exponent", "3", "--strength", "40 N", "--out", tmp_path / "out", "--json")
    assert code == 0
    data = json.loads(out)
    z = 0.4 / (2 * math.sqrt(16))
    q = math.exp(-math.pi * z / math.sqrt(1 - z**2))
    halves = [0.3 * 8 * q**k * (1 + q) / 2 for k in range(12)]  # half cycles in 20 s, whose period is 3.14 s
    spring = next(one for one in data["cycles"] if one["of"] == "spring")
    assert {one["of"] for one in data["cycles"]} == {"spring", "damper"}  # a stress has no strength in N
    assert spring["largest_range"] == pytest.approx(2 * halves[0], rel=1e-10)
    assert spring["damage"] == pytest.approx(sum((a / 40) ** 3 / 2 for a in halves), rel=1e-3)
    assert spring["life"] == pytest.approx(20 / spring["damage"], rel=1e-12)
    random = next(one for one in data["random"] if one["of"] == "spring")
    sigma = 8 * math.sqrt(0.1 / (4 * 0.4 * 8))
    narrow = 2 / (2 * math.pi) * (math.sqrt(2) * sigma / 40) ** 3 * math.gamma(2.5)
    assert random["rms"] == pytest.approx(sigma, rel=1e-10)
    assert random["damage_per_second"] == pytest.approx(narrow, rel=0.12)  # Dirlik's formula has a broader band
    assert sorted(path.suffixes[-1] for path in (tmp_path / "out").iterdir()) == [".csv", ".html", ".npz"]
    lines = (tmp_path / "out" / "cart.fatigue.cycles.csv").read_text().splitlines()
    assert lines[0] == "of,unit,range,mean,count" and lines[1].startswith("spring,N,")


def test_outputs_by_name_with_units_of_their_own(command, scene, tmp_path):
    arguments = ("fatigue", scene, "--exponent", "3", "--out", tmp_path / "out", "--json")
    code, out, _ = command(*arguments, "--strength", "160 MPa", "--output", "stress")
    assert code == 0
    (stress,) = json.loads(out)["cycles"]
    code, out, _ = command(*arguments, "--strength", "80 N", "--output", "spring")
    (spring,) = json.loads(out)["cycles"]
    assert stress["largest_range"] == pytest.approx(2e6 * spring["largest_range"], rel=1e-12)
    assert stress["damage"] == pytest.approx(spring["damage"], rel=1e-12)


def test_a_record(command, tmp_path):
    t = np.arange(0, 5, 0.01)
    lines = (f"{a:.2f};{b:.6f}".replace(".", ",") for a, b in zip(t, np.sin(40 * t) * np.sin(np.pi * t / 5)))
    (tmp_path / "logger.csv").write_text("t (s);a (g)\r\n" + "\r\n".join(lines))
    code, out, _ = command("fatigue", tmp_path / "logger.csv", "--exponent", "4", "--quality", "10", "--out", tmp_path / "out")
    assert code == 0 and "Cycles of the record in 4.99 s" in out and " g " in out
    f, damage = np.loadtxt(tmp_path / "out" / "logger.fatigue.csv", delimiter=",", skiprows=1).T
    assert f[damage.argmax()] == pytest.approx(40 / (2 * np.pi), rel=0.08)
    code, out, _ = command("fatigue", tmp_path / "logger.csv", "--exponent", "4", "--baseline", "linear", "--out", tmp_path / "out")
    assert code == 0 and "a linear baseline of at most" in " ".join(out.split())


def test_a_record_of_forces_has_cycles_alone(command, tmp_path):
    (tmp_path / "force.csv").write_text("t (s),F (kN)\n0,-2\n1,1\n2,-3\n3,5\n4,-1\n5,3\n6,-4\n7,4\n8,-2\n")
    code, out, _ = command(
        "fatigue", tmp_path / "force.csv", "--exponent", "2", "--strength", "3 kN", "--out", tmp_path / "out", "--json"
    )
    data = json.loads(out)
    assert (code, data["spectra"]) == (0, [])
    assert data["cycles"][0]["damage"] == pytest.approx((1.125 + 6 + 16 + 10.125 + 4.5) / 9, rel=1e-12)  # as in tests/frequency


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "give the exponent of the S-N curve: exponent in a table [fatigue], or --exponent"),
        (("--exponent", "0"), "exponent"),
        (("--exponent", "3", "--strength", "2 m"), "strength: found '2 m'; the outputs are in N"),
        (("--exponent", "3", "--strength", "-2 N"), "strength"),
        (("--exponent", "3", "--output", "sprong"), 'there is no "sprong"; did you mean "spring"'),
    ],
)
def test_mistakes_are_reported(command, scene, arguments, message):
    code, _, err = command("fatigue", scene, *arguments)
    assert code in (1, 2) and message in " ".join(err.split())
