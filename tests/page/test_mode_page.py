"""The file of mode shapes: closed to the outside, every text a text, a row and a block to each mode."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from mbconstrained.page.animation import Shapes
from mbconstrained.page.content import PageContent
from mbconstrained.page.drawing import Drawing
from mbconstrained.page.html import page_html, viewer_script
from tests.page.contents import HOSTILE
from tests.page.mode_pages import hostile_modes, many_modes, robot_modes, two_modes, variants
from tests.page.test_html import Texts, data_of


def test_the_same_content_gives_the_same_bytes():
    assert page_html(two_modes()) == page_html(two_modes())


def test_without_modes_there_is_a_page_without_a_script():
    page = page_html(PageContent("None", animation=Shapes(Drawing(()), ())))
    assert '<p class="note">no modes</p>' in page and "<h1>None</h1>" in page
    for word in ("<script", "<button", "<table", 'id="stage"'):
        assert word not in page


def test_only_the_two_scripts_of_the_page_may_run_and_nothing_is_loaded():
    page = page_html(two_modes())
    assert len(re.findall("<script>", page)) == 2
    assert len(re.findall("'sha256-", page)) == 2
    assert (
        re.findall(r"<(?:link|img|iframe|object|embed|base|form)\b|\ssrc=|\shref=|url\(|@import", page.replace(viewer_script(), ""))
        == []
    )


def test_every_mode_has_a_row_with_its_facts_and_the_first_that_moves_is_selected():
    page = page_html(two_modes())
    heads = re.findall(r'<th scope="col"[^>]*>(.*?)</th>', page.split('class="modes"')[1])
    assert heads == ["no.", "mode", "frequency (Hz)", "meaning"]
    rows = re.findall(r'<tr data-mode="(\d)"( class=selected)?>', page)
    assert rows == [("0", " class=selected"), ("1", ""), ("2", "")]
    assert len(re.findall('type="radio" name="mode"', page)) == 3
    assert len(re.findall(r'type="radio"[^>]* checked>', page)) == 1


def test_the_first_mode_that_moves_is_selected_not_one_that_rests():
    shapes = two_modes().animation
    turned = PageContent("t", animation=replace(shapes, modes=shapes.modes[::-1]))
    assert data_of(page_html(turned))["first"] == 1


def test_shares_are_bars_with_their_numbers():
    page = page_html(two_modes())
    block = re.search(r'<section id="mode-2" hidden>.*?</section>', page, re.S)[0]
    assert re.findall('<th scope="row">(.*?)</th>', block) == ["a", "b", "k"]
    assert re.findall(r'width: (.*?)%"></span><span class="percent">(.*?)</span>', block) == [
        ("50.0", "50 %"),
        ("50.0", "50 %"),
        ("100.0", "100 %"),
    ]


def test_a_negative_share_is_told_apart_and_no_bar_is_wider_than_its_cell():
    from mbconstrained.page.html import _bar

    assert _bar(-0.25) == '<td><span class="bar negative" style="width: 25.0%"></span><span class="percent">−25 %</span></td>'
    assert "width: 100.0%" in _bar(1.25) and "125 %" in _bar(1.25)
    assert _bar(0.0) == _bar(-0.0) == _bar(-1e-17) == '<td><span class="percent">0 %</span></td>'
    assert _bar(None) == "<td></td>"


def test_without_shares_and_notes_the_picture_has_the_whole_width():
    page = page_html(many_modes(2))
    assert '<div class="details"' not in page and '<div class="picture"' not in page


def test_the_factor_by_which_it_is_not_to_scale_is_told():
    modes = data_of(page_html(two_modes()))["modes"]
    assert [mode["note"] for mode in modes] == ["not to scale: displacements of the shape drawn × 0.6"] * 2 + ["does not move"]
    assert data_of(page_html(robot_modes()))["modes"][0]["note"] == "not to scale: shape drawn × 0.05"


def test_bounds_hold_all_modes():
    bounds = data_of(page_html(two_modes()))["figure"]["bounds"]
    assert bounds["low"][0] == pytest.approx(-0.6 - 0.4) and bounds["high"][0] == pytest.approx(3 + 0.6 + 0.4)


def test_hostile_texts_come_out_as_texts():
    page = Texts(page_html(hostile_modes()))
    assert page.tags.count("script") == 3  # the data, the viewer, the page's own
    assert not {"img"} & set(page.tags)
    assert not [name for name in page.attributes if name.startswith("on")]
    assert page.texts.count(HOSTILE) >= 6


def test_sixty_modes_are_no_burden():
    page = page_html(many_modes(60))
    assert len(page) < 1.2e6
    assert len(json.dumps(data_of(page))) < 150_000


def test_shapes_are_listed_with_their_phases_and_of_many_entries_the_first():
    entries = (("cart", "1 m"), ("a < b", "0.5 m at 90 deg"), *((f"x{i}", f"{0.1 / i:.3g} m") for i in range(1, 40)))
    values = np.zeros((2, 49))
    content = two_modes()
    shapes = content.animation
    modes = (replace(shapes.modes[0], shape=entries, values=values),)
    page = page_html(replace(content, animation=replace(shapes, modes=modes)))
    assert '<th scope="row">a &lt; b</th><td>0.5 m at 90 deg</td>' in page
    assert "x28</th>" in page and "x29</th>" not in page and "and 11 more with smaller amplitudes" in page


def test_variants_have_a_slider_and_modes_have_none():
    page = page_html(variants(5))
    assert "<h2>Variants</h2>" in page
    assert re.search(r'<input type="range" id="choice" min="0" max="4" step="1" value="0"[^>]* aria-valuetext="sample 10">', page)
    for content in (many_modes(5), variants(1)):
        assert 'id="choice"' not in page_html(content).replace(viewer_script(), "")
