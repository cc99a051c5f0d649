"""The command shock: peaks of a scene, spectra of a support and of a record, their files, and messages for what is wrong."""

import json

import numpy as np
import pytest

SCENE = """
[model]
kind = "lumped"
node = [{ name = "table" }]
mass = [{ name = "box", mass = "4 kg" }]
spring = [{ name = "isolators", between = ["table", "box"], stiffness = "40 kN/m" }]
[[motion]]
name = "shaker"
coordinate = "table"
level = "acceleration"
kind = "pulse"
value = "30 m/s^2"
duration = "5 s"
[time]
end = "0.2 s"
[output]
units = "mm, kN"
"""
RECORD = "t (s), a (m/s^2)\n0, 0\n0.01, 5\n0.03, -1\n0.04, 0\n"


def scene(folder, shock="", text=SCENE):
    path = folder / "drop.toml"
    path.write_text(text + shock, encoding="utf-8")
    return str(path)


@pytest.mark.long
def test_peaks_of_every_coordinate_reaction_and_element_and_the_spectrum(command, tmp_path):
    """A step of the base acceleration a doubles: the spring carries 2 m a at t = pi / w (Inman, section 3.2)."""
    code, out, err = command("shock", scene(tmp_path, "[shock]\ndamping_ratio = 0\ntripartite = true\nend = '50 ms'\n"), "--plots")
    assert (code, err) == (0, "") and max(map(len, out.splitlines())) <= 80
    for words in ("isolators", "shaker", "0.24 kN", f"{np.pi / 100:.6g}", "Peaks of the reaction"):
        assert words in out
    folder = tmp_path / "results" / "drop"
    names = {path.name for path in folder.iterdir()}
    pictures = {name for name in names if name.endswith((".svg", ".png"))}
    assert names - pictures == {f"drop.shock{ending}" for ending in (".html", ".csv", ".peaks.csv", ".npz")} and len(pictures) == 6
    with np.load(folder / "drop.shock.npz") as data:
        assert np.isclose(data["force_minimum"][0], -2 * 4 * 30, rtol=1e-12)
        assert np.isclose(data["force_minimum_time"][0], np.pi / 100, rtol=1e-7)
        assert data["force_names"].tolist() == ["isolators"]
        assert np.isclose(data["maximax"].max(), 60, rtol=1e-12)
    last = (folder / "drop.shock.peaks.csv").read_text().splitlines()[-1].split(",")
    assert (
        last[:3] == ["force", "isolators", "kN"]
        and np.isclose(float(last[5]), -0.24, rtol=1e-12)
        and "1 mm" in (folder / "drop.shock.html").read_text()
    )


@pytest.mark.long
def test_a_record_has_its_spectrum_in_the_unit_of_its_header(command, tmp_path):
    (tmp_path / "record.csv").write_text(RECORD, encoding="utf-8")
    code, out, _ = command("shock", "record.csv", "--quality", "10", "--from", "5", "--to", "50", "--json")
    spectrum = json.loads(out)["spectrum"]
    assert code == 0 and spectrum["damping_ratio"] == 0.05 and spectrum["unit"] == "m/s^2"
    assert np.allclose([spectrum["frequencies_hz"][0], spectrum["frequencies_hz"][-1]], [5, 50])
    in_g = json.loads(command("shock", "record.csv", "--unit", "g", "--quality", "10", "--from", "5", "--to", "50", "--json")[1])
    assert np.allclose(in_g["spectrum"]["maximax"], 9.80665 * np.array(spectrum["maximax"]), rtol=1e-12)


@pytest.mark.long
@pytest.mark.parametrize(
    ("shock", "words"),
    [
        ('[shock]\nof = "shakr"', 'shock.of: there is no motion "shakr"; did you mean "shaker"?'),
        ("[shock]\ndamping_ratio = -1", "damping_ratio: found -1"),
        ("[shock]\ndamping_ratio = 0.1\nquality_factor = 5", "cannot both be given"),
        ('[shock]\nfrom = "5 Hz"\nto = "2 Hz"', "expected a range that ascends"),
        ("[shock]\nfrequencies = [0, 1]", "found 0 Hz; expected positive natural frequencies"),
        ("[shock]\nfrequencies = [1]\nper_octave = 3", "frequencies and per_octave cannot both be given"),
        ('[shock]\nquantity = "jerk"', "quantity: found"),
        ("[shock]\nend = 0", "end: found 0"),
    ],
)
def test_wrong_entries_name_their_place(command, tmp_path, shock, words):
    code, out, err = command("shock", scene(tmp_path, shock))
    assert (code, out) == (1, "") and words in err and err.startswith("drop.toml: shock")


@pytest.mark.long
def test_a_motion_without_end_has_peaks_but_no_spectrum(command, tmp_path):
    harmonic = SCENE.replace('"pulse"', '"harmonic"').replace('duration = "5 s"', 'frequency = "3 Hz"')
    code, out, _ = command("shock", scene(tmp_path, text=harmonic))
    assert code == 0 and "no shock response spectrum" in out and "does not end" in out and "Peaks of the force" in out
    code, _, err = command("shock", scene(tmp_path, '[shock]\nof = "shaker"', harmonic))
    assert code == 1 and "does not end" in err


@pytest.mark.long
def test_wrong_records_and_options(command, tmp_path):
    def error(*options):
        (tmp_path / "record.csv").write_text(RECORD, encoding="utf-8")
        code, out, err = command("shock", "record.csv", *options)
        assert code in (1, 2) and not out
        return err

    assert "expected m/s^2" in error("--unit", "kg")
    assert "there is no column" in error("--column", "b")
    assert "shock.damping_ratio" in error("--damping", "abc")
    assert "there is no such file" in command("shock", "missing.csv")[2]
    assert command("shock", scene(tmp_path), "--unit", "g")[0] == 2


@pytest.mark.long
@pytest.mark.parametrize(
    ("record", "message"),
    [
        ("t (s), a (g)\n0, 0\n0.02, 1\n0.01, 0\n", "record.csv, line 4: 0.02 s is followed by 0.01 s"),
        ("t (s), a (N)\n0, 0\n0.01, 1\n0.02, 0\n", "record.csv: the values are a force (N)"),
        ("", "record.csv: the file is empty"),
    ],
)
def test_records_that_are_none_have_one_message(command, tmp_path, record, message):
    """The file is named once, with the line; a record with uneven steps is accepted."""
    path = tmp_path / "record.csv"
    path.write_text(record, encoding="utf-8")
    code, out, err = command("shock", str(path))
    assert code != 0 and out == ""
    assert err.startswith(message) and err.count("record.csv") == 1
