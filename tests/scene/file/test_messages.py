"""Entries that are wrong: the message names the place, what was found, what was expected, the nearest name."""

import time

import pytest

from mbconstrained.ground.errors import SceneError, SingularPolynomialMatrix
from mbconstrained.scene.file import together
from tests.scene.scenes import COEFFICIENTS, MATRICES, OSCILLATOR, scene_of

KINDS = 'expected "lumped", "matrices", "robot", "state-space" or "transfer-function"'
LUMPED = [  # what is replaced, by what, what the message says
    ("[initial]", "[inital]", 'the file: unknown key "inital"; did you mean "initial"?; known here are title'),
    ("stiffness", "stifness", 'model.spring[1]: unknown key "stifness"; did you mean "stiffness"?'),
    ("points = 11", "stop = 1", 'time: unknown key "stop"; did you mean "end"?; known here are end, start, points, step'),
    ("points = 11", '[output]\ntitle = "x"', 'output: unknown key "title"; title = … stands at the top of the file'),
    ("[time]", '[vary]\nk = "1..3 N/m"\n[time]', "what varies stands by its name in parameters, below [vary.parameters]"),
    ("[[model.mass]]", "[[mass]]", 'the file: unknown key "mass"; it belongs to the model: write [[model.mass]]'),
    ("[[model.mass]]", "[model.mass]", "model.mass: found one table; write it with double brackets, [[model.mass]], once"),
    ("[model]\n", "[[model]]\n", "model: there is one model only: write it with single brackets, [model]"),
    ("[time]", "[[time]]", "time: there is one table of this kind only: write it with single brackets"),
    ('end = "5 s"', "", "time.end: this key is missing"),
    ('kind = "lumped"', 'kind = "lumpd"', f'model: kind: found "lumpd"; {KINDS}; did you mean "lumped"?'),
    ('kind = "lumped"\n', "", f"model: the key kind is missing; {KINDS}"),
    ("points = 11", "points = 1", "time.points: found 1; expected at least 2"),
    ("points = 11", "points = 10000000", "time.points: found 10000000; expected at most 200000"),
    ("points = 11", 'points = "11"', 'time.points: found "11"; expected a whole number'),
    ("points = 11", "points = 1.5", "time.points: found 1.5; expected a whole number"),
    ("points = 11", "[output]\npage = 1", "output.page: found 1; expected true or false"),
    ("points = 11", '[output]\nplots = ["dsplacement"]', 'output.plots[1]: found "dsplacement"; expected "displacement", '),
    ("points = 11", '[output]\nplots = ["reaction"]', "output.plots: found reaction, but there are no constraint rows"),
    ("points = 11", '[output]\nplots = ["energy", "energy"]', 'output.plots: "energy" is named twice; once is enough'),
    ("points = 11", '[output]\ncoordinates = ["crat"]', 'output.coordinates: there is no coordinate "crat"; did you mean "cart"'),
    ('"2 kg"', '"2 N/mm"', 'model.mass[1].mass (of "cart"): found "2 N/mm", a stiffness; expected a mass, e.g. "10 kg"'),
    ('"2 kg"', "0", "found no mass; a point without mass is a node"),
    ('"8 N/m"', '"-8 N/m"', "stiffness: found -8; expected a number greater than zero"),
    ('"5 s"', "0", "time: end is 0 s; expected a time after 0"),
    ('"5 s"', "1979-05-27", "time.end: found 1979-05-27; expected a time"),
    ("cart = 0.1", 'cart = "0.1 rad"', 'initial.displacement: cart: found "0.1 rad", an angle; expected a length'),
    (
        "cart = 0.1",
        "crat = 0.1",
        'initial.displacement: there is no coordinate "crat"; did you mean "cart"?; the coordinates are cart',
    ),
    ('"ground", "cart"', '"ground", "crat"', 'there is no body "crat"; did you mean "cart"'),
    ('"ground", "cart"', '"cart", "cart"', "same body"),
    ('"ground", "cart"', '"ground"', "model.spring[1].between: found an array of 1; expected at least 2 entries"),
    ('name = "cart"', 'name = "=cmd|calc"', 'found "=cmd|calc"; expected a name: a letter first'),
    ('name = "cart"', 'name = "ground"', 'the name "ground" is that of the fixed body'),
    ("[[model.spring]]", '[[model.mass]]\nname = "cart"\nmass = 1\n[[model.spring]]', 'model.mass[2] (of "cart"): '),
    ("[time]", '[[model.node]]\nname = "pin"\n[time]', 'model.node[1] (of "pin"): nothing is attached to this joint'),
    ("[model]", 'title = "\\u001b[31mred"\n[model]', 'title: found the character "\\x1b", which cannot be printed'),
    ("[model]", "title = 3\n[model]", "title: found 3; expected a text in quotes"),
]
MASS, MODEL = "mass = [[1, 0], [0, 1]]", MATRICES.partition("[time]")[0]
OF_MATRICES = [
    (MODEL, "", "model: this table is missing: write [model]"),
    ('["a", "b"]', '["a", "a"]', 'model.coordinates: the name "a" is used twice'),
    ('["a", "b"]', '["a"]', "model.coordinates: found 1 names; expected 2"),
    (MASS, "mass = [[1, 0], [0]]", "model.mass: found rows of 2, 1 numbers; expected rows of equal length"),
    (MASS, "mass = [[1, 0]]", "model.mass: found 1 rows and 2 columns; expected a square matrix"),
    (MASS, "mass = 5", "model.mass: found 5; expected rows of numbers"),
    (f"{MASS}\n", "", "model: give either mass (with damping and stiffness) or coefficients"),
    ("[[1, 0], [0, 4]]", "[[1]]", "model: stiffness: expected shape 2 x 2, found 1 x 1"),
]
OF_COEFFICIENTS = [
    ("coefficients =", "stiffness = [[1]]\ncoefficients =", "model: stiffness cannot stand with coefficients"),
    ("[[[4]], [[0]], [[1]]]", "[]", "model: coefficients is empty"),
    ("[[0]]", "[[0, 0], [0, 0]]", "model.coefficients: A_1 has shape (2, 2), but A_0 has (1, 1)"),
    ("points = 5", '[output]\nplots = ["energy"]', "output.plots: energy is known only where mass"),
    ("[time]", '[initial]\nvelocity = { q = "1 m/s" }\n[time]', "a velocity; expected an angular velocity"),
]
CASES = [
    (text, *case)
    for text, cases in ((OSCILLATOR, LUMPED), (MATRICES, OF_MATRICES), (COEFFICIENTS, OF_COEFFICIENTS))
    for case in cases
]


@pytest.mark.parametrize(("text", "old", "new", "says"), CASES, ids=[f"{case[2][:50]!r}" for case in CASES])
def test_message(tmp_path, text, old, new, says):
    assert old in text
    with pytest.raises(SceneError) as caught:
        scene_of(tmp_path, text.replace(old, new, 1))
    assert str(caught.value).startswith("scene.toml: ") and says in str(caught.value)


FORCE, ROW, BODY = '[[force]]\ncoordinate = "a"', "[[model.constraint]]\nrows", '[[drawing.body]]\nname = "m"\nshape = "box"'
LINK = '[[drawing.link]]\nkind = "spring"\nstart = "m"'
WHEEL = """
[model]
kind = "lumped"
inertia = [{ name = "wheel", inertia = 1 }]
mass = [{ name = "cart", mass = 1 }, { name = "b", mass = 1 }]
"""
ADDED = {
    MODEL: [
        ('[model.units]\nc = "rad"', 'model.units: there is no coordinate "c"'),
        ('[model.units]\na = "mm"', 'model.units.a: found "mm"; expected "m", "rad"'),
        ("[initial]\ndisplacement = [1]", "initial.displacement: found 1 values; expected 2, one for each of a, b"),
        ("[initial]\ndisplacement = 1", "initial.displacement: found 1; expected"),
        ("[initial]\nacceleration = { a = 1 }", "initial.acceleration: the equations have degree 2"),
        ("[initial]\ndisplacement = { a = 1 }\nderivatives = [[1, 1]]", "derivatives and displacement say the same"),
        (f"{ROW} = {{ a = 1, c = -1 }}", 'model.constraint[1]: there is no coordinate "c"'),
        (f"{ROW} = {{}}", "model.constraint[1].rows: found a table; expected coordinates with their factors"),
        (f'{ROW} = {{ a = 1 }}\nlevel = "velocity"\nvalue = "1 m"', 'value: found "1 m", a length; expected a velocity'),
        (f"{ROW} = {{ a = 0 }}\nvalue = 1", "has the value 1 m, but all its coefficients are zero, with the value 0 m;"),
        ('[[motion]]\ncoordinate = "a"\nkind = "record"', 'motion[1]: kind: found "record"; '),
        ('[[force]]\non = "a"\nkind = "step"\nvalue = 1', 'force[1]: unknown key "on"; did you mean "coordinate"?'),
        ('[[force]]\ncoordinate = "x"\nkind = "step"\nvalue = 1', 'force[1]: there is no coordinate "x"'),
        (f'{FORCE}\nkind = "ramp"\nvalue = "1 N"', 'force[1]: value: found "1 N", a force; expected a quantity in N/s'),
        (f'{FORCE}\nkind = "harmonic"\nvalue = 1', "force[1]: give angular_frequency"),
        (f'{FORCE}\nkind = "harmonic"\nvalue = 1\nfrequency = 1\nangular_frequency = 1', "force[1]: give either angular_frequency"),
        (f"{BODY}\nmoves = {{ c = [1, 0, 0] }}", 'drawing.body[1] (of "m"): there is no coordinate "c"'),
        (f'{BODY}\ncolor = "red"', 'found "red"; expected a colour such as'),
        (f'{LINK}\nend = "w"', 'drawing.link[1]: there is no body "m" in the drawing'),
        (f'{BODY}\n{LINK}\nend = "m"', 'drawing.link[1]: start and end are the same body, "m"; name two'),
    ],
    WHEEL: [
        ('[[model.spring]]\nbetween = ["wheel", "cart"]\nstiffness = 3', '"wheel" turns (rad), but a spring needs a body'),
        ('[[model.rack]]\ngear = "cart"\nrack = "wheel"\nradius = 1', 'gear is what turns, here "wheel", and rack what moves'),
        ('[[model.gear]]\nbetween = ["wheel", "cart"]\nteeth = [2, 3]', '"cart" moves along the axis (m), but a gear needs'),
        ('[[model.gear]]\nbetween = ["wheel", "ground"]\nteeth = [2, -3]', "model.gear[1].teeth[2]: found -3; expected a whole"),
        ('[[model.gear]]\nbetween = ["wheel", "ground"]', "expected both radii, both numbers of teeth, or the ratio"),
        (
            'rigid_tie = [{ between = ["cart", "b"] }, { name = "bar", between = ["cart", "b"], distance = "1 m" }]',
            'model: constraint "bar" (position level) has the value 1 m, but it follows from ',
        ),
    ],
}  # fmt: skip


@pytest.mark.parametrize(("model", "entry", "says"), [(model, *case) for model, cases in ADDED.items() for case in cases])
def test_message_about_an_entry(tmp_path, model, entry, says):
    with pytest.raises(SceneError) as caught:
        scene_of(tmp_path, f"{model}{entry}\n[time]\nend = 1\n")
    assert str(caught.value).startswith("scene.toml: ") and says in str(caught.value)


def test_all_problems_are_told_at_once_but_not_endlessly(tmp_path):
    with pytest.raises(SceneError) as caught:
        scene_of(tmp_path, OSCILLATOR.replace("2 kg", "2 m").replace("8 N/m", "8 s").replace("5 s", "5 kg"))
    lines = str(caught.value).splitlines()
    assert lines[0] == "scene.toml: 3 entries are wrong"
    places = [line.split(":")[0].strip() for line in lines[1:]]
    assert places == ['model.mass[1].mass (of "cart")', "model.spring[1].stiffness", "time.end"]
    assert together("a.toml", [str(i) for i in range(100)]).splitlines()[-1] == "  and 95 more"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("\r\n" * 300_000 + "[a]\r\n[[a]]\r\n", "[a] and [[a]] stand in one file"),
        ("[a]\n\n[[a]]\n\n" * 20_000, "[a] and [[a]] stand in one file"),
        ('[model]\nkind = "lumped"\n[time]\nend = "1 s"\n[output]\nplots = [' + '"x", ' * 40_000 + "]", "40000 entries are wrong"),
    ],
    ids=["empty lines", "heads", "wrong entries"],
)
def test_a_long_wrong_scene_is_refused_in_a_time_that_grows_with_its_length_only(tmp_path, text, message):
    """A search that starts anew at each of 300,000 empty lines takes more than 400 s, a linear one 0.2 s."""
    start = time.process_time()
    with pytest.raises(SceneError) as refused:
        scene_of(tmp_path, text)
    assert message in str(refused.value) and time.process_time() - start < 60


@pytest.mark.parametrize("form", ["mass = [[1, 1], [1, 1]]", "coefficients = [[[1, 1], [1, 1]]]"])
def test_equations_that_determine_no_motion_are_refused(tmp_path, form):
    with pytest.raises(SingularPolynomialMatrix, match=r"det A\(s\)"):
        scene_of(tmp_path, f'[model]\nkind = "matrices"\n{form}\n[time]\nend = 1\n')
