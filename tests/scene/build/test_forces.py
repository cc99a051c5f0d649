"""Forces of a scene: signals that may begin later, pulses, records: what they are, what is wrong with them, and what is told."""

import json

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from tests.scene.scenes import MATRICES, OSCILLATOR, scene_of

T = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.75, 4.0])
TABLE = '[[force]]\ncoordinate = "a"\n{}\n[time]'

#: Two coordinates without mass: a = force/4, so that it jumps with the force; b' follows from b'' = force.
MASSLESS = MATRICES.replace("mass = [[1, 0], [0, 1]]", "mass = [[0, 0], [0, 1]]").replace("[[1, 0], [0, 4]]", "[[4, 0], [0, 0]]")


def force(folder, entry, text=MATRICES):
    return scene_of(folder, text.replace("[time]", TABLE.format(entry))).equations.force


SAMPLED = 'kind = "sampled"\ntimes = [1, "2000 ms", 4]\nvalues = ["1 N", 3, "1 N"]'
TERM = 'kind = "term"\nvalue = "2 N/s^2"\npower = 2\nrate = "-0.5 1/s"\nangular_frequency = 3\nphase = 0.1'


@pytest.mark.parametrize(
    ("entry", "function"),
    [  # closed forms as the schema states them
        ('kind = "step"\nvalue = "2 kN"\ndelay = "1 s"', lambda t: 2000.0 * (t >= 1)),
        ('kind = "ramp"\nvalue = "2 N/ms"\ndelay = "500 ms"', lambda t: 2000 * np.maximum(t - 0.5, 0)),
        ('kind = "power"\ngamma = 4\nvalue = "6 N/s^3"', lambda t: t**3),
        ('kind = "harmonic"\nvalue = 3\nfrequency = "1 Hz"\nphase = "90 deg"', lambda t: -3 * np.sin(2 * np.pi * t)),
        ('kind = "harmonic"\nvalue = 1\nangular_frequency = "60 rpm"\ndelay = 1', lambda t: np.cos(2 * np.pi * (t - 1)) * (t >= 1)),
        (TERM, lambda t: 2 * t**2 * np.exp(-0.5 * t) * np.cos(3 * t + 0.1)),
        ('kind = "pulse"\nvalue = "3 kN"\nstart = "1 s"\nduration = "1 s"', lambda t: 3000.0 * ((t >= 1) & (t < 2))),
        ('kind = "pulse"\nvalue = 3\nduration = 0.5\ndelay = 1', lambda t: 3.0 * ((t >= 1) & (t < 1.5))),
        (SAMPLED, lambda t: np.interp(t, [1, 2, 4], [1, 3, 1]) * ((t >= 1) & (t < 4))),
        ('kind = "sampled"\ntimes = [0, 1]\nvalues = [2, 2]\ndelay = 1', lambda t: 2.0 * ((t >= 1) & (t < 2))),
        ('kind = "sampled"\ntimes = [0, 1, 1, 2]\nvalues = [0, 1, 5, 5]', lambda t: np.where(t < 1, t, 5.0 * (t < 2))),
        ('kind = "step"\nvalue = 1\n[[force]]\ncoordinate = "a"\nkind = "ramp"\nvalue = 2', lambda t: 1 + 2 * t),  # they add up
    ],
)
def test_a_force_is_the_function_that_its_table_says(tmp_path, entry, function):
    own = force(tmp_path, entry)
    assert own(T) == pytest.approx(np.array([function(T), 0 * T]), rel=1e-14, abs=2e-14)
    assert not any(impulse.any() for impulse in own.impulses)


@pytest.mark.parametrize(
    ("entry", "order"),
    [
        ('kind = "impulse"\nvalue = "3000 N*ms"', 0),
        ('kind = "impulse"\nvalue = "3 N*s^2"\norder = 1', 1),
        ('kind = "power"\ngamma = -1\nvalue = "3 N*s^2"', 1),
    ],
)
def test_impulse_is_told_by_its_order(tmp_path, entry, order):
    own = force(tmp_path, entry)
    assert not own(T).any()
    assert [impulse.tolist() for impulse in own.impulses] == [[0, 0]] * order + [[pytest.approx(3), 0]]


def test_force_on_an_angle_is_a_torque(tmp_path):
    text = MATRICES.replace("[time]", '[model.units]\na = "rad"\n[time]')
    assert force(tmp_path, 'kind = "step"\nvalue = "2 Nm"', text)(1.0).tolist() == [2.0, 0.0]


@pytest.mark.parametrize(
    ("name", "column", "scale"), [("record.csv", "", 1.0), ("data/record.csv", "column = 3", 10.0), ("record.npz", "", 1.0)]
)
def test_a_record_is_read_from_a_file(tmp_path, name, column, scale):
    times = np.linspace(0.5, 3.5, 1000)
    table = np.column_stack([times, np.sin(times), 10 * np.sin(times)])
    (tmp_path / "data").mkdir()
    for place in ("record.csv", "data/record.csv"):
        np.savetxt(tmp_path / place, table, delimiter=",", header="time (s), force (N), ten times as much", fmt="%.17g")
    np.savez(tmp_path / "record.npz", table)
    found = force(tmp_path, f'kind = "sampled"\nfile = "{name}"\n{column}')
    assert found(T)[0] == pytest.approx(scale * np.interp(T, times, np.sin(times)) * ((T >= 0.5) & (T < 3.5)), rel=1e-13)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("0,1\n1,2\n0.5,3\n", r"record\.csv, line 3: 1 s is followed by 0\.5 s; times must ascend"),
        ("0,1\n", r"record\.csv: times: found 1; a record needs at least two samples"),
        ("0,1\n1e300,1\n", r"record\.csv, line 2: found 1e\+300 s and 1; expected 0 or a size between 1e-100 and 1e\+100"),
        ("# t, f\n0,1e-150\n1,1\n", r"record\.csv, line 2: found 0 s and 1e-150; expected 0 or a size between"),
    ],
)
def test_a_wrong_record_is_named_with_its_line(tmp_path, content, message):
    (tmp_path / "record.csv").write_text(content)
    with pytest.raises(SceneError, match=rf"force\[1\]: {message}"):
        force(tmp_path, 'kind = "sampled"\nfile = "record.csv"')


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ('kind = "step"\nvalue = 1\ndelay = -1', r"force\[1\]: delay: found -1 s; expected 0 or a later time"),
        ('kind = "step"\nvalue = 1\ndelay = "2 N"', r'force\[1\]\.delay: found "2 N", a force'),
        ('kind = "pulse"\nvalue = 1\nduration = 1e-20\ndelay = 2', r"force\[1\]: delay: 2 s would bring .* to one and the same"),
        ('kind = "pulse"\nvalue = 1\nduration = 0', r"force\[1\]: duration: found 0"),
        ('kind = "pulse"\nvalue = "1 m"\nduration = 1', r'force\[1\]: value: found "1 m", a length'),
        ('kind = "sampled"\nfile = "../record.csv"', r"force\[1\]: .*leads out of the folder"),
        ('kind = "sampled"\ntimes = [0, 1]', r"force\[1\]: give times and values, or file"),
        ('kind = "sampled"\ntimes = [0, 1]\nvalues = [1]', r"force\[1\]: found 2 times and 1 values"),
        ('kind = "sampled"\ntimes = [0, 1]\nvalues = [1, "2 m"]', r'force\[1\]: values\[2\]: found "2 m", a length'),
        ('kind = "sampled"\ntimes = [1, 0]\nvalues = [1, 2]', r"force\[1\]: times: 1 s is followed by 0 s"),
        ('kind = "sampled"\ntimes = [0, 1]\nvalues = [1, 2]\nfile = "a.csv"', r"force\[1\]: give either times and values or file"),
        ('kind = "sampled"\ntimes = [0, 1]\nvalues = [1, 2]\ncolumn = 3', r"force\[1\]: column: for a file only; leave out"),
        ('kind = "sampld"\nvalue = 1', r'force\[1\]: kind: found "sampld"; .*did you mean "sampled"'),
    ],
)
def test_wrong_tables_are_told(tmp_path, entry, message):
    with pytest.raises(SceneError, match=message):
        force(tmp_path, entry)


def events_scene(folder, points=5):
    entry = 'kind = "pulse"\nvalue = 8\nstart = 0.25\nduration = 0.5\n[[force]]\ncoordinate = "b"\nkind = "impulse"\nvalue = 3\ndelay = 0.5'
    return scene_of(folder, MASSLESS.replace("[time]", TABLE.format(entry)).replace("points = 5", f"points = {points}")).run()


def test_what_happens_later_has_a_table_and_one_sentence(tmp_path):
    summary = events_scene(tmp_path).summary()
    assert "Jumps and impulses after t = 0" in summary
    assert "note (jump): After t = 0 there are 3 jumps; the tables give the sizes" in summary
    for row in (
        "0.25 s  a   displacement jumps  0 m",
        "0.5 s   b   velocity jumps      0 m/s",
        "0.75 s  a   displacement jumps  2 m",
    ):
        assert row in summary
    assert "At t = 0 there" not in summary


def test_programs_get_all_of_them(tmp_path):
    result = events_scene(tmp_path)
    data = json.loads(json.dumps(result.to_dict()))
    assert [event["time"] for event in data["events"]] == [0.25, 0.5, 0.75]
    assert data["events"][0]["jump"] == [[2.0, 0.0], [0.0, 0.0]]
    with np.load(result.write_npz(tmp_path / "result.npz")) as arrays:
        assert arrays["event_times"].tolist() == [0.25, 0.5, 0.75]
        assert arrays["event_jumps"].shape == (3, 2, 2) and arrays["event_impulses"].shape == (3, 0, 2)


def test_the_curves_have_the_right_limits_at_events(tmp_path):
    result = events_scene(tmp_path)
    assert result.times.tolist() == [0, 0.25, 0.5, 0.75, 1]
    assert result.values == pytest.approx(np.array([[0, 2, 2, 0, 0], [0, 0, 0, 0.75, 1.5]]))
    lines = result.write_csv(tmp_path / "result.csv").read_text("utf-8").splitlines()
    assert [float(entry) for entry in lines[2].split(",")] == [0.25, 2.0, 0.0]


@pytest.mark.parametrize("steps", [True, False])
def test_of_thousands_the_first_are_listed_and_kinks_are_counted(tmp_path, steps):
    """A coordinate without mass follows a record: with steps it jumps 2000 times; else its rate does, and its value at the end alone."""
    times, values = np.linspace(0, 1, 2001), np.random.default_rng(0).normal(size=2001)
    if steps:  # each value lasts until the next time
        times, values = np.repeat(times, 2)[1:], np.repeat(values, 2)[:-1]
    np.savetxt(tmp_path / "record.csv", np.column_stack([times, values]), delimiter=",")
    result = scene_of(tmp_path, MASSLESS.replace("[time]", TABLE.format('kind = "sampled"\nfile = "record.csv"'))).run()
    summary = result.summary()
    assert len(summary.splitlines()) < 80
    assert ("The first 20 of" in summary) == steps
    assert ("at 1999 times" in " ".join(summary.split())) == (not steps)
    assert len(result.to_dict()["events"]) == len(result.motion.events) == 2000
    assert result.is_trusted


def test_coefficients_have_events_with_units(tmp_path):
    # q = force, an angle; the derivative of the force acts on nothing
    text = '[model]\nkind = "matrices"\ncoordinates = ["q"]\nunits = { q = "rad" }\ncoefficients = [[[1]], [[0]]]\n'
    text += '[[force]]\ncoordinate = "q"\nkind = "pulse"\nvalue = 2\nstart = 1\nduration = 1\n[time]\nend = 3\npoints = 7\n'
    notices = [notice.text for notice in scene_of(tmp_path, text).run().notices]
    assert notices[:2] == [
        "q: its angle jumps at t = 1 s by 2 rad, from 0 rad to 2 rad",
        "q: its angle jumps at t = 2 s by -2 rad, from 2 rad to 0 rad",
    ]


def test_the_results_of_a_scene_are_a_record_of_another(tmp_path):
    result = scene_of(tmp_path, OSCILLATOR).run()
    result.write_csv(tmp_path / "run.csv")
    entry = 'kind = "sampled"\nfile = "run.csv"\ncolumn = "cart displacement"\nfactor = "8 N/m"'
    values = force(tmp_path, entry)(result.times[:-1])[0]
    assert values.tolist() == (8 * result.values[0, :-1]).tolist()


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("", r"force\[1\]: a\.csv: the values are an acceleration \(m/s\^2\); expected N: give their unit, or a factor with"),
        ('factor = "2 m"', r"the values are another kind of quantity \(m/s\^2 times factor\); expected N"),
        ('factor = "=1"', r"force\[1\]: factor: found an expression of parameters"),
        ('unit = "Nm"', r"the values are a torque \(Nm\); expected N"),
        ('unit = "N"\noffset = "1 m"', r'offset: found "1 m", a length'),
        ('column = "b"', r'there is no column "b"'),
        ('time = "a"\ncolumn = 1', r"a\.csv, line 3: 2 m/s\^2 is followed|the unit of the time is"),
        ('step = "1 m"', r'force\[1\]: step: found "1 m"; a length belongs to a record over a distance: give speed'),
    ],
)
def test_units_of_a_record_are_checked(tmp_path, entry, message):
    (tmp_path / "a.csv").write_text("t (s), a (m/s^2)\n0, 2\n1, 1\n")
    with pytest.raises(SceneError, match=message):
        force(tmp_path, f'kind = "sampled"\nfile = "a.csv"\n{entry}')


def test_a_recorded_acceleration_times_mass_is_a_force(tmp_path):
    (tmp_path / "quake.AT2").write_text("PEER\nquake\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 3, DT= .5 SEC\n .1 -.2 .0\n")
    found = force(tmp_path, 'kind = "sampled"\nfile = "quake.AT2"\nfactor = "-2 t"\noffset = "1 kN"')
    assert found([0.0, 0.5])[0] == pytest.approx([1000 - 200 * 9.80665, 1000 + 400 * 9.80665], rel=1e-15)


#: Two masses with springs between them, and a load on both; its lines are filled in.
PATTERN = """
[model]
kind = "matrices"
coordinates = ["a", "b"]
mass = [[1, 0], [0, 1]]
damping = [[0.1, 0], [0, 0.05]]
stiffness = [[3, -1], [-1, 2]]
{}
[time]
end = 10
[frequency]
from = "0.05 Hz"
to = "0.5 Hz"
"""
ONE = '[[force]]\nfactors = {{ a = 1, b = -0.5 }}\nname = "both"\n{}\n'
TWO = '[[force]]\ncoordinate = "a"\n{0}\n[[force]]\ncoordinate = "b"\n{1}\n'
COSINE = 'kind = "harmonic"\nfrequency = "0.1 Hz"\nvalue = {}'


def test_a_load_on_several_coordinates_is_one_input(tmp_path):
    from mbconstrained.analyses.frequency import Frequency

    own = Frequency(scene_of(tmp_path, PATTERN.format(ONE.format(COSINE.format(2)))))
    parts = Frequency(scene_of(tmp_path, PATTERN.format(TWO.format(COSINE.format(2), COSINE.format(-1)))))
    assert own.response.inputs == ("both",) and parts.response.inputs == ("a", "b") and not own.notices
    assert "factors" in parts.notices[0].text
    lines = own.response.frequencies_hz
    M, C, K = np.eye(2), np.diag([0.1, 0.05]), np.array([[3.0, -1.0], [-1.0, 2.0]])
    for f, values in zip(lines, own.response.values[:, 0].T):
        s = 2j * np.pi * f
        assert values == pytest.approx(np.linalg.solve(M * s**2 + C * s + K, [1.0, -0.5]), rel=1e-12)
    each = parts.empty(lines).values
    assert own.response.values[:, 0] == pytest.approx(each[:, 0] - 0.5 * each[:, 1], rel=1e-11)  # the sum of complex responses
    largest = own.largest[0]
    dense = np.linspace(0.05, 0.5, 40001)
    assert largest.ravel() == pytest.approx(np.abs(own.empty(dense).values[:, 0]).max(axis=1), rel=1e-6)


def test_a_load_on_several_coordinates_moves_as_its_parts(tmp_path):
    own = scene_of(tmp_path, PATTERN.format(ONE.format(COSINE.format(2) + "\ndelay = 1"))).equations.solve()
    parts = PATTERN.format(TWO.format(COSINE.format(2) + "\ndelay = 1", COSINE.format(-1) + "\ndelay = 1"))
    assert own(T) == pytest.approx(scene_of(tmp_path, parts).equations.solve()(T), rel=1e-13)


def test_the_random_response_to_a_load_on_several_coordinates(tmp_path):
    from scipy.linalg import solve_continuous_lyapunov

    from mbconstrained.analyses.random import random_response

    text = PATTERN.format(ONE.format(COSINE.format(2))) + '[[random.input]]\non = "both"\nwhite = 4\n'
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.array([[3.0, -1.0], [-1.0, 2.0]]), -np.diag([0.1, 0.05])]])
    b = np.array([[0.0, 0.0, 1.0, -0.5]])
    covariance = solve_continuous_lyapunov(A, -(4 / 2) * b.T @ b)  # one-sided density by Hz: intensity G / 2
    assert random_response(scene_of(tmp_path, text)).rms == pytest.approx(np.sqrt(covariance.diagonal()[:2]), rel=1e-12)


@pytest.mark.parametrize(
    ("entry", "problem"),
    [
        ('factors = { a = 1, c = 1 }\nkind = "step"\nvalue = 1', 'no coordinate "c"'),
        ('kind = "step"\nvalue = 1', "either coordinate or factors"),
        ('coordinate = "a"\nfactors = { b = 1 }\nkind = "step"\nvalue = 1', "either coordinate or factors"),
        ('coordinate = "a"\nname = "load"\nkind = "step"\nvalue = 1', "name is that of a load by factors"),
        ('factors = { a = 1 }\nname = "b"\nkind = "step"\nvalue = 1', '"b" is the name of a coordinate'),
        ('factors = { a = 1, q = 1 }\nkind = "step"\nvalue = 1', "have the units m and rad"),
    ],
)
def test_wrong_loads_on_several_coordinates(tmp_path, entry, problem):
    text = PATTERN.format(f"[[force]]\n{entry}\n")
    if "q = 1" in entry:
        text = text.replace('["a", "b"]', '["a", "q"]\nunits = { q = "rad" }')
    with pytest.raises(SceneError, match=problem):
        scene_of(tmp_path, text)


def test_a_load_on_several_inputs_of_a_state_space(tmp_path):
    text = """
[model]
kind = "state-space"
A = [[-1]]
B = [[1, 2]]
inputs = ["u", "v"]
{}
[time]
end = 1
"""
    both = scene_of(tmp_path, text.format('[[force]]\nfactors = { u = 3, v = -1 }\nkind = "step"\nvalue = 2')).equations
    assert both.solve()(T)[0] == pytest.approx(2 * (3 - 2) * (1 - np.exp(-T)), rel=1e-13, abs=1e-15)
