"""The file of mode shapes: closed to the outside, every text a text, a row and a block to each mode."""

import re

import pytest

from mbconstrained.page.animation import Shapes
from mbconstrained.page.content import PageContent
from mbconstrained.page.drawing import Drawing
from mbconstrained.page.html import page_html, viewer_script
from tests.page.contents import HOSTILE
from tests.page.mode_pages import hostile_modes, many_modes, two_modes, variants
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


def test_bounds_hold_all_modes():
    bounds = data_of(page_html(two_modes()))["figure"]["bounds"]
    assert bounds["low"][0] == pytest.approx(-0.6 - 0.4) and bounds["high"][0] == pytest.approx(3 + 0.6 + 0.4)


def test_hostile_texts_come_out_as_texts():
    page = Texts(page_html(hostile_modes()))
    assert page.tags.count("script") == 3  # the data, the viewer, the page's own
    assert not {"img"} & set(page.tags)
    assert not [name for name in page.attributes if name.startswith("on")]
    assert page.texts.count(HOSTILE) >= 6


def test_variants_have_a_slider_and_modes_have_none():
    page = page_html(variants(5))
    assert "<h2>Variants</h2>" in page
    assert re.search(r'<input type="range" id="choice" min="0" max="4" step="1" value="0"[^>]* aria-valuetext="sample 10">', page)
    for content in (many_modes(5), variants(1)):
        assert 'id="choice"' not in page_html(content).replace(viewer_script(), "")
