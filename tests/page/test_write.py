"""Writing: complete or not at all."""

import os

import pytest

from mbconstrained.ground.errors import InputError
from mbconstrained.page.animation import Animation
from mbconstrained.page.content import PageContent
from mbconstrained.page.drawing import Drawing, DrawnBody
from mbconstrained.page.html import page_html, write_page


def test_the_file_is_the_page(tmp_path):
    content = PageContent("Größe × 2")
    path = write_page(tmp_path / "page.html", content)
    assert path.read_bytes() == page_html(content).encode("utf-8")
    assert os.listdir(tmp_path) == ["page.html"]


def test_a_failure_leaves_the_earlier_file(tmp_path):
    path = tmp_path / "page.html"
    path.write_text("earlier")
    wrong = Animation(Drawing((DrawnBody("b", moves={"x": (1, 0, 0)}),)), ("x",), [0, 1], [[0, 1e200]])
    with pytest.raises(InputError, match='body "b" is drawn up to 1e'):
        write_page(path, PageContent("t", animation=wrong))
    assert path.read_text() == "earlier"
    assert os.listdir(tmp_path) == ["page.html"]


def test_a_failure_while_writing_leaves_the_earlier_file(tmp_path, monkeypatch):
    path = tmp_path / "page.html"
    path.write_text("earlier")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(InputError, match="cannot be written: No space left on device; give another path"):
        write_page(path, PageContent("t"))
    assert path.read_text() == "earlier"
    assert os.listdir(tmp_path) == ["page.html"]


@pytest.mark.parametrize("place", ["missing/page.html", "."])
def test_a_place_that_cannot_be_written_is_named(tmp_path, place):
    with pytest.raises(InputError, match=r'the page ".*" cannot be written: .*; give another path'):
        write_page(tmp_path / place, PageContent("t"))
    assert os.listdir(tmp_path) == []
