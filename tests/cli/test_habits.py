"""Habits of the command line and of Python: versions, help, completion, settings given twice, functions as forces."""

import subprocess
import sys

import numpy as np
import pytest

import mbconstrained as mb

CART = """
[model]
kind = "lumped"

[[model.mass]]
name = "cart"
mass = 2

[[model.spring]]
between = ["ground", "cart"]
stiffness = 8

[time]
end = 1
points = 3
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "cart.toml"
    path.write_text(CART, encoding="utf-8")
    return path


@pytest.mark.long
def test_the_version_is_that_of_the_installed_package(command):
    code, out, _ = command("--version")
    assert (code, out) == (0, f"mbconstrained {mb.__version__}\n")
    assert "__version__" in dir(mb)


def test_the_module_runs_as_a_command():
    done = subprocess.run([sys.executable, "-m", "mbconstrained", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("mbconstrained ")


@pytest.mark.long
def test_a_setting_given_twice_is_refused(command, scene):
    code, _, problem = command("check", scene, "--set", "time.end=2", "--set", "time.end=3")
    assert code == 2 and '"time.end" is set twice; give it one value' in problem


@pytest.mark.long
@pytest.mark.parametrize("first", [True, False])
def test_single_and_double_brackets_of_one_table(command, scene, first):
    single = '[model.mass]\nname = "b"\nmass = 1\n'
    text = CART.replace("[[model.spring]]", single + "\n[[model.spring]]") if first else single + CART
    scene.write_text(text, encoding="utf-8")
    code, _, problem = command("check", scene)
    assert code == 1 and "[model.mass] and [[model.mass]] stand in one file; write double brackets, [[model.mass]]" in problem


@pytest.mark.long
def test_a_wrong_parameter_is_reported_once(command, scene):
    text = '[parameters]\nk = "3 N/mn"\n' + CART.replace("= 8", '= "=k"').replace("mass = 2", 'mass = "=k"')
    scene.write_text(text, encoding="utf-8")
    _, _, problem = command("check", scene)
    assert problem.count("\n") == 1 and problem.startswith("cart.toml: parameters.k: ")


FUNCTION = r"mb\.approximated\(function, end\)"


def test_a_function_as_force_is_answered():
    model = mb.LumpedModel()
    model.mass("b", 2.0)
    with pytest.raises(mb.InputError, match=FUNCTION):
        model.force("b", lambda t: t)
    system = model.assemble()
    for force in (abs, {"b": abs}):
        with pytest.raises(mb.InputError, match=FUNCTION):
            system.solve(force=force)


def test_a_quantity_in_python_is_answered():
    model = mb.LumpedModel()
    model.mass("b", "2 kg")
    model.spring("ground", "b", 8.0)
    assert model.assemble().mass.item() == 2.0
    with pytest.raises(mb.InputError, match="found .2 N.; expected a number in SI units without quotes; texts with units belong"):
        mb.step("2 N")


def test_data_of_another_folder_are_read_where_the_command_allows_it(command, scene, tmp_path):
    (tmp_path / "logger").mkdir()
    (tmp_path / "logger" / "push.csv").write_text("\ufefft (s);F (kN)\r\n0,0;1,5\r\n1,0;1,5\r\n", encoding="utf-8")
    own = tmp_path / "scenes"
    own.mkdir()
    path = own / "cart.toml"
    path.write_text(CART + '[[force]]\ncoordinate = "cart"\nkind = "sampled"\nfile = "../logger/push.csv"\n', encoding="utf-8")
    code, _, err = command("check", path)
    assert code == 1 and "to allow another folder give --data-folder DIR" in err
    assert command("check", path, "--data-folder", tmp_path / "logger")[0] == 0
    code, out, _ = command("run", path, "--data-folder", tmp_path / "logger", "--out", tmp_path / "out")
    assert code == 0, out
    last = (tmp_path / "out" / "cart.csv").read_text().splitlines()[-1].split(",")
    assert float(last[1]) == pytest.approx(1500 / 8 * (1 - np.cos(2)), rel=1e-12)  # F / k (1 - cos w t), w = 2 rad/s


@pytest.mark.parametrize(("arguments", "file"), [(("run",), "cart.csv"), (("frequency",), "cart.frequency.csv")])
def test_results_never_replace_a_file_that_the_scene_reads(command, scene, tmp_path, arguments, file):
    record = "t (s),F (N)\n0,1\n1,1\n"
    (tmp_path / file).write_text(record)
    scene.write_text(CART + f'[[force]]\ncoordinate = "cart"\nkind = "sampled"\nfile = "{file}"\n', encoding="utf-8")
    before = sorted(tmp_path.iterdir())
    code, _, err = command(*arguments, scene, "--out", tmp_path)
    assert code == 1 and f"{file}: the scene reads this file, and a result would replace it" in " ".join(err.split())
    assert (tmp_path / file).read_text() == record
    assert sorted(tmp_path.iterdir()) == before  # nor any of the others
    assert command(*arguments, scene, "--out", tmp_path / "out")[0] == 0
