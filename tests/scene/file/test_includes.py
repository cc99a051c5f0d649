"""Scenes that include others: tables put together, and every message naming the file in which the mistake stands."""

import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.scene.file import DEEPEST_INCLUDE
from mbconstrained.scene.run.scene import read_scene

MAIN = """
include = ["parts/base.toml"]
[parameters]
m = "3 kg"
[[model.mass]]
name = "cart"
mass = "=m"
[[model.spring]]
between = ["cart", "load"]
stiffness = "=k"
[initial]
displacement = { cart = 0.1 }
[time]
end = "5 s"
points = 11
"""
BASE = """
include = ["deeper.toml"]
title = "The base"
[parameters]
k = "8 N/m"
m = "1 kg"
[model]
kind = "lumped"
[initial]
displacement = { load = 0.2 }
[time]
end = "1 s"
"""
DEEPER = """
[[model.mass]]
name = "load"
mass = "=m"
"""


@pytest.fixture
def scene(tmp_path):
    """Write the three files, changed, and read the first."""

    def read(main=("", ""), base=("", ""), deeper=("", "")):
        (tmp_path / "parts").mkdir(exist_ok=True)
        for name, text, change in (("main", MAIN, main), ("parts/base", BASE, base), ("parts/deeper", DEEPER, deeper)):
            (tmp_path / f"{name}.toml").write_text(text.replace(*change, 1), encoding="utf-8")
        return read_scene(tmp_path / "main.toml")

    return read


def test_arrays_grow_and_of_all_else_the_last_word_counts(scene):
    found = scene()
    assert found.equations.coordinates.names == ("load", "cart")
    assert found.equations.system.mass.diagonal().tolist() == [3.0, 3.0]
    assert found.equations.initial[0].tolist() == [0.2, 0.1]
    assert (found.title, found.name, found.times[-1]) == ("The base", "main", 5.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"main": ('"=m"', '"=k"')}, r'^main.toml: model.mass\[1\].mass \(of "cart"\): found "=k", a stiffness'),
        ({"deeper": ('"=m"', '"=k"')}, r'^parts/deeper.toml: model.mass\[1\].mass \(of "load"\): found "=k", a stiffness'),
        ({"deeper": ("mass =", "mas =")}, r'^parts/deeper.toml: model.mass\[1\] \(of "load"\): unknown key "mas"; did you mean'),
        ({"base": ("[initial]", "[inital]")}, '^parts/base.toml: the file: unknown key "inital"'),
        ({"base": ("kind =", "color = 1\nkind =")}, '^parts/base.toml: model: unknown key "color"'),
        ({"base": ("8 N/m", "8 N/fox")}, '^parts/base.toml: parameters.k: found "8 N/fox", but there is no unit "fox"'),
        ({"main": ('"5 s"', '"5 m"')}, '^main.toml: time.end: found "5 m", a length'),
        ({"base": ("load = 0.2", "lod = 0.2")}, '^parts/base.toml: initial.displacement: there is no coordinate "lod"; did you mean "load"'),
        ({"main": ("cart = 0.1", "crat = 0.1")}, '^main.toml: initial.displacement: there is no coordinate "crat"; did you mean "cart"'),
        ({"main": ("cart = 0.1", 'cart = "1 s"')}, '^main.toml: initial.displacement: cart: found "1 s", a time; expected a length'),
        ({"deeper": ('"load"', '"cart"')}, r'^main.toml: model.mass\[1\] \(of "cart"\): parts/deeper.toml has a body of this name too, model.mass\[1\]'),
        ({"base": ("deeper", "deper")}, '^parts/base.toml: include: found "deper.toml", but there is no such file; did you mean "deeper.toml"'),
        ({"main": ('["parts/base.toml"]', "3")}, '^main.toml: include: found 3; expected names of scene files, e.g. include = '),
        ({"main": ("parts/base.toml", "/etc/passwd")}, '^main.toml: include: found "/etc/passwd"; expected names of scene files'),
        ({"deeper": ("[[", 'include = "../main.toml"\n[[')}, "include: found \"../main.toml\", which leads in a circle: main.toml → parts/base.toml → parts/deeper.toml → main.toml"),
        ({"deeper": ("[[model.mass]]", "[[model.mass]")}, r"^parts/deeper.toml: not a TOML file: .* at line 2"),
        ({"main": ("[time]", "[output]\ninclude = []\n[time]")}, "output: unknown key \"include\"; include = … stands at the top of the file"),
    ],
)  # fmt: skip
def test_messages_name_the_file_in_which_the_mistake_stands(scene, changes, message):
    with pytest.raises(SceneError, match=message):
        scene(**changes)


@pytest.mark.parametrize(("inner", "outer"), [("along", "about"), ("about", "along")])
def test_of_entries_of_two_files_that_do_not_fit_both_files_are_named(scene, inner, outer):
    main, deeper = (f"[drawing]\n{key} = {axis}\n" for key, axis in ((outer, [0, 0, 1]), (inner, [0, 1, 1])))
    with pytest.raises(SceneError) as caught:
        scene(main=("[time]", f"{main}[time]"), deeper=("\n[[", f"{deeper}[["))
    file, other = ("main.toml", "parts/deeper.toml") if outer == "about" else ("parts/deeper.toml", "main.toml")
    wrong = "drawing: along and about are not at right angles; leave out one of them"
    assert str(caught.value) == f"{file}: {wrong} (along stands in {other})"


def test_a_file_that_several_include_is_read_once(scene):
    found = scene(main=('["parts/base.toml"]', '["parts/deeper.toml", "parts/base.toml", "parts/base.toml"]'))
    assert found.equations.coordinates.names == ("load", "cart")


def test_data_files_lie_beside_the_file_that_names_them(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "mass.csv").write_text("2\n")
    (tmp_path / "parts" / "record.csv").write_text("0,0\n1,1\n")
    force = '[[force]]\ncoordinate = "x"\nkind = "sampled"\nfile = "record.csv"\n'
    (tmp_path / "parts" / "base.toml").write_text(f'[model]\nkind = "matrices"\ncoordinates = ["x"]\nmass = "mass.csv"\n{force}')
    (tmp_path / "main.toml").write_text('include = "parts/base.toml"\n[time]\nend = 1\n')
    assert read_scene(tmp_path / "main.toml").equations.system.mass.tolist() == [[2.0]]
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "main.toml").write_text('include = "../parts/base.toml"\n[time]\nend = 1\n')
    with pytest.raises(SceneError, match='found "../parts/mass.csv", which leads out of the folder; data files must lie in'):
        read_scene(tmp_path / "inner" / "main.toml")


def test_includes_have_a_bottom(tmp_path):
    for number in range(DEEPEST_INCLUDE + 3):
        (tmp_path / f"a{number}.toml").write_text(f'include = ["a{number + 1}.toml"]\n')
    with pytest.raises(SceneError, match=f"a{DEEPEST_INCLUDE}.toml: include: found .*included at most {DEEPEST_INCLUDE} deep"):
        read_scene(tmp_path / "a0.toml")
