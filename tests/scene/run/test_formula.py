"""The formula of a scene agrees with its numeric run; what has none says so."""

import json
import shutil

import numpy as np
import pytest

from mbconstrained.analyses.formula import formula_of, parameters_text, written
from mbconstrained.ground.errors import ContradictoryConstraints, InputError
from mbconstrained.scene.run.plan import OutOfTime, time_limit
from mbconstrained.scene.run.scene import read_scene
from mbconstrained.scene.run.stages import plan_of
from tests.exact.formulas.answers import c_values, python_values
from tests.scene.scenes import EXAMPLES, MATRICES, OSCILLATOR, scene_of


def kind(path) -> str:
    """Of the model of a scene, which may be that of the scene that it includes."""
    return read_scene(path).table.model.kind


#: Determinants of degree 4 and more in parameters, without roots in closed form: only numbers give a formula.
QUARTIC = "tuned_mass_damper"
WITHOUT_ROOTS = (QUARTIC, "bicycle", "driveline", "washing_machine")
NAMES = [
    path.stem
    for path in sorted(EXAMPLES.glob("*.toml"))
    if kind(path) != "robot"
    and not path.stem.startswith(WITHOUT_ROOTS)
    and not any(
        table in path.read_text("utf-8")
        for table in ("[[motion]]", "[[model.rotor]]", "delayed_feedback", "[[model.contact]]", "[[model.clutch]]")
    )  # of which there is no formula
]


def difference(scene, values, times) -> float:
    """From the numeric run, relative to its largest value."""
    control = scene.equations.control
    known = control.response.together(times) if control and control.form else scene.run().motion(times)
    return np.abs(values - known).max() / np.abs(known).max()


def agrees(scene, **options) -> bool:
    times = np.linspace(0, scene.table.time.end, 80)[1:]
    return difference(scene, python_values(formula_of(scene, **options), times), times) <= 1e-12


@pytest.mark.parametrize("name", NAMES)
def test_the_formula_of_every_example_agrees_with_its_run(name):
    assert agrees(read_scene(EXAMPLES / f"{name}.toml"))


def test_an_example_without_closed_form_in_symbols_says_so():
    with pytest.raises(InputError, match="the eigenvalues have no closed form in m, natural, .*formula --numbers"):
        formula_of(read_scene(EXAMPLES / f"{QUARTIC}.toml"))


@pytest.mark.parametrize("name", ["two_masses_formula", "massless_joints_formula", QUARTIC])
def test_numbers_instead_of_symbols_agree_too(name):
    scene = read_scene(EXAMPLES / f"{name}.toml")
    assert formula_of(scene, numbers=True).parameters == ()
    assert agrees(scene, numbers=True)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no C compiler")
@pytest.mark.parametrize("name", ["two_masses_formula", "massless_joints_formula", "pulled_joint", "transfer_function"])
def test_c_agrees_too(name, tmp_path):
    scene = read_scene(EXAMPLES / f"{name}.toml")
    times = np.linspace(0, scene.table.time.end, 80)[1:]
    assert difference(scene, c_values(formula_of(scene), times, tmp_path), times) <= 1e-12


def test_other_values_of_the_parameters_give_the_run_of_a_scene_with_them(tmp_path):
    text = (EXAMPLES / "massless_joints_formula.toml").read_text("utf-8")
    form, times = formula_of(scene_of(tmp_path, text)), np.linspace(0.5, 50, 60)
    other = scene_of(tmp_path, text.replace('"10 kg"', '"7 kg"').replace('"6 N/m"', '"9 N/m"').replace('"2 m"', '"-1 m"'))
    values = python_values(form, times, 7.0, 9.0, 3.0, 8.0, 4.0, -1.0)
    assert difference(other, values, times) <= 1e-12


FORCED = """
[parameters]
m = 2
g = "-9.81 m/s^2"
f = "0.3 Hz"
F = "3 N"
[model]
kind = "lumped"
gravity = "=g"
mass = [{ name = "a", mass = "=m" }, { name = "b", mass = 1.5 }]
spring = [{ between = ["ground", "a"], stiffness = "=4*m", rest_length = 0.25 }]
damper = [{ between = ["ground", "b"], damping = 0.5 }]
TIE = [{ between = ["a", "b"], ARGUMENTS }]
[initial]
displacement = { a = 1.0 }
follow = true
[[force]]
coordinate = "a"
kind = "harmonic"
value = "=F"
frequency = "=f"
phase = "30 deg"
[[force]]
coordinate = "b"
kind = "FORCE"
[time]
end = 6
"""
TIES = {"rigid_tie": 'distance = "=m/4"', "lever": 'arms = ["=m", 1]', "pulley": "length = 2"}
FORCES = {
    "step": "value = 2",
    "ramp": "value = 1\ndelay = 1",
    "power": "gamma = 3\nvalue = 0.1",
    "impulse": 'value = "3 N*s"\ndelay = 0.5',
    "term": 'value = 1\npower = 1\nrate = "=-1/m"\nangular_frequency = 2',
    "pulse": 'value = 4\nstart = 1\nduration = "=m/4"\ndelay = 0.25',
    "sampled": "times = [0, 1, 1, 2.5]\nvalues = [0, 1, 2, 0]",
}


@pytest.mark.parametrize(
    ("tie", "force"), [(tie, "step") for tie in TIES] + [("rigid_tie", force) for force in FORCES if force != "step"]
)
def test_ties_and_forces_with_parameters(tmp_path, tie, force):
    text = FORCED.replace("TIE", tie).replace("ARGUMENTS", TIES[tie]).replace('"FORCE"', f'"{force}"\n{FORCES[force]}')
    assert agrees(scene_of(tmp_path, text), numbers=force == "sampled")


ONE = """
[model]
kind = "matrices"
coordinates = ["x"]
mass = [["M"]]
stiffness = [["K"]]
[initial]
displacement = { x = 1 }
[time]
end = 5
"""

SHAFTS = """
[parameters]
J = "0.2 kg*m^2"
r = 2
[model]
kind = "lumped"
inertia = [{ name = "one", inertia = "=J" }, { name = "two", inertia = "=3*J" }]
mass = [{ name = "slide", mass = 4 }]
torsion_spring = [{ between = ["ground", "one"], stiffness = "5 N*m/rad", rest_angle = "10 deg" }]
gear = [{ between = ["one", "two"], radii = ["=r", 3] }]
rack = [{ gear = "two", rack = "slide", radius = "=r/10" }]
constraint = [{ rows = { one = 3, slide = "=r" }, level = "velocity", value = 0 }]
[initial]
displacement = { one = 0.5 }
[time]
end = 3
"""


def test_shafts_gears_and_racks(tmp_path):
    free = SHAFTS.replace('constraint = [{ rows = { one = 3, slide = "=r" }, level = "velocity", value = 0 }]\n', "")
    assert agrees(scene_of(tmp_path, free))
    dependent = SHAFTS.replace('{ one = 3, slide = "=r" }', '{ one = "=r", two = 3 }')
    assert agrees(scene_of(tmp_path, dependent))


def test_rows_that_contradict_each_other_with_symbols(tmp_path):
    rows = '[[model.constraint]]\nrows = { a = 1 }\nvalue = "=v"\n[[model.constraint]]\nrows = { a = 2 }\nvalue = "=v*v"\n[time]'
    scene = scene_of(tmp_path, "[parameters]\nv = 2\n" + MATRICES.replace("[time]", rows))
    with pytest.raises(ContradictoryConstraints, match="has the value"):
        formula_of(scene)
    assert formula_of(scene, numbers=True).names == ("a", "b")


def test_where_the_formula_does_not_hold_numbers_are_offered(tmp_path):
    text = "[parameters]\nc = 4\n" + MATRICES.replace("stiffness", 'damping = [["=c", 0], [0, 0]]\nstiffness').replace(
        "[[1, 0], [0, 4]]", "[[4, 0], [0, 4]]"
    )
    scene = scene_of(tmp_path, text.replace("[time]", "[initial]\ndisplacement = [1, 1]\n[time]"))
    with pytest.raises(InputError, match=r"is 0, where the formula with symbols does not hold.*--numbers"):
        formula_of(scene)
    assert agrees(scene, numbers=True)


@pytest.mark.parametrize("one", ["s", "x_0", "p", "z", "I"])
def test_names_of_parameters_mean_nothing_to_the_engine(tmp_path, one):
    text = f"[parameters]\n{one} = 2.0\ns_ = 8.0\n" + ONE.replace("M", f"={one}").replace("K", "=s_")
    scene = scene_of(tmp_path, text)
    assert f"sqrt(s_/{one})" in written(formula_of(scene), "text") and agrees(scene)


RESONANT = """
[[force]]
coordinate = "x"
kind = "harmonic"
value = 1
angular_frequency = "=w"
"""


def test_a_formula_that_is_not_finite_for_its_own_defaults_is_refused(tmp_path):
    damped = ONE.replace("mass", 'damping = [["=c"]]\nmass').replace("[initial]", RESONANT + "[initial]")
    text = damped.replace("M", "=m").replace("K", "=k")
    scene = scene_of(tmp_path, "[parameters]\nm = 1\nk = 4\nc = 0\nw = 2\n" + text)
    with pytest.raises(InputError, match=r"c\^2 w\^2 .* is 0, by which the formula divides; .*--numbers"):
        formula_of(scene)
    assert agrees(scene, numbers=True)
    tiny = scene_of(tmp_path, "[parameters]\nm = 1e-20\nk = 5e-20\nc = 1e-21\nw = 1\n" + text)
    assert agrees(tiny)


def test_signs_that_the_formula_relies_on_are_told(tmp_path):
    scene = scene_of(tmp_path, "[parameters]\nm = 1\ng = -2\n" + ONE.replace("M", "=m").replace("K", "=-g"))
    said = "Default values: m = 1, g = -2. Parameters are assumed positive, g negative."
    assert parameters_text(formula_of(scene)) == said


TWO = """
[model]
kind = "matrices"
coordinates = ["x", "y"]
mass = [[1, 0], [0, 1]]
stiffness = [["=k", 0], [0, 4]]
[initial]
displacement = { x = 1, y = 1 }
[time]
end = 5
"""


def test_assumptions_that_no_shown_coordinate_needs_are_not_made(tmp_path):
    scene = scene_of(tmp_path, "[parameters]\nk = 4\n" + TWO)
    assert formula_of(scene).assumptions == () and agrees(scene)
    coupled = TWO.replace('"=k", 0], [0, 4', '"=k", 0], [-1, 4')
    scene = scene_of(tmp_path, "[parameters]\nk = 4\n" + coupled)
    assert formula_of(scene, coordinates=["x"]).assumptions == ()
    with pytest.raises(InputError, match=r"with the default values k - 4 is 0, where the formula with symbols does not hold"):
        formula_of(scene, coordinates=["y"])


@pytest.mark.long
def test_parameters_that_are_0_stay_parameters(tmp_path):
    text = FORCED.replace("TIE", "rigid_tie").replace("ARGUMENTS", 'distance = "=m/4"').replace('"FORCE"', '"step"\nvalue = 2')
    scene = scene_of(tmp_path, text.replace('"-9.81 m/s^2"', "0").replace('"0.3 Hz"', "0"))
    form, times = formula_of(scene), np.linspace(0.1, 6, 40)
    assert {"g", "f"} <= {p.name for p in form.parameters} and agrees(scene)
    other = scene_of(tmp_path, text.replace('"-9.81 m/s^2"', "3"))
    values = {**{p.name: float(p.value) for p in form.parameters}, "g": 3.0, "f": 0.3}
    assert difference(other, python_values(form, times, *values.values()), times) <= 1e-12


def test_conditions_of_a_state_space_are_in_what_is_given(tmp_path):
    text = """
[parameters]
a = 2
b = 3
[model]
kind = "state-space"
E = [[1, 0], [0, 0]]
A = [["=-a", 0], [1, -1]]
B = [[0], ["=b"]]
C = [["=a", "=b"], [0, 1]]
[initial]
state = { x1 = 1 }
[time]
end = 3
"""
    form = formula_of(scene_of(tmp_path, text.replace("E = ", "descriptor = ")))
    assert [str(each) for each in form.continuous] == ["Eq(x1_0, x2_0)"]


def test_symbols_without_a_closed_form_are_told(tmp_path):
    chain = '[[model.mass]]\nname = "N"\nmass = "=m"\n[[model.spring]]\nbetween = ["B", "N"]\nstiffness = "=k*I"\n'
    parts = "".join(
        chain.replace("N", f"x{i}").replace("B", f"x{i - 1}" if i > 1 else "ground").replace("I", str(i)) for i in range(1, 5)
    )
    scene = scene_of(
        tmp_path,
        f'[parameters]\nm = 1\nk = 2\n[model]\nkind = "lumped"\n{parts}[initial]\ndisplacement = {{ x1 = 1 }}\n[time]\nend = 5\n',
    )
    with pytest.raises(InputError, match="the eigenvalues have no closed form in m, k; insert numbers"):
        formula_of(scene)
    assert agrees(scene, numbers=True)


def test_a_robot_has_no_formula():
    with pytest.raises(InputError, match="no formula with symbols for a robot"):
        formula_of(read_scene(EXAMPLES / "pendulum.toml"))


def test_too_large_and_too_long(tmp_path):
    masses = "".join(f'[[model.mass]]\nname = "m{i}"\nmass = 1\n' for i in range(40))
    with pytest.raises(InputError, match="too many for formulas"):
        formula_of(scene_of(tmp_path, f'[model]\nkind = "lumped"\n{masses}[time]\nend = 1\n'))
    with pytest.raises(InputError, match="within 0.0001 s"):
        formula_of(scene_of(tmp_path, OSCILLATOR), seconds=1e-4)
    with pytest.raises(OutOfTime), time_limit(0.01):
        while True:
            pass


def test_only_some_coordinates_and_none_that_are_not_there(tmp_path):
    scene = scene_of(tmp_path, MATRICES)
    assert formula_of(scene, coordinates=["b"]).names == ("b",)
    with pytest.raises(InputError, match='there is no coordinate "c"'):
        formula_of(scene, coordinates=["c"])
    with pytest.raises(InputError, match='the coordinate "b" is named twice'):
        formula_of(scene, coordinates=["b", "b"])


def test_impulses_jumps_and_conditions_are_those_of_the_run():
    form, motion = formula_of(read_scene(EXAMPLES / "rigid_link.toml")), read_scene(EXAMPLES / "rigid_link.toml").run().motion
    assert [(each.name, each.order, float(each.size)) for each in form.impulses] == [("lambda", 1, motion.impulses[1][2])]
    jumps = {(each.name, each.order): float(each.size) for each in form.jumps}
    names = motion.coordinates if hasattr(motion, "coordinates") else ("q1", "q2", "lambda")
    assert jumps == pytest.approx({(names[i], order): motion.jump[order, i] for order, i in np.argwhere(motion.jump)})
    assert len(form.admissible) == 2 and len(form.continuous) == 4


def test_the_page_shows_the_formula_if_it_is_asked_for(tmp_path):
    text = OSCILLATOR.replace('"8 N/m"', '"=k"') + "[parameters]\nk = 8\n[output]\nformula = true\n"
    scene = scene_of(tmp_path, text)
    stage = next(stage for stage in plan_of(scene).stages if stage.name.startswith("symbols"))
    assert (stage.needed, stage.reason) == (True, "formula = true: 1 parameter as symbols")
    result = scene.run(tmp_path / "results")
    page = (tmp_path / "results" / "scene.html").read_text("utf-8")
    assert '<section class="formulas">' in page and "<math" in page and "Default values: k = 8." in page
    assert result.is_trusted


def test_a_formula_that_is_not_found_is_a_notice_on_the_page(tmp_path, monkeypatch):
    monkeypatch.setattr("mbconstrained.scene.run.stages.MOST_FORMULA_STATES", 0)
    scene = scene_of(tmp_path, OSCILLATOR + "[output]\nformula = true\n")
    result = scene.run(tmp_path / "results")
    assert any("the formula is left out: " in notice.text for notice in result.notices)
    assert "<math" not in (tmp_path / "results" / "scene.html").read_text("utf-8")


def test_json_is_plain_data():
    form = formula_of(read_scene(EXAMPLES / "two_masses_formula.toml"))
    found = json.loads(written(form, "json"))
    assert found["parameters"] == {"m": {"value": 10.0, "unit": "kg"}, "k": {"value": 2.0, "unit": "N/m"}}
    assert list(found["formulas"]) == ["x1", "q1", "q2"]
