"""The command campbell: a rotor over its speed as tables, page, pictures and data."""

import json

import numpy as np
import pytest

from mbconstrained import read_scene
from mbconstrained.analyses.campbell import SpeedDiagram
from mbconstrained.scene.schema.analysis_tables import CampbellTable
from tests.scene.build.test_rotors import ELEMENTS, MATRICES

FREE = MATRICES.replace("circulatory = [[0, 5], [-5, 0]]\n", "").replace("damping = [[20, 0], [0, 20]]\n", "")


@pytest.fixture
def campbell(command, tmp_path):
    """The command on a scene of a text: exit code, output, output of errors as one line."""

    def run(text, *options):
        (tmp_path / "rotor.toml").write_text(text, encoding="utf-8")
        code, output, errors = command("campbell", "rotor.toml", "--out", "out", *options)
        return code, output, " ".join(errors.split())

    return run


def test_the_data_of_a_disc(campbell, tmp_path):
    """m w^2 -+ G w W - k = 0; critical speeds at W^2 = k / (m +- G)."""
    code, output, _ = campbell(FREE, "--json", "--points", "5", "--order", "1", "--order", "2")
    assert code == 0
    data = json.loads(output)
    assert [mode["direction"] for mode in data["modes"]] == ["backward", "forward"]
    first = [point for point in data["critical_speeds"] if point["order"] == 1]
    np.testing.assert_allclose([point["speed"] for point in first], np.sqrt(2e4 / np.array([2.4, 1.6])), rtol=1e-13)
    assert len(data["critical_speeds"]) == 4 and data["stability_limits"] == []
    (response, _) = data["unbalance_response"]
    assert response["order"] == 1 and {peak["coordinate"] for peak in response["peaks"]} == {"y", "z"}
    files = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"rotor.campbell.html", "rotor.campbell.png", "rotor.campbell.json"} <= files


@pytest.mark.long
def test_the_text_fits_80_columns_and_names_the_limit_of_stability(campbell, tmp_path):
    """2 z'' + (20 - 0.4 i W) z' + (2e4 - 5 i W) z = 0: the limit is where i w is a root, 20 w = 5 W and 2 w^2 - 0.4 w W ... = k."""
    code, output, _ = campbell(MATRICES, "--to", "10000 rpm")
    assert code == 0 and max(map(len, output.splitlines())) <= 80
    # w = W / 4: 2 W^2 / 16 - 0.4 W^2 / 4 = 2e4 -> W = sqrt(2e4 / 0.025)
    limit = np.sqrt(2e4 / 0.025) * 30 / np.pi
    assert f"a motion begins to grow, or ceases to, at {limit:.8g} rev/min" in " ".join(output.split())
    page = (tmp_path / "out" / "rotor.campbell.html").read_text(encoding="utf-8")
    assert "Waterfall of a run-up" in page and "so slow that every speed has its steady state" in page
    assert "unstable" in page


@pytest.mark.long
def test_a_table_of_speeds_bounds_the_range(campbell, tmp_path):
    code, output, _ = campbell(ELEMENTS, "--points", "11")
    assert code == 0 and "from 1000 to 5000 rev/min" in output
    code, _, errors = campbell(ELEMENTS, "--to", "6000 rpm")
    assert code == 1 and 'the table of the bearing "film"' in errors


@pytest.mark.parametrize(
    "text, options, message",
    [
        ('[model]\nkind = "matrices"\nmass = [[1]]\nstiffness = [[1]]\n[time]\nend = 1\n', [], "nothing of this model turns"),
        (MATRICES, ["--to", "3 kg"], "campbell.to: found"),
        (MATRICES, ["--from", "3 rad/s", "--to", "2 rad/s"], "expected a range that ascends"),
        (MATRICES, ["--points", "1"], "campbell.points"),
        (MATRICES, ["--order", "1", "--order", "1"], "given twice"),
        (MATRICES + "[campbell]\norderz = [1]\n", [], 'did you mean "orders"'),
        (MATRICES.replace("[[2e4, 0], [0, 2e4]]", "[[0, 0], [0, 0]]"), [], "no critical speed of order 1"),
    ],
)
def test_errors_are_those_of_the_scene(campbell, tmp_path, text, options, message):
    code, _, errors = campbell(text, *options)
    assert code == 1 and message in errors
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


def test_orders_of_different_numbers_of_critical_speeds_share_the_speeds_of_the_waterfall(campbell, tmp_path):
    """Within 60 rad/s order 1 has no critical speed and order 3 both; the amplitudes of both orders are those of the same speeds."""
    code, _, errors = campbell(FREE, "--from", "0", "--to", "60 rad/s", "--points", "5", "--order", "1", "--order", "3")
    assert code == 0 and not errors
    assert "Waterfall of a run-up" in (tmp_path / "out" / "rotor.campbell.html").read_text(encoding="utf-8")
    own = SpeedDiagram(
        read_scene(tmp_path / "rotor.toml"), CampbellTable.model_validate({"to": 60.0, "points": 5, "orders": [1, 3]})
    )
    first, second = own.responses.values()
    np.testing.assert_array_equal(first.speeds, second.speeds)
    assert len(first.speeds) > 5


def test_the_page_moves_the_rotor_in_each_critical_shape():
    answer = read_scene("examples/rotor.toml").campbell()
    page, critical = answer.page(), answer.to_dict()["critical_speeds"]
    assert len(page.animation.modes) == len(critical) == 4 and page.tables[0].title != "Critical speeds"
    y, z = (page.animation.names.index(name) for name in ("A y", "A z"))
    for mode, one in zip(page.animation.modes, critical):
        assert mode.period == pytest.approx(2 * np.pi / one["speed"], rel=1e-12)  # order 1
        a, b = mode.values[y], mode.values[z]
        turned = a[0] * b[1] - a[1] * b[0]  # the orbit runs from y to z, as the rotor turns, in forward whirl
        assert (turned > 0) == (dict(mode.facts)["whirl"] == "forward")
