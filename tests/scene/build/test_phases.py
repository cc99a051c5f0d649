"""Scenes of matrices with phases and transitions, and the phase for which linear analyses answer."""

import numpy as np
import pytest

from mbconstrained.cli import application
from mbconstrained.ground.errors import SceneError
from mbconstrained.ground.notices import NoticeKind
from mbconstrained.scene.run.result import start_notices
from tests.scene.scenes import scene_of

#: C1 v1' + i = 0, C2 v2' + G v2 - i = 0, and i = 0 or v1 = v2: a switch that closes a loop of capacitors.
CIRCUIT = """
[model]
kind = "matrices"
coordinates = ["v1", "v2", "i"]
units = { v1 = "1", v2 = "1", i = "1" }
mass = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]
damping = [[2e-6, 0, 0], [0, 1e-6, 0], [0, 0, 0]]
stiffness = [[0, 0, 1], [0, 1e-3, -1], [0, 0, 1]]
[[model.phase]]
name = "open"
[[model.phase]]
name = "closed"
stiffness = [[0, 0, 1], [0, 1e-3, -1], [1, -1, 0]]
[[model.transition]]
from = "open"
to = "closed"
when = { v2 = 1 }
below = 0.5
[initial]
displacement = { v1 = 10, v2 = 1 }
[time]
end = "5 ms"
points = 21
[output]
page = false
"""


def test_a_loop_of_capacitors_keeps_the_charge_and_takes_an_impulse_of_current(tmp_path):
    """v2 = e^(-1000 t) falls to 1/2 at ln 2 ms; then (C1 + C2) v' + G v = 0 from the common voltage of the charge C1 10 + C2 / 2."""
    x = scene_of(tmp_path, CIRCUIT).run()
    (event,) = x.motion.events
    assert event.time == pytest.approx(np.log(2) * 1e-3, rel=1e-14)
    common = (2 * 10 + 0.5) / 3
    assert event.jump[0, :2] == pytest.approx([common - 10, common - 0.5], rel=1e-12)
    assert event.coordinate_impulses[0] == pytest.approx([0, 0, 2e-6 * (10 - common)], rel=1e-12)
    late = x.times > event.time
    assert x.values[0, late] == pytest.approx(common * np.exp(-1e3 / 3 * (x.times[late] - event.time)), rel=1e-12)
    (row,) = next(table for table in x.tables if table.title == "Events").rows
    assert row[2:] == ("to closed", "closed")  # unsymmetric matrices have no energy
    later = next(table for table in x.tables if "after t = 0" in table.title)
    assert ("i", "multiplies δ") in [row[1:3] for row in later.rows]


#: A mass on a spring that a stop holds once it is beyond 20 mm, until the stop would have to pull.
STOPPED = """
[model]
kind = "matrices"
mass = [["1 kg"]]
stiffness = [["100 N/m"]]
linear_phase = "held"
[[model.phase]]
name = "free"
[[model.phase]]
name = "held"
[[model.phase.constraint]]
name = "stop"
rows = { x1 = 1 }
value = "20 mm"
[[model.transition]]
from = "free"
to = "held"
when = { x1 = 1 }
above = "20 mm"
restitution = 0.5
[[model.transition]]
from = "held"
to = "free"
when = { stop = 1 }
above = 0
[[force]]
coordinate = "x1"
kind = "step"
value = "3 N"
[time]
end = "20 s"
points = 11
"""


def test_a_transition_with_restitution_strikes_until_it_rests(tmp_path):
    x = scene_of(tmp_path, STOPPED + "[output]\npage = false\nplots = ['reaction']").run()
    first, last = x.motion.events[0], x.motion.events[-1]
    speed = np.sqrt(2 * 3 * 0.02 - 100 * 0.02**2)
    assert first.impulses["stop"] == pytest.approx(-1.5 * speed, rel=1e-12) and first.after == "free"
    assert first.momentum_residual < 1e-14
    assert last.after == "held" and last.rest_time is not None
    assert x.curves("reaction").values[0, -1] == pytest.approx(2 - 3, rel=1e-12)


def test_linear_analyses_answer_for_the_named_phase_and_say_so(tmp_path):
    scene = scene_of(tmp_path, STOPPED)
    assert scene.modes().data["modes"] == []
    assert any("phase held" in notice.text for notice in scene.modes().notices)
    free = scene_of(tmp_path, STOPPED.replace('linear_phase = "held"', ""))
    modes = free.modes()
    assert [mode["angular_frequency"] for mode in modes.data["modes"]] == pytest.approx([10.0])
    assert any("phase free (at the start), as if nothing switched" in notice.text for notice in modes.notices)
    assert modes.to_dict()["notices"]


@pytest.mark.parametrize("command", ["formula", "stability"])
def test_analyses_of_one_closed_form_refuse_by_name(tmp_path, command, capsys):
    (tmp_path / "scene.toml").write_text(STOPPED)
    with pytest.raises(SystemExit) as end:
        application()([command, str(tmp_path / "scene.toml")], prog_name="mbconstrained")
    assert end.value.code == 1 and f"{command}: not available for models that switch" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("found", "instead", "message"),
    [
        ('to = "held"', 'to = "hold"', r"transition\[1\].to: there is no phase \"hold\"; did you mean \"held\""),
        ("when = { x1 = 1 }", "when = { x2 = 1 }", r"transition\[1\].*no coordinate \"x2\""),
        ('above = "20 mm"', 'above = "20 N"', r"transition\[1\].above"),
        ("restitution = 0.5", "restitution = 1.5", r"transition\[1\].restitution"),
        ("above = 0\n", "above = 0\nbelow = 1\n", r"transition\[2\].*above= or below="),
        ('[[model.phase]]\nname = "held"', '[[model.phase]]\nname = "free"', "used twice"),
        ('linear_phase = "held"', 'linear_phase = "hold"', r"linear_phase.*did you mean \"held\""),
        ('linear_phase = "held"', 'start = "hold"', r"model.start.*did you mean \"held\""),
        ('[[model.phase]]\nname = "held"', '[[model.phase]]\nname = "held"\nmass = [[1, 0], [0, 1]]', r"phase\[2\].*mass|shape"),
        ('[[model.phase]]\nname = "held"', '[[model.phase]]\nname = "held"\nmass = [["1 N"]]', r"phase\[2\].*mass\[1\]\[1\]"),
        ("[[force]]", "[[model.contact]]\n[[force]]", r"\[\[model.phase\]\] and \[\[model.transition\]\]"),
    ],
)
def test_wrong_phases_are_refused_with_their_place(tmp_path, found, instead, message):
    assert found in STOPPED
    with pytest.raises(SceneError, match=message):
        scene_of(tmp_path, STOPPED.replace(found, instead, 1))


def test_transitions_without_phases_are_refused(tmp_path):
    text = STOPPED[: STOPPED.index("[[model.phase]]")] + "[time]\nend = 1\n"
    with pytest.raises(SceneError, match="linear_phase belongs to equations with phases"):
        scene_of(tmp_path, text)


def never(scene) -> list[str]:
    return [notice.text for notice in scene.notices if notice.kind in (NoticeKind.SWITCH, NoticeKind.OMITTED)]


def test_nothing_is_said_of_phases_that_can_be_entered_and_left(tmp_path):
    scene = scene_of(tmp_path, STOPPED)
    assert not never(scene) and not start_notices(scene.equations)


LOST = """
[[model.phase]]
name = "lost"
[[model.transition]]
from = "held"
to = "lost"
when = { x1 = 2 }
above = "{} mm"
[[force]]
"""


def test_a_guard_that_rows_keep_constant_below_its_limit_is_never_reached(tmp_path):
    unreached = scene_of(tmp_path, STOPPED.replace("[[force]]", LOST.replace("{}", "40.001"), 1))
    assert never(unreached) == [
        'the transition from "held" to "lost" never takes place: the rows of "held" keep its output constant',
        'the phase "lost" is never entered: no transition that can take place leads to it',
    ]
    reached = scene_of(tmp_path, STOPPED.replace("[[force]]", LOST.replace("{}", "39.999"), 1))
    assert not never(reached)
    assert [notice.text for notice in start_notices(reached.equations)] == ['nothing leaves the phase "lost"']


def test_a_transition_after_the_end_is_named(tmp_path):
    late = STOPPED.replace('when = { x1 = 1 }\nabove = "20 mm"\nrestitution = 0.5', 'at = "21 s"')
    assert never(scene_of(tmp_path, late)) == [
        'transition to "held": at 21 s, after the last time, 20 s',
        'the phase "held" is never entered: no transition that can take place leads to it',
    ]


def test_a_contact_between_bodies_that_a_row_joins_never_closes(tmp_path):
    text = """
[model]
kind = "lumped"
mass = [{ name = "a", mass = 1 }, { name = "b", mass = 1 }]
contact = [{ name = "stop", start = "a", end = "b", gap = "1 mm" }]
clutch = [{ name = "late", start = "ground", end = "a", engaged = "3 s" }]
constraint = [{ coefficients = { a = 1, b = -1 }, value = 0 }]
[initial]
velocity = { a = 1, b = 1 }
[time]
end = 2
"""
    joined = never(scene_of(tmp_path, text))
    assert joined == [
        "late engages: at 3 s, after the last time, 2 s",
        'stop remains in the state "open": the constraint rows keep its bodies at one distance',
    ]
    assert never(scene_of(tmp_path, text.replace("b = -1", "b = -2").replace("b = 1 }\n[time]", "b = 0.5 }\n[time]"))) == joined[:1]
