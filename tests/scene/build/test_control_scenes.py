"""Scenes of kinds "transfer-function" and "state-space": what they ask for, what is written, what is refused."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.modes import ModalAnalysis
from tests.scene.scenes import scene_of

FRACTION = """
[model]
kind = "transfer-function"
numerator = [2]
denominator = [1, 3, 2]
units = { u = "V", y = "rad" }

[[force]]
coordinate = "u"
kind = "step"
value = "500 mV"

[time]
end = 2
points = 5
"""

STATES = """
[model]
kind = "state-space"
A = [[0, 1], [-4, -5]]
B = [[0], [1]]
C = [[1, 0]]
units = { y1 = "m", x1 = "m", u1 = "N" }

[initial]
state = { x1 = "10 cm" }

[[force]]
coordinate = "u1"
kind = "step"
value = "4 N"

[time]
end = 2
points = 5
"""


def lag(t):
    """2 / (s + 1)(s + 2) from rest by a step of one."""
    return 1 - 2 * np.exp(-t) + np.exp(-2 * t)


def test_a_step_response_in_its_units(tmp_path):
    result = scene_of(tmp_path, FRACTION).run()
    assert result.values[0] == pytest.approx(0.5 * lag(result.times), abs=1e-15)
    assert result.scene.equations.coordinates.units == ("rad",)
    assert "u     y   none         2     1 rad/V" in result.summary()


@pytest.mark.parametrize("gamma", [0, 1, 2, 3])
def test_gamma_is_the_input(tmp_path, gamma):
    text = FRACTION[: FRACTION.index("[[force]]")] + f"gamma = {gamma}\n[time]\nend = 2\npoints = 5\n"
    text = text.replace('units = { u = "V", y = "rad" }\n\ngamma', "gamma")
    result = scene_of(tmp_path, text).run()
    expected = mb.transfer_function_response([2], [1, 3, 2], gamma)
    assert np.array_equal(result.values, expected(result.times))


def test_values_of_the_output_before_zero(tmp_path):
    # y'' + 3 y' + 2 y = 0 from y = 0.2, y' = -0.2: 0.2 e^-t; with u' in the numerator a step makes y' jump by b_1/a_2
    free = (
        FRACTION[: FRACTION.index("[[force]]")]
        + "[initial]\ndisplacement = { y = 0.2 }\nvelocity = { y = -0.2 }\n[time]\nend = 2\npoints = 5\n"
    )
    result = scene_of(tmp_path, free).run()
    assert result.values[0] == pytest.approx(0.2 * np.exp(-result.times), rel=1e-14)
    with_step = free.replace("numerator = [2]", "numerator = [3, 2]").replace(
        "[initial]", '[[force]]\ncoordinate = "u"\nkind = "step"\nvalue = 1\n[initial]'
    )
    found = scene_of(tmp_path, with_step).run()
    assert found.motion.jump[:, 0] == pytest.approx([0, 3])


def test_as_many_zeros_as_poles_and_more(tmp_path):
    # s^2/(s + 1) of a step is s/(s + 1) = 1 - 1/(s + 1): delta - e^-t, times 0.5
    text = FRACTION.replace("[2]", "[1, 0, 0]").replace("[1, 3, 2]", "[1, 1]")
    motion = scene_of(tmp_path, text).run().motion
    assert [impulse.tolist() for impulse in motion.impulses] == [[0.5]]
    assert motion([0.0, 1.0])[0] == pytest.approx([-0.5, -0.5 * np.exp(-1)], abs=1e-15)


def test_a_state_space_from_a_state(tmp_path):
    # x'' + 5 x' + 4 x = 4 from 0.1 at rest: 1 - 0.9 (4 e^-t - e^-4t)/3
    result = scene_of(tmp_path, STATES).run()
    t = result.times
    x = 1 - 0.3 * (4 * np.exp(-t) - np.exp(-4 * t))
    assert result.values == pytest.approx(np.array([x, 1.2 * (np.exp(-t) - np.exp(-4 * t)), x]), abs=1e-14)
    assert result.scene.equations.coordinates.names == ("x1", "x2", "y1")
    assert np.array_equal(result.curves("output").values, result.values[2:])
    assert not result.motion.jump.any()


def test_the_normal_form_moves_the_same_outputs(tmp_path):
    plain = scene_of(tmp_path, STATES).run()
    made = scene_of(tmp_path, STATES.replace("units =", "normal_form = true\nunits =")).run()
    assert made.curves("output").values == pytest.approx(plain.curves("output").values, abs=1e-14)
    assert made.system.stiffness == pytest.approx(np.array([[4.0]]), rel=1e-13)
    assert made.scene.equations.coordinates.names == ("q1",)
    assert made.values == pytest.approx(made.curves("output").values, abs=1e-13)  # B = [0; 1]: q is x1
    content = made.page()
    assert content.animation is not None and [plot.title for plot in content.plots] == ["displacement", "output"]


def test_the_normal_form_starts_from_its_own_values_too(tmp_path):
    text = STATES.replace("units =", 'coordinates = ["cart"]\nnormal_form = true\nunits =').replace(
        "state = { x1 =", "displacement = { cart ="
    )
    made, plain = scene_of(tmp_path, text).run(), scene_of(tmp_path, STATES).run()
    assert made.curves("output").values == pytest.approx(plain.curves("output").values, abs=1e-13)
    assert made.scene.equations.control.start == pytest.approx([0.1, 0.0], abs=1e-15)


def test_outputs_of_the_normal_form_that_jump_are_told(tmp_path):
    text = STATES.replace("C = [[1, 0]]", "C = [[1, 0]]\nD = [[0.5]]\nnormal_form = true")
    summary = scene_of(tmp_path, text).run().summary()
    assert "Outputs at t = 0" in summary and "y1  jumps  0.1 m   2.1 m  2 m" in summary


def test_a_descriptor_in_files(tmp_path):
    np.savez(tmp_path / "plant.npz", E=np.diag([1.0, 0.0]), A=np.array([[-1.0, 1.0], [0.0, 1.0]]))
    text = STATES.replace(
        "A = [[0, 1], [-4, -5]]", 'A = { file = "plant.npz", array = "A" }\ndescriptor = { file = "plant.npz", array = "E" }'
    )
    result = scene_of(tmp_path, text).run()  # x2 = -u = -4, x1' = -x1 - 4 from 0.1
    assert result.values[0] == pytest.approx(-4 + 4.1 * np.exp(-result.times), rel=1e-14)
    assert result.motion.jump[0] == pytest.approx([0, -4, 0])


def test_a_common_factor_is_told(tmp_path):
    result = scene_of(tmp_path, FRACTION.replace("[2]", "[2, 2]")).run()
    assert any("common factor s + 1" in notice.text for notice in result.notices)


def test_zeros_of_many_states_are_not_looked_for(tmp_path):
    text = STATES.replace("[[0, 1], [-4, -5]]", str((-np.eye(50)).tolist())).replace("[[0], [1]]", str([[1]] * 50))
    text = text.replace("[[1, 0]]", str([[1] * 50])).replace("units = ", "#").replace('"10 cm"', "0.1").replace('"4 N"', "4")
    scene = scene_of(tmp_path, text)
    stage = next(stage for stage in scene.plan().stages if stage.name == "transfer functions")
    assert not stage.needed and "DC gains are listed" in stage.reason
    assert "not looked for        50" in scene.run().summary()


def test_modes_of_a_state_space_are_its_poles(tmp_path):
    lines = ModalAnalysis(scene_of(tmp_path, STATES)).lines
    assert [line.value.real for line in lines] == pytest.approx([-1, -4])
    with pytest.raises(mb.SceneError, match="model: a page of modes needs mass"):
        ModalAnalysis.solve(scene_of(tmp_path, STATES)).write(tmp_path, ["page"])


FRACTION_CASES = [  # what is replaced, by what, what the message says
    ("[1, 3, 2]", "[0, 0]", "model: denominator: every coefficient is zero"),
    ("numerator = [2]", 'numerator = ["2 s"]', 'model.numerator[1]: found "2 s"; expected a plain number'),
    ("numerator = [2]", 'numerator = [2]\noutput = "u"', 'model: input and output have the same name, "u"'),
    ('u = "V"', 'v = "V"', 'model: units: there is no input or output "v"'),
    ('u = "V"', 'u = "Volts per"', 'model.units.u: found "Volts per", but there is no unit'),
    ('u = "V"', "u = 5", "model.units.u: found 5; expected a unit such as"),
    ('coordinate = "u"', 'coordinate = "v"', 'force[1]: there is no input "v"; the inputs are u'),
    ('"500 mV"', '"500 mA"', "expected a quantity in V"),
    ("[time]", "[initial]\nstate = [1]\n[time]", "initial.state: a transfer function has no states; give displacement"),
    ("[time]", "[initial]\nacceleration = [1]\n[time]", "initial.acceleration: the equations have degree 2"),
    ("[time]", "[initial]\nfollow = true\n[time]", "initial.follow: there are no constraint rows"),
    ("units =", "delay = -1\nunits =", "delay: found -1"),
    (FRACTION[FRACTION.index("[[force]]") : FRACTION.index("[time]")], "", "model: nothing acts: give gamma = 1"),
]
C, NORMAL_FORM = "C = [[1, 0]]", "C = [[1, 0]]\nnormal_form = true"
UNITS = 'units = { y1 = "m", x1 = "m", u1 = "N" }'
STATES_CASES = [
    ("A = [[0, 1], [-4, -5]]", "A = [[0, 1]]", "model: A: expected a square matrix, found 1 x 2"),
    ("B = [[0], [1]]", "B = [[0]]", "model: B: expected shape 2 x any, found 1 x 1"),
    ("B = [[0], [1]]", 'B = "missing.csv"', "model.B: missing.csv: there is no such file"),
    (C, f'{C}\nstates = ["x1"]', "model: states: 1 names given for 2"),
    (C, f'{C}\ncoordinates = ["q"]', "model: coordinates are the displacements of the normal form"),
    (C, f'{NORMAL_FORM}\ncoordinates = ["a", "b"]', "model.coordinates: found 2 names; expected 1"),
    (C, f'{NORMAL_FORM}\ncoordinates = ["x1"]', 'model: the name "x1" is used twice'),
    (UNITS, 'inputs = ["x2"]', 'the name "x2" is used twice'),
    (UNITS, 'outputs = ["x2"]', 'the name "x2" is used twice'),
    ("state = { x1", "displacement = { x1", "initial: a state space starts from its states; write state = "),
    ("state = { x1", "state = { x3", 'initial.state: there is no state "x3"; the states are x1, x2'),
    ('x1 = "10 cm"', 'x1 = "10 s"', 'initial.state: x1: found "10 s", a time; expected a length'),
    ("[time]", '[output]\nplots = ["energy"]\n[time]', "output.plots: energy is known only where"),
    (f'{C}\nunits = {{ y1 = "m", x1', 'normal_form = true\nunits = { q1 = "kg", x1', """found 'kg'; expected "m", "rad\""""),
    ("units =", "delays = { u2 = 1 }\nunits =", 'delays: there is no input "u2"'),
]
WITH_PLOT = STATES + '[output]\nplots = ["output"]\n'
CASES = [(FRACTION, *case) for case in FRACTION_CASES] + [(STATES, *case) for case in STATES_CASES]
CASES += [(WITH_PLOT, f'{C}\nunits = {{ y1 = "m", ', "units = { ", "output.plots: found output, but no outputs are named")]


@pytest.mark.parametrize(("text", "old", "new", "says"), CASES, ids=[case[2][:30] for case in CASES])
def test_message(tmp_path, text, old, new, says):
    assert old in text
    with pytest.raises(mb.SceneError) as caught:
        scene_of(tmp_path, text.replace(old, new, 1))
    assert str(caught.value).startswith("scene.toml: ") and says in str(caught.value)


def test_states_belong_to_state_spaces_only(tmp_path):
    text = '[model]\nkind = "matrices"\nmass = [[1]]\n[initial]\nstate = [1]\n[time]\nend = 1\n'
    with pytest.raises(mb.SceneError, match='initial.state belongs to kind = "state-space"'):
        scene_of(tmp_path, text)


def test_a_singular_pencil(tmp_path):
    with pytest.raises(mb.SingularPolynomialMatrix):
        scene_of(tmp_path, STATES.replace("[[0, 1], [-4, -5]]", "[[0, 1], [0, 0]]\ndescriptor = [[1, 0], [0, 0]]"))


LATE = [
    (FRACTION.replace("units =", 'delay = "0.3 s"\nunits ='), FRACTION),
    (STATES.replace("units =", 'delays = { u1 = "0.3 s" }\nunits ='), STATES),
]


@pytest.mark.parametrize(("late", "own"), LATE)
def test_a_dead_time_of_an_input_delays_its_force_and_turns_the_phase(tmp_path, late, own):
    (late_scene, own_scene) = (scene_of(tmp_path, text, f"{name}.toml") for name, text in (("late", late), ("own", own)))
    delayed = scene_of(tmp_path, own.replace('kind = "step"', 'kind = "step"\ndelay = "0.3 s"'), "delayed.toml")
    answer = late_scene.run()
    assert (answer.values == delayed.run().values).all() and answer.error_estimate < 1e-13
    frequencies = {"frequencies": ["0.1 Hz", "3 Hz", "1 kHz"]}
    H, G = (scene.frequency(**frequencies) for scene in (late_scene, own_scene))
    values, without, f = H.arrays()["values"], G.arrays()["values"], H.arrays()["frequencies_hz"]
    assert np.abs(values / (without * np.exp(-0.6j * np.pi * f)) - 1).max() < 1e-12
    assert (H.arrays()["error_estimate"] >= G.arrays()["error_estimate"]).all()


def test_dead_times_in_discrete_time_act_after_the_hold(tmp_path):
    late = LATE[1][0].replace("end = 2", 'end = 2\nstep = 0.2\nstep_domain = "discrete"\nhold = 0').replace("points = 5\n", "")
    values = scene_of(tmp_path, late).run().values
    delayed = scene_of(tmp_path, STATES.replace('kind = "step"', 'kind = "step"\ndelay = "0.3 s"')).run()
    assert values[0] == pytest.approx(delayed.motion.of("y1")(0.2 * np.arange(11))[0], abs=1e-14)


def test_an_input_of_least_energy_has_no_dead_time(tmp_path):
    with pytest.raises(mb.SceneError, match='least_energy: the input "u1" has a dead time'):
        scene_of(tmp_path, LATE[1][0] + "[least_energy]\nduration = 1\n").run()
