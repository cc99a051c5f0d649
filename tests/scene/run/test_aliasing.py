"""Times that are too far apart for the motion are told, with its period and what to write instead."""

import re

import numpy as np
import pytest

from mbconstrained.scene.run.result import SMOOTH, aliasing_notices
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import SLOW_AND_FAST

STEP = '[[force]]\ncoordinate = "fast"\nkind = "step"\nvalue = 1e4\ndelay = 80\n'


def told(folder, slow=1.0, fast=1.0, damping=0.0, amplitude=1.0, end=10.0, points=101, force=""):
    path = folder / "scene.toml"
    damper = f'[[model.damper]]\nbetween = ["ground", "fast"]\ndamping = {damping}' if damping else ""
    text = SLOW_AND_FAST.format(slow=slow, fast=fast, damper=damper, amplitude=amplitude, end=end, points=points, force=force)
    path.write_text(text)
    result = read_scene(path).run()
    texts = [notice.text for notice in result.notices if notice.kind == "aliasing"]
    assert texts == [notice.text for notice in aliasing_notices(result.scene, result.motion, len(result.times))] and len(texts) <= 1
    return "".join(texts)


@pytest.mark.parametrize(("end", "points"), [(1e9, 1000), (1e4, 1001), (500.0, 101)])
def test_an_oscillation_between_the_times_is_told_with_its_period(tmp_path, end, points):
    text = told(tmp_path, fast=(2 * np.pi * 1.6) ** 2, end=end, points=points)
    assert "has a period of 0.625 s" in text and f"{end / (points - 1):.3g} s apart" in text


def test_what_is_written_instead_shows_it(tmp_path):
    """More points, and an earlier end only where there may not be so many."""
    for end, found in ((500.0, r"write points = (?P<points>\d+) below"), (1e9, r'write end = "(?P<end>.*) s" below')):
        given = {"fast": 100.0, "end": end, "points": 101}
        text = told(tmp_path, **given)
        step = given | {key: float(value) for key, value in re.search(found, text).groupdict().items()}
        step["points"] = int(step["points"])
        assert 2 * np.pi / 10.0 / (step["end"] / (step["points"] - 1)) == pytest.approx(SMOOTH, rel=0.05)
        assert told(tmp_path, **step) == "" and "the values at the times are right" in text


def test_one_that_is_met_once_in_a_period_and_seems_to_rest_is_told(tmp_path):
    text = told(tmp_path, slow=(2 * np.pi) ** 2, fast=(2 * np.pi) ** 2, end=100.0, points=101)
    assert "has a period of 1 s" in text


@pytest.mark.parametrize(
    "given",
    [
        {"fast": 100.0, "amplitude": 1e-3},  # too small to be seen
        {"fast": 1e4, "damping": 2.0},  # decayed
        {"fast": 1e4, "damping": 2.0, "force": STEP},  # after the force as well
        {"fast": 1e6, "damping": 1e5},  # no oscillation at all
        {"fast": 1e6, "amplitude": 0.0},  # at rest
        {"fast": 1.0, "end": 100.0, "points": 52},  # more than three times in a period
    ],
)
def test_nothing_is_told_of_what_is_not_seen_or_not_missed(tmp_path, given):
    assert told(tmp_path, **{"end": 100.0, "points": 101, "slow": 0.01, **given}) == ""


def test_the_fastest_that_is_seen_counts_and_not_the_fastest_of_all(tmp_path):
    text = told(tmp_path, slow=100.0, fast=1e6, amplitude=1e-4, end=1e4)
    assert "has a period of 0.628 s" in text


@pytest.mark.parametrize(
    ("given", "damping"),
    [
        ({}, 0.6),  # down to a hundredth after 15 of 100 spacings of times
        ({"amplitude": 0.0, "force": STEP}, 0.6),
        ({"amplitude": 0.0, "force": STEP}, 0.0),  # after three quarters of the time, and for good
        ({"amplitude": 0.0, "force": STEP.replace("step", "pulse").replace("delay", "duration = 12\nstart")}, 0.6),
    ],
)
def test_what_begins_late_or_decays_is_told_where_it_leaves_false_points(tmp_path, given, damping):
    text = told(tmp_path, slow=0.01, fast=1e4, damping=damping, end=100.0, points=101, **given)
    assert f"has a period of {2 * np.pi / 100:.3g} s" in text


def test_of_a_record_only_what_it_leaves_behind_is_looked_at(tmp_path):
    """Between its samples there is no time for an oscillation to be seen."""
    times = np.linspace(0.0, 60.0, 301)
    record = f'[[force]]\ncoordinate = "fast"\nkind = "sampled"\ntimes = {times.tolist()}\nvalues = {np.cos(5 * times).tolist()}\n'
    given = {"slow": 0.01, "fast": 1e2, "end": 100.0, "points": 101, "amplitude": 0.0, "force": record}
    assert "has a period of 0.628 s" in told(tmp_path, **given)
    assert "aliasing" not in told(tmp_path, **given, damping=4.0)


NODE = """
[[model.node]]
name = "light"
[[model.spring]]
between = ["ground", "light"]
stiffness = 1
[[model.damper]]
between = ["ground", "light"]
damping = 1
[[force]]
coordinate = "light"
kind = "step"
value = 5
delay = 77
"""


@pytest.mark.parametrize("delay", [75.5, 77.0])
def test_a_kink_is_no_oscillation(tmp_path, delay):
    """Cosines of any frequency fit a kink a little, in a stretch of time in which there is one."""
    force = NODE.replace("77", str(delay))
    assert told(tmp_path, slow=1e-4, fast=50.0, amplitude=0.0, end=100.0, points=101, force=force) == ""
