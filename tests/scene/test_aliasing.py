"""Times that are too far apart for the motion are told, with its period and what to write instead."""

import re

import numpy as np
import pytest

from mbconstrained.scene.aliasing import SMOOTH, aliasing_notices
from mbconstrained.scene.scene import read_scene

SCENE = """
[model]
kind = "lumped"
[[model.mass]]
name = "slow"
mass = 1
[[model.mass]]
name = "fast"
mass = 1
[[model.spring]]
between = ["ground", "slow"]
stiffness = {slow}
[[model.spring]]
between = ["ground", "fast"]
stiffness = {fast}
{damper}
[initial]
displacement = {{ slow = 1, fast = {amplitude} }}
{force}
[time]
end = {end}
points = {points}
"""
FORCE = '[[force]]\ncoordinate = "slow"\nkind = "harmonic"\nvalue = 1e6\nangular_frequency = 1000\n'


def told(folder, slow=1.0, fast=1.0, damping=0.0, amplitude=1.0, end=10.0, points=101, force=""):
    path = folder / "scene.toml"
    damper = f'[[model.damper]]\nbetween = ["ground", "fast"]\ndamping = {damping}' if damping else ""
    text = SCENE.format(slow=slow, fast=fast, damper=damper, amplitude=amplitude, end=end, points=points, force=force)
    path.write_text(text)
    result = read_scene(path).run()
    texts = [notice.text for notice in result.notices if notice.kind == "aliased"]
    assert texts == [notice.text for notice in aliasing_notices(result)] and len(texts) <= 1
    return "".join(texts)


@pytest.mark.parametrize(("end", "points"), [(1e9, 1000), (1e4, 1001), (500.0, 101)])
def test_an_oscillation_between_the_times_is_told_with_its_period(tmp_path, end, points):
    text = told(tmp_path, fast=(2 * np.pi * 1.6) ** 2, end=end, points=points)
    assert "has a period of 0.625 s" in text and f"{end / (points - 1):.3g} s apart" in text


def test_what_is_written_instead_shows_it(tmp_path):
    given = {"fast": 100.0, "end": 500.0, "points": 101}
    text = told(tmp_path, **given)
    end, points = re.search(r'end = "(.*) s" or points = (\d+)', text).groups()
    period = 2 * np.pi / 10.0
    for time in ({"end": float(end)}, {"points": int(points)}):
        step = {**given, **time}
        assert period / (step["end"] / (step["points"] - 1)) == pytest.approx(SMOOTH, rel=0.05)
        assert told(tmp_path, **step) == ""
    assert "points = " not in told(tmp_path, fast=100.0, end=1e9).replace("or points", "points").split("write")[1]


def test_one_that_is_met_once_in_a_period_and_seems_to_rest_is_told(tmp_path):
    text = told(tmp_path, slow=(2 * np.pi) ** 2, fast=(2 * np.pi) ** 2, end=100.0, points=101)
    assert "has a period of 1 s" in text


@pytest.mark.parametrize(
    "given",
    [
        {"fast": 100.0, "amplitude": 1e-3},  # too small to be seen
        {"fast": 1e4, "damping": 2.0},  # decayed
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


def test_forces_count_too(tmp_path):
    assert "has a period of 0.00628 s" in told(tmp_path, force=FORCE)
