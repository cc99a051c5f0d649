"""The command frequency: its table on 80 columns, its files, its options, and exit codes."""

import json

import numpy as np
import pytest

from tests.scene.scenes import MACHINE


def scene(folder):
    path = folder / "machine.toml"
    path.write_text(MACHINE, encoding="utf-8")
    return str(path)


@pytest.mark.long
def test_it_prints_peaks_on_80_columns_and_writes_page_csv_and_npz(command, tmp_path):
    code, out, err = command("frequency", scene(tmp_path), "--plots")
    assert (code, err) == (0, "") and max(map(len, out.splitlines())) <= 80
    names = {path.name for path in (tmp_path / "results" / "machine").iterdir()}
    pictures = {
        f"machine.frequency.{name}.{kind}"
        for name in ("receptance-by-machine", "phase-of-the-receptance-by-machine")
        for kind in ("svg", "png")
    }
    assert names == {f"machine.frequency.{ending}" for ending in ("html", "csv", "npz")} | pictures
    f = np.sqrt(100 - 2 * 1.0**2) / (2 * np.pi)  # of the largest displacement: w^2 = k/m - 2 (c / 2m)^2
    assert f"{f:.5g}" in out and f"{1 / (4 * np.sqrt(100 - 1)):.4g} m/N" in out


@pytest.mark.long
def test_options_replace_what_the_table_has(command, tmp_path):
    path = scene(tmp_path)
    code, out, _ = command("frequency", path, "--quantity", "accelerance", "--from", "1", "--to", "600 rpm", "--json")
    data = json.loads(out)
    assert code == 0 and data["quantity"] == "accelerance" and data["units"] == [["m/s^2/N"]]
    assert np.allclose([data["frequencies"]["from"], data["frequencies"]["to"]], [1, 10])
    code, out, err = command("frequency", path, "--output", "machin")
    assert (code, out) == (1, "") and err.strip().startswith("machine.toml: frequency: outputs: there is no") and '"machine"' in err
    code, _, err = command("frequency", path, "--from", "abc")
    assert code == 1 and "frequency.from" in err
