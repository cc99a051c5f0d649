"""Power spectral densities in files: the answer of the same numbers in the scene."""

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from tests.scene.scenes import scene_of

BOX = """
[model]
kind = "lumped"
node = [{ name = "table" }]
mass = [{ name = "box", mass = "4 kg" }]
spring = [{ between = ["table", "box"], stiffness = "142 N/mm" }]
damper = [{ between = ["table", "box"], damping = "75 N s/m" }]
[[motion]]
name = "shaker"
coordinate = "table"
kind = "harmonic"
value = "0.1 mm"
frequency = "30 Hz"
[time]
end = "1 s"
[random]
quantity = "acceleration"
[[random.input]]
on = "shaker"
of = "acceleration"
"""
INLINE = 'frequencies = ["20 Hz", "80 Hz", "350 Hz", "2000 Hz"]\nvalues = [0.01, 0.04, 0.04, 0.007]\nunit = "g^2/Hz"'
ROWS = ((0.02, 0.01), (0.08, 0.04), (0.35, 0.04), (2.0, 0.007))


def box(folder, entry):
    return scene_of(folder, BOX + entry, "box.toml")


@pytest.mark.parametrize("head", ["f (kHz);ASD (g^2/Hz);x", "f [kHz];ASD [g²/Hz];x", "f;ASD;x\nkHz;g^2/Hz;-"])
def test_a_spectrum_in_a_file(tmp_path, head):
    lines = (f"{f};{value};7".replace(".", ",") for f, value in ROWS)
    (tmp_path / "spec.csv").write_text("\r\n".join([head, *lines]), encoding="utf-8")
    rms = [
        box(tmp_path, entry).random().data["rms"] for entry in (INLINE, 'file = "spec.csv"', 'file = "spec.csv"\ncolumn = "ASD"')
    ]
    assert rms[1] == pytest.approx(rms[0], rel=1e-14) and rms[2].tolist() == rms[1].tolist()
    assert rms[0][0] / 9.80665 == pytest.approx(2.6, abs=0.1)  # g, Miles: sqrt(pi / 2 f Q G) with f = 30 Hz, Q = 10, G about 0.016


def test_spectra_that_are_written_are_read_again(tmp_path):
    """The spectrum of the box as the input of another one: the same curve as from the arrays."""
    answer = box(tmp_path, INLINE).random()
    answer.write(tmp_path, ["csv"])
    (_, f), (name, G) = list(answer.columns()[""].items())[:2]
    assert name == "box ((m/s^2)^2/Hz)"
    entry = f'file = "box.random.csv"\ncolumn = "{name}"'
    inline = f"frequencies = {f.tolist()}\nvalues = {G.tolist()}"
    rms = [box(tmp_path, one).random().data["rms"] for one in (entry, inline)]
    assert rms[0] == pytest.approx(rms[1], rel=1e-13)
    assert np.isfinite(rms[0]).all() and rms[0][0] > 0


@pytest.mark.parametrize(
    ("content", "entry", "message"),
    [
        ("f,G\n20,1\n10,2\n", "", r"random\.input\[1\].*20 Hz is followed by 10 Hz; expected ascending frequencies"),
        ("f,G (g)\n20,1\n30,2\n", "", r"found 'g' for a density of acceleration; expected for example \"g\^2/Hz\""),
        ("f (ms),G (g^2/Hz)\n20,1\n30,2\n", "", r"spec\.csv: unit of the frequencies: found \"1 ms\""),
        ("f,G (g^2/Hz)\n20,1\n30,-2\n", "", "a power spectral density is not negative"),
        ("f,G (g^2/Hz)\n0,1\n30,2\n", "", "a frequency of 0 Hz has no place on logarithmic axes"),
        ("f,G (g^2/Hz)\n20,nan\n30,2\n", "", r"spec\.csv, line 2: found an entry that is nan"),
        ("f,G\n20,1\n30,2\n", "white = 1", "found file and white; expected one of"),
        ("f,G\n20,1\n30,2\n", "values = [1, 2]\nfrequencies = [1, 2]", "found values and file; expected one of"),
        ("f,G\n20,1\n30,2\n", 'column = "H"', 'there is no column "H"'),
    ],
)
def test_mistakes_are_reported(tmp_path, content, entry, message):
    (tmp_path / "spec.csv").write_text(content)
    with pytest.raises(SceneError, match=message):
        box(tmp_path, f'file = "spec.csv"\n{entry}').random()


def test_a_column_belongs_to_a_file(tmp_path):
    with pytest.raises(SceneError, match="column: for a file only; give file, too"):
        box(tmp_path, f"{INLINE}\ncolumn = 2")
