"""What happens at t = 0: notices with units that say what the tables say, and the page's one sentence about them."""

import re

import pytest

from mbconstrained.analyses.motion_report import eigenvalue_table
from mbconstrained.ground.notices import Notice
from mbconstrained.scene.run.result import folded
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import COEFFICIENTS, EXAMPLES, OSCILLATOR, scene_of

LINK = EXAMPLES / "rigid_link.toml"


def texts(result, kind):
    return [notice.text for notice in result.notices if notice.kind == kind]


def test_notices_of_coefficients_have_units():
    # By hand (see test_examples): q1 1 -> 1/2, q2 0 -> 1/2, lambda contains -1/2 delta'.
    result = read_scene(LINK).run()
    assert texts(result, "jump") == [
        "q1: its displacement jumps at t = 0 by -0.5 m, from 1 m to 0.5 m",
        "q2: its displacement jumps at t = 0 by 0.5 m, from 0 m to 0.5 m",
        "lambda: its value jumps at t = 0 by 0.25 N, from 0 N to 0.25 N",
    ]
    assert texts(result, "impulse") == ["lambda: its value contains the first derivative of a Dirac impulse of -0.5 N s^2 at t = 0"]


def test_the_summary_tells_them_once_in_tables_and_counts_them():
    summary = read_scene(LINK).run().summary()
    assert "note (jump): At t = 0 there are 3 jumps and 1 impulse; the tables give the sizes" in " ".join(summary.split())
    assert summary.count("N s^2") == 1


def test_notices_and_tables_give_the_same_numbers():
    result = read_scene(LINK).run()
    summary = result.summary()
    for notice in result.notices:
        if notice.kind in ("jump", "impulse"):
            for value in re.findall(r"-?[\d.]+ (?:m|N s\^2)(?![\w])", notice.text):
                assert re.search(rf" {re.escape(value)}(?:  |\n)", summary), value


@pytest.mark.parametrize(
    ("unit", "jump"),
    [("rad", "its angle jumps at t = 0 by -1 rad, from 1 rad to 0 rad"), ("1", "its value jumps at t = 0 by -1, from 1 to 0")],
)
def test_the_unit_one_is_not_printed(tmp_path, unit, jump):
    # q = 0 beside p' + p = 0, from q(0-) = 1
    text = COEFFICIENTS.replace('["q"]', '["q", "p"]').replace('q = "rad"', f'q = "{unit}"')
    text = text.replace("[[[4]], [[0]], [[1]]]", "[[[1, 0], [0, 1]], [[0, 0], [0, 1]]]").replace(
        "[time]", "[initial]\nderivatives = [[1, 0]]\n[time]"
    )
    assert texts(scene_of(tmp_path, text).run(), "jump") == [f"q: {jump}"]


def test_the_page_tells_jumps_and_impulses_once_in_words_and_once_in_tables():
    content = read_scene(LINK).run().page()
    assert [notice.text for notice in content.notices] == ["At t = 0 there are 3 jumps and 1 impulse; the tables give the sizes"]
    tables = {table.title: table.rows for table in content.tables}
    assert len(tables["Jumps at t = 0"]) == 3
    assert ("lambda", "δ′", "-0.5 N s^2") in tables["Impulses at t = 0"]


def test_the_page_keeps_why_a_mechanical_start_is_changed(tmp_path):
    text = (EXAMPLES / "two_masses_position.toml").read_text("utf-8")
    result = scene_of(tmp_path, text.replace("[initial]\n", "[initial]\n#", 1).replace("points = 1001", "points = 5")).run()
    page = [notice.text for notice in result.page().notices]
    assert any("is violated at 0-" in text for text in page)
    assert any(text.startswith("At t = 0 there ") for text in page)
    assert not any("its displacement jumps" in text for text in page) and len(texts(result, "jump")) > 1


def test_nothing_is_said_where_nothing_happens():
    drift = Notice("drift", "moves on")
    assert folded((drift,), 0, 0) == (drift,)
    assert [notice.text for notice in folded((), 1, 0)] == ["At t = 0 there is 1 jump; the tables give the sizes"]
    assert [notice.kind for notice in folded((), 0, 2)] == ["impulse"]


def test_a_forgotten_start_is_told(tmp_path):
    forgotten = OSCILLATOR.replace("cart = 0.1", "cart = 0")
    assert [str(notice) for notice in scene_of(tmp_path, forgotten).run().notices] == [
        "note (at rest): nothing moves: zero initial conditions and no excitation"
    ]
    assert scene_of(tmp_path, OSCILLATOR).run().notices == ()


def test_zeros_of_coefficients_stand_in_the_columns_of_modes():
    table = eigenvalue_table(read_scene(EXAMPLES / "rigid_link.toml").run())
    of_modes = eigenvalue_table(read_scene(EXAMPLES / "two_masses.toml").run()).columns
    assert of_modes == (*(column.replace("zero", "eigenvalue") for column in table.columns), "kinetic energy", "strain energy")
    (row,) = table.rows  # 2 s^2 + 1
    assert row == ("1", "± 0.707107 i", "0.707107", "1", "oscillation")


def test_curves_have_the_colours_of_their_bodies(tmp_path):
    text = (EXAMPLES / "two_masses.toml").read_text("utf-8").replace("[output]", '[output]\ncoordinates = ["q2"]')
    content = scene_of(tmp_path, text).run().page()
    assert [(curve.name, curve.color) for curve in content.plots[0].curves] == [("q2", 2)]
