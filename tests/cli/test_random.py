"""The command random: its table on 80 columns, its files, and messages for what is wrong in [random]."""

import json

import numpy as np
import pytest

from mbconstrained.analyses.random import Random, random_response
from mbconstrained.ground.errors import SceneError
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import MACHINE

WHITE = '[[random.input]]\non = "machine"\nwhite = 3\n'


def scene(folder, random=WHITE):
    path = folder / "machine.toml"
    path.write_text(MACHINE + random, encoding="utf-8")
    return str(path)


@pytest.mark.long
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


def test_plots_of_the_page(tmp_path):
    """Steps of octaves that add up, the exact cumulative RMS, a path within its band about two thirds of the time; parts of an infinite output."""
    plots = {plot.title: plot for plot in Random.answer(read_scene(scene(tmp_path))).plots()}
    octaves, rising, path = (plots[title] for title in ("RMS of octaves", "RMS up to a frequency", "a random path of machine"))
    rms = np.sqrt(3 / (4 * 4 * 200))
    assert np.isclose(np.square(octaves.curves[0].values[::2]).sum(), rms**2, rtol=1e-3)
    assert np.isclose(rising.curves[0].values[-1], rms, rtol=1e-3)
    assert np.isclose(path.curves[1].values[0], rms) and np.isclose(path.curves[2].values[0], -rms)
    assert 0.5 < np.mean(np.abs(path.curves[0].values) < rms) < 0.85
    rough = Random.answer(read_scene(scene(tmp_path, '[random]\nquantity = "acceleration"\n' + WHITE)))
    assert [plot.title for plot in rough.plots()] == [
        "spectrum of the acceleration",
        "RMS of octaves",
        "RMS up to a frequency",
        "spectrum of the input, force",
    ]


@pytest.mark.long
def test_what_is_wrong_is_named_with_its_place(command, tmp_path):
    """One message each, no traceback."""
    cases = [
        ("", "no table [random]"),
        (WHITE.replace("machine", "machin"), '"machine"'),
        (WHITE.replace("white = 3", "values = [1, 2]"), "frequencies and values"),
        (WHITE.replace("white = 3", 'values = [1, 2]\nfrequencies = ["2 Hz", "1 Hz"]'), "ascending"),
        (WHITE.replace("white = 3", ""), "expected one of values"),
        (WHITE + 'of = "acceleration"\n', "nothing prescribes its motion"),
        (WHITE + 'unit = "N"\n', "squared per Hz"),
        (WHITE.replace("white = 3", "white = -3"), "white"),
    ]
    for text, message in cases:
        with pytest.raises(SceneError) as problem:
            _ = random_response(read_scene(scene(tmp_path, text)))
        assert message in str(problem.value), text
    code, out, err = command("random", scene(tmp_path, ""))
    assert (code, out) == (1, "") and err.strip().startswith("machine.toml: random: the scene has no table [random]")


def test_outputs_are_chosen_on_the_command_line(command, tmp_path):
    """White force of density G on a damped oscillator: E[v^2] = G / (4 c m)."""
    code, out, _ = command("random", scene(tmp_path), "--output", "machine", "--quantity", "velocity", "--json")
    data = json.loads(out)
    assert code == 0 and (data["outputs"], data["quantity"]) == (["machine"], "velocity")
    assert data["rms"] == pytest.approx([np.sqrt(3 / (4 * 4 * 2))], rel=1e-12)
    code, _, problem = command("random", scene(tmp_path), "--output", "machin")
    assert code == 1 and 'did you mean "machine"' in problem


def test_densities_have_their_units_in_their_values(tmp_path):
    """White force: E[x^2] = G / (4 c k); 1 kN^2/Hz is 1e6 N^2/Hz. A table in g^2/Hz is that with unit = "g^2/Hz"."""
    white = WHITE.replace("3", '"3e-6 kN^2/Hz"')
    assert random_response(read_scene(scene(tmp_path, white))).rms[0] == pytest.approx(np.sqrt(3 / (4 * 4 * 200)), rel=1e-12)
    table = """[[motion]]
coordinate = "machine"
kind = "step"
value = 0
[[random.input]]
on = "machine"
of = "acceleration"
frequencies = ["10 Hz", "20 Hz"]
values = {}
"""
    supported = MACHINE.replace("spring = [", 'node = [{ name = "base" }]\nspring = [').replace(
        '"ground", "machine"', '"base", "machine"'
    )
    own = table.replace('"machine"', '"base"')
    found = []
    for values in ('["0.01 g^2/Hz", "0.04 g^2/Hz"]', '[0.01, 0.04]\nunit = "g^2/Hz"'):
        (tmp_path / "supported.toml").write_text(supported + own.format(values), encoding="utf-8")
        found.append(random_response(read_scene(tmp_path / "supported.toml")))
    assert found[0].rms.tolist() == found[1].rms.tolist()
    assert found[0].spectra.spectra[0].name == found[1].spectra.spectra[0].name


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ('["1 N^2/Hz", 3]', "found values in N^2/Hz and numbers without a unit; give all of them with the same unit"),
        ('["1 N^2/Hz", "3 kN^2/Hz"]', "found values in N^2/Hz and kN^2/Hz"),
        ('["1 N^2/Hz", "3 N^2/Hz"]\nunit = "N^2/Hz"', "found values in N^2/Hz; give all"),
        ('["1 N", "3 N"]', '"N" is no density: it must be a unit squared per Hz'),
        ('["one", 3]', 'found "one"; expected a number with its unit'),
    ],
)
def test_densities_of_several_units_are_refused(tmp_path, values, message):
    table = f'[[random.input]]\non = "machine"\nfrequencies = [1, 2]\nvalues = {values}\n'
    with pytest.raises(SceneError) as problem:
        random_response(read_scene(scene(tmp_path, table)))
    assert message in str(problem.value)
