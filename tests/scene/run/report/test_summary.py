"""The short summary fills a screen at most, and no line of a text or table is wider than a terminal."""

import re

import pytest

import mbconstrained as mb
from mbconstrained.analyses.motion_report import eigenvalue_table, frequency_table
from mbconstrained.analyses.run import SCREEN, _printed, overview
from tests.scene.scenes import EXAMPLES, scene_of


@pytest.mark.parametrize("example", ["two_masses", "seven_joint_arm", "inconsistent_start", "descriptor", "pitch_and_bounce"])
def test_the_short_summary_fits_a_screen_and_both_fit_80_columns(example):
    result = mb.read_scene(EXAMPLES / f"{example}.toml").run()
    short = _printed(overview(result))
    assert len(short.splitlines()) <= SCREEN
    assert max(map(len, [*short.splitlines(), *result.summary().splitlines()])) <= 80
    for row in result.tables[0].rows:  # every digit of what is listed, and what is not listed is counted
        assert re.search(rf"^  {row[0]} +{re.escape(row[1])}", short, re.MULTILINE) or re.search(r"and \d+ more", short)


def test_the_short_summary_has_the_requested_end_of_a_motion():
    scene = mb.read_scene(EXAMPLES / "flexible_arm.toml")
    result = scene.run()
    (end,) = scene.equations.ends
    whole, short = _printed(overview(result)), _printed(overview(result, lines=18))
    assert f"energy                     {end.input.energy:.6g} N^2 m^2 s" in whole and len(whole.splitlines()) <= SCREEN
    assert "energy" in short and re.search(r"and \d more", short) and len(short.splitlines()) <= 18


def test_the_short_summary_has_the_first_of_the_largest_values():
    result = mb.read_scene(EXAMPLES / "washing_machine.toml").run()
    short, largest = _printed(overview(result, lines=18)), result.largest
    assert re.search(rf"^  cabinet +displacement +{1e3 * largest[0].value:.6g} mm", short, re.MULTILINE)
    assert re.search(r"^  and \d more$", short, re.MULTILINE) and len(short.splitlines()) <= 18


def test_a_meaning_stands_where_it_adds_something(tmp_path):
    """A free body has a double eigenvalue 0, two equal oscillators a double pair: numbers are those of the list of modes."""
    free = '[model]\nkind = "lumped"\n[[model.mass]]\nname = "a"\nmass = 1\n[time]\nend = 1\npoints = 3\n'
    rigid = frequency_table(scene_of(tmp_path, free).run())
    assert (rigid.title, rigid.columns) == ("No natural frequencies: nothing oscillates", ("no.", "eigenvalue (1/s)", "meaning"))
    assert rigid.rows == (("1", "0", "rigid-body motion"),)
    two = frequency_table(scene_of(tmp_path, free.replace("[time]", '[[model.mass]]\nname = "b"\nmass = 2\n[time]')).run())
    assert two.rows == (("1–2", "0", "2 rigid-body motions"),)
    twins = free.replace('name = "a"\nmass = 1\n', 'name = "a"\nmass = 1\n[[model.mass]]\nname = "b"\nmass = 1\n') + "".join(
        f'[[model.spring]]\nbetween = ["ground", "{name}"]\nstiffness = 4\n' for name in "ab"
    )
    result = scene_of(tmp_path, twins).run()
    assert frequency_table(result).rows == (("1–2", "0.31831", "0", "2 times"),)
    assert eigenvalue_table(result).rows[0][:3] == ("1–2", "± 2 i", "2")
