"""The short summary fills a screen at most, and no line of a text or table is wider than a terminal."""

import re

import pytest

import mbconstrained as mb
from mbconstrained.analyses.motion_report import eigenvalue_table, frequency_table
from mbconstrained.analyses.run import SCREEN, _printed, overview
from mbconstrained.ground.notices import Notice, NoticeKind
from tests.scene.scenes import EXAMPLES, scene_of

LONG = "a spring of " + 30 * "many words "


def chain(count: int) -> str:
    """Equal masses and springs in a row from the ground."""
    bodies = "".join(f'[[model.mass]]\nname = "m{i}"\nmass = 1\n' for i in range(count))
    ends = [("ground" if i == 0 else f"m{i - 1}", f"m{i}") for i in range(count)]
    springs = "".join(f'[[model.spring]]\nbetween = ["{a}", "{b}"]\nstiffness = 100\n' for a, b in ends)
    return f'[model]\nkind = "lumped"\n{bodies}{springs}[initial]\nvelocity = {{ m0 = 1 }}\n[time]\nend = 1\npoints = 3\n'


@pytest.mark.parametrize("example", ["two_masses", "seven_joint_arm", "inconsistent_start", "descriptor", "pitch_and_bounce"])
def test_the_short_summary_fits_a_screen_and_both_fit_80_columns(example):
    result = mb.read_scene(EXAMPLES / f"{example}.toml").run()
    short = _printed(overview(result))
    assert len(short.splitlines()) <= SCREEN
    assert max(map(len, [*short.splitlines(), *result.summary().splitlines()])) <= 80
    for row in result.tables[0].rows:  # every digit of what is listed, and what is not listed is counted
        assert re.search(rf"^  {row[0]} +{re.escape(row[1])}", short, re.MULTILINE) or re.search(r"and \d+ more", short)


@pytest.mark.parametrize("width", [40, 60, 80, 120])
def test_many_modes_and_notices_are_counted(tmp_path, monkeypatch, width):
    result = scene_of(tmp_path, chain(60)).run()
    doubt = Notice("rank", "no clear gap", doubtful=True)
    notices = [Notice("drift", f"{LONG} {number}") for number in range(9)]
    monkeypatch.setattr(type(result), "table_notices", (*notices, doubt))
    text = _printed(overview(result, width), width)
    assert len(text.splitlines()) <= SCREEN and max(map(len, text.splitlines())) <= width
    assert "warning (rank): no clear gap" in " ".join(text.split())
    assert re.search(r"and \d+ further notices", text) and re.search(r"and \d+ more", text)


def test_motions_that_the_equations_do_not_describe_are_reported_before_what_was_left_out(tmp_path, monkeypatch):
    result = scene_of(tmp_path, chain(60)).run()
    kinds = [NoticeKind.OMITTED, NoticeKind.JUMP, NoticeKind.LARGE_MOTION]
    doubt = Notice(NoticeKind.RANK, "no clear gap", doubtful=True)
    monkeypatch.setattr(type(result), "table_notices", (*(Notice(kind, kind.value) for kind in kinds), doubt))
    shown = re.findall(r"(?:note|warning) \(([a-z ]+)\)", _printed(overview(result, 80), 80))
    assert shown == ["rank", "large motion", "jump", "omitted"]


def test_frequencies_come_first_and_the_details_are_folded():
    content = mb.read_scene(EXAMPLES / "pitch_and_bounce.toml").run().page()
    assert content.frequencies.columns == ("no.", "Hz", "damping ratio") and len(content.frequencies.rows) == 2
    assert {table.title.split(":")[0]: table.folded for table in content.tables} == {
        "Largest values": False,
        "Constraints": True,
        "Eigenvalues": True,
        "Evidence": True,
        "Plan": True,
    }


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
