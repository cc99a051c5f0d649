"""Entries that are wrong: the message names the place, what was found, what was expected, the nearest name."""

import time

import pytest

from mbconstrained.ground.errors import SceneError, SingularPolynomialMatrix
from mbconstrained.scene.file import together
from tests.scene.scenes import COEFFICIENTS, MATRICES, OSCILLATOR, scene_of

TURNING = """
[model]
kind = "lumped"

[[model.inertia]]
name = "wheel"
inertia = 1

[[model.mass]]
name = "cart"
mass = 1

[[model.mass]]
name = "load"
mass = 1

[time]
end = 1
"""

BASES = {"turning": TURNING, "lumped": OSCILLATOR, "matrices": MATRICES, "coefficients": COEFFICIENTS}

CASES = [  # base, what is replaced, by what, message
    # keys and tables
    ("lumped", "[initial]", "[inital]", r'the file: unknown key "inital"; did you mean "initial"\?; known here are title'),
    ("lumped", "stiffness", "stifness", r'model\.spring\[1\]: unknown key "stifness"; did you mean "stiffness"\?'),
    ("lumped", "[time]\nend", "[time]\nstop = 1\nend", r'time: unknown key "stop".*known here are end, start, points, step'),
    ("lumped", 'end = "5 s"', "", r"time\.end: this key is missing"),
    (
        "lumped",
        'kind = "lumped"',
        'kind = "lumpd"',
        r'model: kind: found "lumpd"; expected "lumped", "matrices", "robot", "state-space" or "transfer-function"; did you mean "lumped"\?',
    ),
    (
        "lumped",
        'kind = "lumped"\n',
        "",
        r'model: the key kind is missing; expected "lumped", "matrices", "robot", "state-space" or "transfer-function"',
    ),
    ("lumped", "[[model.mass]]", "[model.mass]", r"model\.mass: found one table; write it with double brackets"),
    ("lumped", "points = 11", "points = 1", r"time\.points: found 1; expected at least 2"),
    ("lumped", "points = 11", "points = 10000000", r"time\.points: found 10000000; expected at most 200000"),
    ("lumped", "points = 11", 'points = "11"', r'time\.points: found "11"; expected a whole number'),
    ("lumped", "points = 11", "points = 1.5", r"time\.points: found 1.5; expected a whole number"),
    ("lumped", "points = 11", "[output]\npage = 1", r"output\.page: found 1; expected true or false"),
    (
        "lumped",
        "points = 11",
        '[output]\nplots = ["dsplacement"]',
        r'output\.plots\[1\]: found "dsplacement"; .*did you mean "displacement"',
    ),
    ("lumped", "points = 11", '[output]\nplots = ["reaction"]', r"output\.plots: found reaction, but there are no constraint rows"),
    (
        "lumped",
        "points = 11",
        '[output]\ncoordinates = ["crat"]',
        r'output\.coordinates: there is no coordinate "crat"; did you mean "cart"',
    ),
    ("coefficients", "points = 5", '[output]\nplots = ["energy"]', r"output\.plots: energy is known only where mass"),
    (
        "lumped",
        "points = 11",
        '[output]\nplots = ["velocity", "velocity"]',
        r'output\.plots: "velocity" is named twice; once is enough',
    ),
    ("matrices", "points = 5", '[output]\ncoordinates = ["a", "b", "a"]', r'output\.coordinates: "a" is named twice'),
    ("lumped", "[model]", "[models]", r'the file: unknown key "models"; did you mean "model"\?'),
    (
        "lumped",
        "[time]",
        '[vary]\nk = "1..3 N/m"\n[time]',
        r"vary: unknown key \"k\"; what varies stands by its name in parameters, below \[vary.parameters\]",
    ),
    ("lumped", "[model]\n", "[[model]]\n", r"model: there is one model only: write it with single brackets, \[model\]"),
    ("lumped", "[time]", "[[time]]", r"time: there is one table of this kind only: write it with single brackets"),
    (
        "lumped",
        "points = 11",
        '[[force]]\non = "cart"\nkind = "step"\nvalue = 1',
        r'force\[1\]: unknown key "on"; did you mean "coordinate"\?',
    ),
    (
        "lumped",
        "points = 11",
        '[[force]]\ncoordinate = "cart"\nkind = "harmonic"\namplitude = 1',
        r'force\[1\]: unknown key "amplitude"; did you mean "value"\?',
    ),
    ("lumped", 'end = "5 s"\n', "", r"time\.end: this key is missing"),
    (
        "matrices",
        '[model]\nkind = "matrices"\ncoordinates = ["a", "b"]\nmass = [[1, 0], [0, 1]]\nstiffness = [[1, 0], [0, 4]]',
        "",
        r"model: this table is missing: write \[model\]",
    ),
    ("lumped", "[[model.mass]]", "[[mass]]", r'the file: unknown key "mass"; it belongs to the model: write \[\[model\.mass\]\]'),
    ("lumped", "[[model.spring]]", "[[model.springs]]", r'model: unknown key "springs"; did you mean "spring"\?'),
    ("lumped", "points = 11", '[output]\ntitle = "x"', r'output: unknown key "title"; title = … stands at the top of the file'),
    ("lumped", "displacement = {", "position = {", r'initial: unknown key "position"; did you mean "displacement"\?'),
    (
        "lumped",
        "points = 11",
        "[force]\nkind = 'step'",
        r"force: found one table; write it with double brackets, \[\[force\]\], once for every entry",
    ),
    ("lumped", "points = 11", "points = 0", r"time\.points: found 0; expected at least 2"),
    ("lumped", "points = 11", "number = 3", r'time: unknown key "number"; known here are end, start, points, step'),
    # quantities
    (
        "lumped",
        '"8 N/m"',
        '"8 N/m m"',
        r'stiffness: found "8 N/m m"; expected a stiffness.*then a unit made of names, \*, / and \^',
    ),
    (
        "lumped",
        '"8 N/m"',
        '"8 Newton per metre"',
        r'stiffness: found "8 Newton per metre", but there is no unit "Newton"; did you mean "newton"|found "8 Newton per metre"',
    ),
    ("lumped", '"2 kg"', '"2 kgm"', r'found "2 kgm", but "kgm" may be read as kg\*m; write it with the \*'),
    ("lumped", '"2 kg"', '"2,5 kg"', r'found "2,5 kg"; expected a mass.*decimals have a point: "2.5 kg"'),
    ("lumped", '"2 kg"', '"2"', r'found "2"; .*write its unit too, or the number without quotes, which is then in SI'),
    ("lumped", '"2 kg"', "0", r"found no mass; a point without mass is a node"),
    ("lumped", '"2 kg"', "inf", r"found inf; expected a finite number"),
    ("lumped", '"8 N/m"', "1e200", r"found 1e\+200; expected 0 or a size between 1e-100 and 1e\+100"),
    ("lumped", '"8 N/m"', '"-8 N/m"', r"model\.spring\[1\]: .*stiffness: found -8; expected a number greater than zero"),
    ("lumped", '"5 s"', "0", r"time: end is 0 s; expected a time after 0"),
    ("lumped", '"5 s"', '"5 S"', r'time\.end: found "5 S", .*; did you mean "5 s"\?'),
    (
        "lumped",
        '"2 kg"',
        '"2 N/mm"',
        r'model\.mass\[1\]\.mass \(of "cart"\): found "2 N/mm", a stiffness; expected a mass, e\.g\. "10 kg"',
    ),
    ("lumped", '"2 kg"', "nan", r"model\.mass\[1\]\.mass .*: found nan; expected a finite number"),
    ("lumped", '"2 kg"', "-2", r'model\.mass\[1\] \(of "cart"\): .*mass.*found -2; expected a number greater than zero'),
    ("lumped", '"8 N/m"', '"8 Nm"', r'model\.spring\[1\]\.stiffness: found "8 Nm", a torque; expected a stiffness'),
    ("lumped", '"5 s"', '"5 m"', r'time\.end: found "5 m", a length; expected a time'),
    ("lumped", '"5 s"', "-5", r"time: end is -5 s; expected a time after 0"),
    ("lumped", '"5 s"', "1979-05-27", r"time\.end: found 1979-05-27; expected a time"),
    ("lumped", "cart = 0.1", "cart = nan", r"initial\.displacement: cart: found nan; expected a finite number"),
    ("lumped", "cart = 0.1", 'cart = "0.1 rad"', r'initial\.displacement: cart: found "0.1 rad", an angle; expected a length'),
    (
        "coefficients",
        "[time]",
        '[initial]\nvelocity = { q = "1 m/s" }\n[time]',
        r"initial\.velocity: q: found .*, a velocity; expected an angular velocity",
    ),
    # names
    (
        "lumped",
        "cart = 0.1",
        "crat = 0.1",
        r'initial\.displacement: there is no coordinate "crat"; did you mean "cart"\?; the coordinates are cart',
    ),
    ("lumped", '"ground", "cart"', '"ground", "crat"', r'model\.spring\[1\]: .*there is no body "crat"; did you mean "cart"'),
    ("lumped", '"ground", "cart"', '"cart", "cart"', r"model\.spring\[1\]: .*same body"),
    ("lumped", '"ground", "cart"', '"ground"', r"model\.spring\[1\]\.between: found an array of 1; expected at least 2 entries"),
    (
        "lumped",
        'name = "cart"',
        'name = "=cmd|calc"',
        r'model\.mass\[1\]\.name .*found "=cmd\|calc"; expected a name: a letter first',
    ),
    ("lumped", 'name = "cart"', 'name = "ground"', r'model\.mass\[1\] .*the name "ground" is that of the fixed body'),
    (
        "lumped",
        "[[model.spring]]",
        '[[model.mass]]\nname = "cart"\nmass = 1\n[[model.spring]]',
        r'model\.mass\[2\] \(of "cart"\): .*names must differ',
    ),
    ("matrices", '["a", "b"]', '["a", "a"]', r'model\.coordinates: the name "a" is used twice'),
    ("matrices", '["a", "b"]', '["a"]', r"model\.coordinates: found 1 names; expected 2"),
    ("matrices", "[time]", '[model.units]\nc = "rad"\n[time]', r'model\.units: there is no coordinate "c"'),
    ("matrices", "[time]", '[model.units]\na = "mm"\n[time]', r'model\.units\.a: found "mm"; expected "m", "rad"'),
    # elements between the wrong bodies
    (
        "lumped",
        "[time]",
        '[[model.node]]\nname = "pin"\n[time]',
        r'model\.node\[1\] \(of "pin"\): nothing is attached to this joint, which has no mass',
    ),
    (
        "turning",
        "[time]",
        '[[model.gear]]\nbetween = ["wheel", "cart"]\nteeth = [20, 30]\n[time]',
        r'model\.gear\[1\]: .*"cart" moves along the axis \(m\), but a gear needs a body that turns',
    ),
    (
        "turning",
        "[time]",
        '[[model.spring]]\nbetween = ["wheel", "cart"]\nstiffness = 3\n[time]',
        r'model\.spring\[1\]: .*"wheel" turns \(rad\), but a spring needs a body that moves',
    ),
    (
        "turning",
        "[time]",
        '[[model.rack]]\ngear = "cart"\nrack = "wheel"\nradius = 1\n[time]',
        r'model\.rack\[1\]: gear is what turns, here "wheel", and rack what moves, "cart"; they are swapped',
    ),
    (
        "turning",
        "[time]",
        '[[model.gear]]\nbetween = ["wheel", "ground"]\nteeth = [20, -30]\n[time]',
        r"model\.gear\[1\].teeth\[2\]: found -30; expected a whole number of teeth",
    ),
    (
        "turning",
        "[time]",
        '[[model.gear]]\nbetween = ["wheel", "ground"]\n[time]',
        r"model\.gear\[1\]: .*expected both radii, both numbers of teeth, or the ratio",
    ),
    (
        "turning",
        "[time]",
        '[[model.rigid_tie]]\nname = "rod"\nbetween = ["cart", "load"]\n[[model.rigid_tie]]\nname = "bar"\nbetween = ["cart", "load"]\ndistance = "1 m"\n[time]',
        r'model: constraint "bar" \(position level\) has the value 1 m, but it follows from "rod"',
    ),
    # matrices
    ("matrices", "[[1, 0], [0, 1]]", "[[1, 0], [0]]", r"model\.mass: found rows of 2, 1 numbers; expected rows of equal length"),
    ("matrices", "[[1, 0], [0, 1]]", "[[1, 0]]", r"model\.mass: found 1 rows and 2 columns; expected a square matrix"),
    ("matrices", "[[1, 0], [0, 1]]", "[[1, 0], [0, inf]]", r"model\.mass: found inf; expected a finite number"),
    ("matrices", "[[1, 0], [0, 1]]", '[[1, 0], [0, "1 m"]]', r'model\.mass\[2\]\[2\]: found "1 m", a length; expected a mass'),
    ("matrices", "[[1, 0], [0, 1]]", "[]", r"model\.mass: found an array of 0; expected rows of numbers"),
    ("matrices", "[[1, 0], [0, 1]]", "5", r"model\.mass: found 5; expected rows of numbers"),
    ("matrices", "[[1, 0], [0, 4]]", "[[1]]", r"model: stiffness: expected shape 2 x 2, found 1 x 1"),
    ("matrices", "mass = [[1, 0], [0, 1]]\n", "", r"model: give either mass \(with damping and stiffness\) or coefficients"),
    ("coefficients", "coefficients =", "stiffness = [[1]]\ncoefficients =", r"model: stiffness cannot stand with coefficients"),
    ("coefficients", "[[[4]], [[0]], [[1]]]", "[]", r"model: coefficients is empty"),
    ("coefficients", "[[0]]", "[[0, 0], [0, 0]]", r"model\.coefficients: A_1 has shape \(2, 2\), but A_0 has \(1, 1\)"),
    # initial values
    (
        "matrices",
        "[time]",
        "[initial]\ndisplacement = [1]\n[time]",
        r"initial\.displacement: found 1 values; expected 2, one for each of a, b",
    ),
    ("matrices", "[time]", "[initial]\ndisplacement = 1\n[time]", r"initial\.displacement: found 1; expected"),
    ("matrices", "[time]", "[initial]\nacceleration = { a = 1 }\n[time]", r"initial\.acceleration: the equations have degree 2"),
    (
        "matrices",
        "[time]",
        "[initial]\ndisplacement = { a = 1 }\nderivatives = [[1, 1]]\n[time]",
        r"derivatives and displacement say the same",
    ),
    # constraints and forces
    (
        "matrices",
        "[time]",
        "[[model.constraint]]\nrows = { a = 1, c = -1 }\n[time]",
        r'model\.constraint\[1\]: there is no coordinate "c"',
    ),
    (
        "matrices",
        "[time]",
        "[[model.constraint]]\nrows = {}\n[time]",
        r"model\.constraint\[1\]\.rows: found a table; expected coordinates with their factors",
    ),
    (
        "matrices",
        "[time]",
        '[[model.constraint]]\nrows = { a = 1 }\nlevel = "positon"\n[time]',
        r'level: found "positon"; .*did you mean "position"',
    ),
    (
        "matrices",
        "[time]",
        '[[model.constraint]]\nrows = { a = 1 }\nlevel = "velocity"\nvalue = "1 m"\n[time]',
        r'value: found "1 m", a length; expected a velocity',
    ),
    (
        "matrices",
        "[time]",
        '[model.units]\nb = "rad"\n[[model.constraint]]\nrows = { a = 1, b = 1 }\nvalue = "1 m"\n[time]',
        r"this row mixes m and rad: give a plain number",
    ),
    (
        "matrices",
        "[time]",
        "[[model.constraint]]\nrows = { a = 1 }\n[[model.constraint]]\nrows = { a = 2 }\nvalue = 1\n[time]",
        r"model: constraint .* has the value 1 m, but it follows from",
    ),
    (
        "matrices",
        "[time]",
        "[[model.constraint]]\nrows = { a = 0 }\nvalue = 1\n[time]",
        r"has the value 1 m, but all its coefficients are zero, with the value 0 m;",
    ),
    (
        "matrices",
        "[time]",
        '[[motion]]\ncoordinate = "a"\nkind = "record"\nfile = "r.csv"\n[time]',
        r'motion\[1\]: kind: found "record"; .*did you mean "sampled"',
    ),
    (
        "matrices",
        "[time]",
        '[[force]]\ncoordinate = "a"\nkind = "stp"\nvalue = 1\n[time]',
        r'force\[1\]: kind: found "stp"; .*did you mean "step"',
    ),
    (
        "matrices",
        "[time]",
        '[[force]]\ncoordinate = "x"\nkind = "step"\nvalue = 1\n[time]',
        r'force\[1\]: there is no coordinate "x"',
    ),
    (
        "matrices",
        "[time]",
        '[[force]]\ncoordinate = "a"\nkind = "ramp"\nvalue = "1 N"\n[time]',
        r'force\[1\]: value: found "1 N", a force; expected a quantity in N/s',
    ),
    (
        "matrices",
        "[time]",
        '[[force]]\ncoordinate = "a"\nkind = "harmonic"\nvalue = 1\n[time]',
        r"force\[1\]: give angular_frequency",
    ),
    (
        "matrices",
        "[time]",
        '[[force]]\ncoordinate = "a"\nkind = "harmonic"\nvalue = 1\nfrequency = 1\nangular_frequency = 1\n[time]',
        r"force\[1\]: give either angular_frequency",
    ),
    (
        "matrices",
        "[time]",
        '[[force]]\ncoordinate = "a"\nkind = "step"\nvalue = 1\nphase = 1\n[time]',
        r'force\[1\]: unknown key "phase"',
    ),
    (
        "matrices",
        "[time]",
        '[[force]]\ncoordinate = "a"\nkind = "impulse"\nvalue = 1\norder = -1\n[time]',
        r"force\[1\]\.order: found -1; expected at least 0",
    ),
    # drawing
    (
        "matrices",
        "[time]",
        '[[drawing.body]]\nname = "m"\nshape = "bx"\n[time]',
        r'drawing\.body\[1\]\.shape .*: found "bx"; .*did you mean "box"',
    ),
    (
        "matrices",
        "[time]",
        '[[drawing.body]]\nname = "m"\nshape = "box"\nmoves = { c = [1, 0, 0] }\n[time]',
        r'drawing\.body\[1\] \(of "m"\): there is no coordinate "c"',
    ),
    (
        "matrices",
        "[time]",
        '[[drawing.body]]\nname = "m"\nshape = "box"\ncolor = "red"\n[time]',
        r'color .*found "red"; expected a colour such as',
    ),
    (
        "matrices",
        "[time]",
        '[[drawing.link]]\nkind = "spring"\nstart = "m"\nend = "w"\n[time]',
        r'drawing\.link\[1\]: there is no body "m" in the drawing',
    ),
    (
        "matrices",
        "[time]",
        '[[drawing.body]]\nname = "m"\nshape = "box"\n[[drawing.link]]\nkind = "spring"\nstart = "m"\nend = "m"\n[time]',
        r'drawing\.link\[1\]: start and end are the same body, "m"; name two',
    ),
    # texts
    ("lumped", "[model]", 'title = "\\u001b[31mred"\n[model]', r'title: found the character "\\x1b", which cannot be printed'),
    ("lumped", "[model]", "title = 3\n[model]", r"title: found 3; expected a text in quotes"),
]


@pytest.mark.parametrize(("base", "old", "new", "message"), CASES, ids=[f"{case[0]}: {case[2][:50]!r}" for case in CASES])
def test_message(tmp_path, base, old, new, message):
    text = BASES[base]
    assert old in text
    with pytest.raises(SceneError, match=message) as caught:
        scene_of(tmp_path, text.replace(old, new, 1))
    assert str(caught.value).startswith("scene.toml: ")


def test_all_problems_are_told_at_once_but_not_endlessly(tmp_path):
    with pytest.raises(SceneError) as caught:
        scene_of(tmp_path, OSCILLATOR.replace("2 kg", "2 m").replace("8 N/m", "8 s").replace("5 s", "5 kg"))
    lines = str(caught.value).splitlines()
    assert lines[0] == "scene.toml: 3 entries are wrong"
    assert [line.split(":")[0].strip() for line in lines[1:]] == [
        'model.mass[1].mass (of "cart")',
        "model.spring[1].stiffness",
        "time.end",
    ]
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
