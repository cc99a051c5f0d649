"""Scenes with [parameters]: the same answers as with numbers, and what is wrong told at the door."""

import json
import re

import numpy as np
import pytest

from mbconstrained.analyses.formula import formula_of
from mbconstrained.ground.errors import SceneError
from mbconstrained.ground.quantities import Expressed
from mbconstrained.scene.run.scene import read_scene
from mbconstrained.scene.schema.scene_schema import SceneFile
from tests.scene.scenes import EXAMPLES, MATRICES, OSCILLATOR, scene_of

PARAMETERS = '[parameters]\nm = "2000 g"\nk = "8 N/m"\nx0 = 0.1\n'
WITH = PARAMETERS + OSCILLATOR.replace('"2 kg"', '"=m"').replace('"8 N/m"', '"=k"').replace("cart = 0.1", 'cart = "=x0"')


def problem_of(folder, text):
    with pytest.raises(SceneError) as problem:
        scene_of(folder, text)
    return str(problem.value)


def test_parameters_stand_for_their_values(tmp_path):
    plain, named = scene_of(tmp_path, OSCILLATOR).run(), scene_of(tmp_path, WITH).run()
    assert (plain.values == named.values).all()
    assert named.notices == plain.notices


@pytest.mark.parametrize("name", ["two_masses", "massless_joints"])
def test_the_examples_with_parameters_move_as_those_with_numbers(name):
    plain, named = (read_scene(EXAMPLES / f"{each}.toml").run() for each in (name, f"{name}_formula"))
    assert np.abs(plain.values - named.values).max() <= 1e-15 * np.abs(plain.values).max()


def test_all_kinds_of_numbers_may_be_expressions(tmp_path):
    text = """
[parameters]
a = 2
w = "3 rad/s"
[model]
kind = "matrices"
coordinates = ["x", "y"]
mass = [["=a", 0], [0, "=a/2"]]
stiffness = [["=2*a^2", "=-a"], ["=-a", 4]]
[[model.constraint]]
rows = { x = "=a", y = -1 }
value = "=1/a"
[initial]
displacement = ["=a/4", 0.5]
[[force]]
coordinate = "x"
kind = "term"
value = "=3*a"
rate = "=-1/a"
angular_frequency = "=2*w"
phase = "=a"
delay = "=a/10"
[time]
end = "=a"
points = 3
"""
    plain = re.sub(r'"(=[^"]*)"', lambda p: str(eval(p[1][1:].replace("^", "**"), {"a": 2.0, "w": 3.0})), text)  # our own text
    one, two = scene_of(tmp_path, text), scene_of(tmp_path, plain)
    assert (one.run().values == two.run().values).all()
    assert isinstance(one.table.time.end, Expressed) and one.table.time.end == 2.0


def test_transfer_functions_and_lumped_elements_take_parameters(tmp_path):
    text = '[parameters]\nT = 0.5\n[model]\nkind = "transfer-function"\nnumerator = [1]\ndenominator = ["=T", 1]\ngamma = 1\n[time]\nend = 1\npoints = 3\n'
    values = scene_of(tmp_path, text).run().values[0]
    assert values == pytest.approx(1 - np.exp(-2 * np.linspace(0, 1, 3)), abs=1e-15)
    lumped = OSCILLATOR.replace(
        "[[model.spring]]",
        '[[model.lever]]\nbetween = ["cart", "b"]\narms = ["=l", "=2*l"]\n[[model.mass]]\nname = "b"\nmass = 1\n[[model.spring]]',
    )
    assert scene_of(tmp_path, '[parameters]\nl = "1 m"\n' + lumped).run().is_trusted


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("=m", "=mass1"), 'model.mass[1].mass (of "cart"): found "=mass1", but there is no parameter "mass1"; there are m, k, x0'),
        (("=k", "=kk"), 'no parameter "kk"; did you mean "k"?'),
        (("=m", "=k"), 'found "=k", a stiffness; expected a mass'),
        (("=m", "=m*k"), "which is another kind of quantity; expected a mass"),
        (("=m", "=m + k"), 'found "=m + k": it adds a mass and a stiffness'),
        (("=m", "=m/(k - k)"), "it divides by zero with the default values"),
        (("=m", "=0*m"), "found"),
        (("=m", "=(((k^20)^20)^20)^20"), "far too many digits"),
        (("=m", "=k^20*k^20*k^20*k^20*k^20*k^20*k^20"), "expected 0 or a size between"),
        (("=x0", "=m"), 'initial.displacement: cart: found "=m", a mass; expected a length'),
        (('m = "2000 g"', 'm = "2 fox"'), 'parameters.m: found "2 fox", but there is no unit "fox"'),
        (('m = "2000 g"', 'm = "=2*k"'), 'found "=m", a stiffness; expected a mass'),
        (('m = "2000 g"', 'm = "=2*n"'), 'parameters.m: found "=2*n", but there is no parameter "n"'),
        (
            ('m = "2000 g"', 'm = "=2*n"\nn = "=m/2"'),
            "parameters: m and n: expressions of each other, in a circle; give one of them a value",
        ),
        (('m = "2000 g"', 'm = "=m"'), "parameters: m: expressions of each other, in a circle"),
        (('m = "2000 g"', 'm = "=x0 +"'), 'parameters.m: found "=x0 +", which cannot be read'),
        (('m = "2000 g"', "m = [1]"), "parameters.m: found an array of 1"),
        (('m = "2000 g"', "m = nan"), "parameters.m: found nan; expected a finite number"),
        (('m = "2000 g"', 'm = "20 degC"'), 'found "20 degC", but there is no unit "degC"'),
        (('m = "2000 g"', "t = 3"), "parameters.t: t is the time"),
        (('m = "2000 g"', '"a b" = 3'), "parameters.a b: found the name"),
        (("[parameters]", "parameters = 3\n[others]"), "parameters: found 3; expected names with quantities"),
    ],
)
def test_what_is_wrong_is_told_in_the_words_of_the_scene(tmp_path, change, says):
    message = problem_of(tmp_path, WITH.replace(*change))
    assert message.startswith("scene.toml: ") and says in message


def test_expressions_need_no_parameters_but_names_do(tmp_path):
    assert scene_of(tmp_path, OSCILLATOR.replace('"2 kg"', '"=4/2"')).equations.system.mass[0, 0] == 2
    assert "give it a value in the table [parameters]" in problem_of(tmp_path, OSCILLATOR.replace('"2 kg"', '"=m"'))


def test_parameters_in_matrices_are_of_the_right_kind(tmp_path):
    text = '[parameters]\nk = "3 N/m"\n' + MATRICES.replace("mass = [[1,", 'mass = [["=k",')
    assert 'model.mass[1][1]: found "=k", a stiffness; expected a mass' in problem_of(tmp_path, text)


def test_numbers_in_expressions_have_the_kind_of_their_unit(tmp_path):
    message = problem_of(tmp_path, WITH.replace('"=x0"', '"=0.1*k/k"'))
    assert 'found "=0.1*k/k", a plain number; expected a length' in message and 'may have units, as in "=2*0.2 m"' in message
    assert "it adds a length and a force" in problem_of(tmp_path, WITH.replace('"=x0"', '"=3 mm*k/k + 3 N"'))
    scene = scene_of(tmp_path, WITH.replace('"=x0"', '"=100 mm*k/k"'))
    assert scene.run().motion.displacement(0.0)[0] == pytest.approx(0.1, rel=1e-15)


def test_a_speed_becomes_a_frequency_by_its_turns(tmp_path):
    """1200 rpm are 20 turns a second."""
    force = '[[force]]\ncoordinate = "cart"\nkind = "harmonic"\nvalue = "1 N"\n'
    text = WITH.replace("[parameters]", '[parameters]\nn = "1200 rpm"')
    frequencies = [
        scene_of(tmp_path, text + force + f'frequency = "{value}"').table.force[0].frequency for value in ("1200 rpm", "=n/(1 rev)")
    ]
    assert frequencies == pytest.approx([20.0, 20.0], rel=1e-15)
    assert 'a cycle is a turn of 2 pi: write "=n/(1 rev)"' in problem_of(tmp_path, text + force + 'frequency = "=n"')
    text = text.replace('"1200 rpm"', '"20 Hz"') + force
    assert 'write "=(2*n)*(1 rev)"' in problem_of(tmp_path, text + 'angular_frequency = "=2*n"')


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (
            ('"=k"', '"k"'),
            'found "k"; expected a stiffness, e.g. "3 N/mm", or a number in N/m; this is the name of a parameter: write "=k"',
        ),
        (('"=k"', '"2*k"'), 'this is an expression of parameters without its =: write "=2*k"'),
    ],
)
def test_a_parameter_without_its_sign_is_recognized(tmp_path, change, says):
    assert says in problem_of(tmp_path, WITH.replace(*change))
    matrices = '[parameters]\nk = "3 N/m"\n' + MATRICES.replace("mass = [[1,", f"mass = [[{change[1]},")
    assert says.partition("; this is ")[2] in problem_of(tmp_path, matrices)


def test_an_unused_parameter_is_a_notice(tmp_path):
    scene = scene_of(tmp_path, WITH.replace('"=x0"', "0.1"))
    assert ['"x0"' in notice.text for notice in scene.parameters.notices] == [True]
    assert scene.run().notices[:1] == scene.parameters.notices


def test_editors_are_told_of_parameters_and_expressions():
    schema = SceneFile.model_json_schema()
    number, text = schema["properties"]["parameters"]["additionalProperties"]["anyOf"]
    assert number == {"type": "number"} and [bool(re.match(text["pattern"], each)) for each in ("3 N/mm", "=2*k", "0,5 m")] == [
        True,
        True,
        False,
    ]
    entry = schema["$defs"]["MatricesTable"]["properties"]["mass"]["anyOf"][0]["items"]["items"]["anyOf"][1]
    assert [bool(re.match(entry["pattern"], each)) for each in ("=2*k", "2 kg", "kg")] == [True, True, False]
    assert "=2*k" in json.dumps(schema)


def test_coordinates_may_be_called_like_texts(tmp_path):
    """A title is a text, but a coordinate called title has a displacement, and a factor in a row."""
    text = """
[parameters]
d = 0.5
[model]
kind = "matrices"
coordinates = ["title", "source"]
mass = [[1, 0], [0, 1]]
[[model.constraint]]
rows = { title = "=2*d", source = "=-2*d" }
level = "position"
value = 0
[initial]
displacement = { title = "=d", source = "=d" }
[time]
end = 1
"""
    scene = scene_of(tmp_path, text)
    assert scene.equations.initial[0].tolist() == [0.5, 0.5]


def test_pi_is_no_parameter_in_any_letters(tmp_path):
    for name in ("pi", '"π"'):
        path = tmp_path / "p.toml"
        path.write_text(f"[parameters]\n{name} = 8.0\n" + MATRICES, encoding="utf-8")
        with pytest.raises(SceneError, match="is the number 3.14159"):
            read_scene(path)


def test_parameters_may_be_expressions_of_others_in_any_order(tmp_path):
    text = WITH.replace('m = "2000 g"', 'm = "=2*m1"\nspare = "=2*unused"\nunused = 1\nm1 = "1 kg"')
    scene = scene_of(tmp_path, text)
    assert scene.equations.system.mass[0, 0] == 2.0
    assert scene.parameters.values == {"k": 8.0, "x0": 0.1, "unused": 1.0, "m1": 1.0}  # the symbols of a formula
    assert scene.parameters.unused == ("spare", "unused")
    assert "m1" in str(formula_of(scene).values[0])


def test_expressions_of_expressions_do_not_grow_without_bound(tmp_path):
    many = "".join(f'a{i} = "=a{i - 1} + a{i - 1}"\n' for i in range(1, 60))
    message = problem_of(tmp_path, WITH.replace("[parameters]", f"[parameters]\na0 = 1\n{many}"))
    assert "parameters.a8: it has 511 parts with those of its parameters; expected at most 300" in message
