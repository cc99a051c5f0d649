"""The commands for a scene with a contact."""

import json
from pathlib import Path

import numpy as np
import pytest

SCENE = """
title = "A drop"
[model]
kind = "lumped"
gravity = -9.81
[[model.mass]]
name = "ball"
mass = "1 kg"
[[model.contact]]
name = "floor"
start = "ground"
end = "ball"
restitution = 0.5
[initial]
displacement = { ball = "1 m" }
[time]
end = "2 s"
[output]
page = false
"""


@pytest.fixture
def drop(command):
    Path("drop.toml").write_text(SCENE)
    return lambda name, *options: command(name, "drop.toml", *options)


def test_check_is_silent_where_nothing_is_wrong(drop):
    code, text, _ = drop("check")
    assert code == 0 and text.splitlines()[0] == "drop.toml is fine: A drop" and "note" not in text


def test_check_refuses_penetration_with_its_place(drop):
    code, _, error = drop("check", "--set", "initial.displacement.ball=-0.1")
    assert code == 1 and "initial: floor: at the start it is penetrated by 0.1 m" in error and "penetration = true" in error
    assert drop("check", "--set", "initial.displacement.ball=-0.1", "--set", "initial.penetration=true")[0] == 0


def test_the_plan_names_the_switches(drop):
    stages = {stage["name"]: stage for stage in json.loads(drop("plan", "--json")[1])["plan"]}
    assert stages["switches"]["taken"] and "1 switch (floor)" in stages["switches"]["reason"]


def test_run_shows_the_first_events_on_one_screen_and_all_as_data(drop):
    code, text, _ = drop("run", "--out", "out")
    assert code == 0 and "Events" in text and "floor impact" in text and len(text.splitlines()) <= 24
    data = json.loads(drop("run", "--out", "out", "--json")[1])
    first, last = data["events"][0], data["events"][-1]
    assert first["time"] == pytest.approx(np.sqrt(2 / 9.81), rel=1e-14) and first["impulses"].keys() == {"floor"}
    assert last["after"] == "closed" and last["rest_time"] == pytest.approx(3 * np.sqrt(2 / 9.81), rel=1e-12)
    rows = Path("out/drop.csv").read_text().splitlines()
    assert rows[0] == "time (s),ball displacement (m)" and len(rows) == 402


def test_modes_name_their_phase(drop):
    code, text, _ = drop("modes", "--set", "model.linear_phase=closed")
    assert code == 0 and "of the phase closed, as if nothing switched" in " ".join(text.split())
    code, _, error = drop("modes", "--set", "model.linear_phase=close")
    assert code == 1 and 'did you mean "closed"' in error


def test_certificates_are_refused_by_name(drop):
    code, _, error = drop("run", "--certify", "--out", "out")
    assert code == 1 and "output.certify: exact arithmetic does not follow" in error and not Path("out").exists()
