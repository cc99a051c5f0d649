"""The command compare: every run in a folder of its own name, and their curves in common plots."""

import json

import numpy as np
import pytest

from tests.cli.test_habits import CART
from tests.page.plots.pages import functions_of_page, places_of_page


@pytest.fixture
def carts(tmp_path):
    for name, stiffness in (("soft", "8"), ("stiff", "32")):
        text = CART.replace("stiffness = 8", f"stiffness = {stiffness}") + "\n[initial]\ndisplacement = { cart = 0.1 }\n"
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    return tmp_path


@pytest.mark.long
def test_two_scenes_have_folders_and_common_plots(command, carts):
    code, out, problem = command("compare", "soft.toml", "stiff.toml")
    assert (code, problem) == (0, "")
    folder = carts / "results" / "compare"
    assert {path.name for path in folder.iterdir()} == {"soft", "stiff", "compare.html"}
    assert (folder / "stiff" / "stiff.csv").exists() and "stiff  0.63662 Hz (0)" in out
    page = (folder / "compare.html").read_text(encoding="utf-8")
    assert "cart: displacement" in page and ">soft<" in page and ">stiff<" in page


@pytest.mark.long
def test_several_values_make_a_run_each(command, carts):
    code, out, _ = command("compare", "soft.toml", "--set", "model.spring[1].stiffness=8 N/m, 18 N/m", "--out", "both", "--json")
    data = json.loads(out)
    assert code == 0 and list(data["runs"]) == ["model.spring_1_.stiffness=8_N_m", "model.spring_1_.stiffness=18_N_m"]
    frequencies = [run["eigenvalues"][0]["imaginary"] for run in data["runs"].values()]
    assert frequencies == pytest.approx([2.0, 3.0])
    assert all((carts / "both" / label / f"soft.{label}.npz").exists() for label in data["runs"])


@pytest.mark.long
def test_runs_are_compared_at_the_times_of_the_first(command, carts):
    assert command("compare", "soft.toml", "--set", "time.end=1,2")[0] == 0
    one, two = ((carts / "results" / "compare" / f"time.end={end}" / f"soft.time.end={end}.csv").read_text() for end in (1, 2))
    assert one == two


@pytest.mark.long
@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["soft.toml"], 1, "found 1 run; expected 2 to 12: scenes, or values as in --set k=1,2"),
        (["soft.toml", "--set", "time.end=1", "--set", "time.end=2"], 2, "a name is set twice"),
        (["soft.toml", "no.toml"], 1, "there is no such file"),
        (["soft.toml", "--set", "k=1,2"], 1, "there is no such parameter"),
    ],
)
def test_what_cannot_be_compared_is_refused(command, carts, arguments, code, message):
    left, _, problem = command("compare", *arguments)
    assert left == code and message in problem


@pytest.mark.long
def test_the_readings_of_common_plots_are_those_of_the_solver(command, carts):
    assert command("compare", "soft.toml", "stiff.toml", "--set", "time.points=5")[0] == 0
    page = (carts / "results" / "compare" / "compare.html").read_text(encoding="utf-8")
    sets, places = functions_of_page(page), places_of_page(page)
    for ((number, row),), rate in zip(places[0], (2.0, 4.0)):
        for time in np.linspace(0.01, 0.99, 7):
            value, error = sets[number].at(row, time)
            assert abs(value - 0.1 * np.cos(rate * time)) <= error < 1e-6
