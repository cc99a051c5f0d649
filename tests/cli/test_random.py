"""The command random: its table on 80 columns, its files, and messages for what is wrong in [random]."""

import json

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.scene.run.frequency.scene_random import SceneRandom
from mbconstrained.scene.run.scene import read_scene

SCENE = """
[model]
kind = "lumped"
mass = [{ name = "machine", mass = "2 kg" }]
spring = [{ between = ["ground", "machine"], stiffness = "200 N/m" }]
damper = [{ between = ["ground", "machine"], damping = "4 N*s/m" }]
[time]
end = 1
"""
WHITE = '[[random.input]]\non = "machine"\nwhite = 3\n'


def scene(folder, random=WHITE):
    path = folder / "machine.toml"
    path.write_text(SCENE + random, encoding="utf-8")
    return str(path)


def test_it_prints_rms_values_and_writes_page_csv_and_npz(command, tmp_path):
    """E[x^2] = G / (4 c k)."""
    code, out, err = command("random", scene(tmp_path))
    assert (code, err) == (0, "") and max(map(len, out.splitlines())) <= 80
    assert f"{np.sqrt(3 / (4 * 4 * 200)):.5g} m" in out
    names = {path.name for path in (tmp_path / "results" / "machine").iterdir()}
    assert names == {f"machine.random.{ending}" for ending in ("html", "csv", "npz")}
    with np.load(tmp_path / "results" / "machine" / "machine.random.npz") as data:
        assert np.isclose(data["covariance"].item(), 3 / (4 * 4 * 200), rtol=1e-12)
        assert np.isclose(data["psd"][0, 0], 3 / 200**2, rtol=1e-2)


def test_infinite_variances_are_texts_and_null(command, tmp_path):
    """The acceleration follows white noise directly."""
    path = scene(tmp_path, '[random]\nquantity = "acceleration"\n' + WHITE)
    code, out, _ = command("random", path)
    assert code == 0 and "infinite" in out and "inf " not in out and "nan" not in out
    data = json.loads(command("random", path, "--json")[1])
    assert data["rms"] == [None] and "directly" in data["infinite"]["machine"]


def test_what_is_wrong_is_named_with_its_place(command, tmp_path):
    """One message each, no traceback."""
    cases = [
        ("", "no table [random]"),
        (WHITE.replace("machine", "machin"), '"machine"'),
        (WHITE.replace("white = 3", "values = [1, 2]"), "frequencies and values"),
        (WHITE.replace("white = 3", 'values = [1, 2]\nfrequencies = ["2 Hz", "1 Hz"]'), "ascending"),
        (WHITE.replace("white = 3", ""), "expected one of values"),
        (WHITE + 'of = "acceleration"\n', "no constraint row"),
        (WHITE + 'unit = "N"\n', "squared per Hz"),
        (WHITE.replace("white = 3", "white = -3"), "white"),
    ]
    for text, message in cases:
        with pytest.raises(SceneError) as problem:
            _ = SceneRandom(read_scene(scene(tmp_path, text))).response
        assert message in str(problem.value), text
    code, out, err = command("random", scene(tmp_path, ""))
    assert (code, out) == (1, "") and err.strip().startswith("machine.toml: random: the scene has no table [random]")
