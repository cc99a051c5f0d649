"""Scenes with contacts, friction and other switches: the motion through all phases with its events, in every form of the answer."""

import json

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.errors import InputError, SceneError
from mbconstrained.ground.notices import NoticeKind
from tests.scene.scenes import scene_of

DROP = """
[model]
kind = "lumped"
gravity = -9.81
[[model.mass]]
name = "ball"
mass = "2 kg"
[[model.contact]]
name = "floor"
start = "ground"
end = "ball"
gap = "10 mm"
restitution = 0.5
[initial]
displacement = { ball = 1.0 }
[time]
end = "5 s"
points = 51
[output]
plots = ["displacement", "velocity", "energy", "reaction"]
units = "mm"
"""

#: Of the fall to -10 mm.
SPEED = np.sqrt(2 * 9.81 * 1.01)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("drop")


@pytest.fixture(scope="module")
def drop(folder):
    return scene_of(folder, DROP).run(folder)


def test_the_run_of_a_scene_is_the_motion_of_its_switched_system(drop):
    model = mb.LumpedModel()
    model.mass("ball", 2.0)
    model.gravity(-9.81)
    model.contact("ground", "ball", gap=0.01, restitution=0.5, name="floor")
    x = model.assemble().solve({"ball": 1.0}, end=5.0)
    assert np.array_equal(drop.values, x(drop.times))
    assert [event.time for event in drop.motion.events] == [event.time for event in x.events]


def test_an_impact_takes_the_impulse_and_the_energy_of_its_law(drop):
    first = drop.to_dict()["events"][0]
    assert first["time"] == pytest.approx(SPEED / 9.81, rel=1e-14)
    assert first["impulses"]["floor"] == pytest.approx(2 * 1.5 * SPEED, rel=1e-14)
    assert first["energy_lost"] == pytest.approx(0.75 * SPEED**2, rel=1e-13)
    assert first["jump"][1] == pytest.approx([1.5 * SPEED], rel=1e-14)
    assert (first["before"], first["after"], first["text"]) == ("open", "open", "floor impact")
    assert 0 < first["time_error"] < 1e-14


def test_at_rest_the_contact_carries_the_weight(drop):
    """Bounces add up to 3 flights of e = 1/2: it rests at t = 3 v / g."""
    last = drop.motion.events[-1]
    assert last.rest_time == pytest.approx(3 * SPEED / 9.81, rel=1e-13) and last.after == "closed"
    rows = drop.curves("reaction")
    assert rows.names == ("floor",)
    assert rows.values[0, drop.times > last.time] == pytest.approx(2 * 9.81, rel=1e-13)
    assert not rows.values[0, drop.times < last.time].any()


def test_events_are_printed_in_the_units_of_the_output_and_stored_whole(drop, folder):
    table = next(table for table in drop.tables if table.title == "Events")
    assert len(table.rows) == len(drop.motion.events)
    assert drop.largest[0].value == 1.0 and "1000 mm" in drop.summary()
    with np.load(folder / "scene.npz") as arrays:
        assert arrays["event_times"].tolist() == [event.time for event in drop.motion.events]
        assert arrays["phases"].tolist() == ["open", "closed"]
    assert json.loads(json.dumps(drop.to_dict()))["trusted"]


def test_run_shows_the_first_events_on_one_screen_and_check_is_silent(command, tmp_path):
    scene_of(tmp_path, DROP + "page = false\n")
    code, text, _ = command("run", "scene.toml")
    assert code == 0 and "Events" in text and "floor impact" in text and len(text.splitlines()) <= 24
    code, text, _ = command("check", "scene.toml")
    assert code == 0 and text.startswith("scene.toml is fine: scene") and "note" not in text


def test_nothing_is_reported_twice(drop):
    """The table of events has the impulses, that of jumps the velocities: below them is one sentence with their number."""
    texts = [notice.text for notice in drop.table_notices if notice.kind != NoticeKind.STATIC_LOAD]
    count = sum(np.count_nonzero(event.jump) for event in drop.motion.events)
    assert texts == [f"After t = 0 there are {count} jumps; the tables give the sizes"]
    jumps = next(table for table in drop.tables if table.title == "Jumps and impulses after t = 0")
    assert {row[2] for row in jumps.rows} == {"velocity jumps"}
    assert not [table for table in drop.tables if "at t = 0" in table.title]


def test_the_plan_has_a_stage_for_switches_where_there_are_some(tmp_path):
    stages = {stage.name: stage for stage in scene_of(tmp_path, DROP).plan().stages}
    assert stages["switches"].needed and "1 switch (floor)" in stages["switches"].reason
    assert not stages["scaling and staircase"].needed and not stages["proof"].needed
    without = DROP.split("[[model.contact]]")[0] + DROP[DROP.index("[initial]") :].replace(', "reaction"', "")
    stages = {stage.name: stage for stage in scene_of(tmp_path, without).plan().stages}
    assert not stages["switches"].needed and "no contacts" in stages["switches"].reason


PENETRATED = DROP.replace("ball = 1.0", "ball = -0.11")


def test_a_start_in_penetration_is_refused_with_the_impulse_that_it_would_cause(tmp_path):
    with pytest.raises(SceneError, match=r"scene.toml: initial: floor: .* penetrated by 0.1 m.* impulse of 0.2 N s\^2"):
        scene_of(tmp_path, PENETRATED)


def test_an_accepted_penetration_is_a_jump_with_an_impulse_of_the_contact(tmp_path):
    x = scene_of(tmp_path, PENETRATED.replace("[initial]", "[initial]\npenetration = true")).run()
    assert x.motion.jump[0] == pytest.approx([0.1], rel=1e-14)
    assert [jump.size for jump in x.jumps] == ["100 mm"]
    first = x.motion.events[0]
    assert first.time == 0 and first.higher_impulses["floor"] == pytest.approx((0.2,), rel=1e-14)
    assert "floor 0.2 N s^2" in "".join(next(table for table in x.tables if table.title == "Events").rows[0])


def test_a_start_at_rest_on_a_contact_is_no_event(tmp_path):
    x = scene_of(tmp_path, DROP.replace("ball = 1.0", "ball = -0.01")).run()
    assert not x.motion.events and not x.jumps and x.motion.phases == ((0.0, "closed"),)
    assert {notice.kind for notice in x.notices} == {NoticeKind.STATIC_LOAD, NoticeKind.AT_REST}


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ("[output]\nformula = true", "output.formula"),
        ("[output]\ncertify = true", "output.certify"),
        ("[least_energy]\nduration = 1\n[output]", "least_energy"),
        ('[[force]]\ncoordinate = "ball"\nkind = "step"\nvalue = 1\nshaper = { kind = "ZV" }\n[output]', "force"),
    ],
)
def test_what_belongs_to_one_phase_is_refused_by_name(tmp_path, change, place):
    text = DROP.replace('"2 kg"\n', '"2 kg"\n[[model.spring]]\nbetween = ["ground", "ball"]\nstiffness = 100\n')
    with pytest.raises(SceneError, match=rf"scene.toml: {place}"):
        scene_of(tmp_path, text.replace("[output]", change))


def test_boundary_values_and_certificates_on_request_are_refused(tmp_path):
    boundary = DROP.replace(
        "[initial]\ndisplacement = { ball = 1.0 }", "[boundary]\nduration = 1\nend = { displacement = { ball = 0 } }"
    )
    with pytest.raises(SceneError, match=r"scene.toml: boundary: "):
        scene_of(tmp_path, boundary)
    with pytest.raises(SceneError, match=r"output.certify: exact arithmetic"):
        scene_of(tmp_path, DROP).certified()


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ('contact = [{ start = "ground", end = "ball", gap = "-1 mm" }]', "negative|positive"),
        ('contact = [{ start = "ground", end = "ball", restitution = 1.5 }]', r"0 \(no rebound\) to 1"),
        ('contact = [{ start = "ground", end = "bal" }]', 'did you mean "ball"'),
        ('contact = [{ start = "ground", end = "ball", gap = "1 N" }]', "gap"),
        ('contacts = [{ start = "ground", end = "ball" }]', 'did you mean "contact"'),
        (
            'dry_friction = [{ start = "ground", end = "ball", normal_force = "1 kN", coefficent = 0.1 }]',
            'did you mean "coefficient"',
        ),
        ('release = [{ target = "flor", at = 1 }]', "flor"),
    ],
)
def test_wrong_entries_are_refused_in_the_words_of_the_scene(tmp_path, entry, message):
    with pytest.raises((SceneError, InputError), match=message):
        scene_of(tmp_path, DROP[: DROP.index("[[model.contact]]")].replace("gravity", f"{entry}\ngravity") + "[time]\nend = 1\n")


def test_sweeps_keep_peaks_impulses_and_the_times_of_events(tmp_path):
    """The ball falls from h + 10 mm: t = sqrt(2 h / g), p = m (1 + e) sqrt(2 g h)."""
    text = DROP.replace("ball = 1.0", 'ball = "=h"').replace("[model]", "[parameters]\nh = 1.0\n[model]", 1)
    keep = ["time of event 1", "time of event last", "largest impulse of floor", "number of events", "largest velocity of ball"]
    samples = scene_of(tmp_path, text).sweep({"h": [0.5, 1.0, 1.5]}, keep=keep).run()
    height = np.array([0.5, 1.0, 1.5]) + 0.01
    assert samples.values("time of event 1") == pytest.approx(np.sqrt(2 * height / 9.81), rel=1e-13)
    assert samples.values("time of event last") == pytest.approx(3 * np.sqrt(2 * height / 9.81), rel=1e-12)
    assert samples.values("largest impulse of floor") == pytest.approx(3 * np.sqrt(2 * 9.81 * height), rel=1e-13)
    assert samples.values("largest velocity of ball") == pytest.approx(np.sqrt(2 * 9.81 * height), rel=1e-13)
    assert (samples.values("number of events") > 20).all()


def test_a_sample_without_an_event_has_no_time_of_it_and_one_in_penetration_no_answer(tmp_path):
    text = (
        DROP.replace("ball = 1.0", 'ball = "=h"')
        .replace("[model]", "[parameters]\nh = 1.0\n[model]", 1)
        .replace('"5 s"', '"0.3 s"')
    )
    samples = scene_of(tmp_path, text).sweep({"h": [-0.5, 0.1, 1.0]}, keep=["time of event 1", "number of events"]).run()
    assert np.isnan(samples.values("time of event 1")).tolist() == [True, False, True]
    assert np.isnan(samples.values("number of events")).tolist() == [True, False, False]


def test_figures_of_events_need_switches(tmp_path):
    without = DROP.split("[[model.contact]]")[0] + DROP[DROP.index("[initial]") :].replace(', "reaction"', "")
    text = without.replace("ball = 1.0", 'ball = "=h"').replace("[model]", "[parameters]\nh = 1.0\n[model]", 1)
    with pytest.raises(InputError, match="no contacts"):
        scene_of(tmp_path, text).sweep({"h": [0.5, 1.0]}, keep=["number of events"])


MANY = """
[model]
kind = "lumped"
gravity = -9.81
mass = [{ name = "a", mass = 1.0 }, { name = "b", mass = 2.0 }]
spring = [{ between = ["ground", "a"], stiffness = 300 }, { name = "tie", between = ["a", "b"], stiffness = 200 }]
damper = [{ between = ["a", "b"], damping = 1.0 }]
contact = [{ name = "stop", start = "ground", end = "b", gap = "60 mm", stiffness = "20 kN/m", damping = "5 N s/m" }]
dry_friction = [{ name = "wall", start = "ground", end = "a", normal_force = "10 N", coefficient = 0.4, static_coefficient = 0.6 }]
release = [{ target = "tie", at = "0.8 s" }]
[[force]]
coordinate = "a"
kind = "harmonic"
frequency = "3 Hz"
value = "6 N"
[time]
end = "2 s"
points = 201
[output]
page = false
plots = ["reaction"]
"""


def test_the_forces_of_all_switches_balance_the_motion(tmp_path):
    """M x'' + C x' + K x - f is the sum of the reactions along their rows, stuck or sliding, open or closed."""
    x = scene_of(tmp_path, MANY).run()
    motion, system = x.motion, x.motion.system
    assert {one.text for one in motion.events} >= {"wall slips", "wall sticks", "stop closes", "tie is released"}
    assert {row.name for row in x.rows} == {"wall", "stop", "tie"}
    times = x.times
    inertia = system.mass @ motion.acceleration(times) + system.damping @ motion.velocity(times) + system.stiffness @ motion(times)
    forces = np.array([row.coefficients for row in x.rows]).T @ motion.reaction(times)
    assert inertia - motion.applied(times) - forces == pytest.approx(np.zeros_like(forces), abs=1e-10)
    wall = dict(zip([row.name for row in x.rows], motion.reaction(times)))["wall"]
    assert np.isclose(np.abs(wall), 4.0, rtol=1e-12).sum() > 9 and np.abs(wall).max() < 6.0 + 1e-12
    assert [row["name"] for row in x.to_dict()["constraints"]] == ["wall"]
    assert x.error_estimates["reaction"] < 1e-9
